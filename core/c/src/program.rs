use nsrm_core::Model;
use nsrm_core::dsl::{self, Step};
use nsrm_core::language::{self, Parsed, StepDecisions};

use crate::capacity::{MAX_CORRECTIONS, MAX_FILTERS, MAX_RELATIONS, MAX_STEPS};
use crate::pointers::Sized32;
use crate::text::Text;

/// A part of the sentence, in bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Span {
    /// First byte.
    pub start: u16,
    /// One behind the last byte.
    pub end: u16,
}

/// `which`: the one of the largest volume.
pub const LARGEST: u32 = 1;
/// `which`: the one of the smallest volume.
pub const SMALLEST: u32 = 2;
/// `which`: with the index of an action added, the one that lies farthest in the direction in which the
/// action puts things.
pub const FARTHEST_BY: u32 = 3;

/// `which`: all that fit, apart from the reference; only of what is moved.
pub const ALL: u32 = 512;
/// `which`: all that fit, which are two; only of what is moved.
pub const BOTH: u32 = 513;
/// `which`: one of several that are moved. Once a step with `NSRM_ALL` or `NSRM_BOTH` is grounded, it is
/// replaced by one of these for each object.
pub const EACH: u32 = 514;

/// `which`: the table, and no object.
pub const TABLE: u32 = 515;

/// `which`: the object that is moved, from where it is; of several that are moved, each other one.
pub const ITSELF: u32 = 516;

/// `which`: with an index of `nsrm_ranked_name` added, what is counted from the farthest, the largest or the
/// smallest one, "the second from the left".
pub const RANKED: u32 = 1024;

const _: () = {
    use dsl::{Extreme, Property, Quantifier};
    assert!(Property::Extreme(Extreme::Largest).which_number() == LARGEST);
    assert!(Property::Extreme(Extreme::Smallest).which_number() == SMALLEST);
    assert!(Property::Extreme(Extreme::Action(7)).which_number() == FARTHEST_BY + 7);
    assert!(Property::Quantifier(Quantifier::All).which_number() == ALL);
    assert!(Property::Quantifier(Quantifier::Both).which_number() == BOTH);
    assert!(Property::Quantifier(Quantifier::Each).which_number() == EACH);
    assert!(Property::Table.which_number() == TABLE);
    assert!(Property::Itself.which_number() == ITSELF);
    assert!(Property::Ranked(3).which_number() == RANKED + 3);
};

/// Whether a word names a value, an extreme, a number of objects or the table.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PropertyKind {
    /// What an object looks like, "red".
    Concept = 0,
    /// Which one of several it is, "leftmost".
    Extreme = 1,
    /// That several are meant, "all".
    Quantifier = 2,
    /// That it is the table, and no object.
    Table = 3,
    /// That it is the object that is moved; no word says so.
    Itself = 4,
}

/// What a word says of an object.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Property {
    /// Its kind, of `nsrm_property_kind_t`.
    pub kind: u32,
    /// Index of the concept, or else `which` as in `nsrm_filters_t`.
    pub value: u32,
}

/// Attribute values that an object must have, and which of several it is: "leftmost small red".
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Filters {
    /// How many; 0 for a noun without values.
    pub count: u32,
    /// Their indices, in the order of the sentence; 0 behind the last.
    pub concepts: [u8; MAX_FILTERS],
    /// Which of the objects that have them: 0 if that is left open, `NSRM_LARGEST`, `NSRM_SMALLEST`, or
    /// `NSRM_FARTHEST_BY` plus the index of the action in whose direction it lies farthest; "leftmost" is
    /// that of `MoveLeft`. `NSRM_RANKED` plus an index is what is counted from there. Several that are moved
    /// are `NSRM_ALL`, `NSRM_BOTH` or `NSRM_EACH`. The table, `NSRM_TABLE`, has no values: it is only a
    /// reference, or what an object stands on.
    pub which: u32,
}

/// How an object is related to another one.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RelationKind {
    /// It is where an action puts things: "left of" is where `MoveLeft` does.
    Action = 0,
    /// It is the nearest to the other object, of all that fit.
    Nearest = 1,
    /// It is the farthest from the other object, of all that fit.
    Farthest = 2,
    /// None: the other object is a further reference, of what is put or lies between two.
    And = 3,
}

/// A relation to another object: "left of the yellow one".
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Relation {
    /// Its kind, of `nsrm_relation_kind_t`.
    pub kind: u32,
    /// Index of the action that brings the relation about; 0 for other kinds.
    pub action: u32,
    /// What the other object looks like.
    pub to: Filters,
}

/// What describes one object.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Description {
    /// What the object itself looks like.
    pub filters: Filters,
    /// What objects look like that are not meant though all else fits, "except the red one"; without concepts if
    /// none is left out. `which` is 0 for a single one, or `NSRM_ALL` for any number.
    pub except: Filters,
    /// How many relations there are.
    pub relation_count: u32,
    /// The object's own relation to another one, then that one's to a third; 0 behind the last.
    pub relations: [Relation; MAX_RELATIONS],
}

