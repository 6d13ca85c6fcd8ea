/// A convolution (cross-correlation) whose stride is its kernel; no padding.
#[derive(Debug, Clone, Copy)]
pub struct Conv<const INPUT: usize, const OUTPUT: usize, const KERNEL: usize> {
    /// By input channel, kernel row, kernel column: a value for each output channel.
    pub weight: [[[[f32; OUTPUT]; KERNEL]; KERNEL]; INPUT],
    /// A value for each output channel.
    pub bias: [f32; OUTPUT],
}
