use core::fmt::Debug;

use iceoryx2::prelude::ZeroCopySend;

use crate::message::{Feedback, Heartbeat, Message, PlanReply, PlanRequest, SceneMessage, SubGoal};

/// The guarantees of a publish-subscribe service.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Quality {
    /// The greatest number of messages that wait for a subscriber.
    pub buffer: usize,
    /// How many of the last messages a late subscriber gets.
    pub history: usize,
    /// Whether a full buffer drops its oldest message; otherwise sending fails.
    pub overflow: bool,
    /// The greatest number of publishers.
    pub publishers: usize,
    /// The greatest number of subscribers.
    pub subscribers: usize,
}

/// Whether a robot's processes run on one host or several.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Hosts {
    /// All run on one machine.
    #[default]
    One,
    /// A tunnel on each host forwards the services. It has its own publisher and subscriber at
    /// each, and creates those that only the other host has, all with the same guarantees: no
    /// history for late subscribers, and a full buffer drops the oldest message, not the newest. A
    /// command that is lost in this way is not accepted, which its sender detects.
    Several,
}

impl Quality {
    /// The guarantees that are possible with these hosts.
    pub const fn with_hosts(self, hosts: Hosts) -> Self {
        match hosts {
            Hosts::One => self,
            Hosts::Several => Self {
                buffer: self.buffer,
                history: 0,
                overflow: true,
                publishers: self.publishers + 1,
                subscribers: self.subscribers + 1,
            },
        }
    }
}

/// A message with its own publish-subscribe service.
pub trait Carried: Message + ZeroCopySend + Debug + 'static {
    /// The last part of the service's name.
    const SERVICE: &'static str;
    /// Its guarantees.
    const QUALITY: Quality;
}

/// The greatest number of observers, besides the processes that a robot needs.
pub const ONLOOKERS: usize = 16;
/// Bytes of shared memory that must be free when a process starts. All of a robot's processes
/// together were observed to take less than half of it, besides frames.
pub const ROOM: u64 = 1 << 20;
/// Frames in memory at once with one reader: the one being written, the history for late readers,
/// one that waits and one that is read.
pub const FRAMES_AT_ONCE: u64 = 4;

impl Carried for SceneMessage {
    const SERVICE: &'static str = "scene";
    const QUALITY: Quality = Quality {
        buffer: 1,
        history: 1,
        overflow: true,
        publishers: 1,
        subscribers: ONLOOKERS,
    };
}

impl Carried for SubGoal {
    const SERVICE: &'static str = "sub_goal";
    const QUALITY: Quality = Quality {
        buffer: 8,
        history: 0,
        overflow: false,
        publishers: 1,
        subscribers: 1,
    };
}

impl Carried for Feedback {
    const SERVICE: &'static str = "feedback";
    const QUALITY: Quality = Quality {
        buffer: 64,
        history: 0,
        overflow: true,
        publishers: 1,
        subscribers: ONLOOKERS,
    };
}

impl Carried for Heartbeat {
    const SERVICE: &'static str = "heartbeat";
    const QUALITY: Quality = Quality {
        buffer: 16,
        history: 0,
        overflow: true,
        publishers: ONLOOKERS,
        subscribers: ONLOOKERS,
    };
}

impl Carried for PlanRequest {
    const SERVICE: &'static str = "ask";
    const QUALITY: Quality = Quality {
        buffer: 8,
        history: 0,
        overflow: true,
        publishers: CLIENTS,
        subscribers: 1,
    };
}

impl Carried for PlanReply {
    const SERVICE: &'static str = "answer";
    const QUALITY: Quality = Quality {
        buffer: 64,
        history: 0,
        overflow: true,
        publishers: 1,
        subscribers: ONLOOKERS,
    };
}

/// The service of frames.
pub const CAMERA: &str = "camera";
/// Its guarantees; as [`Carried::QUALITY`], but a frame is a slice with a header.
pub const CAMERA_QUALITY: Quality = Quality {
    buffer: 1,
    history: 1,
    overflow: true,
    publishers: 1,
    subscribers: ONLOOKERS,
};

/// The service of requests and replies.
pub const PLAN: &str = "plan";
/// The greatest number of clients; one is served, the others are told that the planner is busy.
/// Each has a heartbeat, besides those of the robot's own nodes.
pub const CLIENTS: usize = 8;
/// The greatest number of replies that wait for a client. Eight steps without a retry have 33 at
/// most, and each retry five more for each step that it goes back; a client that reads none of 160
/// does not listen.
pub(super) const REPLIES: usize = 160;
