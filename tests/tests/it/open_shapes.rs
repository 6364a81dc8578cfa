//! Are open shapes cut into as few pieces as random cuts make, and does the flat sheet fold back to the shape?

use core::time::Duration;
use std::collections::VecDeque;

use foldpath::folding::align_rigid;
use foldpath::pattern::CreasePattern;
use foldpath::planner::{Outcome, PlanOptions};
use foldpath::read::fold::PatternFile;
use foldpath::unfold::{FoldedShape, UnfoldOptions, unfold};
use foldpath_tests::{Animation, Planned, Random, meshes, worst};
use nalgebra::{Vector2, Vector3};

/// Number of shapes: as many of each kind.
const SHAPES: u64 = 60;
/// Number of random trees of cuts for each shape.
const TREES: usize = 1000;

#[test]
fn open_shapes_are_cut_into_as_few_pieces_as_random_cuts_make() {
    for seed in 0..SHAPES {
        let shape = drawn(seed);
        let unfolding = unfold(&shape, &UnfoldOptions::default()).unwrap();
        assert!(
            unfolding.drawing.is_some(),
            "seed {seed}: {:?}",
            unfolding.reason
        );
        let best = fewest_pieces(&shape, &mut Random::new(seed));
        assert!(
            unfolding.pieces <= best + 1,
            "seed {seed}: {} pieces, not {best}",
            unfolding.pieces
        );
    }
}

/// The oracle folds one sheet. Shapes of several pieces are judged by the pieces alone.
#[test]
fn open_shapes_fold_back_from_their_flat_sheets() {
    let mut whole = 0;
    for seed in 0..SHAPES {
        let shape = drawn(seed);
        let unfolding = unfold(&shape, &UnfoldOptions::default()).unwrap();
        assert!(unfolding.deviation.unwrap() < 1e-9, "seed {seed}");
        let drawing = unfolding.drawing.unwrap();
        let pattern = CreasePattern::new(drawing.clone()).unwrap();
        let title = format!("seed {seed}");
        let options = PlanOptions::default().with(|it| {
            it.keep_vertices = true;
            it.timeout = Some(Duration::from_secs(60));
        });
        let planned = Planned::of(PatternFile { title, pattern }, &options);
        let plan = &planned.plan;
        assert_eq!(
            plan.outcome,
            Outcome::Planned,
            "seed {seed}: {:?}",
            plan.reason
        );
        if unfolding.pieces > 1 {
            continue;
        }
        whole += 1;
        let path = Animation::parse(&planned.text()).unwrap();
        let goal = path.frames.last().unwrap();
        let folded = path.sheet.positions(&path.sheet.fold(&goal.angles));
        let [folded, expected] = [
            marks(&folded, &drawing.faces.unwrap()),
            marks(&shape.vertices, &shape.faces),
        ];
        let laid = align_rigid(&folded, &expected);
        let apart = worst(laid.iter().zip(&expected).map(|(a, b)| (a - b).norm()));
        assert!(apart < 1e-6 * shape.size(), "seed {seed}: {apart}");
    }
    assert!(10 * whole >= 9 * SHAPES, "{whole}");
}

/// Eight panels go round a square hole. The last one lies beside the first in the plane, but no edge joins them in the
/// shape, where half of the panels stand upright. They touch along the width of the last panel, and do not overlap.
#[test]
fn faces_that_touch_in_the_plane_do_not_overlap() {
    for width in [1.0, 0.6] {
        let shape = half_upright_ring(width);
        let unfolding = unfold(&shape, &UnfoldOptions::default()).unwrap();
        assert_eq!(
            (unfolding.cuts, unfolding.pieces),
            (0, 1),
            "{:?}",
            unfolding.reason
        );
        let pattern = CreasePattern::new(unfolding.drawing.unwrap()).unwrap();
        let title = "ring".into();
        let planned = Planned::of(PatternFile { title, pattern }, &PlanOptions::default());
        assert_eq!(
            planned.plan.outcome,
            Outcome::Planned,
            "{:?}",
            planned.plan.reason
        );
    }
}

