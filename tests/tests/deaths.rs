//! A node that dies or hangs is detected within half a second on the clock given to the nodes; a
//! delayed controller does not execute a command that was abandoned meanwhile.
//!
//! The other process is a real one; time passes only where a test advances it.

use std::cell::Cell;
use std::io::{BufRead as _, BufReader};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use nsrm_core::{Model, RawScene};
use nsrm_ipc::clock::now_ns;
use nsrm_ipc::executive::{Limits, Mode};
use nsrm_ipc::message::{
    Feedback, Heartbeat, Outcome, PlanReply, PlanRequest, Reply, Role, SceneMessage, SubGoal,
};
use nsrm_ipc::node::{Client, PlannerNode, RequestError, Transport, Watcher};
use nsrm_ipc::service::{PlanClient, Receiver, Robot, Sender, ServiceError};
use nsrm_tests::by_hand::{Parts, raw_scene};
use nsrm_tests::isolated_memory::{IsolatedMemory, join};
use nsrm_tests::world::{BLOCKS, Pending, SENTENCE, World, last_reason, patient};

const MS: u64 = 1_000_000;
/// How long a death may stay undetected.
const PROMISE_NS: u64 = 500 * MS;
/// The polling period of nodes: the last heartbeat is received, and its absence detected, at most
/// this much later.
const NAP_NS: u64 = 20 * MS;
/// A test that waits longer than this for something hangs.
const HANGS: Duration = Duration::from_secs(120);

/// Another process.
struct Other(Child);

impl Other {
    fn start(role: &str, memory: &IsolatedMemory) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_node"))
            .arg(role)
            .args(memory.arguments())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut line = String::new();
        let stdout = child.stdout.take().unwrap();
        BufReader::new(stdout).read_line(&mut line).unwrap();
        assert_eq!(line, "at work\n");
        Self(child)
    }

    /// Sends a signal that silences the process, and waits until it has had its effect.
    fn silence(&mut self, signal: &str) {
        self.signal(signal);
        if signal == "-KILL" {
            self.0.wait().unwrap();
            return;
        }
        let path = format!("/proc/{}/stat", self.0.id());
        while !std::fs::read_to_string(&path).unwrap().contains(") T ") {
            std::thread::yield_now();
        }
    }

    fn signal(&self, name: &str) {
        let process = self.0.id().to_string();
        let sent = Command::new("kill").args([name, &process]).status();
        assert!(sent.unwrap().success());
    }
}

