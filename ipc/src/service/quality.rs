use core::fmt::Debug;

use iceoryx2::prelude::ZeroCopySend;

use crate::message::{Feedback, Heartbeat, Message, PlanReply, PlanRequest, SceneMessage, SubGoal};

/// What a publish-subscribe service promises.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Quality {
    /// How many messages wait for a subscriber at most.
    pub buffer: usize,
    /// How many of the last ones a late subscriber gets.
    pub history: usize,
    /// Whether a full buffer loses its oldest message; otherwise sending fails.
    pub overflow: bool,
    /// How many may publish.
    pub publishers: usize,
    /// How many may subscribe.
    pub subscribers: usize,
}

/// Over how many hosts a robot's processes are spread.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Hosts {
    /// All are in one machine.
    #[default]
    One,
    /// A tunnel on each host carries what goes through the services. It has a publisher and a
    /// subscriber of its own at each, and makes those anew that only the other host has, all
    /// with the same promises: nothing for who comes late, and the oldest is lost, not the
    /// newest. A command that is lost so is not accepted, which its sender sees.
    Several,
}

impl Quality {
    /// What can be promised over so many hosts.
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

/// A message that has a publish-subscribe service of its own.
pub trait Carried: Message + ZeroCopySend + Debug + 'static {
    /// The end of the service's name.
    const SERVICE: &'static str;
    /// What it promises.
    const QUALITY: Quality;
}

/// How many may look on, beside those that a robot needs.
pub const ONLOOKERS: usize = 16;
/// Bytes of shared memory that must be left for a process to begin. All of a robot's
/// processes together were seen to take less than half of it, beside frames.
pub const ROOM: u64 = 1 << 20;
/// Frames that have memory at once with one reader: the one being written, the one that is
/// kept for who comes late, one that waits and one that is read.
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
/// What it promises; as [`Carried::QUALITY`], but a frame is a slice with a header.
pub const CAMERA_QUALITY: Quality = Quality {
    buffer: 1,
    history: 1,
    overflow: true,
    publishers: 1,
    subscribers: ONLOOKERS,
};

/// The service of requests and replies.
pub const PLAN: &str = "plan";
/// How many may ask at once; one is answered, the others are told that it is busy. Each has
/// a heartbeat, beside those of the robot's own nodes.
pub const CLIENTS: usize = 8;
/// How many replies wait for a client at most. Eight steps without a retry have 33 at most,
/// and each retry five more for each step that it goes back; who takes none of 160 does
/// not listen.
pub(super) const REPLIES: usize = 160;
