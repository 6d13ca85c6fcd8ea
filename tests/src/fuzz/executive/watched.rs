//! The independent specification of what the loop may do: a running sentence, as seen from outside.

use nsrm_core::{MAX_STEPS, Model};
use nsrm_ipc::executive::{Command, CommandId, Event, Failure, Limits, Mode, Sentence};
use nsrm_ipc::message::{Order, Outcome, PlanReply, Reply, ReplyTo, Report, SubGoal};

use crate::fuzz::says;
use crate::plans::check;

/// A running sentence, as seen from outside.
#[derive(Debug)]
pub(super) struct Watched {
    plan: u64,
    mode: Mode,
    sentence: Sentence,
    /// Of the program, once it is known.
    steps: usize,
    commands: u32,
    retries: u8,
    reached: [bool; MAX_STEPS],
    /// The last command sent to the controller, when, and the first end reported for it.
    last: Option<(Command, u64)>,
    ended: Option<Outcome>,
    /// When it first reported that it had accepted it.
    accepted_ns: Option<u64>,
    is_lost: bool,
    /// Whether the last command could not be delivered, as far as is known.
    is_missed: bool,
    is_stopping: bool,
    cancelled_ns: Option<u64>,
    /// The latest time at which the scene of the last plan was taken; `None` after a command of it
    /// was sent.
    planned_ns: Option<u64>,
    /// How many commands each step has taken.
    attempts: [u8; MAX_STEPS],
}

/// What is known outside when an event occurs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Now<'a> {
    pub(super) model: &'a Model<'a>,
    pub(super) limits: &'a Limits,
    pub(super) now_ns: u64,
    /// When the latest scene that was accepted had been taken.
    pub(super) seen_ns: u64,
}

impl Watched {
    pub(super) fn new(plan: u64, mode: Mode, sentence: Sentence) -> Self {
        Self {
            plan,
            mode,
            sentence,
            steps: 0,
            commands: 0,
            retries: 0,
            reached: [false; MAX_STEPS],
            last: None,
            ended: None,
            accepted_ns: None,
            is_lost: false,
            is_missed: false,
            is_stopping: false,
            cancelled_ns: None,
            planned_ns: None,
            attempts: [0; MAX_STEPS],
        }
    }

    pub(super) const fn plan(&self) -> u64 {
        self.plan
    }

    /// The controller reports this outcome; for another command it is ignored.
    pub(super) fn hear(&mut self, report: &Report, now_ns: u64) {
        if !self.last.is_some_and(|(last, _)| last.id == report.id) {
            return;
        }
        self.is_missed = false;
        if report.outcome.is_end() {
            self.ended.get_or_insert(report.outcome);
        } else {
            self.accepted_ns.get_or_insert(now_ns);
        }
    }

    pub(super) fn cancel(&mut self, now_ns: u64) {
        self.cancelled_ns.get_or_insert(now_ns);
    }

    pub(super) fn on_controller_lost(&mut self) {
        self.is_lost = true;
    }

    pub(super) fn on_command_undelivered(&mut self) {
        let is_unheard = self.accepted_ns.is_none() && self.ended.is_none() && !self.is_lost;
        self.is_missed |= self.last.is_some() && is_unheard;
    }

    /// Whether the controller may still accept the last command, or is executing it.
    fn may_go_on(&self) -> bool {
        self.last.is_some() && self.ended.is_none() && !self.is_missed
    }

    /// Checks that this event is allowed.
    pub(super) fn follow(&mut self, event: &Event, now: Now<'_>) {
        self.reply(event, now.model);
        match event {
            Event::Working => {}
            Event::Waiting => self.wait(now.limits, now.now_ns),
            Event::Planned(plan) => {
                check(now.model, plan);
                // In a scene taken after the last command, and not too old.
                let age_ns = now.now_ns.saturating_sub(now.seen_ns);
                assert!(age_ns <= now.limits.scene_age_ns, "{self:?}");
                assert!(now.seen_ns > self.sent_ns(), "{self:?}");
                self.steps = plan.program().steps().len();
                self.planned_ns = Some(now.seen_ns);
            }
            Event::Command(command) => self.command(command, &now),
            &Event::Stop(id) => self.stop(id),
            &Event::Clearing { step, object, .. } => {
                // For the current command, and not before the loop was told.
                let (command, _) = self.last.expect("something is carried out");
                assert_eq!(
                    (command.step, command.planned.object.object),
                    (step, object)
                );
                assert!(self.accepted_ns.is_some() && !self.is_stopping, "{self:?}");
            }
            &Event::Reached { step, off_m } => {
                if self.mode == Mode::ClosedLoop {
                    let tolerance_m = now.limits.tolerance_m;
                    assert!((0.0..=tolerance_m).contains(&off_m), "{off_m}");
                    assert!(now.seen_ns > self.sent_ns());
                } else {
                    assert!(off_m.is_nan());
                }
                self.reach(step);
            }
            Event::Again { step, why } => {
                assert!(usize::from(*step) < self.steps);
                self.blame(why);
                self.retries += 1;
                assert!(self.retries <= now.limits.retries, "{self:?}");
            }
            Event::Ended(result) => self.end(result),
        }
    }

    /// When the last command was sent; 0 before the first.
    fn sent_ns(&self) -> u64 {
        self.last.map_or(0, |(_, sent_ns)| sent_ns)
    }

