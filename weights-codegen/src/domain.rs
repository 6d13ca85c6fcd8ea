//! The domain in the model file, and its checks.

mod compounds;
mod distances;
mod ordinals;
mod rewriting;

use std::collections::{BTreeMap, BTreeSet};

use nsrm_core::dsl::{Extreme, Property, Quantifier};
use nsrm_core::language::word_hash;
use serde::Deserialize;

use crate::error::ModelError;

pub(crate) use compounds::Compound;
use compounds::Compounds;
pub(crate) use distances::Distances;
use ordinals::Ordinals;
pub(crate) use ordinals::Ranked;
use rewriting::{Apart, Exceptions, Perspectives, Repairs, Sequence, Simplification, Table};
pub(crate) use rewriting::{ArrangedStep, Arrangements, Lists, Rephrasing};

/// Keys of a relation of everyday wording that name rules.
const RULE_NAMES: [&str; 4] = ["rule", "state", "related", "undescribed"];

/// Greatest number of attribute types, of concepts and of actions: their
/// indices are `u8` in `nsrm_core`.
pub const MAX_NAMES: usize = 256;

/// Greatest number of words outside the lexicon: their index is a `u16`.
pub const MAX_WORDS: usize = 65_536;

/// The token for a group of concept words, row 0 of the vocabulary.
pub const GROUP_TOKEN: &str = "[[X]]";

/// The parts of the domain file for language, names and object sizes; what only the simulation
/// reads (colours, studs, placements) is left out.
#[derive(Debug, Clone, Deserialize)]
pub struct Domain {
    /// Its name.
    pub name: String,
    /// Attribute types (Table I).
    pub attribute: Vec<Attribute>,
    /// Actions (Table I).
    pub action: Vec<Action>,
    /// The wording of commands: lists of phrases and of patterns with `{placeholders}`; an empty
    /// string if a phrase is optional.
    pub grammar: BTreeMap<String, Vec<String>>,
    /// Everyday wording, if the model was taught it.
    pub everyday: Option<Everyday>,
    /// Words for which one of several objects is meant, "leftmost": by the name of the action in whose
    /// direction it lies farthest, where the first word is the extreme's name, `Largest` or `Smallest`.
    #[serde(default)]
    pub extremes: BTreeMap<String, Vec<String>>,
    /// Words that may stand for what the step before moved, "it", each with the word that is then read
    /// behind it: "one's" for "its", or an empty text.
    #[serde(default)]
    pub pronouns: BTreeMap<String, String>,
    /// Words that put an object somewhere and never only take it.
    #[serde(default)]
    pub placing: BTreeSet<String>,
    /// What a pronoun is a word like any other behind.
    #[serde(default)]
    pub conjunctions: BTreeSet<String>,
    /// What may be said of several objects.
    #[serde(default)]
    pub several: Several,
    /// What is read as other words.
    #[serde(default)]
    pub rephrasing: Rephrasing,
    /// What a refused sentence is read again without.
    #[serde(default)]
    pub simplification: Simplification,
    /// Whose left is meant.
    #[serde(default)]
    pub perspectives: Perspectives,
    /// How objects are left out of a description.
    #[serde(default)]
    pub exceptions: Exceptions,
    /// How objects are listed that are moved.
    #[serde(default)]
    pub lists: Lists,
    /// How something is taken back.
    #[serde(default)]
    pub repairs: Repairs,
    /// In which order steps are carried out that are said in another one.
    #[serde(default)]
    pub sequence: Sequence,
    /// How far from the reference an object is put.
    #[serde(default)]
    pub distances: Option<Distances>,
    /// What stands between values of one object.
    #[serde(default)]
    pub apart: Apart,
    /// How is counted from one side.
    #[serde(default)]
    pub ordinals: Ordinals,
    /// How towers and rows are said.
    #[serde(default)]
    pub arrangements: Arrangements,
    /// The table as a place.
    #[serde(default)]
    pub table: Option<Table>,
    /// Actions that are made of others.
    #[serde(default)]
    pub compounds: Compounds,
    /// What unknown words are read as.
    #[serde(default)]
    pub spelling: Spelling,
}

