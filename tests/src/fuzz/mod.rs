//! The fuzz targets: for each untrusted input of the library, what is done with the bytes and what
//! must hold for the results.
//!
//! `tests/fuzz` passes these functions to libFuzzer; `tests/corpora.rs` runs them on the committed
//! inputs, on any toolchain. None of them may panic for any bytes; a panic is a finding.

mod bytes;
mod executive;
mod messages;
pub mod seeds;
mod text;

pub use executive::executive;
pub use messages::{camera_frame, feedback, heartbeat, plan_reply, plan_request, scene, sub_goal};
pub use text::{model_file, scene_file, sentence};

/// An untrusted input, and its function.
#[derive(Debug, Clone, Copy)]
pub struct Target {
    /// Its name: that of the program in `tests/fuzz/fuzz_targets` and of the folder in
    /// `tests/fuzz/corpus`.
    pub name: &'static str,
    /// What is done with the bytes.
    pub run: fn(&[u8]),
}

/// All untrusted inputs: the messages in the order in which data flows, the closed loop, then text
/// and files.
pub const TARGETS: [Target; 11] = [
    Target {
        name: "camera_frame",
        run: camera_frame,
    },
    Target {
        name: "scene",
        run: scene,
    },
    Target {
        name: "plan_request",
        run: plan_request,
    },
    Target {
        name: "plan_reply",
        run: plan_reply,
    },
    Target {
        name: "sub_goal",
        run: sub_goal,
    },
    Target {
        name: "feedback",
        run: feedback,
    },
    Target {
        name: "heartbeat",
        run: heartbeat,
    },
    Target {
        name: "executive",
        run: executive,
    },
    Target {
        name: "sentence",
        run: sentence,
    },
    Target {
        name: "scene_file",
        run: scene_file,
    },
    Target {
        name: "model_file",
        run: model_file,
    },
];

/// Checks that an error or a refusal has a message, of one line or more.
fn says(error: &impl std::fmt::Display) {
    assert!(!error.to_string().trim().is_empty());
}
