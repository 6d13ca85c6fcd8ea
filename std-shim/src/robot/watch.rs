//! `nsrm watch`: live nodes, the messages between them, and the planner's last replies.

use std::fmt::Write as _;
use std::io::{IsTerminal as _, Write as _};
use std::sync::atomic::Ordering;
use std::time::Duration;

use nsrm::json::decimal;
use nsrm_ipc::clock::{is_due, now_ns};
use nsrm_ipc::message::{PlanReply, Reply, Role};
use nsrm_ipc::node::{Flow, View, Watcher};
use serde_json::{Value, json};

use super::config::Config;
use super::{join, stop_on_signals};
use crate::Failure;

/// Between two polls.
const NAP: Duration = Duration::from_millis(10);
/// Nanoseconds between two refreshes.
const REFRESH_NS: u64 = 500_000_000;
/// Clears a terminal and goes to its upper left corner.
const CLEAR: &str = "\x1b[H\x1b[2J";

/// Shows a robot until a signal arrives, or once.
pub(super) fn watch(config: &Config, as_json: bool, once: bool) -> Result<(), Failure> {
    let stop = stop_on_signals()?;
    let mut watcher = Watcher::begin(join(config, Role::Watcher)?)?;
    let clears = std::io::stdout().is_terminal() && !as_json && !once;
    let mut next_ns = now_ns() + REFRESH_NS;
    // Which nodes were alive at the last poll, `None` for those never heard.
    let mut were_alive = [None; Role::ALL.len()];
    while !stop.load(Ordering::Relaxed) {
        std::thread::sleep(NAP);
        let now_ns = now_ns();
        let view = watcher.look(now_ns);
        let silence_ns = config.limits.silence_ns;
        let nodes = view
            .nodes
            .map(|node| node.map(|node| node.is_alive(silence_ns, now_ns)));
        let is_node_lost = nodes != were_alive && nodes.contains(&Some(false));
        were_alive = nodes;
        if !is_due(next_ns, now_ns, REFRESH_NS) && (!is_node_lost || once) {
            continue;
        }
        next_ns = now_ns + REFRESH_NS;
        let output = if as_json {
            format!("{}\n", view_json(view, silence_ns, now_ns))
        } else {
            let clear = if clears { CLEAR } else { "" };
            format!("{clear}{}", view_text(config, view, now_ns))
        };
        let mut out = std::io::stdout();
        // If nobody reads the output any more, exit.
        if out
            .write_all(output.as_bytes())
            .and_then(|()| out.flush())
            .is_err()
            || once
        {
            break;
        }
    }
    Ok(())
}

fn seconds(from_ns: u64, to_ns: u64) -> f64 {
    to_ns.saturating_sub(from_ns) as f64 * 1e-9
}

fn view_text(config: &Config, view: &View, now_ns: u64) -> String {
    let mut text = format!("robot {}\n\n", config.robot);
    nodes_text(&mut text, config, view, now_ns);
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "\n  {:<12}{:>8}{:>8}{:>8}{:>12}{:>10}",
        "stream", "count", "lost", "rate", "latency", "age"
    );
    for (name, flow) in [("scene", &view.scenes), ("feedback", &view.feedback)] {
        let _ = writeln!(text, "  {name:<12}{}", flow_text(flow, now_ns));
    }
    let _ = writeln!(text, "  {} objects in the last scene", view.objects);
    if view.rejected > 0 {
        let _ = writeln!(text, "  {} invalid messages", view.rejected);
    }
    if !view.replies.is_empty() {
        text.push_str("\n  last replies of the planner\n");
    }
    for reply in &view.replies {
        let _ = writeln!(
            text,
            "  plan {} #{:<3} {}",
            reply.plan,
            reply.number,
            reply_text(reply)
        );
    }
    text
}

