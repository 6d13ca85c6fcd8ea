use nsrm_core::Refusal as CoreRefusal;
use nsrm_core::dsl::Argument;
use nsrm_core::refusal::Candidate as CoreCandidate;

use crate::capacity::MAX_CANDIDATES;
use crate::pointers::Sized32;
use crate::program::{Description, Property, Span};
use crate::text::Text;

/// Why a sentence is refused. Later versions append theirs: treat an unknown one as a refusal, and
/// report it by its message.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
// Names for C; here the numbers come from `KINDS`.
#[allow(dead_code)]
pub enum RefusalKind {
    /// The sentence has no words.
    NoWords = 1,
    /// A word that the model was not trained on: `span`.
    UnknownWord = 2,
    /// The sentence is longer than `limit`; `detail` is the unit.
    SentenceTooLong = 3,
    /// More adjacent attribute values than `limit`: `span`.
    TooManyConcepts = 4,
    /// Two values of one attribute, such as two colours, or two extremes: `span`, `values`.
    ConflictingValues = 5,
    /// More steps than `limit`.
    TooManySteps = 6,
    /// A step describes more objects than its two: `step`, `span`, `limit`.
    TooManyReferences = 7,
    /// A step does not describe both of its objects: `step`, `span`, `references`.
    IncompleteStep = 8,
    /// The same words were taken for both objects: `step`, `span`.
    SameReference = 9,
    /// The parser is not sure enough: `step`, `probability`, `threshold`; `detail` is the decision.
    Unsure = 10,
    /// No object fits: `step`, `argument`, `description`, `threshold`; the best one is the only
    /// candidate.
    NoSuchObject = 11,
    /// Several objects fit: `step`, `argument`, `description`, `candidates`.
    Ambiguous = 12,
    /// Both descriptions fit the same object, and no other: `step`, `object`.
    SameObject = 13,
    /// A network's result is not finite: `step`; `detail` is the result.
    NotFinite = 14,
    /// A sub-goal is outside the work space: `step`, `object`, `position`.
    OutsideWorkSpace = 15,
    /// The scene's embeddings were computed by another model.
    OtherModel = 16,
    /// The scene disagrees with the camera's calibration: `object`, `measured_m`, `expected_m`;
    /// `detail` is what was measured.
    Calibration = 17,
    /// The sentence was parsed by another model.
    ParsedByOtherModel = 18,
    /// The model has an invalid index; impossible if `nsrm_model_check` has passed.
    InvalidModel = 19,
    /// The plan as a whole is not confident enough: `probability`, `threshold`.
    LowConfidence = 20,
    /// The words of a step are known, but not in this order: `step`, `span`, `probability`,
    /// `threshold`.
    UnclearWords = 21,
    /// A description has more relations than `limit`: `step`, `span`.
    TooManyRelations = 22,
    /// An object is outside what the training's camera would see, or is seen from lower: `step`,
    /// `argument`, `object`.
    OutsideTrainingView = 23,
    /// A pronoun may mean one or another object: `step`, `span`.
    UnclearPronoun = 24,
    /// Several objects are described where a single one is needed: `step`, `span`.
    SeveralReferences = 25,
    /// Another number of objects fits a description than it says: `step`, `argument`, `description`,
    /// `limit` objects expected, `fitting`.
    OtherNumber = 26,
    /// The table is moved, described, or something is put beside it: `step`, `span`.
    OnlyOnTable = 27,
    /// What is to be put on the table stands there already: `step`, `object`.
    AlreadyOnTable = 28,
    /// No place on the table is free, in sight and inside the work space: `step`, `object`.
    NoRoomOnTable = 29,
    /// A distance is named from an object of which too little is seen: `step`, `object`.
    HiddenReference = 30,
    /// What is to be moved by a distance from where it is does not stand on the table: `step`, `object`.
    NotOnTable = 31,
}

/// An object that fits a description.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Candidate {
    /// Its id.
    pub object: u32,
    /// Its score, a cosine.
    pub score: f32,
}

