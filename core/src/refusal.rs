//! Why a sentence is refused: refuse, don't guess. Each variant has what the caller needs to report
//! it, to ask back or to choose; [`Refusal::in_context`] explains it to a person.

use crate::calibration::CalibrationFault;
use crate::capacity::MAX_CANDIDATES;
use crate::dsl::{Argument, Description, Property};
use crate::language::Span;
use crate::model::WorkSpace;

/// Why there is no program or no plan; the first reason found. Steps count from 0.
///
/// Later versions may add reasons: treat an unknown variant as a refusal, and report it by
/// [`Refusal::kind`] and its message.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Refusal {
    /// The sentence has no words.
    NoWords,
    /// A word that the model was not trained on; [`Refusal::suggestion`] may give the intended one.
    UnknownWord {
        /// Its place in the sentence.
        span: Span,
    },
    /// The sentence is too long.
    SentenceTooLong {
        /// The greatest length.
        limit: u16,
        /// The unit of the limit.
        unit: LengthUnit,
    },
    /// Too many adjacent concept words for one description.
    TooManyConcepts {
        /// Their place in the sentence.
        span: Span,
        /// The greatest number in one description.
        limit: u8,
    },
    /// Two adjacent values of one attribute, such as two colours, or two extremes, such as "leftmost
    /// topmost"; or a table that is described, "the red table".
    ConflictingValues {
        /// The description's place in the sentence.
        span: Span,
        /// What the first word says.
        first: Property,
        /// What the other word says.
        second: Property,
    },
    /// Too many steps for a program; several objects that are moved take one for each.
    TooManySteps {
        /// The greatest number in a program.
        limit: u8,
    },
    /// A step describes more than its two objects, as "the red and blue block" or "the block that is
    /// red and small" seem to, or has more groups of concept words than any two descriptions.
    TooManyReferences {
        /// Which step.
        step: u8,
        /// Its place in the sentence.
        span: Span,
        /// The greatest number in one step.
        limit: u8,
    },
    /// An object is described by a longer chain of relations than a description has.
    TooManyRelations {
        /// Which step.
        step: u8,
        /// The description's place in the sentence.
        span: Span,
        /// The greatest number in one description.
        limit: u8,
    },
    /// A step that doesn't describe both the object and the reference.
    IncompleteStep {
        /// Which step.
        step: u8,
        /// How many objects it describes; two are needed.
        references: u8,
        /// Its place in the sentence.
        span: Span,
    },
    /// The same words were taken for both arguments.
    SameReference {
        /// Which step.
        step: u8,
        /// The words' place in the sentence.
        span: Span,
    },
    /// Several objects, "all red blocks", are described where a single one is needed: only what is moved
    /// may be several, and not what is the nearest or the farthest.
    SeveralReferences {
        /// Which step.
        step: u8,
        /// The description's place in the sentence.
        span: Span,
    },
    /// The table is moved, described, or something is put beside it: it is only what objects are put on,
    /// or stand on.
    OnlyOnTable {
        /// Which step.
        step: u8,
        /// The description's place in the sentence.
        span: Span,
    },
    /// A pronoun may be read in several ways, or what it stands for is several objects, or described by
    /// where it was before it was moved.
    UnclearPronoun {
        /// Which step.
        step: u8,
        /// Its place in the sentence.
        span: Span,
    },
    /// The words of a step are known, but not in this order or combination.
    UnclearWords {
        /// Which step.
        step: u8,
        /// The least acceptable word's place in the sentence.
        span: Span,
        /// Probability that all words of the step are acceptable.
        probability: f32,
        /// The required probability.
        threshold: f32,
    },
    /// The parser is not sure enough.
    Unsure {
        /// Which step.
        step: u8,
        /// The uncertain decision.
        decision: Decision,
        /// Its probability.
        probability: f32,
        /// The required probability.
        threshold: f32,
    },
    /// No object fits a description.
    NoSuchObject {
        /// Which step.
        step: u8,
        /// Which argument.
        argument: Argument,
        /// The description: the argument's, or that of an object that it is related to.
        description: Description,
        /// The object that fits best, if there is any.
        best: Option<Candidate>,
        /// The required score.
        threshold: f32,
    },
    /// Several objects fit a description; or one does that is seen in part only, so that it may not, and
    /// the description compares objects. Of a description of several objects, it is not clear whether these
    /// are among them.
    Ambiguous {
        /// Which step.
        step: u8,
        /// Which argument.
        argument: Argument,
        /// The description: the argument's, or that of an object that it is related to.
        description: Description,
        /// The objects that fit.
        candidates: Candidates,
    },
    /// Another number of objects fits a description than it says.
    OtherNumber {
        /// Which step.
        step: u8,
        /// The description of the objects to move.
        description: Description,
        /// How many it says.
        expected: u8,
        /// How many it fits.
        got: u8,
    },
    /// Both descriptions fit the same object, and no other.
    SameObject {
        /// Which step.
        step: u8,
        /// Id of the object.
        object: u32,
    },
    /// What is to be put on the table stands there already.
    AlreadyOnTable {
        /// Which step.
        step: u8,
        /// Id of the object.
        object: u32,
    },
    /// No place beside the objects on the table is free, in sight, and inside the work space.
    NoRoomOnTable {
        /// Which step.
        step: u8,
        /// Id of the object to move.
        object: u32,
    },
    /// A distance is named from an object, or another one is put between it and a third, of which too little is seen: where
    /// it is, is not certain enough. It may be the object that is moved.
    HiddenReference {
        /// Which step.
        step: u8,
        /// Id of that object.
        object: u32,
    },
    /// An object is to be moved by a distance from where it is, or another one is to be put between it and a third, but it
    /// does not stand on the table.
    NotOnTable {
        /// Which step.
        step: u8,
        /// Id of the object to move.
        object: u32,
    },
    /// A network's result is infinite or NaN.
    NotFinite {
        /// Which step.
        step: u8,
        /// Which result.
        quantity: Quantity,
    },
    /// An object to move, or its reference, is outside what the training's camera would see, or the
    /// scene's camera sees it from lower: the model has learned nothing about such places and views.
    OutsideTrainingView {
        /// Which step.
        step: u8,
        /// Which argument.
        argument: Argument,
        /// Id of the object.
        object: u32,
    },
    /// A sub-goal is outside the work space.
    OutsideWorkSpace {
        /// Which step.
        step: u8,
        /// Id of the object to move.
        object: u32,
        /// Where its centre would be: world frame, metres.
        position: [f32; 3],
        /// The work space.
        bounds: WorkSpace,
    },
    /// The scene's embeddings were computed by another model than the planner's.
    OtherModel {
        /// Tag of the planner's model.
        expected: u64,
        /// Tag in the scene.
        got: u64,
    },
    /// The sentence was parsed with another model than the planner's.
    ParsedByOtherModel {
        /// Tag of the planner's model.
        expected: u64,
        /// Tag of the model that parsed it.
        got: u64,
    },
    /// The plan as a whole is not confident enough.
    LowConfidence {
        /// Its [`crate::Plan::confidence`].
        confidence: f32,
        /// The required confidence.
        threshold: f32,
    },
    /// The scene disagrees with the camera's calibration: sub-goals would be wrong.
    Calibration(CalibrationFault),
    /// The model has an invalid index, or lacks the objects' sizes; impossible if
    /// [`crate::Model::check`] has passed.
    InvalidModel,
}

