//! The executive with a model made by hand and a simulated world: it executes a whole sentence,
//! observes after each step, retries a bounded number of times, and never acts on an invalid
//! scene.

mod controller;
mod hidden;
mod stops;
mod undone;
mod world;

use nsrm_core::{Refusal, SceneError};
use nsrm_ipc::executive::{Command, Event, Failure, Limits, Mode, SceneFault};
use nsrm_ipc::message::{Outcome, SceneMessage};
use nsrm_tests::by_hand::{DEPTH_M, EDGES_M, Parts, block, raw_scene};
use nsrm_tests::world::{BLOCKS, SENTENCE};

use crate::world::{IN_THE_WAY, MS, TWO_STEPS_DONE, World, unsuccessful};

#[test]
fn a_sentence_is_done_step_by_step_each_in_the_scene_after_the_one_before() {
    let parts = Parts::new();
    let model = parts.model();
    let mut world = World::new(&model, Limits::default());
    let plan = world.ask(SENTENCE, Mode::ClosedLoop);
    assert_eq!(world.run(), Ok(()));
    assert_eq!(world.log, TWO_STEPS_DONE);
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
    world.ask(SENTENCE, Mode::OpenLoop);
    // A block that it had put down falls; in open loop this is not detected.
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
    world.ask(SENTENCE, Mode::OpenLoop);
    world.scene = raw_scene(&model, &BLOCKS);
    world.outcomes = [Outcome::Dropped].into();
    let (step, outcome) = (0, Outcome::Dropped);
    assert_eq!(world.run(), Err(unsuccessful(step, outcome)));
}

