//! The controller's needs in figures: memory, instructions, and time to stop. One command prints all: `cargo test -p
//! foldpath-tests --test it controller_figures -- --nocapture --test-threads 1 --include-ignored`.

use core::time::Duration;
use std::fs;
use std::time::Instant;

use crate::image::path::Fold;
use crate::image::world::{Sight, World};
use crate::image::{board_output, image, size, turn};
use foldpath_core::follower::{Reason, State};
use foldpath_core::wire::driver::Persistence;
use foldpath_firmware_sim::faults::Faults;

/// Instructions in a second of the emulated board's clock, one in each of its cycles.
const PACE: u64 = 25_000_000;
/// Address of the stack, its size in bytes, and the word with which it is painted.
const STACK: usize = 0x2000_0000;
const STACK_SIZE: usize = 96 * 1024;
const PAINT: u32 = 0xcccc_cccc;

/// The flash and RAM that a real part has to offer.
#[test]
fn the_image_is_small() {
    let bytes = fs::read(image("foldpath-mps2-small")).unwrap();
    let flash = size(&bytes, &[".vector_table", ".text", ".rodata", ".data"]);
    let ram = size(&bytes, &[".data", ".bss", ".uninit"]);
    println!("| flash | {flash} bytes |\n| RAM without the stack | {ram} bytes |");
    assert!((1..=40 * 1024).contains(&flash));
    assert!((1..=8 * 1024).contains(&ram));
}

/// A tick of 1,104 hinges is finished before the next tick is due.
#[test]
fn work_is_done_in_time() {
    let output = board_output();
    let cost = |what: &str| -> u64 {
        let prefix = format!("cost {what} ");
        let line = output.lines().find_map(|line| line.strip_prefix(&prefix));
        let cost = line.unwrap_or_else(|| panic!("no {what}")).parse().unwrap();
        println!("| {} | {cost} instructions |", what.replace('-', " "));
        cost
    };
    assert!((100..=300).contains(&cost("closure-of-degree-4")));
    assert!((2000..=4500).contains(&cost("levenberg-marquardt-step-of-6-unknowns")));
    let [few, some, all] = [6, 64, 1104].map(|hinges| cost(&format!("tick-of-{hinges}-hinges")));
    // With the guard of a vertex of four spokes, 400 instructions.
    assert!((100..=1530).contains(&few));
    assert!((58 * 10..=58 * 25).contains(&(some - few)));
    assert!((1098 * 10..=1098 * 25).contains(&(all - few)));
    assert!(all <= PACE / 1000);
    assert!((100..=600).contains(&cost("record-of-2-groups")));
    assert!((400..=1000).contains(&cost("tag-of-40-bytes")));
    assert!((2000..=4000).contains(&cost("tag-of-256-bytes")));
    let plain = cost("setpoint-from-its-frame-to-the-answer");
    let keyed = cost("setpoint-with-a-key-from-its-frame-to-the-answer");
    assert!((plain..=plain * 5 / 4).contains(&keyed));
    let frames = PACE / plain;
    println!("| setpoints received, checked and answered at 25 MHz | {frames} a second |");
    assert!(frames >= 2000);
}

