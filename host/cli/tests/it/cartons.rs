//! Cartons of six kinds in seven sizes, drawn as SVG and as DXF, fold in the order in which people close them: the tube first,
//! then what closes its openings.

use core::f64::consts::PI;
use core::fmt::Write as _;
use std::collections::BTreeMap;

use foldpath_test_support::Folder;
use serde_json::Value;

use crate::common::folder;

type Point = [f64; 2];

/// Width, depth and height of cartons, millimetres; length, width and height of the walls of trays.
const SIZES: [[f64; 3]; 7] = [
    [60.0, 30.0, 100.0],
    [80.0, 80.0, 80.0],
    [120.0, 40.0, 160.0],
    [45.0, 25.0, 60.0],
    [100.0, 60.0, 40.0],
    [70.0, 50.0, 150.0],
    [90.0, 35.0, 30.0],
];
/// The layer of cuts.
const CUT: &str = "CUT";
/// The crease that turns past its goal and returns, so that the tuck goes down inside the wall, is told the angle 110.
const TOP: &str = "tuck-top=110 / lid-top / tuck-top";
const BOTTOM: &str = "tuck-bottom=110 / lid-bottom / tuck-bottom";

/// A line or an arc: layer, ends, and the tangent of a fourth of the angle of the arc, positive if it turns left.
struct Stroke(&'static str, Point, Point, f64);

/// A die-line, y pointing up.
#[derive(Default)]
struct DieLine(Vec<Stroke>);

impl DieLine {
    fn line(&mut self, layer: &'static str, from: Point, to: Point) {
        self.0.push(Stroke(layer, from, to, 0.0));
    }

    /// Cuts along corners, each of which is rounded by its radius; 0 for a sharp corner.
    fn cut(&mut self, corners: &[(Point, f64)]) {
        let mut from = corners[0].0;
        for around in corners.windows(3) {
            let [(before, _), (corner, radius), (after, _)] = [around[0], around[1], around[2]];
            let toward = |to: Point| {
                let way = [to[0] - corner[0], to[1] - corner[1]];
                way.map(|part| part / way[0].hypot(way[1]))
            };
            let (u, v) = (toward(before), toward(after));
            let angle = (u[0] * v[0] + u[1] * v[1]).clamp(-1.0, 1.0).acos();
            let back = radius / (angle / 2.0).tan();
            let [begin, end] =
                [u, v].map(|way| [corner[0] + back * way[0], corner[1] + back * way[1]]);
            self.line(CUT, from, begin);
            if radius > 0.0 {
                let left = (u[0] * v[1] - u[1] * v[0]) < 0.0;
                let bulge = ((PI - angle) / 4.0).tan();
                self.0
                    .push(Stroke(CUT, begin, end, if left { bulge } else { -bulge }));
            }
            from = end;
        }
        self.line(CUT, from, corners[corners.len() - 1].0);
    }

    /// Returns the drawing as SVG. Creases of webs are mountains, all others valleys; if there are webs, opacity tells angles.
    fn svg(&self) -> String {
        let ends = || {
            self.0
                .iter()
                .flat_map(|Stroke(_, from, to, _)| [*from, *to])
        };
        let low = ends().fold([f64::MAX; 2], |low, p| {
            [low[0].min(p[0]), low[1].min(-p[1])]
        });
        let high = ends().fold([f64::MIN; 2], |high, p| {
            [high[0].max(p[0]), high[1].max(-p[1])]
        });
        let [width, height] = [high[0] - low[0], high[1] - low[1]];
        let has_webs = self.0.iter().any(|stroke| stroke.0 == "web");
        let mut layers: Vec<&str> = self.0.iter().map(|stroke| stroke.0).collect();
        layers.sort_unstable();
        layers.dedup();
        let mut text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.4}mm\" height=\"{height:.4}mm\" \
             viewBox=\"{:.4} {:.4} {width:.4} {height:.4}\" fill=\"none\">\n",
            low[0], low[1]
        );
        for layer in layers {
            let look = match layer {
                CUT => "stroke=\"black\"",
                "web" => "stroke=\"red\" stroke-opacity=\"0.25\"",
                "gusset" => "stroke=\"blue\"",
                _ if has_webs => "stroke=\"blue\" stroke-opacity=\"0.5\"",
                _ => "stroke=\"blue\"",
            };
            writeln!(text, "<g id=\"{layer}\" {look}>").unwrap();
            for Stroke(_, [x, y], [u, v], bulge) in self.0.iter().filter(|it| it.0 == layer) {
                let arc = if *bulge == 0.0 {
                    "L".to_string()
                } else {
                    let chord = (u - x).hypot(v - y);
                    let radius = chord * (1.0 + bulge * bulge) / (4.0 * bulge.abs());
                    // With y pointing down, an arc to the left sweeps towards smaller angles.
                    format!("A{radius:.4},{radius:.4} 0 0 {} ", u8::from(*bulge < 0.0))
                };
                writeln!(text, "<path d=\"M{x:.4},{:.4}{arc}{u:.4},{:.4}\"/>", -y, -v).unwrap();
            }
            text += "</g>\n";
        }
        text + "</svg>\n"
    }

    /// Returns the drawing as DXF in millimetres. The colours of layers say mountain and valley.
    fn dxf(&self) -> String {
        let mut text =
            "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n"
                .to_string();
        for Stroke(layer, [x, y], [u, v], bulge) in &self.0 {
            let colour = if *layer == "web" { 1 } else { 5 };
            let [x, y, u, v] = [x, y, u, v].map(|number| format!("{number:.4}"));
            let entity = if *bulge == 0.0 {
                format!("0\nLINE\n8\n{layer}\n62\n{colour}\n10\n{x}\n20\n{y}\n11\n{u}\n21\n{v}\n")
            } else {
                format!(
                    "0\nLWPOLYLINE\n8\n{layer}\n62\n{colour}\n90\n2\n70\n0\n10\n{x}\n20\n{y}\n42\n{bulge:.6}\n\
                     10\n{u}\n20\n{v}\n"
                )
            };
            text += &entity;
        }
        text + "0\nENDSEC\n0\nEOF\n"
    }
}

