//! The table where it is not named: "take the red block off the blue one", "put it down".
//!
//! The words are replaced by those that name it, "take the red block that is on the blue one and put it on
//! the [table]", which the network reads and judges as if they had been said. Nothing is learned here: the
//! model lists what is said and how it is read ([`crate::model::Table`]).

use core::ops::Range;

use super::phrases::PhraseMatcher;
use super::pronouns::pronoun;
use super::tokens::{Tokens, push, span_of};
use super::{Token, TokenKind};
use crate::dsl::{Filters, Property};
use crate::refusal::Refusal;

/// What means the table, and how it is read.
pub(super) struct Implied<'a> {
    /// Index of the word that says that something is taken away, and is read as the model's word for taking.
    removing: Option<usize>,
    /// The words that mean it.
    said: Range<usize>,
    /// The words in their place: empty for none, `None` if they stay.
    instead: Option<&'a str>,
    /// Index of the token before which the table is read, with the words before it; `None` if another
    /// place is named.
    place: Option<(usize, &'a str)>,
}

/// The part of a sentence in which words stand that mean the table.
struct Clause<'t> {
    /// Index of its first token.
    start: usize,
    /// Its tokens before these words.
    before: &'t [Token],
    /// How many objects it describes before them.
    moved: usize,
    /// How many behind them.
    others: usize,
    /// Index of the token before which a place is named.
    end: usize,
    /// Whether what follows says what is done with what was described.
    goes_on: bool,
}

