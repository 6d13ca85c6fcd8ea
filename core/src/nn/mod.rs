//! Layers, one a file: fixed sizes, column-major weights, no allocation.

mod conv;
mod gru;
mod linear;

pub use conv::Conv;
pub use gru::Gru;
pub use linear::Linear;
