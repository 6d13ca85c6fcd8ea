//! The firmware (`tests/firmware`) in an emulated controller: what it computed, and what that took.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, Result, bail, ensure};
use nsrm_core::nn::Precision;
use nsrm_core::{Plan, Planner, Refusal};
use object::{Object as _, ObjectSection as _, SectionFlags, SectionKind};

use crate::Table;
use crate::call_graph::CallGraph;

/// A processor, on a board that QEMU has.
#[derive(Debug, Clone, Copy)]
pub struct Processor {
    /// As in the written figures.
    pub name: &'static str,
    /// The target that its program is built for.
    pub target: &'static str,
    /// QEMU's name of the board.
    board: &'static str,
    /// Ticks of the timer for each instruction: 128 ns at the board's clock.
    ticks: f64,
}

/// All of them. A Cortex-M3 has no unit for floating-point numbers.
pub const PROCESSORS: [Processor; 4] = [
    Processor {
        name: "cortex-m3",
        target: "thumbv7m-none-eabi",
        board: "mps2-an385",
        ticks: 3.2,
    },
    Processor {
        name: "cortex-m4f",
        target: "thumbv7em-none-eabihf",
        board: "mps2-an386",
        ticks: 3.2,
    },
    Processor {
        name: "cortex-m7",
        target: "thumbv7em-none-eabihf",
        board: "mps2-an500",
        ticks: 3.2,
    },
    Processor {
        name: "cortex-m33",
        target: "thumbv8m.main-none-eabihf",
        board: "mps2-an505",
        ticks: 2.56,
    },
];

/// An image that was built for a target.
#[derive(Debug, Clone)]
pub struct Image {
    file: PathBuf,
    /// Whether it makes scenes from images.
    pub has_vision: bool,
    /// Of its model's weights.
    pub precision: Precision,
    /// The target.
    pub target: String,
}

impl Image {
    /// An image, of which the name is that of its target and of its features.
    pub fn open(file: &Path) -> Result<Self> {
        let name = file
            .file_stem()
            .context("an image's name")?
            .to_string_lossy();
        let named = PROCESSORS.iter().find_map(|processor| {
            let features = name.strip_prefix(processor.target)?;
            let features: Vec<_> = features.split('-').collect();
            Some((processor.target, features))
        });
        let (target, features) =
            named.with_context(|| format!("{} is of no known target", file.display()))?;
        Ok(Self {
            file: file.to_owned(),
            has_vision: features.contains(&"vision"),
            precision: if features.contains(&"int8") {
                Precision::Int8
            } else {
                Precision::F32
            },
            target: target.to_owned(),
        })
    }

    /// Bytes of flash and of RAM that it takes, without the stack.
    pub fn memory(&self) -> Result<(u64, u64)> {
        let bytes = fs::read(&self.file).with_context(|| format!("{}", self.file.display()))?;
        let parsed = object::File::parse(&*bytes)?;
        let (mut flash, mut ram) = (0, 0);
        for section in parsed.sections() {
            let SectionFlags::Elf { sh_flags } = section.flags() else {
                bail!("{}: not an ELF file", self.file.display());
            };
            if sh_flags & u64::from(object::elf::SHF_ALLOC) == 0 {
                continue;
            }
            let is_written = sh_flags & u64::from(object::elf::SHF_WRITE) != 0;
            // What is written at run time and begins as something else than zero is in both.
            if section.kind() != SectionKind::UninitializedData {
                flash += section.size();
            }
            if is_written {
                ram += section.size();
            }
        }
        Ok((flash, ram))
    }

    /// The most bytes of stack that beginning, polling and observing can take, whatever the input. An
    /// error if a function on the way calls itself or through a pointer.
    ///
    /// * `objdump`: the program `arm-none-eabi-objdump`
    pub fn stack_bound(&self, objdump: &Path) -> Result<u64> {
        let graph = CallGraph::of(objdump, &self.file)?;
        let mut bound = graph.stack("plan_begin")?.max(graph.stack("plan_poll")?);
        if self.has_vision {
            bound = bound.max(graph.stack("observe_poll")?);
        }
        Ok(bound)
    }

