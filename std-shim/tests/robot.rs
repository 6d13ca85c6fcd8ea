//! The commands that are processes of a robot, as processes: perception, planner and
//! a person's; camera, controller and world are this test's.
#![cfg(feature = "command")]

// Not all of it is for processes.
#[allow(dead_code)]
mod common;

use std::io::{BufRead, BufReader};
use std::process::{Child, ChildStderr, Command, Output, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use common::{Bench, done, refused};
use iceoryx2::config::Config;
use nsrm_ipc::clock::now_ns;
use nsrm_ipc::message::{
    CameraFrame, CameraMessage, DetectedBox, Feedback, Order, Outcome, Role, State, SubGoal,
};
use nsrm_ipc::node::Life;
use nsrm_ipc::service::{FramesOut, Receiver, Robot, Sender};
use nsrm_tests::corner::Corner;
use serde_json::Value;

const SENTENCE: &str = "put the red block on the blue block";
const SIZE: [u32; 2] = [640, 480];
/// Nothing here is about time, and the machine may have other work.
const CONFIG: &str = "
robot = 'left'
model = 'model.safetensors'

[limits]
scene_age_ms = 20000
scene_wait_ms = 20000
accept_wait_ms = 20000
silence_ms = 20000

";
/// Red, and blue.
const COLORS: [[u8; 3]; 2] = [[200, 20, 20], [20, 20, 200]];

/// Two blocks, the camera that sees them and the robot that moves them.
struct World {
    boxes: [DetectedBox; 2],
    frames: FramesOut,
    commands: Receiver<SubGoal>,
    feedback: Sender<Feedback>,
    life: Life,
    sequence: u64,
}

impl World {
    fn new(config: &Config) -> Self {
        let join = |role| Robot::join("left".parse().unwrap(), role, config).unwrap();
        let (camera, controller) = (join(Role::Camera), join(Role::Controller));
        let at = |id, x: f32| DetectedBox {
            id,
            corners: [x, 0.4, x + 0.05, 0.45],
            depth_m: 0.5,
        };
        Self {
            boxes: [at(1, 0.2), at(3, 0.6)],
            frames: camera.frames_out(Self::bytes()).unwrap(),
            commands: controller.receiver().unwrap(),
            feedback: controller.sender().unwrap(),
            life: Life::begin(&controller, Role::Controller, now_ns()).unwrap(),
            sequence: 0,
        }
    }

    const fn bytes() -> usize {
        (SIZE[0] * SIZE[1] * 7) as usize
    }

    fn look(&mut self) {
        self.sequence += 1;
        let [width, height] = SIZE;
        let mut frame = CameraFrame {
            sequence: self.sequence,
            timestamp_ns: now_ns(),
            camera: CameraMessage {
                width,
                height,
                fx: 500.0,
                fy: 500.0,
                cx: 320.0,
                cy: 240.0,
                position: [0.5, 0.0, 1.0],
                orientation: [0.0, 0.0, 0.0, 1.0],
            },
            count: 2,
            ..CameraFrame::default()
        };
        frame.boxes[..2].copy_from_slice(&self.boxes);
        let boxes = self.boxes;
        let draw = |image: &mut [u8]| {
            // The first one stands in front.
            for (found, color) in boxes.iter().zip(COLORS).rev() {
                let [x1, y1, x2, y2] = found.corners;
                let columns = (x1 * width as f32) as usize..(x2 * width as f32) as usize;
                for row in (y1 * height as f32) as usize..(y2 * height as f32) as usize {
                    for column in columns.clone() {
                        let place = 3 * (row * width as usize + column);
                        image[place..place + 3].copy_from_slice(&color);
                    }
                }
            }
        };
        self.frames.send(frame, Self::bytes(), draw).unwrap();
    }

    fn say(&mut self, command: &SubGoal, outcome: Outcome) {
        self.sequence += 1;
        let feedback = Feedback {
            plan: command.plan,
            sequence: self.sequence,
            timestamp_ns: now_ns(),
            command: command.command,
            outcome: outcome as u32,
        };
        self.feedback.send(&feedback).unwrap();
    }

    /// Looks, lives and obeys; how many commands it has taken.
    fn turn(&mut self, works: bool) -> u32 {
        let mut taken = 0;
        self.life.beat(State::Idle, now_ns()).unwrap();
        while let Some(command) = self.commands.receive().unwrap().map(|sample| *sample) {
            taken += 1;
            match command.read().unwrap() {
                Order::Stop => self.say(&command, Outcome::Stopped),
                Order::Move { object, .. } => {
                    self.say(&command, Outcome::Accepted);
                    if works {
                        let [x1, y1, x2, y2, depth_m] = command.location;
                        for found in self.boxes.iter_mut().filter(|found| found.id == object) {
                            (found.corners, found.depth_m) = ([x1, y1, x2, y2], depth_m);
                        }
                        self.say(&command, Outcome::Reached);
                    }
                }
            }
        }
        self.look();
        taken
    }
}

/// A robot of its own, with camera, controller and world in a thread.
struct Stage {
    works: Arc<AtomicBool>,
    taken: Arc<AtomicU32>,
    stop: Arc<AtomicBool>,
    world: Option<JoinHandle<()>>,
    processes: Vec<Child>,
    bench: Bench,
    // Last, so that what is left behind is looked for when all have ended.
    corner: Corner,
}

impl Stage {
    fn new(test: &str) -> Self {
        let corner = Corner::new(test);
        let bench = Bench::new();
        let shared = corner.as_toml();
        bench.write("robot.toml", format!("{CONFIG}{shared}"));
        let [works, stop] = [true, false].map(|value| Arc::new(AtomicBool::new(value)));
        let taken = Arc::new(AtomicU32::new(0));
        let shared = (Arc::clone(&works), Arc::clone(&taken), Arc::clone(&stop));
        let config = corner.config.clone();
        let world = std::thread::spawn(move || {
            let (works, taken, stop) = shared;
            let mut world = World::new(&config);
            while !stop.load(Ordering::Relaxed) {
                let more = world.turn(works.load(Ordering::Relaxed));
                taken.fetch_add(more, Ordering::Relaxed);
                std::thread::sleep(Duration::from_millis(10));
            }
        });
        Self {
            works,
            taken,
            stop,
            world: Some(world),
            processes: Vec::new(),
            bench,
            corner,
        }
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_nsrm"));
        command
            .current_dir(self.bench.folder.path())
            .args(arguments)
            .args(["--config", "robot.toml"]);
        command
    }

    /// Starts a node and waits until it says that it is at work; its place among
    /// the processes.
    fn start(&mut self, node: &str, at_work: &str) -> usize {
        let mut child = self
            .command(&[node])
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(child.stderr.take().unwrap());
        let mut line = String::new();
        while !line.contains(at_work) {
            line.clear();
            assert_ne!(lines.read_line(&mut line).unwrap(), 0, "{node} ended");
        }
        // What it says from now on is read, so that it never waits for a reader.
        std::thread::spawn(move || drain(lines));
        self.processes.push(child);
        self.processes.len() - 1
    }

    fn both(test: &str) -> Self {
        let mut stage = Self::new(test);
        stage.start("perceive", "perceiving");
        stage.start("serve", "planning");
        stage
    }

    /// Says the sentence and presses Ctrl-C when the robot is at it; exit code and
    /// messages.
    fn interrupt_when_under_way(&self) -> (Option<i32>, String) {
        let mut say = self
            .command(&["say", SENTENCE])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(say.stdout.take().unwrap()).lines();
        assert!(lines.any(|line| line.unwrap().contains("is on its way")));
        signal(say.id(), "-INT");
        let ended = say.wait_with_output().unwrap();
        (
            ended.status.code(),
            String::from_utf8(ended.stderr).unwrap(),
        )
    }

    fn say(&self, arguments: &[&str]) -> Output {
        self.command(&[&["say"], arguments].concat())
            .output()
            .unwrap()
    }
}

fn drain(lines: BufReader<ChildStderr>) {
    for line in lines.lines().map_while(Result::ok) {
        println!("{line}");
    }
}

fn signal(process: u32, name: &str) {
    let status = Command::new("kill")
        .args([name, &process.to_string()])
        .status();
    assert!(status.unwrap().success());
}

impl Drop for Stage {
    fn drop(&mut self) {
        for process in &mut self.processes {
            if process.try_wait().unwrap().is_none() {
                signal(process.id(), "-TERM");
                let status = process.wait().unwrap();
                assert!(status.success() || std::thread::panicking(), "{status}");
            }
        }
        self.stop.store(true, Ordering::Relaxed);
        if let Some(world) = self.world.take() {
            let ended = world.join();
            assert!(ended.is_ok() || std::thread::panicking());
        }
    }
}

#[test]
fn a_sentence_is_followed_through_all_processes() {
    let stage = Stage::both("followed");
    let said = done(&stage.say(&[SENTENCE]));
    let lines: Vec<_> = said.lines().collect();
    assert_eq!(
        lines[0],
        "Action(MoveOn, Unique(Filter(red, Scene())), Unique(Filter(blue, Scene())))"
    );
    assert!(
        lines[1].starts_with("  step 1: object 1 (red, 1.00), by object 3 (blue, 1.00), to ("),
        "{said}"
    );
    assert!(
        lines[2].starts_with("step 1: object 1 is on its way to ("),
        "{said}"
    );
    assert!(
        lines[3].starts_with("step 1: done, seen 0.0 mm from"),
        "{said}"
    );
    assert_eq!(lines[4..], ["done"]);
}

/// Without a connection, as between hosts.
#[test]
fn a_sentence_may_be_broadcast() {
    let stage = Stage::both("broadcast");
    let lines = format!("line = 'broadcast'\n{CONFIG}{}", stage.corner.as_toml());
    stage.bench.write("robot.toml", lines);
    // Ctrl-C reaches the robot by the same way.
    stage.works.store(false, Ordering::Relaxed);
    let (code, message) = stage.interrupt_when_under_way();
    assert_eq!(code, Some(2));
    assert_eq!(message, "nsrm: stopping the robot …\nnsrm: cancelled\n");
    stage.works.store(true, Ordering::Relaxed);
    let said = done(&stage.say(&[SENTENCE]));
    assert!(said.ends_with("\ndone\n"), "{said}");
}

#[test]
fn planning_alone_and_json() {
    let stage = Stage::both("json");
    let said = done(&stage.say(&[SENTENCE, "--plan-only", "--json"]));
    let events: Vec<Value> = said
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!(events.len(), 2, "{said}");
    assert_eq!(events[0]["event"], "planned");
    let step = &events[0]["steps"][0];
    assert_eq!(
        (&step["action"], &step["object"][0]),
        (&"MoveOn".into(), &"red".into())
    );
    assert_eq!(step["grounded"]["reference_id"], 3);
    assert_eq!(
        (&events[1]["event"], &events[1]["number"]),
        (&"done".into(), &2.into())
    );
}

#[test]
fn what_is_refused_is_told_with_exit_code_2() {
    let stage = Stage::both("refused");
    let said = stage.say(&["put the purple block on the blue block", "--json"]);
    let message = refused(&said, &["\"purple\" is not a word"]);
    // Not one object but one a line: the event, and why as every command says it.
    assert_eq!(message, Value::Null);
    let printed = String::from_utf8(said.stdout).unwrap();
    let events: Vec<Value> = printed
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!(events[0]["reason"], "unknown_word");
    let said = stage.say(&["put the green block on the blue block"]);
    refused(&said, &["step 1", "\"green\" fits no object"]);
}

#[test]
fn who_watches_sees_who_lives_what_flows_and_what_was_said() {
    let stage = Stage::both("watched");
    let mut watch = stage
        .command(&["watch", "--json"])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let lines = BufReader::new(watch.stdout.take().unwrap()).lines();
    let refused = stage.say(&["put the green block on the blue block"]);
    assert_eq!(refused.status.code(), Some(2));
    let view: Value = lines
        .map(|line| serde_json::from_str(&line.unwrap()).unwrap())
        .find(|view: &Value| {
            let nodes = view["nodes"].as_array().unwrap();
            nodes.len() >= 3 && !view["replies"][0].is_null()
        })
        .unwrap();
    signal(watch.id(), "-TERM");
    assert!(watch.wait().unwrap().success());
    let nodes = view["nodes"].as_array().unwrap();
    for name in ["controller", "perception", "planner"] {
        let node = nodes.iter().find(|node| node["node"] == name).unwrap();
        assert_eq!(
            (&node["lives"], &node["restarts"], &node["rejected"]),
            (&true.into(), &0.into(), &0.into())
        );
    }
    assert!(view["scene"]["count"].as_u64().unwrap() > 0);
    assert_eq!(view["objects"], 2);
    let said = view["replies"][0]["said"].as_str().unwrap();
    assert!(said.starts_with("no_such_object: step 1"), "{said}");

    let text = done(&stage.command(&["watch", "--once"]).output().unwrap());
    assert!(text.starts_with("robot left\n"), "{text}");
    for part in [
        "restarts  rejected",
        "planner     idle",
        "objects in the last scene",
        " ms",
    ] {
        assert!(text.contains(part), "{text}");
    }
}

#[test]
fn no_planner_and_a_second_one_are_told_of() {
    let mut stage = Stage::new("second");
    refused(
        &stage.say(&[SENTENCE]),
        &["robot `left` has no planner; start one: nsrm serve --robot left"],
    );
    let first = stage.start("serve", "planning");
    let process = stage.processes[first].id();
    let second = stage.command(&["serve"]).output().unwrap();
    refused(
        &second,
        &[&format!(
            "robot `left`: `plan` is already served by process {process}; choose another name, or \
             stop it"
        )],
    );
}

#[test]
fn ctrl_c_stops_the_robot_too() {
    let stage = Stage::both("ctrl-c");
    stage.works.store(false, Ordering::Relaxed);
    let (code, message) = stage.interrupt_when_under_way();
    assert_eq!(code, Some(2));
    assert_eq!(message, "nsrm: stopping the robot …\nnsrm: cancelled\n");
}

#[test]
fn a_planner_that_is_killed_is_missed_and_another_takes_its_place() {
    let mut stage = Stage::new("killed");
    stage.start("perceive", "perceiving");
    let planner = stage.start("serve", "planning");
    stage.works.store(false, Ordering::Relaxed);
    let mut say = stage
        .command(&["say", SENTENCE])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(say.stdout.take().unwrap()).lines();
    assert!(lines.any(|line| line.unwrap().contains("is on its way")));
    // A command that was sent is carried out, whoever has died since.
    while stage.taken.load(Ordering::Relaxed) == 0 {
        std::thread::yield_now();
    }
    stage.processes[planner].kill().unwrap();
    stage.processes[planner].wait().unwrap();
    let ended = say.wait_with_output().unwrap();
    assert_eq!(ended.status.code(), Some(2));
    let message = String::from_utf8(ended.stderr).unwrap();
    assert_eq!(
        message,
        "nsrm: the planner of robot `left` died or hangs; look at the robot, then start the \
         planner anew\n"
    );
    stage.works.store(true, Ordering::Relaxed);
    stage.start("serve", "planning");
    let said = done(&stage.say(&[SENTENCE]));
    assert!(said.ends_with("\ndone\n"), "{said}");
}

#[test]
fn bad_configurations_are_told_of() {
    let stage = Stage::new("config");
    let serve = |content: &str| {
        stage.bench.write("bad.toml", content);
        stage.bench.run(&["serve", "--config", "bad.toml"])
    };
    refused(
        &stage.bench.run(&["serve", "--config", "no.toml"]),
        &["no.toml: No such file"],
    );
    refused(&serve("robot = \"Left/1\""), &["'L' in a robot's name"]);
    refused(
        &serve("[limits]\ntolerance_mm = 0"),
        &["limits: tolerance: must be"],
    );
    refused(
        &serve("[limits]\nscene_age_ms = 0"),
        &["limits: scene age: must be"],
    );
    refused(
        &serve("[shared_memory]\nprefix = \"a/b\""),
        &["shared_memory.prefix = \"a/b\""],
    );
    let typo = serve("[limits]\nretry = 3");
    let message = String::from_utf8(typo.stderr).unwrap();
    assert_eq!(typo.status.code(), Some(2));
    assert!(
        message.contains("line 2") && message.contains("`retry`"),
        "{message}"
    );
}
