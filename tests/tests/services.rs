//! The services give the guarantees in their table, between two nodes of one process.

use std::sync::Barrier;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use iceoryx2::config::Config;
use iceoryx2::prelude::*;
use nsrm_ipc::executive::Mode;
use nsrm_ipc::message::{
    CameraFrame, CameraMessage, DetectedBox, Feedback, Heartbeat, Message, PlanReply, PlanRequest,
    ReplyTo, Role, SceneMessage, State, SubGoal,
};
use nsrm_ipc::service::{
    Carried, Hosts, PLAN, Receiver, Robot, RobotName, SendFailure, ServiceError,
};
use nsrm_tests::isolated_memory::IsolatedMemory;

fn name(robot: &str) -> RobotName {
    robot.parse().unwrap()
}

/// Two processes of robot `left`.
fn pair(memory: &IsolatedMemory) -> (Robot, Robot) {
    let join = |role| Robot::join(name("left"), role, &memory.config).unwrap();
    (join(Role::Planner), join(Role::Controller))
}

fn all<M: Carried>(receiver: &Receiver<M>) -> Vec<M> {
    std::iter::from_fn(|| receiver.receive().unwrap().map(|sample| *sample)).collect()
}

fn heartbeat(sequence: u64) -> Heartbeat {
    Heartbeat {
        sequence,
        timestamp_ns: 6,
        started_ns: 4,
        rejected: 3,
        role: Role::Planner as u32,
        state: State::Busy as u32,
    }
}

fn feedback(sequence: u64) -> Feedback {
    Feedback {
        plan: 1,
        sequence,
        timestamp_ns: 0,
        command: 1,
        outcome: 1,
        objects: [0; 2],
    }
}

fn sub_goal(command: u32) -> SubGoal {
    SubGoal::stop(nsrm_ipc::executive::CommandId { plan: 1, command })
}

fn scene(sequence: u64) -> SceneMessage {
    let model = &nsrm_tabletop::TABLETOP;
    let camera = CameraMessage::default().into();
    let raw = nsrm_core::RawScene::empty(model, camera);
    SceneMessage {
        sequence,
        ..SceneMessage::from(&raw)
    }
}

fn request(sequence: u64) -> PlanRequest {
    PlanRequest::new(1, sequence, Mode::PlanOnly, "put the red block …").unwrap()
}

fn reply(number: u32) -> PlanReply {
    let to = ReplyTo {
        client: 1,
        request: 7,
        plan: 0,
        number,
    };
    PlanReply::refused(to, "busy", "wait")
}

#[test]
fn a_heartbeat_arrives_as_it_was_sent_and_rings() {
    let memory = IsolatedMemory::new("heartbeat");
    let (planner, controller) = pair(&memory);
    let sender = planner.sender::<Heartbeat>().unwrap();
    let receiver = controller.receiver::<Heartbeat>().unwrap();
    let wait_set = controller.wait_set([Heartbeat::SERVICE]).unwrap();
    assert_eq!(wait_set.try_wait(), Ok(false));
    assert_eq!(sender.send(&heartbeat(5)), Ok(1));
    assert_eq!(wait_set.try_wait(), Ok(true));
    assert_eq!(wait_set.try_wait(), Ok(false));
    assert_eq!(all(&receiver), [heartbeat(5)]);
    assert_eq!(heartbeat(5).read(), Ok((Role::Planner, State::Busy)));
}

/// Longer than any notification takes, on any machine.
const LATE: Duration = Duration::from_secs(60);

#[test]
fn what_comes_while_a_bell_rings_is_looked_for() {
    let memory = IsolatedMemory::new("notifiers");
    let (planner, controller) = pair(&memory);
    let beats = planner.sender::<Heartbeat>().unwrap();
    let notifier = planner.notifier(PLAN).unwrap();
    let receiver = controller.receiver::<Heartbeat>().unwrap();
    let wait_set = controller.wait_set([PLAN, Heartbeat::SERVICE]).unwrap();
    for number in 1..4 {
        beats.send(&heartbeat(number)).unwrap();
        assert_eq!(wait_set.wait(LATE), Ok(true));
        assert_eq!(all(&receiver), [heartbeat(number)]);
        beats.send(&heartbeat(10 * number)).unwrap();
        assert_eq!(wait_set.wait(LATE), Ok(true));
        assert_eq!(all(&receiver), [heartbeat(10 * number)]);
        assert_eq!(wait_set.wait(Duration::ZERO), Ok(false));
        notifier.notify();
        assert_eq!(wait_set.wait(LATE), Ok(true));
    }
}