/// Appends a table of the nodes: those that are needed, and others that were heard.
fn nodes_text(text: &mut String, config: &Config, view: &View, now_ns: u64) {
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "  {:<12}{:<10}{:>10}{:>12}{:>10}{:>10}",
        "node", "state", "up", "heard", "restarts", "rejected"
    );
    for role in [
        Role::Controller,
        Role::Perception,
        Role::Planner,
        Role::Camera,
        Role::Client,
    ] {
        let node = view.nodes.iter().flatten().find(|node| node.role == role);
        let needed = matches!(role, Role::Controller | Role::Perception | Role::Planner);
        let _ = match node {
            Some(node) => {
                let heard_s = seconds(node.heard_ns, now_ns);
                let lives = node.is_alive(config.limits.silence_ns, now_ns);
                if !lives && role == Role::Client {
                    // Clients come and go.
                    continue;
                }
                let state = if lives {
                    format!("{:?}", node.state).to_lowercase()
                } else {
                    "LOST".into()
                };
                let up_s = seconds(node.started_ns, node.heard_ns);
                writeln!(
                    text,
                    "  {:<12}{state:<10}{up_s:>9.0}s{heard_s:>9.1}s ago{:>6}{:>10}",
                    role.word(),
                    node.restarts,
                    node.rejected
                )
            }
            None if needed => writeln!(text, "  {:<12}not found", role.word()),
            None => Ok(()),
        };
    }
}

fn flow_text(flow: &Flow, now_ns: u64) -> String {
    if flow.count == 0 {
        return format!("{:>8}", "none");
    }
    format!(
        "{:>8}{:>8}{:>8}{:>9.1} ms{:>9.1}s",
        flow.count,
        flow.lost,
        // A few messages give no reliable rate.
        if flow.count > 20 {
            format!("{:.1}/s", flow.rate_hz)
        } else {
            "-".into()
        },
        flow.latency_ns as f64 * 1e-6,
        flow.age_ns(now_ns) as f64 * 1e-9
    )
}

fn reply_text(reply: &PlanReply) -> String {
    match reply.read() {
        Ok(Reply::Planned { steps, .. }) => format!("planned, {} steps", steps.len()),
        Ok(Reply::Commanded { step }) => format!("step {}: moving", step + 1),
        Ok(Reply::Reached { step, .. }) => format!("step {}: done", step + 1),
        Ok(Reply::Clearing { step, message }) => format!("step {}: {message}", step + 1),
        Ok(Reply::Again { message, .. }) => format!("{message}; retrying"),
        Ok(Reply::Done) => "done".into(),
        Ok(Reply::Failed { reason, message }) => format!("{reason}: {message}"),
        Err(error) => error.to_string(),
    }
}

fn view_json(view: &View, silence_ns: u64, now_ns: u64) -> Value {
    let nodes: Vec<Value> = view
        .nodes
        .iter()
        .flatten()
        .map(|node| {
            json!({
                "node": node.role.word(),
                "state": format!("{:?}", node.state).to_lowercase(),
                "lives": node.is_alive(silence_ns, now_ns),
                "up_s": rounded(seconds(node.started_ns, node.heard_ns)),
                "heard_s": rounded(seconds(node.heard_ns, now_ns)),
                "restarts": node.restarts,
                "rejected": node.rejected,
            })
        })
        .collect();
    let flow = |flow: &Flow| {
        json!({
            "count": flow.count,
            "lost": flow.lost,
            "rate_hz": rounded(flow.rate_hz),
            "latency_ms": rounded(flow.latency_ns as f64 * 1e-6),
            "age_s": (flow.count > 0).then(|| rounded(flow.age_ns(now_ns) as f64 * 1e-9)),
        })
    };
    let replies: Vec<Value> = view
        .replies
        .iter()
        .map(|reply| json!({"plan": reply.plan, "number": reply.number, "said": reply_text(reply)}))
        .collect();
    json!({
        "nodes": nodes,
        "scene": flow(&view.scenes),
        "objects": view.objects,
        "feedback": flow(&view.feedback),
        "replies": replies,
        "rejected": view.rejected,
    })
}

/// Rounded to a thousandth.
fn rounded(value: f64) -> f64 {
    decimal((value * 1000.0).round() as f32 / 1000.0)
}
