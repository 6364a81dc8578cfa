//! Plans the patterns of `patterns/` for tests.

use std::path::{Path, PathBuf};

use foldpath::formats::FileError;
use foldpath::formats::fold::{PathFile, PathWriter, PatternFile, read_path, read_pattern};
use foldpath::planner::{Goal, Plan, PlanOptions, plan};
use serde_json::Value;

/// A pattern file and its plan.
pub struct Planned {
    /// The pattern file.
    pub file: PatternFile,
    /// The plan to the pattern's own goal.
    pub plan: Plan,
}

impl Planned {
    /// Plans the pattern of this name to its own goal.
    ///
    /// # Panics
    /// If the file cannot be read or has no goal.
    #[must_use]
    pub fn new(name: &str, options: &PlanOptions) -> Self {
        Self::of(
            read_pattern(&pattern_file(name)).expect("a pattern"),
            options,
        )
    }

    /// Plans a pattern to its own goal.
    ///
    /// # Panics
    /// If the pattern has no goal.
    #[must_use]
    pub fn of(file: PatternFile, options: &PlanOptions) -> Self {
        let goal = Goal::of_pattern(&file.pattern).expect("a goal");
        let plan = plan(&file.pattern, &goal, options);
        Self { file, plan }
    }

    /// Returns the path as the text of a FOLD file.
    #[must_use]
    pub fn text(&self) -> String {
        let writer = PathWriter {
            title: &self.file.title,
            pattern: &self.file.pattern,
            vertices: true,
            seed: 0,
            max_speed: PlanOptions::default().max_speed,
            max_acceleration: None,
        };
        writer.text(&self.plan.path)
    }
}

/// Returns the path to the pattern of this name.
#[must_use]
pub fn pattern_file(name: &str) -> PathBuf {
    let patterns = Path::new(env!("CARGO_MANIFEST_DIR")).join("../patterns");
    patterns.join(name).with_extension("fold")
}

/// Writes this text to a file and reads it as a path.
///
/// # Errors
/// If the text is not a path.
///
/// # Panics
/// If a temporary file cannot be written.
pub fn path_file(text: &str) -> Result<PathFile, FileError> {
    let file = tempfile::NamedTempFile::new().expect("a temporary file");
    std::fs::write(file.path(), text).expect("room for a path");
    read_path(file.path())
}

/// Returns the goal fold angles of the pattern of this name, degrees, straight from its file.
///
/// # Panics
/// If the file cannot be read or has no goal angles.
#[must_use]
pub fn goal_angles(name: &str) -> Vec<f64> {
    let text = std::fs::read_to_string(pattern_file(name)).expect("a pattern");
    let mut file: Value = serde_json::from_str(&text).expect("JSON");
    serde_json::from_value(file["edges_foldAngle"].take()).expect("goal angles")
}
