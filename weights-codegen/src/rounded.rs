//! The large layers in whole numbers of eight bits.

use nsrm_core::model::{
    ACCEPTABILITY_HIDDEN, ENCODER_HIDDEN, HAZARD_INPUT, INSTRUCTION, Int8WordEmbeddings, MERGED,
    SIMULATOR_HIDDEN, SPLITTER_HIDDEN, SPLITTER_WORD, VIEW_EMBEDDING, WORD,
};
use nsrm_core::nn::{Int8Gru, Int8Linear};

use crate::fold::Folded;

/// What takes most of a model's memory, each row with its scale. The rest stays `f32`.
#[derive(Debug)]
pub(crate) struct Rounded {
    pub(crate) words: Vec<Int8WordEmbeddings>,
    pub(crate) forward: Int8Gru<WORD, ENCODER_HIDDEN>,
    pub(crate) backward: Int8Gru<WORD, ENCODER_HIDDEN>,
    pub(crate) object_decoder: Int8Linear<INSTRUCTION, INSTRUCTION>,
    pub(crate) reference_decoder: Int8Linear<INSTRUCTION, INSTRUCTION>,
    pub(crate) acceptability_hidden: Int8Linear<INSTRUCTION, ACCEPTABILITY_HIDDEN>,
    pub(crate) splitter: Int8Gru<SPLITTER_WORD, SPLITTER_HIDDEN>,
    pub(crate) hazard_hidden: Int8Linear<HAZARD_INPUT, SPLITTER_HIDDEN>,
    pub(crate) color_dense: Int8Linear<MERGED, VIEW_EMBEDDING>,
    pub(crate) brightness_dense: Int8Linear<MERGED, VIEW_EMBEDDING>,
    pub(crate) simulator_hidden: Int8Linear<SIMULATOR_HIDDEN, SIMULATOR_HIDDEN>,
}

impl Rounded {
    pub(crate) fn of(folded: &Folded) -> Self {
        let (language, vision) = (&folded.language, &folded.vision);
        Self {
            words: language.words.iter().map(Int8WordEmbeddings::of).collect(),
            forward: Int8Gru::of(&language.forward),
            backward: Int8Gru::of(&language.backward),
            object_decoder: Int8Linear::of(&language.object_decoder),
            reference_decoder: Int8Linear::of(&language.reference_decoder),
            acceptability_hidden: Int8Linear::of(&language.acceptability_hidden),
            splitter: Int8Gru::of(&language.splitter),
            hazard_hidden: Int8Linear::of(&language.hazard_hidden),
            color_dense: Int8Linear::of(&vision.color.dense),
            brightness_dense: Int8Linear::of(&vision.brightness.dense),
            simulator_hidden: Int8Linear::of(&folded.actions.simulator.hidden),
        }
    }
}
