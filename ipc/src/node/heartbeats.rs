//! Heartbeats: every node sends one ten times a second, and detects nodes that stop.

use core::fmt::Display;

use super::rejected::Rejected;
use crate::clock::is_due;
use crate::message::{Heartbeat, Role, State};
use crate::service::{Carried, Receiver, Robot, SendFailure, Sender, ServiceError};

/// Time between two heartbeats of a node, nanoseconds.
pub const HEARTBEAT_NS: u64 = 100_000_000;

/// A node's own heartbeat, and those of others.
///
/// ```no_run
/// use core::time::Duration;
///
/// use iceoryx2::config::Config;
/// use nsrm_ipc::clock::now_ns;
/// use nsrm_ipc::message::{Role, State};
/// use nsrm_ipc::node::Heartbeats;
/// use nsrm_ipc::service::Robot;
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let robot = Robot::join("left".parse()?, Role::Controller, Config::global_config())?;
/// let mut heartbeats = Heartbeats::begin(&robot, Role::Controller, now_ns())?;
/// loop {
///     heartbeats.beat(State::Idle, now_ns())?;
///     // … the node's work …
///     std::thread::sleep(Duration::from_millis(20));
/// }
/// # }
/// ```
#[derive(Debug)]
pub struct Heartbeats {
    sender: Sender<Heartbeat>,
    receiver: Receiver<Heartbeat>,
    own: Heartbeat,
    next_ns: u64,
    rejected: Rejected,
}

impl Heartbeats {
    /// Not yet received.
    pub fn begin(robot: &Robot, role: Role, now_ns: u64) -> Result<Self, ServiceError> {
        Ok(Self {
            sender: robot.sender()?,
            receiver: robot.receiver()?,
            own: Heartbeat {
                sequence: 0,
                timestamp_ns: now_ns,
                started_ns: now_ns,
                rejected: 0,
                role: role as u32,
                state: State::Starting as u32,
            },
            next_ns: now_ns,
            rejected: Rejected::default(),
        })
    }

    /// Sends a heartbeat if one is due; returns whether it was.
    pub fn beat(&mut self, state: State, now_ns: u64) -> Result<bool, SendFailure> {
        if !is_due(self.next_ns, now_ns, HEARTBEAT_NS) {
            return Ok(false);
        }
        self.next_ns = now_ns.saturating_add(HEARTBEAT_NS);
        self.own.sequence = self.own.sequence.wrapping_add(1);
        self.own.timestamp_ns = now_ns;
        self.own.rejected = self.rejected.count();
        self.own.state = state as u32;
        self.sender.send(&self.own).map(|_| true)
    }

    /// When the next heartbeat is due.
    pub const fn next_ns(&self) -> u64 {
        self.next_ns
    }

    /// Receives the heartbeats of others; invalid ones are rejected.
    pub fn receive(&mut self, now_ns: u64, mut heard: impl FnMut(Role, State, &Heartbeat)) {
        for heartbeat in self.receiver.waiting() {
            match heartbeat.read() {
                Ok((role, state)) => heard(role, state, &heartbeat),
                Err(error) => self.rejected.add(Heartbeat::SERVICE, &error, now_ns),
            }
        }
    }

    /// Counts a rejected message; the count is sent with the heartbeats. At most one per second is
    /// logged.
    ///
    /// * `service`: the service of the message
    pub fn reject(&mut self, service: &str, why: &dyn Display, now_ns: u64) {
        self.rejected.add(service, why, now_ns);
    }

    /// How many messages the node has rejected.
    pub const fn rejected(&self) -> u64 {
        self.rejected.count()
    }
}
