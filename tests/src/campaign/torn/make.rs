//! Makes motions of torn sheets: strips of panels in rows, whose creases across all rows turn alike but for a few twisted
//! edges. One angle of the motion is aimed so that two parts of the sheet cross by a random amount, or stay clear by it.

use core::f64::consts::{FRAC_PI_2, PI};

use serde_json::{Value, json};

use super::oracle::Oracle;
use crate::{Motion, Pose, Random, path_file};

/// Kinds of motions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Two long walls on a floor lean towards each other.
    Walls,
    /// A small flap swings into a panel with which it shares a vertex, or beside it.
    Flaps,
    /// A sheet rolls up to a box whose end comes near its floor. In half of them only edges off the spanning tree are
    /// twisted.
    Boxes,
    /// Thin panels roll up, or a thin panel at the end of a wall passes through another wall.
    Thin,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Walls, Self::Flaps, Self::Boxes, Self::Thin];

    /// Returns the name of the kind.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Walls => "walls",
            Self::Flaps => "flaps",
            Self::Boxes => "boxes",
            Self::Thin => "thin",
        }
    }
}

/// Interpolations of paths.
const INTERPOLATIONS: [&str; 4] = ["linear", "hermite", "half-angle", "homogeneous"];
/// Smallest and largest twist, radians: up to less than half of the bound of `check`.
const TWISTS: [f64; 2] = [1e-5, 4e-4];
/// Smallest and largest amount by which parts cross or stay clear, over the median edge.
const AMOUNTS: [f64; 2] = [1e-4, 0.1];
/// Number of parts of each segment in which the amount is measured while it is aimed at.
const AIMING: u32 = 12;
/// Number of trials of an aim.
const TRIALS: usize = 8;

/// Returns the motion of this seed, as the content of its file.
pub(super) fn make(kind: Kind, seed: u64) -> Value {
    let mut random = Random::new(seed);
    match kind {
        Kind::Walls => walls(&mut random, None),
        Kind::Flaps => flaps(&mut random),
        Kind::Boxes => boxes(&mut random),
        Kind::Thin if random.chance(0.5) => {
            let width = random.log_uniform(1e-7, 1e-2);
            walls(&mut random, Some(width))
        }
        Kind::Thin => rolled(&mut random),
    }
}

/// Rows of panels between common lines. Row 0 is at the bottom, column 0 at the left.
#[derive(Clone)]
struct Strip {
    columns: usize,
    rows: usize,
    vertices: Vec<[f64; 2]>,
    edges: Vec<[usize; 2]>,
    faces: Vec<Vec<usize>>,
    /// Angle (radians) and rate of every edge at every knot.
    moves: Vec<Vec<[f64; 2]>>,
    times: Vec<f64>,
    interpolation: &'static str,
    weights: Vec<[f64; 2]>,
    /// `true` if edges that stay flat have the letter F.
    flat_letters: bool,
    /// `true` if hinges that never turn into a mountain have the letter V.
    valley_letters: bool,
    claims: bool,
    positions: bool,
    /// The edges and faces in the order of the file.
    edge_order: Vec<usize>,
    face_order: Vec<usize>,
}

