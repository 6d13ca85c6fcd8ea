//! Programs that checks need beside cargo, installed into the target folder.

use std::path::PathBuf;
use std::process::Command;

use super::context::Context;
use super::step::Step;
use crate::project::output_of;

/// A program from the registry.
pub(super) struct Tool {
    /// The package that it is in.
    pub(super) package: &'static str,
    pub(super) program: &'static str,
    pub(super) version: &'static str,
}

impl Tool {
    /// Where it lies, and the step that puts it there, unless it does already.
    pub(super) fn at_hand(&self, context: &Context) -> (PathBuf, Option<Step>) {
        let tools = context.project().target().join("tools");
        let program = tools.join("bin").join(self.program);
        let told = output_of(Command::new(&program).arg("--version"));
        if told.is_ok_and(|told| told.ends_with(&format!(" {}", self.version))) {
            return (program, None);
        }
        let version = format!("--version={}", self.version);
        // Neither optimised nor with what a debugger reads, which is quicker to build.
        let install = ["install", self.package, "--debug", "--locked", "--force"];
        let step = Step::cargo(&install)
            .arguments(&[&version, "--root"])
            .argument(tools)
            .with("CARGO_PROFILE_DEV_DEBUG", "0");
        (program, Some(step))
    }
}
