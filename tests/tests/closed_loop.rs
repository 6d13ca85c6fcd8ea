//! The executive on a hand-made model and a world of numbers: it does a sentence to
//! its end, looks after each step, tries again a bounded number of times, and never
//! acts on a scene that it should not.

use std::collections::VecDeque;

use nsrm_core::{Model, RawScene, Refusal, Scene, SceneError};
use nsrm_ipc::executive::{
    Busy, Command, CommandId, Event, Executive, Failure, Limits, Mode, SceneFault, Sentence,
};
use nsrm_ipc::message::{Feedback, FeedbackError, Outcome, SceneMessage};
use nsrm_tests::by_hand::{Parts, block, raw_scene};

const MS: u64 = 1_000_000;
const TWO_STEPS: &str = "put the small red block on the blue block then put the green block on the \
                         small red block";
const BLOCKS: [nsrm_tests::by_hand::Block; 3] = [
    block("small", "red"),
    block("lego", "blue"),
    block("lego", "green"),
];

/// Numbers instead of a camera, a robot and a clock.
struct World<'m> {
    executive: Executive<'m>,
    scene: RawScene,
    now_ns: u64,
    sequence: u64,
    /// What the controller will say of the next commands; when none is left, that
    /// they were reached.
    outcomes: VecDeque<Outcome>,
    /// What happened, in order.
    log: Vec<String>,
    commands: Vec<Command>,
}

impl<'m> World<'m> {
    fn new(model: &'m Model<'m>, limits: Limits) -> Self {
        Self {
            executive: Executive::new(model, limits, 100),
            scene: raw_scene(model, &BLOCKS),
            now_ns: 10_000 * MS,
            sequence: 0,
            outcomes: VecDeque::new(),
            log: Vec::new(),
            commands: Vec::new(),
        }
    }

    fn ask(&mut self, sentence: &str, mode: Mode) -> u64 {
        let sentence = Sentence::try_from(sentence).unwrap();
        self.executive.ask(sentence, mode).unwrap()
    }

    fn message(&self, taken_ns: u64) -> SceneMessage {
        let mut raw = self.scene;
        raw.header.sequence = self.sequence;
        raw.header.timestamp_ns = taken_ns;
        SceneMessage::from(&Scene::new(raw, self.executive.model()).unwrap())
    }

    fn see(&mut self) {
        self.sequence += 1;
        let message = self.message(self.now_ns);
        self.executive.see(&message, self.now_ns).unwrap();
    }

    fn say(&mut self, command: &Command, outcome: Outcome) {
        let feedback = Feedback {
            plan: command.id.plan,
            sequence: 0,
            timestamp_ns: self.now_ns,
            command: command.id.command,
            outcome: outcome as u32,
        };
        self.executive.hear(&feedback, self.now_ns).unwrap();
    }

    /// The robot puts the object where it is told to.
    fn carry_out(&mut self, command: &Command) {
        let id = command.planned.sub_goal.object;
        let objects = self.scene.objects.iter_mut();
        for object in objects.filter(|object| object.id == id) {
            object.location = command.planned.location;
        }
    }

    /// Polls, with a scene every 10 ms, until the sentence has ended.
    fn run(&mut self) -> Result<(), Failure> {
        self.run_with(|_, _| {})
    }

    /// As [`World::run`]; something happens right after each command was reached.
    fn run_with(&mut self, mut then: impl FnMut(&mut Self, &Command)) -> Result<(), Failure> {
        for tick in 0..100_000 {
            self.now_ns += MS;
            if tick % 10 == 0 {
                self.see();
            }
            match self.executive.poll(self.now_ns) {
                Event::Waiting | Event::Working => {}
                Event::Planned(plan) => self.log.push(format!("planned from {}", plan.first())),
                Event::Command(command) => {
                    self.log.push(format!("command {}", command.step));
                    self.commands.push(command);
                    self.say(&command, Outcome::Accepted);
                    self.now_ns += 5000 * MS;
                    let outcome = self.outcomes.pop_front().unwrap_or(Outcome::Reached);
                    if outcome == Outcome::Reached {
                        self.carry_out(&command);
                        then(self, &command);
                    }
                    self.say(&command, outcome);
                }
                Event::Stop(id) => self.log.push(format!("stop {}", id.command)),
                Event::Reached { step, .. } => self.log.push(format!("reached {step}")),
                Event::Again { step, why } => {
                    self.log.push(format!("again {step}: {}", why.kind()));
                }
                Event::Ended(result) => {
                    assert_eq!(self.executive.plan(), None);
                    assert_eq!(self.executive.poll(self.now_ns), Event::Waiting);
                    return result;
                }
            }
        }
        panic!("no end: {:?}", self.log);
    }
}