impl Strip {
    /// Returns a flat strip whose columns have these widths, at rest at all knots.
    fn new(random: &mut Random, widths: &[f64], rows: usize) -> Self {
        let columns = widths.len();
        let mut x = vec![0.0];
        for width in widths {
            x.push(x[x.len() - 1] + width);
        }
        let middle = x[columns] / 2.0;
        let mut y = vec![0.0];
        let even = random.chance(0.5);
        for _ in 0..rows {
            let height = if even { 1.0 } else { random.uniform(0.5, 1.5) };
            y.push(y[y.len() - 1] + height);
        }
        let lines = columns + 1;
        let at = |i: usize, j: usize| j * lines + i;
        let vertices = y
            .iter()
            .flat_map(|&y| x.iter().map(move |&x| [x - middle, y]));
        let rungs = (0..rows).flat_map(|r| (0..lines).map(move |i| [at(i, r), at(i, r + 1)]));
        let along = (0..=rows).flat_map(|j| (0..columns).map(move |c| [at(c, j), at(c + 1, j)]));
        let faces = (0..rows).flat_map(|r| {
            let face = move |c| vec![at(c, r), at(c + 1, r), at(c + 1, r + 1), at(c, r + 1)];
            (0..columns).map(face)
        });
        let knots = random.whole(2, 9);
        let even = random.chance(0.5);
        let mut times = vec![0.0];
        for _ in 1..knots {
            let step = if even { 1.0 } else { random.uniform(0.5, 2.0) };
            times.push(times[times.len() - 1] + step);
        }
        let heavy = random.chance(0.5);
        let mut weight = || {
            if heavy {
                [random.uniform(0.8, 1.25), random.uniform(-0.1, 0.1)]
            } else {
                [1.0, 0.0]
            }
        };
        let weights = (0..knots).map(|_| weight()).collect();
        let mut strip = Self {
            columns,
            rows,
            vertices: vertices.collect(),
            edges: rungs.chain(along).collect(),
            faces: faces.collect(),
            moves: Vec::new(),
            times,
            interpolation: INTERPOLATIONS[random.below(INTERPOLATIONS.len())],
            weights,
            flat_letters: random.chance(0.3),
            valley_letters: random.chance(0.5),
            claims: random.chance(0.3),
            positions: random.chance(0.3),
            edge_order: Vec::new(),
            face_order: Vec::new(),
        };
        strip.moves = vec![vec![[0.0; 2]; knots]; strip.edges.len()];
        strip
    }

    /// Puts edges and faces into an order of the file, at random.
    fn order(&mut self, random: &mut Random) {
        self.edge_order = (0..self.edges.len()).collect();
        self.face_order = (0..self.faces.len()).collect();
        if random.chance(0.5) {
            self.edge_order = random.permutation(self.edges.len());
        }
        if random.chance(0.5) {
            self.face_order = random.permutation(self.faces.len());
        }
    }

    fn knots(&self) -> usize {
        self.times.len()
    }

    /// Returns the edge on line `line`, in this row.
    fn rung(&self, line: usize, row: usize) -> usize {
        row * (self.columns + 1) + line
    }

    /// Returns the edge between this row and the one below it, in this column.
    fn along(&self, column: usize, row: usize) -> usize {
        self.rows * (self.columns + 1) + row * self.columns + column
    }

    fn face(&self, column: usize, row: usize) -> usize {
        row * self.columns + column
    }

    fn vertex(&self, line: usize, row: usize) -> usize {
        row * (self.columns + 1) + line
    }

    /// Adds an angle and a rate to all edges of a line at a knot.
    fn turn(&mut self, line: usize, knot: usize, by: [f64; 2]) {
        for row in 0..self.rows {
            let edge = self.rung(line, row);
            self.turn_edge(edge, knot, by);
        }
    }

    fn turn_edge(&mut self, edge: usize, knot: usize, by: [f64; 2]) {
        let rate = if self.interpolation == "linear" {
            0.0
        } else {
            by[1]
        };
        let at = &mut self.moves[edge][knot];
        *at = [at[0] + by[0], at[1] + rate];
    }

    /// Twists an edge by `twist` radians at most: at all knots from `first` on, by an amount that grows, or only between
    /// two knots. Without rates it is only at one knot.
    fn twist(&mut self, random: &mut Random, edge: usize, twist: f64, first: usize) {
        let knots = self.knots();
        match random.below(4) {
            0 => (first..knots).for_each(|knot| self.turn_edge(edge, knot, [twist, 0.0])),
            1 => {
                for knot in first..knots {
                    #[allow(clippy::cast_precision_loss, reason = "a few knots")]
                    let part = (knot + 1 - first) as f64 / (knots - first) as f64;
                    self.turn_edge(edge, knot, [twist * part, 0.0]);
                }
            }
            _ if self.interpolation == "linear" => {
                let knot = random.whole(first.min(knots - 1), knots - 1);
                self.turn_edge(edge, knot, [twist, 0.0]);
            }
            _ => self.bump(random, edge, twist, first),
        }
    }

