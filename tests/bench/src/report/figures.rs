//! The report's figures 3, 4, 6 and 8: data and plots, foldpath beside the report's method.

use core::fmt::Write as _;
use std::io::{self, Write};
use std::path::Path;

use foldpath::folding::{Dihedral, FoldingMap};
use foldpath::planner::plan;
use foldpath_core::Membership;

use super::cases::{self, Case, Extent, Kind, SHORT_LIMIT};
use super::ours::places;
use super::picture::{Curve, Panel, svg};
use super::search::{Accept, search};
use super::sheet::{Freedom, Sheet};
use super::tables::percent;
use super::tune::{Trial, tune};

/// Number of configurations of foldpath's motion in a figure.
const PLACES: usize = 61;
/// Number of configurations between two knots of the report's path.
const BETWEEN: usize = 8;
/// Largest number of creases of a sheet in a figure; more could not be told apart.
const MOST_CREASES: usize = 60;

/// A method's path of a sheet.
struct Traced {
    method: &'static str,
    sheet: Sheet,
    memberships: Vec<Membership>,
    samples: Vec<Sample>,
}

/// A configuration of a path.
struct Sample {
    /// Mean angle over that of the goal.
    progress: f64,
    /// Fold angles of all creases, radians.
    creases: Vec<f64>,
    deformation: f64,
    gap: f64,
    /// Assigned and measured fold angles, radians.
    measured: Vec<[f64; 2]>,
    /// `true` for a knot of the report's path; configurations of foldpath's motion are not marked.
    knot: bool,
}

impl Traced {
    fn new(
        method: &'static str,
        sheet: Sheet,
        memberships: Vec<Membership>,
        places: &[(Vec<f64>, bool)],
    ) -> Self {
        let mut map = FoldingMap::flat(&sheet.pattern);
        let dihedrals = Dihedral::all(&sheet.pattern);
        let goal = sheet.goal.fold_angles.iter().flatten();
        let far: f64 = goal.map(|angle| angle.abs()).sum();
        let samples = places.iter().map(|(angles, knot)| {
            let creases = memberships.iter();
            let creases = creases.map(|of| of.apply(angles[of.group.index()]));
            let creases: Vec<f64> = creases.collect();
            map.fold(&sheet.pattern, sheet.pattern.tree(), &creases);
            let rigidity = map.rigidity(&sheet.pattern, sheet.pattern.tree());
            let assigned = |dihedral: &Dihedral| {
                let crease = sheet.pattern.edge(dihedral.edge?).crease?;
                Some(creases[crease.index()])
            };
            let measured = dihedrals.iter().map(|dihedral| {
                [
                    assigned(dihedral).unwrap_or(0.0),
                    dihedral.fold_angle(map.vertices()),
                ]
            });
            Sample {
                progress: creases.iter().map(|angle| angle.abs()).sum::<f64>() / far,
                deformation: rigidity.deformation,
                gap: rigidity.gap,
                measured: measured.collect(),
                knot: *knot,
                creases,
            }
        });
        Self {
            method,
            samples: samples.collect(),
            memberships,
            sheet,
        }
    }

    /// Returns the path of the report's method with the tuned algorithm, straight between knots, and the trial of that
    /// algorithm.
    fn report(case: &Case, accept: Accept, extent: Extent) -> Option<(Self, Trial)> {
        let sheet = case.sheet();
        let trial = tune(&sheet, accept, true, &case.tuning(extent)).best?;
        let run = search(&sheet, &cases::drawn(case, accept, &trial));
        let run = Some(run).filter(|run| run.reached >= 1.0);
        let knots = &run.as_ref().or_else(|| trial.median())?.knots;
        let mut configurations = Vec::new();
        for pair in knots.windows(2) {
            for place in 0..BETWEEN {
                #[allow(clippy::cast_precision_loss, reason = "small counts")]
                let s = place as f64 / BETWEEN as f64;
                let angles = pair[0].iter().zip(&pair[1]).map(|(a, b)| a + s * (b - a));
                configurations.push((angles.collect(), place == 0));
            }
        }
        configurations.push((knots.last()?.clone(), true));
        let memberships = sheet.groups.memberships().to_vec();
        let traced = Self::new("report", sheet, memberships, &configurations);
        Some((traced, trial))
    }

    /// Returns foldpath's motion.
    fn foldpath(case: &Case) -> Option<Self> {
        let sheet = case.sheet();
        let options = case.freedom.options().with(|it| it.bound = case.bound);
        let plan = plan(&sheet.pattern, &sheet.goal, &options);
        let motion = plan.motion?;
        let configurations = places(&motion, PLACES).into_iter();
        let configurations: Vec<_> = configurations.map(|angles| (angles, false)).collect();
        let drawn = !configurations.is_empty();
        drawn.then(|| Self::new("foldpath", sheet, motion.memberships(), &configurations))
    }

