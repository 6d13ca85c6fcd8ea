//! `nsrm say`: sends a sentence to a robot, prints its execution as it happens, and asks back.

use std::io::Write as _;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant};

use nsrm::dialogue::Question;
use nsrm::json;
use nsrm_core::dsl::Argument;
use nsrm_core::{Model, Planner, Scene};
use nsrm_ipc::clock::{is_due, now_ns};
use nsrm_ipc::executive::Mode;
use nsrm_ipc::message::{PlanReply, Reply, Role, SceneMessage, StepMessage};
use nsrm_ipc::node::{Client, RequestError};
use nsrm_ipc::service::Receiver;
use serde_json::{Value, json};

use super::config::Config;
use super::{join, open, stop_on_signals};
use crate::Failure;

/// How long until a stop, which may have been lost, is sent again, nanoseconds.
const SAID_AGAIN_NS: u64 = 200_000_000;
/// Between two polls for a reply.
const NAP: Duration = Duration::from_millis(2);
/// Between two looks for a stop while an answer is typed.
const LONG_NAP: Duration = Duration::from_millis(50);
/// How long a scene is waited for before a question.
const SCENE_WAIT: Duration = Duration::from_secs(1);

/// Sends the sentence and prints its events until it ends. If it is refused before anything is moved,
/// and `asks`, asks the person back, and sends the sentence that the answer leads to.
pub(super) fn say(
    config: &Config,
    sentence: &str,
    mode: Mode,
    as_json: bool,
    asks: bool,
) -> Result<(), Failure> {
    let any = open(config)?;
    let model = any.model();
    let stop = stop_on_signals()?;
    let robot = join(config, Role::Client)?;
    // Without scenes, such as if all places are taken, only words are asked about.
    let scenes = asks
        .then(|| robot.receiver::<SceneMessage>().ok())
        .flatten();
    let mut client = Client::begin(robot, config.transport, config.limits.silence_ns)?;
    let mut sentence = sentence.to_owned();
    loop {
        let mut told = Told::default();
        let ended = follow(
            &mut client,
            &model,
            &sentence,
            mode,
            as_json,
            &stop,
            &mut told,
        );
        let Err(failure) = ended else {
            return Ok(());
        };
        let asked = asks && told.is_refused && !stop.load(Ordering::Relaxed);
        let scene = scenes.as_ref().filter(|_| asked);
        let scene = scene.and_then(|scenes| latest(scenes, &model));
        let question = asked.then(|| question(&model, scene.as_deref(), &sentence));
        let Some(question) = question.flatten() else {
            return Err(failure);
        };
        eprintln!("nsrm: {}", failure.message);
        match answered(&model, &question, &stop) {
            Some(completed) => sentence = completed,
            None => return Err(failure),
        }
        eprintln!("nsrm: \"{sentence}\"");
    }
}

/// The robot's last scene.
fn latest(scenes: &Receiver<SceneMessage>, model: &Model<'_>) -> Option<Box<Scene>> {
    let start = Instant::now();
    loop {
        if let Some(sample) = scenes.waiting().last() {
            return sample.to_scene(model).ok().map(Box::new);
        }
        if start.elapsed() > SCENE_WAIT {
            return None;
        }
        std::thread::sleep(NAP);
    }
}

/// What to ask about a sentence that the planner has refused.
fn question(model: &Model<'_>, scene: Option<&Scene>, sentence: &str) -> Option<Question> {
    let planner = Planner::new(model);
    let refusal = match scene {
        Some(scene) => planner.plan(scene, sentence).err()?,
        None => planner.parse(sentence).err()?,
    };
    Question::after(model, scene, &refusal, sentence)
}