/// How several objects are said, "all of the red blocks"; without it, they cannot be said.
#[derive(Debug, Clone, Default, Deserialize)]
pub struct Several {
    /// Words for all objects that fit, before a plural.
    pub all: Vec<String>,
    /// Such words before a singular.
    #[serde(default)]
    pub every: Vec<String>,
    /// Words for both of two.
    pub both: Vec<String>,
    /// Words that may stand between these and the rest: "of", "the".
    pub between: Vec<String>,
    /// Words in the plural, each with its singular: "blocks", "them".
    pub plurals: BTreeMap<String, String>,
    /// Words for all objects, without a noun: "everything".
    #[serde(default)]
    pub alone: Vec<String>,
    /// Numbers that mean both behind an article: "two".
    #[serde(default)]
    pub numbers: Vec<String>,
}

/// How people say commands: rules whose alternatives contain words and `{rules}`.
#[derive(Debug, Clone, Deserialize)]
pub struct Everyday {
    /// By action: the name of its relations' rule under `rule`, that of the state that it brings
    /// about under `state`, and what the rules' placeholders stand for. Superlatives have no `rule`,
    /// and rules of their own for descriptions under `related` and `undescribed`.
    pub relations: BTreeMap<String, BTreeMap<String, String>>,
    /// The alternatives of each rule.
    pub rules: BTreeMap<String, Vec<String>>,
}

impl Everyday {
    /// All texts that contain words.
    fn texts(&self) -> impl Iterator<Item = &String> {
        let filled_in = self
            .relations
            .values()
            .flatten()
            .filter_map(|(name, text)| (!RULE_NAMES.contains(&name.as_str())).then_some(text));
        self.rules.values().flatten().chain(filled_in)
    }
}

/// An attribute type.
#[derive(Debug, Clone, Deserialize)]
pub struct Attribute {
    /// Its name.
    pub name: String,
    /// The part of a crop that its operator sees.
    pub view: View,
    /// Its values: the concepts.
    pub values: Vec<Value>,
}

/// The part of a crop that an attribute operator sees.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum View {
    /// Red, green and blue.
    Color,
    /// Brightness only.
    Brightness,
}

/// An attribute value.
#[derive(Debug, Clone, Deserialize)]
pub struct Value {
    /// Its name.
    pub name: String,
    /// The words that name it: the lexicon.
    pub words: Vec<String>,
    /// Edge lengths along x, y and z of objects with this value, metres: given for all values of
    /// one attribute type.
    pub edges_m: Option<[f32; 3]>,
}

/// An action.
#[derive(Debug, Clone, Deserialize)]
pub struct Action {
    /// Its name.
    pub name: String,
    /// Its phrases; the first is used in explanations.
    pub phrases: Vec<String>,
}

/// What unknown words are read as; without it, none is read as another.
#[derive(Debug, Clone, Default, Deserialize)]
pub struct Spelling {
    /// Words that dictation writes for known ones, each with that one.
    pub heard: BTreeMap<String, String>,
    /// Words that are near known ones and mean something else: they are never taken for misspelt.
    pub other_words: Vec<String>,
}

impl Spelling {
    /// The hashes of [`Spelling::other_words`].
    pub fn hashes(&self) -> BTreeSet<u16> {
        self.other_words
            .iter()
            .map(|word| word_hash(word))
            .collect()
    }
}

impl Domain {
    /// Every word of the grammar and of everyday wording outside the lexicon, sorted: the vocabulary
    /// without the group token.
    pub fn words(&self) -> BTreeSet<String> {
        let phrases = self.action.iter().map(|action| &action.phrases);
        self.grammar
            .values()
            .chain(phrases)
            .flatten()
            .chain(self.everyday.iter().flat_map(Everyday::texts))
            .flat_map(|text| words_of(text))
            .collect()
    }

