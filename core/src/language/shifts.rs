//! How far an object is moved from where it is: "move the red block 5 cm to the left".
//!
//! The words are replaced by those that put an object beside another one, "to the left of", and a group that
//! means the object itself, so that the network reads "move the red block to the left of […]". The distance is
//! the step's ([`super::distances`]). Nothing is learned here.

use core::ops::Range;

use super::Token;
use super::phrases::PhraseMatcher;

/// A direction that stands with a distance.
pub(super) struct Shift {
    /// All their words.
    pub(super) words: Range<usize>,
    /// The action that puts things there.
    pub(super) action: u8,
}

impl PhraseMatcher<'_, '_> {
    /// The direction before or behind a distance with these words, if it is one from where the object is: that is
    /// the only one of its clause.
    pub(super) fn shift(&self, tokens: &[Token], distance: &Range<usize>) -> Option<Shift> {
        let distances = self.model.distances;
        let Range { mut start, mut end } = *distance;
        let action = match self.longest(tokens.get(end..)?, distances.shifts) {
            Some((length, shift)) => {
                end = end.checked_add(length)?;
                shift.action
            }
            None => {
                let before = tokens.get(..start)?;
                let said = distances.shifts.iter();
                let said =
                    said.filter_map(|shift| Some((self.ends_with(before, shift.text)?, shift)));
                let (length, shift) = said.max_by_key(|(length, _)| *length)?;
                start = start.checked_sub(length)?;
                shift.action
            }
        };
        let origin = self.longest::<&str>(tokens.get(end..)?, distances.origins);
        end = end.checked_add(origin.map_or(0, |(length, _)| length))?;
        // "To the left of" something.
        let goes_on = |token| !self.separates(token) && self.excludes_distance(token);
        let ends = !tokens.get(end).is_some_and(goes_on);
        let words = start..end;
        let is_only = self.moves_one(tokens, &words);
        (ends && is_only).then_some(Shift { words, action })
    }
}

#[cfg(test)]
mod tests {
    use crate::fixture;

    fn read(sentence: &str) -> std::string::String {
        fixture::read(&fixture::with_distances(), sentence)
    }

    #[test]
    fn an_object_is_moved_from_where_it_is() {
        for sentence in [
            "put red 2 cm right",
            "put red right 2 cm",
            "put red right by two cm",
            "put red right by about 2cm",
            "put red 2 cm to the right",
            "put red 2 cm to the right from there",
            "put red 2 cm away to the right",
        ] {
            let expected =
                "Action(MoveRight, Unique(Filter(red, Scene())), Itself(), Distance(0.020))";
            assert_eq!(read(sentence), expected, "{sentence}");
        }
        assert_eq!(
            read("put red on green then put lego 2 cm right then put small on red"),
            "Action(MoveOn, Unique(Filter(red, Scene())), Unique(Filter(green, Scene())))\n\
             Action(MoveRight, Unique(Filter(lego, Scene())), Itself(), Distance(0.020))\n\
             Action(MoveOn, Unique(Filter(small, Scene())), Unique(Filter(red, Scene())))"
        );
    }

    #[test]
    fn another_place_is_no_shift() {
        let beside = "Action(MoveRight, Unique(Filter(red, Scene())), Unique(Filter(green, Scene())), \
                      Distance(0.020))";
        assert_eq!(read("put red 2 cm right green"), beside);
        for sentence in [
            // Nothing is moved, or two objects.
            "put 2 cm right",
            "put red lego then green 2 cm right",
            // More is said of the place.
            "put red 2 cm right by green",
            "put red 2 cm right , green",
            "put red 2 cm right the green",
            "put red 2 cm from right",
            // No distance, or two.
            "put red right",
            "put red 2 cm right 2 cm",
            // Up, into the air.
            "put red 2 cm on",
        ] {
            let read = read(sentence);
            assert!(!read.contains("Itself"), "{sentence}: {read}");
        }
    }
}