    fn curve(&self, colour: usize, name: String, of: impl Fn(&Sample) -> f64) -> Curve {
        let points = self.samples.iter();
        Curve {
            name: Some(name),
            colour,
            points: points.map(|s| (100.0 * s.progress, of(s))).collect(),
        }
    }

    fn worst(&self) -> f64 {
        let all = self.samples.iter().map(|sample| sample.deformation);
        all.fold(0.0, f64::max)
    }

    /// Writes rows of deformation and gap along the path.
    fn write_errors(&self, name: &str, text: &mut String) {
        for sample in &self.samples {
            let _ = writeln!(
                text,
                "{name},{},{:.4},{},{:.4e},{:.4e}",
                self.method,
                sample.progress,
                u8::from(sample.knot),
                sample.deformation,
                sample.gap
            );
        }
    }
}

const ERRORS_HEAD: &str = "sheet,method,progress,knot,deformation,gap\n";
const PROGRESS: &str = "way to the goal, per cent";

/// Measures the data of the figures and writes the figures.
pub(super) fn print(extent: Extent, out: &mut impl Write, folder: &Path) -> io::Result<()> {
    writeln!(out, "### Figures\n")?;
    figure_3(extent, out, folder)?;
    if extent == Extent::Full {
        figure_4(out, folder)?;
        figure_6(out, folder)?;
    }
    figure_8(extent, out, folder)
}

fn write(
    folder: &Path,
    figure: u8,
    data: &str,
    panels: &[Panel],
    columns: usize,
) -> io::Result<()> {
    std::fs::write(folder.join(format!("report-figure-{figure}.csv")), data)?;
    let picture = svg(panels, columns);
    std::fs::write(folder.join(format!("report-figure-{figure}.svg")), picture)
}

/// Writes the lines of the section that show a figure.
fn show(out: &mut impl Write, figure: u8, text: &str) -> io::Result<()> {
    let file = format!("tests/bench/results/report-figure-{figure}");
    writeln!(
        out,
        "**Figure {figure}** ([data]({file}.csv)): {text}\n\n![Figure {figure} of the report, reproduced]({file}.svg)\n"
    )
}

fn miura(size: usize, freedom: Freedom, bound: f64) -> Case {
    Case {
        kind: Kind::Miura,
        size: [size, size],
        freedom,
        bound,
        limit: SHORT_LIMIT,
    }
}

/// Figure 3: deformation along paths for which the report's method only requires F below 0.1.
fn figure_3(extent: Extent, out: &mut impl Write, folder: &Path) -> io::Result<()> {
    let sizes: &[usize] = match extent {
        Extent::Short => &[3],
        Extent::Full => &[3, 5],
    };
    let (mut data, mut panels) = (String::from(ERRORS_HEAD), Vec::new());
    let mut said = Vec::new();
    for &size in sizes {
        let case = miura(size, Freedom::Full, 0.05);
        eprintln!("figure 3: {}", case.name());
        let mut curves = Vec::new();
        if let Some((theirs, trial)) = Traced::report(&case, Accept::Objective(0.1), extent) {
            theirs.write_errors(&case.name(), &mut data);
            let name = format!("report ({})", trial.algorithm.name());
            curves.push(theirs.curve(0, name, |s| s.deformation));
            said.push(format!("{} up to {}", case.name(), percent(theirs.worst())));
        }
        if let Some(ours) = Traced::foldpath(&case) {
            ours.write_errors(&case.name(), &mut data);
            curves.push(ours.curve(1, "foldpath".into(), |s| s.deformation));
            said.push(format!("foldpath's path of it {}", percent(ours.worst())));
        }
        panels.push(Panel {
            title: format!("{}: largest deformation of an edge", case.name()),
            labels: [PROGRESS, "relative change of length"],
            curves,
            powers: true,
        });
    }
    write(folder, 3, &data, &panels, 2)?;
    let text = format!(
        "edges along paths of the report's method with F(C) < 0.1 in place of a bound on deformation, straight \
         between knots, every crease on its own: {}.",
        said.join(", ")
    );
    show(out, 3, &text)
}

