//! The shared library's name for the loader.

fn main() {
    if std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|system| system == "linux") {
        println!("cargo:rustc-cdylib-link-arg=-Wl,-soname,libnsrm.so.0");
    }
    println!("cargo:rerun-if-changed=build.rs");
}
