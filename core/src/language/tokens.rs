use heapless::Vec;

use super::pronouns::pronoun;
use super::spelling::{Correction, KnownWord, alternatives};
use crate::capacity::{
    ARGUMENTS, MAX_CORRECTIONS, MAX_FILTERS, MAX_READINGS, MAX_SENTENCE_BYTES, MAX_TOKENS,
};
use crate::dsl::{Filters, Property};
use crate::model::{Model, WordEmbeddings};
use crate::refusal::Refusal;

/// A place in a sentence: bytes `start..end`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Span {
    /// First byte.
    pub start: u16,
    /// One after the last byte.
    pub end: u16,
}

impl Span {
    /// The part of `sentence`; `None` if the span is of another sentence and does not fit.
    pub fn of<'a>(&self, sentence: &'a str) -> Option<&'a str> {
        sentence.get(usize::from(self.start)..usize::from(self.end))
    }
}

/// The kind of a token.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum TokenKind {
    /// A word outside the lexicon: index into [`Model::words`].
    Word(u16),
    /// Adjacent words of the lexicon, `[[X]]` in the paper.
    Group(Filters),
    /// A pronoun that is read as a group: it stands for what the step before moved.
    Pronoun,
}

/// A token with its place in the sentence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Token {
    /// Its kind.
    pub kind: TokenKind,
    /// Its place.
    pub span: Span,
}

impl Token {
    /// Its embeddings; `None` only for a token of another model.
    pub fn embeddings<'a>(&self, model: &Model<'a>) -> Option<&'a WordEmbeddings> {
        match self.kind {
            TokenKind::Word(index) => model
                .words
                .get(usize::from(index))
                .map(|word| &word.embeddings),
            TokenKind::Group(_) | TokenKind::Pronoun => Some(model.group),
        }
    }

    /// Whether it describes an object: a group or a pronoun.
    pub const fn is_group(&self) -> bool {
        !matches!(self.kind, TokenKind::Word(_))
    }

    /// The concepts, if it is a group.
    pub const fn filters(&self) -> Option<&Filters> {
        match &self.kind {
            TokenKind::Word(_) | TokenKind::Pronoun => None,
            TokenKind::Group(filters) => Some(filters),
        }
    }
}

/// The unknown words of a sentence that were read as known ones.
pub type Corrections = Vec<Correction, MAX_CORRECTIONS, u8>;

/// The tokens of a sentence.
pub type Tokens = Vec<Token, MAX_TOKENS, u8>;

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
}

impl Reader {
    /// Starts at the beginning of `sentence`; refuses one that is too long for bounded work.
    pub fn new(sentence: &str) -> Result<Self, Refusal> {
        Self::nth(sentence, 0)
    }

