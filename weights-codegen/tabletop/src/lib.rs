//! The trained weights of the domain `tabletop` for [`nsrm_core`], as static arrays.
//!
//! The domain is the paper's: seven colours, two sizes (`lego`, `small`) and the actions
//! `MoveOn`, `MoveRight` and `MoveLeft`. The arrays are 496 kB of read-only memory; nothing
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
//! `nsrm-codegen` writes the arrays from `tabletop.safetensors`, which is in this package, too.
#![no_std]
#![forbid(unsafe_code)]

mod generated;

pub use generated::{TABLETOP, TABLETOP_ABOUT};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
mod readme {}
