//! Kills and suspends processes at random times under load, and restarts them. The journal records
//! what happens; its reader judges it.

use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::Duration;

use anyhow::{Result, ensure};
use nsrm_ipc::clock::now_ns;
use nsrm_ipc::executive::Limits;
use nsrm_ipc::message::Role;
use nsrm_ipc::node::{NodeView, Watcher};
use rustix::process::Signal;
use serde_json::json;

use crate::client::{Client, ask_once};
use crate::parts::stop_on_signals;
use crate::process_group::{PARTS, PATIENCE_NS, ProcessGroup};
use crate::world::SENTENCES;

const MS: u64 = 1_000_000;
/// Between two polls of the observer.
const NAP: Duration = Duration::from_millis(1);
/// Time from one kill to the next, milliseconds.
const BETWEEN_MS: std::ops::Range<u64> = 30..500;
/// Time from a kill to the restart of the same process, milliseconds.
const GONE_MS: std::ops::Range<u64> = 0..700;
/// How long a process is suspended, milliseconds.
const HANG_MS: std::ops::Range<u64> = 600..1000;
/// One in this many is suspended for a while instead of killed.
const HANGS_OF: u64 = 6;
/// How many clients send requests at once; all but one are told that the planner is busy.
const CLIENTS: u64 = 2;

/// The command line.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// The command `nsrm`.
    #[arg(long)]
    nsrm: PathBuf,
    /// Folder for the journal and the logs of processes.
    #[arg(long)]
    out: PathBuf,
    /// How often a process is killed.
    #[arg(long, default_value_t = 1000)]
    kills: u32,
    /// Seed of all random choices.
    #[arg(long, default_value_t = 0)]
    seed: u64,
}

/// What a process of the group is doing.
#[derive(Debug, Clone, Copy)]
enum Fate {
    Lives,
    /// Restarted at that time, nanoseconds.
    Gone(u64),
    /// Continued at that time, nanoseconds.
    Hangs(u64),
}

/// A death or a hang that was not detected yet.
#[derive(Debug, Clone, Copy)]
struct Unnoticed {
    process: u32,
    since_ns: u64,
    /// When it was started, according to its heartbeats.
    started_ns: u64,
    /// How long the observer has been delayed since, nanoseconds.
    kept_ns: u64,
}

pub(crate) fn run(options: &Options) -> Result<()> {
    let stop = stop_on_signals()?;
    let mut group = ProcessGroup::new(&options.out, &options.nsrm, options.seed)?;
    let mut watcher = Watcher::begin(group.join(Role::Watcher)?)?;
    for role in PARTS {
        group.start(role)?;
    }
    group.ready(&mut watcher)?;
    let clients = (0..CLIENTS).map(|number| Client::begin(&group, options.seed ^ (number + 1)));
    let clients = clients.collect::<Result<Vec<_>>>()?;
    let mut chaos = Chaos {
        fates: [Fate::Lives; PARTS.len()],
        unnoticed: [None; PARTS.len()],
        looked_ns: now_ns(),
        rng: fastrand::Rng::with_seed(options.seed),
        group,
        watcher,
    };
    let mut kills = 0;
    let mut next_ns = now_ns();
    while kills < options.kills && !stop.load(Ordering::Relaxed) {
        std::thread::sleep(NAP);
        chaos.look()?;
        chaos.go_on()?;
        if now_ns() < next_ns {
            continue;
        }
        if chaos.strike(&clients)? {
            kills += 1;
            if kills % 50 == 0 {
                eprintln!("{kills} of {} kills", options.kills);
            }
        }
        next_ns = now_ns() + chaos.rng.u64(BETWEEN_MS) * MS;
    }
    chaos.recover()?;
    for client in clients {
        client.end()?;
    }
    let Chaos {
        mut group,
        mut watcher,
        ..
    } = chaos;
    group.ready(&mut watcher)?;
    let end_ns = now_ns() + PATIENCE_NS;
    let mut done = ask_once(&group, SENTENCES[0])?;
    while !done && now_ns() < end_ns && !stop.load(Ordering::Relaxed) {
        done = ask_once(&group, SENTENCES[0])?;
    }
    group.journal().write("recovered", json!({"done": done}))?;
    drop(watcher);
    group.stop()?;
    ensure!(kills == options.kills, "stopped after {kills} kills");
    Ok(())
}

struct Chaos {
    group: ProcessGroup,
    watcher: Watcher,
    fates: [Fate; PARTS.len()],
    unnoticed: [Option<Unnoticed>; PARTS.len()],
    looked_ns: u64,
    rng: fastrand::Rng,
}

