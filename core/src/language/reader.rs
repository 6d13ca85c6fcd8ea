//! From the words of a sentence to its tokens.

mod rewriting;

use heapless::Vec;
use rewriting::{Rewriting, Twofold};

use super::distances::Distance;
use super::phrases::PhraseMatcher;
use super::pronouns::pronoun;
use super::spelling::{KnownWord, alternatives};
use super::tokens::{Corrections, Kept, KeptKind, add_value, push};
use super::words::{find, is_full_stop, is_space, next_word, word};
use super::{Correction, Span, Token, TokenKind, Tokens};
use crate::capacity::{ARGUMENTS, MAX_READINGS, MAX_SENTENCE_BYTES, MAX_STEPS};
use crate::dsl::{Filters, Property};
use crate::model::Model;
use crate::refusal::Refusal;

/// One of the ways in which a sentence can be read.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Reading {
    /// Which of those that its words have, from 0 to before [`Reader::readings`].
    pub(super) number: usize,
    /// Whether it is read without what it can do without.
    pub(super) is_simplified: bool,
}

/// Reads a sentence word by word.
///
/// Words are separated by white space and compared in lower case, letter by letter
/// ([`char::to_lowercase`]), independent of context: `Σ` is `σ` also at the end of a word, and
/// `WEISS` is not `weiß`; the apostrophe `’` is read as `'`. Quotation marks (`" “ ” „`) are white
/// space. `,` is a separate word and `;` is read as `,`; each of the marks `. ! ? : '` at either end
/// of a word is a separate word, too, which most models do not know, except that `. ! ?` at the very
/// end of the sentence are dropped.
///
/// An unknown word that may stand for known ones ([`crate::model::Spelling`]) is read as the first
/// of them, and a pronoun ([`crate::model::Pronoun`]) as a word like any other; a sentence with such
/// words has several readings, of which this is one.
///
/// Behind a quantifier ([`crate::dsl::Quantifier`]), other words may be in the plural, and a few may
/// stand before the values ([`crate::model::Several`]): in "all of the red blocks", "all" and "red"
/// are one group, and "blocks" is read as "block". A quantifier that is also another word is one only
/// where it is followed so.
///
/// What says whose left is meant ([`crate::model::Perspectives`]) is left out, too.
/// A sentence that is refused as it stands is read once more without what it can do without
/// ([`crate::model::Simplification`]). Phrases are read as others that mean the same ([`crate::model::Rephrasing`]).
/// What is left out of a description ([`crate::model::Exceptions`]), "except the red one", is kept apart from the tokens.
/// A description that is taken back or ruled out ([`crate::model::Repairs`]), "the red block" in "the red block, no, the
/// green one", is left out. Two steps that are said in another order ([`crate::model::Sequence`]), "before you put …, put …",
/// are put in order. Values that stand apart ([`crate::model::Apart`]) are joined to one group, "the small block that is red"
/// to that of "the small red block"; what is counted from one side ([`crate::model::Ordinals`]), "the second red
/// block from the left", becomes a part of its group; the table ([`crate::model::Table`]) is named where it is meant, "take the
/// red block off the blue one"; the words of a tower or a row ([`crate::model::Arrangements`]) are replaced by those of its steps, and
/// those of a compound ([`crate::model::Compound`]) by those of its first action, and those of listed objects
/// ([`crate::model::Lists`]) by a step for each; and those of a distance
/// ([`crate::model::Distances`]) are left out, once the whole sentence is read. Where they may mean something else, the
/// sentence has two readings.
///
/// It does not keep the sentence, so that a task can own both: pass the same sentence to every
/// call.
///
/// ```
/// use nsrm_core::language::Reader;
/// use nsrm_tabletop::TABLETOP;
///
/// let sentence = "Put the small red block on the blue one.";
/// let mut reader = Reader::new(sentence)?;
/// while reader.advance(&TABLETOP, sentence)? {}
/// // "small red" is one token, a description.
/// let texts: Vec<_> = reader.tokens().iter().map(|token| token.span.of(sentence)).collect();
/// assert_eq!(texts[..3], [Some("Put"), Some("the"), Some("small red")]);
/// # Ok::<(), nsrm_core::Refusal>(())
/// ```
#[derive(Debug, Clone)]
pub struct Reader {
    rest_from: usize,
    /// Behind the last word.
    end: usize,
    tokens: Tokens,
    /// Whether the last group means several objects.
    is_several: bool,
    corrections: Corrections,
    /// Chooses how each of the further words is read that has several readings: the number of the
    /// reading, divided by the numbers of choices so far.
    choice: usize,
    /// How many readings the sentence has so far.
    readings: usize,
    /// Whether it is read without what it can do without.
    simplifies: bool,
    /// Whether words were left out without which the sentence says the same, or read in simpler ones.
    is_simpler: bool,
    /// Whether it is said from the point of view opposite to the person's, if it says from which.
    is_opposite: Option<bool>,
    /// What was left out of descriptions, and the second ones of what is between two.
    kept: Vec<Kept, MAX_STEPS, u8>,
    /// The distances that were left out of the tokens.
    distances: Vec<Distance, MAX_STEPS, u8>,
    /// What has been done of rewriting the tokens.
    rewriting: Rewriting,
    /// Whether known words of each kind are rewritten in this reading, as far as that is chosen.
    chosen: [Option<bool>; Twofold::COUNT],
}

