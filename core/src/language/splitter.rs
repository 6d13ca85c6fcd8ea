use crate::model::{HAZARD_INPUT, Language, SPLITTER_HIDDEN, SPLITTER_WORD};
use crate::nn::{sigmoid, tanh_all};

/// A hazard above this ends the step. Below 1 − h > h: not splitting is likelier.
pub const SPLIT_HAZARD: f32 = 0.5;

/// Finds the end of the first step in the rest of a sentence (section IV-B).
///
/// `h_t = σ(hazard(tanh(hidden(GRU state at t, the next `[`LOOKAHEAD`]` tokens))))`
/// is the probability that the step ends at token t, given that it has not ended
/// before. The step ends at the first t with `h_t > ½`; its probability is
/// `h_t·Π_{s<t}(1 − h_s)`.
///
/// [`LOOKAHEAD`]: crate::model::LOOKAHEAD
#[derive(Debug, Clone)]
pub struct Splitter {
    hidden: [f32; SPLITTER_HIDDEN],
    /// `Π (1 − h_s)` over the tokens so far: the step has not ended.
    survival: f32,
}

impl Splitter {
    /// The state before the first token of the rest.
    pub const fn new() -> Self {
        Self {
            hidden: [0.0; SPLITTER_HIDDEN],
            survival: 1.0,
        }
    }

    /// Feeds a token that is not the last; returns its hazard.
    ///
    /// * `ahead`: the tokens behind it, of which at most [`LOOKAHEAD`] are looked at; zeros stand
    ///   for those after the end of the sentence
    ///
    /// Cost: `3·32·(24 + 32) + 32·(32 + 6·24) + 32` multiply-adds, 65 sigmoids and 64 hyperbolic
    /// tangents.
    ///
    /// [`LOOKAHEAD`]: crate::model::LOOKAHEAD
    pub fn hazard(
        &mut self,
        language: &Language<'_>,
        token: &[f32; SPLITTER_WORD],
        ahead: impl Iterator<Item = [f32; SPLITTER_WORD]>,
    ) -> f32 {
        self.hidden = language.splitter.step(token, &self.hidden);
        let layer = language.hazard_hidden;
        let mut features = *layer.bias();
        layer.add_products(&mut features, 0, &self.hidden);
        let firsts = (SPLITTER_HIDDEN..HAZARD_INPUT).step_by(SPLITTER_WORD);
        for (first, token) in firsts.zip(ahead) {
            layer.add_products(&mut features, first, &token);
        }
        tanh_all(&mut features);
        sigmoid(language.hazard.single(&features))
    }

    /// Whether the step ends at a token with this hazard: its probability, or `None` if it
    /// continues.
    pub fn decide(&mut self, hazard: f32) -> Option<f32> {
        let (ends, probability) = decision(hazard);
        self.follow(ends, probability)
    }

    /// Follows a decision that is right with this probability: see [`Splitter::decide`].
    pub(super) fn follow(&mut self, ends: bool, probability: f32) -> Option<f32> {
        let both = self.survival * probability;
        if !ends {
            self.survival = both;
        }
        ends.then_some(both)
    }

    /// Probability that the step did not end at any token so far.
    pub const fn survival(&self) -> f32 {
        self.survival
    }
}

/// Whether the step ends at a token with this hazard, and the probability that this is right.
pub(super) fn decision(hazard: f32) -> (bool, f32) {
    if hazard > SPLIT_HAZARD {
        (true, hazard)
    } else {
        (false, 1.0 - hazard)
    }
}

impl Default for Splitter {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture;
    use crate::nn::{Cell, Dense};

    #[test]
    fn a_hazard_sees_the_state_and_the_six_tokens_behind() {
        let model = fixture::model();
        let mut language = model.language;
        let mut cell = *language.splitter.as_f32().unwrap();
        cell.weight_ih[23][2][31] = 1.0;
        let mut hidden = fixture::linear();
        hidden.weight[31][4] = 0.5;
        // Unit 2 of the next token, unit 3 of the last one seen.
        hidden.weight[32 + 2][4] = 1.0;
        hidden.weight[32 + 5 * 24 + 3][4] = 1.0;
        hidden.bias[4] = 0.1;
        let mut hazard = *language.hazard;
        hazard.weight = [[0.0]; 32];
        hazard.weight[4] = [2.0];
        hazard.bias = [-0.25];
        (language.hazard_hidden, language.hazard) = (Dense::F32(&hidden), &hazard);
        language.splitter = Cell::F32(&cell);
        let between = [0.0; SPLITTER_WORD];
        let (mut token, mut next, mut last) = (between, between, between);
        token[23] = 0.8;
        (next[2], next[3]) = (0.3, 50.0);
        (last[2], last[3]) = (50.0, -0.7);
        let ahead = [next, between, between, between, between, last, last];
        // State of unit 31: half of tanh(0.8), as the update gate is σ(0).
        let state = 0.5 * libm::tanhf(0.8);
        let expected = |ahead: f32| sigmoid(2.0 * libm::tanhf(0.5 * state + 0.1 + ahead) - 0.25);
        let got = Splitter::new().hazard(&language, &token, ahead.into_iter());
        assert!((got - expected(0.3 - 0.7)).abs() < 1e-6, "{got}");
        let got = Splitter::new().hazard(&language, &token, ahead.into_iter().take(5));
        assert!((got - expected(0.3)).abs() < 1e-6, "{got}");
    }

    #[test]
    fn a_step_ends_where_the_hazard_passes_one_half() {
        let mut splitter = Splitter::new();
        assert_eq!(splitter.decide(0.25), None);
        assert_eq!(splitter.decide(0.5), None);
        assert_eq!(splitter.survival(), 0.375);
        assert_eq!(splitter.decide(0.75), Some(0.281_25));
    }
}
