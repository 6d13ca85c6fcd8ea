//! A step of a program in a [`PlanReply`](super::PlanReply).

#[cfg(feature = "processes")]
use iceoryx2::prelude::ZeroCopySend;
use nsrm_core::dsl::{Argument, Description, Filters, Property, Relation, RelationKind, Step};
use nsrm_core::planner::PlannedStep;
use nsrm_core::{MAX_FILTERS, MAX_RELATIONS};

use super::checks::{all_finite, is_unit};
use super::layout::message;

message! {
    /// A relation in a description: to what, and where this lies from it.
    "nsrm.v1.RelationMessage.c033a237e5f05959"
    pub struct RelationMessage {
        /// 0: the state that an action brings about; 1: nearest; 2: farthest; 3: none, a further
        /// reference of what is between two.
        pub kind: u32,
        /// Index of that action in the model; 0 for the other kinds.
        pub action: u32,
        /// How many concepts describe the other object.
        pub count: u32,
        /// Those concepts: indices in the model; 0 after the last.
        pub concepts: [u8; MAX_FILTERS],
        /// Which of several such objects: 0 if that is left open, 1 for the largest, 2 for the
        /// smallest, or 3 plus the index of the action in whose direction it lies farthest.
        pub which: u32,
    }
}

message! {
    /// A step as parsed and, if it is still to be done, as grounded.
    "nsrm.v1.StepMessage.cf0090730a3b4daa"
    pub struct StepMessage {
        /// Index of the action in the model.
        pub action: u32,
        /// How many concepts describe the object to move.
        pub object_count: u32,
        /// Those concepts: indices in the model; 0 after the last.
        pub object: [u8; MAX_FILTERS],
        /// Which of several such objects is moved, as in a relation.
        pub object_which: u32,
        /// How many concepts describe objects that are not moved though all else fits; 0 if none is
        /// left out.
        pub object_except_count: u32,
        /// Those concepts.
        pub object_except: [u8; MAX_FILTERS],
        /// Whether a single such object is left out, 0, or any number, as which of several.
        pub object_except_which: u32,
        /// How many relations the description of the object to move has.
        pub object_relation_count: u32,
        /// Those relations: its own to another object, then that one's to a third; all 0 after the
        /// last.
        pub object_relations: [RelationMessage; MAX_RELATIONS],
        /// How many concepts describe the reference.
        pub reference_count: u32,
        /// Those concepts.
        pub reference: [u8; MAX_FILTERS],
        /// Which of several such objects is the reference, as in a relation.
        pub reference_which: u32,
        /// How many concepts describe objects that are not the reference though all else fits.
        pub reference_except_count: u32,
        /// Those concepts.
        pub reference_except: [u8; MAX_FILTERS],
        /// Whether a single such object is left out, 0, or any number.
        pub reference_except_which: u32,
        /// How many relations the description of the reference has.
        pub reference_relation_count: u32,
        /// Those relations.
        pub reference_relations: [RelationMessage; MAX_RELATIONS],
        /// The distance between the faces of the two, or by which the object is moved from where it
        /// is, millimetres; 0 where the sentence names none.
        pub distance_mm: u32,
        /// Id of the object to move; 0 if the step is not grounded, and then all fields below are
        /// 0.
        pub object_id: u32,
        /// Id of the reference; of the table, that of the object beside which there is room; of the
        /// object itself, its own.
        pub reference_id: u32,
        /// How well the object fits its description, a cosine.
        pub object_score: f32,
        /// How well the reference fits.
        pub reference_score: f32,
        /// Probability of each choice: split, acceptable words, action, relations between the words,
        /// words of the object, words of the reference, object, reference.
        pub confidence: [f32; 8],
        /// Sub-goal position of the object's centre: world frame, metres.
        pub position: [f32; 3],
        /// Sub-goal orientation, world frame: x, y, z, w.
        pub orientation: [f32; 4],
        /// Predicted location in the image: x1, y1, x2, y2 as fractions of the image, mean depth in
        /// metres.
        pub location: [f32; 5],
    }
}

impl RelationMessage {
    /// None.
    const EMPTY: Self = Self {
        kind: 0,
        action: 0,
        count: 0,
        concepts: [0; MAX_FILTERS],
        which: 0,
    };

    /// Whether a received relation is valid.
    fn makes_sense(&self) -> bool {
        self.kind().is_some() && self.count <= MAX_FILTERS as u32 && is_which(self.which)
    }

    /// What relates the objects; `None` in a relation that is not valid.
    fn kind(&self) -> Option<RelationKind> {
        match (self.kind, self.action) {
            (0, action) => Some(RelationKind::Action(u8::try_from(action).ok()?)),
            (1, 0) => Some(RelationKind::Nearest),
            (2, 0) => Some(RelationKind::Farthest),
            (3, 0) => Some(RelationKind::And),
            _ => None,
        }
    }
}

