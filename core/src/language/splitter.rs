use crate::model::{LOOKAHEAD, Language, SPLITTER_HIDDEN, SPLITTER_WORD, WordEmbeddings};
use crate::nn::{add_products, sigmoid, tanh_all};

/// A hazard above this ends the step. Below 1 − h > h: not splitting is likelier.
pub const SPLIT_HAZARD: f32 = 0.5;

/// Finds the end of the first step in the rest of a sentence (section IV-B).
///
/// `h_t = σ(hazard(tanh(hidden(GRU state at t, the next `[`LOOKAHEAD`]` tokens))))`
/// is the probability that the step ends at token t, given that it has not ended
/// before. The step ends at the first t with `h_t > ½`; its probability is
/// `h_t·Π_{s<t}(1 − h_s)`.
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
    pub fn hazard<'w>(
        &mut self,
        language: &Language<'_>,
        token: &WordEmbeddings,
        ahead: impl Iterator<Item = &'w WordEmbeddings>,
    ) -> f32 {
        self.hidden = language.splitter.step(&token.splitter, &self.hidden);
        let layer = language.hazard_hidden;
        let mut features = layer.bias;
        let (columns, mut rest) = layer.weight.split_at(SPLITTER_HIDDEN);
        add_products(&mut features, &self.hidden, columns);
        for token in ahead.take(LOOKAHEAD) {
            let (columns, behind) = rest.split_at(rest.len().min(SPLITTER_WORD));
            add_products(&mut features, &token.splitter, columns);
            rest = behind;
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
    use crate::model::HAZARD_INPUT;

    #[test]
    fn a_hazard_sees_the_state_and_the_six_tokens_behind() {
        let model = fixture::model();
        let mut language = model.language;
        let mut cell = *language.splitter;
        cell.weight_ih[23][2][31] = 1.0;
        let mut hidden = *language.hazard_hidden;
        hidden.weight = [[0.0; 32]; HAZARD_INPUT];
        hidden.weight[31][4] = 0.5;
        // Unit 2 of the next token, unit 3 of the last one seen.
        hidden.weight[32 + 2][4] = 1.0;
        hidden.weight[32 + 5 * 24 + 3][4] = 1.0;
        hidden.bias[4] = 0.1;
        let mut hazard = *language.hazard;
        hazard.weight = [[0.0]; 32];
        hazard.weight[4] = [2.0];
        hazard.bias = [-0.25];
        (language.hazard_hidden, language.hazard) = (&hidden, &hazard);
        language.splitter = &cell;
        let mut token = *model.group;
        token.splitter[23] = 0.8;
        let (mut next, mut last) = (*model.group, *model.group);
        (next.splitter[2], next.splitter[3]) = (0.3, 50.0);
        (last.splitter[2], last.splitter[3]) = (50.0, -0.7);
        let between = model.group;
        let ahead = [&next, between, between, between, between, &last, &last];
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