impl Reader {
    /// Starts at the beginning of `sentence`; refuses one that is too long for bounded work.
    pub fn new(sentence: &str) -> Result<Self, Refusal> {
        Self::nth(sentence, Reading::default())
    }

    /// For another reading of the sentence.
    pub(super) fn nth(sentence: &str, reading: Reading) -> Result<Self, Refusal> {
        if sentence.len() > MAX_SENTENCE_BYTES {
            return Err(Refusal::SentenceTooLong {
                limit: MAX_SENTENCE_BYTES as u16,
                unit: crate::refusal::LengthUnit::Bytes,
            });
        }
        Ok(Self {
            rest_from: 0,
            end: sentence
                .trim_end_matches(|c: char| is_space(c) || is_full_stop(c))
                .len(),
            choice: reading.number,
            simplifies: reading.is_simplified,
            ..Self::empty()
        })
    }

    /// On a sentence without words.
    pub(super) const fn empty() -> Self {
        Self {
            rest_from: 0,
            end: 0,
            tokens: Tokens::new(),
            is_several: false,
            corrections: Corrections::new(),
            choice: 0,
            readings: 1,
            simplifies: false,
            is_simpler: false,
            is_opposite: None,
            kept: Vec::new(),
            distances: Vec::new(),
            rewriting: Rewriting::Perspectives { from: 0 },
            chosen: [None; Twofold::COUNT],
        }
    }

    /// Reads the next word of the sentence, or then does a piece of rewriting; false if nothing is left.
    ///
    /// Cost: one pass over the word and the white space before it, and one binary search in the
    /// lexicon and the words. For a word that is not found there, a few comparisons with each letter
    /// of each of the model's words.
    pub fn advance(&mut self, model: &Model<'_>, sentence: &str) -> Result<bool, Refusal> {
        match self.read_word(model, sentence) {
            Ok(false) => self.rewrite(model, sentence),
            Ok(true) => Ok(true),
            Err(refusal) => Err(self.unknown().unwrap_or(refusal)),
        }
    }

    fn read_word(&mut self, model: &Model<'_>, sentence: &str) -> Result<bool, Refusal> {
        let words = sentence.get(..self.end).unwrap_or_default();
        let Some((text, span)) = next_word(words, self.rest_from) else {
            return Ok(false);
        };
        self.rest_from = usize::from(span.end);
        let text = if text == ";" { "," } else { text };
        let named = find(model.lexicon, text, |entry| entry.text);
        let property = named
            .map(|(_, entry)| entry.property)
            .filter(|property| self.is_said(model, *property, text, words));
        if let Some(property) = property {
            self.add_property(model, property, span)?;
        } else if let Some(index) = self.plural(model, text).or_else(|| word(model, text)) {
            if !self.is_between(model, index) {
                self.add_word(model, words, index, span)?;
            }
        } else if named.is_some() {
            // A number, and not how many objects are meant.
            self.add(TokenKind::Unknown, span)?;
        } else {
            match self.correct(model, text, span) {
                Ok(KnownWord::Word(index)) => self.add_word(model, words, index, span)?,
                Ok(KnownWord::Concept(index)) => {
                    let entry = model.lexicon.get(usize::from(index));
                    let property = entry.ok_or(Refusal::InvalidModel)?.property;
                    self.add_property(model, property, span)?;
                }
                Err(unknown) if model.has_no_rewriting() => return Err(unknown),
                Err(_) => self.add(TokenKind::Unknown, span)?,
            }
        }
        Ok(true)
    }

