//! Programs of the package, compiled with the library as it is shipped.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

pub(crate) const PACKAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../core/c");
const WARNINGS: [&str; 6] = [
    "-Wall",
    "-Wextra",
    "-Wpedantic",
    "-Wconversion",
    "-Wshadow",
    "-Werror",
];

/// The folder with `libnsrm.a` as it is shipped, and with the built-in model in each precision.
pub(crate) fn library() -> PathBuf {
    build(&["--features=int8"])
}

/// The same without a standard library, as for a controller without an operating system.
pub(crate) fn library_without_std() -> PathBuf {
    let target = concat!(env!("CARGO_TARGET_TMPDIR"), "/c-without-std");
    build(&[
        "--no-default-features",
        "--features=tabletop,int8,vision",
        "--target-dir",
        target,
    ])
}

fn build(arguments: &[&str]) -> PathBuf {
    let built = Command::new(env!("CARGO"))
        .args(["build", "--locked", "--profile=c", "--package=nsrm-c"])
        .args(arguments)
        .args(["--message-format=json", "--manifest-path"])
        .arg(format!("{PACKAGE}/Cargo.toml"))
        .output()
        .expect("cargo runs");
    assert!(built.status.success(), "{}", said(&built));
    let messages = String::from_utf8_lossy(&built.stdout);
    let file = messages.lines().find_map(|line| {
        let message: Value = serde_json::from_str(line).ok()?;
        let files = message["filenames"].as_array()?;
        let file = files.iter().filter_map(Value::as_str);
        file.map(PathBuf::from)
            .find(|file| file.ends_with("libnsrm.a"))
    });
    let file = file.expect("cargo tells where libnsrm.a is");
    file.parent().expect("a folder").to_owned()
}

pub(crate) fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Compiles a program of the package with the library, and these flags besides the warnings.
pub(crate) fn compile(source: &str, flags: &[&str]) -> PathBuf {
    compile_with(&library(), source, flags)
}

/// The same with the library in a folder.
pub(crate) fn compile_with(library: &Path, source: &str, flags: &[&str]) -> PathBuf {
    let source = Path::new(PACKAGE).join(source);
    let name = format!(
        "{}{}",
        source.file_stem().unwrap().to_string_lossy(),
        flags.concat().replace(['=', ','], "-")
    );
    let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let (compiler, standard) = if source.extension() == Some(OsStr::new("cpp")) {
        ("c++", "-std=c++17")
    } else {
        ("cc", "-std=c99")
    };
    let compiled = Command::new(compiler)
        .arg(standard)
        .args(["-O1", "-g", "-D_POSIX_C_SOURCE=200809L"])
        .args(WARNINGS)
        .args(flags)
        .args(["-I", &format!("{PACKAGE}/include"), "-I"])
        .arg(format!("{PACKAGE}/examples"))
        .arg(source)
        .arg(library.join("libnsrm.a"))
        .arg("-o")
        .arg(&program)
        .output()
        .expect("a C compiler");
    assert!(compiled.status.success(), "{}", said(&compiled));
    program
}

pub(crate) fn run(program: &Path, arguments: &[&str]) -> Output {
    Command::new(program)
        .args(arguments)
        .output()
        .expect("the program starts")
}
