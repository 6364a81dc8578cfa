//! Tests the lattice of a tessellation, and the sheet folded by one cell of its lattice, against the whole sheet.

use core::f64::consts::PI;
use std::collections::HashMap;

use crate::common::{class_of, miura, noise, waterbomb, yoshimura};
use foldpath::folding::FoldingMap;
use foldpath::generate::{Letters, Quad, Resch, SquareTwist};
use foldpath::lattice::{
    AngleVariation, Lattice, LatticeCoord, LatticeMotion, LatticeMotionBounds, PairClass, Pose,
    Stretch,
};
use foldpath::pattern::{CreaseId, CreasePattern, Drawing, EdgeId, FaceId};
use foldpath::symmetry::{CreaseGroups, ReducedStars};
use foldpath_core::{HalfAngle, Membership};
use nalgebra::{Rotation2, Vector2, Vector3};
use rand_pcg::Pcg64;

fn quad(rows: usize, columns: usize) -> Drawing {
    let sheet = Quad {
        rows,
        columns,
        fold: 0.0675,
    };
    sheet.drawing().unwrap()
}

fn resch(rows: usize, columns: usize) -> Drawing {
    Resch { rows, columns }.drawing().unwrap()
}

fn square_twist(rows: usize, columns: usize, fold: f64) -> Drawing {
    let sheet = SquareTwist {
        rows,
        columns,
        angle: 0.5,
        letters: Letters::Foldable,
        fold,
    };
    sheet.drawing().unwrap()
}

/// Returns the inverse of a rigid motion.
fn inverse(pose: Pose) -> Pose {
    let r_wf = pose.r_wf.inverse();
    Pose::new(r_wf, -r_wf.rotate(&pose.p_w))
}

/// Returns the rigid motion of space that leads from cell `[0, 0]` to this cell.
fn cell_motion(motion: &LatticeMotion, [i, j]: [i32; 2]) -> Pose {
    let [first, second] = motion.steps();
    first.power(i) * second.power(j)
}

/// Returns the pose of the face of an orbit in a cell, whether the sheet has this face or not.
fn pose(motion: &LatticeMotion, orbit: u32, cell: [i32; 2]) -> Pose {
    cell_motion(motion, cell) * motion.pose(orbit)
}

/// A sheet with its lattice.
struct Sheet {
    pattern: CreasePattern,
    memberships: Vec<Membership>,
    lattice: Lattice,
}

impl Sheet {
    fn find(drawing: Drawing) -> Option<Self> {
        let pattern = CreasePattern::new(drawing).unwrap();
        let memberships = CreaseGroups::find(&pattern).memberships().to_vec();
        Self::with(pattern, memberships)
    }

    fn with(pattern: CreasePattern, memberships: Vec<Membership>) -> Option<Self> {
        let lattice = Lattice::find(&pattern, &memberships)?;
        Some(Self {
            pattern,
            memberships,
            lattice,
        })
    }

    fn new(drawing: Drawing) -> Self {
        Self::find(drawing).expect("a lattice")
    }

    /// Returns the group angles of the goal, which closes.
    fn goal(&self) -> Vec<f64> {
        let groups = self.memberships.iter().map(|m| m.group.index() + 1).max();
        let mut angles = vec![0.0; groups.unwrap()];
        for (membership, &id) in self.memberships.iter().zip(self.pattern.creases()) {
            angles[membership.group.index()] =
                membership.apply(self.pattern.edge(id).goal.unwrap());
        }
        angles
    }

    fn creases(&self, angles: &[f64]) -> Vec<f64> {
        let creases = self.memberships.iter();
        creases.map(|m| m.apply(angles[m.group.index()])).collect()
    }

    /// Returns the folded lattice at these group angles.
    fn motion(&self, angles: &[f64]) -> LatticeMotion {
        let mut motion = LatticeMotion::new(&self.pattern, &self.memberships, &self.lattice);
        motion.fold(&halves(angles));
        motion
    }

