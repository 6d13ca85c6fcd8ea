use super::resolve::Within;
use crate::capacity::MAX_OBJECTS;
use crate::model::LOCATION;
use crate::refusal::Refusal;
use crate::relation::{CLEARLY_NEARER, distance};

/// Share of an object's box above which a nearer object in front of it hides what it looks like: it
/// may fit any filters.
const HIDDEN: f32 = 0.2;

/// Which of the distances to an anchor is sought.
#[derive(Debug, Clone, Copy)]
pub(super) enum Extreme {
    /// That of the nearest object.
    Least,
    /// That of the farthest.
    Greatest,
}

impl Extreme {
    /// Leaves the objects that may be meant: those that fit and are not clearly another's rivals, and
    /// those in their place that are hidden, which get the score at which an object may fit or not.
    ///
    /// * `anchor`: its index, with a score of −1
    /// * `scores`: how well each object fits the filters
    ///
    /// Cost: the distance of each object, and for those that do not fit a comparison of its box
    /// with all others.
    pub(super) fn compare(
        self,
        anchor: usize,
        scores: &mut [f32],
        within: &Within<'_>,
    ) -> Result<(), Refusal> {
        let threshold = within.model.header.thresholds.match_score;
        // Always there: it is an object of the scene.
        let place = within.locations.get(anchor).ok_or(Refusal::InvalidModel)?;
        let mut lengths_m = [0.0; MAX_OBJECTS];
        let (mut least_m, mut greatest_m) = (f32::INFINITY, 0.0_f32);
        for ((length_m, score), object) in lengths_m
            .iter_mut()
            .zip(scores.iter())
            .zip(within.locations)
        {
            *length_m = distance(within.model, within.viewpoint, object, place)
                .ok_or(within.not_finite())?;
            if *score >= threshold {
                (least_m, greatest_m) = (least_m.min(*length_m), greatest_m.max(*length_m));
            }
        }
        if least_m > greatest_m {
            // Nothing fits.
            return Ok(());
        }
        let objects = within.locations.get(..scores.len()).unwrap_or_default();
        let each = scores.iter_mut().zip(lengths_m).zip(objects).enumerate();
        for (index, ((score, length_m), object)) in each {
            let may_be_meant = match self {
                Self::Least => length_m < CLEARLY_NEARER * least_m,
                Self::Greatest => greatest_m < CLEARLY_NEARER * length_m,
            };
            let fits = *score >= threshold;
            if fits && !may_be_meant {
                *score = -1.0;
            } else if !fits && may_be_meant && index != anchor && is_hidden(object, objects) {
                *score = threshold;
            }
        }
        Ok(())
    }
}

/// Whether a nearer object hides much of it.
fn is_hidden(object: &[f32; LOCATION], objects: &[[f32; LOCATION]]) -> bool {
    let [left, top, right, bottom, depth_m] = *object;
    let area = (right - left) * (bottom - top);
    objects.iter().any(|&[x1, y1, x2, y2, other_m]| {
        let width = right.min(x2) - left.max(x1);
        let height = bottom.min(y2) - top.max(y1);
        other_m < depth_m && width > 0.0 && height > 0.0 && width * height > HIDDEN * area
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
