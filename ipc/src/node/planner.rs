//! The planner as a process: takes sentences and scenes, sends commands and replies.

use core::sync::atomic::{AtomicBool, Ordering};
use core::time::Duration;

use iceoryx2::active_request::ActiveRequest;
use iceoryx2::prelude::*;
use nsrm_core::Model;
use tracing::{debug, info, warn};

use super::heartbeats::{HEARTBEAT_NS, Heartbeats};
use super::peer::Peer;
use crate::clock::{is_due, now_ns};
use crate::executive::{Event, Executive, Failure, Limits, Sentence};
use crate::message::{
    Asked, Feedback, PlanReply, PlanRequest, ReplyTo, Role, SceneMessage, State, SubGoal,
};
use crate::service::{Carried, PLAN, PlanServer, Receiver, Robot, Sender, ServiceError};

/// Whether there is more work to do now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum PollStatus {
    /// Nothing to do until something arrives or time passes.
    Idle,
    /// Call [`PlannerNode::poll`] again.
    Working,
}

/// The longest sleep when nothing arrives, which bounds the delay of timeouts.
const NAP: Duration = Duration::from_millis(20);

/// How many requests one call of [`PlannerNode::poll`] answers, so that a flood of requests cannot
/// block its work.
const REQUESTS_AT_ONCE: usize = 16;

type Active = ActiveRequest<ipc::Service, PlanRequest, (), PlanReply, ()>;

/// A robot's planner.
#[derive(Debug)]
pub struct PlannerNode<'m> {
    robot: Robot,
    server: PlanServer,
    /// Requests without a connection.
    asked: Receiver<PlanRequest>,
    /// All replies, for observers and for clients without a connection.
    answers: Sender<PlanReply>,
    scenes: Receiver<SceneMessage>,
    commands: Sender<SubGoal>,
    feedback: Receiver<Feedback>,
    heartbeats: Heartbeats,
    controller: Peer,
    controller_alive: bool,
    began_ns: u64,
    silence_ns: u64,
    executive: Executive<'m>,
    current: Option<Current>,
    /// [`Event::Planned`], until it is published.
    planned: Option<Event>,
}

/// The request that is being executed.
#[derive(Debug)]
struct Current {
    /// The connection, if it has one.
    active: Option<Active>,
    to: ReplyTo,
    sentence: Sentence,
}

