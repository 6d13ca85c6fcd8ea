//! The header is what the crate says, and compilers take it as C and as C++ without a warning.

use std::path::Path;
use std::process::Command;

#[path = "../examples/header.rs"]
#[allow(dead_code)]
mod generator;

const PACKAGE: &str = env!("CARGO_MANIFEST_DIR");

#[test]
fn the_committed_header_is_what_is_written_from_the_crate() {
    let committed = std::fs::read_to_string(Path::new(PACKAGE).join(generator::FILE)).unwrap();
    let expected = generator::header().unwrap();
    assert!(
        committed == expected,
        "{}: write it again with cargo run -p nsrm-c --example header",
        generator::FILE
    );
}

#[test]
fn compilers_give_no_warning() {
    for (language, standard, header) in [
        ("c", "c99", "nsrm.h"),
        ("c", "c11", "nsrm.h"),
        ("c", "c17", "nsrm.h"),
        ("c++", "c++11", "nsrm.h"),
        ("c++", "c++17", "nsrm.hpp"),
        ("c++", "c++20", "nsrm.hpp"),
    ] {
        let compiled = Command::new("cc")
            .args(["-x", language])
            .arg(format!("-std={standard}"))
            .args(["-Wall", "-Wextra", "-Wpedantic", "-Wconversion"])
            .args(["-Werror", "-fno-exceptions", "-fsyntax-only"])
            .arg(Path::new(PACKAGE).join("include").join(header))
            .output()
            .expect("a C compiler");
        let said = String::from_utf8_lossy(&compiled.stderr);
        assert!(compiled.status.success(), "{header}, {standard}: {said}");
    }
}
