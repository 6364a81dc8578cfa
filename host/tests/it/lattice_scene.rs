//! Tests crossings in single configurations of a tessellation: those found by its lattice against those found among all
//! faces.

use foldpath::collision::{CollisionScene, LatticeScene};
use foldpath::folding::{FoldingMap, SpanningTree};
use foldpath::generate::{Miura, Waterbomb, Yoshimura};
use foldpath::lattice::Lattice;
use foldpath::pattern::{CreasePattern, Drawing};
use foldpath::symmetry::CreaseGroups;

/// Returns the depths of the deepest crossings, over the median edge, of the sheet folded to its goal: by the lattice,
/// and among all faces.
fn both(drawing: Drawing) -> [f64; 2] {
    let pattern = CreasePattern::new(drawing).unwrap();
    let groups = CreaseGroups::find(&pattern);
    let goal: Vec<_> = pattern
        .creases()
        .iter()
        .map(|id| pattern.edge(*id).goal)
        .collect();
    let angles: Vec<f64> = groups
        .reduce(&goal)
        .into_iter()
        .map(Option::unwrap)
        .collect();
    let lattice = Lattice::find(&pattern, groups.memberships()).unwrap();
    let mut scene =
        LatticeScene::new(&pattern, groups.memberships(), groups.len(), &lattice).unwrap();
    // A configuration that was tested before must leave nothing behind.
    let other: Vec<f64> = angles.iter().map(|angle| 0.9 * angle).collect();
    scene.deepest_crossing(&other);
    let found = scene.deepest_crossing(&angles);
    let counts = scene.counts();
    assert_eq!(
        counts.pairs,
        counts.tested
            + counts.skipped_symmetry
            + counts.skipped_bounds
            + counts.skipped_edges
            + counts.skipped_motion
    );
    let mut map = FoldingMap::flat(&pattern);
    let tree = SpanningTree::from_central_face(&pattern);
    map.fold_groups(&pattern, &tree, groups.memberships(), &angles);
    let deepest = CollisionScene::new(&pattern).deepest_crossing(&map, 1e-6);
    [found, deepest].map(|crossing| crossing.map_or(0.0, |c| c.depth) / pattern.median_edge())
}

/// Waterbomb sheets that are wide enough pass through themselves after their tube has closed.
#[test]
fn the_lattice_finds_the_deepest_crossing_of_all() {
    let (mut crossed, mut free) = (0, 0);
    let mut compare = |what: &str, drawing: Drawing| {
        let [found, deepest] = both(drawing);
        assert!((found - deepest).abs() < 1e-9, "{what}: {found} {deepest}");
        if deepest > 0.0 {
            crossed += 1;
        } else {
            free += 1;
        }
    };
    for fold in (1..=24).map(|k| f64::from(k) / 25.0) {
        for (rows, columns) in [(4, 6), (8, 4), (10, 10), (12, 22), (13, 9)] {
            let sheet = Waterbomb {
                rows,
                columns,
                fold,
            };
            compare(&format!("{sheet:?}"), sheet.drawing().unwrap());
        }
        for (rows, columns) in [(3, 3), (9, 12)] {
            let sheet = Miura {
                rows,
                columns,
                sector_angle: 1.0,
                fold,
            };
            compare(&format!("{sheet:?}"), sheet.drawing().unwrap());
            let sheet = Yoshimura {
                rows: 2 * rows,
                columns,
                angle: 0.6,
                fold,
            };
            compare(&format!("{sheet:?}"), sheet.drawing().unwrap());
        }
    }
    println!("{crossed} cross, {free} do not");
    assert!(crossed > 20 && free > 100, "{crossed} cross, {free} do not");
}
