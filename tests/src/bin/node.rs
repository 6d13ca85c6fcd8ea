//! A node of robot `left` as a process of its own, for tests that stop or kill it: `node ROLE
//! FOLDER PREFIX`. Reports on stdout when it works, and ends with its stdin.

use std::io::Read as _;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use nsrm_ipc::clock::now_ns;
use nsrm_ipc::message::Role;
use nsrm_ipc::node::PlannerNode;
use nsrm_tests::by_hand::Parts;
use nsrm_tests::controller::Controller;
use nsrm_tests::isolated_memory::{config, join};
use nsrm_tests::world::patient;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [role, folder, prefix] = &arguments[..] else {
        panic!("usage: node controller|planner FOLDER PREFIX");
    };
    let config = config(folder, prefix);
    std::thread::spawn(|| {
        let _ = std::io::stdin().read_to_end(&mut Vec::new());
        std::process::exit(1);
    });
    match role.as_str() {
        "controller" => {
            let mut controller = Controller::new("left", &config);
            // It accepts, and is busy until it is stopped.
            controller.works = false;
            println!("at work");
            loop {
                controller.turn(now_ns(), |_| {});
                std::thread::sleep(Duration::from_millis(5));
            }
        }
        "planner" => {
            let parts = Parts::new();
            let model = parts.model();
            let robot = join("left", Role::Planner, &config);
            // No scene arrives, and the test may take long.
            let node = PlannerNode::begin(robot, &model, patient());
            let mut node = node.expect("a planner's place");
            println!("at work");
            node.run(&AtomicBool::new(false))
                .expect("shared memory works");
        }
        role => panic!("{role:?} is neither controller nor planner"),
    }
}
