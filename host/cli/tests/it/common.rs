//! Makes folders in which the command runs.

use foldpath_test_support::Folder;
use serde_json::Value;

/// Folder of the repository's patterns.
pub(crate) const PATTERNS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../patterns");

/// Makes an empty folder in which `foldpath` runs.
pub(crate) fn folder() -> Folder {
    Folder::of(env!("CARGO_BIN_EXE_foldpath"))
}

/// Makes a folder with `miura.fold`, 3x3, and the path `path.fold` planned for it.
pub(crate) fn folder_with_path() -> Folder {
    let folder = folder();
    folder.done("generate miura --rows 3 --cols 3 -o miura.fold");
    folder.done("plan miura.fold -o path.fold");
    folder
}

/// Returns the 3x3 Miura fold of `foldpath generate`, with its faces written out.
pub(crate) fn pattern() -> Value {
    let folder = folder_with_path();
    let mut pattern = folder.read_json("miura.fold");
    pattern["faces_vertices"] = folder.read_json("path.fold")["faces_vertices"].take();
    pattern
}