    /// Turns an edge by `turn` radians at the middle between two knots, and by nothing at both.
    fn bump(&mut self, random: &mut Random, edge: usize, turn: f64, first: usize) {
        let last = self.knots() - 2;
        let from = random.whole(first.min(last), last);
        let rate = 4.0 * turn / (self.times[from + 1] - self.times[from]);
        self.turn_edge(edge, from, [0.0, rate]);
        self.turn_edge(edge, from + 1, [0.0, -rate]);
    }

    /// Returns the content of the file.
    fn file(&self) -> Value {
        let boundary = |edge: usize| {
            let [a, b] = self.edges[edge];
            let sides = self.faces.iter().filter(|face| {
                let mut pairs = crate::sheet::sides(face);
                pairs.any(|side| side == [a, b] || side == [b, a])
            });
            sides.count() < 2
        };
        let letter = |edge: usize| {
            let values = || self.moves[edge].iter();
            let still = values().all(|at| at.iter().all(|x| x.abs() <= 0.0));
            let valley = values().all(|&[angle, rate]| angle >= 0.0 && rate.abs() <= 0.0);
            if boundary(edge) {
                "B"
            } else if still && self.flat_letters {
                "F"
            } else if !still && valley && self.valley_letters {
                "V"
            } else {
                "U"
            }
        };
        let letters: Vec<_> = self.edge_order.iter().map(|&edge| letter(edge)).collect();
        let frame = |knot: usize| {
            let degrees = |part: usize| -> Vec<f64> {
                let edges = self.edge_order.iter();
                edges
                    .map(|&edge| self.moves[edge][knot][part].to_degrees())
                    .collect()
            };
            let mut frame = json!({
                "frame_classes": ["foldedForm"],
                "frame_parent": 0,
                "frame_inherit": true,
                "foldpath:time": self.times[knot],
                "edges_foldAngle": degrees(0),
            });
            if self.interpolation != "linear" {
                frame["foldpath:edges_foldAngleRate"] = json!(degrees(1));
            }
            if self.interpolation == "homogeneous" {
                let each = |part: usize, still: f64| -> Vec<f64> {
                    let of = |letter: &&str| {
                        if matches!(*letter, "B" | "F") {
                            still
                        } else {
                            self.weights[knot][part]
                        }
                    };
                    letters.iter().map(of).collect()
                };
                frame["foldpath:edges_weight"] = json!(each(0, 1.0));
                frame["foldpath:edges_weightRate"] = json!(each(1, 0.0));
            }
            if self.claims {
                for key in ["deformation", "gap", "closure"] {
                    frame[format!("foldpath:{key}")] = json!(9e-4);
                }
            }
            frame
        };
        let edges: Vec<_> = self.edge_order.iter().map(|&e| self.edges[e]).collect();
        let faces: Vec<_> = self.face_order.iter().map(|&f| &self.faces[f]).collect();
        json!({
            "file_spec": 1.2,
            "file_classes": ["animation"],
            "frame_classes": ["creasePattern"],
            "vertices_coords": self.vertices,
            "edges_vertices": edges,
            "edges_assignment": letters,
            "faces_vertices": faces,
            "foldpath:interpolation": self.interpolation,
            "file_frames": (0..self.knots()).map(frame).collect::<Vec<_>>(),
        })
    }

    /// Returns the oracle of this motion.
    ///
    /// # Panics
    /// If the file is no path.
    fn oracle(&self) -> Oracle {
        let file = self.file();
        let path = path_file(&file.to_string()).expect("a path");
        let tree = path.pattern.tree();
        Oracle::of(&file, tree).expect("a path with all keys")
    }

    /// Returns the file, at random with the positions of the vertices at knots.
    fn finished(&self) -> Value {
        let mut file = self.file();
        if self.positions {
            let oracle = self.oracle();
            for knot in 0..self.knots() {
                let segment = knot.min(self.knots() - 2);
                let s = if knot == segment { 0.0 } else { 1.0 };
                let poses = oracle.poses(segment, s);
                let places = oracle.sheet.positions(&poses);
                let places: Vec<[f64; 3]> = places.iter().map(|p| [p.x, p.y, p.z]).collect();
                file["file_frames"][knot]["vertices_coords"] = json!(places);
            }
        }
        file
    }

