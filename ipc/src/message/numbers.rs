//! Enumerated fields: names for the numbers that a field may hold. A message contains no enum,
//! since not every number would be valid.

/// One of the values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Member {
    /// Its name.
    pub name: &'static str,
    /// What it means, in Markdown.
    pub doc: &'static str,
    /// Its number in the field.
    pub number: u32,
}

/// The values of a field, for bindings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Numbers {
    /// The enum's name.
    pub name: &'static str,
    /// The message and its field.
    pub field: &'static str,
    /// All of them, in order.
    pub members: &'static [Member],
}

/// Defines an enum whose values a field holds as numbers: the enum, its conversion from a number,
/// and its description for bindings.
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

            /// The value with this number, if there is one.
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
