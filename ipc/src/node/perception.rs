//! Perception as a process: takes frames with boxes and publishes scenes. It reads the pixels in
//! place, where the camera's process has written them.

use core::sync::atomic::{AtomicBool, Ordering};
use core::time::Duration;

use nsrm_core::Model;
use tracing::warn;

use super::appearance_cache::AppearanceCache;
use super::frame::see;
use super::heartbeats::{HEARTBEAT_NS, Heartbeats};
use crate::clock::{is_due, now_ns};
use crate::message::{DetectedBox, Role, SceneMessage, State};
use crate::service::{CAMERA, Frames, Robot, Sender, ServiceError};

/// The longest sleep when no frame arrives.
const NAP: Duration = Duration::from_millis(20);

/// A robot's perception.
#[derive(Debug)]
pub struct PerceptionNode<'m> {
    robot: Robot,
    model: &'m Model<'m>,
    frames: Frames,
    scenes: Sender<SceneMessage>,
    appearances: AppearanceCache,
    heartbeats: Heartbeats,
}

impl<'m> PerceptionNode<'m> {
    /// Joins a robot as its perception.
    ///
    /// ```no_run
    /// use core::sync::atomic::AtomicBool;
    ///
    /// use iceoryx2::config::Config;
    /// use nsrm_ipc::message::Role;
    /// use nsrm_ipc::node::PerceptionNode;
    /// use nsrm_ipc::service::Robot;
    /// use nsrm_tabletop::TABLETOP;
    ///
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// static STOP: AtomicBool = AtomicBool::new(false); // set by a signal handler
    ///
    /// let robot = Robot::join("left".parse()?, Role::Perception, Config::global_config())?;
    /// let mut perception = PerceptionNode::begin(robot, &TABLETOP)?;
    /// perception.run(&STOP)?;
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`ServiceError`], for instance [`ServiceError::Taken`] if the robot has a perception.
    pub fn begin(robot: Robot, model: &'m Model<'m>) -> Result<Self, ServiceError> {
        Ok(Self {
            model,
            frames: robot.frames_in()?,
            scenes: robot.sender()?,
            appearances: AppearanceCache::default(),
            heartbeats: Heartbeats::begin(&robot, Role::Perception, now_ns())?,
            robot,
        })
    }

    /// Publishes scenes until `stop` is set. Sleeps while no frame arrives.
    pub fn run(&mut self, stop: &AtomicBool) -> Result<(), ServiceError> {
        let wait_set = self.robot.wait_set([CAMERA])?;
        let mut burial_ns = 0;
        while !stop.load(Ordering::Relaxed) {
            // An endless stream of frames must not keep it from stopping.
            while self.poll(now_ns()) && !stop.load(Ordering::Relaxed) {}
            // After the work: it takes some hundreds of microseconds.
            if is_due(burial_ns, now_ns(), HEARTBEAT_NS) {
                self.robot.cleanup_dead_nodes();
                burial_ns = now_ns().saturating_add(HEARTBEAT_NS);
            }
            wait_set
                .wait(NAP)
                .map_err(|error| self.robot.fault(CAMERA, &error))?;
        }
        Ok(())
    }

    /// Publishes a scene of the latest frame, if there is a new one; returns whether there was.
    /// Never waits.
    pub fn poll(&mut self, now_ns: u64) -> bool {
        match self.heartbeats.beat(State::Idle, now_ns) {
            Ok(true) => self.scenes.update_connections(),
            Ok(false) => {}
            Err(failure) => warn!(%failure, "heartbeat not sent"),
        }
        // If receiving fails, the next call tries again.
        let Ok(Some(frame)) = self.frames.receive() else {
            return false;
        };
        // A copy: checked data must not change afterwards.
        let header = *frame.user_header();
        match see(self.model, &header, frame.payload()) {
            Ok(mut scene) => {
                let objects = scene.objects.get_mut(..scene.count as usize);
                self.appearances
                    .recall(&header, objects.unwrap_or_default());
                leave_out(&mut scene, |id| {
                    let mut boxes = header.boxes.iter();
                    let is_hidden = |it: &DetectedBox| it.covered == DetectedBox::HIDDEN;
                    boxes.any(|it| it.id == id && is_hidden(it)) && !self.appearances.knows(id)
                });
                if let Err(failure) = self.scenes.send(&scene) {
                    warn!(%failure, "scene not sent");
                }
            }
            Err(fault) => self.heartbeats.reject(CAMERA, &fault, now_ns),
        }
        true
    }

    /// How many frames it has rejected.
    pub const fn rejected(&self) -> u64 {
        self.heartbeats.rejected()
    }
}

/// Removes objects from a scene; the others keep their order.
fn leave_out(scene: &mut SceneMessage, is_out: impl Fn(u32) -> bool) {
    let mut kept = 0;
    for index in 0..scene.count as usize {
        let Some(object) = scene.objects.get(index).copied() else {
            break;
        };
        if !is_out(object.id)
            && let Some(place) = scene.objects.get_mut(kept)
        {
            *place = object;
            kept += 1;
        }
    }
    // At most as many as before.
    scene.count = kept as u32;
}

#[cfg(test)]
mod tests {
    use nsrm_core::scene::ObservedObject;
    use nsrm_core::{Camera, RawScene};
    use nsrm_tabletop::TABLETOP;

    use super::{SceneMessage, leave_out};

    #[test]
    fn what_is_left_out_leaves_no_gap() {
        let mut raw = RawScene::empty(&TABLETOP, Camera::default());
        for id in 1..=4 {
            let object = ObservedObject::EMPTY;
            raw.push(ObservedObject { id, ..object }).unwrap();
        }
        let mut scene = SceneMessage::from(&raw);
        leave_out(&mut scene, |id| id == 1 || id == 3);
        let ids: Vec<_> = scene.objects[..scene.count as usize]
            .iter()
            .map(|object| object.id)
            .collect();
        assert_eq!(ids, [2, 4]);
        // A wrong count is kept for the later check, or clipped to the available boxes.
        scene.count = 99;
        leave_out(&mut scene, |_| false);
        assert_eq!(scene.count as usize, scene.objects.len());
    }
}
