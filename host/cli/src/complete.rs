//! Runs `foldpath completions` and `foldpath man`, which print completion scripts and manual pages.

use std::path::Path;

use clap::CommandFactory;
use clap_complete::Shell;
use clap_mangen::Man as Page;

use crate::args::Cli;
use crate::output::write_whole;
use crate::{Answer, CliError, print, print_to};

pub(crate) fn completions(shell: Shell) -> Answer {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "foldpath", &mut script);
    print_to(std::io::stdout().lock(), &script)?;
    Ok(true)
}

pub(crate) fn man(output: Option<&Path>) -> Answer {
    let mut command = Cli::command();
    command.build();
    let Some(folder) = output else {
        print_to(std::io::stdout().lock(), &page(command)?)?;
        return Ok(true);
    };
    let pages = write_pages(command, folder)?;
    let folder = folder.display();
    print(&format!(
        "{pages} pages written to {folder}: man -l {folder}/foldpath.1\n"
    ))?;
    Ok(true)
}

/// Writes the manual pages of a command and of all its subcommands. Returns the number of pages.
fn write_pages(command: clap::Command, folder: &Path) -> Result<usize, CliError> {
    let mut pages = 1;
    for below in command
        .get_subcommands()
        .filter(|below| below.get_name() != "help")
    {
        pages += write_pages(below.clone(), folder)?;
    }
    let name = command.get_display_name().unwrap_or(command.get_name());
    write_whole(&folder.join(format!("{name}.1")), &page(command.clone())?)?;
    Ok(pages)
}

/// Returns the manual page of a command.
fn page(command: clap::Command) -> Result<Vec<u8>, CliError> {
    let mut page = Vec::new();
    Page::new(command)
        .render(&mut page)
        .map_err(CliError::Output)?;
    Ok(page)
}