/// Figure 4: assigned and measured fold angles under bounds on deformation.
fn figure_4(out: &mut impl Write, folder: &Path) -> io::Result<()> {
    let mut data = String::from("method,bound,progress,edge,assigned_degrees,measured_degrees\n");
    let mut panels = Vec::new();
    let mut said = Vec::new();
    for bound in [0.1, 0.05, 0.02, 0.01] {
        let case = miura(3, Freedom::Full, bound);
        eprintln!("figure 4: {}", percent(bound));
        let theirs = Traced::report(&case, case.accept(), Extent::Full);
        let ours = Traced::foldpath(&case).filter(|_| bound <= 0.01);
        for traced in theirs.map(|(theirs, _)| theirs).into_iter().chain(ours) {
            let knots = || {
                let foldpath = traced.method == "foldpath";
                traced.samples.iter().filter(move |s| s.knot || foldpath)
            };
            let mut worst = 0.0_f64;
            for sample in knots() {
                for (edge, angles) in sample.measured.iter().enumerate() {
                    let [assigned, measured] = angles.map(f64::to_degrees);
                    worst = worst.max((assigned - measured).abs());
                    let _ = writeln!(
                        data,
                        "{},{bound},{:.4},{edge},{assigned:.4},{measured:.4}",
                        traced.method, sample.progress
                    );
                }
            }
            said.push(if worst > 1e-3 {
                format!("{} {}: {worst:.1}", traced.method, percent(bound))
            } else {
                format!("{} {}: {worst:.0e}", traced.method, percent(bound))
            });
            for (which, name) in ["assigned", "measured"].into_iter().enumerate() {
                let count = knots().next().map_or(0, |sample| sample.measured.len());
                let curves = (0..count).map(|edge| Curve {
                    name: None,
                    // Virtual edges, whose assigned angle is 0, have a colour of their own.
                    colour: usize::from(edge >= count - traced.sheet.pattern.diagonals().len()),
                    points: knots()
                        .map(|s| (100.0 * s.progress, s.measured[edge][which].to_degrees()))
                        .collect(),
                });
                panels.push(Panel {
                    title: format!("{}, bound {}: {name}", traced.method, percent(bound)),
                    labels: [PROGRESS, "fold angle, degrees"],
                    curves: curves.collect(),
                    powers: false,
                });
            }
        }
    }
    write(folder, 4, &data, &panels, 2)?;
    let text = format!(
        "fold angles assigned to the edges of the 3x3 Miura, and measured on the folded sheet, virtual edges \
         (orange) among them. Largest difference in degrees at knots: {}.",
        said.join("; ")
    );
    show(out, 4, &text)
}

/// Figure 6: trajectories of all creases, each an unknown of its own, on a small and on a large sheet.
fn figure_6(out: &mut impl Write, folder: &Path) -> io::Result<()> {
    let mut data = String::from("sheet,method,progress,crease,degrees\n");
    let mut panels = Vec::new();
    let mut said = Vec::new();
    let sizes = [
        ("report", 3),
        ("report", 5),
        ("foldpath", 3),
        ("foldpath", 24),
    ];
    for (method, size) in sizes {
        let case = miura(size, Freedom::Full, 0.01);
        eprintln!("figure 6: {method} {}", case.name());
        let traced = match method {
            "report" => Traced::report(&case, case.accept(), Extent::Full).map(|found| found.0),
            _ => Traced::foldpath(&case),
        };
        let Some(traced) = traced else {
            said.push(format!("{method} has no path of {}", case.name()));
            continue;
        };
        let creases = traced.memberships.len();
        let drawn: Vec<usize> = (0..creases)
            .step_by(creases.div_ceil(MOST_CREASES))
            .collect();
        let mut curves = Vec::new();
        for &crease in &drawn {
            let points = traced
                .samples
                .iter()
                .filter(|s| s.knot || method == "foldpath");
            let points: Vec<_> = points
                .map(|s| (100.0 * s.progress, s.creases[crease].to_degrees()))
                .collect();
            for (progress, degrees) in &points {
                let _ = writeln!(
                    data,
                    "{},{method},{:.4},{crease},{degrees:.4}",
                    case.name(),
                    progress / 100.0
                );
            }
            curves.push(Curve {
                name: None,
                colour: usize::from(method == "foldpath"),
                points,
            });
        }
        let spread = spread(&traced);
        said.push(format!("{method} {}: {}", case.name(), degrees(spread)));
        panels.push(Panel {
            title: format!(
                "{method}: {}, {} of {creases} creases",
                case.name(),
                drawn.len()
            ),
            labels: [PROGRESS, "fold angle, degrees"],
            curves,
            powers: false,
        });
    }
    write(folder, 6, &data, &panels, 2)?;
    let text = format!(
        "fold angles of creases of small and large Miura sheets, planned with every crease on its own, bound 1 %. \
         Farthest apart that two creases of a group are at the same place, in degrees: {}.",
        said.join("; ")
    );
    show(out, 6, &text)
}

