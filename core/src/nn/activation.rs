//! Scalar functions by polynomials, without branches: the compiler computes them lane by lane over
//! whole arrays, and they give the same bits on every machine.
//!
//! All come from `e^x − 1 = 2^n·(e^r − 1) + (2^n − 1)` with `x = n·ln 2 + r`, n whole and
//! `|r| ≤ ln 2 / 2`.

use super::{Kernel, widest};

/// `1 / (1 + e^-x)`, within 3e-7 of the true value for every `x`.
///
/// Saturates without a NaN: 0 from about −89 down (where `e^-x` is infinite),
/// 1 from about 17 up. A NaN gives a NaN.
///
/// ```
/// use nsrm_core::nn::sigmoid;
/// assert_eq!(sigmoid(0.0), 0.5);
/// assert_eq!((sigmoid(-1e30), sigmoid(1e30)), (0.0, 1.0));
/// ```
#[inline(always)]
pub fn sigmoid(x: f32) -> f32 {
    1.0 / (1.0 + exp(-x))
}

/// `e^x`, within 2e-7 of it; 0 below −87.3, infinite from 88.4 up.
#[inline(always)]
pub(super) fn exp(x: f32) -> f32 {
    let (power, rest) = parts(x);
    let exp = power * (1.0 + rest);
    if x < LEAST { 0.0 } else { exp }
}

/// Hyperbolic tangent, within 3e-7 of the true value and, near 0, within 3e-7 of it in proportion;
/// ±1 from about ±9 on. A NaN gives a NaN.
#[inline(always)]
pub fn tanh(x: f32) -> f32 {
    // Beyond, tanh is ±1.
    let x = clamp(x, -10.0, 10.0);
    let (power, rest) = parts(x + x);
    let exp_m1 = power * rest + (power - 1.0);
    exp_m1 / (exp_m1 + 2.0)
}

/// The least `x` for which `e^x` is not denormal.
const LEAST: f32 = -87.336_54;
/// Where `e^x` is infinite: `2^n` is, from n = 128 on.
const GREATEST: f32 = 89.0;
/// 1.5·2^23: what is added to it is rounded to a whole number, which its low bits hold.
const ROUND: f32 = 12_582_912.0;
/// ln 2 in two parts; n times the first one is exact.
const LN_2: [f32; 2] = [0.693_359_4, -2.121_944_4e-4];
/// q of `e^r − 1 ≈ r + r²·q(r)`, from the constant on: the greatest error is least, 1.3e-8 of the value
/// for `|r| ≤ ln 2 / 2`.
const Q: [f32; 5] = [
    0.5,
    0.166_665_44,
    0.041_667_2,
    0.008_366_521,
    0.001_388_252_2,
];

/// `2^n` and `e^r − 1` of `e^x = 2^n·e^r`.
#[inline(always)]
fn parts(x: f32) -> (f32, f32) {
    let x = clamp(x, LEAST, GREATEST);
    let rounded = x * core::f32::consts::LOG2_E + ROUND;
    let n = rounded - ROUND;
    let r = (x - n * LN_2[0]) - n * LN_2[1];
    let [q0, q1, q2, q3, q4] = Q;
    let q = q0 + r * (q1 + r * (q2 + r * (q3 + r * q4)));
    // n + 127 in the exponent's place; the bits above it fall out.
    let power = f32::from_bits((rounded.to_bits() << 23).wrapping_add(0x3f80_0000));
    (power, r + r * r * q)
}

/// Between two limits; a NaN stays one.
#[inline(always)]
fn clamp(x: f32, least: f32, greatest: f32) -> f32 {
    let x = if x < least { least } else { x };
    if x > greatest { greatest } else { x }
}

/// [`tanh`] of each element, in place.
pub fn tanh_all<const LENGTH: usize>(values: &mut [f32; LENGTH]) {
    widest(TanhAll(values));
}

/// See [`tanh_all`].
struct TanhAll<'a, const LENGTH: usize>(&'a mut [f32; LENGTH]);

impl<const LENGTH: usize> Kernel for TanhAll<'_, LENGTH> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for value in self.0 {
            *value = tanh(*value);
        }
    }
}

/// `max(x, 0)`, except that a NaN stays one and is found where results are checked.
#[inline(always)]
pub fn relu(x: f32) -> f32 {
    if x < 0.0 { 0.0 } else { x }
}

/// [`relu`] of each element, in place.
#[inline(always)]
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

    /// A sample of all numbers; `cargo run --release -p nsrm-bench --bin accuracy` tries every one.
    #[test]
    fn errors_stay_within_what_is_promised() {
        const STEP: usize = 5_003;
        for bits in (0..=u32::MAX).step_by(STEP) {
            let x = f32::from_bits(bits);
            if !x.is_finite() {
                continue;
            }
            let exact = f64::from(x);
            let error = |got: f32, exact: f64| (f64::from(got) - exact).abs();
            assert!(error(tanh(x), exact.tanh()) < 3e-7, "tanh({x})");
            assert!(
                error(tanh(x), exact.tanh()) <= 3e-7 * exact.abs(),
                "tanh({x})"
            );
            let exact_sigmoid = 1.0 / (1.0 + (-exact).exp());
            assert!(error(sigmoid(x), exact_sigmoid) < 3e-7, "sigmoid({x})");
            let exp = exact.exp();
            if (-87.0..88.0).contains(&x) {
                assert!(error(super::exp(x), exp) < 2e-7 * exp, "exp({x})");
            }
        }
    }

    #[test]
    fn exp_is_zero_or_infinite_beyond_its_range() {
        assert_eq!(
            (super::exp(-87.4), super::exp(f32::NEG_INFINITY)),
            (0.0, 0.0)
        );
        assert_eq!(super::exp(89.0), f32::INFINITY);
        assert_eq!(super::exp(f32::INFINITY), f32::INFINITY);
        assert!(super::exp(f32::NAN).is_nan());
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
