//! Sheets of plates: no motion holds on which plates pass through each other, and few are refused on which they do not.
//!
//! The oracle calls nothing of the library. It folds panels along a tree by rotations about their hinges, takes a plate as the
//! intersection of half-spaces, and finds the points that two plates share, at many times of a motion.

use core::f64::consts::PI;

use foldpath::check::{CheckOptions, Failure, Outcome, check};
use foldpath::motion::PlateOptions;
use foldpath::pattern::CreasePattern;
use foldpath::planner::{Goal, Note, PlanOptions, PlateRequest, plan};
use foldpath_tests::meshes::Carton;
use foldpath_tests::{Random, path_file};
use nalgebra::{Isometry3, Matrix3, Point3, Translation3, Unit, UnitQuaternion, Vector2, Vector3};
use serde_json::json;

/// Number of times at which the oracle looks.
const TIMES: usize = 64;
/// Depth of an overlap that counts, and of one that is none.
const DEEP: f64 = 2e-5;
const TOUCHING: f64 = 1e-7;
/// Rounding of a place that is on several planes.
const ROUNDING: f64 = 1e-10;

/// A hinge between two panels: ends, and panel before and behind it, which lies to the left.
#[derive(Clone, Copy, Debug)]
struct Hinge {
    ends: [usize; 2],
    panels: [usize; 2],
    /// Angles at the three knots, radians.
    angles: [f64; 3],
}

/// A tree of convex panels.
#[derive(Debug)]
struct Sheet {
    vertices: Vec<Vector2<f64>>,
    panels: Vec<Vec<usize>>,
    /// The panel before a hinge is placed earlier.
    hinges: Vec<Hinge>,
    thickness: f64,
    hinge_plane: f64,
    is_inset: bool,
    gap: f64,
    margin: f64,
    /// `true` if the file has panels with four corners as two faces, joined by an edge that stays flat.
    is_split: bool,
}

fn angles(random: &mut Random, most: f64) -> [f64; 3] {
    let sign = random.sign();
    let degrees = |random: &mut Random| sign * random.uniform(10.0, most);
    let [middle, end] = [degrees(random), degrees(random)].map(f64::to_radians);
    [
        0.0,
        if random.chance(0.7) {
            end / 2.0
        } else {
            middle
        },
        end,
    ]
}

impl Sheet {
    fn new(
        random: &mut Random,
        vertices: Vec<Vector2<f64>>,
        panels: Vec<Vec<usize>>,
        hinges: Vec<Hinge>,
    ) -> Self {
        let is_inset = random.chance(0.4);
        Self {
            vertices,
            panels,
            hinges,
            thickness: random.log_uniform(0.004, 0.12),
            hinge_plane: [0.0, 0.5, 1.0, random.uniform(0.0, 1.0)][random.below(4)],
            is_inset,
            gap: if is_inset && random.chance(0.5) {
                random.uniform(0.0, 0.05)
            } else {
                0.0
            },
            is_split: random.chance(0.3),
            margin: if random.chance(0.3) {
                random.uniform(0.0, 0.1)
            } else {
                0.0
            },
        }
    }

    /// A strip of panels between slanted hinges.
    fn chain(random: &mut Random) -> Self {
        let count = random.whole(3, 6);
        let slants: Vec<f64> = (0..=count).map(|_| random.uniform(-0.25, 0.25)).collect();
        let most = [90.0, 140.0, 165.0][random.below(3)];
        Self::strip(random, &slants, |random, _| angles(random, most))
    }

    /// A strip that is folded up to and fro.
    fn stack(random: &mut Random) -> Self {
        let count = random.whole(3, 7);
        let fold = random.uniform(100.0, 168.0).to_radians();
        Self::strip(random, &vec![0.0; count + 1], |random, k| {
            let end = fold * random.uniform(0.95, 1.0) * if k % 2 == 0 { 1.0 } else { -1.0 };
            [0.0, end * random.uniform(0.3, 0.7), end]
        })
    }

