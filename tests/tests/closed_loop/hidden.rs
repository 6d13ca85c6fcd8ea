//! A camera that looks down from above: it shows only the top block of a stack.

use nsrm_core::model::LOCATION;
use nsrm_core::{RawScene, Refusal};
use nsrm_ipc::executive::{Command, Event, Failure, Limits, Mode};
use nsrm_ipc::message::Outcome;
use nsrm_tests::by_hand::{Block, EDGES_M, Parts, block, raw_scene};
use nsrm_tests::world::{BLOCKS, SENTENCE};

use crate::world::{TWO_STEPS_DONE, World};

/// Height of a block, metres.
pub(crate) const EDGE_M: f32 = EDGES_M[2];
/// Width of its box as a fraction of the image's. Predictions do not change it, so it must still be
/// valid for a block that is nearer to the camera by the height of two blocks.
const WIDTH: f32 = 0.018;
/// The distance between a block and the one beside it, as a fraction of the image's width.
const BESIDE: f32 = 0.05;

/// A model that puts one block onto another (nearer to the camera by its height), or to its right.
pub(crate) fn parts() -> Parts {
    let mut parts = Parts::new();
    parts.simulator.output.bias[4] = -EDGE_M;
    // One unit of each layer, which only the second action sets.
    parts.actions[1].simulator_bias[0] = 20.0;
    parts.simulate_one_unit();
    parts.simulator.output.weight[0] = [BESIDE, 0.0, 0.0, 0.0, EDGE_M];
    parts
}

/// The fraction of a block's box that is covered by another box nearer to the camera.
fn hidden_share(of: &[f32; LOCATION], by: &[f32; LOCATION]) -> f32 {
    if by[4] >= of[4] {
        return 0.0;
    }
    let width = (of[2].min(by[2]) - of[0].max(by[0])).max(0.0);
    let height = (of[3].min(by[3]) - of[1].max(by[1])).max(0.0);
    width * height / ((of[2] - of[0]) * (of[3] - of[1]))
}

/// What the camera shows: no block of which nine tenths are hidden.
fn from_above(scene: &RawScene) -> RawScene {
    let all = &scene.objects[..scene.count as usize];
    let mut shown = *scene;
    shown.count = 0;
    for object in all {
        let is_hidden = all
            .iter()
            .any(|other| hidden_share(&object.location, &other.location) > 0.9);
        if !is_hidden {
            shown.push(*object).unwrap();
        }
    }
    shown
}

/// A world with these blocks, seen by this camera.
fn world<'m>(model: &'m nsrm_core::Model<'m>, blocks: &[Block], limits: Limits) -> World<'m> {
    let mut world = World::new(model, limits);
    world.scene = raw_scene(model, blocks);
    for object in &mut world.scene.objects[..blocks.len()] {
        object.location[2] = object.location[0] + WIDTH;
    }
    world.view = from_above;
    world
}

impl World<'_> {
    fn location(&mut self, id: u32) -> &mut [f32; LOCATION] {
        let mut objects = self.scene.objects.iter_mut();
        &mut objects.find(|object| object.id == id).unwrap().location
    }

    /// Removes a block, as a person would.
    fn take(&mut self, id: u32) {
        let count = self.scene.count as usize;
        let objects = &mut self.scene.objects[..count];
        let place = objects.iter().position(|object| object.id == id).unwrap();
        objects.swap(place, count - 1);
        self.scene.count -= 1;
    }

    fn shows(&self, id: u32) -> bool {
        let shown = from_above(&self.scene);
        let mut shown = shown.objects.iter().take(shown.count as usize);
        shown.any(|object| object.id == id)
    }

    fn steps(&self) -> Vec<u8> {
        self.commands.iter().map(|command| command.step).collect()
    }
}

fn is_no_such_object(result: &Result<(), Failure>, at: u8) -> bool {
    matches!(result, Err(Failure::Refused(Refusal::NoSuchObject { step, .. })) if *step == at)
}

#[test]
fn a_stack_of_three_seen_from_above_is_done() {
    let parts = parts();
    let model = parts.model();
    let mut world = world(&model, &BLOCKS, Limits::default());
    world.ask(SENTENCE, Mode::ClosedLoop);
    assert_eq!(world.run(), Ok(()));
    assert_eq!([1, 2, 3].map(|id| world.shows(id)), [false, false, true]);
    assert_eq!(world.log, TWO_STEPS_DONE);
}

