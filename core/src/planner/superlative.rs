//! Comparing the objects that fit: "nearest to", "farthest from", "leftmost" and "largest".

use nalgebra::Point3;

use super::resolve::Within;
use crate::capacity::MAX_OBJECTS;
use crate::dsl::Extreme;
use crate::model::LOCATION;
use crate::nn::dot;
use crate::refusal::Refusal;
use crate::relation::{CLEARLY_FARTHER_M, CLEARLY_LARGER, CLEARLY_NEARER, direction, distance};

/// Share of an object's box above which a nearer object in front of it hides what it looks like.
const HIDDEN: f32 = 0.2;
/// How far an object that is seen in part only may be from where its box lets it seem, metres: 10 mm at
/// the 95th percentile in scenes with stacks, and half as much again.
const PARTIAL_OFF_M: f32 = 0.015;
/// How far apart the centres of two objects are at most along the table if one stands on the other, and
/// how much higher that one is at least, metres: half an edge of the paper's larger blocks, farther out
/// nothing rests, and half of what its smaller blocks are higher by on each other.
pub(super) const ON_TOP_M: (f32, f32) = (0.03, 0.02);

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
    /// Whether it is seen in part only.
    is_partial: bool,
}

impl Superlative {
    /// Leaves the objects that may be meant: those that fit and are not clearly behind another one.
    /// Whether one of them that is seen whole fits, or none fits; otherwise no one is clearly meant.
    ///
    /// What is seen in part only may fit or not, whatever it looks like. So it puts no other behind
    /// it, unless nothing else fits; and where it may be the one that is meant, it gets the score at
    /// which an object may fit.
    ///
    /// * `scores`: how well each object fits the filters
    /// * `volumes`: of each object, if they are compared by size
    ///
    /// Cost: an action, the place of each object, and a comparison of each with all others.
    pub(super) fn compare(
        self,
        scores: &mut [f32],
        volumes: &[f32; MAX_OBJECTS],
        within: &Within<'_>,
    ) -> Result<bool, Refusal> {
        let threshold = within.model.header.thresholds.match_score;
        if scores.iter().all(|score| *score < threshold) {
            return Ok(true);
        }
        let compared = self.objects(scores.len(), volumes, within)?;
        let fitting = scores.iter().zip(&compared);
        let fitting = fitting.filter(|(score, _)| **score >= threshold);
        let is_whole = fitting.clone().any(|(_, object)| !object.is_partial);
        let (mut least, mut greatest) = (f32::INFINITY, f32::NEG_INFINITY);
        for (_, object) in fitting.filter(|(_, object)| !is_whole || !object.is_partial) {
            // What is not known, NaN, changes neither.
            (least, greatest) = (least.min(object.measure), greatest.max(object.measure));
        }
        for (index, (score, object)) in scores.iter_mut().zip(compared).enumerate() {
            let is_behind = self.is_behind(&object, least, greatest);
            let fits = *score >= threshold;
            if fits && is_behind {
                *score = -1.0;
            } else if !fits && !is_behind && object.is_partial && !self.is_anchor(index) {
                *score = threshold;
            }
        }
        Ok(is_whole)
    }

    /// Whether an object is clearly not the one that is meant; what is not known, NaN, may be.
    fn is_behind(self, object: &Compared, least: f32, greatest: f32) -> bool {
        let measure = object.measure;
        let off_m = if object.is_partial {
            PARTIAL_OFF_M
        } else {
            0.0
        };
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
        volumes: &[f32; MAX_OBJECTS],
        within: &Within<'_>,
    ) -> Result<[Compared; MAX_OBJECTS], Refusal> {
        let direction = self.direction(within)?;
        let mut objects = seen_in_part(within).map(|is_partial| Compared {
            measure: f32::NAN,
            is_partial,
        });
        let each = objects.iter_mut().zip(within.locations).zip(volumes);
        for ((object, location), volume) in each.take(count) {
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
                    if !object.is_partial {
                        object.measure = *volume;
                    }
                    continue;
                }
            };
            object.measure = metres.ok_or(within.not_finite())?;
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

/// Which objects of the scene are seen in part only: whatever they look like, they may look like
/// something else.
pub(super) fn seen_in_part(within: &Within<'_>) -> [bool; MAX_OBJECTS] {
    let objects = within.scene.objects();
    let mut seen = [[0.0; LOCATION]; MAX_OBJECTS];
    for (location, object) in seen.iter_mut().zip(objects) {
        *location = within.viewpoint.to_training(&object.location);
    }
    let mut are_partial = [false; MAX_OBJECTS];
    // What earlier steps uncover looks as it did before; what they cover will be seen in part.
    for locations in [&seen, within.locations] {
        let locations = locations.get(..objects.len()).unwrap_or_default();
        mark_partial(&mut are_partial, locations, within);
    }
    are_partial
}

/// Marks the objects that are seen in part only where they are in these places.
fn mark_partial(are_partial: &mut [bool], locations: &[[f32; LOCATION]], within: &Within<'_>) {
    let mut places = [Point3::origin(); MAX_OBJECTS];
    for (place, location) in places.iter_mut().zip(locations) {
        *place = within.place(location);
    }
    let places = places.get(..locations.len()).unwrap_or_default();
    for ((is_partial, location), place) in are_partial.iter_mut().zip(locations).zip(places) {
        *is_partial |= is_hidden(location, locations) || carries_any(place, places);
    }
}

/// Whether a nearer object hides much of it.
pub(super) fn is_hidden(object: &[f32; LOCATION], objects: &[[f32; LOCATION]]) -> bool {
    let [left, top, right, bottom, depth_m] = *object;
    let area = (right - left) * (bottom - top);
    objects.iter().any(|&[x1, y1, x2, y2, other_m]| {
        let width = right.min(x2) - left.max(x1);
        let height = bottom.min(y2) - top.max(y1);
        other_m < depth_m && width > 0.0 && height > 0.0 && width * height > HIDDEN * area
    })
}

/// Whether another object stands on it, which then covers its upper face.
fn carries_any(place: &Point3<f32>, places: &[Point3<f32>]) -> bool {
    let (aside_m, higher_m) = ON_TOP_M;
    places.iter().any(|other| {
        let [x, y, z]: [f32; 3] = (other - place).into();
        z > higher_m && x * x + y * y < aside_m * aside_m
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_nearer_object_overlaps_is_hidden() {
        let object = [0.4, 0.4, 0.5, 0.6, 0.5];
        // Overlapping by 0.05 of 0.1 and by 0.1 of 0.2: a quarter.
        let over = [0.45, 0.5, 0.6, 0.7, 0.4];
        assert!(is_hidden(&object, &[object, over]));
        let behind = [0.45, 0.5, 0.6, 0.7, 0.6];
        let less = [0.47, 0.5, 0.6, 0.7, 0.4];
        let beside = [0.5, 0.4, 0.6, 0.6, 0.4];
        let apart = [0.6, 0.7, 0.7, 0.9, 0.4];
        assert!(!is_hidden(&object, &[object, behind, less, beside, apart]));
    }
}
