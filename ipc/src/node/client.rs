//! Who asks: a sentence in, what becomes of it out.

use core::fmt;

use iceoryx2::pending_response::PendingResponse;
use iceoryx2::prelude::*;

use super::heartbeats::{Heartbeats, Peer};
use crate::clock::now_ns;
use crate::executive::Mode;
use crate::message::{PlanReply, PlanRequest, PlanRequestError, Role, State};
use crate::service::{
    Notifier, PLAN, PlanClient, Receiver, Robot, RobotName, Sender, ServiceError,
};

/// Why nothing was asked, or nothing more will be heard.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum RequestError {
    /// No planner is there.
    NoPlanner(RobotName),
    /// The planner died or hangs; what was commanded may have been carried out.
    PlannerLost(RobotName),
    /// A reply is missing.
    ReplyLost {
        /// Which, from 1.
        number: u32,
    },
    /// The sentence can't be sent.
    Request(PlanRequestError),
    /// What iceoryx2 says.
    Iceoryx(String),
}

impl RequestError {
    /// Its name, for programs: part of the interface, as the message is not.
    pub const fn kind(&self) -> &'static str {
        match self {
            Self::NoPlanner(_) => "no_planner",
            Self::PlannerLost(_) => "planner_lost",
            Self::ReplyLost { .. } => "reply_lost",
            Self::Request(_) => "bad_request",
            Self::Iceoryx(_) => "iceoryx",
        }
    }
}

impl fmt::Display for RequestError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoPlanner(robot) => write!(
                f,
                "robot `{robot}` has no planner; start one: nsrm serve --robot {robot}"
            ),
            Self::PlannerLost(robot) => write!(
                f,
                "the planner of robot `{robot}` died or hangs; look at the robot, then start the \
                 planner anew"
            ),
            Self::ReplyLost { number } => write!(
                f,
                "reply {number} was lost, or what was asked; look at the robot, then ask again"
            ),
            Self::Request(error) => write!(f, "{error}"),
            Self::Iceoryx(says) => write!(
                f,
                "asking: {says}; see that there is room in /dev/shm, then ask again"
            ),
        }
    }
}

impl core::error::Error for RequestError {}

/// How long a planner may say that it is idle while an end is waited for, nanoseconds: so long
/// two tunnels at most take there and back before all its scenes are too old.
const IDLE_NS: u64 = 2_000_000_000;
/// How many replies are looked through at once for one that belongs to a conversation.
const REPLIES_AT_ONCE: usize = 64;

type Pending = PendingResponse<ipc::Service, PlanRequest, (), PlanReply, ()>;

/// By which services a planner is asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Transport {
    /// `plan`: the planner notices at once when who asked is gone.
    #[default]
    Connection,
    /// `ask` and `answer`: goes through what carries publish-subscribe alone, such as a
    /// tunnel to another host. The planner does not notice when who asked is gone.
    Broadcast,
}

/// A person's end.
#[derive(Debug)]
pub struct Client {
    robot: Robot,
    ports: Ports,
    heartbeats: Heartbeats,
    planner: Peer,
    silence_ns: u64,
    client: u64,
    sequence: u64,
}

#[derive(Debug)]
enum Ports {
    Connection {
        client: PlanClient,
        notifier: Notifier,
    },
    Broadcast {
        ask: Sender<PlanRequest>,
        answers: Receiver<PlanReply>,
    },
}

/// A sentence that was asked, until its last reply.
#[derive(Debug)]
pub struct Request {
    /// The connection, if there is one.
    pending: Option<Pending>,
    sequence: u64,
    /// Of the next reply.
    number: u32,
    began_ns: u64,
    /// Since when the planner says that it is idle.
    idle_ns: Option<u64>,
}

impl Client {
    /// Takes one of the clients' places at a robot.
    ///
    /// * `silence_ns`: how long the planner may be silent before it is held to be dead
    pub fn begin(
        robot: Robot,
        transport: Transport,
        silence_ns: u64,
    ) -> Result<Self, ServiceError> {
        let now_ns = now_ns();
        Ok(Self {
            ports: match transport {
                Transport::Connection => Ports::Connection {
                    client: robot.plan_client()?,
                    notifier: robot.notifier(PLAN)?,
                },
                Transport::Broadcast => Ports::Broadcast {
                    ask: robot.sender()?,
                    answers: robot.receiver()?,
                },
            },
            heartbeats: Heartbeats::begin(&robot, Role::Client, now_ns)?,
            planner: Peer::default(),
            silence_ns,
            // Two clients begun in the same nanosecond have different processes.
            client: now_ns ^ (u64::from(std::process::id()) << 40),
            sequence: 0,
            robot,
        })
    }

    /// Asks for a sentence to be followed.
    pub fn ask(&mut self, sentence: &str, mode: Mode) -> Result<Request, RequestError> {
        self.sequence += 1;
        // What was heard before is no word on this one, nor is a planner that died before.
        self.heartbeats.receive(now_ns(), |_, _, _| {});
        self.planner = Peer::default();
        let request = PlanRequest::new(self.client, self.sequence, mode, sentence);
        let pending = self.send(request.map_err(RequestError::Request)?)?;
        Ok(Request {
            pending,
            sequence: self.sequence,
            number: 1,
            began_ns: now_ns(),
            idle_ns: None,
        })
    }

