//! The machine: one of its cores, and what kind it is.

use anyhow::{Context as _, Result};
use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};

/// Pins this process, and so all that it starts, to the last core that it may use; the core's number.
pub(crate) fn pin_to_one_core() -> Result<usize> {
    let allowed = sched_getaffinity(None).context("asking for the cores that may be used")?;
    let mut cores = (0..CpuSet::MAX_CPU).rev();
    let core = cores
        .find(|&core| allowed.is_set(core))
        .context("no core")?;
    let mut one = CpuSet::new();
    one.set(core);
    sched_setaffinity(None, &one).with_context(|| format!("staying on core {core}"))?;
    Ok(core)
}

/// The processor's model, and the number of cores.
pub(crate) fn kind() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let value = |line: &str, name: &str| {
        let (key, value) = line.split_once(':')?;
        (key.trim() == name).then(|| value.trim().to_owned())
    };
    let find = |name| text.lines().find_map(|line| value(line, name));
    let model = find("model name").unwrap_or_else(|| "unknown processor".to_owned());
    let flags = find("flags").unwrap_or_default();
    let cores = text
        .lines()
        .filter(|line| value(line, "processor").is_some())
        .count();
    let widest = ["avx512f", "avx2", "sse2"]
        .into_iter()
        .find(|wanted| flags.split(' ').any(|flag| flag == *wanted));
    let vectors = match widest {
        Some("avx512f") => ", with AVX-512",
        Some("avx2") => ", with AVX2",
        _ => "",
    };
    format!("{model}, {cores} cores{vectors}")
}
