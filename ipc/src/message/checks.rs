//! Checks shared by several messages.

use nsrm_core::nn::LENGTH_TOLERANCE;

/// Whether all numbers are finite.
pub(crate) fn all_finite(numbers: &[f32]) -> bool {
    numbers.iter().all(|number| number.is_finite())
}

/// Whether a quaternion (x, y, z, w) has length 1; not if it isn't finite.
pub(crate) fn is_unit(quaternion: &[f32; 4]) -> bool {
    let squared: f32 = quaternion.iter().map(|part| part * part).sum();
    (squared - 1.0).abs() <= LENGTH_TOLERANCE
}
