/// In which order two steps are carried out that are said in another one: "before you put …, put …". Nothing is
/// learned for it. By default, steps are carried out as they are said.
///
/// All texts are words in lower case with one space in between. Those that are said need not be among
/// [`Model::words`](super::Model::words).
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Sequence<'a> {
    /// What stands before the step that is carried out second, "before you"; sorted by text.
    pub later: &'a [SequenceText<'a>],
    /// What stands before the step that is carried out first, "after you"; sorted by text.
    pub earlier: &'a [SequenceText<'a>],
    /// The first word of each of these; sorted.
    pub first_words: &'a [&'a str],
    /// What is read between the two: ", then".
    pub next: &'a str,
}

/// Words before one of two steps.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct SequenceText<'a> {
    /// The words, "after putting".
    pub text: &'a str,
    /// What is read in their place, "put", or an empty text.
    pub read_as: &'a str,
    /// Whether the other step must stand before them, as for "but first".
    pub is_afterthought: bool,
}

impl Sequence<'_> {
    /// Whether steps are always carried out as they are said.
    pub(crate) const fn is_empty(&self) -> bool {
        self.later.is_empty() && self.earlier.is_empty()
    }
}
