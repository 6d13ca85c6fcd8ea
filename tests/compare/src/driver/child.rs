//! A contender's process.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{ChildStdin, ChildStdout, Command, Stdio};

use anyhow::{Context as _, Result, bail};
use nsrm_compare::{Job, Outputs};

/// A kind of contender.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Kind {
    /// Its name in tables.
    pub(crate) name: &'static str,
    program: Program,
}

#[derive(Debug, Clone, Copy)]
enum Program {
    /// One of ours, `contender-NAME`.
    Rust,
    /// A module of the harness.
    Python(&'static str),
}

/// All contenders, in the order of tables.
pub(crate) const KINDS: [Kind; 8] = [
    Kind::rust("empty"),
    Kind::rust("nsrm"),
    Kind::rust("nsrm-plain"),
    Kind::rust("onnxruntime"),
    Kind::rust("tract"),
    Kind::rust("candle"),
    Kind::python("onnxruntime-python", "onnxruntime_contender"),
    Kind::python("jax", "jax_contender"),
];

impl Kind {
    const fn rust(name: &'static str) -> Self {
        Self {
            name,
            program: Program::Rust,
        }
    }

    const fn python(name: &'static str, module: &'static str) -> Self {
        Self {
            name,
            program: Program::Python(module),
        }
    }
}

/// Where the contenders' programs and files are.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Programs<'a> {
    pub(crate) folder: &'a Path,
    pub(crate) programs: &'a Path,
    pub(crate) python: &'a Path,
    pub(crate) library: &'a Path,
}

impl Programs<'_> {
    fn command(&self, kind: Kind) -> Command {
        let mut command = match kind.program {
            Program::Rust => {
                let name = format!("contender-{}", kind.name);
                Command::new(self.programs.join(name))
            }
            Program::Python(module) => {
                let mut command = Command::new(self.python);
                let module = format!("nsrm_harness.learning.comparison.{module}");
                command.args(["-m", &module]);
                command
            }
        };
        command
            .arg(self.folder)
            .env("ORT_DYLIB_PATH", self.library)
            // candle's and gemm's pool.
            .env("RAYON_NUM_THREADS", "1")
            .env("JAX_PLATFORMS", "cpu");
        command
    }
}

/// A running contender. It ends when it is dropped, with its input.
#[derive(Debug)]
pub(crate) struct Child {
    name: &'static str,
    version: String,
    process: std::process::Child,
    requests: Option<ChildStdin>,
    answers: BufReader<ChildStdout>,
}

impl Child {
    /// Starts a contender and waits until it is ready.
    pub(crate) fn start(kind: Kind, programs: &Programs<'_>) -> Result<Self> {
        let mut command = programs.command(kind);
        let mut process = command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .with_context(|| {
                let program = command.get_program().to_string_lossy();
                format!("cannot start {} ({program})", kind.name)
            })?;
        let requests = process.stdin.take();
        let answers = process.stdout.take().context("no standard output")?;
        let mut child = Self {
            name: kind.name,
            version: String::new(),
            process,
            requests,
            answers: BufReader::new(answers),
        };
        let ready = child.line()?;
        let Some(version) = ready.strip_prefix("ready ") else {
            bail!("{}: expected \"ready\", got {ready:?}", kind.name);
        };
        child.version = version.to_owned();
        Ok(child)
    }

    /// Its name.
    pub(crate) fn name(&self) -> &'static str {
        self.name
    }

    /// What it says about its version.
    pub(crate) fn version(&self) -> String {
        self.version.clone()
    }

    /// Whether it computes anything.
    pub(crate) fn computes(&self) -> bool {
        self.name != "empty"
    }

    /// What it computes, or why it cannot express the job.
    pub(crate) fn outputs(&mut self, job: Job) -> Result<Result<Outputs, String>> {
        self.ask(&format!("outputs {job}"))?;
        let mut outputs = Outputs::default();
        loop {
            let line = self.line()?;
            if let Some(reason) = line.strip_prefix("missing ") {
                return Ok(Err(reason.to_owned()));
            }
            if line == "end" {
                return Ok(Ok(outputs));
            }
            let mut words = line.split(' ');
            let (Some("output"), Some(name)) = (words.next(), words.next()) else {
                bail!("{}: expected outputs, got {line:?}", self.name);
            };
            let numbers = words.map(str::parse).collect::<Result<_, _>>();
            let numbers = numbers.with_context(|| format!("{}: {name} of {job}", self.name))?;
            outputs = outputs.with(name, numbers);
        }
    }

    /// Does a job some times; the nanoseconds of each.
    pub(crate) fn time(&mut self, job: Job, runs: usize) -> Result<Vec<u64>> {
        self.ask(&format!("time {job} {runs}"))?;
        let line = self.line()?;
        let times = line.strip_prefix("times ").map(|times| times.split(' '));
        let Some(times) = times else {
            bail!("{}: expected times, got {line:?}", self.name);
        };
        let times: Vec<u64> = times
            .map(str::parse)
            .collect::<Result<_, _>>()
            .with_context(|| format!("{}: times of {job}", self.name))?;
        if times.len() != runs {
            bail!("{}: {} times for {runs} runs", self.name, times.len());
        }
        Ok(times)
    }

    fn ask(&mut self, request: &str) -> Result<()> {
        let requests = self.requests.as_mut().context("no standard input")?;
        let asked = writeln!(requests, "{request}").and_then(|()| requests.flush());
        asked.with_context(|| format!("{} has ended; its message is above", self.name))
    }

    fn line(&mut self) -> Result<String> {
        let mut line = String::new();
        if self.answers.read_line(&mut line)? == 0 {
            let status = self.process.wait()?;
            bail!("{} has ended ({status}); its message is above", self.name);
        }
        Ok(line.trim_end().to_owned())
    }
}

impl Drop for Child {
    fn drop(&mut self) {
        // Without input it ends by itself.
        drop(self.requests.take());
        let _ = self.process.wait();
    }
}