    /// Returns the largest distance between a corner moved by a step and the corner that counts as its image.
    fn deviation(&self) -> f64 {
        let corners = |face: FaceId| {
            let cycle = self.pattern.faces()[face.index()].iter();
            cycle.map(|v| self.pattern.vertices()[v.index()])
        };
        let mut worst = 0.0;
        for face in (0..self.pattern.faces().len()).map(FaceId::new) {
            let LatticeCoord { orbit, cell } = self.lattice.coord(face);
            for (step, way) in self.lattice.steps().iter().zip([[1, 0], [0, 1]]) {
                let cell = [cell[0] + way[0], cell[1] + way[1]];
                let image = self.lattice.face_at(LatticeCoord { orbit, cell });
                for corner in image.iter().flat_map(|_| corners(face)) {
                    let moved = corner + step;
                    let off = image
                        .into_iter()
                        .flat_map(corners)
                        .map(|c| (c - moved).norm());
                    worst = f64::max(worst, off.fold(f64::INFINITY, f64::min));
                }
            }
        }
        worst
    }

    /// Returns the corners of a face as the lattice has them: without the translation of the face's cell.
    fn reduced(&self, face: FaceId) -> impl Iterator<Item = Vector2<f64>> {
        let origin = self.lattice.translation(self.lattice.coord(face).cell);
        let cycle = self.pattern.faces()[face.index()].iter();
        cycle.map(move |v| self.pattern.vertices()[v.index()] - origin)
    }

    /// Returns the largest distance between the corners of a face in the lattice and in the whole folding map, as seen
    /// from the first face of each pair of faces.
    fn disagreement(&self, angles: &[f64]) -> f64 {
        let motion = self.motion(angles);
        let tree = self.pattern.tree();
        let map = FoldingMap::new(&self.pattern, tree, &self.creases(angles));
        let faces = 0..self.pattern.faces().len();
        let mut relative = HashMap::new();
        let mut worst = 0.0_f64;
        for a in faces.clone().map(FaceId::new) {
            let from = self.lattice.coord(a);
            let origin = self.lattice.translation(from.cell).push(0.0);
            let back = inverse(map.poses()[a.index()]);
            for b in faces.clone().skip(a.index() + 1).map(FaceId::new) {
                let (class, pair) = class_of(&self.lattice, [a, b]).unwrap();
                // Pose of the second face of the class as seen from the first.
                let seen = *relative.entry(class).or_insert_with(|| {
                    let [first, second] = class.orbits;
                    inverse(motion.pose(first)) * pose(&motion, second, class.offset)
                });
                let seen = if pair == [a, b] { seen } else { inverse(seen) };
                let expected = back * map.poses()[b.index()];
                let cycle = self.pattern.faces()[b.index()].iter();
                for (reduced, vertex) in self.reduced(b).zip(cycle) {
                    let flat = self.pattern.vertices()[vertex.index()];
                    let off = seen.apply(reduced) - (expected.apply(flat) - origin);
                    worst = worst.max(off.norm());
                }
            }
        }
        worst
    }

    /// Checks from edge to edge that the lattice is right. If two neighbouring faces both have images under a
    /// translation of the lattice, the images share the translated edge, which turns like the original edge.
    fn check(&self, what: &str) {
        let Self {
            pattern, lattice, ..
        } = self;
        let hinge = |crease: Option<CreaseId>| crease.map(|id| self.memberships[id.index()]);
        let mut beyond: HashMap<[FaceId; 2], Vec<_>> = HashMap::new();
        for edge in pattern.edges() {
            if let Some([a, b]) = edge.inner_faces() {
                for pair in [[a, b], [b, a]] {
                    beyond.entry(pair).or_default().push(edge);
                }
            }
        }
        let mut of_orbit = vec![Vec::new(); lattice.orbits().len()];
        for (face, place) in lattice.coords().iter().enumerate() {
            let face = FaceId::new(face);
            assert_eq!(lattice.face_at(*place), Some(face), "{what}");
            of_orbit[place.orbit as usize].push(face);
            let orbit = lattice.orbits()[place.orbit as usize];
            assert!((0..2).all(|k| (orbit.low[k]..=orbit.high[k]).contains(&place.cell[k])));
        }
        for (&[a, b], edges) in &beyond {
            let (from, to) = (lattice.coord(a), lattice.coord(b));
            for &image in &of_orbit[from.orbit as usize] {
                let on = [0, 1].map(|k| lattice.coord(image).cell[k] - from.cell[k]);
                let shift = lattice.translation(on);
                let cell = [0, 1].map(|k| to.cell[k] + on[k]);
                let orbit = to.orbit;
                let Some(other) = lattice.face_at(LatticeCoord { orbit, cell }) else {
                    continue;
                };
                let images = &beyond[&[image, other]];
                assert_eq!(images.len(), edges.len(), "{what}");
                for edge in edges {
                    let ends = edge.ends.map(|v| pattern.vertices()[v.index()] + shift);
                    let found = images.iter().any(|image| {
                        let places = image.ends.map(|v| pattern.vertices()[v.index()]);
                        let same = |order: [usize; 2]| {
                            (0..2).all(|k| (places[order[k]] - ends[k]).norm() < 1e-5)
                        };
                        (same([0, 1]) || same([1, 0])) && hinge(image.crease) == hinge(edge.crease)
                    });
                    assert!(found, "{what}: {a} {b} to {image} {other}");
                }
            }
        }
    }
}

