//! Tests what is asked of the reader of drawings: the tolerance within which lines meet, and letters of colours. Lost
//! lines are told with their place and the tolerance that keeps them.

use core::fmt::Write as _;

use crate::common::folder;
use crate::drawings::external;
use foldpath::pattern::CreasePattern;
use foldpath::read::{ColourLetters, ReadOptions, Straighten, parse_pattern_with};
use foldpath_test_support::Random;
use nalgebra::Vector2;
use serde_json::json;

/// Side of the square sheets.
const SIDE: f64 = 100.0;

fn read(name: &str, text: &str, options: &ReadOptions) -> CreasePattern {
    let file = parse_pattern_with(name.as_ref(), text.as_bytes(), options);
    file.unwrap_or_else(|error| panic!("{error}")).pattern
}

fn within(tolerance: f64) -> ReadOptions {
    ReadOptions::default().with(|it| {
        it.tolerance = Some(tolerance);
        it.straighten = Straighten::Off;
    })
}

/// Returns the numbers of vertices, edges and faces.
fn counts(pattern: &CreasePattern) -> [usize; 3] {
    [
        pattern.vertices().len(),
        pattern.edges().len(),
        pattern.faces().len(),
    ]
}

/// A square with lines that run askew from one border to the other.
struct Askew {
    /// CP file of the lines.
    text: String,
    /// Ends of the lines as they were meant, y pointing down.
    lines: Vec<[Vector2<f64>; 2]>,
    /// Numbers of vertices, edges and faces as they were meant.
    counts: [usize; 3],
    /// Numbers of ends that go past the border: by more than the usual tolerance, and by a little less or more.
    beyond: [usize; 2],
}

impl Askew {
    /// Draws up to four lines each way. Every end is moved along its line by up to `error`.
    fn new(rng: &mut Random, error: f64) -> Self {
        let mut text = "1 0 0 100 0\n1 100 0 100 100\n1 100 100 0 100\n1 0 100 0 0\n".to_string();
        let numbers = [rng.whole(1, 4), rng.whole(1, 4)];
        let (mut lines, mut beyond) = (Vec::new(), [0; 2]);
        for (way, count) in numbers.into_iter().enumerate() {
            for slot in 0..count {
                #[allow(clippy::cast_precision_loss, reason = "at most 4")]
                let middle = SIDE * (slot as f64 + 1.0) / (count as f64 + 1.0);
                let ends = [0.0, SIDE].map(|across| {
                    let at = middle + rng.uniform(-4.0, 4.0);
                    if way == 0 {
                        Vector2::new(across, at)
                    } else {
                        Vector2::new(at, across)
                    }
                });
                lines.push(ends);
                let along = (ends[1] - ends[0]).normalize();
                let [a, b] = [-1.0, 1.0].map(|side| {
                    let past = rng.uniform(-error, error);
                    beyond[0] += usize::from(past > 0.02);
                    beyond[1] += usize::from(past > 0.01);
                    along * side * past
                });
                let (from, to) = (ends[0] + a, ends[1] + b);
                let kind = rng.whole(2, 3);
                writeln!(text, "{kind} {} {} {} {}", from.x, from.y, to.x, to.y).unwrap();
            }
        }
        let [n, m] = numbers;
        let vertices = 4 + 2 * n + 2 * m + n * m;
        let faces = (n + 1) * (m + 1);
        Self {
            text,
            lines,
            counts: [vertices, vertices + faces - 1, faces],
            beyond,
        }
    }

    /// Returns the largest distance of a vertex from the lines and borders as they were meant.
    fn error(&self, pattern: &CreasePattern) -> f64 {
        let corners = [[0.0, 0.0], [SIDE, 0.0], [SIDE, SIDE], [0.0, SIDE]].map(Vector2::from);
        let borders = (0..4).map(|k| [corners[k], corners[(k + 1) % 4]]);
        let lines: Vec<_> = borders.chain(self.lines.iter().copied()).collect();
        let vertices = pattern.vertices().iter();
        let far = vertices.map(|at| {
            let at = Vector2::new(at.x, -at.y);
            let mut near: Vec<f64> = lines
                .iter()
                .map(|[a, b]| (at - a).perp(&(b - a).normalize()).abs())
                .collect();
            near.sort_by(f64::total_cmp);
            // Every vertex is where two lines meet.
            near[1]
        });
        far.fold(0.0, f64::max)
    }
}

