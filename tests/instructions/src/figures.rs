//! The stored instruction counts, in `figures.csv`.

use std::collections::BTreeMap;
use std::path::PathBuf;

/// Toolchain and processor for which the figures are counted.
pub(crate) const TOOLCHAIN: &str = concat!("rustc ", env!("CARGO_PKG_RUST_VERSION"), " on x86-64");

const HEAD: &str = "kernel,instructions";

/// Instructions of one call of each kernel, by its name.
#[derive(Default)]
pub(crate) struct Figures(BTreeMap<String, f64>);

impl Figures {
    fn file() -> PathBuf {
        PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/figures.csv"))
    }

    /// Reads the stored figures.
    pub(crate) fn read() -> Result<Self, String> {
        let file = Self::file();
        let text = std::fs::read_to_string(&file);
        let text = text.map_err(|error| format!("{}: {error}", file.display()))?;
        let mut lines = text.lines();
        if lines.next() != Some(HEAD) {
            return Err(format!("{}: expected the head {HEAD}", file.display()));
        }
        let figure = |line: &str| {
            let (name, count) = line.split_once(',')?;
            Some((name.to_string(), count.parse().ok()?))
        };
        let figures = lines.map(|line| figure(line).ok_or(line));
        let figures: Result<_, _> = figures.collect();
        Ok(Self(figures.map_err(|line| {
            format!(
                "{}: expected a kernel and its instructions, found {line}",
                file.display()
            )
        })?))
    }

    pub(crate) fn of(&self, kernel: &str) -> Option<f64> {
        self.0.get(kernel).copied()
    }

    pub(crate) fn set(&mut self, kernel: &str, count: f64) {
        self.0.insert(kernel.to_string(), count);
    }

    pub(crate) fn write(&self) -> Result<(), String> {
        let mut text = format!("{HEAD}\n");
        for (name, count) in &self.0 {
            text += &format!("{name},{count:.0}\n");
        }
        std::fs::write(Self::file(), text).map_err(|error| error.to_string())
    }
}
