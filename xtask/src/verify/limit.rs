//! A time limit for commands: one test that hangs must not block the other checks.

use std::fs;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail};

/// How long a command may take; the slowest take a third of it on two cores.
pub(super) const LIMIT: Duration = Duration::from_secs(20 * 60);

/// How often a running command is polled.
const NAP: Duration = Duration::from_millis(20);

/// Waits until a command has ended; at the limit, kills it and its descendants.
pub(super) fn wait(mut child: Child, limit: Duration) -> Result<ExitStatus> {
    let start = Instant::now();
    loop {
        if let Some(status) = child.try_wait().context("waiting for a command")? {
            return Ok(status);
        }
        if start.elapsed() > limit {
            kill(child.id());
            child.wait().context("waiting for a command")?;
            bail!(
                "did not end within {} min and was killed; the last lines of the log show where it was",
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
        assert_eq!(wait(shell("exit 3"), LIMIT).unwrap().code(), Some(3));
    }

    #[test]
    fn what_does_not_end_is_killed_with_all_that_it_started() {
        let mut child = shell("(sh -c 'echo begun; sleep 1000; true'; true) & wait");
        let mut output = BufReader::new(child.stdout.take().unwrap());
        output.read_line(&mut String::new()).unwrap();
        let error = wait(child, Duration::ZERO).unwrap_err();
        assert!(error.to_string().contains("did not end within"));
        // Nobody holds the other end any more.
        assert_eq!(output.read_to_end(&mut Vec::new()).unwrap(), 0);
    }
}