    /// Returns the position of a face in the file.
    fn in_file(&self, face: usize) -> usize {
        let place = self.face_order.iter().position(|&other| other == face);
        place.unwrap_or(face)
    }
}

/// Aim of a motion: how high are some corners over the nearest of some faces at their lowest?
struct Aim {
    /// Corners: a face and its vertex.
    corners: Vec<[usize; 2]>,
    faces: Vec<usize>,
    /// First segment that counts.
    first: usize,
    /// Height to aim at; below 0 the corners pass through.
    height: f64,
}

impl Aim {
    fn miss(&self, strip: &Strip, oracle: &Oracle) -> f64 {
        let sheet = &oracle.sheet;
        let centre = |face: usize, poses: &[Pose]| {
            let corners = &sheet.faces[face];
            poses[face].apply((sheet.flat[corners[0]] + sheet.flat[corners[2]]) / 2.0)
        };
        let faces: Vec<_> = self.faces.iter().map(|&f| strip.in_file(f)).collect();
        let corners = self.corners.iter();
        let corners = corners.map(|&[face, vertex]| (strip.in_file(face), sheet.flat[vertex]));
        let corners: Vec<_> = corners.collect();
        let mut least = f64::INFINITY;
        for segment in self.first..oracle.motion.segments() {
            for part in 0..=AIMING {
                let poses = oracle.poses(segment, f64::from(part) / f64::from(AIMING));
                for (face, corner) in &corners {
                    let place = poses[*face].apply(*corner);
                    let far = |face: &usize| (centre(*face, &poses) - place).norm();
                    let near = faces.iter().min_by(|a, b| far(a).total_cmp(&far(b)));
                    if let Some(&near) = near {
                        least = least.min(poses[near].seen(place).z);
                    }
                }
            }
        }
        least - self.height
    }

    /// Returns the strip that `bend` makes of `strip` with the number for which the aim is met, as nearly as it is found
    /// from `start` on with steps of no more than `widest` (secants).
    fn meet(
        &self,
        strip: &Strip,
        start: f64,
        widest: f64,
        bend: impl Fn(&mut Strip, f64),
    ) -> Strip {
        let bent = |by: f64| {
            let mut bent = strip.clone();
            bend(&mut bent, by);
            bent
        };
        let mut oracle = bent(start).oracle();
        let mut miss = |by: f64| {
            if let Ok(motion) = Motion::of(&bent(by).file()) {
                oracle.motion = motion;
            }
            self.miss(strip, &oracle)
        };
        let (mut before, mut by) = (start + widest / 10.0, start);
        let (mut last, mut value) = (miss(before), miss(by));
        let mut best = (value, by);
        for _ in 0..TRIALS {
            let slope = (value - last) / (by - before);
            let step = -value / slope;
            if !step.is_finite() || value.abs() < 1e-3 * self.height.abs() {
                break;
            }
            (before, last) = (by, value);
            by += step.clamp(-widest, widest);
            value = miss(by);
            if value.abs() < f64::abs(best.0) {
                best = (value, by);
            }
        }
        bent(best.1)
    }
}

/// Returns widths of columns, all 1 or about 1.
fn widths(random: &mut Random, count: usize) -> Vec<f64> {
    let even = random.chance(0.5);
    let mut width = || if even { 1.0 } else { random.uniform(0.7, 1.3) };
    (0..count).map(|_| width()).collect()
}

/// Returns a number of columns for some 10 to 300 panels in this number of rows, at least `least`.
fn columns(random: &mut Random, rows: usize, least: usize) -> usize {
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "10 to 300"
    )]
    let panels = random.log_uniform(10.0, 300.0) as usize;
    (panels / rows).max(least)
}

/// Returns a random amount by which parts cross (below 0) or stay clear.
fn amount(random: &mut Random, [low, high]: [f64; 2]) -> f64 {
    random.sign() * random.log_uniform(low, high)
}

