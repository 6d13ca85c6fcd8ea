//! The services of one robot, `nsrm/v1/<robot>/…`, and their guarantees.
//!
//! | service | messages | guarantees, and why |
//! |---|---|---|
//! | `camera` | slices with a `CameraFrame` as header | only the latest frame: an old image is of no use. One publisher |
//! | `scene` | `SceneMessage` | the latest scene, also for late subscribers. One publisher |
//! | `plan` | `PlanRequest`, and `PlanReply`s until the last | one server; a request that does not fit is an error for the client; the replies to a whole sentence fit |
//! | `ask`, `answer` | `PlanRequest`, `PlanReply` | the same without a connection, for bridges that carry publish-subscribe only, such as a tunnel between hosts; the last 8 and 64. `answer` has all replies, for observers |
//! | `sub_goal` | `SubGoal` | none is dropped: a full buffer is an error for the sender, which never waits. One publisher and one subscriber: no robot has two planners, no command two controllers |
//! | `feedback` | `Feedback` | the last 64; sequence numbers show a gap. A controller never waits for its readers. One publisher |
//! | `heartbeat` | `Heartbeat` | the last 16 of every node |
//!
//! Each has an event service of the same name: senders notify, so that receivers need not spin.
//! Defaults of iceoryx2 that are changed here: a publisher with a full buffer waits for ever; dead
//! nodes are detected only on request ([`Robot::cleanup_dead_nodes`]); it handles signals; a
//! process that writes to full shared memory is killed, so none starts without [`ROOM`].

mod cause;
mod error;
mod fault;
mod global_config;
mod leftovers;
mod memory;
mod name;
mod open;
mod port;
mod quality;
mod wait_set;

pub use error::{SendFailure, ServiceError};
pub use global_config::set_global_config;
pub use name::{MAX_NAME, RobotName, RobotNameError};
pub use port::{Frames, FramesOut, Notifier, Receiver, Sender};
pub use quality::{
    CAMERA, CAMERA_QUALITY, CLIENTS, Carried, FRAMES_AT_ONCE, Hosts, ONLOOKERS, PLAN, Quality, ROOM,
};
pub use wait_set::WaitSet;

use core::fmt::Debug;
use std::time::{Instant, SystemTime};

use iceoryx2::config::Config;
use iceoryx2::port::BackpressureAction;
use iceoryx2::port::client::Client;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::server::Server;
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::{event, publish_subscribe, request_response};

use crate::message::{CameraFrame, PlanReply, PlanRequest, Role};
use cause::likely_cause;
use memory::find_room;
use open::{BETWEEN_TRIES, IN_FLUX, TRY, folder_of_other};
use quality::REPLIES;

/// The server of `plan`.
pub type PlanServer = Server<ipc::Service, PlanRequest, (), PlanReply, ()>;
/// A client of `plan`.
pub type PlanClient = Client<ipc::Service, PlanRequest, (), PlanReply, ()>;

/// A process as a member of a robot.
#[derive(Debug)]
pub struct Robot {
    node: Node<ipc::Service>,
    name: RobotName,
    hosts: Hosts,
}

impl Robot {
    /// Joins a robot.
    ///
    /// * `role`: the role of this process, which others name in errors
    /// * `config`: where iceoryx2 keeps its files; [`Config::global_config`] except in tests
    pub fn join(name: RobotName, role: Role, config: &Config) -> Result<Self, ServiceError> {
        let service = "node";
        find_room(&name, service, ROOM)?;
        let says = |error: &dyn Debug| ServiceError::Iceoryx {
            robot: name.clone(),
            service,
            says: format!("{error:?}"),
            cause: likely_cause(config),
        };
        let node_name = node_name(&name, role);
        let mut config = config.clone();
        config.global.creation_timeout = TRY;
        // Only `cleanup_dead_nodes` cleans up, since it first checks whether that would hang.
        config.global.node.cleanup_dead_nodes_on_creation = false;
        config.global.node.cleanup_dead_nodes_on_destruction = false;
        config.global.service.cleanup_dead_nodes_on_open = false;
        let node_name = NodeName::new(&node_name).map_err(|error| says(&error))?;
        let node = NodeBuilder::new()
            .name(&node_name)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .config(&config)
            .create::<ipc::Service>()
            .map_err(|error| match folder_of_other(&config) {
                Some(folder) => ServiceError::OtherUser {
                    robot: name.clone(),
                    service,
                    folder,
                },
                None => says(&error),
            })?;
        leftovers::remove_nodes(&config);
        leftovers::remove_sockets(&config);
        let robot = Self {
            node,
            name,
            hosts: Hosts::One,
        };
        let begun = Instant::now();
        while !robot.cleanup_dead_nodes() && begun.elapsed() < IN_FLUX {
            std::thread::sleep(BETWEEN_TRIES);
        }
        leftovers::remove_connections(&robot.node);
        Ok(robot)
    }

