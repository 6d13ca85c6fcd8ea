//! Comparing the objects that fit: "nearest to", "farthest from", "leftmost" and "largest".

use nalgebra::Point3;

use super::resolve::{Judged, Within};
use super::sight::Fit;
use crate::capacity::MAX_OBJECTS;
use crate::dsl::Extreme;
use crate::nn::dot;
use crate::refusal::Refusal;
use crate::relation::{CLEARLY_FARTHER_M, CLEARLY_LARGER, CLEARLY_NEARER, direction, distance};

/// How far an object that is seen in part only may be from where its box lets it seem, metres: 10 mm at
/// the 95th percentile in scenes with stacks, and half as much again.
const PARTIAL_OFF_M: f32 = 0.015;

/// What the objects that fit are compared by.
#[derive(Debug, Clone, Copy)]
pub(super) enum Superlative {
    /// The least distance to an anchor: its index, with a score of −1.
    Nearest(usize),
    /// The greatest distance to an anchor.
    Farthest(usize),
    /// What says which one is meant.
    Extreme(Extreme),
}

/// How an object compares.
#[derive(Clone, Copy)]
struct Compared {
    /// Metres, or a volume; NaN if that is not known.
    measure: f32,
    /// How far the object may be from where it seems to be, metres.
    off_m: f32,
}

impl Superlative {
    /// Leaves the objects that may be meant: those that fit and are not clearly behind another one.
    /// Whether one of them certainly fits, or none fits; otherwise no one is clearly meant.
    ///
    /// What may fit or not puts no other behind it, unless nothing else fits; and where it may be the one
    /// that is meant, it gets the score at which an object may fit.
    ///
    /// * `scores`: how well each object fits the filters
    /// * `judged`: what is known of each object
    ///
    /// Cost: an action, and the place of each object.
    pub(super) fn compare(
        self,
        scores: &mut [f32],
        judged: &[Judged; MAX_OBJECTS],
        within: &Within<'_>,
    ) -> Result<bool, Refusal> {
        let threshold = within.model.header.thresholds.match_score;
        if scores.iter().all(|score| *score < threshold) {
            return Ok(true);
        }
        let compared = self.objects(scores.len(), judged, within)?;
        let fitting = scores.iter().zip(judged).zip(&compared);
        let fitting = fitting.filter(|((score, _), _)| **score >= threshold);
        let is_certain = fitting.clone().any(|((_, own), _)| own.fit == Fit::Yes);
        let (mut least, mut greatest) = (f32::INFINITY, f32::NEG_INFINITY);
        for (_, object) in fitting.filter(|((_, own), _)| !is_certain || own.fit == Fit::Yes) {
            // What is not known, NaN, changes neither.
            least = least.min(object.measure + object.off_m);
            greatest = greatest.max(object.measure - object.off_m);
        }
        let objects = scores.iter_mut().zip(judged).zip(compared);
        for (index, ((score, own), object)) in objects.enumerate() {
            let is_behind = self.is_behind(&object, least, greatest);
            let seems_to = *score >= threshold;
            if seems_to && is_behind {
                *score = -1.0;
            } else if !seems_to && !is_behind && own.fit == Fit::Maybe && !self.is_anchor(index) {
                *score = threshold;
            }
        }
        Ok(is_certain)
    }

    /// Whether an object is clearly not the one that is meant; what is not known, NaN, may be.
    fn is_behind(self, object: &Compared, least: f32, greatest: f32) -> bool {
        let Compared { measure, off_m } = *object;
        match self {
            Self::Nearest(_) => measure - off_m >= CLEARLY_NEARER * least,
            Self::Farthest(_) => greatest >= CLEARLY_NEARER * (measure + off_m),
            Self::Extreme(Extreme::Action(_)) => greatest >= CLEARLY_FARTHER_M + off_m + measure,
            Self::Extreme(Extreme::Largest) => greatest >= CLEARLY_LARGER * measure,
            Self::Extreme(Extreme::Smallest) => measure >= CLEARLY_LARGER * least,
        }
    }

    const fn is_anchor(self, index: usize) -> bool {
        match self {
            Self::Nearest(anchor) | Self::Farthest(anchor) => index == anchor,
            Self::Extreme(_) => false,
        }
    }

    /// How the objects of the scene compare.
    fn objects(
        self,
        count: usize,
        judged: &[Judged; MAX_OBJECTS],
        within: &Within<'_>,
    ) -> Result<[Compared; MAX_OBJECTS], Refusal> {
        let direction = self.direction(within)?;
        let mut objects = [Compared {
            measure: f32::NAN,
            off_m: 0.0,
        }; MAX_OBJECTS];
        let each = objects.iter_mut().zip(within.locations).zip(judged);
        for ((object, location), own) in each.take(count) {
            let metres = match self {
                Self::Nearest(anchor) | Self::Farthest(anchor) => {
                    // Always there: it is an object of the scene.
                    let anchor = within.locations.get(anchor).ok_or(Refusal::InvalidModel)?;
                    distance(within.model, within.viewpoint, location, anchor)
                }
                Self::Extreme(Extreme::Action(_)) => {
                    let reach_m = dot(&direction, &within.place(location).coords.into());
                    reach_m.is_finite().then_some(reach_m)
                }
                Self::Extreme(Extreme::Largest | Extreme::Smallest) => {
                    object.measure = own.volume;
                    continue;
                }
            };
            object.measure = metres.ok_or(within.not_finite())?;
            if own.is_rough {
                object.off_m = PARTIAL_OFF_M;
            }
        }
        Ok(objects)
    }

    /// The direction of an extreme, a unit vector in the world; 0 for what has none.
    ///
    /// It is that of the action for a cube of the first size that the model knows, on the table in the
    /// middle of the work space: what stands higher, or at the edge, is put to another side than "left".
    fn direction(self, within: &Within<'_>) -> Result<[f32; 3], Refusal> {
        let Self::Extreme(Extreme::Action(action)) = self else {
            return Ok([0.0; 3]);
        };
        let Within {
            model, viewpoint, ..
        } = within;
        let mut concepts = model.concepts.iter();
        let edges_m = concepts.find_map(|concept| concept.edges_m);
        let action = model.actions.get(usize::from(action));
        // Always there: the model was checked.
        let ([edge_m, _, _], action) = edges_m.zip(action).ok_or(Refusal::InvalidModel)?;
        let ([x, y], [_, _, table]) = (
            model.header.work_space.middle(),
            model.header.work_space.min,
        );
        let middle = viewpoint.locate(&Point3::new(x, y, table + 0.5 * edge_m), edge_m);
        direction(model, viewpoint, action, &middle).ok_or(within.not_finite())
    }
}
