use core::fmt;

use super::unknown_word::UnknownWord;
use crate::dsl::{Argument, Description, Property};
use crate::language::{Span, says_order};
use crate::model::Model;
use crate::refusal::{Candidate, Candidates, Decision, LengthUnit, Quantity, Refusal};

impl Refusal {
    /// The known word that may have been meant by an unknown one; see
    /// [`nearest_word`](crate::language::nearest_word). None may for a word that only towers and rows have, for one
    /// by which something is taken back or ruled out, and for a unit or a number of a distance: "not" doesn't mean
    /// "now".
    ///
    /// * `model`, `sentence`: those that were refused
    ///
    /// ```
    /// use nsrm_core::Planner;
    /// use nsrm_tabletop::TABLETOP;
    ///
    /// let sentence = "put the greens block on the red block";
    /// let refused = Planner::new(&TABLETOP).parse(sentence).unwrap_err();
    /// assert_eq!(refused.suggestion(&TABLETOP, sentence), Some("green"));
    /// ```
    pub fn suggestion<'a>(&self, model: &Model<'a>, sentence: &str) -> Option<&'a str> {
        match self {
            Self::UnknownWord { span } => {
                let word = span.of(sentence)?;
                match UnknownWord::of(model, word) {
                    UnknownWord::Like(known) => Some(known),
                    _ => None,
                }
            }
            _ => None,
        }
    }

    /// The refusal in full sentences: the words of the sentence and the names of
    /// the domain in place of spans and indices, and what may be done about it.
    ///
    /// * `model`, `sentence`: those that were refused
    ///
    /// ```
    /// use nsrm_core::Planner;
    /// use nsrm_tabletop::TABLETOP;
    ///
    /// let sentence = "put the greens block on the red block";
    /// let refused = Planner::new(&TABLETOP).parse(sentence).unwrap_err();
    /// assert_eq!(refused.kind(), "unknown_word");
    /// assert_eq!(
    ///     refused.in_context(&TABLETOP, sentence).to_string(),
    ///     "\"greens\" is not a word that the model knows; did you mean \"green\"?"
    /// );
    /// ```
    pub fn in_context<'a>(
        &'a self,
        model: &'a Model<'a>,
        sentence: &'a str,
    ) -> impl fmt::Display + 'a {
        Message {
            refusal: self,
            context: Some((model, sentence)),
        }
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        Message {
            refusal: self,
            context: None,
        }
        .fmt(f)
    }
}

impl fmt::Display for LengthUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Bytes => "bytes",
            Self::Tokens => "words",
            Self::StepTokens => "words of one step",
        })
    }
}

impl fmt::Display for Decision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Split => f.write_str("where the step ends"),
            Self::Action => f.write_str("what is to be done"),
            Self::Relation => f.write_str("how the described objects are related"),
            Self::Argument(argument) => write!(f, "which words name the {argument}"),
        }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Split => f.write_str("the splitter's hazard"),
            Self::Action => f.write_str("the action decoder's result"),
            Self::Relation => f.write_str("the relation decoder's result"),
            Self::Argument(argument) => write!(f, "the {argument} decoder's result"),
            Self::Words => f.write_str("the words' acceptability"),
            Self::Score(argument) => write!(f, "a score for the {argument}"),
            Self::Location => f.write_str("the predicted location"),
            Self::Pose => f.write_str("the sub-goal's pose"),
        }
    }
}

/// A refusal, with the model and the sentence where they are known.
struct Message<'a> {
    refusal: &'a Refusal,
    context: Option<(&'a Model<'a>, &'a str)>,
}

