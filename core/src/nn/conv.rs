use super::{Kernel, add_row_products, widest};

/// A convolution (cross-correlation) whose stride is its kernel; no padding.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
// A cache line: no vector of a column lies across two.
#[repr(align(64))]
pub struct Conv<const INPUT: usize, const OUTPUT: usize, const KERNEL: usize> {
    /// `[INPUT][KERNEL][KERNEL][OUTPUT]`: input channel, kernel row, kernel column, output channel.
    pub weight: [[[[f32; OUTPUT]; KERNEL]; KERNEL]; INPUT],
    /// A value for each output channel.
    pub bias: [f32; OUTPUT],
}

impl<const INPUT: usize, const OUTPUT: usize, const KERNEL: usize> Conv<INPUT, OUTPUT, KERNEL> {
    /// From maps of `SIDE × SIDE` to maps of `SIDE/KERNEL × SIDE/KERNEL = RESULT × RESULT`,
    /// both by channel, row, column. Writes into `output`, which may be large.
    ///
    /// Cost: `INPUT·OUTPUT·SIDE²` multiply-adds.
    pub fn apply<const SIDE: usize, const RESULT: usize>(
        &self,
        input: &[[[f32; SIDE]; SIDE]; INPUT],
        output: &mut [[[f32; RESULT]; RESULT]; OUTPUT],
    ) {
        widest(Apply {
            layer: self,
            input,
            output,
        });
    }
}

/// See [`Conv::apply`].
struct Apply<
    'a,
    const INPUT: usize,
    const OUTPUT: usize,
    const KERNEL: usize,
    const SIDE: usize,
    const RESULT: usize,
> {
    layer: &'a Conv<INPUT, OUTPUT, KERNEL>,
    input: &'a [[[f32; SIDE]; SIDE]; INPUT],
    output: &'a mut [[[f32; RESULT]; RESULT]; OUTPUT],
}

impl<
    const INPUT: usize,
    const OUTPUT: usize,
    const KERNEL: usize,
    const SIDE: usize,
    const RESULT: usize,
> Kernel for Apply<'_, INPUT, OUTPUT, KERNEL, SIDE, RESULT>
{
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self {
            layer,
            input,
            output,
        } = self;
        const { assert!(KERNEL > 0 && SIDE == RESULT * KERNEL && INPUT * KERNEL * KERNEL <= PATCH) };
        let columns = layer.weight.as_flattened().as_flattened();
        let mut patch = [0.0; PATCH];
        for row in 0..RESULT {
            for column in 0..RESULT {
                let patch = gather::<SIDE, KERNEL>(input, row, column, &mut patch);
                let mut values = layer.bias;
                add_row_products::<OUTPUT, 1, 0>(&mut values, patch, columns.as_chunks::<1>().0);
                for (map, value) in output.iter_mut().zip(values) {
                    // Always present: row and column are below RESULT.
                    if let Some(place) = map.as_flattened_mut().get_mut(row * RESULT + column) {
                        *place = value;
                    }
                }
            }
        }
    }
}

/// The most inputs of one result: 24 channels of 2×2, in the encoder's second layer.
const PATCH: usize = 96;

/// The patch of all channels at a row and column of the result, in the order of the weights.
#[inline(always)]
fn gather<'p, const SIDE: usize, const KERNEL: usize>(
    input: &[[[f32; SIDE]; SIDE]],
    row: usize,
    column: usize,
    patch: &'p mut [f32; PATCH],
) -> &'p [f32] {
    let rows = input
        .iter()
        .flat_map(|map| map.as_chunks::<KERNEL>().0.get(row))
        .flatten();
    let pieces = rows.flat_map(|pixels| pixels.as_chunks::<KERNEL>().0.get(column));
    let mut length = 0_usize;
    for (place, piece) in patch.as_chunks_mut::<KERNEL>().0.iter_mut().zip(pieces) {
        *place = *piece;
        length = length.wrapping_add(KERNEL);
    }
    patch.get(..length).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two channels in, three out, kernel 2 on 4×4: every index has its own size
    /// or its own number.
    #[test]
    fn is_a_cross_correlation_by_channel_row_column() {
        let mut conv = Conv::<2, 3, 2> {
            weight: [[[[0.0; 3]; 2]; 2]; 2],
            bias: [100.0, 200.0, 300.0],
        };
        conv.weight[0][0][1][0] = 1.0; // channel 0, row 0, column 1 -> map 0
        conv.weight[0][1][0][1] = 1.0; // channel 0, row 1, column 0 -> map 1
        conv.weight[1][1][1][2] = 2.0; // channel 1, row 1, column 1 -> map 2
        // Pixel = 16·channel + 4·row + column.
        let mut input = [[[0.0; 4]; 4]; 2];
        for (channel, map) in input.iter_mut().enumerate() {
            for (row, pixels) in map.iter_mut().enumerate() {
                for (column, pixel) in pixels.iter_mut().enumerate() {
                    *pixel = (16 * channel + 4 * row + column) as f32;
                }
            }
        }
        let mut output = [[[0.0; 2]; 2]; 3];
        conv.apply(&input, &mut output);
        assert_eq!(output[0], [[101.0, 103.0], [109.0, 111.0]]);
        assert_eq!(output[1], [[204.0, 206.0], [212.0, 214.0]]);
        assert_eq!(output[2], [[342.0, 346.0], [358.0, 362.0]]);
    }
}
