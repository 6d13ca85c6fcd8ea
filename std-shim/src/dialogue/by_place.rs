//! Options by where objects stand, for those that their values do not tell apart: "the red one to
//! the left of the blue one", "the leftmost red one".

use nsrm_core::Scene;
use nsrm_core::dsl::{Description, Extreme, Filters, Property, Relation, RelationKind};
use nsrm_core::grounding::score;
use nsrm_core::relation::{RELATION_CLEAR, relate};
use nsrm_core::scene::ObservedObject;
use nsrm_core::viewpoint::Viewpoint;

use super::described::Described;
use super::{Choice, Context};

/// What objects may be told apart by.
struct Surroundings<'a> {
    viewpoint: Viewpoint<'a>,
    /// Those that have the values of the refused description.
    fitting: Vec<&'a ObservedObject>,
    /// Those whose values name no other object.
    anchors: Vec<(&'a ObservedObject, Filters)>,
}

impl Context<'_> {
    /// An option for each of these objects that is the only one of its values in some relation, or the
    /// one that lies farthest in some direction.
    ///
    /// * `filters`: those of the refused description
    /// * `wanted`: ids of objects that fit it
    pub(super) fn by_place(
        &self,
        place: &Described,
        filters: &Filters,
        wanted: &[u32],
    ) -> Vec<Choice> {
        let Some(around) = self.surroundings(place, filters) else {
            return Vec::new();
        };
        let objects = around.fitting.iter();
        let objects = objects.filter(|object| wanted.contains(&object.id));
        objects
            .filter_map(|object| {
                let mut relations = self.relations(object, &around).into_iter();
                relations
                    .find_map(|relation| self.related(place, filters, relation))
                    .or_else(|| self.extreme(place, filters, object.id))
            })
            .collect()
    }

    /// `None` without a scene, and if an earlier step moves one of the fitting objects: it stands
    /// elsewhere by then. Anchors that are moved are left out.
    fn surroundings(&self, place: &Described, filters: &Filters) -> Option<Surroundings<'_>> {
        let scene = self.scene?;
        let moved = place.moved_before(self.model, scene, self.sentence)?;
        let is_moved = |object: &ObservedObject| moved.contains(&object.id);
        let fitting = self.fitting(scene, filters);
        if fitting.iter().any(|object| is_moved(object)) {
            return None;
        }
        let still = scene.objects().iter().filter(|object| !is_moved(object));
        let anchors = still.map(|object| (object, self.shown(&object.embedding)));
        let names_no_other = |(_, shown): &(&ObservedObject, Filters)| {
            !shown.concepts().is_empty() && self.fitting(scene, shown).len() == 1
        };
        Some(Surroundings {
            viewpoint: Viewpoint::new(self.model, scene.camera()),
            fitting,
            anchors: anchors.filter(names_no_other).collect(),
        })
    }

    /// The objects that have these values.
    fn fitting<'s>(&self, scene: &'s Scene, filters: &Filters) -> Vec<&'s ObservedObject> {
        let threshold = self.model.header.thresholds.match_score;
        let fits = |object: &&ObservedObject| {
            score(self.model, &object.embedding, filters).is_ok_and(|score| score >= threshold)
        };
        scene.objects().iter().filter(fits).collect()
    }

    /// The relations that only this one of the fitting objects is in, the clearest first.
    fn relations(&self, object: &ObservedObject, around: &Surroundings<'_>) -> Vec<Relation> {
        let mut relations = Vec::new();
        for (index, _) in (0..).zip(self.model.actions) {
            for &(anchor, to) in &around.anchors {
                if let Some(cosine) = self.only_one(object, index, anchor, around) {
                    let kind = RelationKind::Action(index);
                    relations.push((cosine, Relation { kind, to }));
                }
            }
        }
        relations.sort_by(|(one, _), (other, _)| other.total_cmp(one));
        relations
            .into_iter()
            .map(|(_, relation)| relation)
            .collect()
    }

    /// How clearly the object is in a relation to an anchor; `None` if it is not, or another fitting
    /// one may be. As the planner judges it.
    fn only_one(
        &self,
        object: &ObservedObject,
        action: u8,
        anchor: &ObservedObject,
        around: &Surroundings<'_>,
    ) -> Option<f32> {
        let (model, viewpoint) = (self.model, &around.viewpoint);
        let cosine = |object: &ObservedObject| {
            let [object, anchor] =
                [object, anchor].map(|seen| viewpoint.to_training(&seen.location));
            relate(model, viewpoint, action, &object, &anchor)
        };
        // An object in a relation to itself has no direction, so that its cosine is -1.
        let own = cosine(object).filter(|own| *own >= RELATION_CLEAR)?;
        let threshold = model.header.thresholds.match_score;
        let mut others = around.fitting.iter();
        let is_other = |other: &ObservedObject| ![object.id, anchor.id].contains(&other.id);
        others
            .all(|other| !is_other(other) || cosine(other).is_some_and(|score| score < threshold))
            .then_some(own)
    }

    /// The option with the refused description's values and this relation.
    fn related(&self, place: &Described, filters: &Filters, relation: Relation) -> Option<Choice> {
        let phrase = relation.kind.phrase(self.model);
        let (own, anchor) = (self.named(filters), self.named(&relation.to));
        let mut description = Description::of(*filters);
        description.relate(relation).ok()?;
        let answer = format!("the {own} one {phrase} the {anchor} one");
        // The noun behind the refused description is then the anchor's.
        let words = format!("{own} that is {phrase} the {anchor}");
        self.option_by(answer, place, &words, &description)
    }

    /// The option with the refused description's values and an extreme that is this object.
    fn extreme(&self, place: &Described, filters: &Filters, wanted: u32) -> Option<Choice> {
        let scene = self.scene.filter(|_| !filters.is_compared())?;
        let actions = (0..).zip(self.model.actions);
        let mut named = actions.filter(|(_, action)| action.extreme.is_some());
        named.find_map(|(index, _)| {
            let mut own = *filters;
            own.add(Property::Extreme(Extreme::Action(index))).ok()?;
            let words = self.named(&own);
            let answer = format!("the {words} one");
            let option = self.option_by(answer, place, &words, &Description::of(own))?;
            let chosen = place.chosen(self.model, scene, &option.sentence);
            (chosen == Some(wanted)).then_some(option)
        })
    }
}
