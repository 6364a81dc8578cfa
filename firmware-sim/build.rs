//! Hands the linker the board's memory map, for the image only.

use std::path::PathBuf;
use std::{env, fs};

fn main() {
    println!("cargo::rerun-if-changed=memory.x");
    if env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    fs::copy("memory.x", out.join("memory.x")).expect("OUT_DIR is writable");
    // The names of a device's interrupts, of which the boards here have none.
    fs::write(out.join("device.x"), "").expect("OUT_DIR is writable");
    // For the images of this package alone: a search path would reach the images of other packages that use the library.
    for images in ["bins", "examples"] {
        println!("cargo::rustc-link-arg-{images}=-L{}", out.display());
        println!("cargo::rustc-link-arg-{images}=-Tlink.x");
    }
}
