use heapless::Vec;

use crate::capacity::MAX_GROUPS;
use crate::model::{ENCODER_HIDDEN, INSTRUCTION, Language, WORD};

/// The sentence encoder on the tokens of one step: a GRU in each direction
/// (section IV-B). Of the states in between only those at concept groups are kept.
#[derive(Debug, Clone)]
pub struct Encoder {
    forward: [f32; ENCODER_HIDDEN],
    backward: [f32; ENCODER_HIDDEN],
    /// State at each group: forward half, backward half.
    groups: Vec<[f32; INSTRUCTION], MAX_GROUPS, u8>,
    /// Groups that the backward cell has not reached.
    groups_ahead: usize,
}

impl Encoder {
    /// Both cells in their zero state.
    pub const fn new() -> Self {
        Self {
            forward: [0.0; ENCODER_HIDDEN],
            backward: [0.0; ENCODER_HIDDEN],
            groups: Vec::new(),
            groups_ahead: 0,
        }
    }

    /// Forgets the step.
    pub fn clear(&mut self) {
        self.forward = [0.0; ENCODER_HIDDEN];
        self.backward = [0.0; ENCODER_HIDDEN];
        self.groups.clear();
        self.groups_ahead = 0;
    }

    /// Feeds the next token to the forward cell, from the first to the last; false if it is a group
    /// and [`MAX_GROUPS`] have been fed.
    ///
    /// Cost: `3·48·(32 + 48)` multiply-adds, 96 sigmoids and 48 hyperbolic tangents.
    pub fn forward(&mut self, language: &Language<'_>, token: &[f32; WORD], group: bool) -> bool {
        self.forward = language.forward.step(token, &self.forward);
        if group {
            let state = join(&self.forward, &[0.0; ENCODER_HIDDEN]);
            if self.groups.push(state).is_err() {
                return false;
            }
            self.groups_ahead += 1;
        }
        true
    }

    /// Feeds the previous token to the backward cell, from the last to the first. Cost: as
    /// [`Encoder::forward`].
    pub fn backward(&mut self, language: &Language<'_>, token: &[f32; WORD], group: bool) {
        self.backward = language.backward.step(token, &self.backward);
        if group {
            self.groups_ahead = self.groups_ahead.saturating_sub(1);
            if let Some(state) = self.groups.get_mut(self.groups_ahead) {
                let backward_half = state.iter_mut().skip(ENCODER_HIDDEN);
                for (state, value) in backward_half.zip(self.backward) {
                    *state = value;
                }
            }
        }
    }

    /// The forward cell's state.
    pub const fn ahead(&self) -> &[f32; ENCODER_HIDDEN] {
        &self.forward
    }

    /// The backward cell's state.
    pub const fn behind(&self) -> &[f32; ENCODER_HIDDEN] {
        &self.backward
    }

    /// The instruction's embedding `emb(Λ)`: the forward cell's last state and the backward cell's,
    /// once both have been fed all tokens.
    pub fn instruction(&self) -> [f32; INSTRUCTION] {
        join(&self.forward, &self.backward)
    }

    /// State at each group, in the order of the sentence, once both cells have been fed all tokens.
    pub fn groups(&self) -> &[[f32; INSTRUCTION]] {
        &self.groups
    }
}

impl Default for Encoder {
    fn default() -> Self {
        Self::new()
    }
}

fn join(forward: &[f32; ENCODER_HIDDEN], backward: &[f32; ENCODER_HIDDEN]) -> [f32; INSTRUCTION] {
    let mut joined = [0.0; INSTRUCTION];
    for (place, &value) in joined.iter_mut().zip(forward.iter().chain(backward)) {
        *place = value;
    }
    joined
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture;
    use crate::nn::Cell;

    /// A forward and a backward cell that add up 1, 10, 100 … and so tell which
    /// tokens they have seen: `tanh` is nearly straight so close to zero.
    #[test]
    fn states_at_groups_hold_both_directions() {
        let model = fixture::model();
        let mut language = model.language;
        let mut cell = *language.forward.as_f32().unwrap();
        // reset → 1, update → 0, new = input + h; the first cell adds the word to its first unit,
        // the other to its last one.
        cell.bias = [[20.0; ENCODER_HIDDEN], [-20.0; ENCODER_HIDDEN], [0.0; 48]];
        for unit in 0..ENCODER_HIDDEN {
            cell.weight_hh[unit][2][unit] = 1.0;
        }
        cell.weight_ih = [[[0.0; ENCODER_HIDDEN]; 3]; WORD];
        let mut backward = cell;
        cell.weight_ih[0][2][0] = 1.0;
        backward.weight_ih[0][2][47] = 1.0;
        (language.forward, language.backward) = (Cell::F32(&cell), Cell::F32(&backward));
        let tokens = [1e-6, 1e-5, 1e-4, 1e-3].map(|value| {
            let mut token = [0.0; WORD];
            token[0] = value;
            token
        });
        let groups = [false, true, true, false];
        let mut encoder = Encoder::new();
        // What another sentence left is forgotten.
        encoder.forward(&language, &tokens[3], true);
        encoder.backward(&language, &tokens[3], true);
        encoder.clear();
        for (token, group) in tokens.iter().zip(groups) {
            assert!(encoder.forward(&language, token, group));
        }
        for (token, group) in tokens.iter().zip(groups).rev() {
            encoder.backward(&language, token, group);
        }
        let ends = |state: &[f32; INSTRUCTION]| [state[0], state[95]];
        let close = |got: [f32; 2], expected: [f32; 2]| {
            let near = |(a, b): (f32, f32)| (a - b).abs() < 1e-3 * b;
            assert!(got.into_iter().zip(expected).all(near), "{got:?}");
        };
        let [second, third] = encoder.groups() else {
            panic!("two groups");
        };
        close(ends(second), [1.1e-5, 1.11e-3]);
        close(ends(third), [1.11e-4, 1.1e-3]);
        close(ends(&encoder.instruction()), [1.111e-3, 1.111e-3]);
    }

    #[test]
    fn one_group_too_many_is_refused() {
        let model = fixture::model();
        let mut encoder = Encoder::new();
        for _ in 0..MAX_GROUPS {
            assert!(encoder.forward(&model.language, &[0.0; WORD], true));
        }
        assert!(!encoder.forward(&model.language, &[0.0; WORD], true));
        assert!(encoder.forward(&model.language, &[0.0; WORD], false));
        assert_eq!(encoder.groups().len(), MAX_GROUPS);
    }
}
