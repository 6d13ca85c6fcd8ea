//! The closed loop in a world driven by bytes: scenes that are late, old, broken or missing, a
//! controller that obeys, fails, lies or is silent.
//!
//! `watched` is an independent specification of what the loop may do; the two must agree.

mod watched;

use std::sync::LazyLock;

use nsrm_core::planner::MAX_POLLS;
use nsrm_core::{Model, RawScene};
use nsrm_ipc::executive::{Command, CommandId, Event, Executive, Failure, Limits, Mode, Sentence};
use nsrm_ipc::message::{Feedback, Outcome, SceneMessage};
use nsrm_tabletop::TABLETOP;

use self::watched::{Now, Watched};
use super::bytes::{Script, bytes_of, message};
use super::says;
use super::text::SQUARES;
use crate::by_hand::{Parts, block, raw_scene};

const MS: u64 = 1_000_000;

/// The sentences that one byte selects; a greater byte means that the sentence follows.
pub(super) const SENTENCES: [&str; 7] = [
    "put the small red block on the blue block then put the green block on the small red block",
    "put the red block on the blue block",
    "put the green block beside the blue block",
    "put the red block on the blue block then put the red block on the green block then put the \
     blue block on the red block",
    "put the purple block on the blue block",
    "put the small green block on the blue block",
    "move the red block to the left of the green block, then put the yellow block on the red one",
];

/// The operation of a byte of the script, modulo [`Op::ALL`]. Its parameters follow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Op {
    /// A sentence and a mode.
    Ask,
    /// So many polls.
    Poll,
    /// Polls until there is nothing to do, or something to send.
    PollOn,
    /// Milliseconds.
    Wait,
    /// Tenths of a second.
    WaitLong,
    /// Eight bytes of nanoseconds.
    Leap,
    /// The world as it is now.
    See,
    /// The world as it is, dated so many times 4 ms back.
    SeeLate,
    /// The world with four bytes of its message replaced, at a place of two bytes.
    SeeBroken,
    /// An object goes somewhere, or away.
    Move,
    /// The controller accepts the last command.
    Accept,
    /// It executes the command, and reports it.
    Obey,
    /// It reports some outcome of the last command, at some time.
    Say,
    /// It sends any feedback.
    Babble,
    /// The sentence is cancelled.
    Cancel,
    /// The controller is lost, or could not be reached.
    Lose,
}

impl Op {
    const ALL: [Self; 16] = [
        Self::Ask,
        Self::Poll,
        Self::PollOn,
        Self::Wait,
        Self::WaitLong,
        Self::Leap,
        Self::See,
        Self::SeeLate,
        Self::SeeBroken,
        Self::Move,
        Self::Accept,
        Self::Obey,
        Self::Say,
        Self::Babble,
        Self::Cancel,
        Self::Lose,
    ];
}

/// First byte of a script: the hand-made model instead of the pretrained one, a controller that
/// obeys once the script is at its end, and the number of retries.
pub(super) const BY_HAND: u8 = 1;
pub(super) const OBEDIENT: u8 = 2;
const RETRIES: u8 = 3;

static PARTS: LazyLock<Parts> = LazyLock::new(Parts::new);
static MODEL: LazyLock<Model<'static>> = LazyLock::new(|| PARTS.model());

/// A script of operations; after its end the current sentence must end, in a world that works or in
/// one that is silent.
pub fn executive(bytes: &[u8]) {
    play(bytes);
}

/// Runs a script; returns how each sentence has ended: `done`, or the failure's kind.
fn play(bytes: &[u8]) -> Vec<&'static str> {
    let mut script = Script::new(bytes);
    let settings = script.byte();
    let (model, scene) = if settings & BY_HAND == 0 {
        (&TABLETOP, *SQUARES.raw())
    } else {
        let blocks = [
            block("small", "red"),
            block("lego", "blue"),
            block("lego", "green"),
        ];
        (&*MODEL, raw_scene(&MODEL, &blocks))
    };
    let limits = Limits {
        retries: settings >> 6 & RETRIES,
        ..Limits::default()
    };
    assert_eq!(limits.check(), Ok(()));
    let mut world = World::new(model, limits, scene);
    while !script.is_at_end() {
        world.step(&mut script);
    }
    world.end(settings & OBEDIENT != 0);
    world.ended
}

struct World {
    executive: Executive<'static>,
    limits: Limits,
    scene: RawScene,
    now_ns: u64,
    /// When the latest scene that was accepted had been taken.
    seen_ns: u64,
    last_plan: u64,
    /// The last command of all.
    command: Option<Command>,
    watched: Option<Watched>,
    /// How each sentence so far has ended.
    ended: Vec<&'static str>,
}

