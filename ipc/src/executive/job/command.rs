//! A command to the controller: sent, reported on, ended or stopped.

use nsrm_core::Refusal;

use super::Job;
use crate::executive::failure::Failure;
use crate::executive::limits::Limits;
use crate::executive::scene_gate::AHEAD_NS;
use crate::executive::stage::{CommandStatus, Stage, Tried};
use crate::executive::{Command, CommandId, Event, Mode};
use crate::message::{Outcome, Report};

impl Job<'_> {
    pub(super) fn send(&mut self, limits: &Limits, now_ns: u64) -> Result<Event, Failure> {
        // A plan has a step for each remaining one, of which there is at least one.
        let planned = self.next.ok_or(Failure::Refused(Refusal::InvalidModel))?;
        self.commands = self.commands.saturating_add(1);
        if let Some(attempts) = self.attempts.get_mut(self.step) {
            *attempts = attempts.saturating_add(1);
        }
        (self.clearing, self.has_cleared) = (None, false);
        self.belief.carry(planned.object.object);
        self.placements.take(self.step, planned.object.object);
        if self.is_shift() {
            // Sought anew once the object has moved, its goal would move on with it.
            self.placements.put(self.step, planned, None);
        }
        let command = Command {
            id: CommandId {
                plan: self.number,
                command: self.commands,
            },
            until_ns: now_ns.saturating_add(limits.accept_wait_ns),
            // Both are at most MAX_STEPS.
            step: self.step as u8,
            steps: self.steps() as u8,
            planned,
            keep: self.placements.kept(),
        };
        self.stage = Stage::Commanded {
            command,
            sent_ns: now_ns,
            since_ns: now_ns,
            heard: CommandStatus::Nothing,
        };
        Ok(Event::Command(command))
    }

    pub(in crate::executive) fn hear(&mut self, report: &Report, now_ns: u64) {
        match &mut self.stage {
            Stage::Commanded {
                command,
                sent_ns,
                since_ns,
                heard,
            } if command.id == report.id => match (report.outcome, &heard) {
                // It was delivered, whatever the sender reported.
                (Outcome::Accepted, CommandStatus::Nothing | CommandStatus::Undelivered) => {
                    *heard = CommandStatus::Accepted;
                    *since_ns = now_ns;
                }
                (
                    Outcome::Clearing,
                    CommandStatus::Nothing | CommandStatus::Undelivered | CommandStatus::Accepted,
                ) => {
                    if !matches!(heard, CommandStatus::Accepted) {
                        *heard = CommandStatus::Accepted;
                        *since_ns = now_ns;
                    }
                    self.clearing = Some(report.objects);
                    self.has_cleared = true;
                    for id in report.objects {
                        self.belief.carry(id);
                    }
                }
                // A repeated or late report extends no timeout and revokes nothing.
                (Outcome::Accepted | Outcome::Clearing, _) => {}
                // The first report counts; it may have been sent before the controller was lost.
                (
                    _,
                    CommandStatus::Nothing
                    | CommandStatus::Accepted
                    | CommandStatus::Lost
                    | CommandStatus::Undelivered,
                ) => {
                    // Not before the command, whatever the controller's clock says: an earlier
                    // scene does not show the result. Nor further in the future than a scene may
                    // be, or no scene would ever be later.
                    let latest_ns = now_ns.saturating_add(AHEAD_NS);
                    let timestamp_ns = report.timestamp_ns.min(latest_ns).max(*sent_ns);
                    *heard = CommandStatus::Ended(Report {
                        timestamp_ns,
                        ..*report
                    });
                }
                (_, CommandStatus::Ended(_)) => {}
            },
            Stage::Stopping {
                id,
                confirmed,
                begun,
                ..
            } if *id == report.id => {
                *begun |= matches!(
                    report.outcome,
                    Outcome::Accepted | Outcome::Clearing | Outcome::Reached
                );
                *confirmed |= report.outcome.is_end();
            }
            _ => {}
        }
    }

    pub(in crate::executive) fn on_controller_lost(&mut self) {
        if let Stage::Commanded { heard, .. } = &mut self.stage
            && matches!(heard, CommandStatus::Nothing | CommandStatus::Accepted)
        {
            *heard = CommandStatus::Lost;
        }
    }

    pub(in crate::executive) fn on_command_undelivered(&mut self) {
        if let Stage::Commanded { heard, .. } = &mut self.stage
            && matches!(heard, CommandStatus::Nothing)
        {
            *heard = CommandStatus::Undelivered;
        }
    }

    /// Waits for the outcome of a command.
    pub(super) fn await_outcome(
        &mut self,
        command: &Command,
        since_ns: u64,
        heard: CommandStatus,
        limits: &Limits,
        now_ns: u64,
    ) -> Result<Event, Failure> {
        let (step, waited_ns) = (command.step, now_ns.saturating_sub(since_ns));
        if let Some(first) = self.clearing.take() {
            let object = command.planned.object.object;
            return Ok(Event::Clearing {
                step,
                object,
                first,
            });
        }
        match heard {
            CommandStatus::Nothing if waited_ns > limits.accept_wait_ns => {
                Err(Failure::NotAccepted { step })
            }
            CommandStatus::Accepted if waited_ns > limits.move_wait_ns => {
                Err(Failure::NoOutcome { step })
            }
            CommandStatus::Nothing | CommandStatus::Accepted => Ok(Event::Waiting),
            CommandStatus::Lost => Err(Failure::ControllerLost { step }),
            CommandStatus::Undelivered => Err(Failure::NotAccepted { step }),
            CommandStatus::Ended(report) => self.end_command(command, &report, limits, now_ns),
        }
    }

    /// The controller reported the outcome of a command.
    fn end_command(
        &mut self,
        command: &Command,
        report: &Report,
        limits: &Limits,
        now_ns: u64,
    ) -> Result<Event, Failure> {
        let (step, at_ns, outcome) = (command.step, report.timestamp_ns, report.outcome);
        if outcome == Outcome::Reached {
            return self.end_reached(command, at_ns, now_ns);
        }
        let failure = Failure::Unsuccessful {
            step,
            outcome,
            objects: report.objects,
        };
        let is_closed = self.mode == Mode::ClosedLoop;
        if is_closed && outcome.may_be_tried_again() {
            let event = self.again(self.only(self.step), failure, limits)?;
            self.look_to_verify(at_ns, now_ns, Tried::Known);
            return Ok(event);
        }
        if is_closed && outcome.depends_on_others() {
            self.look_to_verify(at_ns, now_ns, Tried::Unable(failure));
            return Ok(Event::Working);
        }
        Err(failure)
    }

    fn end_reached(
        &mut self,
        command: &Command,
        at_ns: u64,
        now_ns: u64,
    ) -> Result<Event, Failure> {
        if self.mode == Mode::OpenLoop {
            self.placements.finish(self.step);
            self.stage = match self.placements.next(self.steps()) {
                Some(next) => {
                    self.step = next;
                    self.next = self.plan.steps().get(next).copied();
                    Stage::Send { seen: None }
                }
                None => Stage::Finished,
            };
            let (step, off_m) = (command.step, f32::NAN);
            return Ok(Event::Reached { step, off_m });
        }
        let (planned, reference) = (command.planned, self.reference);
        self.placements.put(self.step, planned, reference);
        self.look_to_verify(at_ns, now_ns, Tried::Reached);
        Ok(Event::Working)
    }

    /// Ends the sentence with a failure. A command that might still be accepted or executed is
    /// stopped first. Nothing else ends a sentence before its last step is done.
    pub(super) fn give_up(&mut self, why: Failure, now_ns: u64) -> Event {
        let Stage::Commanded {
            command: Command { id, .. },
            heard: heard @ (CommandStatus::Nothing | CommandStatus::Accepted | CommandStatus::Lost),
            ..
        } = self.stage
        else {
            return Event::Ended(Err(why));
        };
        self.stage = Stage::Stopping {
            id,
            since_ns: now_ns,
            is_lost: matches!(heard, CommandStatus::Lost),
            confirmed: false,
            begun: false,
            why,
        };
        Event::Stop(id)
    }
}

/// The failure of a sentence after a stop was sent.
pub(super) fn stopped(why: Failure, confirmed: bool, begun: bool) -> Failure {
    match why {
        Failure::Cancelled if !confirmed => Failure::CancelledUnconfirmed,
        // It reported late, or may have started without a report.
        Failure::NotAccepted { step } if begun || !confirmed => Failure::Unanswered { step },
        why => why,
    }
}
