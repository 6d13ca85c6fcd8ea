//! Whatever ends a sentence, and whatever else arrives before the same poll: a command that might
//! still be accepted or executed is stopped.

use nsrm_ipc::executive::{Command, Event, Failure, Limits, Mode};
use nsrm_ipc::message::Outcome;
use nsrm_tests::by_hand::Parts;

use crate::world::{MS, World};

/// What may arrive between two polls.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Arrival {
    Cancel,
    LoseController,
    MissController,
    SetClockBack,
    /// More time than a command may take to be accepted.
    LetTimePass,
    Hear(Outcome),
}

const ARRIVALS: [Arrival; 9] = [
    Arrival::Cancel,
    Arrival::LoseController,
    Arrival::MissController,
    Arrival::SetClockBack,
    Arrival::LetTimePass,
    Arrival::Hear(Outcome::Accepted),
    Arrival::Hear(Outcome::Clearing),
    Arrival::Hear(Outcome::Dropped),
    Arrival::Hear(Outcome::Reached),
];

/// Whether the controller may be executing a command, or start it, after these; derived by hand.
fn may_go_on(arrivals: &[Arrival]) -> bool {
    let (mut is_heard, mut is_lost, mut is_missed) = (false, false, false);
    for arrival in arrivals {
        match arrival {
            Arrival::Hear(outcome) if outcome.is_end() => return false,
            Arrival::Hear(_) => (is_heard, is_missed) = (true, false),
            Arrival::LoseController => is_lost = true,
            Arrival::MissController => is_missed |= !is_heard && !is_lost,
            _ => {}
        }
    }
    !is_missed
}

impl World<'_> {
    fn arrive(&mut self, command: &Command, arrival: Arrival) {
        match arrival {
            Arrival::Cancel => self.executive.cancel(),
            Arrival::LoseController => self.executive.on_controller_lost(),
            Arrival::MissController => self.executive.on_command_undelivered(),
            Arrival::SetClockBack => self.now_ns -= 5000 * MS,
            Arrival::LetTimePass => self.now_ns += Limits::default().accept_wait_ns + MS,
            Arrival::Hear(outcome) => self.say(command, outcome),
        }
    }

    /// Commands a step and lets these, and nothing else, arrive before the next poll; returns the
    /// number of stops sent, and the failure.
    fn end_with(&mut self, arrivals: &[Arrival]) -> (usize, Failure) {
        self.ask("put the red block on the blue block", Mode::ClosedLoop);
        self.see();
        let command = std::iter::from_fn(|| Some(self.executive.poll(self.now_ns)))
            .find_map(|event| match event {
                Event::Command(command) => Some(command),
                _ => None,
            })
            .unwrap();
        for arrival in arrivals {
            self.arrive(&command, *arrival);
        }
        let mut stops = 0;
        loop {
            match self.executive.poll(self.now_ns) {
                Event::Waiting => self.now_ns += 100 * MS,
                Event::Stop(id) => {
                    assert_eq!(id, command.id);
                    stops += 1;
                }
                Event::Ended(result) => return (stops, result.unwrap_err()),
                _ => {}
            }
        }
    }
}

#[test]
fn what_may_still_be_carried_out_is_stopped_whatever_ends_the_sentence() {
    let parts = Parts::new();
    let model = parts.model();
    let mut world = World::new(&model, Limits::default());
    // The clock is set back again and again.
    world.now_ns = 1_000_000_000 * MS;
    let none: &[Arrival] = &[];
    let mut rows: Vec<Vec<Arrival>> = vec![none.into()];
    for _ in 0..3 {
        let longer: Vec<Vec<Arrival>> = rows
            .iter()
            .flat_map(|row| ARRIVALS.map(|next| [&row[..], &[next]].concat()))
            .collect();
        for arrivals in &longer {
            let (stops, why) = world.end_with(arrivals);
            let may_go_on = may_go_on(arrivals);
            assert_eq!(stops, usize::from(may_go_on), "{arrivals:?}: {why:?}");
            if arrivals.contains(&Arrival::Cancel) {
                // No feedback has confirmed the stop.
                let expected = if may_go_on {
                    Failure::CancelledUnconfirmed
                } else {
                    Failure::Cancelled
                };
                assert_eq!(why, expected, "{arrivals:?}");
            }
        }
        rows = longer;
    }
}

/// It was only delayed: it continues with the accepted command unless it receives the stop.
#[test]
fn a_controller_that_is_lost_as_the_sentence_is_cancelled_is_stopped_and_not_waited_for() {
    let parts = Parts::new();
    let model = parts.model();
    let mut world = World::new(&model, Limits::default());
    world.ask("put the red block on the blue block", Mode::ClosedLoop);
    let command = world.until_command();
    world.say(&command, Outcome::Accepted);
    assert_eq!(world.executive.poll(world.now_ns), Event::Waiting);
    world.executive.cancel();
    world.executive.on_controller_lost();
    assert_eq!(world.executive.poll(world.now_ns), Event::Stop(command.id));
    // A replacement controller does not know the command.
    world.say(&command, Outcome::Stopped);
    let ended = world.executive.poll(world.now_ns);
    let unconfirmed = Failure::CancelledUnconfirmed;
    assert_eq!(ended, Event::Ended(Err(unconfirmed)));
}

/// Feedback about a command proves that it was delivered.
#[test]
fn a_command_that_seemed_not_to_be_sent_and_is_accepted_is_waited_for() {
    let parts = Parts::new();
    let model = parts.model();
    let mut world = World::new(&model, Limits::default());
    world.ask("put the red block on the blue block", Mode::ClosedLoop);
    let command = world.until_command();
    world.executive.on_command_undelivered();
    world.say(&command, Outcome::Accepted);
    assert_eq!(world.executive.poll(world.now_ns), Event::Waiting);
    world.carry_out(&command);
    world.say(&command, Outcome::Reached);
    assert_eq!(world.run(), Ok(()));
}
