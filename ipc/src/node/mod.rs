//! The processes of a robot that are written in Rust.

mod life;
mod perception;
mod planner;

pub use life::{HEARTBEAT_NS, Life, Peer, SILENCE_NS};
pub use perception::{FrameFault, PerceptionNode, see};
pub use planner::{Busyness, PlannerNode};
