//! Measures latencies between processes through shared memory, from a sentence to its first
//! sub-goal and from a frame to its scene, and the share of computation.
//!
//! Measured alternately with it and on the same core, since no core is equally fast all the time:
//! the computation alone, and the cost on this machine of waking another process and being woken by
//! it, by a pipe. If the answering process spins, it also does the computation alone; if it waits,
//! another process does, woken by a pipe. The cores are swapped in turn.

mod alone;
mod answering;
mod beside;

use std::fs::File;
use std::io::Write;
use std::path::PathBuf;
use std::time::Duration;

use anyhow::{Context as _, Result, bail, ensure};
use nsrm_ipc::clock::now_ns;
use nsrm_ipc::message::{
    CameraFrame, Feedback, Outcome, Reply, Role, SceneMessage, State, SubGoal,
};
use nsrm_ipc::node::{Heartbeats, see};
use nsrm_ipc::service::{Carried, FramesOut, PLAN, WaitSet};
use nsrm_tabletop::TABLETOP;
use serde_json::json;

use self::alone::sentence;
use self::answering::{Answering, feedback, stay_on};
pub(crate) use self::answering::{Peer, WaitMode, answer};
use self::beside::{Beside, ByPipe};
use crate::process_group::ROBOT;
use crate::world::World;

/// The longest wait for an answer.
const PATIENCE_NS: u64 = 120_000_000_000;
/// How often the planner may be missing, or without a scene or a controller, on a busy machine.
const WARM: u32 = 1000;
/// How many measurements are made at most before the two processes swap cores.
const TURN: u32 = 1000;
/// Measurements that do not count, since the answering process has just started.
const UNCOUNTED: u32 = 20;
/// Between two requests, so that a waiting process is asleep again.
const REST: Duration = Duration::from_micros(300);
/// Sizes of images whose hand-over is measured, pixels.
const SIZES: [(u32, u32); 2] = [(640, 480), (3840, 2160)];

/// The command line.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// The command `nsrm`; not needed, as its nodes run here.
    #[arg(long, hide = true)]
    nsrm: Option<PathBuf>,
    /// Folder for the results.
    #[arg(long)]
    out: PathBuf,
    /// The number of measurements of each.
    #[arg(long, default_value_t = 20_000)]
    samples: u32,
}

/// Measures everything, and writes `latency.jsonl`, one line per measured quantity.
pub(crate) fn run(options: &Options) -> Result<()> {
    std::fs::create_dir_all(&options.out).with_context(|| options.out.display().to_string())?;
    let path = options.out.join("latency.jsonl");
    let file = File::create(&path).with_context(|| path.display().to_string())?;
    let mut book = Book { file };
    let samples = options.samples;
    let mut pipe = Times::new();
    for wait in [WaitMode::Spinning, WaitMode::Waiting] {
        let word = wait.word();
        for (what, measure) in [("sentence", sentences as Measure), ("frame", scenes)] {
            let mut measured = Measured::default();
            on_both_cores(samples, |share, core| {
                measure(wait, share, core, &mut measured)
            })?;
            book.write(&format!("{what}, computation alone"), word, &measured.alone)?;
            book.write(&format!("{what}, overhead"), word, &measured.above)?;
            book.write(what, word, &measured.through)?;
            pipe.append(&mut measured.pipe);
        }
    }
    book.write("pipe", "", &pipe)?;
    let mut sizes = SIZES.map(|size| (size, Times::new()));
    let mut event = Times::new();
    on_both_cores(samples, |share, core| {
        for (size, times) in &mut sizes {
            hand_over(WaitMode::Spinning, *size, share, core, times)?;
        }
        hand_over(WaitMode::Waiting, SIZES[0], share, core, &mut event)
    })?;
    for ((width, height), times) in &sizes {
        book.write("hand-over", &format!("{width}x{height}"), times)?;
    }
    book.write("event", "", &event)
}

/// Nanoseconds.
type Times = Vec<i64>;

/// A measurement through shared memory, and its baselines.
#[derive(Debug, Default)]
struct Measured {
    /// The round trip through a pipe, if the answering process waits.
    pipe: Times,
    /// The computation alone.
    alone: Times,
    /// The total.
    through: Times,
    /// The total without the computation measured just before it.
    above: Times,
}

impl Measured {
    /// * `number`: from 1; the first ones do not count
    fn record(&mut self, number: u64, pipe_ns: Option<u64>, alone_ns: u64, through_ns: u64) {
        if number <= UNCOUNTED.into() {
            return;
        }
        // None lasts for centuries.
        let (alone_ns, through_ns) = (alone_ns as i64, through_ns as i64);
        self.pipe.extend(pipe_ns.map(|pipe_ns| pipe_ns as i64));
        self.alone.push(alone_ns);
        self.through.push(through_ns);
        self.above.push(through_ns - alone_ns);
    }
}