/// Twists edges that lie between two panels: one to three of them, or all in a row alike. Returns the sum of the twists,
/// radians.
fn twist_some(random: &mut Random, strip: &mut Strip, first: usize) -> f64 {
    let size = if random.chance(0.4) {
        random.uniform(0.5, 1.0) * TWISTS[1]
    } else {
        random.log_uniform(TWISTS[0], TWISTS[1])
    };
    if random.chance(0.2) {
        let (row, twist) = (random.below(strip.rows), random.sign() * size);
        let profile = random.clone();
        for line in 1..strip.columns {
            *random = profile.clone();
            let edge = strip.rung(line, row);
            strip.twist(random, edge, twist, first);
        }
        #[allow(clippy::cast_precision_loss, reason = "a few columns")]
        return size * strip.columns as f64;
    }
    let mut sum = 0.0;
    for _ in 0..random.whole(1, 3) {
        let (edge, size) = if random.chance(0.8) {
            let line = random.whole(1, strip.columns - 1);
            (strip.rung(line, random.below(strip.rows)), size)
        } else {
            // Such an edge parts the panels beside it.
            let row = random.whole(1, strip.rows - 1);
            (strip.along(random.below(strip.columns), row), 0.3 * size)
        };
        let twist = random.sign() * size;
        strip.twist(random, edge, twist, first);
        sum += size;
    }
    sum
}

/// Two walls on a floor. `thin`: width of a panel at the end of the left wall that points at the right one.
fn walls(random: &mut Random, thin: Option<f64>) -> Value {
    let rows = random.whole(2, 3);
    let fin = usize::from(thin.is_some());
    // Nothing but one edge of long walls turns between two knots.
    let quiet = thin.is_none() && random.chance(0.4);
    let columns = columns(random, rows, if quiet { 20 } else { 5 });
    let floor = random.whole(1, 4.min(columns - 4));
    let left = (columns - floor) / 2 - random.below(2).min((columns - floor) / 2 - 2);
    let right = columns - floor - left;
    let widths: Vec<f64> = thin.into_iter().chain(widths(random, columns)).collect();
    let feet = [fin + left, fin + left + floor];
    let length = |part: &[f64]| part.iter().sum::<f64>();
    let heights = [length(&widths[fin..feet[0]]), length(&widths[feet[1]..])];
    let half = length(&widths[feet[0]..feet[1]]) / 2.0;
    let mut strip = Strip::new(random, &widths, rows);
    strip.order(random);
    if quiet && strip.interpolation == "linear" {
        strip.interpolation = INTERPOLATIONS[random.whole(1, 3)];
    }
    let first = usize::from(strip.knots() > 2 && random.chance(0.5));
    let lean = (half / heights[0].min(heights[1])).min(0.8).asin();
    let sways = !quiet && random.chance(0.5);
    for knot in first..strip.knots() {
        for foot in feet {
            // The walls stand farther apart at some knots, and sway between them.
            let open = if sways && random.chance(0.5) {
                random.uniform(0.0, 0.05)
            } else {
                0.0
            };
            let rate = if sways && random.chance(0.3) {
                random.uniform(-0.02, 0.02)
            } else {
                0.0
            };
            strip.turn(foot, knot, [FRAC_PI_2 + lean - open, rate]);
        }
        if thin.is_some() {
            strip.turn(1, knot, [FRAC_PI_2, 0.0]);
        }
    }
    let twist = if quiet {
        let twist = random.uniform(0.2, 1.0) * TWISTS[1];
        let line = random.whole(feet[0] - left / 4, feet[1] + right / 4);
        let edge = strip.rung(line, random.below(rows));
        let turn = random.sign() * twist;
        strip.bump(random, edge, turn, first);
        twist
    } else if thin.is_none() || random.chance(0.5) {
        twist_some(random, &mut strip, first)
    } else {
        0.0
    };
    // Twists move the ends of the walls by no more than about this.
    let most = (twist * heights[0].min(heights[1])).clamp(2.0 * AMOUNTS[0], AMOUNTS[1]);
    // The end of the lower wall meets the higher one.
    let from_left = thin.is_some() || heights[0] <= heights[1];
    let (end, beside, others) = if from_left {
        (0, 0, feet[1]..fin + columns)
    } else {
        (fin + columns, fin + columns - 1, 0..feet[0])
    };
    let corners = (0..rows).flat_map(|row| {
        let face = strip.face(beside, row);
        [row, row + 1].map(|line| [face, strip.vertex(end, line)])
    });
    let faces = others.flat_map(|column| (0..rows).map(move |row| [column, row]));
    let aim = Aim {
        corners: corners.collect(),
        faces: faces.map(|[column, row]| strip.face(column, row)).collect(),
        first,
        height: match thin {
            Some(width) => amount(random, [1e-3 * width, 0.9 * width]),
            None if quiet => random.sign() * random.uniform(0.05, 0.9) * most,
            None if random.chance(0.6) => amount(random, [AMOUNTS[0], most]),
            None => amount(random, AMOUNTS),
        },
    };
    let strip = aim.meet(&strip, 0.0, 0.05, |strip, by| {
        for knot in first..strip.knots() {
            for foot in feet {
                strip.turn(foot, knot, [by, 0.0]);
            }
        }
    });
    strip.finished()
}

