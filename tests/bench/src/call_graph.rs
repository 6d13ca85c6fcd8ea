//! Which function calls which in a program for Arm, and the stack that they take together: a bound
//! that no input exceeds, by the program's disassembly.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::path::Path;
use std::process::Command;

use anyhow::{Context as _, Result, bail};

/// A function's own part.
#[derive(Debug, Default)]
struct Function {
    calls: BTreeSet<String>,
    /// Calls through a pointer.
    indirect: usize,
    /// Bytes of stack: what it pushes and reserves.
    stack: u64,
}

/// A program's functions by name.
#[derive(Debug)]
pub struct CallGraph(BTreeMap<String, Function>);

/// Why no bound exists.
#[derive(Debug, PartialEq, Eq)]
pub enum Unbounded {
    /// A function calls itself, perhaps through others.
    Recursion(String),
    /// A function calls through a pointer.
    IndirectCall(String),
    /// The program has no such function.
    Missing(String),
}

impl fmt::Display for Unbounded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Recursion(name) => write!(f, "{name} calls itself"),
            Self::IndirectCall(name) => write!(f, "{name} calls through a pointer"),
            Self::Missing(name) => write!(f, "the program has no function {name}"),
        }
    }
}

impl std::error::Error for Unbounded {}

impl CallGraph {
    /// Of a program.
    ///
    /// * `objdump`: the program `arm-none-eabi-objdump`
    pub fn of(objdump: &Path, program: &Path) -> Result<Self> {
        let listed = Command::new(objdump)
            .args(["--disassemble", "--no-show-raw-insn"])
            .arg(program)
            .output()
            .with_context(|| format!("starting {}", objdump.display()))?;
        if !listed.status.success() {
            let said = String::from_utf8_lossy(&listed.stderr);
            bail!("{} {}: {said}", objdump.display(), program.display());
        }
        Self::parse(&String::from_utf8_lossy(&listed.stdout))
    }

    fn parse(listing: &str) -> Result<Self> {
        let mut functions = BTreeMap::<String, Function>::new();
        let mut current = String::new();
        for line in listing.lines() {
            if let Some((_, name)) = line.strip_suffix(">:").and_then(|l| l.split_once(" <")) {
                current = name.to_owned();
                functions.entry(current.clone()).or_default();
            } else if let Some((_, instruction)) = line.split_once(":\t")
                && let Some(function) = functions.get_mut(&current)
            {
                function
                    .add(instruction, &current)
                    .with_context(|| format!("in {current}: {instruction}"))?;
            }
        }
        Ok(Self(functions))
    }

    /// The most bytes of stack that a call of this function takes.
    pub fn stack(&self, function: &str) -> Result<u64, Unbounded> {
        self.deepest(function, &mut Vec::new(), &mut BTreeMap::new())
    }

    fn deepest<'a>(
        &'a self,
        name: &'a str,
        above: &mut Vec<&'a str>,
        known: &mut BTreeMap<&'a str, u64>,
    ) -> Result<u64, Unbounded> {
        if above.contains(&name) {
            return Err(Unbounded::Recursion(name.to_owned()));
        }
        if let Some(stack) = known.get(name) {
            return Ok(*stack);
        }
        let Some(function) = self.0.get(name) else {
            return Err(Unbounded::Missing(name.to_owned()));
        };
        if function.indirect > 0 {
            return Err(Unbounded::IndirectCall(name.to_owned()));
        }
        above.push(name);
        let mut below = 0;
        for called in &function.calls {
            below = below.max(self.deepest(called, above, known)?);
        }
        above.pop();
        let stack = function.stack + below;
        known.insert(name, stack);
        Ok(stack)
    }
}