/// Measures, given how the answering process receives, the number of measurements, and the core of
/// the answering process.
type Measure = fn(WaitMode, u32, usize, &mut Measured) -> Result<()>;

/// Measures half on one core and half on the other in turn, with the answering process on the other
/// one: no core is equally fast all the time.
///
/// * `measure`: gets the number of measurements and the core of the answering process
fn on_both_cores(samples: u32, mut measure: impl FnMut(u32, usize) -> Result<()>) -> Result<()> {
    let turns = samples.div_ceil(TURN).next_multiple_of(2);
    for turn in 0..turns {
        let (here, there) = if turn % 2 == 0 { (0, 1) } else { (1, 0) };
        stay_on(here)?;
        measure(samples / turns + u32::from(turn < samples % turns), there)?;
    }
    Ok(())
}

/// Writes the results.
struct Book {
    file: File,
}

impl Book {
    fn write(&mut self, what: &str, how: &str, times: &Times) -> Result<()> {
        let mut sorted = times.clone();
        sorted.sort_unstable();
        let middle = sorted.get(sorted.len() / 2).copied().unwrap_or_default();
        eprintln!("{what} {how}: p50 {:.1} µs", middle as f64 / 1000.0);
        let line = json!({"what": what, "how": how, "times_ns": sorted});
        writeln!(self.file, "{line}")?;
        Ok(())
    }
}

/// Waits until `take` returns something: spinning, or woken by a notification.
fn until<T>(
    wait: WaitMode,
    wait_set: &WaitSet<1>,
    mut take: impl FnMut() -> Result<Option<T>>,
) -> Result<T> {
    let end_ns = now_ns() + PATIENCE_NS;
    loop {
        if let Some(taken) = take()? {
            return Ok(taken);
        }
        if now_ns() > end_ns {
            bail!("no answer after {} s", PATIENCE_NS / 1_000_000_000);
        }
        if wait == WaitMode::Waiting {
            let _ = wait_set.wait(Duration::from_millis(100));
        } else {
            std::hint::spin_loop();
        }
    }
}

/// A process that a pipe wakes and that does nothing, if the answering process waits.
struct Way(Option<ByPipe>);

impl Way {
    fn start(wait: WaitMode, core: usize) -> Result<Self> {
        Ok(Self(match wait {
            WaitMode::Spinning => None,
            WaitMode::Waiting => Some(ByPipe::start(Peer::Pipe, core)?),
        }))
    }

    /// Sleeps, then measures one round trip, nanoseconds.
    fn take(&mut self) -> Result<Option<u64>> {
        std::thread::sleep(REST);
        let Some(idle) = &mut self.0 else {
            return Ok(None);
        };
        let way_ns = idle.way()?;
        std::thread::sleep(REST);
        Ok(Some(way_ns))
    }

    fn end(self) -> Result<()> {
        self.0.map_or(Ok(()), ByPipe::end)
    }
}

/// From a sentence to its first sub-goal: a [`Measure`].
fn sentences(wait: WaitMode, samples: u32, core: usize, measured: &mut Measured) -> Result<()> {
    let mut peer = Answering::start(Peer::Planner, wait, core)?;
    let robot = peer.join(ROBOT, Role::Controller)?;
    let (scenes, commands) = (robot.sender()?, robot.receiver::<SubGoal>()?);
    let feedbacks = robot.sender::<Feedback>()?;
    let (client, notifier) = (robot.plan_client()?, robot.notifier(PLAN)?);
    let wait_set = robot.wait_set([SubGoal::SERVICE])?;
    let mut heartbeats = Heartbeats::begin(&robot, Role::Controller, now_ns())?;
    let mut beside = Beside::start(wait, Peer::SentenceByPipe, &peer, core)?;
    let mut way = Way::start(wait, core)?;
    let world = World::new()?;
    let mut image = vec![0; world.bytes()];
    world.paint(&mut image);
    let (mut refused, mut not_yet) = (0, 0);
    for number in 1..=u64::from(UNCOUNTED + samples) {
        scenes.send(&see(&TABLETOP, &world.header(number, now_ns()), &image)?)?;
        let _ = heartbeats.beat(State::Idle, now_ns());
        let request = sentence(number)?;
        beside.prepare()?;
        let pipe_ns = way.take()?;
        let computed_ns = beside.take()?;
        std::thread::sleep(REST);

        let begun_ns = now_ns();
        let pending = client.send_copy(request)?;
        notifier.notify();
        if pending.number_of_server_connections() == 0 {
            // The planner has not started yet.
            not_yet += 1;
            ensure!(not_yet < WARM, "no planner was started");
            std::thread::sleep(Duration::from_millis(5));
            continue;
        }
        let mut ended = None;
        let command = until(wait, &wait_set, || {
            let command = commands.receive()?.map(|command| *command);
            if command.is_none() {
                // A planner that has just started has no scene yet.
                while let Some(reply) = pending.receive()? {
                    if let Ok(Reply::Failed { message, .. }) = reply.read() {
                        ended = Some(message.to_owned());
                    }
                }
            }
            Ok(command.map(Some).or_else(|| ended.take().map(|_| None)))
        })?;
        let taken_ns = now_ns() - begun_ns;
        let Some(command) = command else {
            refused += 1;
            ensure!(refused < WARM, "the planner refuses a valid sentence");
            continue;
        };
        measured.record(number, pipe_ns, computed_ns, taken_ns);
        for outcome in [Outcome::Accepted, Outcome::Reached] {
            feedbacks.send(&feedback(command.plan, command.command, number, outcome))?;
        }
        until(WaitMode::Spinning, &wait_set, || {
            let has_ended = !pending.is_connected();
            Ok((pending.receive()?.is_none() && has_ended).then_some(()))
        })?;
    }
    way.end()?;
    beside.end()?;
    peer.end()
}

