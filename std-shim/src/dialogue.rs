//! What is asked back after a refusal, and how an answer completes the sentence.
//!
//! ```
//! use nsrm::AnyModel;
//! use nsrm::dialogue::Question;
//! use nsrm_core::Planner;
//!
//! let model = AnyModel::Pretrained.model();
//! let sentence = "put the reds block on the blue block";
//! let refusal = Planner::new(&model).parse(sentence).unwrap_err();
//! let question = Question::after(&model, None, &refusal, sentence).expect("a word is near");
//! assert_eq!(question.to_string(), "do you mean \"red\"?");
//! let completed = question.complete("yes").expect("an answer");
//! assert_eq!(completed, "put the red block on the blue block");
//! assert!(Planner::new(&model).parse(&completed).is_ok());
//! ```

use std::collections::BTreeSet;
use std::fmt;

use nsrm_core::dsl::{Argument, Description};
use nsrm_core::language::Span;
use nsrm_core::vision::similarity;
use nsrm_core::{Model, Planner, Refusal, Scene};

/// The most options of a question.
const MOST_OPTIONS: usize = 6;
/// Words of an answer that choose nothing: "the small one, please".
const FILLERS: [&str; 9] = [
    "a", "block", "i", "mean", "object", "one", "please", "that", "the",
];
/// Answers that choose the only option.
const YES: [&str; 5] = ["correct", "ok", "y", "yeah", "yes"];

/// A question that a refusal leads to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Question {
    asked: Asked,
    options: Vec<Choice>,
    sentence: String,
}

/// One of the possible answers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Choice {
    /// In words: `the small one`.
    pub answer: String,
    /// The sentence with it. The model understands it, and nothing in the scene is against it up to
    /// the place of the refusal.
    pub sentence: String,
}

/// What is asked.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Asked {
    /// Which of several objects; its description in the sentence.
    Which { described: String },
    /// Whether something else was meant.
    Instead,
    /// What is missing at the end of a step.
    Rest { step: String, end: usize },
}

impl Question {
    /// The question after a refusal; `None` if nothing but another sentence helps.
    ///
    /// * `scene`: where the sentence was planned; without it, only words are asked about
    pub fn after(
        model: &Model<'_>,
        scene: Option<&Scene>,
        refusal: &Refusal,
        sentence: &str,
    ) -> Option<Self> {
        let context = Context {
            model,
            scene,
            refusal,
            sentence,
        };
        let (asked, options) = context.ask()?;
        if options.is_empty() && !matches!(asked, Asked::Rest { .. }) {
            return None;
        }
        Some(Self {
            asked,
            options,
            sentence: sentence.to_owned(),
        })
    }

    /// The possible answers; none if the question is open.
    pub fn options(&self) -> &[Choice] {
        &self.options
    }

    /// The sentence that an answer leads to: the number of an option, from 1, words that only one of
    /// them has, or "yes" if there is only one; to an open question, the words that are missing.
    /// `None` if the answer is none of these: it may be a sentence of its own.
    pub fn complete(&self, answer: &str) -> Option<String> {
        let said = words(answer);
        if let Asked::Rest { end, .. } = &self.asked {
            let (before, behind) = self.sentence.split_at_checked(*end)?;
            let added = answer.trim().trim_end_matches(['.', '!']);
            return (!said.is_empty()).then(|| format!("{before} {added}{behind}"));
        }
        let mut each = said.iter();
        let only_word = each.next().filter(|_| each.next().is_none());
        if let (Some(word), [only]) = (only_word, &*self.options)
            && YES.contains(&word.as_str())
        {
            return Some(only.sentence.clone());
        }
        if let Some(number) = only_word.and_then(|word| word.parse::<usize>().ok()) {
            let option = self.options.get(number.checked_sub(1)?)?;
            return Some(option.sentence.clone());
        }
        let fits = |option: &&Choice| said.is_subset(&words(&option.answer));
        let mut fitting = self.options.iter().filter(fits);
        let option = fitting
            .next()
            .filter(|_| fitting.next().is_none() && !said.is_empty());
        option.map(|option| option.sentence.clone())
    }
}

impl fmt::Display for Question {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.asked {
            Asked::Which { described } => write!(f, "which \"{described}\" object: ")?,
            Asked::Instead => f.write_str("do you mean ")?,
            Asked::Rest { step, .. } => {
                return write!(f, "\"{step}\" names one object only: what is missing?");
            }
        }
        let last = self.options.len().saturating_sub(1);
        for (index, option) in self.options.iter().enumerate() {
            f.write_str(match index {
                0 => "",
                _ if index == last => " or ",
                _ => ", ",
            })?;
            f.write_str(&option.answer)?;
        }
        f.write_str("?")
    }
}

/// The words of an answer that choose something, in lower case.
fn words(answer: &str) -> BTreeSet<String> {
    let is_between = |c: char| c.is_whitespace() || matches!(c, '.' | ',' | '!' | '?' | '"');
    let lower = answer.to_lowercase();
    let words = lower.split(is_between);
    words
        .filter(|word| !word.is_empty() && !FILLERS.contains(word))
        .map(str::to_owned)
        .collect()
}

/// A refusal and what it is about.
struct Context<'a> {
    model: &'a Model<'a>,
    scene: Option<&'a Scene>,
    refusal: &'a Refusal,
    sentence: &'a str,
}

