//! From a trained model file to what `nsrm_core` reads.
//!
//! A model file (safetensors, written by the trainer) becomes an [`OwnedModel`]:
//! the SHA-256 over all of it verified, every tensor's name, shape, element type and
//! finiteness checked, the metadata checked against the domain that travels in it, matrices
//! transposed, and products that depend on the model alone folded. From there
//!
//! * [`OwnedModel::as_model`] lends it as the type that the static arrays have;
//! * [`rust_source`] writes it as those static arrays, for `build.rs` or a commit;
//! * [`memory_report`] says how much read-only memory they take.
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
mod statics;
mod tensors;
mod tree;

pub use domain::{Action, Attribute, Domain, GROUP_TOKEN, MAX_NAMES, MAX_WORDS, Value, View};
pub use emit::{InvalidName, Options, rust_source};
pub use error::ModelError;
pub use owned::OwnedModel;
pub use report::{ArraySize, MemoryReport, memory_report};

/// Two lower-case digits a byte.
pub fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
mod readme {}
