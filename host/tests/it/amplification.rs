//! Tests the bound on errors of the whole sheet per closure residual: it holds, and it is tight enough to be of use.

use crate::common::{miura, noise, waterbomb, yoshimura};
use foldpath::folding::{FoldingMap, Holonomy, Rigidity, amplification, worst_amplification};
use foldpath::pattern::{CreasePattern, Drawing, Letter};
use foldpath::planner::{Goal, Outcome, PlanOptions, plan};
use foldpath::symmetry::{CreaseGroups, ReducedStars, closure_of};
use foldpath_core::{HalfAngle, closure, hole, norm};
use rand_pcg::Pcg64;

fn factors_of(pattern: &CreasePattern) -> Rigidity {
    amplification(pattern, pattern.tree()).unwrap()
}

/// Returns gap, deformation and twist at these angles, each over its bound.
fn fractions(pattern: &CreasePattern, angles: &[f64]) -> [f64; 3] {
    let tree = pattern.tree();
    let factors = amplification(pattern, tree).unwrap();
    let known: Vec<_> = angles.iter().copied().map(Some).collect();
    let residual = closure_of(pattern, &known).unwrap();
    let measured = FoldingMap::new(pattern, tree, angles).rigidity(pattern, tree);
    [
        measured.gap / (factors.gap * residual),
        measured.deformation / (factors.deformation * residual),
        measured.twist / (factors.twist * residual),
    ]
}

/// Angles are perturbed by independent noise, by noise that all creases of one letter and goal share, and by noise that
/// grows along the sheet. Sizes go from that of rounding errors to one at which nothing is small any more.
#[test]
fn no_error_is_larger_than_its_factor_times_the_largest_residual() {
    let mut random = Pcg64::new(5, 7);
    let mut closest = [0.0_f64; 3];
    for (name, drawing) in [
        ("miura 3x3", miura(3, 3, 0.7)),
        ("miura 3x24", miura(3, 24, 0.7)),
        ("miura 11x11", miura(11, 11, 0.7)),
        ("miura 24x24", miura(24, 24, 0.7)),
        ("waterbomb 4x6", waterbomb(4, 6, 0.5)),
        ("waterbomb 12x22", waterbomb(12, 22, 0.5)),
        ("yoshimura 12x12", yoshimura(12, 12, 0.3)),
    ] {
        let pattern = CreasePattern::new(drawing).unwrap();
        let goals = pattern.creases().iter().map(|&id| pattern.edge(id).goal);
        let goals: Vec<f64> = goals.map(Option::unwrap).collect();
        let factors = factors_of(&pattern);
        let mut worst = [[0.0_f64; 3]; 3];
        for size in [1e-8, 1e-6, 1e-4, 1e-2, 0.5] {
            for _ in 0..4 {
                let shared: [f64; 2] = [noise(&mut random), noise(&mut random)];
                let slope = [noise(&mut random), noise(&mut random)];
                let mut perturbed = [goals.clone(), goals.clone(), goals.clone()];
                for (crease, &goal) in goals.iter().enumerate() {
                    let ends = pattern.edge(pattern.creases()[crease]).ends;
                    let place = pattern.vertices()[ends[0].index()];
                    let kind = usize::from(goal.abs() > goals[0].abs() + 1e-6);
                    perturbed[0][crease] += size * noise(&mut random);
                    perturbed[1][crease] += size * shared[kind] * goal.signum();
                    perturbed[2][crease] += size * (slope[0] * place.x + slope[1] * place.y) / 24.0;
                }
                for (kind, angles) in perturbed.iter().enumerate() {
                    let now = fractions(&pattern, angles);
                    for (worst, now) in worst[kind].iter_mut().zip(now) {
                        // Rounding alone breaks no bound, because residuals here are at least 1e-9.
                        assert!(now <= 1.0 + 1e-6, "{name} {size:e}: {now}");
                        *worst = worst.max(now);
                    }
                }
            }
        }
        println!(
            "{name}: gap {:.1}, deformation {:.1}, twist {:.0}; filled: independent {:.3?}, shared \
             {:.3?}, sloping {:.3?}",
            factors.gap, factors.deformation, factors.twist, worst[0], worst[1], worst[2]
        );
        for kind in worst {
            for (closest, now) in closest.iter_mut().zip(kind) {
                *closest = closest.max(now);
            }
        }
    }
    // On some sheet each bound is nearly reached, so no factor can be reduced to 0.3 of its value.
    println!("closest: {closest:.3?}");
    assert!(closest.iter().all(|filled| *filled > 0.3), "{closest:?}");
}

