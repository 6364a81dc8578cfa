//! Plates: trims and volumes against closed forms, how thick plates may be, and what is refused.

use core::f64::consts::{FRAC_PI_2, PI};
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use foldpath::check::{CheckOptions, Failure, check};
use foldpath::collision::{PlateError, Plates, Trims};
use foldpath::export::fold::motion_text;
use foldpath::export::svg_pattern::Colour;
use foldpath::export::{ExportOptions, Format, Source};
use foldpath::generate::Miura;
use foldpath::lattice::Lattice;
use foldpath::motion::{Motion, PlateOptions, PlateSides};
use foldpath::pattern::{CreasePattern, Drawing, DrawnEdge, Letter};
use foldpath::planner::{Goal, Outcome, PlanOptions, PlateRequest, Reason, plan};
use foldpath::read::fold::parse_motion;
use nalgebra::Vector2;

/// Returns a sheet of unit squares at these places, with hinges between all that have a side in common and the fold angle.
fn squares(places: &[[i32; 2]], hinges: &[[usize; 2]], angle: f64) -> CreasePattern {
    let mut vertices: Vec<[i32; 2]> = Vec::new();
    let mut number = |at: [i32; 2]| {
        vertices
            .iter()
            .position(|known| *known == at)
            .unwrap_or_else(|| {
                vertices.push(at);
                vertices.len() - 1
            })
    };
    let faces: Vec<Vec<usize>> = places
        .iter()
        .map(|&[x, y]| {
            [[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]]
                .map(&mut number)
                .to_vec()
        })
        .collect();
    let side = |a: &[usize], b: &[usize]| {
        let shared: Vec<usize> = a.iter().copied().filter(|v| b.contains(v)).collect();
        [shared[0], shared[1]]
    };
    let folded: Vec<[usize; 2]> = hinges
        .iter()
        .map(|&[a, b]| side(&faces[a], &faces[b]))
        .collect();
    let mut edges: Vec<DrawnEdge> = folded
        .iter()
        .map(|&ends| DrawnEdge {
            ends,
            letter: Letter::Unassigned,
            goal: Some(angle),
        })
        .collect();
    for face in &faces {
        for (&a, &b) in face.iter().zip(face.iter().cycle().skip(1)) {
            if !edges
                .iter()
                .any(|edge| edge.ends == [a, b] || edge.ends == [b, a])
            {
                edges.push(DrawnEdge {
                    ends: [a, b],
                    letter: Letter::Boundary,
                    goal: None,
                });
            }
        }
    }
    let place = |&[x, y]: &[i32; 2]| Vector2::new(f64::from(x), f64::from(y));
    let drawing = Drawing {
        vertices: vertices.iter().map(place).collect(),
        edges,
        faces: Some(faces),
    };
    CreasePattern::new(drawing).unwrap()
}

fn planned(pattern: &CreasePattern, options: &PlanOptions) -> Motion {
    let plan = plan(pattern, &Goal::of_pattern(pattern).unwrap(), options);
    assert_eq!(plan.outcome, Outcome::Planned, "{:?}", plan.reason);
    plan.motion.unwrap()
}

fn with_plates(request: PlateRequest) -> PlanOptions {
    PlanOptions::default().with(|it| it.plates = Some(request))
}

#[test]
fn plates_stay_back_from_a_hinge_by_the_closed_form() {
    for step in 1..=10 {
        for sign in [1.0, -1.0] {
            let angle = sign * f64::from(step) * 16.0_f64.to_radians();
            let pattern = squares(&[[0, 0], [1, 0]], &[[0, 1]], angle);
            let motion = planned(&pattern, &PlanOptions::default());
            for plane in [0.0, 0.5, 1.0] {
                for sides in [PlateSides::Taper, PlateSides::Inset] {
                    let options = PlateOptions::of_thickness(0.02)
                        .with(|it| (it.hinge_plane, it.sides) = (plane, sides));
                    let plates =
                        Plates::new(&pattern, &Trims::of(&motion, &options), &options).unwrap();
                    let heights = [plane * 0.02, (1.0 - plane) * 0.02];
                    let closing = heights[usize::from(angle > 0.0)];
                    for (layer, &height) in plates.heights.iter().enumerate() {
                        let reach = match sides {
                            PlateSides::Taper => (height * sign).max(0.0),
                            _ => closing,
                        };
                        let back = reach * (angle.abs() / 2.0).tan();
                        // The hinge lies at x = 1.
                        for (plate, side) in [(0, -1.0), (1, 1.0)] {
                            let outline = plates.list[plate].outlines[layer].iter().flatten();
                            let away = outline.map(|at| (at.x - 1.0) * side);
                            let found = away.fold(f64::INFINITY, f64::min);
                            assert!(
                                (found - back).abs() < 1e-12,
                                "{angle} {plane} {height}: {found} {back}"
                            );
                        }
                    }
                }
            }
        }
    }
}

