//! Runs a robot's processes for hours and records their resources.

use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::Duration;

use anyhow::{Context as _, Result, bail};
use nsrm_ipc::clock::now_ns;
use nsrm_ipc::message::Role;
use nsrm_ipc::node::{View, Watcher};
use serde_json::{Value, json};

use crate::client::Client;
use crate::parts::stop_on_signals;
use crate::process_group::{PARTS, ProcessGroup};

/// Between two polls of the observer.
const NAP: Duration = Duration::from_millis(5);
const SECOND: u64 = 1_000_000_000;

/// The command line.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// The command `nsrm`.
    #[arg(long)]
    nsrm: PathBuf,
    /// Folder for the journal and the logs of processes.
    #[arg(long)]
    out: PathBuf,
    /// Duration, hours.
    #[arg(long, default_value_t = 1.0)]
    hours: f64,
    /// Seconds between two samples.
    #[arg(long, default_value_t = 10)]
    every: u64,
}

pub(crate) fn run(options: &Options) -> Result<()> {
    let stop = stop_on_signals()?;
    let mut group = ProcessGroup::new(&options.out, &options.nsrm, 0)?;
    let mut watcher = Watcher::begin(group.join(Role::Watcher)?)?;
    for role in PARTS {
        group.start(role)?;
    }
    group.ready(&mut watcher)?;
    let client = Client::begin(&group, 1)?;
    let begun_ns = now_ns();
    let length_ns = (options.hours * 3600.0 * SECOND as f64) as u64;
    let mut next_ns = begun_ns;
    while now_ns() - begun_ns < length_ns && !stop.load(Ordering::Relaxed) {
        std::thread::sleep(NAP);
        let now_ns = now_ns();
        let view = watcher.look(now_ns);
        if now_ns < next_ns {
            continue;
        }
        next_ns += options.every * SECOND;
        let more = sample(&group, view)?;
        group.journal().write("sample", more)?;
        if let Some((role, status)) = group.ended()?.first() {
            bail!("{} ended: {status}", role.word());
        }
        let minutes = (now_ns - begun_ns) / (60 * SECOND);
        if minutes.is_multiple_of(5) && (now_ns - begun_ns) % (60 * SECOND) < options.every * SECOND
        {
            eprintln!("{minutes} of {:.0} minutes", options.hours * 60.0);
        }
    }
    client.end()?;
    drop(watcher);
    group.stop()
}

/// The resources of the processes, and the use of shared memory.
fn sample(group: &ProcessGroup, view: &View) -> Result<Value> {
    let mut nodes = serde_json::Map::new();
    for role in PARTS {
        let process = group.process(role).context("a process is missing")?;
        nodes.insert(role.word().into(), held(process)?);
    }
    let (files, bytes) = group.shared()?;
    let scenes = &view.scenes;
    Ok(json!({
        "nodes": nodes,
        "shared": {"files": files, "bytes": bytes},
        "scenes": {
            "count": scenes.count,
            "lost": scenes.lost,
            "rate_hz": scenes.rate_hz,
            "latency_ns": scenes.latency_ns,
        },
    }))
}

/// Memory, threads and open files of a process, from `/proc`.
fn held(process: u32) -> Result<Value> {
    let folder = PathBuf::from(format!("/proc/{process}"));
    let status = std::fs::read_to_string(folder.join("status"))?;
    let number = |name: &str| -> Result<u64> {
        let line = status.lines().find_map(|line| line.strip_prefix(name));
        let word = line.and_then(|line| line.split_whitespace().next());
        Ok(word.context("/proc: status")?.parse()?)
    };
    Ok(json!({
        "rss_kib": number("VmRSS:")?,
        "threads": number("Threads:")?,
        "handles": std::fs::read_dir(folder.join("fd"))?.count(),
    }))
}