/// From a frame to its scene: a [`Measure`].
fn scenes(wait: WaitMode, samples: u32, core: usize, measured: &mut Measured) -> Result<()> {
    let mut peer = Answering::start(Peer::Perception, wait, core)?;
    let robot = peer.join(ROBOT, Role::Camera)?;
    let world = World::new()?;
    let frames = robot.frames_out(world.bytes())?;
    let scenes = robot.receiver::<SceneMessage>()?;
    let wait_set = robot.wait_set([SceneMessage::SERVICE])?;
    let mut beside = Beside::start(wait, Peer::FrameByPipe, &peer, core)?;
    let frames_beside = beside.robot().frames_out(world.bytes())?;
    let mut way = Way::start(wait, core)?;
    until(WaitMode::Spinning, &wait_set, || {
        std::thread::sleep(Duration::from_millis(5));
        let sent = frames.send(CameraFrame::default(), world.bytes(), |_| {})?;
        Ok((sent > 0).then_some(()))
    })?;
    // Returns when it was there.
    let send = |frames: &FramesOut, number| -> Result<u64> {
        let mut painted_ns = 0;
        frames.send(world.header(number, now_ns()), world.bytes(), |place| {
            world.paint(place);
            painted_ns = now_ns();
        })?;
        Ok(painted_ns)
    };
    for number in 1..=u64::from(UNCOUNTED + samples) {
        beside.prepare()?;
        let pipe_ns = way.take()?;
        send(&frames_beside, number)?;
        let computed_ns = beside.take()?;
        std::thread::sleep(REST);
        while scenes.receive()?.is_some() {}

        let begun_ns = send(&frames, number)?;
        until(wait, &wait_set, || {
            let scene = scenes.receive()?;
            Ok(scene.filter(|scene| scene.sequence == number).map(|_| ()))
        })?;
        measured.record(number, pipe_ns, computed_ns, now_ns() - begun_ns);
    }
    way.end()?;
    beside.end()?;
    peer.end()
}

/// From a complete frame to its arrival in another process, and back by a small message. Nothing is
/// written to the frame meanwhile: that would evict everything else from the caches, the more the
/// larger it is.
fn hand_over(
    wait: WaitMode,
    (width, height): (u32, u32),
    samples: u32,
    core: usize,
    times: &mut Times,
) -> Result<()> {
    let bytes = (width * height * 7) as usize;
    let mut peer = Answering::start(Peer::Frames, wait, core)?;
    let robot = peer.join(ROBOT, Role::Camera)?;
    let frames = robot.frames_out(bytes)?;
    let said = robot.receiver::<Feedback>()?;
    let wait_set = robot.wait_set([Feedback::SERVICE])?;
    let mut left = UNCOUNTED + samples;
    let mut number = 0;
    while left > 0 {
        number += 1;
        let header = CameraFrame {
            sequence: number,
            ..CameraFrame::default()
        };
        if wait == WaitMode::Waiting {
            std::thread::sleep(REST);
        }
        let mut begun_ns = 0;
        let sent = frames.send(header, bytes, |_| begun_ns = now_ns())?;
        if sent == 0 {
            std::thread::sleep(Duration::from_millis(5));
            continue;
        }
        until(wait, &wait_set, || {
            let said = said.receive()?;
            Ok(said.filter(|said| said.sequence == number).map(|_| ()))
        })?;
        if left <= samples {
            times.push((now_ns() - begun_ns) as i64);
        }
        left -= 1;
    }
    peer.end()
}
