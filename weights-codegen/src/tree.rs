//! A value as a tree of records, arrays and numbers: what [`crate::emit`]
//! prints and [`crate::report`] counts.

use nsrm_core::dsl::{Extreme, Property};
use nsrm_core::model::{CompoundKind, View};

/// A value of the static model.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Node {
    /// A number, an enum's variant, or an optional text or array of a few numbers: the Rust text and
    /// the size in bytes.
    Scalar { text: String, bytes: usize },
    /// A string.
    Text(String),
    /// A reference to another static.
    Reference(&'static str),
    /// A variant of an enum with a reference to another static.
    Variant(&'static str, &'static str),
    /// A fixed array.
    Array(Vec<Node>),
    /// A struct that is built with `new` and a `with_` method for each field: its name, and its
    /// fields in the order of declaration.
    Record(&'static str, Vec<(&'static str, Node)>),
}

impl Node {
    pub(crate) fn record<const N: usize>(
        name: &'static str,
        fields: [(&'static str, Node); N],
    ) -> Self {
        Self::Record(name, fields.into())
    }
}

/// A type of the static model.
pub(crate) trait Describe {
    /// The value as a tree.
    fn describe(&self) -> Node;
}

impl Describe for f32 {
    /// In the shortest decimal notation that reads back as the same bits.
    fn describe(&self) -> Node {
        Node::Scalar {
            text: format!("{self:?}"),
            bytes: size_of::<f32>(),
        }
    }
}

impl Describe for bool {
    fn describe(&self) -> Node {
        Node::Scalar {
            text: self.to_string(),
            bytes: size_of::<bool>(),
        }
    }
}

impl Describe for i8 {
    fn describe(&self) -> Node {
        Node::Scalar {
            text: self.to_string(),
            bytes: size_of::<i8>(),
        }
    }
}

impl Describe for u8 {
    fn describe(&self) -> Node {
        Node::Scalar {
            text: self.to_string(),
            bytes: size_of::<u8>(),
        }
    }
}

impl Describe for u16 {
    fn describe(&self) -> Node {
        Node::Scalar {
            text: self.to_string(),
            bytes: size_of::<u16>(),
        }
    }
}

impl Describe for u32 {
    fn describe(&self) -> Node {
        Node::Scalar {
            text: self.to_string(),
            bytes: size_of::<u32>(),
        }
    }
}

impl Describe for View {
    fn describe(&self) -> Node {
        Node::Scalar {
            text: format!("View::{self:?}"),
            bytes: size_of::<View>(),
        }
    }
}

impl Describe for CompoundKind {
    fn describe(&self) -> Node {
        Node::Scalar {
            text: format!("CompoundKind::{self:?}"),
            bytes: size_of::<Self>(),
        }
    }
}

/// A few indices.
impl Describe for &[u8] {
    fn describe(&self) -> Node {
        Node::Scalar {
            text: format!("&{self:?}"),
            bytes: size_of::<Self>() + self.len(),
        }
    }
}

impl Describe for Property {
    fn describe(&self) -> Node {
        Node::Scalar {
            text: match self {
                Self::Concept(concept) => format!("Property::Concept({concept})"),
                Self::Extreme(extreme) => format!("Property::Extreme(Extreme::{extreme:?})"),
                Self::Ranked(index) => format!("Property::Ranked({index})"),
                Self::Quantifier(quantifier) => {
                    format!("Property::Quantifier(Quantifier::{quantifier:?})")
                }
                Self::Table => "Property::Table".into(),
                Self::Itself => "Property::Itself".into(),
            },
            bytes: size_of::<Property>(),
        }
    }
}

impl Describe for Extreme {
    fn describe(&self) -> Node {
        Node::Scalar {
            text: format!("Extreme::{self:?}"),
            bytes: size_of::<Self>(),
        }
    }
}

impl Describe for Option<u16> {
    fn describe(&self) -> Node {
        Node::Scalar {
            text: format!("{self:?}"),
            bytes: size_of::<Self>(),
        }
    }
}

impl Describe for Option<&str> {
    fn describe(&self) -> Node {
        Node::Scalar {
            text: format!("{self:?}"),
            bytes: size_of::<Self>() + self.map_or(0, str::len),
        }
    }
}

impl<const N: usize> Describe for Option<[f32; N]> {
    fn describe(&self) -> Node {
        Node::Scalar {
            text: format!("{self:?}"),
            bytes: size_of::<Self>(),
        }
    }
}

impl Describe for &str {
    fn describe(&self) -> Node {
        Node::Text((*self).to_owned())
    }
}

impl<T: Describe> Describe for [T] {
    fn describe(&self) -> Node {
        Node::Array(self.iter().map(T::describe).collect())
    }
}

impl<T: Describe, const N: usize> Describe for [T; N] {
    fn describe(&self) -> Node {
        self.as_slice().describe()
    }
}

/// Implements [`Describe`] for structs field by field.
macro_rules! describe {
    ($($name:ident $(<$lifetime:lifetime>)? { $($field:ident),* $(,)? })*) => {$(
        impl $crate::tree::Describe for $name $(<$lifetime>)? {
            fn describe(&self) -> $crate::tree::Node {
                let Self { $($field),*, .. } = self;
                $crate::tree::Node::record(
                    stringify!($name),
                    [$((stringify!($field), $crate::tree::Describe::describe($field))),*],
                )
            }
        }
    )*};
}
pub(crate) use describe;
