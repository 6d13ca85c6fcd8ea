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
    /// What says which one is meant, and its number counted from there.
    Extreme { extreme: Extreme, rank: u8 },
}

/// How an object compares.
#[derive(Clone, Copy)]
struct Compared {
    /// Metres, or a volume; NaN if that is not known.
    measure: f32,
    /// How far the object may be from where it seems to be, metres.
    off_m: f32,
    /// Whether it fits, and whether its score says so.
    fit: Fit,
    seems_to_fit: bool,
}

impl Superlative {
    /// Leaves the objects that may be meant: of those that fit, those that may have the number that is meant,
    /// which is the first unless one counts. Whether one of them certainly fits, and they certainly have it, or
    /// none fits; otherwise no one is clearly meant.
    ///
    /// As many as are clearly ahead of an object have numbers before its own, and at most those that are not
    /// clearly behind it. What may fit or not is clearly ahead of no other, unless nothing else fits; and where it
    /// may be the one that is meant, it gets the score at which an object may fit.
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
        let mut objects = self.objects(scores.len(), judged, within)?;
        for (index, ((object, score), own)) in
            objects.iter_mut().zip(&*scores).zip(judged).enumerate()
        {
            object.seems_to_fit = *score >= threshold;
            let may_fit = own.fit == Fit::Maybe && !self.is_anchor(index);
            object.fit = if object.seems_to_fit || may_fit {
                own.fit
            } else {
                Fit::No
            };
        }
        let fits = |object: &Compared| object.seems_to_fit && object.fit == Fit::Yes;
        let is_certain = objects.iter().any(fits);
        let counts = |object: &Compared| object.seems_to_fit && (!is_certain || fits(object));
        let mut is_counted = true;
        for (score, (index, object)) in scores.iter_mut().zip(objects.iter().enumerate()) {
            if object.fit == Fit::No {
                continue;
            }
            let (mut least, mut most) = (1_usize, 1_usize);
            let others = objects.iter().enumerate();
            for (_, other) in others.filter(|(other, _)| *other != index) {
                let is_ahead = counts(other) && self.is_ahead(other, object);
                let may_be_ahead = other.fit != Fit::No && !self.is_ahead(object, other);
                least = least.saturating_add(usize::from(is_ahead));
                most = most.saturating_add(usize::from(may_be_ahead));
            }
            if (least..=most).contains(&self.rank()) {
                // Of the first, the others that may be it are meant, too.
                is_counted &= least == most || self.rank() == 1;
                *score = score.max(threshold);
            } else if object.seems_to_fit {
                *score = -1.0;
            }
        }
        Ok(is_certain && is_counted)
    }

    /// The number of the object that is meant.
    const fn rank(self) -> usize {
        match self {
            Self::Extreme { rank, .. } => rank as usize,
            Self::Nearest(_) | Self::Farthest(_) => 1,
        }
    }

    /// Whether an object is clearly ahead of another one; not if one of them is not known, NaN.
    fn is_ahead(self, object: &Compared, other: &Compared) -> bool {
        let (greatest, least) = (object.measure - object.off_m, object.measure + object.off_m);
        let Compared { measure, off_m, .. } = *other;
        match self {
            Self::Nearest(_) => measure - off_m >= CLEARLY_NEARER * least,
            Self::Farthest(_) => greatest >= CLEARLY_NEARER * (measure + off_m),
            Self::Extreme { extreme, .. } => match extreme {
                Extreme::Action(_) => greatest >= CLEARLY_FARTHER_M + off_m + measure,
                Extreme::Largest => greatest >= CLEARLY_LARGER * measure,
                Extreme::Smallest => measure >= CLEARLY_LARGER * least,
            },
        }
    }

    const fn is_anchor(self, index: usize) -> bool {
        match self {
            Self::Nearest(anchor) | Self::Farthest(anchor) => index == anchor,
            Self::Extreme { .. } => false,
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
            fit: Fit::No,
            seems_to_fit: false,
        }; MAX_OBJECTS];
        let each = objects.iter_mut().zip(within.locations).zip(judged);
        for ((object, location), own) in each.take(count) {
            let metres = match self {
                Self::Nearest(anchor) | Self::Farthest(anchor) => {
                    // Always there: it is an object of the scene.
                    let anchor = within.locations.get(anchor).ok_or(Refusal::InvalidModel)?;
                    distance(within.model, within.viewpoint, location, anchor)
                }
                Self::Extreme {
                    extreme: Extreme::Action(_),
                    ..
                } => {
                    let reach_m = dot(&direction, &within.place(location).coords.into());
                    reach_m.is_finite().then_some(reach_m)
                }
                Self::Extreme { .. } => {
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
        let Self::Extreme {
            extreme: Extreme::Action(action),
            ..
        } = self
        else {
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
