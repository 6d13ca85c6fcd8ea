//! Several objects that are moved one after the other: "put the red and the blue block on the green one", "take the
//! red and the blue block and put them on the green one".
//!
//! The words are replaced by those of a step for each object: "put the red on the green one, then put the blue block
//! on it". So each is moved in relation to the one before, as those of "all red blocks" are; to the table, each by itself.
//! Nothing is learned here: the model lists the words ([`crate::model::Lists`]).

use core::ops::Range;

use heapless::Vec;

use super::arrangements::is_several;
use super::phrases::PhraseMatcher;
use super::plurals::Number;
use super::pronouns::pronoun;
use super::tokens::{Kept, KeptKind, Tokens, push, span_of};
use super::{Token, TokenKind};
use crate::capacity::{ARGUMENTS, MAX_STEPS};
use crate::dsl::{Filters, Property, Quantifier};
use crate::model::Lists;
use crate::refusal::Refusal;

/// The places of the objects in a list.
type Items = Vec<Item, MAX_STEPS, u8>;

/// An object in a list.
#[derive(Clone, Copy)]
struct Item {
    /// Index of its article, or of its group if it has none.
    start: usize,
    /// Index of its group.
    group: usize,
    has_article: bool,
    /// Its noun.
    noun: Option<Number>,
}

impl Item {
    /// Index of the token behind it.
    fn end(&self) -> usize {
        self.group
            .saturating_add(1)
            .saturating_add(usize::from(self.noun.is_some()))
    }
}

/// A list among the tokens, and what is done with its objects.
pub(super) struct Listed {
    /// The verb, before the list or behind it.
    verb: Range<usize>,
    items: Items,
    /// What says where to, up to the reference.
    relation: Range<usize>,
    /// The reference, with what is said behind it.
    reference: Range<usize>,
    /// From the first token to behind the last.
    words: Range<usize>,
    /// Whether the reference is the table.
    is_on_table: bool,
}

impl Listed {
    /// Index of the token behind it.
    pub(super) const fn behind(&self) -> usize {
        self.words.end
    }
}

/// Two objects between which something is.
pub(super) struct Pair {
    /// Index of the group for the first one.
    pub(super) first: usize,
    /// The words for the second one, and those that join them.
    pub(super) second: Range<usize>,
    /// What the second one looks like.
    pub(super) kept: Kept,
}

impl PhraseMatcher<'_, '_> {
    /// The two objects that are described from a token on.
    pub(super) fn pair(&self, tokens: &[Token], from: usize) -> Option<Pair> {
        let items = self.listed(tokens, from, ARGUMENTS)?;
        let [first, second] = items.as_slice() else {
            return None;
        };
        let TokenKind::Group(filters) = tokens.get(second.group)?.kind else {
            return None;
        };
        let first_group = tokens.get(first.group)?;
        Some(Pair {
            first: first.group,
            second: first.end()..second.end(),
            kept: Kept {
                at: first_group.span.start,
                filters,
                kind: KeptKind::Second,
            },
        })
    }

    /// Whether there are as many descriptions as of two objects in a list, and of a reference.
    pub(super) fn may_list(&self, tokens: &[Token]) -> bool {
        let mut groups = tokens.iter().filter(|token| token.is_group());
        !self.model.lists.is_empty() && groups.nth(ARGUMENTS).is_some()
    }

    /// The words of a clause in which several objects are put on each other beside another one: "stack the red and the
    /// blue one left of the white one". What is read beside it would be a row.
    pub(super) fn stacked_aside(&self, tokens: &[Token]) -> Option<Range<usize>> {
        let Lists {
            stacking, aside, ..
        } = self.model.lists;
        let stacks = |at: &usize| {
            let token = tokens.get(*at);
            token.is_some_and(|token| self.is_one_of(stacking, token))
        };
        (0..tokens.len()).filter(stacks).find_map(|at| {
            let behind = at.checked_add(1)?;
            let clause = tokens.get(behind..)?;
            let end = clause.iter().position(|token| self.ends(token));
            let clause = clause.get(..end.unwrap_or(clause.len()))?;
            let is_several = clause.iter().any(is_several)
                || self.listed_before(clause).is_some()
                || self.list(tokens, at).is_some();
            let is_aside = clause.iter().any(|token| self.is_one_of(aside, token));
            let end = behind.checked_add(clause.len())?;
            (is_several && is_aside).then_some(at..end)
        })
    }