    /// Each word of the lexicon with the index of its concept, in the order of
    /// the domain.
    pub fn lexicon(&self) -> impl Iterator<Item = (&str, usize)> + Clone {
        self.concepts().enumerate().flat_map(|(index, (_, value))| {
            value.words.iter().map(move |word| (word.as_str(), index))
        })
    }

    /// Each word for an extreme.
    fn extremes(&self) -> impl Iterator<Item = (&str, Extreme)> + Clone {
        self.extremes.iter().flat_map(|(name, words)| {
            let extreme = self.extreme(name);
            words
                .iter()
                .filter_map(move |word| Some((word.as_str(), extreme?)))
        })
    }

    /// The extreme with this name, if the domain has it.
    fn extreme(&self, name: &str) -> Option<Extreme> {
        match name {
            "Largest" => Some(Extreme::Largest),
            "Smallest" => Some(Extreme::Smallest),
            _ => {
                let index = self.action_index(name)?;
                u8::try_from(index).ok().map(Extreme::Action)
            }
        }
    }

    /// Each word that says which of several objects is meant, that several are, or that it is the table.
    pub(crate) fn choices(&self) -> impl Iterator<Item = (&str, Property)> + Clone {
        let Several {
            all,
            every,
            both,
            alone,
            numbers,
            ..
        } = &self.several;
        let quantifiers = [
            (Quantifier::All, all),
            (Quantifier::All, every),
            (Quantifier::All, alone),
            (Quantifier::Both, both),
            (Quantifier::Both, numbers),
        ];
        let quantifiers = quantifiers.into_iter().flat_map(|(quantifier, words)| {
            let property = Property::Quantifier(quantifier);
            words.iter().map(move |word| (word.as_str(), property))
        });
        let extremes = self.extremes();
        let extremes = extremes.map(|(word, extreme)| (word, Property::Extreme(extreme)));
        let table = self.table.iter().flat_map(|table| &table.words);
        let table = table.map(|word| (word.as_str(), Property::Table));
        extremes.chain(quantifiers).chain(table)
    }

    /// The words that stand together for a group token: of concepts, of extremes, for several, and for
    /// the table.
    fn group_words(&self) -> impl Iterator<Item = &str> + Clone {
        let concepts = self.lexicon().map(|(word, _)| word);
        concepts.chain(self.choices().map(|(word, _)| word))
    }

    /// Each concept with the index of its attribute type, in the order of the
    /// domain.
    pub fn concepts(&self) -> impl Iterator<Item = (usize, &Value)> + Clone {
        self.attribute
            .iter()
            .enumerate()
            .flat_map(|(index, attribute)| attribute.values.iter().map(move |value| (index, value)))
    }