/// The net of a cube: each square has four sides at which it meets another one at a right angle, at hinges and at borders that
/// close.
#[test]
fn plates_of_a_cube_have_the_volumes_of_frusta() {
    let places = [[0, 0], [1, 0], [2, 0], [3, 0], [1, 1], [1, -1]];
    let hinges = [[0, 1], [1, 2], [2, 3], [1, 4], [1, 5]];
    let pattern = squares(&places, &hinges, FRAC_PI_2);
    for (plane, inside) in [(0.5, 0.05_f64), (0.0, 0.1), (1.0, 0.0)] {
        let options = PlateOptions::of_thickness(0.1).with(|it| it.hinge_plane = plane);
        let motion = planned(&pattern, &with_plates(PlateRequest::given(options)));
        assert!(check(&motion, &CheckOptions::default()).holds());
        let plates = Plates::new(&pattern, &Trims::of(&motion, &options), &options).unwrap();
        // At height z inside, the square is smaller by z on each side.
        let frustum = (1.0 - (1.0 - 2.0 * inside).powi(3)) / 6.0;
        for plate in 0..6 {
            let volume = plates.mesh(plate).volume();
            assert!(
                (volume - frustum - (0.1 - inside)).abs() < 1e-12,
                "{plane}: {volume}"
            );
        }
    }
}

fn miura(rows: usize, columns: usize) -> CreasePattern {
    let miura = Miura {
        rows,
        columns,
        sector_angle: PI / 3.0,
        fold: 150.0 / 180.0,
    };
    CreasePattern::new(miura.drawing().unwrap()).unwrap()
}

/// A panel of a Miura ends where its taper at one zigzag crosses it: at half the thickness times the tangent of half the
/// largest angle. With upright sides it stays back so far from both zigzags.
#[test]
fn the_largest_thickness_of_a_miura_is_the_closed_form() {
    for (sides, width) in [(PlateSides::Taper, 1.0), (PlateSides::Inset, 0.5)] {
        let options = PlateOptions::of_thickness(0.0).with(|it| it.sides = sides);
        let pattern = miura(5, 5);
        let plan = plan(
            &pattern,
            &Goal::of_pattern(&pattern).unwrap(),
            &with_plates(PlateRequest::thickest(options)),
        );
        let [proved, refuted] = plan.max_thickness.unwrap();
        let closed = 2.0 * width * (PI / 3.0).sin() / (75.0_f64.to_radians()).tan();
        assert!((refuted / closed - 1.0).abs() < 1e-9, "{refuted} {closed}");
        assert!(
            proved < closed && refuted <= 1.01 * proved,
            "{proved} {refuted}"
        );
        assert_eq!(plan.thickness, Some(proved));
        let motion = plan.motion.unwrap();
        assert!(check(&motion, &CheckOptions::default()).holds());
        // A little thicker, the file says what cannot be.
        let mut thicker = motion.clone();
        thicker.plates = motion
            .plates
            .map(|plates| plates.with(|it| it.thickness = 1.05 * refuted));
        let failures = check(&thicker, &CheckOptions::default()).failures;
        assert!(
            matches!(
                failures[..],
                [Failure::PlatesNotMade(PlateError::UsedUp { .. })]
            ),
            "{failures:?}"
        );
    }
}

