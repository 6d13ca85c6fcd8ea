//! A controller over shared memory that executes commands instantly, by the rules of [`SubGoal`].

use iceoryx2::config::Config;
use nsrm_ipc::message::{Feedback, Heartbeat, Order, Outcome, Role, State, SubGoal, SubGoalError};
use nsrm_ipc::service::{Receiver, Robot, Sender};

use crate::isolated_memory::join;

/// A robot's controller.
#[derive(Debug)]
pub struct Controller {
    /// Its start time: another time means another controller.
    pub started_ns: u64,
    /// Whether it executes the commands that it accepts.
    pub works: bool,
    /// Executed commands.
    pub done: Vec<SubGoal>,
    /// How many commands arrived, executed or not.
    pub taken: u32,
    /// How many were invalid or too late.
    pub rejected: u64,
    commands: Receiver<SubGoal>,
    feedback: Sender<Feedback>,
    heartbeats: Sender<Heartbeat>,
    beats: u64,
    said: u64,
    /// The latest command, and the last outcome reported for it.
    last: Option<(SubGoal, Outcome)>,
    _robot: Robot,
}

impl Controller {
    /// Joins a robot as its controller.
    pub fn new(robot: &str, config: &Config) -> Self {
        let robot = join(robot, Role::Controller, config);
        Self {
            started_ns: 1,
            works: true,
            done: Vec::new(),
            taken: 0,
            rejected: 0,
            commands: robot.receiver().expect("a controller's place"),
            feedback: robot.sender().expect("a controller's place"),
            heartbeats: robot.sender().expect("a place for heartbeats"),
            beats: 0,
            said: 0,
            last: None,
            _robot: robot,
        }
    }

    /// The last outcome reported for the latest command.
    pub fn outcome(&self) -> Option<Outcome> {
        self.last.map(|(_, outcome)| outcome)
    }

    /// Sends heartbeats and executes commands.
    ///
    /// * `carry_out`: moves a command's object to its sub-goal
    pub fn turn(&mut self, now_ns: u64, mut carry_out: impl FnMut(&SubGoal)) {
        self.beats += 1;
        let heartbeat = Heartbeat {
            sequence: self.beats,
            timestamp_ns: now_ns,
            started_ns: self.started_ns,
            rejected: self.rejected,
            role: Role::Controller as u32,
            state: State::Idle as u32,
        };
        self.heartbeats.send(&heartbeat).expect("nobody must wait");
        let mut commands: Vec<_> = self.commands.waiting().map(|command| *command).collect();
        commands.sort_by_key(|command| command.read(now_ns) != Ok(Order::Stop));
        for command in commands {
            self.taken += 1;
            match command.read(now_ns) {
                Ok(order) => self.obey(&command, Some(order), now_ns, &mut carry_out),
                Err(error) => {
                    self.rejected += 1;
                    if matches!(error, SubGoalError::TooLate { .. }) {
                        self.obey(&command, None, now_ns, &mut carry_out);
                    }
                }
            }
        }
    }

    /// Obeys an order; `None` is a move that is too late.
    fn obey(
        &mut self,
        command: &SubGoal,
        order: Option<Order>,
        now_ns: u64,
        carry_out: &mut impl FnMut(&SubGoal),
    ) {
        let number = |command: &SubGoal| (command.plan, command.command);
        if let Some((last, outcome)) = self.last {
            if number(command) < number(&last) {
                return self.say(command, Outcome::Impossible, now_ns);
            }
            let is_under_way = outcome == Outcome::Accepted && order == Some(Order::Stop);
            if number(command) == number(&last) && !is_under_way {
                return self.say(command, outcome, now_ns);
            }
        }
        let outcome = match order {
            None => Outcome::TooLate,
            Some(Order::Stop) => Outcome::Stopped,
            Some(Order::Move { .. }) => {
                self.say(command, Outcome::Accepted, now_ns);
                if !self.works {
                    self.last = Some((*command, Outcome::Accepted));
                    return;
                }
                carry_out(command);
                self.done.push(*command);
                Outcome::Reached
            }
        };
        self.last = Some((*command, outcome));
        self.say(command, outcome, now_ns);
    }

    fn say(&mut self, command: &SubGoal, outcome: Outcome, now_ns: u64) {
        self.said += 1;
        let feedback = Feedback {
            plan: command.plan,
            sequence: self.said,
            timestamp_ns: now_ns,
            command: command.command,
            outcome: outcome as u32,
            objects: [0; 2],
        };
        self.feedback.send(&feedback).expect("nobody must wait");
    }
}
