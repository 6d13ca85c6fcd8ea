use super::{add_products, dot};

/// A dense layer: `y = W·x + b`.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
// A cache line: no vector of a column lies across two.
#[repr(align(64))]
pub struct Linear<const INPUT: usize, const OUTPUT: usize> {
    /// A column for each input.
    pub weight: [[f32; OUTPUT]; INPUT],
    /// Added to the product.
    pub bias: [f32; OUTPUT],
}

impl<const INPUT: usize> Linear<INPUT, 1> {
    /// The only element of [`Linear::apply`], faster. Cost: `INPUT` multiply-adds.
    #[inline(always)]
    pub(crate) fn single(&self, input: &[f32; INPUT]) -> f32 {
        let [bias] = self.bias;
        dot(&self.weight.map(|[weight]| weight), input) + bias
    }
}

impl<const INPUT: usize, const OUTPUT: usize> Linear<INPUT, OUTPUT> {
    /// `W·input + b`. Cost: `INPUT·OUTPUT` multiply-adds.
    ///
    /// ```
    /// use nsrm_core::nn::Linear;
    /// let layer = Linear::new()
    ///     .with_weight([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]])
    ///     .with_bias([0.5, 0.0]);
    /// assert_eq!(layer.apply(&[1.0, 10.0, 100.0]), [531.5, 642.0]);
    /// ```
    pub fn apply(&self, input: &[f32; INPUT]) -> [f32; OUTPUT] {
        const { assert!(INPUT > 0 && OUTPUT > 0) };
        let mut output = self.bias;
        add_products(&mut output, input, &self.weight);
        output
    }
}
