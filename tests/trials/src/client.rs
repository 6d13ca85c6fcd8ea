//! Clients, which send one sentence after the other, each with its own process.

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};
use std::thread::JoinHandle;
use std::time::Duration;

use anyhow::{Context as _, Result};
use serde_json::{Value, json};

use crate::journal::Journal;
use crate::process_group::ProcessGroup;
use crate::world::{REFUSED, SENTENCES};

/// Between two checks whether a process has ended.
const NAP: Duration = Duration::from_millis(1);
/// Between two sentences.
const PAUSE_MS: std::ops::Range<u64> = 1..40;
/// One in this many sentences is refused.
const REFUSED_OF: usize = 8;

/// Numbers of sentences, across all clients.
static NEXT: AtomicU64 = AtomicU64::new(1);

/// A client in a thread, which sends sentences until it is stopped.
#[derive(Debug)]
pub(crate) struct Client {
    current: Arc<Mutex<Option<Child>>>,
    /// Held while a sentence is sent and answered.
    sentence: Arc<Mutex<()>>,
    stop: Arc<AtomicBool>,
    thread: JoinHandle<Result<()>>,
}

impl Client {
    /// Starts.
    pub(crate) fn begin(group: &ProcessGroup, seed: u64) -> Result<Self> {
        let current = Arc::new(Mutex::new(None));
        let sentence = Arc::new(Mutex::new(()));
        let stop = Arc::new(AtomicBool::new(false));
        let journal = group.journal().also("client")?;
        let say = group.nsrm(&["say", "--json"]);
        let (shared, stopped) = (Arc::clone(&current), Arc::clone(&stop));
        let turn = Arc::clone(&sentence);
        let thread = std::thread::spawn(move || {
            let mut rng = fastrand::Rng::with_seed(seed);
            while !stopped.load(Ordering::Relaxed) {
                let sentence = if rng.usize(..REFUSED_OF) == 0 {
                    REFUSED[rng.usize(..REFUSED.len())]
                } else {
                    SENTENCES[rng.usize(..SENTENCES.len())]
                };
                let held = turn.lock().unwrap_or_else(PoisonError::into_inner);
                ask(&say, sentence, &journal, &shared)?;
                drop(held);
                std::thread::sleep(Duration::from_millis(rng.u64(PAUSE_MS)));
            }
            Ok(())
        });
        Ok(Self {
            current,
            sentence,
            stop,
            thread,
        })
    }

    /// Kills the current process of the client; returns it, if there is one.
    pub(crate) fn kill(&self, note: impl FnOnce(u32) -> Result<()>) -> Result<bool> {
        let mut current = self.current.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(child) = current.as_mut() else {
            return Ok(false);
        };
        note(child.id())?;
        child.kill()?;
        Ok(true)
    }

    /// Between two sentences: keeps the client there until what is returned is dropped. None while
    /// a sentence is sent and answered.
    pub(crate) fn between_sentences(&self) -> Option<MutexGuard<'_, ()>> {
        match self.sentence.try_lock() {
            Ok(held) => Some(held),
            Err(TryLockError::Poisoned(held)) => Some(held.into_inner()),
            Err(TryLockError::WouldBlock) => None,
        }
    }

    /// Lets its sentence end.
    pub(crate) fn end(self) -> Result<()> {
        self.stop.store(true, Ordering::Relaxed);
        let ended = self.thread.join();
        ended.unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    }
}

/// Sends a sentence and records its events; returns whether it was done.
pub(crate) fn ask_once(group: &ProcessGroup, sentence: &str) -> Result<bool> {
    let journal = group.journal().also("client")?;
    let say = group.nsrm(&["say", "--json"]);
    let code = ask(&say, sentence, &journal, &Mutex::new(None))?;
    Ok(code == Some(0))
}

fn ask(
    say: &Command,
    sentence: &str,
    journal: &Journal,
    current: &Mutex<Option<Child>>,
) -> Result<Option<i32>> {
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    journal.write("ask", json!({"ask": number, "sentence": sentence}))?;
    let mut command = Command::new(say.get_program());
    let mut child = command
        .args(say.get_args())
        .arg(sentence)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()?;
    let said = BufReader::new(child.stdout.take().context("no pipe")?);
    let mut errors = child.stderr.take().context("no pipe")?;
    let lock = || current.lock().unwrap_or_else(PoisonError::into_inner);
    *lock() = Some(child);
    for line in said.lines() {
        let line = line?;
        // A killed process may have written half of its last line.
        if let Ok(event) = serde_json::from_str::<Value>(&line) {
            journal.write("said", json!({"ask": number, "event": event}))?;
        }
    }
    let mut message = String::new();
    errors.read_to_string(&mut message)?;
    let status = loop {
        // Under the lock: a process that is waited for cannot be killed any more.
        let mut current = lock();
        let ended = match current.as_mut() {
            Some(child) => child.try_wait()?,
            None => None,
        };
        if let Some(status) = ended {
            *current = None;
            break status;
        }
        drop(current);
        std::thread::sleep(NAP);
    };
    let more = json!({"ask": number, "code": status.code(), "message": message.trim_end()});
    journal.write("answered", more)?;
    Ok(status.code())
}