/// Lines that end short of the border or go past it are read as they were meant: with a tolerance that is asked for, no
/// line is lost and none is bent. Without it, what goes past the border is cut off, and a tolerance is named that keeps
/// it.
#[test]
fn lines_within_the_tolerance_meet() {
    let mut rng = Random::new(7);
    let mut named = 0;
    for round in 0..100 {
        let drawing = Askew::new(&mut rng, 0.4);
        let pattern = read("askew.cp", &drawing.text, &within(0.5));
        assert_eq!(
            counts(&pattern),
            drawing.counts,
            "{round}\n{}",
            drawing.text
        );
        assert_eq!(pattern.lost_lines(), None, "{round}\n{}", drawing.text);
        let error = drawing.error(&pattern);
        // Ends within the usual tolerance stay where they are.
        assert!(error < 0.0142, "{round}: {error}\n{}", drawing.text);

        let pattern = read("askew.cp", &drawing.text, &ReadOptions::default());
        assert_eq!(
            counts(&pattern),
            drawing.counts,
            "{round}\n{}",
            drawing.text
        );
        let lost = pattern.lost_lines();
        let [at_least, at_most] = drawing.beyond;
        let count = lost.map_or(0, |lost| lost.count);
        assert!((at_least..=at_most).contains(&count), "{round}: {count}");
        let Some(lost) = lost else { continue };
        named += 1;
        let tolerance = lost
            .kept_by
            .unwrap_or_else(|| panic!("{round}\n{}", drawing.text));
        assert!((0.01..0.5).contains(&tolerance), "{round}: {tolerance}");
        let kept = read("askew.cp", &drawing.text, &within(tolerance));
        assert_eq!(kept.lost_lines(), None, "{round}: {tolerance}");
        assert_eq!(counts(&kept), drawing.counts, "{round}: {tolerance}");
    }
    assert!(named > 50, "{named}");
}

/// Any tolerance, also one that joins all, gives a pattern or an error.
#[test]
fn any_tolerance_is_taken() {
    let mut rng = Random::new(8);
    for _ in 0..40 {
        let drawing = Askew::new(&mut rng, 2.0);
        for tolerance in [1e-300, 1e-9, 1.0, 5.0, 20.0, 70.0, 200.0, 1e300] {
            let file =
                parse_pattern_with("a.cp".as_ref(), drawing.text.as_bytes(), &within(tolerance));
            if let Err(error) = file {
                assert!(error.to_string().starts_with("a.cp: "), "{error}");
            }
        }
    }
}

/// Returns a CP file with the border of a square from 0 to 4, and these lines.
fn square(lines: &str) -> String {
    format!("1 0 0 4 0\n1 4 0 4 4\n1 4 4 0 4\n1 0 4 0 0\n{lines}")
}

#[test]
fn open_ends_are_joined_to_the_one_line_near() {
    for (lines, expected, told) in [
        // Short of the border.
        (
            "2 2 0 2 3.995",
            [6, 7, 2],
            "open ends joined to the line near them: 1, moved by 5.0e-3 at most, the first to (2, 4)",
        ),
        // A line askew is prolonged as it runs.
        (
            "2 1 0 2.995 3.99",
            [6, 7, 2],
            "open ends joined to the line near them: 1, moved by 1.1e-2 at most, the first to (3, 4)",
        ),
        // Too far for its length and for the sheet.
        (
            "2 2 0 2 4\n2 2 2 2.2 2.2",
            [7, 8, 2],
            "lines that end in the open, without faces between, left out: 1, up to 2.8e-1 long, the first open end at \
             (2.2, 2.2); no tolerance was found that keeps all lines",
        ),
        // Short of one line that is joined to another only then.
        (
            "3 2 2.005 2 4\n2 0 2 3.985 2",
            [8, 10, 3],
            "open ends joined to the line near them: 2, moved by 1.5e-2 at most, the first to (2, 2)",
        ),
    ] {
        let pattern = read("a.cp", &square(lines), &ReadOptions::default());
        assert_eq!(
            counts(&pattern),
            expected,
            "{lines}: {:?}",
            pattern.repairs()
        );
        let repairs = pattern.repairs();
        assert!(repairs.iter().any(|it| it == told), "{lines}: {repairs:?}");
    }
}

