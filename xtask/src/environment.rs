//! The project's own Python environment: `.venv` in the checkout.
//!
//! Each step (the environment itself, each set of requirements, the Python module)
//! leaves a stamp with the hash of its inputs, so that later runs only compare
//! hashes, and interrupted steps are repeated. A lock file keeps two commands from
//! changing it at once.

mod python;

use std::ffi::OsString;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result, bail};

use crate::project::{Project, output_of, run_on_stderr, without_cargo_variables};
use crate::stamp::{Inputs, Stamp};

/// The sources of the Python module.
const MODULE_SOURCES: [&str; 14] = [
    "Cargo.lock",
    "Cargo.toml",
    "core/Cargo.toml",
    "core/src",
    "weights-codegen/Cargo.toml",
    "weights-codegen/src",
    "weights-codegen/tabletop/Cargo.toml",
    "weights-codegen/tabletop/src",
    "std-shim/Cargo.toml",
    "std-shim/src",
    "std-shim/python/Cargo.toml",
    "std-shim/python/nsrm.pyi",
    "std-shim/python/pyproject.toml",
    "std-shim/python/src",
];

/// Commands of the harness that need only the demo's requirements.
const LIGHT_COMMANDS: [&str; 7] = [
    "calibration",
    "chaos",
    "demo",
    "episodes",
    "look",
    "robot",
    "world",
];

/// A set of requirements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Requirements {
    /// World, renderer, episodes, the build of the Python module.
    Demo,
    /// Recordings of the demo.
    Record,
    /// Learning and evaluation.
    Train,
    /// Lints, types and tests of the Python parts.
    Dev,
    /// The model in ONNX Runtime.
    Compare,
}

impl Requirements {
    /// The set and those that it depends on, in the order of installation.
    fn sets(self) -> &'static [Self] {
        match self {
            Self::Demo => &[Self::Demo],
            Self::Record => &[Self::Demo, Self::Record],
            Self::Train => &[Self::Demo, Self::Train],
            Self::Dev => &[Self::Demo, Self::Train, Self::Dev, Self::Record],
            Self::Compare => &[Self::Demo, Self::Train, Self::Compare],
        }
    }

    /// What a command of the harness needs; the first argument is its name.
    pub(crate) fn of_command(arguments: &[OsString]) -> Self {
        match arguments.first().and_then(|name| name.to_str()) {
            Some("onnx") => Self::Compare,
            Some(name) if !name.starts_with('-') && !LIGHT_COMMANDS.contains(&name) => Self::Train,
            _ if records(arguments) => Self::Record,
            _ => Self::Demo,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Demo => "demo",
            Self::Record => "record",
            Self::Train => "train",
            Self::Dev => "dev",
            Self::Compare => "compare",
        }
    }

    /// What is installed and about how long that takes, as a message.
    fn announcement(self) -> &'static str {
        match self {
            Self::Demo => {
                "installing the Python packages of world, camera and detector (about a minute)"
            }
            Self::Record => "installing the Python packages of recordings (a few seconds, 700 MB)",
            Self::Train => "installing the Python packages of learning (about a minute, 600 MB)",
            Self::Dev => "installing the Python packages of the checks (a few seconds)",
            Self::Compare => "installing ONNX Runtime (a few seconds, 160 MB)",
        }
    }
}

/// Whether a command writes a recording.
fn records(arguments: &[OsString]) -> bool {
    arguments
        .iter()
        .filter_map(|argument| argument.to_str())
        .take_while(|&argument| argument != "--")
        .any(|argument| argument == "--record" || argument.starts_with("--record="))
}

/// The environment of a checkout, made or not.
#[derive(Debug)]
pub(crate) struct Environment {
    project: Project,
    folder: PathBuf,
}

impl Environment {
    /// The environment of this checkout, created again if it does not work.
    pub(crate) fn open(project: Project) -> Result<Self> {
        let environment = Self {
            folder: project.path(".venv"),
            project,
        };
        environment.ensure_made()?;
        Ok(environment)
    }

