use super::products::add_four_products;
use super::{Kernel, widest};

/// Side of the square that becomes one pixel.
const SIDE: usize = 2;
/// Pixels of a row of the result that are computed together: each weight is loaded once for both.
const TOGETHER: usize = 2;

/// A convolution (cross-correlation) of squares of 2×2 pixels that do not overlap; no padding. The
/// channels of a pixel lie together.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
// A cache line: no vector of a column lies across two.
#[repr(align(64))]
pub struct MergeConv<const INPUT: usize, const OUTPUT: usize> {
    /// By row and column of the square, input channel, output channel.
    pub weight: [[[[f32; OUTPUT]; INPUT]; SIDE]; SIDE],
    /// A value for each output channel.
    pub bias: [f32; OUTPUT],
}

impl<const INPUT: usize, const OUTPUT: usize> MergeConv<INPUT, OUTPUT> {
    /// From a map of `WIDTH × WIDTH` to one of `RESULT × RESULT` with `WIDTH = 2·RESULT`, both by row,
    /// column, channel. Writes into `output`, which may be large.
    ///
    /// Cost: `INPUT·OUTPUT·WIDTH²` multiply-adds.
    pub fn apply<const WIDTH: usize, const RESULT: usize>(
        &self,
        input: &[[[f32; INPUT]; WIDTH]; WIDTH],
        output: &mut [[[f32; OUTPUT]; RESULT]; RESULT],
    ) {
        widest(Apply {
            layer: self,
            input,
            output,
        });
    }
}

/// See [`MergeConv::apply`].
struct Apply<'a, const INPUT: usize, const OUTPUT: usize, const WIDTH: usize, const RESULT: usize> {
    layer: &'a MergeConv<INPUT, OUTPUT>,
    input: &'a [[[f32; INPUT]; WIDTH]; WIDTH],
    output: &'a mut [[[f32; OUTPUT]; RESULT]; RESULT],
}

impl<const INPUT: usize, const OUTPUT: usize, const WIDTH: usize, const RESULT: usize> Kernel
    for Apply<'_, INPUT, OUTPUT, WIDTH, RESULT>
{
    type Output = ();

    #[inline(always)]
    fn run(self) {
        const { assert!(WIDTH == RESULT * SIDE && RESULT.is_multiple_of(TOGETHER)) };
        let (rows, _) = self.input.as_chunks::<SIDE>();
        for (rows, results) in rows.iter().zip(self.output) {
            let (results, _) = results.as_chunks_mut::<TOGETHER>();
            for (column, results) in results.iter_mut().enumerate() {
                let squares = rows.each_ref().map(|row| {
                    let (pairs, _) = row.as_chunks::<SIDE>();
                    pairs.as_chunks::<TOGETHER>().0.get(column)
                });
                if let [Some(above), Some(below)] = squares {
                    *results = self.layer.at([above, below]);
                }
            }
        }
    }
}

impl<const INPUT: usize, const OUTPUT: usize> MergeConv<INPUT, OUTPUT> {
    /// The results of squares side by side.
    ///
    /// * `rows`: the upper and the lower two pixels of each square
    #[inline(always)]
    fn at(&self, rows: [&[[[f32; INPUT]; SIDE]; TOGETHER]; SIDE]) -> [[f32; OUTPUT]; TOGETHER] {
        const { assert!(INPUT.is_multiple_of(4)) };
        let mut sums = [self.bias; TOGETHER];
        for ([left, right], weights) in rows.into_iter().zip(&self.weight) {
            let columns = left.iter().zip(right).zip(weights);
            for ((left, right), weights) in columns {
                let pixels = left.as_chunks::<4>().0.iter().zip(right.as_chunks::<4>().0);
                for ((left, right), weights) in pixels.zip(weights.as_chunks::<4>().0) {
                    add_four_products(&mut sums, &[*left, *right], weights);
                }
            }
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four channels in, three out, of 4×4 pixels: every index has its own size or its own number.
    #[test]
    fn is_a_cross_correlation_by_row_column_channel() {
        let mut conv = MergeConv::<4, 3> {
            weight: [[[[0.0; 3]; 4]; 2]; 2],
            bias: [100.0, 200.0, 300.0],
        };
        conv.weight[0][1][0][0] = 1.0; // row 0, column 1, channel 0 -> channel 0
        conv.weight[1][0][3][1] = 1.0; // row 1, column 0, channel 3 -> channel 1
        conv.weight[1][1][2][2] = 2.0; // row 1, column 1, channel 2 -> channel 2
        let number = |row, column, channel| (16 * row + 4 * column + channel) as f32;
        let input: [[[f32; 4]; 4]; 4] = core::array::from_fn(|row| {
            core::array::from_fn(|column| {
                core::array::from_fn(|channel| number(row, column, channel))
            })
        });
        let mut output = [[[0.0; 3]; 2]; 2];
        conv.apply(&input, &mut output);
        for (row, results) in output.iter().enumerate() {
            for (column, result) in results.iter().enumerate() {
                let (y, x) = (2 * row, 2 * column);
                let expected = [
                    100.0 + number(y, x + 1, 0),
                    200.0 + number(y + 1, x, 3),
                    300.0 + 2.0 * number(y + 1, x + 1, 2),
                ];
                assert_eq!(*result, expected, "row {row}, column {column}");
            }
        }
    }
}
