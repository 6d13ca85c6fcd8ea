//! Instructions, counted by valgrind's callgrind: the same number on every run, however noisy the
//! machine is.

use std::process::Command;

use anyhow::{Context as _, Result, bail, ensure};

/// The instructions that this program takes within a function, without those of its preparation.
///
/// * `function`: by its path
/// * `arguments`: with which the program calls it once
pub fn count(function: &str, arguments: &[&str]) -> Result<u64> {
    #[cfg(target_arch = "x86_64")]
    ensure!(
        std::arch::is_x86_feature_detected!("avx2"),
        "this processor lacks AVX2, with which the written instructions were counted"
    );
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(format!("--toggle-collect={function}"))
        .arg(std::env::current_exe()?)
        .args(arguments)
        .output()
        .context("starting valgrind, of the package valgrind")?;
    let text = String::from_utf8_lossy(&output.stderr);
    if !output.status.success() {
        bail!("valgrind: {text}");
    }
    let collected = text
        .lines()
        .find_map(|line| line.split_once("Collected : "));
    let (_, number) = collected.with_context(|| format!("valgrind counted nothing: {text}"))?;
    let number = number.trim().parse()?;
    ensure!(
        number > 0,
        "valgrind saw no call of {function} with {arguments:?}"
    );
    Ok(number)
}