    /// Its Python interpreter.
    pub(crate) fn python(&self) -> PathBuf {
        self.folder.join("bin/python")
    }

    /// Installs a set of requirements and those that it depends on, unless they are up to date.
    pub(crate) fn ensure(&self, wanted: Requirements) -> Result<()> {
        for set in wanted.sets() {
            let file = self
                .project
                .path(&format!("sim-harness/requirements/{}.txt", set.name()));
            let inputs = Inputs::default().path(&file)?.finish();
            self.once(set.name(), &inputs, set.announcement(), || {
                let mut pip = self.pip();
                pip.args(["install", "--quiet", "--require-hashes", "--requirement"]);
                run_on_stderr(pip.arg(&file)).with_context(|| {
                    format!(
                        "cannot install {}; {}",
                        file.display(),
                        python::build_hint(&self.python())
                    )
                })
            })?;
        }
        Ok(())
    }

    /// Builds and installs the Python module `nsrm` if its sources have changed.
    /// Needs the demo's requirements.
    pub(crate) fn ensure_module(&self) -> Result<()> {
        let mut inputs = Inputs::default();
        for source in MODULE_SOURCES {
            inputs.path(&self.project.path(source))?;
        }
        let announcement = "building the Python module of the Rust core (one to three minutes)";
        self.once("module", &inputs.finish(), announcement, || {
            let wheels = self.folder.join("wheels");
            remove_folder(&wheels)?;
            let mut maturin = Command::new(self.python());
            maturin
                .args(["-m", "maturin", "build", "--release", "--quiet"])
                .arg("--manifest-path")
                .arg(self.project.path("std-shim/python/Cargo.toml"))
                .arg("--interpreter")
                .arg(self.python())
                .arg("--out")
                .arg(&wheels);
            output_of(without_cargo_variables(&mut maturin)).context("building std-shim/python")?;
            let wheel = only_file(&wheels)?;
            let mut pip = self.pip();
            pip.args(["install", "--quiet", "--no-index", "--no-deps"]);
            run_on_stderr(pip.arg("--force-reinstall").arg(wheel))
        })
    }

    fn ensure_made(&self) -> Result<()> {
        let root = self.project.root().to_string_lossy().into_owned();
        // A moved checkout, or a removed Python, needs a new one.
        if !self.python().exists() {
            self.stamp("made").clear()?;
        }
        self.once(
            "made",
            &root,
            "creating the Python environment .venv (a few seconds)",
            || {
                let python = python::find()?;
                self.empty()?;
                let mut venv = Command::new(&python.program);
                run_on_stderr(venv.args(["-m", "venv"]).arg(&self.folder))
                    .with_context(|| format!("{} cannot create .venv", python.program))?;
                let packages = self.packages()?;
                let harness = self.project.path("sim-harness");
                fs::write(
                    packages.join("nsrm_harness.pth"),
                    format!("{}\n", harness.display()),
                )
                .context("adding sim-harness to .venv")
            },
        )
    }

    /// Runs a step if its stamp is out of date, one process at a time.
    fn once(
        &self,
        name: &str,
        inputs: &str,
        announcement: &str,
        work: impl FnOnce() -> Result<()>,
    ) -> Result<()> {
        let stamp = self.stamp(name);
        if stamp.holds(inputs) {
            return Ok(());
        }
        let _lock = self.lock()?;
        if stamp.holds(inputs) {
            return Ok(()); // Another process did it while we waited.
        }
        eprintln!("setup: {announcement} ...");
        let start = Instant::now();
        stamp.clear()?;
        work()?;
        stamp.write(inputs)?;
        eprintln!("setup: done in {:.0} s", start.elapsed().as_secs_f32());
        Ok(())
    }

    fn stamp(&self, name: &str) -> Stamp {
        Stamp::at(self.folder.join(format!("{name}.stamp")))
    }