/// Lost lines are told on stdout and in `repairs`.
#[test]
fn lost_lines_are_told() {
    let folder = folder();
    let told =
        "1 end in the open, up to 3.9e0 long, the first at (2, 3.9); --tolerance 0.12 keeps all";
    folder.write("two.cp", &square("2 2 0 2 3.9\n3 1 0 1 4"));
    for command in ["info", "plan --fold 0.5"] {
        let answer = folder.run(&format!("{command} two.cp --quiet"));
        assert!(answer.stdout.contains(told), "{answer:?}");
    }
    // Without the one crease there is no goal.
    folder.write("one.cp", &square("2 2 0 2 3.9"));
    let answer = folder.run("plan one.cp").with_status(2);
    assert!(
        answer.stderr.contains("note: lines that end in the open"),
        "{answer:?}"
    );
    assert_eq!(answer.stdout, "");
    let info = folder.done("info two.cp --tolerance 0.12 --json").json();
    assert_eq!(info["creases"], json!(2), "{info}");
    let lost = info["repairs"].as_array().unwrap().iter();
    assert!(
        !lost
            .clone()
            .any(|it| it.as_str().unwrap().contains("in the open")),
        "{info}"
    );
    let plan = folder
        .run("plan two.cp --tolerance 0.12 --fold 0.5 --json")
        .json();
    assert_eq!(plan["outcome"], json!("planned"), "{plan}");
    assert_eq!(plan["options"]["tolerance"], json!(0.12), "{plan}");
    folder.done("export two.cp --tolerance 0.12 --to svg -o two.svg");
    assert_eq!(
        folder.done("info two.svg --json").json()["creases"],
        json!(2)
    );
}

/// Edges of a FOLD file without faces are lines as well.
#[test]
fn fold_files_without_faces_have_a_tolerance() {
    let folder = folder();
    let sheet = json!({
        "vertices_coords": [[0, 0], [4, 0], [4, 4], [0, 4], [2, 0.1], [2, 4]],
        "edges_vertices": [[0, 1], [1, 2], [2, 5], [5, 3], [3, 0], [4, 5]],
        "edges_assignment": ["B", "B", "B", "B", "B", "V"],
    });
    folder.write("gap.fold", &sheet.to_string());
    folder.run("info gap.fold").with_status(2);
    let info = folder.done("info gap.fold --tolerance 0.2 --json").json();
    assert_eq!(
        [&info["faces"], &info["creases"]],
        [&json!(2), &json!(1)],
        "{info}"
    );
}

/// A drawing with red and blue exchanged reads alike if the colours are said.
#[test]
fn colours_have_the_letters_that_are_asked_for() {
    let mut rng = Random::new(9);
    for _ in 0..20 {
        let drawing = Askew::new(&mut rng, 0.0);
        let svg = |colours: [&str; 2], rng: &mut Random| {
            let mut text = "<svg xmlns='http://www.w3.org/2000/svg'>\
                            <rect width='100' height='100' fill='none' stroke='black'/>"
                .to_string();
            for [a, b] in &drawing.lines {
                let colour = colours[rng.below(2)];
                let opacity = rng.uniform(0.1, 0.9);
                let [x1, y1, x2, y2] = [a.x, a.y, b.x, b.y];
                writeln!(
                    text,
                    "<line x1='{x1}' y1='{y1}' x2='{x2}' y2='{y2}' stroke='{colour}' opacity='{opacity:.3}'/>"
                )
                .unwrap();
            }
            text + "</svg>"
        };
        let seed = rng.below(1000) as u64;
        let edges = |text: &str, colours: &str| {
            let options = ReadOptions::default().with(|it| {
                it.colours = match colours {
                    "" => ColourLetters::default(),
                    text => text.parse().unwrap(),
                }
            });
            let pattern = read("a.svg", text, &options);
            let edges = pattern.edges().iter();
            let found: Vec<_> = edges.map(|it| (it.ends, it.letter, it.goal)).collect();
            (found, pattern.assumptions().len())
        };
        let usual = edges(&svg(["red", "blue"], &mut Random::new(seed)), "").0;
        for (colours, letters) in [
            (["blue", "red"], "red=V,blue=M"),
            (["#00ff00", "#808080"], "lime=m, gray=v"),
            // Near the colours that are named.
            (["#00a651", "#ed1c24"], "#00ff00=M,red=V"),
        ] {
            let (found, notes) = edges(&svg(colours, &mut Random::new(seed)), letters);
            assert_eq!(found, usual, "{letters}");
            // Each colour is told, and that opacity is the angle.
            assert_eq!(notes, 3, "{letters}");
        }
    }
}

