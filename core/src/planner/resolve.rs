use heapless::Vec;
use nalgebra::Point3;

use super::Grounding;
use super::sight::{Fit, Sight};
use super::superlative::Superlative;
use crate::capacity::MAX_OBJECTS;
use crate::dsl::{Argument, Description, Extreme, Filters, Quantifier, Relation, RelationKind};
use crate::grounding::{Filtered, ScoreError, Scores, filter};
use crate::model::{LOCATION, Model};
use crate::refusal::{Candidate, Candidates, Quantity, Refusal};
use crate::relation::{RELATION_CLEAR, between, relate};
use crate::scene::{ObservedObject, Scene};
use crate::viewpoint::Viewpoint;
use crate::vision;

/// How many objects "both" means.
const BOTH: usize = 2;

/// Which objects are not among several that are moved.
#[derive(Debug, Clone, Copy)]
pub(super) enum LeftOut {
    /// None: they are moved from where they are.
    None,
    /// The one in relation to which they are moved: its place in the scene.
    Object(u8),
    /// What stands on the table, since they are put there.
    OnTable,
}

/// Finds the object that a description refers to, from the innermost anchor of its relations
/// outwards. Each [`Resolver::poll`] scores one object or chooses one.
#[derive(Debug, Clone)]
pub(super) struct Resolver {
    /// Links of the chain outside of what is sought now.
    level: usize,
    /// What the link inside refers to.
    anchor: Option<Grounding>,
    scores: Scores,
    /// What else is known of the objects that have a score.
    judged: [Judged; MAX_OBJECTS],
}

/// What is known of an object, beside its score.
#[derive(Debug, Clone, Copy)]
pub(super) struct Judged {
    /// Whether it is what is sought.
    pub(super) fit: Fit,
    /// Whether its place is less certain.
    pub(super) is_rough: bool,
    /// If objects are compared by size: NaN if it's not known.
    pub(super) volume: f32,
    /// Whether it is left out, though it would fit.
    is_excepted: bool,
}

impl Judged {
    /// Nothing known.
    const UNKNOWN: Self = Self {
        fit: Fit::No,
        is_rough: false,
        volume: f32::NAN,
        is_excepted: false,
    };
}

/// What a description is resolved in.
#[derive(Clone, Copy)]
pub(super) struct Within<'a> {
    pub(super) model: &'a Model<'a>,
    pub(super) scene: &'a Scene,
    pub(super) viewpoint: &'a Viewpoint<'a>,
    /// Where the objects are after the steps so far, as the training's camera would see them.
    pub(super) locations: &'a [[f32; LOCATION]; MAX_OBJECTS],
    /// Whether they moved anything.
    pub(super) has_moved: bool,
    pub(super) step: usize,
    pub(super) argument: Argument,
    /// The id of the only object that may be meant, of several that are moved.
    pub(super) each: Option<u32>,
}

