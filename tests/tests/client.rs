//! A client, with a planner that belongs to the test: it gives replies that no planner should
//! give, or replies to a client that is dead.

use nsrm_core::RawScene;
use nsrm_ipc::clock::now_ns;
use nsrm_ipc::executive::{Limits, Mode};
use nsrm_ipc::message::{
    PlanReply, PlanRequest, Reply, ReplyTo, Role, SceneMessage, State, SubGoal,
};
use nsrm_ipc::node::{Client, Heartbeats, PlannerNode, Request, RequestError, Transport};
use nsrm_ipc::service::{Robot, Sender};
use nsrm_tests::by_hand::{Parts, block, raw_scene};
use nsrm_tests::isolated_memory::IsolatedMemory;

const SENTENCE: &str = "put the small red block on the blue block";
const MS: u64 = 1_000_000;

fn join(role: Role, memory: &IsolatedMemory) -> Robot {
    Robot::join("left".parse().unwrap(), role, &memory.config).unwrap()
}

/// iceoryx2 was seen to hand the reply for a client that was killed to the next one.
#[test]
fn replies_to_another_client_are_ignored() {
    let memory = IsolatedMemory::new("another-client");
    let planner = join(Role::Planner, &memory);
    let server = planner.plan_server().unwrap();
    let silence_ns = 60_000 * MS;
    let mut client = Client::begin(
        join(Role::Client, &memory),
        Transport::Connection,
        silence_ns,
    )
    .unwrap();
    let mut request = client.ask(SENTENCE, Mode::ClosedLoop).unwrap();
    let active = server.receive().unwrap().unwrap();
    let own = ReplyTo {
        client: active.client,
        request: active.sequence,
        plan: 7,
        number: 1,
    };
    let before = ReplyTo { request: 99, ..own };
    let dead = ReplyTo {
        client: own.client ^ 1,
        number: 3,
        ..own
    };
    for to in [dead, before, own] {
        let reply = PlanReply::refused(to, "busy", "as it is");
        active.send_copy(reply).unwrap();
    }
    let reply = client.poll(&mut request, now_ns()).unwrap().unwrap();
    assert_eq!((reply.request, reply.number), (own.request, 1));
}

/// Without a connection nobody says that what was asked did not arrive.
#[test]
fn that_a_request_was_lost_is_detected_while_the_planner_lives() {
    let memory = IsolatedMemory::new("lost-request");
    let planner = join(Role::Planner, &memory);
    let _deaf = planner.receiver::<PlanRequest>().unwrap();
    let mut heartbeats = Heartbeats::begin(&planner, Role::Planner, now_ns()).unwrap();
    let client = join(Role::Client, &memory);
    let mut client = Client::begin(client, Transport::Broadcast, 350 * MS).unwrap();
    let begun_ns = now_ns();
    for (state, expected) in [
        (State::Busy, None),
        (State::Idle, Some(RequestError::ReplyLost { number: 1 })),
    ] {
        let mut request = client.ask(SENTENCE, Mode::ClosedLoop).unwrap();
        let begun_ns = now_ns().max(begun_ns);
        let heard = (0..40).find_map(|beat| {
            let now_ns = begun_ns + beat * 100 * MS;
            heartbeats.beat(state, now_ns).unwrap();
            client.poll(&mut request, now_ns).err()
        });
        assert_eq!(heard, expected);
    }
}

/// By the wall clock, which several hosts go by.
#[test]
fn a_clock_that_is_set_back_loses_no_planner_that_lives_and_keeps_none_that_does_not() {
    let memory = IsolatedMemory::new("set-back");
    let planner = join(Role::Planner, &memory);
    let _deaf = planner.receiver::<PlanRequest>().unwrap();
    let mut heartbeats = Heartbeats::begin(&planner, Role::Planner, now_ns()).unwrap();
    let client = join(Role::Client, &memory);
    let mut client = Client::begin(client, Transport::Broadcast, 350 * MS).unwrap();
    let lost = RequestError::PlannerLost("left".parse().unwrap());
    for (state, beats, expected) in [
        (State::Busy, 5, lost),
        (State::Idle, 40, RequestError::ReplyLost { number: 1 }),
    ] {
        let mut request = client.ask(SENTENCE, Mode::ClosedLoop).unwrap();
        let late_ns = now_ns() + 100_000 * MS;
        heartbeats.beat(state, late_ns).unwrap();
        assert_eq!(client.poll(&mut request, late_ns), Ok(None));
        // Before the planner has detected and reported it.
        let back_ns = late_ns - 50_000 * MS;
        assert_eq!(client.poll(&mut request, back_ns), Ok(None));
        let (ticks, error) = (0..60)
            .find_map(|tick| {
                let now_ns = back_ns + tick * 100 * MS;
                if tick < beats {
                    heartbeats.beat(state, now_ns).unwrap();
                }
                let heard = client.poll(&mut request, now_ns);
                heard.err().map(|error| (tick, error))
            })
            .expect("it does not wait for ever");
        assert_eq!(error, expected);
        // Four ticks of silence after the last heartbeat; two seconds of being idle.
        assert_eq!(ticks, if state == State::Busy { 8 } else { 21 });
    }
}

/// A planner without a controller whose heartbeats it would hear.
struct Stage<'m> {
    planner: PlannerNode<'m>,
    scene: RawScene,
    scenes: Sender<SceneMessage>,
    client: Client,
    request: Request,
}

impl Stage<'_> {
    fn turn(&mut self, now_ns: u64) -> Option<PlanReply> {
        self.scene.header.sequence += 1;
        self.scene.header.timestamp_ns = now_ns;
        self.scenes.send(&SceneMessage::from(&self.scene)).unwrap();
        let _ = self.planner.poll(now_ns);
        self.client.poll(&mut self.request, now_ns).unwrap()
    }
}

/// One that hangs would carry it out whenever it goes on.
#[test]
fn a_controller_that_is_silent_is_commanded_nothing() {
    let memory = IsolatedMemory::new("silent-controller");
    let parts = Parts::new();
    let model = parts.model();
    let hung = join(Role::Controller, &memory);
    let commands = hung.receiver::<SubGoal>().unwrap();
    let limits = Limits {
        // Here the client and the scenes have another clock than the planner.
        scene_age_ns: u64::MAX,
        ..Limits::default()
    };
    let mut client = Client::begin(
        join(Role::Client, &memory),
        Transport::Connection,
        600_000 * MS,
    )
    .unwrap();
    let planner = PlannerNode::begin(join(Role::Planner, &memory), &model, limits).unwrap();
    let request = client.ask(SENTENCE, Mode::ClosedLoop).unwrap();
    let mut stage = Stage {
        planner,
        scene: raw_scene(&model, &[block("small", "red"), block("lego", "blue")]),
        scenes: join(Role::Perception, &memory).sender().unwrap(),
        client,
        request,
    };
    let late_ns = now_ns() + limits.silence_ns + MS;
    let replies = (0..).find_map(|tick| {
        let reply = stage.turn(late_ns + tick)?;
        matches!(reply.read(), Ok(Reply::Failed { .. })).then_some(reply)
    });
    let reply = replies.unwrap();
    let Ok(Reply::Failed { reason, message }) = reply.read() else {
        panic!("{reply:?}");
    };
    assert_eq!(reason, "not_accepted", "{message}");
    assert!(commands.receive().unwrap().is_none());
}