    /// Checks that the client can read the reply for the event.
    fn reply(&self, event: &Event, model: &Model<'_>) {
        let to = ReplyTo {
            client: 1,
            request: 2,
            plan: self.plan,
            number: 1,
        };
        let Some(reply) = PlanReply::about(to, event, model, &self.sentence) else {
            let is_silent = matches!(event, Event::Waiting | Event::Working | Event::Stop(_));
            assert!(is_silent, "{event:?}");
            return;
        };
        let said = reply.read().expect("what is said can be read");
        let is_same = match (event, said) {
            (Event::Planned(plan), Reply::Planned { steps, .. }) => {
                let grounded = steps.iter().filter(|step| step.is_grounded()).count();
                grounded == plan.steps().len() && steps.len() == plan.program().steps().len()
            }
            (Event::Command(command), Reply::Commanded { step }) => step == u32::from(command.step),
            (
                Event::Clearing { step, .. },
                Reply::Clearing {
                    step: said,
                    message,
                },
            ) => said == u32::from(*step) && !message.is_empty(),
            (Event::Reached { step, .. }, Reply::Reached { step: said, .. }) => {
                said == u32::from(*step)
            }
            (
                Event::Again { why, .. },
                Reply::Again {
                    reason, message, ..
                },
            )
            | (Event::Ended(Err(why)), Reply::Failed { reason, message }) => {
                reason == why.kind() && !message.is_empty()
            }
            (Event::Ended(Ok(())), Reply::Done) => true,
            _ => false,
        };
        assert!(is_same, "{event:?} is told as {said:?}");
    }

    fn wait(&self, limits: &Limits, now_ns: u64) {
        let Some((_, sent_ns)) = self.last else {
            return;
        };
        // The loop waits for a command no longer than it may take, however often the controller
        // reports that it has accepted it.
        if self.ended.is_none() && self.mode != Mode::PlanOnly && !self.is_stopping {
            let (since_ns, most_ns) = match self.accepted_ns {
                Some(accepted_ns) => (accepted_ns, limits.move_wait_ns),
                None => (sent_ns, limits.accept_wait_ns),
            };
            assert!(now_ns.saturating_sub(since_ns) <= most_ns, "{self:?}");
        }
    }

    fn command(&mut self, command: &Command, now: &Now<'_>) {
        let (limits, now_ns) = (now.limits, now.now_ns);
        assert!(self.mode != Mode::PlanOnly && !self.is_stopping);
        assert_eq!(self.cancelled_ns, None);
        // The caller may be delayed after the plan.
        if self.mode == Mode::ClosedLoop {
            // An object that is put back to its old place is not planned, but observed.
            let seen_ns = self.planned_ns.take().unwrap_or(now.seen_ns);
            assert!(seen_ns > self.sent_ns(), "{self:?}");
            let age_ns = now_ns.saturating_sub(seen_ns);
            assert!(age_ns <= limits.scene_age_ns, "{self:?}");
        }
        // Never two at once, and never the same number twice.
        assert!(self.last.is_none() || self.ended.is_some(), "{self:?}");
        let id = CommandId {
            plan: self.plan,
            command: self.commands + 1,
        };
        assert_eq!(command.id, id);
        self.commands += 1;
        assert_eq!(usize::from(command.steps), self.steps);
        assert!(command.step < command.steps);
        let most = self.steps * (usize::from(limits.retries) + 1);
        assert!(self.commands as usize <= most, "{self:?}");
        let attempts = &mut self.attempts[usize::from(command.step)];
        *attempts += 1;
        assert!(*attempts <= limits.attempts, "{self:?}");
        let sub_goal = SubGoal::from(command);
        let order = sub_goal
            .read(now_ns)
            .expect("what is commanded can be read");
        let Order::Move { object, pose } = order else {
            panic!("{order:?}");
        };
        assert_eq!(object, command.planned.object.object);
        let off = pose.translation.vector - command.planned.sub_goal.pose.translation.vector;
        assert_eq!(off.norm(), 0.0);
        self.last = Some((*command, now_ns));
        self.ended = None;
        self.accepted_ns = None;
        (self.is_lost, self.is_missed) = (false, false);
    }

    fn stop(&mut self, id: CommandId) {
        assert!(!self.is_stopping, "stopped twice: {self:?}");
        assert_eq!(self.last.map(|(command, _)| command.id), Some(id));
        assert!(self.may_go_on(), "{self:?}");
        self.is_stopping = true;
    }

    fn reach(&mut self, step: u8) {
        assert!(usize::from(step) < self.steps);
        assert_eq!(self.ended, Some(Outcome::Reached), "{self:?}");
        self.reached[usize::from(step)] = true;
    }

    /// The controller's first report counts.
    fn blame(&self, why: &Failure) {
        says(why);
        if matches!(why, Failure::NotAccepted { .. }) {
            assert!(self.accepted_ns.is_none(), "{self:?}");
            assert_ne!(self.ended, Some(Outcome::Reached), "{self:?}");
        }
        if let Failure::Unsuccessful { outcome, .. } = why {
            assert_eq!(self.ended, Some(*outcome), "{self:?}");
            assert_ne!(*outcome, Outcome::Reached);
        }
    }

    fn end(&self, result: &Result<(), Failure>) {
        // However it ends, and whatever arrived in the same turn.
        assert!(self.is_stopping || !self.may_go_on(), "{self:?}");
        match result {
            Ok(()) if self.mode == Mode::PlanOnly => assert_eq!(self.commands, 0),
            Ok(()) => assert!(self.steps > 0 && self.reached[..self.steps].iter().all(|it| *it)),
            Err(why) => {
                self.blame(why);
                let is_cancelled =
                    matches!(why, Failure::Cancelled | Failure::CancelledUnconfirmed);
                assert!(!is_cancelled || self.cancelled_ns.is_some(), "{self:?}");
            }
        }
    }
}