impl StepMessage {
    /// None.
    pub(super) const EMPTY: Self = Self {
        action: 0,
        object_count: 0,
        object: [0; MAX_FILTERS],
        object_which: 0,
        object_except_count: 0,
        object_except: [0; MAX_FILTERS],
        object_except_which: 0,
        object_relation_count: 0,
        object_relations: [RelationMessage::EMPTY; MAX_RELATIONS],
        reference_count: 0,
        reference: [0; MAX_FILTERS],
        reference_which: 0,
        reference_except_count: 0,
        reference_except: [0; MAX_FILTERS],
        reference_except_which: 0,
        reference_relation_count: 0,
        reference_relations: [RelationMessage::EMPTY; MAX_RELATIONS],
        distance_mm: 0,
        object_id: 0,
        reference_id: 0,
        object_score: 0.0,
        reference_score: 0.0,
        confidence: [0.0; 8],
        position: [0.0; 3],
        orientation: [0.0; 4],
        location: [0.0; 5],
    };

    /// A step of a program, not grounded.
    pub(super) fn understood(step: &Step) -> Self {
        Self {
            action: step.action.into(),
            distance_mm: step.distance_mm.map_or(0, |mm| mm.get().into()),
            ..Self::about(&step.object, &step.reference)
        }
    }

    /// A step about these, and nothing else.
    fn about(object: &Description, reference: &Description) -> Self {
        let mut step = Self::EMPTY;
        (step.object_count, step.object, step.object_which) = told(object.filters());
        let except = object.except().copied().unwrap_or_default();
        (
            step.object_except_count,
            step.object_except,
            step.object_except_which,
        ) = told(&except);
        (step.object_relation_count, step.object_relations) = relations(object);
        (step.reference_count, step.reference, step.reference_which) = told(reference.filters());
        let except = reference.except().copied().unwrap_or_default();
        (
            step.reference_except_count,
            step.reference_except,
            step.reference_except_which,
        ) = told(&except);
        (step.reference_relation_count, step.reference_relations) = relations(reference);
        step
    }

    /// The same step, grounded.
    pub(super) fn ground(&mut self, planned: &PlannedStep) {
        let (object, reference) = (&planned.object, &planned.reference);
        let confidence = &planned.confidence;
        let pose = &planned.sub_goal.pose;
        self.object_id = object.object;
        self.reference_id = reference.object;
        self.object_score = object.score;
        self.reference_score = reference.score;
        self.confidence = [
            confidence.split,
            confidence.words,
            confidence.action,
            confidence.relations,
            confidence.object,
            confidence.reference,
            confidence.object_unique,
            confidence.reference_unique,
        ];
        self.position = pose.translation.vector.into();
        self.orientation = pose.rotation.coords.into();
        self.location = planned.location;
    }

    /// The description of one of the arguments, in a step that has been checked.
    pub fn description(&self, argument: Argument) -> Description {
        let (filters, except, relation_count, relations) = match argument {
            Argument::Reference => (
                filters(self.reference_count, &self.reference, self.reference_which),
                filters(
                    self.reference_except_count,
                    &self.reference_except,
                    self.reference_except_which,
                ),
                self.reference_relation_count,
                &self.reference_relations,
            ),
            // There are these two.
            _ => (
                filters(self.object_count, &self.object, self.object_which),
                filters(
                    self.object_except_count,
                    &self.object_except,
                    self.object_except_which,
                ),
                self.object_relation_count,
                &self.object_relations,
            ),
        };
        let mut description = Description::of(filters).excepting(except);
        for relation in relations.iter().take(relation_count as usize) {
            // As many places; other kinds were refused.
            let _ = description.relate(Relation {
                kind: relation.kind().unwrap_or(RelationKind::Action(u8::MAX)),
                to: self::filters(relation.count, &relation.concepts, relation.which),
            });
        }
        description
    }

    /// Whether it is still to be done.
    pub const fn is_grounded(&self) -> bool {
        self.object_id != 0
    }

    /// Whether a received step is valid.
    pub(super) fn makes_sense(&self) -> bool {
        let counts = [
            self.object_count,
            self.reference_count,
            self.object_except_count,
            self.reference_except_count,
        ];
        let relation_counts = [self.object_relation_count, self.reference_relation_count];
        let mut relations = self
            .object_relations
            .iter()
            .chain(&self.reference_relations);
        let which = [
            self.object_which,
            self.reference_which,
            self.object_except_which,
            self.reference_except_which,
        ];
        let described = counts.iter().all(|count| *count <= MAX_FILTERS as u32)
            && which.into_iter().all(is_which)
            && relation_counts
                .iter()
                .all(|count| *count <= MAX_RELATIONS as u32)
            && relations.all(RelationMessage::makes_sense);
        let numbers: [&[f32]; 4] = [
            &self.position,
            &self.location,
            &self.confidence,
            &[self.object_score, self.reference_score],
        ];
        let finite = numbers.into_iter().all(all_finite);
        let far = self.distance_mm <= u16::MAX.into();
        described && far && finite && (!self.is_grounded() || is_unit(&self.orientation))
    }
}