impl<'m> PlannerNode<'m> {
    /// Joins a robot as its planner.
    ///
    /// ```no_run
    /// use core::sync::atomic::AtomicBool;
    ///
    /// use iceoryx2::config::Config;
    /// use nsrm_ipc::executive::Limits;
    /// use nsrm_ipc::message::Role;
    /// use nsrm_ipc::node::PlannerNode;
    /// use nsrm_ipc::service::Robot;
    /// use nsrm_tabletop::TABLETOP;
    ///
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// static STOP: AtomicBool = AtomicBool::new(false); // set by a signal handler
    ///
    /// let robot = Robot::join("left".parse()?, Role::Planner, Config::global_config())?;
    /// let mut planner = PlannerNode::begin(robot, &TABLETOP, Limits::default())?;
    /// planner.run(&STOP)?;
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`ServiceError`], for instance [`ServiceError::Taken`] if the robot has a planner.
    pub fn begin(robot: Robot, model: &'m Model<'m>, limits: Limits) -> Result<Self, ServiceError> {
        let now_ns = now_ns();
        Ok(Self {
            server: robot.plan_server()?,
            asked: robot.receiver()?,
            answers: robot.sender()?,
            scenes: robot.receiver()?,
            commands: robot.sender()?,
            feedback: robot.receiver()?,
            heartbeats: Heartbeats::begin(&robot, Role::Planner, now_ns)?,
            controller: Peer::default(),
            controller_alive: true,
            began_ns: now_ns,
            silence_ns: limits.silence_ns,
            executive: Executive::new(model, limits, now_ns),
            current: None,
            planned: None,
            robot,
        })
    }

    /// Runs until `stop` is set, then stops a running motion. Sleeps while there is nothing to do.
    pub fn run(&mut self, stop: &AtomicBool) -> Result<(), ServiceError> {
        let ended = self.work_until(stop);
        self.give_up(now_ns());
        ended
    }

    fn work_until(&mut self, stop: &AtomicBool) -> Result<(), ServiceError> {
        let wait_set = self.robot.wait_set([
            PLAN,
            PlanRequest::SERVICE,
            SceneMessage::SERVICE,
            Feedback::SERVICE,
        ])?;
        let mut burial_ns = 0;
        while !stop.load(Ordering::Relaxed) {
            self.work(now_ns());
            // After the work: it takes some hundreds of microseconds.
            if is_due(burial_ns, now_ns(), HEARTBEAT_NS) {
                self.robot.cleanup_dead_nodes();
                burial_ns = now_ns().saturating_add(HEARTBEAT_NS);
            }
            wait_set
                .wait(NAP)
                .map_err(|error| self.robot.fault(PLAN, &error))?;
        }
        Ok(())
    }

    /// Stops a running motion, and tells the client that the planner was stopped. Dropping the node
    /// does the same.
    pub fn give_up(&mut self, now_ns: u64) {
        self.executive.cancel();
        if let Event::Stop(id) = self.executive.poll(now_ns) {
            self.send(&SubGoal::stop(id));
        }
        self.planned = None;
        if let Some(current) = self.current.take() {
            let said = PlanReply::refused(current.to, "stopping", "the planner was stopped");
            reply(&self.answers, current.active.as_ref(), &said);
        }
    }

    /// Receives what has arrived and does one unit of work ([`Executive::poll`]); never waits. For
    /// use in your own loop.
    ///
    /// Cost: some microseconds besides the unit of work. The first call after a process, such as a
    /// client, has joined or left maps or unmaps its memory: up to 0.4 ms were measured
    /// (`docs/processes`).
    pub fn poll(&mut self, now_ns: u64) -> PollStatus {
        self.take_in(now_ns);
        self.go_on(now_ns)
    }

    /// Receives what has arrived and does all resulting work, at most that of one sentence; never
    /// waits. Polling every port for each unit of work would take longer than the work.
    pub fn work(&mut self, now_ns: u64) {
        self.take_in(now_ns);
        while self.go_on(now_ns) == PollStatus::Working {}
    }

    fn take_in(&mut self, now_ns: u64) {
        self.hear_life(now_ns);
        self.hear_feedback(now_ns);
        self.see(now_ns);
        self.hear_requests(now_ns);
        let connection = self.current.as_ref().and_then(|it| it.active.as_ref());
        if connection.is_some_and(|active| !active.is_connected()) {
            self.executive.cancel();
        }
    }

    fn go_on(&mut self, now_ns: u64) -> PollStatus {
        let event = self.executive.poll(now_ns);
        let busyness = match event {
            Event::Waiting => PollStatus::Idle,
            _ => PollStatus::Working,
        };
        self.act(event);
        busyness
    }

    /// How many messages it has rejected: heartbeats, scenes, feedback, requests.
    pub const fn rejected(&self) -> u64 {
        self.heartbeats.rejected()
    }

    fn hear_life(&mut self, now_ns: u64) {
        let mut lost = false;
        let (heartbeats, controller) = (&mut self.heartbeats, &mut self.controller);
        heartbeats.receive(now_ns, |role, _, heartbeat| {
            if role == Role::Controller {
                lost |= controller.hear(heartbeat, now_ns);
            }
        });
        self.controller_alive = controller.may_be_alive(self.began_ns, self.silence_ns, now_ns);
        if lost || !self.controller_alive {
            self.executive.on_controller_lost();
        }
        let state = if self.current.is_some() {
            State::Busy
        } else {
            State::Idle
        };
        if let Err(failure) = heartbeats.beat(state, now_ns) {
            warn!(%failure, "heartbeat not sent");
        }
    }

    fn hear_feedback(&mut self, now_ns: u64) {
        for feedback in self.feedback.waiting() {
            if let Err(error) = self.executive.on_feedback(&feedback, now_ns) {
                self.heartbeats.reject(Feedback::SERVICE, &error, now_ns);
            }
        }
    }

    fn see(&mut self, now_ns: u64) {
        if let Ok(Some(scene)) = self.scenes.receive()
            && let Err(fault) = self.executive.on_scene(&scene, now_ns)
        {
            self.heartbeats
                .reject(SceneMessage::SERVICE, &fault, now_ns);
        }
    }

    fn hear_requests(&mut self, now_ns: u64) {
        for _ in 0..REQUESTS_AT_ONCE {
            let Ok(Some(active)) = self.server.receive() else {
                break;
            };
            let request = *active;
            self.hear_request(&request, Some(active), now_ns);
        }
        for _ in 0..REQUESTS_AT_ONCE {
            let Ok(Some(request)) = self.asked.receive() else {
                break;
            };
            self.hear_request(&request, None, now_ns);
        }
    }

    fn hear_request(&mut self, request: &PlanRequest, active: Option<Active>, now_ns: u64) {
        let mut to = ReplyTo {
            client: request.client,
            request: request.sequence,
            plan: 0,
            number: 1,
        };
        let said = match request.read() {
            Ok(Asked::Follow { sentence, mode }) => {
                match self.executive.ask(sentence.clone(), mode) {
                    Ok(plan) => {
                        debug!(
                            plan,
                            sentence = sentence.as_str(),
                            ?mode,
                            "request received"
                        );
                        to.plan = plan;
                        self.current = Some(Current {
                            active,
                            to,
                            sentence,
                        });
                        return;
                    }
                    Err(busy) => Some(PlanReply::refused(to, "busy", busy)),
                }
            }
            Ok(Asked::Cancel) => {
                let is_it = self.current.as_ref().is_some_and(|current| {
                    (current.to.client, current.to.request) == (to.client, to.request)
                });
                if is_it {
                    self.executive.cancel();
                    // A cancel is acknowledged on its own connection only: to all others it would
                    // look like the end of the sentence, which follows.
                    let heard = Event::Ended(Ok(()));
                    let heard = PlanReply::about(to, &heard, self.executive.model(), "");
                    if let (Some(active), Some(heard)) = (active, heard) {
                        answer(&active, &heard);
                    }
                    return;
                } else {
                    let message = "no request with this number is being executed";
                    Some(PlanReply::refused(to, "no_such_request", message))
                }
            }
            Err(error) => {
                self.heartbeats.reject(PLAN, &error, now_ns);
                Some(PlanReply::refused(to, "bad_request", error))
            }
        };
        if let Some(said) = said {
            reply(&self.answers, active.as_ref(), &said);
        }
    }

    /// Sends what an event requires. A plan is published after the command that follows it, since
    /// the robot waits for the command.
    fn act(&mut self, event: Event) {
        self.command(&event);
        if matches!(event, Event::Planned(_)) {
            self.planned = Some(event);
            return;
        }
        if let Some(planned) = self.planned.take() {
            self.tell(&planned);
        }
        self.tell(&event);
    }

    /// Sends the command or stop of an event to the controller.
    fn command(&mut self, event: &Event) {
        match event {
            // A controller that hangs would execute it later, whatever has been sent since.
            Event::Command(_) if !self.controller_alive => self.executive.on_command_undelivered(),
            Event::Command(command) => self.send(&SubGoal::from(command)),
            Event::Stop(id) => self.send(&SubGoal::stop(*id)),
            Event::Again { step, why } => warn!(step, %why, "retrying"),
            _ => {}
        }
    }

    /// Tells the client about an event.
    fn tell(&mut self, event: &Event) {
        let Some(current) = &mut self.current else {
            return;
        };
        let (model, sentence) = (self.executive.model(), current.sentence.as_str());
        if let Some(said) = PlanReply::about(current.to, event, model, sentence) {
            reply(&self.answers, current.active.as_ref(), &said);
            current.to.number = current.to.number.saturating_add(1);
        }
        let plan = current.to.plan;
        match event {
            // After the command, for which the robot waits, since logging may be slow.
            Event::Planned(_) => info!(plan, sentence, "planned"),
            Event::Ended(outcome) => {
                match outcome {
                    Ok(()) => info!(plan, sentence, "done"),
                    Err(Failure::Refused(refusal)) => {
                        let why = refusal.in_context(model, sentence);
                        info!(plan, sentence, %why, "refused");
                    }
                    Err(why) => warn!(plan, sentence, %why, "failed"),
                }
                self.current = None;
            }
            _ => {}
        }
    }

    fn send(&mut self, command: &SubGoal) {
        match self.commands.send(command) {
            Ok(0) => self.executive.on_command_undelivered(),
            Ok(_) => {}
            Err(failure) => {
                warn!(%failure, "command not sent");
                self.executive.on_command_undelivered();
            }
        }
    }
}

