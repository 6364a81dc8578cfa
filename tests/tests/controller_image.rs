//! The controller's image in an emulator, and what goes wrong round it, five seeds each. The world judges all that
//! the board tells: nothing is commanded that was not sent, nothing beyond the limits, nothing that tears the sheet.
//! Times are the board's own.

use std::fs;
use std::sync::LazyLock;
use std::thread;
use std::time::Duration;

use foldpath_core::follower::{Reason, State};
use foldpath_core::wire::driver::Persistence;
use foldpath_core::wire::frame;
use foldpath_core::wire::message::{SCHEMA, ToDevice, ToHost, VERSION};
use foldpath_core::wire::sender::Failure;
use foldpath_firmware_sim::faults::Faults;
use image::path::Fold;
use image::world::{World, moment, rng, stuffed};
use image::{image, size};
use rand_core::Rng;

mod image;

const AN386: &str = "mps2-an386";
const SEEDS: u64 = 5;
/// Microseconds after which a silent host is missed, and the path clock at rest: 250 ms each. And a round of telemetry.
const HELD: u64 = 550_000;

static FOLD: LazyLock<Fold> = LazyLock::new(Fold::miura);

/// Runs a test with each seed, at the same time.
fn seeds(test: impl Fn(u64) + Sync) {
    LazyLock::force(&FOLD);
    image("foldpath-controller");
    thread::scope(|scope| {
        for seed in 0..SEEDS {
            let test = &test;
            scope.spawn(move || test(seed));
        }
    });
}

/// A board, and a host on a line without faults that has begun to greet.
fn world(seed: u64, persistence: Persistence) -> World<'static> {
    let mut world = World::new(&FOLD, AN386, Faults::default(), seed);
    world.greet(persistence);
    world
}

/// What a real part would have to offer.
#[test]
fn the_image_is_small() {
    let bytes = fs::read(image("foldpath-controller")).unwrap();
    let flash = size(&bytes, &[".vector_table", ".text", ".rodata", ".data"]);
    let ram = size(&bytes, &[".data", ".bss", ".uninit"]);
    assert!((1..=32 * 1024).contains(&flash), "{flash}");
    assert!((1..=8 * 1024).contains(&ram), "{ram}");
}

#[test]
fn a_whole_fold_comes_back_bit_for_bit() {
    seeds(|seed| {
        let machine = if seed == 0 { "mps2-an500" } else { AN386 };
        let mut world = World::new(&FOLD, machine, Faults::default(), seed);
        world.greet(Persistence::None);
        world.finish();
        // Every 20 ms of two seconds.
        assert!(world.sights > 90, "{}", world.sights);
    });
}
