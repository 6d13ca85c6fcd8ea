//! The processes of one robot: started, killed and restarted.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::Duration;

use anyhow::{Context as _, Result, bail, ensure};
use nsrm_ipc::clock::now_ns;
use nsrm_ipc::executive::Limits;
use nsrm_ipc::message::Role;
use nsrm_ipc::node::Watcher;
use nsrm_ipc::service::{Robot, set_global_config};
use nsrm_tests::isolated_memory::IsolatedMemory;
use rustix::process::{Pid, Signal, kill_process};
use serde_json::json;

use crate::journal::Journal;

/// The robot of a trial.
pub(crate) const ROBOT: &str = "trial";
/// How long all processes may take to be ready, or to end; one that takes longer hangs, even on a
/// busy machine.
pub(crate) const PATIENCE_NS: u64 = 300_000_000_000;
/// Between two clean-ups of dead nodes at the end.
const BETWEEN_CLEANUPS: Duration = Duration::from_millis(100);
/// Between two polls.
const NAP: Duration = Duration::from_millis(2);

/// The processes that are started.
pub(crate) const PARTS: [Role; 4] = [
    Role::Camera,
    Role::Perception,
    Role::Planner,
    Role::Controller,
];

/// Name of a process's log file.
fn log(role: Role) -> String {
    format!("{}.log", role.word())
}

/// All processes of a robot except the clients.
#[derive(Debug)]
pub(crate) struct ProcessGroup {
    folder: PathBuf,
    nsrm: PathBuf,
    running: BTreeMap<&'static str, (Role, Child)>,
    journal: Journal,
    rng: fastrand::Rng,
    memory: IsolatedMemory,
}

impl ProcessGroup {
    /// A group without processes.
    ///
    /// * `folder`: where the journal and the logs are written; older ones are replaced
    /// * `nsrm`: the command
    pub(crate) fn new(folder: &Path, nsrm: &Path, seed: u64) -> Result<Self> {
        std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
        let memory = IsolatedMemory::new("trial");
        set_global_config(&memory.config)?;
        let journal = folder.join("journal.jsonl");
        for old in PARTS
            .map(log)
            .iter()
            .map(|log| folder.join(log))
            .chain([journal.clone()])
        {
            if let Err(error) = std::fs::remove_file(&old) {
                let is_new = error.kind() == std::io::ErrorKind::NotFound;
                ensure!(is_new, "{}: {error}", old.display());
            }
        }
        let configuration = format!("robot = \"{ROBOT}\"\n\n{}", memory.as_toml());
        std::fs::write(folder.join("robot.toml"), configuration)?;
        Ok(Self {
            journal: Journal::open(&journal, "trial")?,
            folder: std::path::absolute(folder)?,
            nsrm: nsrm.to_owned(),
            running: BTreeMap::new(),
            rng: fastrand::Rng::with_seed(seed),
            memory,
        })
    }

    pub(crate) const fn journal(&self) -> &Journal {
        &self.journal
    }

    /// Joins their robot.
    pub(crate) fn join(&self, role: Role) -> Result<Robot> {
        Ok(Robot::join(ROBOT.parse()?, role, &self.memory.config)?)
    }

    /// A command of `nsrm` for this robot.
    pub(crate) fn nsrm(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(&self.nsrm);
        command
            .args(arguments)
            .arg("--config")
            .arg(self.folder.join("robot.toml"))
            .stdin(Stdio::null());
        command
    }

    fn own(&self, part: &str) -> Result<Command> {
        let mut command = Command::new(std::env::current_exe()?);
        command.arg(part).args(["--robot", ROBOT]);
        command.arg("--root").arg(self.memory.root());
        command.args(["--prefix", self.memory.prefix()]);
        command
            .arg("--journal")
            .arg(self.folder.join("journal.jsonl"));
        command.stdin(Stdio::null());
        Ok(command)
    }