fn degrees(angle: f64) -> String {
    if angle > 0.01 {
        format!("{angle:.1}")
    } else {
        format!("{angle:.0e}")
    }
}

/// Returns the largest difference of two creases of a crease group in one configuration, degrees.
fn spread(traced: &Traced) -> f64 {
    let groups = foldpath::symmetry::CreaseGroups::find(&traced.sheet.pattern);
    let mut worst = 0.0_f64;
    for sample in traced
        .samples
        .iter()
        .filter(|s| s.knot || traced.method == "foldpath")
    {
        let mut ends = vec![[f64::INFINITY, f64::NEG_INFINITY]; groups.len()];
        for (of, &angle) in groups.memberships().iter().zip(&sample.creases) {
            let angle = of.apply(angle);
            let [low, high] = &mut ends[of.group.index()];
            (*low, *high) = (low.min(angle), high.max(angle));
        }
        let apart = ends.iter().map(|[low, high]| high - low);
        worst = apart.fold(worst, f64::max);
    }
    worst.to_degrees()
}

/// Figure 8: the path of the essential Quad, reused on a large sheet.
fn figure_8(extent: Extent, out: &mut impl Write, folder: &Path) -> io::Result<()> {
    let quad = |size| Case {
        kind: Kind::Quad,
        size: [size, size],
        freedom: Freedom::Essential,
        bound: 1e-3,
        limit: SHORT_LIMIT,
    };
    let (small, large) = (quad(3), quad(24));
    eprintln!("figure 8");
    let Some((theirs, _)) = Traced::report(&small, small.accept(), extent) else {
        return writeln!(
            out,
            "**Figure 8**: the report's method found no path of the 3x3 Quad.\n"
        );
    };
    let reused = reuse(&small, &theirs, &large);
    let mut data = String::from(ERRORS_HEAD);
    theirs.write_errors(&small.name(), &mut data);
    reused.write_errors(&large.name(), &mut data);
    let mut panels = vec![Panel {
        title: format!("{}: fold angles of the crease groups", small.name()),
        labels: [PROGRESS, "fold angle, degrees"],
        curves: theirs
            .sheet
            .groups
            .memberships()
            .iter()
            .enumerate()
            .map(|(crease, of)| Curve {
                name: None,
                colour: of.group.index(),
                points: theirs
                    .samples
                    .iter()
                    .map(|s| (100.0 * s.progress, s.creases[crease].to_degrees()))
                    .collect(),
            })
            .collect(),
        powers: false,
    }];
    for (case, traced) in [(&small, &theirs), (&large, &reused)] {
        panels.push(Panel {
            title: format!("{}: deformation and gap", case.name()),
            labels: [PROGRESS, "part of length"],
            curves: vec![
                traced.curve(0, "deformation".into(), |s| s.deformation),
                traced.curve(1, "gap".into(), |s| s.gap),
            ],
            powers: false,
        });
    }
    write(folder, 8, &data, &panels, 3)?;
    let sheet = large.sheet();
    let options = large.freedom.options().with(|it| it.bound = large.bound);
    let answer = plan(&sheet.pattern, &sheet.goal, &options);
    let text = format!(
        "the 3x3 Quad deforms by {} on the path that the report's method finds within 0.1 %; the 24x24 Quad that \
         reuses it by {}: not rigidly foldable. foldpath's answer for 24x24 is `{}`: {}.",
        percent(theirs.worst()),
        percent(reused.worst()),
        answer.outcome.name(),
        answer
            .reason
            .map_or_else(String::new, |reason| reason.to_string())
    );
    show(out, 8, &text)
}

/// Reuses a path with crease groups on a larger sheet: each group of the larger sheet takes the angles of the group
/// with the nearest goal.
fn reuse(small: &Case, path: &Traced, large: &Case) -> Traced {
    let (from, to) = (small.sheet(), large.sheet());
    let source = |goal: f64| {
        let off = |group: &usize| (from.goal_angles[*group] - goal).abs();
        (0..from.groups.len()).min_by(|a, b| off(a).total_cmp(&off(b)))
    };
    let sources: Vec<usize> = to.goal_angles.iter().filter_map(|&g| source(g)).collect();
    let first = |group: usize| {
        let mut members = path.memberships.iter();
        members
            .position(|of| of.group.index() == group)
            .unwrap_or(0)
    };
    let configurations = path.samples.iter().map(|sample| {
        let angles = sources.iter().map(|&group| {
            let crease = first(group);
            path.memberships[crease].apply(sample.creases[crease])
        });
        (angles.collect(), sample.knot)
    });
    let configurations: Vec<_> = configurations.collect();
    let memberships = to.groups.memberships().to_vec();
    Traced::new(path.method, to, memberships, &configurations)
}