    /// For another reading of the sentence, from 0 to before [`Reader::readings`].
    pub(super) fn nth(sentence: &str, reading: usize) -> Result<Self, Refusal> {
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
            choice: reading,
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
        }
    }

    /// Reads the next word of the sentence; false if none is left.
    ///
    /// Cost: one pass over the word and the white space before it, and one binary search in the
    /// lexicon and the words. For a word that is not found there, a few comparisons with each letter
    /// of each of the model's words.
    pub fn advance(&mut self, model: &Model<'_>, sentence: &str) -> Result<bool, Refusal> {
        let words = sentence.get(..self.end).unwrap_or_default();
        let Some((text, span)) = next_word(words, self.rest_from) else {
            return Ok(false);
        };
        self.rest_from = usize::from(span.end);
        let text = if text == ";" { "," } else { text };
        let property = find(model.lexicon, text, |entry| entry.text)
            .map(|(_, entry)| entry.property)
            .filter(|property| self.is_said(model, *property, text, words));
        if let Some(property) = property {
            self.add_property(model, property, span)?;
        } else if let Some(index) = self.plural(model, text).or_else(|| word(model, text)) {
            if !self.is_between(model, index) {
                self.add_word(model, words, index, span)?;
            }
        } else {
            match self.correct(model, text, span)? {
                KnownWord::Word(index) => self.add_word(model, words, index, span)?,
                KnownWord::Concept(index) => {
                    let entry = model.lexicon.get(usize::from(index));
                    let property = entry.ok_or(Refusal::InvalidModel)?.property;
                    self.add_property(model, property, span)?;
                }
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

    /// How many readings the sentence has so far: 1 without corrections and pronouns.
    pub(super) const fn readings(&self) -> usize {
        self.readings
    }

    /// Whether a word of the lexicon is meant as such: "all" in "all the red blocks", and not in "all
    /// right", if the model has it among its other words, too.
    fn is_said(&self, model: &Model<'_>, property: Property, text: &str, words: &str) -> bool {
        if !matches!(property, Property::Quantifier(_)) || word(model, text).is_none() {
            return true;
        }
        next_word(words, self.rest_from).is_some_and(|(next, _)| {
            let is_between = |index| model.several.between.contains(&index);
            find(model.lexicon, next, |entry| entry.text).is_some()
                || find(model.several.plurals, next, |plural| plural.text).is_some()
                || word(model, next).is_some_and(is_between)
        })
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

    /// What an unknown word is read as.
    fn correct(&mut self, model: &Model<'_>, text: &str, span: Span) -> Result<KnownWord, Refusal> {
        let unknown = Refusal::UnknownWord { span };
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
        if readings > MAX_READINGS {
            return None;
        }
        let chosen = self.choice.checked_rem(ways)?;
        self.choice = self.choice.checked_div(ways)?;
        self.readings = readings;
        Some(chosen)
    }

    /// A word outside the lexicon. A pronoun behind the descriptions of a whole step may mean what
    /// that one moved, unless another description follows ("that red block", "so that it is"), and as
    /// long as the sentence does not have too many readings.
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
            if described.count() >= ARGUMENTS && !follows && self.choose(2) == Some(1) {
                self.add(TokenKind::Pronoun, span)?;
                return pronoun
                    .owner
                    .map_or(Ok(()), |owner| self.add(TokenKind::Word(owner), span));
            }
        }
        self.add(TokenKind::Word(index), span)
    }

    /// A word of the lexicon joins the group before it or starts one. Values of one attribute
    /// exclude each other, so that no object has two; and so do extremes and quantifiers.
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
            if let Some(first) = conflicting(model, filters, property) {
                return Err(Refusal::ConflictingValues {
                    span: *group,
                    first,
                    second: property,
                });
            }
            return filters.add(property).map_err(|_| Refusal::TooManyConcepts {
                span: *group,
                limit: MAX_FILTERS as u8,
            });
        }
        self.is_several = is_quantifier;
        let mut filters = Filters::new();
        // Empty filters have room.
        let _ = filters.add(property);
        self.add(TokenKind::Group(filters), span)
    }

    fn add(&mut self, kind: TokenKind, span: Span) -> Result<(), Refusal> {
        self.tokens
            .push(Token { kind, span })
            .map_err(|_| Refusal::SentenceTooLong {
                limit: MAX_TOKENS as u16,
                unit: crate::refusal::LengthUnit::Tokens,
            })
    }
}

/// Whether a word may describe an object, by itself or with others.
fn may_describe(model: &Model<'_>, text: &str) -> bool {
    find(model.lexicon, text, |entry| entry.text).is_some()
        || word(model, text).is_some_and(|index| pronoun(model, index).is_some())
}

/// The index of a word outside the lexicon.
fn word(model: &Model<'_>, text: &str) -> Option<u16> {
    let (index, _) = find(model.words, text, |word| word.text)?;
    // There are no more than a u16 can count: the model was checked.
    u16::try_from(index).ok()
}

/// What a group says that excludes a further property.
fn conflicting(model: &Model<'_>, filters: &Filters, property: Property) -> Option<Property> {
    match property {
        Property::Concept(concept) => {
            let attribute_of = |concept: u8| {
                let found = model.concepts.get(usize::from(concept));
                found.map(|concept| concept.attribute)
            };
            let conflicts =
                |&other: &u8| other != concept && attribute_of(other) == attribute_of(concept);
            let mut concepts = filters.concepts().iter().copied();
            concepts.find(conflicts).map(Property::Concept)
        }
        Property::Extreme(_) | Property::Quantifier(_) => {
            filters.choice().filter(|other| *other != property)
        }
    }
}

const fn is_full_stop(c: char) -> bool {
    matches!(c, '.' | '!' | '?')
}

const fn is_mark(c: char) -> bool {
    is_full_stop(c) || matches!(c, ':' | '\'' | '’')
}

