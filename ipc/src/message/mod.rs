//! The messages, one file per service; their memory layout is in `layout.rs`, the values of
//! enumerated fields in `numbers.rs`.

mod camera_frame;
mod checks;
mod feedback;
mod heartbeat;
pub(crate) mod layout;
mod numbers;
mod plan_reply;
mod plan_request;
mod scene;
mod step;
mod sub_goal;
mod text;

pub use camera_frame::{CameraFrame, CameraFrameError, DetectedBox, Frame};
pub use feedback::{Feedback, FeedbackError, Outcome, Report};
pub use heartbeat::{Heartbeat, HeartbeatError, Role, State};
pub use layout::{Element, Field, Message, Type};
pub use numbers::{Member, Numbers};
pub use plan_reply::{
    MAX_MESSAGE_BYTES, PlanReply, PlanReplyError, REASONS, Reply, ReplyTo, Status,
};
pub use plan_request::{Asked, PlanRequest, PlanRequestError, Purpose};
pub use scene::{CameraMessage, ObjectMessage, SceneMessage};
pub use step::{RelationMessage, StepMessage};
pub use sub_goal::{Kind, Order, SubGoal, SubGoalError};
