//! The layers of `nsrm_core::nn`, one per file: read from row-major tensors, and described for the
//! emitter.

mod conv;
mod gru;
mod linear;

pub(crate) use conv::{merge_conv, patch_conv};
pub(crate) use gru::gru;
pub(crate) use linear::linear;
