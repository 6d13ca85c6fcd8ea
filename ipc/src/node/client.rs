//! A client of the planner: sends a sentence and receives the events of its execution.

use core::fmt;

use iceoryx2::pending_response::PendingResponse;
use iceoryx2::prelude::*;
use thiserror::Error;

use super::heartbeats::Heartbeats;
use super::peer::Peer;
use crate::clock::now_ns;
use crate::executive::Mode;
use crate::message::{PlanReply, PlanRequest, PlanRequestError, Role, State};
use crate::service::{
    Notifier, PLAN, PlanClient, Receiver, Robot, RobotName, Sender, ServiceError,
};

/// Why a request was not sent, or gets no more replies.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum RequestError {
    /// The robot has no planner.
    #[error("robot `{0}` has no planner; start one: nsrm serve --robot {0}")]
    NoPlanner(RobotName),
    /// The planner died or hangs; the last command may have been executed.
    #[error("the planner of robot `{0}` died or hangs; check the robot, then restart the planner")]
    PlannerLost(RobotName),
    /// A reply is missing.
    #[error(
        "reply {number}, or the request, was lost; check the robot, then send the sentence again"
    )]
    ReplyLost {
        /// Which, from 1.
        number: u32,
    },
    /// The sentence cannot be sent.
    #[error("{0}")]
    Request(PlanRequestError),
    /// Any other error of iceoryx2.
    #[error("request: {0}; check that /dev/shm has free space, then send the sentence again")]
    Iceoryx(String),
}

impl RequestError {
    /// Its name, for programs. It is part of the interface; the message is not.
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

/// How long a planner may report that it is idle while a client waits for the end of its request,
/// nanoseconds: the longest round trip through two tunnels before all scenes are too old.
const IDLE_NS: u64 = 2_000_000_000;
/// How many replies one call searches for one that belongs to the request.
const REPLIES_AT_ONCE: usize = 64;

type Pending = PendingResponse<ipc::Service, PlanRequest, (), PlanReply, ()>;

/// The services over which a client sends requests to the planner.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Transport {
    /// `plan`: the planner detects at once when the client disconnects.
    #[default]
    Connection,
    /// `ask` and `answer`: for bridges that carry publish-subscribe only, such as a tunnel to
    /// another host. The planner does not detect when the client is gone.
    Broadcast,
}

/// The client side of the planner's services.
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

/// A sentence that was sent, until its last reply.
#[derive(Debug)]
pub struct Request {
    /// The connection, with [`Transport::Connection`].
    pending: Option<Pending>,
    sequence: u64,
    /// Number of the next reply.
    number: u32,
    began_ns: u64,
    /// Since when the planner has reported that it is idle.
    idle_ns: Option<u64>,
}

