//! Feedback of a controller: late, repeated, for another command, or missing; and stops.

use nsrm_ipc::executive::{Busy, CommandId, Event, Failure, Limits, Mode, Sentence};
use nsrm_ipc::message::{Feedback, FeedbackError, Outcome};
use nsrm_tests::by_hand::{Parts, raw_scene};
use nsrm_tests::world::{BLOCKS, SENTENCE};

use crate::world::{MS, World, unsuccessful};

#[test]
fn a_cancelled_sentence_stops_the_robot_and_waits_for_it() {
    let parts = Parts::new();
    let model = parts.model();
    let mut world = World::new(&model, Limits::default());
    for confirmed in [true, false] {
        world.scene = raw_scene(&model, &BLOCKS);
        world.ask(SENTENCE, Mode::ClosedLoop);
        let command = world.until_command();
        world.say(&command, Outcome::Accepted);
        world.executive.cancel();
        assert_eq!(world.until_stop(), 1);
        if confirmed {
            world.say(&command, Outcome::Stopped);
        }
        let expected = if confirmed {
            Failure::Cancelled
        } else {
            Failure::CancelledUnconfirmed
        };
        assert_eq!(world.run(), Err(expected));
    }
    // Nothing moves yet, so there is nothing to stop.
    world.ask(SENTENCE, Mode::ClosedLoop);
    world.executive.cancel();
    let ended = world.executive.poll(world.now_ns);
    assert_eq!(ended, Event::Ended(Err(Failure::Cancelled)));
}

/// Messages may be repeated or late; a poll sees all that arrived since the previous one.
#[test]
fn what_a_controller_says_first_of_a_commands_end_is_what_counts() {
    let parts = Parts::new();
    let model = parts.model();
    let mut world = World::new(&model, Limits::default());
    for later in [Outcome::Accepted, Outcome::Reached, Outcome::NoPath] {
        world.scene = raw_scene(&model, &BLOCKS);
        world.ask(SENTENCE, Mode::ClosedLoop);
        let command = world.until_command();
        world.say(&command, Outcome::Accepted);
        world.say(&command, Outcome::Dropped);
        world.say(&command, later);
        let (step, outcome) = (0, Outcome::Dropped);
        let why = unsuccessful(step, outcome);
        let event = world.executive.poll(world.now_ns);
        assert_eq!(event, Event::Again { step, why }, "{later:?}");
        assert_eq!(world.run(), Ok(()));
    }
}

#[test]
fn accepting_again_and_again_gives_no_more_time() {
    let parts = Parts::new();
    let model = parts.model();
    let mut world = World::new(&model, Limits::default());
    world.ask(SENTENCE, Mode::ClosedLoop);
    let command = world.until_command();
    let sent_ns = world.now_ns;
    loop {
        world.say(&command, Outcome::Accepted);
        world.now_ns += 100 * MS;
        match world.executive.poll(world.now_ns) {
            Event::Waiting => {}
            Event::Stop(id) => break assert_eq!(id, command.id),
            event => panic!("{event:?}"),
        }
        assert!(world.now_ns - sent_ns <= 60_000 * MS);
    }
}

/// The controller's clock is behind: on it the step ended before it was commanded.
#[test]
fn a_scene_from_before_a_command_shows_nothing_of_what_came_of_it() {
    let parts = Parts::new();
    let model = parts.model();
    let mut world = World::new(&model, Limits::default());
    world.ask("put the red block on the blue block", Mode::ClosedLoop);
    let command = world.until_command();
    world.carry_out(&command);
    world.now_ns += MS;
    let CommandId { plan, command } = command.id;
    let feedback = Feedback {
        plan,
        sequence: 0,
        timestamp_ns: 0,
        command,
        outcome: Outcome::Reached as u32,
        objects: [0; 2],
    };
    world
        .executive
        .on_feedback(&feedback, world.now_ns)
        .unwrap();
    assert_eq!(world.executive.poll(world.now_ns), Event::Working);
    assert_eq!(world.executive.poll(world.now_ns), Event::Waiting);
    assert_eq!(world.run(), Ok(()));
    assert_eq!(world.log, ["reached 0"]);
}