    /// The list whose verb is at a token.
    pub(super) fn list(&self, tokens: &[Token], at: usize) -> Option<Listed> {
        let behind = at.checked_add(1)?;
        let verb = tokens.get(at)?;
        if self.puts(verb) {
            let items = self.listed(tokens, behind, MAX_STEPS)?;
            let end = items.last()?.end();
            return self.moved(tokens, at..behind, items, at..end);
        }
        let taking = self.model.simplification.taking.words;
        if !self.is_one_of(taking, verb) {
            return None;
        }
        // "Pick up".
        let items = self
            .listed(tokens, behind, MAX_STEPS)
            .or_else(|| self.listed(tokens, behind.checked_add(1)?, MAX_STEPS))?;
        let end = items.last()?.end();
        let put = tokens
            .get(end..)?
            .iter()
            .position(|token| self.puts(token))?;
        let put = end.checked_add(put)?;
        let them = put.checked_add(1)?;
        let length = self.listed_before(tokens.get(them..)?)?;
        let joins = tokens.get(end..put)?;
        if joins.iter().any(|token| token.is_group()) {
            return None;
        }
        self.moved(tokens, put..them, items, at..them.checked_add(length)?)
    }

    /// Whether a token is a word that puts something somewhere.
    pub(super) fn puts(&self, token: &Token) -> bool {
        match token.kind {
            TokenKind::Word(word) => self.model.placing.binary_search(&word).is_ok(),
            _ => false,
        }
    }

    /// The objects that are listed from a token on: two or more, the last behind a word for "and". Each ends with its noun,
    /// or before the article of the next one; or all have one noun in the plural, or none: "the red and blue block" is no
    /// list.
    ///
    /// * `most`: how many are read
    fn listed(&self, tokens: &[Token], from: usize, most: usize) -> Option<Items> {
        let mut items = Items::new();
        // Whether what stands before the next one has more than a comma.
        let (mut at, mut joins, mut is_joined) = (from, false, false);
        while let Some(item) = self.item(tokens, at) {
            // More are too many steps.
            items.push(item).ok()?;
            is_joined = joins;
            let end = item.end();
            let behind_comma = self.behind_comma(tokens, end);
            let further = tokens.get(behind_comma..)?;
            let between = self.longest::<&str>(further, self.model.lists.between);
            let length = between.map_or(0, |(length, _)| length);
            at = behind_comma.checked_add(length)?;
            joins = length > 0;
            if at == end || items.len() == most {
                break;
            }
        }
        let (last, others) = items.split_last()?;
        let first = others.first().filter(|_| is_joined)?;
        if self.says_both(tokens, first) && items.len() != ARGUMENTS {
            return None;
        }
        let all = |is: fn(&Item) -> bool| items.iter().all(is);
        let is_single = all(|item| item.noun != Some(Number::Several));
        let values = |item: &Item| {
            let filters = tokens.get(item.group).and_then(Token::filters);
            filters.map_or(0, |filters| filters.concepts().len())
        };
        let says_as_much = items.iter().all(|item| values(item) == values(first));
        let ends = |before: &Item, behind: &Item| before.noun.is_some() || behind.has_article;
        let mut pairs = items.iter().zip(items.iter().skip(1));
        let is_list = if last.noun == Some(Number::Several) {
            says_as_much && others.iter().all(|item| item.noun.is_none())
        } else if all(|item| item.noun.is_none() && !item.has_article) {
            says_as_much && self.excludes(tokens, &items)
        } else {
            is_single && pairs.all(|(before, behind)| ends(before, behind))
        };
        is_list.then_some(items)
    }

    /// Whether an object is described as one of two: "both the red and the blue block".
    fn says_both(&self, tokens: &[Token], item: &Item) -> bool {
        let filters = tokens.get(item.group).and_then(Token::filters);
        filters.is_some_and(|filters| filters.quantifier() == Some(Quantifier::Both))
    }

