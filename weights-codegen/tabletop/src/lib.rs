//! The trained weights of the domain `tabletop` for [`nsrm_core`], as static arrays.
//!
//! The domain is the paper's: seven colours, two sizes (`lego`, `small`) and the actions
//! `MoveOn`, `MoveRight` and `MoveLeft`. The arrays are 534 kB of read-only memory; nothing
//! is loaded, copied or checked at run time.
//!
//! ```
//! use nsrm_core::Planner;
//! use nsrm_tabletop::TABLETOP;
//!
//! let parsed = Planner::new(&TABLETOP).parse("put the red block on the small blue block")?;
//! assert_eq!(
//!     parsed.program().notation(&TABLETOP).to_string(),
//!     "Action(MoveOn, Unique(Filter(red, Scene())), Unique(Filter(small, Filter(blue, Scene()))))"
//! );
//! # Ok::<(), nsrm_core::Refusal>(())
//! ```
//!
//! Weights and interface have versions of their own. A new training changes what
//! [`Model::tag`](nsrm_core::Model::tag) gives and, in rare cases, what a sentence is taken for:
//! it is a new minor version of this crate. It changes no type, and nothing in `nsrm-core`.
//!
//! With the feature `int8` there is `TABLETOP_INT8`, too: the same model, its large layers in whole
//! numbers of eight bits, 209 kB. A program with this feature alone, without `default`, has no code
//! for other weights.
//!
//! `nsrm-codegen` writes the arrays from `tabletop.safetensors`, which is in this package, too.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(feature = "f32")]
mod generated;
#[cfg(feature = "int8")]
mod int8;

#[cfg(feature = "f32")]
pub use generated::{TABLETOP, TABLETOP_ABOUT};
#[cfg(feature = "int8")]
pub use int8::{TABLETOP_INT8, TABLETOP_INT8_ABOUT};

#[cfg(all(doctest, feature = "f32"))]
#[doc = include_str!("../README.md")]
mod readme {}