fn halves(angles: &[f64]) -> Vec<HalfAngle<f64>> {
    angles.iter().map(|&angle| HalfAngle::of(angle)).collect()
}

/// The number of faces of a cell is that of the sheet times the area of the cell over that of the sheet, for sheets of
/// whole cells.
#[test]
fn steps_and_orbits_are_those_found_by_hand() {
    let (miura_height, yoshimura_height) = (3_f64.sqrt(), 1.0 / 0.9_f64.tan());
    let root3 = 3_f64.sqrt();
    for (name, drawing, steps, orbits) in [
        // A cell has two rows and two columns of faces.
        (
            "miura 3x3",
            miura(3, 3, 0.7),
            [[2.0, 0.0], [0.0, miura_height]],
            4,
        ),
        (
            "miura 24x24",
            miura(24, 24, 0.7),
            [[2.0, 0.0], [0.0, miura_height]],
            4,
        ),
        // Units of six faces lie on two by two squares. The units of the next row are shifted by one.
        (
            "waterbomb 4x6",
            waterbomb(4, 6, 0.5),
            [[2.0, 0.0], [1.0, 2.0]],
            6,
        ),
        (
            "waterbomb 12x22",
            waterbomb(12, 22, 0.5),
            [[2.0, 0.0], [1.0, 2.0]],
            6,
        ),
        // Triangles lie to the left and right of straight creases. At the top and bottom there are halves of both.
        (
            "yoshimura 12x12",
            yoshimura(12, 12, 0.3),
            [[1.0, yoshimura_height], [-1.0, yoshimura_height]],
            6,
        ),
        // A cell is one parallelogram of two triangles.
        (
            "quad 3x3",
            quad(3, 3),
            [[1.0, 0.0], [1.85 * 0.1_f64.cos(), 1.85 * 0.1_f64.sin()]],
            2,
        ),
        (
            "quad 24x24",
            quad(24, 24),
            [[1.0, 0.0], [1.85 * 0.1_f64.cos(), 1.85 * 0.1_f64.sin()]],
            2,
        ),
        // A cell has the six faces of a star, and two faces between stars.
        (
            "resch 3x3",
            resch(3, 3),
            [[1.5 * root3, 1.5], [0.0, 3.0]],
            8,
        ),
        (
            "resch 8x8",
            resch(8, 8),
            [[1.5 * root3, 1.5], [0.0, 3.0]],
            8,
        ),
    ] {
        let sheet = Sheet::new(drawing);
        sheet.check(name);
        assert_eq!(sheet.lattice.orbits().len(), orbits, "{name}");
        assert!(sheet.deviation() < 1e-12, "{name}");
        let [a, b] = steps.map(Vector2::from);
        let found = sheet.lattice.steps();
        assert_eq!(found.len(), 2, "{name}");
        // The steps found are whole combinations of the expected ones, with determinant 1 or -1, so the lattice is the
        // same.
        let parts =
            [found[0], found[1]].map(|step| [step.perp(&b), a.perp(&step)].map(|x| x / a.perp(&b)));
        let whole = parts
            .as_flattened()
            .iter()
            .all(|x| (x - x.round()).abs() < 1e-9);
        let det = parts[0][0] * parts[1][1] - parts[0][1] * parts[1][0];
        assert!(whole && (det.abs() - 1.0).abs() < 1e-9, "{name}: {found:?}");
    }
}