/// One perturbed vertex has a closed form: per residual, the point of the border that hangs on it moves by its distance
/// from the vertex, whatever the sheet.
#[test]
fn a_single_vertex_is_amplified_by_its_distance_from_the_border() {
    let pattern = CreasePattern::new(miura(2, 2, 0.7)).unwrap();
    let factors = factors_of(&pattern);
    assert!((factors.gap - 1.0).abs() < 1e-12, "{factors:?}");
    assert!((factors.deformation - 1.0).abs() < 1e-12, "{factors:?}");
    assert!((factors.twist - 1.0).abs() < 1e-12, "{factors:?}");
}

/// Factors have no unit, so they do not depend on the scale of the sheet.
#[test]
fn factors_are_those_of_the_scaled_sheet() {
    let drawing = waterbomb(8, 10, 0.5);
    let factors = factors_of(&CreasePattern::new(drawing.clone()).unwrap());
    for scale in [1e-3, 1e3] {
        let mut scaled = drawing.clone();
        for vertex in &mut scaled.vertices {
            *vertex *= scale;
        }
        let other = factors_of(&CreasePattern::new(scaled).unwrap());
        let same = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-9;
        assert!(same(factors.gap, other.gap) && same(factors.deformation, other.deformation));
    }
}

/// Returns the sheet without these faces, and cut along the edges of these chains of vertices.
fn cut(sheet: &Drawing, faces: &[usize], ways: &[&[usize]]) -> Drawing {
    let whole = CreasePattern::new(sheet.clone()).unwrap();
    let cycles = whole.faces().iter().enumerate();
    let kept = cycles.filter(|(index, _)| !faces.contains(index));
    let kept = kept.map(|(_, f)| f.iter().map(|v| v.index()).collect());
    let mut drawing = Drawing {
        faces: Some(kept.collect()),
        ..sheet.clone()
    };
    for pair in ways.iter().flat_map(|way| way.windows(2)) {
        let edge = drawing
            .edges
            .iter_mut()
            .find(|edge| edge.ends == [pair[0], pair[1]] || edge.ends == [pair[1], pair[0]]);
        edge.unwrap().letter = Letter::Cut;
    }
    drawing
}

/// The residuals of a hole count like those of a vertex. They turn the part of the sheet that hangs below the hole
/// about a point within reach. The bound from the residual of every single vertex and hole holds too.
#[test]
fn errors_of_sheets_with_holes_are_bounded_too() {
    let mut random = Pcg64::new(11, 3);
    let (small, large, bombs) = (miura(5, 5, 0.7), miura(11, 11, 0.7), waterbomb(8, 10, 0.5));
    let ring = [6, 7, 8, 11, 12, 13, 16, 17, 18];
    let strip: Vec<usize> = (36..43).collect();
    let mut closest = [0.0_f64; 3];
    for (name, drawing, holes) in [
        ("a face missing", cut(&small, &[12], &[]), 1),
        ("a ring", cut(&small, &ring, &[]), 1),
        ("two holes side by side", cut(&large, &[48, 50], &[]), 2),
        ("four holes", cut(&large, &[24, 30, 90, 96], &[]), 4),
        ("a long hole", cut(&large, &strip, &[]), 1),
        ("a cut", cut(&large, &[], &[&[52, 53, 54, 55, 56, 57]]), 1),
        (
            "cuts and holes",
            cut(&large, &[12, 60, 108], &[&[88, 89, 90, 91]]),
            4,
        ),
        ("waterbomb", cut(&bombs, &[30, 31, 50], &[]), 2),
    ] {
        let pattern = CreasePattern::new(drawing).unwrap();
        assert_eq!(pattern.holes().len(), holes, "{name}");
        let groups = CreaseGroups::trivial(&pattern);
        let stars = ReducedStars::all(&pattern, &groups);
        let tree = pattern.tree();
        let holonomy = Holonomy::new(&pattern, tree).unwrap();
        let factors = amplification(&pattern, tree).unwrap();
        let goals = pattern.creases().iter().map(|&id| pattern.edge(id).goal);
        let goals: Vec<f64> = goals.map(|goal| goal.unwrap_or(0.0)).collect();
        let mut filled = [0.0_f64; 3];
        for size in [1e-7, 1e-4, 1e-2, 0.3, 2.0] {
            for _ in 0..20 {
                let slope = [noise(&mut random), noise(&mut random)];
                let local = noise(&mut random);
                let creases = goals.iter().zip(pattern.creases()).map(|(goal, &id)| {
                    let place = pattern.vertices()[pattern.edge(id).ends[0].index()];
                    let sloping = (slope[0] * place.x + slope[1] * place.y) / 10.0;
                    goal + size * (sloping + local * noise(&mut random))
                });
                let creases: Vec<f64> = creases.collect();
                let known: Vec<_> = creases.iter().copied().map(Some).collect();
                let x: Vec<f64> = groups
                    .reduce(&known)
                    .into_iter()
                    .map(Option::unwrap)
                    .collect();
                let mut half_angles = vec![HalfAngle::default(); x.len()];
                closure::half_angles(&x, &mut half_angles);
                let mut vertices = vec![0.0; pattern.vertices().len()];
                for (vertex, star) in stars.vertices().iter().zip(stars.view().iter()) {
                    vertices[vertex.index()] = norm(&closure::residual(star, &half_angles));
                }
                let loops = stars.loops();
                let loops = loops.iter().map(|l| hole::residuals(l, &half_angles));
                let loops: Vec<_> = loops.map(|both| both.map(|part| norm(&part))).collect();
                let map = FoldingMap::new(&pattern, tree, &creases);
                let measured = map.rigidity(&pattern, tree);
                let bound = holonomy.rigidity(&vertices, &loops);
                let residual = vertices.iter().chain(loops.iter().flatten());
                let residual = residual.copied().fold(0.0, f64::max);
                let pairs = [
                    (measured.gap, bound.gap, factors.gap),
                    (measured.deformation, bound.deformation, factors.deformation),
                    (measured.twist, bound.twist, factors.twist),
                ];
                for ((measured, bound, factor), filled) in pairs.into_iter().zip(&mut filled) {
                    assert!(
                        measured <= bound * (1.0 + 1e-5),
                        "{name}: {measured} {bound}"
                    );
                    assert!(bound <= factor * residual * (1.0 + 1e-12), "{name}");
                    *filled = filled.max(measured / bound);
                }
            }
        }
        println!("{name}: {factors:.1?}, filled {filled:.3?}");
        for (closest, filled) in closest.iter_mut().zip(filled) {
            *closest = closest.max(filled);
        }
    }
    assert!(closest.iter().all(|filled| *filled > 0.2), "{closest:?}");
}

