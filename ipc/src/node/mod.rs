//! The processes of a robot that are written in Rust.

mod asker;
mod life;
mod looks;
mod perception;
mod planner;
mod rejected;
mod watcher;

pub use asker::{AskError, Asker, Conversation, Line};
pub use life::{HEARTBEAT_NS, Life, Peer};
pub use perception::{FrameFault, PerceptionNode, see};
pub use planner::{Busyness, PlannerNode};
pub use watcher::{Flow, NodeView, View, Watcher};