impl Client {
    /// Joins a robot as one of its clients.
    ///
    /// * `silence_ns`: how long the planner may be silent before it is considered dead
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
            // Two clients started in the same nanosecond are in different processes.
            client: now_ns ^ (u64::from(std::process::id()) << 40),
            sequence: 0,
            robot,
        })
    }

    /// Sends a sentence to the planner.
    ///
    /// ```no_run
    /// use iceoryx2::config::Config;
    /// use nsrm_ipc::clock::now_ns;
    /// use nsrm_ipc::executive::{Limits, Mode};
    /// use nsrm_ipc::message::{Reply, Role};
    /// use nsrm_ipc::node::{Client, Transport};
    /// use nsrm_ipc::service::Robot;
    ///
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let robot = Robot::join("left".parse()?, Role::Client, Config::global_config())?;
    /// let mut client = Client::begin(
    ///     robot,
    ///     Transport::Connection,
    ///     Limits::default().silence_ns,
    /// )?;
    /// let mut request = client.ask("put the red block on the blue block", Mode::ClosedLoop)?;
    /// loop {
    ///     // An error if the planner is lost.
    ///     let Some(reply) = client.poll(&mut request, now_ns())? else {
    ///         std::thread::sleep(std::time::Duration::from_millis(1));
    ///         continue;
    ///     };
    ///     match reply.read()? {
    ///         Reply::Done => break,
    ///         Reply::Failed { reason, message } => return Err(format!("{reason}: {message}").into()),
    ///         progress => println!("{progress:?}"),
    ///     }
    /// }
    /// # Ok(())
    /// # }
    /// ```
    pub fn ask(&mut self, sentence: &str, mode: Mode) -> Result<Request, RequestError> {
        self.sequence += 1;
        // Earlier heartbeats say nothing about this request, nor does a planner that died before.
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

    /// Cancels a request; it then ends with `cancelled`, once the robot has stopped.
    pub fn cancel(&mut self, request: &Request) -> Result<(), RequestError> {
        self.send(PlanRequest::cancel(self.client, request.sequence))
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

    /// The next reply to a request. Invalid replies are rejected; the loss is detected when the
    /// next one arrives.
    fn receive(
        &mut self,
        request: &Request,
        now_ns: u64,
    ) -> Result<Option<PlanReply>, RequestError> {
        let says = |error: &dyn fmt::Debug| RequestError::Iceoryx(format!("{error:?}"));
        for _ in 0..REPLIES_AT_ONCE {
            let reply = match (&self.ports, &request.pending) {
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
            // A client that reuses a dead client's slot in shared memory may get its replies, too.
            if let Err(error) = reply.read() {
                self.heartbeats.reject(PLAN, &error, now_ns);
            } else if (reply.client, reply.request) == (self.client, request.sequence) {
                return Ok(Some(reply));
            }
        }
        Ok(None)
    }

    /// How many invalid messages it has rejected: heartbeats and replies.
    pub const fn rejected(&self) -> u64 {
        self.heartbeats.rejected()
    }

    /// The next reply, if one has arrived; after the last one, an error. Its
    /// [`PlanReply::read`] can no longer fail.
    ///
    /// * `now_ns`: the time, on the machine's clock
    pub fn poll(
        &mut self,
        request: &mut Request,
        now_ns: u64,
    ) -> Result<Option<PlanReply>, RequestError> {
        // Times in the future come from a clock that was set back since.
        self.planner.not_after(now_ns);
        request.began_ns = request.began_ns.min(now_ns);
        request.idle_ns = request.idle_ns.map(|since_ns| since_ns.min(now_ns));
        let planner = &mut self.planner;
        let mut is_other = false;
        self.heartbeats.receive(now_ns, |role, state, heartbeat| {
            if role == Role::Planner {
                is_other |= planner.hear(heartbeat, now_ns);
                match state {
                    State::Idle => _ = request.idle_ns.get_or_insert(now_ns),
                    _ => request.idle_ns = None,
                }
            }
        });
        // It can receive even if nobody receives its heartbeats.
        let _ = self.heartbeats.beat(State::Busy, now_ns);
        // Checked first, since replies may arrive in between.
        let pending = request.pending.as_ref();
        let goes_on = pending.is_none_or(PendingResponse::is_connected);
        if let Some(reply) = self.receive(request, now_ns)? {
            let number = request.number;
            if reply.number != number {
                return Err(RequestError::ReplyLost { number });
            }
            request.number = number.saturating_add(1);
            request.idle_ns = None;
            return Ok(Some(reply));
        }
        // A planner that ends a request on its own sends a last reply.
        let (began_ns, silence_ns) = (request.began_ns, self.silence_ns);
        if !goes_on || is_other || !self.planner.may_be_alive(began_ns, silence_ns, now_ns) {
            return Err(RequestError::PlannerLost(self.robot.name().clone()));
        }
        // Without a connection, this is the only sign that the request, or its end, was lost.
        let idle_ns = request.idle_ns;
        if idle_ns.is_some_and(|since_ns| now_ns.saturating_sub(since_ns) > IDLE_NS) {
            let number = request.number;
            return Err(RequestError::ReplyLost { number });
        }
        Ok(None)
    }
}
