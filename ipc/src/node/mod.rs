//! The processes of a robot that are written in Rust.
//!
//! Without the feature `processes` only what they make of received messages is here: [`see`],
//! [`Peer`] and [`View`].

#[cfg(feature = "processes")]
mod appearance_cache;
#[cfg(feature = "processes")]
mod client;
mod frame;
#[cfg(feature = "processes")]
mod heartbeats;
mod peer;
#[cfg(feature = "processes")]
mod perception;
#[cfg(feature = "processes")]
mod planner;
#[cfg(feature = "processes")]
mod rejected;
mod view;
#[cfg(feature = "processes")]
mod watcher;

#[cfg(feature = "processes")]
pub use client::{Client, Request, RequestError, Transport};
pub use frame::{FrameFault, see};
#[cfg(feature = "processes")]
pub use heartbeats::{HEARTBEAT_NS, Heartbeats};
pub use peer::Peer;
#[cfg(feature = "processes")]
pub use perception::PerceptionNode;
#[cfg(feature = "processes")]
pub use planner::{PlannerNode, PollStatus};
pub use view::{Flow, NodeView, View};
#[cfg(feature = "processes")]
pub use watcher::Watcher;