/// Two rows, or two columns, of Miura faces have a single step, which runs along the strip.
#[test]
fn a_strip_has_one_step() {
    for (drawing, step) in [
        (miura(2, 9, 0.7), [2.0, 0.0]),
        (miura(9, 2, 0.7), [0.0, 3_f64.sqrt()]),
    ] {
        let sheet = Sheet::new(drawing);
        sheet.check("strip");
        let [found] = sheet.lattice.steps() else {
            panic!("{:?}", sheet.lattice.steps());
        };
        assert!((found - Vector2::from(step)).norm() < 1e-12, "{found}");
        assert_eq!(sheet.lattice.orbits().len(), 4);
        assert!(sheet.disagreement(&sheet.goal()) < 1e-12);
    }
}

/// All pairs of faces are compared at closed configurations on the motions of the families.
#[test]
fn relative_poses_are_those_of_the_whole_folding_map() {
    let mut random = Pcg64::new(7, 1);
    for _ in 0..4 {
        let mut fold = || 0.5 + 0.45 * noise(&mut random);
        for (name, drawing) in [
            ("miura 5x5", miura(5, 5, fold())),
            ("miura 11x24", miura(11, 24, fold())),
            ("waterbomb 8x10", waterbomb(8, 10, fold())),
            ("waterbomb 12x22", waterbomb(12, 22, fold())),
            ("yoshimura 12x12", yoshimura(12, 12, fold())),
            ("square twist 4x4", square_twist(4, 4, fold())),
            ("resch 6x6", resch(6, 6)),
        ] {
            let sheet = Sheet::new(drawing);
            sheet.check(name);
            let worst = sheet.disagreement(&sheet.goal());
            println!("{name}: {worst:.1e}");
            assert!(worst < 1e-11, "{name}: {worst:e}");
        }
    }
}

/// Only the long sides turn, about parallel axes. A step is then a rotation, and far cells go round many times.
#[test]
fn a_rolled_sheet_is_that_of_the_whole_folding_map() {
    let sheet = Sheet::new(quad(6, 40));
    let long = sheet.pattern.creases().iter().position(|&id| {
        let ends = sheet.pattern.edge(id).ends;
        (sheet.pattern.length(ends) - 1.85).abs() < 1e-9
    });
    let long = sheet.memberships[long.unwrap()].group.index();
    for angle in [0.01, 0.3, -1.0, 2.5, PI] {
        let mut angles = vec![0.0; 3];
        angles[long] = angle;
        let worst = sheet.disagreement(&angles);
        assert!(worst < 1e-11, "{angle}: {worst:e}");
        let [first, second] = sheet.motion(&angles).steps().map(|step| step.motion());
        let turned = [first, second].map(|step| step.r_wf.v.norm());
        let expected = (angle / 2.0).sin().abs();
        assert!(
            turned.iter().any(|sin| (sin - expected).abs() < 1e-12),
            "{turned:?}"
        );
    }
}

/// Cells a thousand steps away are exact to 1e-12 of the sheet's size.
#[test]
fn far_cells_are_as_exact_as_the_whole_folding_map() {
    for (name, drawing) in [
        ("miura 2x2000", miura(2, 2000, 0.6)),
        ("waterbomb 4x2000", waterbomb(4, 2000, 0.4)),
        ("yoshimura 4x1000", yoshimura(4, 1000, 0.2)),
    ] {
        let sheet = Sheet::new(drawing);
        let angles = sheet.goal();
        let motion = sheet.motion(&angles);
        let tree = sheet.pattern.tree();
        let map = FoldingMap::new(&sheet.pattern, tree, &sheet.creases(&angles));
        let vertices = sheet.pattern.vertices();
        let size = vertices.iter().map(|v| v.norm()).fold(0.0, f64::max);
        let base = FaceId(0);
        let at_base = sheet.lattice.coord(base);
        let frame = map.poses()[0] * inverse(pose(&motion, at_base.orbit, at_base.cell));
        let mut worst = 0.0_f64;
        for face in (0..sheet.pattern.faces().len()).map(FaceId::new) {
            let place = sheet.lattice.coord(face);
            let origin = sheet.lattice.translation(at_base.cell).push(0.0);
            let pose = frame * pose(&motion, place.orbit, place.cell);
            let cycle = sheet.pattern.faces()[face.index()].iter();
            for (reduced, vertex) in sheet.reduced(face).zip(cycle) {
                let expected = map.poses()[face.index()].apply(vertices[vertex.index()]);
                // Here face 0 has its flat points without its own translation.
                let off = pose.apply(reduced) + map.poses()[0].r_wf.rotate(&origin) - expected;
                worst = worst.max(off.norm());
            }
        }
        println!("{name}: {:.1e} of its size", worst / size);
        assert!(worst < 1e-12 * size, "{name}: {:e}", worst / size);
    }
}

