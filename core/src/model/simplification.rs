use super::Rephrasing;

/// What a sentence can do without, and phrases that are read in simpler words, once it is refused as it stands:
/// "um", "please", "here is what i want:". Nothing is learned for them. By default, a refused sentence is not read again.
///
/// In all lists an empty text is read for what is left out.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Simplification<'a> {
    /// At the beginning of the sentence.
    pub opening: Rephrasing<'a>,
    /// At any place.
    pub anywhere: Rephrasing<'a>,
    /// At the end of the sentence.
    pub closing: Rephrasing<'a>,
    /// At the beginning of each further step: they only connect it to the one before, "and finally". All are left out.
    pub connecting: Rephrasing<'a>,
    /// Words by which a step is said to be the first, "first" and "begin"; sorted. Nothing is left out before one: of a
    /// further step, it makes no sense.
    pub starting: &'a [&'a str],
    /// How an object is taken that is put somewhere.
    pub taking: Taking<'a>,
    /// How an object is described by where it stands alone.
    pub standing: Standing<'a>,
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

/// How an object without attributes is said to stand somewhere: "the block left of the red one", "the one that is left of the
/// red one". All is read in the same words, which mark the relation as one of the description: "the thing standing left of
/// the red one". By default, as it stands.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Standing<'a> {
    /// What may stand between the noun and the relation, "that is"; sorted.
    pub clauses: &'a [&'a str],
    /// Words with which relations begin; sorted.
    pub relations: &'a [&'a str],
    /// What is read in place of noun and clause: "thing standing".
    pub read_as: &'a str,
}

impl<'a> Simplification<'a> {
    /// Whether a refused sentence is not read again.
    pub(crate) const fn is_empty(&self) -> bool {
        self.opening.is_empty()
            && self.anywhere.is_empty()
            && self.closing.is_empty()
            && self.connecting.is_empty()
    }

    /// The lists, as they stand here.
    pub(crate) const fn lists(&self) -> [&Rephrasing<'a>; 4] {
        [
            &self.opening,
            &self.anywhere,
            &self.closing,
            &self.connecting,
        ]
    }
}