#[test]
fn a_sentence_is_done_step_by_step_each_in_the_scene_after_the_one_before() {
    let parts = Parts::new();
    let model = parts.model();
    let mut world = World::new(&model, Limits::default());
    let plan = world.ask(TWO_STEPS, Mode::ClosedLoop);
    assert_eq!(world.run(), Ok(()));
    assert_eq!(
        world.log,
        [
            "planned from 0",
            "command 0",
            "reached 0",
            "planned from 1",
            "command 1",
            "reached 1"
        ]
    );
    let [first, second] = world.commands[..] else {
        panic!("{:?}", world.commands);
    };
    assert_eq!((first.id.plan, first.id.command, first.steps), (plan, 1, 2));
    assert_eq!((second.id.plan, second.id.command), (plan, 2));
    let objects = |command: &Command| {
        let planned = &command.planned;
        (planned.object.object, planned.reference.object)
    };
    assert_eq!((objects(&first), objects(&second)), ((1, 2), (3, 1)));
    assert_eq!(
        world.ask("put the red block on the blue block", Mode::PlanOnly),
        plan + 1
    );
}

#[test]
fn open_loop_carries_out_the_first_plan_without_looking() {
    let parts = Parts::new();
    let model = parts.model();
    let mut world = World::new(&model, Limits::default());
    world.ask(TWO_STEPS, Mode::OpenLoop);
    // What it had put down falls, and it does not see it.
    let result = world.run_with(|world, _| world.scene.objects[0].location[4] = 0.5);
    assert_eq!(result, Ok(()));
    assert_eq!(
        world.log,
        [
            "planned from 0",
            "command 0",
            "reached 0",
            "command 1",
            "reached 1"
        ]
    );
    world.ask(TWO_STEPS, Mode::OpenLoop);
    world.scene = raw_scene(&model, &BLOCKS);
    world.outcomes = [Outcome::Dropped].into();
    let (step, outcome) = (0, Outcome::Dropped);
    assert_eq!(world.run(), Err(Failure::Unsuccessful { step, outcome }));
}

#[test]
fn planning_alone_commands_nothing() {
    let parts = Parts::new();
    let model = parts.model();
    let mut world = World::new(&model, Limits::default());
    world.ask(TWO_STEPS, Mode::PlanOnly);
    assert_eq!(world.run(), Ok(()));
    assert_eq!(world.log, ["planned from 0"]);
}

#[test]
fn a_refusal_ends_it_before_anything_moves() {
    let parts = Parts::new();
    let model = parts.model();
    let mut world = World::new(&model, Limits::default());
    world.ask(
        "put the small green block on the blue block",
        Mode::ClosedLoop,
    );
    let refused = world.run();
    assert!(
        matches!(
            refused,
            Err(Failure::Refused(Refusal::NoSuchObject { step: 0, .. }))
        ),
        "{refused:?}"
    );
    assert!(world.log.is_empty());
}

#[test]
fn what_went_wrong_is_tried_again_a_bounded_number_of_times() {
    let parts = Parts::new();
    let model = parts.model();
    let limits = Limits {
        retries: 2,
        ..Limits::default()
    };
    let mut world = World::new(&model, limits);
    world.outcomes = [Outcome::NotGrasped, Outcome::Dropped].into();
    world.ask("put the red block on the blue block", Mode::ClosedLoop);
    assert_eq!(world.run(), Ok(()));
    let again = "again 0: unsuccessful";
    let (planned, command) = ("planned from 0", "command 0");
    assert_eq!(
        world.log,
        [
            planned,
            command,
            again,
            planned,
            command,
            again,
            planned,
            command,
            "reached 0"
        ]
    );
    let numbers: Vec<_> = world
        .commands
        .iter()
        .map(|command| command.id.command)
        .collect();
    assert_eq!(numbers, [1, 2, 3]);

    world.scene = raw_scene(&model, &BLOCKS);
    world.outcomes = [Outcome::NotGrasped; 3].into();
    world.ask("put the red block on the blue block", Mode::ClosedLoop);
    let (step, outcome) = (0, Outcome::NotGrasped);
    assert_eq!(world.run(), Err(Failure::Unsuccessful { step, outcome }));
    // That can't get better by itself.
    for outcome in [
        Outcome::NoPath,
        Outcome::Stopped,
        Outcome::Busy,
        Outcome::Impossible,
    ] {
        world.outcomes = [outcome].into();
        world.ask("put the red block on the blue block", Mode::ClosedLoop);
        assert_eq!(world.run(), Err(Failure::Unsuccessful { step, outcome }));
    }
}

