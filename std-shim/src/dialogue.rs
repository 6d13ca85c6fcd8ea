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

mod answer;
mod by_place;
mod described;

use std::collections::BTreeMap;
use std::fmt;

use nsrm_core::dsl::{Argument, Description, Filters, Property};
use nsrm_core::language::Span;
use nsrm_core::model::OBJECT_EMBEDDING;
use nsrm_core::vision::similarity;
use nsrm_core::{MAX_RELATIONS, Model, Planner, Program, Refusal, Scene};

use answer::{chosen, words};
use described::Described;

/// The most options of a question.
const MOST_OPTIONS: usize = 6;
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
    /// In words: `the small red one`, `the red one to the left of the blue one`, `the leftmost red one`.
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
        chosen(said, &self.options).map(|option| option.sentence.clone())
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
                let option = self.option(format!("\"{word}\""), span, word, None);
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
                description,
                candidates,
                ..
            } => {
                let place = Described::find(self.model, self.refusal, self.sentence)?;
                let fitting = candidates.listed().iter();
                let fitting: Vec<u32> = fitting.map(|candidate| candidate.object).collect();
                let described = place.own.of(self.sentence)?.to_owned();
                let options = self.which(&place, &description, &fitting);
                // What cannot be told apart by words is left to the person.
                (options.len() > 1).then_some((Asked::Which { described }, options))
            }
            Refusal::NoSuchObject { description, .. } => {
                let place = Described::find(self.model, self.refusal, self.sentence)?;
                let wanted = description.concepts();
                let options = self.by_values(&place, |_, values| {
                    let common = values.iter().filter(|value| wanted.contains(value)).count();
                    // The most alike first; with nothing in common only if one value was asked for.
                    (common > 0 || wanted.len() == 1).then(|| wanted.len() - common)
                });
                let options = options.into_iter().map(|(_, option)| option);
                Some((Asked::Instead, options.take(MOST_OPTIONS).collect()))
            }
            _ => None,
        }
    }

    /// An option for each of several fitting objects that words tell apart: by its values, or else
    /// by where it stands.
    fn which(&self, place: &Described, refused: &Description, fitting: &[u32]) -> Vec<Choice> {
        let by_values = self.by_values(place, |id, values| {
            let known = refused.concepts();
            let adds = values.iter().any(|value| !known.contains(value));
            (fitting.contains(&id) && adds).then_some(0)
        });
        let (told, mut options): (Vec<u32>, Vec<Choice>) = by_values.into_iter().unzip();
        let others = fitting.iter().copied().filter(|id| !told.contains(id));
        let others: Vec<u32> = others.collect();
        options.extend(self.by_place(place, refused.filters(), &others));
        options.truncate(MOST_OPTIONS);
        options
    }

    /// An option for each object of the scene whose values name no other, with its id: full
    /// descriptions in place of the refused one and all that it is related to, in the order of
    /// `rank`; `None` leaves an object out.
    fn by_values(
        &self,
        place: &Described,
        rank: impl Fn(u32, &[u8]) -> Option<usize>,
    ) -> Vec<(u32, Choice)> {
        let mut ranked = BTreeMap::new();
        for object in self.scene.into_iter().flat_map(Scene::objects) {
            let shown = self.shown(&object.embedding);
            if let Some(rank) = rank(object.id, shown.concepts()) {
                ranked.insert((rank, self.named(&shown)), (object.id, shown));
            }
        }
        let options = ranked.iter().filter_map(|((_, named), (id, shown))| {
            let answer = format!("the {named} one");
            let option = self.option_by(answer, place, named, &Description::of(*shown))?;
            Some((*id, option))
        });
        options.collect()
    }

    /// The values that an object shows, as they are said: that of the last attribute first.
    fn shown(&self, embedding: &[f32; OBJECT_EMBEDDING]) -> Filters {
        let mut shown = Filters::new();
        for attribute in (0..self.model.attributes.len()).rev() {
            if let Some(value) = self.value(attribute, embedding) {
                // As many places as attribute types; too many are no option.
                let _ = shown.push(value);
            }
        }
        shown
    }

    /// The value of an attribute that an object shows most clearly, if it does.
    fn value(&self, attribute: usize, embedding: &[f32; OBJECT_EMBEDDING]) -> Option<u8> {
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

    /// Words for filters: "leftmost small red".
    fn named(&self, filters: &Filters) -> String {
        let values = filters.concepts().iter().copied().map(Property::Concept);
        let words = filters
            .choice()
            .into_iter()
            .chain(values)
            .filter_map(|property| {
                let name = property.name(self.model);
                let mut entries = self.model.lexicon.iter();
                let own = entries.find(|entry| entry.text == name);
                let mut entries = self.model.lexicon.iter();
                own.or_else(|| entries.find(|entry| entry.property == property))
            });
        let words: Vec<&str> = words.map(|entry| entry.text).collect();
        words.join(" ")
    }

    /// The option with another description, in these words, in place of the refused one.
    fn option_by(
        &self,
        answer: String,
        place: &Described,
        words: &str,
        description: &Description,
    ) -> Option<Choice> {
        let program = place.with(description)?;
        self.option(answer, place.whole, words, Some(&program))
    }

    /// The option with other words at a place of the sentence, if it means this program and leads
    /// further.
    fn option(
        &self,
        answer: String,
        span: Span,
        words: &str,
        program: Option<&Program>,
    ) -> Option<Choice> {
        let (before, rest) = self.sentence.split_at_checked(usize::from(span.start))?;
        let behind = rest.get(usize::from(span.end).checked_sub(usize::from(span.start))?..)?;
        let sentence = format!("{before}{words}{behind}");
        let planner = Planner::new(self.model);
        let parsed = planner.parse(&sentence);
        if let (Some(meant), Ok(parsed)) = (program, &parsed)
            && parsed.program() != meant
        {
            return None;
        }
        let refused = match self.scene {
            Some(scene) => planner.plan(scene, &sentence).err(),
            None => parsed.err(),
        };
        let before = place(self.model, self.refusal, self.sentence);
        refused
            .is_none_or(|refused| place(self.model, &refused, &sentence) > before)
            .then_some(Choice { answer, sentence })
    }
}

/// How far planning has come: refusals that ask about words, then about objects, in their order,
/// anchors before what is related to them; `None`, before all of them, for other refusals.
fn place(model: &Model<'_>, refusal: &Refusal, sentence: &str) -> Option<(u8, u16, u8, usize)> {
    if let Refusal::UnknownWord { span } = refusal {
        return Some((0, span.start, 0, 0));
    }
    let (step, argument, description) = described::refused(refusal)?;
    let parsed = Planner::new(model).parse(sentence).ok()?;
    let symbols = parsed.program().steps().get(usize::from(step))?;
    let level = described::level(symbols.description(argument), description)?;
    let is_reference = argument == Argument::Reference;
    let outwards = MAX_RELATIONS.checked_sub(level)?;
    Some((1, u16::from(step), u8::from(is_reference), outwards))
}
