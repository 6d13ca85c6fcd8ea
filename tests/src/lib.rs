//! What the tests across crates share.
//!
//! * [`by_hand`]: a model whose weights were set by hand, so that what it does
//!   with a sentence is known without training;
//! * [`controller`] and [`world`]: what stands around a planner;
//! * [`isolated_memory`]: shared memory of one test, and what was left behind in it;
//! * [`counting`]: an allocator that counts;
//! * [`fuzz`]: what is done with bytes from anywhere, by the fuzz targets and by a test;
//! * [`golden`]: what the trainer computed, for everything to agree with;
//! * [`picture`]: a picture of coloured squares, for what must run on any image;
//! * [`plans`]: what holds of every plan.

pub mod by_hand;
pub mod controller;
pub mod counting;
pub mod fuzz;
pub mod golden;
pub mod isolated_memory;
pub mod picture;
pub mod plans;
pub mod world;
