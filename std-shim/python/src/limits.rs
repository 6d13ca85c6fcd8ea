//! Limits of the closed loop: timeouts, tolerances and retries.

use nsrm_ipc::executive;
use pyo3::prelude::*;

use crate::errors::argument;

/// The limits of the closed loop, with defaults.
#[pyclass(frozen, eq, get_all, module = "nsrm", from_py_object)]
#[derive(Clone, PartialEq)]
pub(crate) struct Limits {
    scene_age_ns: u64,
    scene_wait_ns: u64,
    accept_wait_ns: u64,
    move_wait_ns: u64,
    silence_ns: u64,
    tolerance_m: f32,
    moved_m: f32,
    covered_m: f32,
    attempts: u8,
    retries: u8,
}

impl Limits {
    pub(crate) const fn inner(&self) -> executive::Limits {
        executive::Limits {
            scene_age_ns: self.scene_age_ns,
            scene_wait_ns: self.scene_wait_ns,
            accept_wait_ns: self.accept_wait_ns,
            move_wait_ns: self.move_wait_ns,
            silence_ns: self.silence_ns,
            tolerance_m: self.tolerance_m,
            moved_m: self.moved_m,
            covered_m: self.covered_m,
            attempts: self.attempts,
            retries: self.retries,
        }
    }
}

#[pymethods]
impl Limits {
    #[new]
    #[pyo3(signature = (
        *,
        scene_age_ns = None,
        scene_wait_ns = None,
        accept_wait_ns = None,
        move_wait_ns = None,
        silence_ns = None,
        tolerance_m = None,
        moved_m = None,
        covered_m = None,
        attempts = None,
        retries = None,
    ))]
    #[allow(clippy::too_many_arguments, reason = "keywords in Python")]
    fn new(
        scene_age_ns: Option<u64>,
        scene_wait_ns: Option<u64>,
        accept_wait_ns: Option<u64>,
        move_wait_ns: Option<u64>,
        silence_ns: Option<u64>,
        tolerance_m: Option<f32>,
        moved_m: Option<f32>,
        covered_m: Option<f32>,
        attempts: Option<u8>,
        retries: Option<u8>,
    ) -> PyResult<Self> {
        let usual = executive::Limits::default();
        let limits = Self {
            scene_age_ns: scene_age_ns.unwrap_or(usual.scene_age_ns),
            scene_wait_ns: scene_wait_ns.unwrap_or(usual.scene_wait_ns),
            accept_wait_ns: accept_wait_ns.unwrap_or(usual.accept_wait_ns),
            move_wait_ns: move_wait_ns.unwrap_or(usual.move_wait_ns),
            silence_ns: silence_ns.unwrap_or(usual.silence_ns),
            tolerance_m: tolerance_m.unwrap_or(usual.tolerance_m),
            moved_m: moved_m.unwrap_or(usual.moved_m),
            covered_m: covered_m.unwrap_or(usual.covered_m),
            attempts: attempts.unwrap_or(usual.attempts),
            retries: retries.unwrap_or(usual.retries),
        };
        let checked = limits.inner().check();
        checked.map_err(|error| argument("limits", error))?;
        Ok(limits)
    }
}
