//! The processes of a robot that are written in Rust.

mod appearance_cache;
mod client;
mod heartbeats;
mod perception;
mod planner;
mod rejected;
mod watcher;

pub use client::{Client, Request, RequestError, Transport};
pub use heartbeats::{HEARTBEAT_NS, Heartbeats, Peer};
pub use perception::{FrameFault, PerceptionNode, see};
pub use planner::{PlannerNode, PollStatus};
pub use watcher::{Flow, NodeView, View, Watcher};