/// The blue block is at the bottom of the stack, and is named again.
#[test]
fn what_is_left_is_planned_with_what_the_steps_have_hidden() {
    let parts = parts();
    let model = parts.model();
    let blocks = [&BLOCKS[..], &[block("small", "green")]].concat();
    let mut world = world(&model, &blocks, Limits::default());
    let blue = *world.location(2);
    world.ask(
        "put the small red block on the blue block then put the lego green block on the small red \
         block then put the small green block beside the blue block",
        Mode::ClosedLoop,
    );
    assert_eq!(world.run(), Ok(()));
    assert_eq!(world.steps(), [0, 1, 2]);
    let beside = *world.location(4);
    assert!((beside[0] - blue[0] - BESIDE).abs() < 1e-5, "{beside:?}");
    assert!((beside[4] - blue[4]).abs() < 1e-5, "{beside:?}");
}

/// The red block is removed while another step is executed elsewhere.
#[test]
fn a_block_that_has_vanished_is_missed() {
    let sentence = "put the small red block beside the blue block then put the green block on the \
                    blue block";
    let parts = parts();
    let model = parts.model();
    let limits = Limits {
        retries: 0,
        ..Limits::default()
    };
    // The object that a step has put down, and its reference.
    for (gone, at) in [(1, 1), (2, 0)] {
        let mut world = world(&model, &BLOCKS, limits);
        world.ask(sentence, Mode::ClosedLoop);
        let result = world.run_with(|world, command| {
            if command.step == at {
                world.take(gone);
            }
        });
        let (step, object) = (0, gone);
        assert_eq!(result, Err(Failure::NotSeen { step, object }));
    }
    // With retries the scene is observed once more, and nothing is moved meanwhile.
    let mut world = world(&model, &BLOCKS, Limits::default());
    world.ask(sentence, Mode::ClosedLoop);
    let result = world.run_with(|world, command| {
        if command.step == 1 {
            world.take(1);
        }
    });
    assert!(is_no_such_object(&result, 0), "{result:?}");
    assert_eq!(world.log.last().unwrap(), "again 0: not_seen");
    assert_eq!(world.steps(), [0, 1]);
}

/// The green block falls to the place of the red one that supported it.
#[test]
fn a_block_that_has_vanished_from_under_another_is_missed() {
    let parts = parts();
    let model = parts.model();
    let mut world = world(&model, &BLOCKS, Limits::default());
    world.ask(SENTENCE, Mode::ClosedLoop);
    let result = world.run_with(|world, command| {
        if command.step == 1 {
            world.take(1);
            world.location(3)[4] += EDGE_M;
        }
    });
    assert!(
        world.log.contains(&"again 0: not_seen".into()),
        "{:?}",
        world.log
    );
    assert!(is_no_such_object(&result, 0), "{result:?}");
}

/// A block is put in front of the red one while a step is executed elsewhere.
#[test]
fn what_no_step_has_put_before_a_block_excuses_nothing() {
    let parts = parts();
    let model = parts.model();
    let limits = Limits {
        retries: 0,
        ..Limits::default()
    };
    let blocks = [&BLOCKS[..], &[block("small", "green")]].concat();
    let mut world = world(&model, &blocks, limits);
    world.ask(
        "put the small red block beside the blue block then put the lego green block on the blue \
         block",
        Mode::ClosedLoop,
    );
    let result = world.run_with(|world, command| {
        if command.step == 1 {
            let mut above = *world.location(1);
            above[4] -= EDGE_M;
            *world.location(4) = above;
        }
    });
    assert!(!world.shows(1) && world.shows(4));
    let (step, object) = (0, 1);
    assert_eq!(result, Err(Failure::NotSeen { step, object }));
}

/// A camera that looks slightly from the side shows a strip of a hidden block: its side face.
fn a_strip(scene: &RawScene) -> RawScene {
    let all = &scene.objects[..scene.count as usize];
    let mut shown = *scene;
    for object in &mut shown.objects[..all.len()] {
        let is_hidden = all
            .iter()
            .any(|other| hidden_share(&object.location, &other.location) > 0.4);
        if is_hidden {
            let [x1, _, x2, _, depth_m] = &mut object.location;
            *x2 = *x1 + 0.2 * (*x2 - *x1);
            *depth_m += EDGE_M / 2.0;
            // Its appearance differs, too.
            object.embedding.fill(0.1);
        }
    }
    shown
}

