//! Nodes of one robot over shared memory, in one process and without sleeping: the real planner and
//! perception, with a controller and a client that belong to the test.

use iceoryx2::config::Config;
use nsrm_core::Model;
use nsrm_core::vision::{ObservationTask, RgbImage, Stamp};
use nsrm_ipc::clock::now_ns;
use nsrm_ipc::executive::Mode;
use nsrm_ipc::message::{Outcome, PlanReply, PlanRequest, Reply, Role, SceneMessage};
use nsrm_ipc::node::{PerceptionNode, PlannerNode};
use nsrm_tests::by_hand::{Parts, block, raw_scene};
use nsrm_tests::counting::{Counting, counted};
use nsrm_tests::isolated_memory::{IsolatedMemory, join};
use nsrm_tests::picture;
use nsrm_tests::world::{SENTENCE, World, last_reason, patient};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Robot `left`'s planner.
fn planner<'m>(model: &'m Model<'m>, config: &Config) -> PlannerNode<'m> {
    let robot = join("left", Role::Planner, config);
    PlannerNode::begin(robot, model, patient()).unwrap()
}

#[test]
fn a_sentence_goes_through_shared_memory_and_comes_back_done() {
    let memory = IsolatedMemory::new("done");
    let config = &memory.config;
    let parts = Parts::new();
    let model = parts.model();
    let mut planner = planner(&model, config);
    let mut world = World::new("left", &model, config);
    let pending = world.ask(7, SENTENCE);
    let replies = world.follow(&mut planner, &pending, now_ns);
    let told: Vec<_> = replies
        .iter()
        .map(|reply| match reply.read().unwrap() {
            Reply::Planned { steps, .. } => format!("planned {}", steps.len()),
            Reply::Commanded { step } => format!("commanded {step}"),
            Reply::Reached { step, off_m } => {
                assert!(off_m < 1e-3);
                format!("reached {step}")
            }
            Reply::Done => "done".into(),
            reply => panic!("{reply:?}"),
        })
        .collect();
    assert_eq!(
        told,
        [
            "planned 2",
            "commanded 0",
            "reached 0",
            "planned 2",
            "commanded 1",
            "reached 1",
            "done"
        ]
    );
    let numbers: Vec<_> = replies.iter().map(|reply| reply.number).collect();
    assert_eq!(numbers, (1..=7).collect::<Vec<_>>());
    assert!(
        replies
            .iter()
            .all(|reply| (reply.client, reply.request) == (3, 7))
    );
    let objects: Vec<_> = world
        .controller
        .done
        .iter()
        .map(|goal| goal.object_id)
        .collect();
    assert_eq!(objects, [1, 3]);
}

/// Calls of the allocator for each message that iceoryx2 sends, and for each request that it
/// receives: it allocates once and frees it.
const A_MESSAGE: u64 = 2;
/// Time between two turns.
const TURN_NS: u64 = 100_000;

/// From the second sentence on, and from the second frame on.
#[test]
fn no_node_allocates_once_it_is_at_work_but_for_iceoryx2s_sending() {
    let memory = IsolatedMemory::new("allocation");
    let parts = Parts::new();
    let model = parts.model();
    let mut planner = planner(&model, &memory.config);
    let mut world = World::new("left", &model, &memory.config);
    let standing = world.scene;
    // Set by the test, so that the number of heartbeats is the same on any machine.
    let mut now = now_ns();
    for sequence in 1..=3 {
        world.scene.objects = standing.objects;
        let pending = world.ask(sequence, SENTENCE);
        let (mut calls, mut messages, mut ended) = (0, 1, false);
        while !ended {
            now += TURN_NS;
            world.turn(now);
            calls += counted(|| planner.poll(now)).1;
            while let Some(reply) = pending.receive().unwrap() {
                // One to the client and one to the observers; a command is a message, too.
                let is_command = matches!(reply.read(), Ok(Reply::Commanded { .. }));
                messages += 2 + u64::from(is_command);
                ended |= matches!(reply.read(), Ok(Reply::Done));
            }
        }
        // Heartbeats are sent when they are due.
        let beats = [0, 1, 2].map(|beats| A_MESSAGE * (messages + beats));
        assert!(
            sequence == 1 || beats.contains(&calls),
            "{calls}, {messages}"
        );
    }

    let model = &nsrm_tabletop::TABLETOP;
    let camera = join("left", Role::Camera, &memory.config);
    let picture = picture::squares();
    let bytes = picture.pixels.len() / 3 * 7;
    let out = camera.frames_out(bytes).unwrap();
    drop(world);
    let robot = join("left", Role::Perception, &memory.config);
    let mut perception = PerceptionNode::begin(robot, model).unwrap();
    let began_ns = now_ns();
    let mut calls = Vec::new();
    for _ in 0..3 {
        let header = picture.frame();
        let write =
            |image: &mut [u8]| image[..picture.pixels.len()].copy_from_slice(&picture.pixels);
        assert_eq!(out.send(header, bytes, write), Ok(1));
        // Long before its next heartbeat.
        let (seen, more) = counted(|| perception.poll(began_ns));
        assert!(seen);
        calls.push(more);
    }
    assert_eq!(calls[1..], [A_MESSAGE; 2], "{calls:?}");
}