/// A tube of four walls with a glue flap, whose openings get flaps.
struct Tube {
    die: DieLine,
    /// Places of the creases between the walls, and of the ends of the strip.
    x: [f64; 5],
    size: [f64; 3],
}

/// The end of the tube to which a flap belongs.
#[derive(Clone, Copy, PartialEq)]
enum End {
    Top,
    Bottom,
}

impl Tube {
    fn new(size: [f64; 3], glue: f64) -> Self {
        let [w, d, h] = size;
        let x = [0.0, w, w + d, 2.0 * w + d, 2.0 * (w + d)];
        let mut die = DieLine::default();
        for at in &x[1..4] {
            die.line("body", [*at, 0.0], [*at, h]);
        }
        die.line("glue", [0.0, 0.0], [0.0, h]);
        let slope = 0.3 * glue + 1.0;
        die.cut(&[
            ([0.0, 0.0], 0.0),
            ([-glue, slope], 0.2 * glue),
            ([-glue, h - slope], 0.2 * glue),
            ([0.0, h], 0.0),
        ]);
        die.line(CUT, [x[4], 0.0], [x[4], h]);
        Self { die, x, size }
    }

    /// Returns a place from the distances along a wall and away from it.
    fn place(&self, wall: usize, end: End, [along, away]: Point) -> Point {
        let y = match end {
            End::Top => self.size[2] + away,
            End::Bottom => -away,
        };
        [self.x[wall] + along, y]
    }

    /// Adds a window with rounded corners to the first wall.
    fn window(&mut self) {
        let [w, _, h] = self.size;
        let [left, right, low, high] = [0.3 * w, 0.7 * w, 0.3 * h, 0.7 * h];
        self.die.cut(&[
            ([left, low], 0.0),
            ([right, low], 2.0),
            ([right, high], 2.0),
            ([left, high], 2.0),
            ([left, low], 0.0),
        ]);
    }