    /// The tokens read so far.
    pub fn tokens(&self) -> &[Token] {
        &self.tokens
    }

    /// The unknown words so far that were read as known ones.
    pub fn corrections(&self) -> &[Correction] {
        &self.corrections
    }

    /// What was left out of descriptions, or the second ones of what is between two.
    pub(super) fn kept(&self, kind: KeptKind) -> impl Iterator<Item = &Kept> + Clone {
        self.kept.iter().filter(move |kept| kept.kind == kind)
    }

    /// The distances that were left out of the tokens.
    pub(super) fn distances(&self) -> &[Distance] {
        &self.distances
    }

    /// Whether directions are those of someone who looks the other way.
    pub(super) fn is_opposite(&self) -> bool {
        self.is_opposite == Some(true)
    }

    /// How many readings the sentence has so far, as it stands or simplified: 1 without corrections and pronouns.
    pub(super) const fn readings(&self) -> usize {
        self.readings
    }

    /// Whether a word of the lexicon is meant as such: "all" in "all the red blocks", and not in "all
    /// right", if the model has it among its other words, too; and "two" in "the two red blocks", and not in "two blocks
    /// to the left".
    fn is_said(&self, model: &Model<'_>, property: Property, text: &str, words: &str) -> bool {
        let is_number = is_number(model, text);
        let is_other = is_number || word(model, text).is_some();
        if !matches!(property, Property::Quantifier(_)) || !is_other {
            return true;
        }
        let follows_article = || {
            let last = self.tokens.last();
            last.is_some_and(|token| is_article(model, token))
        };
        if (is_number && !follows_article()) || self.says_first_of(model) {
            return false;
        }
        next_word(words, self.rest_from).is_some_and(|(next, _)| {
            let is_between = |index| model.several.between.contains(&index);
            find(model.lexicon, next, |entry| entry.text).is_some()
                || find(model.several.plurals, next, |plural| plural.text).is_some()
                || word(model, next).is_some_and(is_between)
        })
    }

    /// Whether the last words are those before "all" in "first of all".
    fn says_first_of(&self, model: &Model<'_>) -> bool {
        let [.., first, of] = self.tokens.as_slice() else {
            return false;
        };
        let (TokenKind::Word(first), TokenKind::Word(of)) = (first.kind, of.kind) else {
            return false;
        };
        let first = model.words.get(usize::from(first));
        let mut counts = model.ordinals.counts.iter();
        let mut is_first = |text| counts.any(|count| count.rank == 1 && count.text == text);
        model.several.between.contains(&of) && first.is_some_and(|word| is_first(word.text))
    }

    /// Whether a word only stands between a quantifier and what it is about: "of" and "the" in "all of
    /// the red blocks".
    fn is_between(&self, model: &Model<'_>, index: u16) -> bool {
        let last = self.tokens.last().and_then(Token::filters);
        let is_open = |group: &Filters| group.quantifier().is_some() && group.concepts().is_empty();
        last.is_some_and(is_open) && model.several.between.contains(&index)
    }

    /// The word of which another one is the plural, if the last group means several objects.
    fn plural(&self, model: &Model<'_>, text: &str) -> Option<u16> {
        if !self.is_several {
            return None;
        }
        let plural = find(model.several.plurals, text, |plural| plural.text);
        plural.map(|(_, plural)| plural.word)
    }

    /// What an unknown word is read as; a plural is not misspelt.
    fn correct(&mut self, model: &Model<'_>, text: &str, span: Span) -> Result<KnownWord, Refusal> {
        let unknown = Refusal::UnknownWord { span };
        if find(model.several.plurals, text, |plural| plural.text).is_some() {
            return Err(unknown);
        }
        let alternatives = alternatives(model, text);
        let chosen = self.choose(alternatives.len()).ok_or(unknown)?;
        let word = *alternatives.get(chosen).ok_or(unknown)?;
        let correction = Correction::new(span, word);
        if self.corrections.push(correction).is_err() {
            return Err(unknown);
        }
        Ok(word)
    }