/// The number of concepts of filters, the concepts, and which of the objects that fit.
fn told(filters: &Filters) -> (u32, [u8; MAX_FILTERS], u32) {
    let mut places = [0; MAX_FILTERS];
    for (place, &concept) in places.iter_mut().zip(filters.concepts()) {
        *place = concept;
    }
    let which = filters.choice().map_or(0, Property::which_number);
    // At most MAX_FILTERS.
    (filters.concepts().len() as u32, places, which)
}

/// The number of relations of a description, and the relations.
fn relations(description: &Description) -> (u32, [RelationMessage; MAX_RELATIONS]) {
    let mut places = [RelationMessage::EMPTY; MAX_RELATIONS];
    for (place, relation) in places.iter_mut().zip(description.relations()) {
        let (count, concepts, which) = told(&relation.to);
        let (kind, action) = match relation.kind {
            RelationKind::Action(action) => (0, action.into()),
            RelationKind::Nearest => (1, 0),
            RelationKind::Farthest => (2, 0),
            RelationKind::And => (3, 0),
        };
        *place = RelationMessage {
            kind,
            action,
            count,
            concepts,
            which,
        };
    }
    // At most MAX_RELATIONS.
    (description.relations().len() as u32, places)
}

/// Whether a received number is 0 or says which of the objects that fit.
fn is_which(number: u32) -> bool {
    number == 0 || Property::of_which_number(number).is_some()
}

/// The first `count` concepts, and which of the objects that have them.
fn filters(count: u32, concepts: &[u8; MAX_FILTERS], which: u32) -> Filters {
    let mut filters = Filters::new();
    if let Some(choice) = Property::of_which_number(which) {
        // There is always room for it.
        let _ = filters.add(choice);
    }
    for &concept in concepts.iter().take(count as usize) {
        // As many places.
        let _ = filters.push(concept);
    }
    filters
}

#[cfg(test)]
mod tests {
    use nsrm_core::dsl::{Extreme, Quantifier};

    use super::*;

    fn of(concepts: &[u8]) -> Filters {
        let mut filters = Filters::new();
        for &concept in concepts {
            filters.push(concept).unwrap();
        }
        filters
    }

    #[test]
    fn descriptions_arrive_with_their_relations() {
        let mut object = Description::of(of(&[3, 1]));
        for (kind, concepts) in [
            (RelationKind::Action(2), &[4][..]),
            (RelationKind::Farthest, &[0, 5, 6, 7]),
        ] {
            let to = of(concepts);
            object.relate(Relation { kind, to }).unwrap();
        }
        let mut to = of(&[2]);
        to.add(Property::Extreme(Extreme::Action(u8::MAX))).unwrap();
        let mut all = of(&[5]);
        all.add(Property::Quantifier(Quantifier::All)).unwrap();
        let mut extreme = Filters::new();
        extreme.add(Property::Extreme(Extreme::Largest)).unwrap();
        let mut reference = Description::of(extreme);
        let kind = RelationKind::Nearest;
        reference.relate(Relation { kind, to }).unwrap();
        for (object, reference) in [
            (object, reference),
            (reference, Description::new()),
            (Description::of(to), object),
            (Description::of(all), reference),
            (
                Description::of(all).excepting(to),
                reference.excepting(of(&[1, 6])),
            ),
        ] {
            let message = StepMessage::about(&object, &reference);
            assert!(message.makes_sense());
            assert_eq!(message.description(Argument::Object), object);
            assert_eq!(message.description(Argument::Reference), reference);
        }
    }

    #[test]
    fn what_no_step_has_is_refused() {
        let cases: [fn(&mut StepMessage); 11] = [
            |step| step.distance_mm = 65_536,
            |step| step.object_except_count = 5,
            |step| step.reference_except_which = 511,
            |step| step.object_which = 259,
            |step| step.reference_relations[1].which = u32::MAX,
            |step| step.object_relation_count = 3,
            |step| step.reference_relation_count = u32::MAX,
            |step| step.object_relations[1].count = 5,
            |step| step.reference_relations[0].action = 256,
            |step| step.reference_relations[1].kind = 4,
            |step| {
                (
                    step.object_relations[0].kind,
                    step.object_relations[0].action,
                ) = (1, 1)
            },
        ];
        for break_it in cases {
            let mut broken = StepMessage::EMPTY;
            break_it(&mut broken);
            assert!(!broken.makes_sense());
        }
    }
}
