//! Layers, one a file: fixed sizes, column-major weights, no allocation.
//!
//! A product runs over the columns of its matrix, `y += x[j]·W[j]`: contiguous
//! memory and lanes that don't depend on each other, so that the compiler uses
//! the vector unit without being allowed to reorder a sum. Every sum is taken in
//! the order of the inputs, the same on every machine.

mod activation;
mod choice;
mod conv;
mod gru;
mod linear;

pub use activation::{relu, relu_all, sigmoid, tanh, tanh_all};
pub use choice::Choice;
pub use conv::Conv;
pub use gru::Gru;
pub use linear::Linear;

/// How far the squared length of what must have length 1 may be from it.
pub const LENGTH_TOLERANCE: f32 = 1e-3;

/// `sum += factor · column`, element by element.
#[inline(always)]
pub(crate) fn accumulate<const LENGTH: usize>(
    sum: &mut [f32; LENGTH],
    factor: f32,
    column: &[f32; LENGTH],
) {
    for (sum, &weight) in sum.iter_mut().zip(column) {
        *sum += factor * weight;
    }
}

/// `left · right`, summed in order.
#[inline]
pub(crate) fn dot<const LENGTH: usize>(left: &[f32; LENGTH], right: &[f32; LENGTH]) -> f32 {
    let mut sum = 0.0;
    for (left, right) in left.iter().zip(right) {
        sum += left * right;
    }
    sum
}

/// Whether a vector has length 1; false for what is not finite.
pub(crate) fn is_unit<const LENGTH: usize>(vector: &[f32; LENGTH]) -> bool {
    (dot(vector, vector) - 1.0).abs() <= LENGTH_TOLERANCE
}
