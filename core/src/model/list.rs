/// How several objects are listed that are moved: "put the red and the blue block on the green one", "take the red and
/// the blue block and put them on it". Nothing is learned for them. By default, none can be listed.
///
/// The articles and nouns around them are those of [`Ordinals`](super::Ordinals), and plurals of nouns those of
/// [`Several`](super::Several).
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Lists<'a> {
    /// Words between two of them, with or without a comma before, "and": in lower case with one space in between;
    /// sorted.
    pub between: &'a [&'a str],
    /// What they are called where they were taken before, "them": words; sorted. Quantifiers may stand before, behind or in
    /// place of them, "both of them".
    pub them: &'a [&'a str],
    /// Words that put several objects on each other, "stack"; sorted. Near one of `aside`, "stack them left of it", they
    /// mean a tower there, which is no program.
    pub stacking: &'a [&'a str],
    /// Words for a place beside another object, "left"; sorted.
    pub aside: &'a [&'a str],
    /// What is read between two steps: ", then"; words of the model. Empty if no objects can be listed.
    pub next: &'a str,
}

impl Lists<'_> {
    /// Whether no objects can be listed.
    pub(crate) const fn is_empty(&self) -> bool {
        self.next.is_empty()
    }
}