/// Returns eight panels round a square hole, the last of this width. The second half is turned up by 90 degrees.
fn half_upright_ring(width: f64) -> FoldedShape {
    let ring = [[0, 0], [1, 0], [2, 0], [2, 1], [2, 2], [1, 2]];
    let mut places: Vec<[f64; 2]> = Vec::new();
    let mut named = |place: [f64; 2]| {
        let bits = place.map(f64::to_bits);
        let known = places.iter().position(|p| p.map(f64::to_bits) == bits);
        known.unwrap_or_else(|| {
            places.push(place);
            places.len() - 1
        })
    };
    let mut faces: Vec<Vec<usize>> = ring
        .iter()
        .map(|&[x, y]| {
            let [x, y] = [x, y].map(f64::from);
            [[x, y], [x + 1.0, y], [x + 1.0, y + 1.0], [x, y + 1.0]]
                .map(&mut named)
                .to_vec()
        })
        .collect();
    let top = [[1.0, 2.0], [1.0, 3.0], [0.0, 3.0], [0.0, 2.0]].map(&mut named);
    let [right, left] = [named([width, 2.0]), top[3]];
    let mut corner = top.to_vec();
    if right != top[0] {
        corner.push(right);
    }
    faces.push(corner);
    // Corners of its own, at the places of others in the plane.
    faces.push(vec![places.len(), places.len() + 1, right, left]);
    places.extend([[0.0, 1.0], [width, 1.0]]);
    let upright: Vec<usize> = faces[4..].concat();
    let fold = |(vertex, &[x, y]): (usize, &[f64; 2])| {
        if upright.contains(&vertex) {
            Vector3::new(x, 2.0, y - 2.0)
        } else {
            Vector3::new(x, y, 0.0)
        }
    };
    FoldedShape {
        vertices: places.iter().enumerate().map(fold).collect(),
        faces,
        edges: Vec::new(),
    }
}

fn drawn(seed: u64) -> FoldedShape {
    let kind = usize::try_from(seed).unwrap();
    meshes::open_shape(&mut Random::new(seed), kind)
}

/// Returns two points for each face that do not depend on how many corners lie on its sides: its centre of area, and the
/// point above it on the face's upper side.
fn marks(places: &[Vector3<f64>], faces: &[Vec<usize>]) -> Vec<Vector3<f64>> {
    let marks = faces.iter().flat_map(|cycle| {
        let at = |k: usize| places[cycle[k % cycle.len()]];
        let fan = (1..cycle.len() - 1).map(|k| {
            let area = (at(k) - at(0)).cross(&(at(k + 1) - at(0)));
            (area, (at(0) + at(k) + at(k + 1)) / 3.0)
        });
        let whole: Vector3<f64> = fan.clone().map(|(area, _)| area).sum();
        let up = whole.normalize();
        let centre: Vector3<f64> = fan.map(|(area, centre)| centre * area.dot(&up)).sum();
        let centre = centre / whole.norm();
        [centre, centre + up]
    });
    marks.collect()
}

