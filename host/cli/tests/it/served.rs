//! Tests of `foldpath sim`: a controller over TCP that keeps what a client has left.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use foldpath_test_support::Folder;
use serde_json::Value;

use crate::common::{folder, folder_with_path};

/// A running server, which ends with the test.
struct Server {
    process: Child,
    address: String,
}

impl Server {
    fn start(folder: &Folder, options: &str) -> Self {
        let mut command = folder.command(&format!("sim --listen 0 {options}"));
        let mut process = command.stdout(Stdio::piped()).spawn().unwrap();
        let mut line = String::new();
        let mut lines = BufReader::new(process.stdout.take().unwrap());
        lines.read_line(&mut line).unwrap();
        let address = line.trim().strip_prefix("sim: listens at ").unwrap();
        Self {
            address: address.into(),
            process,
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

#[test]
fn clients_find_what_the_one_before_has_left() {
    let folder = folder_with_path();
    folder.done("export path.fold --to traj -o path.traj");
    let server = Server::start(&folder, "");
    let stream = format!(
        "stream path.traj --to tcp:{} --insecure --json",
        server.address
    );
    let json = folder.done(&stream).json();
    assert_eq!(json["outcome"], "done", "{json}");
    // The sheet is measured all the time, and follows its commands exactly.
    assert_eq!(json["max_lag"], 0.0, "{json}");
    // It stands at the goal, where the path does not begin.
    let json = folder.run(&stream).with_status(1).json();
    assert_eq!(json["outcome"], "held", "{json}");
    let json = folder.done(&format!("{stream} --reverse")).json();
    assert_eq!(json["outcome"], "done", "{json}");
}

#[test]
fn a_served_controller_with_a_key_answers_its_owner_alone() {
    let folder = folder_with_path();
    folder.done("export path.fold --to traj -o path.traj");
    folder.write("lab.key", &"5a".repeat(16));
    let server = Server::start(&folder, "--key lab.key");
    let stream = format!("stream path.traj --to tcp:{} --json", server.address);
    let json = folder.done(&format!("{stream} --key lab.key")).json();
    assert_eq!(json["outcome"], "done", "{json}");
}

#[test]
fn an_address_that_cannot_be_had_is_told() {
    let folder = folder();
    let answer = folder.run("sim --listen nowhere").with_status(2);
    assert!(
        answer.begins("--listen nowhere: expected HOST:PORT or PORT"),
        "{answer:?}"
    );
}

/// A client that was written from `firmware-sim/PROTOCOL.md` alone, without any code of this repository. The Python that runs
/// it is named by `FOLDPATH_PYTHON`.
#[test]
fn a_client_of_the_specification_alone_folds_a_sheet() {
    let Some(python) = std::env::var_os("FOLDPATH_PYTHON") else {
        println!("skipped: FOLDPATH_PYTHON is not set");
        return;
    };
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let folder = folder();
    folder.done("generate miura --rows 3 --cols 3 -o miura.fold");
    folder.done("plan miura.fold --max-speed 90 -o path.fold");
    folder.done("export path.fold --to traj -o path.traj");
    folder.write("lab.key", &"5a".repeat(16));
    let client = |arguments: &[&str]| {
        let answer = Command::new(&python)
            .arg(root.join("tests/protocol/client.py"))
            .args(arguments)
            .current_dir(folder.path(""))
            .output()
            .unwrap();
        let text = String::from_utf8_lossy(&answer.stdout).into_owned();
        assert!(answer.status.success(), "{arguments:?}: {answer:?}");
        text
    };
    let specification = root.join("firmware-sim/PROTOCOL.md");
    client(&["--self-test", specification.to_str().unwrap()]);
    for (key, more) in [
        ("", vec![]),
        ("--key lab.key", vec!["--hold-after", "0.5"]),
        ("--key lab.key", vec!["--drop", "0.05", "--seed", "3"]),
    ] {
        let server = Server::start(&folder, key);
        let mut arguments = vec!["path.traj", &server.address];
        arguments.extend(key.split_whitespace());
        arguments.extend(more);
        let json: Value = serde_json::from_str(&client(&arguments)).unwrap();
        assert_eq!(json["outcome"], "done", "{arguments:?}: {json}");
        let closure = json["largest_closure"].as_f64().unwrap();
        assert!(closure < 1e-5, "{json}");
    }
}
