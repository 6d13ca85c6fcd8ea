//! Converts tensors to the parameters that core reads: transposed, with every product that depends
//! only on the model computed once, in `f64`.

mod language;
mod simulator;
mod vision;

use nsrm_core::model::PixelToCamera;

pub(crate) use language::FoldedLanguage;
pub(crate) use simulator::FoldedActions;
pub(crate) use vision::{FoldedView, FoldedVision};

use crate::error::ModelError;
use crate::metadata::Metadata;
use crate::tensors::Tensors;

/// All parameters of a model, without the texts.
#[derive(Debug)]
pub(crate) struct Folded {
    pub(crate) language: FoldedLanguage,
    pub(crate) vision: FoldedVision,
    pub(crate) actions: FoldedActions,
    pub(crate) camera: PixelToCamera,
}

impl Folded {
    /// Takes every tensor; refuses any left over.
    pub(crate) fn read(mut tensors: Tensors, metadata: &Metadata) -> Result<Self, ModelError> {
        let domain = &metadata.domain;
        let language = FoldedLanguage::read(&mut tensors, metadata.vocabulary.len())?;
        let vision = FoldedVision::read(&mut tensors, domain)?;
        let actions = simulator::read(&mut tensors, domain.action.len())?;
        let [x, y, z] = tensors
            .rows("camera.weight", 3)?
            .try_into()
            .unwrap_or_else(|rows: Vec<[f32; 6]>| unreachable!("{} rows of 3", rows.len()));
        tensors.finish()?;
        Ok(Self {
            language,
            vision,
            actions,
            camera: PixelToCamera::new().with_weight([x, y, z]),
        })
    }
}

/// Refuses a folded array that overflowed.
fn finite<'a>(name: &str, values: impl IntoIterator<Item = &'a f32>) -> Result<(), ModelError> {
    if values.into_iter().all(|value| value.is_finite()) {
        return Ok(());
    }
    Err(ModelError::FoldedNotFinite { name: name.into() })
}