/// Why a sentence is refused, for programs; `nsrm_refusal_message` says it to people. What a kind does
/// not name is 0.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Refusal {
    /// `sizeof(nsrm_refusal_t)`; set it before the call.
    pub size: u32,
    /// The number of an `nsrm_refusal_kind_t`.
    pub kind: u32,
    /// Which step, from 0.
    pub step: u32,
    /// Which argument: 1 for the object to move, 2 for the reference, 0 for none.
    pub argument: u32,
    /// The place in the sentence.
    pub span: Span,
    /// The greatest number or length.
    pub limit: u32,
    /// How many objects the step describes.
    pub references: u32,
    /// The two values.
    pub values: [Property; 2],
    /// The description that does not fit, or fits several.
    pub description: Description,
    /// Id of the object.
    pub object: u32,
    /// How many objects fit.
    pub fitting: u32,
    /// How many of them are listed.
    pub candidate_count: u32,
    /// These objects, the best first; 0 behind the last.
    pub candidates: [Candidate; MAX_CANDIDATES],
    /// The probability.
    pub probability: f32,
    /// The least one, or the least score, with which it would have been accepted.
    pub threshold: f32,
    /// Where the object's centre would be: world frame, metres.
    pub position: [f32; 3],
    /// What was measured, metres.
    pub measured_m: f32,
    /// What would agree with the calibration, metres.
    pub expected_m: f32,
    /// Which unit, decision, result or quantity: a name in snake case that lives for ever.
    pub detail: Text,
}

// SAFETY: the first field is the size.
unsafe impl Sized32 for Refusal {}

impl From<CoreCandidate> for Candidate {
    fn from(candidate: CoreCandidate) -> Self {
        Self {
            object: candidate.object,
            score: candidate.score,
        }
    }
}

/// The number of an argument.
const fn number(argument: Argument) -> u32 {
    match argument {
        Argument::Reference => 2,
        _ => 1,
    }
}

impl Refusal {
    /// Of no kind.
    fn empty() -> Self {
        Self {
            size: size_of::<Self>() as u32,
            kind: 0,
            step: 0,
            argument: 0,
            span: Span::default(),
            limit: 0,
            references: 0,
            values: [Property::default(); 2],
            description: Description::default(),
            object: 0,
            fitting: 0,
            candidate_count: 0,
            candidates: [Candidate::default(); MAX_CANDIDATES],
            probability: 0.0,
            threshold: 0.0,
            position: [0.0; 3],
            measured_m: 0.0,
            expected_m: 0.0,
            detail: Text::NONE,
        }
    }

    fn list(&mut self, candidates: impl Iterator<Item = CoreCandidate>) {
        for (place, candidate) in self.candidates.iter_mut().zip(candidates) {
            *place = candidate.into();
            self.candidate_count += 1;
        }
    }
}

/// The kind's number: its place in [`CoreRefusal::KINDS`], from 1.
fn kind(refusal: &CoreRefusal) -> u32 {
    let place = CoreRefusal::KINDS
        .iter()
        .position(|kind| *kind == refusal.kind());
    // All kinds are there.
    place.map_or(0, |place| place as u32 + 1)
}