    /// Runs it on a processor with these sentences about the table.
    ///
    /// * `qemu`: the program
    pub fn run(
        &self,
        qemu: &Path,
        processor: &Processor,
        table: &Table,
        sentences: &[&str],
    ) -> Result<Run> {
        let folder = self.file.with_extension("run");
        fs::create_dir_all(&folder).with_context(|| format!("making {}", folder.display()))?;
        let input = table.firmware_input(self.has_vision, sentences);
        fs::write(folder.join("input.bin"), input).context("writing input.bin")?;
        let output = Command::new("timeout")
            .arg("300")
            .arg(qemu)
            .args(["-M", processor.board, "-nographic", "-monitor", "none"])
            .args(["-serial", "none", "-icount", "shift=7,sleep=off"])
            .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
            .arg(fs::canonicalize(&self.file)?)
            .current_dir(&folder)
            .stdin(std::process::Stdio::null())
            .output()
            .context("starting QEMU")?;
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr);
            bail!(
                "{} on {}: {text}{said}",
                self.file.display(),
                processor.name
            );
        }
        let run = Run {
            text,
            ticks: processor.ticks,
        };
        run.compare(table, sentences)
            .with_context(|| format!("{} on {}", self.file.display(), processor.name))?;
        Ok(run)
    }
}

/// What a run printed.
#[derive(Debug, Clone)]
pub struct Run {
    text: String,
    ticks: f64,
}

impl Run {
    /// Instructions of what a line counts in ticks, such as `plan` and `largest`; the nth line that
    /// begins so.
    pub fn instructions(&self, line: &str, number: usize, word: &str) -> Result<u64> {
        let ticks = self.number(line, number, word)? - self.number("nothing", 0, "ticks")?;
        Ok((ticks as f64 / self.ticks).round() as u64)
    }

    /// The most bytes of stack that any part took.
    pub fn stack(&self) -> Result<u64> {
        let lines = self.text.lines().filter(|line| line.starts_with("stack "));
        let numbers = lines.flat_map(|line| line.split(' ').filter_map(|word| word.parse().ok()));
        numbers.max().context("no stack was measured")
    }

    fn number(&self, begin: &str, number: usize, word: &str) -> Result<u64> {
        let mut lines = self.text.lines().filter(|line| line.starts_with(begin));
        let line = lines.nth(number).with_context(|| format!("no {begin}"))?;
        let mut words = line.split(' ').skip_while(|other| *other != word);
        let value = words.nth(1).with_context(|| format!("no {word}: {line}"))?;
        Ok(value.parse()?)
    }

    /// Fails unless all results are this machine's, bit by bit.
    fn compare(&self, table: &Table, sentences: &[&str]) -> Result<()> {
        let planner = Planner::new(table.model());
        let told = ["goal", "confidence", "refused"];
        let is_result = |line: &&str| {
            let first = line.split(' ').next().unwrap_or_default();
            told.contains(&first) || (line.len() == 8 && u32::from_str_radix(line, 16).is_ok())
        };
        let got: Vec<_> = self.text.lines().filter(is_result).collect();
        let mut expected = Vec::new();
        for sentence in sentences {
            expected.extend(lines(planner.plan(table.scene(), sentence)));
        }
        ensure!(
            got == expected,
            "the results are not this machine's: {got:?}, here {expected:?}"
        );
        Ok(())
    }
}

/// A result as the firmware prints it.
fn lines(result: Result<Plan, Refusal>) -> Vec<String> {
    let plan = match result {
        Ok(plan) => plan,
        Err(refusal) => return vec![format!("refused {}", refusal.kind())],
    };
    let mut lines = Vec::new();
    for goal in plan.sub_goals() {
        lines.push(format!("goal {}", goal.object));
        let pose = &goal.pose;
        let numbers = pose
            .translation
            .vector
            .iter()
            .chain(pose.rotation.coords.iter());
        lines.extend(numbers.map(|number| format!("{:08x}", number.to_bits())));
    }
    lines.push(format!("confidence {:08x}", plan.confidence().to_bits()));
    lines
}
