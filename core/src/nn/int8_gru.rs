use super::gru::gated;
use super::int8::{Quantized, add_rows, round_row};
use super::{Gru, Kernel, widest};

/// A GRU cell whose weights are whole numbers, one scale a unit and gate.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Int8Gru<const INPUT: usize, const HIDDEN: usize> {
    /// For the reset, update and new gate a row for each hidden unit, of the inputs' weights.
    pub weight_ih: [[[i8; INPUT]; HIDDEN]; 3],
    /// What 1 in a row of `weight_ih` stands for.
    pub scale_ih: [[f32; HIDDEN]; 3],
    /// Added to the reset, update and new gate.
    pub bias: [[f32; HIDDEN]; 3],
    /// For the reset, update and new gate a row for each hidden unit, of the hidden units' weights.
    pub weight_hh: [[[i8; HIDDEN]; HIDDEN]; 3],
    /// What 1 in a row of `weight_hh` stands for.
    pub scale_hh: [[f32; HIDDEN]; 3],
    /// Added inside `r ⊙ (…)` of the new gate.
    pub bias_n: [f32; HIDDEN],
}

impl<const INPUT: usize, const HIDDEN: usize> Int8Gru<INPUT, HIDDEN> {
    /// The weights of a cell, each row rounded to 255 steps.
    pub fn of(cell: &Gru<INPUT, HIDDEN>) -> Self {
        let mut rounded = Self {
            weight_ih: [[[0; INPUT]; HIDDEN]; 3],
            scale_ih: [[0.0; HIDDEN]; 3],
            bias: cell.bias,
            weight_hh: [[[0; HIDDEN]; HIDDEN]; 3],
            scale_hh: [[0.0; HIDDEN]; 3],
            bias_n: cell.bias_n,
        };
        round(
            &mut rounded.weight_ih,
            &mut rounded.scale_ih,
            &cell.weight_ih,
        );
        round(
            &mut rounded.weight_hh,
            &mut rounded.scale_hh,
            &cell.weight_hh,
        );
        rounded
    }

    /// As [`Gru::step`]. Cost: the same, its multiply-adds on whole numbers.
    pub fn step(&self, input: &[f32; INPUT], hidden: &[f32; HIDDEN]) -> [f32; HIDDEN] {
        widest(Step {
            cell: self,
            input,
            hidden,
        })
    }
}

/// Rounds the rows of three gates.
fn round<const COLUMNS: usize, const HIDDEN: usize>(
    rounded: &mut [[[i8; COLUMNS]; HIDDEN]; 3],
    scales: &mut [[f32; HIDDEN]; 3],
    columns: &[[[f32; HIDDEN]; 3]; COLUMNS],
) {
    for (gate, (rows, scales)) in rounded.iter_mut().zip(scales).enumerate() {
        for (unit, (row, scale)) in rows.iter_mut().zip(scales).enumerate() {
            let weight = |gates: &[[f32; HIDDEN]; 3]| {
                let weight = gates.get(gate).and_then(|gate| gate.get(unit));
                weight.copied().unwrap_or(0.0)
            };
            *scale = round_row(row, columns.iter().map(weight));
        }
    }
}

/// See [`Int8Gru::step`].
struct Step<'a, const INPUT: usize, const HIDDEN: usize> {
    cell: &'a Int8Gru<INPUT, HIDDEN>,
    input: &'a [f32; INPUT],
    hidden: &'a [f32; HIDDEN],
}

impl<const INPUT: usize, const HIDDEN: usize> Kernel for Step<'_, INPUT, HIDDEN> {
    type Output = [f32; HIDDEN];

    #[inline(always)]
    fn run(self) -> [f32; HIDDEN] {
        const { assert!(INPUT > 0 && HIDDEN > 0) };
        let Self { cell, hidden, .. } = self;
        let (input, state) = (Quantized::new(self.input), Quantized::new(hidden));
        let [mut reset, mut update, mut input_new] = cell.bias;
        let mut recurrent_new = cell.bias_n;
        let inputs = [&mut reset, &mut update, &mut input_new];
        for ((sum, rows), scale) in inputs.into_iter().zip(&cell.weight_ih).zip(&cell.scale_ih) {
            add_rows(sum, rows, scale, 0, &input);
        }
        let states = [&mut reset, &mut update, &mut recurrent_new];
        for ((sum, rows), scale) in states.into_iter().zip(&cell.weight_hh).zip(&cell.scale_hh) {
            add_rows(sum, rows, scale, 0, &state);
        }
        gated(hidden, [&reset, &update, &input_new, &recurrent_new])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A different number in every place.
    fn cell() -> Gru<3, 5> {
        let number = |index: usize| libm::sinf(index as f32 * 1.7);
        Gru {
            weight_ih: core::array::from_fn(|input| {
                core::array::from_fn(|gate| {
                    core::array::from_fn(|unit| number(input * 15 + gate * 5 + unit))
                })
            }),
            bias: core::array::from_fn(|gate| {
                core::array::from_fn(|unit| number(100 + gate * 5 + unit))
            }),
            weight_hh: core::array::from_fn(|input| {
                core::array::from_fn(|gate| {
                    core::array::from_fn(|unit| number(200 + input * 15 + gate * 5 + unit))
                })
            }),
            bias_n: core::array::from_fn(|unit| number(300 + unit)),
        }
    }

    #[test]
    fn a_step_is_that_of_the_cell_within_the_rounding_of_its_weights() {
        let cell = cell();
        let small = Int8Gru::of(&cell);
        let (mut state, mut rounded) = ([0.3, -0.9, 0.0, 0.5, -0.2], [0.3, -0.9, 0.0, 0.5, -0.2]);
        for step in 0..20 {
            let input = [0.8, -0.5, 0.3].map(|value| value * libm::cosf(step as f32));
            state = cell.step(&input, &state);
            rounded = small.step(&input, &rounded);
            for (got, expected) in rounded.iter().zip(state) {
                assert!(
                    (got - expected).abs() < 0.02,
                    "{step}: {rounded:?} {state:?}"
                );
            }
        }
    }

    #[test]
    fn the_width_of_the_vectors_does_not_change_a_bit() {
        let small = Int8Gru::of(&cell());
        let (input, hidden) = (&[0.7, -0.1, 0.4], &[0.1, 0.2, -0.3, 0.4, -0.5]);
        let kernel = Step {
            cell: &small,
            input,
            hidden,
        };
        let wide = small.step(input, hidden);
        assert_eq!(wide.map(f32::to_bits), kernel.run().map(f32::to_bits));
    }

    #[test]
    fn an_unset_cell_gives_nothing_that_is_finite() {
        for unset in [Int8Gru::<3, 5>::new(), Int8Gru::of(&Gru::new())] {
            let state = unset.step(&[0.5; 3], &[0.0; 5]);
            assert!(state.iter().all(|value| value.is_nan()));
        }
    }
}
