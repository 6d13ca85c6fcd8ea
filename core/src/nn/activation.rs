//! Scalar functions by `libm`: the same bits on every machine.

/// `1 / (1 + e^-x)`, within 3e-7 of the true value for every `x`.
///
/// Saturates without a NaN: 0 from about −104 down (where `e^-x` is infinite),
/// 1 from about 17 up. A NaN gives a NaN.
///
/// ```
/// use nsrm_core::nn::sigmoid;
/// assert_eq!(sigmoid(0.0), 0.5);
/// assert_eq!((sigmoid(-1e30), sigmoid(1e30)), (0.0, 1.0));
/// ```
#[inline]
pub fn sigmoid(x: f32) -> f32 {
    1.0 / (1.0 + exp(-x))
}

/// `e^x`; infinite from about 88.7 up.
#[inline]
pub(super) fn exp(x: f32) -> f32 {
    libm::expf(x)
}

/// Hyperbolic tangent, within 3e-7 of the true value; ±1 from about ±9 on.
/// A NaN gives a NaN.
#[inline]
pub fn tanh(x: f32) -> f32 {
    libm::tanhf(x)
}

/// [`tanh`] of each element, in place.
#[inline]
pub fn tanh_all<const LENGTH: usize>(values: &mut [f32; LENGTH]) {
    for value in values {
        *value = tanh(*value);
    }
}

/// `max(x, 0)`, except that a NaN stays one and is found where results are checked.
#[inline]
pub fn relu(x: f32) -> f32 {
    if x < 0.0 { 0.0 } else { x }
}

/// [`relu`] of each element, in place.
#[inline]
pub fn relu_all<const LENGTH: usize>(values: &mut [f32; LENGTH]) {
    for value in values {
        *value = relu(*value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From a table of the functions, to 8 digits.
    const TABLE: [(f32, f32, f32); 6] = [
        (-20.0, 2.061_153_6e-9, -1.0),
        (-2.0, 0.119_202_92, -0.964_027_6),
        (-0.001, 0.499_75, -0.000_999_999_7),
        (0.5, 0.622_459_33, 0.462_117_16),
        (4.0, 0.982_013_8, 0.999_329_3),
        (20.0, 1.0, 1.0),
    ];

    #[test]
    fn agree_with_a_table() {
        for (x, expected_sigmoid, expected_tanh) in TABLE {
            assert!((sigmoid(x) - expected_sigmoid).abs() < 3e-7, "sigmoid({x})");
            assert!((tanh(x) - expected_tanh).abs() < 3e-7, "tanh({x})");
        }
    }

    #[test]
    fn saturate_without_nan_and_keep_nan() {
        for x in [f32::MIN, f32::NEG_INFINITY] {
            assert_eq!((sigmoid(x), tanh(x)), (0.0, -1.0));
        }
        for x in [f32::MAX, f32::INFINITY] {
            assert_eq!((sigmoid(x), tanh(x)), (1.0, 1.0));
        }
        assert!(sigmoid(f32::NAN).is_nan() && tanh(f32::NAN).is_nan() && relu(f32::NAN).is_nan());
        assert_eq!((relu(-1.5), relu(0.0), relu(2.5)), (0.0, 0.0, 2.5));
    }
}
