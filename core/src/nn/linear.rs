/// A dense layer: `y = W·x + b`.
#[derive(Debug, Clone, Copy)]
pub struct Linear<const INPUT: usize, const OUTPUT: usize> {
    /// A column for each input.
    pub weight: [[f32; OUTPUT]; INPUT],
    /// Added to the product.
    pub bias: [f32; OUTPUT],
}
