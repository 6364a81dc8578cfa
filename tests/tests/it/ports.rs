//! Do the ports to real parts link, and fit into them? They were never tried on hardware. The examples that they are sized
//! for are those that the commands make.

use std::fs;
use std::path::Path;

use foldpath::export::fold::motion_text;
use foldpath::export::traj::TrajFile;
use foldpath::planner::{PlanOptions, Symmetry};
use foldpath::read::read_pattern;
use foldpath_tests::{Planned, path_file};
use object::{Object, ObjectSymbol};

use crate::image::{IMAGES, image, port, size};

/// Links a port. Asserts that it needs at most so many bytes of flash and of RAM, and that its stack lies below its data, so
/// that an overflow is a fault.
fn links(package: &str, [most_flash, most_ram]: [u64; 2]) {
    let bytes = fs::read(port(package)).unwrap();
    let flash = size(&bytes, &[".vector_table", ".text", ".rodata", ".data"]);
    let ram = size(&bytes, &[".data", ".bss", ".uninit"]);
    println!("{package}: flash {flash} bytes, RAM without the stack {ram} bytes");
    assert!((10_000..=most_flash).contains(&flash), "{flash}");
    assert!((1000..=most_ram).contains(&ram), "{ram}");
    let elf = object::File::parse(&*bytes).unwrap();
    let address = |name: &str| {
        let mut symbols = elf.symbols().filter(|symbol| symbol.name() == Ok(name));
        symbols.next().expect("a symbol of cortex-m-rt").address()
    };
    assert!(address("_stack_start") <= address("__sdata"));
}

#[test]
fn the_port_to_an_stm32f411_links() {
    links("foldpath-port-stm32f4", [64 << 10, 16 << 10]);
}

#[test]
#[ignore = "builds embassy for a minute: `tests/run full` runs it"]
fn the_port_to_embassy_links() {
    links("foldpath-port-embassy-stm32f4", [80 << 10, 32 << 10]);
}

/// The table of PORTING.md.
#[test]
fn the_images_have_the_memory_that_their_sizes_need() {
    for name in &IMAGES[1..] {
        let bytes = fs::read(image(name)).unwrap();
        let flash = size(&bytes, &[".vector_table", ".text", ".rodata", ".data"]);
        let ram = size(&bytes, &[".data", ".bss", ".uninit"]);
        println!("{name}: flash {flash} bytes, RAM without the stack {ram} bytes");
    }
    let bytes = fs::read(image("foldpath-mps2")).unwrap();
    let ram = size(&bytes, &[".data", ".bss", ".uninit"]);
    let (groups, hinges, spokes, knots) = (256, 2048, 512, 32);
    // The bytes that PORTING.md gives for each.
    let expected = groups * (16 * knots + 120) + 4 * hinges + 20 * spokes + 2048;
    assert!(
        (expected * 9 / 10..=expected * 11 / 10).contains(&ram),
        "{ram} {expected}"
    );
}

#[test]
fn the_example_of_the_port_is_what_the_commands_make() {
    let folder =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../firmware-sim/boards/stm32f4/example");
    let options = PlanOptions::default().with(|it| {
        it.symmetry = Symmetry::Off;
        it.max_acceleration = Some(180_f64.to_radians());
    });
    let planned = Planned::of(read_pattern(&folder.join("vertex.fold")).unwrap(), &options);
    let path = path_file(&motion_text(&planned.motion())).unwrap();
    let bytes = TrajFile::of(&path, Path::new("vertex.path.fold"))
        .unwrap()
        .bytes;
    assert!(bytes == fs::read(folder.join("vertex.traj")).unwrap());
}
