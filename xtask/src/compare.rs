//! `cargo compare`: times our inference and that of other runtimes on the same weights.
//!
//! The contenders and their driver are in `tests/compare`, a workspace of its own: nothing else
//! downloads or builds the rivals. Each is built by itself, since cargo gives all that it builds at
//! once the same features.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use anyhow::{Context as _, Result, bail};

use crate::BAD_INPUT;
use crate::environment::{Environment, Requirements};
use crate::project::{Project, run_on_stderr, without_cargo_variables};

const HELP: &str = "\
usage: cargo compare [--quick] [--only NAME,...] [--out FOLDER]

Times our inference and that of other runtimes on the same weights and on one core, and writes
compare.csv, compare.png and README.md into FOLDER. The first run builds the other runtimes, which takes
up to an hour and 1.5 GB; nothing else should run while times are taken.

  --quick       take fewer times, within three minutes; p99.99 is then the longest time
  --only NAMES  compare nsrm with these only: empty, nsrm-plain, onnxruntime, tract, candle,
                onnxruntime-python, jax
  --out FOLDER  where to write; without it docs/performance, and nothing with --quick or --only";

/// Where results belong.
const RESULTS: &str = "docs/performance";
const MODEL: &str = "weights-codegen/tabletop/tabletop.safetensors";

/// The contenders that are Rust programs, with the feature of each.
const PROGRAMS: [(&str, Option<&str>); 6] = [
    ("empty", None),
    ("nsrm-plain", None),
    (OURS, Some("vectors")),
    ("onnxruntime", Some("onnxruntime")),
    ("tract", Some("tract")),
    ("candle", Some("candle")),
];
/// Those in Python.
const MODULES: [&str; 2] = ["onnxruntime-python", "jax"];
/// The contender that always takes part.
const OURS: &str = "nsrm";

/// The command line.
#[derive(Debug, Default, PartialEq, Eq)]
struct Arguments {
    quick: bool,
    help: bool,
    /// Empty for all.
    only: Vec<String>,
    out: Option<PathBuf>,
}

impl Arguments {
    fn parse(words: &[OsString]) -> Result<Self> {
        let mut arguments = Self::default();
        let mut words = words.iter();
        while let Some(word) = words.next() {
            let text = word.to_string_lossy();
            let (option, value) = match text.split_once('=') {
                Some((option, value)) => (option, Some(OsString::from(value))),
                None => (&*text, None),
            };
            match (option, &value) {
                ("--quick", None) => arguments.quick = true,
                ("--help" | "-h", None) => arguments.help = true,
                ("--out", _) => {
                    let folder = value.or_else(|| words.next().cloned());
                    let folder = folder.context("--out needs a folder")?;
                    arguments.out = Some(folder.into());
                }
                ("--only", _) => {
                    let names = value.or_else(|| words.next().cloned());
                    let names = names.context("--only needs names, separated by commas")?;
                    for name in names.to_string_lossy().split(',') {
                        arguments.add(name)?;
                    }
                }
                _ => bail!("unknown argument {word:?}: see cargo compare --help"),
            }
        }
        Ok(arguments)
    }

    fn add(&mut self, name: &str) -> Result<()> {
        let programs = PROGRAMS.iter().map(|(name, _)| name);
        if !programs.chain(&MODULES).any(|known| *known == name) {
            bail!("unknown contender {name:?}: see cargo compare --help");
        }
        self.only.push(name.to_owned());
        Ok(())
    }

    fn wants(&self, name: &str) -> bool {
        name == OURS || self.only.is_empty() || self.only.iter().any(|wanted| wanted == name)
    }

    /// Where results go, if anywhere.
    fn folder(&self, project: &Project) -> Option<PathBuf> {
        let whole = !self.quick && self.only.is_empty();
        let default = whole.then(|| project.path(RESULTS));
        self.out.clone().or(default)
    }
}