/// One step of a program.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ProgramStep {
    /// Index of the action.
    pub action: u32,
    /// The object to move.
    pub object: Description,
    /// The reference.
    pub reference: Description,
    /// The distance between the faces of the two, millimetres; 0 where the sentence names none. With
    /// `NSRM_ITSELF` as the reference, that by which the object is moved.
    pub distance_mm: u32,
    /// The step's place in the sentence.
    pub span: Span,
    /// The place of the words that describe the object to move.
    pub object_span: Span,
    /// The place of the words that describe the reference.
    pub reference_span: Span,
    /// The probability that the parser's choices are right.
    pub probability: f32,
}

/// A misspelt word of the sentence, and what it was read as: tell the person.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Correction {
    /// The word's place in the sentence.
    pub span: Span,
    /// The known word; the text lives as long as the model.
    pub read_as: Text,
}

/// What a sentence says, independent of a scene.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Program {
    /// `sizeof(nsrm_program_t)`; set it before the call.
    pub size: u32,
    /// How many steps it has.
    pub step_count: u32,
    /// The steps in the order of execution; 0 behind the last.
    pub steps: [ProgramStep; MAX_STEPS],
    /// How many words were misspelt.
    pub correction_count: u32,
    /// These words; 0 behind the last.
    pub corrections: [Correction; MAX_CORRECTIONS],
}

// SAFETY: the first field is the size.
unsafe impl Sized32 for Program {}

impl From<language::Span> for Span {
    fn from(span: language::Span) -> Self {
        let language::Span { start, end, .. } = span;
        Self { start, end }
    }
}

impl From<dsl::Property> for Property {
    fn from(property: dsl::Property) -> Self {
        let (kind, value) = match property {
            dsl::Property::Concept(concept) => (PropertyKind::Concept, concept.into()),
            dsl::Property::Extreme(_) | dsl::Property::Ranked(_) => {
                (PropertyKind::Extreme, property.which_number())
            }
            dsl::Property::Quantifier(_) => (PropertyKind::Quantifier, property.which_number()),
            dsl::Property::Table => (PropertyKind::Table, property.which_number()),
            dsl::Property::Itself => (PropertyKind::Itself, property.which_number()),
        };
        Self {
            kind: kind as u32,
            value,
        }
    }
}

impl From<&dsl::Filters> for Filters {
    fn from(filters: &dsl::Filters) -> Self {
        let mut copied = Self {
            which: filters.choice().map_or(0, dsl::Property::which_number),
            ..Self::default()
        };
        for (place, concept) in copied.concepts.iter_mut().zip(filters.concepts()) {
            *place = *concept;
            copied.count += 1;
        }
        copied
    }
}

impl From<&dsl::Description> for Description {
    fn from(description: &dsl::Description) -> Self {
        let mut copied = Self {
            filters: description.filters().into(),
            except: description.except().map(Filters::from).unwrap_or_default(),
            ..Self::default()
        };
        for (place, relation) in copied.relations.iter_mut().zip(description.relations()) {
            let (kind, action) = match relation.kind {
                dsl::RelationKind::Action(action) => (RelationKind::Action, action.into()),
                dsl::RelationKind::Nearest => (RelationKind::Nearest, 0),
                dsl::RelationKind::Farthest => (RelationKind::Farthest, 0),
                dsl::RelationKind::And => (RelationKind::And, 0),
            };
            *place = Relation {
                kind: kind as u32,
                action,
                to: (&relation.to).into(),
            };
            copied.relation_count += 1;
        }
        copied
    }
}

impl ProgramStep {
    fn new(step: &Step, decisions: &StepDecisions) -> Self {
        Self {
            action: step.action.into(),
            object: (&step.object).into(),
            reference: (&step.reference).into(),
            distance_mm: step.distance_mm.map_or(0, |mm| mm.get().into()),
            span: decisions.span.into(),
            object_span: decisions.object_span.into(),
            reference_span: decisions.reference_span.into(),
            probability: decisions.split
                * decisions.words
                * decisions.action
                * decisions.relations
                * decisions.object
                * decisions.reference,
        }
    }
}

impl Program {
    /// Without steps.
    pub(crate) fn empty() -> Self {
        const NONE: Correction = Correction {
            span: Span { start: 0, end: 0 },
            read_as: Text::NONE,
        };
        Self {
            size: size_of::<Self>() as u32,
            step_count: 0,
            steps: [ProgramStep::default(); MAX_STEPS],
            correction_count: 0,
            corrections: [NONE; MAX_CORRECTIONS],
        }
    }

    pub(crate) fn new(model: &Model<'static>, parsed: &Parsed) -> Self {
        let mut copied = Self::empty();
        let steps = parsed.program().steps().iter().zip(parsed.decisions());
        for (place, (step, decisions)) in copied.steps.iter_mut().zip(steps) {
            *place = ProgramStep::new(step, decisions);
            copied.step_count += 1;
        }
        for (place, correction) in copied.corrections.iter_mut().zip(parsed.corrections()) {
            *place = Correction {
                span: correction.span().into(),
                read_as: Text::of(correction.read_as(model)),
            };
            copied.correction_count += 1;
        }
        copied
    }
}
