//! A step that was undone is repeated, and no other; a command that was impossible is retried once
//! the scene has changed.

use nsrm_core::model::LOCATION;
use nsrm_core::scene::ObservedObject;
use nsrm_core::{Model, Refusal};
use nsrm_ipc::executive::{Command, Event, Failure, Limits, Mode};
use nsrm_ipc::message::Outcome;
use nsrm_tests::by_hand::{Block, block, raw_scene};
use nsrm_tests::world::BLOCKS;

use crate::hidden::{EDGE_M, parts};
use crate::world::{MS, World, unsuccessful};

/// [`BLOCKS`], and ids 4 to 6.
const MORE: [Block; 6] = [
    BLOCKS[0],
    BLOCKS[1],
    BLOCKS[2],
    block("small", "green"),
    block("lego", "red"),
    block("small", "blue"),
];
/// The first beside the second, the fourth beside the third.
const BESIDE: &str = "put the small red block beside the lego blue block then put the small green \
                      block beside the lego green block";
/// Image widths per metre on the table.
const PER_M: f32 = 600.0 / 640.0 / 0.975;

fn world<'m>(model: &'m Model<'m>, limits: Limits) -> World<'m> {
    let mut world = World::new(model, limits);
    world.scene = raw_scene(model, &MORE);
    world
}

impl World<'_> {
    fn at(&mut self, id: u32) -> &mut [f32; LOCATION] {
        let mut objects = self.scene.objects.iter_mut();
        &mut objects.find(|object| object.id == id).unwrap().location
    }

    /// Pushes a block along the image's width, as a person would.
    fn push(&mut self, id: u32, by_m: f32) {
        let location = self.at(id);
        location[0] += by_m * PER_M;
        location[2] += by_m * PER_M;
    }

    fn commanded(&self) -> Vec<u8> {
        self.commands.iter().map(|command| command.step).collect()
    }

    /// Runs a sentence; something happens after the command with this number.
    fn follow(
        &mut self,
        sentence: &str,
        number: u32,
        happens: impl Fn(&mut Self),
    ) -> Result<(), Failure> {
        self.ask(sentence, Mode::ClosedLoop);
        self.run_with(|world, command| {
            if command.id.command == number {
                happens(world);
            }
        })
    }
}

#[test]
fn a_step_that_is_undone_is_done_again_and_only_that() {
    let parts = parts();
    let model = parts.model();
    let mut world = world(&model, Limits::default());
    let result = world.follow(BESIDE, 2, |world| world.push(1, 0.1));
    assert_eq!(result, Ok(()));
    assert_eq!(world.commanded(), [0, 1, 0]);
    let planned = ["planned from 0", "planned from 1", "planned from 0"];
    let log = world.log.iter().filter(|what| what.starts_with("planned"));
    assert_eq!(log.collect::<Vec<_>>(), planned);
}

#[test]
fn when_a_reference_is_moved_what_was_put_beside_it_follows() {
    let parts = parts();
    let model = parts.model();
    let mut world = world(&model, Limits::default());
    let result = world.follow(BESIDE, 2, |world| world.push(2, -0.06));
    assert_eq!(result, Ok(()));
    assert_eq!(world.commanded(), [0, 1, 0]);
    let (red, blue) = (*world.at(1), *world.at(2));
    assert!((red[0] - blue[0] - 0.05).abs() < 1e-5, "{red:?} {blue:?}");
}

#[test]
fn what_a_later_step_has_moved_on_is_not_fetched_back() {
    let parts = parts();
    let model = parts.model();
    let mut world = world(&model, Limits::default());
    let result = world.follow(
        "put the small red block beside the lego blue block then put the small red block beside \
         the lego green block",
        2,
        |world| world.push(2, -0.06),
    );
    assert_eq!(result, Ok(()));
    assert_eq!(world.commanded(), [0, 1]);
}

