//! `cargo verify`: runs every check and ends with a table. Three sequences run in parallel: checks
//! that compute on all processors, checks that leave one free, and, with a lower priority, one that
//! takes long.
//!
//! A check that fails or times out prints all of its output, and the others still run, so that one
//! run shows everything that is wrong. The output of a check is kept in
//! `target/verify/NAME.log`.

mod checks;
mod context;
mod count;
mod fuzz;
mod limit;
mod package;
mod report;
mod slow;
mod step;
mod system_packages;
mod tools;

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::Write;
use std::path::Path;
use std::process::{ExitCode, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail};

use crate::project::{Project, without_cargo_variables};
use crate::{BAD_INPUT, USAGE};
use checks::{CHECKS, Check, Lane};
use context::Context;
use count::Counts;
use limit::{Ended, LIMIT};
use report::{Outcome, Report};
use step::Step;

const HELP: &str = "\
usage: cargo verify [--quick] [--only NAME]... [--list] [--install]

Runs every check and ends with a table and the slowest tests.

  --quick       run what is needed before each commit: format, lints, quick tests, one demo;
                five minutes on two cores once everything is built
  --only NAME   run this check only; can be repeated
  --list        list the checks and what each proves
  --install     first install the system packages that the checks need; as root, on Debian and
                its derivatives

The output of each check is kept in target/verify/NAME.log.";

/// The command line.
#[derive(Debug, Default, PartialEq, Eq)]
struct Arguments {
    only: Vec<String>,
    quick: bool,
    list: bool,
    install: bool,
    help: bool,
}

impl Arguments {
    fn parse(words: &[OsString]) -> Result<Self> {
        let mut arguments = Self::default();
        let mut words = words.iter();
        while let Some(word) = words.next() {
            match word.to_str() {
                Some("--list") => arguments.list = true,
                Some("--quick") => arguments.quick = true,
                Some("--install") => arguments.install = true,
                Some("--help" | "-h") => arguments.help = true,
                Some("--only") => {
                    let Some(name) = words.next() else {
                        bail!("--only needs the name of a check (cargo verify --list)");
                    };
                    let name = name.to_string_lossy().into_owned();
                    if !CHECKS.iter().any(|check| check.name == name) {
                        bail!("unknown check {name:?} (cargo verify --list)");
                    }
                    arguments.only.push(name);
                }
                _ => bail!("unknown argument {word:?}\n{USAGE}"),
            }
        }
        Ok(arguments)
    }

    fn wants(&self, check: &Check) -> bool {
        let is_named = self.only.is_empty() || self.only.iter().any(|name| name == check.name);
        is_named && (!self.quick || check.quick.is_some())
    }
}