#[test]
fn a_sleep_ends_where_nothing_rings() {
    let memory = IsolatedMemory::new("naps");
    let (_, controller) = pair(&memory);
    let wait_set = controller.wait_set([PLAN]).unwrap();
    let nap = Duration::from_millis(20);
    let begun = Instant::now();
    for _ in 0..5 {
        assert_eq!(wait_set.wait(nap), Ok(false));
    }
    // No wait ends too early, on any machine; how late it ends is not asserted.
    assert!(begun.elapsed() > 4 * nap, "{:?}", begun.elapsed());
    for other in [Duration::from_millis(3), Duration::ZERO, nap] {
        assert_eq!(wait_set.wait(other), Ok(false));
    }
}

#[test]
fn who_sleeps_for_ever_is_woken() {
    let memory = IsolatedMemory::new("ever");
    let join = |role| Robot::join(name("left"), role, &memory.config).unwrap();
    let controller = join(Role::Controller);
    let wait_set = controller.wait_set([PLAN]).unwrap();
    assert_eq!(wait_set.wait(Duration::from_millis(1)), Ok(false));
    let waits = AtomicBool::new(false);
    let sleeper = std::fs::read_link("/proc/thread-self").unwrap();
    let stat = std::path::Path::new("/proc").join(sleeper).join("stat");
    std::thread::scope(|threads| {
        threads.spawn(|| {
            let notifier = join(Role::Planner).notifier(PLAN).unwrap();
            let sleeps = || std::fs::read_to_string(&stat).unwrap().contains(") S ");
            while !(waits.load(Ordering::Relaxed) && sleeps()) {
                std::thread::yield_now();
            }
            notifier.notify();
        });
        waits.store(true, Ordering::Relaxed);
        assert_eq!(wait_set.wait(Duration::MAX), Ok(true));
    });
}

/// A process gets the next request while it drains the notification of the previous one.
#[test]
fn no_bell_is_lost_while_one_is_heard_out() {
    const TIMES: u64 = 20_000;
    let (memory, all_here) = (IsolatedMemory::new("two-notifiers"), Barrier::new(2));
    let join = |role| Robot::join(name("left"), role, &memory.config).unwrap();
    std::thread::scope(|threads| {
        threads.spawn(|| {
            let robot = join(Role::Controller);
            let (asked, answers) = (robot.receiver().unwrap(), robot.sender().unwrap());
            let wait_set = robot.wait_set([Heartbeat::SERVICE]).unwrap();
            all_here.wait();
            for number in 0..TIMES {
                while all::<Heartbeat>(&asked).is_empty() {
                    assert_eq!(wait_set.wait(LATE), Ok(true), "question {number}");
                }
                answers.send(&feedback(number)).unwrap();
            }
            all_here.wait();
        });
        let robot = join(Role::Planner);
        let (asks, answers) = (
            robot.sender().unwrap(),
            robot.receiver::<Feedback>().unwrap(),
        );
        all_here.wait();
        for number in 0..TIMES {
            asks.send(&heartbeat(number)).unwrap();
            while all(&answers).is_empty() {
                // The answering thread may need this processor.
                std::thread::yield_now();
            }
            // A different delay each time, of up to some microseconds.
            for _ in 0..number * 7919 % 151 {
                std::hint::spin_loop();
            }
        }
        all_here.wait();
    });
}

#[test]
fn a_late_reader_gets_the_latest_scene_and_none_before_it() {
    let memory = IsolatedMemory::new("scene");
    let (planner, controller) = pair(&memory);
    let sender = planner.sender::<SceneMessage>().unwrap();
    let early = controller.receiver::<SceneMessage>().unwrap();
    for sequence in 1..=3 {
        sender.send(&scene(sequence)).unwrap();
    }
    let late = controller.receiver::<SceneMessage>().unwrap();
    sender.update_connections();
    for receiver in [early, late] {
        let sequences: Vec<_> = all(&receiver).iter().map(|scene| scene.sequence).collect();
        assert_eq!(sequences, [3]);
    }
}

#[test]
fn a_command_that_finds_no_room_is_an_error_and_those_before_it_arrive() {
    let memory = IsolatedMemory::new("sub-goal");
    let (planner, controller) = pair(&memory);
    let sender = planner.sender::<SubGoal>().unwrap();
    // There is no controller yet.
    assert_eq!(sender.send(&sub_goal(99)), Ok(0));
    let receiver = controller.receiver::<SubGoal>().unwrap();
    for command in 1..=8 {
        assert_eq!(sender.send(&sub_goal(command)), Ok(1));
    }
    assert_eq!(sender.send(&sub_goal(9)), Err(SendFailure::Full));
    let commands: Vec<_> = all(&receiver).iter().map(|goal| goal.command).collect();
    assert_eq!(commands, [1, 2, 3, 4, 5, 6, 7, 8]);
    assert_eq!(sender.send(&sub_goal(10)), Ok(1));
    assert_eq!(all(&receiver), [sub_goal(10)]);
}

