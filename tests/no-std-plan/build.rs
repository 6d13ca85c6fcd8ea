//! No C library, no start-up code: the program begins at its own `_start`.
//! Link arguments stand here and not in RUSTFLAGS, which would build everything
//! else anew.

fn main() {
    for argument in ["-nostdlib", "-nostartfiles", "-static", "-no-pie"] {
        println!("cargo:rustc-link-arg-bins={argument}");
    }
    println!("cargo:rerun-if-changed=build.rs");
}
