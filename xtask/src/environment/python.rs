//! Finds a Python for the environment.

use std::path::Path;
use std::process::Command;

use anyhow::{Result, bail};

use crate::project::output_of;

/// In order of preference: PyBullet has a binary wheel for 3.11 only.
const CANDIDATES: [&str; 5] = [
    "python3.11",
    "python3.12",
    "python3.13",
    "python3",
    "python",
];

/// Supported versions: minor numbers of Python 3.
const MINOR_VERSIONS: std::ops::RangeInclusive<u32> = 11..=13;

/// An interpreter that was tried.
pub(super) struct Python {
    /// The name of the program.
    pub(super) program: String,
}

/// The first candidate with a supported version that can create environments.
pub(super) fn find() -> Result<Python> {
    let mut reasons = Vec::new();
    for program in CANDIDATES {
        match try_candidate(program) {
            Ok(minor) => {
                if minor != *MINOR_VERSIONS.start() {
                    eprintln!(
                        "setup: using Python 3.{minor}; PyBullet has a ready-made package for 3.11 \
                         only, and is compiled now, which takes some minutes"
                    );
                }
                return Ok(Python {
                    program: program.to_owned(),
                });
            }
            Err(Some(reason)) => reasons.push(format!("  {program}: {reason}")),
            Err(None) => {}
        }
    }
    if reasons.is_empty() {
        bail!(
            "no Python found; install Python 3.11 with venv and its headers \
             (Debian: apt-get install python3.11 python3.11-venv python3.11-dev)"
        );
    }
    bail!(
        "no Python from 3.{} to 3.{} with the modules venv and ensurepip found:\n{}\n\
         (Debian keeps them in a package of their own, e.g. python3.11-venv)",
        MINOR_VERSIONS.start(),
        MINOR_VERSIONS.end(),
        reasons.join("\n")
    );
}

/// The minor version, or why it cannot be used; `None` if the program does not exist.
fn try_candidate(program: &str) -> Result<u32, Option<String>> {
    let run = |code: &str| output_of(Command::new(program).args(["-c", code]));
    let Ok(version) = run("import sys; print(*sys.version_info[:2])") else {
        return Err(None);
    };
    let minor = parse_version(&version).ok_or_else(|| {
        Some(format!(
            "is Python {}, which is not supported",
            version.replace(' ', ".")
        ))
    })?;
    if run("import venv, ensurepip").is_err() {
        return Err(Some(format!(
            "has no venv or ensurepip (Debian: apt-get install python3.{minor}-venv)"
        )));
    }
    Ok(minor)
}

/// `"3 11"` → 11, if that version is supported.
fn parse_version(printed: &str) -> Option<u32> {
    let (major, minor) = printed.split_once(' ')?;
    let minor = minor.parse().ok()?;
    (major == "3" && MINOR_VERSIONS.contains(&minor)).then_some(minor)
}

/// What may be missing if packages cannot be installed, for an error message.
pub(super) fn build_hint(python: &Path) -> String {
    let works = |program: &str| output_of(Command::new(program).arg("--version")).is_ok();
    let headers = "import sysconfig, os, sys; \
                   sys.exit(not os.path.exists(sysconfig.get_path('include') + '/Python.h'))";
    let mut missing = Vec::new();
    if !works("cc") && !works("gcc") {
        missing.push("a C compiler (Debian: gcc)");
    }
    if !works("c++") && !works("g++") {
        missing.push("a C++ compiler (Debian: g++)");
    }
    if output_of(Command::new(python).args(["-c", headers])).is_err() {
        missing.push("Python's headers (Debian: python3-dev)");
    }
    if missing.is_empty() {
        "can the package index be reached?".to_owned()
    } else {
        format!(
            "packages without a ready-made build for this Python are compiled, and this machine \
             lacks {}",
            missing.join(", ")
        )
    }
}

#[cfg(test)]
mod tests {
    use super::parse_version;

    #[test]
    fn versions_outside_what_is_supported_are_refused() {
        assert_eq!(parse_version("3 11"), Some(11));
        assert_eq!(parse_version("3 13"), Some(13));
        assert_eq!(parse_version("3 10"), None);
        assert_eq!(parse_version("3 14"), None);
        assert_eq!(parse_version("2 11"), None);
        assert_eq!(parse_version(""), None);
    }
}
