//! Neuro-symbolic robot manipulation: plans a sentence in a scene, as a program with grounded
//! sub-goals. `no_std`, no allocation, bounded time.
//!
//! The modules follow the paper (*Learning Robot Manipulation Programs: A
//! Neuro-symbolic Approach*):
//!
//! 1. [`dsl`]: programs over actions and concepts (section IV-A, Table I)
//! 2. [`language`]: a sentence to a program (section IV-B)
//! 3. [`vision`]: crops to embeddings, embeddings to concepts (section IV-C)
//! 4. [`scene`] and [`grounding`]: descriptions to objects (section IV-C, Table II)
//! 5. [`action`]: the action simulator (section IV-D); [`relation`]: how objects stand to each other,
//!    by what actions bring about
//! 6. [`camera`]: from the image to the world (section III); [`calibration`]: whether the scene
//!    agrees with it; [`viewpoint`]: any camera's view as the training's would have it
//! 7. [`planner`]: the whole pipeline, at once or in bounded steps; [`refusal`]: why there is no
//!    plan; [`explain`]: plans and refusals in words
//!
//! Below them are [`model`], the trained parameters by reference, and [`nn`], the layers.
//!
//! ```
//! # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/observed/mod.rs"));
//! use nsrm_core::{Planner, Refusal};
//! use nsrm_tabletop::TABLETOP; // trained weights: a crate of their own
//!
//! fn obey(scene: &Scene, sentence: &str) -> Result<(), Refusal> {
//!     let plan = Planner::new(&TABLETOP).plan(scene, sentence)?;
//!     println!("{}", plan.program().notation(&TABLETOP));
//!     for goal in plan.sub_goals() {
//!         println!("object {} to {}", goal.object, goal.pose); // world frame, metres
//!     }
//!     Ok(())
//! }
//! # fn main() -> Result<(), Refusal> {
//! #     obey(&scene(&TABLETOP), "put the red block on the yellow block")
//! # }
//! ```
//!
//! Nothing here panics, allocates or contains unsafe code; exceeding a capacity is a typed refusal.
//! All numbers are `f32`; lengths are in metres.
#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    warn(
        clippy::expect_used,
        clippy::indexing_slicing,
        clippy::panic,
        clippy::unwrap_used
    )
)]

#[cfg(test)]
extern crate std;

pub mod action;
pub mod calibration;
pub mod camera;
mod capacity;
pub mod dsl;
pub mod explain;
#[cfg(test)]
mod fixture;
pub mod grounding;
pub mod language;
pub mod model;
pub mod nn;
pub mod planner;
pub mod refusal;
pub mod relation;
pub mod scene;
pub mod viewpoint;
pub mod vision;

/// Re-exported in the version used here: a task that owns its sentence keeps it in a
/// [`heapless::String`].
pub use heapless;
/// Re-exported in the version used here: poses are [`nalgebra::Isometry3`].
pub use nalgebra;

pub use camera::Camera;
pub use capacity::{
    MAX_CANDIDATES, MAX_CORRECTIONS, MAX_FILTERS, MAX_GROUPS, MAX_OBJECTS, MAX_READINGS,
    MAX_RELATIONS, MAX_SENTENCE_BYTES, MAX_SPLITS, MAX_STEP_TOKENS, MAX_STEPS, MAX_TOKENS,
};
pub use dsl::Program;
pub use model::Model;
pub use planner::{GroundingTask, Plan, Planner, PlanningTask};
pub use refusal::Refusal;
pub use scene::{RawScene, Scene, SceneError};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
mod readme {}