#[test]
fn the_stop_line_stops_within_a_tick_and_the_stack_is_shallow() {
    let fold = Fold::miura();
    image("foldpath-mps2-small");
    let _turn = turn();
    let mut world = World::new(&fold, "mps2-an386", Faults::default(), 0);
    world.greet(Persistence::Always);
    let mut latest = i64::MIN;
    for _ in 0..4 {
        world.until(|world| world.sight.is_some_and(|sight| sight.rate >= 1.0));
        world.freeze();
        let before = world.sight.unwrap();
        world.board.draw_stop();
        let drawn = world.board.micros();
        assert!(drawn >= before.time);
        world.board.thaw();
        world.until(|world| world.report.is_some_and(|r| r.reason == Reason::StopLine));
        let told = world.time();
        world.until(|world| world.time() > told);
        let after = world.sight.unwrap();
        assert_eq!((after.state, after.rate.to_bits()), (State::Holding, 0));
        // At full speed the place on the path tells the time. The place is that of the last tick, at most a millisecond
        // ago.
        let gone = fold.time(after.place) - fold.time(before.place);
        #[allow(clippy::cast_possible_truncation, reason = "below a second")]
        let still = i64::try_from(before.time).unwrap() + (1e6 * gone) as i64;
        latest = latest.max(still - i64::try_from(drawn).unwrap());
    }
    println!(
        "| from the stop line to the last motion | at most {} us |",
        latest.max(0)
    );
    // The last tick before came up to a round of the main loop earlier; one with telemetry takes more than 2 ms.
    assert!((-4000..=1000).contains(&latest), "{latest}");
    world.finish();

    let memory = world.board.memory(STACK, STACK_SIZE);
    let (words, _) = memory.as_chunks::<4>();
    let clean = words
        .iter()
        .take_while(|word| u32::from_le_bytes(**word) == PAINT);
    let used = STACK_SIZE - 4 * clean.count();
    println!("| stack | {used} bytes |");
    assert!((256..=8 * 1024).contains(&used));
}

/// Follows the path at its full rate, lets something happen while the board is frozen, and prints when the board first told
/// that nothing moves any more, milliseconds, and the milliseconds of the path until then. Returns the latter.
fn stops(fold: &Fold, what: &str, happens: impl Fn(&mut World<'_>)) -> f64 {
    let mut world = World::new(fold, "mps2-an386", Faults::default(), 0);
    world.greet(Persistence::None);
    world.until(|world| world.sight.is_some_and(|sight| sight.rate >= 1.0));
    world.freeze();
    let before = world.sight.unwrap();
    let (frozen, age) = (world.board.micros(), world.board.since(before.time));
    // A host that is awake speaks every 20 ms. Its frames wait in the line, and reach the board as soon as its time goes on.
    let waits = |world: &mut World<'_>| {
        let begun = Instant::now();
        while begun.elapsed() < Duration::from_millis(60) {
            world.step();
        }
    };
    waits(&mut world);
    happens(&mut world);
    waits(&mut world);
    world.board.thaw();
    world.until(|world| {
        let rests = |sight: Sight| sight.rate <= 0.0 && sight.time > frozen;
        world.sight.is_some_and(rests)
    });
    let after = world.sight.unwrap();
    // At full rate, the motion went on from the last telemetry to the moment at which the board was frozen.
    let way = fold.time(after.place) - fold.time(before.place) - age.as_secs_f64();
    let time = (after.time - frozen) / 1000;
    println!(
        "| {what} | told after {time} ms | {:.0} ms of the path |",
        1e3 * way
    );
    1e3 * way
}

/// The emulated board stops as the controller on this machine does: see `firmware-sim/tests/it/stops.rs`.
#[test]
#[ignore = "takes ten seconds: `tests/run full` runs it"]
fn an_emulated_board_stops_as_fast_as_the_controller_on_this_machine() {
    let fold = Fold::miura();
    image("foldpath-mps2-small");
    let _turn = turn();
    let line = stops(&fold, "the stop line", |world| world.board.draw_stop());
    // The last tick before came up to a round of the main loop earlier.
    assert!((-4.0..=1.0).contains(&line), "{line}");
    // 125 ms of braking, and the bytes of the frames that wait, which the emulator takes one at a time.
    let asked = stops(&fold, "`Hold`, as by Ctrl-C", |world| {
        world.hosts[0].driver.stop();
    });
    assert!((122.0..=250.0).contains(&asked), "{asked}");
    // The host is heard until the last byte that waits, and 500 ms later the board brakes.
    let gone = stops(&fold, "a host that is gone", |world| {
        world.hosts[0].awake = false;
    });
    assert!((622.0..=750.0).contains(&gone), "{gone}");
    // Two exchanges come before, with a host that may have to wait for this machine: at most until it counts as silent.
    let other = stops(&fold, "another host that greets", |world| {
        world.hosts[0].awake = false;
        world.greet(Persistence::None);
    });
    assert!((122.0..=750.0).contains(&other), "{other}");
}
