use super::products::add_four_products;
use super::{Kernel, widest};

/// Side of a patch, pixels.
const SIDE: usize = 4;
/// Patches of a row that are computed together: each weight is loaded once for all.
const TOGETHER: usize = 4;

/// A convolution (cross-correlation) of 4×4 patches that do not overlap; no padding. Reads one map for
/// each channel; the channels of a pixel of the result lie together, as [`MergeConv`] reads them.
///
/// [`MergeConv`]: super::MergeConv
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
// A cache line: no vector of a column lies across two.
#[repr(align(64))]
pub struct PatchConv<const INPUT: usize, const OUTPUT: usize> {
    /// By input channel, row and column of the patch, output channel.
    pub weight: [[[[f32; OUTPUT]; SIDE]; SIDE]; INPUT],
    /// A value for each output channel.
    pub bias: [f32; OUTPUT],
}

impl<const INPUT: usize, const OUTPUT: usize> PatchConv<INPUT, OUTPUT> {
    /// From maps of `WIDTH × WIDTH`, by channel, row, column, to a map of `RESULT × RESULT` with
    /// `WIDTH = 4·RESULT`, by row, column, channel. Writes into `output`, which may be large.
    ///
    /// Cost: `INPUT·OUTPUT·WIDTH²` multiply-adds.
    pub fn apply<const WIDTH: usize, const RESULT: usize>(
        &self,
        input: &[[[f32; WIDTH]; WIDTH]; INPUT],
        output: &mut [[[f32; OUTPUT]; RESULT]; RESULT],
    ) {
        widest(Apply {
            layer: self,
            input,
            output,
        });
    }
}

/// See [`PatchConv::apply`].
struct Apply<'a, const INPUT: usize, const OUTPUT: usize, const WIDTH: usize, const RESULT: usize> {
    layer: &'a PatchConv<INPUT, OUTPUT>,
    input: &'a [[[f32; WIDTH]; WIDTH]; INPUT],
    output: &'a mut [[[f32; OUTPUT]; RESULT]; RESULT],
}

impl<const INPUT: usize, const OUTPUT: usize, const WIDTH: usize, const RESULT: usize> Kernel
    for Apply<'_, INPUT, OUTPUT, WIDTH, RESULT>
{
    type Output = ();

    #[inline(always)]
    fn run(self) {
        const { assert!(WIDTH == RESULT * SIDE && RESULT.is_multiple_of(TOGETHER)) };
        for (row, pixels) in self.output.iter_mut().enumerate() {
            let (results, _) = pixels.as_chunks_mut::<TOGETHER>();
            for (column, results) in results.iter_mut().enumerate() {
                *results = self.layer.at(self.input, row, column);
            }
        }
    }
}

impl<const INPUT: usize, const OUTPUT: usize> PatchConv<INPUT, OUTPUT> {
    /// The results of patches side by side.
    ///
    /// * `row`, `column`: counted in patches, and in groups of [`TOGETHER`] patches
    #[inline(always)]
    fn at<const WIDTH: usize>(
        &self,
        input: &[[[f32; WIDTH]; WIDTH]; INPUT],
        row: usize,
        column: usize,
    ) -> [[f32; OUTPUT]; TOGETHER] {
        let mut sums = [self.bias; TOGETHER];
        for (map, weights) in input.iter().zip(&self.weight) {
            let lines = map.as_chunks::<SIDE>().0.get(row).into_iter().flatten();
            for (line, weights) in lines.zip(weights) {
                let (patches, _) = line.as_chunks::<SIDE>();
                if let Some(patches) = patches.as_chunks().0.get(column) {
                    add_four_products(&mut sums, patches, weights);
                }
            }
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two channels in, three out, of 16×16 pixels: every index has its own size or its own number.
    #[test]
    fn is_a_cross_correlation_by_channel_row_column() {
        let mut conv = PatchConv::<2, 3> {
            weight: [[[[0.0; 3]; 4]; 4]; 2],
            bias: [1000.0, 2000.0, 3000.0],
        };
        conv.weight[0][0][1][0] = 1.0; // channel 0, row 0, column 1 -> channel 0
        conv.weight[0][3][0][1] = 1.0; // channel 0, row 3, column 0 -> channel 1
        conv.weight[1][1][2][2] = 2.0; // channel 1, row 1, column 2 -> channel 2
        let pixel = |channel, row, column| (256 * channel + 16 * row + column) as f32;
        let input: [[[f32; 16]; 16]; 2] = core::array::from_fn(|channel| {
            core::array::from_fn(|row| core::array::from_fn(|column| pixel(channel, row, column)))
        });
        let mut output = [[[0.0; 3]; 4]; 4];
        conv.apply(&input, &mut output);
        for (row, results) in output.iter().enumerate() {
            for (column, result) in results.iter().enumerate() {
                let (y, x) = (4 * row, 4 * column);
                let expected = [
                    1000.0 + pixel(0, y, x + 1),
                    2000.0 + pixel(0, y + 3, x),
                    3000.0 + 2.0 * pixel(1, y + 1, x + 2),
                ];
                assert_eq!(*result, expected, "row {row}, column {column}");
            }
        }
    }
}
