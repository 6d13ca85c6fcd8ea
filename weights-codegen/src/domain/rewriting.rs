//! What is read in place of other words: what is taken back, steps in another order, values that stand apart,
//! the table where it is not named, and towers and rows.

use std::collections::{BTreeMap, BTreeSet};

use nsrm_core::model::MAX_SIDES;
use serde::Deserialize;

use super::{Domain, MAX_NAMES, at_most, not_empty, readable};
use crate::error::ModelError;

/// Phrases that are read as others; without them, all words are read as they stand.
pub(crate) type Rephrasing = BTreeMap<String, String>;

/// What a refused sentence is read again without, and phrases that are then read as simpler ones; without them, it is
/// not read again.
#[derive(Debug, Clone, Default, Deserialize)]
pub struct Simplification {
    /// At its beginning.
    pub opening: Rephrasing,
    /// At any place.
    pub anywhere: Rephrasing,
    /// At its end.
    pub closing: Rephrasing,
    /// At the beginning of each further step.
    #[serde(default)]
    pub connecting: Rephrasing,
    /// Words by which a step is said to be the first.
    #[serde(default)]
    pub starting: BTreeSet<String>,
    /// How an object is taken that is put somewhere.
    #[serde(default)]
    pub taking: Taking,
    /// How an object is described by where it stands alone.
    #[serde(default)]
    pub standing: Standing,
}

/// How an object without attributes is said to stand somewhere.
#[derive(Debug, Clone, Default, Deserialize)]
pub struct Standing {
    /// What may stand between the noun and the relation.
    pub clauses: BTreeSet<String>,
    /// Words with which relations begin.
    pub relations: BTreeSet<String>,
    /// What is read in place of noun and clause.
    pub read_as: String,
}

/// How something is said to be taken and put somewhere in fewer words than a command has.
#[derive(Debug, Clone, Default, Deserialize)]
pub struct Taking {
    /// Words that only take an object.
    pub words: BTreeSet<String>,
    /// Words that say where it is put, and never where it is.
    pub towards: BTreeSet<String>,
    /// What is read in place of the former before the latter.
    pub order: String,
    /// What is read where the object is not named again.
    pub object: String,
}

/// Words by which objects are left out of a description; without them, none is.
#[derive(Debug, Clone, Default, Deserialize)]
pub struct Exceptions {
    /// Before a description of objects that are left out.
    pub phrases: BTreeSet<String>,
    /// Before values that an object does not have.
    pub negations: BTreeSet<String>,
}

/// How objects are listed that are moved; without it, none are.
#[derive(Debug, Clone, Default, Deserialize)]
pub struct Lists {
    /// Words between two of them, beside commas.
    pub between: BTreeSet<String>,
    /// What they are called where they were taken before.
    pub them: BTreeSet<String>,
    /// Words that put several objects on each other.
    #[serde(default)]
    pub stacking: BTreeSet<String>,
    /// Words for a place beside another object.
    #[serde(default)]
    pub aside: BTreeSet<String>,
    /// What is read between two steps.
    pub next: String,
}

/// How a person says whose left is meant; without it, nobody can.
#[derive(Debug, Clone, Default, Deserialize)]
pub struct Perspectives {
    /// What means the person's own.
    pub own: BTreeSet<String>,
    /// What means that of someone who looks the other way.
    pub other: BTreeSet<String>,
    /// Actions, each with the one in the opposite direction.
    pub opposites: BTreeMap<String, String>,
}

/// Words by which something is taken back; without them, nothing is.
#[derive(Debug, Clone, Default, Deserialize)]
pub struct Repairs {
    /// Between a description and the one that is meant.
    pub corrections: BTreeSet<String>,
    /// Between the description that is meant and another one.
    pub exclusions: BTreeSet<String>,
}

/// Words that say in which order two steps are carried out; without them, it is that in which they are said.
#[derive(Debug, Clone, Default, Deserialize)]
pub struct Sequence {
    /// Before the step that is carried out second, each with what is read in their place.
    pub later: BTreeMap<String, String>,
    /// Before the one that is carried out first.
    pub earlier: BTreeMap<String, String>,
    /// Those before the one that is carried out first if it is said behind the other one only.
    pub afterthoughts: BTreeSet<String>,
    /// What is read between the two.
    pub next: String,
}

