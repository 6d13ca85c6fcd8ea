//! Whole numbers of eight bits in place of weights, one scale a row (symmetric, per channel).
//!
//! The other factor of a product is rounded to sixteen bits as it comes, with the scale of its
//! greatest element (dynamic quantization): sums of products are whole, the same in any order, and
//! lose nothing; what is lost is the rounding of the weights. A processor without floating-point
//! unit converts one number a row.

/// The greatest whole number that an input is rounded to.
const GREATEST: f32 = 32_767.0;

/// The most inputs of a row: the sum of this many products of the greatest weight and the greatest
/// input fits into 32 bits.
pub(super) const MAX_INPUTS: usize = 516;

/// Adding it to a number of at most 22 bits leaves the number, rounded to the nearest whole one, in
/// the last bits of the sum: 1.5·2²³.
const ROUND: f32 = 12_582_912.0;

/// A vector in whole numbers: `values[i]·scale`.
pub(super) struct Quantized<const LENGTH: usize> {
    values: [i16; LENGTH],
    /// NaN if any element was not finite.
    scale: f32,
}

impl<const LENGTH: usize> Quantized<LENGTH> {
    #[inline(always)]
    pub(super) fn new(vector: &[f32; LENGTH]) -> Self {
        let greatest = greatest(vector.iter().copied());
        // Infinite for zeros, and for what is as good as that.
        let per_one = GREATEST / greatest;
        let scale = if per_one.is_finite() {
            greatest / GREATEST
        } else {
            0.0
        };
        Self {
            values: vector.map(|x| (x * per_one + ROUND).to_bits() as i16),
            scale: scale + 0.0 * greatest,
        }
    }
}

/// The greatest magnitude; infinite or NaN if one is not finite.
#[inline(always)]
fn greatest(numbers: impl Iterator<Item = f32>) -> f32 {
    // Without their signs, numbers have the order of their bits; infinite ones and NaN are last.
    let magnitudes = numbers.map(|x| x.to_bits() & 0x7fff_ffff);
    f32::from_bits(magnitudes.fold(0, u32::max))
}

/// Rounds a row to whole numbers of at most 127; what 1 stands for, NaN if a weight is not finite.
pub(crate) fn round_row<const LENGTH: usize>(
    row: &mut [i8; LENGTH],
    weights: impl Iterator<Item = f32> + Clone,
) -> f32 {
    const GREATEST: f32 = 127.0;
    let greatest = greatest(weights.clone());
    let per_one = GREATEST / greatest;
    for (rounded, weight) in row.iter_mut().zip(weights) {
        // NaN, of zeros, is 0.
        *rounded = libm::rintf(weight * per_one) as i8;
    }
    greatest / GREATEST
}

/// `sum[i] += scale[i]·Σ_j rows[i][first + j]·input[j]`.
#[inline(always)]
pub(super) fn add_rows<const PART: usize, const INPUT: usize, const OUTPUT: usize>(
    sum: &mut [f32; OUTPUT],
    rows: &[[i8; INPUT]; OUTPUT],
    scale: &[f32; OUTPUT],
    first: usize,
    input: &Quantized<PART>,
) {
    const { assert!(PART <= MAX_INPUTS) };
    let (fours, ones) = rows.as_chunks::<4>();
    let (sums_of_fours, sums_of_ones) = sum.as_chunks_mut::<4>();
    let (scales_of_fours, scales_of_ones) = scale.as_chunks::<4>();
    let blocks = sums_of_fours.iter_mut().zip(scales_of_fours).zip(fours);
    for ((sums, scales), rows) in blocks {
        add_block(sums, rows, scales, first, input);
    }
    let blocks = sums_of_ones.as_chunks_mut::<1>().0.iter_mut();
    let blocks = blocks.zip(scales_of_ones.as_chunks::<1>().0);
    for ((sums, scales), rows) in blocks.zip(ones.as_chunks::<1>().0) {
        add_block(sums, rows, scales, first, input);
    }
}

