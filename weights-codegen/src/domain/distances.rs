//! How far from the reference, or from where it is, an object is put.

use std::collections::{BTreeMap, BTreeSet};

use serde::Deserialize;

use super::{Domain, readable};
use crate::error::ModelError;

/// Words that say a distance; without units, none is understood.
#[derive(Debug, Clone, Default, Deserialize)]
pub struct Distances {
    /// The actions that put an object beside another one.
    pub sides: Vec<String>,
    /// Units of length, in millimetres.
    pub units: BTreeMap<String, f32>,
    /// Numbers in words.
    pub numbers: BTreeMap<String, f32>,
    /// What may stand before a distance and belongs to it.
    pub before: BTreeSet<String>,
    /// What may stand behind it and belongs to it.
    pub behind: BTreeSet<String>,
    /// What stands between it and the reference where no side is named.
    pub from: BTreeSet<String>,
    /// What is read in its place.
    pub beside: String,
    /// Words before it with which it is the size of an object.
    pub unless: BTreeSet<String>,
    /// By action, how a direction is said in which an object is moved from where it is.
    #[serde(default)]
    pub shifts: BTreeMap<String, BTreeSet<String>>,
    /// What may stand behind it and says nothing more.
    #[serde(default)]
    pub origins: BTreeSet<String>,
    /// That of the demonstrations, millimetres.
    pub usual_mm: u16,
}

impl Domain {
    /// Checks that distances are said in words that can be read, and of sizes that there are.
    pub(super) fn check_distances(&self) -> Result<(), ModelError> {
        let Some(distances) = &self.distances else {
            return Ok(());
        };
        let sizes = distances.units.iter().chain(&distances.numbers);
        let mut sizes = sizes.filter(|(_, size)| !(size.is_finite() && **size > 0.0));
        if let Some((text, _)) = sizes.next() {
            return Err(ModelError::Length { text: text.clone() });
        }
        let mut sides = distances.sides.iter();
        if let Some(name) = sides.find(|name| self.action_index(name).is_none()) {
            return Err(ModelError::DistanceSide { name: name.clone() });
        }
        let mut shifted = distances.shifts.keys();
        if let Some(name) = shifted.find(|name| !distances.sides.contains(name)) {
            return Err(ModelError::ShiftSide { name: name.clone() });
        }
        let shifts = || distances.shifts.iter();
        let mut said: Vec<_> = shifts().flat_map(|(_, texts)| texts).collect();
        said.sort_unstable();
        if let Some([text, _]) = said.windows(2).find(|pair| pair.first() == pair.last()) {
            return Err(ModelError::ShiftText {
                text: (*text).clone(),
            });
        }
        if !said.is_empty() && !self.tells_what_is_on_table() {
            return Err(ModelError::TableHeight);
        }
        let sets = [
            &distances.before,
            &distances.behind,
            &distances.from,
            &distances.unless,
            &distances.origins,
        ];
        let sized = distances.units.keys().chain(distances.numbers.keys());
        let texts = sized.chain(sets.into_iter().flatten()).chain(said);
        let mut words = texts.flat_map(|text| text.split(' '));
        if let Some(word) = words.find(|word| !readable(word)) {
            return Err(ModelError::UnreadableWord { word: word.into() });
        }
        let words = self.words();
        let mut beside = distances.beside.split(' ');
        match beside.find(|word| !words.contains(*word)) {
            Some(word) => Err(ModelError::DistanceWord { word: word.into() }),
            None => Ok(()),
        }
    }
}
