/// How a person says whose left is meant: "from my point of view", which is how all is read, and "from the robot's point of
/// view", who looks the other way. Nothing is learned for them. By default, neither can be said.
///
/// All texts are words in lower case with one space in between. They need not be among [`Model::words`](super::Model::words).
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Perspectives<'a> {
    /// What means the person's own; sorted.
    pub own: &'a [&'a str],
    /// What means that of someone who looks the other way; sorted.
    pub other: &'a [&'a str],
    /// The first word of each of these; sorted.
    pub first_words: &'a [&'a str],
    /// For each action, the one in the opposite direction, itself if the direction is the same from both sides: indices
    /// into [`Model::actions`](super::Model::actions). Empty if no other viewpoint can be said.
    pub opposites: &'a [u8],
}

impl Perspectives<'_> {
    /// Whether no viewpoint can be said.
    pub(crate) const fn is_empty(&self) -> bool {
        self.own.is_empty() && self.other.is_empty()
    }
}
