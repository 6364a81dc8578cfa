//! Tests files made to take all memory or time. They are refused with an error, within two gigabytes of address space.
#![cfg(unix)]

use std::fs::File;
use std::io::{BufWriter, Write};
use std::process::{Command, Stdio};

use crate::common::folder;
use foldpath_test_support::Folder;

/// Address space that the program may have, kilobytes.
const MEMORY: usize = 2_000_000;

/// Length of the longest files, bytes.
const LONG: usize = 100_000_000;

/// Writes a file of `repeat(0)`, `repeat(1)` and so on, between two texts, with at most `bytes` bytes.
fn write(
    folder: &Folder,
    name: &str,
    [before, behind]: [&str; 2],
    bytes: usize,
    repeat: impl Fn(usize) -> String,
) {
    let mut out = BufWriter::new(File::create(folder.path(name)).unwrap());
    out.write_all(before.as_bytes()).unwrap();
    let mut written = before.len() + behind.len();
    for index in 0.. {
        let text = repeat(index);
        written += text.len();
        if written > bytes {
            break;
        }
        out.write_all(text.as_bytes()).unwrap();
    }
    out.write_all(behind.as_bytes()).unwrap();
}

/// Asserts that `info` refuses the file with these words while it has little memory.
fn assert_bounded(folder: &Folder, name: &str, words: &str) {
    let program = env!("CARGO_BIN_EXE_foldpath");
    let answer = Command::new("sh")
        .arg("-c")
        .arg(format!("ulimit -v {MEMORY} && exec {program} info {name}"))
        .current_dir(folder.path(""))
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&answer.stderr);
    assert_eq!(answer.status.code(), Some(2), "{name}: {said}");
    assert!(
        said.contains(words),
        "{name}: expected {words}, found {said}"
    );
    std::fs::remove_file(folder.path(name)).unwrap();
}

/// Returns a pseudorandom number from 0 to 1 for each `k`.
fn random(k: usize) -> f64 {
    let mixed = u32::try_from(k % (1 << 31))
        .unwrap()
        .wrapping_mul(2_654_435_761);
    f64::from(mixed >> 8) / f64::from(1 << 24)
}

#[test]
fn long_fold_files() {
    let folder = folder();
    let same = |text: &'static str| move |_| text.to_string();
    write(&folder, "deep.fold", ["", ""], LONG, same("[[[[[[[["));
    assert_bounded(&folder, "deep.fold", "recursion limit exceeded");
    let points = ["{\"vertices_coords\":[[0,0]", "]}"];
    write(&folder, "points.fold", points, LONG, same(",[0,0]"));
    assert_bounded(&folder, "points.fold", "edges_vertices: expected a list");
    let numbers = ["{\"vertices_coords\":[0", "]}"];
    write(&folder, "numbers.fold", numbers, LONG, same(",0"));
    assert_bounded(
        &folder,
        "numbers.fold",
        "vertices_coords[0]: expected a list, found 0",
    );
    // Each frame inherits from the frame before it.
    let frames = ["{\"file_frames\":[{}", "]}"];
    write(&folder, "frames.fold", frames, LONG / 2, |k| {
        format!(",{{\"frame_parent\":{},\"frame_inherit\":true}}", k + 1)
    });
    assert_bounded(
        &folder,
        "frames.fold",
        "vertices_coords: expected a list, found nothing",
    );
}

/// A hundred thousand edges side by side, and a face with a hundred thousand corners. Checks of all pairs would take
/// hours.
#[test]
fn crowded_fold_files() {
    let folder = folder();
    let count = 100_000;
    let list = |text: &dyn Fn(usize) -> String| {
        let list: Vec<String> = (0..count).map(text).collect();
        list.join(",")
    };
    let points = list(&|k| {
        format!(
            "[0,{0}],[1,{0}]",
            1e-6 * f64::from(u32::try_from(k).unwrap())
        )
    });
    let edges = list(&|k| format!("[{},{}]", 2 * k, 2 * k + 1));
    let text = format!("{{\"vertices_coords\":[{points}],\"edges_vertices\":[{edges}]}}");
    folder.write("beside.fold", &text);
    assert_bounded(&folder, "beside.fold", "too many in one place");
    let points = list(&|k| {
        let turn = core::f64::consts::TAU * f64::from(u32::try_from(k).unwrap()) / 1e5;
        format!("[{},{}]", turn.cos(), turn.sin())
    });
    let edges = list(&|k| format!("[{},{}]", k, (k + 1) % count));
    let text = format!("{{\"vertices_coords\":[{points}],\"edges_vertices\":[{edges}]}}");
    folder.write("round.fold", &text);
    assert_bounded(
        &folder,
        "round.fold",
        "expected faces of fewer corners, found 100000",
    );
}

