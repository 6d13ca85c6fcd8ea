use super::int8::{Quantized, add_rows, round_row};
use super::{Kernel, Linear, widest};

/// A dense layer `y = W·x + b` whose weights are whole numbers, one scale an output.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Int8Linear<const INPUT: usize, const OUTPUT: usize> {
    /// A row for each output.
    pub weight: [[i8; INPUT]; OUTPUT],
    /// What 1 in a row stands for.
    pub scale: [f32; OUTPUT],
    /// Added to the product.
    pub bias: [f32; OUTPUT],
}

impl<const INPUT: usize, const OUTPUT: usize> Int8Linear<INPUT, OUTPUT> {
    /// The weights of a layer, each row rounded to 255 steps.
    ///
    /// ```
    /// use nsrm_core::nn::{Int8Linear, Linear};
    /// let layer = Linear::new()
    ///     .with_weight([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]])
    ///     .with_bias([0.5, 0.0]);
    /// let small = Int8Linear::of(&layer);
    /// assert_eq!(small.weight[0], [25, 76, 127]);
    /// let [first, second] = small.apply(&[1.0, 10.0, 100.0]);
    /// assert!((first - 531.5).abs() < 0.5 && (second - 642.0).abs() < 0.5);
    /// ```
    pub fn of(layer: &Linear<INPUT, OUTPUT>) -> Self {
        let mut rounded = Self {
            weight: [[0; INPUT]; OUTPUT],
            scale: [0.0; OUTPUT],
            bias: layer.bias,
        };
        let rows = rounded.weight.iter_mut().zip(&mut rounded.scale);
        for (output, (row, scale)) in rows.enumerate() {
            let column = |weights: &[f32; OUTPUT]| weights.get(output).copied().unwrap_or(0.0);
            *scale = round_row(row, layer.weight.iter().map(column));
        }
        rounded
    }

    /// `W·input + b`. Cost: `INPUT·OUTPUT` multiply-adds of whole numbers.
    pub fn apply(&self, input: &[f32; INPUT]) -> [f32; OUTPUT] {
        const { assert!(INPUT > 0 && OUTPUT > 0) };
        let mut output = self.bias;
        self.add_products(&mut output, 0, input);
        output
    }

    /// `sum += W[.., first..first + PART]·input`.
    pub(super) fn add_products<const PART: usize>(
        &self,
        sum: &mut [f32; OUTPUT],
        first: usize,
        input: &[f32; PART],
    ) {
        widest(AddProducts {
            layer: self,
            sum,
            first,
            input,
        });
    }
}

/// See [`Int8Linear::add_products`].
struct AddProducts<'a, const PART: usize, const INPUT: usize, const OUTPUT: usize> {
    layer: &'a Int8Linear<INPUT, OUTPUT>,
    sum: &'a mut [f32; OUTPUT],
    first: usize,
    input: &'a [f32; PART],
}

impl<const PART: usize, const INPUT: usize, const OUTPUT: usize> Kernel
    for AddProducts<'_, PART, INPUT, OUTPUT>
{
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Int8Linear { weight, scale, .. } = self.layer;
        let input = Quantized::new(self.input);
        add_rows(self.sum, weight, scale, self.first, &input);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layer() -> Linear<96, 17> {
        let mut layer = Linear::new();
        layer.weight = core::array::from_fn(|input| {
            core::array::from_fn(|output| libm::sinf((input * 17 + output) as f32))
        });
        layer.bias = core::array::from_fn(|output| output as f32 - 8.0);
        layer
    }

    #[test]
    fn its_results_are_those_of_the_rounded_weights() {
        let layer = layer();
        let small = Int8Linear::of(&layer);
        let input: [f32; 96] = core::array::from_fn(|index| libm::cosf(index as f32));
        for (output, got) in small.apply(&input).into_iter().enumerate() {
            let row = &small.weight[output];
            assert!(row.iter().any(|weight| weight.abs() == 127), "{output}");
            let weights = row
                .iter()
                .map(|&w| f64::from(w) * f64::from(small.scale[output]));
            let products = weights.clone().zip(input).map(|(w, x)| w * f64::from(x));
            let expected = f64::from(layer.bias[output]) + products.sum::<f64>();
            assert!((f64::from(got) - expected).abs() < 2e-3, "{output}: {got}");
            for (input, weight) in weights.enumerate() {
                let error = weight - f64::from(layer.weight[input][output]);
                assert!(error.abs() <= 0.5 * f64::from(small.scale[output]) + 1e-7);
            }
        }
    }

    #[test]
    fn the_width_of_the_vectors_does_not_change_a_bit() {
        let small = Int8Linear::of(&layer());
        let input: [f32; 96] = core::array::from_fn(|index| libm::cosf(index as f32));
        let [mut wide, mut narrow] = [small.bias; 2];
        small.add_products(&mut wide, 0, &input);
        let kernel = AddProducts {
            layer: &small,
            sum: &mut narrow,
            first: 0,
            input: &input,
        };
        kernel.run();
        assert_eq!(wide.map(f32::to_bits), narrow.map(f32::to_bits));
    }

    #[test]
    fn rows_of_zeros_and_unset_ones_stay_what_they_are() {
        let zeros = Linear::<3, 2> {
            weight: [[0.0; 2]; 3],
            bias: [1.0, 2.0],
        };
        assert_eq!(Int8Linear::of(&zeros).apply(&[1.0; 3]), [1.0, 2.0]);
        let unset = Int8Linear::of(&Linear::<3, 2>::new());
        assert!(unset.apply(&[1.0; 3]).iter().all(|value| value.is_nan()));
        let unset = Int8Linear::<3, 2>::new();
        assert!(unset.apply(&[1.0; 3]).iter().all(|value| value.is_nan()));
    }
}
