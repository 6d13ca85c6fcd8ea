//! If shared memory is small, for instance in a container, a process refuses to start; otherwise
//! the system would kill it without a message later.
#![cfg(feature = "command")]

// Some of it is for other tests.
#[allow(dead_code)]
mod common;

use std::process::{Command, Output};

use common::stage::{CONFIG, SENTENCE};
use common::{Bench, refused};
use nsrm_tests::isolated_memory::IsolatedMemory;

#[test]
#[ignore = "needs root, to mount memory of its own; run by cargo verify"]
fn too_little_shared_memory_is_refused() {
    let memory = IsolatedMemory::new("small-memory");
    let bench = Bench::new();
    bench.write("robot.toml", format!("{CONFIG}{}", memory.as_toml()));
    for arguments in [
        &["say", SENTENCE][..],
        &["watch", "--once"],
        &["perceive"],
        &["serve"],
    ] {
        let ended = with_memory(&bench, 512, arguments);
        let wants = "robot `left`: `node` needs 1.0 MB of shared memory, but 0.5 are left in \
                     /dev/shm; remove unused files there, or enlarge it";
        refused(&ended, &[wants]);
    }
    // With a little more memory it works as usual.
    let ended = with_memory(&bench, 2048, &["say", SENTENCE]);
    refused(&ended, &["robot `left` has no planner"]);
}

/// Runs the command with its own shared memory of this many KiB.
fn with_memory(bench: &Bench, kib: u32, arguments: &[&str]) -> Output {
    let mount = format!("mount -t tmpfs -o size={kib}k none /dev/shm && exec \"$@\"");
    Command::new("unshare")
        .args(["--mount", "--propagation=private", "sh", "-c", &mount, "sh"])
        .arg(env!("CARGO_BIN_EXE_nsrm"))
        .args(arguments)
        .args(["--config", "robot.toml"])
        .current_dir(bench.folder.path())
        .output()
        .unwrap()
}
