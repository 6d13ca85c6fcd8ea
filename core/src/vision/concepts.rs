use crate::model::{Attribute, CONCEPT, Model, OBJECT_EMBEDDING, VIEW_EMBEDDING, View};
use crate::nn::{dot, relu_all};

/// The smallest length by which a vector is divided, as in training.
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

/// `cos(f_u(emb(o)), emb(val))` for the concept `val` and its attribute type `u` (Table II); `None`
/// if the model has no such concept or type, NaN if the length of the operator's result overflows.
///
/// Cost: one [`operate`], 32 multiply-adds, a root and a division.
///
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/observed/mod.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use nsrm_core::vision::similarity;
/// use nsrm_tabletop::TABLETOP;
///
/// # let scene = scene(&TABLETOP);
/// let red_block = &scene.objects()[3].embedding;
/// let cosine = |name| {
///     let concept = TABLETOP.concepts.iter().position(|concept| concept.name == name);
///     similarity(&TABLETOP, red_block, concept.expect("a concept") as u8)
/// };
/// assert!(cosine("red") > Some(0.9));
/// assert!(cosine("green") < Some(0.5));
/// # Ok(())
/// # }
/// ```
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
    if length.is_infinite() {
        return Some(f32::NAN);
    }
    let length = if length < LEAST_NORM {
        LEAST_NORM
    } else {
        length
    };
    Some(dot(&vector, &concept.embedding) / length)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture;

    #[test]
    fn each_operator_reads_its_own_view() {
        let model = fixture::model();
        let mut embedding = [0.0; OBJECT_EMBEDDING];
        (embedding[0], embedding[1]) = (3.0, 4.0);
        embedding[VIEW_EMBEDDING] = 0.25;
        let cosines = [0, 1, 2, 3].map(|concept| similarity(&model, &embedding, concept).unwrap());
        for (got, expected) in cosines.iter().zip([0.6, 0.8, 1.0, 0.0]) {
            assert!((got - expected).abs() < 1e-6, "{cosines:?}");
        }
        assert_eq!(similarity(&model, &embedding, 4), None);
    }

    /// Every weight has its own number, so that no two places can be swapped.
    #[test]
    fn an_operator_is_two_layers_with_a_relu_between() {
        let mut attribute = fixture::model().attributes[0];
        (attribute.hidden, attribute.output) = (fixture::linear(), fixture::linear());
        attribute.hidden.weight[31][0] = 2.0;
        attribute.hidden.weight[30][1] = -1.0;
        attribute.hidden.bias[2] = 0.5;
        attribute.output.weight[0][15] = 10.0;
        attribute.output.weight[1][15] = 1000.0;
        attribute.output.weight[2][14] = 4.0;
        attribute.output.bias[13] = -3.0;
        let mut embedding = [0.0; OBJECT_EMBEDDING];
        (embedding[30], embedding[31], embedding[63]) = (1.0, 0.25, 100.0);
        let mut expected = [0.0; CONCEPT];
        (expected[13], expected[14], expected[15]) = (-3.0, 2.0, 5.0);
        assert_eq!(operate(&attribute, &embedding), expected);
    }

    #[test]
    fn a_vector_without_direction_has_no_similarity() {
        let model = fixture::model();
        assert_eq!(similarity(&model, &[0.0; OBJECT_EMBEDDING], 1), Some(0.0));
        let overflows = similarity(&model, &[1e30; OBJECT_EMBEDDING], 1);
        assert!(overflows.is_some_and(f32::is_nan));
    }
}
