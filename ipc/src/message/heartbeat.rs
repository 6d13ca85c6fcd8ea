//! Heartbeats: every node publishes them several times a second, so that others detect if it dies
//! or hangs.

#[cfg(feature = "processes")]
use iceoryx2::prelude::ZeroCopySend;
use thiserror::Error;

use super::layout::message;
use super::numbers::numbers;

message! {
    /// A heartbeat (service `heartbeat`).
    "nsrm.v1.Heartbeat.6f9d992f9581fe82"
    pub struct Heartbeat {
        /// Sequence number: increases with each heartbeat of one node.
        pub sequence: u64,
        /// When it was sent, nanoseconds on the sender's clock.
        pub timestamp_ns: u64,
        /// When the node was started: distinguishes it from a later one in its place.
        pub started_ns: u64,
        /// How many messages it has rejected since then, because they were invalid or too late.
        pub rejected: u64,
        /// The sender's role: the number of a [`Role`].
        pub role: u32,
        /// The sender's state: the number of a [`State`].
        pub state: u32,
    }
}

numbers! {
    /// The role of a node.
    "Heartbeat.role"
    pub enum Role {
        /// Publishes camera frames.
        Camera = 1,
        /// Turns frames into scenes.
        Perception = 2,
        /// Answers sentences with plans.
        Planner = 3,
        /// Executes sub-goals.
        Controller = 4,
        /// Sends sentences to the planner.
        Client = 5,
        /// Observes.
        Watcher = 6,
    }
}

impl Role {
    /// The name in lower case, as in a node's name.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Camera => "camera",
            Self::Perception => "perception",
            Self::Planner => "planner",
            Self::Controller => "controller",
            Self::Client => "client",
            Self::Watcher => "watcher",
        }
    }
}

numbers! {
    /// The state of a node.
    "Heartbeat.state"
    pub enum State {
        /// Not yet ready.
        Starting = 1,
        /// Ready and idle.
        Idle = 2,
        /// Working.
        Busy = 3,
        /// Alive, but unable to work; needs a person.
        Failed = 4,
    }
}

/// Why a heartbeat is invalid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum HeartbeatError {
    /// Unknown role.
    #[error("heartbeat: unknown role {0}")]
    Role(u32),
    /// Unknown state.
    #[error("heartbeat: unknown state {0}")]
    State(u32),
}

impl Heartbeat {
    /// The sender's role and state.
    ///
    /// ```
    /// use nsrm_ipc::message::{Heartbeat, Role, State};
    ///
    /// let heartbeat = Heartbeat {
    ///     role: Role::Planner as u32,
    ///     state: State::Idle as u32,
    ///     sequence: 1,
    ///     timestamp_ns: 6,
    ///     started_ns: 5,
    ///     rejected: 0,
    /// };
    /// assert_eq!(heartbeat.read(), Ok((Role::Planner, State::Idle)));
    /// ```
    pub fn read(&self) -> Result<(Role, State), HeartbeatError> {
        let role = Role::from_number(self.role).ok_or(HeartbeatError::Role(self.role))?;
        let state = State::from_number(self.state).ok_or(HeartbeatError::State(self.state))?;
        Ok((role, state))
    }
}

#[cfg(test)]
mod tests {
    use super::{Heartbeat, HeartbeatError, Role, State};

    fn heartbeat(role: u32, state: u32) -> Heartbeat {
        Heartbeat {
            sequence: 0,
            timestamp_ns: 0,
            started_ns: 0,
            rejected: 0,
            role,
            state,
        }
    }

    #[test]
    fn numbers_come_back_as_what_they_were_and_others_are_refused() {
        for role in Role::ALL {
            for state in State::ALL {
                assert_eq!(
                    heartbeat(role as u32, state as u32).read(),
                    Ok((role, state))
                );
            }
        }
        assert_eq!(heartbeat(0, 1).read(), Err(HeartbeatError::Role(0)));
        assert_eq!(heartbeat(7, 1).read(), Err(HeartbeatError::Role(7)));
        assert_eq!(heartbeat(1, 0).read(), Err(HeartbeatError::State(0)));
        assert_eq!(
            heartbeat(1, u32::MAX).read(),
            Err(HeartbeatError::State(u32::MAX))
        );
    }
}