/// Builds, exports and compares.
pub(crate) fn run(words: &[OsString]) -> Result<ExitCode> {
    let arguments = match Arguments::parse(words) {
        Ok(arguments) => arguments,
        Err(error) => {
            eprintln!("error: {error}");
            return Ok(ExitCode::from(BAD_INPUT));
        }
    };
    if arguments.help {
        println!("{HELP}");
        return Ok(ExitCode::SUCCESS);
    }
    let project = Project::find()?;
    let environment = Environment::open(project.clone())?;
    environment.ensure(Requirements::Compare)?;
    environment.ensure_module()?;
    let library = library(&environment.packages()?)?;
    let target = project.target().join("compare");
    let programs = target.join("release");
    build(&project, &target, "nsrm-compare", None)?;
    for (name, feature) in PROGRAMS {
        if arguments.wants(name) {
            build(&project, &target, &format!("contender-{name}"), feature)?;
        }
    }

    // What all contenders read.
    let files = target.join("files");
    let driver = programs.join("nsrm-compare");
    run_on_stderr(Command::new(&driver).arg("inputs").arg(&files))?;
    let model = project.path(MODEL);
    fs::copy(&model, files.join("model.safetensors"))
        .with_context(|| format!("copying {} to {}", model.display(), files.display()))?;
    eprintln!("compare: exporting the model as ONNX graphs and checking them ...");
    let mut export = Command::new(environment.python());
    export.args(["-m", "nsrm_harness.cli", "onnx", "--model"]);
    run_on_stderr(export.arg(&model).arg("--out").arg(&files))?;

    let mut measure = Command::new(&driver);
    measure.arg("measure").arg("--folder").arg(&files);
    measure.arg("--programs").arg(&programs);
    measure.arg("--python").arg(environment.python());
    measure.arg("--library").arg(library);
    if arguments.quick {
        measure.arg("--quick");
    }
    if !arguments.only.is_empty() {
        measure.arg("--only").arg(arguments.only.join(","));
    }
    if let Some(out) = arguments.folder(&project) {
        measure.arg("--out").arg(out);
    }
    let status = measure
        .status()
        .with_context(|| format!("cannot start {}", driver.display()))?;
    Ok(if status.success() {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

/// Builds a program of `tests/compare`.
fn build(project: &Project, target: &Path, program: &str, feature: Option<&str>) -> Result<()> {
    eprintln!("compare: building {program} ...");
    let mut cargo = Command::new("cargo");
    // Not `--locked`: the lock file has the version of our own model, which changes with it.
    cargo.args(["build", "--release", "--bin", program]);
    if let Some(feature) = feature {
        cargo.args(["--features", feature]);
    }
    cargo.arg("--target-dir").arg(target);
    cargo.current_dir(project.path("tests/compare"));
    // As a user's plain `cargo build --release` does it.
    cargo.env_remove("RUSTFLAGS");
    cargo.env_remove("CARGO_ENCODED_RUSTFLAGS");
    run_on_stderr(without_cargo_variables(&mut cargo)).with_context(|| {
        format!("cannot build {program} in tests/compare; --only compares with fewer contenders")
    })
}

/// ONNX Runtime's shared library in the folder of installed packages.
fn library(packages: &Path) -> Result<PathBuf> {
    let folder = packages.join("onnxruntime/capi");
    let entries = fs::read_dir(&folder).with_context(|| format!("reading {}", folder.display()))?;
    for entry in entries {
        let entry = entry?;
        let name = entry.file_name();
        if name.to_string_lossy().starts_with("libonnxruntime.so.") {
            return Ok(entry.path());
        }
    }
    bail!(
        "{} has no libonnxruntime.so: cargo compare needs Linux; there, remove the folder .venv and \
         try again",
        folder.display()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(words: &[&str]) -> Result<Arguments> {
        let words: Vec<OsString> = words.iter().map(Into::into).collect();
        Arguments::parse(&words)
    }

    #[test]
    fn options_are_read_in_both_forms() {
        let both = [
            parse(&["--quick", "--out", "a/b", "--only", "jax,tract"]).unwrap(),
            parse(&["--out=a/b", "--only=jax", "--only=tract", "--quick"]).unwrap(),
        ];
        for arguments in both {
            assert!(arguments.quick);
            assert_eq!(arguments.out.as_deref(), Some(Path::new("a/b")));
            let wanted = ["nsrm", "jax", "tract", "candle"].map(|name| arguments.wants(name));
            assert_eq!(wanted, [true, true, true, false]);
        }
    }

    #[test]
    fn invalid_arguments_are_named() {
        for (words, expected) in [
            (&["--fast"][..], "--fast"),
            (&["--out"], "needs a folder"),
            (&["--only", "jax,torch"], "\"torch\""),
            (&["--quick=yes"], "--quick=yes"),
        ] {
            let message = parse(words).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
    }

    #[test]
    fn only_a_whole_comparison_replaces_the_committed_results() {
        let project = Project::find().unwrap();
        let folder = |words: &[&str]| parse(words).unwrap().folder(&project);
        assert_eq!(folder(&[]), Some(project.path("docs/performance")));
        assert_eq!(folder(&["--quick"]), None);
        assert_eq!(folder(&["--only", "jax"]), None);
        assert_eq!(folder(&["--quick", "--out", "a"]), Some("a".into()));
    }
}