    /// Starts a process; its log goes to a file.
    pub(crate) fn start(&mut self, role: Role) -> Result<()> {
        let name = role.word();
        let mut command = match role {
            Role::Planner => self.nsrm(&["serve"]),
            Role::Perception => self.nsrm(&["perceive"]),
            Role::Camera => self.own("camera")?,
            _ => {
                let seed = self.rng.u64(..).to_string();
                let mut command = self.own("controller")?;
                command.args(["--seed", &seed]);
                command
            }
        };
        let log = self.folder.join(log(role));
        let log = File::options().append(true).create(true).open(log)?;
        let child = command.stdout(log.try_clone()?).stderr(log).spawn()?;
        let more = json!({"node": name, "process": child.id()});
        self.journal.write("started", more)?;
        self.running.insert(name, (role, child));
        Ok(())
    }

    /// Waits until heartbeats of all have arrived.
    pub(crate) fn ready(&mut self, watcher: &mut Watcher) -> Result<()> {
        let end_ns = now_ns() + PATIENCE_NS;
        loop {
            let now_ns = now_ns();
            let view = watcher.look(now_ns);
            let live = view.nodes.iter().flatten().filter(|node| {
                PARTS.contains(&node.role) && node.is_alive(Limits::default().silence_ns, now_ns)
            });
            if live.count() == PARTS.len() && view.scenes.count > 0 {
                return Ok(());
            }
            ensure!(
                now_ns < end_ns,
                "some processes sent no heartbeats: {view:?}"
            );
            if let Some((role, status)) = self.ended()?.first() {
                bail!("{} ended before it was ready: {status}", role.word());
            }
            std::thread::sleep(NAP);
        }
    }

    /// The process with a role, if it runs.
    pub(crate) fn process(&self, role: Role) -> Option<u32> {
        let (_, child) = self.running.get(role.word())?;
        Some(child.id())
    }

    /// The number of files that the processes share, in memory and in their folder, and the bytes
    /// of those in memory.
    pub(crate) fn shared(&self) -> Result<(usize, u64)> {
        let names = self.memory.left_behind();
        // Files that disappear meanwhile do not count.
        let bytes = names
            .iter()
            .filter_map(|name| std::fs::metadata(Path::new("/dev/shm").join(name)).ok())
            .map(|file| file.len())
            .sum();
        Ok((names.len(), bytes))
    }

    /// Kills a process, and waits until it has ended.
    pub(crate) fn kill(&mut self, role: Role) -> Result<()> {
        if let Some((_, mut child)) = self.running.remove(role.word()) {
            child.kill()?;
            child.wait()?;
        }
        Ok(())
    }

    /// Sends a process a signal.
    pub(crate) fn signal(&self, role: Role, signal: Signal) -> Result<()> {
        if let Some((_, child)) = self.running.get(role.word()) {
            kill_process(Pid::from_child(child), signal)?;
        }
        Ok(())
    }

    /// The processes that have ended on their own.
    pub(crate) fn ended(&mut self) -> Result<Vec<(Role, ExitStatus)>> {
        let mut ended = Vec::new();
        for (role, child) in self.running.values_mut() {
            if let Some(status) = child.try_wait()? {
                let more = json!({
                    "node": role.word(),
                    "process": child.id(),
                    "code": status.code(),
                });
                self.journal.write("ended", more)?;
                ended.push((*role, status));
            }
        }
        for (role, _) in &ended {
            self.running.remove(role.word());
        }
        Ok(ended)
    }

    /// Stops all processes; returns the files that they have left behind.
    pub(crate) fn stop(mut self) -> Result<()> {
        for (_, child) in self.running.values() {
            kill_process(Pid::from_child(child), Signal::TERM)?;
        }
        let end_ns = now_ns() + PATIENCE_NS;
        while !self.running.is_empty() {
            self.ended()?;
            ensure!(
                now_ns() < end_ns,
                "a process does not end: {:?}",
                self.running
            );
            std::thread::sleep(NAP);
        }
        // Cleans up dead nodes, as each node does at its start and afterwards.
        let left = loop {
            drop(self.join(Role::Watcher)?);
            let left = self.memory.left_behind();
            if left.is_empty() || now_ns() >= end_ns {
                break left;
            }
            std::thread::sleep(BETWEEN_CLEANUPS);
        };
        self.journal.write("left", json!({"names": left}))
    }
}

impl Drop for ProcessGroup {
    /// If a trial is aborted, no process keeps running and no file is left.
    fn drop(&mut self) {
        for (_, child) in self.running.values_mut() {
            let _ = child.kill();
            let _ = child.wait();
        }
        self.memory.clear();
    }
}