fn is_space(c: char) -> bool {
    c.is_whitespace() || matches!(c, '"' | '“' | '”' | '„')
}

const fn is_comma(c: char) -> bool {
    matches!(c, ',' | ';')
}

/// The first non-empty word at or after byte `from`, and its place.
fn next_word(sentence: &str, from: usize) -> Option<(&str, Span)> {
    let rest = sentence.get(from..)?;
    let word = rest.trim_start_matches(is_space);
    let start = from + (rest.len() - word.len());
    let first = word.chars().next()?;
    let length = if is_comma(first) || is_mark(first) {
        first.len_utf8()
    } else {
        let length = word
            .find(|c: char| is_space(c) || is_comma(c))
            .unwrap_or(word.len());
        word.get(..length)?.trim_end_matches(is_mark).len()
    };
    let span = Span {
        start: u16::try_from(start).ok()?,
        end: u16::try_from(start + length).ok()?,
    };
    Some((word.get(..length)?, span))
}

/// The letters of a word in lower case.
fn letters(word: &str) -> impl Iterator<Item = char> + '_ {
    let plain = |c| if c == '’' { '\'' } else { c };
    word.chars().map(plain).flat_map(char::to_lowercase)
}

/// The entry whose text is `word` in lower case, and its index.
fn find<'a, T>(entries: &'a [T], word: &str, text: fn(&T) -> &str) -> Option<(usize, &'a T)> {
    // In UTF-8, bytes are in the order of letters.
    let index = if word.is_ascii() {
        entries.binary_search_by(|entry| {
            let lower = word.bytes().map(|byte| byte.to_ascii_lowercase());
            text(entry).bytes().cmp(lower)
        })
    } else {
        entries.binary_search_by(|entry| text(entry).chars().cmp(letters(word)))
    };
    let index = index.ok()?;
    entries.get(index).map(|entry| (index, entry))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dsl::Extreme;

    fn words(sentence: &str) -> std::vec::Vec<&str> {
        let mut words = std::vec::Vec::new();
        let mut from = 0;
        while let Some((word, span)) = next_word(sentence, from) {
            assert_eq!(span.of(sentence), Some(word));
            assert!(usize::from(span.end) > from || from == 0);
            from = usize::from(span.end);
            words.push(word);
        }
        words
    }

    #[test]
    fn words_are_parted_at_white_space_commas_and_marks_at_their_ends() {
        assert_eq!(words("  put\tthe\u{a0}red "), ["put", "the", "red"]);
        assert_eq!(words("red,blue;then"), ["red", ",", "blue", ";", "then"]);
        assert_eq!(words("\"red\" “don't”."), ["red", "don't", "."]);
        assert_eq!(words("1. 'red' \""), ["1", ".", "'", "red", "'"]);
        assert_eq!(words("größe 1.5!?"), ["größe", "1.5", "!", "?"]);
        assert_eq!(words(" \n"), [""; 0]);
    }

    #[test]
    fn case_is_folded_letter_by_letter() {
        let known = ["don't", "kırmızı", "weiß", "λευκός"];
        for (word, expected) in [
            ("WEIß", Some(2)),
            ("WEIẞ", Some(2)),
            ("WEISS", None),
            ("KıRMıZı", Some(1)),
            ("KIRMIZI", None),
            ("KİRMİZİ", None),
            ("ΛΕΥΚΌς", Some(3)),
            ("ΛΕΥΚΌΣ", None),
            ("Don’t", Some(0)),
        ] {
            let found = find(&known, word, |text| text).map(|(index, _)| index);
            assert_eq!(found, expected, "{word}");
        }
    }

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
            TokenKind::Pronoun => "pronoun".into(),
        });
        let texts: std::vec::Vec<_> = texts.collect();
        assert_eq!(texts, ["5", "[3, 1]", "0", "[0]", "0", "7", "[2]"]);
        assert_eq!(tokens[1].span, Span { start: 4, end: 16 });
    }

    #[test]
    fn an_extreme_is_a_word_of_the_group_and_excludes_others() {
        let tokens = read("the topmost red , rightmost lego");
        let which = tokens.iter().filter_map(|token| token.filters()?.which());
        assert!(which.eq([Extreme::Action(0), Extreme::Action(1)]));
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