#[test]
fn of_feedback_the_last_64_wait() {
    let memory = IsolatedMemory::new("feedback");
    let (planner, controller) = pair(&memory);
    let sender = controller.sender::<Feedback>().unwrap();
    let receiver = planner.receiver::<Feedback>().unwrap();
    for sequence in 0..70 {
        assert_eq!(sender.send(&feedback(sequence)), Ok(1));
    }
    let sequences: Vec<_> = all(&receiver).iter().map(|one| one.sequence).collect();
    assert_eq!(sequences, (6..70).collect::<Vec<_>>());
}

#[test]
fn no_robot_has_two_of_what_it_has_one_of() {
    let memory = IsolatedMemory::new("taken");
    let join = |robot, role| Robot::join(name(robot), role, &memory.config).unwrap();
    let planner = join("left", Role::Planner);
    let (_server, _goals) = (
        planner.plan_server().unwrap(),
        planner.sender::<SubGoal>().unwrap(),
    );
    let second = join("left", Role::Planner);
    let process = Some(std::process::id());
    let taken = |service| ServiceError::Taken {
        robot: name("left"),
        service,
        process,
    };
    assert_eq!(second.plan_server().unwrap_err(), taken("plan"));
    let refused = second.sender::<SubGoal>().unwrap_err();
    assert_eq!(refused, taken("sub_goal"));
    assert_eq!(
        refused.to_string(),
        format!(
            "robot `left`: `sub_goal` is already served by process {}; choose another robot \
             name, or stop that process",
            std::process::id()
        )
    );
    let controller = join("left", Role::Controller);
    let _receiver = controller.receiver::<SubGoal>().unwrap();
    let refused = join("left", Role::Controller).receiver::<SubGoal>();
    let (robot, service) = (name("left"), "sub_goal");
    assert_eq!(refused.unwrap_err(), ServiceError::Full { robot, service });

    // Another robot is not affected.
    let other = join("right", Role::Planner);
    let goals = other.sender::<SubGoal>().unwrap();
    assert_eq!(goals.send(&sub_goal(1)), Ok(0));
}

#[test]
fn the_place_of_one_that_left_is_free() {
    let memory = IsolatedMemory::new("left");
    let (planner, other) = pair(&memory);
    let goals = planner.sender::<SubGoal>().unwrap();
    assert!(other.sender::<SubGoal>().is_err());
    drop(goals);
    assert!(other.sender::<SubGoal>().is_ok());
}

#[test]
fn a_request_has_many_replies_and_notices_when_its_server_is_gone() {
    let memory = IsolatedMemory::new("plan");
    let (planner, client) = pair(&memory);
    let server = planner.plan_server().unwrap();
    let client = client.plan_client().unwrap();
    let pending = client.send_copy(request(7)).unwrap();
    let active = server.receive().unwrap().expect("it was just sent");
    assert_eq!(*active, request(7));
    for number in 1..=100 {
        active.send_copy(reply(number)).unwrap();
    }
    for number in 1..=100 {
        let got = pending.receive().unwrap().expect("none is lost");
        assert_eq!(*got, reply(number));
    }
    assert!(pending.is_connected() && active.is_connected());
    drop(active);
    assert!(!pending.is_connected());

    // The other way round: the client is gone.
    let pending = client.send_copy(request(8)).unwrap();
    let active = server.receive().unwrap().expect("it was just sent");
    drop(pending);
    assert!(!active.is_connected());
}

/// [`Feedback`] in another version.
#[repr(C)]
#[derive(Debug, Clone, Copy, ZeroCopySend)]
#[type_name("nsrm.v1.Feedback.0000000000000000")]
struct OtherFeedback {
    numbers: [u64; 3],
    outcome: u32,
    command: u32,
    objects: [u32; 2],
}

#[test]
fn a_peer_with_another_layout_is_refused() {
    let memory = IsolatedMemory::new("layout");
    let node = NodeBuilder::new()
        .config(&memory.config)
        .create::<ipc::Service>()
        .unwrap();
    let service = "nsrm/v1/left/feedback".try_into().unwrap();
    // They have the same size and differ only in the type name.
    assert_eq!(size_of::<Feedback>(), size_of::<OtherFeedback>());
    let _other = node
        .service_builder(&service)
        .publish_subscribe::<OtherFeedback>()
        .max_publishers(16)
        .max_subscribers(16)
        .max_nodes(32)
        .subscriber_max_buffer_size(64)
        .create()
        .unwrap();
    let robot = Robot::join(name("left"), Role::Planner, &memory.config).unwrap();
    let refused = robot.sender::<Feedback>().unwrap_err();
    let (robot, service) = (name("left"), "feedback");
    assert_eq!(refused, ServiceError::OtherVersion { robot, service });
}

