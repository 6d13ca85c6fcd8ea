//! `compare.csv` and `README.md`.

use std::fs;
use std::path::Path;

use anyhow::{Context as _, Result};
use nsrm_compare::TOLERANCE;

use super::machine;
use super::rounds::Rounds;
use super::table::Table;

/// All that is written about a measurement.
#[derive(Debug)]
pub(crate) struct Report {
    pub(crate) table: Table,
    /// Of each contender, in the table's order.
    pub(crate) versions: Vec<String>,
    pub(crate) rounds: Rounds,
}

impl Report {
    /// Writes both files into a folder.
    pub(crate) fn write(&self, folder: &Path) -> Result<()> {
        for (name, text) in [
            ("compare.csv", self.table.csv()),
            ("README.md", self.text()),
        ] {
            let path = folder.join(name);
            fs::write(&path, text).with_context(|| format!("writing {}", path.display()))?;
        }
        Ok(())
    }

    fn text(&self) -> String {
        let named = self.table.contenders.iter().zip(&self.versions);
        let contenders: String = named
            .map(|(name, version)| {
                let how = about(name);
                format!("| `{name}` | {version} | {how} |\n")
            })
            .collect();
        let Rounds {
            blocks,
            runs,
            warm_up,
        } = self.rounds;
        let total = blocks * runs;
        let machine = machine::kind();
        let table = self.table.markdown();
        let line = self.table.against(super::RIVAL, super::OURS);
        let line = line.map_or_else(String::new, |line| format!("`{line}`\n\n"));
        let head = include_str!("report/head.md");
        let tail = include_str!("report/tail.md");
        let tail = tail.replace("TOLERANCE", &format!("{TOLERANCE:e}"));
        format!(
            "{head}\n{line}Measured on: {machine}.\n{total} runs of each, in {blocks} blocks of {runs}; \
             {warm_up} more at the start of each block do not count.\n\n\
             ![p50 and p99 of each job and contender](compare.png)\n\n{table}\n\
             ## Contenders\n\n| contender | version | how it runs |\n|---|---|---|\n{contenders}\n{tail}"
        )
    }
}

/// How a contender runs.
fn about(contender: &str) -> &'static str {
    match contender {
        "empty" => "an empty loop with the same clock: the machine's own noise",
        "nsrm" => {
            "as users of the crate `nsrm` have it: AVX2 is chosen at run time; no compiler flags"
        }
        "nsrm-plain" => "`nsrm-core` without that choice: SSE2; no compiler flags",
        "onnxruntime" => {
            "the library of PyPI's wheel; one thread, all graph optimisations, inputs and outputs bound to memory"
        }
        "tract" => {
            "the same graphs, optimised, `crops` without `ReduceMax`, which is slow in it; a new state for each run"
        }
        "candle" => "written by hand with its tensors; weights are transposed beforehand",
        "onnxruntime-python" => {
            "the same library and options, `InferenceSession.run` with NumPy arrays"
        }
        "jax" => {
            "`jit` of the trainer's own model; inputs are on the device, until the result is ready"
        }
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_report_names_contenders_machine_and_direction() {
        let report = Report {
            table: Table {
                contenders: vec!["empty", "nsrm"],
                measured: Vec::new(),
                missing: Vec::new(),
            },
            versions: vec!["no version".to_owned(), "nsrm 0".to_owned()],
            rounds: Rounds::QUICK,
        };
        let text = report.text();
        assert!(text.contains("| `nsrm` | nsrm 0 | as users"), "{text}");
        assert!(text.contains("2500 runs of each, in 25 blocks of 100"));
        assert!(text.contains("above 1, `nsrm` is faster"));
        assert!(!text.contains("TOLERANCE"));
    }
}