    /// How this reading reads a word that can be read in so many ways; `None` if there is no way, or
    /// the sentence then has too many readings.
    fn choose(&mut self, ways: usize) -> Option<usize> {
        let readings = self.readings.saturating_mul(ways);
        if readings > self.most_readings() {
            return None;
        }
        let chosen = self.choice.checked_rem(ways)?;
        self.choice = self.choice.checked_div(ways)?;
        self.readings = readings;
        Some(chosen)
    }

    /// How many readings the sentence may have: so many that there is room for both those of the sentence as it
    /// stands and those of a simplified one.
    const fn most_readings(&self) -> usize {
        match self.is_simpler {
            true => MAX_READINGS / 2,
            false => MAX_READINGS,
        }
    }

    /// A word outside the lexicon. A pronoun behind the descriptions of a whole step may mean what
    /// that one moved, unless another description follows ("that red block") or a conjunction stands before it ("so that
    /// it is"), and as long as the sentence does not have too many readings. It means that, if both that step and the pronoun's begin
    /// with words that put something, and it is no article: "put the red block on the blue one, then put it …".
    ///
    /// * `words`: the sentence up to its last word
    fn add_word(
        &mut self,
        model: &Model<'_>,
        words: &str,
        index: u16,
        span: Span,
    ) -> Result<(), Refusal> {
        if let Some(pronoun) = pronoun(model, index) {
            let described = self.tokens.iter().filter(|token| token.is_group());
            let follows =
                next_word(words, self.rest_from).is_some_and(|(next, _)| may_describe(model, next));
            let may_be_moved = described.count() >= ARGUMENTS
                && !follows
                && !self.follows_conjunction(model, words);
            // "That" may stand before a noun.
            let kind = TokenKind::Word(index);
            let is_article = is_article(model, &Token { kind, span });
            let is_moved = may_be_moved && !is_article && self.puts_again(model);
            if is_moved || (may_be_moved && self.choose(2) == Some(1)) {
                self.add(TokenKind::Pronoun, span)?;
                return pronoun
                    .owner
                    .map_or(Ok(()), |owner| self.add(TokenKind::Word(owner), span));
            }
        }
        self.add(TokenKind::Word(index), span)
    }

    /// Whether a pronoun behind the last word is a word like any other.
    fn follows_conjunction(&self, model: &Model<'_>, sentence: &str) -> bool {
        let said = PhraseMatcher { model, sentence };
        let mut conjunctions = model.conjunctions.iter();
        conjunctions.any(|text| said.ends_with(&self.tokens, text).is_some())
    }

    /// Whether the last word puts something, and so does one before the last two descriptions, between which no clause
    /// ends.
    fn puts_again(&self, model: &Model<'_>) -> bool {
        let puts = |word: u16| model.placing.binary_search(&word).is_ok();
        let mut kinds = self.tokens.iter().rev().map(|token| token.kind);
        if !matches!(kinds.next(), Some(TokenKind::Word(word)) if puts(word)) {
            return false;
        }
        let mut described = 0;
        for kind in kinds {
            match kind {
                TokenKind::Word(word) if described == 1 && ends_clause(model, word) => {
                    return false;
                }
                TokenKind::Word(word) if described == ARGUMENTS && puts(word) => return true,
                TokenKind::Group(_) | TokenKind::Pronoun => described += 1,
                _ => {}
            }
        }
        false
    }

    /// A word of the lexicon joins the group before it or starts one.
    fn add_property(
        &mut self,
        model: &Model<'_>,
        property: Property,
        span: Span,
    ) -> Result<(), Refusal> {
        let is_quantifier = matches!(property, Property::Quantifier(_));
        if let Some(Token {
            kind: TokenKind::Group(filters),
            span: group,
        }) = self.tokens.last_mut()
        {
            self.is_several |= is_quantifier;
            group.end = span.end;
            return add_value(model, filters, property, *group);
        }
        self.is_several = is_quantifier;
        let mut filters = Filters::new();
        // Empty filters have room.
        let _ = filters.add(property);
        self.add(TokenKind::Group(filters), span)
    }

