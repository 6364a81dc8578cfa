//! The controller's images, built for their own target.

pub(crate) mod board;
pub(crate) mod path;
pub(crate) mod rig;
pub(crate) mod world;

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use object::{Object, ObjectSection, ObjectSymbol};

const TARGET: &str = "thumbv7em-none-eabihf";
/// Seconds after which `timeout` ends the emulator, even if this process is gone.
pub(crate) const TIME_LIMIT: &str = "60";

/// Name of the image that computes and prints, an example.
pub(crate) const PROBE: &str = "examples/probe";

/// Arguments of cargo for all images of the simulated controller.
const SIMULATED: [&str; 7] = [
    "--package",
    "foldpath-firmware-sim",
    "--bins",
    "--example",
    "probe",
    "--example",
    "servo_buses",
];

/// Builds the image of this name as for a real board, and returns its path.
pub(crate) fn image(name: &str) -> PathBuf {
    build("fw", &[]).join(name)
}

/// Builds the image of a port, which has the name of its package, and returns its path.
pub(crate) fn port(package: &str) -> PathBuf {
    let manifest = "../firmware-sim/boards/Cargo.toml";
    let port = ["--manifest-path", manifest, "--package", package];
    build_package(&port, "fw", &[]).join(package)
}

/// Builds the images with `settings` in the environment, and returns their folder.
pub(crate) fn build(directory: &str, settings: &[(&str, &str)]) -> PathBuf {
    build_package(&SIMULATED, directory, settings)
}

/// Builds the images of the package that the arguments name. The target directory is another one, because the outer cargo
/// may hold the lock of its own; ports and other images share it, and with it the libraries that both need.
fn build_package(package: &[&str], directory: &str, settings: &[(&str, &str)]) -> PathBuf {
    let parent = Path::new(env!("CARGO_TARGET_TMPDIR")).join("..");
    let target_dir = parent.join(directory);
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["build", "--locked"]);
    cargo.args(package);
    cargo.args(["--profile", "firmware", "--target", TARGET]);
    cargo.arg("--target-dir").arg(&target_dir);
    // Builds with other settings share the parts on which settings have no effect, such as macros that run on the host.
    cargo.env("CARGO_BUILD_BUILD_DIR", parent.join("fw-parts"));
    cargo.current_dir(env!("CARGO_MANIFEST_DIR"));
    cargo.envs(settings.iter().copied());
    for meant_for_the_host in [
        "CARGO_BUILD_TARGET",
        "CARGO_ENCODED_RUSTFLAGS",
        "RUSTC_WRAPPER",
        "RUSTFLAGS",
    ] {
        cargo.env_remove(meant_for_the_host);
    }
    let build = cargo.output().expect("cargo starts");
    assert!(
        build.status.success(),
        "the image does not build; `tests/run` installs what it needs\n{}",
        String::from_utf8_lossy(&build.stderr)
    );
    target_dir.join(TARGET).join("firmware")
}

/// Holds the emulator until it is dropped: tests in which time passes on a board and on its host run one at a time, also
/// across processes. Boards that share a core would lose their hosts.
pub(crate) fn turn() -> File {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("boards.lock");
    let file = File::create(path).unwrap();
    file.lock().unwrap();
    file
}

/// Returns the output of the probe, which counts instructions. Panics unless the emulator runs it to a successful end.
pub(crate) fn board_output() -> String {
    output_of(&image(PROBE))
}

/// Returns the output of this build of the probe, as above.
pub(crate) fn output_of(probe: &Path) -> String {
    let run = Command::new("timeout")
        .args(["--foreground", "--kill-after=5", TIME_LIMIT])
        .args(["qemu-system-arm", "-machine", "mps2-an386"])
        .args(["-icount", "shift=10"])
        .args(["-display", "none", "-monitor", "none", "-serial", "none"])
        .args(["-semihosting-config", "enable=on,target=native"])
        .arg("-kernel")
        .arg(probe)
        .stdin(Stdio::null())
        .output()
        .expect("timeout, of coreutils, starts");
    let output = String::from_utf8_lossy(&run.stdout).into_owned();
    let problem = match run.status.code() {
        Some(0) => return output,
        Some(124 | 137) => "the image did not end in time",
        Some(127) => "qemu-system-arm is missing: `tests/run` installs it",
        _ => "the image failed",
    };
    let errors = String::from_utf8_lossy(&run.stderr);
    panic!("{problem} ({})\n{output}{errors}", run.status);
}

/// Returns the names in the symbol table of `image` that contain one of `parts`.
pub(crate) fn symbols(image: &[u8], parts: &[&str]) -> Vec<String> {
    let elf = object::File::parse(image).unwrap();
    let names: Vec<_> = elf.symbols().filter_map(|s| s.name().ok()).collect();
    for present in ["Reset", "foldpath_core", "atanf"] {
        let found = names.iter().any(|name| name.contains(present));
        assert!(found, "no {present}: is this the symbol table?");
    }
    let named = |name: &&str| parts.iter().any(|part| name.contains(part));
    names.into_iter().filter(named).map(String::from).collect()
}

/// Names of the images.
pub(crate) const IMAGES: [&str; 4] = [
    PROBE,
    "examples/servo_buses",
    "foldpath-mps2",
    "foldpath-mps2-small",
];

/// Returns the address of the small image's function or variable whose name contains all `parts`.
pub(crate) fn address(parts: &[&str]) -> u64 {
    address_in("foldpath-mps2-small", parts)
}

/// Returns the address of the function or variable of this image whose name contains all `parts`.
pub(crate) fn address_in(name: &str, parts: &[&str]) -> u64 {
    let bytes = std::fs::read(image(name)).unwrap();
    let elf = object::File::parse(&*bytes).unwrap();
    let named = |name: &str| parts.iter().all(|part| name.contains(part));
    let mut symbols = elf.symbols().filter(|s| s.name().is_ok_and(named));
    let symbol = symbols.next().expect("a symbol of that name");
    assert!(symbols.next().is_none(), "two of {parts:?}");
    // The lowest bit only marks Thumb instructions.
    symbol.address() & !1
}

/// Returns the size of these sections of `image`, bytes.
pub(crate) fn size(image: &[u8], names: &[&str]) -> u64 {
    let elf = object::File::parse(image).unwrap();
    let sections = names.iter().filter_map(|name| elf.section_by_name(name));
    sections.map(|section| section.size()).sum()
}