/// Returns the smallest number of pieces of random spanning trees of the faces. Each face is laid beside its neighbour in
/// the tree, or begins a new piece if it would overlap the piece.
fn fewest_pieces(shape: &FoldedShape, random: &mut Random) -> usize {
    let count = shape.faces.len();
    let mut joints = Vec::new();
    for (a, first) in shape.faces.iter().enumerate() {
        for (b, second) in shape.faces.iter().enumerate().skip(a + 1) {
            joints.extend(
                sides(first)
                    .filter(|[x, y]| sides(second).any(|s| s == [*y, *x]))
                    .map(|s| (a, b, s)),
            );
        }
    }
    let mut best = count;
    for _ in 0..TREES {
        if best == 1 {
            break;
        }
        for k in (1..joints.len()).rev() {
            joints.swap(k, random.below(k + 1));
        }
        let mut groups: Vec<usize> = (0..count).collect();
        let mut beyond = vec![Vec::new(); count];
        for &(a, b, side) in &joints {
            let (from, to) = (groups[a], groups[b]);
            if from != to {
                groups
                    .iter_mut()
                    .filter(|group| **group == from)
                    .for_each(|group| *group = to);
                beyond[a].push((b, side));
                beyond[b].push((a, [side[1], side[0]]));
            }
        }
        best = best.min(pieces(shape, &beyond));
    }
    best
}

fn sides(cycle: &[usize]) -> impl Iterator<Item = [usize; 2]> {
    let next = cycle.iter().cycle().skip(1);
    cycle.iter().zip(next).map(|(&a, &b)| [a, b])
}

/// Lays the faces along a tree and returns the number of pieces. `beyond` has for each face its neighbours in the tree, each
/// with the common side in the order of the face.
fn pieces(shape: &FoldedShape, beyond: &[Vec<(usize, [usize; 2])>]) -> usize {
    let mut laid: Vec<Option<(usize, Vec<Vector2<f64>>)>> = vec![None; beyond.len()];
    laid[0] = Some((0, flat(shape, 0)));
    let mut count = 1;
    let mut open = VecDeque::from([0]);
    while let Some(face) = open.pop_front() {
        let (piece, places) = laid[face].clone().unwrap();
        for &(other, [a, b]) in &beyond[face] {
            if laid[other].is_some() {
                continue;
            }
            let own = flat(shape, other);
            let at = |face: usize, places: &[Vector2<f64>], vertex: usize| {
                places[shape.faces[face].iter().position(|v| *v == vertex).unwrap()]
            };
            let [to_a, to_b] = [a, b].map(|v| at(face, &places, v));
            let [from_a, from_b] = [a, b].map(|v| at(other, &own, v));
            let (from, to) = (from_b - from_a, to_b - to_a);
            let (cos, sin) = (
                from.dot(&to) / from.norm_squared(),
                from.perp(&to) / from.norm_squared(),
            );
            let moved = own.iter().map(|p| {
                let arm = p - from_a;
                to_a + Vector2::new(cos * arm.x - sin * arm.y, sin * arm.x + cos * arm.y)
            });
            let moved: Vec<_> = moved.collect();
            let mut others = laid.iter().flatten().filter(|(of, _)| *of == piece);
            if others.any(|(_, placed)| overlap(placed, &moved)) {
                laid[other] = Some((count, own));
                count += 1;
            } else {
                laid[other] = Some((piece, moved));
            }
            open.push_back(other);
        }
    }
    count
}

/// Returns a face in its plane.
fn flat(shape: &FoldedShape, face: usize) -> Vec<Vector2<f64>> {
    let at = |k: usize| shape.vertices[shape.faces[face][k]];
    let x = (at(1) - at(0)).normalize();
    let up = x.cross(&(at(2) - at(0))).normalize();
    let y = up.cross(&x);
    let place = |k| {
        let arm: Vector3<f64> = at(k) - at(0);
        Vector2::new(arm.dot(&x), arm.dot(&y))
    };
    (0..shape.faces[face].len()).map(place).collect()
}

/// Returns `true` if two convex polygons have more than a side in common.
fn overlap(a: &[Vector2<f64>], b: &[Vector2<f64>]) -> bool {
    let parted = |a: &[Vector2<f64>], b: &[Vector2<f64>]| {
        (0..a.len()).any(|k| {
            let side = a[(k + 1) % a.len()] - a[k];
            b.iter()
                .all(|p| side.perp(&(p - a[k])) <= 1e-9 * side.norm())
        })
    };
    !parted(a, b) && !parted(b, a)
}