    /// Leaves the end of a wall without a flap.
    fn plain(&mut self, wall: usize, end: End) {
        let width = self.x[wall + 1] - self.x[wall];
        let ends = [0.0, width].map(|along| self.place(wall, end, [along, 0.0]));
        self.die.line(CUT, ends[0], ends[1]);
    }

    /// Adds a flap to a wall, with a crease between two places along the wall, and the corners of its outline.
    fn flap(
        &mut self,
        wall: usize,
        end: End,
        layer: &'static str,
        crease: [f64; 2],
        corners: &[(Point, f64)],
    ) {
        let width = self.x[wall + 1] - self.x[wall];
        let at = |along: f64| self.place(wall, end, [along, 0.0]);
        let [start, from, to, stop] = [0.0, crease[0], crease[1], width].map(at);
        let corners = corners.iter();
        let corners = corners.map(|(corner, radius)| (self.place(wall, end, *corner), *radius));
        let outline: Vec<_> = core::iter::once((from, 0.0))
            .chain(corners)
            .chain([(to, 0.0)])
            .collect();
        self.die.line(layer, from, to);
        self.die.cut(&outline);
        if crease[0] > 0.0 {
            self.die.line(CUT, start, from);
        }
        if crease[1] < width {
            self.die.line(CUT, to, stop);
        }
    }