#[test]
fn plates_that_are_in_the_way_are_named() {
    // The ends of a strip come near each other: as paper they pass, as plates they do not.
    let pattern = squares(
        &[[0, 0], [1, 0], [2, 0], [3, 0]],
        &[[0, 1], [1, 2], [2, 3]],
        85.0_f64.to_radians(),
    );
    let thin = planned(&pattern, &PlanOptions::default());
    let mut thick = thin.clone();
    thick.plates = Some(PlateOptions::of_thickness(0.3).with(|it| it.hinge_plane = 0.0));
    let failures = check(&thick, &CheckOptions::default()).failures;
    assert!(!failures.is_empty());
    let options = with_plates(PlateRequest::given(thick.plates.unwrap()));
    let no = plan(&pattern, &Goal::of_pattern(&pattern).unwrap(), &options);
    assert!(
        matches!(no.outcome, Outcome::Crossing(_)),
        "{:?}",
        no.reason
    );
    assert!(matches!(
        no.reason,
        Some(Reason::PlatesCross { .. } | Reason::PlatesNotMade(_))
    ));
    // Flat-folded plates would need tapers without end.
    let flat = squares(&[[0, 0], [1, 0]], &[[0, 1]], PI);
    let options = with_plates(PlateRequest::given(PlateOptions::of_thickness(0.01)));
    let no = plan(&flat, &Goal::of_pattern(&flat).unwrap(), &options);
    let Some(Reason::PlatesNotMade(error @ PlateError::TurnsTooFar { .. })) = no.reason else {
        panic!("{:?}", no.reason)
    };
    assert!(
        error.to_string().contains("turns to 180.0 degrees"),
        "{error}"
    );
}

#[test]
fn a_path_with_plates_is_read_as_it_was_written() {
    let options = PlateOptions::of_thickness(0.03).with(|it| {
        (it.hinge_plane, it.sides, it.gap, it.margin) =
            (0.25, PlateSides::Inset, 0.01, 2.0_f64.to_radians());
    });
    let motion = planned(&miura(3, 3), &with_plates(PlateRequest::given(options)));
    let text = motion_text(&motion);
    let read = parse_motion(Path::new("path.fold"), text.as_bytes()).unwrap();
    let plates = read.plates.unwrap();
    assert!((plates.margin - options.margin).abs() < 1e-15);
    assert_eq!(plates.with(|it| it.margin = options.margin), options);
    assert!(check(&read, &CheckOptions::default()).holds());
    for (key, bad) in [
        ("thickness", "-1"),
        ("hingePlane", "2"),
        ("panels", "\"round\""),
        ("cutsCorners", "1"),
    ] {
        let line = text
            .lines()
            .find(|line| line.starts_with(&format!("\"foldpath:{key}\"")))
            .unwrap();
        let broken = text.replace(line, &format!("\"foldpath:{key}\":{bad},"));
        let error = parse_motion(Path::new("path.fold"), broken.as_bytes()).unwrap_err();
        assert!(error.to_string().contains(key), "{error}");
    }
    let metres = {
        let mut motion = read.clone();
        Arc::make_mut(&mut motion.pattern);
        motion.measured_in(foldpath::pattern::Unit::Millimetre);
        motion.in_unit(foldpath::pattern::Unit::Metre).unwrap()
    };
    assert!((metres.plates.unwrap().thickness - 3e-5).abs() < 1e-18);
}

/// At the vertices of a waterbomb, panels that share a vertex and no hinge lean into each other: their corners are cut off.
#[test]
fn corners_that_are_in_the_way_are_cut_off() {
    let sheet = foldpath::generate::Waterbomb {
        rows: 4,
        columns: 6,
        fold: 0.4,
    };
    let pattern = CreasePattern::new(sheet.drawing().unwrap()).unwrap();
    let options = PlateOptions::of_thickness(0.05);
    let motion = planned(&pattern, &with_plates(PlateRequest::given(options)));
    let plates = motion.plates.unwrap();
    assert!(plates.cuts_corners && Trims::of(&motion, &plates).corners_cut() > 0);
    assert!(check(&motion, &CheckOptions::default()).holds());
    let mut whole = motion.clone();
    whole.plates = Some(plates.with(|it| it.cuts_corners = false));
    let failures = check(&whole, &CheckOptions::default()).failures;
    assert!(
        matches!(failures[..], [Failure::PlatesCross { .. }]),
        "{failures:?}"
    );
}

/// Neighbours touch at each hinge, so that a lattice tells of plates only what it tells of a sheet that is not torn: their motion
/// closes as nearly as that takes.
#[test]
fn plates_keep_to_their_lattice() {
    let sheet = foldpath::generate::Waterbomb {
        rows: 8,
        columns: 10,
        fold: 0.4,
    };
    let pattern = CreasePattern::new(sheet.drawing().unwrap()).unwrap();
    let goal = Goal::of_pattern(&pattern).unwrap();
    let thin = plan(&pattern, &goal, &PlanOptions::default());
    let options = with_plates(PlateRequest::given(PlateOptions::of_thickness(0.05)));
    let thick = plan(&pattern, &goal, &options);
    let off = [&thin, &thick].map(|plan| {
        let motion = plan.motion.as_ref().unwrap();
        let lattice = Lattice::find(&pattern, &motion.memberships()).unwrap();
        lattice.lattice_deviation(&pattern, plan.certified_closure().unwrap())
    });
    assert_eq!(thick.outcome, Outcome::Planned);
    assert!(off[0] > 1e-5 && off[1] <= 1e-6, "{off:?}");
}