/// Each pair of faces is in exactly one class, and that class has the pair. No other class has pairs.
#[test]
fn classes_part_the_pairs() {
    for (name, drawing) in [
        ("miura 5x7", miura(5, 7, 0.7)),
        ("miura 2x9", miura(2, 9, 0.7)),
        ("waterbomb 8x10", waterbomb(8, 10, 0.5)),
        ("yoshimura 6x7", yoshimura(6, 7, 0.3)),
        ("resch 4x4", resch(4, 4)),
        ("quad 5x4", quad(5, 4)),
    ] {
        let Sheet { lattice, .. } = Sheet::new(drawing);
        let faces = lattice.coords().len();
        let mut count: HashMap<PairClass, u64> = HashMap::new();
        for a in (0..faces).map(FaceId::new) {
            assert_eq!(class_of(&lattice, [a, a]), None);
            for b in (0..a.index()).map(FaceId::new) {
                let (class, pair) = class_of(&lattice, [a, b]).unwrap();
                assert_eq!(class_of(&lattice, [b, a]), Some((class, pair)));
                assert!(pair == [a, b] || pair == [b, a]);
                *count.entry(class).or_default() += 1;
            }
        }
        let orbits = 0..u32::try_from(lattice.orbits().len()).unwrap();
        let orbits = orbits.clone().flat_map(|b| (0..=b).map(move |a| [a, b]));
        // Some of these classes have no pair.
        let offsets = || (-20..=20).flat_map(|row| (-20..=20).map(move |column| [column, row]));
        let classes =
            orbits.flat_map(|orbits| offsets().map(move |offset| PairClass { orbits, offset }));
        // Within an orbit, one of two opposite offsets is a class.
        let ordered = |class: &PairClass| {
            let ([a, b], [column, row]) = (class.orbits, class.offset);
            a < b || (row, column) > (0, 0)
        };
        let (mut found, mut missing) = (0, 0);
        for class in &classes.filter(ordered).collect::<Vec<_>>() {
            let pair = lattice.pair_of(*class);
            assert_eq!(
                pair.is_some(),
                count.contains_key(class),
                "{name} {class:?}"
            );
            if let Some(pair) = pair {
                assert_eq!(class_of(&lattice, pair), Some((*class, pair)));
                found += 1;
            } else {
                missing += 1;
            }
        }
        assert_eq!(found, count.len(), "{name}");
        assert!(missing > 0, "{name}");
    }
}

