//! Runs the committed corpora of the fuzz targets, on any toolchain, so that no fixed fault comes
//! back.

use std::fs;
use std::path::{Path, PathBuf};

use nsrm_tests::fuzz::{TARGETS, Target, seeds};

const FUZZ: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/fuzz");

fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap_or_else(|error| panic!("{folder:?}: {error}"));
    let mut files: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

fn run_on_corpus(target: &Target) {
    let files = files(&Path::new(FUZZ).join("corpus").join(target.name));
    assert!(!files.is_empty(), "{} has no corpus", target.name);
    for file in files {
        // Printed if the test fails.
        println!("{}", file.display());
        (target.run)(&fs::read(&file).unwrap());
    }
}

#[test]
fn no_committed_input_breaks_anything() {
    for target in &TARGETS {
        run_on_corpus(target);
    }
}

#[test]
fn no_seed_breaks_anything() {
    for target in &TARGETS {
        let seeds = seeds::of(target.name);
        assert!(!seeds.is_empty(), "{} has no seeds", target.name);
        for seed in seeds {
            (target.run)(&seed);
        }
    }
}

#[test]
fn every_target_has_a_program_and_a_corpus_and_nothing_else_has() {
    let mut names = TARGETS.map(|target| target.name.to_owned()).to_vec();
    names.sort();
    let stems = |folder: &str| {
        let files = files(&Path::new(FUZZ).join(folder)).into_iter();
        let stems = files.map(|file| file.file_stem().unwrap().to_str().unwrap().to_owned());
        stems.collect::<Vec<_>>()
    };
    assert_eq!(stems("fuzz_targets"), names);
    assert_eq!(stems("corpus"), names);
    for name in stems("dictionaries") {
        assert!(names.contains(&name), "{name}");
    }
}