/// Asks until an answer leads to a sentence or is one; `None` if there is no answer.
fn answered(model: &Model<'_>, question: &Question, stop: &AtomicBool) -> Option<String> {
    loop {
        eprintln!("{question}");
        for (number, option) in (1..).zip(question.options()) {
            eprintln!("  {number}  {}", option.answer);
        }
        eprint!("> ");
        let answer = typed(stop)?;
        if Planner::new(model).parse(&answer).is_ok() {
            return Some(answer);
        }
        if let Some(sentence) = question.complete(&answer) {
            return Some(sentence);
        }
        eprintln!("nsrm: \"{answer}\" is none of the answers; an empty line ends this");
    }
}

/// A line of the input; `None` if it is empty, at the end of the input, and after a stop.
fn typed(stop: &AtomicBool) -> Option<String> {
    let (sender, receiver) = mpsc::channel();
    // It ends with the process if nothing is typed any more.
    std::thread::spawn(move || {
        let mut line = String::new();
        let read = std::io::stdin().read_line(&mut line);
        let _ = sender.send(read.map(|_| line));
    });
    loop {
        match receiver.recv_timeout(LONG_NAP) {
            Ok(line) => {
                let line = line.ok()?.trim().to_owned();
                return (!line.is_empty()).then_some(line);
            }
            Err(RecvTimeoutError::Timeout) if !stop.load(Ordering::Relaxed) => {}
            Err(_) => return None,
        }
    }
}

/// Sends a sentence and prints its events until it ends.
fn follow(
    client: &mut Client,
    model: &Model<'_>,
    sentence: &str,
    mode: Mode,
    as_json: bool,
    stop: &AtomicBool,
    told: &mut Told,
) -> Result<(), Failure> {
    let mut request = client.ask(sentence, mode).map_err(not_heard)?;
    // When the stop is sent next.
    let mut again_ns = None;
    let mut is_moved = false;
    loop {
        let now_ns = now_ns();
        let is_due = |next_ns| is_due(next_ns, now_ns, SAID_AGAIN_NS);
        if stop.load(Ordering::Relaxed) && again_ns.is_none_or(is_due) {
            let is_first = again_ns.replace(now_ns + SAID_AGAIN_NS).is_none();
            let said = client.cancel(&request);
            // Whether the planner is still there is checked below.
            if is_first {
                eprintln!("nsrm: stopping the robot …");
                said.map_err(not_heard)?;
            }
        }
        let Some(reply) = client.poll(&mut request, now_ns).map_err(not_heard)? else {
            std::thread::sleep(NAP);
            continue;
        };
        let said = reply
            .read()
            .map_err(|error| not_heard(RequestError::Iceoryx(error.to_string())))?;
        let written = if as_json {
            writeln!(std::io::stdout(), "{}", event_json(model, &reply, &said))
        } else {
            match told.text(model, &said) {
                Some(text) => writeln!(std::io::stdout(), "{text}"),
                None => Ok(()),
            }
        };
        // If nobody reads the output any more, the robot goes on.
        let _ = written;
        is_moved |= matches!(said, Reply::Commanded { .. });
        match said {
            Reply::Done => return Ok(()),
            Reply::Failed { reason, message } => {
                told.is_refused = !is_moved;
                return Err(Failure {
                    message: message.into(),
                    json: json!({"refused": reason, "message": message}),
                });
            }
            _ => {}
        }
    }
}

/// Why the request failed; its JSON has the error's kind.
fn not_heard(error: RequestError) -> Failure {
    let message = error.to_string();
    let mut json = json::error(&message);
    json["error"]["kind"] = error.kind().into();
    Failure { message, json }
}

/// What has been printed so far.
#[derive(Default)]
struct Told {
    /// The last plan.
    steps: Vec<StepMessage>,
    /// Whether the sentence has failed before anything was moved.
    is_refused: bool,
}