impl Drop for Other {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Removes what dead processes have left, once all others have ended. A process may end a moment
/// before its locks are released; fails the test if something stays.
fn cleanup_dead_nodes(memory: &IsolatedMemory) {
    let begun = Instant::now();
    while begun.elapsed() < HANGS {
        join("left", Role::Watcher, &memory.config).cleanup_dead_nodes();
        if memory.left_behind().is_empty() {
            return;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    panic!("left behind: {:?}", memory.left_behind());
}

/// Waits until this many further heartbeats of this role have arrived.
fn wait_for_beats(heartbeats: &Receiver<Heartbeat>, role: Role, count: usize) {
    let mut heard = 0;
    while heard < count {
        match heartbeats.receive().unwrap() {
            Some(beat) => heard += usize::from(beat.role == role as u32),
            None => std::thread::sleep(Duration::from_millis(1)),
        }
    }
}

/// A planner that was given a sentence; the test sets its clock.
struct Scene<'m> {
    planner: PlannerNode<'m>,
    scenes: Sender<SceneMessage>,
    scene: RawScene,
    heard: Receiver<Feedback>,
    _client: PlanClient,
    pending: Pending,
    robot: Robot,
}

impl<'m> Scene<'m> {
    fn new(model: &'m Model<'m>, limits: Limits, memory: &IsolatedMemory) -> Self {
        let planner = join("left", Role::Planner, &memory.config);
        let robot = join("left", Role::Client, &memory.config);
        let client = robot.plan_client().unwrap();
        let (scenes, heard) = (robot.sender().unwrap(), robot.receiver().unwrap());
        let planner = PlannerNode::begin(planner, model, limits).unwrap();
        let request = PlanRequest::new(3, 1, Mode::ClosedLoop, SENTENCE).unwrap();
        Self {
            planner,
            scenes,
            scene: raw_scene(model, &BLOCKS),
            heard,
            pending: client.send_copy(request).unwrap(),
            _client: client,
            robot,
        }
    }

    /// Publishes a scene taken at this time and lets the planner work; returns its replies.
    fn turn(&mut self, now_ns: u64) -> Vec<PlanReply> {
        self.scene.header.timestamp_ns = now_ns;
        let message = SceneMessage::from(&self.scene);
        self.scenes.send(&message).unwrap();
        self.planner.poll(now_ns);
        let replies = std::iter::from_fn(|| self.pending.receive().unwrap());
        replies.map(|reply| *reply).collect()
    }

    /// Repeats [`Scene::turn`] until the first command has been sent.
    fn until_commanded(&mut self, now_ns: u64) {
        while !self
            .turn(now_ns)
            .iter()
            .any(|reply| matches!(reply.read(), Ok(Reply::Commanded { .. })))
        {}
    }

    /// The controller's next outcome.
    fn outcome(&self) -> Outcome {
        loop {
            if let Some(feedback) = self.heard.receive().unwrap() {
                return feedback.read().unwrap().outcome;
            }
            std::thread::yield_now();
        }
    }
}

#[test]
fn a_controller_that_dies_or_hangs_is_detected_within_half_a_second() {
    let parts = Parts::new();
    let model = parts.model();
    for signal in ["-STOP", "-KILL"] {
        let memory = IsolatedMemory::new(&format!("lost{signal}"));
        // The other process has a running clock.
        let limits = Limits {
            silence_ns: Limits::default().silence_ns,
            ..patient()
        };
        let mut it = Scene::new(&model, limits, &memory);
        let heartbeats: Receiver<Heartbeat> = it.robot.receiver().unwrap();
        let mut controller = Other::start("controller", &memory);
        // Of two heartbeats the first is in the planner's queue, and is received now, however long
        // ago the planner was started.
        wait_for_beats(&heartbeats, Role::Controller, 2);
        let now = now_ns();
        it.until_commanded(now);
        assert_eq!(it.outcome(), Outcome::Accepted);
        controller.silence(signal);
        // Everything that it has sent is received now.
        assert!(it.turn(now).is_empty());
        assert!(it.turn(now + Limits::default().silence_ns).is_empty());
        let noticed = now + PROMISE_NS - 2 * NAP_NS;
        let mut replies = it.turn(noticed);
        replies.extend(it.turn(noticed));
        assert_eq!(last_reason(&replies), Some("controller_lost"), "{signal}");
        if signal == "-STOP" {
            // It continues, and finds the stop.
            controller.signal("-CONT");
            assert_eq!(it.outcome(), Outcome::Stopped);
        }
        drop((controller, it, heartbeats));
        cleanup_dead_nodes(&memory);
    }
}

#[test]
fn a_planner_that_dies_or_hangs_is_detected_within_half_a_second() {
    let silence_ns = Limits::default().silence_ns;
    let mut corners = 1..;
    for signal in ["-STOP", "-KILL"] {
        for transport in [Transport::Connection, Transport::Broadcast] {
            let memory = IsolatedMemory::new(&format!("detected{}", corners.next().unwrap()));
            let mut planner = Other::start("planner", &memory);
            let robot = join("left", Role::Client, &memory.config);
            let mut client = Client::begin(robot, transport, silence_ns).unwrap();
            let robot = join("left", Role::Watcher, &memory.config);
            let heartbeats: Receiver<Heartbeat> = robot.receiver().unwrap();
            let mut watcher = Watcher::begin(robot).unwrap();
            let mut request = client.ask(SENTENCE, Mode::ClosedLoop).unwrap();
            // Of two heartbeats the first is in all queues, and is received now, however long ago
            // the request was sent.
            while heartbeats.receive().unwrap().is_some() {}
            wait_for_beats(&heartbeats, Role::Planner, 2);
            planner.silence(signal);
            let now = now_ns();
            let lives = |watcher: &mut Watcher, now| {
                let nodes = watcher.look(now).nodes;
                let mut nodes = nodes.iter().flatten();
                let planner = nodes.find(|node| node.role == Role::Planner);
                planner.is_some_and(|planner| planner.is_alive(silence_ns, now))
            };
            assert_eq!(client.poll(&mut request, now), Ok(None));
            assert!(lives(&mut watcher, now) && lives(&mut watcher, now + silence_ns));
            assert_eq!(client.poll(&mut request, now + silence_ns), Ok(None));
            let noticed = now + PROMISE_NS - 2 * NAP_NS;
            assert!(!lives(&mut watcher, noticed));
            let lost = Err(RequestError::PlannerLost("left".parse().unwrap()));
            assert_eq!(client.poll(&mut request, noticed), lost, "{signal}");
            drop((planner, client, watcher, heartbeats, request));
            cleanup_dead_nodes(&memory);
        }
    }
}

/// It was suspended before the command arrived, and continues when the command is obsolete.
#[test]
fn a_controller_that_was_held_up_does_not_begin_with_what_was_given_up() {
    let parts = Parts::new();
    let model = parts.model();
    for gives_up in [true, false] {
        let memory = IsolatedMemory::new(&format!("held-up-{gives_up}"));
        let mut it = Scene::new(&model, Limits::default(), &memory);
        // Of two heartbeats the first is in the planner's queue, too.
        let heartbeats: Receiver<Heartbeat> = it.robot.receiver().unwrap();
        let mut controller = Other::start("controller", &memory);
        wait_for_beats(&heartbeats, Role::Controller, 2);
        controller.silence("-STOP");
        // If the planner is never polled again, as if it had died, only the command's deadline
        // shows it; here it has passed before the command is sent.
        let mut now = if gives_up {
            now_ns()
        } else {
            now_ns() - 10_000 * MS
        };
        it.until_commanded(now);
        let mut replies = Vec::new();
        while gives_up && it.pending.is_connected() {
            now += 50 * MS;
            replies.extend(it.turn(now));
        }
        controller.signal("-CONT");
        if gives_up {
            assert_eq!(last_reason(&replies), Some("controller_lost"));
            // The answers to the stop, and then to the command.
            assert_eq!([it.outcome(), it.outcome()], [Outcome::Stopped; 2]);
        } else {
            assert_eq!(it.outcome(), Outcome::TooLate);
        }
        drop((controller, it, heartbeats));
        cleanup_dead_nodes(&memory);
    }
}

/// As above, without real processes: a later sentence is executed.
#[test]
fn what_comes_too_late_keeps_nothing_from_what_comes_after_it() {
    let memory = IsolatedMemory::new("too-late");
    let parts = Parts::new();
    let model = parts.model();
    let robot = join("left", Role::Planner, &memory.config);
    let mut planner = PlannerNode::begin(robot, &model, Limits::default()).unwrap();
    let mut world = World::new("left", &model, &memory.config);
    let pending = world.ask(1, SENTENCE);
    let now = now_ns();
    world.turn(now);
    while !matches!(
        pending.receive().unwrap().map(|reply| reply.status),
        Some(2)
    ) {
        planner.poll(now);
    }
    // The controller sleeps for ten seconds; the planner abandons the sentence.
    let late = now + 10_000 * MS;
    world.turn(late);
    assert_eq!(world.controller.rejected, 1);
    let replies = world.follow(&mut planner, &pending, || late);
    let expected = Some("unsuccessful");
    assert_eq!(last_reason(&replies), expected);
    assert!(world.controller.done.is_empty());

    let pending = world.ask(2, SENTENCE);
    let clock = Cell::new(late);
    let replies = world.follow(&mut planner, &pending, || {
        clock.set(clock.get() + MS);
        clock.get()
    });
    assert_eq!(last_reason(&replies), None);
    assert_eq!(world.controller.done.len(), 2);
}

/// Also for a process that joined before it died, and has cleaned up nothing since.
#[test]
fn the_place_of_one_that_was_just_killed_is_free() {
    let memory = IsolatedMemory::new("just-killed");
    let mut controller = Other::start("controller", &memory);
    let heir = join("left", Role::Controller, &memory.config);
    let taken = ServiceError::Taken {
        robot: heir.name().clone(),
        service: "feedback",
        process: Some(controller.0.id()),
    };
    assert_eq!(heir.sender::<Feedback>().unwrap_err(), taken);
    controller.silence("-KILL");
    assert!(heir.sender::<Feedback>().is_ok() && heir.receiver::<SubGoal>().is_ok());
    drop(heir);
    cleanup_dead_nodes(&memory);
}