/// What may stand between values of one object that are said apart; without it, nothing may.
#[derive(Debug, Clone, Default, Deserialize)]
pub struct Apart {
    /// Directly between values.
    pub between: Vec<String>,
    /// Between an object and another of its values.
    pub phrases: Vec<String>,
}

/// How towers and rows are said, "build a tower of red, green and blue"; without it, they cannot be said.
#[derive(Debug, Clone, Default, Deserialize)]
pub struct Arrangements {
    /// Words between the objects of a list.
    pub between: BTreeSet<String>,
    /// Words before which a list ends.
    pub ends: BTreeSet<String>,
    /// What is read between two steps.
    pub next: String,
    /// What is meant, by name.
    pub steps: BTreeMap<String, ArrangedStep>,
    /// What is said.
    pub patterns: Vec<Pattern>,
}

/// As what the steps of an arrangement are read.
#[derive(Debug, Clone, Deserialize)]
pub struct ArrangedStep {
    /// What is read before the object that is moved.
    pub order: String,
    /// What is read between it and the one before it.
    pub relation: String,
    /// Whether the list begins with the last object.
    #[serde(default)]
    pub reversed: bool,
}

/// What may stand before and behind the objects of a list.
#[derive(Debug, Clone, Deserialize)]
pub struct Pattern {
    /// Before it.
    pub openings: Vec<String>,
    /// Behind it, or an empty text for nothing, each with what is then meant.
    pub closings: BTreeMap<String, String>,
}

impl Arrangements {
    /// Each opening with the index of its pattern, sorted by text.
    pub(crate) fn openings(&self) -> Vec<(&str, usize)> {
        let each = self.patterns.iter().enumerate();
        let each = each
            .flat_map(|(index, pattern)| pattern.openings.iter().map(move |text| (&**text, index)));
        let mut openings: Vec<_> = each.collect();
        openings.sort_unstable();
        openings
    }

    /// Each closing with the index of its pattern and the name of what is meant.
    pub(crate) fn closings(&self) -> impl Iterator<Item = (&str, usize, &str)> + Clone {
        let each = self.patterns.iter().enumerate();
        each.flat_map(|(index, pattern)| {
            pattern
                .closings
                .iter()
                .map(move |(text, meant)| (&**text, index, &**meant))
        })
    }
}

/// The table as a place; without it, nothing can be put there.
#[derive(Debug, Clone, Default, Deserialize)]
pub struct Table {
    /// Words for it.
    pub words: Vec<String>,
    /// Name of the action that is said of it.
    pub action: String,
    /// Names of those that put an object on the table beside another one.
    pub sides: Vec<String>,
    /// What stands between an object and the one that it is taken off.
    pub off: Vec<String>,
    /// What stands there, too, and also says other things.
    #[serde(default)]
    pub sources: Vec<String>,
    /// Words before these with which they say other things.
    #[serde(default)]
    pub unless: Vec<String>,
    /// Words that say that something is taken off another one, and put on the table.
    #[serde(default)]
    pub removing: Vec<String>,
    /// What is read in their place.
    #[serde(default)]
    pub taking: String,
    /// What is read instead of what stands between the two objects.
    pub standing: String,
    /// What is then read before the table.
    pub order: String,
    /// What means the table if nothing else says where to.
    pub down: Vec<String>,
    /// What is then read before the table.
    pub relation: String,
}

impl Domain {
    /// Checks that what is left out, and what is taken back, is said in words that can be read.
    pub(super) fn check_repairs(&self) -> Result<(), ModelError> {
        let Exceptions { phrases, negations } = &self.exceptions;
        let Repairs {
            corrections,
            exclusions,
        } = &self.repairs;
        let excepted = phrases.iter().chain(negations);
        let lists = &self.lists;
        let listed = lists.between.iter().chain(&lists.them);
        let listed = listed.chain(&lists.stacking).chain(&lists.aside);
        let seen = self.perspectives.own.iter().chain(&self.perspectives.other);
        let said = excepted.chain(listed).chain(seen);
        let said = said.chain(corrections).chain(exclusions);
        let mut words = said.flat_map(|text| text.split(' '));
        if let Some(word) = words.find(|word| !readable(word)) {
            return Err(ModelError::UnreadableWord { word: word.into() });
        }
        let words = self.words();
        let mut next = self.lists.next.split(' ').filter(|word| !word.is_empty());
        match next.find(|word| !words.contains(*word)) {
            Some(word) => Err(ModelError::Listed { word: word.into() }),
            None => Ok(()),
        }
    }