#[test]
fn refusals_and_a_busy_planner_are_told_in_words() {
    let memory = IsolatedMemory::new("refused");
    let config = &memory.config;
    let parts = Parts::new();
    let model = parts.model();
    let mut planner = planner(&model, config);
    let mut world = World::new("left", &model, config);
    let pending = world.ask(1, "put the purple block on the blue block");
    let replies = world.follow(&mut planner, &pending, now_ns);
    let Ok(Reply::Failed { reason, message }) = replies[0].read() else {
        panic!("{:?}", replies[0].read());
    };
    assert_eq!((reason, replies.len()), ("unknown_word", 1));
    assert!(message.contains("\"purple\""), "{message}");
    drop(pending);

    // A camera whose calibration says that it is higher than it is.
    world.scene.camera.position[2] += 0.05;
    let pending = world.ask(4, SENTENCE);
    let replies = world.follow(&mut planner, &pending, now_ns);
    let Ok(Reply::Failed { reason, message }) = replies[0].read() else {
        panic!("{:?}", replies[0].read());
    };
    assert_eq!((reason, replies.len()), ("calibration", 1));
    let parts = [
        "object 1",
        "0.075 m",
        "0.025 m",
        "calibrate the camera again",
    ];
    assert!(parts.iter().all(|part| message.contains(part)), "{message}");
    assert_eq!(world.controller.taken, 0);
    world.scene.camera.position[2] -= 0.05;
    drop(pending);

    world.controller.works = false;
    let first = world.ask(2, SENTENCE);
    for _ in 0..200 {
        world.turn(now_ns());
        planner.poll(now_ns());
    }
    let second = world.ask(3, SENTENCE);
    let replies = world.follow(&mut planner, &second, now_ns);
    assert_eq!(last_reason(&replies), Some("busy"));
    drop(second);
    // A client can cancel its own request only, not another client's by its number.
    for (sequence, expected) in [(9, Some("no_such_request")), (2, None)] {
        let cancel = world
            .client
            .send_copy(PlanRequest::cancel(3, sequence))
            .unwrap();
        let replies = world.follow(&mut planner, &cancel, now_ns);
        assert_eq!(last_reason(&replies), expected);
    }
    let replies = world.follow(&mut planner, &first, now_ns);
    assert_eq!(last_reason(&replies), Some("cancelled"));
    assert!(world.controller.done.is_empty());
}

/// The reply to a cancel request is not for them, and is not the end of the sentence.
#[test]
fn onlookers_are_told_once_how_a_cancelled_sentence_ended() {
    let memory = IsolatedMemory::new("onlooker");
    let config = &memory.config;
    let parts = Parts::new();
    let model = parts.model();
    let mut planner = planner(&model, config);
    let mut world = World::new("left", &model, config);
    let onlooker = join("left", Role::Watcher, config);
    let answers = onlooker.receiver::<PlanReply>().unwrap();
    world.controller.works = false;
    let pending = world.ask(1, SENTENCE);
    for _ in 0..200 {
        world.turn(now_ns());
        planner.poll(now_ns());
    }
    let cancel = PlanRequest::cancel(3, 1);
    let cancel = world.client.send_copy(cancel).unwrap();
    assert_eq!(
        last_reason(&world.follow(&mut planner, &cancel, now_ns)),
        None
    );
    let told = world.follow(&mut planner, &pending, now_ns);
    assert_eq!(last_reason(&told), Some("cancelled"));
    let seen: Vec<_> = answers.waiting().map(|reply| *reply).collect();
    let ends = seen.iter().filter_map(|reply| match reply.read().unwrap() {
        Reply::Done => Some("done"),
        Reply::Failed { reason, .. } => Some(reason),
        _ => None,
    });
    assert_eq!(ends.collect::<Vec<_>>(), ["cancelled"]);
    let numbers: Vec<_> = seen.iter().map(|reply| reply.number).collect();
    assert_eq!(numbers, (1..=seen.len() as u32).collect::<Vec<_>>());
}

#[test]
fn who_asked_and_left_has_cancelled() {
    let memory = IsolatedMemory::new("left");
    let config = &memory.config;
    let parts = Parts::new();
    let model = parts.model();
    let mut planner = planner(&model, config);
    let mut world = World::new("left", &model, config);
    world.controller.works = false;
    drop(world.ask(1, SENTENCE));
    for _ in 0..200 {
        world.turn(now_ns());
        planner.poll(now_ns());
    }
    assert!(world.controller.done.is_empty());
    world.controller.works = true;
    let pending = world.ask(2, SENTENCE);
    let replies = world.follow(&mut planner, &pending, now_ns);
    assert_eq!(last_reason(&replies), None);
}