#[test]
fn long_cp_files() {
    let folder = folder();
    write(&folder, "hatched.cp", ["", ""], LONG, |k| {
        let [a, b, c, d] = [4 * k, 4 * k + 1, 4 * k + 2, 4 * k + 3].map(random);
        format!("2 {a} {b} {c} {d}\n")
    });
    assert_bounded(&folder, "hatched.cp", "at most 4194304 lines and crossings");
    // Long lines that never cross lie side by side on a thousandth of the sheet; most other lines are far shorter.
    write(
        &folder,
        "beside.cp",
        ["1 0 0 1 0\n1 1 0 1 1\n1 1 1 0 0\n", ""],
        LONG / 20,
        |k| {
            let y = random(k) / 1000.0;
            format!(
                "2 0 {y} 0 {}\n3 0 {y} 1 {y}\n2 1 {y} 1 {}\n",
                y + 1e-8,
                y + 1e-8
            )
        },
    );
    assert_bounded(&folder, "beside.cp", "at most 4194304 lines and crossings");
    write(&folder, "points.cp", ["", ""], LONG, |_| {
        "2 0 0 0 0\n".into()
    });
    assert_bounded(&folder, "points.cp", "at most 4194304 lines");
}

/// Short drawings that ask for much memory or time.
#[test]
fn svg_bombs() {
    let folder = folder();
    let svg = |before: &str, elements: &str| {
        format!(
            "{before}<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 9 9\">{elements}</svg>"
        )
    };
    let mut uses = "<g id=\"a0\"><path d=\"M0 0h9v9z\" stroke=\"red\"/></g>\n".to_string();
    for level in 1..12 {
        let below = format!("<use href=\"#a{}\"/>", level - 1).repeat(10);
        uses += &format!("<g id=\"a{level}\">{below}</g>\n");
    }
    let long = "l1 1".repeat(20_000);
    let path = format!("<path id=\"p\" d=\"M0 0{long}\" stroke=\"red\"/>");
    let entity = format!("<!DOCTYPE svg [<!ENTITY e \"{}\">]>", "M0 0".repeat(10_000));
    let namespaces = (0..9000)
        .map(|k| format!("<g xmlns:n{k}=\"n\"/>"))
        .collect::<String>();
    let selector = "g ".repeat(12) + "h{stroke:red}";
    let nested = |count: usize| "<g>".repeat(count) + &"</g>".repeat(count);
    let rules: String = (0..9000).map(|k| format!(".c{k}{{stroke:red}}")).collect();
    let pattern = format!("<pattern id=\"t\" width=\"1\" height=\"1\">{path}</pattern>");
    for (name, text, words) in [
        ("deep.svg", svg("", &nested(100_000)), "levels of elements"),
        ("uses.svg", svg("", &uses), "elements, each use counted"),
        (
            "itself.svg",
            svg("", "<g id=\"g\"><use href=\"#g\"/></g>"),
            "a use of what it is in",
        ),
        (
            "copies.svg",
            svg(
                "",
                &format!("{path}{}", "<use href=\"#p\"/>".repeat(10_000)),
            ),
            "MiB of attributes and of arcs, each use counted",
        ),
        (
            "painted.svg",
            svg(
                "",
                &format!(
                    "{pattern}{}",
                    "<path d=\"M0 0h1v1\" stroke=\"url(#t)\"/>".repeat(10_000)
                ),
            ),
            "MiB of attributes and of arcs, each use counted",
        ),
        (
            "arc.svg",
            svg(
                "",
                &format!("<path d=\"M0 0a1 1 0 0 1 1 {}\"/>", "5".repeat(25)).repeat(1_000),
            ),
            "MiB of attributes and of arcs, each use counted",
        ),
        (
            "circles.svg",
            svg("", &"<circle r=\"1e36\"/>".repeat(100)),
            "MiB of attributes and of arcs, each use counted",
        ),
        (
            "laughs.svg",
            svg(&entity, &"<g d=\"&e;\"/>".repeat(100_000)),
            "entities that could grow",
        ),
        (
            "namespaces.svg",
            svg("", &namespaces),
            "declarations of namespaces",
        ),
        (
            "selector.svg",
            svg("", &format!("<style>{selector}</style>{}", nested(200))),
            "style sheets whose selectors take too long",
        ),
        (
            "rules.svg",
            svg(
                "",
                &format!("<style>{rules}</style>{}", "<g/>".repeat(100_000)),
            ),
            "style sheets whose selectors take too long",
        ),
        (
            "elements.svg",
            svg("", &"<g/>".repeat(1_000_000)),
            "elements, each use counted",
        ),
        (
            "empty.svg",
            svg("", &"<a/>".repeat(4_000_000)),
            "nodes limit reached",
        ),
    ] {
        folder.write(name, &text);
        assert_bounded(&folder, name, words);
    }
    let one = |_| "l1 1".to_string();
    let path = [
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 9 9\"><path stroke=\"red\" d=\"M0 0",
        "\"/></svg>",
    ];
    write(&folder, "path.svg", path, 60_000_000, one);
    assert_bounded(
        &folder,
        "path.svg",
        "MiB of attributes and of arcs, each use counted",
    );
    write(&folder, "path.svg", path, 30_000_000, one);
    assert_bounded(&folder, "path.svg", "at most 4194304 lines");
    write(&folder, "path.svg", path, LONG, one);
    assert_bounded(
        &folder,
        "path.svg",
        "the file: expected at most 64 MiB, found more",
    );
}

