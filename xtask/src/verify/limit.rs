//! Waits for commands, with a time limit for silent ones: one test that hangs must not block the
//! other checks.

use std::fs;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail};

/// How long a command may print nothing. Not how long it may take: on a busy machine, that is a
/// multiple. The slowest is silent for five minutes on two idle cores, while it trains.
pub(super) const LIMIT: Duration = Duration::from_secs(25 * 60);

/// How long a silent command has, once what it started is aborted, to tell of it and end.
const LAST_WORDS: Duration = Duration::from_secs(20);

/// How often a running command is polled.
const NAP: Duration = Duration::from_millis(20);

/// Ticks a second of the times in `/proc`, on every Linux.
const TICKS: u64 = 100;

/// How a command ended.
#[derive(Debug)]
pub(super) struct Ended {
    pub(super) status: ExitStatus,
    /// Processor time of the command and of the descendants that were waited for.
    pub(super) processor: Duration,
}

/// Waits until a command has ended. If it is silent for too long, aborts its descendants, at which
/// Python prints where each of its threads was; then kills it.
///
/// * `printed`: how much it has printed so far
pub(super) fn wait(mut child: Child, limit: Duration, printed: impl Fn() -> u64) -> Result<Ended> {
    let (mut before, mut since) = (printed(), Instant::now());
    let mut processor = Duration::ZERO;
    loop {
        // Nobody can read it any more once the command has been waited for.
        processor = processor_time(child.id()).unwrap_or(processor);
        if let Some(status) = child.try_wait().context("waiting for a command")? {
            return Ok(Ended { status, processor });
        }
        let now = printed();
        if now != before {
            (before, since) = (now, Instant::now());
        } else if since.elapsed() > limit {
            end(&mut child)?;
            bail!(
                "printed nothing for {} min and was killed; the last lines of the log show where it was",
                limit.as_secs() / 60
            );
        }
        thread::sleep(NAP);
    }
}

/// The processor time of a process and of its descendants that were waited for (proc_pid_stat(5):
/// utime, stime, cutime and cstime).
fn processor_time(process: u32) -> Option<Duration> {
    let stat = fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // The second field, the program's name in parentheses, may contain anything.
    let (_, fields) = stat.rsplit_once(')')?;
    let ticks = fields.split_whitespace().skip(11).take(4);
    let ticks: u64 = ticks.filter_map(|field| field.parse::<u64>().ok()).sum();
    Some(Duration::from_millis(ticks * 1000 / TICKS))
}

/// Ends a silent command: aborts what it started, and kills it unless it then ends by itself.
fn end(child: &mut Child) -> Result<()> {
    let processes = stop(child.id());
    let descendants = processes.iter().skip(1);
    signal("-ABRT", descendants.clone());
    signal("-CONT", &processes);
    let since = Instant::now();
    while since.elapsed() < LAST_WORDS {
        if child.try_wait().context("waiting for a command")?.is_some() {
            break;
        }
        thread::sleep(NAP);
    }
    signal("-KILL", descendants);
    if child.try_wait().context("waiting for a command")?.is_none() {
        signal("-KILL", &stop(child.id()));
        child.wait().context("waiting for a command")?;
    }
    Ok(())
}

/// Stops a process and its descendants, and lists them. They share our process group, so that
/// Ctrl-C reaches them all; hence they are searched for one by one.
fn stop(process: u32) -> Vec<String> {
    let mut processes = vec![process.to_string()];
    let mut index = 0;
    while let Some(parent) = processes.get(index).cloned() {
        // A stopped process starts no more children while they are listed.
        signal("-STOP", [&parent]);
        processes.extend(children(&parent));
        index += 1;
    }
    processes
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
        let ended = wait(shell("exit 3"), LIMIT, || 0).unwrap();
        assert_eq!(ended.status.code(), Some(3));
    }

    #[test]
    fn what_prints_now_and_then_is_not_limited() {
        let printed = Cell::new(0);
        let status = wait(shell("sleep 0.2"), Duration::ZERO, || {
            printed.set(printed.get() + 1);
            printed.get()
        });
        assert!(status.unwrap().status.success());
    }

    #[test]
    fn the_processor_time_of_descendants_counts() {
        let busy = shell("(i=0; while [ $i -lt 300000 ]; do i=$((i + 1)); done); true");
        let ended = wait(busy, LIMIT, || 0).unwrap();
        assert!(ended.processor > Duration::ZERO);
        let idle = wait(shell("true"), LIMIT, || 0).unwrap();
        assert!(idle.processor < ended.processor);
    }

    #[test]
    fn what_hangs_can_tell_where_it_was() {
        let hanging = "trap 'echo here; exit 1' ABRT; echo begun; while :; do sleep 0.1; done";
        let mut child = shell(&format!("sh -c \"{hanging}\" & wait; echo ended"));
        let mut output = BufReader::new(child.stdout.take().unwrap());
        output.read_line(&mut String::new()).unwrap();
        wait(child, Duration::ZERO, || 0).unwrap_err();
        let mut said = String::new();
        output.read_to_string(&mut said).unwrap();
        assert_eq!(said, "here\nended\n");
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
