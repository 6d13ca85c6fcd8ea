//! What a node knows of another one, from its heartbeats.

use crate::message::Heartbeat;

/// Another node, as known from its heartbeats.
///
/// ```
/// use nsrm_ipc::message::{Heartbeat, Role, State};
/// use nsrm_ipc::node::Peer;
///
/// let silence_ns = 350_000_000;
/// let mut controller = Peer::default();
/// let heartbeat = Heartbeat {
///     sequence: 1,
///     timestamp_ns: 1_000_000_000,
///     started_ns: 900_000_000,
///     rejected: 0,
///     role: Role::Controller as u32,
///     state: State::Idle as u32,
/// };
/// assert!(!controller.hear(&heartbeat, 1_000_000_000));
/// assert!(controller.may_be_alive(0, silence_ns, 1_200_000_000));
/// assert!(!controller.may_be_alive(0, silence_ns, 1_400_000_000));
/// // It was started again.
/// let heartbeat = Heartbeat { started_ns: 1_450_000_000, ..heartbeat };
/// assert!(controller.hear(&heartbeat, 1_500_000_000));
/// ```
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
    pub fn not_after(&mut self, now_ns: u64) {
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
