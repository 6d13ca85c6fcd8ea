use heapless::Vec;

use crate::capacity::MAX_GROUPS;
use crate::model::{ENCODER_HIDDEN, INSTRUCTION, Language, WordParameters};

/// The sentence encoder on the tokens of one step: a GRU in each direction
/// (section IV-B). Of the states in between only those at concept groups are kept.
#[derive(Debug, Clone)]
pub struct Encoder {
    forward: [f32; ENCODER_HIDDEN],
    backward: [f32; ENCODER_HIDDEN],
    /// State at each group: forward half, backward half.
    groups: Vec<[f32; INSTRUCTION], MAX_GROUPS, u8>,
    /// Groups that the backward cell has not come to.
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

    /// The forward cell takes in the next token, from the first to the last; false
    /// when it is a group and [`MAX_GROUPS`] have been seen.
    ///
    /// Cost: `3·48²` multiply-adds, 96 sigmoids and 48 hyperbolic tangents.
    pub fn forward(
        &mut self,
        language: &Language<'_>,
        token: &WordParameters,
        group: bool,
    ) -> bool {
        self.forward = language.forward.step(&token.forward_gates, &self.forward);
        if group {
            let state = join(&self.forward, &[0.0; ENCODER_HIDDEN]);
            if self.groups.push(state).is_err() {
                return false;
            }
            self.groups_ahead += 1;
        }
        true
    }

    /// The backward cell takes in the token before, from the last to the first.
    /// Cost: as [`Encoder::forward`].
    pub fn backward(&mut self, language: &Language<'_>, token: &WordParameters, group: bool) {
        self.backward = language
            .backward
            .step(&token.backward_gates, &self.backward);
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

    /// The instruction's embedding `emb(Λ)`: the forward cell's last state and the
    /// backward cell's, once both have seen all tokens.
    pub fn instruction(&self) -> [f32; INSTRUCTION] {
        join(&self.forward, &self.backward)
    }

    /// State at each group, in the order of the sentence, once both cells have
    /// seen all tokens.
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