#[test]
fn a_step_that_is_seen_not_to_have_worked_is_done_again() {
    let parts = Parts::new();
    let model = parts.model();
    let mut world = World::new(&model, Limits::default());
    world.ask("put the red block on the blue block", Mode::ClosedLoop);
    let mut times = 0;
    let result = world.run_with(|world, _| {
        times += 1;
        if times == 1 {
            // It slid off, 5 cm to the side.
            world.scene.objects[0].location[0] += 0.05;
            world.scene.objects[0].location[2] += 0.05;
        }
    });
    assert_eq!(result, Ok(()));
    assert_eq!(world.log[2], "again 0: not_there");
    assert_eq!(world.commands.len(), 2);
}

/// The red block falls as the green one is put onto it: both are put back.
#[test]
fn an_earlier_step_that_came_undone_is_done_again_and_what_follows_too() {
    let parts = Parts::new();
    let model = parts.model();
    let mut world = World::new(&model, Limits::default());
    world.ask(TWO_STEPS, Mode::ClosedLoop);
    let result = world.run_with(|world, command| {
        if command.id.command == 2 {
            world.scene.objects[0].location = [0.1, 0.48, 0.115, 0.52, 0.95];
            world.scene.objects[2].location = [0.2, 0.48, 0.215, 0.52, 0.95];
        }
    });
    assert_eq!(result, Ok(()));
    let steps: Vec<_> = world.commands.iter().map(|command| command.step).collect();
    assert_eq!(steps, [0, 1, 0, 1]);
    assert!(
        world.log.contains(&"again 1: not_there".into()),
        "{:?}",
        world.log
    );
}

#[test]
fn an_object_that_is_no_longer_seen_is_waited_for_and_then_missed() {
    let parts = Parts::new();
    let model = parts.model();
    let limits = Limits {
        retries: 0,
        ..Limits::default()
    };
    let mut world = World::new(&model, limits);
    world.ask("put the red block on the blue block", Mode::ClosedLoop);
    let result = world.run_with(|world, _| {
        // The last one takes its place.
        world.scene.objects[0] = world.scene.objects[2];
        world.scene.count = 2;
    });
    assert_eq!(result, Err(Failure::NotSeen { step: 0, object: 1 }));
}

#[test]
fn scenes_that_must_not_be_acted_upon_are_refused_by_name() {
    let parts = Parts::new();
    let model = parts.model();
    let mut world = World::new(&model, Limits::default());
    let now_ns = world.now_ns;
    world.see();
    let mut see = |change: &dyn Fn(&mut SceneMessage)| {
        let mut message = world.message(now_ns);
        change(&mut message);
        world.executive.see(&message, now_ns)
    };
    assert_eq!(see(&|_| {}), Ok(()));
    assert_eq!(
        see(&|scene| scene.timestamp_ns -= 501 * MS),
        Err(SceneFault::OutOfOrder)
    );
    assert_eq!(
        see(&|scene| scene.timestamp_ns += 9 * MS),
        Err(SceneFault::FromTheFuture { by_ms: 9 })
    );
    assert!(matches!(
        see(&|scene| scene.model_tag ^= 1),
        Err(SceneFault::Invalid(SceneError::ModelTag { .. }))
    ));
    assert!(matches!(
        see(&|scene| scene.count = 99),
        Err(SceneFault::Invalid(SceneError::TooManyObjects { .. }))
    ));
    // No sentence was begun, so another camera is none too many.
    assert_eq!(see(&|scene| scene.camera.position[0] += 0.1), Ok(()));
    let late_ns = now_ns + 600 * MS;
    let late = world.executive.see(&world.message(now_ns), late_ns);
    let (age_ms, limit_ms) = (600, 500);
    assert_eq!(late, Err(SceneFault::TooOld { age_ms, limit_ms }));
}