/// Blocks in blocks, arrays of arrays, and as many things as the bytes can list.
#[test]
fn dxf_bombs() {
    let folder = folder();
    let file = |blocks: &str, entities: &str| {
        format!(
            "0\nSECTION\n2\nBLOCKS\n{blocks}0\nENDSEC\n0\nSECTION\n2\nENTITIES\n{entities}0\nENDSEC\n0\nEOF\n"
        )
    };
    let insert = |name: usize, cells: i16| {
        format!("0\nINSERT\n8\n0\n2\nB{name}\n70\n{cells}\n71\n{cells}\n")
    };
    let mut blocks = "0\nBLOCK\n2\nB0\n0\nLINE\n8\nCUT\n11\n1\n0\nENDBLK\n".to_string();
    for level in 1..20 {
        let inner = insert(level - 1, 1).repeat(10);
        blocks += &format!("0\nBLOCK\n2\nB{level}\n{inner}0\nENDBLK\n");
    }
    let most = "each place of a block counted";
    for (name, text, words) in [
        ("blocks.dxf", file(&blocks, &insert(19, 1)), most),
        ("arrays.dxf", file(&blocks, &insert(0, i16::MAX)), most),
        (
            "lines.dxf",
            file("", &"0\nLINE\n".repeat(1 << 20)),
            "at most 262144 things",
        ),
        (
            "vertices.dxf",
            file(
                "",
                &format!("0\nLWPOLYLINE\n{}", "10\n1\n".repeat(4_500_000)),
            ),
            "a line of at most 4194304 pieces",
        ),
    ] {
        folder.write(name, &text);
        assert_bounded(&folder, name, words);
    }
    let long = ["0\nSECTION\n2\nENTITIES\n0\nLWPOLYLINE\n", "0\nEOF\n"];
    write(&folder, "long.dxf", long, LONG, |_| "10\n1\n".into());
    assert_bounded(
        &folder,
        "long.dxf",
        "the file: expected at most 32 MiB, found more",
    );
}

/// A file that never ends is not read to its end.
#[test]
fn endless_files() {
    let folder = folder();
    for name in ["endless.svg", "endless.cp", "endless.dxf"] {
        std::os::unix::fs::symlink("/dev/zero", folder.path(name)).unwrap();
        assert_bounded(&folder, name, "MiB, found more");
    }
}