/// A sheet with a defect in the middle is tested with its own groups, and with those of the sheet without the defect.
/// It has no steps, or only steps that take the defect to the border or beyond.
#[test]
fn a_defect_has_no_step_or_only_right_ones() {
    let clean = CreasePattern::new(miura(9, 9, 0.7)).unwrap();
    let groups = CreaseGroups::find(&clean);
    let vertex = clean.real_vertices().nth(28).unwrap();
    let place = clean.vertices()[vertex.index()];
    let far = |id: usize| {
        let ends = clean.edges()[id].ends;
        let middle = ends.iter().map(|v| clean.vertices()[v.index()]).sum();
        (place - 0.5 * Vector2::clone(&middle)).norm()
    };
    let creases = || clean.creases().iter().map(|id| id.index());
    let central = creases()
        .min_by(|&a, &b| far(a).total_cmp(&far(b)))
        .unwrap();
    let mut moved = miura(9, 9, 0.7);
    moved.vertices[vertex.index()].x += 1e-3;
    let mut missing = miura(9, 9, 0.7);
    missing.edges.remove(central);
    let mut flipped = miura(9, 9, 0.7);
    flipped.edges[central].letter = flipped.edges[central].letter.flipped();
    flipped.edges[central].goal = None;
    for (what, drawing) in [("moved", moved), ("missing", missing), ("flipped", flipped)] {
        let pattern = CreasePattern::new(drawing.clone()).unwrap();
        let before = |&id: &EdgeId| {
            let ends = pattern.edge(id).ends;
            let same = creases()
                .find(|&other| clean.edges()[other].ends == ends)
                .unwrap();
            let mut membership = groups.of(clean.edges()[same].crease.unwrap());
            membership.negative ^= what == "flipped" && same == central;
            membership
        };
        let memberships: Vec<_> = pattern.creases().iter().map(before).collect();
        assert!(
            Lattice::find(&pattern, &memberships[1..]).is_none(),
            "one too few"
        );
        for sheet in [Sheet::find(drawing), Sheet::with(pattern, memberships)] {
            let Some(sheet) = sheet else {
                println!("{what}: none");
                continue;
            };
            println!(
                "{what}: {:?}, {} orbits",
                sheet.lattice.steps(),
                sheet.lattice.orbits().len()
            );
            sheet.check(what);
            let steps = sheet.lattice.steps().iter();
            let shortest = steps.map(|step| step.norm()).fold(f64::INFINITY, f64::min);
            assert!(shortest > 3.0, "{what}: {shortest}");
        }
    }
}

/// The sheet is turned, scaled, moved and renumbered.
#[test]
fn the_lattice_moves_with_the_sheet() {
    for (name, drawing) in [
        ("waterbomb", waterbomb(8, 10, 0.5)),
        ("yoshimura", yoshimura(9, 8, 0.3)),
        ("resch", resch(4, 5)),
    ] {
        let expected = Sheet::new(drawing.clone()).lattice;
        for (turn, scale, shift) in [(1.2, 1.0, 0.0), (-2.5, 1e3, 1e4), (0.4, 1e-3, -5.0)] {
            let mut moved = drawing.clone();
            for vertex in &mut moved.vertices {
                *vertex = (Rotation2::new(turn) * *vertex) * scale + Vector2::repeat(shift);
            }
            moved.edges.reverse();
            let sheet = Sheet::new(moved);
            sheet.check(name);
            assert_eq!(
                sheet.lattice.orbits().len(),
                expected.orbits().len(),
                "{name}"
            );
            let area = |steps: &[Vector2<f64>]| steps[0].perp(&steps[1]).abs();
            let ratio = area(sheet.lattice.steps()) / (area(expected.steps()) * scale * scale);
            assert!((ratio - 1.0).abs() < 1e-9, "{name}: {ratio}");
        }
    }
}

#[test]
fn a_sheet_with_a_hole_has_a_lattice_and_two_sheets_have_none() {
    let whole = CreasePattern::new(miura(9, 9, 0.7)).unwrap();
    let groups = CreaseGroups::find(&whole);
    let faces = whole.faces().iter();
    let faces: Vec<Vec<usize>> = faces
        .map(|f| f.iter().map(|v| v.index()).collect())
        .collect();
    let without = |taken: core::ops::Range<usize>| {
        let mut left = faces.clone();
        left.drain(taken);
        let drawing = Drawing {
            faces: Some(left),
            ..miura(9, 9, 0.7)
        };
        let pattern = CreasePattern::new(drawing).unwrap();
        // Edges of the hole are no longer creases. All other edges keep their groups.
        let edges = pattern.edges().iter().zip(whole.edges());
        let creases = edges.filter(|(edge, _)| edge.crease.is_some());
        let memberships = creases.map(|(_, edge)| groups.of(edge.crease.unwrap()));
        let memberships = memberships.collect();
        (pattern, memberships)
    };
    let (pattern, memberships) = without(40..41);
    assert_eq!(pattern.holes().len(), 1);
    let sheet = Sheet::with(pattern, memberships).expect("a lattice");
    sheet.check("hole");
    assert_eq!(sheet.lattice.orbits().len(), 4);
    assert!(sheet.disagreement(&sheet.goal()) < 1e-12);
    // The middle row of faces is missing.
    let (pattern, memberships) = without(36..45);
    assert_eq!(pattern.sheets(), 2);
    assert!(Sheet::with(pattern, memberships).is_none());
}