#[test]
fn a_controller_that_was_started_anew_ends_the_sentence() {
    let memory = IsolatedMemory::new("anew");
    let config = &memory.config;
    let parts = Parts::new();
    let model = parts.model();
    let mut planner = planner(&model, config);
    let mut world = World::new("left", &model, config);
    world.controller.works = false;
    let pending = world.ask(1, SENTENCE);
    let mut replies = Vec::new();
    while !replies
        .iter()
        .any(|reply: &PlanReply| matches!(reply.read(), Ok(Reply::Commanded { .. })))
    {
        world.turn(now_ns());
        planner.poll(now_ns());
        replies.extend(pending.receive().unwrap().map(|reply| *reply));
    }
    world.turn(now_ns());
    planner.poll(now_ns());
    world.controller.started_ns = 2;
    let replies = world.follow(&mut planner, &pending, now_ns);
    assert_eq!(last_reason(&replies), Some("controller_lost"));
}

/// In a caller's own loop, where nothing else would stop it.
#[test]
fn a_planner_that_is_dropped_stops_what_moves() {
    let memory = IsolatedMemory::new("dropped");
    let parts = Parts::new();
    let model = parts.model();
    let mut planner = planner(&model, &memory.config);
    let mut world = World::new("left", &model, &memory.config);
    world.controller.works = false;
    let pending = world.ask(1, SENTENCE);
    while world.controller.taken == 0 {
        world.turn(now_ns());
        planner.poll(now_ns());
    }
    drop(planner);
    world.turn(now_ns());
    assert_eq!(world.controller.taken, 2);
    assert_eq!(world.controller.outcome(), Some(Outcome::Stopped));
    let replies = std::iter::from_fn(|| pending.receive().unwrap().map(|reply| *reply));
    assert_eq!(last_reason(&replies.collect::<Vec<_>>()), Some("stopping"));
}

#[test]
fn without_a_controller_nothing_is_accepted() {
    let memory = IsolatedMemory::new("alone");
    let config = &memory.config;
    let parts = Parts::new();
    let model = parts.model();
    let mut planner = planner(&model, config);
    let robot = join("left", Role::Client, config);
    let (scenes, client) = (
        robot.sender::<SceneMessage>().unwrap(),
        robot.plan_client().unwrap(),
    );
    let request = PlanRequest::new(3, 1, Mode::ClosedLoop, SENTENCE).unwrap();
    let pending = client.send_copy(request).unwrap();
    let mut scene = raw_scene(&model, &[block("small", "red"), block("lego", "blue")]);
    let mut objects = scene.objects[1];
    objects.id = 3;
    objects.embedding = nsrm_tests::by_hand::embedding(&block("lego", "green"));
    objects.location[0] += 0.05;
    objects.location[2] += 0.05;
    scene.push(objects).unwrap();
    let mut replies = Vec::new();
    while pending.is_connected() {
        scene.header.timestamp_ns = now_ns();
        scenes.send(&SceneMessage::from(&scene)).unwrap();
        planner.poll(now_ns());
        replies.extend(pending.receive().unwrap().map(|reply| *reply));
    }
    replies.extend(pending.receive().unwrap().map(|reply| *reply));
    assert_eq!(last_reason(&replies), Some("not_accepted"));
}

/// The same scene as core computes from the same image; the image is read in place.
#[test]
fn perception_makes_a_scene_of_a_frame() {
    let memory = IsolatedMemory::new("perception");
    let config = &memory.config;
    let model = &nsrm_tabletop::TABLETOP;
    let camera = join("left", Role::Camera, config);
    let picture = picture::squares();
    let bytes = picture.pixels.len() / 3 * 7;
    let out = camera.frames_out(bytes).unwrap();
    let scenes = camera.receiver::<SceneMessage>().unwrap();
    let mut perception =
        PerceptionNode::begin(join("left", Role::Perception, config), model).unwrap();
    let mut frame = picture.frame();
    let write = |image: &mut [u8]| image[..picture.pixels.len()].copy_from_slice(&picture.pixels);
    assert_eq!(out.send(frame, bytes, write), Ok(1));
    assert!(perception.poll(now_ns()));
    let scene = scenes
        .receive()
        .unwrap()
        .expect("a scene")
        .to_scene(model)
        .unwrap();
    let [width, height] = picture::SIZE;
    let image = RgbImage::new(&picture.pixels, width, height, 3 * width as usize).unwrap();
    let (sequence, timestamp_ns) = (4, 5);
    let stamp = Stamp {
        sequence,
        timestamp_ns,
    };
    let task = ObservationTask::new(model, image, picture::camera(), &picture.detections, stamp);
    assert_eq!(Ok(scene), task.unwrap().finish());

    // An invalid frame is only rejected.
    frame.count = 99;
    assert_eq!(out.send(frame, bytes, write), Ok(1));
    assert!(perception.poll(now_ns()));
    assert!(scenes.receive().unwrap().is_none());
    assert!(!perception.poll(now_ns()));
}
