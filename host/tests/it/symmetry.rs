//! Tests crease groups without a goal on sheets as they come: with letters only, with rough coordinates, cut out,
//! moved, mirrored, scaled or renumbered. Sheets that are not symmetric are tested too.

use std::collections::HashMap;

use crate::common::{miura, noise, waterbomb, yoshimura};
use foldpath::pattern::{CreasePattern, Drawing, Letter};
use foldpath::planner::{Goal, Outcome, PlanOptions, plan};
use foldpath::progress::{Progress, Watch};
use foldpath::read::read_pattern;
use foldpath::symmetry::{CreaseGroups, ReducedStars, closure_of};
use nalgebra::{Rotation2, Vector2};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::Rng;

/// Returns sheets with their numbers of groups, which are those of the closed forms.
fn sheets() -> [(&'static str, Drawing, usize); 4] {
    [
        ("miura 11x11", miura(11, 11, 0.7), 2),
        ("miura 24x24", miura(24, 24, 0.7), 2),
        ("waterbomb 12x22", waterbomb(12, 22, 0.5), 4),
        ("yoshimura 12x12", yoshimura(12, 12, 0.3), 2),
    ]
}

fn without_goal(mut drawing: Drawing) -> Drawing {
    for edge in &mut drawing.edges {
        edge.goal = None;
    }
    drawing
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "the remainder is below a size"
)]
fn below(random: &mut Pcg64, end: usize) -> usize {
    (random.next_u64() % end as u64) as usize
}

/// Returns for each edge its group, named by the first edge of the group, and `true` if the edge turns against that
/// first edge.
fn partition(pattern: &CreasePattern, groups: &CreaseGroups) -> Vec<Option<(usize, bool)>> {
    let mut first = HashMap::new();
    let edges = pattern.edges().iter().enumerate();
    edges
        .map(|(index, edge)| {
            let membership = groups.of(edge.crease?);
            let (name, negative) = *first
                .entry(membership.group)
                .or_insert((index, membership.negative));
            Some((name, membership.negative ^ negative))
        })
        .collect()
}

/// Asserts that mountains of a group turn against its valleys.
fn check_letters(pattern: &CreasePattern, groups: &CreaseGroups, what: &str) {
    let mut sign_of = HashMap::new();
    for &id in pattern.creases() {
        let edge = pattern.edge(id);
        let membership = groups.of(edge.crease.unwrap());
        let valley = (edge.letter == Letter::Valley) ^ membership.negative;
        let known = sign_of.entry(membership.group).or_insert(valley);
        assert_eq!(*known, valley, "{what}");
    }
}

#[track_caller]
fn check_same(drawing: Drawing, expected: &[Option<(usize, bool)>], count: usize, what: &str) {
    let pattern = CreasePattern::new(drawing).unwrap();
    let groups = CreaseGroups::find(&pattern);
    assert_eq!(groups.len(), count, "{what}");
    check_letters(&pattern, &groups, what);
    assert!(partition(&pattern, &groups) == expected, "{what}");
}

#[test]
fn letters_alone_give_the_groups_of_the_goal() {
    for (name, drawing, count) in sheets() {
        let with_goal = CreasePattern::new(drawing.clone()).unwrap();
        let expected = partition(&with_goal, &CreaseGroups::find(&with_goal));
        check_same(without_goal(drawing), &expected, count, name);
    }
}

#[test]
fn what_all_stars_close_by_is_told_by_those_that_differ() {
    let mut random = Pcg64::new(3, 5);
    for (name, drawing, count) in sheets() {
        let pattern = CreasePattern::new(drawing).unwrap();
        let all = ReducedStars::all(&pattern, &CreaseGroups::find(&pattern));
        let distinct = all.distinct();
        let [few, many] = [&distinct, &all].map(|stars| stars.vertices().len());
        assert!(4 * few < many, "{name}: {few} of {many}");
        for _ in 0..20 {
            let x: Vec<f64> = (0..count).map(|_| 3.0 * noise(&mut random)).collect();
            let worst = all.residuals(&x).into_iter().fold(0.0, f64::max);
            assert!(worst > 1e-3);
            assert_eq!(
                distinct.largest_residual(&x).to_bits(),
                worst.to_bits(),
                "{name}"
            );
        }
    }
}

