//! Runs sessions with controllers and keeps all their telemetry.

use std::io;

use foldpath::stream::{Link, Options, StreamPath, Summary, Telemetry, Watcher, Wish, run};

/// Watcher that keeps all telemetry.
struct Ear<'a> {
    heard: Vec<Telemetry>,
    wish: &'a dyn Fn(&[Telemetry]) -> Wish,
}

impl Watcher for Ear<'_> {
    fn telemetry(&mut self, telemetry: &Telemetry) -> io::Result<()> {
        self.heard.push(telemetry.clone());
        Ok(())
    }

    fn wish(&mut self) -> Wish {
        (self.wish)(&self.heard)
    }
}

/// Runs a session with these options. Returns its summary and its telemetry.
pub(crate) fn session(
    link: &mut impl Link,
    path: &StreamPath,
    options: Options,
    wish: &dyn Fn(&[Telemetry]) -> Wish,
) -> (Summary, Vec<Telemetry>) {
    let heard = Vec::new();
    let mut ear = Ear { heard, wish };
    let summary = run(link, path, options, &mut ear).unwrap();
    (summary, ear.heard)
}
