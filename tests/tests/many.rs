//! Several robots on one machine, each with several observers: nobody receives messages of another
//! robot, and everyone receives the latest scene.

use nsrm_ipc::clock::now_ns;
use nsrm_ipc::executive::Mode;
use nsrm_ipc::message::{PlanReply, Role, SceneMessage, SubGoal};
use nsrm_ipc::node::{Client, Heartbeats, PlannerNode, Transport, Watcher};
use nsrm_ipc::service::{CLIENTS, ONLOOKERS, Robot, ServiceError};
use nsrm_tests::by_hand::{Block, Parts, block, raw_scene};
use nsrm_tests::isolated_memory::{IsolatedMemory, join};
use nsrm_tests::world::{Pending, World, last_reason, patient};

const ONLOOKERS_EACH: usize = 8;

/// A robot: the blocks in front of it, its sentence, and the objects that are moved.
struct Case {
    name: &'static str,
    blocks: &'static [Block],
    sentence: &'static str,
    moved: &'static [u32],
}

const CASES: [Case; 4] = [
    Case {
        name: "north",
        blocks: &[block("small", "red"), block("lego", "blue")],
        sentence: "put the red block on the blue block",
        moved: &[1],
    },
    Case {
        name: "north-2",
        blocks: &[
            block("lego", "green"),
            block("small", "blue"),
            block("small", "red"),
        ],
        sentence: "put the red block on the green block then put the blue block on the red block",
        moved: &[3, 2],
    },
    Case {
        name: "south",
        blocks: &[
            block("lego", "red"),
            block("small", "red"),
            block("lego", "blue"),
            block("small", "green"),
        ],
        sentence: "put the small green block on the lego red block",
        moved: &[4],
    },
    // Unlike the others, it has no object that the sentence names.
    Case {
        name: "west",
        blocks: &[block("small", "green"), block("lego", "green")],
        sentence: "put the red block on the blue block",
        moved: &[],
    },
];

struct Everyone<'m> {
    planner: PlannerNode<'m>,
    world: World,
    pending: Pending,
    replies: Vec<PlanReply>,
    onlookers: Vec<Watcher>,
    case: &'static Case,
}

#[test]
fn robots_side_by_side_don_t_hear_of_each_other() {
    let memory = IsolatedMemory::new("many");
    let config = &memory.config;
    let parts = Parts::new();
    let model = parts.model();
    let mut robots: Vec<Everyone<'_>> = Vec::new();
    for case in &CASES {
        let robot = join(case.name, Role::Planner, config);
        let planner = PlannerNode::begin(robot, &model, patient()).unwrap();
        let mut world = World::new(case.name, &model, config);
        world.scene = raw_scene(&model, case.blocks);
        let onlooker = |_| Watcher::begin(join(case.name, Role::Watcher, config)).unwrap();
        robots.push(Everyone {
            planner,
            pending: world.ask(1, case.sentence),
            world,
            replies: Vec::new(),
            onlookers: (0..ONLOOKERS_EACH).map(onlooker).collect(),
            case,
        });
    }
    // All work at the same time, one unit of work each in turn.
    let mut under_way = 0;
    while robots.iter().any(|it| it.pending.is_connected()) {
        for it in &mut robots {
            it.world.turn(now_ns());
            it.planner.poll(now_ns());
            while let Some(reply) = it.pending.receive().unwrap() {
                it.replies.push(*reply);
            }
            for onlooker in &mut it.onlookers {
                let view = onlooker.look(now_ns());
                // The latest scene, in whatever order they were published.
                assert_eq!(view.scenes.made_ns, it.world.scene.header.timestamp_ns);
                assert_eq!(view.objects as usize, it.case.blocks.len());
            }
        }
        let at_it = robots.iter().filter(|it| it.pending.is_connected());
        under_way = under_way.max(at_it.count());
    }
    assert_eq!(under_way, CASES.len());
    for it in &mut robots {
        while let Some(reply) = it.pending.receive().unwrap() {
            it.replies.push(*reply);
        }
        let name = it.case.name;
        let goals = &it.world.controller.done;
        let moved: Vec<_> = goals.iter().map(|goal| goal.object_id).collect();
        assert_eq!(moved, it.case.moved, "{name}");
        // Each received command is from the robot's own planner.
        assert_eq!(it.world.controller.taken as usize, goals.len(), "{name}");
        let plan = it.replies.iter().map(|reply| reply.plan).max().unwrap();
        assert!(goals.iter().all(|goal: &SubGoal| goal.plan == plan));
        let expected = it.case.moved.is_empty().then_some("no_such_object");
        assert_eq!(last_reason(&it.replies), expected, "{name}");
        for onlooker in &mut it.onlookers {
            let view = onlooker.look(now_ns());
            let told = view.replies.iter();
            assert!(told.eq(it.replies.iter().rev().take(8).rev()), "{name}");
            assert_eq!((view.rejected, view.feedback.lost), (0, 0), "{name}");
            assert_eq!(view.feedback.count as usize, 2 * goals.len(), "{name}");
        }
    }
}

