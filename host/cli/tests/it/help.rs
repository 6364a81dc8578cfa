//! Tests help texts, whose examples run, completion scripts and manual pages.

use std::fs;
use std::process::{Command, Stdio};

use crate::common::folder;
use foldpath_test_support::Folder;

/// Returns the names below `Commands:` in a help text, without `help` itself.
fn commands_in(help: &str) -> Vec<String> {
    let lines = help.lines().skip_while(|line| *line != "Commands:").skip(1);
    let named = lines.take_while(|line| !line.is_empty());
    // The description of a command may continue on lines with more indentation.
    let named = named.filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    let names = named.filter_map(|line| line.split_whitespace().next());
    names
        .filter(|name| *name != "help")
        .map(String::from)
        .collect()
}

/// Returns all commands with their help texts, each command before its subcommands.
fn all_help(folder: &Folder, command: &str) -> Vec<(String, String)> {
    let help = folder.done(&format!("{command} --help")).stdout;
    let below = commands_in(&help);
    let mut all = vec![(command.trim().to_string(), help)];
    for name in below {
        all.extend(all_help(folder, &format!("{command} {name}")));
    }
    all
}

/// Returns the command lines of the examples in a help text, without the name of the program.
fn examples(help: &str) -> Vec<&str> {
    let lines = help.lines().skip_while(|line| *line != "Examples:").skip(1);
    lines
        .map(|line| {
            line.strip_prefix("  foldpath ")
                .unwrap_or_else(|| panic!("{line}"))
        })
        .collect()
}

/// Returns `true` if an example needs a controller that no test has. Such an example answers that there is none.
fn needs_hardware(example: &str) -> bool {
    example.contains("--to serial:")
}

/// Examples run in the order of the help texts, each with the files that those before have written.
#[test]
fn every_command_has_examples_that_run() {
    let folder = folder();
    // No command writes designs.
    let design =
        "{\"id\": \"a\", \"generate\": {\"family\": \"miura\", \"rows\": 3, \"cols\": 3}}\n";
    folder.write("designs.jsonl", design);
    let all = all_help(&folder, "");
    let names: Vec<&str> = all.iter().map(|(name, _)| name.as_str()).collect();
    for name in ["", "plan", "generate kresling", "completions", "man"] {
        assert!(names.contains(&name), "{names:?}");
    }
    for (name, help) in &all {
        let examples = examples(help);
        assert!((2..=4).contains(&examples.len()), "{name}: {examples:?}");
        for example in examples {
            assert!(example.starts_with(name.as_str()), "{name}: {example}");
            let (arguments, output) = match example.split_once(" > ") {
                Some((arguments, output)) => (arguments, Some(output)),
                None => (example, None),
            };
            // It serves until it is ended, and has tests of its own.
            if name == "sim" {
                continue;
            }
            let answer = folder.run(arguments);
            let status = if needs_hardware(example) { 1 } else { 0 };
            assert_eq!(answer.status, Some(status), "{example}: {answer:?}");
            if let Some(output) = output {
                folder.write(output, &answer.stdout);
            }
        }
    }
}

#[test]
fn help_groups_the_options_of_plan() {
    let help = folder().done("plan --help").stdout;
    let heading = |option: &str| {
        let at = help
            .find(&format!(" {option} "))
            .unwrap_or_else(|| panic!("{option}: {help}"));
        let above = help[..at]
            .lines()
            .rev()
            .find(|line| line.ends_with(':') && !line.starts_with(' '));
        above.unwrap().to_string()
    };
    for (option, expected) in [
        ("--goal", "Goal:"),
        ("--via", "Goal:"),
        ("--limit", "Limits:"),
        ("--max-speed", "Limits:"),
        ("--output", "Path written:"),
        ("--seed", "Method:"),
        ("--collision", "Crossings:"),
    ] {
        assert_eq!(heading(option), expected, "{option}");
    }
}

#[test]
fn completions_are_scripts_of_their_shells() {
    let folder = folder();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = folder.done(&format!("completions {shell}")).stdout;
        for word in ["plan", "--max-speed", "square-twist", "completions"] {
            assert!(
                script.contains(word.trim_start_matches("--")),
                "{shell}: {word}"
            );
        }
        folder.write(shell, &script);
    }
    let bash = |arguments: &[&str]| {
        let mut command = Command::new("bash");
        command.args(arguments).current_dir(folder.path("."));
        command.stdin(Stdio::null()).output().unwrap()
    };
    let checked = bash(&["-n", "bash"]);
    assert!(checked.status.success(), "{checked:?}");
    // Bash itself completes a command line.
    let complete = "source ./bash; COMP_WORDS=(foldpath plan x.fold --max-s); COMP_CWORD=3; \
                    _foldpath foldpath --max-s x.fold; echo \"${COMPREPLY[@]}\"";
    let completed = bash(&["-c", complete]);
    assert_eq!(
        String::from_utf8_lossy(&completed.stdout).trim(),
        "--max-speed",
        "{completed:?}"
    );
    folder.run("completions tcsh").with_status(2);
}

#[test]
fn every_command_has_a_manual_page() {
    let folder = folder();
    let commands = all_help(&folder, "");
    fs::create_dir(folder.path("man")).unwrap();
    let answer = folder.done("man -o man");
    assert!(
        answer
            .stdout
            .starts_with(&format!("{} pages written", commands.len())),
        "{answer:?}"
    );
    for (name, help) in &commands {
        let dashed = format!("foldpath {name}").trim().replace(' ', "-");
        let page = folder.read(&format!("man/{dashed}.1"));
        for section in ["NAME", "SYNOPSIS", "DESCRIPTION", "OPTIONS"] {
            assert!(
                page.contains(&format!(".SH {section}\n")),
                "{dashed}: {section}"
            );
        }
        let title = format!("{} \\- ", dashed.replace('-', "\\-"));
        assert!(page.contains(&title), "{dashed}: {page}");
        for example in examples(help) {
            let first = example.split_whitespace().next().unwrap();
            assert!(page.contains(first), "{dashed}: {example}");
        }
    }
    assert_eq!(folder.done("man").stdout, folder.read("man/foldpath.1"));
    let refused = folder.run("man -o nowhere").with_status(2);
    assert!(
        refused.stderr.starts_with("foldpath: nowhere/"),
        "{refused:?}"
    );
}