impl Told {
    /// The text of a reply, if any. Only the first plan is printed: later ones differ by what
    /// has been observed since.
    fn text(&mut self, model: &Model<'_>, said: &Reply<'_>) -> Option<String> {
        if let Reply::Planned { steps, program } = said {
            let is_first = self.steps.is_empty();
            self.steps = steps.to_vec();
            let lines = steps.iter().enumerate();
            let lines = lines.map(|(index, step)| step_text(model, index, step));
            let all = std::iter::once((*program).to_owned()).chain(lines);
            return is_first.then(|| all.collect::<Vec<_>>().join("\n"));
        }
        if let Reply::Commanded { step } = said {
            let goal = self.steps.get(*step as usize)?;
            let [x, y, z] = goal.position;
            return Some(format!(
                "step {}: moving object {} to ({x:.3}, {y:.3}, {z:.3}) m",
                step + 1,
                goal.object_id
            ));
        }
        event_text(said)
    }
}

fn event_text(said: &Reply<'_>) -> Option<String> {
    Some(match said {
        Reply::Reached { step, off_m } if off_m.is_finite() => format!(
            "step {}: done, observed {:.1} mm from its sub-goal",
            step + 1,
            1000.0 * off_m
        ),
        Reply::Reached { step, .. } => {
            format!("step {}: done, according to the controller", step + 1)
        }
        Reply::Clearing { step, message } => format!("step {}: {message}", step + 1),
        Reply::Again { message, .. } => format!("{message}; retrying"),
        Reply::Done => "done".into(),
        Reply::Planned { .. } | Reply::Commanded { .. } | Reply::Failed { .. } => return None,
    })
}

fn step_text(model: &Model<'_>, index: usize, step: &StepMessage) -> String {
    let described = |argument| {
        let words = step.description(argument).words(model).to_string();
        if words.is_empty() {
            "any".into()
        } else {
            words
        }
    };
    let confidence: f32 = step.confidence.iter().product();
    let [x, y, z] = step.position;
    format!(
        "  step {}: object {} ({}, {:.2}), by object {} ({}, {:.2}), to ({x:.3}, {y:.3}, {z:.3}) m; \
         confidence {confidence:.3}",
        index + 1,
        step.object_id,
        described(Argument::Object),
        step.object_score,
        step.reference_id,
        described(Argument::Reference),
        step.reference_score,
    )
}

fn event_json(model: &Model<'_>, reply: &PlanReply, said: &Reply<'_>) -> Value {
    let mut event = match said {
        Reply::Planned { steps, program } => json!({
            "event": "planned",
            "program": program,
            "steps": steps.iter().map(|step| step_json(model, step)).collect::<Vec<_>>(),
        }),
        Reply::Commanded { step } => json!({"event": "commanded", "step": step}),
        Reply::Reached { step, off_m } => json!({
            "event": "reached",
            "step": step,
            "off_m": off_m.is_finite().then(|| json::decimal(*off_m)),
        }),
        Reply::Clearing { step, message } => {
            json!({"event": "clearing", "step": step, "message": message})
        }
        Reply::Again {
            step,
            reason,
            message,
        } => json!({"event": "again", "step": step, "reason": reason, "message": message}),
        Reply::Done => json!({"event": "done"}),
        Reply::Failed { reason, message } => {
            json!({"event": "failed", "reason": reason, "message": message})
        }
    };
    event["plan"] = reply.plan.into();
    event["number"] = reply.number.into();
    event
}

fn step_json(model: &Model<'_>, step: &StepMessage) -> Value {
    // A model has at most 255 actions.
    let action = u8::try_from(step.action).unwrap_or(u8::MAX);
    let grounded = step.is_grounded().then(|| {
        json!({
            "object_id": step.object_id,
            "reference_id": step.reference_id,
            "object_score": json::decimal(step.object_score),
            "reference_score": json::decimal(step.reference_score),
            "confidence": json::decimal(step.confidence.iter().product()),
            "position": json::decimals(&step.position),
            "orientation": json::decimals(&step.orientation),
            "location": json::decimals(&step.location),
        })
    });
    json!({
        "action": json::action_name(model, action),
        "object": json::description(model, &step.description(Argument::Object)),
        "reference": json::description(model, &step.description(Argument::Reference)),
        "grounded": grounded,
    })
}