#[test]
fn a_camera_that_moves_during_a_sentence_ends_it() {
    let parts = Parts::new();
    let model = parts.model();
    let mut world = World::new(&model, Limits::default());
    world.ask("put the red block on the blue block", Mode::ClosedLoop);
    world.see();
    while !matches!(world.executive.poll(world.now_ns), Event::Command(_)) {}
    world.now_ns += MS;
    let mut message = world.message(world.now_ns);
    message.camera.position[2] += 0.001;
    let fault = world.executive.see(&message, world.now_ns);
    assert_eq!(fault, Err(SceneFault::OtherCamera));
}

#[test]
fn an_old_scene_is_not_acted_upon_and_waiting_ends() {
    let parts = Parts::new();
    let model = parts.model();
    let mut world = World::new(&model, Limits::default());
    world.see();
    world.now_ns += 501 * MS;
    world.ask("put the red block on the blue block", Mode::ClosedLoop);
    let begun_ns = world.now_ns;
    let ended = loop {
        world.now_ns += MS;
        match world.executive.poll(world.now_ns) {
            Event::Waiting | Event::Working => {}
            Event::Ended(result) => break result,
            event => panic!("{event:?}"),
        }
    };
    let Err(Failure::NoScene {
        last: Some(SceneFault::TooOld { .. }),
    }) = ended
    else {
        panic!("{ended:?}");
    };
    assert!(world.now_ns - begun_ns < 2200 * MS);
}

/// Grounding may be spread over so many ticks that the scene grows old meanwhile.
#[test]
fn a_plan_that_took_too_long_is_made_again() {
    let parts = Parts::new();
    let model = parts.model();
    let mut world = World::new(&model, Limits::default());
    let begin = |world: &mut World<'_>| {
        world.ask("put the red block on the blue block", Mode::PlanOnly);
        world.see();
        (1..)
            .find(|_| match world.executive.poll(world.now_ns) {
                Event::Planned(_) => true,
                Event::Working => false,
                event => panic!("{event:?}"),
            })
            .unwrap()
    };
    let polls = begin(&mut world);
    assert_eq!(world.run(), Ok(()));

    world.ask("put the red block on the blue block", Mode::ClosedLoop);
    world.see();
    for _ in 1..polls {
        assert_eq!(world.executive.poll(world.now_ns), Event::Working);
    }
    world.now_ns += 501 * MS;
    // What it comes to is of a scene too old; there is no other one yet.
    assert_eq!(world.executive.poll(world.now_ns), Event::Working);
    assert_eq!(world.executive.poll(world.now_ns), Event::Waiting);
    assert_eq!(world.run(), Ok(()));
    assert_eq!(world.log, ["planned from 0", "command 0", "reached 0"]);
}

/// Polls, with scenes, until a command is sent, and does nothing with it.
fn until_command(world: &mut World<'_>) -> Command {
    loop {
        world.now_ns += MS;
        world.see();
        if let Event::Command(command) = world.executive.poll(world.now_ns) {
            return command;
        }
    }
}

/// Polls, with scenes, until a stop is sent; whether it ended before.
fn until_stop(world: &mut World<'_>) -> u32 {
    loop {
        world.now_ns += MS;
        world.see();
        match world.executive.poll(world.now_ns) {
            Event::Waiting | Event::Working => {}
            Event::Stop(id) => return id.command,
            event => panic!("{event:?}"),
        }
    }
}