    fn strip(
        random: &mut Random,
        slants: &[f64],
        mut fold: impl FnMut(&mut Random, usize) -> [f64; 3],
    ) -> Self {
        let (mut vertices, mut x) = (Vec::new(), 0.0);
        for slant in slants {
            vertices.push(Vector2::new(x - slant, 0.0));
            vertices.push(Vector2::new(x + slant, 1.0));
            x += random.uniform(0.8, 1.4);
        }
        let count = slants.len() - 1;
        let panels = (0..count)
            .map(|k| vec![2 * k, 2 * k + 2, 2 * k + 3, 2 * k + 1])
            .collect();
        // The panel behind lies to the right of the way up, so the hinge leads down.
        let hinges = (1..count)
            .map(|k| Hinge {
                ends: [2 * k + 1, 2 * k],
                panels: [k - 1, k],
                angles: fold(random, k),
            })
            .collect();
        Self::new(random, vertices, panels, hinges)
    }

    /// Sectors round a vertex at the border.
    fn fan(random: &mut Random) -> Self {
        let count = random.whole(3, 5);
        let mut vertices = vec![Vector2::zeros()];
        let mut direction = 0.0_f64;
        for _ in 0..=count {
            let reach = random.uniform(0.9, 1.3);
            vertices.push(Vector2::new(direction.cos(), direction.sin()) * reach);
            direction += random.uniform(0.6, 1.1);
        }
        let panels = (1..=count).map(|k| vec![0, k, k + 1]).collect();
        let hinges = (2..=count)
            .map(|k| Hinge {
                ends: [0, k],
                panels: [k - 2, k - 1],
                angles: angles(random, 120.0),
            })
            .collect();
        Self::new(random, vertices, panels, hinges)
    }

    /// A net of a cube: a row of four squares with one above and one below.
    fn net(random: &mut Random) -> Self {
        let [above, below] = [random.below(4), random.below(4)];
        let squares = (0..4)
            .map(|k| [k, 0])
            .chain([[above, 1]])
            .collect::<Vec<_>>();
        let at = |x: f64, y: f64| Vector2::new(x, y);
        let mut vertices = Vec::new();
        for y in [0.0, 1.0] {
            vertices.extend((0..5).map(|x| at(f64::from(x), y)));
        }
        #[allow(clippy::cast_precision_loss, reason = "a small number")]
        let [up, down] = [above as f64, below as f64];
        vertices.extend([
            at(up, 2.0),
            at(up + 1.0, 2.0),
            at(down, -1.0),
            at(down + 1.0, -1.0),
        ]);
        let mut panels: Vec<Vec<usize>> = squares[..4]
            .iter()
            .map(|[k, _]| vec![*k, k + 1, k + 6, k + 5])
            .collect();
        panels.push(vec![above + 5, above + 6, 11, 10]);
        panels.push(vec![12, 13, below + 1, below]);
        let most = if random.chance(0.5) { 89.0 } else { 120.0 };
        let mut hinge = |ends, panels| Hinge {
            ends,
            panels,
            angles: angles(random, most),
        };
        let mut hinges: Vec<Hinge> = (1..4).map(|k| hinge([k + 5, k], [k - 1, k])).collect();
        hinges.push(hinge([above + 5, above + 6], [above, 4]));
        hinges.push(hinge([below + 1, below], [below, 5]));
        Self::new(random, vertices, panels, hinges)
    }

    fn random(seed: u64) -> Self {
        let mut random = Random::stream(seed, 59);
        match seed % 4 {
            0 => Self::chain(&mut random),
            1 => Self::stack(&mut random),
            2 => Self::fan(&mut random),
            _ => Self::net(&mut random),
        }
    }

