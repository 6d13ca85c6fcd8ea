/// Words by which a speaker takes something back, or says what is not meant: "the red block, no, the green
/// one", "the red block instead of the green one". Nothing is learned for them. By default, there are none.
///
/// All texts are words in lower case with one space in between. They need not be among
/// [`Model::words`](super::Model::words), and mean this only where one of their words is not.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Repairs<'a> {
    /// What stands between a description and the one that is meant, "no"; sorted.
    pub corrections: &'a [&'a str],
    /// What stands between the description that is meant and another one, "instead of"; sorted.
    pub exclusions: &'a [&'a str],
}

impl Repairs<'_> {
    /// Whether nothing can be taken back.
    pub(crate) const fn is_empty(&self) -> bool {
        self.corrections.is_empty() && self.exclusions.is_empty()
    }
}
