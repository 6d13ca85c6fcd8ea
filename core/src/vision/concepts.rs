use crate::model::{Attribute, CONCEPT, Concept, Model, OBJECT_EMBEDDING, VIEW_EMBEDDING, View};
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
    Some(dot(&vector, &concept.embedding) / length(&vector))
}

/// The length of an operator's result, NaN if it overflows. Concept embeddings have length 1.
fn length(vector: &[f32; CONCEPT]) -> f32 {
    let length = libm::sqrtf(dot(vector, vector));
    if length.is_infinite() {
        f32::NAN
    } else if length < LEAST_NORM {
        LEAST_NORM
    } else {
        length
    }
}

/// [`similarity`] to a concept, and whether the object shows another one of its type: that fits by the model's
/// threshold for matches, and this one does not.
///
/// Cost: one [`operate`], a root, and 16 multiply-adds and a division for each concept of the type.
pub(crate) fn similarity_or_other(
    model: &Model<'_>,
    embedding: &[f32; OBJECT_EMBEDDING],
    concept: u8,
) -> Option<(f32, bool)> {
    let concept = model.concepts.get(usize::from(concept))?;
    let attribute = model.attributes.get(usize::from(concept.attribute))?;
    let vector = operate(attribute, embedding);
    let length = length(&vector);
    let own = dot(&vector, &concept.embedding) / length;
    let threshold = model.header.thresholds.match_score;
    let mut others = model.concepts.iter();
    let shows_other = own < threshold
        && others.any(|other| {
            other.attribute == concept.attribute
                && dot(&vector, &other.embedding) >= threshold * length
        });
    Some((own, shows_other))
}

/// Whether a concept is a size.
pub(crate) fn is_size(model: &Model<'_>, concept: u8) -> bool {
    let concept = model.concepts.get(usize::from(concept));
    concept.is_some_and(|concept| concept.edges_m.is_some())
}

/// Whether a concept is a colour, which an object shows as well if others hide a part of it: what the colour
/// view tells, but no size.
pub(crate) fn is_color(model: &Model<'_>, concept: u8) -> bool {
    let Some(concept) = model.concepts.get(usize::from(concept)) else {
        return false;
    };
    let is_size =
        |other: &Concept<'_>| other.attribute == concept.attribute && other.edges_m.is_some();
    let attribute = model.attributes.get(usize::from(concept.attribute));
    attribute.is_some_and(|attribute| attribute.view == View::Color)
        && !model.concepts.iter().any(is_size)
}

/// The volume of the size that an object shows most clearly, cubic metres; NaN if no size fits it,
/// by the model's threshold for matches.
///
/// Cost: one [`operate`], and 16 multiply-adds and a division for each size.
pub fn volume(model: &Model<'_>, embedding: &[f32; OBJECT_EMBEDDING]) -> f32 {
    let mut best = (model.header.thresholds.match_score, f32::NAN);
    let mut operated = None;
    for concept in model.concepts {
        let Some([x_m, y_m, z_m]) = concept.edges_m else {
            continue;
        };
        // One attribute type says the sizes.
        let Some((vector, length)) = operated.or_else(|| {
            let attribute = model.attributes.get(usize::from(concept.attribute))?;
            let vector = operate(attribute, embedding);
            operated = Some((vector, length(&vector)));
            operated
        }) else {
            continue;
        };
        let score = dot(&vector, &concept.embedding) / length;
        if score >= best.0 {
            best = (score, x_m * y_m * z_m);
        }
    }
    best.1
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
    fn a_volume_is_that_of_the_size_that_an_object_shows() {
        let mut concepts = [0, 1, 2, 3].map(|concept| fixture::model().concepts[concept]);
        concepts[3].edges_m = Some([0.1, 0.2, 0.3]);
        let model = fixture::model().with_concepts(&concepts);
        let lego = fixture::object(1, fixture::RED, fixture::LEGO, 0.5, 0.5).embedding;
        let small = fixture::object(2, fixture::RED, fixture::SMALL, 0.5, 0.5).embedding;
        let edges_m = concepts[2].edges_m.unwrap();
        assert_eq!(volume(&model, &lego), edges_m.iter().product::<f32>());
        assert_eq!(volume(&model, &small), 0.1 * 0.2 * 0.3);
        let other = fixture::object(3, fixture::RED, 5, 0.5, 0.5).embedding;
        assert!(volume(&model, &other).is_nan());
        assert!(volume(&model, &[1e30; OBJECT_EMBEDDING]).is_nan());
        let mut between = lego;
        between[VIEW_EMBEDDING + fixture::SMALL] = 0.6;
        assert_eq!(volume(&model, &between), 0.1 * 0.2 * 0.3);
    }

    #[test]
    fn a_vector_without_direction_has_no_similarity() {
        let model = fixture::model();
        assert_eq!(similarity(&model, &[0.0; OBJECT_EMBEDDING], 1), Some(0.0));
        let overflows = similarity(&model, &[1e30; OBJECT_EMBEDDING], 1);
        assert!(overflows.is_some_and(f32::is_nan));
    }
}