    /// Returns the motion as a path file.
    fn file(&self) -> String {
        let mut edges: Vec<[usize; 2]> = self.hinges.iter().map(|hinge| hinge.ends).collect();
        let is_known = |edges: &[[usize; 2]], [a, b]: [usize; 2]| {
            edges.iter().any(|edge| *edge == [a, b] || *edge == [b, a])
        };
        for panel in &self.panels {
            for (&a, &b) in panel.iter().zip(panel.iter().cycle().skip(1)) {
                if !is_known(&edges, [a, b]) {
                    edges.push([a, b]);
                }
            }
        }
        let hinges = self.hinges.len();
        let mut letters: Vec<_> = (0..edges.len())
            .map(|k| if k < hinges { "U" } else { "B" })
            .collect();
        let mut faces = self.panels.clone();
        for panel in self
            .panels
            .iter()
            .filter(|panel| self.is_split && panel.len() == 4)
        {
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| panel[k]);
            edges.push([a, c]);
            letters.push("F");
            faces.retain(|face| face != panel);
            faces.extend([vec![a, b, c], vec![a, c, d]]);
        }
        let frame = |knot: usize| {
            let angle = |k: usize| {
                self.hinges
                    .get(k)
                    .map_or(0.0, |hinge| hinge.angles[knot].to_degrees())
            };
            json!({
                "frame_classes": ["foldedForm"],
                "frame_parent": 0,
                "frame_inherit": true,
                "foldpath:time": knot,
                "edges_foldAngle": (0..edges.len()).map(angle).collect::<Vec<_>>(),
            })
        };
        let file = json!({
            "file_spec": 1.2,
            "file_classes": ["animation"],
            "frame_classes": ["creasePattern"],
            "vertices_coords": self.vertices.iter().map(|at| [at.x, at.y]).collect::<Vec<_>>(),
            "edges_vertices": edges,
            "edges_assignment": letters,
            "faces_vertices": faces,
            "foldpath:interpolation": "linear",
            "foldpath:thickness": self.thickness,
            "foldpath:hingePlane": self.hinge_plane,
            "foldpath:panels": if self.is_inset { "inset" } else { "taper" },
            "foldpath:panelGap": self.gap,
            "foldpath:margin": self.margin.to_degrees(),
            "file_frames": (0..3).map(frame).collect::<Vec<_>>(),
        });
        file.to_string()
    }

    /// Returns the half-spaces of each plate, as unit normals and offsets: the points x with n x ≤ o belong to it.
    fn plates(&self) -> Vec<Vec<(Vector3<f64>, f64)>> {
        let below = self.hinge_plane * self.thickness;
        let above = self.thickness - below;
        let tangents = |hinge: &Hinge| {
            let most = |sign: f64| {
                hinge
                    .angles
                    .iter()
                    .map(|angle| sign * angle)
                    .fold(0.0, f64::max)
            };
            let tangent = |most: f64| {
                if most > 0.0 {
                    ((most + self.margin) / 2.0).tan()
                } else {
                    0.0
                }
            };
            [tangent(most(-1.0)), tangent(most(1.0))]
        };
        let plate = |panel: &Vec<usize>| {
            let mut planes = vec![(Vector3::z(), above), (-Vector3::z(), below)];
            for (&a, &b) in panel.iter().zip(panel.iter().cycle().skip(1)) {
                let (from, along) = (
                    self.vertices[a],
                    (self.vertices[b] - self.vertices[a]).normalize(),
                );
                let outward = Vector2::new(along.y, -along.x);
                let offset = outward.dot(&from);
                let hinge = self
                    .hinges
                    .iter()
                    .find(|hinge| hinge.ends == [a, b] || hinge.ends == [b, a]);
                let [mountain, valley] = hinge.map_or([0.0; 2], tangents);
                if self.is_inset {
                    let back = (below * mountain).max(above * valley);
                    let back = if hinge.is_some() {
                        back.max(self.gap)
                    } else {
                        0.0
                    };
                    planes.push((outward.push(0.0), offset - back));
                } else {
                    // Upright at a border, and slanted on the sides on which a hinge closes.
                    let slopes = [valley, -mountain];
                    let count = if hinge.is_some() { 2 } else { 1 };
                    for &slope in &slopes[..count] {
                        let normal = outward.push(slope);
                        planes.push((normal.normalize(), offset / normal.norm()));
                    }
                }
            }
            planes
        };
        self.panels.iter().map(plate).collect()
    }

    /// Returns the places of the panels at a time from 0 to 2.
    fn placed(&self, time: f64) -> Vec<Isometry3<f64>> {
        let mut places = vec![Isometry3::identity(); self.panels.len()];
        for hinge in &self.hinges {
            let [a, b, c] = hinge.angles;
            let angle = if time < 1.0 {
                a + (b - a) * time
            } else {
                b + (c - b) * (time - 1.0)
            };
            let [from, to] = hinge.ends.map(|end| self.vertices[end].push(0.0));
            // A positive angle lifts the panel to the left.
            let turn = UnitQuaternion::from_axis_angle(&Unit::new_normalize(to - from), angle);
            let about = Translation3::from(from) * turn * Translation3::from(-from);
            places[hinge.panels[1]] = places[hinge.panels[0]] * about;
        }
        places
    }

    /// Returns the largest depth to which two plates are in each other at any time looked at; 0 or less if none are.
    fn depth(&self) -> f64 {
        let plates = self.plates();
        let corners: Vec<_> = plates.iter().map(|planes| corners(planes)).collect();
        let mut deepest = -1.0_f64;
        for step in 0..=TIMES {
            #[allow(clippy::cast_precision_loss, reason = "a small number")]
            let places = self.placed(2.0 * step as f64 / TIMES as f64);
            for b in 0..plates.len() {
                for a in 0..b {
                    let planes = [a, b].map(|k| moved(&plates[k], &places[k]));
                    let corners = [a, b].map(|k| {
                        corners[k]
                            .iter()
                            .map(|at| places[k] * at)
                            .collect::<Vec<_>>()
                    });
                    // A plane of one plate that has all of the other one ahead.
                    let parts = |k: usize| {
                        planes[k].iter().any(|(normal, offset)| {
                            let mut others = corners[1 - k].iter();
                            others.all(|at| normal.dot(&at.coords) > *offset)
                        })
                    };
                    if !parts(0) && !parts(1) {
                        deepest = deepest.max(shared(&planes.concat()));
                    }
                }
            }
        }
        deepest
    }
}