/// The green block must be where it was put, not where its reference was moved afterwards.
#[test]
fn what_has_gone_to_one_that_was_moved_on_goes_back_to_where_it_was() {
    let parts = parts();
    let model = parts.model();
    for (pushed, again) in [(1, 2), (4, 1)] {
        let mut world = world(&model, Limits::default());
        let result = world.follow(
            "put the small red block beside the lego blue block then put the small green block \
             beside the small red block then put the small red block beside the lego red block",
            3,
            |world| world.push(pushed, 0.04),
        );
        assert_eq!(result, Ok(()));
        assert_eq!(world.commanded(), [0, 1, 2, again]);
        let goals = world.commands.iter().filter(|it| it.step == again);
        let goals: Vec<_> = goals.map(|it| it.planned.sub_goal).collect();
        assert_eq!(goals[0], goals[1]);
    }
}

#[test]
fn a_controller_is_told_what_is_to_stay_as_the_steps_that_are_done_have_left_it() {
    let parts = parts();
    let model = parts.model();
    let mut world = world(&model, Limits::default());
    let result = world.follow(BESIDE, 2, |world| world.push(1, 0.1));
    assert_eq!(result, Ok(()));
    let kept = world.commands.iter().map(|command| {
        let ids = command.keep.into_iter().filter(|id| *id != 0);
        (command.step, ids.collect::<Vec<_>>())
    });
    // An object whose step was undone may be moved aside by the repeated step.
    let expected = [(0, vec![]), (1, vec![1, 2]), (0, vec![4, 3])];
    assert_eq!(kept.collect::<Vec<_>>(), expected);
}

/// A step whose reference was displaced is executed once the reference is back.
#[test]
fn what_the_next_step_goes_to_is_put_back_before() {
    let parts = parts();
    let model = parts.model();
    let mut world = world(&model, Limits::default());
    let result = world.follow(
        "put the small red block beside the lego blue block then put the small green block beside \
         the small red block",
        2,
        |world| world.push(1, 0.1),
    );
    assert_eq!(result, Ok(()));
    assert_eq!(world.commanded()[..3], [0, 1, 0]);
    let (red, green) = (*world.at(1), *world.at(4));
    assert!((green[0] - red[0] - 0.05).abs() < 1e-5, "{red:?} {green:?}");
}

#[test]
fn a_small_shift_is_noticed_unless_another_covers_a_part() {
    let parts = parts();
    let model = parts.model();
    // How far the reference is moved: uncovered, or with a block on it that stays or moves along.
    for (relation, by_m, with_what_it_bears, is_undone) in [
        ("beside", 0.002, false, false),
        ("beside", 0.004, false, true),
        ("on", 0.004, false, false),
        ("on", 0.012, false, true),
        ("on", 0.004, true, true),
    ] {
        let mut world = world(&model, Limits::default());
        let sentence = format!(
            "put the lego red block {relation} the lego blue block then put the small green block \
             beside the lego green block"
        );
        let result = world.follow(&sentence, 2, |world| {
            world.push(2, by_m);
            if with_what_it_bears {
                world.push(5, by_m);
            }
        });
        assert_eq!(result, Ok(()));
        let steps: &[u8] = if is_undone { &[0, 1, 0] } else { &[0, 1] };
        assert_eq!(world.commanded(), steps, "{relation} {by_m}");
    }
}

/// A block that the sentence does not name is on the reference from the start.
#[test]
fn a_reference_that_bears_another_is_seen_less_well_unless_that_goes_with_it() {
    let parts = parts();
    let model = parts.model();
    for (by_m, with_what_it_bears, is_undone) in [
        (0.004, false, false),
        (0.012, false, true),
        (0.004, true, true),
    ] {
        let mut world = world(&model, Limits::default());
        *world.at(6) = *world.at(2);
        world.at(6)[4] -= EDGE_M;
        let result = world.follow(BESIDE, 2, |world| {
            world.push(2, by_m);
            if with_what_it_bears {
                world.push(6, by_m);
            }
        });
        assert_eq!(result, Ok(()));
        let steps: &[u8] = if is_undone { &[0, 1, 0] } else { &[0, 1] };
        assert_eq!(world.commanded(), steps, "{by_m}");
    }
}

#[test]
fn what_nobody_spoke_of_may_be_moved() {
    let parts = parts();
    let model = parts.model();
    let mut world = world(&model, Limits::default());
    let result = world.follow(BESIDE, 1, |world| world.push(6, 0.1));
    assert_eq!((result, world.commanded()), (Ok(()), vec![0, 1]));
}

