//! What the words of an answer choose.

use std::collections::BTreeSet;

use super::Choice;

/// Words that choose nothing: "the small one, please".
const FILLERS: [&str; 9] = [
    "a", "block", "i", "mean", "object", "one", "please", "that", "the",
];
/// Words that choose nothing either if no option has them: "the one on the left".
const LINKS: [&str; 8] = ["at", "in", "is", "of", "on", "side", "to", "which"];

/// Letters of the shortest words that stand for those that begin with them.
const LEAST_BEGINNING: usize = 3;

/// The words of an answer that may choose something, in lower case.
pub(super) fn words(answer: &str) -> BTreeSet<String> {
    let is_between = |c: char| c.is_whitespace() || matches!(c, '.' | ',' | '!' | '?' | '"');
    let lower = answer.to_lowercase();
    let words = lower.split(is_between);
    words
        .filter(|word| !word.is_empty() && !FILLERS.contains(word))
        .map(str::to_owned)
        .collect()
}

/// The only option that these words fit.
pub(super) fn chosen(mut said: BTreeSet<String>, options: &[Choice]) -> Option<&Choice> {
    let offered = options.iter().flat_map(|option| words(&option.answer));
    let offered: BTreeSet<String> = offered.collect();
    said.retain(|word| offered.contains(word) || !LINKS.contains(&word.as_str()));
    let mut fitting = options.iter().filter(|option| fits(&said, &option.answer));
    let option = fitting.next();
    option.filter(|_| fitting.next().is_none() && !said.is_empty())
}

/// Whether an option has these words. Those of an anchor count only together with the relation:
/// with "the red one to the left of the small one", "small" alone may mean another red one.
fn fits(said: &BTreeSet<String>, option: &str) -> bool {
    // As `by_place` writes it.
    let (own, relation) = option.split_once(" one ").unwrap_or((option, ""));
    let (phrase, _anchor) = relation.rsplit_once(" the ").unwrap_or_default();
    let is_by_place = !said.is_disjoint(&words(phrase)) && said.is_subset(&words(option));
    let own = words(own);
    said.iter().all(|word| is_said(word, &own)) || is_by_place
}

/// Whether a word stands among others, or begins one: "left" is said for "leftmost".
fn is_said(word: &str, words: &BTreeSet<String>) -> bool {
    words.contains(word)
        || words
            .iter()
            .any(|other| word.len() >= LEAST_BEGINNING && other.starts_with(word))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The place among these options that an answer chooses.
    fn place(answer: &str, options: &[&str]) -> Option<usize> {
        let choice = |answer: &&str| Choice {
            answer: (*answer).to_owned(),
            sentence: String::new(),
        };
        let options: Vec<Choice> = options.iter().map(choice).collect();
        let chosen = chosen(words(answer), &options)?;
        options.iter().position(|option| option == chosen)
    }

    #[test]
    fn words_of_an_anchor_choose_nothing_without_its_relation() {
        let options = [
            "the lego red one",
            "the red one to the left of the small blue one",
        ];
        for (answer, expected) in [
            ("the lego red one", Some(0)),
            ("the left one", Some(1)),
            ("left of the small one", Some(1)),
            ("the small one", None),
            ("blue", None),
            ("red", None),
            ("lego left", None),
        ] {
            assert_eq!(place(answer, &options), expected, "{answer}");
        }
    }

    #[test]
    fn an_extreme_is_chosen_by_its_beginning() {
        let options = ["the leftmost red one", "the topmost red one"];
        for (answer, expected) in [
            ("the left one", Some(0)),
            ("the one on the left side", Some(0)),
            ("topmost", Some(1)),
            ("to", None),
            ("red", None),
            ("leftmost top", None),
        ] {
            assert_eq!(place(answer, &options), expected, "{answer}");
        }
        let related = [
            "the leftmost red one",
            "the red one to the left of the blue one",
        ];
        assert_eq!(place("left", &related), None);
        assert_eq!(place("leftmost", &related), Some(0));
    }

    #[test]
    fn links_choose_only_what_has_them() {
        let (left, on) = (
            "the red one to the left of the blue one",
            "the red one on the green one",
        );
        assert_eq!(place("the one on the left side", &[left]), Some(0));
        assert_eq!(place("the one on the left", &[left, on]), None);
        assert_eq!(place("which is on the green one", &[left, on]), Some(1));
        assert_eq!(place("on", &[left, on]), Some(1));
        assert_eq!(place("at", &[left, on]), None);
        // A single known word is offered for an unknown one.
        assert_eq!(place("on", &["\"on\""]), Some(0));
    }
}
