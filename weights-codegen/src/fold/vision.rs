//! Crop encoder, attribute operators and concepts (section IV-C).

use nsrm_core::model::{
    CONCEPT, MERGE_CHANNELS, MERGED, OPERATOR_HIDDEN, PATCH_CHANNELS, VIEW_EMBEDDING,
};
use nsrm_core::nn::{Linear, MergeConv, PatchConv};

use crate::domain::Domain;
use crate::error::ModelError;
use crate::nn::{linear, merge_conv, patch_conv};
use crate::tensors::Tensors;

/// The vision module's parameters.
#[derive(Debug)]
pub(crate) struct FoldedVision {
    pub(crate) color: FoldedView<3>,
    pub(crate) brightness: FoldedView<1>,
    /// In the domain's order.
    pub(crate) operators: Vec<Operator>,
    /// Of length 1, in the domain's order.
    pub(crate) concepts: Vec<[f32; CONCEPT]>,
}

/// The encoder of one view of a crop.
#[derive(Debug)]
pub(crate) struct FoldedView<const CHANNELS: usize> {
    pub(crate) patch: Box<PatchConv<CHANNELS, PATCH_CHANNELS>>,
    pub(crate) merge: Box<MergeConv<PATCH_CHANNELS, MERGE_CHANNELS>>,
    pub(crate) dense: Box<Linear<MERGED, VIEW_EMBEDDING>>,
}

/// An attribute type's operator.
#[derive(Debug)]
pub(crate) struct Operator {
    pub(crate) hidden: Linear<VIEW_EMBEDDING, OPERATOR_HIDDEN>,
    pub(crate) output: Linear<OPERATOR_HIDDEN, CONCEPT>,
}

impl FoldedVision {
    pub(crate) fn read(tensors: &mut Tensors, domain: &Domain) -> Result<Self, ModelError> {
        let color = view(tensors, "vision.color")?;
        let brightness = view(tensors, "vision.brightness")?;
        let operators = domain
            .attribute
            .iter()
            .map(|attribute| operator(tensors, &attribute.name))
            .collect::<Result<Vec<Operator>, ModelError>>()?;
        let names = domain.concepts().map(|(_, value)| value.name.as_str());
        let concepts = tensors
            .rows::<CONCEPT>("vision.concept.weight", domain.concepts().count())?
            .iter()
            .zip(names)
            .map(|(embedding, name)| unit(embedding, name))
            .collect::<Result<Vec<[f32; CONCEPT]>, ModelError>>()?;
        Ok(Self {
            color,
            brightness,
            operators,
            concepts,
        })
    }
}

fn view<const CHANNELS: usize>(
    tensors: &mut Tensors,
    name: &str,
) -> Result<FoldedView<CHANNELS>, ModelError> {
    let mut dense = Box::new(linear(tensors, &format!("{name}.dense"))?);
    dense.weight = channels_last(&dense.weight);
    Ok(FoldedView {
        patch: Box::new(patch_conv(tensors, &format!("{name}.patch"))?),
        merge: Box::new(merge_conv(tensors, &format!("{name}.merge"))?),
        dense,
    })
}

/// From maps flattened by channel, row and column to by row, column and channel.
fn channels_last<T: Copy>(flat: &[T; MERGED]) -> [T; MERGED] {
    const PIXELS: usize = MERGED / MERGE_CHANNELS;
    std::array::from_fn(|index| {
        let (pixel, channel) = (index / MERGE_CHANNELS, index % MERGE_CHANNELS);
        flat[channel * PIXELS + pixel]
    })
}

fn operator(tensors: &mut Tensors, attribute: &str) -> Result<Operator, ModelError> {
    Ok(Operator {
        hidden: linear(tensors, &format!("vision.operator.{attribute}.hidden"))?,
        output: linear(tensors, &format!("vision.operator.{attribute}.output"))?,
    })
}

/// The embedding divided by its length.
fn unit(embedding: &[f32; CONCEPT], concept: &str) -> Result<[f32; CONCEPT], ModelError> {
    /// The cosine's guard against division by zero, in the trainer and in core.
    const LEAST_LENGTH: f64 = 1e-6;
    let square: f64 = embedding.iter().map(|&x| f64::from(x).powi(2)).sum();
    let length = square.sqrt();
    if length < LEAST_LENGTH {
        return Err(ModelError::ConceptLength {
            concept: concept.into(),
            length,
        });
    }
    Ok(embedding.map(|x| (f64::from(x) / length) as f32))
}
