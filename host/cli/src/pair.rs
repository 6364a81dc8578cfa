//! Runs `foldpath pair`, which gives a controller a key.

use std::io;

use foldpath::stream::{Link, Pairing, Sim, pair};

use crate::args::Pair;
use crate::link::Wire;
use crate::values::Target;
use crate::{Answer, CliError, key, say};
use crate::{print, report::outcome};

pub(crate) fn run(args: &Pair, quiet: bool) -> Answer {
    if !matches!(args.to, Target::Sim | Target::Serial(_)) {
        let text = "--to: expected sim or serial:DEVICE, a line that no stranger reaches";
        return Err(CliError::Usage(text.into()));
    }
    // The key is in its file before a controller has it: a key that nobody knows would lock the controller.
    let (key, made) = key::read_or_make(&args.key)?;
    if !made && !quiet {
        let path = args.key.display();
        say(&format!(
            "note: {path} was there already: if another controller has this key, their nonces must differ from each other"
        ));
    }
    let paired = match &args.to {
        Target::Serial(device) => given(Wire::open(device, args.baud), key),
        _ => given(Ok(Sim::new()), key),
    };
    let (name, why) = match &paired {
        Ok(Pairing::Paired) => ("paired", None),
        Ok(Pairing::Refused) => (
            "refused",
            Some(
                "the controller takes no key: it has no room for one, its sheet moves, or its board allows no key over \
                 this line"
                    .into(),
            ),
        ),
        Ok(Pairing::Version(failure)) => ("no_device", Some(failure.to_string())),
        Ok(_) => (
            "no_device",
            Some("no controller answers; one that has another key does not".into()),
        ),
        Err(error) => ("no_device", Some(format!("the line: {error}"))),
    };
    let done = matches!(paired, Ok(Pairing::Paired));
    if !quiet {
        let mut text = format!("pair: {}\n", outcome(done, name));
        if let Some(why) = why {
            text += &format!("  reason       {why}\n");
        }
        let state = if made { ", made" } else { "" };
        text += &format!("  key          {}{state}\n", args.key.display());
        print(&text)?;
    }
    Ok(done)
}

fn given(link: io::Result<impl Link>, key: foldpath_core::wire::key::Key) -> io::Result<Pairing> {
    pair(&mut link?, key, key::nonce()?)
}
