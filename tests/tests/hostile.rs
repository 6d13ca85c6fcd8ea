//! Invalid messages under the right type name do no harm: every node counts and rejects them, and
//! works afterwards.

use nsrm_core::scene::SceneError;
use nsrm_ipc::clock::now_ns;
use nsrm_ipc::executive::{Limits, Mode, SceneFault};
use nsrm_ipc::message::{
    CameraFrame, Feedback, Heartbeat, Message, Outcome, PlanReply, PlanRequest, Reply, ReplyTo,
    Role, SceneMessage, State, SubGoal,
};
use nsrm_ipc::node::{Client, HEARTBEAT_NS, PerceptionNode, PlannerNode, Transport, Watcher};
use nsrm_ipc::service::{Carried, Receiver, Sender};
use nsrm_tests::by_hand::{Parts, raw_scene};
use nsrm_tests::counting::{Counting, counted};
use nsrm_tests::isolated_memory::{IsolatedMemory, join};
use nsrm_tests::picture;
use nsrm_tests::world::{BLOCKS, HOUR_NS, SENTENCE, World, last_reason, patient};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// A change that makes a message invalid.
type Break<M> = fn(&mut M);

const MS: u64 = 1_000_000;
/// How often everything is sent.
const ROUNDS: u64 = 300;
/// Calls of the allocator for each message that iceoryx2 sends, and for each request
/// that it receives.
const A_MESSAGE: u64 = 2;