#[test]
fn planning_alone_commands_nothing() {
    let parts = Parts::new();
    let model = parts.model();
    let mut world = World::new(&model, Limits::default());
    world.ask(SENTENCE, Mode::PlanOnly);
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
    assert_eq!(world.run(), Err(unsuccessful(step, outcome)));
    let why = unsuccessful(0, Outcome::NoPath).to_string();
    assert_eq!(
        why,
        "step 1: no collision-free path exists: object 3 is in the way; make room, and send \
         the sentence again"
    );
    // Outcomes that a retry cannot change.
    for outcome in [
        Outcome::NoPath,
        Outcome::WouldFall,
        Outcome::OutOfReach,
        Outcome::NotFollowing,
        Outcome::Covered,
        Outcome::CannotHold,
        Outcome::Stopped,
        Outcome::Busy,
        Outcome::Impossible,
    ] {
        world.outcomes = [outcome].into();
        world.ask("put the red block on the blue block", Mode::ClosedLoop);
        assert_eq!(world.run(), Err(unsuccessful(step, outcome)));
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

/// The blue block is pushed while the red one is carried to the blue one's old place.
#[test]
fn a_step_whose_reference_has_moved_meanwhile_is_done_again() {
    let parts = Parts::new();
    let model = parts.model();
    let mut world = World::new(&model, Limits::default());
    world.ask("put the red block on the blue block", Mode::ClosedLoop);
    let result = world.run_with(|world, command| {
        if command.id.command == 1 {
            let reference = command.planned.reference.object;
            let objects = &mut world.scene.objects;
            let pushed = objects.iter_mut().find(|it| it.id == reference);
            let location = &mut pushed.expect("it is seen").location;
            location[0] += 0.05;
            location[2] += 0.05;
        }
    });
    assert_eq!(result, Ok(()));
    assert_eq!(world.log[2], "again 0: not_there");
    let [first, second] = &world.commands[..] else {
        panic!("{:?}", world.log);
    };
    let [was, is] = [first, second].map(|it| it.planned.sub_goal.pose.translation.vector);
    assert!((is - was).norm() > 0.02, "{was} {is}");
}

#[test]
fn what_is_moved_first_is_told_and_changes_nothing_else() {
    let parts = Parts::new();
    let model = parts.model();
    let mut world = World::new(&model, Limits::default());
    world.ask("put the red block on the blue block", Mode::ClosedLoop);
    let command = world.until_command();
    world.say(&command, Outcome::Clearing);
    let event = world.executive.poll(world.now_ns);
    let object = command.planned.object.object;
    let first = IN_THE_WAY;
    let told = Event::Clearing {
        step: 0,
        object,
        first,
    };
    assert_eq!(event, told);
    // It counts as accepted, and is reported once.
    world.now_ns += 2 * Limits::default().accept_wait_ns;
    assert_eq!(world.executive.poll(world.now_ns), Event::Waiting);
    world.carry_out(&command);
    world.say(&command, Outcome::Reached);
    assert_eq!(world.run(), Ok(()));
    // After the command's end it is ignored.
    world.say(&command, Outcome::Clearing);
    assert_eq!(world.executive.poll(world.now_ns), Event::Waiting);
}

/// The blue block, beside which the red one was put on the table, is pushed meanwhile: nothing is wrong.
#[test]
fn what_is_put_on_the_table_may_lose_what_it_stands_beside() {
    let mut parts = Parts::new();
    parts.add_table();
    let model = parts.model();
    assert_eq!(model.check(), Ok(()));
    let mut world = World::new(&model, Limits::default());
    let blue = world.scene.objects[1].location;
    let [left, top, right, bottom, depth_m] = blue;
    let wider = 0.1 * (right - left);
    // On the blue block, nearer to the camera.
    let lifted = depth_m - EDGES_M[2];
    world.scene.objects[0].location = [left - wider, top, right + wider, bottom, lifted];
    world.ask("put the red block on the desk", Mode::ClosedLoop);
    let result = world.run_with(|world, _| {
        let pushed = &mut world.scene.objects[1].location;
        pushed[0] += 0.05;
        pushed[2] += 0.05;
    });
    assert_eq!(result, Ok(()), "{:?}", world.log);
    assert_eq!(world.commands.len(), 1, "{:?}", world.log);
    let planned = &world.commands[0].planned;
    assert_eq!((planned.object.object, planned.action), (1, 1));
}

/// The robot drops the red block halfway: it goes where it was to go at first, and not as far again from where it
/// lies now.
#[test]
fn what_is_moved_from_where_it_was_goes_to_the_same_place_when_tried_again() {
    let mut parts = Parts::new();
    parts.add_distances();
    // An action puts things to the right.
    parts.simulator.output.bias = [0.1, 0.0, 0.1, 0.0, 0.0];
    let model = parts.model();
    assert_eq!(model.check(), Ok(()));
    let mut world = World::new(&model, Limits::default());
    world.ask("put the red block 60 mm aside", Mode::ClosedLoop);
    let first = world.until_command();
    let dropped = &mut world.scene.objects[0].location;
    dropped[0] += 0.02;
    dropped[2] += 0.02;
    world.say(&first, Outcome::Accepted);
    world.say(&first, Outcome::Dropped);
    assert_eq!(world.run(), Ok(()), "{:?}", world.log);
    let [second] = world.commands[..] else {
        panic!("{:?}", world.log);
    };
    assert_eq!(first.planned.sub_goal, second.planned.sub_goal);
    let planned = &first.planned;
    assert_eq!((planned.object.object, planned.reference.object), (1, 1));
}

/// The red block falls while the green one is put onto it: both are put back.
#[test]
fn an_earlier_step_that_came_undone_is_done_again_and_what_follows_too() {
    let parts = Parts::new();
    let model = parts.model();
    let mut world = World::new(&model, Limits::default());
    world.ask(SENTENCE, Mode::ClosedLoop);
    let result = world.run_with(|world, command| {
        if command.id.command == 2 {
            world.scene.objects[0].location = [0.1, 0.48, 0.115, 0.52, DEPTH_M];
            world.scene.objects[2].location = [0.2, 0.48, 0.215, 0.52, DEPTH_M];
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

/// The robot drops the red block that was the farthest, nearer than the other red one: no other is
/// moved instead.
#[test]
fn a_description_that_means_another_object_after_a_failure_ends_it() {
    let parts = Parts::new();
    let model = parts.model();
    let mut world = World::new(&model, Limits::default());
    let (red, blue) = (block("small", "red"), block("lego", "blue"));
    world.scene = raw_scene(&model, &[red, blue, block("lego", "green"), red]);
    world.ask(
        "put the red furthest the blue block on the green block",
        Mode::ClosedLoop,
    );
    let result = world.run_with(|world, _| {
        world.scene.objects[3].location = [0.34, 0.49, 0.355, 0.53, DEPTH_M];
    });
    let failure = Failure::OtherObject {
        step: 0,
        meant: 4,
        found: 1,
    };
    assert_eq!(result, Err(failure), "{:?}", world.log);
    assert_eq!(world.commands.len(), 1);
    assert_eq!(
        failure.to_string(),
        "step 1: the description means object 1 now, and meant object 4 when the sentence was \
         started; send it again as things stand"
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
        // The last object of the list replaces it.
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
        world.executive.on_scene(&message, now_ns)
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
    // No sentence was started, so the camera may be another one.
    assert_eq!(see(&|scene| scene.camera.position[0] += 0.1), Ok(()));
    let late_ns = now_ns + 600 * MS;
    let late = world.executive.on_scene(&world.message(now_ns), late_ns);
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
    let fault = world.executive.on_scene(&message, world.now_ns);
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

/// Grounding may be spread over so many ticks that the scene becomes too old.
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
    // The plan is for a scene that is too old; there is no newer one yet.
    assert_eq!(world.executive.poll(world.now_ns), Event::Working);
    assert_eq!(world.executive.poll(world.now_ns), Event::Waiting);
    assert_eq!(world.run(), Ok(()));
    assert_eq!(world.log, ["planned from 0", "command 0", "reached 0"]);
}

/// The caller may be delayed between a plan and its command.
#[test]
fn a_plan_that_has_grown_old_is_made_again() {
    for mode in [Mode::ClosedLoop, Mode::OpenLoop] {
        let parts = Parts::new();
        let model = parts.model();
        let mut world = World::new(&model, Limits::default());
        world.ask("put the red block on the blue block", mode);
        world.see();
        while !matches!(world.executive.poll(world.now_ns), Event::Planned(_)) {}
        world.now_ns += 501 * MS;
        assert_eq!(world.executive.poll(world.now_ns), Event::Working);
        assert_eq!(world.executive.poll(world.now_ns), Event::Waiting);
        assert_eq!(world.run(), Ok(()));
        assert_eq!(world.log, ["planned from 0", "command 0", "reached 0"]);
    }
}

/// The wall clock, which several hosts share, may be set back.
#[test]
fn a_clock_that_is_set_back_ends_what_is_under_way_and_no_more() {
    let parts = Parts::new();
    let model = parts.model();
    let mut world = World::new(&model, Limits::default());
    for is_commanded in [true, false] {
        world.ask("put the red block on the blue block", Mode::ClosedLoop);
        world.see();
        let mut commands = 0;
        let mut events = std::iter::from_fn(|| Some(world.executive.poll(world.now_ns)));
        let last = events.find(|event| {
            commands += u32::from(matches!(event, Event::Command(_)));
            !is_commanded || commands > 0
        });
        assert!(last.is_some());
        world.now_ns -= 5000 * MS;
        let mut event = world.executive.poll(world.now_ns);
        if is_commanded {
            assert!(matches!(event, Event::Stop(_)), "{event:?}");
            world.now_ns += Limits::default().accept_wait_ns + 1;
            event = world.executive.poll(world.now_ns);
        }
        assert_eq!(event, Event::Ended(Err(Failure::ClockSetBack)));
    }
    // Scenes that are older than earlier ones are accepted again.
    world.ask("put the red block on the blue block", Mode::ClosedLoop);
    assert_eq!(world.run(), Ok(()));
    world.now_ns -= 5000 * MS;
    assert_eq!(world.executive.poll(world.now_ns), Event::Waiting);
    world.ask("put the red block on the blue block", Mode::PlanOnly);
    assert_eq!(world.run(), Ok(()));
}

/// With the controller's clock ahead, no scene would ever be later.
#[test]
fn feedback_from_the_future_does_not_keep_the_planner_from_looking() {
    let parts = Parts::new();
    let model = parts.model();
    let mut world = World::new(&model, Limits::default());
    world.ahead_ns = 3_600_000 * MS;
    world.ask("put the red block on the blue block", Mode::ClosedLoop);
    assert_eq!(world.run(), Ok(()));
    assert_eq!(world.log, ["planned from 0", "command 0", "reached 0"]);
}
