//! Who lives: every node says so ten times a second, and notices who no longer does.

use core::fmt::Display;

use super::rejected::Rejected;
use crate::clock::is_due;
use crate::message::{Heartbeat, Role, State};
use crate::service::{Carried, Receiver, Robot, SendFailure, Sender, ServiceError};

/// Time between two heartbeats of a node, nanoseconds.
pub const HEARTBEAT_NS: u64 = 100_000_000;

/// A node's own heartbeat, and those of others.
#[derive(Debug)]
pub struct Heartbeats {
    sender: Sender<Heartbeat>,
    receiver: Receiver<Heartbeat>,
    own: Heartbeat,
    next_ns: u64,
    rejected: Rejected,
}

impl Heartbeats {
    /// Not yet heard of.
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

    /// Says that the node lives, when it is time to; whether it was.
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

    /// Takes in what others have said; what makes no sense is rejected.
    pub fn receive(&mut self, now_ns: u64, mut heard: impl FnMut(Role, State, &Heartbeat)) {
        for heartbeat in self.receiver.waiting() {
            match heartbeat.read() {
                Ok((role, state)) => heard(role, state, &heartbeat),
                Err(error) => self.rejected.add(Heartbeat::SERVICE, &error, now_ns),
            }
        }
    }

    /// Counts a message that the node has received and passes over; the count goes
    /// with its heartbeats. At most once a second one is logged.
    ///
    /// * `service`: through which it came
    pub fn reject(&mut self, service: &str, why: &dyn Display, now_ns: u64) {
        self.rejected.add(service, why, now_ns);
    }

    /// How many messages the node has passed over.
    pub const fn rejected(&self) -> u64 {
        self.rejected.count()
    }
}

/// Another node, as its heartbeats tell of it.
#[derive(Debug, Clone, Copy, Default)]
pub struct Peer {
    /// When it was started and last heard, if ever.
    known: Option<(u64, u64)>,
}

impl Peer {
    /// Takes in a heartbeat; whether it is from another process than the one
    /// before it.
    pub fn hear(&mut self, heartbeat: &Heartbeat, now_ns: u64) -> bool {
        let is_other = self
            .known
            .is_some_and(|(started_ns, _)| started_ns != heartbeat.started_ns);
        self.known = Some((heartbeat.started_ns, now_ns));
        is_other
    }

    /// Whether it may be alive: it was heard of, or is listened to if it never was, no longer
    /// ago than it may be silent.
    ///
    /// * `since_ns`: when listening began
    pub fn may_be_alive(&self, since_ns: u64, silence_ns: u64, now_ns: u64) -> bool {
        let heard_ns = self.known.map_or(since_ns, |(_, heard_ns)| heard_ns);
        may_be_alive(heard_ns, silence_ns, now_ns)
    }

    /// If it was heard later than now, the clock was set back since: it has as long again to be
    /// heard.
    pub(super) fn not_after(&mut self, now_ns: u64) {
        if let Some((_, heard_ns)) = &mut self.known {
            *heard_ns = now_ns.min(*heard_ns);
        }
    }
}

/// Whether who was heard then may be alive: no longer ago than it may be silent. A time that is
/// yet to come is that of a clock that was set back, and counts like one that has gone.
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
        // The clock is set back: who is heard again lives, who isn't does not for long.
        let (mut heard, silent) = (peer, peer);
        heard.hear(&heartbeat(6), 2);
        assert!(heard.may_be_alive(10_000, 5, 3) && !silent.may_be_alive(10_000, 5, 3));
        // Or it has as long again to be heard.
        let mut silent = silent;
        silent.not_after(3);
        assert!(silent.may_be_alive(10_000, 5, 8) && !silent.may_be_alive(10_000, 5, 9));
        silent.not_after(50);
        assert!(!silent.may_be_alive(10_000, 5, 50));
    }
}
