//! The known word nearest to an unknown one.

use heapless::Vec;

use crate::model::Model;

/// Letters of the longest word that is compared.
const MAX_LETTERS: usize = 24;

pub(super) type Letters = Vec<char, MAX_LETTERS, u8>;
/// Distances between a prefix of one word and every prefix of another.
type Row = [u8; MAX_LETTERS + 1];

/// The word of the model that `word` is likely to be a misspelling of: the nearest concept word or,
/// where none is nearer, other word; of equally near ones the first. `None` if none is near: two
/// words are near if one letter omitted, added, changed or swapped with its neighbour turns one
/// into the other, or two such edits if both have more than five letters. Words of one or two
/// letters, and of more than 24, have no near word.
///
/// Cost: at most 24² steps for each word of the model, of a few comparisons each.
/// No allocation.
///
/// ```
/// use nsrm_core::language::nearest_word;
/// use nsrm_tabletop::TABLETOP;
///
/// assert_eq!(nearest_word(&TABLETOP, "yelow"), Some("yellow"));
/// assert_eq!(nearest_word(&TABLETOP, "purple"), None);
/// ```
pub fn nearest_word<'a>(model: &Model<'a>, word: &str) -> Option<&'a str> {
    let letters = letters(word)?;
    let concepts = model.lexicon.iter().map(|entry| entry.text);
    let others = model.words.iter().map(|word| word.text);
    let mut nearest = None;
    for text in concepts.chain(others) {
        let Some(known) = self::letters(text) else {
            continue;
        };
        if letters.len().abs_diff(known.len()) > MOST_EDITS {
            continue;
        }
        let edits = distance(&letters, &known);
        let is_nearer = nearest.is_none_or(|(least, _)| edits < least);
        if is_nearer && edits <= edits_allowed(letters.len().min(known.len())) {
            nearest = Some((edits, text));
        }
    }
    nearest.map(|(_, text)| text)
}

/// The most that [`edits_allowed`] gives.
const MOST_EDITS: usize = 2;

/// The greatest distance of near words, by the length of the shorter one.
const fn edits_allowed(letters: usize) -> u8 {
    match letters {
        0..=2 => 0,
        3..=5 => 1,
        _ => MOST_EDITS as u8,
    }
}

/// In lower case; `None` for a word that is too long.
pub(super) fn letters(word: &str) -> Option<Letters> {
    let mut letters = Letters::new();
    for letter in word.chars().flat_map(char::to_lowercase) {
        letters.push(letter).ok()?;
    }
    Some(letters)
}

/// Whether one letter omitted, added, changed or swapped with its neighbour turns one word into the
/// other, which is different.
pub(super) fn is_one_edit(left: &[char], right: &[char]) -> bool {
    let same = |(left, right): &(&char, &char)| left == right;
    let shorter = left.len().min(right.len());
    let before = left.iter().zip(right).take_while(same).count();
    let behind = left.iter().rev().zip(right.iter().rev());
    let behind = behind
        .take(shorter.saturating_sub(before))
        .take_while(same)
        .count();
    let rest = |word: &[char]| word.len().saturating_sub(before).saturating_sub(behind);
    match (rest(left), rest(right)) {
        (0 | 1, 1) | (1, 0) => true,
        (2, 2) => {
            let mut swapped = right.iter().skip(before).take(2).rev();
            left.iter()
                .skip(before)
                .take(2)
                .all(|letter| swapped.next() == Some(letter))
        }
        _ => false,
    }
}

/// The smallest number of letters omitted, added, changed or swapped with their neighbour, none
/// edited twice (optimal string alignment).
fn distance(left: &[char], right: &[char]) -> u8 {
    // `above[j]`: from the letters of `left` so far to the first j of `right`.
    let mut above: Row = core::array::from_fn(|column| column as u8);
    let mut before = above;
    let mut previous = None;
    for (&letter, row_number) in left.iter().zip(1..) {
        let mut row = [row_number; MAX_LETTERS + 1];
        for (column, &other) in right.iter().enumerate() {
            let changed = at(&above, column).saturating_add(u8::from(letter != other));
            let left_out = at(&above, column.saturating_add(1)).saturating_add(1);
            let added = at(&row, column).saturating_add(1);
            let mut least = changed.min(left_out).min(added);
            if let Some(behind) = column.checked_sub(1)
                && previous == Some(other)
                && right.get(behind) == Some(&letter)
            {
                least = least.min(at(&before, behind).saturating_add(1));
            }
            if let Some(place) = row.get_mut(column.saturating_add(1)) {
                *place = least;
            }
        }
        before = above;
        above = row;
        previous = Some(letter);
    }
    at(&above, right.len())
}

/// An entry; a missing one is far.
fn at(row: &Row, column: usize) -> u8 {
    row.get(column).copied().unwrap_or(u8::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture;

    fn between(left: &str, right: &str) -> u8 {
        distance(&letters(left).unwrap(), &letters(right).unwrap())
    }

    #[test]
    fn distances_by_hand() {
        for (left, right, edits) in [
            ("green", "green", 0),
            ("gren", "green", 1),
            ("greeen", "green", 1),
            ("grean", "green", 1),
            ("rgeen", "green", 1),
            ("geren", "green", 1),
            ("magneta", "magenta", 1),
            ("mganeta", "magenta", 2),
            ("ca", "abc", 3),
            ("abcd", "badc", 2),
            ("", "red", 3),
            ("red", "blue", 4),
            ("größe", "grösse", 2),
        ] {
            assert_eq!(between(left, right), edits, "{left} {right}");
            assert_eq!(between(right, left), edits, "{right} {left}");
            let [one, other] = [left, right].map(|word| letters(word).unwrap());
            assert_eq!(is_one_edit(&one, &other), edits == 1, "{left} {right}");
            assert_eq!(is_one_edit(&other, &one), edits == 1, "{right} {left}");
        }
        let longest = "x".repeat(MAX_LETTERS);
        assert_eq!(between(&longest, ""), MAX_LETTERS as u8);
        assert_eq!(between(&longest, &longest), 0);
    }

    #[test]
    fn the_nearest_word_is_offered_if_it_is_near() {
        let model = fixture::model();
        for (word, expected) in [
            ("gren", Some("green")),
            ("GREN", Some("green")),
            ("gerene", None),
            ("samll", Some("small")),
            ("lgo", Some("lego")),
            ("rad", Some("red")),
            ("rigth", Some("right")),
            ("thn", Some("the")),
            ("thenn", Some("then")),
            ("pur", Some("put")),
            ("on", Some("on")),
            ("in", None),
            ("sofa", None),
            (";", None),
            ("", None),
        ] {
            assert_eq!(nearest_word(&model, word), expected, "{word}");
        }
        assert_eq!(nearest_word(&model, &"red".repeat(1000)), None);
    }
}