/// Returns half-spaces that move with a plate.
fn moved(planes: &[(Vector3<f64>, f64)], place: &Isometry3<f64>) -> Vec<(Vector3<f64>, f64)> {
    let planes = planes.iter().map(|(normal, offset)| {
        let normal = place.rotation * normal;
        (normal, offset + normal.dot(&place.translation.vector))
    });
    planes.collect()
}

/// Returns the corners of what all half-spaces share.
fn corners(planes: &[(Vector3<f64>, f64)]) -> Vec<Point3<f64>> {
    let mut corners = Vec::new();
    for a in 0..planes.len() {
        for b in 0..a {
            for c in 0..b {
                let three = [a, b, c].map(|k| planes[k]);
                let rows = Matrix3::from_rows(&three.map(|(normal, _)| normal.transpose()));
                if rows.determinant().abs() <= 1e-9 {
                    continue;
                }
                let Some(inverse) = rows.try_inverse() else {
                    continue;
                };
                let at = inverse * Vector3::from(three.map(|(_, offset)| offset));
                if planes
                    .iter()
                    .all(|(normal, offset)| normal.dot(&at) <= offset + ROUNDING)
                {
                    corners.push(at.into());
                }
            }
        }
    }
    corners
}

/// Returns the distance of the middle of the points that all half-spaces share from the nearest of their planes; -1 if they
/// share no point.
fn shared(planes: &[(Vector3<f64>, f64)]) -> f64 {
    let corners = corners(planes);
    if corners.is_empty() {
        return -1.0;
    }
    #[allow(clippy::cast_precision_loss, reason = "a mean")]
    let middle = corners.iter().map(|at| at.coords).sum::<Vector3<f64>>() / corners.len() as f64;
    let room = planes
        .iter()
        .map(|(normal, offset)| offset - normal.dot(&middle));
    room.fold(f64::INFINITY, f64::min)
}

/// Numbers of motions by their answers.
#[derive(Debug, Default)]
struct Tally {
    held: usize,
    refused: usize,
    used_up: usize,
    undecided: usize,
    /// Motions that are refused or not decided although the oracle finds no plates in each other.
    clear: usize,
}

