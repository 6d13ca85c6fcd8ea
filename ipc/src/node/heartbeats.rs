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

/// Another node, as known from its heartbeats.
#[derive(Debug, Clone, Copy, Default)]
pub struct Peer {
    /// When it was started and when its last heartbeat arrived, if any.
    known: Option<(u64, u64)>,
}

impl Peer {
    /// Records a heartbeat; returns whether it is from another process than the previous one.
    pub fn hear(&mut self, heartbeat: &Heartbeat, now_ns: u64) -> bool {
        let is_other = self
            .known
            .is_some_and(|(started_ns, _)| started_ns != heartbeat.started_ns);
        self.known = Some((heartbeat.started_ns, now_ns));
        is_other
    }

    /// Whether it may be alive: its last heartbeat, or the start of listening if none has arrived,
    /// is recent enough.
    ///
    /// * `since_ns`: when listening began
    pub fn may_be_alive(&self, since_ns: u64, silence_ns: u64, now_ns: u64) -> bool {
        let heard_ns = self.known.map_or(since_ns, |(_, heard_ns)| heard_ns);
        may_be_alive(heard_ns, silence_ns, now_ns)
    }

    /// If its last heartbeat is in the future, the clock was set back: it gets the whole timeout
    /// again.
    pub(super) fn not_after(&mut self, now_ns: u64) {
        if let Some((_, heard_ns)) = &mut self.known {
            *heard_ns = now_ns.min(*heard_ns);
        }
    }
}

/// Whether a node with a heartbeat at that time may be alive. A future time comes from a clock that
/// was set back, and counts like one in the past.
pub(super) const fn may_be_alive(heard_ns: u64, silence_ns: u64, now_ns: u64) -> bool {
    now_ns.abs_diff(heard_ns) <= silence_ns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn silence_and_a_new_process_are_noticed() {
        let heartbeat = |started_ns| Heartbeat {
            sequence: 1,
            timestamp_ns: 0,
            started_ns,
            rejected: 0,
            role: 1,
            state: 1,
        };
        let mut peer = Peer::default();
        assert!(peer.may_be_alive(10, 50, 60) && !peer.may_be_alive(10, 50, 61));
        assert!(!peer.hear(&heartbeat(5), 20));
        assert!(peer.may_be_alive(10, 50, 70) && !peer.may_be_alive(10, 50, 71));
        assert!(!peer.hear(&heartbeat(5), 30));
        assert!(peer.hear(&heartbeat(6), 40));
        // The clock is set back: a node with new heartbeats stays alive, one without does not for
        // long.
        let (mut heard, silent) = (peer, peer);
        heard.hear(&heartbeat(6), 2);
        assert!(heard.may_be_alive(10_000, 5, 3) && !silent.may_be_alive(10_000, 5, 3));
        // Or it gets the whole timeout again.
        let mut silent = silent;
        silent.not_after(3);
        assert!(silent.may_be_alive(10_000, 5, 8) && !silent.may_be_alive(10_000, 5, 9));
        silent.not_after(50);
        assert!(!silent.may_be_alive(10_000, 5, 50));
    }
}