impl World {
    fn new(model: &'static Model<'static>, limits: Limits, scene: RawScene) -> Self {
        let first_plan = 100;
        Self {
            executive: Executive::new(model, limits, first_plan),
            limits,
            scene,
            now_ns: 10_000 * MS,
            seen_ns: 0,
            last_plan: first_plan - 1,
            command: None,
            watched: None,
            ended: Vec::new(),
        }
    }

    fn step(&mut self, script: &mut Script<'_>) {
        let op = Op::ALL[usize::from(script.byte()) % Op::ALL.len()];
        match op {
            Op::Ask => self.ask(script),
            Op::Poll => {
                for _ in 0..script.byte() {
                    let _ = self.poll();
                }
            }
            Op::PollOn => self.poll_on(),
            Op::Wait => self.pass(u64::from(script.byte()) * MS),
            Op::WaitLong => self.pass(u64::from(script.byte()) * 100 * MS),
            Op::Leap => self.pass(u64::from_le_bytes(script.array())),
            Op::See => self.see(&self.view(self.now_ns)),
            Op::SeeLate => {
                let age_ns = u64::from(script.byte()) * 4 * MS;
                self.see(&self.view(self.now_ns.saturating_sub(age_ns)));
            }
            Op::SeeBroken => self.see_broken(script),
            Op::Move => self.move_object(script),
            Op::Accept => self.say(Outcome::Accepted as u32, self.now_ns),
            Op::Obey => self.obey(),
            Op::Say => self.say_sometime(script),
            Op::Babble => {
                let (feedback, _): (Feedback, _) = message(script.take(size_of::<Feedback>()));
                self.hear(&feedback);
            }
            Op::Cancel => {
                self.executive.cancel();
                if let Some(watched) = &mut self.watched {
                    watched.cancel(self.now_ns);
                }
            }
            Op::Lose => self.lose(script),
        }
    }

    /// Shows the scene with four bytes of its message replaced.
    fn see_broken(&mut self, script: &mut Script<'_>) {
        let mut bytes = bytes_of(&self.view(self.now_ns)).to_vec();
        let place = usize::from(u16::from_le_bytes(script.array()));
        let place = place % (bytes.len() - 3);
        bytes[place..place + 4].copy_from_slice(&script.array::<4>());
        self.see(&message(&bytes).0);
    }

    /// Moves an object in the image, or changes how many the scene has.
    fn move_object(&mut self, script: &mut Script<'_>) {
        let [which, x, y] = script.array();
        let count = usize::from(which) % self.scene.objects.len();
        if which >= 128 {
            self.scene.count = count as u32;
        } else {
            let [x1, y1, x2, y2, _] = &mut self.scene.objects[count].location;
            let (width, height) = (*x2 - *x1, *y2 - *y1);
            (*x1, *y1) = (f32::from(x) / 300.0, f32::from(y) / 300.0);
            (*x2, *y2) = (*x1 + width, *y1 + height);
        }
    }

    /// Reports an outcome, at a time that the script chooses.
    fn say_sometime(&mut self, script: &mut Script<'_>) {
        let [outcome, when] = script.array();
        let at_ns = match when {
            0 => 0,
            255 => u64::MAX,
            when => {
                let ahead_ns = self.now_ns.saturating_add(64 * MS);
                ahead_ns.saturating_sub(u64::from(when) * MS)
            }
        };
        self.say(outcome.into(), at_ns);
    }

    /// Loses the controller, or the command on its way.
    fn lose(&mut self, script: &mut Script<'_>) {
        let is_lost = script.byte().is_multiple_of(2);
        if is_lost {
            self.executive.on_controller_lost();
        } else {
            self.executive.on_command_undelivered();
        }
        if let Some(watched) = &mut self.watched {
            if is_lost {
                watched.on_controller_lost();
            } else {
                watched.on_command_undelivered();
            }
        }
    }

    fn pass(&mut self, by_ns: u64) {
        self.now_ns = self.now_ns.saturating_add(by_ns);
    }

    fn ask(&mut self, script: &mut Script<'_>) {
        let [mode, which] = script.array();
        let mode = match mode % 3 {
            0 => Mode::ClosedLoop,
            1 => Mode::OpenLoop,
            _ => Mode::PlanOnly,
        };
        let text = match SENTENCES.get(usize::from(which)) {
            Some(text) => (*text).to_owned(),
            None => String::from_utf8_lossy(script.take(which.into())).into_owned(),
        };
        let sentence = Sentence::try_from(text.as_str()).expect("255 bytes at most, each three");
        let before = self.executive.plan();
        match (self.executive.ask(sentence.clone(), mode), &self.watched) {
            (Ok(plan), None) => {
                assert_eq!((before, self.executive.plan()), (None, Some(plan)));
                assert!(plan > self.last_plan);
                self.last_plan = plan;
                self.watched = Some(Watched::new(plan, mode, sentence));
            }
            (Err(busy), Some(watched)) => {
                assert_eq!((busy.plan, self.executive.plan()), (watched.plan(), before));
                says(&busy);
            }
            (result, watched) => panic!("{result:?} while on its way is {watched:?}"),
        }
    }

