//! What is rewritten before a sentence is read: ordinals, arrangements, the table, compounds and distances.

#[cfg(test)]
mod tests;

use super::{MAX_INDEXED, ModelFault};
use crate::model::{
    COMPOSED, Compound, CompoundKind, CountedFrom, Distances, Exceptions, Lists, MAX_SIDES, Model,
    Ordinals, Perspectives, Ranked, Repairs, Rephrasing, Sequence, SequenceText, Standing, Table,
    Taking,
};

impl<'a> Model<'a> {
    pub(super) fn check_arrangements(&self) -> Result<(), ModelFault<'a>> {
        let said = &self.arrangements;
        let is_there = |index: u8| usize::from(index) < said.arrangements.len();
        let mut before = "";
        for opening in said.openings {
            // The same words may open several.
            if opening.text.is_empty() || opening.text < before {
                return Err(ModelFault::Opening(opening.text));
            }
            before = opening.text;
        }
        for words in [said.between, said.ends] {
            if let Some(word) = first_unsorted(words.iter().copied()) {
                return Err(ModelFault::ListWord(word));
            }
        }
        let mut closings = said.closings.iter();
        if let Some(closing) = closings.find(|closing| !is_there(closing.arrangement)) {
            return Err(ModelFault::Closing(closing.text));
        }
        let read_as = said.arrangements.iter();
        let read_as = read_as.flat_map(|each| [each.order, each.relation]);
        let next = (!said.openings.is_empty()).then_some(said.next);
        match self.first_unknown(read_as.chain(next)) {
            Some(text) => Err(ModelFault::ArrangementWord(text)),
            None => Ok(()),
        }
    }

    pub(super) fn check_table(&self) -> Result<(), ModelFault<'a>> {
        let Table {
            action,
            sides,
            off,
            sources,
            unless,
            removing,
            taking,
            standing,
            order,
            down,
            relation,
        } = self.table;
        if sides.is_empty() {
            return Ok(());
        }
        let is_action = |index: &u8| usize::from(*index) < self.actions.len();
        if sides.len() > MAX_SIDES || !sides.iter().chain([&action]).all(is_action) {
            return Err(ModelFault::TableAction);
        }
        for texts in [off, sources, unless, removing, down] {
            if let Some(text) = first_unsorted(texts.iter().copied()) {
                return Err(ModelFault::TableText(text));
            }
        }
        if self.on_table_below_m().is_none() {
            return Err(ModelFault::TableHeight);
        }
        let taking = (!removing.is_empty()).then_some(taking);
        let read_as = [standing, order, relation].into_iter().chain(taking);
        match self.first_unknown(read_as) {
            Some(text) => Err(ModelFault::TableWord(text)),
            None => Ok(()),
        }
    }

    pub(super) fn check_exceptions(&self) -> Result<(), ModelFault<'a>> {
        let Exceptions { phrases, negations } = self.exceptions;
        let mut texts = [phrases, negations].into_iter();
        match texts.find_map(|texts| first_unsorted(texts.iter().copied())) {
            Some(text) => Err(ModelFault::ExceptionText(text)),
            None => Ok(()),
        }
    }

    pub(super) fn check_repairs(&self) -> Result<(), ModelFault<'a>> {
        let Repairs {
            corrections,
            exclusions,
        } = self.repairs;
        let mut texts = [corrections, exclusions].into_iter();
        match texts.find_map(|texts| first_unsorted(texts.iter().copied())) {
            Some(text) => Err(ModelFault::RepairText(text)),
            None => Ok(()),
        }
    }

    pub(super) fn check_perspectives(&self) -> Result<(), ModelFault<'a>> {
        let Perspectives {
            own,
            other,
            first_words,
            opposites,
        } = self.perspectives;
        let mut texts = [own, other, first_words].into_iter();
        let unsorted = texts.find_map(|texts| first_unsorted(texts.iter().copied()));
        let begins = |text: &str| first_words.contains(&text.split(' ').next().unwrap_or_default());
        let mut said = own.iter().chain(other).copied();
        if let Some(text) = unsorted.or_else(|| said.find(|text| !begins(text))) {
            return Err(ModelFault::PerspectiveText(text));
        }
        let of = |action: u8| opposites.get(usize::from(action)).copied();
        let mut actions = (0_u8..).zip(opposites);
        let are_pairs = actions.all(|(action, opposite)| of(*opposite) == Some(action));
        let expected = if other.is_empty() {
            0
        } else {
            self.actions.len()
        };
        if !are_pairs || opposites.len() != expected {
            return Err(ModelFault::Opposites);
        }
        Ok(())
    }

    pub(super) fn check_lists(&self) -> Result<(), ModelFault<'a>> {
        let Lists {
            between,
            them,
            stacking,
            aside,
            next,
        } = self.lists;
        let mut texts = [between, them, stacking, aside].into_iter();
        if let Some(text) = texts.find_map(|texts| first_unsorted(texts.iter().copied())) {
            return Err(ModelFault::ListedText(text));
        }
        match self.first_unknown(Some(next).filter(|next| !next.is_empty()).into_iter()) {
            Some(text) => Err(ModelFault::ListedWord(text)),
            None => Ok(()),
        }
    }

    pub(super) fn check_rephrasing(&self) -> Result<(), ModelFault<'a>> {
        let lists = self.simplification.lists();
        let mut lists = [&self.rephrasing].into_iter().chain(lists);
        lists.try_for_each(|list| self.check_phrases(list))?;
        let mut connecting = self.simplification.connecting.said.iter();
        let unsorted = first_unsorted(self.simplification.starting.iter().copied());
        let read = connecting.find(|said| !said.read_as.is_empty());
        if let Some(text) = unsorted.or(read.map(|said| said.text)) {
            return Err(ModelFault::Connecting(text));
        }
        self.check_taking()?;
        self.check_standing()
    }

    fn check_standing(&self) -> Result<(), ModelFault<'a>> {
        let Standing {
            clauses,
            relations,
            read_as,
        } = self.simplification.standing;
        let mut texts = [clauses, relations].into_iter();
        if let Some(text) = texts.find_map(|texts| first_unsorted(texts.iter().copied())) {
            return Err(ModelFault::StandingText(text));
        }
        match self.first_unknown(Some(read_as).filter(|_| !relations.is_empty()).into_iter()) {
            Some(text) => Err(ModelFault::RephrasedWord(text)),
            None => Ok(()),
        }
    }

    fn check_taking(&self) -> Result<(), ModelFault<'a>> {
        let Taking {
            words,
            towards,
            order,
            object,
        } = self.simplification.taking;
        let mut texts = [words, towards].into_iter();
        if let Some(text) = texts.find_map(|texts| first_unsorted(texts.iter().copied())) {
            return Err(ModelFault::TakingText(text));
        }
        let read = [order, object].into_iter();
        match self.first_unknown(read.filter(|_| !words.is_empty())) {
            Some(text) => Err(ModelFault::RephrasedWord(text)),
            None => Ok(()),
        }
    }

    fn check_phrases(&self, list: &Rephrasing<'a>) -> Result<(), ModelFault<'a>> {
        let Rephrasing { said, first_words } = *list;
        let texts = || said.iter().map(|said| said.text);
        let unsorted = first_unsorted(texts()).or(first_unsorted(first_words.iter().copied()));
        let begins = |text: &str| first_words.contains(&text.split(' ').next().unwrap_or_default());
        if let Some(text) = unsorted.or_else(|| texts().find(|text| !begins(text))) {
            return Err(ModelFault::Rephrased(text));
        }
        let mut read_as = said.iter().flat_map(|said| said.read_as.split(' '));
        let is_named = |text: &str| self.lexicon.iter().any(|entry| entry.text == text);
        let is_known = |text: &str| text.is_empty() || self.is_word(text) || is_named(text);
        match read_as.find(|text| !is_known(text)) {
            Some(text) => Err(ModelFault::RephrasedWord(text)),
            None => Ok(()),
        }
    }

    pub(super) fn check_sequence(&self) -> Result<(), ModelFault<'a>> {
        let Sequence {
            later,
            earlier,
            first_words,
            next,
        } = self.sequence;
        let mut lists = [later, earlier].into_iter();
        let unsorted =
            |texts: &[SequenceText<'a>]| first_unsorted(texts.iter().map(|text| text.text));
        if let Some(text) = lists.find_map(unsorted) {
            return Err(ModelFault::SequenceText(text));
        }
        let begins = |text: &str| first_words.contains(&text.split(' ').next().unwrap_or_default());
        let mut texts = later.iter().chain(earlier).map(|text| text.text);
        let unsorted = first_unsorted(first_words.iter().copied());
        if let Some(text) = unsorted.or_else(|| texts.find(|text| !begins(text))) {
            return Err(ModelFault::SequenceText(text));
        }
        if self.sequence.is_empty() {
            return Ok(());
        }
        let read_as = later.iter().chain(earlier).map(|text| text.read_as);
        let read_as = read_as.filter(|text| !text.is_empty());
        match self.first_unknown(read_as.chain([next])) {
            Some(text) => Err(ModelFault::SequenceWord(text)),
            None => Ok(()),
        }
    }

    pub(super) fn check_distances(&self) -> Result<(), ModelFault<'a>> {
        let Distances {
            sides,
            units,
            numbers,
            before,
            behind,
            from,
            beside,
            unless,
            shifts,
            origins,
            ..
        } = self.distances;
        let fault = |text| Err(ModelFault::DistanceText(text));
        let units_in_order = first_unsorted(units.iter().map(|unit| unit.text));
        let numbers_in_order = first_unsorted(numbers.iter().map(|number| number.text));
        let shifts_in_order = first_unsorted(shifts.iter().map(|shift| shift.text));
        let in_order = units_in_order.or(numbers_in_order).or(shifts_in_order);
        let mut lists = [before, behind, from, unless, origins].into_iter();
        let unsorted = lists.find_map(|texts| first_unsorted(texts.iter().copied()));
        if let Some(text) = in_order.or(unsorted) {
            return fault(text);
        }
        let units = units.iter().map(|unit| (unit.text, unit.mm));
        let numbers = numbers.iter().map(|number| (number.text, number.value));
        let is_positive = |number: f32| number.is_finite() && number > 0.0;
        let mut sizes = units.chain(numbers);
        let is_there = |side: &u8| usize::from(*side) < self.actions.len();
        let has_side = !sides.is_empty() && sides.iter().all(is_there);
        if let Some((text, _)) = sizes.find(|(_, size)| !has_side || !is_positive(*size)) {
            return fault(text);
        }
        if let Some(shift) = shifts.iter().find(|shift| !sides.contains(&shift.action)) {
            return fault(shift.text);
        }
        // What stands on the table, and may be shifted, is told by its height.
        if !shifts.is_empty() && self.on_table_below_m().is_none() {
            return Err(ModelFault::TableHeight);
        }
        let beside = (!from.is_empty()).then_some(beside);
        let shifted = shifts.iter().filter_map(|shift| {
            let action = self.actions.get(usize::from(shift.action))?;
            Some(action.phrase)
        });
        match self.first_unknown(shifted.chain(beside)) {
            Some(text) => Err(ModelFault::DistanceWord(text)),
            None => Ok(()),
        }
    }

    pub(super) fn check_ordinals(&self) -> Result<(), ModelFault<'a>> {
        let Ordinals {
            ranked,
            counts,
            from,
            first_words,
            articles,
            nouns,
            unless,
        } = self.ordinals;
        for (index, named) in ranked.iter().enumerate() {
            let Ranked { extreme, rank, .. } = *named;
            let mut before = ranked.iter().take(index);
            let is_repeated = before.any(|other| (other.extreme, other.rank) == (extreme, rank));
            let is_too_many = index >= MAX_INDEXED;
            if rank < 2 || !self.has_extreme(extreme) || is_repeated || is_too_many {
                return Err(ModelFault::Ranked(named.name));
            }
        }
        if let Some(count) = counts.iter().find(|count| count.rank == 0) {
            return Err(ModelFault::OrdinalText(count.text));
        }
        if let Some(from) = from.iter().find(|from| !self.has_extreme(from.extreme)) {
            return Err(ModelFault::OrdinalText(from.text));
        }
        let mut firsts = from.iter().filter(|from| from.is_first);
        let is_left_out = |from: &&CountedFrom<'_>| {
            let first = from.text.split(' ').next().unwrap_or_default();
            !first_words.contains(&first)
        };
        if let Some(from) = firsts.find(is_left_out) {
            return Err(ModelFault::OrdinalText(from.text));
        }
        let unsorted = [
            first_unsorted(counts.iter().map(|count| count.text)),
            first_unsorted(from.iter().map(|from| from.text)),
            first_unsorted(first_words.iter().copied()),
            first_unsorted(articles.iter().copied()),
            first_unsorted(nouns.iter().copied()),
            first_unsorted(unless.iter().copied()),
        ];
        match unsorted.into_iter().flatten().next() {
            Some(text) => Err(ModelFault::OrdinalText(text)),
            None => Ok(()),
        }
    }

    pub(super) fn check_compounds(&self) -> Result<(), ModelFault<'a>> {
        for compound in self.compounds.compounds {
            let Compound {
                name, kind, parts, ..
            } = *compound;
            let mut known = parts.iter();
            let are_known = known.all(|index| usize::from(*index) < self.actions.len());
            let is_made = match kind {
                CompoundKind::Any => !parts.is_empty() && parts.len() <= MAX_SIDES,
                CompoundKind::All => parts.len() == COMPOSED,
                CompoundKind::Between => parts.len() == 1,
            };
            if !are_known || !is_made {
                return Err(ModelFault::CompoundParts(name));
            }
            if let Some(text) = self.first_unknown([compound.read].into_iter()) {
                return Err(ModelFault::CompoundWord(text));
            }
        }
        let mut before = "";
        for said in self.compounds.said {
            let is_there = usize::from(said.compound) < self.compounds.compounds.len();
            let first = said.text.split(' ').next().unwrap_or_default();
            let begins = self.compounds.first_words.contains(&first);
            if said.text <= before || !is_there || !begins {
                return Err(ModelFault::CompoundText(said.text));
            }
            before = said.text;
        }
        for words in [self.compounds.first_words, self.compounds.sides] {
            if let Some(word) = first_unsorted(words.iter().copied()) {
                return Err(ModelFault::CompoundText(word));
            }
        }
        // Whether a free place is on the table is told by its height.
        let mut kinds = self
            .compounds
            .compounds
            .iter()
            .map(|compound| compound.kind);
        if kinds.any(|kind| kind != CompoundKind::All) && self.on_table_below_m().is_none() {
            return Err(ModelFault::TableHeight);
        }
        Ok(())
    }

    /// The first word of these texts that is none of the model's.
    fn first_unknown(&self, mut texts: impl Iterator<Item = &'a str>) -> Option<&'a str> {
        texts.find_map(|text| text.split(' ').find(|text| !self.is_word(text)))
    }

    fn is_word(&self, text: &str) -> bool {
        self.words.iter().any(|word| word.text == text)
    }

    /// Whether the words of every sentence are read as they stand.
    pub(crate) const fn has_no_rewriting(&self) -> bool {
        self.arrangements.openings.is_empty()
            && self.apart.phrases.is_empty()
            && self.rephrasing.is_empty()
            && self.simplification.is_empty()
            && self.exceptions.is_empty()
            && self.perspectives.is_empty()
            && self.lists.is_empty()
            && self.repairs.is_empty()
            && self.sequence.is_empty()
            && self.distances.is_empty()
            && self.ordinals.is_empty()
            && !self.table.is_place()
            && self.compounds.said.is_empty()
    }
}

/// The first of these texts that is empty or does not come behind the one before it.
pub(super) fn first_unsorted<'a>(texts: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let mut before = "";
    texts.into_iter().find(|text| {
        let is_behind = *text > before;
        before = text;
        !is_behind
    })
}