/// Drawings by other authors are read alike with their colours exchanged.
#[test]
fn real_drawings_have_the_letters_that_are_asked_for() {
    let Some(folder) = external() else { return };
    for name in ["birdBase", "miura-ori", "hypar", "waterbomb"] {
        let file = folder.join(format!("origami-simulator/{name}.svg"));
        let text = std::fs::read_to_string(file).unwrap();
        let text = text
            .replace("#FF0000", "#ff0000")
            .replace("#0000FF", "#0000ff");
        let exchanged = text
            .replace("#ff0000", "#other!")
            .replace("#0000ff", "#ff0000")
            .replace("#other!", "#0000ff");
        assert_ne!(text, exchanged, "{name}");
        let options =
            ReadOptions::default().with(|it| it.colours = "red=V,#0000ff=M".parse().unwrap());
        let edges = |text: &str, options: &ReadOptions| -> Vec<_> {
            let pattern = read("a.svg", text, options);
            let edges = pattern.edges().iter();
            edges.map(|it| (it.ends, it.letter, it.goal)).collect()
        };
        let usual = edges(&text, &ReadOptions::default());
        assert_eq!(edges(&exchanged, &options), usual, "{name}");
    }
}

/// Returns an OPX file of a CP file. The encoder omits zeros, and writes the array in one of two ways.
fn opx(cp: &str, as_field: bool) -> String {
    let mut lines = String::new();
    for (index, line) in cp.lines().enumerate() {
        let fields: Vec<&str> = line.split_whitespace().collect();
        let mut properties = String::new();
        for (name, value) in
            [("x0", 1), ("x1", 3), ("y0", 2), ("y1", 4)].map(|(n, i)| (n, fields[i]))
        {
            if value.parse::<f64>() != Ok(0.0) {
                write!(
                    properties,
                    "<void property=\"{name}\">\n<double>{value}</double>\n</void>\n"
                )
                .unwrap();
            }
        }
        if fields[0] != "0" {
            write!(
                properties,
                "<void property=\"type\"><int>{}</int></void>",
                fields[0]
            )
            .unwrap();
        }
        writeln!(
            lines,
            "<void index=\"{index}\"><object class=\"oripa.OriLineProxy\">{properties}</object></void>"
        )
        .unwrap();
    }
    let lines = format!("<array class=\"oripa.OriLineProxy\" length=\"9\">{lines}</array>");
    let title = "<string>A fold &amp; more</string>";
    let data = if as_field {
        let field = |name: &str, value: &str| {
            format!(
                "<void class=\"oripa.DataSet\" method=\"getField\"><string>{name}</string><void method=\"set\">\
                 <object idref=\"DataSet0\"/>{value}</void></void>\n"
            )
        };
        field("lines", &lines) + &field("title", title)
    } else {
        format!(
            "<void property=\"lines\">{lines}</void>\n<void property=\"title\">{title}</void>\n"
        )
    };
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<java version=\"1.7.0\" class=\"java.beans.XMLDecoder\">\n\
         <object class=\"oripa.DataSet\" id=\"DataSet0\">\n{data}</object>\n</java>\n"
    )
}

