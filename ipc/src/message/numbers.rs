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

/// The numbers of a field, as bindings tell of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Numbers {
    /// The enum's name.
    pub name: &'static str,
    /// The message and its field.
    pub field: &'static str,
    /// All of them, in their order.
    pub members: &'static [Member],
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

            /// Their names and what they mean.
            pub const NUMBERS: $crate::message::Numbers = $crate::message::Numbers {
                name: stringify!($name),
                field: $field,
                members: &[
                    $($crate::message::Member {
                        name: stringify!($member),
                        doc: concat!($($member_doc, "\n"),*),
                        number: $number,
                    },)*
                ],
            };

            /// The one of this number, if there is one.
            pub const fn from_number(number: u32) -> Option<Self> {
                match number {
                    $($number => Some(Self::$member),)*
                    _ => None,
                }
            }
        }
    };
}

pub(crate) use numbers;