    /// Asks for it to be followed no longer; the conversation then ends with
    /// `cancelled`, once the robot has stopped.
    pub fn cancel(&mut self, conversation: &Request) -> Result<(), RequestError> {
        self.send(PlanRequest::cancel(self.client, conversation.sequence))
            .map(|_| ())
    }

    fn send(&self, request: PlanRequest) -> Result<Option<Pending>, RequestError> {
        let (pending, hearers) = match &self.ports {
            Ports::Connection { client, notifier } => {
                let sent = client.send_copy(request);
                let pending = sent.map_err(|error| RequestError::Iceoryx(format!("{error:?}")))?;
                notifier.notify();
                let hearers = pending.number_of_server_connections();
                (Some(pending), hearers)
            }
            Ports::Broadcast { ask, .. } => {
                let sent = ask.send(&request);
                let hearers = sent.map_err(|failure| RequestError::Iceoryx(failure.to_string()))?;
                (None, hearers)
            }
        };
        if hearers == 0 {
            return Err(RequestError::NoPlanner(self.robot.name().clone()));
        }
        Ok(pending)
    }

    /// What was said next in a conversation. What makes no sense is passed over, and
    /// missed when the next one comes.
    fn receive(
        &mut self,
        conversation: &Request,
        now_ns: u64,
    ) -> Result<Option<PlanReply>, RequestError> {
        let says = |error: &dyn fmt::Debug| RequestError::Iceoryx(format!("{error:?}"));
        for _ in 0..REPLIES_AT_ONCE {
            let reply = match (&self.ports, &conversation.pending) {
                (Ports::Broadcast { answers, .. }, _) => {
                    let reply = answers.receive().map_err(|error| says(&error))?;
                    reply.map(|reply| *reply)
                }
                (_, Some(pending)) => {
                    let reply = pending.receive().map_err(|error| says(&error))?;
                    reply.map(|reply| *reply)
                }
                (_, None) => None,
            };
            let Some(reply) = reply else {
                return Ok(None);
            };
            // Who takes a dead client's place in shared memory may get its replies, too.
            if let Err(error) = reply.read() {
                self.heartbeats.reject(PLAN, &error, now_ns);
            } else if (reply.client, reply.request) == (self.client, conversation.sequence) {
                return Ok(Some(reply));
            }
        }
        Ok(None)
    }

    /// How many messages it has passed over: heartbeats and replies that make no sense.
    pub const fn rejected(&self) -> u64 {
        self.heartbeats.rejected()
    }

    /// The next reply, if there is one now; after the last one, an error. Its
    /// [`PlanReply::read`] has been tried and does not fail.
    ///
    /// * `now_ns`: the time, on the machine's clock
    pub fn hear(
        &mut self,
        conversation: &mut Request,
        now_ns: u64,
    ) -> Result<Option<PlanReply>, RequestError> {
        // What was counted from a later time was so on a clock that was set back since.
        self.planner.not_after(now_ns);
        conversation.began_ns = conversation.began_ns.min(now_ns);
        conversation.idle_ns = conversation.idle_ns.map(|since_ns| since_ns.min(now_ns));
        let planner = &mut self.planner;
        let mut is_other = false;
        self.heartbeats.receive(now_ns, |role, state, heartbeat| {
            if role == Role::Planner {
                is_other |= planner.hear(heartbeat, now_ns);
                match state {
                    State::Idle => _ = conversation.idle_ns.get_or_insert(now_ns),
                    _ => conversation.idle_ns = None,
                }
            }
        });
        // Not being heard by anyone does not keep it from hearing.
        let _ = self.heartbeats.beat(State::Busy, now_ns);
        // Asked first, since replies may come in between.
        let pending = conversation.pending.as_ref();
        let goes_on = pending.is_none_or(PendingResponse::is_connected);
        if let Some(reply) = self.receive(conversation, now_ns)? {
            let number = conversation.number;
            if reply.number != number {
                return Err(RequestError::ReplyLost { number });
            }
            conversation.number = number.saturating_add(1);
            conversation.idle_ns = None;
            return Ok(Some(reply));
        }
        // One that ends a conversation of its own will has a last word.
        let (began_ns, silence_ns) = (conversation.began_ns, self.silence_ns);
        if !goes_on || is_other || !self.planner.may_be_alive(began_ns, silence_ns, now_ns) {
            return Err(RequestError::PlannerLost(self.robot.name().clone()));
        }
        // Without a connection nothing else tells that what was asked, or its end, was lost.
        let idle_ns = conversation.idle_ns;
        if idle_ns.is_some_and(|since_ns| now_ns.saturating_sub(since_ns) > IDLE_NS) {
            let number = conversation.number;
            return Err(RequestError::ReplyLost { number });
        }
        Ok(None)
    }
}
