//! The linker's script, and where memory is on the boards.

use std::path::PathBuf;

fn main() -> std::io::Result<()> {
    let out = PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo sets it"));
    // Not in the package's own folder, where the linker looks first.
    let target = std::env::var("TARGET").unwrap_or_default();
    let memory = if target.starts_with("thumbv8m") {
        "memory/an505.x"
    } else {
        "memory/mps2.x"
    };
    std::fs::copy(memory, out.join("memory.x"))?;
    println!("cargo:rustc-link-search={}", out.display());
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    println!("cargo:rerun-if-changed=memory");
    println!("cargo:rerun-if-changed=build.rs");
    Ok(())
}
