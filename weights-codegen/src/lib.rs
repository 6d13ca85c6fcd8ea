//! Converts a trained model file to the model that `nsrm_core` reads.
//!
//! A model file (safetensors, written by the trainer) becomes an [`OwnedModel`]: its SHA-256 is
//! verified, every tensor's name, shape, element type and finiteness checked, the metadata checked
//! against the domain in the file, matrices transposed, and products that depend only on the model
//! folded. From there
//!
//! * [`OwnedModel::as_model`] borrows it as the type that the static arrays have;
//! * [`rust_source`] generates those static arrays, for `build.rs` or a commit;
//! * [`memory_report`] lists their read-only memory.
//!
//! The command `nsrm-codegen` does the same from a shell.
//!
//! ```no_run
//! // build.rs
//! let bytes = std::fs::read("model.safetensors")?;
//! let model = nsrm_codegen::OwnedModel::from_bytes(&bytes)?;
//! let source = nsrm_codegen::rust_source(&model, &nsrm_codegen::Options::new("KITCHEN")?);
//! let out = std::path::PathBuf::from(std::env::var("OUT_DIR")?);
//! std::fs::write(out.join("kitchen.rs"), source)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

mod domain;
mod emit;
mod error;
mod fold;
mod hash;
mod metadata;
mod nn;
mod owned;
mod report;
mod rewrite;
mod rounded;
mod statics;
mod tensors;
mod tree;

pub use domain::{
    Action, Attribute, Domain, GROUP_TOKEN, MAX_NAMES, MAX_WORDS, Spelling, Value, View,
};
pub use emit::{InvalidName, Options, rust_source};
pub use error::ModelError;
pub use owned::OwnedModel;
pub use report::{ArraySize, MemoryReport, memory_report};
pub use rewrite::with_confidence;

/// Two lower-case digits per byte.
pub fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
mod readme {}