/// A box: floor, right wall, ceiling and left wall, whose end comes to lie on the floor.
fn boxes(random: &mut Random) -> Value {
    let rows = random.whole(2, 5);
    let columns = columns(random, rows, 8);
    let short = (columns / 4).max(1);
    let long = columns.div_ceil(2) - short;
    let ceiling = long - random.whole(1, (long / 2).max(1)).min(long - 1);
    let mut widths = widths(random, long);
    let wall: Vec<f64> = (0..short).map(|_| random.uniform(0.8, 1.2)).collect();
    let shrunk = 1.0 - random.uniform(0.0, 0.1);
    widths.extend(&wall);
    widths.extend((0..ceiling).map(|_| 1.0));
    widths.extend(wall.iter().map(|width| width * shrunk));
    let corners = [long, long + short, long + short + ceiling];
    let mut strip = Strip::new(random, &widths, rows);
    if random.chance(0.5) {
        halve(random, &mut strip);
    }
    strip.order(random);
    let first = usize::from(strip.knots() > 2 && random.chance(0.5));
    for knot in first..strip.knots() {
        let open = random.chance(0.3);
        for line in corners {
            let less = if open { random.uniform(0.0, 0.02) } else { 0.0 };
            strip.turn(line, knot, [FRAC_PI_2 - less, 0.0]);
        }
    }
    // Still edges are twisted: those off the tree, which leaves the folded sheet as it is, or any.
    let oracle = strip.oracle();
    let still = |edge: &usize| strip.moves[*edge].iter().all(|at| at[0].abs() <= 0.0);
    let off_tree = random.chance(0.5);
    let mut edges: Vec<usize> = if off_tree {
        oracle.loops().map(|edge| strip.edge_order[edge]).collect()
    } else {
        let lines = (0..rows).flat_map(|row| (1..strip.columns).map(move |line| [line, row]));
        lines.map(|[line, row]| strip.rung(line, row)).collect()
    };
    if edges.iter().any(still) {
        edges.retain(still);
    }
    let mut most = 0.0;
    for _ in 0..random.whole(1, 3) {
        if edges.is_empty() {
            break;
        }
        let edge = edges[random.below(edges.len())];
        let twist = random.log_uniform(TWISTS[0], TWISTS[1]);
        let turn = random.sign() * twist;
        if random.chance(0.5) && strip.interpolation != "linear" {
            strip.bump(random, edge, turn, first);
        } else {
            strip.twist(random, edge, turn, first);
        }
        most += twist * widths.iter().sum::<f64>() / 2.0;
    }
    let most = if off_tree {
        AMOUNTS[1]
    } else {
        most.clamp(2.0 * AMOUNTS[0], AMOUNTS[1])
    };
    let (end, beside) = (strip.columns, strip.columns - 1);
    let ends = (0..rows).map(|row| [strip.face(beside, row), strip.vertex(end, row)]);
    let faces = (0..long).flat_map(|column| (0..rows).map(move |row| [column, row]));
    let aim = Aim {
        // The lower right corner of a quadrangle is one of its lower half, too.
        corners: ends.collect(),
        faces: faces.map(|[column, row]| strip.face(column, row)).collect(),
        first,
        height: amount(random, [AMOUNTS[0], most]),
    };
    let strip = aim.meet(&strip, 0.0, 0.02, |strip, by| {
        for knot in first..strip.knots() {
            strip.turn(corners[0], knot, [by, 0.0]);
        }
    });
    strip.finished()
}

