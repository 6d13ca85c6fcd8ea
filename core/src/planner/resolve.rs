use nalgebra::Point3;

use super::Grounding;
use super::superlative::Superlative;
use crate::capacity::MAX_OBJECTS;
use crate::dsl::{Argument, Description, Extreme, RelationKind};
use crate::grounding::{ScoreError, Scores, score};
use crate::model::{LOCATION, Model};
use crate::refusal::{Candidate, Candidates, Quantity, Refusal};
use crate::relation::{RELATION_CLEAR, relate};
use crate::scene::{ObservedObject, Scene};
use crate::viewpoint::Viewpoint;
use crate::vision;

/// Finds the object that a description refers to, from the innermost anchor of its relations
/// outwards. Each [`Resolver::poll`] scores one object or chooses one.
#[derive(Debug, Clone)]
pub(super) struct Resolver {
    /// Links of the chain outside of what is sought now.
    level: usize,
    /// What the link inside refers to.
    anchor: Option<Grounding>,
    scores: Scores,
    /// Of the objects that have a score, if they are compared by size.
    volumes: [f32; MAX_OBJECTS],
}

/// What a description is resolved in.
#[derive(Clone, Copy)]
pub(super) struct Within<'a> {
    pub(super) model: &'a Model<'a>,
    pub(super) scene: &'a Scene,
    pub(super) viewpoint: &'a Viewpoint<'a>,
    /// Where the objects are after the steps so far, as the training's camera would see them.
    pub(super) locations: &'a [[f32; LOCATION]; MAX_OBJECTS],
    pub(super) step: usize,
    pub(super) argument: Argument,
}

impl Resolver {
    /// Nothing scored yet.
    pub(super) fn new(description: &Description) -> Self {
        Self {
            level: description.relations().len(),
            anchor: None,
            scores: Scores::new(),
            volumes: [0.0; MAX_OBJECTS],
        }
    }

    /// Does one unit of work; the object once it is found.
    ///
    /// * `description`: the one that it was made for
    pub(super) fn poll(
        &mut self,
        description: &Description,
        within: &Within<'_>,
    ) -> Result<Option<Grounding>, Refusal> {
        // Always there: levels are counted down from the chain's length.
        let sought = description.anchor(self.level);
        let sought = sought.ok_or(Refusal::InvalidModel)?;
        if let Some(object) = within.scene.objects().get(self.scores.values().len()) {
            let score = self.score(&sought, within, object)?;
            if let Some(Extreme::Largest | Extreme::Smallest) = sought.filters().which()
                && let Some(place) = self.volumes.get_mut(self.scores.values().len())
            {
                *place = vision::volume(within.model, &object.embedding);
            }
            // As many places as a scene has objects.
            let _ = self.scores.push(score);
            return Ok(None);
        }
        let is_clear = self.compare(&sought, within)?;
        let found = self.choose(&sought, within, is_clear)?;
        let Some(level) = self.level.checked_sub(1) else {
            return Ok(Some(found));
        };
        *self = Self {
            level,
            anchor: Some(found),
            scores: Scores::new(),
            volumes: [0.0; MAX_OBJECTS],
        };
        Ok(None)
    }

    /// How well the next object fits.
    fn score(
        &self,
        sought: &Description,
        within: &Within<'_>,
        object: &ObservedObject,
    ) -> Result<f32, Refusal> {
        let filtered = score(within.model, &object.embedding, sought.filters());
        let filtered = filtered.map_err(|error| match error {
            ScoreError::UnknownConcept => Refusal::InvalidModel,
            ScoreError::NotFinite => within.not_finite(),
        })?;
        let related = self.relation(sought, within, self.scores.values().len())?;
        Ok(related.map_or(filtered, |related| filtered.min(related)))
    }

