//! A layer in one of the precisions that there are: what a model refers to.

use core::str::FromStr;

use thiserror::Error;

#[cfg(any(feature = "f32", not(feature = "int8")))]
use super::{Gru, Linear, add_products};
#[cfg(feature = "int8")]
use super::{Int8Gru, Int8Linear};

/// How the weights of a model's large layers are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Precision {
    /// As trained.
    #[default]
    F32,
    /// As whole numbers of eight bits, one scale an output: a quarter of the memory.
    Int8,
}

impl Precision {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::F32, Self::Int8];

    /// Bits of a weight.
    pub const fn bits(self) -> u32 {
        match self {
            Self::F32 => 32,
            Self::Int8 => 8,
        }
    }

    /// Its name on the command line and in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::Int8 => "int8",
        }
    }
}

/// A name that is no precision's.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("expected f32 or int8")]
pub struct UnknownPrecision;

impl FromStr for Precision {
    type Err = UnknownPrecision;

    fn from_str(name: &str) -> Result<Self, UnknownPrecision> {
        let mut all = Self::ALL.into_iter();
        all.find(|precision| precision.name() == name)
            .ok_or(UnknownPrecision)
    }
}

/// A dense layer `y = W·x + b`.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub enum Dense<'a, const INPUT: usize, const OUTPUT: usize> {
    /// With the weights as trained.
    #[cfg(any(feature = "f32", not(feature = "int8")))]
    F32(&'a Linear<INPUT, OUTPUT>),
    /// With rounded weights. Needs the feature `int8`.
    #[cfg(feature = "int8")]
    Int8(&'a Int8Linear<INPUT, OUTPUT>),
}

impl<'a, const INPUT: usize, const OUTPUT: usize> Dense<'a, INPUT, OUTPUT> {
    /// The layer, if its weights are as trained.
    #[cfg(any(feature = "f32", not(feature = "int8")))]
    pub const fn as_f32(&self) -> Option<&'a Linear<INPUT, OUTPUT>> {
        match self {
            #[cfg(any(feature = "f32", not(feature = "int8")))]
            Self::F32(layer) => Some(layer),
            #[cfg(feature = "int8")]
            Self::Int8(_) => None,
        }
    }

    /// `b`.
    pub(crate) const fn bias(&self) -> &[f32; OUTPUT] {
        match self {
            #[cfg(any(feature = "f32", not(feature = "int8")))]
            Self::F32(layer) => &layer.bias,
            #[cfg(feature = "int8")]
            Self::Int8(layer) => &layer.bias,
        }
    }

    /// `W·input + b`. Cost: `INPUT·OUTPUT` multiply-adds.
    pub fn apply(&self, input: &[f32; INPUT]) -> [f32; OUTPUT] {
        match self {
            #[cfg(any(feature = "f32", not(feature = "int8")))]
            Self::F32(layer) => layer.apply(input),
            #[cfg(feature = "int8")]
            Self::Int8(layer) => layer.apply(input),
        }
    }

    /// Adds a part of the product: `sum += W[.., first..first + PART]·input`.
    ///
    /// Cost: `PART·OUTPUT` multiply-adds.
    pub(crate) fn add_products<const PART: usize>(
        &self,
        sum: &mut [f32; OUTPUT],
        first: usize,
        input: &[f32; PART],
    ) {
        match self {
            #[cfg(any(feature = "f32", not(feature = "int8")))]
            Self::F32(layer) => {
                let columns = layer.weight.get(first..).unwrap_or_default();
                let columns = columns.get(..PART).unwrap_or_default();
                add_products(sum, input, columns);
            }
            #[cfg(feature = "int8")]
            Self::Int8(layer) => layer.add_products(sum, first, input),
        }
    }
}

/// A GRU cell.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub enum Cell<'a, const INPUT: usize, const HIDDEN: usize> {
    /// With the weights as trained.
    #[cfg(any(feature = "f32", not(feature = "int8")))]
    F32(&'a Gru<INPUT, HIDDEN>),
    /// With rounded weights. Needs the feature `int8`.
    #[cfg(feature = "int8")]
    Int8(&'a Int8Gru<INPUT, HIDDEN>),
}

impl<'a, const INPUT: usize, const HIDDEN: usize> Cell<'a, INPUT, HIDDEN> {
    /// The cell, if its weights are as trained.
    #[cfg(any(feature = "f32", not(feature = "int8")))]
    pub const fn as_f32(&self) -> Option<&'a Gru<INPUT, HIDDEN>> {
        match self {
            #[cfg(any(feature = "f32", not(feature = "int8")))]
            Self::F32(cell) => Some(cell),
            #[cfg(feature = "int8")]
            Self::Int8(_) => None,
        }
    }

    /// See [`Gru::step`].
    pub fn step(&self, input: &[f32; INPUT], hidden: &[f32; HIDDEN]) -> [f32; HIDDEN] {
        match self {
            #[cfg(any(feature = "f32", not(feature = "int8")))]
            Self::F32(cell) => cell.step(input, hidden),
            #[cfg(feature = "int8")]
            Self::Int8(cell) => cell.step(input, hidden),
        }
    }
}
