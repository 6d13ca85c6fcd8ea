//! The messages lie in memory as the committed table says, in C too, and their type
//! names carry the hash of it.

use std::path::Path;
use std::process::Command;

use nsrm_ipc::bindings::{MESSAGES, files};

#[test]
fn every_type_name_carries_the_hash_of_its_layout() {
    let wrong: Vec<_> = MESSAGES
        .iter()
        .map(|message| {
            let (name, hash) = (message.name, message.layout_hash);
            (message.type_name, format!("nsrm.v1.{name}.{hash:016x}"))
        })
        .filter(|(written, expected)| written != expected)
        .collect();
    assert!(wrong.is_empty(), "change these type names: {wrong:#?}");
}

#[test]
fn the_committed_bindings_are_what_is_written_from_the_structs() {
    for (file, expected) in files() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
        let committed = std::fs::read_to_string(&path).unwrap();
        assert!(
            committed == expected,
            "{file}: rewrite it with cargo run -p nsrm-ipc --bin nsrm-bindings"
        );
    }
}

/// The header asserts size, alignment and every offset.
#[test]
fn c_and_cpp_lay_the_messages_out_in_the_same_way() {
    let header = concat!(env!("CARGO_MANIFEST_DIR"), "/include/nsrm_messages.h");
    for (language, standard) in [("c", "-std=c11"), ("c++", "-std=c++11")] {
        let compiled = Command::new("cc")
            .args([
                "-x",
                language,
                standard,
                "-Wall",
                "-Wextra",
                "-Werror",
                "-fsyntax-only",
            ])
            .arg(header)
            .output()
            .expect("a C compiler");
        let said = String::from_utf8_lossy(&compiled.stderr);
        assert!(compiled.status.success(), "{language}: {said}");
    }
}
