//! How long it takes from a sentence to its first sub-goal and from a frame to its scene,
//! through shared memory and to another process, and what of it is computation.
//!
//! What is measured beside it in the same run: the computation alone, in this process; and
//! what waking another process and being woken by it costs on this machine, by a pipe and by
//! iceoryx2's events. The two processes change cores for the second half of each, since one
//! core may be faster than the other.

mod answering;

use std::fs::File;
use std::io::{Read, Write};
use std::path::PathBuf;
use std::time::Duration;

use anyhow::{Context as _, Result, bail, ensure};
use hdrhistogram::Histogram;
use nsrm_core::pretrained::TABLETOP;
use nsrm_ipc::clock::now_ns;
use nsrm_ipc::executive::{Event, Executive, Limits, Mode};
use nsrm_ipc::message::{
    Asked, CameraFrame, Feedback, Outcome, PlanRequest, Reply, Role, SceneMessage, State, SubGoal,
};
use nsrm_ipc::node::{Life, see};
use nsrm_ipc::service::{Carried, PLAN};
use serde_json::json;

use self::answering::{Answering, feedback, stay_on};
pub(crate) use self::answering::{Looks, Peer, answer};
use crate::world::{SENTENCES, World};

/// The longest that is counted, nanoseconds; what takes longer counts as this.
const LONGEST_NS: u64 = 1_000_000_000;
/// The longest wait for an answer.
const PATIENCE_NS: u64 = 10_000_000_000;
/// How often the planner may not be there yet, or have no scene or no word of a controller
/// on a machine with other work.
const WARM: u32 = 1000;
/// Between two questions: who waits is asleep again.
const REST: Duration = Duration::from_micros(300);
/// Images of a frame whose hand-over is measured, pixels.
const SIZES: [(u32, u32); 2] = [(640, 480), (3840, 2160)];

/// What is told on the command line.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// The command `nsrm`; not needed, as its nodes run here.
    #[arg(long, hide = true)]
    nsrm: Option<PathBuf>,
    /// Folder for what was measured.
    #[arg(long)]
    out: PathBuf,
    /// How often each is measured.
    #[arg(long, default_value_t = 20_000)]
    samples: u32,
}

/// Measures all, and writes `latency.jsonl`: a line for each thing that was measured.
pub(crate) fn run(options: &Options) -> Result<()> {
    std::fs::create_dir_all(&options.out).with_context(|| options.out.display().to_string())?;
    let path = options.out.join("latency.jsonl");
    let file = File::create(&path).with_context(|| path.display().to_string())?;
    let mut book = Book { file };
    let samples = options.samples;
    let [times] = on_both_cores(samples, pipe)?;
    book.write("pipe", "", &times)?;
    for looks in [Looks::Spinning, Looks::Waiting] {
        let [alone, through] = on_both_cores(samples, |share, core| sentences(looks, share, core))?;
        book.write("sentence, computation alone", looks.word(), &alone)?;
        book.write("sentence", looks.word(), &through)?;
        let [alone, through] = on_both_cores(samples, |share, core| scenes(looks, share, core))?;
        book.write("frame, computation alone", looks.word(), &alone)?;
        book.write("frame", looks.word(), &through)?;
    }
    for (width, height) in SIZES {
        let bytes = (width * height * 7) as usize;
        let hand_over = |share, core| hand_over(Looks::Spinning, bytes, share, core);
        let [times] = on_both_cores(samples, hand_over)?;
        book.write("hand-over", &format!("{width}x{height}"), &times)?;
    }
    let (width, height) = SIZES[0];
    let bytes = (width * height * 7) as usize;
    let woken = |share, core| hand_over(Looks::Waiting, bytes, share, core);
    let [times] = on_both_cores(samples, woken)?;
    book.write("event", "", &times)?;
    Ok(())
}

/// Measures half on one core and half on the other, with who answers on the one that is left.
///
/// * `measure`: is given how often, and the core of who answers
fn on_both_cores<const N: usize>(
    samples: u32,
    measure: impl Fn(u32, usize) -> Result<[Histogram<u64>; N]>,
) -> Result<[Histogram<u64>; N]> {
    stay_on(0)?;
    let mut all = measure(samples.div_ceil(2), 1)?;
    if samples > 1 {
        stay_on(1)?;
        for (all, more) in all.iter_mut().zip(measure(samples / 2, 0)?) {
            all.add(more)?;
        }
    }
    Ok(all)
}

