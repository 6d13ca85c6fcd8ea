//! What is counted from one side: "the second red block from the left".

use std::collections::{BTreeMap, BTreeSet};

use nsrm_core::dsl::Extreme;
use serde::Deserialize;

use super::{Domain, MAX_NAMES, at_most, not_empty, readable, unique};
use crate::error::ModelError;

/// How is counted from one side; without it, nothing is.
#[derive(Debug, Clone, Default, Deserialize)]
pub struct Ordinals {
    /// Words that count 1, 2 and so on; the first of each names what is counted.
    pub counts: Vec<Vec<String>>,
    /// From where is counted, "from the left", with the names of the extremes.
    pub starts: BTreeMap<String, String>,
    /// The same of what also means the extreme itself where nothing is counted, "on the far left".
    pub first: BTreeMap<String, String>,
    /// Words that stand before a count without a noun.
    pub articles: BTreeSet<String>,
    /// Words that may stand between a description and from where is counted.
    pub nouns: BTreeSet<String>,
    /// Words behind "from the left" with which it means something else.
    pub unless: BTreeSet<String>,
}

/// What is counted from an extreme, with its name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Ranked {
    pub(crate) name: String,
    pub(crate) extreme: Extreme,
    pub(crate) rank: u8,
}

impl Domain {
    /// What can be counted from the extremes, in the order of their names and then of the numbers.
    pub(crate) fn ranked(&self) -> Vec<Ranked> {
        let extremes = self.extremes.iter();
        let extremes =
            extremes.filter_map(|(name, words)| Some((self.extreme(name)?, words.first()?)));
        extremes
            .flat_map(|(extreme, word)| {
                let counts = (1_u8..).zip(&self.ordinals.counts).skip(1);
                counts.filter_map(move |(rank, counts)| {
                    let name = format!("{} {word}", counts.first()?);
                    Some(Ranked {
                        name,
                        extreme,
                        rank,
                    })
                })
            })
            .collect()
    }

    /// Each word that counts, with its number, sorted.
    pub(crate) fn counts(&self) -> BTreeMap<&str, u8> {
        let counts = (1_u8..).zip(&self.ordinals.counts);
        counts
            .flat_map(|(rank, words)| words.iter().map(move |word| (word.as_str(), rank)))
            .collect()
    }

    /// Each text that says from where is counted, with the extreme and whether it also means this itself,
    /// sorted.
    pub(crate) fn counted_from(&self) -> Result<BTreeMap<&str, (Extreme, bool)>, ModelError> {
        let Ordinals { starts, first, .. } = &self.ordinals;
        let from = starts.iter().map(|named| (named, false));
        let from = from.chain(first.iter().map(|named| (named, true)));
        from.map(|((text, name), is_first)| {
            let extreme = self.extreme(name);
            let extreme = extreme.filter(|_| self.extremes.contains_key(name));
            let extreme = extreme.ok_or_else(|| ModelError::CountedFrom { name: name.clone() })?;
            Ok((text.as_str(), (extreme, is_first)))
        })
        .collect()
    }

    /// The first word of each text that means the extreme itself where nothing is counted.
    pub(crate) fn first_words_of_counts(&self) -> BTreeSet<&str> {
        let texts = self.ordinals.first.keys();
        texts.filter_map(|text| text.split(' ').next()).collect()
    }

    /// Checks that what is counted from are extremes of the domain, that each text and count is there once, and
    /// that all words can be read.
    pub(super) fn check_ordinals(&self) -> Result<(), ModelError> {
        let Ordinals {
            counts,
            starts,
            first,
            articles,
            nouns,
            unless,
        } = &self.ordinals;
        for words in counts {
            not_empty("the list of words of a count", words.len())?;
        }
        let ranked = self.extremes.len().saturating_mul(counts.len());
        at_most("extremes times counts", MAX_NAMES, ranked)?;
        let counts = || counts.iter().flatten().map(String::as_str);
        unique("count", counts())?;
        let texts = || starts.keys().chain(first.keys()).map(String::as_str);
        unique("text from where is counted", texts())?;
        self.counted_from()?;
        let lists = [articles, nouns, unless].into_iter().flatten();
        let words = texts().flat_map(|text| text.split(' ')).chain(counts());
        match words
            .chain(lists.map(String::as_str))
            .find(|word| !readable(word))
        {
            Some(word) => Err(ModelError::UnreadableWord { word: word.into() }),
            None => Ok(()),
        }
    }
}
