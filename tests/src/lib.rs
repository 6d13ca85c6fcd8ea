//! Helpers for the tests across crates.
//!
//! * [`by_hand`]: a model whose weights were set by hand, so that its results are known without
//!   training;
//! * [`controller`] and [`world`]: the surroundings of a planner;
//! * [`isolated_memory`]: isolated shared memory of a test, and what was left behind in it;
//! * [`counting`]: a counting allocator;
//! * [`fuzz`]: the fuzz targets' functions, which a test runs, too;
//! * [`golden`]: the trainer's results, with which everything must agree;
//! * [`picture`]: an image of coloured squares, for properties that hold for any image;
//! * [`plans`]: properties of every plan.

pub mod by_hand;
#[cfg(feature = "processes")]
pub mod controller;
pub mod counting;
pub mod fuzz;
pub mod golden;
#[cfg(feature = "processes")]
pub mod isolated_memory;
pub mod picture;
pub mod plans;
#[cfg(feature = "processes")]
pub mod world;