/// Writes down what was measured.
struct Book {
    file: File,
}

impl Book {
    fn write(&mut self, what: &str, how: &str, times: &Histogram<u64>) -> Result<()> {
        eprintln!(
            "{what} {how}: p50 {:.1} µs",
            times.value_at_quantile(0.5) as f64 / 1000.0
        );
        let counts: Vec<_> = times
            .iter_recorded()
            .map(|step| (step.value_iterated_to(), step.count_since_last_iteration()))
            .collect();
        let line = json!({"what": what, "how": how, "counts_ns": counts});
        writeln!(self.file, "{line}")?;
        Ok(())
    }
}

fn histogram() -> Result<Histogram<u64>> {
    Ok(Histogram::new_with_bounds(1, LONGEST_NS, 3)?)
}

/// Waking another process and being woken by it.
fn pipe(samples: u32, core: usize) -> Result<[Histogram<u64>; 1]> {
    let mut peer = Answering::start(Peer::Pipe, Looks::Waiting, core)?;
    let mut input = peer.child.stdin.take().context("no pipe")?;
    let mut output = peer.child.stdout.take().context("no pipe")?;
    let mut times = histogram()?;
    let mut byte = [7];
    for _ in 0..samples {
        std::thread::sleep(REST);
        let begun_ns = now_ns();
        input.write_all(&byte)?;
        output.read_exact(&mut byte)?;
        times.saturating_record(now_ns() - begun_ns);
    }
    drop(input);
    ensure!(peer.child.wait()?.success(), "who answers failed");
    Ok([times])
}

/// Waits until `take` has something: spinning, or woken at `listener`.
fn until<T>(
    looks: Looks,
    listener: &iceoryx2::port::listener::Listener<iceoryx2::prelude::ipc::Service>,
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
        if looks == Looks::Waiting {
            let _ = listener.timed_wait(|_| {}, Duration::from_millis(100));
        } else {
            std::hint::spin_loop();
        }
    }
}