impl Chaos {
    /// Records which deaths and hangs are detectable by now from heartbeats only.
    fn look(&mut self) -> Result<()> {
        let now_ns = now_ns();
        let kept_ns = (now_ns - self.looked_ns).saturating_sub(5 * MS);
        self.looked_ns = now_ns;
        let view = self.watcher.look(now_ns);
        let silence_ns = Limits::default().silence_ns;
        for (role, place) in PARTS.iter().zip(&mut self.unnoticed) {
            let Some(unnoticed) = place else {
                continue;
            };
            unnoticed.kept_ns += kept_ns;
            let Some(node) = seen(&view.nodes, *role) else {
                continue;
            };
            let how = if node.started_ns != unnoticed.started_ns {
                "another one"
            } else if now_ns.saturating_sub(node.heard_ns) > silence_ns {
                "silence"
            } else {
                continue;
            };
            let more = json!({
                "node": role.word(),
                "process": unnoticed.process,
                "how": how,
                "after_ns": now_ns - unnoticed.since_ns,
                "kept_ns": unnoticed.kept_ns,
            });
            *place = None;
            self.group.journal().write("noticed", more)?;
        }
        Ok(())
    }

    /// Restarts and continues processes that are due, and restarts those that ended on their own.
    fn go_on(&mut self) -> Result<()> {
        for (role, _) in self.group.ended()? {
            let (place, _) = place(role);
            self.fates[place] = Fate::Gone(now_ns() + 100 * MS);
        }
        for (place, role) in PARTS.into_iter().enumerate() {
            match self.fates[place] {
                Fate::Gone(until_ns) if now_ns() >= until_ns => self.group.start(role)?,
                // Not before its silence was detected: on a busy machine the observer may have been
                // delayed for all that time, and would never detect it.
                Fate::Hangs(until_ns)
                    if now_ns() >= until_ns && self.unnoticed[place].is_none() =>
                {
                    self.note("goes on", role)?;
                    self.group.signal(role, Signal::CONT)?;
                }
                _ => continue,
            }
            self.fates[place] = Fate::Lives;
        }
        Ok(())
    }

    /// Kills or suspends a live process; returns whether it was a kill.
    fn strike(&mut self, clients: &[Client]) -> Result<bool> {
        let choice = self.rng.usize(..PARTS.len() + clients.len());
        if let Some(client) = choice.checked_sub(PARTS.len()) {
            let journal = self.group.journal();
            return clients[client].kill(|process| {
                journal.write("kill", json!({"node": "client", "process": process}))
            });
        }
        let role = PARTS[choice];
        if !matches!(self.fates[choice], Fate::Lives) {
            return Ok(false);
        }
        let hangs = self.rng.u64(..HANGS_OF) == 0;
        let now_ns = now_ns();
        self.note(if hangs { "hang" } else { "kill" }, role)?;
        if hangs {
            self.group.signal(role, Signal::STOP)?;
            let until_ns = now_ns + self.rng.u64(HANG_MS) * MS;
            self.fates[choice] = Fate::Hangs(until_ns);
        }
        // Others cannot detect the loss of a process that they have not received yet, or whose loss
        // they have already detected.
        let view = self.watcher.look(now_ns);
        let silence_ns = Limits::default().silence_ns;
        self.unnoticed[choice] = seen(&view.nodes, role)
            .filter(|node| now_ns.saturating_sub(node.heard_ns) <= silence_ns)
            .filter(|_| self.unnoticed[choice].is_none())
            .zip(self.group.process(role))
            .map(|(node, process)| Unnoticed {
                process,
                since_ns: now_ns,
                started_ns: node.started_ns,
                kept_ns: 0,
            });
        if !hangs {
            self.group.kill(role)?;
            let until_ns = now_ns + self.rng.u64(GONE_MS) * MS;
            self.fates[choice] = Fate::Gone(until_ns);
        }
        Ok(!hangs)
    }

    fn note(&self, what: &str, role: Role) -> Result<()> {
        let process = self.group.process(role);
        let more = json!({"node": role.word(), "process": process});
        self.group.journal().write(what, more)
    }

    /// Lets all processes run.
    fn recover(&mut self) -> Result<()> {
        while self.fates.iter().any(|fate| !matches!(fate, Fate::Lives))
            || self.unnoticed.iter().any(Option::is_some)
        {
            std::thread::sleep(NAP);
            self.look()?;
            self.go_on()?;
        }
        Ok(())
    }
}

fn place(role: Role) -> (usize, Role) {
    let mut places = PARTS.into_iter().enumerate();
    places
        .find(|(_, part)| *part == role)
        .unwrap_or((0, PARTS[0]))
}

fn seen(nodes: &[Option<NodeView>], role: Role) -> Option<NodeView> {
    nodes
        .iter()
        .flatten()
        .find(|node| node.role == role)
        .copied()
}
