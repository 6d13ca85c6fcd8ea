//! The command: its files, its messages and its exit codes.
#![cfg(feature = "command")]

mod common;

use std::path::Path;
use std::process::{Command, Output};

use common::ModelFile;

fn run(directory: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_nsrm-codegen"))
        .current_dir(directory)
        .args(arguments)
        .output()
        .expect("the command starts")
}

#[track_caller]
fn assert_refused(output: &Output, parts: &[&str]) {
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert_eq!(message.trim_end().lines().count(), 1, "{message}");
    for part in parts {
        assert!(message.contains(part), "{message:?} lacks {part:?}");
    }
}

fn with_model() -> tempfile::TempDir {
    let directory = tempfile::tempdir().expect("a directory");
    let bytes = ModelFile::flat().bytes();
    std::fs::write(directory.path().join("model.safetensors"), bytes).expect("a model file");
    directory
}

#[test]
fn writes_and_checks() {
    let directory = with_model();
    let write = ["model.safetensors", "--out", "shelf.rs", "--name", "SHELF"];
    let check = [&write[..], &["--check"]].concat();
    assert_refused(&run(directory.path(), &check), &["shelf.rs"]);
    assert!(run(directory.path(), &write).status.success());
    assert!(run(directory.path(), &check).status.success());
    let path = directory.path().join("shelf.rs");
    let source = std::fs::read_to_string(&path).expect("the source");
    assert_eq!(source, include_str!("snapshots/shelf.rs"));
    std::fs::write(&path, source + "\n").expect("a changed source");
    assert_refused(
        &run(directory.path(), &check),
        &["shelf.rs", "differs from what", "run again"],
    );
}

#[test]
fn reports() {
    let directory = with_model();
    let output = run(directory.path(), &["model.safetensors", "--report"]);
    assert!(output.status.success());
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(
        text.contains("language.forward.weight_hh") && text.contains("total"),
        "{text}"
    );
}

#[test]
fn refuses_with_one_line() {
    let directory = with_model();
    let missing = run(directory.path(), &["none.safetensors", "--out", "x.rs"]);
    assert_refused(&missing, &["none.safetensors"]);
    std::fs::write(directory.path().join("bad"), b"no model").expect("a file");
    assert_refused(
        &run(directory.path(), &["bad", "--out", "x.rs"]),
        &["bad", "safetensors"],
    );
    assert!(!directory.path().join("x.rs").exists());
    let named = run(
        directory.path(),
        &["model.safetensors", "--out", "x.rs", "--name", "a b"],
    );
    assert_refused(&named, &["a b", "capital letters"]);
}
