//! What of a message must be the same on both sides, and a name that says so.

/// A field of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Field {
    /// Its name.
    pub name: &'static str,
    /// Its type as written in the source, for people.
    pub written_type: &'static str,
    /// [`Element::KIND`] of its type.
    pub kind: u64,
    /// Bytes from the start of the message.
    pub offset: usize,
    /// Its size in bytes.
    pub size: usize,
}

/// What a message may be made of: integers, floats, arrays and messages, but no
/// `bool`, `char` or enum, since not every byte is a valid one of those.
pub trait Element: Copy {
    /// Tells element types apart.
    const KIND: u64;
}

impl Element for u8 {
    const KIND: u64 = hash_bytes(START, b"u8");
}

impl Element for u32 {
    const KIND: u64 = hash_bytes(START, b"u32");
}

impl Element for u64 {
    const KIND: u64 = hash_bytes(START, b"u64");
}

impl Element for f32 {
    const KIND: u64 = hash_bytes(START, b"f32");
}

impl<T: Element, const LENGTH: usize> Element for [T; LENGTH] {
    const KIND: u64 = hash_number(T::KIND, LENGTH as u64);
}

/// A struct that crosses processes.
///
/// Implemented by this crate's `message!` alone, which also makes it a compile
/// error when there is padding between or behind the fields.
pub trait Message: Copy {
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

/// Whether the fields fill the message, one right behind the other.
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

/// Defines a message: the struct with its type name for iceoryx2, its fields for
/// the layout's table and hash, and the proof that it has no padding.
/// `ZeroCopySend` must be in scope.
macro_rules! message {
    (
        $(#[$attribute:meta])*
        $type_name:literal
        $visibility:vis struct $name:ident {
            $($(#[$field_attribute:meta])* pub $field:ident: $type:ty,)*
        }
    ) => {
        $(#[$attribute])*
        #[repr(C)]
        #[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend)]
        #[type_name($type_name)]
        $visibility struct $name {
            $($(#[$field_attribute])* pub $field: $type,)*
        }

        impl $crate::layout::Message for $name {
            const TYPE_NAME: &'static str = $type_name;
            const FIELDS: &'static [$crate::layout::Field] = &[
                $($crate::layout::Field {
                    name: stringify!($field),
                    written_type: stringify!($type),
                    kind: <$type as $crate::layout::Element>::KIND,
                    offset: core::mem::offset_of!($name, $field),
                    size: size_of::<$type>(),
                },)*
            ];
        }

        impl $crate::layout::Element for $name {
            const KIND: u64 = <Self as $crate::layout::Message>::LAYOUT_HASH;
        }

        const _: () = assert!(
            !$crate::layout::has_padding::<$name>(),
            concat!(stringify!($name), " has padding: add a reserved field")
        );
    };
}

pub(crate) use message;

#[cfg(test)]
mod tests {
    use super::Message;
    use iceoryx2::prelude::ZeroCopySend;

    message! {
        "test.Pair"
        struct Pair {
            pub first: f32,
            pub second: u32,
        }
    }

    mod swapped {
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