    /// Checks what core relies on: no empty lists, no duplicates, indices that fit, words that can
    /// occur in a sentence.
    pub(crate) fn check(&self) -> Result<(), ModelError> {
        not_empty("the list of attribute types", self.attribute.len())?;
        not_empty("the list of actions", self.action.len())?;
        for attribute in &self.attribute {
            let what = format!("the list of values of {:?}", attribute.name);
            not_empty(&what, attribute.values.len())?;
            for value in &attribute.values {
                let what = format!("the list of words of {:?}", value.name);
                not_empty(&what, value.words.len())?;
            }
        }
        for action in &self.action {
            let what = format!("the list of phrases of {:?}", action.name);
            not_empty(&what, action.phrases.len())?;
        }
        at_most("attribute types", MAX_NAMES, self.attribute.len())?;
        at_most("concepts", MAX_NAMES, self.concepts().count())?;
        at_most("actions", MAX_NAMES, self.action.len())?;
        let made = self.compounds.made.len();
        let actions = self.action.len().saturating_add(made);
        at_most("actions with compounds", MAX_NAMES, actions)?;
        unique("attribute type", self.attribute.iter().map(|a| &*a.name))?;
        unique("concept", self.concepts().map(|(_, value)| &*value.name))?;
        let actions = self.action.iter().map(|action| &*action.name);
        let made = self.compounds.made.iter().map(|compound| &*compound.name);
        unique("action", actions.chain(made))?;
        for (name, words) in &self.extremes {
            not_empty(&format!("the list of words of {name:?}"), words.len())?;
            if self.extreme(name).is_none() {
                return Err(ModelError::Extreme { name: name.clone() });
            }
        }
        self.check_edges()?;
        let words = self.words();
        not_empty("the list of words", words.len())?;
        at_most("words", MAX_WORDS, words.len())?;
        let lexicon = self.group_words();
        unique("word", lexicon.clone())?;
        // A quantifier may be another word, too: "all right".
        let Several {
            all, both, every, ..
        } = &self.several;
        let quantifiers = || all.iter().chain(every).chain(both);
        let others = words
            .iter()
            .filter(|word| !quantifiers().any(|other| other == *word));
        unique("word", others.map(String::as_str).chain(lexicon.clone()))?;
        match words
            .iter()
            .map(String::as_str)
            .chain(lexicon)
            .find(|word| !readable(word))
        {
            Some(word) => Err(ModelError::UnreadableWord { word: word.into() }),
            None => {
                self.check_pronouns()?;
                self.check_several()?;
                self.check_rephrasing()?;
                self.check_repairs()?;
                self.opposites()?;
                self.check_sequence()?;
                self.check_distances()?;
                self.check_ordinals()?;
                self.check_arrangements()?;
                self.check_table()?;
                self.check_compounds()?;
                self.check_spelling()
            }
        }
    }

    /// Checks that pronouns, what is read behind them, and what puts an object somewhere are words, and conjunctions can
    /// be read.
    fn check_pronouns(&self) -> Result<(), ModelError> {
        let mut conjunctions = self.conjunctions.iter().flat_map(|text| text.split(' '));
        if let Some(word) = conjunctions.find(|word| !readable(word)) {
            return Err(ModelError::UnreadableWord { word: word.into() });
        }
        let words = self.words();
        let owners = self.pronouns.values().filter(|owner| !owner.is_empty());
        match self
            .pronouns
            .keys()
            .chain(owners)
            .chain(&self.placing)
            .find(|word| !words.contains(*word))
        {
            Some(word) => Err(ModelError::Pronoun { word: word.clone() }),
            None => Ok(()),
        }
    }

    /// Checks that what stands behind a quantifier are words, and plurals of words.
    fn check_several(&self) -> Result<(), ModelError> {
        let words = self.words();
        let Several {
            between, plurals, ..
        } = &self.several;
        let known = between.iter().chain(plurals.values());
        if let Some(word) = known.into_iter().find(|word| !words.contains(*word)) {
            return Err(ModelError::Several { word: word.clone() });
        }
        let mut lexicon = self.group_words();
        if let Some(word) = lexicon.find(|word| plurals.contains_key(*word)) {
            return Err(ModelError::Duplicate {
                what: "word",
                name: word.into(),
            });
        }
        match plurals.keys().find(|word| !readable(word)) {
            Some(word) => Err(ModelError::UnreadableWord { word: word.clone() }),
            None => Ok(()),
        }
    }

    /// Checks that words are heard as known ones, and that no known word is unknown, too.
    fn check_spelling(&self) -> Result<(), ModelError> {
        let words = self.words();
        let is_known =
            |text: &str| words.contains(text) || self.group_words().any(|word| word == text);
        let Spelling { heard, other_words } = &self.spelling;
        for (text, read_as) in heard {
            if !is_known(read_as) {
                let (text, read_as) = (text.clone(), read_as.clone());
                return Err(ModelError::HeardAs { text, read_as });
            }
        }
        let unknown = || heard.keys().chain(other_words);
        if let Some(word) = unknown().find(|word| is_known(word)) {
            return Err(ModelError::Duplicate {
                what: "word",
                name: word.clone(),
            });
        }
        match unknown().find(|word| !readable(word)) {
            Some(word) => Err(ModelError::UnreadableWord { word: word.clone() }),
            None => Ok(()),
        }
    }

