//! Checks that every module of the library uses only modules below it.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// The modules of the library from the lowest to the highest. Modules of one line use neither each other nor anything
/// above.
const LAYERS: [&[&str]; 14] = [
    // `progress` is part of `util` and has a name at the root of the library.
    &["colours", "util", "progress"],
    &["pattern"],
    &["generate", "straighten"],
    &["motion"],
    &["symmetry"],
    &["folding"],
    &["lattice"],
    &["certificate"],
    &["collision"],
    &["sensitivity"],
    &["planner", "check", "unfold"],
    &["read"],
    &["export"],
    &["view", "plot", "stream", "request"],
];

/// Returns the layer of a module.
fn layer(module: &str) -> Option<usize> {
    LAYERS.iter().position(|layer| layer.contains(&module))
}

/// Collects the source files in a folder.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            found.push(path);
        }
    }
}

/// Returns the modules of the crate that a source text names, unit tests and comments apart.
fn named(text: &str) -> BTreeSet<String> {
    let code = text.split("#[cfg(test)]\nmod tests").next().unwrap();
    let lines = code
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"));
    let code: Vec<&str> = lines.collect();
    let code = code.join("\n");
    let mut found = BTreeSet::new();
    for rest in code.split("crate::").skip(1) {
        // Several modules may be named in braces.
        let group = rest
            .strip_prefix('{')
            .and_then(|rest| rest.split('}').next());
        for path in group.unwrap_or(rest).split(',') {
            let is_part = |c: &char| c.is_alphanumeric() || *c == '_';
            let name: String = path.trim_start().chars().take_while(is_part).collect();
            found.insert(name);
            if group.is_none() {
                break;
            }
        }
    }
    found.remove("");
    found
}

#[test]
fn modules_use_only_modules_below_them() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&root, &mut files);
    let mut wrong = Vec::new();
    let mut arrows = 0;
    for file in files {
        let relative = file.strip_prefix(&root).unwrap();
        let first = relative.components().next().unwrap();
        let module = first.as_os_str().to_str().unwrap().trim_end_matches(".rs");
        if module == "lib" {
            continue;
        }
        let own = layer(module).unwrap_or_else(|| panic!("{module} is in no layer"));
        for other in named(&fs::read_to_string(&file).unwrap()) {
            let Some(other_layer) = layer(&other).filter(|_| other != module) else {
                continue;
            };
            arrows += 1;
            if other_layer >= own {
                wrong.push(format!("{} uses {other}", relative.display()));
            }
        }
    }
    assert!(arrows > 100, "{arrows} arrows found");
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn an_arrow_upwards_is_found() {
    let text = "use crate::read::FileError;\n// crate::view\nuse crate::{plot, export::csv};\n\
                fn f() { crate::check::check() }\n#[cfg(test)]\nmod tests {\n    use crate::stream;\n}\n";
    let expected = ["check", "export", "plot", "read"];
    assert!(named(text).iter().eq(expected), "{:?}", named(text));
    assert!(layer("read") > layer("pattern") && layer("reed").is_none());
}

/// The clock of `std` stops a program in a browser, so that all times are taken from `util::clock`.
#[test]
fn one_module_knows_the_clock() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&folder, &mut files);
    files.retain(|file| fs::read_to_string(file).unwrap().contains("std::time::"));
    assert_eq!(files, [folder.join("util/clock.rs")]);
}
