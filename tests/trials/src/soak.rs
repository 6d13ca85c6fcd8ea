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
/// The processes have settled once as many polls find the same handles ...
const UNCHANGED: u32 = 20;
/// ... or after this many polls.
const SETTLED: u32 = 400;
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
        // A client that is connected has memory and handles of its own.
        let Some(_held) = client.between_sentences() else {
            continue;
        };
        next_ns += options.every * SECOND;
        let resources = settled(&group)?;
        group.journal().write("sample", sample(&resources, view))?;
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

/// Waits until the processes have let go of a client that has left; returns their resources.
fn settled(group: &ProcessGroup) -> Result<Resources> {
    let mut last = Resources::read(group)?;
    let mut unchanged = 0;
    for _ in 0..SETTLED {
        std::thread::sleep(NAP);
        let now = Resources::read(group)?;
        unchanged = if now.handles() == last.handles() {
            unchanged + 1
        } else {
            0
        };
        last = now;
        if unchanged == UNCHANGED {
            break;
        }
    }
    Ok(last)
}

/// What the processes hold.
struct Resources {
    nodes: Vec<(Role, Held)>,
    files: usize,
    bytes: u64,
}

/// What a process holds.
struct Held {
    rss_kib: u64,
    threads: u64,
    handles: usize,
}

impl Resources {
    fn read(group: &ProcessGroup) -> Result<Self> {
        let held = |role| {
            let process = group.process(role).context("a process is missing")?;
            Ok((role, Held::read(process)?))
        };
        let nodes = PARTS.into_iter().map(held).collect::<Result<_>>()?;
        let (files, bytes) = group.shared()?;
        Ok(Self {
            nodes,
            files,
            bytes,
        })
    }

    /// Files in shared memory, and open files of all processes: each connection has its own.
    fn handles(&self) -> (usize, usize) {
        let open = self.nodes.iter().map(|(_, held)| held.handles).sum();
        (self.files, open)
    }
}

impl Held {
    /// From `/proc`.
    fn read(process: u32) -> Result<Self> {
        let folder = PathBuf::from(format!("/proc/{process}"));
        let status = std::fs::read_to_string(folder.join("status"))?;
        let number = |name: &str| -> Result<u64> {
            let line = status.lines().find_map(|line| line.strip_prefix(name));
            let word = line.and_then(|line| line.split_whitespace().next());
            Ok(word.context("/proc: status")?.parse()?)
        };
        Ok(Self {
            rss_kib: number("VmRSS:")?,
            threads: number("Threads:")?,
            handles: std::fs::read_dir(folder.join("fd"))?.count(),
        })
    }
}

/// A sample of the journal.
fn sample(resources: &Resources, view: &View) -> Value {
    let nodes: serde_json::Map<_, _> = resources
        .nodes
        .iter()
        .map(|(role, held)| {
            let held = json!({
                "rss_kib": held.rss_kib,
                "threads": held.threads,
                "handles": held.handles,
            });
            (role.word().to_owned(), held)
        })
        .collect();
    let scenes = &view.scenes;
    json!({
        "nodes": nodes,
        "shared": {"files": resources.files, "bytes": resources.bytes},
        "scenes": {
            "count": scenes.count,
            "lost": scenes.lost,
            "rate_hz": scenes.rate_hz,
            "latency_ns": scenes.latency_ns,
        },
    })
}