    /// Whether no object can be what the first two of a list are.
    fn excludes(&self, tokens: &[Token], items: &[Item]) -> bool {
        let filters = |index: usize| {
            let item: &Item = items.get(index)?;
            tokens.get(item.group)?.filters()
        };
        let Some((first, second)) = filters(0).zip(filters(1)) else {
            return false;
        };
        let attribute = |concept: &u8| {
            let concept = self.model.concepts.get(usize::from(*concept));
            concept.map(|concept| concept.attribute)
        };
        let mut concepts = first.concepts().iter();
        concepts.any(|one| {
            let mut others = second.concepts().iter();
            others.any(|other| one != other && attribute(one) == attribute(other))
        })
    }

    /// The object that begins at a token.
    fn item(&self, tokens: &[Token], start: usize) -> Option<Item> {
        let articles = self.model.ordinals.articles;
        let mut has_article = self.is_one_of(articles, tokens.get(start)?);
        let group = start.checked_add(usize::from(has_article))?;
        let filters = tokens.get(group)?.filters()?;
        let says_something = match filters.choice() {
            None => !filters.concepts().is_empty(),
            Some(Property::Extreme(_) | Property::Ranked(_)) => true,
            // The article is a part of it: "both the red and the blue block".
            Some(Property::Quantifier(Quantifier::Both)) if !has_article => {
                has_article = true;
                !filters.concepts().is_empty()
            }
            _ => false,
        };
        let noun = tokens.get(group.checked_add(1)?);
        let noun = noun.and_then(|noun| self.number(noun));
        says_something.then_some(Item {
            start,
            group,
            has_article,
            noun,
        })
    }

    /// How many tokens stand for objects that were listed before: "them", "both", "them both" and "both of them".
    fn listed_before(&self, tokens: &[Token]) -> Option<usize> {
        let is_quantifier = |token: &Token| {
            let filters = token.filters();
            filters.is_some_and(|all| all.quantifier().is_some() && all.concepts().is_empty())
        };
        let is_them = |token: &Token| match token.kind {
            // The plural behind a quantifier is read as a singular.
            TokenKind::Word(word) => pronoun(self.model, word).is_some(),
            _ => self.is_one_of(self.model.lists.them, token),
        };
        let (first, behind) = tokens.split_first()?;
        let next = behind.first();
        let follows = if is_quantifier(first) {
            next.is_some_and(is_them)
        } else if self.is_one_of(self.model.lists.them, first) {
            next.is_some_and(is_quantifier)
        } else {
            return None;
        };
        Some(1_usize.saturating_add(usize::from(follows)))
    }

    /// A list of which is said where its objects are put.
    ///
    /// * `words`: from its first token to before what says where to
    fn moved(
        &self,
        tokens: &[Token],
        verb: Range<usize>,
        items: Items,
        words: Range<usize>,
    ) -> Option<Listed> {
        let from = words.end;
        let rest = tokens.get(from..)?;
        let describes = |token: &Token| token.is_group() || self.number(token).is_some();
        let described = from.checked_add(rest.iter().position(describes)?)?;
        let start = described.saturating_sub(usize::from(self.is_article(tokens, described)));
        let relation = tokens.get(from..start)?;
        if relation.is_empty() || relation.iter().any(|token| self.separates(token)) {
            return None;
        }
        let behind = tokens.get(described..)?;
        let end = behind.iter().position(|token| self.separates(token));
        let reference = behind.get(..end.unwrap_or(behind.len()))?;
        // With another description, nobody can tell where the last object is and where they are put.
        let mut groups = reference.iter().filter(|token| token.is_group());
        let group = groups.next().filter(|_| groups.next().is_none())?;
        let end = described.checked_add(reference.len())?;
        Some(Listed {
            verb,
            items,
            relation: from..start,
            reference: start..end,
            words: words.start..end,
            is_on_table: group.filters().is_some_and(Filters::is_table),
        })
    }