/// If the sheet does not close, the lattice and the folding map differ by no more than the bound
/// `Lattice::lattice_deviation`.
#[test]
fn faces_deviate_from_the_lattice_no_farther_than_their_vertices_allow() {
    let mut random = Pcg64::new(21, 4);
    let mut fullest = 0.0_f64;
    for (name, drawing) in [
        ("miura", miura(6, 7, 0.5)),
        ("waterbomb", waterbomb(6, 8, 0.5)),
        ("yoshimura", yoshimura(8, 8, 0.3)),
        ("square twist", square_twist(4, 4, 0.5)),
    ] {
        let sheet = Sheet::new(drawing);
        let groups = CreaseGroups::find(&sheet.pattern);
        let stars = ReducedStars::all(&sheet.pattern, &groups);
        for round in 0..12 {
            let size = 10_f64.powi(-2 - round % 4);
            let angles = sheet.goal().into_iter();
            let angles: Vec<_> = angles
                .map(|angle| angle + size * noise(&mut random))
                .collect();
            let residual = stars.largest_residual(&angles);
            let most = sheet.lattice.lattice_deviation(&sheet.pattern, residual)
                * sheet.pattern.median_edge();
            let off = sheet.disagreement(&angles);
            assert!(off <= most + 1e-12, "{name} {size:e}: {off:e} {most:e}");
            fullest = fullest.max(off / most);
        }
    }
    assert!(fullest > 0.01, "of use: {fullest}");
}

/// Compares `LatticeMotionBounds` with a motion on which hinges turn evenly between two sets of group angles. The
/// distance between corners of different cells must not be less than the gap, and must not change by more than the
/// bounds allow. Returns the largest change over its bound.
fn filled(sheet: &Sheet, [from, to]: [&[f64]; 2], what: &str) -> f64 {
    let changes = || from.iter().zip(to).map(|(a, b)| b - a);
    let mut bounds = LatticeMotionBounds::new(&sheet.motion(from), [1000, 1000]);
    let variations: Vec<_> = changes()
        .map(|change| AngleVariation {
            total: change.abs(),
            nonlinearity: 0.0,
        })
        .collect();
    let half_way: Vec<f64> = from.iter().zip(to).map(|(a, b)| (a + b) / 2.0).collect();
    let configurations = [&halves(&half_way)[..], &halves(to)];
    bounds.push(
        &mut sheet.motion(from),
        configurations,
        &variations,
        [f64::INFINITY; 2],
    );
    let at = |part: f64| -> Vec<f64> {
        let angles = from.iter().zip(changes());
        angles.map(|(a, change)| a + part * change).collect()
    };
    let parts = [
        [0.0, 0.2],
        [0.0, 0.5],
        [0.0, 0.8],
        [0.0, 1.0],
        [0.3, 0.5],
        [0.5, 1.0],
        [0.97, 1.0],
    ];
    let filled = parts.map(|[since, until]| {
        let stretch = if since > 0.0 {
            let head = until - since;
            Stretch {
                head,
                from: 1,
                to: 1,
            }
        } else {
            [0, 1].into()
        };
        let what = format!("{what} from {since} to {until}");
        filled_between(sheet, [&at(since), &at(until)], (&bounds, stretch), &what)
    });
    filled.into_iter().fold(0.0, f64::max)
}

