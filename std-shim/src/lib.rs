//! The parts of NSRM that need an operating system: models loaded at run time, scenes read from
//! JSON and images, plans and refusals as JSON. The command `nsrm` is built on them; `nsrm_core`
//! does the planning.
//!
//! ```no_run
//! use nsrm::{AnyModel, read_scene};
//! use nsrm_core::Planner;
//!
//! let model = AnyModel::load("model.safetensors")?;
//! let model = model.model();
//! let scene = read_scene("scene.json", None, &model)?;
//! let sentence = "put the red block on the small blue block";
//! match Planner::new(&model).plan(&scene, sentence) {
//!     Ok(plan) => println!("{}", nsrm::json::plan(&model, &plan, sentence)),
//!     Err(refusal) => eprintln!("{}", refusal.in_context(&model, sentence)),
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

pub mod dialogue;
mod info;
pub mod json;
mod models;
#[cfg(feature = "scene-files")]
mod png_file;
#[cfg(feature = "risk")]
pub mod risk;
#[cfg(feature = "scene-files")]
mod scenes;

pub use info::{info_json, info_text};
pub use models::{AnyModel, LoadError, load_model, load_model_as};
pub use nsrm_codegen::{ModelError, OwnedModel, with_confidence};
#[cfg(feature = "scene-files")]
pub use scenes::{SceneFileError, SceneText, read_scene, read_scene_text};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
mod readme {}
