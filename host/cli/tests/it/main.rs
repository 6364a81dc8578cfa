//! Tests that run the command, one module for each subject.

mod answers;
mod bad_files;
mod cli;
mod common;
mod cuts_and_holes;
mod drawings;
mod errors;
mod export;
mod help;
mod hostile;
mod jobs;
mod odd_files;
mod options;
mod outlook;
mod path_file;
mod patterns;
mod plot;
mod recorded;
mod routes;
mod rust_source;
mod session;
mod sloppy_drawings;
mod stream;
mod terminal;
mod traj;
mod unfold;