/// [`add_rows`] of some rows together: each input is loaded once for all of them.
#[inline(always)]
fn add_block<const PART: usize, const INPUT: usize, const ROWS: usize>(
    sums: &mut [f32; ROWS],
    rows: &[[i8; INPUT]; ROWS],
    scales: &[f32; ROWS],
    first: usize,
    input: &Quantized<PART>,
) {
    let rows = rows.each_ref().map(|row| {
        let part = row.get(first..).and_then(<[i8]>::first_chunk::<PART>);
        // Always there: parts lie within the input.
        part.unwrap_or(&[0; PART])
    });
    let mut whole = [0_i32; ROWS];
    for (index, &x) in input.values.iter().enumerate() {
        for (whole, row) in whole.iter_mut().zip(rows) {
            let weight = row.get(index).copied().unwrap_or(0);
            *whole = whole.wrapping_add(i32::from(weight).wrapping_mul(i32::from(x)));
        }
    }
    for ((sum, whole), scale) in sums.iter_mut().zip(whole).zip(scales) {
        *sum += whole as f32 * (scale * input.scale);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vector_is_rounded_to_its_greatest_element() {
        let quantized = Quantized::new(&[0.5, -1.0, 0.25, 1.0 / 65_534.0, 0.0]);
        assert_eq!(quantized.values, [16_384, -32_767, 8_192, 0, 0]);
        assert_eq!(quantized.scale, 1.0 / 32_767.0);
        for tiny in [0.0, f32::from_bits(1), f32::MIN_POSITIVE] {
            let quantized = Quantized::new(&[tiny, -tiny]);
            let back = f32::from(quantized.values[0]) * quantized.scale;
            assert!((back - tiny).abs() <= f32::MIN_POSITIVE, "{tiny}: {back}");
        }
        let greatest = Quantized::new(&[f32::MAX, -f32::MAX]);
        assert_eq!(greatest.values, [32_767, -32_767]);
    }

    #[test]
    fn what_is_not_finite_stays_so() {
        for wrong in [f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            for input in [[wrong, 1.0], [1.0, wrong], [wrong, f32::NAN]] {
                let mut sum = [0.5; 1];
                add_rows(&mut sum, &[[3, 4]], &[1.0], 0, &Quantized::new(&input));
                assert!(!sum[0].is_finite(), "{input:?}");
            }
        }
    }

    #[test]
    fn products_are_exact_and_parts_are_where_they_belong() {
        let rows: [[i8; 11]; 6] = core::array::from_fn(|row| {
            core::array::from_fn(|column| (row * 31 + column * 17) as i8)
        });
        let scale = core::array::from_fn(|row| 1.0 / (1 << row) as f32);
        // Whole numbers with the greatest one there is: the vector's scale is 1.
        let input = [32_767.0, -5.0, 7.0, 300.0, -32_767.0];
        for first in [0, 3, 6] {
            let mut sum = core::array::from_fn(|row| row as f32);
            add_rows(&mut sum, &rows, &scale, first, &Quantized::new(&input));
            for (row, got) in sum.iter().enumerate() {
                let weights = rows[row].iter().skip(first);
                let products = weights.zip(input).map(|(&w, x)| i64::from(w) * x as i64);
                let expected = row as f32 + products.sum::<i64>() as f32 * scale[row];
                assert_eq!(*got, expected, "from {first}, row {row}");
            }
        }
    }

    #[test]
    fn the_longest_row_does_not_overflow() {
        let rows = [[127; MAX_INPUTS]; 1];
        let mut sum = [0.0];
        let input = Quantized::new(&[1.0; MAX_INPUTS]);
        add_rows(&mut sum, &rows, &[1.0], 0, &input);
        assert!((sum[0] / (127 * MAX_INPUTS) as f32 - 1.0).abs() < 1e-6);
    }
}