    /// The opposite of each action, itself without one.
    pub(crate) fn opposites(&self) -> Result<Vec<u8>, ModelError> {
        let opposites = &self.perspectives.opposites;
        let index = |name: &String| {
            let index = self.action_index(name);
            let index = index.and_then(|index| u8::try_from(index).ok());
            index.ok_or_else(|| ModelError::Opposite { name: name.clone() })
        };
        for (name, opposite) in opposites {
            index(name)?;
            if opposites.get(opposite) != Some(name) {
                return Err(ModelError::Opposite { name: name.clone() });
            }
        }
        if self.perspectives.other.is_empty() {
            return Ok(Vec::new());
        }
        let names = self.action.iter().map(|action| &action.name);
        names
            .map(|name| index(opposites.get(name).unwrap_or(name)))
            .collect()
    }

    /// Checks that phrases can be read, and are read as words of the domain.
    pub(super) fn check_rephrasing(&self) -> Result<(), ModelError> {
        let Simplification {
            opening,
            anywhere,
            closing,
            connecting,
            starting,
            taking,
            standing,
        } = &self.simplification;
        let mut lists = [&self.rephrasing, opening, anywhere, closing, connecting].into_iter();
        lists.try_for_each(|list| self.check_phrases(list))?;
        if let Some((text, _)) = connecting.iter().find(|(_, read_as)| !read_as.is_empty()) {
            return Err(ModelError::Connecting { text: text.clone() });
        }
        let texts = taking.words.iter().chain(&taking.towards).chain(starting);
        let texts = texts.chain(&standing.clauses).chain(&standing.relations);
        let mut said = texts.flat_map(|text| text.split(' '));
        if let Some(word) = said.find(|word| !readable(word)) {
            return Err(ModelError::UnreadableWord { word: word.into() });
        }
        let words = self.words();
        let taking = (!taking.words.is_empty()).then_some([&taking.order, &taking.object]);
        let standing = (!standing.relations.is_empty()).then_some(&standing.read_as);
        let read = taking.into_iter().flatten().chain(standing);
        let mut read = read.flat_map(|text| text.split(' '));
        match read.find(|word| !words.contains(*word)) {
            Some(word) => Err(ModelError::Rephrased { word: word.into() }),
            None => Ok(()),
        }
    }

    fn check_phrases(&self, list: &Rephrasing) -> Result<(), ModelError> {
        let mut said = list.keys().flat_map(|text| text.split(' '));
        if let Some(word) = said.find(|word| !readable(word)) {
            return Err(ModelError::UnreadableWord { word: word.into() });
        }
        let words = self.words();
        let named: BTreeSet<&str> = self.group_words().collect();
        let read_as = list.values().filter(|text| !text.is_empty());
        let mut read_as = read_as.flat_map(|text| text.split(' '));
        match read_as.find(|word| !words.contains(*word) && !named.contains(word)) {
            Some(word) => Err(ModelError::Rephrased { word: word.into() }),
            None => Ok(()),
        }
    }

    /// The first word of each text that says the order of steps.
    pub(crate) fn first_words_of_sequence(&self) -> BTreeSet<&str> {
        let Sequence {
            later,
            earlier,
            afterthoughts,
            ..
        } = &self.sequence;
        let texts = later.keys().chain(earlier.keys()).chain(afterthoughts);
        texts.filter_map(|text| text.split(' ').next()).collect()
    }

    /// Checks that the order of steps is said in words that can be read, and read as those of the domain.
    pub(super) fn check_sequence(&self) -> Result<(), ModelError> {
        let Sequence {
            later,
            earlier,
            afterthoughts,
            next,
        } = &self.sequence;
        if let Some(text) = afterthoughts
            .iter()
            .find(|text| earlier.contains_key(*text))
        {
            return Err(ModelError::Afterthought { text: text.clone() });
        }
        let said = later.keys().chain(earlier.keys()).chain(afterthoughts);
        let mut said = said.flat_map(|text| text.split(' ')).peekable();
        if said.peek().is_none() {
            return Ok(());
        }
        if let Some(word) = said.find(|word| !readable(word)) {
            return Err(ModelError::UnreadableWord { word: word.into() });
        }
        let words = self.words();
        let read_as = later.values().chain(earlier.values());
        let read_as = read_as.filter(|text| !text.is_empty()).chain([next]);
        let mut read_as = read_as.flat_map(|text| text.split(' '));
        match read_as.find(|word| !words.contains(*word)) {
            Some(word) => Err(ModelError::Sequence { word: word.into() }),
            None => Ok(()),
        }
    }

