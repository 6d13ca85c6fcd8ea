//! Who looks on: who lives, what flows, and what was said last.

use heapless::Deque;

use crate::message::{Feedback, Heartbeat, PlanReply, Role, SceneMessage, State};
use crate::service::{Receiver, Robot, ServiceError};

/// How many of the last replies are kept.
const REPLIES: usize = 8;
/// Share of the newest interval in a rate.
const NEWEST: f64 = 0.1;

/// A node as its heartbeats tell of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodeView {
    /// What it is.
    pub role: Role,
    /// What it does.
    pub state: State,
    /// When it was started, nanoseconds.
    pub started_ns: u64,
    /// When it was heard last, nanoseconds.
    pub heard_ns: u64,
    /// How often it was started anew while it was watched.
    pub restarts: u32,
}

/// A stream of messages.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Flow {
    /// How many came.
    pub count: u64,
    /// How many are missing, by their numbers; a new publisher begins anew.
    pub lost: u64,
    /// Messages a second, the last ten or so.
    pub rate_hz: f64,
    /// When the last one was made (for a scene: when its picture was taken),
    /// nanoseconds.
    pub made_ns: u64,
    /// How long it had been on its way when it was seen here, nanoseconds.
    pub latency_ns: u64,
    sequence: u64,
}

impl Flow {
    fn hear(&mut self, sequence: u64, made_ns: u64, now_ns: u64) {
        if self.count > 0 {
            let passed_s = made_ns.saturating_sub(self.made_ns) as f64 * 1e-9;
            let steps = sequence.saturating_sub(self.sequence);
            if steps > 0 && passed_s > 0.0 {
                let rate_hz = steps as f64 / passed_s;
                self.rate_hz += if self.rate_hz == 0.0 {
                    rate_hz
                } else {
                    NEWEST * (rate_hz - self.rate_hz)
                };
            }
            self.lost += steps.saturating_sub(1);
        }
        self.count += 1;
        self.sequence = sequence;
        self.made_ns = made_ns;
        self.latency_ns = now_ns.saturating_sub(made_ns);
    }
}

/// All that is known of a robot.
#[derive(Debug, Clone, Default)]
pub struct View {
    /// The nodes that were heard, in the order of their roles.
    pub nodes: [Option<NodeView>; Role::ALL.len()],
    /// Scenes. Of those that come faster than they are looked for some count as lost.
    pub scenes: Flow,
    /// Objects in the last one.
    pub objects: u32,
    /// What the controller says.
    pub feedback: Flow,
    /// What the planner said last, the latest last.
    pub replies: Deque<PlanReply, REPLIES>,
}

/// Looks on; changes nothing.
#[derive(Debug)]
pub struct Watcher {
    heartbeats: Receiver<Heartbeat>,
    scenes: Receiver<SceneMessage>,
    feedback: Receiver<Feedback>,
    answers: Receiver<PlanReply>,
    view: View,
    _robot: Robot,
}

impl Watcher {
    /// Takes one of the onlookers' places at a robot.
    pub fn begin(robot: Robot) -> Result<Self, ServiceError> {
        Ok(Self {
            heartbeats: robot.receiver()?,
            scenes: robot.receiver()?,
            feedback: robot.receiver()?,
            answers: robot.receiver()?,
            view: View::default(),
            _robot: robot,
        })
    }

    /// Takes in what has come, and what is known now. A stream that can't be read now
    /// is read by the next call.
    pub fn look(&mut self, now_ns: u64) -> &View {
        let view = &mut self.view;
        while let Ok(Some(heartbeat)) = self.heartbeats.receive() {
            hear(&mut view.nodes, &heartbeat, now_ns);
        }
        while let Ok(Some(scene)) = self.scenes.receive() {
            view.scenes.hear(scene.sequence, scene.timestamp_ns, now_ns);
            view.objects = scene.count;
        }
        while let Ok(Some(feedback)) = self.feedback.receive() {
            let Feedback {
                sequence,
                timestamp_ns,
                ..
            } = *feedback;
            view.feedback.hear(sequence, timestamp_ns, now_ns);
        }
        while let Ok(Some(reply)) = self.answers.receive() {
            if view.replies.is_full() {
                let _ = view.replies.pop_front();
            }
            let _ = view.replies.push_back(*reply);
        }
        view
    }
}

fn hear(nodes: &mut [Option<NodeView>], heartbeat: &Heartbeat, now_ns: u64) {
    let Ok((role, state)) = heartbeat.read() else {
        return;
    };
    let Some(place) = nodes.get_mut(role as usize - 1) else {
        return;
    };
    let before = place.as_ref();
    let restarts = before.map_or(0, |before| {
        before.restarts + u32::from(before.started_ns != heartbeat.started_ns)
    });
    *place = Some(NodeView {
        role,
        state,
        started_ns: heartbeat.started_ns,
        heard_ns: now_ns,
        restarts,
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_and_rates_are_seen() {
        let mut flow = Flow::default();
        for (sequence, ms) in [(1, 0), (2, 100), (5, 400), (6, 500)] {
            flow.hear(sequence, ms * 1_000_000, (ms + 3) * 1_000_000);
        }
        assert_eq!((flow.count, flow.lost), (4, 2));
        assert!((flow.rate_hz - 10.0).abs() < 1e-9, "{}", flow.rate_hz);
        assert_eq!(flow.latency_ns, 3_000_000);
        // A publisher that was started anew.
        flow.hear(1, 600_000_000, 600_000_000);
        assert_eq!((flow.count, flow.lost), (5, 2));
    }

    #[test]
    fn a_node_that_was_started_anew_is_counted() {
        let mut nodes = [None; Role::ALL.len()];
        for (started_ns, restarts) in [(5, 0), (5, 0), (6, 1)] {
            let heartbeat = Heartbeat {
                sequence: 1,
                timestamp_ns: 0,
                started_ns,
                role: Role::Planner as u32,
                state: State::Idle as u32,
            };
            hear(&mut nodes, &heartbeat, 9);
            assert_eq!(nodes[2].map(|node| node.restarts), Some(restarts));
        }
        assert!(nodes[0].is_none());
    }
}