#[test]
fn rough_coordinates_have_the_groups_of_exact_ones() {
    let mut random = Pcg64::new(11, 3);
    for (name, drawing, count) in sheets() {
        let drawing = without_goal(drawing);
        let clean = CreasePattern::new(drawing.clone()).unwrap();
        let expected = partition(&clean, &CreaseGroups::find(&clean));
        for decimals in 4..=9 {
            let unit = 10_f64.powi(-decimals);
            let mut rounded = drawing.clone();
            for vertex in &mut rounded.vertices {
                let turned = Rotation2::new(0.3) * *vertex;
                *vertex = turned.map(|c| (c / unit).round() * unit);
            }
            let what = format!("{name}, {decimals} decimals");
            check_same(rounded, &expected, count, &what);
        }
        for size in [1e-9, 1e-8, 1e-7, 3e-7, 1e-6, 3e-6, 1e-5, 3e-5, 1e-4] {
            let mut rough = drawing.clone();
            for vertex in &mut rough.vertices {
                *vertex += Vector2::new(noise(&mut random), noise(&mut random)) * size;
            }
            check_same(rough, &expected, count, &format!("{name}, noise {size:e}"));
        }
    }
}

#[test]
fn a_moved_and_renumbered_sheet_has_the_same_groups() {
    let mut random = Pcg64::new(2, 5);
    for (name, drawing, count) in sheets() {
        let drawing = without_goal(drawing);
        let clean = CreasePattern::new(drawing.clone()).unwrap();
        let expected = partition(&clean, &CreaseGroups::find(&clean));
        for (turn, scale, shift, mirrored) in [
            (1.234, 1.0, 0.0, false),
            (-0.7, 1e-3, 0.0, true),
            (2.9, 1e3, 0.0, false),
            (0.1, 1.0, 1e4, true),
        ] {
            let mut moved = drawing.clone();
            for vertex in &mut moved.vertices {
                if mirrored {
                    vertex.x = -vertex.x;
                }
                *vertex = Rotation2::new(turn) * *vertex * scale + Vector2::new(shift, -shift);
            }
            check_same(moved, &expected, count, &format!("{name} {turn}"));
        }

        // The sheet is renumbered: vertex v becomes to[v], edge e comes from[e].
        let mut shuffled = |count: usize| {
            let mut order: Vec<usize> = (0..count).collect();
            for last in (1..count).rev() {
                order.swap(last, below(&mut random, last + 1));
            }
            order
        };
        let to = shuffled(drawing.vertices.len());
        let from = shuffled(drawing.edges.len());
        let mut renumbered = drawing.clone();
        for (old, &new) in to.iter().enumerate() {
            renumbered.vertices[new] = drawing.vertices[old];
        }
        renumbered.edges = from.iter().map(|&e| drawing.edges[e]).collect();
        for edge in &mut renumbered.edges {
            edge.ends = edge.ends.map(|end| to[end]);
        }
        let pattern = CreasePattern::new(renumbered).unwrap();
        let groups = CreaseGroups::find(&pattern);
        assert_eq!(groups.len(), count, "{name}");
        check_letters(&pattern, &groups, name);
        let found = partition(&pattern, &groups);
        // Edges that were in one group are in one group again, whatever its name.
        let mut names = HashMap::new();
        for (new, &old) in from.iter().enumerate() {
            let (a, b) = (expected[old].map(|x| x.0), found[new].map(|x| x.0));
            assert_eq!(*names.entry(a).or_insert(b), b, "{name}");
        }
    }
}

/// Returns the part of the sheet that consists of these faces.
fn cut_out(whole: &CreasePattern, faces: &[usize]) -> CreasePattern {
    let mut vertices = HashMap::new();
    let mut drawing = Drawing::default();
    let mut kept = Vec::new();
    for &face in faces {
        let cycle = whole.faces()[face].iter().map(|v| {
            *vertices.entry(v.index()).or_insert_with(|| {
                drawing.vertices.push(whole.vertices()[v.index()]);
                drawing.vertices.len() - 1
            })
        });
        kept.push(cycle.collect::<Vec<usize>>());
    }
    for edge in whole.edges() {
        let sides = edge.faces.iter().flatten();
        let sides = sides.filter(|f| faces.contains(&f.index())).count();
        if sides > 0 {
            drawing.edges.push(foldpath::pattern::DrawnEdge {
                ends: edge.ends.map(|end| vertices[&end.index()]),
                letter: if sides == 2 {
                    edge.letter
                } else {
                    Letter::Boundary
                },
                goal: None,
            });
        }
    }
    drawing.faces = Some(kept);
    CreasePattern::new(drawing).unwrap()
}

