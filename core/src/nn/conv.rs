use super::accumulate;

/// A convolution (cross-correlation) whose stride is its kernel; no padding.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
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
        const { assert!(KERNEL > 0 && SIDE == RESULT * KERNEL) };
        for row in 0..RESULT {
            for column in 0..RESULT {
                let values = self.at(input, row * KERNEL, column * KERNEL);
                for (map, value) in output.iter_mut().zip(values) {
                    // Always present: row and column are below RESULT.
                    if let Some(place) = map.get_mut(row).and_then(|row| row.get_mut(column)) {
                        *place = value;
                    }
                }
            }
        }
    }

    /// Every output channel over the patch whose first pixel is (`top`, `left`).
    fn at<const SIDE: usize>(
        &self,
        input: &[[[f32; SIDE]; SIDE]; INPUT],
        top: usize,
        left: usize,
    ) -> [f32; OUTPUT] {
        let mut sum = self.bias;
        for (map, kernel) in input.iter().zip(&self.weight) {
            for (pixels, kernel_row) in map.iter().skip(top).zip(kernel) {
                for (&pixel, column) in pixels.iter().skip(left).zip(kernel_row) {
                    accumulate(&mut sum, pixel, column);
                }
            }
        }
        sum
    }
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
