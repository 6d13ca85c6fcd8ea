//! The messages that cross processes in shared memory, by iceoryx2.
//!
//! In the order in which data flows: [`CameraFrame`] (an image with its boxes) →
//! [`SceneMessage`] (what perception makes of it) → [`PlanRequest`] and
//! [`PlanReply`] (a sentence, and its sub-goals or refusal) → [`SubGoal`] (a
//! command) → [`Feedback`] (what came of it); and [`Heartbeat`] from everyone.
//!
//! A message is plain memory: `#[repr(C)]`, fixed size, no padding, no pointer,
//! no `bool`, no enum. **Anything may stand in a message that was received**: its
//! methods check and convert it into types whose values make sense, or say by a
//! typed error what is wrong. There is one error enum a message.
//!
//! iceoryx2 compares a message's type name and size between peers, but not the
//! order of its fields. So the type name carries the version of the schema and a
//! hash over name, kind, offset and size of every field ([`Message`]); the whole
//! layout stands in `layout.txt`, which tests compare with the structs.
//!
//! The nodes that send and receive them are not written yet.

mod camera_frame;
mod feedback;
mod heartbeat;
mod layout;
mod number;
mod plan;
mod scene;
mod sub_goal;
mod text;

pub use camera_frame::{CameraFrame, CameraFrameError, DetectedBox, Frame};
pub use feedback::{Feedback, FeedbackError, Outcome};
pub use heartbeat::{Heartbeat, HeartbeatError, Role, State};
pub use layout::{Element, Field, Message};
pub use plan::{
    MAX_KIND_BYTES, MAX_MESSAGE_BYTES, PlanReply, PlanReplyError, PlanRequest, PlanRequestError,
    PlanResult,
};
pub use scene::{CameraMessage, ObjectMessage, SceneMessage};
pub use sub_goal::{SubGoal, SubGoalError};
