//! A robot's processes: messages in shared memory by iceoryx2, services, nodes, and the closed
//! loop.
//!
//! [`message`], in the order in which data flows: [`message::CameraFrame`] (an image with its
//! boxes) → [`message::SceneMessage`] (perception's result) → [`message::PlanRequest`] and
//! [`message::PlanReply`] (a sentence and the events of its execution) → [`message::SubGoal`] (a
//! command) → [`message::Feedback`] (its outcome); and [`message::Heartbeat`] from every node.
//!
//! [`executive`]: the closed loop, independent of any transport. [`bindings`]: the messages in C
//! and Python. [`service`]: the services between processes. [`node`]: the processes.
//!
//! A message is plain memory: `#[repr(C)]`, fixed size, no padding, no pointer, no `bool`, no enum.
//! **A received message may contain anything**: its methods check it and convert it into types that
//! are always valid, or return a typed error. Each message has one error enum.
//!
//! iceoryx2 compares a message's type name and size between peers, but not the order of its fields.
//! So the type name carries the version of the schema and a hash over name, kind, offset and size
//! of every field ([`message::Message`]); the whole layout is in `layout.txt`,
//! `include/nsrm_messages.h` and the harness's `messages.py`, which tests compare with the structs.
//!
//! Without the feature `processes` (on by default) the crate has only the messages, what nodes make
//! of them, and the executive, and does not depend on iceoryx2: for a closed loop within one
//! process.

#[cfg(feature = "processes")]
pub mod bindings;
#[cfg(feature = "processes")]
pub mod clock;
pub mod executive;
pub mod message;
pub mod node;
#[cfg(feature = "processes")]
pub mod service;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
mod readme {}
