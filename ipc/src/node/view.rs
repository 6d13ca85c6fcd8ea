//! What an observer knows of a robot, from the messages that it has received.

use heapless::Deque;
use nsrm_core::scene::SCENE_SCHEMA;
use nsrm_core::{MAX_OBJECTS, SceneError};

use super::peer::may_be_alive;
use crate::message::{
    Feedback, FeedbackError, Heartbeat, HeartbeatError, PlanReply, PlanReplyError, Role,
    SceneMessage, State,
};

/// How many of the last replies are kept.
const REPLIES: usize = 8;
/// Share of the newest interval in a rate.
const NEWEST: f64 = 0.1;

/// A node, as known from its heartbeats.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct NodeView {
    /// Its role.
    pub role: Role,
    /// Its state.
    pub state: State,
    /// When it was started, nanoseconds.
    pub started_ns: u64,
    /// When its last heartbeat arrived, nanoseconds.
    pub heard_ns: u64,
    /// How often it has restarted while it was observed.
    pub restarts: u32,
    /// How many messages it has rejected since it was started.
    pub rejected: u64,
}

/// A stream of messages.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct Flow {
    /// How many have arrived.
    pub count: u64,
    /// How many are missing, by sequence number; a new publisher starts at zero.
    pub lost: u64,
    /// Messages per second, over about the last ten.
    pub rate_hz: f64,
    /// When the last one was made (for a scene: when its image was taken), nanoseconds.
    pub made_ns: u64,
    /// Its age on arrival, nanoseconds.
    pub latency_ns: u64,
    /// When it arrived, nanoseconds.
    pub heard_ns: u64,
    sequence: u64,
}

impl NodeView {
    /// Whether it may be alive: its last heartbeat is recent enough. A time in the future counts
    /// like one in the past.
    pub const fn is_alive(&self, silence_ns: u64, now_ns: u64) -> bool {
        may_be_alive(self.heard_ns, silence_ns, now_ns)
    }
}

impl Flow {
    /// The age of the last one, nanoseconds.
    pub const fn age_ns(&self, now_ns: u64) -> u64 {
        let heard_ns = now_ns.saturating_sub(self.heard_ns);
        heard_ns.saturating_add(self.latency_ns)
    }

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
            self.lost = self.lost.saturating_add(steps.saturating_sub(1));
        }
        self.count += 1;
        self.sequence = sequence;
        self.made_ns = made_ns;
        self.latency_ns = now_ns.saturating_sub(made_ns);
        self.heard_ns = now_ns;
    }
}

/// Everything known about a robot.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct View {
    /// The known nodes, in the order of their roles.
    pub nodes: [Option<NodeView>; Role::ALL.len()],
    /// Scenes. Those that arrive faster than they are polled count in part as lost.
    pub scenes: Flow,
    /// Objects in the last scene.
    pub objects: u32,
    /// Feedback of the controller.
    pub feedback: Flow,
    /// The planner's last replies, the latest last.
    pub replies: Deque<PlanReply, REPLIES>,
    /// How many messages were invalid; they are in none of the above.
    pub rejected: u64,
}

impl View {
    /// Times in the future come from a clock that was set back: they become the present time, and
    /// each node gets its whole timeout again.
    pub fn not_after(&mut self, now_ns: u64) {
        for node in self.nodes.iter_mut().flatten() {
            node.heard_ns = node.heard_ns.min(now_ns);
        }
        for flow in [&mut self.scenes, &mut self.feedback] {
            flow.heard_ns = flow.heard_ns.min(now_ns);
        }
    }

    /// Records a heartbeat.
    pub fn hear_heartbeat(
        &mut self,
        heartbeat: &Heartbeat,
        now_ns: u64,
    ) -> Result<(), HeartbeatError> {
        let (role, state) = heartbeat.read()?;
        let Some(place) = self.nodes.get_mut(role as usize - 1) else {
            return Ok(());
        };
        let before = place.as_ref();
        let restarts = before.map_or(0, |before| {
            let more = u32::from(before.started_ns != heartbeat.started_ns);
            before.restarts.saturating_add(more)
        });
        *place = Some(NodeView {
            role,
            state,
            started_ns: heartbeat.started_ns,
            heard_ns: now_ns,
            restarts,
            rejected: heartbeat.rejected,
        });
        Ok(())
    }

    /// Records a scene. Only a process with its model can check the rest.
    pub fn hear_scene(&mut self, scene: &SceneMessage, now_ns: u64) -> Result<(), SceneError> {
        let (got, count) = (scene.schema, scene.count);
        if got != SCENE_SCHEMA {
            return Err(SceneError::Schema { got });
        }
        if count as usize > MAX_OBJECTS {
            return Err(SceneError::TooManyObjects { count });
        }
        self.scenes.hear(scene.sequence, scene.timestamp_ns, now_ns);
        self.objects = count;
        Ok(())
    }

    /// Records feedback.
    pub fn hear_feedback(&mut self, feedback: &Feedback, now_ns: u64) -> Result<(), FeedbackError> {
        let made_ns = feedback.read()?.timestamp_ns;
        self.feedback.hear(feedback.sequence, made_ns, now_ns);
        Ok(())
    }

    /// Records a reply; the oldest one is dropped.
    pub fn hear_reply(&mut self, reply: &PlanReply) -> Result<(), PlanReplyError> {
        reply.read()?;
        if self.replies.is_full() {
            let _ = self.replies.pop_front();
        }
        let _ = self.replies.push_back(*reply);
        Ok(())
    }
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
        // A restarted publisher.
        flow.hear(1, 600_000_000, 600_000_000);
        assert_eq!((flow.count, flow.lost), (5, 2));
        // Implausible numbers.
        for sequence in [u64::MAX, 0, u64::MAX] {
            flow.hear(sequence, sequence, 0);
        }
        assert_eq!((flow.count, flow.lost), (8, u64::MAX));
    }

    fn heartbeat(started_ns: u64) -> Heartbeat {
        Heartbeat {
            sequence: 1,
            timestamp_ns: 0,
            started_ns,
            rejected: 3,
            role: Role::Planner as u32,
            state: State::Idle as u32,
        }
    }

    #[test]
    fn a_node_that_died_before_the_clock_was_set_back_does_not_live_on() {
        let mut view = View::default();
        let (silence_ns, heard_ns) = (50, 10_000);
        assert_eq!(view.hear_heartbeat(&heartbeat(5), heard_ns), Ok(()));
        view.scenes.hear(1, heard_ns - 7, heard_ns);
        let lives = |view: &View, now_ns| view.nodes[2].map(|it| it.is_alive(silence_ns, now_ns));
        assert_eq!(lives(&view, heard_ns + 51), Some(false));
        assert_eq!(lives(&view, 3000), Some(false));
        // It gets the whole timeout again.
        view.not_after(3000);
        assert_eq!(
            [3050, 3051].map(|it| lives(&view, it)),
            [Some(true), Some(false)]
        );
        assert_eq!(view.scenes.age_ns(3020), 27);
        view.not_after(3051);
        assert_eq!(lives(&view, 3051), Some(false));
    }

    #[test]
    fn a_node_that_was_started_anew_is_counted() {
        let mut view = View::default();
        for (started_ns, restarts) in [(5, 0), (5, 0), (6, 1)] {
            assert_eq!(view.hear_heartbeat(&heartbeat(started_ns), 9), Ok(()));
            let seen = view.nodes[2].map(|node| (node.restarts, node.rejected));
            assert_eq!(seen, Some((restarts, 3)));
        }
        assert!(view.nodes[0].is_none());
    }
}