/// An OPX file has the same pattern as the CP file of the same lines, and its title.
#[test]
fn opx_files_are_read() {
    let mut rng = Random::new(10);
    for round in 0..20 {
        let cp = Askew::new(&mut rng, 0.01).text + "0 0 0 30 30\n4 0 0 30 40\n5 0 0 1 1";
        let expected = read("a.cp", &cp, &ReadOptions::default());
        for as_field in [false, true] {
            let text = opx(&cp, as_field);
            let options = ReadOptions::default();
            let file = parse_pattern_with("a.OPX".as_ref(), text.as_bytes(), &options).unwrap();
            assert_eq!(file.title, "A fold & more", "{round}");
            assert_eq!(file.pattern.vertices(), expected.vertices(), "{round}");
            let letters = |pattern: &CreasePattern| -> Vec<_> {
                pattern
                    .edges()
                    .iter()
                    .map(|edge| (edge.ends, edge.letter))
                    .collect()
            };
            assert_eq!(letters(&file.pattern), letters(&expected), "{round}");
            let notes = [
                "auxiliary lines (type 0) left out: 1",
                "auxiliary lines (type 4) left out: 1",
                "lines of type 5, taken as auxiliary, left out: 1",
            ];
            assert_eq!(file.pattern.assumptions(), notes, "{round}");
        }
    }
    let folder = folder();
    folder.write("sheet.opx", &opx(&square("2 2 0 2 3.9\n3 1 0 1 4"), true));
    let info = folder.done("info sheet.opx --tolerance 0.2 --json").json();
    assert_eq!(info["creases"], json!(2), "{info}");
}

/// Text that was changed anywhere gives a pattern or an error.
#[test]
fn broken_opx_files_are_refused() {
    let mut rng = Random::new(11);
    let text = opx(&Askew::new(&mut rng, 0.1).text, false).into_bytes();
    for _ in 0..2000 {
        let mut bytes = text.clone();
        for _ in 0..rng.whole(1, 4) {
            let at = rng.below(bytes.len());
            match rng.below(3) {
                0 => bytes[at] = b"<>/\"09-ex&;"[rng.below(11)],
                1 => drop(bytes.remove(at)),
                _ => bytes.truncate(at.max(1)),
            }
        }
        let file = parse_pattern_with("a.opx".as_ref(), &bytes, &ReadOptions::default());
        if let Err(error) = file {
            assert!(error.to_string().starts_with("a.opx: "), "{error}");
        }
    }
}

/// Creases that miss a vertex by a little more than the tolerance are named with place and distance. The hint on a no names
/// the tolerance that joins them, with which the sheet is planned. Creases far from each other are not named.
#[test]
fn creases_that_miss_each_other_are_named_with_the_tolerance_that_joins_them() {
    let square = "1 0 0 400 0\n1 400 0 400 400\n1 400 400 0 400\n1 0 400 0 0\n";
    // Folded twice through all layers, with one digit.
    let creases = "2 0 364.7 279.7 0\n3 92 244.6 400 287.8\n2 0 27.9 92 244.6\n";
    let folder = folder();
    folder.write("twice.cp", &format!("{square}{creases}"));
    let answer = folder.run("plan twice.cp").with_status(1);
    let note = "lines that pass near each other without meeting: 2 places, the nearest 8.6e-2 apart at (92, 244.6); a \
                tolerance of 0.17 joins them";
    assert!(answer.stderr.contains(note), "{}", answer.stderr);
    let help = "help: `--tolerance 0.17` joins lines 8.6e-2 apart";
    assert!(answer.stderr.contains(help), "{}", answer.stderr);
    folder.done("plan twice.cp --tolerance 0.17");
    folder.write(
        "pleats.cp",
        &format!("{square}3 0 100 400 100\n2 0 102 400 102\n"),
    );
    let answer = folder.run("info pleats.cp --json").json();
    let assumptions = answer["assumptions"].to_string();
    assert!(!assumptions.contains("near each other"), "{assumptions}");
}