    fn add(&mut self, kind: TokenKind, span: Span) -> Result<(), Refusal> {
        push(&mut self.tokens, kind, span)
    }

    /// Refuses the first unknown word.
    fn unknown(&self) -> Option<Refusal> {
        let mut tokens = self.tokens.iter();
        let token = tokens.find(|token| token.kind == TokenKind::Unknown)?;
        Some(Refusal::UnknownWord { span: token.span })
    }
}

/// Whether a word is a number of a distance.
fn is_number(model: &Model<'_>, text: &str) -> bool {
    find(model.distances.numbers, text, |number| number.text).is_some()
}

/// Whether a token is an article.
fn is_article(model: &Model<'_>, token: &Token) -> bool {
    let TokenKind::Word(index) = token.kind else {
        return false;
    };
    let word = model.words.get(usize::from(index));
    word.is_some_and(|word| model.ordinals.articles.contains(&word.text))
}

/// Whether a clause ends before a word, a verb for instance.
fn ends_clause(model: &Model<'_>, word: u16) -> bool {
    let word = model.words.get(usize::from(word));
    word.is_some_and(|word| find(model.arrangements.ends, word.text, |text| text).is_some())
}

/// Whether a word may describe an object, by itself or with others.
fn may_describe(model: &Model<'_>, text: &str) -> bool {
    // "It two …" is "it" and a distance.
    let is_named =
        find(model.lexicon, text, |entry| entry.text).is_some() && !is_number(model, text);
    is_named || word(model, text).is_some_and(|index| pronoun(model, index).is_some())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capacity::MAX_TOKENS;
    use crate::dsl::Extreme;

    fn read(sentence: &str) -> std::vec::Vec<Token> {
        let model = crate::fixture::model();
        let mut reader = Reader::new(sentence).unwrap();
        while reader.advance(&model, sentence).unwrap() {}
        reader.tokens().to_vec()
    }

    #[test]
    fn concept_words_next_to_each_other_become_one_group() {
        let tokens = read("PUT small  Green,red; the lego!");
        let texts = tokens.iter().map(|token| match &token.kind {
            TokenKind::Word(index) => std::format!("{index}"),
            TokenKind::Group(filters) => std::format!("{:?}", filters.concepts()),
            other => std::format!("{other:?}"),
        });
        let texts: std::vec::Vec<_> = texts.collect();
        assert_eq!(texts, ["5", "[3, 1]", "0", "[0]", "0", "7", "[2]"]);
        assert_eq!(tokens[1].span, Span { start: 4, end: 16 });
    }

    #[test]
    fn an_extreme_is_a_word_of_the_group_and_excludes_others() {
        let tokens = read("the topmost red , rightmost lego");
        let which = tokens.iter().filter_map(|token| token.filters()?.choice());
        assert!(which.eq([Extreme::Action(0), Extreme::Action(1)].map(Property::Extreme)));
        assert_eq!(read("red topmost small topmost").len(), 1);
        let model = crate::fixture::model();
        let sentence = "the topmost red rightmost";
        let mut reader = Reader::new(sentence).unwrap();
        let refusal = loop {
            match reader.advance(&model, sentence) {
                Ok(true) => {}
                other => break other.unwrap_err(),
            }
        };
        assert_eq!(
            refusal,
            Refusal::ConflictingValues {
                span: Span { start: 4, end: 25 },
                first: Property::Extreme(Extreme::Action(0)),
                second: Property::Extreme(Extreme::Action(1)),
            }
        );
    }

    #[test]
    fn the_most_tokens_are_read_and_one_more_refused() {
        let model = crate::fixture::model();
        let sentence = "the red ".repeat(MAX_TOKENS / 2);
        assert_eq!(read(&sentence).len(), MAX_TOKENS);
        let longer = sentence + "the";
        let mut reader = Reader::new(&longer).unwrap();
        let refusal = loop {
            match reader.advance(&model, &longer) {
                Ok(true) => {}
                other => break other,
            }
        };
        assert!(matches!(refusal, Err(Refusal::SentenceTooLong { .. })));
    }
}