#[test]
fn a_block_that_is_hidden_in_part_is_where_it_was() {
    let parts = parts();
    let model = parts.model();
    let mut world = world(&model, &BLOCKS, Limits::default());
    world.view = a_strip;
    world.ask(SENTENCE, Mode::ClosedLoop);
    assert_eq!(world.run(), Ok(()));
    assert_eq!(world.steps(), [0, 1]);
}

#[test]
fn a_block_that_has_moved_is_not_excused_by_what_hides_a_part_of_it_or_nothing() {
    let parts = parts();
    let model = parts.model();
    let limits = Limits {
        retries: 0,
        ..Limits::default()
    };
    // The strip is seen beside the block's old place, and nothing covers it.
    for (relation, axis, by) in [("on", 0, -0.008), ("beside", 4, EDGE_M / 2.0)] {
        let mut world = world(&model, &BLOCKS, limits);
        world.view = a_strip;
        let sentence = format!("put the small red block {relation} the blue block");
        world.ask(&sentence, Mode::ClosedLoop);
        let result = world.run_with(|world, _| {
            let blue = world.location(2);
            blue[axis] += by;
            if axis == 0 {
                blue[2] += by;
            }
        });
        assert!(
            matches!(result, Err(Failure::NotThere { object: 2, .. })),
            "{relation}: {result:?}"
        );
    }
}

/// The green block slips on the red one, which it still hides. A third block is where it should be,
/// so the camera's calibration is not blamed.
#[test]
fn what_hides_another_is_put_right_without_it() {
    let parts = parts();
    let model = parts.model();
    let blocks = [&BLOCKS[..], &[block("small", "green")]].concat();
    let mut world = world(&model, &blocks, Limits::default());
    world.ask(
        "put the small red block on the blue block then put the lego green block on the small red \
         block",
        Mode::ClosedLoop,
    );
    let result = world.run_with(|world, command| {
        if command.id.command == 2 {
            world.location(3)[4] -= EDGE_M / 2.0;
        }
    });
    assert_eq!(result, Ok(()));
    assert_eq!(world.steps(), [0, 1, 1]);
}

/// The step that was undone is planned with the blocks hidden since, and the stack stays.
#[test]
fn an_earlier_step_is_done_again_beside_a_stack() {
    let parts = parts();
    let model = parts.model();
    let blocks = [&BLOCKS[..], &[block("lego", "red"), block("small", "blue")]].concat();
    let mut world = world(&model, &blocks, Limits::default());
    world.ask(
        "put the small blue block beside the lego red block then put the small red block on the \
         lego blue block",
        Mode::ClosedLoop,
    );
    let result = world.run_with(|world, command| {
        if command.id.command == 2 {
            world.location(5)[0] += 0.1;
            world.location(5)[2] += 0.1;
        }
    });
    assert_eq!(result, Ok(()));
    assert_eq!(world.steps(), [0, 1, 0]);
}

/// The controller moves the green block out of the image, and the red one to its sub-goal.
#[test]
fn what_was_moved_aside_is_not_believed_to_be_where_it_was() {
    let parts = parts();
    let model = parts.model();
    let mut world = world(&model, &BLOCKS, Limits::default());
    world.ask(
        "put the small red block on the blue block then put the green block on the small red block",
        Mode::ClosedLoop,
    );
    *world.location(3) = *world.location(2);
    world.location(3)[0] += 0.001;
    let command = world.until_command();
    world.say(&command, Outcome::Clearing);
    assert!(matches!(
        world.executive.poll(world.now_ns),
        Event::Clearing { .. }
    ));
    world.carry_out(&command);
    world.take(3);
    world.say(&command, Outcome::Reached);
    let result = world.run();
    assert!(is_no_such_object(&result, 1), "{result:?}");
    assert_eq!(world.log, ["reached 0"]);
}

/// The belief about a carried object is dropped, whatever is at its old place.
#[test]
fn what_was_carried_must_be_seen_where_it_was_put() {
    let parts = parts();
    let model = parts.model();
    let limits = Limits {
        retries: 0,
        ..Limits::default()
    };
    let mut world = world(&model, &BLOCKS, limits);
    world.ask(SENTENCE, Mode::ClosedLoop);
    let result = world.run_with(|world, command: &Command| {
        if command.step == 1 {
            world.take(3);
        }
    });
    let (step, object) = (1, 3);
    assert_eq!(result, Err(Failure::NotSeen { step, object }));
}
