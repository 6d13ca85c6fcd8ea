//! What builds and runs programs for Arm's Cortex-M: Rust's core library for the target, and QEMU.
//!
//! `rustup target add` installs the first, and a system's package `qemu-system-arm` the second. Where
//! one of them is missing, Debian's packages are unpacked into `target/tools/arm`, and nothing of the
//! system changes: a Rust compiler that comes with its sources, from which cargo builds core, and QEMU
//! with its libraries.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, Result, bail};

use crate::project::{Project, output_of, run_on_stderr, without_cargo_variables};

/// Compiler and sources of one version.
const COMPILER: [&str; 5] = [
    "libllvm22",
    "libstd-rust-web-1.96",
    "libstd-rust-web-dev",
    "rust-web-src",
    "rustc-web",
];
/// What disassembles programs.
const BINUTILS: [&str; 1] = ["binutils-arm-none-eabi"];
const OBJDUMP: &str = "arm-none-eabi-objdump";
/// QEMU, and those of its libraries that a system without it lacks.
const EMULATOR: [&str; 12] = [
    "libcapstone4",
    "libdaxctl1",
    "libfdt1",
    "libibverbs1",
    "libndctl6",
    "libnl-3-200",
    "libnl-route-3-200",
    "libpmem1",
    "librdmacm1",
    "libslirp0",
    "libvdeplug2",
    "qemu-system-arm",
];

/// Where the firmware is, in the checkout.
const FIRMWARE: &str = "tests/firmware/Cargo.toml";
const QEMU: &str = "qemu-system-arm";

/// The programs for Arm.
pub(crate) struct Tools {
    project: Project,
    /// Where Debian's packages are unpacked.
    unpacked: PathBuf,
}

impl Tools {
    pub(crate) fn new(project: &Project) -> Self {
        Self {
            project: project.clone(),
            unpacked: project.target().join("tools/arm"),
        }
    }

    /// Builds the firmware and returns its image.
    pub(crate) fn firmware(&self, target: &str, features: &[&str]) -> Result<PathBuf> {
        let folder = self.project.target().join("firmware");
        let mut cargo = Command::new("cargo");
        without_cargo_variables(&mut cargo)
            .args([
                "build",
                "--quiet",
                "--locked",
                "--release",
                "--manifest-path",
            ])
            .arg(self.project.path(FIRMWARE))
            .args(["--target", target, "--target-dir"])
            .arg(&folder)
            .arg(format!("--features={}", features.join(",")))
            // The first is for the machine that builds; the other would change what is measured.
            .env_remove("RUSTFLAGS")
            .env_remove("CARGO_ENCODED_RUSTFLAGS")
            // Cargo takes it for the one that is asked for by name.
            .env_remove("RUSTUP_TOOLCHAIN");
        if !has_target(target) {
            self.unpack(&COMPILER)?;
            let variable = target.to_uppercase().replace(['-', '.'], "_");
            cargo
                .args(["-Z", "build-std=core"])
                .env("RUSTC_BOOTSTRAP", "1")
                .env("RUSTC", self.unpacked.join("usr/bin/rustc"))
                .env("LD_LIBRARY_PATH", self.libraries())
                .env(format!("CARGO_TARGET_{variable}_LINKER"), linker()?);
        }
        run_on_stderr(&mut cargo)?;
        let image = folder.join(target).join("release/nsrm-firmware");
        let kept = folder.join(format!("{target}-{}.elf", features.join("-")));
        fs::copy(&image, &kept).with_context(|| format!("copying {}", image.display()))?;
        Ok(kept)
    }

    /// QEMU, and the environment that it needs.
    pub(crate) fn qemu(&self) -> Result<(PathBuf, Vec<(&'static str, OsString)>)> {
        if output_of(Command::new(QEMU).arg("--version")).is_ok() {
            return Ok((QEMU.into(), Vec::new()));
        }
        self.unpack(&EMULATOR)?;
        let environment = vec![("LD_LIBRARY_PATH", self.libraries())];
        Ok((self.unpacked.join("usr/bin").join(QEMU), environment))
    }

    /// What disassembles programs; needs no environment.
    pub(crate) fn objdump(&self) -> Result<PathBuf> {
        if output_of(Command::new(OBJDUMP).arg("--version")).is_ok() {
            return Ok(OBJDUMP.into());
        }
        self.unpack(&BINUTILS)?;
        Ok(self.unpacked.join("usr/bin").join(OBJDUMP))
    }

    fn libraries(&self) -> OsString {
        let mut folders = OsString::new();
        for folder in ["usr/lib/x86_64-linux-gnu", "lib/x86_64-linux-gnu"] {
            folders.push(self.unpacked.join(folder));
            folders.push(":");
        }
        folders
    }

    /// Downloads and unpacks packages, once.
    fn unpack(&self, packages: &[&str]) -> Result<()> {
        let name = packages.last().context("packages")?;
        let done = self.unpacked.join(format!("{name}.unpacked"));
        if done.exists() {
            return Ok(());
        }
        eprintln!("footprint: unpacking {} ...", packages.join(", "));
        let downloads = self.unpacked.join("packages");
        fs::create_dir_all(&downloads)
            .with_context(|| format!("making {}", downloads.display()))?;
        // Only root may; others have the lists of the last time.
        let _ = output_of(Command::new("apt-get").args(["--quiet", "update"]));
        let mut apt = Command::new("apt-get");
        apt.args(["--quiet", "download"]).args(packages);
        output_of(apt.current_dir(&downloads)).with_context(|| {
            format!(
                "downloading {name}; without Debian's packages install {QEMU}, and the target by \
                 rustup target add"
            )
        })?;
        for package in packages {
            let file = downloaded(&downloads, package)?;
            let mut dpkg = Command::new("dpkg");
            output_of(dpkg.arg("--extract").arg(&file).arg(&self.unpacked))?;
            fs::remove_file(&file).with_context(|| format!("removing {}", file.display()))?;
        }
        fs::write(&done, "").with_context(|| format!("writing {}", done.display()))
    }
}

/// The file of a package.
fn downloaded(folder: &Path, package: &str) -> Result<PathBuf> {
    let prefix = format!("{package}_");
    for file in fs::read_dir(folder).with_context(|| format!("reading {}", folder.display()))? {
        let file = file?;
        if file.file_name().to_string_lossy().starts_with(&prefix) {
            return Ok(file.path());
        }
    }
    bail!("apt-get has downloaded no {package}");
}

/// Whether `rustup target add` has installed it.
fn has_target(target: &str) -> bool {
    let mut rustc = Command::new("rustc");
    let folder = output_of(rustc.args(["--print", "target-libdir", "--target", target]));
    folder.is_ok_and(|folder| Path::new(folder.trim()).is_dir())
}

/// The linker that comes with rustc.
fn linker() -> Result<PathBuf> {
    let printed = |what| output_of(Command::new("rustc").args(["--print", what]));
    let sysroot = PathBuf::from(printed("sysroot")?.trim());
    let host = printed("host-tuple")?;
    Ok(sysroot.join(format!("lib/rustlib/{}/bin/rust-lld", host.trim())))
}
