//! Layers, one a file: fixed sizes, column-major weights, no allocation.
//!
//! The results are the same on every machine, bit by bit: every sum has its order, with vectors of
//! any width, and products are rounded before they are added.

mod activation;
mod choice;
mod gru;
mod int8;
mod int8_gru;
mod int8_linear;
mod linear;
mod merge;
mod patch;
mod precision;
mod products;
mod wide;

pub use activation::{relu, relu_all, sigmoid, tanh, tanh_all};
pub use choice::Choice;
pub use gru::Gru;
pub(crate) use int8::round_row;
pub use int8_gru::Int8Gru;
pub use int8_linear::Int8Linear;
pub use linear::Linear;
pub use merge::MergeConv;
pub use patch::PatchConv;
pub use precision::{Cell, Dense, Precision, UnknownPrecision};
use products::add_row_products;
pub(crate) use products::{add_products, dot};
pub(crate) use wide::{Kernel, widest};

/// How far the squared length of what must have length 1 may be from it.
pub const LENGTH_TOLERANCE: f32 = 1e-3;

/// Whether a vector has length 1; false for what is not finite.
pub(crate) fn is_unit<const LENGTH: usize>(vector: &[f32; LENGTH]) -> bool {
    (dot(vector, vector) - 1.0).abs() <= LENGTH_TOLERANCE
}