#[test]
fn a_step_that_does_not_stay_is_given_up_after_its_attempts() {
    let parts = parts();
    let model = parts.model();
    let limits = Limits {
        attempts: 3,
        retries: 100,
        ..Limits::default()
    };
    // They alternate: each step has its own attempts.
    for (also, most) in [(1, 3), (4, 5)] {
        let mut world = world(&model, limits);
        world.ask(BESIDE, Mode::ClosedLoop);
        let mut number = 0;
        let result = world.run_with(|world, _| {
            number += 1;
            if number >= 2 {
                world.push(if number % 2 == 0 { 1 } else { also }, 0.05);
            }
        });
        assert!(
            matches!(result, Err(Failure::NotThere { .. })),
            "{result:?}"
        );
        let steps = world.commanded();
        let attempts = [0, 1].map(|step| steps.iter().filter(|it| **it == step).count());
        assert_eq!(attempts.iter().max(), Some(&3), "{steps:?}");
        assert!(steps.len() >= most, "{steps:?}");
    }
}

/// Outcomes that depend on where other objects are.
const UNABLE: [Outcome; 6] = [
    Outcome::NoPath,
    Outcome::WouldFall,
    Outcome::OutOfReach,
    Outcome::Covered,
    Outcome::CannotHold,
    Outcome::Impossible,
];

/// The controller says so of the next command; meanwhile something happens.
fn unable(world: &mut World<'_>, outcome: Outcome, happens: impl Fn(&mut World<'_>)) -> Command {
    let command = world.until_command();
    world.say(&command, Outcome::Accepted);
    world.now_ns += MS;
    happens(world);
    world.say(&command, outcome);
    command
}

#[test]
fn what_could_not_be_done_is_tried_again_only_if_something_else_has_changed() {
    let parts = parts();
    let model = parts.model();
    let sentence = "put the small red block beside the lego blue block";
    for outcome in UNABLE {
        let mut world = world(&model, Limits::default());
        world.ask(sentence, Mode::ClosedLoop);
        unable(&mut world, outcome, |_| {});
        assert_eq!(world.run(), Err(unsuccessful(0, outcome)));
        // The block itself was moved: it was at the place where it was seen.
        world.ask(sentence, Mode::ClosedLoop);
        unable(&mut world, outcome, |world| world.push(1, 0.01));
        assert_eq!(world.run(), Err(unsuccessful(0, outcome)));

        world.log.clear();
        world.ask(sentence, Mode::ClosedLoop);
        unable(&mut world, outcome, |world| world.push(6, 0.05));
        assert_eq!(world.run(), Ok(()));
        assert_eq!(world.log[0], "again 0: unsuccessful");

        // Each time, until its attempts are used up.
        world.ask(sentence, Mode::ClosedLoop);
        for _ in 0..Limits::default().attempts {
            unable(&mut world, outcome, |world| world.push(6, 0.01));
        }
        assert_eq!(world.run(), Err(unsuccessful(0, outcome)));
    }
    // Without an image it is unknown.
    let mut world = world(&model, Limits::default());
    world.ask(sentence, Mode::ClosedLoop);
    unable(&mut world, Outcome::NoPath, |_| {});
    let ended = loop {
        world.now_ns += MS;
        match world.executive.poll(world.now_ns) {
            Event::Ended(ended) => break ended,
            event => assert!(
                matches!(event, Event::Waiting | Event::Working),
                "{event:?}"
            ),
        }
    };
    assert_eq!(ended, Err(unsuccessful(0, Outcome::NoPath)));
}

/// An earlier step is put right first.
#[test]
fn what_has_come_undone_while_a_step_could_not_be_done_is_done_again() {
    let parts = parts();
    let model = parts.model();
    let mut world = world(&model, Limits::default());
    world.ask(BESIDE, Mode::ClosedLoop);
    reach(&mut world);
    let second = unable(&mut world, Outcome::NoPath, |world| world.push(1, 0.05));
    assert_eq!(second.step, 1);
    assert_eq!(world.run(), Ok(()));
    assert_eq!(world.commanded(), [0, 1]);
    assert_eq!(world.log[0], "again 0: unsuccessful");
}