/// Rectangles are cut out without regard to unit cells. The smallest size is that at which a sheet has each kind of
/// star with its neighbours.
#[test]
fn cut_outs_have_the_groups_of_the_sheet() {
    let mut random = Pcg64::new(8, 1);
    let [miura, _, waterbomb, _] = sheets();
    for (name, drawing, count, [least_x, least_y]) in [
        (miura.0, miura.1, miura.2, [3, 3]),
        (waterbomb.0, waterbomb.1, waterbomb.2, [5, 6]),
    ] {
        let whole = CreasePattern::new(drawing).unwrap();
        // Rows are cut along y. Along x the cut follows the zigzag of columns, so that every cell is whole.
        let cell = |face: usize| {
            let corners = &whole.faces()[face];
            let n = corners.len() as f64;
            let sum: Vector2<f64> = corners.iter().map(|v| whole.vertices()[v.index()]).sum();
            let center = sum / n;
            let height = if count == 2 { 0.75_f64.sqrt() } else { 1.0 };
            let row = (center.y / height).floor();
            let lean = if count == 2 { 0.25 } else { 0.0 };
            #[allow(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "cells are counted from 0"
            )]
            let cell = [(center.x - lean).floor() as usize, row as usize];
            cell
        };
        let size = [0, 1].map(|k| 1 + (0..whole.faces().len()).map(|f| cell(f)[k]).max().unwrap());
        for _ in 0..40 {
            let mut range = |size: usize, least: usize| {
                let length = least + below(&mut random, size - least + 1);
                let start = below(&mut random, size - length + 1);
                start..start + length
            };
            let (x, y) = (range(size[0], least_x), range(size[1], least_y));
            let faces = (0..whole.faces().len())
                .filter(|&f| x.contains(&cell(f)[0]) && y.contains(&cell(f)[1]));
            let part = cut_out(&whole, &faces.collect::<Vec<_>>());
            let groups = CreaseGroups::find(&part);
            let what = format!("{name} {x:?} {y:?}");
            assert_eq!(groups.len(), count, "{what}");
            check_letters(&part, &groups, &what);
        }
    }
}

/// One vertex is moved by a visible distance, or one letter is flipped. Then there are more groups, and a plan closes
/// or says why there is none, but a planned motion never fails to close.
#[test]
fn a_defect_gives_no_wrong_groups() {
    let clean = CreasePattern::new(miura(7, 7, 0.7)).unwrap();
    let vertex = clean.real_vertices().nth(14).unwrap();
    let mut moved = miura(7, 7, 0.7);
    moved.vertices[vertex.index()].x += 0.05;
    let mut flipped = without_goal(miura(7, 7, 0.7));
    let edge = clean.creases()[31].index();
    flipped.edges[edge].letter = flipped.edges[edge].letter.flipped();
    for (what, drawing) in [
        ("moved", moved.clone()),
        ("moved, letters", without_goal(moved)),
        ("flipped", flipped),
    ] {
        let pattern = CreasePattern::new(drawing).unwrap();
        let groups = CreaseGroups::find(&pattern);
        assert!(groups.len() > 2, "{what}: {}", groups.len());
        check_letters(&pattern, &groups, what);
        let goal = Goal::of_pattern(&pattern).unwrap();
        let answer = plan(&pattern, &goal, &PlanOptions::default());
        if answer.outcome == Outcome::Planned {
            assert!(
                answer.errors.closure <= answer.reduced.closure_tolerance,
                "{what}"
            );
        } else {
            assert!(answer.reason.is_some(), "{what}");
        }
    }
}

