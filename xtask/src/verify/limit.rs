//! A time limit for silent commands: one test that hangs must not block the other checks.

use std::fs;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail};

/// How long a command may print nothing. Not how long it may take: on a busy machine, that is a
/// multiple. The slowest is silent for seven minutes on two idle cores, while it trains.
pub(super) const LIMIT: Duration = Duration::from_secs(40 * 60);

/// How often a running command is polled.
const NAP: Duration = Duration::from_millis(20);

/// Waits until a command has ended; kills it and its descendants if it is silent for too long.
///
/// * `printed`: how much it has printed so far
pub(super) fn wait(
    mut child: Child,
    limit: Duration,
    printed: impl Fn() -> u64,
) -> Result<ExitStatus> {
    let (mut before, mut since) = (printed(), Instant::now());
    loop {
        if let Some(status) = child.try_wait().context("waiting for a command")? {
            return Ok(status);
        }
        let now = printed();
        if now != before {
            (before, since) = (now, Instant::now());
        } else if since.elapsed() > limit {
            kill(child.id());
            child.wait().context("waiting for a command")?;
            bail!(
                "printed nothing for {} min and was killed; the last lines of the log show where it was",
                limit.as_secs() / 60
            );
        }
        thread::sleep(NAP);
    }
}

/// Kills a process and its descendants. They share our process group, so that Ctrl-C reaches
/// them all; hence they are searched for one by one.
fn kill(process: u32) {
    let mut processes = vec![process.to_string()];
    let mut index = 0;
    while let Some(parent) = processes.get(index).cloned() {
        // A stopped process starts no more children while they are listed.
        signal("-STOP", [&parent]);
        processes.extend(children(&parent));
        index += 1;
    }
    signal("-KILL", &processes);
}

/// Sends a signal; not an error if the process has ended meanwhile.
fn signal<'a>(name: &str, processes: impl IntoIterator<Item = &'a String>) {
    let _ = Command::new("kill")
        .arg(name)
        .args(processes)
        .stderr(Stdio::null())
        .status();
}

/// The live children of a process's threads.
fn children(process: &str) -> Vec<String> {
    let threads = fs::read_dir(format!("/proc/{process}/task"));
    threads
        .into_iter()
        .flatten()
        .flatten()
        .filter_map(|thread| fs::read_to_string(thread.path().join("children")).ok())
        .flat_map(|list| list.split(' ').map(str::to_owned).collect::<Vec<_>>())
        .filter(|child| !child.is_empty())
        .collect()
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::io::{BufRead as _, BufReader, Read as _};
    use std::process::{Child, Command, Stdio};
    use std::time::Duration;

    use super::{LIMIT, wait};

    fn shell(script: &str) -> Child {
        Command::new("sh")
            .args(["-c", script])
            .stdout(Stdio::piped())
            .spawn()
            .unwrap()
    }

    #[test]
    fn what_ends_by_itself_is_waited_for() {
        assert_eq!(wait(shell("exit 3"), LIMIT, || 0).unwrap().code(), Some(3));
    }

    #[test]
    fn what_prints_now_and_then_is_not_limited() {
        let printed = Cell::new(0);
        let status = wait(shell("sleep 0.2"), Duration::ZERO, || {
            printed.set(printed.get() + 1);
            printed.get()
        });
        assert!(status.unwrap().success());
    }

    #[test]
    fn what_hangs_is_killed_with_all_that_it_started() {
        let mut child = shell("(sh -c 'echo begun; sleep 1000; true'; true) & wait");
        let mut output = BufReader::new(child.stdout.take().unwrap());
        output.read_line(&mut String::new()).unwrap();
        let error = wait(child, Duration::ZERO, || 0).unwrap_err();
        assert!(error.to_string().contains("printed nothing for"));
        // Nobody holds the other end any more.
        assert_eq!(output.read_to_end(&mut Vec::new()).unwrap(), 0);
    }
}