/// Halves all panels by still creases from their lower left corners. The upper halves come last.
fn halve(random: &mut Random, strip: &mut Strip) {
    if strip.faces.len() > 150 || random.chance(0.2) {
        return;
    }
    let knots = strip.knots();
    for face in 0..strip.faces.len() {
        let [a, b, c, d] = strip.faces[face][..] else {
            continue;
        };
        strip.faces[face] = vec![a, b, c];
        strip.faces.push(vec![a, c, d]);
        strip.edges.push([a, c]);
        strip.moves.push(vec![[0.0; 2]; knots]);
    }
}

/// A zigzag strip with a flap of two parts at its lower side. The second part turns about an edge of the first that ends
/// at a corner of a panel.
fn flaps(random: &mut Random) -> Value {
    let rows = random.whole(2, 3);
    let columns = columns(random, rows, 4);
    let widths = widths(random, columns);
    let mut strip = Strip::new(random, &widths, rows);
    let knots = strip.knots();
    let moving = random.chance(0.5);
    for line in 1..columns {
        let angle = random.uniform(0.0, 0.3) * if line % 2 == 0 { 1.0 } else { -1.0 };
        for knot in 0..knots {
            #[allow(clippy::cast_precision_loss, reason = "a few knots")]
            let part = knot as f64 / (knots - 1) as f64;
            strip.turn(line, knot, [angle * if moving { part } else { 1.0 }, 0.0]);
        }
    }
    twist_some(random, &mut strip, 0);
    let (wide, narrow) = (random.log_uniform(1e-4, 0.4), random.log_uniform(1e-4, 1.0));
    let long = if random.chance(0.5) {
        narrow
    } else {
        random.log_uniform(1e-4, 0.5)
    };
    let column = random.below(columns);
    let corner = strip.vertices[strip.vertex(column, 0)];
    let from_corner = random.chance(0.5);
    let start = if from_corner {
        0.0
    } else {
        0.3 * widths[column]
    };
    // The turning edge leans, and the second part leaves a slit between itself and the panel.
    let lean = random.uniform(60_f64.to_radians(), 120_f64.to_radians());
    let slit = random.log_uniform(1e-3, lean - 0.5);
    let add = |strip: &mut Strip, x: f64, y: f64| {
        strip.vertices.push([corner[0] + x, corner[1] + y]);
        strip.vertices.len() - 1
    };
    let down = [long * lean.cos(), -long * lean.sin()];
    let out = [narrow * slit.cos(), -narrow * slit.sin()];
    let p = if from_corner {
        strip.vertex(column, 0)
    } else {
        add(&mut strip, start, 0.0)
    };
    let hinge = start + wide;
    let q = add(&mut strip, hinge, 0.0);
    let p_down = add(&mut strip, start + down[0], down[1]);
    let q_down = add(&mut strip, hinge + down[0], down[1]);
    let tip = add(&mut strip, hinge + out[0], out[1]);
    let mut second = vec![q, q_down, tip];
    if random.chance(0.5) {
        let tip_down = add(&mut strip, hinge + out[0] + down[0], out[1] + down[1]);
        second = vec![q, q_down, tip_down, tip];
    }
    // The lower side of the panel is parted in two or three.
    let (panel, side) = (strip.face(column, 0), strip.along(column, 0));
    let [left, right] = strip.edges[side];
    let add_edge = |strip: &mut Strip, ends: [usize; 2]| {
        strip.edges.push(ends);
        strip.moves.push(vec![[0.0; 2]; knots]);
        strip.edges.len() - 1
    };
    let first_hinge = if from_corner {
        strip.edges[side] = [p, q];
        strip.faces[panel].insert(1, q);
        side
    } else {
        strip.edges[side] = [left, p];
        strip.faces[panel].splice(1..1, [p, q]);
        add_edge(&mut strip, [p, q])
    };
    add_edge(&mut strip, [q, right]);
    let second_hinge = add_edge(&mut strip, [q, q_down]);
    strip.faces.push(vec![p_down, q_down, q, p]);
    let tips = second[2..].to_vec();
    for [a, b] in [[p, p_down], [p_down, q_down]] {
        add_edge(&mut strip, [a, b]);
    }
    for [a, b] in crate::sheet::sides(&second).skip(1) {
        add_edge(&mut strip, [a, b]);
    }
    strip.faces.push(second);
    strip.order(random);
    let up = if random.chance(0.8) {
        random.uniform(95_f64.to_radians(), 160_f64.to_radians())
    } else {
        random.uniform(0.2, 1.5)
    };
    for knot in 0..knots {
        strip.turn_edge(first_hinge, knot, [up, 0.0]);
    }
    let bump = random.below(knots - 1);
    let far = strip.faces.len() - 1;
    let aim = Aim {
        corners: tips.iter().map(|&tip| [far, tip]).collect(),
        faces: vec![panel],
        first: 0,
        height: amount(random, [1e-3, 0.5]) * narrow.min(long),
    };
    let way = if random.chance(0.8) { 1.0 } else { -1.0 };
    let strip = aim.meet(&strip, 0.5 * way, 0.2, |strip, by| {
        // In the other direction the flap swings away from the panel.
        let by = way * by.abs().min(2.0);
        if strip.interpolation == "linear" {
            strip.turn_edge(second_hinge, bump + 1, [by, 0.0]);
        } else {
            let rate = 4.0 * by / (strip.times[bump + 1] - strip.times[bump]);
            strip.turn_edge(second_hinge, bump, [0.0, rate]);
            strip.turn_edge(second_hinge, bump + 1, [0.0, -rate]);
        }
    });
    strip.finished()
}