    /// Held until the file is dropped or the process ends.
    fn lock(&self) -> Result<File> {
        fs::create_dir_all(&self.folder)
            .with_context(|| format!("making {}", self.folder.display()))?;
        let path = self.lock_path();
        let file = File::create(&path).with_context(|| format!("opening {}", path.display()))?;
        if file.try_lock().is_err() {
            eprintln!("setup: another command is changing .venv; waiting for it ...");
            file.lock()
                .with_context(|| format!("locking {}", path.display()))?;
        }
        Ok(file)
    }

    fn lock_path(&self) -> PathBuf {
        self.folder.join("lock")
    }

    /// Removes the remains of an earlier or interrupted set-up, except the lock.
    fn empty(&self) -> Result<()> {
        for entry in fs::read_dir(&self.folder).context("reading .venv")? {
            let path = entry?.path();
            if path == self.lock_path() {
                continue;
            }
            let is_folder = path.symlink_metadata().is_ok_and(|found| found.is_dir());
            let removed = if is_folder {
                fs::remove_dir_all(&path)
            } else {
                fs::remove_file(&path)
            };
            removed.with_context(|| format!("removing {}", path.display()))?;
        }
        Ok(())
    }

    /// The folder of installed packages.
    pub(crate) fn packages(&self) -> Result<PathBuf> {
        let question = "import sysconfig; print(sysconfig.get_path('purelib'))";
        output_of(Command::new(self.python()).args(["-c", question])).map(PathBuf::from)
    }

    fn pip(&self) -> Command {
        let mut pip = Command::new(self.python());
        pip.args(["-m", "pip", "--disable-pip-version-check", "--no-input"]);
        pip
    }
}

fn remove_folder(folder: &Path) -> Result<()> {
    match fs::remove_dir_all(folder) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(error).with_context(|| format!("removing {}", folder.display()))
        }
        _ => Ok(()),
    }
}

fn only_file(folder: &Path) -> Result<PathBuf> {
    let mut files = fs::read_dir(folder)
        .with_context(|| format!("reading {}", folder.display()))?
        .map(|entry| Ok(entry?.path()))
        .collect::<Result<Vec<_>>>()?;
    match (files.pop(), files.is_empty()) {
        (Some(file), true) => Ok(file),
        _ => bail!("expected one wheel in {}", folder.display()),
    }
}

#[cfg(test)]
mod tests {
    use super::Requirements;

    #[test]
    fn only_what_learns_needs_the_requirements_of_learning() {
        let of = |words: &[&str]| {
            let arguments: Vec<_> = words.iter().map(Into::into).collect();
            Requirements::of_command(&arguments)
        };
        assert_eq!(of(&["demo", "put it there"]), Requirements::Demo);
        assert_eq!(of(&["--help"]), Requirements::Demo);
        assert_eq!(of(&[]), Requirements::Demo);
        assert_eq!(of(&["train", "--quick"]), Requirements::Train);
        assert_eq!(of(&["train", "--record"]), Requirements::Train);
        assert_eq!(of(&["evaluate"]), Requirements::Train);
        assert_eq!(of(&["onnx", "--out", "a"]), Requirements::Compare);
    }

    #[test]
    fn only_recordings_and_the_checks_need_what_records() {
        let of = |words: &[&str]| {
            let arguments: Vec<_> = words.iter().map(Into::into).collect();
            Requirements::of_command(&arguments)
        };
        assert_eq!(of(&["demo", "--record", "a.rrd"]), Requirements::Record);
        assert_eq!(of(&["demo", "--record=a.rrd"]), Requirements::Record);
        assert_eq!(of(&["demo", "--recorded"]), Requirements::Demo);
        assert_eq!(of(&["demo", "--", "--record"]), Requirements::Demo);
        for set in [Requirements::Demo, Requirements::Train] {
            assert!(!set.sets().contains(&Requirements::Record));
        }
        for set in [Requirements::Record, Requirements::Dev] {
            assert_eq!(set.sets().last(), Some(&Requirements::Record));
        }
    }
}