    /// Replaces the words of a list by those of its steps; the index of the token behind them.
    #[inline(never)]
    pub(super) fn write_list(&self, tokens: &mut Tokens, found: &Listed) -> Result<usize, Refusal> {
        let mut before = Tokens::new();
        // As many fit.
        let _ = before.extend_from_slice(tokens);
        tokens.truncate(found.words.start);
        let said = |range: &Range<usize>| before.get(range.clone()).unwrap_or_default();
        let span = span_of(said(&found.words)).ok_or(Refusal::InvalidModel)?;
        for (number, item) in found.items.iter().enumerate() {
            if number > 0 {
                self.write_words(self.model.lists.next, span, tokens)?;
            }
            let (verb, relation) = (said(&found.verb), said(&found.relation));
            for token in verb.iter().chain(said(&(item.start..item.group))) {
                push(tokens, token.kind, token.span)?;
            }
            let group = before.get(item.group).ok_or(Refusal::InvalidModel)?;
            push(tokens, single(group), group.span)?;
            if item.noun == Some(Number::One)
                && let Some(noun) = before.get(item.group.saturating_add(1))
            {
                push(tokens, noun.kind, noun.span)?;
            }
            for token in relation {
                push(tokens, token.kind, token.span)?;
            }
            let first = found
                .items
                .first()
                .filter(|_| number > 0 && !found.is_on_table);
            match first.and_then(|_| before.get(found.items.get(number.saturating_sub(1))?.group)) {
                // What the step before moved.
                Some(last) => push(tokens, TokenKind::Pronoun, last.span)?,
                None => {
                    for token in said(&found.reference) {
                        push(tokens, token.kind, token.span)?;
                    }
                }
            }
        }
        let behind = tokens.len();
        for token in said(&(found.words.end..before.len())) {
            push(tokens, token.kind, token.span)?;
        }
        Ok(behind)
    }
}

/// A group without "both", which says of a list that it has two.
pub(super) fn single(group: &Token) -> TokenKind {
    match group.filters() {
        Some(filters) if filters.quantifier().is_some() => {
            let mut single = Filters::new();
            for concept in filters.concepts() {
                // As many fit.
                let _ = single.add(Property::Concept(*concept));
            }
            TokenKind::Group(single)
        }
        _ => group.kind,
    }
}

#[cfg(test)]
mod tests {
    use std::string::String;

    use crate::fixture;
    use crate::model::{Lists, Model, Simplification, Taking};

    fn model() -> Model<'static> {
        let mut model = fixture::with_exceptions();
        let put = model.words.iter().position(|word| word.text == "put");
        let put = u16::try_from(put.unwrap()).unwrap();
        model.placing = std::boxed::Box::leak(std::boxed::Box::new([put]));
        let taking = Taking::new()
            .with_words(&["take"])
            .with_order("put")
            .with_object("the");
        model.simplification = Simplification::new().with_taking(taking);
        model.lists = Lists::new()
            .with_between(&["and", "as well as"])
            .with_them(&["them"])
            .with_stacking(&["put"])
            .with_aside(&["beside"])
            .with_next("then");
        assert_eq!(model.check(), Ok(()));
        model
    }

    fn read(sentence: &str) -> String {
        fixture::read(&model(), sentence)
    }

    #[test]
    fn each_object_is_put_in_relation_to_the_one_before() {
        let two = read("put the red on lego then put the green on red");
        assert!(two.starts_with("Action(MoveOn"), "{two}");
        for sentence in [
            "put the red and the green on lego",
            "put the red , and the green on lego",
            "put the red as well as the green on lego",
            "put red and green on lego",
            "put red near and green near on lego",
            "put the red and green nears on lego",
            "take the red and the green and put them on lego",
            "take the red and the green then put them on lego",
        ] {
            assert_eq!(read(sentence), two, "{sentence}");
        }
        assert_eq!(
            read("put the red and the small and the green right lego then put lego on red"),
            read(
                "put the red right lego then put the small right red then put the green right small then put lego on red"
            )
        );
        let to_table = read("put the red on the table then put the green on the table");
        assert_eq!(read("put the red and the green on the table"), to_table);
    }

    #[test]
    fn what_is_no_list_is_refused() {
        for sentence in [
            // Of two colours, or one of two blocks.
            "put the red and green on lego",
            "put the red and green near on lego",
            // No list ends without "and", and the first may be taken back.
            "put the red , the green on lego",
            "put the red and green near right small on lego",
            "put the red and the green near right the small near on lego",
            "put the red and the green right",
            "put the red and the green",
            // Nobody can tell whether both are small.
            "put the small red and green nears on lego",
            "take the red and the green on lego",
            "put the red nears and the green on lego",
            // A tower there.
            "put the red and the green beside lego",
            "put all red beside lego",
        ] {
            let kind = read(sentence);
            assert!(!kind.starts_with("Action"), "{sentence}: {kind}");
        }
    }
}