impl<'a> PhraseMatcher<'_, 'a> {
    /// What means the table and begins at a token.
    pub(super) fn implied_table(&self, tokens: &[Token], at: usize) -> Option<Implied<'a>> {
        let table = self.model.table;
        let rest = tokens.get(at..).filter(|_| table.is_place())?;
        rest.first().filter(|token| !token.is_group())?;
        let longest = |texts| {
            let found = self.longest::<&str>(rest, texts);
            found.map(|(length, _)| length)
        };
        if let Some(length) = longest(table.off) {
            self.taken_off(tokens, at..at.checked_add(length)?, false)
        } else if let Some(length) = longest(table.sources) {
            self.taken_off(tokens, at..at.checked_add(length)?, true)
        } else {
            self.put_down(tokens, at..at.checked_add(longest(table.down)?)?)
        }
    }

    /// An object that is taken off another one.
    ///
    /// * `is_source`: whether the words also say other things, as "from" does
    fn taken_off(
        &self,
        tokens: &[Token],
        said: Range<usize>,
        is_source: bool,
    ) -> Option<Implied<'a>> {
        let table = self.model.table;
        let clause = self.described(tokens, &said)?;
        let removes = |token: &Token| self.is_one_of(table.removing, token);
        let removing = clause.before.iter().position(removes);
        let removing = removing.and_then(|index| clause.start.checked_add(index));
        // The object or its noun, "toy block": "from" belongs to it.
        let follows_object = clause.before.iter().rev().take(3).any(Token::is_group);
        let means_other = |token: &Token| self.is_one_of(table.unless, token);
        if is_source && clause.before.iter().any(means_other) {
            return None;
        }
        let is_said = !is_source || removing.is_some() || (clause.goes_on && follows_object);
        let instead = match (clause.moved, clause.others) {
            (1, 1) if is_said => table.standing,
            (1, 2) if follows_object && removing.is_none() => table.standing,
            (_, 0) if !is_source && said.len() == 1 && self.is_moved(&clause) => "",
            _ => return None,
        };
        let is_elsewhere = clause.goes_on || clause.others > 1;
        Some(Implied {
            removing,
            said,
            instead: Some(instead),
            place: (!is_elsewhere).then_some((clause.end, table.order)),
        })
    }

    /// An object that is put down.
    fn put_down(&self, tokens: &[Token], said: Range<usize>) -> Option<Implied<'a>> {
        let clause = self.described(tokens, &said)?;
        let at = match (self.is_moved(&clause), clause.others) {
            (true, 0) => said.end,
            (false, 1) => clause.end,
            _ => return None,
        };
        let words = tokens.get(said.clone())?;
        let is_unknown = words.iter().any(|token| token.kind == TokenKind::Unknown);
        (!clause.goes_on).then_some(Implied {
            removing: None,
            said,
            instead: is_unknown.then_some(""),
            place: Some((at, self.model.table.relation)),
        })
    }

    /// What is described in the clause in which words stand that mean the table.
    fn described<'t>(&self, tokens: &'t [Token], said: &Range<usize>) -> Option<Clause<'t>> {
        let Range { start, end } = self.clause(tokens, said)?;
        let before = tokens.get(start..said.start)?;
        let behind = tokens.get(said.end..)?;
        let clause = tokens.get(said.end..end)?;
        // The table is read before ", please" and "and".
        let last = clause.iter().rposition(Token::is_group).unwrap_or(0);
        let mut rest = clause.iter().skip(last);
        let separator = rest.position(|token| self.ends_clause(token));
        let length = separator.map_or(clause.len(), |separator| last.saturating_add(separator));
        let described = |tokens: &[Token]| tokens.iter().filter(|token| token.is_group()).count();
        Some(Clause {
            start,
            before,
            moved: described(before),
            others: described(clause),
            end: said.end.checked_add(length)?,
            goes_on: self.goes_on(behind.get(length..).unwrap_or_default()),
        })
    }

    /// Whether the clause of these words describes one object, or a pronoun stands for one, before them and none
    /// behind.
    pub(super) fn moves_one(&self, tokens: &[Token], said: &Range<usize>) -> bool {
        let clause = self.described(tokens, said);
        clause
            .is_some_and(|clause| clause.moved <= 1 && clause.others == 0 && self.is_moved(&clause))
    }

    /// Whether one object stands before the words that mean the table.
    fn is_moved(&self, clause: &Clause<'_>) -> bool {
        clause.moved == 1 || clause.before.iter().any(|token| self.is_pronoun(token))
    }

    /// Appends the tokens as they are read; the index behind what was replaced.
    pub(super) fn write_table(
        &self,
        tokens: &[Token],
        implied: &Implied<'a>,
        read: &mut Tokens,
    ) -> Result<usize, Refusal> {
        let Implied {
            removing,
            said,
            instead,
            place,
        } = implied;
        let mut behind = 0;
        let words = tokens.get(said.clone()).unwrap_or_default();
        let span = span_of(words).ok_or(Refusal::InvalidModel)?;
        for index in 0..=tokens.len() {
            if let Some(instead) = instead.filter(|_| index == said.start) {
                self.write_words(instead, span, read)?;
            }
            if let Some((_, words)) = place.filter(|(at, _)| *at == index) {
                let mut table = Filters::new();
                // It has room.
                let _ = table.add(Property::Table);
                self.write_words(words, span, read)?;
                push(read, TokenKind::Group(table), span)?;
            }
            if index == said.end {
                behind = read.len();
            }
            match tokens.get(index) {
                Some(token) if *removing == Some(index) => {
                    self.write_words(self.model.table.taking, token.span, read)?;
                }
                Some(token) if instead.is_none() || !said.contains(&index) => {
                    push(read, token.kind, token.span)?;
                }
                _ => {}
            }
        }
        Ok(behind)
    }

    /// Whether what means the table may mean something else: a single word that is known.
    pub(super) fn may_be_read(tokens: &[Token], implied: &Implied<'_>) -> bool {
        let words = tokens.get(implied.said.clone()).unwrap_or_default();
        implied.removing.is_none() && matches!(words, [word] if word.kind != TokenKind::Unknown)
    }

    /// Whether a token stands between two clauses: as it ends a list, or separates what is listed.
    fn ends_clause(&self, token: &Token) -> bool {
        let lists = self.model.arrangements;
        self.ends(token) || self.is_one_of(lists.between, token)
    }

    /// Whether these tokens say what is done with what was described before, "and put it on the blue one",
    /// unlike "after that, put that red block on …".
    fn goes_on(&self, tokens: &[Token]) -> bool {
        let group = tokens.iter().position(|token| token.filters().is_some());
        let end = group.map_or(tokens.len(), |group| group.saturating_add(1));
        let before = tokens.get(..end).unwrap_or_default();
        before.windows(2).any(|pair| match pair {
            [pronoun, next] => {
                self.is_pronoun(pronoun) && !next.is_group() && !self.ends_clause(next)
            }
            _ => false,
        })
    }

    fn is_pronoun(&self, token: &Token) -> bool {
        match token.kind {
            TokenKind::Pronoun => true,
            TokenKind::Word(index) => pronoun(self.model, index).is_some(),
            _ => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::fixture::{self, parse};
    use crate::refusal::Refusal;

    #[test]
    fn the_table_is_read_where_it_is_meant() {
        let model = fixture::with_table();
        for (sentence, read_as) in [
            ("put red off green", "put red above green on the desk"),
            ("put red down from green", "put red above green on the desk"),
            ("put red off", "put red on the desk"),
            ("put red down", "put red on the desk"),
            ("remove red from green", "put red above green on the desk"),
            ("remove red off green", "put red above green on the desk"),
            (
                "remove the red from green then put lego on small",
                "put the red above green on the desk then put lego on small",
            ),
            ("put red from green on lego", "put red above green on lego"),
            (
                "put red down then put lego on small",
                "put red on the desk then put lego on small",
            ),
            ("put down the red", "put the red on the desk"),
            (
                "put red off green then put lego on small",
                "put red above green on the desk then put lego on small",
            ),
            (
                "put lego on small then put red down",
                "put lego on small then put red on the desk",
            ),
            // All words are known: it is read so if nothing else makes sense.
            (
                "put red near green then put lego on small",
                "put red near green then put lego on small",
            ),
        ] {
            assert_eq!(
                parse(&model, sentence),
                parse(&model, read_as),
                "{sentence}"
            );
        }
    }

    #[test]
    fn elsewhere_the_words_are_unknown() {
        for sentence in [
            "put red on green off",
            "put off",
            // As in "get off the red block".
            "put off red",
            "put red down from",
            "put red down on green",
            "put red on green down",
            "off red on green",
            // Where to is not said.
            "put red from green",
            "remove red",
            "remove red from",
            // "The farthest red one from the green one".
            "put the perhaps red from green on small",
            // Whether on the table or on the small one.
            "remove red from green on small",
            "put the red then from green on small",
        ] {
            let refusal = parse(&fixture::with_table(), sentence).unwrap_err();
            assert!(
                matches!(refusal, Refusal::UnknownWord { .. }),
                "{sentence}: {refusal:?}"
            );
        }
    }

    #[test]
    fn objects_are_only_put_on_the_table_or_stand_on_it() {
        for sentence in [
            "put red right desk",
            "put desk on red",
            "put red on desk beside green",
            "put red beside desk on green",
            "put red above green beside desk on lego",
            "put red on green closest desk",
            "put red above desk on desk",
        ] {
            let refusal = parse(&fixture::with_table(), sentence).unwrap_err();
            assert!(
                matches!(refusal, Refusal::OnlyOnTable { .. }),
                "{sentence}: {refusal:?}"
            );
        }
        for sentence in ["put red on green desk", "put red on the rightmost desk"] {
            let refusal = parse(&fixture::with_table(), sentence).unwrap_err();
            assert_eq!(refusal.kind(), "conflicting_values", "{sentence}");
        }
    }
}