#[test]
fn who_finds_no_place_is_told_so_and_the_others_go_on() {
    let memory = IsolatedMemory::new("full");
    let config = &memory.config;
    let parts = Parts::new();
    let publisher = join("north", Role::Perception, config);
    let scenes = publisher.sender::<SceneMessage>().unwrap();
    let mut message = SceneMessage::from(&raw_scene(&parts.model(), CASES[0].blocks));
    let readers: Vec<_> = (0..ONLOOKERS)
        .map(|_| {
            let robot = join("north", Role::Watcher, config);
            (robot.receiver::<SceneMessage>().unwrap(), robot)
        })
        .collect();
    let full = |robot: &Robot| {
        let refused = robot.receiver::<SceneMessage>().unwrap_err();
        let (robot, service) = ("north".parse().unwrap(), "scene");
        assert_eq!(refused, ServiceError::Full { robot, service });
    };
    full(&join("north", Role::Watcher, config));
    for sequence in 1..=3 {
        message.sequence = sequence;
        assert_eq!(scenes.send(&message), Ok(ONLOOKERS));
    }
    for (reader, _) in &readers {
        let latest = reader.receive().unwrap().expect("a scene");
        assert_eq!(latest.sequence, 3);
        assert!(reader.receive().unwrap().is_none());
    }
    // Another robot has its own slots, and a slot that was released can be taken.
    let other = join("south", Role::Watcher, config);
    assert!(other.receiver::<SceneMessage>().is_ok());
    drop(readers);
    assert!(publisher.receiver::<SceneMessage>().is_ok());
}

/// In addition to all of the robot's own nodes, each of which sends heartbeats, too.
#[test]
fn as_many_as_may_ask_find_a_place_and_one_more_is_told_so() {
    let memory = IsolatedMemory::new("clients");
    let config = &memory.config;
    let parts = Parts::new();
    let model = parts.model();
    let robot = join("north", Role::Planner, config);
    let mut planner = PlannerNode::begin(robot, &model, patient()).unwrap();
    let nodes = [Role::Controller, Role::Perception, Role::Watcher].map(|role| {
        let robot = join("north", role, config);
        (Heartbeats::begin(&robot, role, now_ns()).unwrap(), robot)
    });
    for transport in [Transport::Connection, Transport::Broadcast] {
        let begin = || Client::begin(join("north", Role::Client, config), transport, u64::MAX);
        let mut clients: Vec<_> = (0..CLIENTS).map(|_| begin().unwrap()).collect();
        let refused = begin().unwrap_err();
        assert!(matches!(refused, ServiceError::Full { .. }), "{refused}");
        // Each of them is answered.
        for client in &mut clients {
            let mut asked = client.ask("put the red block", Mode::PlanOnly).unwrap();
            let reply = loop {
                planner.poll(now_ns());
                if let Some(reply) = client.poll(&mut asked, now_ns()).unwrap() {
                    break reply;
                }
            };
            assert_eq!(last_reason(&[reply]), Some("incomplete_step"));
        }
    }
    drop(nodes);
}