    /// Adds a lid with a tuck whose corners are rounded.
    fn lid(&mut self, wall: usize, end: End, [lid, tuck]: [&'static str; 2]) {
        let [w, d, _] = self.size;
        let (deep, inset) = (0.45 * d, 0.04 * w);
        let corners = [
            ([0.0, d], 0.0),
            ([inset, d], 0.0),
            ([inset, d + deep], 0.4 * deep),
            ([w - inset, d + deep], 0.4 * deep),
            ([w - inset, d], 0.0),
            ([w, d], 0.0),
        ];
        self.flap(wall, end, lid, [0.0, w], &corners);
        let [from, to] = [inset, w - inset].map(|along| self.place(wall, end, [along, d]));
        self.die.line(tuck, from, to);
    }

    /// Adds dust flaps to the side walls, which leave room beside their creases for a tuck, as a fraction of the depth.
    fn dust_flaps(&mut self, end: End, room: f64) {
        let [w, d, _] = self.size;
        let corner = |along: f64| ([along * d, 0.42 * w], 0.08 * d);
        let corners = [corner(room + 0.02), corner(0.98 - room)];
        for wall in [1, 3] {
            self.flap(wall, end, "dust", [room * d, (1.0 - room) * d], &corners);
        }
    }
}

/// Room beside dust flaps that suffices for a tuck, as a fraction of the depth.
const ROOM: f64 = 0.12;

/// A carton with tucks at both ends, at the same wall, or at opposite ones and with a window.
fn tucked(size: [f64; 3], reverse: bool, room: f64) -> DieLine {
    let mut tube = Tube::new(size, 0.35 * size[1]);
    let below = if reverse { 2 } else { 0 };
    tube.lid(0, End::Top, ["lid-top", "tuck-top"]);
    tube.plain(2, End::Top);
    tube.lid(below, End::Bottom, ["lid-bottom", "tuck-bottom"]);
    tube.plain(2 - below, End::Bottom);
    tube.dust_flaps(End::Top, room);
    tube.dust_flaps(End::Bottom, room);
    if reverse {
        tube.window();
    }
    tube.die
}

/// A carton with a tuck above and a bottom of four flaps, one with a recess for the tongue of another.
fn snap_lock(size: [f64; 3]) -> DieLine {
    let [w, d, _] = size;
    let mut tube = Tube::new(size, 0.35 * d);
    tube.lid(0, End::Top, ["lid-top", "tuck-top"]);
    tube.plain(2, End::Top);
    tube.dust_flaps(End::Top, ROOM);
    let at = |along: f64, away: f64, radius: f64| ([along * w, away * d], radius * d);
    let main = [
        at(0.05, 0.62, 0.05),
        at(0.3, 0.62, 0.0),
        at(0.3, 0.45, 0.0),
        at(0.7, 0.45, 0.0),
        at(0.7, 0.62, 0.0),
        at(0.95, 0.62, 0.05),
    ];
    tube.flap(0, End::Bottom, "main", [0.02 * w, 0.98 * w], &main);
    let sides = [[0.1, 0.35], [0.55, 0.42], [0.9, 0.2]];
    let sides = sides.map(|[along, away]| ([along * d, away * w], 0.04 * d));
    for wall in [1, 3] {
        tube.flap(wall, End::Bottom, "sides", [0.04 * d, 0.96 * d], &sides);
    }
    let lock = [
        at(0.08, 0.4, 0.05),
        at(0.32, 0.4, 0.0),
        at(0.34, 0.6, 0.04),
        at(0.66, 0.6, 0.04),
        at(0.68, 0.4, 0.0),
        at(0.92, 0.4, 0.05),
    ];
    tube.flap(2, End::Bottom, "lock", [0.02 * w, 0.98 * w], &lock);
    tube.die
}

/// A box whose flaps meet in the middle, with slots between them.
fn slotted(size: [f64; 3]) -> DieLine {
    let [w, d, _] = size;
    let mut tube = Tube::new(size, 0.2 * d);
    let slot = 0.015 * d;
    for (end, [outer, inner]) in [
        (End::Top, ["outer-top", "inner-top"]),
        (End::Bottom, ["outer-bottom", "inner-bottom"]),
    ] {
        for wall in 0..4 {
            let (layer, width) = if wall % 2 == 0 {
                (outer, w)
            } else {
                (inner, d)
            };
            let crease = [slot, width - slot];
            let corners = crease.map(|along| ([along, d / 2.0], 0.03 * d));
            tube.flap(wall, end, layer, crease, &corners);
        }
    }
    tube.die
}

/// A tube open at both ends, with a window whose corners are rounded.
fn sleeve(size: [f64; 3]) -> DieLine {
    let mut tube = Tube::new(size, 0.35 * size[1]);
    for wall in 0..4 {
        tube.plain(wall, End::Top);
        tube.plain(wall, End::Bottom);
    }
    tube.window();
    tube.die
}

/// A tray whose walls are joined at the corners by webs.
fn tray([length, width, height]: [f64; 3]) -> DieLine {
    let mut die = DieLine::default();
    let corners = [[0.0, 0.0], [length, 0.0], [length, width], [0.0, width]];
    let outward = |[x, y]: Point| {
        let sign = |at: f64| if at > 0.0 { height } else { -height };
        [sign(x), sign(y)]
    };
    for (corner, next) in corners.into_iter().zip(corners.into_iter().cycle().skip(1)) {
        let ([x, y], [across, up]) = (corner, outward(corner));
        die.line("walls", corner, next);
        die.line("web", corner, [x + across, y]);
        die.line("web", corner, [x, y + up]);
        die.line("gusset", corner, [x + across, y + up]);
        die.line(CUT, [x + across, y], [x + across, y + up]);
        die.line(CUT, [x, y + up], [x + across, y + up]);
        // The rim of the wall beyond the side to the next corner.
        let along_x = (next[0] - x).abs() > 0.0;
        let shift = |[x, y]: Point| {
            if along_x {
                [x, y + up]
            } else {
                [x + across, y]
            }
        };
        die.line(CUT, shift(corner), shift(next));
    }
    die
}

/// A kind of carton: its name, its die-line, and the order in which people close it.
type Kind = (&'static str, fn([f64; 3]) -> DieLine, Option<String>);

fn kinds() -> [Kind; 6] {
    let tucks = || Some(format!("glue / body / dust / {TOP} / {BOTTOM}"));
    let bottom = format!("glue / body / main / sides / lock / dust / {TOP}");
    let flaps = "glue / body / inner-bottom / outer-bottom / inner-top / outer-top";
    [
        ("straight tuck", |size| tucked(size, false, ROOM), tucks()),
        ("reverse tuck", |size| tucked(size, true, ROOM), tucks()),
        ("snap-lock bottom", snap_lock, Some(bottom)),
        ("slotted box", slotted, Some(flaps.into())),
        ("sleeve", sleeve, Some("glue / body".into())),
        // All walls rise at once, as the webs join them.
        ("tray", tray, None),
    ]
}

/// The layers of creases that close the openings of tubes.
const FLAPS: [&str; 12] = [
    "dust",
    "lid-top",
    "tuck-top",
    "lid-bottom",
    "tuck-bottom",
    "main",
    "sides",
    "lock",
    "inner-top",
    "outer-top",
    "inner-bottom",
    "outer-bottom",
];

/// Plans a drawing; the path is kept however far it goes.
fn plan(folder: &Folder, file: &str, order: Option<&str>, has_goal: bool) -> Value {
    let fold = if has_goal { "" } else { "--fold 0.5" };
    let mut command = folder.command(&format!(
        "plan {file} {fold} --timeout 2 --keep --json -o path.fold"
    ));
    if let Some(order) = order {
        command.arg("--order").arg(order);
    }
    let answer = command.output().unwrap();
    let text = String::from_utf8_lossy(&answer.stdout);
    serde_json::from_str(&text).unwrap_or_else(|_| panic!("{file}: {text}"))
}

/// Returns the edges that have one of some names.
fn with_names(folder: &Folder, file: &str, names: &[&str]) -> Vec<usize> {
    let info = folder.done(&format!("info {file} --edges --json")).json();
    let edges = info["edges"].as_array().unwrap().iter().enumerate();
    let has = |edge: &Value| {
        let of_edge = edge["names"].as_array().unwrap();
        of_edge.iter().any(|name| names.iter().any(|it| name == it))
    };
    edges
        .filter(|(_, edge)| has(edge))
        .map(|(number, _)| number)
        .collect()
}

/// Returns `true` if some edges have all ended to turn along the path before any others begin.
fn turn_before(path: &Value, first: &[usize], later: &[usize]) -> bool {
    let frames = path["file_frames"].as_array().unwrap();
    let turns = |edge: &usize, at: usize| {
        let [from, to] =
            [at, at + 1].map(|at| frames[at]["edges_foldAngle"][*edge].as_f64().unwrap());
        (from - to).abs() > 1e-6
    };
    let steps = || 0..frames.len() - 1;
    let ended = steps()
        .filter(|at| first.iter().any(|edge| turns(edge, *at)))
        .max();
    let begun = steps().find(|at| later.iter().any(|edge| turns(edge, *at)));
    ended < begun
}

/// Calls `check` with each kind of carton in each size as SVG and DXF: the folder and the file of the drawing, the words for
/// it, its kind, and the order of the trade.
fn for_each_drawing(check: impl Fn(&Folder, &str, &str, &str, Option<&str>)) {
    for (kind, drawn, order) in kinds() {
        for size in SIZES {
            let die = drawn(size);
            for (file, text) in [("a.svg", die.svg()), ("a.dxf", die.dxf())] {
                let folder = folder();
                folder.write(file, &text);
                let said = format!("{kind} {size:?} {file}");
                check(&folder, file, &said, kind, order.as_deref());
            }
        }
    }
}

#[test]
fn cartons_fold_in_the_order_of_the_trade() {
    for_each_drawing(|folder, file, said, _, order| {
        let has_goal = order.is_none() && file == "a.svg";
        let answer = plan(folder, file, order, has_goal);
        assert_eq!(answer["outcome"], "planned", "{said}: {answer}");
        let (body, flaps) = (
            with_names(folder, file, &["body", "glue"]),
            with_names(folder, file, &FLAPS),
        );
        if order.is_some() {
            assert_eq!(body.len(), 4, "{said}");
        }
        if !flaps.is_empty() {
            let path = folder.read_json("path.fold");
            assert!(turn_before(&path, &body, &flaps), "{said}");
        }
    });
}

/// The planner takes the order of people by itself: it closes the tube first, and dust flaps before lids.
#[test]
fn tubes_close_before_their_lids_without_an_order() {
    for_each_drawing(|folder, file, said, kind, _| {
        if kind == "tray" {
            return;
        }
        let answer = plan(folder, file, None, false);
        assert_eq!(answer["outcome"], "planned", "{said}: {answer}");
        let named = |names: &[&str]| with_names(folder, file, names);
        let (body, flaps) = (named(&["body", "glue"]), named(&FLAPS));
        if flaps.is_empty() {
            return;
        }
        let path = folder.read_json("path.fold");
        assert!(turn_before(&path, &body, &flaps), "{said}: {answer}");
        let (dust, lids) = (named(&["dust"]), named(&["lid-top", "lid-bottom"]));
        assert!(
            dust.is_empty() || turn_before(&path, &dust, &lids),
            "{said}: {answer}"
        );
    });
}

/// Returns for each edge of an order the step in which it first turns.
fn first_steps(order: &str) -> BTreeMap<usize, usize> {
    let mut steps = BTreeMap::new();
    for (step, turns) in order.split(" / ").enumerate() {
        for turn in turns.split(',') {
            let edge = turn.split_once('=').map_or(turn, |(edge, _)| edge);
            steps.entry(edge.parse().unwrap()).or_insert(step);
        }
    }
    steps
}

/// Each order that is listed can be asked for, and in any two of them some edges fold in the opposite order.
#[test]
fn orders_that_are_listed_differ_and_can_be_asked_for() {
    for ((kind, drawn, _), most) in kinds().into_iter().zip([4, 4, 4, 4, 1, 0]) {
        let folder = folder();
        folder.write("a.svg", &drawn(SIZES[0]).svg());
        let fold = if kind == "tray" { "" } else { "--fold 0.5" };
        let answer = folder.done(&format!("plan a.svg {fold} --orders 4 --json"));
        let answer = answer.json();
        let orders = answer["orders"].as_array().unwrap().iter();
        let orders: Vec<&str> = orders.map(|order| order.as_str().unwrap()).collect();
        assert_eq!(orders.len(), most, "{kind}: {orders:?}");
        for (number, order) in orders.iter().enumerate() {
            let asked = plan(&folder, "a.svg", Some(order), false);
            assert_eq!(asked["outcome"], "planned", "{kind}: {order}: {asked}");
            let here = first_steps(order);
            assert_eq!(
                here.len(),
                if kind == "sleeve" { 4 } else { 12 },
                "{kind}: {order}"
            );
            for other in &orders[..number] {
                let there = first_steps(other);
                let mut pairs = here.iter().flat_map(|a| here.iter().map(move |b| (a, b)));
                let is_swapped = pairs.any(|(a, b)| a.1 < b.1 && there[a.0] > there[b.0]);
                assert!(is_swapped, "{kind}: {order} and {other}");
            }
        }
    }
}

/// Dust flaps as wide as the side walls leave a tuck no way into the tube: the answer names the tuck and a dust flap.
#[test]
fn a_tuck_without_room_is_named_with_what_stops_it() {
    let (_, _, order) = &kinds()[0];
    for size in SIZES {
        let folder = folder();
        folder.write("a.svg", &tucked(size, false, 0.0).svg());
        let answer = plan(&folder, "a.svg", order.as_deref(), false);
        assert_eq!(answer["outcome"], "crossing", "{size:?}: {answer}");
        let notes = answer["notes"].to_string();
        let step = "the path ends in step 5 of the order (edges lid-top)";
        assert!(notes.contains(step), "{size:?}: {notes}");
        let words: Vec<&str> = answer["reason"].as_str().unwrap().split(' ').collect();
        let named: [usize; 2] = [1, 3].map(|word| words[word].parse().unwrap());
        let path = folder.read_json("path.fold");
        let at = |name: &str| {
            let edges = with_names(&folder, "a.svg", &[name]);
            let has = |face: &usize| {
                let corners = path["faces_vertices"][*face].as_array().unwrap();
                edges.iter().any(|edge| {
                    let ends = path["edges_vertices"][*edge].as_array().unwrap();
                    ends.iter().all(|end| corners.contains(end))
                })
            };
            named.iter().filter(|face| has(face)).count()
        };
        // The lid has the crease of the tuck as well, and walls have that of a dust flap.
        let counts = ["tuck-top", "dust", "lid-top", "body"].map(at);
        assert_eq!(counts, [1, 1, 0, 0], "{size:?}: {answer}");
    }
}
