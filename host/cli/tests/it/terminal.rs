//! Tests the output on a terminal: colours, and bars for work over a second. `script` of util-linux makes the terminal.
#![cfg(target_os = "linux")]

use std::process::{Command, Output, Stdio};

use crate::common::folder_with_path;
use foldpath_test_support::Folder;

/// Character with which the code of a colour begins.
const ESCAPE: char = '\u{1b}';

/// Runs a command line with a terminal for stdout and stderr. Returns the text on the terminal and the exit status.
fn on_terminal(
    folder: &Folder,
    arguments: &str,
    variables: &[(&str, &str)],
) -> (String, Option<i32>) {
    let program = env!("CARGO_BIN_EXE_foldpath");
    let mut script = Command::new("script");
    script.args(["-qec", &format!("{program} {arguments}"), "/dev/null"]);
    script.current_dir(folder.path(".")).stdin(Stdio::null());
    script
        .env("TERM", "xterm")
        .env_remove("NO_COLOR")
        .env_remove("CLICOLOR");
    script.envs(variables.iter().copied());
    let Output { stdout, status, .. } = script.output().expect("`script` of util-linux");
    (String::from_utf8(stdout).unwrap(), status.code())
}

/// Returns the text without colours and with the line ends of files.
fn plain(shown: &str) -> String {
    let mut parts = shown.split(ESCAPE);
    let first = parts.next().unwrap_or_default().to_string();
    let rest = parts.map(|part| part.split_once('m').map_or(part, |(_, text)| text));
    rest.fold(first, |text, part| text + part)
        .replace("\r\n", "\n")
}

#[test]
fn colours_are_on_a_terminal_alone_and_change_no_text() {
    let folder = folder_with_path();
    folder.write("bad.fold", "{\"vertices_coords\": [[0, 0], \"x\"]}");
    for (arguments, status) in [
        ("check path.fold", 0),
        ("check path.fold --bound 1e-300", 1),
        ("info miura.fold", 0),
        ("info bad.fold", 2),
        ("export path.fold --to csv -o path.fold", 2),
    ] {
        let answer = folder.run(arguments).with_status(status);
        let piped = answer.stdout + &answer.stderr;
        assert!(!piped.contains(ESCAPE), "{piped:?}");
        let (shown, shown_status) = on_terminal(&folder, arguments, &[]);
        assert_eq!(shown_status, Some(status), "{arguments}");
        assert!(shown.contains(ESCAPE), "{arguments}: {shown:?}");
        assert_eq!(plain(&shown), piped, "{arguments}");
    }
    // https://no-color.org
    let (shown, _) = on_terminal(&folder, "check path.fold", &[("NO_COLOR", "1")]);
    assert!(
        !shown.contains(ESCAPE) && shown.contains("holds"),
        "{shown:?}"
    );
    // The answer is one JSON object, whatever stdout is.
    let (shown, _) = on_terminal(&folder, "check path.fold --json", &[]);
    let json: serde_json::Value = serde_json::from_str(&shown).unwrap();
    assert_eq!(json["outcome"], "holds");
}

/// Planning with tens of thousands of unknowns takes all the time that it is given.
#[test]
fn a_bar_is_drawn_on_a_terminal_for_work_over_a_second() {
    let folder = folder_with_path();
    folder.done("generate miura --rows 200 --cols 200 -o large.fold");
    let long = "plan large.fold --symmetry off --timeout 2";
    let (shown, status) = on_terminal(&folder, long, &[]);
    assert_eq!(status, Some(1), "{shown}");
    let bars = ["reading", "finding crease groups", "following the motion"];
    let drawn = |shown: &str| {
        bars.iter().any(|bar| shown.contains(bar)) || shown.replace("\r\n", "").contains('\r')
    };
    assert!(drawn(&shown), "{shown:?}");
    assert!(plain(&shown).contains(": timeout\n"), "{shown}");
    for arguments in [
        &format!("{long} --quiet"),
        &format!("{long} --json"),
        "plan miura.fold",
    ] {
        let (shown, _) = on_terminal(&folder, arguments, &[]);
        assert!(!drawn(&shown), "{arguments}: {shown:?}");
    }
    let piped = folder.run(long).with_status(1);
    assert!(!drawn(&(piped.stderr.clone() + &piped.stdout)), "{piped:?}");
}