#[test]
fn a_cancelled_sentence_stops_the_robot_and_waits_for_it() {
    let parts = Parts::new();
    let model = parts.model();
    let mut world = World::new(&model, Limits::default());
    for confirmed in [true, false] {
        world.scene = raw_scene(&model, &BLOCKS);
        world.ask(TWO_STEPS, Mode::ClosedLoop);
        let command = until_command(&mut world);
        world.say(&command, Outcome::Accepted);
        world.executive.cancel();
        assert_eq!(until_stop(&mut world), 1);
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
    // Nothing moves yet: nothing to stop.
    world.ask(TWO_STEPS, Mode::ClosedLoop);
    world.executive.cancel();
    let ended = world.executive.poll(world.now_ns);
    assert_eq!(ended, Event::Ended(Err(Failure::Cancelled)));
}

/// Messages may come doubled or late; a poll sees all that came since the one before it.
#[test]
fn what_a_controller_says_first_of_a_commands_end_is_what_counts() {
    let parts = Parts::new();
    let model = parts.model();
    let mut world = World::new(&model, Limits::default());
    for later in [Outcome::Accepted, Outcome::Reached, Outcome::NoPath] {
        world.scene = raw_scene(&model, &BLOCKS);
        world.ask(TWO_STEPS, Mode::ClosedLoop);
        let command = until_command(&mut world);
        world.say(&command, Outcome::Accepted);
        world.say(&command, Outcome::Dropped);
        world.say(&command, later);
        let (step, outcome) = (0, Outcome::Dropped);
        let why = Failure::Unsuccessful { step, outcome };
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
    world.ask(TWO_STEPS, Mode::ClosedLoop);
    let command = until_command(&mut world);
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

/// The controller's clock is behind: by it the step ended before it was commanded.
#[test]
fn a_scene_from_before_a_command_shows_nothing_of_what_came_of_it() {
    let parts = Parts::new();
    let model = parts.model();
    let mut world = World::new(&model, Limits::default());
    world.ask("put the red block on the blue block", Mode::ClosedLoop);
    let command = until_command(&mut world);
    world.carry_out(&command);
    world.now_ns += MS;
    let CommandId { plan, command } = command.id;
    let feedback = Feedback {
        plan,
        sequence: 0,
        timestamp_ns: 0,
        command,
        outcome: Outcome::Reached as u32,
    };
    world.executive.hear(&feedback, world.now_ns).unwrap();
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
    world.ask(TWO_STEPS, Mode::ClosedLoop);
    let command = until_command(&mut world);
    let sent_ns = world.now_ns;
    assert_eq!(until_stop(&mut world), 1);
    assert_eq!(command.until_ns, sent_ns + 500 * MS);
    let waited_ms = (world.now_ns - sent_ns) / MS;
    assert!((500..510).contains(&waited_ms), "{waited_ms}");
    // It may have begun, for all that is known.
    assert_eq!(world.run(), Err(Failure::Unanswered { step: 0 }));

    // It says after the stop that it has not begun; that it has; that it has ended.
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
        world.ask(TWO_STEPS, Mode::ClosedLoop);
        let command = until_command(&mut world);
        assert_eq!(until_stop(&mut world), 1);
        for outcome in said {
            world.say(&command, outcome);
        }
        assert_eq!(world.run(), Err(expected), "{said:?}");
    }

    world.ask(TWO_STEPS, Mode::ClosedLoop);
    let command = until_command(&mut world);
    world.say(&command, Outcome::Accepted);
    assert_eq!(until_stop(&mut world), 1);
    world.say(&command, Outcome::Stopped);
    assert_eq!(world.run(), Err(Failure::NoOutcome { step: 0 }));
}

#[test]
fn a_lost_controller_ends_it_at_once_unless_it_had_said_how_it_went() {
    let parts = Parts::new();
    let model = parts.model();
    let mut world = World::new(&model, Limits::default());
    world.ask(TWO_STEPS, Mode::ClosedLoop);
    let command = until_command(&mut world);
    world.say(&command, Outcome::Accepted);
    world.executive.lose_controller();
    // In case that it was only held up; its answer is not waited for.
    assert_eq!(world.executive.poll(world.now_ns), Event::Stop(command.id));
    let ended = world.executive.poll(world.now_ns);
    let lost = Failure::ControllerLost { step: 0 };
    assert_eq!(ended, Event::Ended(Err(lost)));

    world.ask(TWO_STEPS, Mode::ClosedLoop);
    let command = until_command(&mut world);
    world.carry_out(&command);
    world.say(&command, Outcome::Reached);
    world.executive.lose_controller();
    assert_eq!(world.run(), Ok(()));
}

#[test]
fn what_is_about_another_command_changes_nothing() {
    let parts = Parts::new();
    let model = parts.model();
    let mut world = World::new(&model, Limits::default());
    let plan = world.ask(TWO_STEPS, Mode::ClosedLoop);
    let command = until_command(&mut world);
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
    };
    let refused = world.executive.hear(&nonsense, world.now_ns);
    assert_eq!(refused, Err(FeedbackError::Outcome(77)));
    let sentence = Sentence::try_from("put").unwrap();
    let busy = world.executive.ask(sentence, Mode::PlanOnly);
    assert_eq!(busy, Err(Busy { plan }));
}
