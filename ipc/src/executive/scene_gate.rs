use nsrm_core::camera::Camera;
use nsrm_core::{Model, Scene};

use super::failure::SceneFault;
use super::limits::Limits;
use crate::message::SceneMessage;

const NS_PER_MS: u64 = 1_000_000;
/// How far in the future a scene's time may be, nanoseconds: the clocks of one machine agree, those
/// of two within about a millisecond.
pub(super) const AHEAD_NS: u64 = 5 * NS_PER_MS;

/// The latest usable scene.
#[derive(Debug)]
pub(super) struct SceneGate {
    scene: Option<Scene>,
    /// What was wrong with the last scene, if it was rejected.
    fault: Option<SceneFault>,
    /// The camera that all scenes of a sentence must have.
    camera: Option<Camera>,
}

impl SceneGate {
    pub(super) const fn new() -> Self {
        Self {
            scene: None,
            fault: None,
            camera: None,
        }
    }

    /// The next sentence may have another camera.
    pub(super) fn forget_camera(&mut self) {
        self.camera = None;
    }

    /// Takes a scene if it is usable.
    pub(super) fn see(
        &mut self,
        message: &SceneMessage,
        model: &Model<'_>,
        limits: &Limits,
        now_ns: u64,
    ) -> Result<(), SceneFault> {
        let checked = self.check(message, model, limits, now_ns);
        self.fault = checked.err();
        self.scene = Some(checked?);
        Ok(())
    }

    fn check(
        &self,
        message: &SceneMessage,
        model: &Model<'_>,
        limits: &Limits,
        now_ns: u64,
    ) -> Result<Scene, SceneFault> {
        let scene = message.to_scene(model).map_err(SceneFault::Invalid)?;
        let taken_ns = scene.header().timestamp_ns;
        if taken_ns > now_ns.saturating_add(AHEAD_NS) {
            let by_ms = (taken_ns - now_ns) / NS_PER_MS;
            return Err(SceneFault::FromTheFuture { by_ms });
        }
        // A restarted publisher counts from 0 again, but time goes on.
        if let Some(before) = &self.scene
            && taken_ns < before.header().timestamp_ns
        {
            return Err(SceneFault::OutOfOrder);
        }
        if let Some(fault) = too_old(taken_ns, limits, now_ns) {
            return Err(fault);
        }
        if self.camera.is_some_and(|camera| camera != *scene.camera()) {
            return Err(SceneFault::OtherCamera);
        }
        Ok(scene)
    }

    /// The usable scene: its image was taken after `after_ns` and is not too old now. From now on
    /// all scenes must be from its camera.
    pub(super) fn look(&mut self, after_ns: u64, limits: &Limits, now_ns: u64) -> Option<Scene> {
        let scene = self.scene?;
        let taken_ns = scene.header().timestamp_ns;
        if taken_ns <= after_ns {
            return None;
        }
        if let Some(fault) = too_old(taken_ns, limits, now_ns) {
            self.fault = Some(fault);
            return None;
        }
        self.camera = Some(*scene.camera());
        Some(scene)
    }

    /// What was wrong with the last scene.
    pub(super) const fn fault(&self) -> Option<SceneFault> {
        self.fault
    }
}

/// Whether a scene of this time is too old to use.
pub(super) fn too_old(taken_ns: u64, limits: &Limits, now_ns: u64) -> Option<SceneFault> {
    let age_ns = now_ns.saturating_sub(taken_ns);
    (age_ns > limits.scene_age_ns).then_some(SceneFault::TooOld {
        age_ms: age_ns / NS_PER_MS,
        limit_ms: limits.scene_age_ns / NS_PER_MS,
    })
}
