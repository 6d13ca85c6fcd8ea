//! What is done with bytes from anywhere at each border of the library, and what must
//! hold of what comes out.
//!
//! `tests/fuzz` hands these functions to libFuzzer; `tests/corpora.rs` runs them on the
//! inputs that are committed, on any toolchain. None of them may panic, whatever the
//! bytes; a panic is a find.

mod bytes;
mod executive;
mod messages;
pub mod seeds;
mod text;

pub use executive::executive;
pub use messages::{camera_frame, feedback, heartbeat, plan_reply, plan_request, scene, sub_goal};
pub use text::{model_file, scene_file, sentence};

/// A border, and what is done there.
#[derive(Debug, Clone, Copy)]
pub struct Target {
    /// Its name: that of the program in `tests/fuzz/fuzz_targets` and of the folder in
    /// `tests/fuzz/corpus`.
    pub name: &'static str,
    /// What is done with the bytes.
    pub run: fn(&[u8]),
}

/// All borders: the messages in the order in which data flows, the loop between them,
/// then what people and files say.
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

/// An error or a refusal says something, in one line or several but never in none.
fn says(error: &impl std::fmt::Display) {
    assert!(!error.to_string().trim().is_empty());
}
