//! The files of the planner use only files before them, in the order that its documentation states.

use std::fs;
use std::path::Path;

/// The files in their order.
const ORDER: [&str; 56] = [
    "vectors",
    "goal",
    "knots",
    "reason",
    "messages",
    "plan",
    "options",
    "problem",
    "closing/sparse",
    "closing/chord",
    "closing/solver",
    "following/follow",
    "following/reduction",
    "following/search",
    "following/nearly_closed",
    "following/branch",
    "following/judge",
    "following/mobility",
    "following/legs",
    "following/completion",
    "following/route",
    "following/route_selection",
    "foldability/flat_cone",
    "foldability/products",
    "foldability/locked_loop",
    "foldability/certificate",
    "foldability/cause",
    "foldability/forecast",
    "foldability/stacking",
    "placement/overshoot",
    "placement/reachability",
    "placement/timing",
    "placement/reduced_path",
    "placement/segment",
    "placement/knot_placer",
    "placement/knot_placement",
    "lifting/lifted",
    "lifting/certified_motion",
    "lifting/measured_motion",
    "lifting/swept_motion",
    "lifting/whole_sheet",
    "strategies/arrival",
    "strategies/simple_folds",
    "strategies/plates",
    "strategies/pipeline",
    "strategies/rows",
    "strategies/stops",
    "strategies/phase_samples",
    "strategies/fold_sequence",
    "strategies/rings",
    "strategies/split_phases",
    "strategies/way_round",
    "strategies/bending",
    "strategies/lines",
    "strategies/advice",
    "strategies/driver",
];

#[test]
fn files_use_only_files_before_them() {
    let planner = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/planner");
    let place = |file: &str| ORDER.iter().position(|known| *known == file);
    let mut files = 0;
    for (at, file) in ORDER.iter().enumerate() {
        let text = fs::read_to_string(planner.join(file).with_extension("rs")).unwrap();
        let folder = file.split_once('/').map_or("", |(folder, _)| folder);
        for line in text
            .lines()
            .filter(|line| line.starts_with("use ") || line.starts_with("pub use "))
        {
            let path = line.split_once("use ").unwrap().1;
            let used = if let Some(path) = path.strip_prefix("super::") {
                let [folder, slash] = if folder.is_empty() {
                    ["", ""]
                } else {
                    [folder, "/"]
                };
                format!("{folder}{slash}{path}")
            } else if let Some(path) = path.strip_prefix("crate::planner::") {
                path.replacen("::", "/", 1)
            } else {
                continue;
            };
            // `a::b` and `folder/a::b` name the file a; the types that the planner exports are those of the first files.
            let used = used.split("::").next().unwrap().trim_end_matches(';');
            let used = place(used).or_else(|| place(used.split('/').next().unwrap()));
            assert!(used.is_none_or(|used| used < at), "{file}: {line}");
            files += usize::from(used.is_some());
        }
    }
    assert!(files > 100, "{files} uses were found");
}

/// The architecture document has a row for each strategy of the planner's table, in the order of the table.
#[test]
fn strategies_are_documented_in_their_order() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let read = |path: &str| fs::read_to_string(root.join(path)).unwrap();
    let (driver, plan) = (
        read("src/planner/strategies/driver.rs"),
        read("src/planner/plan.rs"),
    );
    let table = driver.split_once("static STRATEGIES").unwrap().1;
    let table = table.split_once("\n];").unwrap().0.lines().map(str::trim);
    let strategies = table.filter_map(|line| match line {
        "BASE," => Some("CreaseGroups"),
        "other_seed(0)," => Some("OtherSeed"),
        _ => line.strip_prefix("strategy: Strategy::")?.strip_suffix(','),
    });
    let names: Vec<&str> = strategies
        .map(|strategy| {
            let name = plan
                .split_once(&format!("Self::{strategy} => \""))
                .unwrap()
                .1;
            name.split_once('"').unwrap().0
        })
        .collect();
    let document = read("../ARCHITECTURE.md");
    let rows = document.split_once("| strategy | tried if |").unwrap().1;
    let rows = rows.lines().skip(2).take_while(|line| !line.is_empty());
    let documented: Vec<&str> = rows
        .map(|row| row.split('|').nth(1).unwrap().trim().trim_end_matches(" *"))
        .collect();
    assert_eq!(documented, names);
    assert_eq!(names.len(), 17);
}

#[test]
fn every_file_has_a_place() {
    let planner = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/planner");
    let mut folders = vec![planner.clone()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let file = path.strip_prefix(&planner).unwrap().with_extension("");
            let file = file.to_str().unwrap();
            assert!(file.ends_with("mod") || ORDER.contains(&file), "{file}");
        }
    }
}