impl From<&CoreRefusal> for Refusal {
    #[rustfmt::skip]
    fn from(refusal: &CoreRefusal) -> Self {
        let mut told = Self { kind: kind(refusal), ..Self::empty() };
        match *refusal {
            CoreRefusal::UnknownWord { span } => told.span = span.into(),
            CoreRefusal::SentenceTooLong { limit, unit } => {
                told.limit = limit.into();
                told.detail = Text::of(unit.name());
            }
            CoreRefusal::TooManyConcepts { span, limit } => {
                (told.span, told.limit) = (span.into(), limit.into());
            }
            CoreRefusal::ConflictingValues { span, first, second } => {
                told.span = span.into();
                told.values = [first, second].map(Property::from);
            }
            CoreRefusal::TooManySteps { limit } => told.limit = limit.into(),
            CoreRefusal::TooManyReferences { step, span, limit }
            | CoreRefusal::TooManyRelations { step, span, limit } => {
                (told.step, told.span, told.limit) = (step.into(), span.into(), limit.into());
            }
            CoreRefusal::IncompleteStep { step, references, span } => {
                (told.step, told.span) = (step.into(), span.into());
                told.references = references.into();
            }
            CoreRefusal::SameReference { step, span }
            | CoreRefusal::SeveralReferences { step, span }
            | CoreRefusal::OnlyOnTable { step, span }
            | CoreRefusal::UnclearPronoun { step, span } => {
                (told.step, told.span) = (step.into(), span.into());
            }
            CoreRefusal::UnclearWords { step, span, probability, threshold } => {
                (told.step, told.span) = (step.into(), span.into());
                (told.probability, told.threshold) = (probability, threshold);
            }
            CoreRefusal::Unsure { step, decision, probability, threshold } => {
                told.step = step.into();
                (told.probability, told.threshold) = (probability, threshold);
                told.detail = Text::of(decision.name());
            }
            CoreRefusal::NoSuchObject { step, argument, description, best, threshold } => {
                (told.step, told.argument) = (step.into(), number(argument));
                (told.description, told.threshold) = ((&description).into(), threshold);
                told.list(best.into_iter());
            }
            CoreRefusal::OtherNumber { step, description, expected, got } => {
                (told.step, told.argument) = (step.into(), number(Argument::Object));
                told.description = (&description).into();
                (told.limit, told.fitting) = (expected.into(), got.into());
            }
            CoreRefusal::Ambiguous { step, argument, description, candidates } => {
                (told.step, told.argument) = (step.into(), number(argument));
                told.description = (&description).into();
                // At most MAX_OBJECTS.
                told.fitting = candidates.count() as u32;
                told.list(candidates.listed().iter().copied());
            }
            CoreRefusal::SameObject { step, object }
            | CoreRefusal::AlreadyOnTable { step, object }
            | CoreRefusal::NoRoomOnTable { step, object }
            | CoreRefusal::HiddenReference { step, object }
            | CoreRefusal::NotOnTable { step, object } => {
                (told.step, told.object) = (step.into(), object);
            }
            CoreRefusal::NotFinite { step, quantity } => {
                told.step = step.into();
                told.detail = Text::of(quantity.name());
            }
            CoreRefusal::OutsideTrainingView { step, argument, object } => {
                (told.step, told.argument, told.object) = (step.into(), number(argument), object);
            }
            CoreRefusal::OutsideWorkSpace { step, object, position, .. } => {
                (told.step, told.object, told.position) = (step.into(), object, position);
            }
            CoreRefusal::LowConfidence { confidence, threshold } => {
                (told.probability, told.threshold) = (confidence, threshold);
            }
            CoreRefusal::Calibration(fault) => {
                told.object = fault.object;
                (told.measured_m, told.expected_m) = (fault.measured_m, fault.expected_m);
                told.detail = Text::of(fault.quantity.name());
            }
            // Without anything but its kind, as are those of later versions.
            _ => {}
        }
        told
    }
}

#[cfg(test)]
mod tests {
    use nsrm_core::{language, refusal};

    use super::*;

    #[test]
    fn the_kinds_are_those_of_core_in_their_order() {
        let header = include_str!("../include/nsrm.h");
        for (number, kind) in (1..).zip(CoreRefusal::KINDS) {
            let line = format!("NSRM_REFUSAL_{} = {number},", kind.to_uppercase());
            assert!(header.contains(&line), "{line}");
        }
        let last = RefusalKind::NotOnTable as usize;
        assert_eq!(last, CoreRefusal::KINDS.len());
    }

    #[test]
    fn what_a_kind_names_is_copied() {
        let span = language::Span { start: 3, end: 9 };
        let told = Refusal::from(&CoreRefusal::UnclearWords {
            step: 2,
            span,
            probability: 0.25,
            threshold: 0.5,
        });
        assert_eq!(told.kind, RefusalKind::UnclearWords as u32);
        assert_eq!((told.step, told.span), (2, Span { start: 3, end: 9 }));
        assert_eq!((told.probability, told.threshold), (0.25, 0.5));
        let told = Refusal::from(&CoreRefusal::Unsure {
            step: 1,
            decision: refusal::Decision::Argument(Argument::Reference),
            probability: 0.25,
            threshold: 0.5,
        });
        assert_eq!(told.detail.length, "reference".len());
    }
}
