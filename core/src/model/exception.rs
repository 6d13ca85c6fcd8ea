/// Words by which objects are left out of those that are described: "all blocks except the red one", "the block that is
/// not red". Nothing is learned for them. By default, there are none.
///
/// All texts are words in lower case with one space in between. They need not be among
/// [`Model::words`](super::Model::words), and mean this only where one of their words is not. What may stand around
/// the description behind them are the articles and nouns of [`Ordinals`](super::Ordinals), and plurals of nouns.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Exceptions<'a> {
    /// What stands before a description of objects that are left out, "except"; sorted.
    pub phrases: &'a [&'a str],
    /// What stands before values that an object does not have, "that is not"; sorted.
    pub negations: &'a [&'a str],
}

impl Exceptions<'_> {
    /// Whether nothing can be left out.
    pub(crate) const fn is_empty(&self) -> bool {
        self.phrases.is_empty() && self.negations.is_empty()
    }
}
