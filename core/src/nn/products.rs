//! Products of matrices and vectors.
//!
//! A product runs over the columns of its matrix, `y += x[j]·W[j]`: contiguous memory and lanes that do
//! not depend on each other, so that the compiler uses vectors without being allowed to reorder a
//! sum.

use core::hint::black_box;

use super::{Kernel, widest};

/// `sum += Σ_j input[j]·columns[j]`, element by element: the products of four inputs are added in
/// pairs, and then to the sum.
///
/// * `columns`: one for each input
pub(crate) fn add_products<const LENGTH: usize>(
    sum: &mut [f32; LENGTH],
    input: &[f32],
    columns: &[[f32; LENGTH]],
) {
    widest(AddProducts {
        sum,
        input,
        columns,
    });
}

/// See [`add_products`].
struct AddProducts<'a, const LENGTH: usize> {
    sum: &'a mut [f32; LENGTH],
    input: &'a [f32],
    columns: &'a [[f32; LENGTH]],
}

impl<const LENGTH: usize> Kernel for AddProducts<'_, LENGTH> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (rows, _) = self.columns.as_chunks::<1>();
        add_row_products::<LENGTH, 1, 0>(self.sum, self.input, rows);
    }
}

/// [`add_products`] with the columns at the index `COLUMN` of rows of several. The sums of a block
/// are kept in registers over all inputs.
#[inline(always)]
pub(super) fn add_row_products<const LENGTH: usize, const COLUMNS: usize, const COLUMN: usize>(
    sum: &mut [f32; LENGTH],
    input: &[f32],
    rows: &[[[f32; LENGTH]; COLUMNS]],
) {
    let rest = add_to_blocks::<LENGTH, COLUMNS, COLUMN, 48>(sum, 0, input, rows);
    let rest = add_to_blocks::<LENGTH, COLUMNS, COLUMN, 32>(sum, rest, input, rows);
    let rest = add_to_blocks::<LENGTH, COLUMNS, COLUMN, 24>(sum, rest, input, rows);
    let rest = add_to_blocks::<LENGTH, COLUMNS, COLUMN, 16>(sum, rest, input, rows);
    let rest = add_to_blocks::<LENGTH, COLUMNS, COLUMN, 4>(sum, rest, input, rows);
    add_to_blocks::<LENGTH, COLUMNS, COLUMN, 1>(sum, rest, input, rows);
}

/// Adds to as many whole blocks as there are from element `first` on; the first element behind them.
#[inline(always)]
fn add_to_blocks<
    const LENGTH: usize,
    const COLUMNS: usize,
    const COLUMN: usize,
    const BLOCK: usize,
>(
    sum: &mut [f32; LENGTH],
    first: usize,
    input: &[f32],
    rows: &[[[f32; LENGTH]; COLUMNS]],
) -> usize {
    const { assert!(COLUMN < COLUMNS) };
    // With a length that is known, the loop is unrolled in full and its sums leave the registers.
    let (fours, ones) = black_box(input).as_chunks::<4>();
    let (rows_of_fours, rows_of_ones) = rows.as_chunks::<4>();
    let mut begin = first;
    while let Some(block) = sum
        .get_mut(begin..)
        .and_then(<[f32]>::first_chunk_mut::<BLOCK>)
    {
        let mut kept = *block;
        for ([a, b, c, d], rows) in fours.iter().zip(rows_of_fours) {
            let [wa, wb, wc, wd] = rows
                .each_ref()
                .map(|row| weights::<LENGTH, COLUMNS, COLUMN, BLOCK>(row, begin));
            let weights = wa.iter().zip(wb).zip(wc.iter().zip(wd));
            for (kept, ((wa, wb), (wc, wd))) in kept.iter_mut().zip(weights) {
                *kept += (a * wa + b * wb) + (c * wc + d * wd);
            }
        }
        for (factor, row) in ones.iter().zip(rows_of_ones) {
            let weights = weights::<LENGTH, COLUMNS, COLUMN, BLOCK>(row, begin);
            for (kept, weight) in kept.iter_mut().zip(weights) {
                *kept += factor * weight;
            }
        }
        *block = kept;
        begin = begin.wrapping_add(BLOCK);
    }
    begin
}