    /// Checks that one attribute type gives the sizes of objects for all its values, and that edges
    /// have a length.
    fn check_edges(&self) -> Result<(), ModelError> {
        let sized = |attribute: &&Attribute| {
            let mut values = attribute.values.iter();
            values.any(|value| value.edges_m.is_some())
        };
        let types: Vec<_> = self.attribute.iter().filter(sized).collect();
        not_empty("the list of objects' edge lengths (edges_m)", types.len())?;
        at_most("attribute types with edges_m", 1, types.len())?;
        for value in types.iter().flat_map(|attribute| &attribute.values) {
            let has_length = |edge_m: &f32| edge_m.is_finite() && *edge_m > 0.0;
            if !value
                .edges_m
                .is_some_and(|edges| edges.iter().all(has_length))
            {
                return Err(ModelError::Edges {
                    concept: value.name.clone(),
                    got: value.edges_m,
                });
            }
        }
        Ok(())
    }

    /// Checks that a model file's vocabulary is the group token, then
    /// [`Self::words`] in their order.
    pub(crate) fn check_vocabulary(&self, vocabulary: &[String]) -> Result<(), ModelError> {
        let Some((group, words)) = vocabulary.split_first() else {
            return Err(ModelError::GroupToken { got: String::new() });
        };
        if group != GROUP_TOKEN {
            return Err(ModelError::GroupToken { got: group.clone() });
        }
        unique("word of the vocabulary", words.iter().map(String::as_str))?;
        let expected = self.words();
        let got: BTreeSet<String> = words.iter().cloned().collect();
        if expected != got {
            return Err(ModelError::Vocabulary {
                missing: expected.difference(&got).cloned().collect(),
                extra: got.difference(&expected).cloned().collect(),
            });
        }
        match words.windows(2).find(|pair| pair[0] > pair[1]) {
            Some(pair) => Err(ModelError::VocabularyOrder {
                first: pair[0].clone(),
                second: pair[1].clone(),
            }),
            None => Ok(()),
        }
    }
}

/// The tokens of a phrase or of a command's pattern; `{placeholders}` are not tokens, a comma is a
/// separate token.
fn words_of(text: &str) -> Vec<String> {
    text.replace(',', " , ")
        .split_whitespace()
        .filter(|token| !token.starts_with('{'))
        .map(str::to_owned)
        .collect()
}

/// Whether the tokeniser of core can produce this word: see
/// `nsrm_core::language`.
fn readable(word: &str) -> bool {
    const AT_WORD_ENDS: &[char] = &['.', '!', '?', ';', ':', '\'', ','];
    const NOWHERE: &[char] = &['"', '“', '”', '„', '’', ','];
    matches!(word, "," | "." | "!" | "?" | ":")
        || (!word.is_empty()
            && word.to_lowercase() == word
            && !word.chars().any(char::is_whitespace)
            && !word.contains(NOWHERE)
            && !word.starts_with(AT_WORD_ENDS)
            && !word.ends_with(AT_WORD_ENDS))
}

fn not_empty(what: &str, length: usize) -> Result<(), ModelError> {
    if length == 0 {
        return Err(ModelError::Empty { what: what.into() });
    }
    Ok(())
}

fn at_most(what: &'static str, limit: usize, got: usize) -> Result<(), ModelError> {
    if got > limit {
        return Err(ModelError::TooMany { what, limit, got });
    }
    Ok(())
}

fn unique<'a>(what: &'static str, names: impl Iterator<Item = &'a str>) -> Result<(), ModelError> {
    let mut seen = BTreeSet::new();
    for name in names {
        if !seen.insert(name) {
            return Err(ModelError::Duplicate {
                what,
                name: name.into(),
            });
        }
    }
    Ok(())
}
