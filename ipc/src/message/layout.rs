//! The memory layout of messages, which must be the same on both sides, and a type name that
//! ensures it.

/// A field of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Field {
    /// Its name.
    pub name: &'static str,
    /// What it means, in Markdown.
    pub doc: &'static str,
    /// Its type.
    pub element: Type,
    /// [`Element::KIND`] of its type.
    pub kind: u64,
    /// Bytes from the start of the message.
    pub offset: usize,
    /// Its size in bytes.
    pub size: usize,
}

/// The type of a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Type {
    /// `u8`
    U8,
    /// `u32`
    U32,
    /// `u64`
    U64,
    /// `f32`
    F32,
    /// An array of a type.
    Array(&'static Type, usize),
    /// A message, by its [`Message::NAME`].
    Message(&'static str),
}

/// The types that fields may have: integers, floats, arrays and messages, but no `bool`, `char` or
/// enum, for which not every byte is valid.
pub trait Element: Copy {
    /// For bindings.
    const TYPE: Type;
    /// Distinguishes element types.
    const KIND: u64;
}

impl Element for u8 {
    const TYPE: Type = Type::U8;
    const KIND: u64 = hash_bytes(START, b"u8");
}

impl Element for u32 {
    const TYPE: Type = Type::U32;
    const KIND: u64 = hash_bytes(START, b"u32");
}

impl Element for u64 {
    const TYPE: Type = Type::U64;
    const KIND: u64 = hash_bytes(START, b"u64");
}

impl Element for f32 {
    const TYPE: Type = Type::F32;
    const KIND: u64 = hash_bytes(START, b"f32");
}

impl<T: Element, const LENGTH: usize> Element for [T; LENGTH] {
    const TYPE: Type = Type::Array(&T::TYPE, LENGTH);
    const KIND: u64 = hash_number(T::KIND, LENGTH as u64);
}

/// A struct that crosses processes.
///
/// Implemented only by this crate's `message!`, which makes padding between or after the fields a
/// compile error.
pub trait Message: Copy {
    /// The struct's name.
    const NAME: &'static str;
    /// What the message is, in Markdown.
    const DOC: &'static str;
    /// What iceoryx2 compares: `nsrm.v<schema>.<name>.<hash>`, the hash being
    /// [`Message::LAYOUT_HASH`] in hexadecimal.
    const TYPE_NAME: &'static str;
    /// All fields, in memory order.
    const FIELDS: &'static [Field];
    /// Hash (FNV-1a) over name, kind, offset and size of each field, and over the
    /// message's size and alignment.
    const LAYOUT_HASH: u64 = hash_of::<Self>();
}

/// Offset basis of FNV-1a, 64 bits.
const START: u64 = 0xcbf2_9ce4_8422_2325;

const fn hash_bytes(mut hash: u64, bytes: &[u8]) -> u64 {
    let mut index = 0;
    while index < bytes.len() {
        hash = (hash ^ bytes[index] as u64).wrapping_mul(0x0100_0000_01b3);
        index += 1;
    }
    hash
}

const fn hash_number(hash: u64, number: u64) -> u64 {
    hash_bytes(hash, &number.to_le_bytes())
}

const fn hash_of<T: Message>() -> u64 {
    let mut hash = START;
    let mut index = 0;
    while index < T::FIELDS.len() {
        let field = &T::FIELDS[index];
        hash = hash_bytes(hash, field.name.as_bytes());
        hash = hash_number(hash, field.kind);
        hash = hash_number(hash, field.offset as u64);
        hash = hash_number(hash, field.size as u64);
        index += 1;
    }
    hash = hash_number(hash, size_of::<T>() as u64);
    hash_number(hash, align_of::<T>() as u64)
}

/// Whether the fields fill the message without gaps.
pub(crate) const fn has_padding<T: Message>() -> bool {
    let mut end = 0;
    let mut index = 0;
    while index < T::FIELDS.len() {
        if T::FIELDS[index].offset != end {
            return true;
        }
        end += T::FIELDS[index].size;
        index += 1;
    }
    end != size_of::<T>()
}

/// Defines a message: the struct with its type name for iceoryx2, its fields for the layout's table
/// and hash, and the proof that it has no padding. `ZeroCopySend` must be in scope with the feature
/// `processes`.
macro_rules! message {
    (
        $(#[doc = $doc:literal])*
        $(#[derive($($derive:ident),*)])?
        $type_name:literal
        $visibility:vis struct $name:ident {
            $($(#[doc = $field_doc:literal])* pub $field:ident: $type:ty,)*
        }
    ) => {
        $(#[doc = $doc])*
        $(#[derive($($derive),*)])?
        #[repr(C)]
        #[derive(Debug, Clone, Copy, PartialEq)]
        #[cfg_attr(
            feature = "processes",
            derive(ZeroCopySend),
            type_name($type_name)
        )]
        $visibility struct $name {
            $($(#[doc = $field_doc])* pub $field: $type,)*
        }

        impl $crate::message::layout::Message for $name {
            const NAME: &'static str = stringify!($name);
            const DOC: &'static str = concat!($($doc, "\n"),*);
            const TYPE_NAME: &'static str = $type_name;
            const FIELDS: &'static [$crate::message::layout::Field] = &[
                $($crate::message::layout::Field {
                    name: stringify!($field),
                    doc: concat!($($field_doc, "\n"),*),
                    element: <$type as $crate::message::layout::Element>::TYPE,
                    kind: <$type as $crate::message::layout::Element>::KIND,
                    offset: core::mem::offset_of!($name, $field),
                    size: size_of::<$type>(),
                },)*
            ];
        }

        impl $crate::message::layout::Element for $name {
            const TYPE: $crate::message::layout::Type =
                $crate::message::layout::Type::Message(stringify!($name));
            const KIND: u64 = <Self as $crate::message::layout::Message>::LAYOUT_HASH;
        }

        const _: () = assert!(
            !$crate::message::layout::has_padding::<$name>(),
            concat!(stringify!($name), " has padding: add a reserved field")
        );
    };
}

pub(crate) use message;

#[cfg(test)]
mod tests {
    use super::Message;
    #[cfg(feature = "processes")]
    use iceoryx2::prelude::ZeroCopySend;

    message! {
        "test.Pair"
        struct Pair {
            pub first: f32,
            pub second: u32,
        }
    }

    mod swapped {
        #[cfg(feature = "processes")]
        use iceoryx2::prelude::ZeroCopySend;

        message! {
            "test.Pair"
            pub(super) struct Pair {
                pub second: u32,
                pub first: f32,
            }
        }
    }

    mod other_kind {
        #[cfg(feature = "processes")]
        use iceoryx2::prelude::ZeroCopySend;

        message! {
            "test.Pair"
            pub(super) struct Pair {
                pub first: u32,
                pub second: u32,
            }
        }
    }

    mod grouped {
        #[cfg(feature = "processes")]
        use iceoryx2::prelude::ZeroCopySend;

        message! {
            "test.Outer"
            pub(super) struct Outer {
                pub pairs: [super::Pair; 2],
            }
        }
    }

    #[test]
    fn what_iceoryx2_does_not_notice_changes_the_hash() {
        assert_eq!(size_of::<Pair>(), size_of::<swapped::Pair>());
        assert_ne!(Pair::LAYOUT_HASH, swapped::Pair::LAYOUT_HASH);
        assert_ne!(Pair::LAYOUT_HASH, other_kind::Pair::LAYOUT_HASH);
        assert_eq!(grouped::Outer::FIELDS[0].size, 16);
    }
}