impl Context<'_> {
    fn ask(&self) -> Option<(Asked, Vec<Choice>)> {
        match *self.refusal {
            Refusal::UnknownWord { span } => {
                let word = self.refusal.suggestion(self.model, self.sentence)?;
                let option = self.option(format!("\"{word}\""), span, word);
                Some((Asked::Instead, option.into_iter().collect()))
            }
            Refusal::IncompleteStep {
                references: 1,
                span,
                ..
            } => {
                let (step, end) = (span.of(self.sentence)?.to_owned(), usize::from(span.end));
                Some((Asked::Rest { step, end }, Vec::new()))
            }
            Refusal::Ambiguous {
                step,
                argument,
                description,
                candidates,
            } => {
                let span = self.argument(step, argument)?;
                let fitting = candidates.listed().iter();
                let fitting: Vec<u32> = fitting.map(|candidate| candidate.object).collect();
                let described = span.of(self.sentence)?.to_owned();
                let options = self.described(span, |id, values| {
                    let adds = values
                        .iter()
                        .any(|value| !description.concepts().contains(value));
                    (fitting.contains(&id) && adds).then_some(0)
                });
                // What cannot be told apart by words is left to the person.
                (options.len() > 1).then_some((Asked::Which { described }, options))
            }
            Refusal::NoSuchObject {
                step,
                argument,
                description,
                ..
            } => {
                let span = self.argument(step, argument)?;
                let wanted = description.concepts();
                let options = self.described(span, |_, values| {
                    let common = values.iter().filter(|value| wanted.contains(value)).count();
                    // The most alike first; with nothing in common only if one value was asked for.
                    (common > 0 || wanted.len() == 1).then(|| wanted.len() - common)
                });
                Some((Asked::Instead, options))
            }
            _ => None,
        }
    }

    /// An option for each description of an object of the scene that names no other: full
    /// descriptions at a place of the sentence, in the order of `rank`; `None` leaves an object out.
    fn described(&self, span: Span, rank: impl Fn(u32, &[u8]) -> Option<usize>) -> Vec<Choice> {
        let Some(scene) = self.scene else {
            return Vec::new();
        };
        let mut ranked = BTreeSet::new();
        for object in scene.objects() {
            let values: Vec<u8> = (0..self.model.attributes.len())
                .filter_map(|attribute| self.value(attribute, &object.embedding))
                .collect();
            if let Some(rank) = rank(object.id, &values) {
                ranked.insert((rank, self.named(&values)));
            }
        }
        ranked
            .iter()
            .filter_map(|(_, named)| self.option(format!("the {named} one"), span, named))
            .take(MOST_OPTIONS)
            .collect()
    }

    /// The value of an attribute that an object shows most clearly, if it does.
    fn value(
        &self,
        attribute: usize,
        embedding: &[f32; nsrm_core::model::OBJECT_EMBEDDING],
    ) -> Option<u8> {
        let of_attribute = |index: &u8| {
            let concept = self.model.concepts.get(usize::from(*index));
            concept.is_some_and(|concept| usize::from(concept.attribute) == attribute)
        };
        (0..=u8::MAX)
            .take(self.model.concepts.len())
            .filter(of_attribute)
            .filter_map(|index| Some((similarity(self.model, embedding, index)?, index)))
            .filter(|(score, _)| *score >= self.model.header.thresholds.match_score)
            .max_by(|(one, _), (other, _)| one.total_cmp(other))
            .map(|(_, index)| index)
    }

    /// Words for values, those of the last attribute type first: "small red".
    fn named(&self, values: &[u8]) -> String {
        let mut description = Description::new();
        for &value in values.iter().rev() {
            // As many places as attribute types.
            let _ = description.push(value);
        }
        let words = description.concepts().iter().filter_map(|&value| {
            let concept = self.model.concepts.get(usize::from(value))?;
            let mut entries = self.model.lexicon.iter();
            let own = entries.find(|entry| entry.text == concept.name);
            let mut entries = self.model.lexicon.iter();
            own.or_else(|| entries.find(|entry| entry.concept == value))
        });
        let words: Vec<&str> = words.map(|entry| entry.text).collect();
        words.join(" ")
    }

    /// The option with other words at a place of the sentence, if it leads further.
    fn option(&self, answer: String, span: Span, words: &str) -> Option<Choice> {
        let (before, rest) = self.sentence.split_at_checked(usize::from(span.start))?;
        let behind = rest.get(usize::from(span.end).checked_sub(usize::from(span.start))?..)?;
        let sentence = format!("{before}{words}{behind}");
        let planner = Planner::new(self.model);
        let refused = match self.scene {
            Some(scene) => planner.plan(scene, &sentence).err(),
            None => planner.parse(&sentence).err(),
        };
        refused
            .is_none_or(|refused| place(&refused) > place(self.refusal))
            .then_some(Choice { answer, sentence })
    }

    /// The place of an argument's description in the sentence.
    fn argument(&self, step: u8, argument: Argument) -> Option<Span> {
        let parsed = Planner::new(self.model).parse(self.sentence).ok()?;
        let decisions = parsed.decisions().get(usize::from(step))?;
        match argument {
            Argument::Object => Some(decisions.object_span),
            Argument::Reference => Some(decisions.reference_span),
            _ => None,
        }
    }
}

/// How far planning has come: refusals that ask about words, then about objects, in their order;
/// `None`, before all of them, for other refusals.
fn place(refusal: &Refusal) -> Option<(u8, u16, u8)> {
    match refusal {
        Refusal::UnknownWord { span } => Some((0, span.start, 0)),
        Refusal::Ambiguous { step, argument, .. }
        | Refusal::NoSuchObject { step, argument, .. } => {
            let is_reference = *argument == Argument::Reference;
            Some((1, u16::from(*step), u8::from(is_reference)))
        }
        _ => None,
    }
}