/// The next pseudorandom number (`SplitMix64`).
fn random(seed: &mut u64) -> u64 {
    *seed = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut number = *seed;
    number = (number ^ (number >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    number = (number ^ (number >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    number ^ (number >> 31)
}

/// All bits 0 in the first round, all bits 1 in the second, then random.
fn bytes(round: u64, length: usize, seed: &mut u64) -> Vec<u8> {
    (0..length)
        .map(|_| match round {
            0 => 0,
            1 => u8::MAX,
            _ => random(seed).to_le_bytes()[0],
        })
        .collect()
}

/// A message of [`bytes`].
fn nonsense<M: Message>(round: u64, seed: &mut u64) -> M {
    let bytes = bytes(round, size_of::<M>(), seed);
    // SAFETY: the length is the message's, and any bytes are valid: a message consists of integers,
    // floats and arrays of them, without padding.
    unsafe { bytes.as_ptr().cast::<M>().read_unaligned() }
}

/// The valid message with one of these changes, or random bytes.
fn broken<M: Message>(valid: &M, breaks: &[Break<M>], round: u64, seed: &mut u64) -> M {
    if round < 2 || random(seed).is_multiple_of(2) {
        return nonsense(round, seed);
    }
    let mut message = *valid;
    breaks[random(seed) as usize % breaks.len()](&mut message);
    message
}

const HEARTBEAT: Heartbeat = Heartbeat {
    sequence: 1,
    timestamp_ns: 2,
    started_ns: 3,
    rejected: 0,
    role: Role::Controller as u32,
    state: State::Idle as u32,
};
const HEARTBEATS: &[Break<Heartbeat>] = &[
    |it| it.role = 0,
    |it| it.role = 7,
    |it| it.state = 0,
    |it| it.state = 5,
];

const FEEDBACK: Feedback = Feedback {
    plan: 1,
    sequence: 1,
    timestamp_ns: 2,
    command: 1,
    outcome: Outcome::Reached as u32,
    objects: [0; 2],
};
const FEEDBACKS: &[Break<Feedback>] = &[
    |it| it.command = 0,
    |it| it.outcome = 0,
    |it| it.outcome = 99,
];

const REQUESTS: &[Break<PlanRequest>] = &[
    |it| it.purpose = 0,
    |it| it.purpose = 5,
    |it| it.sentence_length = 100_000,
    |it| it.sentence_length = u32::MAX,
    |it| it.sentence[3] = 0xff,
];

const SCENES: &[Break<SceneMessage>] = &[
    |it| it.schema = 2,
    |it| it.frame = 9,
    |it| it.model_tag ^= 1,
    |it| it.timestamp_ns = 0,
    |it| it.timestamp_ns = u64::MAX,
    |it| it.count = 17,
    |it| it.count = u32::MAX,
    |it| it.camera.width = 0,
    |it| it.camera.fx = f32::NAN,
    |it| it.camera.position[1] = f32::INFINITY,
    |it| it.camera.orientation = [0.0; 4],
    |it| it.objects[0].id = 0,
    |it| it.objects[1].id = it.objects[0].id,
    |it| it.objects[0].location[0] = f32::NAN,
    |it| it.objects[1].location.swap(0, 2),
    |it| it.objects[2].location[4] = -1.0,
    |it| it.objects[2].embedding[5] = f32::NEG_INFINITY,
];

const FRAMES: &[Break<CameraFrame>] = &[
    |it| it.camera.width = 0,
    |it| it.camera.height = u32::MAX,
    |it| it.camera.width += 1,
    |it| it.camera.fy = f32::NAN,
    |it| it.camera.orientation[0] = 2.0,
    |it| it.count = 17,
    |it| it.count = u32::MAX,
    |it| it.boxes[0].id = 0,
    |it| it.boxes[1].id = it.boxes[0].id,
    |it| it.boxes[0].visible[2] = f32::NAN,
    |it| it.boxes[0].location.swap(1, 3),
    |it| it.boxes[1].location[0] = -3.0e38,
    |it| it.boxes[1].location[4] = f32::INFINITY,
    |it| it.boxes[2].location[4] = 0.0,
];

const REPLIES: &[Break<PlanReply>] = &[
    |it| it.status = 0,
    |it| it.status = 8,
    |it| (it.status, it.count) = (1, 0),
    |it| (it.status, it.count) = (1, 9),
    |it| (it.status, it.step) = (3, 8),
    |it| (it.status, it.reason) = (6, 0),
    |it| (it.status, it.reason, it.message_length) = (6, 1, u32::MAX),
    |it| (it.status, it.reason, it.message_length, it.message[0]) = (6, 1, 1, 0xff),
];

const SUB_GOALS: &[Break<SubGoal>] = &[
    |it| it.command = 0,
    |it| it.kind = 3,
    |it| it.step = it.steps,
    |it| it.steps = 9,
    |it| it.object_id = 0,
    |it| it.reference_id = it.object_id,
    |it| it.position[0] = f32::NAN,
    |it| it.location[4] = f32::INFINITY,
    |it| it.orientation = [0.0; 4],
    |it| it.confidence = 1.5,
];

fn all<M: Carried>(receiver: &Receiver<M>) -> Vec<M> {
    receiver.waiting().map(|sample| *sample).collect()
}

fn is_refusal(reply: &PlanReply) -> bool {
    let reply = reply.read();
    matches!(reply, Ok(Reply::Failed { reason, .. }) if reason == "bad_request")
}

/// The number of rejected messages in the planner's next heartbeat.
fn beat(planner: &mut PlannerNode<'_>, heard: &Receiver<Heartbeat>, now_ns: u64) -> u64 {
    planner.poll(now_ns);
    let beats = all(heard).into_iter();
    let mut planners = beats.filter(|it| it.role == Role::Planner as u32);
    planners.next_back().map_or(0, |beat| beat.rejected)
}

#[test]
fn a_planner_counts_what_makes_no_sense_and_goes_on() {
    let memory = IsolatedMemory::new("hostile-planner");
    let config = &memory.config;
    let parts = Parts::new();
    let model = parts.model();
    let robot = join("left", Role::Planner, config);
    let mut planner = PlannerNode::begin(robot, &model, patient()).unwrap();
    let other = join("left", Role::Watcher, config);
    let (commands, replies, heard) = (
        other.receiver::<SubGoal>().unwrap(),
        other.receiver::<PlanReply>().unwrap(),
        other.receiver::<Heartbeat>().unwrap(),
    );
    let (heartbeats, scenes, feedback, asks, client) = (
        other.sender::<Heartbeat>().unwrap(),
        other.sender::<SceneMessage>().unwrap(),
        other.sender::<Feedback>().unwrap(),
        other.sender::<PlanRequest>().unwrap(),
        other.plan_client().unwrap(),
    );
    let request = PlanRequest::new(3, 1, Mode::ClosedLoop, SENTENCE).unwrap();
    let mut scene = SceneMessage::from(&raw_scene(&model, &BLOCKS));
    // As if the machine had run for longer than a scene may be old: one of time 0 is too old.
    let (mut now, mut seed, mut sent) = (now_ns() + 2 * HOUR_NS, 7, 0);
    for round in 0..ROUNDS {
        now += MS;
        for _ in 0..16 {
            let message = broken(&HEARTBEAT, HEARTBEATS, round, &mut seed);
            heartbeats.send(&message).unwrap();
        }
        scene.timestamp_ns = now;
        scenes
            .send(&broken(&scene, SCENES, round, &mut seed))
            .unwrap();
        for _ in 0..8 {
            let message = broken(&FEEDBACK, FEEDBACKS, round, &mut seed);
            feedback.send(&message).unwrap();
            asks.send(&broken(&request, REQUESTS, round, &mut seed))
                .unwrap();
        }
        let pending = client
            .send_copy(broken(&request, REQUESTS, round, &mut seed))
            .unwrap();
        let (_, calls) = counted(|| planner.poll(now));
        sent += 16 + 1 + 8 + 8 + 1;
        assert_eq!(planner.rejected(), sent, "round {round}");
        // One received request, nine answers for all, one for the client; and a heartbeat if it is
        // due.
        let expected = [1 + 9 + 1, 1 + 9 + 1 + 1].map(|messages| A_MESSAGE * messages);
        assert!(round == 0 || expected.contains(&calls), "{calls}");
        let told = pending.receive().unwrap().expect("an answer");
        assert!(is_refusal(&told) && !pending.is_connected());
        let told = all(&replies);
        assert!(told.len() == 9 && told.iter().all(is_refusal));
    }
    assert!(all(&commands).is_empty());
    // The heartbeat has the same number.
    assert_eq!(beat(&mut planner, &heard, now + HEARTBEAT_NS), sent);

    drop((commands, scenes, feedback));
    let mut world = World::new("left", &model, config);
    let pending = world.ask(1, SENTENCE);
    let base = (now, now_ns());
    let replies = world.follow(&mut planner, &pending, || {
        // Meanwhile, invalid messages to the services with several publishers.
        heartbeats.send(&nonsense(sent, &mut sent.clone())).unwrap();
        asks.send(&nonsense(sent, &mut sent.clone())).unwrap();
        base.0 + HEARTBEAT_NS + (now_ns() - base.1)
    });
    assert_eq!(last_reason(&replies), None);
    assert_eq!(world.controller.done.len(), 2);
}

#[test]
fn perception_makes_nothing_of_what_is_no_frame() {
    let memory = IsolatedMemory::new("hostile-camera");
    let config = &memory.config;
    let model = &nsrm_tabletop::TABLETOP;
    let camera = join("left", Role::Camera, config);
    // Small, since each frame is written again.
    let mut valid = picture::squares().frame();
    (valid.camera.width, valid.camera.height) = (64, 48);
    let length = 64 * 48 * 7;
    let out = camera.frames_out(length).unwrap();
    let scenes = camera.receiver::<SceneMessage>().unwrap();
    let robot = join("left", Role::Perception, config);
    let mut perception = PerceptionNode::begin(robot, model).unwrap();
    let (now, mut seed) = (now_ns(), 7);
    for round in 0..5 * ROUNDS {
        let header = broken(&valid, FRAMES, round, &mut seed);
        out.send(header, length, |_| {}).unwrap();
        let (seen, calls) = counted(|| perception.poll(now));
        // Except for the connection to the camera, and the first heartbeat.
        assert!(seen && (round == 0 || calls == 0), "{calls}");
        // Valid, except for the length of the image.
        let wrong = random(&mut seed) as usize % length;
        out.send(valid, wrong, |_| {}).unwrap();
        assert!(perception.poll(now));
        assert_eq!(perception.rejected(), 2 * (round + 1), "{header:?}");
        assert!(scenes.receive().unwrap().is_none());
    }
    out.send(valid, length, |image| image.fill(99)).unwrap();
    assert!(perception.poll(now));
    let scene = scenes.receive().unwrap().expect("a scene");
    assert!(scene.to_scene(model).is_ok());
    assert_eq!(perception.rejected(), 10 * ROUNDS);
}

#[test]
fn who_asks_takes_no_nonsense_for_an_answer() {
    let memory = IsolatedMemory::new("hostile-answers");
    let config = &memory.config;
    let planner = join("left", Role::Planner, config);
    let (asked, answers, heartbeats, server) = (
        planner.receiver::<PlanRequest>().unwrap(),
        planner.sender::<PlanReply>().unwrap(),
        planner.sender::<Heartbeat>().unwrap(),
        planner.plan_server().unwrap(),
    );
    for transport in [Transport::Connection, Transport::Broadcast] {
        let mut client =
            Client::begin(join("left", Role::Client, config), transport, u64::MAX).unwrap();
        let mut request = client.ask(SENTENCE, Mode::ClosedLoop).unwrap();
        let active = server.receive().unwrap();
        let received = match &active {
            Some(active) => **active,
            None => *asked.receive().unwrap().expect("one of both"),
        };
        let done = PlanReply::refused(to(&received, 1), "busy", "another sentence");
        let reply = |message: PlanReply| match &active {
            Some(active) => active.send_copy(message).unwrap(),
            None => assert_eq!(answers.send(&message), Ok(1)),
        };
        let mut seed = 7;
        for round in 0..ROUNDS {
            for _ in 0..8 {
                reply(broken(&done, REPLIES, round, &mut seed));
            }
            let message = broken(&HEARTBEAT, HEARTBEATS, round, &mut seed);
            heartbeats.send(&message).unwrap();
            let now = now_ns();
            assert_eq!(client.poll(&mut request, now), Ok(None), "{transport:?}");
            assert_eq!(client.rejected(), 9 * (round + 1), "{transport:?}");
        }
        reply(done);
        assert_eq!(client.poll(&mut request, now_ns()), Ok(Some(done)));
    }
}

fn to(request: &PlanRequest, number: u32) -> ReplyTo {
    ReplyTo {
        client: request.client,
        request: request.sequence,
        plan: 0,
        number,
    }
}

#[test]
fn who_looks_on_sees_nothing_in_nonsense() {
    let memory = IsolatedMemory::new("hostile-watched");
    let config = &memory.config;
    let parts = Parts::new();
    let mut watcher = Watcher::begin(join("left", Role::Watcher, config)).unwrap();
    let other = join("left", Role::Planner, config);
    let (heartbeats, scenes, feedback, answers) = (
        other.sender::<Heartbeat>().unwrap(),
        other.sender::<SceneMessage>().unwrap(),
        other.sender::<Feedback>().unwrap(),
        other.sender::<PlanReply>().unwrap(),
    );
    let scene = SceneMessage::from(&raw_scene(&parts.model(), &BLOCKS));
    let request = PlanRequest::cancel(3, 1);
    let reply = PlanReply::refused(to(&request, 1), "busy", "another sentence");
    let mut seed = 7;
    for round in 0..ROUNDS {
        for _ in 0..8 {
            let message = broken(&HEARTBEAT, HEARTBEATS, round, &mut seed);
            heartbeats.send(&message).unwrap();
            let message = broken(&FEEDBACK, FEEDBACKS, round, &mut seed);
            feedback.send(&message).unwrap();
            let message = broken(&reply, REPLIES, round, &mut seed);
            answers.send(&message).unwrap();
        }
        // Without the model no more of a scene can be checked.
        let breaks: &[Break<SceneMessage>] = &[|it| it.schema = 2, |it| it.count = 17];
        let message = broken(&scene, breaks, round, &mut seed);
        scenes.send(&message).unwrap();
        let view = watcher.look(now_ns());
        assert_eq!(view.rejected, 25 * (round + 1));
        assert!(view.nodes.iter().all(Option::is_none) && view.replies.is_empty());
        assert_eq!((view.scenes.count, view.feedback.count), (0, 0));
    }
    heartbeats.send(&HEARTBEAT).unwrap();
    let nodes = watcher.look(now_ns()).nodes;
    assert_eq!(nodes.iter().flatten().count(), 1);
}

#[test]
fn a_controller_moves_nothing_by_what_is_no_command() {
    let memory = IsolatedMemory::new("hostile-commands");
    let config = &memory.config;
    let parts = Parts::new();
    let model = parts.model();
    let mut world = World::new("left", &model, config);
    let other = join("left", Role::Planner, config);
    let commands: Sender<SubGoal> = other.sender().unwrap();
    let valid = SubGoal {
        plan: 1,
        until_ns: u64::MAX,
        command: 1,
        kind: 1,
        step: 0,
        steps: 1,
        action: 0,
        object_id: 1,
        reference_id: 2,
        confidence: 0.9,
        position: [0.5, 0.0, 0.02],
        orientation: [0.0, 0.0, 0.0, 1.0],
        location: [0.1, 0.2, 0.3, 0.4, 1.0],
        keep: [3, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0],
    };
    let (objects, mut seed) = (world.scene.objects, 7);
    for round in 0..ROUNDS {
        for _ in 0..8 {
            let message = broken(&valid, SUB_GOALS, round, &mut seed);
            commands.send(&message).unwrap();
        }
        world.turn(now_ns());
        assert_eq!(world.controller.rejected, 8 * (round + 1));
    }
    assert!(world.controller.done.is_empty() && world.scene.objects == objects);
    // Whatever numbers those had that made no sense.
    commands.send(&valid).unwrap();
    world.turn(now_ns());
    assert_eq!(world.controller.done, [valid]);
}

/// A scene of a robot's own is broken by each of the ways above, and not without them.
#[test]
fn each_way_to_break_a_scene_breaks_it() {
    let parts = Parts::new();
    let model = parts.model();
    let mut valid = SceneMessage::from(&raw_scene(&model, &BLOCKS));
    valid.timestamp_ns = 1000 * MS;
    let mut executive = nsrm_ipc::executive::Executive::new(&model, Limits::default(), 1);
    assert_eq!(executive.on_scene(&valid, 1000 * MS), Ok(()));
    for (place, break_it) in SCENES.iter().enumerate() {
        let mut scene = valid;
        break_it(&mut scene);
        let seen = executive.on_scene(&scene, 1000 * MS);
        assert!(seen.is_err(), "way {place}");
    }
    let mut scene = valid;
    scene.count = u32::MAX;
    let count = u32::MAX;
    let expected = SceneFault::Invalid(SceneError::TooManyObjects { count });
    assert_eq!(executive.on_scene(&scene, 1000 * MS), Err(expected));
}
