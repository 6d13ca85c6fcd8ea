//! Sentence encoder, decoders and splitter (section IV-B).

use nsrm_core::model::{
    ACCEPTABILITY_HIDDEN, ENCODER_HIDDEN, HAZARD_INPUT, INSTRUCTION, SPLITTER_HIDDEN,
    SPLITTER_WORD, WORD, WordEmbeddings,
};
use nsrm_core::nn::{Gru, Linear};

use crate::error::ModelError;
use crate::nn::{gru, linear};
use crate::tensors::Tensors;

/// The language module's parameters.
#[derive(Debug)]
pub(crate) struct FoldedLanguage {
    /// The group token, then the words in the vocabulary's order.
    pub(crate) words: Vec<WordEmbeddings>,
    pub(crate) forward: Box<Gru<WORD, ENCODER_HIDDEN>>,
    pub(crate) backward: Box<Gru<WORD, ENCODER_HIDDEN>>,
    pub(crate) object_decoder: Box<Linear<INSTRUCTION, INSTRUCTION>>,
    pub(crate) reference_decoder: Box<Linear<INSTRUCTION, INSTRUCTION>>,
    pub(crate) acceptability_hidden: Box<Linear<INSTRUCTION, ACCEPTABILITY_HIDDEN>>,
    pub(crate) acceptability: Box<Linear<ACCEPTABILITY_HIDDEN, 1>>,
    pub(crate) splitter: Box<Gru<SPLITTER_WORD, SPLITTER_HIDDEN>>,
    pub(crate) hazard_hidden: Box<Linear<HAZARD_INPUT, SPLITTER_HIDDEN>>,
    pub(crate) hazard: Box<Linear<SPLITTER_HIDDEN, 1>>,
}

impl FoldedLanguage {
    /// * `words`: length of the vocabulary, including the group token
    pub(crate) fn read(tensors: &mut Tensors, words: usize) -> Result<Self, ModelError> {
        let encoder = tensors.rows::<WORD>("language.embedding.weight", words)?;
        let splitter =
            tensors.rows::<SPLITTER_WORD>("language.splitter.embedding.weight", words)?;
        let words = encoder
            .into_iter()
            .zip(splitter)
            .map(|(encoder, splitter)| {
                WordEmbeddings::new()
                    .with_encoder(encoder)
                    .with_splitter(splitter)
            });
        Ok(Self {
            words: words.collect(),
            forward: Box::new(gru(tensors, "language.encoder.forward")?),
            backward: Box::new(gru(tensors, "language.encoder.backward")?),
            object_decoder: Box::new(linear(tensors, "language.object_decoder")?),
            reference_decoder: Box::new(linear(tensors, "language.reference_decoder")?),
            acceptability_hidden: Box::new(linear(tensors, "language.acceptability.hidden")?),
            acceptability: Box::new(linear(tensors, "language.acceptability.output")?),
            splitter: Box::new(gru(tensors, "language.splitter.gru")?),
            hazard_hidden: Box::new(linear(tensors, "language.splitter.hidden")?),
            hazard: Box::new(linear(tensors, "language.splitter.hazard")?),
        })
    }
}
