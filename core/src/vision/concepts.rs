use crate::model::{Attribute, CONCEPT, Model, OBJECT_EMBEDDING, VIEW_EMBEDDING, View};
use crate::nn::{dot, relu_all};

/// Added to nothing, but the least length that a vector is divided by, as in training.
const LEAST_NORM: f32 = 1e-6;

/// An attribute type's operator `f_u`: the object's embedding to concept space.
///
/// Cost: `32·32 + 32·16` multiply-adds.
pub fn operate(attribute: &Attribute<'_>, embedding: &[f32; OBJECT_EMBEDDING]) -> [f32; CONCEPT] {
    let skipped = match attribute.view {
        View::Color => 0,
        View::Brightness => VIEW_EMBEDDING,
    };
    let mut view = [0.0; VIEW_EMBEDDING];
    for (place, &value) in view.iter_mut().zip(embedding.iter().skip(skipped)) {
        *place = value;
    }
    let mut hidden = attribute.hidden.apply(&view);
    relu_all(&mut hidden);
    attribute.output.apply(&hidden)
}

/// `cos(f_u(emb(o)), emb(val))` for the concept `val` and its attribute type `u`
/// (Table II); `None` when the model has no such concept or type.
///
/// Cost: one [`operate`], 32 multiply-adds, a root and a division.
pub fn similarity(
    model: &Model<'_>,
    embedding: &[f32; OBJECT_EMBEDDING],
    concept: u8,
) -> Option<f32> {
    let concept = model.concepts.get(usize::from(concept))?;
    let attribute = model.attributes.get(usize::from(concept.attribute))?;
    let vector = operate(attribute, embedding);
    // Concept embeddings have length 1.
    let length = libm::sqrtf(dot(&vector, &vector));
    Some(
        dot(&vector, &concept.embedding)
            / if length > LEAST_NORM {
                length
            } else {
                LEAST_NORM
            },
    )
}
