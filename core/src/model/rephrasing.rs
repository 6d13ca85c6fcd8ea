/// Phrases that are read as others which mean the same: "so that it is" as "so that it's", of which the network
/// knows only one. Nothing is learned for them. By default, all words are read as they stand.
///
/// All texts are words in lower case with one space in between. Those that are said need not be among
/// [`Model::words`](super::Model::words).
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Rephrasing<'a> {
    /// What may be said; sorted by text.
    pub said: &'a [Rephrased<'a>],
    /// The first word of each; sorted.
    pub first_words: &'a [&'a str],
}

/// A phrase that is read as another one.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Rephrased<'a> {
    /// The words, "is supposed to be".
    pub text: &'a str,
    /// What is read in their place, "should be".
    pub read_as: &'a str,
}

impl Rephrasing<'_> {
    /// Whether all words are read as they stand.
    pub(crate) const fn is_empty(&self) -> bool {
        self.said.is_empty()
    }
}
