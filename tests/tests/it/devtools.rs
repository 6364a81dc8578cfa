//! A tab of Chromium, driven by the Chrome DevTools Protocol over two pipes. A client library would take minutes to build,
//! because it has a type for each of the protocol's two thousand messages.
//!
//! Source: <https://chromedevtools.github.io/devtools-protocol/>. With `--remote-debugging-pipe` Chromium reads messages
//! from file descriptor 3 and writes them to 4: JSON, each followed by a zero byte.

use core::time::Duration;
use std::io::{BufRead as _, BufReader, Write as _};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread;

use serde_json::{Value, json};

/// A browser with one tab. It ends when this is dropped.
pub(crate) struct Devtools {
    browser: Child,
    to: Option<ChildStdin>,
    from: Receiver<Value>,
    patience: Duration,
    /// Session of the tab, once there is one.
    session: Option<String>,
    calls: u64,
    /// All events so far.
    pub(crate) events: Vec<Value>,
}

impl Devtools {
    /// Starts a browser with these switches and an empty tab. Each answer may take as long as `patience`.
    pub(crate) fn start(program: &Path, switches: &[&str], patience: Duration) -> Self {
        let mut browser = Command::new("sh")
            .args(["-c", "exec \"$@\" 3<&0 4>&1 </dev/null >&2", "sh"])
            .arg(program)
            .args(["--headless", "--remote-debugging-pipe", "--no-first-run"])
            // The root user of a container can have no sandbox.
            .args(["--no-sandbox", "--disable-background-networking"])
            .args(switches)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Chromium starts");
        let (to, output) = (browser.stdin.take(), browser.stdout.take());
        let mut pieces = BufReader::new(output.unwrap()).split(0);
        let (sender, from) = channel();
        thread::spawn(move || {
            while let Some(Ok(piece)) = pieces.next() {
                let message = serde_json::from_slice(&piece).expect("a message");
                if sender.send(message).is_err() {
                    break;
                }
            }
        });
        let mut devtools = Self {
            browser,
            to,
            from,
            patience,
            session: None,
            calls: 0,
            events: Vec::new(),
        };
        let tab = devtools.call("Target.createTarget", json!({ "url": "about:blank" }));
        let tab = json!({ "targetId": tab["targetId"], "flatten": true });
        let session = devtools.call("Target.attachToTarget", tab);
        devtools.session = session["sessionId"].as_str().map(String::from);
        devtools
    }

    /// Calls a method and returns its result.
    pub(crate) fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.calls += 1;
        let mut message = json!({ "id": self.calls, "method": method, "params": parameters });
        if let Some(session) = &self.session {
            message["sessionId"] = json!(session);
        }
        let to = self.to.as_mut().unwrap();
        to.write_all(format!("{message}\0").as_bytes()).unwrap();
        loop {
            let answer = self.from.recv_timeout(self.patience);
            let mut answer = answer.unwrap_or_else(|error| panic!("{method}: {error}"));
            if answer["id"] != self.calls {
                self.events.push(answer);
                continue;
            }
            assert!(answer["error"].is_null(), "{method}: {}", answer["error"]);
            return answer["result"].take();
        }
    }
}

impl Drop for Devtools {
    fn drop(&mut self) {
        // Chromium ends once nobody can write to it any more.
        self.to = None;
        let _ = self.browser.wait();
    }
}
