use super::Rephrasing;

/// What a sentence can do without, and phrases that are read in simpler words, once it is refused as it stands:
/// "um", "please", "here is what i want:". Nothing is learned for them. By default, a refused sentence is not read again.
///
/// In all three lists an empty text is read for what is left out.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Simplification<'a> {
    /// At the beginning of the sentence.
    pub opening: Rephrasing<'a>,
    /// At any place.
    pub anywhere: Rephrasing<'a>,
    /// At the end of the sentence.
    pub closing: Rephrasing<'a>,
    /// How an object is taken that is put somewhere.
    pub taking: Taking<'a>,
}

/// How something is said to be taken and put somewhere in fewer words than a command has: "take the red block and put on
/// the blue one", without "it", and "lift the red block onto the blue one", without "put". By default, neither is read.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Taking<'a> {
    /// Words that only take an object, "take" and "lift"; sorted.
    pub words: &'a [&'a str],
    /// Words that say where it is put, and never where it is, "onto"; sorted.
    pub towards: &'a [&'a str],
    /// What is read in place of the former before the latter: "put".
    pub order: &'a str,
    /// What is read where the object is not named again: "it".
    pub object: &'a str,
}

impl<'a> Simplification<'a> {
    /// Whether a refused sentence is not read again.
    pub(crate) const fn is_empty(&self) -> bool {
        self.opening.is_empty() && self.anywhere.is_empty() && self.closing.is_empty()
    }

    /// The three lists, as they stand here.
    pub(crate) const fn lists(&self) -> [&Rephrasing<'a>; 3] {
        [&self.opening, &self.anywhere, &self.closing]
    }
}