    /// Sets whether the robot's processes run on one host or several; all of them must agree.
    pub const fn with_hosts(mut self, hosts: Hosts) -> Self {
        self.hosts = hosts;
        self
    }

    /// The robot's name.
    pub const fn name(&self) -> &RobotName {
        &self.name
    }

    /// Frees the slots of dead processes. Call it a few times per second, since nothing else does.
    /// Returns whether it was possible now: it is not while another process is creating something.
    pub fn cleanup_dead_nodes(&self) -> bool {
        self.cleanup_dead_nodes_at(SystemTime::now())
    }

    /// As [`Robot::cleanup_dead_nodes`], for a program with its own clock.
    ///
    /// * `now`: on the clock of the file system: what a dead process has left half created is
    ///   removed when it is a second old
    pub fn cleanup_dead_nodes_at(&self, now: SystemTime) -> bool {
        let config = self.node.config();
        if leftovers::remove_segments(config, now) {
            return false;
        }
        if self.node.try_cleanup_dead_nodes().failed_cleanups > 0 {
            // The next call can then clean up.
            leftovers::remove_tags(config, now);
        }
        true
    }

    /// A sender of messages of this type.
    ///
    /// A process that publishes scenes:
    ///
    /// ```no_run
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/../core/examples/observed/mod.rs"));
    /// use iceoryx2::config::Config;
    /// use nsrm_ipc::clock::now_ns;
    /// use nsrm_ipc::message::{Role, SceneMessage};
    /// use nsrm_ipc::service::Robot;
    /// use nsrm_tabletop::TABLETOP;
    ///
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let robot = Robot::join("left".parse()?, Role::Perception, Config::global_config())?;
    /// let scenes = robot.sender::<SceneMessage>()?;
    /// let mut message = SceneMessage::from(&scene(&TABLETOP));
    /// message.timestamp_ns = now_ns(); // when the image was taken
    /// scenes.send(&message)?;
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`ServiceError::Taken`] if the service has one publisher and another process is it.
    pub fn sender<M: Carried>(&self) -> Result<Sender<M>, ServiceError> {
        let service = self.stream::<M>()?;
        let full = match M::QUALITY.publishers {
            1 => Self::taken,
            _ => Self::full,
        };
        let publisher = self.create_port(M::SERVICE, full, || {
            service
                .publisher_builder()
                // The default waits for ever if a buffer is full; this returns an error.
                .backpressure_strategy(BackpressureStrategy::DiscardData)
                .set_backpressure_handler(|_| BackpressureAction::DiscardDataAndFail)
                .create()
        })?;
        Ok(Sender::new(publisher, self.notifier(M::SERVICE)?))
    }

    /// A receiver of messages of this type.
    ///
    /// A controller, which executes sub-goals:
    ///
    /// ```no_run
    /// use core::time::Duration;
    ///
    /// use iceoryx2::config::Config;
    /// use nsrm_ipc::clock::now_ns;
    /// use nsrm_ipc::message::{Feedback, Order, Outcome, Role, SubGoal};
    /// use nsrm_ipc::service::{Carried, Robot};
    ///
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let robot = Robot::join("left".parse()?, Role::Controller, Config::global_config())?;
    /// let commands = robot.receiver::<SubGoal>()?;
    /// let feedback = robot.sender::<Feedback>()?;
    /// let wait_set = robot.wait_set([SubGoal::SERVICE])?;
    /// let mut sequence = 0;
    /// loop {
    ///     wait_set.wait(Duration::from_millis(100))?;
    ///     for command in commands.waiting() {
    ///         let outcome = match command.read(now_ns()) {
    ///             Ok(Order::Move { object, pose }) => {
    ///                 println!("move object {object} to {pose} (world frame, metres)");
    ///                 Outcome::Accepted // later `Reached`, or why not
    ///             }
    ///             Ok(Order::Stop) => Outcome::Stopped,
    ///             Err(error) => {
    ///                 eprintln!("{error}");
    ///                 continue;
    ///             }
    ///         };
    ///         sequence += 1;
    ///         feedback.send(&Feedback {
    ///             plan: command.plan,
    ///             sequence,
    ///             timestamp_ns: now_ns(),
    ///             command: command.command,
    ///             outcome: outcome as u32,
    ///             objects: [0; 2],
    ///         })?;
    ///     }
    /// }
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`ServiceError::Full`] if all of the service's subscribers are taken.
    pub fn receiver<M: Carried>(&self) -> Result<Receiver<M>, ServiceError> {
        let service = self.stream::<M>()?;
        let subscriber = self.create_port(M::SERVICE, Self::full, || {
            service
                .subscriber_builder()
                // A tunnel may have created the service, with more slots.
                .buffer_size(M::QUALITY.buffer)
                .create()
        })?;
        Ok(Receiver::new(subscriber))
    }

    /// A publisher of frames of up to `bytes` bytes.
    ///
    /// ```no_run
    /// use iceoryx2::config::Config;
    /// use nsrm_core::Camera;
    /// use nsrm_ipc::clock::now_ns;
    /// use nsrm_ipc::message::{CameraFrame, CameraMessage, DetectedBox, Role};
    /// use nsrm_ipc::service::Robot;
    ///
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let camera = Camera {
    ///     width: 640,
    ///     height: 480,
    ///     fx: 936.0,
    ///     fy: 936.0,
    ///     cx: 320.0,
    ///     cy: 240.0,
    ///     position: [1.3, 0.0, 0.8], // world frame, metres
    ///     orientation: [0.6395828, 0.6395828, -0.30155238, -0.30155238], // x, y, z, w
    /// };
    /// let robot = Robot::join("left".parse()?, Role::Camera, Config::global_config())?;
    /// let bytes = 7 * camera.width as usize * camera.height as usize;
    /// let frames = robot.frames_out(bytes)?;
    /// let mut header = CameraFrame {
    ///     sequence: 1,
    ///     timestamp_ns: now_ns(), // when the image was taken
    ///     camera: CameraMessage::from(camera),
    ///     count: 1,
    ///     ..CameraFrame::default()
    /// };
    /// // Object 1 covers these fractions of the image, 0.9 m from the camera.
    /// header.boxes[0] = DetectedBox::whole(1, [0.4, 0.4, 0.5, 0.5, 0.9]);
    /// frames.send(header, bytes, |image| image.fill(0))?;
    /// # Ok(())
    /// # }
    /// ```
    pub fn frames_out(&self, bytes: usize) -> Result<FramesOut, ServiceError> {
        let frames = FRAMES_AT_ONCE.saturating_mul(bytes as u64);
        find_room(&self.name, CAMERA, frames.saturating_add(ROOM))?;
        let service = self.frames()?;
        let publisher = self.create_port(CAMERA, Self::taken, || {
            service
                .publisher_builder()
                .backpressure_strategy(BackpressureStrategy::DiscardData)
                .initial_max_slice_len(bytes)
                .create()
        })?;
        Ok(FramesOut::new(publisher, self.notifier(CAMERA)?))
    }

    /// A receiver of frames.
    pub fn frames_in(&self) -> Result<Frames, ServiceError> {
        let service = self.frames()?;
        let subscriber = self.create_port(CAMERA, Self::full, || {
            let builder = service.subscriber_builder();
            builder.buffer_size(CAMERA_QUALITY.buffer).create()
        })?;
        Ok(Frames::new(subscriber))
    }

    /// The planner's side of `plan`.
    pub fn plan_server(&self) -> Result<PlanServer, ServiceError> {
        let service = self.plan()?;
        self.create_port(PLAN, Self::taken, || {
            let builder = service.server_builder();
            builder
                .backpressure_strategy(BackpressureStrategy::DiscardData)
                .create()
        })
    }

    /// The client's side of `plan`.
    pub fn plan_client(&self) -> Result<PlanClient, ServiceError> {
        let service = self.plan()?;
        self.create_port(PLAN, Self::full, || {
            let builder = service.client_builder();
            builder
                .backpressure_strategy(BackpressureStrategy::DiscardData)
                .create()
        })
    }

    /// A notifier, which wakes the wait sets of a service ([`Robot::wait_set`]).
    pub fn notifier(&self, service: &'static str) -> Result<Notifier, ServiceError> {
        let events = self.events(service)?;
        let notifier =
            self.create_port(service, Self::full, || events.notifier_builder().create())?;
        Ok(Notifier::new(notifier))
    }

    /// A wait set, which wakes up when something arrives at these services.
    pub fn wait_set<const N: usize>(
        &self,
        services: [&'static str; N],
    ) -> Result<WaitSet<N>, ServiceError> {
        let listeners = services.into_iter().map(|service| self.listener(service));
        Ok(WaitSet::new(listeners.collect::<Result<_, _>>()?))
    }

    fn listener(&self, service: &'static str) -> Result<Listener<ipc::Service>, ServiceError> {
        let events = self.events(service)?;
        self.create_port(service, Self::full, || events.listener_builder().create())
    }

    fn stream<M: Carried>(
        &self,
    ) -> Result<publish_subscribe::PortFactory<ipc::Service, M, ()>, ServiceError> {
        let Quality {
            buffer,
            history,
            overflow,
            publishers,
            subscribers,
        } = M::QUALITY.with_hosts(self.hosts);
        self.open(M::SERVICE, MessagingPattern::PublishSubscribe, |builder| {
            builder
                .publish_subscribe::<M>()
                .subscriber_max_buffer_size(buffer)
                .history_size(history)
                .enable_safe_overflow(overflow)
                .max_publishers(publishers)
                .max_subscribers(subscribers)
                .max_nodes(ONLOOKERS + publishers)
                .open_or_create()
        })
    }

    fn frames(
        &self,
    ) -> Result<publish_subscribe::PortFactory<ipc::Service, [u8], CameraFrame>, ServiceError> {
        let quality = CAMERA_QUALITY.with_hosts(self.hosts);
        self.open(CAMERA, MessagingPattern::PublishSubscribe, |builder| {
            builder
                .publish_subscribe::<[u8]>()
                .user_header::<CameraFrame>()
                .subscriber_max_buffer_size(quality.buffer)
                .history_size(quality.history)
                .enable_safe_overflow(quality.overflow)
                .max_publishers(quality.publishers)
                .max_subscribers(quality.subscribers)
                .max_nodes(ONLOOKERS + quality.publishers)
                .open_or_create()
        })
    }

    fn plan(
        &self,
    ) -> Result<
        request_response::PortFactory<ipc::Service, PlanRequest, (), PlanReply, ()>,
        ServiceError,
    > {
        self.open(PLAN, MessagingPattern::RequestResponse, |builder| {
            builder
                .request_response::<PlanRequest, PlanReply>()
                .max_servers(1)
                .max_clients(CLIENTS)
                .max_active_requests_per_client(2)
                .max_response_buffer_size(REPLIES)
                .enable_safe_overflow_for_requests(false)
                .enable_safe_overflow_for_responses(false)
                .max_nodes(ONLOOKERS + 1)
                .open_or_create()
        })
    }

    fn events(
        &self,
        service: &'static str,
    ) -> Result<event::PortFactory<ipc::Service>, ServiceError> {
        self.open(service, MessagingPattern::Event, |builder| {
            builder
                .event()
                // A woken listener checks the count of each id, of which the default has 256.
                .event_id_max_value(0)
                .max_notifiers(ONLOOKERS)
                .max_listeners(ONLOOKERS)
                .max_nodes(2 * ONLOOKERS)
                .open_or_create()
        })
    }
}

fn node_name(robot: &RobotName, role: Role) -> String {
    format!("nsrm/{robot}/{}", role.word())
}
