//! Is the controller's image without an allocator and without panics, and does its board, in an emulator, compute the
//! bits that the host computes?

use std::fs;

use crate::image::{IMAGES, board_output, build, image, symbols};

#[path = "../../../firmware-sim/examples/probe/probe.rs"]
mod probe;

fn host_output() -> String {
    let mut output = String::new();
    probe::run(&mut output).expect("the probe succeeds on the host");
    output
}

/// Returns the numbers behind "`fold` `what`" in each line that begins with these words.
fn numbers<'a>(output: &'a str, fold: &str, what: &str) -> impl Iterator<Item = Vec<f64>> + 'a {
    let prefix = format!("{fold} {what} ");
    let lines = output.lines().filter_map(move |l| l.strip_prefix(&prefix));
    lines.map(|line| {
        let words = line.split(' ').map(|word| u32::from_str_radix(word, 16));
        words
            .map(|bits| f32::from_bits(bits.unwrap()).into())
            .collect()
    })
}

/// Looks at an unoptimised image, because link-time optimisation may inline an allocator until its name is gone.
/// Unoptimised code still has panics; the controller's image does not link with them.
#[test]
fn nothing_reaches_an_allocator() {
    let settings = [
        ("CARGO_PROFILE_FIRMWARE_LTO", "off"),
        ("CARGO_PROFILE_FIRMWARE_OPT_LEVEL", "0"),
        (
            "CARGO_TARGET_THUMBV7EM_NONE_EABIHF_RUSTFLAGS",
            "-Clink-arg=--unresolved-symbols=ignore-all",
        ),
    ];
    let images = build("fw-unoptimised", &settings);
    let allocators = ["__rust_alloc", "__rg_alloc", "__rdl_alloc", "malloc"];
    for name in IMAGES {
        let image = fs::read(images.join(name)).unwrap();
        assert_eq!(symbols(&image, &allocators), [""; 0], "{name}");
    }
}

/// The linker drops the panic handler, with its message, if nothing reaches it. The handler of the controller's image
/// has no message, but calls a function that does not exist, so that an image with a panic would not link.
#[test]
fn nothing_in_the_image_panics() {
    let panics = ["panicking", "rust_begin_unwind", "slice_index_fail"];
    for name in IMAGES {
        let image = fs::read(image(name)).unwrap();
        assert_eq!(symbols(&image, &panics), [""; 0], "{name}");
        let message = image.windows(8).any(|bytes| bytes == b"panicked");
        assert!(!message, "the panic handler is in {name}");
    }
}

#[test]
fn the_board_computes_the_bits_of_the_host() {
    let (board, host) = (board_output(), host_output());
    let board = board.split("cost ").next().unwrap();
    for (board, host) in board.lines().zip(host.lines()) {
        assert_eq!(board, host);
    }
    assert_eq!(board.lines().count(), host.lines().count());
}

#[test]
fn the_probe_follows_the_closed_forms() {
    let miura = |zigzag: f64| vec![zigzag, 2.0 * (0.5 * (zigzag / 2.0).tan()).atan()];
    let waterbomb = |m: f64| {
        let t = (m / 2.0).tan();
        let r = 2.0 * (2.0 * t).atan();
        vec![m, r, -2.0 * (2_f64.sqrt() * t).atan(), 2.0 * r - m]
    };
    let output = host_output();
    follows(&output, "miura", miura);
    follows(&output, "waterbomb", waterbomb);
}

/// Asserts that the knots of `fold` lie on its closed form, a function of the first angle, up to at least 99 degrees,
/// and that the fold stays closed between them.
fn follows(output: &str, fold: &str, closed_form: impl Fn(f64) -> Vec<f64>) {
    let knots: Vec<_> = numbers(output, fold, "knot").collect();
    assert_eq!(knots.len(), usize::from(probe::STEPS) + 1);
    assert!(knots.last().unwrap()[0] > 99_f64.to_radians());
    for knot in &knots {
        let (angles, rates) = knot.split_at(knot.len() / 2);
        assert!(
            distance(angles, &closed_form(angles[0])) < 5e-6,
            "{fold} {angles:?}"
        );
        let h = 1e-6;
        let (before, after) = (closed_form(angles[0] - h), closed_form(angles[0] + h));
        let slopes = before.iter().zip(&after).map(|(b, a)| (a - b) / (2.0 * h));
        let slopes: Vec<_> = slopes.collect();
        assert!(
            distance(rates, &slopes) < 5e-5,
            "{fold} {rates:?} {slopes:?}"
        );
    }
    for sample in numbers(output, fold, "sample") {
        let [max, sum] = [sample[0], sample[1]];
        assert!(max <= sum && sum < 1e-4, "{fold} {sample:?}");
    }
}

/// Returns the largest difference of two entries.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}
