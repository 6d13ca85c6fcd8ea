//! The surroundings of a planner, in the hand-made domain: scenes, a controller that changes them,
//! and a client.

use iceoryx2::config::Config;
use iceoryx2::pending_response::PendingResponse;
use iceoryx2::prelude::ipc;
use nsrm_core::{Model, RawScene};
use nsrm_ipc::executive::{Limits, Mode};
use nsrm_ipc::message::{PlanReply, PlanRequest, Reply, Role, SceneMessage};
use nsrm_ipc::node::PlannerNode;
use nsrm_ipc::service::{PlanClient, Sender};

use crate::by_hand::{Block, block, raw_scene};
use crate::controller::Controller;
use crate::isolated_memory::join;

/// The default blocks on the table, with ids from 1.
pub const BLOCKS: [Block; 3] = [
    block("small", "red"),
    block("lego", "blue"),
    block("lego", "green"),
];
/// Two steps that can be executed with [`BLOCKS`].
pub const SENTENCE: &str = "put the small red block on the blue block then put the green block on \
                            the small red block";

/// An hour: longer than any test, on however busy a machine.
pub const HOUR_NS: u64 = 3_600_000_000_000;

/// Limits without effective timeouts.
pub fn patient() -> Limits {
    Limits {
        scene_age_ns: HOUR_NS,
        scene_wait_ns: HOUR_NS,
        accept_wait_ns: HOUR_NS,
        move_wait_ns: HOUR_NS,
        silence_ns: HOUR_NS,
        ..Limits::default()
    }
}

/// A request by connection, until its last reply.
pub type Pending = PendingResponse<ipc::Service, PlanRequest, (), PlanReply, ()>;

/// The surroundings of a planner.
#[derive(Debug)]
pub struct World {
    /// The content of the next scene.
    pub scene: RawScene,
    /// The controller.
    pub controller: Controller,
    /// The port for scenes.
    pub scenes: Sender<SceneMessage>,
    /// The client.
    pub client: PlanClient,
}

impl World {
    /// With [`BLOCKS`].
    pub fn new(robot: &str, model: &Model<'_>, config: &Config) -> Self {
        let camera = join(robot, Role::Camera, config);
        let client = join(robot, Role::Client, config);
        Self {
            scene: raw_scene(model, &BLOCKS),
            controller: Controller::new(robot, config),
            scenes: camera.sender().expect("perception's place"),
            client: client.plan_client().expect("a client's place"),
        }
    }

    /// Publishes the current scene, and lets the controller execute its commands.
    pub fn turn(&mut self, now_ns: u64) {
        let Self {
            scene,
            controller,
            scenes,
            ..
        } = self;
        scene.header.sequence += 1;
        scene.header.timestamp_ns = now_ns;
        let message = SceneMessage::from(&*scene);
        scenes.send(&message).expect("nobody must wait");
        controller.turn(now_ns, |command| {
            let objects = scene.objects.iter_mut();
            for object in objects.filter(|object| object.id == command.object_id) {
                object.location = command.location;
            }
        });
    }

    /// Sends a sentence.
    pub fn ask(&self, sequence: u64, sentence: &str) -> Pending {
        let request = PlanRequest::new(3, sequence, Mode::ClosedLoop, sentence);
        let request = request.expect("a sentence of moderate length");
        self.client.send_copy(request).expect("a planner")
    }

    /// All replies until the planner sends no more.
    ///
    /// * `clock`: gives the time
    pub fn follow(
        &mut self,
        planner: &mut PlannerNode<'_>,
        pending: &Pending,
        clock: impl Fn() -> u64,
    ) -> Vec<PlanReply> {
        let mut replies = Vec::new();
        loop {
            self.turn(clock());
            planner.poll(clock());
            // Checked first, since replies may arrive in between.
            let goes_on = pending.is_connected();
            while let Some(reply) = pending.receive().expect("nothing is lost") {
                replies.push(*reply);
            }
            if !goes_on {
                return replies;
            }
        }
    }
}

/// Why a sentence was not executed; `None` if it was.
pub fn last_reason(replies: &[PlanReply]) -> Option<&'static str> {
    let last = replies.last().expect("a last word");
    match last.read().expect("a reply that makes sense") {
        Reply::Failed { reason, .. } => Some(reason),
        Reply::Done => None,
        reply => panic!("{reply:?}"),
    }
}
