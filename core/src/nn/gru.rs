use super::{Kernel, add_row_products, sigmoid, tanh, widest};

/// A GRU cell.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
// A cache line: no vector of a column lies across two.
#[repr(align(64))]
pub struct Gru<const INPUT: usize, const HIDDEN: usize> {
    /// For each input its column in the reset, update and new gate.
    pub weight_ih: [[[f32; HIDDEN]; 3]; INPUT],
    /// Added to the reset, update and new gate.
    pub bias: [[f32; HIDDEN]; 3],
    /// For each hidden unit its column in the reset, update and new gate.
    pub weight_hh: [[[f32; HIDDEN]; 3]; HIDDEN],
    /// Added inside `r ⊙ (…)` of the new gate.
    pub bias_n: [f32; HIDDEN],
}

impl<const INPUT: usize, const HIDDEN: usize> Gru<INPUT, HIDDEN> {
    /// One step: `h' = n + z ⊙ (h − n)`, where `g = W_ih·x + b`,
    /// `r = σ(g_r + W_r·h)`, `z = σ(g_z + W_z·h)`, `n = tanh(g_n + r ⊙ (W_n·h + b_n))`.
    ///
    /// * `input`: `x`
    /// * `hidden`: the previous state `h`
    ///
    /// Cost: `3·HIDDEN·(INPUT + HIDDEN)` multiply-adds and `3·HIDDEN` scalar functions.
    /// Convention: that of `equinox.nn.GRUCell` (and `torch.nn.GRU`).
    pub fn step(&self, input: &[f32; INPUT], hidden: &[f32; HIDDEN]) -> [f32; HIDDEN] {
        widest(Step {
            cell: self,
            input,
            hidden,
        })
    }
}

/// See [`Gru::step`].
struct Step<'a, const INPUT: usize, const HIDDEN: usize> {
    cell: &'a Gru<INPUT, HIDDEN>,
    input: &'a [f32; INPUT],
    hidden: &'a [f32; HIDDEN],
}

impl<const INPUT: usize, const HIDDEN: usize> Kernel for Step<'_, INPUT, HIDDEN> {
    type Output = [f32; HIDDEN];

    #[inline(always)]
    fn run(self) -> [f32; HIDDEN] {
        const { assert!(INPUT > 0 && HIDDEN > 0) };
        let Self {
            cell,
            input,
            hidden,
        } = self;
        let [mut reset, mut update, mut input_new] = cell.bias;
        let mut recurrent_new = cell.bias_n;
        add_row_products::<HIDDEN, 3, 0>(&mut reset, input, &cell.weight_ih);
        add_row_products::<HIDDEN, 3, 1>(&mut update, input, &cell.weight_ih);
        add_row_products::<HIDDEN, 3, 2>(&mut input_new, input, &cell.weight_ih);
        add_row_products::<HIDDEN, 3, 0>(&mut reset, hidden, &cell.weight_hh);
        add_row_products::<HIDDEN, 3, 1>(&mut update, hidden, &cell.weight_hh);
        add_row_products::<HIDDEN, 3, 2>(&mut recurrent_new, hidden, &cell.weight_hh);
        gated(hidden, [&reset, &update, &input_new, &recurrent_new])
    }
}

/// The next state.
///
/// * `sums`: before the functions: reset, update, and the input's and the state's share of new
#[inline(always)]
pub(super) fn gated<const HIDDEN: usize>(
    hidden: &[f32; HIDDEN],
    sums: [&[f32; HIDDEN]; 4],
) -> [f32; HIDDEN] {
    let [reset, update, input_new, recurrent_new] = sums;
    let mut next = *hidden;
    let gated = reset.iter().zip(update);
    let candidates = input_new.iter().zip(recurrent_new);
    for (state, ((&r, &z), (&input, &recurrent))) in next.iter_mut().zip(gated.zip(candidates)) {
        let new = tanh(input + sigmoid(r) * recurrent);
        *state = new + sigmoid(z) * (*state - new);
    }
    next
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two units with different numbers in every place: swapping gates, rows,
    /// columns or the place of `bias_n` changes the result.
    #[test]
    fn a_step_agrees_with_numbers_worked_out_by_hand() {
        let cell = Gru::<1, 2> {
            weight_ih: [[[0.25, -0.5], [0.1, -0.05], [0.4, 0.2]]],
            bias: [[0.0, 0.5], [0.0, 0.0], [0.2, -0.1]],
            weight_hh: [
                [[0.1, -0.2], [0.3, 0.4], [-0.5, 0.6]],
                [[0.7, 0.8], [-0.9, 1.0], [1.1, -1.2]],
            ],
            bias_n: [0.25, -0.75],
        };
        // The input's share: [0.5, −0.5], [0.2, −0.1], [1.0, 0.3].
        let next = cell.step(&[2.0], &[0.6, -0.4]);
        // unit 0: r = σ(0.5 + 0.06 − 0.28) = 0.569_546_22, z = σ(0.2 + 0.18 + 0.36) = 0.676_995_86,
        //   n = tanh(1.0 + r·(0.25 − 0.30 − 0.44)) = tanh(0.720_922_35) = 0.617_480_3
        // unit 1: r = σ(−0.5 − 0.12 − 0.32) = 0.280_900_3, z = σ(−0.1 + 0.24 − 0.40) = 0.435_363_71,
        //   n = tanh(0.3 + r·(−0.75 + 0.36 + 0.48)) = tanh(0.325_281_03) = 0.314_274_22
        let expected = [0.605_646_2, 0.003_305_15];
        for (got, expected) in next.iter().zip(expected) {
            assert!((got - expected).abs() < 2e-6, "{next:?}");
        }
    }

    #[test]
    fn an_open_update_gate_keeps_the_state_even_under_saturation() {
        let cell = Gru::<1, 3> {
            weight_ih: [[[-3e38; 3], [3e38; 3], [3e38; 3]]],
            bias: [[0.0; 3]; 3],
            weight_hh: [[[0.0; 3]; 3]; 3],
            bias_n: [0.0; 3],
        };
        let state = [0.5, -0.25, 0.0];
        assert_eq!(cell.step(&[1.0], &state), state);
    }
}