/// Returns the files that an export of a path makes: names and texts.
fn exported(motion: &Motion, name: &str, options: &ExportOptions) -> Vec<(String, String)> {
    let mut files = Vec::new();
    let format = Format::named(name).unwrap();
    let sink = &mut |name: &str, content| {
        files.push((name.to_string(), String::from_utf8(content).unwrap()));
        Ok(())
    };
    let made = format.make(Source::Motion(motion), Path::new("p"), options, sink);
    made.unwrap();
    files
}

/// Every panel is in the list once.
#[test]
fn plates_of_a_sheet_are_sorted_by_form() {
    let mut motion = planned(&miura(5, 5), &PlanOptions::default());
    motion.plates = Some(PlateOptions::of_thickness(0.05));
    let files = exported(&motion, "stl", &ExportOptions::default());
    let (name, list) = files.last().unwrap();
    assert_eq!(name, "panels.csv");
    let forms = list
        .lines()
        .skip(1)
        .map(|line| line.rsplit(',').next().unwrap());
    let panels = forms.clone().flat_map(|panels| panels.split(' '));
    let mut panels: Vec<usize> = panels.map(|panel| panel.parse().unwrap()).collect();
    panels.sort_unstable();
    assert_eq!(panels, (0..25).collect::<Vec<_>>());
    // Half a turn takes plates inside the sheet to others; borders are not trimmed.
    let forms = forms.count();
    assert!((4..20).contains(&forms), "{forms}");
    assert_eq!(files.len(), forms + 1);
}

/// Every export of plates is a whole file, and each mesh is closed: each side of a triangle belongs to one other triangle.
#[test]
fn plates_are_exported_as_closed_meshes_and_outlines() {
    let plates = PlateOptions::of_thickness(0.05).with(|it| it.sides = PlateSides::Inset);
    let motion = planned(&miura(4, 3), &with_plates(PlateRequest::given(plates)));
    let options = ExportOptions::default();
    let stl = exported(&motion, "stl", &options);
    let (list, solids) = stl.split_last().unwrap();
    assert_eq!(list.0, "panels.csv");
    let counts = list
        .1
        .lines()
        .skip(1)
        .map(|line| line.split(',').nth(1).unwrap());
    assert_eq!(
        counts
            .map(|count| count.parse::<usize>().unwrap())
            .sum::<usize>(),
        12
    );
    let one_file = (options.clone()).with(|it| it.assembled = true);
    let assembled = exported(&motion, "stl", &one_file);
    assert_eq!(assembled[0].1.matches("endsolid").count(), 12);
    for (name, text) in solids {
        let corners: Vec<&str> = text
            .lines()
            .filter_map(|line| line.strip_prefix("vertex "))
            .collect();
        let mut sides: HashMap<[&str; 2], i32> = HashMap::new();
        for triangle in corners.chunks(3) {
            for k in 0..3 {
                let [a, b] = [triangle[k], triangle[(k + 1) % 3]];
                *sides.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
            }
        }
        assert!(
            sides.len() >= 18 && sides.values().all(|count| *count == 0),
            "{name}"
        );
    }
    let wide = (options.clone()).with(|it| (it.kerf, it.colour) = (0.02, Colour::Plates));
    for (name, options) in [
        ("svg", &wide),
        (
            "dxf",
            &(wide.clone()).with(|it| it.colour = Colour::Letters),
        ),
    ] {
        let [(_, text)] = &exported(&motion, name, options)[..] else {
            panic!("{name}")
        };
        for layer in ["CUT", "MOUNTAIN", "VALLEY", "HOLE", "TEXT"] {
            assert!(text.contains(layer), "{name}: {layer}");
        }
    }
    // Without plates there is nothing to cut.
    let thin = Motion {
        plates: None,
        ..motion.clone()
    };
    let none = Format::named("stl").unwrap().make(
        Source::Motion(&thin),
        Path::new("p"),
        &options,
        &mut |_, _| Ok(()),
    );
    assert!(none.unwrap_err().to_string().contains("foldpath:thickness"));
}
