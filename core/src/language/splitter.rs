use crate::model::{Language, SPLITTER_HIDDEN, WordParameters};
use crate::nn::{sigmoid, tanh_all};

/// A hazard above this ends the step. Below 1 − h > h: not splitting is likelier.
pub const SPLIT_HAZARD: f32 = 0.5;

/// Finds where the first step of what remains of a sentence ends (section IV-B).
///
/// `h_t = σ(hazard(tanh(hidden(GRU state at t, the next token, the one after))))`
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
    /// Before the first token of what remains.
    pub const fn new() -> Self {
        Self {
            hidden: [0.0; SPLITTER_HIDDEN],
            survival: 1.0,
        }
    }

    /// Takes in a token that others follow; its hazard.
    ///
    /// * `after_next`: `None` past the end of the sentence, where zeros stand
    ///
    /// Cost: `4·32² + 32` multiply-adds, 65 sigmoids and 64 hyperbolic tangents.
    pub fn hazard(
        &mut self,
        language: &Language<'_>,
        token: &WordParameters,
        next: &WordParameters,
        after_next: Option<&WordParameters>,
    ) -> f32 {
        self.hidden = language.splitter.step(&token.splitter_gates, &self.hidden);
        let mut features = language.hazard_hidden.apply(&self.hidden);
        crate::nn::accumulate(&mut features, 1.0, &next.hazard_next);
        if let Some(token) = after_next {
            crate::nn::accumulate(&mut features, 1.0, &token.hazard_after_next);
        }
        tanh_all(&mut features);
        let [logit] = language.hazard.apply(&features);
        sigmoid(logit)
    }

    /// Whether the step ends at a token with this hazard: its probability, or
    /// `None` where it goes on.
    pub fn decide(&mut self, hazard: f32) -> Option<f32> {
        if hazard > SPLIT_HAZARD {
            Some(self.survival * hazard)
        } else {
            self.survival *= 1.0 - hazard;
            None
        }
    }

    /// Probability that the step did not end at any token so far.
    pub const fn survival(&self) -> f32 {
        self.survival
    }
}

impl Default for Splitter {
    fn default() -> Self {
        Self::new()
    }
}