/// The unit of a sentence's length.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum LengthUnit {
    /// Bytes of UTF-8.
    Bytes,
    /// Words and commas; a group of concept words counts as one.
    Tokens,
    /// The same, of one step.
    StepTokens,
}

/// A decision of the parser.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Decision {
    /// Where the step ends.
    Split,
    /// The action.
    Action,
    /// What a group of concept words is related to, and how.
    Relation,
    /// Which words describe this argument.
    Argument(Argument),
}

/// A result that is checked to be finite.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Quantity {
    /// The splitter's hazard.
    Split,
    /// The action decoder's logits.
    Action,
    /// The relation decoder's logits.
    Relation,
    /// An argument decoder's logits.
    Argument(Argument),
    /// The acceptability of the words.
    Words,
    /// The scores of the objects for this argument.
    Score(Argument),
    /// The location that the action simulator predicts.
    Location,
    /// The sub-goal's pose.
    Pose,
}

impl LengthUnit {
    /// The name in snake case, as in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Bytes => "bytes",
            Self::Tokens => "tokens",
            Self::StepTokens => "step_tokens",
        }
    }
}

impl Decision {
    /// The name in snake case, as in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Split => "split",
            Self::Action => "action",
            Self::Relation => "relation",
            Self::Argument(argument) => argument.name(),
        }
    }
}

