use heapless::Vec;

use crate::capacity::MAX_STEP_TOKENS;
use crate::model::{ACCEPTABILITY_HIDDEN, ENCODER_HIDDEN, Language};
use crate::nn::{sigmoid, tanh_all};

/// Judges whether each word of a step stands where commands have it: a step is accepted if all its
/// words are. What nobody says is so refused, although all its words are known. Not in the paper.
///
/// The probability of a word is `σ(acceptability(tanh(hidden(encoder's states at the word))))`.
#[derive(Debug, Clone)]
pub struct Acceptability {
    /// The forward state's share in the hidden layer, for each token that is not judged yet.
    shares: Vec<[f32; ACCEPTABILITY_HIDDEN], MAX_STEP_TOKENS, u8>,
    probability: f32,
    least: Least,
}

/// The least acceptable token of a step.
#[derive(Debug, Clone, Copy)]
struct Least {
    /// Counted from the step's first one.
    token: usize,
    probability: f32,
}

impl Acceptability {
    /// Before the first token of a step.
    pub const fn new() -> Self {
        Self {
            shares: Vec::new(),
            probability: 1.0,
            least: Least {
                token: 0,
                probability: 1.0,
            },
        }
    }

    /// Forgets the step.
    pub fn clear(&mut self) {
        self.shares.clear();
        self.probability = 1.0;
        self.least = Self::new().least;
    }

    /// Takes the state of the encoder's forward cell at the next token, from the first to the last;
    /// false after [`MAX_STEP_TOKENS`].
    ///
    /// Cost: `48·16` multiply-adds.
    pub fn ahead(&mut self, language: &Language<'_>, state: &[f32; ENCODER_HIDDEN]) -> bool {
        let hidden = language.acceptability_hidden;
        let mut share = *hidden.bias();
        hidden.add_products(&mut share, 0, state);
        self.shares.push(share).is_ok()
    }

    /// Takes the state of the encoder's backward cell at the previous token, from the last to the
    /// first, and judges that token.
    ///
    /// Cost: `49·16` multiply-adds, a sigmoid and 16 hyperbolic tangents.
    pub fn behind(&mut self, language: &Language<'_>, state: &[f32; ENCODER_HIDDEN]) {
        let Some(mut features) = self.shares.pop() else {
            return;
        };
        let hidden = language.acceptability_hidden;
        hidden.add_products(&mut features, ENCODER_HIDDEN, state);
        tanh_all(&mut features);
        let probability = sigmoid(language.acceptability.single(&features));
        self.probability *= probability;
        if probability < self.least.probability {
            self.least = Least {
                token: self.shares.len(),
                probability,
            };
        }
    }

    /// The probability that all tokens are acceptable, once all are judged.
    pub const fn probability(&self) -> f32 {
        self.probability
    }

    /// The least acceptable token, counted from the step's first one.
    pub const fn least(&self) -> usize {
        self.least.token
    }
}

impl Default for Acceptability {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture;
    use crate::nn::{Dense, Linear};

    /// Unit 5 sums the first element of the forward state and the last one of the backward state.
    fn layers() -> (
        Linear<96, ACCEPTABILITY_HIDDEN>,
        Linear<ACCEPTABILITY_HIDDEN, 1>,
    ) {
        let mut hidden = fixture::linear();
        hidden.weight[0][5] = 0.5;
        hidden.weight[95][5] = 2.0;
        hidden.bias[5] = 0.1;
        let mut output = fixture::linear();
        output.weight[5] = [3.0];
        output.bias = [0.25];
        (hidden, output)
    }

    #[test]
    fn a_step_is_as_acceptable_as_all_its_words() {
        let (hidden, output) = layers();
        let mut language = fixture::model().language;
        (language.acceptability_hidden, language.acceptability) = (Dense::F32(&hidden), &output);
        let mut judge = Acceptability::new();
        let state = |place: usize, value: f32| {
            let mut state = [0.0; ENCODER_HIDDEN];
            state[place] = value;
            state
        };
        // What another step left is forgotten.
        assert!(judge.ahead(&language, &state(0, -9.0)));
        judge.behind(&language, &state(47, -9.0));
        judge.clear();
        for value in [0.2, -0.6, 0.4] {
            assert!(judge.ahead(&language, &state(0, value)));
        }
        for value in [0.3, -0.1, 0.2] {
            judge.behind(&language, &state(47, value));
        }
        let word = |ahead: f32, behind: f32| {
            sigmoid(3.0 * libm::tanhf(0.1 + 0.5 * ahead + 2.0 * behind) + 0.25)
        };
        let expected = word(0.2, 0.2) * word(-0.6, -0.1) * word(0.4, 0.3);
        assert!((judge.probability() - expected).abs() < 1e-6);
        assert_eq!(judge.least(), 1);
    }

    #[test]
    fn one_token_too_many_is_refused() {
        let language = fixture::model().language;
        let mut judge = Acceptability::new();
        for _ in 0..MAX_STEP_TOKENS {
            assert!(judge.ahead(&language, &[0.0; ENCODER_HIDDEN]));
        }
        assert!(!judge.ahead(&language, &[0.0; ENCODER_HIDDEN]));
    }
}
