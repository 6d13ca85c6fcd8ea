//! A robot with `nsrm perceive` and `nsrm serve` as processes; camera, controller and world are a
//! thread of the test.

use std::io::{BufRead, BufReader, Lines};
use std::path::PathBuf;
use std::process::{Child, ChildStderr, ChildStdout, Command, Output, Stdio};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use iceoryx2::config::Config;
use nsrm_ipc::clock::now_ns;
use nsrm_ipc::message::{CameraFrame, CameraMessage, DetectedBox, Role};
use nsrm_ipc::service::FramesOut;
use nsrm_tests::controller::Controller;
use nsrm_tests::isolated_memory::{IsolatedMemory, join};

use super::{Bench, DEPTH_M, ORIENTATION, POSITION};

/// A valid sentence for the two blocks.
pub(crate) const SENTENCE: &str = "put the red block on the blue block";
const SIZE: [u32; 2] = [640, 480];
/// These tests do not test timeouts, and the machine may be busy: an hour is longer than any
/// test.
pub(crate) const CONFIG: &str = "
robot = 'left'
model = 'model.safetensors'

[limits]
scene_age_ms = 3600000
scene_wait_ms = 3600000
accept_wait_ms = 3600000
move_wait_ms = 3600000
silence_ms = 3600000

";
/// A test that waits longer than this for something hangs.
pub(crate) const HANGS: Duration = Duration::from_secs(120);
/// Red, and blue.
const COLORS: [[u8; 3]; 2] = [[200, 20, 20], [20, 20, 200]];

/// Two blocks, the camera that sees them and the robot that moves them.
struct World {
    boxes: [DetectedBox; 2],
    frames: FramesOut,
    controller: Controller,
    sequence: u64,
}

impl World {
    fn new(config: &Config) -> Self {
        let camera = join("left", Role::Camera, config);
        let at = |id, x: f32| DetectedBox::whole(id, [x, 0.4, x + 0.05, 0.45, DEPTH_M]);
        Self {
            boxes: [at(1, 0.2), at(3, 0.6)],
            frames: camera.frames_out(Self::bytes()).unwrap(),
            controller: Controller::new("left", config),
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
                position: POSITION,
                orientation: ORIENTATION,
            },
            count: 2,
            ..CameraFrame::default()
        };
        frame.boxes[..2].copy_from_slice(&self.boxes);
        let boxes = self.boxes;
        let draw = |image: &mut [u8]| {
            image.fill(0);
            // The first one is in front.
            for (found, color) in boxes.iter().zip(COLORS).rev() {
                let [x1, y1, x2, y2] = found.visible;
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

    /// Publishes a frame, sends heartbeats and executes commands; returns the number of commands so far.
    fn turn(&mut self, works: bool) -> u32 {
        let Self {
            boxes, controller, ..
        } = self;
        controller.works = works;
        controller.turn(now_ns(), |command| {
            let found = boxes.iter_mut();
            for found in found.filter(|found| found.id == command.object_id) {
                *found = DetectedBox::whole(found.id, command.location);
            }
        });
        self.look();
        self.controller.taken
    }
}

/// The test's own robot, with camera, controller and world in a thread.
pub(crate) struct Stage {
    pub(crate) works: Arc<AtomicBool>,
    pub(crate) taken: Arc<AtomicU32>,
    stop: Arc<AtomicBool>,
    world: Option<JoinHandle<()>>,
    pub(crate) processes: Vec<Child>,
    /// What the processes have logged since they were ready, in order of arrival.
    pub(crate) logged: Arc<Mutex<String>>,
    pub(crate) bench: Bench,
    // Last, so that leftovers are searched when all processes have ended.
    pub(crate) memory: IsolatedMemory,
    /// Path of the command `nsrm`.
    pub(crate) nsrm: PathBuf,
}

impl Stage {
    pub(crate) fn new(test: &str) -> Self {
        let memory = IsolatedMemory::new(test);
        let bench = Bench::new();
        let shared = memory.as_toml();
        bench.write("robot.toml", format!("{CONFIG}{shared}"));
        let [works, stop] = [true, false].map(|value| Arc::new(AtomicBool::new(value)));
        let taken = Arc::new(AtomicU32::new(0));
        let shared = (Arc::clone(&works), Arc::clone(&taken), Arc::clone(&stop));
        let config = memory.config.clone();
        let world = std::thread::spawn(move || {
            let (works, taken, stop) = shared;
            let mut world = World::new(&config);
            while !stop.load(Ordering::Relaxed) {
                let more = world.turn(works.load(Ordering::Relaxed));
                taken.store(more, Ordering::Relaxed);
                std::thread::sleep(Duration::from_millis(10));
            }
        });
        Self {
            works,
            taken,
            stop,
            world: Some(world),
            processes: Vec::new(),
            logged: Arc::default(),
            bench,
            memory,
            nsrm: env!("CARGO_BIN_EXE_nsrm").into(),
        }
    }

    pub(crate) fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(&self.nsrm);
        command
            .current_dir(self.bench.folder.path())
            .args(arguments)
            .args(["--config", "robot.toml"]);
        command
    }

    /// Starts a node and waits until it logs that it is ready; returns its index in
    /// [`Stage::processes`].
    pub(crate) fn start(&mut self, node: &str, at_work: &str) -> usize {
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
        // Further output is read, so that the process never waits for a reader.
        let logged = Arc::clone(&self.logged);
        std::thread::spawn(move || drain(lines, &logged));
        self.processes.push(child);
        self.processes.len() - 1
    }

    pub(crate) fn both(test: &str) -> Self {
        let mut stage = Self::new(test);
        stage.start("perceive", "perceiving");
        stage.start("serve", "planning");
        stage
    }

    /// Runs `nsrm say` and waits until the first command is sent; returns the process and the rest
    /// of its output.
    pub(crate) fn say_and_wait_for_the_way(&self) -> (Child, Lines<BufReader<ChildStdout>>) {
        let mut say = self
            .command(&["say", SENTENCE])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(say.stdout.take().unwrap()).lines();
        assert!(lines.any(|line| line.unwrap().contains(": moving object ")));
        (say, lines)
    }

    /// Runs `nsrm say` and sends Ctrl-C once the first command is sent; returns exit code and
    /// messages.
    pub(crate) fn interrupt_when_under_way(&self) -> (Option<i32>, String) {
        let (say, _printed) = self.say_and_wait_for_the_way();
        signal(say.id(), "-INT");
        let ended = say.wait_with_output().unwrap();
        (
            ended.status.code(),
            String::from_utf8(ended.stderr).unwrap(),
        )
    }

    /// Waits until a node has logged a line with all of `parts`; panics if none does.
    pub(crate) fn wait_for_log(&self, parts: &[&str]) {
        let has_all = |line: &str| parts.iter().all(|part| line.contains(part));
        let begun = Instant::now();
        while begun.elapsed() < HANGS {
            if self.logged.lock().unwrap().lines().any(has_all) {
                return;
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        let logged = self.logged.lock().unwrap();
        panic!("no line with {parts:?} in:\n{logged}");
    }

    pub(crate) fn say(&self, arguments: &[&str]) -> Output {
        self.command(&[&["say"], arguments].concat())
            .output()
            .unwrap()
    }
}

fn drain(lines: BufReader<ChildStderr>, logged: &Mutex<String>) {
    for line in lines.lines().map_while(Result::ok) {
        println!("{line}");
        let mut logged = logged.lock().unwrap();
        logged.push_str(&line);
        logged.push('\n');
    }
}

/// Sends a process a signal, named as for `kill`.
pub(crate) fn signal(process: u32, name: &str) {
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
