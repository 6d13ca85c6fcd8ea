//! Actions that are made of others: "next to", "in front and to the left of".

use std::collections::BTreeSet;

use nsrm_core::model::{COMPOSED, CompoundKind, MAX_SIDES};
use serde::Deserialize;

use super::{Domain, at_most, not_empty, readable, unique};
use crate::error::ModelError;

/// Actions that are made of others; without it, there are none.
#[derive(Debug, Clone, Default, Deserialize)]
pub struct Compounds {
    /// The actions.
    pub made: Vec<Compound>,
    /// Words that name a side.
    pub sides: BTreeSet<String>,
}

/// An action that is made of others. It has one of `any`, `all` and `between`.
#[derive(Debug, Clone, Deserialize)]
pub struct Compound {
    /// Its name in programs.
    pub name: String,
    /// How a person says it.
    pub phrase: String,
    /// Names of the actions of which it is any.
    #[serde(default)]
    pub any: Vec<String>,
    /// Names of those of which it is both, one after the other.
    #[serde(default)]
    pub all: Vec<String>,
    /// The name of that which tells how far an object between two others is from them.
    #[serde(default)]
    pub between: Vec<String>,
    /// What means it.
    pub said: Vec<String>,
    /// What is read instead.
    pub read: String,
}

impl Compound {
    /// How its parts make it up, and their names.
    pub(crate) fn parts(&self) -> (CompoundKind, &[String]) {
        if !self.between.is_empty() {
            (CompoundKind::Between, &self.between)
        } else if self.all.is_empty() {
            (CompoundKind::Any, &self.any)
        } else {
            (CompoundKind::All, &self.all)
        }
    }
}

impl Domain {
    /// Each text that means a compound, with its index, sorted.
    pub(crate) fn compound_texts(&self) -> Vec<(&str, usize)> {
        let each = self.compounds.made.iter().enumerate();
        let each = each
            .flat_map(|(index, compound)| compound.said.iter().map(move |text| (&**text, index)));
        let mut texts: Vec<_> = each.collect();
        texts.sort_unstable();
        texts
    }

    /// The indices of the actions of which each compound is made.
    pub(crate) fn compound_parts(&self) -> Result<Vec<Vec<u8>>, ModelError> {
        let index = |compound: &Compound, action: &String| {
            let found = self.action_index(action);
            let found = found.and_then(|index| u8::try_from(index).ok());
            found.ok_or_else(|| ModelError::CompoundAction {
                name: compound.name.clone(),
                action: action.clone(),
            })
        };
        let each = self.compounds.made.iter();
        each.map(|compound| {
            let parts = compound.parts().1.iter();
            parts.map(|action| index(compound, action)).collect()
        })
        .collect()
    }

    /// The first word of each of these texts.
    pub(crate) fn compound_first_words(&self) -> BTreeSet<&str> {
        let texts = self.compound_texts().into_iter();
        texts
            .filter_map(|(text, _)| text.split(' ').next())
            .collect()
    }

    /// Checks that compounds are made of actions of the domain, said in words that can be read, each
    /// text of one only, and read as words of the domain.
    pub(super) fn check_compounds(&self) -> Result<(), ModelError> {
        unique(
            "text of a compound",
            self.compound_texts().into_iter().map(|(text, _)| text),
        )?;
        let words = self.words();
        for compound in &self.compounds.made {
            let Compound {
                name,
                any,
                all,
                between,
                ..
            } = compound;
            let (kind, parts) = compound.parts();
            not_empty(&format!("the list of actions of {name:?}"), parts.len())?;
            at_most("actions of a compound", MAX_SIDES, parts.len())?;
            let given = [any, all, between].into_iter();
            let is_one = given.filter(|list| !list.is_empty()).count() == 1;
            let expected = match kind {
                CompoundKind::All => COMPOSED,
                CompoundKind::Between => 1,
                _ => parts.len(),
            };
            if !is_one || parts.len() != expected {
                return Err(ModelError::CompoundParts { name: name.clone() });
            }
            let unknown = |part: &&String| self.action_index(part).is_none();
            if let Some(part) = parts.iter().find(unknown) {
                let (name, action) = (name.clone(), part.clone());
                return Err(ModelError::CompoundAction { name, action });
            }
            let mut read = compound.read.split(' ');
            if let Some(word) = read.find(|word| !words.contains(*word)) {
                let (name, word) = (name.clone(), word.into());
                return Err(ModelError::CompoundWord { name, word });
            }
        }
        let made = self.compounds.made.iter();
        let said = made.flat_map(|compound| &compound.said);
        let said = said.flat_map(|text| text.split(' '));
        let mut said = said.chain(self.compounds.sides.iter().map(String::as_str));
        if let Some(word) = said.find(|word| !readable(word)) {
            return Err(ModelError::UnreadableWord { word: word.into() });
        }
        let mut kinds = self
            .compounds
            .made
            .iter()
            .map(|compound| compound.parts().0);
        if kinds.any(|kind| kind != CompoundKind::All) && !self.tells_what_is_on_table() {
            return Err(ModelError::TableHeight);
        }
        Ok(())
    }
}
