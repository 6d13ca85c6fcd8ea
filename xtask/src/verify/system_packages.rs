//! Packages of the system that the checks need, on machines that have `dpkg`.

use std::process::Command;

use anyhow::{Context, Result};

use crate::project::{output_of, run_on_stderr};

/// A Debian package, and what cannot be done without it.
struct SystemPackage {
    name: &'static str,
    without: &'static str,
}

const PACKAGES: [SystemPackage; 8] = [
    SystemPackage {
        name: "cmake",
        without: "the C library's installation is not checked",
    },
    SystemPackage {
        name: "gcc",
        without: "no program can be linked",
    },
    SystemPackage {
        name: "g++",
        without: "no new inputs are fuzzed",
    },
    SystemPackage {
        name: "iproute2",
        without: "the check hosts cannot run",
    },
    SystemPackage {
        name: "libegl1",
        without: "the GL renderer is not checked",
    },
    SystemPackage {
        name: "libgl1-mesa-dri",
        without: "the GL renderer is not checked",
    },
    SystemPackage {
        name: "pkg-config",
        without: "the C library's installation is not checked",
    },
    SystemPackage {
        name: "valgrind",
        without: "instructions are not counted, and the C library's memory is not checked",
    },
];

/// Installs missing packages, as root, if asked to or in CI; otherwise lists them.
pub(super) fn prepare(asked: bool) -> Result<()> {
    if output_of(Command::new("dpkg-query").arg("--version")).is_err() {
        if asked {
            eprintln!(
                "verify: --install works on Debian and its derivatives only; continuing without it"
            );
        }
        return Ok(());
    }
    let missing: Vec<_> = PACKAGES
        .iter()
        .filter(|package| !is_installed(package.name))
        .collect();
    if missing.is_empty() {
        return Ok(());
    }
    let names: Vec<_> = missing.iter().map(|package| package.name).collect();
    let in_ci = std::env::var_os("CI").is_some_and(|value| value == "true");
    if (asked || in_ci) && is_root() {
        eprintln!("verify: installing {} ...", names.join(", "));
        return install(&names);
    }
    for package in missing {
        eprintln!(
            "verify: the system package {} is missing; without it {}",
            package.name, package.without
        );
    }
    eprintln!(
        "verify: to install them, run as root: cargo verify --install, or: apt-get install {}",
        names.join(" ")
    );
    Ok(())
}

fn is_installed(name: &str) -> bool {
    let mut query = Command::new("dpkg-query");
    query.args(["--show", "--showformat", "${db:Status-Status}", name]);
    output_of(&mut query).is_ok_and(|status| status == "installed")
}

fn is_root() -> bool {
    output_of(Command::new("id").arg("-u")).is_ok_and(|user| user == "0")
}

fn install(names: &[&str]) -> Result<()> {
    let apt = || {
        let mut apt = Command::new("apt-get");
        apt.env("DEBIAN_FRONTEND", "noninteractive").arg("--quiet");
        apt
    };
    run_on_stderr(apt().arg("update")).context("updating the list of packages")?;
    let mut command = apt();
    command.args(["install", "--yes", "--no-install-recommends"]);
    run_on_stderr(command.args(names)).with_context(|| format!("installing {}", names.join(", ")))
}
