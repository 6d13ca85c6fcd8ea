//! The built-in model, or one loaded at run time.

use std::io;
use std::path::{Path, PathBuf};

use nsrm_codegen::{ModelError, OwnedModel};
use nsrm_core::model::Model;
use nsrm_core::nn::Precision;
use nsrm_tabletop::{TABLETOP, TABLETOP_ABOUT, TABLETOP_INT8};
use thiserror::Error;

/// A model for the planner, built in or loaded.
#[derive(Debug)]
#[non_exhaustive]
pub enum AnyModel {
    /// The built-in static arrays: the domain `tabletop`.
    Pretrained,
    /// The same with the weights of its large layers in whole numbers of eight bits.
    PretrainedInt8,
    /// Loaded from a model file.
    Loaded(Box<OwnedModel>),
}

/// Why a model file cannot be used.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LoadError {
    /// The file cannot be read.
    #[error("{}: cannot read the model file: {source}", .path.display())]
    Read {
        /// Its path.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// Its content is invalid.
    #[error("{}: {source}", .path.display())]
    Model {
        /// Its path.
        path: PathBuf,
        /// What is wrong with it.
        source: ModelError,
    },
}

/// Reads, checks and folds a model file (safetensors).
///
/// # Errors
/// [`LoadError`] if it cannot be read or its content is invalid.
pub fn load_model(path: impl AsRef<Path>) -> Result<OwnedModel, LoadError> {
    load_model_as(path, Precision::F32)
}

/// [`load_model`], and rounds its weights to a precision.
///
/// # Errors
/// As [`load_model`].
pub fn load_model_as(
    path: impl AsRef<Path>,
    precision: Precision,
) -> Result<OwnedModel, LoadError> {
    let path = path.as_ref();
    let bytes = std::fs::read(path).map_err(|source| LoadError::Read {
        path: path.into(),
        source,
    })?;
    OwnedModel::from_bytes_as(&bytes, precision).map_err(|source| LoadError::Model {
        path: path.into(),
        source,
    })
}

impl AnyModel {
    /// [`load_model`].
    ///
    /// # Errors
    /// [`LoadError`] if it cannot be read or its content is invalid.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, LoadError> {
        Self::load_as(path, Precision::F32)
    }

    /// [`load_model_as`].
    ///
    /// # Errors
    /// [`LoadError`] if it cannot be read or its content is invalid.
    pub fn load_as(path: impl AsRef<Path>, precision: Precision) -> Result<Self, LoadError> {
        Ok(Self::Loaded(Box::new(load_model_as(path, precision)?)))
    }

    /// The built-in model in a precision.
    pub fn pretrained(precision: Precision) -> Self {
        if precision == Precision::Int8 {
            Self::PretrainedInt8
        } else {
            Self::Pretrained
        }
    }

    /// The model as core reads it.
    pub fn model(&self) -> Model<'_> {
        match self {
            Self::Pretrained => TABLETOP,
            Self::PretrainedInt8 => TABLETOP_INT8,
            Self::Loaded(owned) => owned.as_model(),
        }
    }

    /// Its training and its metrics, as written by the trainer: an object with `training` and
    /// `metrics`.
    pub fn about(&self) -> serde_json::Value {
        match self {
            // Written by the code generator, which took it from JSON.
            Self::Pretrained | Self::PretrainedInt8 => {
                serde_json::from_str(TABLETOP_ABOUT).unwrap_or_default()
            }
            Self::Loaded(owned) => serde_json::json!({
                "training": owned.training(),
                "metrics": owned.metrics(),
            }),
        }
    }
}
