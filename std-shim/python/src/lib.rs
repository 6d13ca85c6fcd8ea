//! The Python module `nsrm`: models, scenes and plans of `nsrm_core` as plain
//! types, numpy arrays in and out, refusals as exceptions.
//!
//! What each class and function takes and gives is said in `nsrm.pyi`.

mod arrays;
mod camera;
mod dialogue;
mod errors;
mod events;
mod executive;
mod limits;
mod model;
mod observed;
mod plan;
mod risk;
mod scene;
mod values;

/// Sentences and scenes to robot programs and sub-goals.
#[pyo3::pymodule(name = "nsrm")]
mod module {
    #[pymodule_export]
    use crate::camera::Camera;
    #[pymodule_export]
    use crate::dialogue::{Choice, Question};
    #[pymodule_export]
    use crate::errors::{ModelError, NsrmError, Refused, SceneError};
    #[pymodule_export]
    use crate::events::{
        Again, Clearing, Command, Ended, Failure, Planned, Reached, Stop, Waiting, Working,
    };
    #[pymodule_export]
    use crate::executive::Executive;
    #[pymodule_export]
    use crate::limits::Limits;
    #[pymodule_export]
    use crate::model::Model;
    #[pymodule_export]
    use crate::observed::Observed;
    #[pymodule_export]
    use crate::plan::{Correction, Plan, PlannedStep, Program, Step};
    #[pymodule_export]
    use crate::risk::{Accepted, accepted, least_confidence, with_confidence};
    #[pymodule_export]
    use crate::scene::{Scene, crop};

    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const __version__: &str = env!("CARGO_PKG_VERSION");

    #[pymodule_export]
    const MAX_CANDIDATES: usize = nsrm_core::MAX_CANDIDATES;
    #[pymodule_export]
    const MAX_CORRECTIONS: usize = nsrm_core::MAX_CORRECTIONS;
    #[pymodule_export]
    const MAX_FILTERS: usize = nsrm_core::MAX_FILTERS;
    #[pymodule_export]
    const MAX_GROUPS: usize = nsrm_core::MAX_GROUPS;
    #[pymodule_export]
    const MAX_OBJECTS: usize = nsrm_core::MAX_OBJECTS;
    #[pymodule_export]
    const MAX_READINGS: usize = nsrm_core::MAX_READINGS;
    #[pymodule_export]
    const MAX_RELATIONS: usize = nsrm_core::MAX_RELATIONS;
    #[pymodule_export]
    const MAX_SENTENCE_BYTES: usize = nsrm_core::MAX_SENTENCE_BYTES;
    #[pymodule_export]
    const MAX_STEP_TOKENS: usize = nsrm_core::MAX_STEP_TOKENS;
    #[pymodule_export]
    const MAX_STEPS: usize = nsrm_core::MAX_STEPS;
    #[pymodule_export]
    const MAX_TOKENS: usize = nsrm_core::MAX_TOKENS;
}