impl Resolver {
    /// Nothing scored yet.
    pub(super) fn new(description: &Description) -> Self {
        let relations = description.relations();
        // The table is no object that is sought.
        let sought = match relations.split_last() {
            Some((innermost, others)) if innermost.to.is_table() => others,
            _ => relations,
        };
        Self {
            level: sought.len(),
            anchor: None,
            scores: Scores::new(),
            judged: [Judged::UNKNOWN; MAX_OBJECTS],
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
        if self.score_next(&sought, within)? {
            return Ok(None);
        }
        self.check_excepted(&sought, within)?;
        let is_clear = self.compare(&sought, within)?;
        let found = self.choose(&sought, within, is_clear)?;
        let Some(level) = self.level.checked_sub(1) else {
            return Ok(Some(found));
        };
        *self = Self {
            level,
            anchor: Some(found),
            scores: Scores::new(),
            judged: [Judged::UNKNOWN; MAX_OBJECTS],
        };
        Ok(None)
    }

    /// Does one unit of work on a description of several objects; their ids once they are found, from
    /// the highest to the lowest, so that none carries one that is moved later.
    ///
    /// * `description`: the one that it was made for
    /// * `left_out`: objects that are none of them, though they fit
    pub(super) fn poll_several(
        &mut self,
        description: &Description,
        within: &Within<'_>,
        left_out: LeftOut,
    ) -> Result<Option<Vec<u32, MAX_OBJECTS, u8>>, Refusal> {
        if self.level > 0 {
            // Its relation is to a single object.
            return self.poll(description, within).map(|_| None);
        }
        if self.score_next(description, within)? {
            return Ok(None);
        }
        self.check_excepted(description, within)?;
        let threshold = within.model.header.thresholds.match_score;
        let mut unclear = Candidates::default();
        // Heights and ids, the highest first.
        let mut found: Vec<(f32, u32), MAX_OBJECTS, u8> = Vec::new();
        let mut on_table = None;
        let objects = within.scene.objects().iter().zip(within.locations);
        let scores = self.scores.values().iter().zip(self.judged);
        for (index, ((object, location), (&score, judged))) in objects.zip(scores).enumerate() {
            let fits = score >= threshold;
            match left_out {
                LeftOut::Object(reference) if index == usize::from(reference) => continue,
                LeftOut::OnTable if within.is_on_table(index) => {
                    on_table = on_table.or(fits.then_some(object.id));
                    continue;
                }
                _ => {}
            }
            let related = self.relation(description, within, index)?;
            let is_vague = fits && related.is_some_and(|related| related < RELATION_CLEAR);
            if is_vague || judged.fit == Fit::Maybe {
                unclear.add(Candidate {
                    object: object.id,
                    score,
                });
            }
            if fits {
                let mut lower = (within.place(location).z, object.id);
                // Each place behind the object's takes what stood in front of it.
                for place in &mut found {
                    if lower.0 > place.0 {
                        core::mem::swap(place, &mut lower);
                    }
                }
                // As many places as a scene has objects.
                let _ = found.push(lower);
            }
        }
        if let Some(object) = on_table.filter(|_| found.is_empty()) {
            let step = within.step as u8;
            return Err(Refusal::AlreadyOnTable { step, object });
        }
        if found.is_empty() {
            let best = self.best(within);
            let best = best.map(|best| candidate(&best, best.score));
            return Err(within.no_such_object(description, best, threshold));
        }
        if unclear.count() > 0 {
            return Err(within.ambiguous(description, unclear));
        }
        if description.filters().quantifier() == Some(Quantifier::Both) && found.len() != BOTH {
            return Err(Refusal::OtherNumber {
                step: within.step as u8,
                description: *description,
                expected: BOTH as u8,
                got: found.len() as u8,
            });
        }
        let mut ids = Vec::new();
        for (_, id) in &found {
            // As many places.
            let _ = ids.push(*id);
        }
        Ok(Some(ids))
    }

    /// Scores the next object; false if none is left.
    fn score_next(&mut self, sought: &Description, within: &Within<'_>) -> Result<bool, Refusal> {
        let index = self.scores.values().len();
        let Some(object) = within.scene.objects().get(index) else {
            return Ok(false);
        };
        let (score, judged) = self.judge(sought, within, index, object)?;
        if let Some(place) = self.judged.get_mut(index) {
            *place = judged;
        }
        // As many places as a scene has objects.
        let _ = self.scores.push(score);
        Ok(true)
    }

    /// How well the next object fits, and what else is known of it.
    ///
    /// Of what is seen in part only, the rest tells the colour and its width the size, or nothing does.
    fn judge(
        &self,
        sought: &Description,
        within: &Within<'_>,
        index: usize,
        object: &ObservedObject,
    ) -> Result<(f32, Judged), Refusal> {
        let filters = sought.filters();
        let filtered = within.filtered(object, filters)?;
        let except = sought.except();
        let is_compared = filters.choice().is_some()
            || !matches!(
                sought.relations().first(),
                None | Some(Relation {
                    kind: RelationKind::Action(_) | RelationKind::And,
                    ..
                })
            );
        // Else nothing depends on it.
        let sight = if is_compared || filtered.size.is_some() || except.is_some() {
            Sight::of(index, within)
        } else {
            Sight::WHOLE
        };
        let (mut score, has_size) = seen(&filtered, &sight, within.model);
        if within.each.is_some_and(|each| object.id != each) {
            score = -1.0;
        } else if let Some(related) = self.relation(sought, within, index)? {
            score = score.min(related);
        }
        let threshold = within.model.header.thresholds.match_score;
        let is_open = filters.concepts().is_empty();
        let mut fit = fits(&filtered, &sight, has_size, score >= threshold, is_open);
        let mut is_excepted = false;
        if let Some(except) = except.filter(|_| fit != Fit::No) {
            let filtered = within.filtered(object, except)?;
            let (excepted, has_size) = seen(&filtered, &sight, within.model);
            match fits(&filtered, &sight, has_size, excepted >= threshold, false) {
                Fit::Yes => {
                    (score, is_excepted) = (-1.0, fit == Fit::Yes);
                    fit = Fit::No;
                }
                Fit::No => {}
                Fit::Maybe => fit = Fit::Maybe,
            }
        }
        let volume = match filters.which(within.model) {
            Some((Extreme::Largest | Extreme::Smallest, _)) if sight.is_partial => {
                sight.volume(within.model)
            }
            Some((Extreme::Largest | Extreme::Smallest, _)) => {
                vision::volume(within.model, &object.embedding)
            }
            _ => f32::NAN,
        };
        let judged = Judged {
            fit,
            is_rough: sight.is_rough,
            volume,
            is_excepted,
        };
        Ok((score, judged))
    }

    /// Refuses a single object that is left out if there is none, or several.
    fn check_excepted(&self, sought: &Description, within: &Within<'_>) -> Result<(), Refusal> {
        let except = sought
            .except()
            .filter(|except| except.quantifier().is_none());
        let Some(except) = except else {
            return Ok(());
        };
        let mut candidates = Candidates::default();
        for (object, judged) in within.scene.objects().iter().zip(self.judged) {
            if judged.is_excepted {
                let (object, score) = (object.id, 1.0);
                candidates.add(Candidate { object, score });
            }
        }
        let left_out = Description::of(*except);
        match candidates.count() {
            1 => Ok(()),
            0 => {
                let threshold = within.model.header.thresholds.match_score;
                Err(within.no_such_object(&left_out, None, threshold))
            }
            _ => Err(within.ambiguous(&left_out, candidates)),
        }
    }

    /// How clearly an object is in the relation to the anchor, which never is, or to the table; `None`
    /// without a relation, and for a superlative, which compares those that fit.
    fn relation(
        &self,
        sought: &Description,
        within: &Within<'_>,
        index: usize,
    ) -> Result<Option<f32>, Refusal> {
        let Some(relation) = sought.relations().first() else {
            return Ok(None);
        };
        if relation.to.is_table() {
            return Ok(Some(if within.is_on_table(index) { 1.0 } else { -1.0 }));
        }
        let Some(grounding) = &self.anchor else {
            return Ok(None);
        };
        let anchor = usize::from(grounding.index);
        if index == anchor {
            return Ok(Some(-1.0));
        }
        let RelationKind::Action(action) = relation.kind else {
            return Ok(None);
        };
        // Always there: all are objects of the scene.
        let location = |index: usize| within.locations.get(index).ok_or(Refusal::InvalidModel);
        let (object, anchor) = (location(index)?, location(anchor)?);
        let related = if within.model.is_between(action) {
            let second = within.second(grounding).ok_or(Refusal::InvalidModel)?;
            if index == second {
                return Ok(Some(-1.0));
            }
            let anchors = [anchor, location(second)?];
            between(within.model, within.viewpoint, object, anchors)
        } else {
            relate(within.model, within.viewpoint, action, object, anchor)
        };
        related.map(Some).ok_or(within.not_finite())
    }

    /// Of a superlative, leaves those objects that may be meant: of the relation first, "the leftmost
    /// of those nearest to …". Whether one of them may be chosen, as it is seen whole.
    fn compare(&mut self, sought: &Description, within: &Within<'_>) -> Result<bool, Refusal> {
        let related = sought.relations().first().zip(self.anchor);
        let related = related.and_then(|(relation, anchor)| match relation.kind {
            RelationKind::Action(_) | RelationKind::And => None,
            RelationKind::Nearest => Some(Superlative::Nearest(anchor.index.into())),
            RelationKind::Farthest => Some(Superlative::Farthest(anchor.index.into())),
        });
        let which = sought.filters().which(within.model);
        let which = which.map(|(extreme, rank)| Superlative::Extreme { extreme, rank });
        let mut is_clear = true;
        for superlative in related.into_iter().chain(which) {
            is_clear &= superlative.compare(self.scores.values_mut(), &self.judged, within)?;
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
        let judged = self.judged.get(usize::from(best.index));
        let may_be_excepted =
            sought.except().is_some() && judged.is_none_or(|judged| judged.fit == Fit::Maybe);
        if candidates.count() > 1 || !is_clear || may_be_excepted {
            return Err(within.ambiguous(sought, candidates));
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

/// How well an object fits what is asked of it, as far as it is seen: of what is seen in part only, its width tells the
/// size; and whether it has that.
fn seen(filtered: &Filtered, sight: &Sight, model: &Model<'_>) -> (f32, Option<Fit>) {
    let size = filtered.size.filter(|_| sight.is_partial);
    let has_size = size.map(|size| sight.has_size(size, model));
    let score = match has_size {
        Some(Fit::No) => -1.0,
        Some(Fit::Yes) => filtered.besides_size,
        Some(Fit::Maybe) | None => filtered.score,
    };
    (score, has_size)
}

/// Whether an object is what is asked of it; of what is seen in part only, that may be open.
///
/// * `seems_to`: whether it is by its score
/// * `is_open`: whether every object is
fn fits(
    filtered: &Filtered,
    sight: &Sight,
    has_size: Option<Fit>,
    seems_to: bool,
    is_open: bool,
) -> Fit {
    let is_all_told = sight.is_color_told && filtered.are_colors && has_size != Some(Fit::Maybe);
    let is_clear = !sight.is_partial
        || is_open
        || has_size == Some(Fit::No)
        || (sight.is_color_told && filtered.is_other_color)
        || (seems_to && is_all_told);
    match (is_clear, seems_to) {
        (true, true) => Fit::Yes,
        (true, false) => Fit::No,
        (false, _) => Fit::Maybe,
    }
}

impl Within<'_> {
    /// How an object passes filters.
    fn filtered(&self, object: &ObservedObject, filters: &Filters) -> Result<Filtered, Refusal> {
        filter(self.model, &object.embedding, filters).map_err(|error| match error {
            ScoreError::UnknownConcept => Refusal::InvalidModel,
            ScoreError::NotFinite => self.not_finite(),
        })
    }

    /// The centre of an object: world frame, metres.
    ///
    /// * `location`: as the training's camera would see it
    pub(super) fn place(&self, location: &[f32; LOCATION]) -> Point3<f32> {
        self.viewpoint
            .training()
            .locate(self.model.camera, location)
    }

    /// The place in the scene of what a grounded object is described together with, or by.
    pub(super) fn second(&self, grounding: &Grounding) -> Option<usize> {
        let second = *grounding.anchors().first()?;
        let mut objects = self.scene.objects().iter();
        objects.position(|object| object.id == second)
    }

    /// Whether an object of the scene stands on the table.
    pub(super) fn is_on_table(&self, index: usize) -> bool {
        let place = self
            .locations
            .get(index)
            .map(|location| self.place(location));
        place
            .zip(self.model.on_table_below_m())
            .is_some_and(|(place, below_m)| place.z < below_m)
    }

    pub(super) const fn not_finite(&self) -> Refusal {
        Refusal::NotFinite {
            step: self.step as u8,
            quantity: Quantity::Score(self.argument),
        }
    }

    fn ambiguous(&self, sought: &Description, candidates: Candidates) -> Refusal {
        Refusal::Ambiguous {
            step: self.step as u8,
            argument: self.argument,
            description: by_itself(sought),
            candidates,
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
            description: by_itself(sought),
            best,
            threshold,
        }
    }
}

/// A description without the further reference that it is named together with.
fn by_itself(sought: &Description) -> Description {
    match sought.relations().first() {
        Some(relation) if relation.kind == RelationKind::And => Description::of(*sought.filters()),
        _ => *sought,
    }
}

const fn candidate(grounding: &Grounding, score: f32) -> Candidate {
    Candidate {
        object: grounding.object,
        score,
    }
}
