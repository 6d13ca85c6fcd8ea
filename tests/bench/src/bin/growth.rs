//! Counts how many instructions a plan takes with more objects, steps, tokens, words and concepts, and
//! writes `docs/performance/growth.csv`, or the file that is named.
//!
//! With an axis and a size, does that once, for callgrind.

use std::path::Path;

use anyhow::{Context as _, Result};
use nsrm_bench::callgrind;
use nsrm_bench::growth::{Axis, Subject};

const RESULTS: &str = "../../docs/performance/growth.csv";

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [name, size] = arguments.as_slice() {
        let axis = Axis::ALL.into_iter().find(|axis| axis.name() == name);
        let axis = axis.with_context(|| format!("unknown axis {name:?}"))?;
        Subject::new(axis, size.parse()?).run();
        return Ok(());
    }
    let mut text = String::from("axis,size,instructions\n");
    for axis in Axis::ALL {
        for size in axis.sizes() {
            let counted = callgrind::count(
                "nsrm_bench::growth::Subject::run",
                &[axis.name(), &size.to_string()],
            )?;
            let line = format!(
                "{},{},{counted}",
                axis.name(),
                Subject::new(axis, *size).size()
            );
            println!("{line}");
            text += &line;
            text.push('\n');
        }
    }
    let default = Path::new(env!("CARGO_MANIFEST_DIR")).join(RESULTS);
    let path = arguments.first().map_or(default, |name| name.into());
    std::fs::write(&path, text).with_context(|| format!("writing {}", path.display()))?;
    println!("figures: {}", path.display());
    Ok(())
}