/// Runs the requested checks; fails if any of them fails.
pub(crate) fn run(words: &[OsString]) -> Result<ExitCode> {
    let arguments = match Arguments::parse(words) {
        Ok(arguments) => arguments,
        Err(error) => {
            eprintln!("error: {error}");
            return Ok(ExitCode::from(BAD_INPUT));
        }
    };
    if arguments.help {
        println!("{HELP}");
        return Ok(ExitCode::SUCCESS);
    }
    if arguments.list {
        for check in CHECKS {
            println!("{:<14} {}", check.name, check.title);
        }
        return Ok(ExitCode::SUCCESS);
    }
    let project = Project::find()?;
    system_packages::prepare(arguments.install)?;
    let logs = project.target().join("verify");
    fs::create_dir_all(&logs).with_context(|| format!("making {}", logs.display()))?;
    let run = Run {
        context: Context::new(project, logs),
        quick: arguments.quick,
        report: Mutex::default(),
    };
    let start = Instant::now();
    let wanted: Vec<_> = CHECKS
        .iter()
        .filter(|check| arguments.wants(check))
        .collect();
    if wanted.is_empty() {
        eprintln!("error: none of these checks runs with --quick (cargo verify --list)");
        return Ok(ExitCode::from(BAD_INPUT));
    }
    run.all(&wanted)?;
    let report = run.report.into_inner().unwrap_or_default();
    println!("\n{}", report.table(start.elapsed().as_secs_f32()));
    Ok(if report.passed() {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

/// State shared by the checks of a run.
struct Run {
    context: Context,
    quick: bool,
    report: Mutex<Report>,
}

impl Run {
    /// Runs all checks, each lane in its order. Those of the other lanes start only after all
    /// computing ones before them have ended.
    fn all(&self, checks: &[&'static Check]) -> Result<()> {
        thread::scope(|scope| {
            let lane = || {
                let (queue, own) = mpsc::channel::<&Check>();
                let work = move || own.into_iter().try_for_each(|check| self.one(check));
                (queue, scope.spawn(work))
            };
            let (waiting, of_waiting) = lane();
            let (long, of_long) = lane();
            for check in checks {
                // The receivers stay until the end, except after an error of ours, which is
                // reported below.
                match check.lane {
                    Lane::Computing => self.one(check)?,
                    Lane::Waiting => drop(waiting.send(check)),
                    Lane::Long => drop(long.send(check)),
                }
            }
            drop((waiting, long));
            [of_waiting, of_long].into_iter().try_for_each(|own| {
                own.join()
                    .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
            })
        })
    }

    fn one(&self, check: &'static Check) -> Result<()> {
        let Check {
            name, title, about, ..
        } = check;
        println!("\n== {name}: {title} (about {about})");
        let outcome = run_check(&self.context, check, self.quick)?;
        println!("   {name}: {}", outcome.line());
        if let Ok(mut report) = self.report.lock() {
            report.add(outcome);
        }
        Ok(())
    }
}

/// Runs one check. An `Err` is an error of ours (a log that cannot be written); a failure of the
/// check is in the outcome.
fn run_check(context: &Context, check: &Check, quick: bool) -> Result<Outcome> {
    let start = Instant::now();
    let log = context.logs().join(format!("{}.log", check.name));
    fs::write(&log, "").with_context(|| format!("writing {}", log.display()))?;
    let (mut counts, mut processor) = (Counts::default(), Duration::ZERO);
    let mut problem = None;
    let steps = if quick { check.quick } else { None };
    match steps.unwrap_or(check.steps)(context) {
        Ok(steps) => {
            for steps in steps.chunk_by(|one, next| one.beside && next.beside) {
                for result in run_steps(context, steps, &log)? {
                    match result {
                        Ok(done) => {
                            counts.add(done.counts);
                            processor += done.processor;
                        }
                        Err(error) => {
                            problem.get_or_insert(error);
                        }
                    }
                }
            }
        }
        Err(error) => problem = Some(error),
    }
    if let Some(error) = &problem {
        writeln!(append_to(&log)?, "error: {error:#}")?;
    }
    let failed = problem.is_some() || counts.failed > 0;
    if failed {
        print!("{}", fs::read_to_string(&log).unwrap_or_default());
        println!("   (log: {})", log.display());
    }
    if counts == Counts::default() || (failed && counts.failed == 0) {
        // A check without tests counts as one test.
        counts.add(Counts::one(!failed));
    }
    Ok(Outcome {
        name: check.name,
        failed,
        counts,
        seconds: start.elapsed().as_secs_f32(),
        processor: processor.as_secs_f32(),
        slow: slow::in_output(&fs::read_to_string(&log).unwrap_or_default()),
    })
}

/// How many steps run at the same time, of those that can.
const AT_ONCE: usize = 2;

/// A step that ran to its end.
struct Done {
    counts: Counts,
    processor: Duration,
}

/// Runs one step, or several in parallel. Parallel steps write their own logs, which are then
/// appended to the check's log in the order of the steps.
fn run_steps(context: &Context, steps: &[Step], log: &Path) -> Result<Vec<Result<Done>>> {
    if let [step] = steps {
        return Ok(vec![run_step(context, step, log)]);
    }
    let own_log = |index: usize| log.with_extension(format!("{index}.log"));
    for index in 0..steps.len() {
        let own_log = own_log(index);
        fs::write(&own_log, "").with_context(|| format!("writing {}", own_log.display()))?;
    }
    let next = AtomicUsize::new(0);
    let work = || {
        let mut results = Vec::new();
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(step) = steps.get(index) else {
                return results;
            };
            results.push((index, run_step(context, step, &own_log(index))));
        }
    };
    let mut results: Vec<_> = thread::scope(|scope| {
        let workers = [(); AT_ONCE].map(|()| scope.spawn(work));
        workers
            .into_iter()
            .flat_map(|worker| worker.join().unwrap_or_default())
            .collect()
    });
    results.sort_by_key(|(index, _)| *index);
    for (index, _) in &results {
        let own_log = own_log(*index);
        append_to(log)?.write_all(&fs::read(&own_log)?)?;
        fs::remove_file(&own_log)?;
    }
    if results.len() < steps.len() {
        bail!("a step did not run to completion");
    }
    Ok(results.into_iter().map(|(_, result)| result).collect())
}

/// Runs one command, writes its output to the log, and counts its tests.
fn run_step(context: &Context, step: &Step, log: &Path) -> Result<Done> {
    let shown = step.shown();
    let mut file = append_to(log)?;
    writeln!(file, "$ {shown}")?;
    let before = usize::try_from(file.metadata()?.len())?;
    let mut command = step.command();
    command
        .current_dir(context.project().root())
        .stdin(Stdio::null())
        .stdout(file.try_clone()?)
        .stderr(file);
    let child = without_cargo_variables(&mut command)
        .spawn()
        .with_context(|| format!("{shown}: cannot be started"))?;
    let printed = || fs::metadata(log).map_or(0, |file| file.len());
    let Ended { status, processor } =
        limit::wait(child, LIMIT, printed).with_context(|| shown.clone())?;
    let written = fs::read(log).with_context(|| format!("reading {}", log.display()))?;
    let printed = String::from_utf8_lossy(&written[before..]);
    let counts = step.tests.map_or(Ok(Counts::default()), |kind| {
        count::in_output(kind, &printed)
    });
    // Failed tests also make the status a failure; they are counted already.
    match counts {
        Ok(counts) if status.success() || counts.failed > 0 => Ok(Done { counts, processor }),
        Err(error) if status.success() => Err(error.context(shown)),
        _ => bail!("{shown}: failed ({status})"),
    }
}

fn append_to(log: &Path) -> Result<File> {
    File::options()
        .append(true)
        .open(log)
        .with_context(|| format!("writing {}", log.display()))
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;
    use std::sync::Mutex;

    use super::checks::Check;
    use super::context::Context;
    use super::step::Step;
    use super::{Arguments, CHECKS, Project, Report, Run};

    fn parse(words: &[&str]) -> anyhow::Result<Arguments> {
        Arguments::parse(&words.iter().map(Into::into).collect::<Vec<_>>())
    }

    #[test]
    fn what_is_not_a_check_is_refused() {
        assert!(parse(&["--only", "no-such-check"]).is_err());
        assert!(parse(&["--only"]).is_err());
        assert!(parse(&["format"]).is_err());
    }

    #[test]
    fn only_what_is_named_runs_and_without_names_everything() {
        let one = parse(&["--only", CHECKS[0].name, "--install"]).unwrap();
        assert!(one.install && one.wants(&CHECKS[0]) && !one.wants(&CHECKS[1]));
        assert!(parse(&["--help"]).unwrap().help);
        let quick = parse(&["--quick"]).unwrap();
        assert!(CHECKS.iter().any(|check| quick.wants(check)));
        assert!(!CHECKS.iter().all(|check| quick.wants(check)));
        let all = parse(&[]).unwrap();
        assert!(CHECKS.iter().all(|check| all.wants(check)));
    }

    fn mark(context: &Context) -> PathBuf {
        context.logs().join("mark")
    }

    /// Ends when the computing check after it has started.
    const WAITING: Check = Check::new("waiting", "", "", |context| {
        let script = "until [ -e \"$0\" ]; do sleep 0.01; done";
        Ok(vec![
            Step::new("sh", &["-c", script]).argument(mark(context)),
        ])
    })
    .waiting();
    const COMPUTING: Check = Check::new("computing", "", "", |context| {
        Ok(vec![Step::new("touch", &[]).argument(mark(context))])
    })
    .quick(|_| Ok(vec![Step::new("false", &[])]));

    fn run(quick: bool, checks: &[&'static Check]) -> Report {
        let project = Project::find().unwrap();
        let names: Vec<_> = checks.iter().map(|check| check.name).collect();
        let name = format!(
            "nsrm-verify-{}-{}-{quick}",
            std::process::id(),
            names.join("-")
        );
        let logs = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&logs).unwrap();
        let run = Run {
            context: Context::new(project, logs.clone()),
            quick,
            report: Mutex::default(),
        };
        run.all(checks).unwrap();
        std::fs::remove_dir_all(logs).unwrap();
        run.report.into_inner().unwrap()
    }

    #[test]
    fn what_waits_runs_beside_what_computes() {
        assert!(run(false, &[&WAITING, &COMPUTING]).passed());
    }

    /// Ends after the waiting check, which waits for the computing one.
    const LONG: Check = Check::new("long", "", "", |context| {
        let script = "until [ -e \"$0\" ]; do sleep 0.01; done";
        Ok(vec![
            Step::new("sh", &["-c", script]).argument(mark(context)),
        ])
    })
    .long();

    #[test]
    fn what_takes_long_runs_beside_both() {
        assert!(run(false, &[&LONG, &WAITING, &COMPUTING]).passed());
    }

    #[test]
    fn quick_runs_the_quick_steps() {
        assert!(!run(true, &[&COMPUTING]).passed());
    }
}