/// Judges random motions and compares with the oracle.
fn judged(seeds: core::ops::Range<u64>) -> Tally {
    let mut tally = Tally::default();
    for seed in seeds {
        let sheet = Sheet::random(seed);
        let path = path_file(&sheet.file()).unwrap();
        assert!(path.plates.is_some());
        let verdict = check(&path, &CheckOptions::default());
        let depth = sheet.depth();
        match verdict.outcome() {
            Outcome::Holds => {
                tally.held += 1;
                assert!(
                    depth < DEEP,
                    "{seed}: holds, but plates are {depth:e} deep in each other: {sheet:?}"
                );
            }
            Outcome::Fails => {
                let is_used_up = |failure: &Failure| matches!(failure, Failure::PlatesNotMade(_));
                if verdict.failures.iter().any(is_used_up) {
                    tally.used_up += 1;
                } else {
                    tally.refused += 1;
                    tally.clear += usize::from(depth < TOUCHING);
                    if depth < TOUCHING {
                        println!("{seed}: {:?}, {depth:e}", verdict.findings());
                    }
                }
            }
            _ => {
                tally.undecided += 1;
                tally.clear += usize::from(depth < TOUCHING);
                println!("{seed}: {:?}, {depth:e}", verdict.findings());
            }
        }
    }
    tally
}

#[test]
fn the_oracle_sees_plates_in_each_other() {
    let mut random = Random::new(1);
    let mut sheet = Sheet::strip(&mut random, &[0.0; 3], |_, _| [0.0, PI / 4.0, PI / 2.0]);
    (
        sheet.thickness,
        sheet.hinge_plane,
        sheet.is_inset,
        sheet.margin,
    ) = (0.1, 0.5, false, 0.0);
    // Neighbours touch at the end, and without a trim they are in each other.
    assert!(sheet.depth().abs() < 1e-9, "{}", sheet.depth());
    let mut plates = sheet.plates();
    for planes in &mut plates {
        planes.retain(|(normal, _)| normal.z.abs() < 1e-9 || normal.z.abs() > 1.0 - 1e-9);
    }
    let places = sheet.placed(2.0);
    let whole = [0, 1].map(|k| moved(&plates[k], &places[k])).concat();
    assert!(shared(&whole) > 0.01, "{}", shared(&whole));
}

#[test]
fn no_motion_holds_on_which_plates_pass_through_each_other() {
    let tally = judged(0..1000);
    println!("{tally:?}");
    assert!(tally.held >= 600 && tally.refused >= 200, "{tally:?}");
    assert!(50 * tally.clear <= 1000, "{tally:?}");
}

/// Board folds a carton if and only if it is no thicker than the steps that the carton is drawn with.
#[test]
fn cartons_fold_if_their_board_is_no_thicker_than_their_steps() {
    for seed in 0..12 {
        let mut random = Random::stream(seed, 60);
        let carton = Carton::random(&mut random);
        let pattern = CreasePattern::new(carton.drawing()).unwrap();
        let goal = Goal::of_pattern(&pattern).unwrap();
        let thin = random.uniform(0.3, 0.98);
        for (part, folds) in [(thin, true), (1.0, true), (1.05, false)] {
            let plates = PlateOptions::of_thickness(part * carton.step);
            let options =
                PlanOptions::default().with(|it| it.plates = Some(PlateRequest::given(plates)));
            let answer = plan(&pattern, &goal, &options);
            let what = format!("{seed}: {part} of {carton:?}: {:?}", answer.reason);
            if folds {
                assert_eq!(
                    answer.outcome,
                    foldpath::planner::Outcome::Planned,
                    "{what}"
                );
                let motion = answer.motion.unwrap();
                assert_eq!(motion.plates, Some(plates), "{what}");
                let verdict = check(&motion, &CheckOptions::default());
                assert_eq!(verdict.outcome(), Outcome::Holds, "{what}");
            } else {
                assert!(
                    matches!(answer.outcome, foldpath::planner::Outcome::Crossing(_)),
                    "{what}"
                );
                // The flap in the tube lies in the side that closes over it.
                let at_goal = |note: &Note| matches!(note, Note::PlatesCrossAtGoal { .. });
                assert!(
                    answer.notes.iter().any(at_goal),
                    "{what}: {:?}",
                    answer.notes
                );
            }
        }
    }
}