impl Quantity {
    /// The name in snake case, as in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Split => "split",
            Self::Action => "action",
            Self::Relation => "relation",
            Self::Argument(argument) => argument.name(),
            Self::Words => "words",
            Self::Score(Argument::Object) => "object_score",
            Self::Score(Argument::Reference) => "reference_score",
            Self::Location => "location",
            Self::Pose => "pose",
        }
    }
}

/// An object that fits a description, with its score.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct Candidate {
    /// Id of the object.
    pub object: u32,
    /// Its score, a cosine.
    pub score: f32,
}

/// Objects that fit a description: the best [`MAX_CANDIDATES`], best first.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Candidates {
    listed: [Candidate; MAX_CANDIDATES],
    count: u8,
}

impl Candidates {
    /// Adds an object; of equal scores the first stays in front.
    pub(crate) fn add(&mut self, candidate: Candidate) {
        let listed = usize::from(self.count).min(MAX_CANDIDATES);
        let mut carried = candidate;
        let mut found = false;
        // Each place behind the candidate's takes what stood in front of it.
        for place in self.listed.iter_mut().take(listed) {
            found |= candidate.score > place.score;
            if found {
                core::mem::swap(place, &mut carried);
            }
        }
        if let Some(place) = self.listed.get_mut(listed) {
            *place = carried;
        }
        self.count = self.count.saturating_add(1);
    }

    /// The listed candidates, best first.
    pub fn listed(&self) -> &[Candidate] {
        let listed = usize::from(self.count).min(MAX_CANDIDATES);
        self.listed.get(..listed).unwrap_or_default()
    }

    /// How many objects fit, listed or not.
    pub const fn count(&self) -> usize {
        self.count as usize
    }
}

/// Gives each variant its name, and all names their list.
macro_rules! kinds {
    ($($variant:pat => $kind:literal,)*) => {
        impl Refusal {
            /// All values of [`Refusal::kind`]; later versions append theirs.
            pub const KINDS: &[&str] = &[$($kind),*];

            /// The variant's name in snake case, as in JSON.
            pub const fn kind(&self) -> &'static str {
                match self {
                    $($variant => $kind,)*
                }
            }
        }
    };
}

kinds! {
    Self::NoWords => "no_words",
    Self::UnknownWord { .. } => "unknown_word",
    Self::SentenceTooLong { .. } => "sentence_too_long",
    Self::TooManyConcepts { .. } => "too_many_concepts",
    Self::ConflictingValues { .. } => "conflicting_values",
    Self::TooManySteps { .. } => "too_many_steps",
    Self::TooManyReferences { .. } => "too_many_references",
    Self::IncompleteStep { .. } => "incomplete_step",
    Self::SameReference { .. } => "same_reference",
    Self::Unsure { .. } => "unsure",
    Self::NoSuchObject { .. } => "no_such_object",
    Self::Ambiguous { .. } => "ambiguous",
    Self::SameObject { .. } => "same_object",
    Self::NotFinite { .. } => "not_finite",
    Self::OutsideWorkSpace { .. } => "outside_work_space",
    Self::OtherModel { .. } => "other_model",
    Self::Calibration(_) => "calibration",
    Self::ParsedByOtherModel { .. } => "parsed_by_other_model",
    Self::InvalidModel => "invalid_model",
    Self::LowConfidence { .. } => "low_confidence",
    Self::UnclearWords { .. } => "unclear_words",
    Self::TooManyRelations { .. } => "too_many_relations",
    Self::OutsideTrainingView { .. } => "outside_training_view",
    Self::UnclearPronoun { .. } => "unclear_pronoun",
    Self::SeveralReferences { .. } => "several_references",
    Self::OtherNumber { .. } => "other_number",
    Self::OnlyOnTable { .. } => "only_on_table",
    Self::AlreadyOnTable { .. } => "already_on_table",
    Self::NoRoomOnTable { .. } => "no_room_on_table",
    Self::HiddenReference { .. } => "hidden_reference",
    Self::NotOnTable { .. } => "not_on_table",
}

impl core::error::Error for Refusal {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn candidates_are_listed_best_first_and_all_counted() {
        let mut candidates = Candidates::default();
        for (object, score) in (1..).zip([0.5, 0.9, 0.7, 0.9, 0.6, 0.8, 0.4, 0.3, 0.95, 0.2]) {
            candidates.add(Candidate { object, score });
        }
        let ids: std::vec::Vec<u32> = candidates.listed().iter().map(|c| c.object).collect();
        assert_eq!(ids, [9, 2, 4, 6, 3, 5, 1, 7]);
        assert_eq!(candidates.count(), 10);
    }
}