impl fmt::Display for Message<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.refusal {
            Refusal::NoWords
            | Refusal::UnknownWord { .. }
            | Refusal::SentenceTooLong { .. }
            | Refusal::TooManyConcepts { .. }
            | Refusal::ConflictingValues { .. }
            | Refusal::TooManySteps { .. } => self.sentence(f),
            Refusal::TooManyReferences { .. }
            | Refusal::TooManyRelations { .. }
            | Refusal::IncompleteStep { .. }
            | Refusal::SameReference { .. }
            | Refusal::SeveralReferences { .. }
            | Refusal::OnlyOnTable { .. }
            | Refusal::UnclearPronoun { .. }
            | Refusal::UnclearWords { .. }
            | Refusal::Unsure { .. } => self.step(f),
            Refusal::LowConfidence {
                confidence,
                threshold,
            } => write!(
                f,
                "not sure enough of the plan: confidence {confidence:.4}, needed {threshold:.4}; \
                 say it in other words"
            ),
            Refusal::NoSuchObject { .. }
            | Refusal::Ambiguous { .. }
            | Refusal::OtherNumber { .. }
            | Refusal::AlreadyOnTable { .. }
            | Refusal::NoRoomOnTable { .. }
            | Refusal::HiddenReference { .. }
            | Refusal::NotOnTable { .. }
            | Refusal::SameObject { .. }
            | Refusal::OutsideTrainingView { .. }
            | Refusal::OutsideWorkSpace { .. }
            | Refusal::Calibration(_) => self.scene(f),
            Refusal::NotFinite { .. }
            | Refusal::OtherModel { .. }
            | Refusal::ParsedByOtherModel { .. }
            | Refusal::InvalidModel => self.model(f),
        }
    }
}

