//! The messages that cross processes in shared memory, by iceoryx2.
//!
//! [`message`], in the order in which data flows: [`message::CameraFrame`] (an image
//! with its boxes) → [`message::SceneMessage`] (what perception makes of it) →
//! [`message::PlanRequest`] and [`message::PlanReply`] (a sentence, and what becomes
//! of it) → [`message::SubGoal`] (a command) → [`message::Feedback`] (what came of
//! it); and [`message::Heartbeat`] from everyone.
//!
//! [`executive`]: the loop between them, without any transport. [`bindings`]: the
//! messages in C and Python. [`service`]: where processes meet. [`node`]:
//! the processes.
//!
//! A message is plain memory: `#[repr(C)]`, fixed size, no padding, no pointer,
//! no `bool`, no enum. **Anything may stand in a message that was received**: its
//! methods check and convert it into types whose values make sense, or say by a
//! typed error what is wrong. There is one error enum a message.
//!
//! iceoryx2 compares a message's type name and size between peers, but not the
//! order of its fields. So the type name carries the version of the schema and a
//! hash over name, kind, offset and size of every field ([`message::Message`]); the whole
//! layout stands in `layout.txt`, `include/nsrm_messages.h` and the harness's
//! `messages.py`, which tests compare with the structs.
//!
//! Without the feature `processes` (on by default) there are messages and executive alone, and
//! iceoryx2 is not built: for a closed loop within one process.

#[cfg(feature = "processes")]
pub mod bindings;
#[cfg(feature = "processes")]
pub mod clock;
pub mod executive;
pub mod message;
#[cfg(feature = "processes")]
pub mod node;
#[cfg(feature = "processes")]
pub mod service;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
mod readme {}