/// A tunnel creates the services that only the other host has, with the documented configuration.
#[test]
fn what_a_tunnel_makes_is_used_over_several_hosts() {
    fn made<M: Carried + Copy>(tunnel: &Node<ipc::Service>, robot: &Robot, message: M) {
        let service = format!("nsrm/v1/left/{}", M::SERVICE);
        let service = tunnel
            .service_builder(&service.as_str().try_into().unwrap())
            .publish_subscribe::<M>()
            .create()
            .unwrap();
        let (sender, receiver) = (robot.sender::<M>().unwrap(), robot.receiver::<M>().unwrap());
        // The tunnel has its own publisher and subscriber.
        let _publisher = service.publisher_builder().create().unwrap();
        let passes_on = service.subscriber_builder().create().unwrap();
        assert_eq!(sender.send(&message), Ok(2), "{}", M::SERVICE);
        assert!(receiver.receive().unwrap().is_some() && passes_on.receive().unwrap().is_some());
    }
    let memory = IsolatedMemory::new("tunnel");
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/hosts/iceoryx2.toml");
    let mut config = Config::from_file(&FilePath::new(file.as_bytes()).unwrap()).unwrap();
    config.global = memory.config.global.clone();
    let tunnel = NodeBuilder::new()
        .config(&config)
        .create::<ipc::Service>()
        .unwrap();
    let robot = Robot::join(name("left"), Role::Planner, &memory.config).unwrap();
    let robot = robot.with_hosts(Hosts::Several);
    made(&tunnel, &robot, scene(1));
    made(&tunnel, &robot, sub_goal(1));
    made(&tunnel, &robot, feedback(1));
    made(&tunnel, &robot, heartbeat(1));
    made(&tunnel, &robot, request(1));
    made(&tunnel, &robot, reply(1));
}

#[test]
fn who_was_told_of_another_number_of_hosts_is_refused() {
    let memory = IsolatedMemory::new("hosts");
    let join = || Robot::join(name("left"), Role::Planner, &memory.config).unwrap();
    let (one, several) = (join(), join().with_hosts(Hosts::Several));
    let _first = one.sender::<SubGoal>().unwrap();
    let refused = several.receiver::<SubGoal>().unwrap_err();
    let (robot, service) = (name("left"), "sub_goal");
    assert_eq!(refused, ServiceError::OtherVersion { robot, service });
    assert!(
        refused.to_string().contains("the same `hosts` for"),
        "{refused}"
    );
}

#[test]
fn a_frame_is_read_where_it_was_written() {
    let memory = IsolatedMemory::new("frame");
    let (camera, perception) = pair(&memory);
    let out = camera.frames_out(2 * 3 * 7).unwrap();
    let frames = perception.frames_in().unwrap();
    let frame = frame();
    let sent = out.send(frame, 2 * 3 * 7, |image| image.fill(9));
    assert_eq!(sent, Ok(1));
    let received = frames.receive().unwrap().expect("it was just sent");
    let parts = received.user_header().read(received.payload()).unwrap();
    assert_eq!((parts.rgb, parts.depth), (&[9; 18][..], &[9; 24][..]));
    assert_eq!(parts.boxes, &frame.boxes[..1]);
    assert!(in_shared_memory(parts.rgb) && in_shared_memory(parts.depth));
    assert!(!in_shared_memory(&[9; 18]));
}

/// Whether these bytes are in a mapping that is shared with other processes.
fn in_shared_memory(bytes: &[u8]) -> bool {
    let address = bytes.as_ptr().addr();
    let maps = std::fs::read_to_string("/proc/self/maps").unwrap();
    maps.lines().any(|line| {
        let mut words = line.split_whitespace();
        let range = words.next().unwrap().split_once('-').unwrap();
        let [from, to] = [range.0, range.1].map(|end| usize::from_str_radix(end, 16).unwrap());
        let shared = words.next().is_some_and(|rights| rights.ends_with('s'));
        shared && (from..to).contains(&address) && address + bytes.len() <= to
    })
}

fn frame() -> CameraFrame {
    let camera = CameraMessage {
        width: 2,
        height: 3,
        fx: 500.0,
        fy: 500.0,
        cx: 1.0,
        cy: 1.5,
        position: [0.0; 3],
        orientation: [0.0, 0.0, 0.0, 1.0],
    };
    let found = DetectedBox::whole(1, [0.1, 0.2, 0.3, 0.4, 1.0]);
    CameraFrame {
        sequence: 1,
        timestamp_ns: 2,
        camera,
        count: 1,
        boxes: [found; 16],
    }
}

#[test]
fn iceoryx2_compares_the_names_with_the_hash() {
    // SAFETY: the name is only read.
    let name = unsafe { <CameraFrame as ZeroCopySend>::type_name() };
    assert_eq!(name, CameraFrame::TYPE_NAME);
}