/// The next command is carried out and confirmed.
fn reach(world: &mut World<'_>) {
    let command = world.until_command();
    world.carry_out(&command);
    world.now_ns += MS;
    world.say(&command, Outcome::Reached);
    loop {
        world.see();
        world.now_ns += MS;
        if let Event::Reached { .. } = world.executive.poll(world.now_ns) {
            break;
        }
    }
}

/// The red block, beside which the green one was put, is lost as it is carried on.
#[test]
fn what_a_step_loses_is_not_held_against_an_earlier_one() {
    let parts = parts();
    let model = parts.model();
    let mut world = world(&model, Limits::default());
    world.ask(
        "put the small green block beside the small red block then put the small red block beside \
         the lego red block",
        Mode::ClosedLoop,
    );
    reach(&mut world);
    let second = unable(&mut world, Outcome::Dropped, |world| world.push(1, 0.05));
    assert_eq!(second.step, 1);
    assert_eq!(world.run(), Ok(()));
    assert_eq!(world.commanded(), [1]);
    assert_eq!(world.log[0], "again 1: unsuccessful");
}

#[test]
fn a_reference_that_was_moved_before_the_grasp_is_looked_for_again() {
    let parts = parts();
    let model = parts.model();
    let mut world = world(&model, Limits::default());
    world.outcomes = [Outcome::ReferenceMoved].into();
    world.ask(BESIDE, Mode::ClosedLoop);
    assert_eq!(world.run(), Ok(()));
    assert_eq!(world.commanded(), [0, 0, 1]);
}

/// Once something has moved, a scene that disagrees with the calibration may be one in which it
/// moves still; before, it is the calibration that is wrong.
#[test]
fn a_scene_that_disagrees_with_the_calibration_is_refused_unless_a_later_one_agrees() {
    let parts = parts();
    let model = parts.model();
    let lift = |world: &mut World<'_>, by_m: f32| {
        for id in [3, 4, 5, 6] {
            world.at(id)[4] -= by_m;
        }
    };
    let is_refused = |result: &Result<(), Failure>| {
        matches!(result, Err(Failure::Refused(Refusal::Calibration(_))))
    };
    let mut world = world(&model, Limits::default());
    lift(&mut world, EDGE_M / 2.0);
    world.ask(BESIDE, Mode::ClosedLoop);
    let result = world.run();
    assert!(is_refused(&result), "{result:?}");

    for ends in [true, false] {
        world.scene = raw_scene(&model, &MORE);
        world.ask(BESIDE, Mode::ClosedLoop);
        let first = world.until_command();
        world.carry_out(&first);
        world.now_ns += MS;
        world.say(&first, Outcome::Reached);
        lift(&mut world, EDGE_M / 2.0);
        let begun_ns = world.now_ns;
        while world.now_ns < begun_ns + 500 * MS {
            world.see();
            world.now_ns += MS;
            let event = world.executive.poll(world.now_ns);
            assert!(
                !matches!(event, Event::Ended(_) | Event::Command(_)),
                "{event:?}"
            );
        }
        if ends {
            lift(&mut world, -EDGE_M / 2.0);
        }
        let result = world.run();
        assert!(
            if ends {
                result == Ok(())
            } else {
                is_refused(&result)
            },
            "{result:?}"
        );
    }
}

/// A detector may take parts of two blocks for a third one, midway.
#[test]
fn what_appears_later_is_no_object_of_the_sentence_unless_one_that_is_meant_has_gone() {
    let parts = parts();
    let model = parts.model();
    for is_in_its_place in [false, true] {
        let mut world = world(&model, Limits::default());
        let result = world.follow(BESIDE, 1, |world| {
            // It looks like the object of the second step.
            let green = world.scene.objects[3];
            let mut appeared = ObservedObject { id: 9, ..green };
            appeared.location[0] += 0.1;
            appeared.location[2] += 0.1;
            if is_in_its_place {
                world.scene.objects[3] = appeared;
            } else {
                world.scene.push(appeared).unwrap();
            }
        });
        assert_eq!(result, Ok(()));
        assert_eq!(world.commanded(), [0, 1]);
        let moved = world.commands[1].planned.object.object;
        assert_eq!(moved, if is_in_its_place { 9 } else { 4 });
    }
}
