use super::Model;

/// Actions by which a free place on the table is sought.
pub const MAX_SIDES: usize = 8;

/// The table as a place, which [`Property::Table`](crate::dsl::Property::Table) of the lexicon names: "put
/// the red block on the table", "take it off the blue one", "put it down". By default, nothing can be put
/// there.
///
/// All texts are words in lower case with one space in between. What is read in place of others is among
/// [`Model::words`]; the others need not be.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Table<'a> {
    /// The action that is said of it, `MoveOn`: index into [`Model::actions`].
    pub action: u8,
    /// The actions that put an object on the table beside another one, at most
    /// [`MAX_SIDES`]: a free place is sought by them.
    pub sides: &'a [u8],
    /// What stands between an object and the one that it is taken off, "off" or "down from"; sorted.
    pub off: &'a [&'a str],
    /// What may stand there, too, and also says other things, "from": it is read so where something is removed,
    /// or where another place follows; sorted.
    pub sources: &'a [&'a str],
    /// Words before these in a clause with which they say other things: "farthest"; sorted.
    pub unless: &'a [&'a str],
    /// Words for taking an object off another one, which say that it is put on the table: "remove"; sorted.
    pub removing: &'a [&'a str],
    /// What is read in their place: "take".
    pub taking: &'a str,
    /// What is read instead of what stands between an object and the one that it is taken off: "that is on".
    pub standing: &'a str,
    /// What is then read before the table, if nothing else says where to: "and put it on the".
    pub order: &'a str,
    /// What means the table if nothing else says where to, "down"; sorted.
    pub down: &'a [&'a str],
    /// What is then read before the table: "on the".
    pub relation: &'a str,
}

impl Table<'_> {
    /// Whether anything can be put there.
    pub(crate) const fn is_place(&self) -> bool {
        !self.sides.is_empty()
    }
}

impl Model<'_> {
    /// The height of an object's centre below which it stands on the table, metres: halfway between that of
    /// the highest object there, and that of the lowest one on another like it. `None` if these two may
    /// be mistaken for each other.
    pub(crate) fn on_table_below_m(&self) -> Option<f32> {
        let (mut lowest_m, mut highest_m) = (f32::INFINITY, 0.0_f32);
        for [_, _, height_m] in self.concepts.iter().filter_map(|concept| concept.edges_m) {
            (lowest_m, highest_m) = (lowest_m.min(height_m), highest_m.max(height_m));
        }
        let (on_table_m, on_another_m) = (0.5 * highest_m, 1.5 * lowest_m);
        (on_table_m < on_another_m).then_some(0.5 * (on_table_m + on_another_m))
    }
}
