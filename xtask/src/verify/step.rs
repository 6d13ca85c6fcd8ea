//! One command of a check.

use std::env;
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::Command;

use super::count::Runner;

/// A command that a check runs in the root of the checkout.
pub(super) struct Step {
    pub(super) program: PathBuf,
    pub(super) arguments: Vec<OsString>,
    pub(super) variables: Vec<(&'static str, OsString)>,
    /// The test runner, if it runs tests.
    pub(super) tests: Option<Runner>,
    /// Whether it can run in parallel with adjacent steps of this kind.
    pub(super) beside: bool,
}

impl Step {
    pub(super) fn new(program: impl Into<PathBuf>, arguments: &[&str]) -> Self {
        Self {
            program: program.into(),
            arguments: arguments.iter().map(Into::into).collect(),
            variables: Vec::new(),
            tests: None,
            beside: false,
        }
    }

    pub(super) fn cargo(arguments: &[&str]) -> Self {
        Self::new("cargo", arguments)
    }

    /// Tests of the Rust packages; `chosen` says which of them are built. All packages are always
    /// selected: for each other selection, cargo would build the dependencies again, with the
    /// features of that selection.
    pub(super) fn rust_tests(chosen: &[&str]) -> Self {
        Self::cargo(&["test", "--locked", "--workspace", "--no-fail-fast"])
            .arguments(chosen)
            .counting(Runner::Cargo)
    }

    /// Appends an argument.
    pub(super) fn argument(mut self, argument: impl Into<OsString>) -> Self {
        self.arguments.push(argument.into());
        self
    }

    pub(super) fn arguments(mut self, arguments: &[&str]) -> Self {
        self.arguments.extend(arguments.iter().map(Into::into));
        self
    }

    pub(super) fn beside_others(mut self) -> Self {
        self.beside = true;
        self
    }

    pub(super) fn counting(mut self, runner: Runner) -> Self {
        self.tests = Some(runner);
        self
    }

    /// Sets the target folder; for packages outside the workspace, which would otherwise build
    /// into the source tree.
    pub(super) fn building_in(mut self, folder: PathBuf) -> Self {
        self.arguments.splice(
            1..1,
            [OsString::from("--target-dir"), folder.into_os_string()],
        );
        self
    }

    /// Builds with the workspace's profile, or what the environment has in its place, for packages that
    /// do not inherit it: their dependencies are then built already.
    pub(super) fn with_workspace_profile(self) -> Self {
        let names = [
            "CARGO_PROFILE_DEV_DEBUG",
            "CARGO_PROFILE_DEV_BUILD_OVERRIDE_DEBUG",
        ];
        names.into_iter().fold(self, |step, name| {
            let lines = env::var_os(name).unwrap_or_else(|| "line-tables-only".into());
            step.with(name, lines)
        })
    }

    /// Sets an environment variable, in place of what it was set to before.
    pub(super) fn with(mut self, name: &'static str, value: impl Into<OsString>) -> Self {
        self.variables.retain(|(other, _)| *other != name);
        self.variables.push((name, value.into()));
        self
    }

    /// The command, to be run.
    pub(super) fn command(&self) -> Command {
        let mut command = Command::new(&self.program);
        let variables = self.variables.iter().map(|(name, value)| (name, value));
        command.args(&self.arguments).envs(variables);
        command
    }

    /// The command as typed in a shell.
    pub(super) fn shown(&self) -> String {
        let mut text = String::new();
        for (name, value) in &self.variables {
            text += &format!("{name}={value:?} ");
        }
        text += &self.program.to_string_lossy();
        for argument in &self.arguments {
            text += " ";
            text += &argument.to_string_lossy();
        }
        text
    }
}
