//! Observes a robot: live nodes, streams of messages, and the last replies.

use super::rejected::Rejected;
use super::view::View;
use crate::message::{Feedback, Heartbeat, PlanReply, SceneMessage};
use crate::service::{Carried, Receiver, Robot, ServiceError};

/// Observes a robot; changes nothing.
#[derive(Debug)]
pub struct Watcher {
    heartbeats: Receiver<Heartbeat>,
    scenes: Receiver<SceneMessage>,
    feedback: Receiver<Feedback>,
    answers: Receiver<PlanReply>,
    view: View,
    rejected: Rejected,
    _robot: Robot,
}

impl Watcher {
    /// Joins a robot as one of its observers.
    ///
    /// ```no_run
    /// use iceoryx2::config::Config;
    /// use nsrm_ipc::clock::now_ns;
    /// use nsrm_ipc::message::Role;
    /// use nsrm_ipc::node::Watcher;
    /// use nsrm_ipc::service::Robot;
    ///
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let robot = Robot::join("left".parse()?, Role::Watcher, Config::global_config())?;
    /// let mut watcher = Watcher::begin(robot)?;
    /// loop {
    ///     let view = watcher.look(now_ns());
    ///     println!("{} objects in the last scene", view.objects);
    ///     for node in view.nodes.iter().flatten() {
    ///         println!("{}: {:?}", node.role.word(), node.state);
    ///     }
    ///     std::thread::sleep(std::time::Duration::from_millis(250));
    /// }
    /// # }
    /// ```
    pub fn begin(robot: Robot) -> Result<Self, ServiceError> {
        Ok(Self {
            heartbeats: robot.receiver()?,
            scenes: robot.receiver()?,
            feedback: robot.receiver()?,
            answers: robot.receiver()?,
            view: View::default(),
            rejected: Rejected::default(),
            _robot: robot,
        })
    }

    /// Receives what has arrived and returns the current view. If a stream cannot be read, the next
    /// call tries again.
    pub fn look(&mut self, now_ns: u64) -> &View {
        let (view, rejected) = (&mut self.view, &mut self.rejected);
        view.not_after(now_ns);
        for heartbeat in self.heartbeats.waiting() {
            if let Err(error) = view.hear_heartbeat(&heartbeat, now_ns) {
                rejected.add(Heartbeat::SERVICE, &error, now_ns);
            }
        }
        for scene in self.scenes.waiting() {
            if let Err(error) = view.hear_scene(&scene, now_ns) {
                rejected.add(SceneMessage::SERVICE, &error, now_ns);
            }
        }
        for feedback in self.feedback.waiting() {
            if let Err(error) = view.hear_feedback(&feedback, now_ns) {
                rejected.add(Feedback::SERVICE, &error, now_ns);
            }
        }
        for reply in self.answers.waiting() {
            if let Err(error) = view.hear_reply(&reply) {
                rejected.add(PlanReply::SERVICE, &error, now_ns);
            }
        }
        view.rejected = rejected.count();
        view
    }
}