    /// Checks that towers and rows, and values that stand apart, are said in words that can be read, and
    /// read as those of the domain.
    pub(super) fn check_arrangements(&self) -> Result<(), ModelError> {
        let words = self.words();
        let said = &self.arrangements;
        at_most("arrangements", MAX_NAMES, said.steps.len())?;
        at_most("patterns of arrangements", MAX_NAMES, said.patterns.len())?;
        let read_as = said
            .steps
            .values()
            .flat_map(|step| [&step.order, &step.relation]);
        let next = (!said.steps.is_empty()).then_some(&said.next);
        let mut read_as = read_as.chain(next).flat_map(|text| text.split(' '));
        if let Some(word) = read_as.find(|word| !words.contains(*word)) {
            return Err(ModelError::Arrangement { word: word.into() });
        }
        if let Some((.., name)) = said
            .closings()
            .find(|(.., name)| !said.steps.contains_key(*name))
        {
            return Err(ModelError::ArrangedSteps { name: name.into() });
        }
        let openings = said.openings();
        let closings = said.closings().filter(|(text, ..)| !text.is_empty());
        let texts = closings.map(|(text, ..)| text);
        let texts = texts.chain(openings.iter().map(|(text, _)| *text));
        let apart = self.apart.between.iter().chain(&self.apart.phrases);
        let mut words = texts
            .chain(apart.map(String::as_str))
            .flat_map(|text| text.split(' '))
            .chain(said.between.iter().chain(&said.ends).map(String::as_str));
        match words.find(|word| !readable(word)) {
            Some(word) => Err(ModelError::UnreadableWord { word: word.into() }),
            None => Ok(()),
        }
    }

    /// Checks that the table is said in words that can be read, and read as those of the domain, and that
    /// its actions are there.
    pub(super) fn check_table(&self) -> Result<(), ModelError> {
        let Some(table) = &self.table else {
            return Ok(());
        };
        not_empty("the list of words for the table", table.words.len())?;
        not_empty("the list of sides of the table", table.sides.len())?;
        at_most("sides of the table", MAX_SIDES, table.sides.len())?;
        let mut actions = table.sides.iter().chain([&table.action]);
        if let Some(name) = actions.find(|name| self.action_index(name).is_none()) {
            return Err(ModelError::TableAction { name: name.clone() });
        }
        if !self.tells_what_is_on_table() {
            return Err(ModelError::TableHeight);
        }
        let words = self.words();
        let taking = (!table.removing.is_empty()).then_some(&table.taking);
        let read_as = [&table.standing, &table.order, &table.relation];
        let read_as = read_as.into_iter().chain(taking);
        let mut read_as = read_as.flat_map(|text| text.split(' '));
        if let Some(word) = read_as.find(|word| !words.contains(*word)) {
            return Err(ModelError::Table { word: word.into() });
        }
        let Table {
            off,
            sources,
            unless,
            removing,
            down,
            ..
        } = table;
        let said = [off, sources, unless, removing, down].into_iter().flatten();
        let mut said = said.flat_map(|text| text.split(' '));
        match said.find(|word| !readable(word)) {
            Some(word) => Err(ModelError::UnreadableWord { word: word.into() }),
            None => Ok(()),
        }
    }

    /// Whether the highest object on the table is lower than the lowest one that stands on another.
    pub(super) fn tells_what_is_on_table(&self) -> bool {
        let heights = self.concepts().filter_map(|(_, value)| value.edges_m);
        let heights = heights.map(|[_, _, height_m]| height_m);
        let (lowest, highest) = (heights.clone().reduce(f32::min), heights.reduce(f32::max));
        lowest
            .zip(highest)
            .is_some_and(|(lowest, highest)| 0.5 * highest < 1.5 * lowest)
    }

    /// The index of an action.
    pub(crate) fn action_index(&self, name: &str) -> Option<usize> {
        self.action.iter().position(|action| action.name == name)
    }
}
