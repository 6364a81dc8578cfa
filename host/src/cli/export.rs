//! `foldpath export`.

use super::args::{Export, ExportFormat};
use super::{Answer, check_output, print};
use crate::formats::fold::read_path;
use crate::formats::traj::TrajFile;
use crate::formats::{csv, rust, write_whole};

pub(super) fn run(args: &Export) -> Answer {
    check_output(&args.path, &args.output)?;
    let path = read_path(&args.path)?;
    let (bytes, content) = match args.to {
        ExportFormat::Traj | ExportFormat::Rust => {
            let file = TrajFile::of(&path, &args.path)?;
            let content = format!(
                "{} knots of {} groups, {} hinges, {:.3} s",
                file.knots, file.groups, file.hinges, file.duration
            );
            if args.to == ExportFormat::Rust {
                let text = rust::source(&file, &path.title, &args.path)?;
                (text.into_bytes(), content)
            } else {
                (file.bytes, content)
            }
        }
        ExportFormat::Csv => {
            let text = csv::path_text(&path, &args.path)?;
            (text.into_bytes(), format!("{} knots", path.knots.len()))
        }
    };
    write_whole(&args.output, &bytes)?;
    print(&format!(
        "{}: {content}, {} bytes written to {}\n",
        path.title,
        bytes.len(),
        args.output.display()
    ))?;
    Ok(true)
}
