//! Plans the patterns of `patterns/` for tests.

use std::path::{Path, PathBuf};

use foldpath::export::fold::motion_text;
use foldpath::motion::Motion;
use foldpath::planner::{Goal, Plan, PlanOptions, plan};
use foldpath::read::FileError;
use foldpath::read::fold::{PatternFile, read_motion};
use foldpath::read::read_pattern;
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

    /// Returns the motion, titled as its pattern.
    ///
    /// # Panics
    /// If the plan has no motion.
    #[must_use]
    pub fn motion(&self) -> Motion {
        let motion = self.plan.motion.clone().expect("a motion");
        Motion {
            title: self.file.title.clone(),
            ..motion
        }
    }

    /// Returns the motion as the text of a FOLD file.
    ///
    /// # Panics
    /// If the plan has no motion.
    #[must_use]
    pub fn text(&self) -> String {
        motion_text(&self.motion())
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
pub fn path_file(text: &str) -> Result<Motion, FileError> {
    let file = tempfile::NamedTempFile::new().expect("a temporary file");
    std::fs::write(file.path(), text).expect("room for a path");
    read_motion(file.path())
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