fn filled_between(
    sheet: &Sheet,
    ends: [&[f64]; 2],
    (bounds, stretch): (&LatticeMotionBounds, Stretch),
    what: &str,
) -> f64 {
    let motions = ends.map(|angles| sheet.motion(angles));
    let corners = |motion: &LatticeMotion, cell| {
        let mut all = Vec::new();
        for orbit in (0..).take(sheet.lattice.orbits().len()) {
            let pose = pose(motion, orbit, cell);
            all.extend(motion.corners(orbit).iter().map(|&c| pose.apply(c)));
        }
        all
    };
    let here = motions.each_ref().map(|motion| corners(motion, [0, 0]));
    let mut fullest = 0.0_f64;
    let near = [[1, 0], [0, 1], [-1, 1], [3, 0], [0, -4], [2, 5], [-7, 3]];
    let far = [[40, 0], [0, 30], [-1000, 0], [0, 1000], [300, -300]];
    for offset in near.into_iter().chain(far) {
        let there = motions.each_ref().map(|motion| corners(motion, offset));
        let (gap, bound) = (
            motions[0].gap_at(&cell_motion(&motions[0], offset).carry(&motions[0].middle())),
            bounds.cells(stretch, offset),
        );
        let mut most = 0.0_f64;
        let pairs = |corners: &[Vec<Vector3<f64>>; 2]| {
            let [before, after] = corners.each_ref().map(|corners| corners.iter().copied());
            before.zip(after).collect::<Vec<_>>()
        };
        for (a, a_after) in pairs(&here) {
            for (b, b_after) in pairs(&there) {
                let [before, after] = [(a - b).norm(), (a_after - b_after).norm()];
                assert!(before >= gap - 1e-10, "{what} {offset:?}: {before} {gap}");
                most = most.max((after - before).abs());
            }
        }
        assert!(
            most <= bound + 1e-10,
            "{what} {offset:?}: {most:e} {bound:e}"
        );
        fullest = fullest.max(most / (bound + 1e-10));
    }
    fullest
}

/// The motions lead from closed configurations to others.
#[test]
fn gap_and_bounds_hold_for_motions() {
    let mut random = Pcg64::new(3, 3);
    let mut fullest = 0.0_f64;
    let rolled = |angle: f64| {
        let mut drawing = quad(4, 9);
        for edge in &mut drawing.edges {
            let length = (drawing.vertices[edge.ends[1]] - drawing.vertices[edge.ends[0]]).norm();
            let long = (length - 1.85).abs() < 1e-9;
            edge.goal = edge.goal.map(|_| if long { angle } else { 0.0 });
        }
        drawing
    };
    for size in [1e-6, 1e-3, 0.05, 0.3] {
        for _ in 0..6 {
            let fold = 0.5 + 0.4 * noise(&mut random);
            let other = (fold + size * noise(&mut random)).clamp(0.05, 0.95);
            let both = [fold, other];
            for (name, [from, to]) in [
                ("miura", both.map(|fold| miura(9, 9, fold))),
                ("waterbomb", both.map(|fold| waterbomb(8, 12, fold))),
                ("yoshimura", both.map(|fold| yoshimura(8, 8, fold))),
                ("square twist", both.map(|fold| square_twist(4, 4, fold))),
                ("rolled quad", both.map(rolled)),
                (
                    "flattened waterbomb",
                    [size * fold, size * fold / 50.0].map(|fold| waterbomb(8, 12, fold)),
                ),
            ] {
                // Both are the same sheet with different goals.
                let (sheet, next) = (Sheet::new(from), Sheet::new(to));
                let angles = [&sheet.goal()[..], &next.goal()];
                fullest = fullest.max(filled(&sheet, angles, &format!("{name} {size:e}")));
            }
        }
    }
    println!("filled to {fullest:.2}");
    assert!(fullest > 0.3, "of use: {fullest}");
}

/// The bound does not require that the sheet closes. At the flat sheet much of the first order cancels, so the second
/// order counts.
#[test]
fn gap_and_bounds_hold_for_changes_that_do_not_close() {
    let mut random = Pcg64::new(13, 3);
    for (name, drawing) in [
        ("miura", miura(9, 9, 0.5)),
        ("waterbomb", waterbomb(8, 12, 0.5)),
        ("yoshimura", yoshimura(8, 8, 0.5)),
        ("square twist", square_twist(4, 4, 0.5)),
        ("resch", resch(5, 5)),
        ("quad", quad(5, 5)),
    ] {
        let sheet = Sheet::new(drawing);
        let groups = sheet.goal().len();
        for round in 0..40 {
            let size = 10_f64.powi(-(round % 4));
            let start = if round < 20 { 0.0 } else { 1.5 };
            let from: Vec<f64> = (0..groups).map(|_| start * noise(&mut random)).collect();
            let to = from.iter().map(|angle| angle + size * noise(&mut random));
            let to: Vec<f64> = to.collect();
            filled(&sheet, [&from, &to], name);
        }
    }
}
