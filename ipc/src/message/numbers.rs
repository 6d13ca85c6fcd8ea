//! Names for the numbers that a field may hold: a message holds no enum, since not every
//! number is one of its values.

/// One of the numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Member {
    /// Its name.
    pub name: &'static str,
    /// What it means, in Markdown.
    pub doc: &'static str,
    /// As it stands in the field.
    pub number: u32,
}

/// An enum whose values a field holds by their numbers.
///
/// Implemented by this crate's `numbers!` alone.
pub trait Numbers {
    /// The enum's name.
    const NAME: &'static str;
    /// The message and its field.
    const FIELD: &'static str;
    /// All of them, in the order of their numbers.
    const MEMBERS: &'static [Member];
}

/// Defines an enum whose values a field holds by their numbers: the enum, how it is got
/// from a number, and what bindings tell of it.
macro_rules! numbers {
    (
        $(#[doc = $doc:literal])*
        $field:literal
        pub enum $name:ident {
            $($(#[doc = $member_doc:literal])* $member:ident = $number:literal,)*
        }
    ) => {
        $(#[doc = $doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[repr(u32)]
        pub enum $name {
            $($(#[doc = $member_doc])* $member = $number,)*
        }

        impl $name {
            /// All of them, in the order of their numbers.
            pub const ALL: [Self; [$($number),*].len()] = [$(Self::$member),*];

            /// The one of this number, if there is one.
            pub const fn from_number(number: u32) -> Option<Self> {
                match number {
                    $($number => Some(Self::$member),)*
                    _ => None,
                }
            }
        }

        impl $crate::message::numbers::Numbers for $name {
            const NAME: &'static str = stringify!($name);
            const FIELD: &'static str = $field;
            const MEMBERS: &'static [$crate::message::numbers::Member] = &[
                $($crate::message::numbers::Member {
                    name: stringify!($member),
                    doc: concat!($($member_doc, "\n"),*),
                    number: $number,
                },)*
            ];
        }
    };
}

pub(crate) use numbers;
