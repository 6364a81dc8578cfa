//! The bound on errors of the whole sheet per closure residual holds, and is of use.

use foldpath::folding::{Amplification, FoldingMap, SpanningTree};
use foldpath::generate::{Miura, Waterbomb, Yoshimura};
use foldpath::pattern::{CreasePattern, Drawing};
use foldpath::planner::{Goal, Outcome, PlanOptions, closure_of, plan};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::Rng;

fn miura(rows: usize, columns: usize) -> Drawing {
    let sector_angle = 60_f64.to_radians();
    let sheet = Miura {
        rows,
        columns,
        sector_angle,
        fold: 0.7,
    };
    sheet.drawing().unwrap()
}

fn waterbomb(rows: usize, columns: usize) -> Drawing {
    let sheet = Waterbomb {
        rows,
        columns,
        fold: 0.5,
    };
    sheet.drawing().unwrap()
}

fn yoshimura(rows: usize, columns: usize) -> Drawing {
    let sheet = Yoshimura {
        rows,
        columns,
        angle: 0.9,
        fold: 0.3,
    };
    sheet.drawing().unwrap()
}

/// Uniform in -1..1.
fn noise(random: &mut Pcg64) -> f64 {
    (random.next_u64() >> 11) as f64 / 2_f64.powi(52) - 1.0
}

fn amplification(pattern: &CreasePattern) -> Amplification {
    Amplification::new(pattern, &SpanningTree::from_central_face(pattern)).unwrap()
}

/// Gap, deformation and twist at these angles, each over its bound.
fn fractions(pattern: &CreasePattern, angles: &[f64]) -> [f64; 3] {
    let tree = SpanningTree::from_central_face(pattern);
    let factors = Amplification::new(pattern, &tree).unwrap();
    let known: Vec<_> = angles.iter().copied().map(Some).collect();
    let residual = closure_of(pattern, &known).unwrap();
    let measured = FoldingMap::new(pattern, &tree, angles).rigidity(pattern, &tree);
    [
        measured.gap / (factors.gap * residual),
        measured.deformation / (factors.deformation * residual),
        measured.twist / (factors.twist * residual),
    ]
}

/// Perturbed by independent noise, by noise that all creases of one letter and goal share, and by
/// noise that grows along the sheet; from rounding's size to where nothing is small any more.
#[test]
fn no_error_is_larger_than_its_factor_times_the_largest_residual() {
    let mut random = Pcg64::new(5, 7);
    let mut closest = [0.0_f64; 3];
    for (name, drawing) in [
        ("miura 3x3", miura(3, 3)),
        ("miura 3x24", miura(3, 24)),
        ("miura 11x11", miura(11, 11)),
        ("miura 24x24", miura(24, 24)),
        ("waterbomb 4x6", waterbomb(4, 6)),
        ("waterbomb 12x22", waterbomb(12, 22)),
        ("yoshimura 12x12", yoshimura(12, 12)),
    ] {
        let pattern = CreasePattern::new(drawing).unwrap();
        let goals = pattern.creases().iter().map(|&id| pattern.edge(id).goal);
        let goals: Vec<f64> = goals.map(Option::unwrap).collect();
        let factors = amplification(&pattern);
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
                        // Rounding alone breaks no bound: residuals here are at least 1e-9.
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
    // On some sheet each is nearly reached: no factor can be made smaller by as much as this.
    println!("closest: {closest:.3?}");
    assert!(closest.iter().all(|filled| *filled > 0.3), "{closest:?}");
}

/// One perturbed vertex is a closed form: the point of the border it hangs on moves by its own
/// distance, whatever the sheet.
#[test]
fn a_single_vertex_is_amplified_by_its_distance_from_the_border() {
    let pattern = CreasePattern::new(miura(2, 2)).unwrap();
    let factors = amplification(&pattern);
    assert!((factors.gap - 1.0).abs() < 1e-12, "{factors:?}");
    assert!((factors.deformation - 1.0).abs() < 1e-12, "{factors:?}");
    assert!((factors.twist - 1.0).abs() < 1e-12, "{factors:?}");
}

/// Factors have no unit.
#[test]
fn factors_are_those_of_the_scaled_sheet() {
    let drawing = waterbomb(8, 10);
    let factors = amplification(&CreasePattern::new(drawing.clone()).unwrap());
    for scale in [1e-3, 1e3] {
        let mut scaled = drawing.clone();
        for vertex in &mut scaled.vertices {
            *vertex *= scale;
        }
        let other = amplification(&CreasePattern::new(scaled).unwrap());
        let same = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-9;
        assert!(same(factors.gap, other.gap) && same(factors.deformation, other.deformation));
    }
}

/// A hole has conditions of its own, which no residual of a vertex bounds.
#[test]
fn a_sheet_with_a_hole_has_no_factor() {
    let whole = CreasePattern::new(miura(5, 5)).unwrap();
    let faces = whole.faces().iter().map(|f| f.iter().map(|v| v.index()));
    let mut faces: Vec<Vec<usize>> = faces.map(Iterator::collect).collect();
    faces.remove(12);
    let drawing = Drawing {
        faces: Some(faces),
        ..miura(5, 5)
    };
    let pattern = CreasePattern::new(drawing).unwrap();
    let tree = SpanningTree::from_central_face(&pattern);
    assert_eq!(Amplification::new(&pattern, &tree), None);
}

/// The essential tolerance is the bound over the amplification, and what is planned within it keeps
/// the bound.
#[test]
fn plan_derives_the_essential_tolerance_from_the_bound() {
    let mut random = Pcg64::new(3, 9);
    let mut drawing = miura(11, 11);
    for vertex in &mut drawing.vertices {
        for axis in 0..2 {
            vertex[axis] += 1e-7 * noise(&mut random);
        }
    }
    let pattern = CreasePattern::new(drawing).unwrap();
    let goal = Goal::of_pattern(&pattern).unwrap();
    let factor = amplification(&pattern).worst();
    for bound in [1e-2, 1e-4, 1e-6, 1e-8] {
        let options = PlanOptions {
            bound,
            ..PlanOptions::default()
        };
        let plan = plan(&pattern, &goal, &options);
        assert_eq!(plan.amplification, Some(factor));
        let ratio = plan.essential_tolerance * factor / bound;
        assert!((ratio - 1.0).abs() < 1e-12, "{ratio}");
        if plan.outcome == Outcome::Planned {
            assert!(plan.rigidity.gap <= bound && plan.rigidity.deformation <= bound);
            assert!(plan.max_closure <= bound);
        }
        // The sheet closes to about the noise in it: under the loose bound, not under the tight one.
        let planned = plan.outcome == Outcome::Planned;
        if bound >= 1e-3 {
            assert!(planned, "{:?}", plan.reason);
        }
        if bound <= 1e-8 {
            assert!(!planned, "{:?}", plan.rigidity);
        }
    }
}