/// A strip at whose right end thin panels roll up.
fn rolled(random: &mut Random) -> Value {
    let rows = random.whole(1, 3);
    let columns = columns(random, rows, 6);
    let thin = random.whole(3, 4.min(columns - 2));
    let width = random.log_uniform(1e-7, 1e-2);
    let even = random.chance(0.3);
    let mut widths = widths(random, columns - thin);
    for _ in 0..thin {
        widths.push(if even {
            width
        } else {
            width * random.uniform(0.7, 1.4)
        });
    }
    let mut strip = Strip::new(random, &widths, rows);
    strip.order(random);
    let first = columns - thin;
    let knots = strip.knots();
    let grown = |knot: usize| {
        #[allow(clippy::cast_precision_loss, reason = "a few knots")]
        let part = knot as f64 / (knots - 1) as f64;
        part
    };
    for line in 1..first {
        let angle = random.uniform(0.0, 0.3) * if line % 2 == 0 { 1.0 } else { -1.0 };
        let moving = random.chance(0.3);
        for knot in 0..knots {
            let part = if moving { grown(knot) } else { 1.0 };
            strip.turn(line, knot, [angle * part, 0.0]);
        }
    }
    if rows > 1 && random.chance(0.5) {
        twist_some(random, &mut strip, 0);
    }
    // The first thin panel goes on from the others. The next stands up, and the last comes down on those before.
    let angle = random.uniform(100_f64.to_radians(), 125_f64.to_radians());
    let last = first + 2;
    for knot in 0..knots {
        strip.turn(first + 1, knot, [angle * grown(knot), 0.0]);
    }
    let corners = (0..rows).flat_map(|row| {
        let face = strip.face(last, row);
        [row, row + 1].map(|line| [face, strip.vertex(last + 1, line)])
    });
    let aim = Aim {
        corners: corners.collect(),
        faces: (0..rows).map(|row| strip.face(first, row)).collect(),
        first: knots - 2,
        height: amount(random, [1e-3, 0.5]) * width,
    };
    let strip = aim.meet(&strip, 2.0, 0.1, |strip, by| {
        for knot in 0..strip.knots() {
            strip.turn(last, knot, [by.clamp(0.0, 0.95 * PI) * grown(knot), 0.0]);
        }
    });
    strip.finished()
}
