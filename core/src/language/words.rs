//! The words of a sentence, and how they are compared.

use crate::model::Model;

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

pub(super) const fn is_full_stop(c: char) -> bool {
    matches!(c, '.' | '!' | '?')
}

const fn is_mark(c: char) -> bool {
    is_full_stop(c) || matches!(c, ':' | '\'' | '’')
}

pub(super) fn is_space(c: char) -> bool {
    c.is_whitespace() || matches!(c, '"' | '“' | '”' | '„')
}

const fn is_comma(c: char) -> bool {
    matches!(c, ',' | ';')
}

/// The first non-empty word at or after byte `from`, and its place.
pub(super) fn next_word(sentence: &str, from: usize) -> Option<(&str, Span)> {
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
pub(super) fn letters(word: &str) -> impl Iterator<Item = char> + '_ {
    let plain = |c| if c == '’' { '\'' } else { c };
    word.chars().map(plain).flat_map(char::to_lowercase)
}

/// The entry whose text is `word` in lower case, and its index.
pub(super) fn find<'a, T>(
    entries: &'a [T],
    word: &str,
    text: fn(&T) -> &str,
) -> Option<(usize, &'a T)> {
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

/// The index of a word outside the lexicon.
pub(super) fn word(model: &Model<'_>, text: &str) -> Option<u16> {
    let (index, _) = find(model.words, text, |word| word.text)?;
    // There are no more than a u16 can count: the model was checked.
    u16::try_from(index).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