/// The messages, by what is at fault. Each method writes those of its own kind alone.
impl Message<'_> {
    /// The words of the sentence, or how many there are.
    fn sentence(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.refusal {
            Refusal::NoWords => {
                f.write_str("the sentence has no words; say what to move, and where to")
            }
            Refusal::UnknownWord { span } => {
                let word = match self.context {
                    Some((model, sentence)) => {
                        UnknownWord::of(model, span.of(sentence).unwrap_or_default())
                    }
                    None => UnknownWord::Strange,
                };
                word.write(self.quoted(*span), f)
            }
            Refusal::SentenceTooLong { limit, unit } => write!(
                f,
                "the sentence is too long: at most {limit} {unit} are read; give it in parts"
            ),
            Refusal::TooManyConcepts { span, limit } => write!(
                f,
                "{} are too many words for one object: at most {limit} are read",
                self.quoted(*span)
            ),
            Refusal::ConflictingValues {
                span,
                first,
                second,
            } => {
                let quoted = self.quoted(*span);
                match self.context {
                    Some((model, _)) => write!(
                        f,
                        "{quoted} describes one object as both {} and {}; name one of them",
                        first.name(model),
                        second.name(model)
                    ),
                    None => write!(
                        f,
                        "{quoted} gives one object two values of the same attribute; name one"
                    ),
                }
            }
            Refusal::TooManySteps { limit } => write!(
                f,
                "the sentence takes more than {limit} steps, one for each object that is moved; give it \
                 in parts"
            ),
            other => f.write_str(other.kind()),
        }
    }

    /// What one step says, or how sure the parser is of it.
    fn step(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.refusal {
            Refusal::TooManyReferences { step, span, limit } => write!(
                f,
                "step {}, {}, describes more than {limit} objects; say one thing to move and one place, \
                 and describe each by attribute words that stand together",
                number(*step),
                self.quoted(*span)
            ),
            Refusal::TooManyRelations { step, span, limit } => write!(
                f,
                "step {}: {} describes one object by more than {limit} others; \
                 describe it by fewer",
                number(*step),
                self.quoted(*span)
            ),
            Refusal::IncompleteStep {
                step,
                references,
                span,
            } => write!(
                f,
                "step {}, {}, describes {references} of the two objects that it needs; \
                 say what to move, and on or beside what",
                number(*step),
                self.quoted(*span)
            ),
            Refusal::SameReference { step, span } => write!(
                f,
                "step {}: {} was understood as both what to move and where to; \
                 say it in other words",
                number(*step),
                self.quoted(*span)
            ),
            Refusal::SeveralReferences { step, span } => write!(
                f,
                "step {}: {} describes several objects where a single one is needed; say which one",
                number(*step),
                self.quoted(*span)
            ),
            Refusal::OnlyOnTable { step, span } => write!(
                f,
                "step {}: {} can only be what objects are put on, or stand on; describe an object instead",
                number(*step),
                self.quoted(*span)
            ),
            Refusal::UnclearPronoun { step, span } => write!(
                f,
                "step {}: it is not clear which object {} means; describe the object instead",
                number(*step),
                self.quoted(*span)
            ),
            Refusal::UnclearWords {
                step,
                span,
                probability,
                threshold,
            } => {
                let says_order = self.context.is_some_and(|(model, sentence)| {
                    says_order(model, span.of(sentence).unwrap_or_default())
                });
                if says_order {
                    return write!(
                        f,
                        "{} leaves open in which order the steps are carried out; say them in that \
                         order",
                        self.quoted(*span)
                    );
                }
                write!(
                    f,
                    "step {} is not clear at {}: probability {probability:.2}, needed {threshold:.2}; \
                 say it in other words",
                    number(*step),
                    self.quoted(*span)
                )
            }
            Refusal::Unsure {
                step,
                decision,
                probability,
                threshold,
            } => write!(
                f,
                "step {}: not sure {decision}: probability {probability:.2}, \
                 needed {threshold:.2}; say it in other words",
                number(*step)
            ),
            other => f.write_str(other.kind()),
        }
    }

    /// The objects of the scene, and where they would be moved.
    fn scene(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.refusal {
            Refusal::NoSuchObject {
                step,
                argument,
                description,
                best,
                threshold,
            } => {
                self.description(*step, *argument, description, f)?;
                f.write_str(" fits no object in the scene")?;
                match best {
                    Some(Candidate { object, score }) => write!(
                        f,
                        ": the best is object {object} with a score of {score:.2}, \
                         needed {threshold:.2}"
                    ),
                    None => f.write_str(": it is empty"),
                }
            }
            Refusal::Ambiguous {
                step,
                argument,
                description,
                candidates,
            } => {
                self.description(*step, *argument, description, f)?;
                if description.filters().quantifier().is_some() {
                    f.write_str(" may or may not include object")?;
                    for (index, Candidate { object, .. }) in candidates.listed().iter().enumerate()
                    {
                        let separator = if index > 0 { "," } else { "" };
                        write!(f, "{separator} {object}")?;
                    }
                    return f.write_str(
                        ": others hide a part of it, or it is not clearly where the sentence says; uncover \
                         it, or describe the objects in another way",
                    );
                }
                match candidates.listed() {
                    [only]
                        if matches!(description.filters().choice(), Some(Property::Ranked(_))) =>
                    {
                        write!(
                            f,
                            " may be object {}, but others hide a part of what may count before it; uncover \
                             that, or describe the object in another way",
                            only.object
                        )
                    }
                    [only] => write!(
                        f,
                        " fits object {} only, of which others hide a part; uncover it, or describe \
                         another one",
                        only.object
                    ),
                    _ => write!(f, " fits {}; describe it more closely", Fitting(candidates)),
                }
            }
            Refusal::OtherNumber {
                step,
                description,
                expected,
                got,
            } => {
                self.description(*step, Argument::Object, description, f)?;
                write!(
                    f,
                    " means {expected} objects, but fits {got}; describe them more closely"
                )
            }
            Refusal::SameObject { step, object } => write!(
                f,
                "step {}: both descriptions fit object {object}, which cannot be moved \
                 in relation to itself",
                number(*step)
            ),
            Refusal::AlreadyOnTable { step, object } => write!(
                f,
                "step {}: object {object} stands on the table already; describe another one",
                number(*step)
            ),
            Refusal::NoRoomOnTable { step, object } => write!(
                f,
                "step {}: no free place on the table is in sight for object {object}; say on which side of \
                 which object to put it",
                number(*step)
            ),
            Refusal::HiddenReference { step, object } => write!(
                f,
                "step {}: other objects hide too much of object {object} to tell exactly where it is; take away \
                 what hides it, or name neither a distance nor two objects",
                number(*step)
            ),
            Refusal::NotOnTable { step, object } => write!(
                f,
                "step {}: object {object} does not stand on the table, from where objects are moved by a distance, and \
                 where others are put between two; say beside or on which object to put it",
                number(*step)
            ),
            Refusal::OutsideTrainingView {
                step,
                argument,
                object,
            } => write!(
                f,
                "step {}: the {}, object {object}, is farther out, or seen by a lower camera, than \
                 in training; move it towards the middle of the table, or raise the camera",
                number(*step),
                argument.name()
            ),
            Refusal::OutsideWorkSpace {
                step,
                object,
                position: [x, y, z],
                bounds,
            } => {
                let ([x1, y1, z1], [x2, y2, z2]) = (bounds.min, bounds.max);
                write!(
                    f,
                    "step {}: object {object} would be moved to ({x:.3}, {y:.3}, {z:.3}) m, \
                     outside the work space: x {x1} to {x2}, y {y1} to {y2}, z {z1} to {z2} m",
                    number(*step)
                )
            }
            Refusal::Calibration(fault) => fmt::Display::fmt(fault, f),
            other => f.write_str(other.kind()),
        }
    }

    /// The model, or whose scene and program these are.
    fn model(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.refusal {
            Refusal::NotFinite { step, quantity } => write!(
                f,
                "step {}: {quantity} is not a finite number; the model does not fit this input",
                number(*step)
            ),
            Refusal::OtherModel { expected, got } => write!(
                f,
                "the scene was made with model {got:016x}, but the planner's is \
                 {expected:016x}; observe it again with this model"
            ),
            Refusal::ParsedByOtherModel { expected, got } => write!(
                f,
                "the sentence was parsed with model {got:016x}, but the planner's is \
                 {expected:016x}; parse it again with this model"
            ),
            Refusal::InvalidModel => {
                f.write_str("the model is damaged; check it and load it again")
            }
            other => f.write_str(other.kind()),
        }
    }

    fn quoted(&self, span: Span) -> Quoted<'_> {
        Quoted {
            span,
            sentence: self.context.map(|(_, sentence)| sentence),
        }
    }

    /// Which description of which step; its words where the model is known.
    fn description(
        &self,
        step: u8,
        argument: Argument,
        description: &Description,
        f: &mut fmt::Formatter<'_>,
    ) -> fmt::Result {
        write!(f, "step {}: ", number(step))?;
        match self.context {
            Some((model, _)) => write!(f, "the {argument} \"{}\"", description.words(model)),
            None => write!(f, "the {argument}'s description"),
        }
    }
}

/// How many objects fit a description, and which.
struct Fitting<'a>(&'a Candidates);

impl fmt::Display for Fitting<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let listed = self.0.listed();
        write!(f, "{} objects: ", self.0.count())?;
        for (index, Candidate { object, score }) in listed.iter().enumerate() {
            let separator = if index > 0 { ", " } else { "" };
            write!(f, "{separator}{object} (score {score:.2})")?;
        }
        if self.0.count() > listed.len() {
            f.write_str(" and others")?;
        }
        Ok(())
    }
}

/// Steps are counted from 1 for a person.
const fn number(step: u8) -> usize {
    step as usize + 1
}

/// A part of the sentence in quotation marks, or where it stands.
struct Quoted<'a> {
    span: Span,
    sentence: Option<&'a str>,
}

impl fmt::Display for Quoted<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.sentence.and_then(|sentence| self.span.of(sentence)) {
            Some(words) => write!(f, "\"{words}\""),
            None => write!(f, "bytes {} to {}", self.span.start, self.span.end),
        }
    }
}
