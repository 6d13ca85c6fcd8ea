//! The computations of the answering processes, without communication.

use anyhow::{Context as _, Result, bail};
use nsrm_ipc::clock::now_ns;
use nsrm_ipc::executive::{Event, Executive, Limits, Mode};
use nsrm_ipc::message::{Asked, PlanRequest, SubGoal};
use nsrm_ipc::node::see;
use nsrm_ipc::service::{Frames, Robot};
use nsrm_tabletop::TABLETOP;

use super::PATIENCE_NS;
use crate::world::{SENTENCES, World};

/// A computation.
pub(super) trait Alone {
    /// Prepares a computation.
    fn prepare(&mut self) -> Result<()>;
    /// Computes; returns its time, nanoseconds.
    fn take(&mut self) -> Result<u64>;
}

/// No computation.
pub(super) struct Nothing;

impl Alone for Nothing {
    fn prepare(&mut self) -> Result<()> {
        Ok(())
    }

    fn take(&mut self) -> Result<u64> {
        Ok(0)
    }
}

/// From a sentence to its first sub-goal.
pub(super) struct SentenceAlone {
    world: World,
    image: Vec<u8>,
    number: u64,
    executive: Executive<'static>,
}

impl SentenceAlone {
    pub(super) fn new() -> Result<Self> {
        // A waiting process may be delayed.
        let limits = Limits {
            scene_age_ns: PATIENCE_NS,
            ..Limits::default()
        };
        let world = World::new()?;
        let mut image = vec![0; world.bytes()];
        world.paint(&mut image);
        Ok(Self {
            world,
            image,
            number: 0,
            executive: Executive::new(&TABLETOP, limits, 1),
        })
    }
}

impl Alone for SentenceAlone {
    /// Takes a new scene, as a planner has when a request arrives.
    fn prepare(&mut self) -> Result<()> {
        self.number += 1;
        let header = self.world.header(self.number, now_ns());
        let scene = see(&TABLETOP, &header, &self.image)?;
        Ok(self.executive.on_scene(&scene, now_ns())?)
    }

    fn take(&mut self) -> Result<u64> {
        let request = sentence(self.number)?;
        let executive = &mut self.executive;
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
        executive.on_command_undelivered();
        while !matches!(executive.poll(now_ns()), Event::Ended(_)) {}
        Ok(taken_ns)
    }
}

/// The request that is measured.
pub(super) fn sentence(number: u64) -> Result<PlanRequest> {
    let request = PlanRequest::new(1, number, Mode::OpenLoop, SENTENCES[0])?;
    Ok(request)
}

/// From a frame to its scene. The measuring process has painted it in place: the computation starts
/// with its pixels in another core's caches, as always.
pub(super) struct FrameAlone {
    frames: Frames,
}

impl FrameAlone {
    pub(super) fn new(robot: &Robot) -> Result<Self> {
        let frames = robot.frames_in()?;
        Ok(Self { frames })
    }
}

impl Alone for FrameAlone {
    fn prepare(&mut self) -> Result<()> {
        Ok(())
    }

    fn take(&mut self) -> Result<u64> {
        let frame = self.frames.receive()?.context("no frame")?;
        let begun_ns = now_ns();
        let scene = see(&TABLETOP, frame.user_header(), frame.payload())?;
        std::hint::black_box(scene);
        Ok(now_ns() - begun_ns)
    }
}
