//! What the checks work on.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use anyhow::Result;

use crate::environment::{Environment, Requirements};
use crate::project::Project;

/// The checkout, its environment, and where logs go.
pub(super) struct Context {
    project: Project,
    logs: PathBuf,
    /// Held while the environment is made: two checks may need it at once.
    environment: Mutex<()>,
}

impl Context {
    pub(super) fn new(project: Project, logs: PathBuf) -> Self {
        Self {
            project,
            logs,
            environment: Mutex::new(()),
        }
    }

    pub(super) fn project(&self) -> &Project {
        &self.project
    }

    /// The interpreter of the project's environment, with everything that the checks need.
    pub(super) fn python(&self) -> Result<PathBuf> {
        let _one = self
            .environment
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        let environment = Environment::open(self.project.clone())?;
        environment.ensure(Requirements::Dev)?;
        environment.ensure_module()?;
        Ok(environment.python())
    }

    /// The folder of the logs.
    pub(super) fn logs(&self) -> &Path {
        &self.logs
    }
}
