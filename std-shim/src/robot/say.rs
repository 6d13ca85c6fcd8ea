//! `nsrm say`: sends a sentence to a robot and prints its execution as it happens.

use std::io::Write as _;
use std::sync::atomic::Ordering;
use std::time::Duration;

use nsrm::json;
use nsrm_core::Model;
use nsrm_core::dsl::Description;
use nsrm_ipc::clock::{is_due, now_ns};
use nsrm_ipc::executive::Mode;
use nsrm_ipc::message::{PlanReply, Reply, Role, StepMessage};
use nsrm_ipc::node::{Client, RequestError};
use serde_json::{Value, json};

use super::config::Config;
use super::{join, open, stop_on_signals};
use crate::Failure;

/// How long until a stop, which may have been lost, is sent again, nanoseconds.
const SAID_AGAIN_NS: u64 = 200_000_000;
/// Between two polls for a reply.
const NAP: Duration = Duration::from_millis(2);

/// Sends the sentence and prints its events until it ends.
pub(super) fn say(
    config: &Config,
    sentence: &str,
    mode: Mode,
    as_json: bool,
) -> Result<(), Failure> {
    let any = open(config)?;
    let model = any.model();
    let stop = stop_on_signals()?;
    let mut client = Client::begin(
        join(config, Role::Client)?,
        config.transport,
        config.limits.silence_ns,
    )?;
    let mut request = client.ask(sentence, mode).map_err(not_heard)?;
    // When the stop is sent next.
    let mut again_ns = None;
    let mut told = Told::default();
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
            writeln!(std::io::stdout(), "{}", event_json(&model, &reply, &said))
        } else {
            match told.text(&model, &said) {
                Some(text) => writeln!(std::io::stdout(), "{text}"),
                None => Ok(()),
            }
        };
        // If nobody reads the output any more, the robot goes on.
        let _ = written;
        match said {
            Reply::Done => return Ok(()),
            Reply::Failed { reason, message } => {
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
    let described = |count: u32, concepts: &[u8]| {
        let names = json::names(model, &description(count, concepts));
        if names.is_empty() {
            "any".into()
        } else {
            names.join(" ")
        }
    };
    let confidence: f32 = step.confidence.iter().product();
    let [x, y, z] = step.position;
    format!(
        "  step {}: object {} ({}, {:.2}), by object {} ({}, {:.2}), to ({x:.3}, {y:.3}, {z:.3}) m; \
         confidence {confidence:.3}",
        index + 1,
        step.object_id,
        described(step.object_count, &step.object),
        step.object_score,
        step.reference_id,
        described(step.reference_count, &step.reference),
        step.reference_score,
    )
}

/// The first `count` concepts; they fit, since the reply has been checked.
fn description(count: u32, concepts: &[u8]) -> Description {
    let mut description = Description::new();
    for &concept in concepts.iter().take(count as usize) {
        let _ = description.push(concept);
    }
    description
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
    let object = description(step.object_count, &step.object);
    let reference = description(step.reference_count, &step.reference);
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
        "object": json::names(model, &object),
        "reference": json::names(model, &reference),
        "grounded": grounded,
    })
}
