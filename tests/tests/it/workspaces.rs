//! Do the workspaces of their own keep to the rules of the main one? Cargo shares no lints, versions and profiles between
//! workspaces, so that these are written again.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// Folders of the workspaces of their own, whose lists of versions are checked in.
const OWN: [&str; 2] = ["firmware-sim/boards", "tests/bench"];

fn read(folder: &str, file: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    fs::read_to_string(root.join(folder).join(file)).unwrap()
}

/// Returns the settings of each table of a manifest, without comments. The tables that a package of its own and a
/// workspace name differently have the names of a workspace.
fn tables(manifest: &str) -> BTreeMap<String, BTreeMap<&str, &str>> {
    let mut tables = BTreeMap::<_, BTreeMap<_, _>>::new();
    let mut name = String::new();
    for line in manifest.lines().filter(|line| !line.starts_with('#')) {
        if let Some(table) = line.strip_prefix('[') {
            let table = table.trim_matches(['[', ']']);
            let of_package = ["package", "lints.rust", "lints.clippy"].contains(&table);
            name = if of_package {
                format!("workspace.{table}")
            } else {
                table.to_owned()
            };
        } else if let Some((key, value)) = line.split_once(" = ") {
            tables.entry(name.clone()).or_default().insert(key, value);
        }
    }
    tables
}

/// Returns the packages of a list of versions.
fn packages(lock: &str) -> BTreeSet<(&str, &str)> {
    let names = lock.lines().filter_map(|line| line.strip_prefix("name = "));
    let versions = lock
        .lines()
        .filter_map(|line| line.strip_prefix("version = \""));
    let versions = versions.map(|version| version.trim_matches('"'));
    // The first line with a version is that of the format, without quotes.
    names
        .map(|name| name.trim_matches('"'))
        .zip(versions)
        .collect()
}

/// Returns the part of a version that has to be equal for Cargo to take one for the other.
fn compatible(version: &str) -> &str {
    let parts = if version.starts_with("0.") { 2 } else { 1 };
    let end = version.match_indices('.').nth(parts - 1);
    end.map_or(version, |(end, _)| &version[..end])
}

#[test]
fn lints_and_settings_of_packages_are_those_of_the_main_workspace() {
    let root = read("", "Cargo.toml");
    let root = tables(&root);
    for folder in OWN {
        let own = read(folder, "Cargo.toml");
        let own = tables(&own);
        for lints in ["workspace.lints.rust", "workspace.lints.clippy"] {
            assert!(root[lints].len() > 2);
            assert_eq!(own[lints], root[lints], "{folder}");
        }
        for (key, value) in &root["workspace.package"] {
            assert_eq!(own["workspace.package"].get(key), Some(value), "{folder}");
        }
    }
}

/// Otherwise nothing would be built once for both workspaces.
#[test]
fn profiles_are_those_of_the_main_workspace() {
    let root = read("", "Cargo.toml");
    let root = tables(&root);
    for folder in OWN {
        let own = read(folder, "Cargo.toml");
        for (table, settings) in tables(&own) {
            if ["profile.release.package", "profile.dist.package"].contains(&table.as_str()) {
                // Without the packages that only one of the workspaces has.
                for (package, setting) in settings {
                    let main = root[&table].get(package);
                    assert!(
                        main.is_none_or(|main| *main == setting),
                        "{folder}: {package}"
                    );
                }
            } else if table.starts_with("profile.") {
                assert_eq!(settings, root[&table], "{folder}: {table}");
            }
        }
    }
}

#[test]
fn versions_are_those_of_the_main_workspace() {
    let root = read("", "Cargo.lock");
    let root = packages(&root);
    assert!(root.contains(&("foldpath-core", env!("CARGO_PKG_VERSION"))));
    for folder in OWN {
        let own = read(folder, "Cargo.lock");
        for (name, version) in packages(&own) {
            let mut others = root
                .iter()
                .filter(|(other, at)| *other == name && compatible(at) == compatible(version));
            let same = others.clone().any(|(_, other)| *other == version);
            assert!(
                same || others.next().is_none(),
                "{folder}: {name} {version}"
            );
        }
    }
}
