mod rewriting;

use thiserror::Error;

use super::{COMPOSED, MAX_SIDES, Model, WorkSpace};
use crate::camera::CameraError;
use crate::dsl::{Extreme, Property, Quantifier};
use crate::nn::is_unit;

/// The number of concepts, attribute types or actions that a one-byte index can address.
const MAX_INDEXED: usize = 256;
/// The number of words that a two-byte index can address.
const MAX_WORDS: usize = 65_536;

/// Why a model cannot be used; the first fault found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ModelFault<'a> {
    /// A list is empty; its name.
    #[error("the model has no {0}")]
    Empty(&'static str),
    /// A list is longer than its index can address; its name.
    #[error("the model has too many {0}")]
    TooLong(&'static str),
    /// Words are not sorted and unique; the word out of order.
    #[error("word \"{0}\" is out of order or repeated")]
    WordOrder(&'a str),
    /// The embeddings are not those of the group and of each word; their number.
    #[error("the model has {0} embeddings; expected one for the group and one for each word")]
    Embeddings(usize),
    /// Lexicon words are not sorted and unique; the word out of order.
    #[error("lexicon word \"{0}\" is out of order or repeated")]
    LexiconOrder(&'a str),
    /// A word is both among the words and in the lexicon, and no quantifier.
    #[error("word \"{0}\" stands in the lexicon too")]
    WordInLexicon(&'a str),
    /// A lexicon word has an invalid index, that of an action without a word for its extreme, or the
    /// quantifier that no word says.
    #[error("lexicon word \"{0}\" names a concept, an extreme or a quantifier that isn't there")]
    LexiconProperty(&'a str),
    /// Pronouns are not sorted and unique, or one is no word; its index.
    #[error("pronoun {0} is out of order, repeated or no word")]
    Pronoun(u16),
    /// Words that put an object somewhere are not sorted and unique, or one is no word; its index.
    #[error("word {0}, which puts an object somewhere, is out of order, repeated or no word")]
    Placing(u16),
    /// What stands before no pronoun is empty, or not sorted and unique; the text.
    #[error("\"{0}\", behind which there is no pronoun, is empty, out of order or repeated")]
    Conjunction(&'a str),
    /// A word between a quantifier and the rest is none of the model's; its index.
    #[error("word {0}, which stands behind quantifiers, isn't there")]
    Between(u16),
    /// Plurals are not sorted and unique, in the lexicon, or of no word; the plural.
    #[error("plural \"{0}\" is out of order, repeated, in the lexicon or of no word")]
    Plural(&'a str),
    /// What opens an arrangement has no words, or is not sorted; the opening.
    #[error("opening \"{0}\" of an arrangement is out of order or empty")]
    Opening(&'a str),
    /// Words between the objects of a list, or before which it ends, are not sorted and unique; the
    /// word out of order.
    #[error("word \"{0}\" between or behind the objects of a list is out of order or repeated")]
    ListWord(&'a str),
    /// A closing names no arrangement; the closing.
    #[error("closing \"{0}\" names an arrangement that isn't there")]
    Closing(&'a str),
    /// A word that an arrangement is read as is none of the model's; the word.
    #[error("word \"{0}\", as which an arrangement is read, isn't there")]
    ArrangementWord(&'a str),
    /// The table names an action that isn't there, or too many.
    #[error("the table names an action that isn't there, or more than {MAX_SIDES} sides")]
    TableAction,
    /// By its height, the highest object on the table may stand on the lowest one.
    #[error("the highest object on the table is as high as one that stands on the lowest")]
    TableHeight,
    /// What means the table is not sorted and unique; the text out of order.
    #[error("\"{0}\", which means the table, is out of order or repeated")]
    TableText(&'a str),
    /// A word that is read of the table is none of the model's; the word.
    #[error("word \"{0}\", which is read of the table, isn't there")]
    TableWord(&'a str),
    /// A phrase that is read as another one, or a first word of one, is empty, or not sorted and unique, or the first word
    /// isn't listed; the text.
    #[error(
        "\"{0}\", which is read as other words, is empty, out of order, repeated, or its first word is not listed"
    )]
    Rephrased(&'a str),
    /// A word that is read in its place is none of the model's; the word.
    #[error("word \"{0}\", which is read in place of other words, isn't there")]
    RephrasedWord(&'a str),
    /// What only connects two steps is read in other words, or words that start one are empty, or not sorted and unique;
    /// the text.
    #[error(
        "\"{0}\", which connects a step to the one before it or starts one, is read in words, empty, out of order or repeated"
    )]
    Connecting(&'a str),
    /// What says whose left is meant, or a first word of this, is empty, or not sorted and unique, or the first word isn't
    /// listed; the text.
    #[error(
        "\"{0}\", which says from where something is seen, is empty, out of order, repeated, or its first word is not listed"
    )]
    PerspectiveText(&'a str),
    /// Actions have opposites that are not theirs in turn, or other numbers of them.
    #[error("the actions' opposites are not one for each action, in pairs")]
    Opposites,
    /// What stands in a list of objects, or in their place, is empty, or not sorted and unique; the text.
    #[error("\"{0}\", which is said of listed objects, is empty, out of order or repeated")]
    ListedText(&'a str),
    /// A word that is read between the steps of listed objects is none of the model's; the word.
    #[error("word \"{0}\", which is read between the steps of listed objects, isn't there")]
    ListedWord(&'a str),
    /// A word that takes an object, or that says where one is then put, is empty, or not sorted and unique; the text.
    #[error("\"{0}\", by which an object is taken, is empty, out of order or repeated")]
    TakingText(&'a str),
    /// What says that an object stands somewhere is empty, or not sorted and unique; the text.
    #[error(
        "\"{0}\", which says that an object stands somewhere, is empty, out of order or repeated"
    )]
    StandingText(&'a str),
    /// What stands before or behind something that is taken back is empty, or not sorted and unique; the text.
    #[error("\"{0}\", by which something is taken back, is empty, out of order or repeated")]
    RepairText(&'a str),
    /// What says the order of two steps, or one of the first words of this, is empty, or not sorted and unique, or the
    /// first word isn't listed; the text.
    #[error(
        "\"{0}\", which says the order of two steps, is empty, out of order, repeated, or its first word is not listed"
    )]
    SequenceText(&'a str),
    /// A word that is read where two steps are put in order is none of the model's; the word.
    #[error("word \"{0}\", which is read where two steps are put in order, isn't there")]
    SequenceWord(&'a str),
    /// What leaves objects out is empty, or not sorted and unique; the text.
    #[error("\"{0}\", which leaves objects out, is empty, out of order or repeated")]
    ExceptionText(&'a str),
    /// What says a distance is empty, or not sorted and unique, a unit or a number is not positive and finite, or there
    /// are units without a side, or with one that isn't there, or it is a direction of no side; the text.
    #[error(
        "\"{0}\", which says a distance, is empty, out of order, repeated, not positive, or of no side that is there"
    )]
    DistanceText(&'a str),
    /// A word that is read in place of a distance without a side, or of a direction, is none of the model's; the word.
    #[error(
        "word \"{0}\", which is read where a distance has no side or no reference, isn't there"
    )]
    DistanceWord(&'a str),
    /// What is counted from an extreme is the extreme itself, of one that isn't there, or there twice; its name.
    #[error(
        "\"{0}\" is counted from an extreme that isn't there, is this itself, is there twice or one too many"
    )]
    Ranked(&'a str),
    /// What is said of it is empty, not sorted and unique, counts nothing, or is of an extreme that isn't there;
    /// the text.
    #[error(
        "\"{0}\", by which is counted, is empty, out of order, repeated, or of no number or extreme"
    )]
    OrdinalText(&'a str),
    /// A compound is made of actions that aren't there, of none, or of another number; its name.
    #[error(
        "compound {0} names an action that isn't there, none, more than {MAX_SIDES}, or, of the kind \
         `All`, other than {COMPOSED}"
    )]
    CompoundParts(&'a str),
    /// What means a compound, or names a side, is empty, not sorted and unique, or means one that isn't there;
    /// the text.
    #[error(
        "\"{0}\", which means a compound or a side, is empty, out of order, repeated or of none"
    )]
    CompoundText(&'a str),
    /// A word that is read of a compound is none of the model's; the word.
    #[error("word \"{0}\", which is read of a compound, isn't there")]
    CompoundWord(&'a str),
    /// Words that are heard as others are not sorted and unique, or known themselves; the word.
    #[error("word \"{0}\", which is heard as another, is out of order, repeated or known")]
    HeardOrder(&'a str),
    /// A word is heard as one that is not known; that one.
    #[error("a word is heard as \"{0}\", which is not known")]
    HeardAs(&'a str),
    /// The hashes of other words are not sorted and unique; the hash out of order.
    #[error("hash {0} of another word is out of order or repeated")]
    OtherWordOrder(u16),
    /// A concept has an invalid attribute type; its name.
    #[error("concept {0} has an attribute type that isn't there")]
    ConceptAttribute(&'a str),
    /// A concept's embedding does not have length 1; its name.
    #[error("the embedding of concept {0} has not length 1")]
    ConceptLength(&'a str),
    /// An edge length of a concept is not finite, or not greater than 0; its name.
    #[error("an edge of concept {0} is not longer than 0 and finite")]
    ConceptEdges(&'a str),
    /// No concept has edge lengths: the sizes of objects are unknown.
    #[error("no concept of the model has edge lengths")]
    NoEdges,
    /// A threshold is outside 0 to 1.
    #[error("a threshold is not from 0 to 1")]
    Threshold,
    /// The work space is not finite or has its bounds in the wrong order.
    #[error("the work space's bounds are not ordered and finite")]
    WorkSpace,
    /// The orientation of placed objects is not a quaternion of length 1.
    #[error("placed_orientation is not a quaternion of length 1")]
    PlacedOrientation,
    /// The camera of the training is invalid.
    #[error("training_camera: {0}")]
    TrainingCamera(CameraError),
}

impl<'a> Model<'a> {
    /// The first eight bytes of the identity: ties a scene's embeddings to the model that computed
    /// them.
    ///
    /// It differs for other weights, thresholds, work spaces or domains, and does not depend on the
    /// model's metrics.
    pub const fn tag(&self) -> u64 {
        let [a, b, c, d, e, f, g, h, ..] = self.header.identity;
        u64::from_le_bytes([a, b, c, d, e, f, g, h])
    }

    /// The same model without the crop encoder. In a program that has only this one, the linker leaves
    /// the encoder's weights out, 160 KB.
    ///
    /// ```
    /// use nsrm_core::{Model, Planner};
    /// use nsrm_tabletop::TABLETOP;
    ///
    /// static PLANNING: Model<'static> = TABLETOP.without_vision();
    /// assert!(Planner::new(&PLANNING).parse("put the red block on the blue block").is_ok());
    /// ```
    #[must_use]
    pub const fn without_vision(self) -> Self {
        Self {
            vision: None,
            ..self
        }
    }

    /// Checks that every index is valid, every list is sorted and the header is valid. A model that
    /// passes never causes [`crate::Refusal::InvalidModel`].
    ///
    /// Parameters are not checked: the code generator and the loader check the tensors, and results
    /// that are not finite are refused.
    ///
    /// ```
    /// use nsrm_core::model::{Model, ModelFault};
    /// use nsrm_tabletop::TABLETOP;
    ///
    /// assert_eq!(TABLETOP.check(), Ok(()));
    /// assert_eq!(Model::new().check(), Err(ModelFault::Empty("words")));
    /// ```
    pub fn check(&self) -> Result<(), ModelFault<'a>> {
        self.check_lengths()?;
        self.check_words()?;
        for concept in self.concepts {
            if usize::from(concept.attribute) >= self.attributes.len() {
                return Err(ModelFault::ConceptAttribute(concept.name));
            }
            if !is_unit(&concept.embedding) {
                return Err(ModelFault::ConceptLength(concept.name));
            }
            let mut edges = concept.edges_m.iter().flatten();
            if !edges.all(|edge_m| edge_m.is_finite() && *edge_m > 0.0) {
                return Err(ModelFault::ConceptEdges(concept.name));
            }
        }
        if !self.has_edges() {
            return Err(ModelFault::NoEdges);
        }
        self.check_header()
    }

    /// Whether the sizes of objects are known.
    pub(crate) fn has_edges(&self) -> bool {
        self.concepts
            .iter()
            .any(|concept| concept.edges_m.is_some())
    }

    fn check_lengths(&self) -> Result<(), ModelFault<'a>> {
        let lists = [
            ("words", self.words.len(), MAX_WORDS),
            ("lexicon words", self.lexicon.len(), usize::MAX),
            ("attributes", self.attributes.len(), MAX_INDEXED),
            ("concepts", self.concepts.len(), MAX_INDEXED),
            (
                "actions",
                self.actions.len(),
                MAX_INDEXED.saturating_sub(self.compounds.compounds.len()),
            ),
        ];
        for (name, length, limit) in lists {
            if length == 0 {
                return Err(ModelFault::Empty(name));
            }
            if length > limit {
                return Err(ModelFault::TooLong(name));
            }
        }
        Ok(())
    }

    fn check_words(&self) -> Result<(), ModelFault<'a>> {
        let mut before = "";
        for word in self.words {
            if word.text <= before {
                return Err(ModelFault::WordOrder(word.text));
            }
            before = word.text;
        }
        if self.embeddings.count() != self.words.len().saturating_add(1) {
            return Err(ModelFault::Embeddings(self.embeddings.count()));
        }
        let mut before = "";
        for entry in self.lexicon {
            if entry.text <= before {
                return Err(ModelFault::LexiconOrder(entry.text));
            }
            before = entry.text;
            let is_there = match entry.property {
                Property::Concept(concept) => usize::from(concept) < self.concepts.len(),
                Property::Extreme(extreme) => self.has_extreme(extreme),
                Property::Ranked(index) => usize::from(index) < self.ordinals.ranked.len(),
                Property::Quantifier(quantifier) => quantifier != Quantifier::Each,
                Property::Table => self.table.is_place(),
                Property::Itself => false,
            };
            if !is_there {
                return Err(ModelFault::LexiconProperty(entry.text));
            }
            let is_quantifier = matches!(entry.property, Property::Quantifier(_));
            if !is_quantifier && self.words.iter().any(|word| word.text == entry.text) {
                return Err(ModelFault::WordInLexicon(entry.text));
            }
        }
        self.check_pronouns()?;
        self.check_several()?;
        self.check_rephrasing()?;
        self.check_lists()?;
        self.check_perspectives()?;
        self.check_exceptions()?;
        self.check_repairs()?;
        self.check_sequence()?;
        self.check_distances()?;
        self.check_ordinals()?;
        self.check_arrangements()?;
        self.check_table()?;
        self.check_compounds()?;
        self.check_spelling()
    }

    fn check_pronouns(&self) -> Result<(), ModelFault<'a>> {
        let mut least = 0;
        for pronoun in self.pronouns {
            let (word, owner) = (
                usize::from(pronoun.word),
                pronoun.owner.map_or(0, usize::from),
            );
            if word < least || word.max(owner) >= self.words.len() {
                return Err(ModelFault::Pronoun(pronoun.word));
            }
            least = word.saturating_add(1);
        }
        let mut least = 0;
        for &word in self.placing {
            if usize::from(word) < least || usize::from(word) >= self.words.len() {
                return Err(ModelFault::Placing(word));
            }
            least = usize::from(word).saturating_add(1);
        }
        match rewriting::first_unsorted(self.conjunctions.iter().copied()) {
            Some(text) => Err(ModelFault::Conjunction(text)),
            None => Ok(()),
        }
    }

    fn check_several(&self) -> Result<(), ModelFault<'a>> {
        let is_word = |index: u16| usize::from(index) < self.words.len();
        let mut between = self.several.between.iter();
        if let Some(&index) = between.find(|index| !is_word(**index)) {
            return Err(ModelFault::Between(index));
        }
        let is_lexical = |text: &str| self.lexicon.iter().any(|entry| entry.text == text);
        let mut before = "";
        for plural in self.several.plurals {
            if plural.text <= before || is_lexical(plural.text) || !is_word(plural.word) {
                return Err(ModelFault::Plural(plural.text));
            }
            before = plural.text;
        }
        Ok(())
    }

    /// Whether objects can be compared by it.
    fn has_extreme(&self, extreme: Extreme) -> bool {
        match extreme {
            Extreme::Action(action) => {
                let action = self.actions.get(usize::from(action));
                action.is_some_and(|action| action.extreme.is_some())
            }
            Extreme::Largest | Extreme::Smallest => true,
        }
    }

    fn is_known(&self, text: &str) -> bool {
        self.words.iter().any(|word| word.text == text)
            || self.lexicon.iter().any(|entry| entry.text == text)
    }

    fn check_spelling(&self) -> Result<(), ModelFault<'a>> {
        let mut before = "";
        for heard in self.spelling.heard {
            if heard.text <= before || self.is_known(heard.text) {
                return Err(ModelFault::HeardOrder(heard.text));
            }
            if !self.is_known(heard.read_as) {
                return Err(ModelFault::HeardAs(heard.read_as));
            }
            before = heard.text;
        }
        let mut hashes = self.spelling.other_words.windows(2);
        match hashes.find_map(|pair| match pair {
            [before, behind] if before >= behind => Some(*behind),
            _ => None,
        }) {
            Some(hash) => Err(ModelFault::OtherWordOrder(hash)),
            None => Ok(()),
        }
    }

    fn check_header(&self) -> Result<(), ModelFault<'a>> {
        let thresholds = self.header.thresholds;
        let fractions = [
            thresholds.match_score,
            thresholds.decision,
            thresholds.confidence,
        ];
        if !fractions.iter().all(|value| (0.0..=1.0).contains(value)) {
            return Err(ModelFault::Threshold);
        }
        let WorkSpace { min, max } = self.header.work_space;
        let ordered = min
            .iter()
            .zip(&max)
            .all(|(min, max)| min.is_finite() && max.is_finite() && min <= max);
        if !ordered {
            return Err(ModelFault::WorkSpace);
        }
        if !is_unit(&self.header.placed_orientation) {
            return Err(ModelFault::PlacedOrientation);
        }
        let camera = self.header.training_camera.check();
        camera.map_err(ModelFault::TrainingCamera)
    }
}

impl WorkSpace {
    /// The x and y of its middle.
    pub(crate) fn middle(&self) -> [f32; 2] {
        let ([x1, y1, _], [x2, y2, _]) = (self.min, self.max);
        [0.5 * (x1 + x2), 0.5 * (y1 + y2)]
    }

    /// Whether a point is inside, bounds included.
    ///
    /// * `position`: world frame, metres
    pub fn contains(&self, position: &[f32; 3]) -> bool {
        let bounds = self.min.iter().zip(&self.max);
        position
            .iter()
            .zip(bounds)
            .all(|(value, (min, max))| min <= value && value <= max)
    }
}

#[cfg(test)]
mod tests;