impl Function {
    /// An instruction as objdump writes it: operation, a tab, operands.
    fn add(&mut self, instruction: &str, own: &str) -> Result<()> {
        let (operation, rest) = instruction.split_once('\t').unwrap_or((instruction, ""));
        let operands = rest.split(['@', ';']).next().unwrap_or_default().trim();
        match operation {
            "push" | "push.w" | "vpush" => self.stack += registers(operands)?,
            "stmdb" | "stmfd" if operands.starts_with("sp!,") => {
                self.stack += registers(operands)?;
            }
            "sub" | "sub.w" | "subw" if operands.starts_with("sp,") => {
                let (_, number) = operands.split_once('#').context("a frame of any size")?;
                self.stack += number.parse::<u64>()?;
            }
            "mov" | "mov.w" if operands.starts_with("sp,") => bail!("a frame of any size"),
            // The stack pointer moves as a register is written below it.
            _ if operands.contains("[sp, #-") && operands.ends_with("]!") => {
                let number = operands.split("#-").nth(1).unwrap_or_default();
                self.stack += number.trim_end_matches("]!").parse::<u64>()?;
            }
            "blx" | "bx" if operands != "lr" => self.indirect += 1,
            // Not `mov pc`: that is how a `match` jumps into a table of branches of its own function, which stand
            // behind it; pointers are called by `blx`, and at the end of a function by `bx`.
            "ldr.w" | "ldr" if operands.starts_with("pc,") => self.indirect += 1,
            _ => self.branch(operation, operands, own),
        }
        Ok(())
    }

    /// A jump to the start of another function is a call at the end of this one.
    fn branch(&mut self, operation: &str, operands: &str, own: &str) {
        let Some((_, name)) = operands.split_once('<') else {
            return;
        };
        let name = name.trim_end_matches('>');
        let calls = operation == "bl";
        let is_start = !name.contains("+0x");
        if operation.starts_with('b') && is_start && (calls || name != own) {
            self.calls.insert(name.to_owned());
        }
    }
}

/// Bytes of the registers in braces, each by its name or as a range.
fn registers(operands: &str) -> Result<u64> {
    let list = operands.split(['{', '}']).nth(1).context("no registers")?;
    let mut bytes = 0;
    for part in list.split(',').map(str::trim) {
        let size = if part.starts_with('d') { 8 } else { 4 };
        let number = |name: &str| name.trim_start_matches(['d', 'r', 's']).parse::<u64>();
        let count = match part.split_once('-') {
            Some((first, last)) => number(last)? - number(first)? + 1,
            None => 1,
        };
        bytes += size * count;
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LISTING: &str = "\
firmware:     file format elf32-littlearm

00000100 <outer>:
     100:\tpush\t{r4, r5, r6, r7, lr}
     102:\tstmdb\tsp!, {r8, r9, sl, fp}
     106:\tvpush\t{d8-d10}
     10a:\tsub.w\tsp, sp, #1008\t@ 0x3f0
     10e:\tbl\t200 <inner>
     112:\tbl\t300 <leaf>
     116:\tbne.n\t10e <outer+0xe>
     118:\tbx\tlr

00000200 <inner>:
     200:\tstr.w\tr8, [sp, #-4]!
     204:\tsub\tsp, #24
     205:\tmov\tpc, r3
     206:\tb.w\t300 <leaf>

00000300 <leaf>:
     300:\tpush\t{r7, lr}
     302:\tpop\t{r7, pc}

00000400 <odd>:
     400:\tbl\t500 <even>
     404:\tblx\tr3

00000500 <even>:
     500:\tbl\t600 <around>

00000600 <around>:
     600:\tbl\t500 <even>
";

    #[test]
    fn the_deepest_path_counts() {
        let graph = CallGraph::parse(LISTING).unwrap();
        assert_eq!(graph.stack("leaf"), Ok(8));
        assert_eq!(graph.stack("inner"), Ok(4 + 24 + 8));
        assert_eq!(graph.stack("outer"), Ok(20 + 16 + 24 + 1008 + 36));
    }

    #[test]
    fn what_has_no_bound_is_named() {
        let graph = CallGraph::parse(LISTING).unwrap();
        let pointer = Unbounded::IndirectCall("odd".into());
        assert_eq!(graph.stack("odd"), Err(pointer));
        let recursion = Unbounded::Recursion("even".into());
        assert_eq!(graph.stack("even"), Err(recursion));
        let missing = Unbounded::Missing("none".into());
        assert_eq!(graph.stack("none"), Err(missing));
        let frame = "00000100 <any>:\n     100:\tsub.w\tsp, sp, r4\n";
        assert!(CallGraph::parse(frame).is_err());
    }
}