/// From a sentence to its first sub-goal: the computation alone, and through the planner's
/// process.
fn sentences(looks: Looks, samples: u32, core: usize) -> Result<[Histogram<u64>; 2]> {
    let mut peer = Answering::start(Peer::Planner, looks, core)?;
    let robot = peer.join(Role::Controller)?;
    let (scenes, commands) = (robot.sender()?, robot.receiver::<SubGoal>()?);
    let feedbacks = robot.sender::<Feedback>()?;
    let (client, bell) = (robot.plan_client()?, robot.bell(PLAN)?);
    let listener = robot.listen(SubGoal::SERVICE)?;
    let mut life = Life::begin(&robot, Role::Controller, now_ns())?;
    let (mut alone, mut through) = (histogram()?, histogram()?);
    let world = World::new()?;
    let mut image = vec![0; world.bytes()];
    world.paint(&mut image);
    let mut executive = Executive::new(&TABLETOP, Limits::default(), 1);
    let (mut refused, mut not_yet) = (0, 0);
    for number in 1..=u64::from(samples) {
        let seen = see(&TABLETOP, &world.header(number, now_ns()), &image)?;
        scenes.send(&seen)?;
        let _ = life.beat(State::Idle, now_ns());
        let request = PlanRequest::new(1, number, Mode::OpenLoop, SENTENCES[0])?;
        executive.see(&seen, now_ns())?;
        looks.rest(|| commands.receive().is_ok());
        let computed_ns = compute(&mut executive, &request)?;
        std::thread::sleep(REST);

        let begun_ns = now_ns();
        let pending = client.send_copy(request)?;
        bell.ring();
        if pending.number_of_server_connections() == 0 {
            // The planner has not begun yet.
            not_yet += 1;
            ensure!(not_yet < WARM, "no planner was started");
            std::thread::sleep(Duration::from_millis(5));
            continue;
        }
        let mut ended = None;
        let command = until(looks, &listener, || {
            let command = commands.receive()?.map(|command| *command);
            if command.is_none() {
                // A planner that has just begun has no scene yet.
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
            ensure!(refused < WARM, "the planner refuses what can be done");
            continue;
        };
        alone.saturating_record(computed_ns);
        through.saturating_record(taken_ns);
        for outcome in [Outcome::Accepted, Outcome::Reached] {
            feedbacks.send(&feedback(command.plan, command.command, number, outcome))?;
        }
        until(Looks::Spinning, &listener, || {
            let has_ended = !pending.is_connected();
            Ok((pending.receive()?.is_none() && has_ended).then_some(()))
        })?;
    }
    peer.end()?;
    Ok([alone, through])
}

/// What a planner does between a sentence and its first sub-goal, and nothing else.
fn compute(executive: &mut Executive<'_>, request: &PlanRequest) -> Result<u64> {
    let begun_ns = now_ns();
    let Asked::Follow { sentence, mode } = request.read()? else {
        bail!("no sentence");
    };
    executive.ask(sentence, mode)?;
    loop {
        match executive.poll(now_ns()) {
            Event::Command(command) => {
                std::hint::black_box(SubGoal::from(&command));
                break;
            }
            Event::Ended(end) => bail!("the sentence ended: {end:?}"),
            _ => {}
        }
    }
    let taken_ns = now_ns() - begun_ns;
    executive.miss_controller();
    while !matches!(executive.poll(now_ns()), Event::Ended(_)) {}
    Ok(taken_ns)
}

/// From a frame to its scene: the computation alone, and through perception's process.
fn scenes(looks: Looks, samples: u32, core: usize) -> Result<[Histogram<u64>; 2]> {
    let mut peer = Answering::start(Peer::Perception, looks, core)?;
    let robot = peer.join(Role::Camera)?;
    let world = World::new()?;
    let frames = robot.frames_out(world.bytes())?;
    let scenes = robot.receiver::<SceneMessage>()?;
    let listener = robot.listen(SceneMessage::SERVICE)?;
    let (mut alone, mut through) = (histogram()?, histogram()?);
    let mut image = vec![0; world.bytes()];
    until(Looks::Spinning, &listener, || {
        std::thread::sleep(Duration::from_millis(5));
        let sent = frames.send(CameraFrame::default(), world.bytes(), |_| {})?;
        Ok((sent > 0).then_some(()))
    })?;
    for number in 1..=u64::from(samples) {
        world.paint(&mut image);
        let header = world.header(number, now_ns());
        looks.rest(|| scenes.receive().is_ok());
        let begun_ns = now_ns();
        std::hint::black_box(see(&TABLETOP, &header, &image)?);
        alone.saturating_record(now_ns() - begun_ns);
        std::thread::sleep(REST);
        while scenes.receive()?.is_some() {}

        let mut begun_ns = 0;
        frames.send(world.header(number, now_ns()), world.bytes(), |place| {
            world.paint(place);
            begun_ns = now_ns();
        })?;
        until(looks, &listener, || {
            let scene = scenes.receive()?;
            Ok(scene.filter(|scene| scene.sequence == number).map(|_| ()))
        })?;
        through.saturating_record(now_ns() - begun_ns);
    }
    peer.end()?;
    Ok([alone, through])
}

/// From a frame that stands there to its being in another process's hands, and back by a
/// small message. Nothing is written into it meanwhile: that would leave nothing else in the
/// caches, the more the larger it is.
fn hand_over(looks: Looks, bytes: usize, samples: u32, core: usize) -> Result<[Histogram<u64>; 1]> {
    let mut peer = Answering::start(Peer::Frames, looks, core)?;
    let robot = peer.join(Role::Camera)?;
    let frames = robot.frames_out(bytes)?;
    let said = robot.receiver::<Feedback>()?;
    let listener = robot.listen(Feedback::SERVICE)?;
    let mut times = histogram()?;
    let mut number = 0;
    while times.len() < u64::from(samples) {
        number += 1;
        let header = CameraFrame {
            sequence: number,
            ..CameraFrame::default()
        };
        if looks == Looks::Waiting {
            std::thread::sleep(REST);
        }
        let mut begun_ns = 0;
        let sent = frames.send(header, bytes, |_| begun_ns = now_ns())?;
        if sent == 0 {
            std::thread::sleep(Duration::from_millis(5));
            continue;
        }
        until(looks, &listener, || {
            let said = said.receive()?;
            Ok(said.filter(|said| said.sequence == number).map(|_| ()))
        })?;
        times.saturating_record(now_ns() - begun_ns);
    }
    peer.end()?;
    Ok([times])
}
