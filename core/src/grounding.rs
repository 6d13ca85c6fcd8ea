//! From descriptions to objects (section IV-C, Table II): `Scene`, `Filter` and
//! `Unique`.
//!
//! * `Scene()` → a score of 1 for each object;
//! * `Filter(scores, val)` → `min(scores[i], cos(f_u(emb(o_i)), emb(val)))`, where
//!   `u` is the attribute type of `val`;
//! * `Relate(scores, k, y)` → `min(scores[i], …)`: see [`crate::relation`];
//! * `Unique(scores)` → the object with the greatest score; the trainer samples it
//!   from `softmax(10·scores)`, whose probability is kept as a confidence.

use thiserror::Error;

use crate::capacity::MAX_OBJECTS;
use crate::dsl::Filters;
use crate::model::{Model, OBJECT_EMBEDDING};
use crate::nn::Choice;
use crate::vision;

/// The factor on scores before `Unique`'s softmax, as in training.
pub const UNIQUE_SHARPNESS: f32 = 10.0;

/// Why filters give no score for an object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ScoreError {
    /// The model has no such concept or attribute type; impossible if [`Model::check`] has passed.
    #[error("the filters name a concept that the model does not have")]
    UnknownConcept,
    /// A cosine is NaN.
    #[error("the score is not a finite number; the model does not fit this object")]
    NotFinite,
}

/// How well an object passes a description's filters over `Scene()`: the smallest cosine; 1 without
/// filters.
///
/// Cost: one [`vision::similarity`] for each concept, at most `MAX_FILTERS`, and to the others of its type.
///
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/observed/mod.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use nsrm_core::Planner;
/// use nsrm_core::grounding::{Scores, score};
/// use nsrm_tabletop::TABLETOP;
///
/// # let scene = scene(&TABLETOP);
/// let parsed = Planner::new(&TABLETOP).parse("put the red block on the lego block")?;
/// let filters = parsed.program().steps()[0].object.filters(); // "red"
/// let mut scores = Scores::new();
/// for object in scene.objects() {
///     let fits = score(&TABLETOP, &object.embedding, filters)?;
///     scores.push(fits).expect("at most MAX_OBJECTS");
/// }
/// let chosen = scores.unique().expect("a scene with objects");
/// assert_eq!(scene.objects()[chosen.index].id, 4);
/// # Ok(())
/// # }
/// ```
pub fn score(
    model: &Model<'_>,
    embedding: &[f32; OBJECT_EMBEDDING],
    filters: &Filters,
) -> Result<f32, ScoreError> {
    Ok(filter(model, embedding, filters)?.score)
}

/// How an object passes filters.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Filtered {
    /// The smallest cosine.
    pub(crate) score: f32,
    /// The size that it should have.
    pub(crate) size: Option<u8>,
    /// The smallest cosine to all other concepts.
    pub(crate) besides_size: f32,
    /// Whether these are colours.
    pub(crate) are_colors: bool,
    /// Whether it shows another colour than it should have.
    pub(crate) is_other_color: bool,
}

/// [`score`], apart by what a concept says.
///
/// Cost: as of [`score`], and 16 multiply-adds and a division for each concept of the filters' types.
pub(crate) fn filter(
    model: &Model<'_>,
    embedding: &[f32; OBJECT_EMBEDDING],
    filters: &Filters,
) -> Result<Filtered, ScoreError> {
    let mut filtered = Filtered {
        score: 1.0,
        size: None,
        besides_size: 1.0,
        are_colors: true,
        is_other_color: false,
    };
    for &concept in filters.concepts() {
        let found = vision::similarity_or_other(model, embedding, concept);
        let (cosine, is_other) = found.ok_or(ScoreError::UnknownConcept)?;
        if !cosine.is_finite() {
            return Err(ScoreError::NotFinite);
        }
        filtered.score = filtered.score.min(cosine);
        if vision::is_size(model, concept) {
            filtered.size = Some(concept);
            continue;
        }
        let is_color = vision::is_color(model, concept);
        filtered.besides_size = filtered.besides_size.min(cosine);
        filtered.are_colors &= is_color;
        filtered.is_other_color |= is_other && is_color;
    }
    Ok(filtered)
}

/// The scores of a scene's objects, in the scene's order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scores {
    values: [f32; MAX_OBJECTS],
    count: usize,
}

/// An object chosen by `Unique`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Chosen {
    /// Its place in the scene.
    pub index: usize,
    /// Its score, a cosine.
    pub score: f32,
    /// Its share in `softmax(10·scores)`.
    pub probability: f32,
}

impl Scores {
    /// No scores yet.
    pub const fn new() -> Self {
        Self {
            values: [0.0; MAX_OBJECTS],
            count: 0,
        }
    }

    /// Adds the score of the next object; returns it if all places are taken.
    pub fn push(&mut self, score: f32) -> Result<(), f32> {
        let place = self.values.get_mut(self.count).ok_or(score)?;
        *place = score;
        self.count += 1;
        Ok(())
    }

    /// The scores, in the scene's order.
    pub fn values(&self) -> &[f32] {
        self.values.get(..self.count).unwrap_or_default()
    }

    /// The same, to change them.
    pub(crate) fn values_mut(&mut self) -> &mut [f32] {
        self.values.get_mut(..self.count).unwrap_or_default()
    }

    /// The object with the greatest score, the first one of a tie; `None` without objects or if a
    /// score is not finite.
    pub fn unique(&self) -> Option<Chosen> {
        let mut choice = Choice::new();
        for score in self.values() {
            choice.offer(UNIQUE_SHARPNESS * score);
        }
        let index = choice.index()?;
        Some(Chosen {
            index,
            score: *self.values().get(index)?,
            probability: choice.probability(),
        })
    }
}

impl Default for Scores {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unique_is_the_softmax_of_ten_times_the_score() {
        let mut scores = Scores::new();
        assert_eq!(scores.unique(), None);
        for score in [0.1, 0.9, 0.8] {
            scores.push(score).unwrap();
        }
        let chosen = scores.unique().unwrap();
        assert_eq!((chosen.index, chosen.score), (1, 0.9));
        // 1 / (1 + e^-1 + e^-8)
        assert!((chosen.probability - 0.730_879).abs() < 1e-5);
    }

    #[test]
    fn a_full_set_of_scores_gives_the_next_back() {
        let mut scores = Scores::new();
        for _ in 0..MAX_OBJECTS {
            scores.push(-1.0).unwrap();
        }
        assert_eq!(scores.push(0.5), Err(0.5));
        assert_eq!(scores.values().len(), MAX_OBJECTS);
    }
}