#[test]
fn a_controller_that_says_nothing_in_time_is_stopped_and_told_of() {
    let parts = Parts::new();
    let model = parts.model();
    let mut world = World::new(&model, Limits::default());
    world.ask(SENTENCE, Mode::ClosedLoop);
    let command = world.until_command();
    let sent_ns = world.now_ns;
    assert_eq!(world.until_stop(), 1);
    assert_eq!(command.until_ns, sent_ns + 500 * MS);
    let waited_ms = (world.now_ns - sent_ns) / MS;
    assert!((500..510).contains(&waited_ms), "{waited_ms}");
    // Whether it has started is unknown.
    assert_eq!(world.run(), Err(Failure::Unanswered { step: 0 }));

    // After the stop it reports that it has not started; that it has started; that it has ended.
    for (said, expected) in [
        (
            [Outcome::Stopped, Outcome::Stopped],
            Failure::NotAccepted { step: 0 },
        ),
        (
            [Outcome::TooLate, Outcome::Stopped],
            Failure::NotAccepted { step: 0 },
        ),
        (
            [Outcome::Accepted, Outcome::Stopped],
            Failure::Unanswered { step: 0 },
        ),
        (
            [Outcome::Reached, Outcome::Reached],
            Failure::Unanswered { step: 0 },
        ),
    ] {
        world.ask(SENTENCE, Mode::ClosedLoop);
        let command = world.until_command();
        assert_eq!(world.until_stop(), 1);
        for outcome in said {
            world.say(&command, outcome);
        }
        assert_eq!(world.run(), Err(expected), "{said:?}");
    }

    world.ask(SENTENCE, Mode::ClosedLoop);
    let command = world.until_command();
    world.say(&command, Outcome::Accepted);
    assert_eq!(world.until_stop(), 1);
    world.say(&command, Outcome::Stopped);
    assert_eq!(world.run(), Err(Failure::NoOutcome { step: 0 }));
}

#[test]
fn a_lost_controller_ends_it_at_once_unless_it_had_said_how_it_went() {
    let parts = Parts::new();
    let model = parts.model();
    let mut world = World::new(&model, Limits::default());
    world.ask(SENTENCE, Mode::ClosedLoop);
    let command = world.until_command();
    world.say(&command, Outcome::Accepted);
    world.executive.on_controller_lost();
    // In case it was only delayed; nobody waits for its answer.
    assert_eq!(world.executive.poll(world.now_ns), Event::Stop(command.id));
    let ended = world.executive.poll(world.now_ns);
    let lost = Failure::ControllerLost { step: 0 };
    assert_eq!(ended, Event::Ended(Err(lost)));

    world.ask(SENTENCE, Mode::ClosedLoop);
    let command = world.until_command();
    world.carry_out(&command);
    world.say(&command, Outcome::Reached);
    world.executive.on_controller_lost();
    assert_eq!(world.run(), Ok(()));
}

#[test]
fn what_is_about_another_command_changes_nothing() {
    let parts = Parts::new();
    let model = parts.model();
    let mut world = World::new(&model, Limits::default());
    let plan = world.ask(SENTENCE, Mode::ClosedLoop);
    let command = world.until_command();
    for (other_plan, other_command) in [(plan - 1, 1), (plan, 2)] {
        let mut other = command;
        other.id.plan = other_plan;
        other.id.command = other_command;
        world.say(&other, Outcome::Reached);
        assert_eq!(world.executive.poll(world.now_ns), Event::Waiting);
    }
    let nonsense = Feedback {
        plan,
        sequence: 0,
        timestamp_ns: world.now_ns,
        command: 1,
        outcome: 77,
        objects: [0; 2],
    };
    let refused = world.executive.on_feedback(&nonsense, world.now_ns);
    assert_eq!(refused, Err(FeedbackError::Outcome(77)));
    let sentence = Sentence::try_from("put").unwrap();
    let busy = world.executive.ask(sentence, Mode::PlanOnly);
    assert_eq!(busy, Err(Busy { plan }));
}
