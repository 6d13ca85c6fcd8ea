//! The model that is built in, or one loaded at run time.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use nsrm_codegen::{ModelError, OwnedModel};
use nsrm_core::model::Model;
use nsrm_tabletop::{TABLETOP, TABLETOP_ABOUT};

/// A model that the planner can use, wherever it comes from.
#[derive(Debug)]
#[non_exhaustive]
pub enum AnyModel {
    /// The static arrays that are built in: the domain `tabletop`.
    Pretrained,
    /// Loaded from a model file.
    Loaded(Box<OwnedModel>),
}

/// Why a model file can't be used.
#[derive(Debug)]
#[non_exhaustive]
pub enum LoadError {
    /// It can't be read.
    Read {
        /// Its path.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// Its content is refused.
    Model {
        /// Its path.
        path: PathBuf,
        /// What is wrong with it.
        source: ModelError,
    },
}

impl fmt::Display for LoadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Read { path, source } => {
                write!(f, "{}: can't read the model file: {source}", path.display())
            }
            Self::Model { path, source } => write!(f, "{}: {source}", path.display()),
        }
    }
}

impl std::error::Error for LoadError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Read { source, .. } => Some(source),
            Self::Model { source, .. } => Some(source),
        }
    }
}

/// Reads, checks and folds a model file (safetensors).
///
/// # Errors
/// [`LoadError`] when it can't be read or its content is refused.
pub fn load_model(path: impl AsRef<Path>) -> Result<OwnedModel, LoadError> {
    let path = path.as_ref();
    let bytes = std::fs::read(path).map_err(|source| LoadError::Read {
        path: path.into(),
        source,
    })?;
    OwnedModel::from_bytes(&bytes).map_err(|source| LoadError::Model {
        path: path.into(),
        source,
    })
}

impl AnyModel {
    /// [`load_model`].
    ///
    /// # Errors
    /// [`LoadError`] when it can't be read or its content is refused.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, LoadError> {
        Ok(Self::Loaded(Box::new(load_model(path)?)))
    }

    /// The model as core reads it.
    pub fn model(&self) -> Model<'_> {
        match self {
            Self::Pretrained => TABLETOP,
            Self::Loaded(owned) => owned.as_model(),
        }
    }

    /// How it was trained and what it reached, as the trainer wrote it: an object
    /// with `training` and `metrics`.
    pub fn about(&self) -> serde_json::Value {
        match self {
            // Written by the code generator, which took it from JSON.
            Self::Pretrained => serde_json::from_str(TABLETOP_ABOUT).unwrap_or_default(),
            Self::Loaded(owned) => serde_json::json!({
                "training": owned.training(),
                "metrics": owned.metrics(),
            }),
        }
    }
}