/// `sums[i] += Σ_j inputs[i][j]·columns[j]` of several sums, each column loaded once for all; the
/// products are added in pairs.
#[inline(always)]
pub(super) fn add_four_products<const LENGTH: usize, const SUMS: usize>(
    sums: &mut [[f32; LENGTH]; SUMS],
    inputs: &[[f32; 4]; SUMS],
    columns: &[[f32; LENGTH]; 4],
) {
    let [wa, wb, wc, wd] = columns;
    for (sum, [a, b, c, d]) in sums.iter_mut().zip(inputs) {
        let weights = wa.iter().zip(wb).zip(wc.iter().zip(wd));
        for (sum, ((wa, wb), (wc, wd))) in sum.iter_mut().zip(weights) {
            *sum += (a * wa + b * wb) + (c * wc + d * wd);
        }
    }
}

/// A block of one column.
#[inline(always)]
fn weights<const LENGTH: usize, const COLUMNS: usize, const COLUMN: usize, const BLOCK: usize>(
    row: &[[f32; LENGTH]; COLUMNS],
    begin: usize,
) -> &[f32; BLOCK] {
    let column = row.get(COLUMN).and_then(|column| column.get(begin..));
    let block = column.and_then(<[f32]>::first_chunk);
    // Always there: a column is as long as the sum.
    block.unwrap_or(&[0.0; BLOCK])
}

/// `left · right`: eight sums, of every eighth product each, which are then added in order.
#[inline(always)]
pub(crate) fn dot<const LENGTH: usize>(left: &[f32; LENGTH], right: &[f32; LENGTH]) -> f32 {
    let ((left, left_rest), (right, right_rest)) = (left.as_chunks::<8>(), right.as_chunks::<8>());
    let mut sums = [0.0; 8];
    for (left, right) in left.iter().zip(right) {
        for ((sum, left), right) in sums.iter_mut().zip(left).zip(right) {
            *sum += left * right;
        }
    }
    for ((sum, left), right) in sums.iter_mut().zip(left_rest).zip(right_rest) {
        *sum += left * right;
    }
    sums.iter().sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whole numbers, so that every order of a sum gives the same.
    fn number(index: usize) -> f32 {
        (index * 7 % 23) as f32 - 11.0
    }

    fn check<const LENGTH: usize>(inputs: usize) {
        let input: std::vec::Vec<f32> = (0..inputs).map(number).collect();
        let columns: std::vec::Vec<[f32; LENGTH]> = (0..inputs)
            .map(|column| core::array::from_fn(|row| number(31 * column + row)))
            .collect();
        let mut sum = core::array::from_fn(number);
        add_products(&mut sum, &input, &columns);
        for (row, got) in sum.iter().enumerate() {
            let products = input
                .iter()
                .zip(&columns)
                .map(|(x, column)| x * column[row]);
            let expected = number(row) + products.sum::<f32>();
            assert_eq!(*got, expected, "{inputs} inputs, row {row} of {LENGTH}");
        }
    }

    #[test]
    fn every_element_and_every_input_counts() {
        for inputs in [0, 1, 3, 4, 7, 32] {
            check::<1>(inputs);
            check::<5>(inputs);
            check::<24>(inputs);
            // A block of each size.
            check::<125>(inputs);
        }
    }

    #[test]
    fn a_dot_product_leaves_nothing_out() {
        fn check<const LENGTH: usize>() {
            let left: [f32; LENGTH] = core::array::from_fn(number);
            let right = core::array::from_fn(|index| number(3 * index + 1));
            let expected: f32 = left
                .iter()
                .zip(&right)
                .map(|(left, right)| left * right)
                .sum();
            assert_eq!(dot(&left, &right), expected, "{LENGTH}");
        }
        check::<0>();
        check::<3>();
        check::<8>();
        check::<96>();
        check::<29>();
    }

    #[test]
    fn the_width_of_the_vectors_does_not_change_a_bit() {
        let columns: [[f32; 48]; 30] = core::array::from_fn(|column| {
            core::array::from_fn(|row| 1.0 / (3 + 48 * column + row) as f32)
        });
        let input: [f32; 30] = core::array::from_fn(|index| libm::sqrtf(index as f32 + 0.1));
        let [mut wide, mut narrow] = [[0.1; 48]; 2];
        add_products(&mut wide, &input, &columns);
        let kernel = AddProducts {
            sum: &mut narrow,
            input: &input,
            columns: &columns,
        };
        kernel.run();
        assert_eq!(wide.map(f32::to_bits), narrow.map(f32::to_bits));
    }
}
