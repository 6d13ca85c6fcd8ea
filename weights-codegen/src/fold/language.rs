//! Sentence encoder, decoders and splitter (section IV-B).

use nsrm_core::model::{
    ENCODER_HIDDEN, INSTRUCTION, SPLITTER_HIDDEN, SPLITTER_WORD, WORD, WordParameters,
};
use nsrm_core::nn::{Gru, Linear};

use super::finite;
use crate::error::ModelError;
use crate::nn::{Gates, gru, linear};
use crate::tensors::Tensors;

/// Columns of the hazard's hidden layer: state, next token, token after the next.
const HAZARD_INPUT: usize = SPLITTER_HIDDEN + 2 * SPLITTER_WORD;

/// The language module's parameters.
#[derive(Debug)]
pub(crate) struct FoldedLanguage {
    /// The group token, then the words in the vocabulary's order.
    pub(crate) words: Vec<WordParameters>,
    pub(crate) forward: Box<Gru<ENCODER_HIDDEN>>,
    pub(crate) backward: Box<Gru<ENCODER_HIDDEN>>,
    pub(crate) object_decoder: Box<Linear<INSTRUCTION, INSTRUCTION>>,
    pub(crate) reference_decoder: Box<Linear<INSTRUCTION, INSTRUCTION>>,
    pub(crate) splitter: Box<Gru<SPLITTER_HIDDEN>>,
    pub(crate) hazard_hidden: Box<Linear<SPLITTER_HIDDEN, SPLITTER_HIDDEN>>,
    pub(crate) hazard: Box<Linear<SPLITTER_HIDDEN, 1>>,
}

impl FoldedLanguage {
    /// * `words`: length of the vocabulary, including the group token
    pub(crate) fn read(tensors: &mut Tensors, words: usize) -> Result<Self, ModelError> {
        let embeddings = tensors.rows::<WORD>("language.embedding.weight", words)?;
        let (forward_gates, forward) =
            gru::<ENCODER_HIDDEN, WORD>(tensors, "language.encoder.forward")?;
        let (backward_gates, backward) =
            gru::<ENCODER_HIDDEN, WORD>(tensors, "language.encoder.backward")?;
        let splitter_embeddings =
            tensors.rows::<SPLITTER_WORD>("language.splitter.embedding.weight", words)?;
        let (splitter_gates, splitter) =
            gru::<SPLITTER_HIDDEN, SPLITTER_WORD>(tensors, "language.splitter.gru")?;
        let hazard =
            tensors.columns::<SPLITTER_HIDDEN, HAZARD_INPUT>("language.splitter.hidden.weight")?;
        let folding = Folding {
            forward: &forward_gates,
            backward: &backward_gates,
            splitter: &splitter_gates,
            hazard: &hazard,
        };
        let words = embeddings
            .iter()
            .zip(&splitter_embeddings)
            .map(|(embedding, splitter)| folding.word(embedding, splitter))
            .collect::<Result<Vec<WordParameters>, ModelError>>()?;
        Ok(Self {
            words,
            forward: Box::new(forward),
            backward: Box::new(backward),
            object_decoder: Box::new(linear(tensors, "language.object_decoder")?),
            reference_decoder: Box::new(linear(tensors, "language.reference_decoder")?),
            splitter: Box::new(splitter),
            hazard_hidden: Box::new(
                Linear::new()
                    .with_weight(std::array::from_fn(|column| hazard[column]))
                    .with_bias(tensors.vector("language.splitter.hidden.bias")?),
            ),
            hazard: Box::new(linear(tensors, "language.splitter.hazard")?),
        })
    }
}

/// The parameters that are folded into each word's embeddings.
struct Folding<'a> {
    forward: &'a Gates,
    backward: &'a Gates,
    splitter: &'a Gates,
    hazard: &'a [[f32; SPLITTER_HIDDEN]; HAZARD_INPUT],
}

impl Folding<'_> {
    fn word(
        &self,
        embedding: &[f32; WORD],
        splitter: &[f32; SPLITTER_WORD],
    ) -> Result<WordParameters, ModelError> {
        let (next, after_next) = self.hazard[SPLITTER_HIDDEN..].split_at(SPLITTER_WORD);
        let word = WordParameters::new()
            .with_forward_gates(self.forward.fold(embedding))
            .with_backward_gates(self.backward.fold(embedding))
            .with_splitter_gates(self.splitter.fold(splitter))
            .with_hazard_next(share(next, splitter))
            .with_hazard_after_next(share(after_next, splitter));
        finite("words.forward_gates", word.forward_gates.as_flattened())?;
        finite("words.backward_gates", word.backward_gates.as_flattened())?;
        finite("words.splitter_gates", word.splitter_gates.as_flattened())?;
        finite("words.hazard_next", &word.hazard_next)?;
        finite("words.hazard_after_next", &word.hazard_after_next)?;
        Ok(word)
    }
}

/// `Σ_j e[j]·columns[j]`, summed in `f64`.
fn share(
    columns: &[[f32; SPLITTER_HIDDEN]],
    embedding: &[f32; SPLITTER_WORD],
) -> [f32; SPLITTER_HIDDEN] {
    std::array::from_fn(|row| {
        let product: f64 = columns
            .iter()
            .zip(embedding)
            .map(|(column, &value)| f64::from(column[row]) * f64::from(value))
            .sum();
        product as f32
    })
}