/// However the planner ends, also by an error or a panic, the robot does not continue alone.
impl Drop for PlannerNode<'_> {
    fn drop(&mut self) {
        self.give_up(now_ns());
    }
}

/// Sends a reply to the client, and publishes it for observers.
///
/// * `active`: the client's connection, if there is one. If the client is gone, its request is
///   cancelled; if it does not read its replies, it loses them
fn reply(answers: &Sender<PlanReply>, active: Option<&Active>, said: &PlanReply) {
    if let Some(active) = active {
        answer(active, said);
    }
    if let Err(failure) = answers.send(said) {
        warn!(%failure, "reply not published");
    }
}

/// Sends a reply over a connection.
fn answer(active: &Active, said: &PlanReply) {
    if let Err(error) = active.send_copy(*said) {
        warn!(?error, "reply not sent");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A death is detected within half a second; three lost heartbeats do not count as one.
    #[test]
    fn naps_and_silence_keep_what_is_promised() {
        let silence_ns = Limits::default().silence_ns;
        // The last heartbeat is received up to one nap late, and the timeout is detected another
        // one late.
        let noticed_ns = u128::from(silence_ns) + 2 * NAP.as_nanos();
        assert!(noticed_ns <= 500_000_000, "{noticed_ns}");
        assert!(silence_ns > 3 * HEARTBEAT_NS);
    }
}
