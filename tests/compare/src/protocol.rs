//! A contender's side: lines on its standard input, lines on its standard output.
//!
//! | the driver writes | the contender answers |
//! |---|---|
//! | (nothing: it has started the contender) | `ready VERSION` |
//! | `outputs JOB` | `output NAME NUMBER …` for each output, then `end`; or `missing REASON` |
//! | `time JOB RUNS` | `times NANOSECONDS …`, one for each run |
//!
//! It ends when its input ends. What it cannot do is written to its standard error, and it exits.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::io::{BufRead, Write};
use std::path::Path;
use std::time::Instant;

use anyhow::{Context as _, Result, bail};

use crate::{Inputs, Job, Outputs};

/// What computes the jobs.
pub trait Contender {
    /// Its version and those of what it is made of.
    fn version(&self) -> String;

    /// Gets a job ready: everything that a program does once.
    fn prepare(&mut self, job: Job, inputs: &Inputs) -> Result<Prepared>;
}

/// A job that is ready, or why it will never be.
pub enum Prepared {
    /// Ready to be run.
    Ready(Box<dyn Work>),
    /// The contender cannot express the job; the reason.
    Missing(String),
}

/// A job of a contender.
pub trait Work {
    /// Does it once; this is timed.
    fn run(&mut self) -> Result<()>;

    /// What it gives.
    fn outputs(&mut self) -> Result<Outputs>;
}

/// Answers the driver until its lines end. The only argument of a contender's program is the folder with
/// the inputs, the graphs and the model file.
pub fn serve<C: Contender>(make: impl FnOnce(&Path) -> Result<C>) -> Result<()> {
    let folder = std::env::args_os().nth(1).context(
        "the folder with the inputs is missing: this program is started by `cargo compare`",
    )?;
    let folder = Path::new(&folder);
    let inputs = Inputs::read(&folder.join("inputs.safetensors"))?;
    let contender = make(folder)?;
    answer(
        contender,
        &inputs,
        std::io::stdin().lock(),
        std::io::stdout().lock(),
    )
}

fn answer(
    mut contender: impl Contender,
    inputs: &Inputs,
    lines: impl BufRead,
    mut answers: impl Write,
) -> Result<()> {
    writeln!(answers, "ready {}", contender.version())?;
    answers.flush()?;
    let mut prepared: HashMap<Job, Prepared> = HashMap::new();
    for line in lines.lines() {
        let line = line?;
        let words: Vec<&str> = line.split_whitespace().collect();
        let (job, runs) = match words[..] {
            ["outputs", job] => (job.parse()?, None),
            ["time", job, runs] => (job.parse()?, Some(runs.parse::<usize>()?)),
            _ => bail!("unknown request {line:?}"),
        };
        let prepared = match prepared.entry(job) {
            Entry::Occupied(entry) => entry.into_mut(),
            Entry::Vacant(entry) => {
                let ready = contender.prepare(job, inputs);
                entry.insert(ready.with_context(|| format!("preparing {job}"))?)
            }
        };
        let text = match (prepared, runs) {
            (Prepared::Ready(work), None) => written(&work.outputs()?),
            (Prepared::Ready(work), Some(runs)) => timed(work.as_mut(), runs)?,
            (Prepared::Missing(reason), None) => format!("missing {reason}\n"),
            (Prepared::Missing(_), Some(_)) => bail!("{job} cannot be timed"),
        };
        answers.write_all(text.as_bytes())?;
        answers.flush()?;
    }
    Ok(())
}

fn written(outputs: &Outputs) -> String {
    let mut text = String::new();
    for (name, numbers) in outputs.iter() {
        text += &format!("output {name}");
        for number in numbers {
            text += &format!(" {number}");
        }
        text.push('\n');
    }
    text + "end\n"
}

fn timed(work: &mut dyn Work, runs: usize) -> Result<String> {
    let mut times = Vec::with_capacity(runs);
    for _ in 0..runs {
        let start = Instant::now();
        let done = work.run();
        times.push(start.elapsed().as_nanos());
        done?;
    }
    let mut text = String::from("times");
    for time in times {
        text += &format!(" {time}");
    }
    text.push('\n');
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Table;

    struct Halves;

    impl Contender for Halves {
        fn version(&self) -> String {
            "halves 1".to_owned()
        }

        fn prepare(&mut self, job: Job, _inputs: &Inputs) -> Result<Prepared> {
            Ok(match job {
                Job::Simulator => Prepared::Ready(Box::new(Self)),
                _ => Prepared::Missing("too hard".to_owned()),
            })
        }
    }

    impl Work for Halves {
        fn run(&mut self) -> Result<()> {
            Ok(())
        }

        fn outputs(&mut self) -> Result<Outputs> {
            Ok(Outputs::default().with("location", vec![0.5, -1.0]))
        }
    }

    fn answers(lines: &str) -> (Result<()>, String) {
        let inputs = Inputs::new(&Table::new().unwrap()).unwrap();
        let mut written = Vec::new();
        let result = answer(Halves, &inputs, lines.as_bytes(), &mut written);
        (result, String::from_utf8(written).unwrap())
    }

    #[test]
    fn each_line_is_answered() {
        let (result, text) = answers("outputs simulator\noutputs plan\ntime simulator 3\n");
        result.unwrap();
        let lines: Vec<&str> = text.lines().collect();
        let [ready, location, end, missing, times] = lines[..] else {
            panic!("{text}");
        };
        assert_eq!(
            (ready, location),
            ("ready halves 1", "output location 0.5 -1")
        );
        assert_eq!((end, missing), ("end", "missing too hard"));
        assert_eq!(times.split(' ').count(), 4);
    }

    #[test]
    fn unknown_lines_end_it() {
        for line in ["sing", "outputs song", "time simulator many", "time plan 3"] {
            assert!(answers(line).0.is_err(), "{line}");
        }
    }
}
