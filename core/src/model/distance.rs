/// How far from the reference an object is put, "two centimetres to the left of the blue block", or "5 cm from
/// it", or how far it is moved from where it is, "5 cm to the left": texts that say so. Nothing is learned for it. By default, no distance is understood.
///
/// All texts are words in lower case with one space in between. Those that are said need not be among
/// [`Model::words`](super::Model::words).
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Distances<'a> {
    /// The actions that put an object beside another one, to a single side: indices into
    /// [`Model::actions`](super::Model::actions).
    pub sides: &'a [u8],
    /// Units of length; sorted by text.
    pub units: &'a [DistanceUnit<'a>],
    /// Numbers in words, beside those in digits; sorted by text.
    pub numbers: &'a [DistanceNumber<'a>],
    /// What may stand before a distance and belongs to it, "at a distance of"; sorted.
    pub before: &'a [&'a str],
    /// What may stand behind it and belongs to it, "away"; sorted.
    pub behind: &'a [&'a str],
    /// What stands between a distance and the reference where no side is named, "away from"; sorted.
    pub from: &'a [&'a str],
    /// What is read in its place, "next to".
    pub beside: &'a str,
    /// Words before a distance with which it is the size of an object, "the" in "the 4 cm block"; sorted.
    pub unless: &'a [&'a str],
    /// Directions in which an object is moved by a distance from where it is, "to the left"; sorted by text. In
    /// place of one, and of the distance, the action's [`phrase`](super::Action::phrase) is read, and a group that
    /// means the object itself.
    pub shifts: &'a [DistanceShift<'a>],
    /// What may stand behind it and says nothing more, "from where it is"; sorted.
    pub origins: &'a [&'a str],
    /// The distance between the faces of an object and its reference in the demonstrations, millimetres: that at
    /// which the learned actions put an object.
    pub usual_mm: u16,
}

/// A unit of length.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct DistanceUnit<'a> {
    /// The word, "centimetres".
    pub text: &'a str,
    /// Its length in millimetres.
    pub mm: f32,
}

/// Words for a number.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct DistanceNumber<'a> {
    /// The words, "one and a half".
    pub text: &'a str,
    /// The number.
    pub value: f32,
}

/// A direction in which an object is moved.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct DistanceShift<'a> {
    /// The words, "to the left".
    pub text: &'a str,
    /// The action that puts things there: index into [`Model::actions`](super::Model::actions).
    pub action: u8,
}

impl Distances<'_> {
    /// Whether no distance is understood.
    pub(crate) const fn is_empty(&self) -> bool {
        self.units.is_empty()
    }
}