    /// How clearly an object is in the relation to the anchor, which never is; `None` without a
    /// relation, and for a superlative, which compares those that fit.
    fn relation(
        &self,
        sought: &Description,
        within: &Within<'_>,
        index: usize,
    ) -> Result<Option<f32>, Refusal> {
        let Some((relation, anchor)) = sought.relations().first().zip(self.anchor) else {
            return Ok(None);
        };
        let anchor = usize::from(anchor.index);
        if index == anchor {
            return Ok(Some(-1.0));
        }
        let RelationKind::Action(action) = relation.kind else {
            return Ok(None);
        };
        let action = within.model.actions.get(usize::from(action));
        // Always there: both are objects of the scene.
        let (object, anchor) = within
            .locations
            .get(index)
            .zip(within.locations.get(anchor))
            .ok_or(Refusal::InvalidModel)?;
        let cosine = relate(
            within.model,
            within.viewpoint,
            action.ok_or(Refusal::InvalidModel)?,
            object,
            anchor,
        );
        cosine.map(Some).ok_or(within.not_finite())
    }

    /// Of a superlative, leaves those objects that may be meant: of the relation first, "the leftmost
    /// of those nearest to …". Whether one of them may be chosen, as it is seen whole.
    fn compare(&mut self, sought: &Description, within: &Within<'_>) -> Result<bool, Refusal> {
        let related = sought.relations().first().zip(self.anchor);
        let related = related.and_then(|(relation, anchor)| match relation.kind {
            RelationKind::Action(_) => None,
            RelationKind::Nearest => Some(Superlative::Nearest(anchor.index.into())),
            RelationKind::Farthest => Some(Superlative::Farthest(anchor.index.into())),
        });
        let which = sought.filters().which().map(Superlative::Extreme);
        let mut is_clear = true;
        for superlative in related.into_iter().chain(which) {
            is_clear &= superlative.compare(self.scores.values_mut(), &self.volumes, within)?;
        }
        Ok(is_clear)
    }

    /// The object that fits, if only one does and is clearly in its relation. Objects that fit
    /// without being clearly in it count as others that fit.
    ///
    /// * `is_clear`: what [`Resolver::compare`] says
    fn choose(
        &self,
        sought: &Description,
        within: &Within<'_>,
        is_clear: bool,
    ) -> Result<Grounding, Refusal> {
        let threshold = within.model.header.thresholds.match_score;
        let best = self.best(within);
        let Some(best) = best.filter(|best| best.score >= threshold) else {
            let best = best.map(|best| candidate(&best, best.score));
            return Err(within.no_such_object(sought, best, threshold));
        };
        let mut candidates = Candidates::default();
        for (object, &score) in within.scene.objects().iter().zip(self.scores.values()) {
            if score >= threshold {
                candidates.add(Candidate {
                    object: object.id,
                    score,
                });
            }
        }
        if candidates.count() > 1 || !is_clear {
            return Err(Refusal::Ambiguous {
                step: within.step as u8,
                argument: within.argument,
                description: *sought,
                candidates,
            });
        }
        let related = self.relation(sought, within, usize::from(best.index))?;
        if let Some(score) = related.filter(|related| *related < RELATION_CLEAR) {
            let vague = Some(candidate(&best, score));
            return Err(within.no_such_object(sought, vague, RELATION_CLEAR));
        }
        Ok(self.anchor.map_or(best, |anchor| best.related_to(&anchor)))
    }

    fn best(&self, within: &Within<'_>) -> Option<Grounding> {
        let chosen = self.scores.unique()?;
        let object = within.scene.objects().get(chosen.index)?;
        Some(Grounding::new(object.id, chosen.index as u8, &chosen))
    }
}

impl Within<'_> {
    /// The centre of an object: world frame, metres.
    ///
    /// * `location`: as the training's camera would see it
    pub(super) fn place(&self, location: &[f32; LOCATION]) -> Point3<f32> {
        self.viewpoint
            .training()
            .locate(self.model.camera, location)
    }

    pub(super) const fn not_finite(&self) -> Refusal {
        Refusal::NotFinite {
            step: self.step as u8,
            quantity: Quantity::Score(self.argument),
        }
    }

    fn no_such_object(
        &self,
        sought: &Description,
        best: Option<Candidate>,
        threshold: f32,
    ) -> Refusal {
        Refusal::NoSuchObject {
            step: self.step as u8,
            argument: self.argument,
            description: *sought,
            best,
            threshold,
        }
    }
}

const fn candidate(grounding: &Grounding, score: f32) -> Candidate {
    Candidate {
        object: grounding.object,
        score,
    }
}