/// Columns whose sector angles change little by little are no rough Miura fold, and goal angles that drift along the
/// sheet are no group.
#[test]
fn what_drifts_is_not_one_group() {
    for step in [3e-5, 2e-4, 1e-3, 3e-3] {
        // Straight lines stay straight. Each zigzag line leans a little more than the line before.
        let mut drifting = without_goal(miura(12, 24, 0.7));
        for vertex in &mut drifting.vertices {
            let row = (vertex.y / 0.75_f64.sqrt()).round();
            let odd = row.rem_euclid(2.0) > 0.5;
            let column = (vertex.x - if odd { 0.5 } else { 0.0 }).round();
            vertex.x += if odd { step * column } else { 0.0 };
        }
        let pattern = CreasePattern::new(drifting).unwrap();
        let groups = CreaseGroups::find(&pattern);
        println!(
            "step {step:e}: {} groups to {:e}",
            groups.len(),
            groups.tolerance()
        );
        // Directions in the first and last column differ by 23 steps times the sine of 60 degrees. All sheets but the
        // first vary by more than the 2e-3 that rough stars may.
        if 23.0 * step * 0.75_f64.sqrt() > 2e-3 {
            assert!(groups.len() > 2, "{step:e}: {}", groups.len());
        }
    }
    let mut drawing = miura(11, 11, 0.7);
    for edge in &mut drawing.edges {
        let x = drawing.vertices[edge.ends[0]].x;
        // Neighbours differ by less than one group allows, the ends of the sheet by much more.
        edge.goal = edge.goal.map(|goal| goal * (1.0 - 2e-3 * x));
    }
    let pattern = CreasePattern::new(drawing).unwrap();
    let groups = CreaseGroups::find(&pattern);
    let goals = pattern.creases().iter().map(|&id| pattern.edge(id).goal);
    let goals: Vec<_> = goals.collect();
    let means = groups.reduce(&goals);
    for (crease, goal) in goals.iter().enumerate() {
        let membership = groups.memberships()[crease];
        let mean = membership.apply(means[membership.group.index()].unwrap());
        assert!((mean - goal.unwrap()).abs() <= 1e-2, "{crease}");
    }
}

/// Patterns by other authors, if they are at hand.
#[test]
fn real_files_have_few_groups_and_close() {
    let Some(folder) = std::env::var_os("FOLDPATH_EXTERNAL_PATTERNS") else {
        println!("skipped: FOLDPATH_EXTERNAL_PATTERNS is not set");
        return;
    };
    for name in [
        "report-authors/miura_8_8.fold",
        "report-authors/wb_12_6.fold",
        "report-authors/yoshimura_12_12.fold",
        "flat-folder/074_miuraoripa_Miura-ori.fold",
    ] {
        let file = std::path::Path::new(&folder).join(name);
        let pattern = read_pattern(&file).unwrap().pattern;
        let groups = CreaseGroups::find(&pattern);
        let all: Vec<_> = (0..pattern.faces().len()).collect();
        let letters = CreaseGroups::find(&cut_out(&pattern, &all));
        println!(
            "{name}, letters only: {} groups to {:.0e}",
            letters.len(),
            letters.tolerance()
        );
        let goal = Goal::of_pattern(&pattern).unwrap();
        let answer = plan(&pattern, &goal, &PlanOptions::default());
        println!(
            "{name}: {} creases, {} groups to {:.0e}; {:?} with {} groups, deformation {:.1e}, gap \
             {:.1e}, closure {:.1e} {:?}",
            pattern.creases().len(),
            groups.len(),
            groups.tolerance(),
            answer.outcome,
            answer.reduced.groups,
            answer.errors.rigidity.deformation,
            answer.errors.rigidity.gap,
            answer.errors.closure,
            answer.notes
        );
        let last = answer.knots().last().expect("a path");
        let angles = last.angles.clone();
        let creases = answer.motion.as_ref().unwrap().memberships();
        let creases = creases
            .iter()
            .map(|m| Some(m.apply(angles[m.group.index()])));
        let closure = closure_of(&pattern, &creases.collect::<Vec<_>>()).unwrap();
        assert!(
            closure <= answer.reduced.closure_tolerance,
            "{name}: {closure:e}"
        );
    }
}

#[test]
fn a_search_that_is_over_keeps_the_groups_found_until_then() {
    let pattern = CreasePattern::new(miura(11, 11, 0.7)).unwrap();
    assert_eq!(CreaseGroups::find(&pattern).len(), 2);
    let progress = Progress::new();
    progress.cancel();
    let groups = CreaseGroups::find_until(&pattern, Watch::new(&progress));
    assert!(groups.is_trivial());
}