    /// The world as a message.
    fn view(&self, taken_ns: u64) -> SceneMessage {
        let mut raw = self.scene;
        raw.header.timestamp_ns = taken_ns;
        SceneMessage::from(&raw)
    }

    fn see(&mut self, message: &SceneMessage) {
        match self.executive.on_scene(message, self.now_ns) {
            Ok(()) => {
                assert!(message.to_scene(self.executive.model()).is_ok());
                assert!(message.timestamp_ns >= self.seen_ns);
                assert!(message.timestamp_ns <= self.now_ns.saturating_add(5 * MS));
                let age_ns = self.now_ns.saturating_sub(message.timestamp_ns);
                assert!(age_ns <= self.limits.scene_age_ns);
                self.seen_ns = message.timestamp_ns;
            }
            Err(fault) => says(&fault),
        }
    }

    /// The controller reports this outcome of the last command.
    fn say(&mut self, outcome: u32, timestamp_ns: u64) {
        let id = self.command.map(|command| command.id);
        let CommandId { plan, command } = id.unwrap_or_default();
        self.hear(&Feedback {
            plan,
            sequence: 0,
            timestamp_ns,
            command,
            outcome,
            objects: [0; 2],
        });
    }

    fn hear(&mut self, feedback: &Feedback) {
        let heard = self.executive.on_feedback(feedback, self.now_ns);
        assert_eq!(heard, feedback.read().map(|_| ()));
        if let (Ok(report), Some(watched)) = (feedback.read(), &mut self.watched) {
            watched.hear(&report, self.now_ns);
        }
    }

    /// The controller executes the last command.
    fn obey(&mut self) {
        let Some(command) = self.command else {
            return;
        };
        self.say(Outcome::Accepted as u32, self.now_ns);
        let moved = command.planned.sub_goal.object;
        let objects = self.scene.objects.iter_mut();
        for object in objects.filter(|object| object.id == moved) {
            object.location = command.planned.location;
        }
        self.pass(MS);
        self.say(Outcome::Reached as u32, self.now_ns);
    }

    fn poll_on(&mut self) {
        for _ in 0..2 * MAX_POLLS {
            match self.poll() {
                Event::Waiting | Event::Command(_) | Event::Stop(_) | Event::Ended(_) => return,
                _ => {}
            }
        }
        panic!("no end of work: {:?}", self.watched);
    }

    /// Runs until the sentence has ended, which it must.
    fn end(&mut self, is_obedient: bool) {
        for tick in 0..200_000 {
            if self.executive.plan().is_none() {
                assert_eq!(self.executive.poll(self.now_ns), Event::Waiting);
                return;
            }
            // Time ends, too.
            let is_over = self.now_ns > u64::MAX / 2;
            if is_over {
                return;
            }
            if is_obedient && tick % 10 == 0 {
                self.see(&self.view(self.now_ns));
            }
            match self.poll() {
                Event::Command(_) if is_obedient => self.obey(),
                Event::Waiting if !is_obedient => self.pass(250 * MS),
                _ => self.pass(MS),
            }
        }
        panic!("no end: {:?}", self.watched);
    }

    fn poll(&mut self) -> Event {
        let event = self.executive.poll(self.now_ns);
        let Some(watched) = &mut self.watched else {
            assert_eq!(event, Event::Waiting);
            return event;
        };
        watched.follow(
            &event,
            Now {
                model: self.executive.model(),
                limits: &self.limits,
                now_ns: self.now_ns,
                seen_ns: self.seen_ns,
            },
        );
        match &event {
            Event::Command(command) => self.command = Some(*command),
            Event::Ended(result) => {
                let kind = result.as_ref().map_or_else(Failure::kind, |()| "done");
                self.ended.push(kind);
                self.watched = None;
                assert_eq!(self.executive.plan(), None);
            }
            _ => {}
        }
        event
    }
}

#[cfg(test)]
mod tests {
    use super::play;
    use crate::fuzz::seeds;

    /// All assertions above would hold for a loop that never does anything.
    #[test]
    fn the_seeds_end_in_many_ways() {
        let mut ends: Vec<_> = seeds::of("executive")
            .iter()
            .flat_map(|script| play(script))
            .collect();
        ends.sort_unstable();
        ends.dedup();
        let expected = [
            "cancelled",
            "cancelled_unconfirmed",
            "controller_lost",
            "done",
            "no_outcome",
            "no_scene",
            "not_accepted",
            "not_seen",
            "not_there",
            "outside_work_space",
            "unanswered",
            "unknown_word",
            "unsuccessful",
        ];
        assert_eq!(ends, expected);
    }
}