/// A ring of faces is one loop. The two faces that the spanning tree does not join are off by the loop's residuals and
/// nothing else.
#[test]
fn a_ring_misses_by_the_residuals_of_its_hole() {
    let pattern = CreasePattern::new(cut(&miura(3, 3, 0.7), &[4], &[])).unwrap();
    let tree = pattern.tree();
    let holonomy = Holonomy::new(&pattern, tree).unwrap();
    let vertices = vec![1.0; pattern.vertices().len()];
    let (_, size) = pattern.hole_frame(0);
    // The first error is a shift alone. The second is a turn about a point whose distance from the rim is at most half
    // the way round plus the size of the hole; the border is one edge farther away.
    let shift = holonomy.rigidity(&vertices, &[[0.0, 0.1]]);
    assert!((shift.gap - 0.1 * size).abs() < 1e-12, "{shift:?}");
    assert!(shift.twist.abs() < 1e-12);
    let turn = holonomy.rigidity(&vertices, &[[0.1, 0.0]]);
    assert!(
        (turn.gap - 0.1 * (2.0 + size + 1.0)).abs() < 1e-12,
        "{turn:?}"
    );
    assert!((turn.twist - 0.1).abs() < 1e-12);
}

/// The essential tolerance is the bound over the amplification, and a plan within this tolerance keeps the bound.
#[test]
fn plan_derives_the_essential_tolerance_from_the_bound() {
    let mut random = Pcg64::new(3, 9);
    let mut drawing = miura(11, 11, 0.7);
    for vertex in &mut drawing.vertices {
        for axis in 0..2 {
            vertex[axis] += 1e-7 * noise(&mut random);
        }
    }
    let pattern = CreasePattern::new(drawing).unwrap();
    let goal = Goal::of_pattern(&pattern).unwrap();
    let tree = pattern.tree();
    let factor = worst_amplification(&pattern, tree).unwrap();
    for bound in [1e-2, 1e-4, 1e-6, 1e-8] {
        let options = PlanOptions::default().with(|it| it.bound = bound);
        let plan = plan(&pattern, &goal, &options);
        assert_eq!(plan.reduced.amplification, Some(factor));
        let ratio = plan.reduced.closure_tolerance * factor / bound;
        assert!((ratio - 1.0).abs() < 1e-12, "{ratio}");
        if plan.outcome == Outcome::Planned {
            assert!(plan.errors.rigidity.gap <= bound && plan.errors.rigidity.deformation <= bound);
            assert!(plan.errors.closure <= bound);
        }
        // The sheet closes to about the noise in its coordinates: within the loose bound, but not within the tight one.
        let planned = plan.outcome == Outcome::Planned;
        if bound >= 1e-3 {
            assert!(planned, "{:?}", plan.reason);
        }
        if bound <= 1e-8 {
            assert!(!planned, "{:?}", plan.errors.rigidity);
        }
    }
}
