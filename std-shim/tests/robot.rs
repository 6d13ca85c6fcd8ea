//! The subcommands that are processes of a robot: perception, planner and a client. Camera,
//! controller and world belong to the test.
#![cfg(feature = "command")]

// Some of it is for other tests.
#[allow(dead_code)]
mod common;

use std::io::{BufRead, BufReader, Write};
use std::process::{Command, Output, Stdio};
use std::sync::atomic::Ordering;
use std::time::Instant;

use common::stage::{CONFIG, HANGS, SENTENCE, Stage, signal};
use common::{Bench, done, refused};
use nsrm_tests::isolated_memory::IsolatedMemory;
use serde_json::Value;

#[test]
fn a_sentence_is_followed_through_all_processes() {
    let stage = Stage::both("followed");
    let said = done(&stage.say(&[SENTENCE]));
    let lines: Vec<_> = said.lines().collect();
    assert_eq!(
        lines[0],
        "Action(MoveOn, Unique(Filter(red, Scene())), Unique(Filter(blue, Scene())))"
    );
    assert!(
        lines[1].starts_with("  step 1: object 1 (red, 1.00), by object 3 (blue, 1.00), to ("),
        "{said}"
    );
    assert!(
        lines[2].starts_with("step 1: moving object 1 to ("),
        "{said}"
    );
    assert!(
        lines[3].starts_with("step 1: done, observed 0.0 mm from"),
        "{said}"
    );
    assert_eq!(lines[4..], ["done"]);
    stage.wait_for_log(&[" done ", SENTENCE]);
}

/// Without a connection, as between hosts.
#[test]
fn a_sentence_may_be_broadcast() {
    let stage = Stage::both("broadcast");
    let lines = format!(
        "transport = 'broadcast'\n{CONFIG}{}",
        stage.memory.as_toml()
    );
    stage.bench.write("robot.toml", lines);
    // Ctrl-C reaches the robot over the same services.
    stage.works.store(false, Ordering::Relaxed);
    let (code, message) = stage.interrupt_when_under_way();
    assert_eq!(code, Some(2));
    assert_eq!(message, "nsrm: stopping the robot …\nnsrm: cancelled\n");
    stage.works.store(true, Ordering::Relaxed);
    let said = done(&stage.say(&[SENTENCE]));
    assert!(said.ends_with("\ndone\n"), "{said}");
}

#[test]
fn planning_alone_and_json() {
    let stage = Stage::both("json");
    let said = done(&stage.say(&[SENTENCE, "--plan-only", "--json"]));
    let events: Vec<Value> = said
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!(events.len(), 2, "{said}");
    assert_eq!(events[0]["event"], "planned");
    let step = &events[0]["steps"][0];
    assert_eq!(
        (&step["action"], &step["object"][0]),
        (&"MoveOn".into(), &"red".into())
    );
    assert_eq!(step["grounded"]["reference_id"], 3);
    assert_eq!(
        (&events[1]["event"], &events[1]["number"]),
        (&"done".into(), &2.into())
    );
}

#[test]
fn what_is_refused_is_told_with_exit_code_2() {
    let stage = Stage::both("refused");
    let said = stage.say(&["put the purple block on the blue block", "--json"]);
    let message = refused(&said, &["\"purple\" is not a word"]);
    // One object a line: the event, and the error as in every command.
    assert_eq!(message, Value::Null);
    let printed = String::from_utf8(said.stdout).unwrap();
    let events: Vec<Value> = printed
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!(events[0]["reason"], "unknown_word");
    let said = stage.say(&["put the green block on the blue block"]);
    refused(&said, &["step 1", "\"green\" fits no object"]);
    // The planner logs it, too.
    stage.wait_for_log(&[" refused ", "the purple block", "\"purple\" is not a word"]);
    stage.wait_for_log(&[" refused ", "the green block", "\"green\" fits no object"]);
}

/// `nsrm say --dialogue` with these lines as its input.
fn asked(stage: &Stage, sentence: &str, answers: &str) -> Output {
    let mut say = stage
        .command(&["say", "--dialogue", "--plan-only", sentence])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = say.stdin.take().unwrap();
    input.write_all(answers.as_bytes()).unwrap();
    drop(input);
    say.wait_with_output().unwrap()
}

#[test]
fn an_answer_completes_what_was_refused() {
    let stage = Stage::both("asked");
    let sentence = "put the green block on the blue block";
    let said = asked(&stage, sentence, "the purple one\nthe red one\n");
    let told = String::from_utf8_lossy(&said.stderr).into_owned();
    for part in [
        "\"green\" fits no object",
        "do you mean the ",
        "\"the purple one\" is none of the answers",
        " red block on the blue block\"",
    ] {
        assert!(told.contains(part), "{told}");
    }
    assert!(said.status.success(), "{told}");
    assert!(said.stdout.starts_with(b"Action(MoveOn, "));
    // The rest of a step, then a sentence of its own.
    for answer in ["on the blue one", SENTENCE] {
        let said = asked(&stage, "put the red block", answer);
        let told = String::from_utf8_lossy(&said.stderr).into_owned();
        assert!(
            told.contains("names one object only: what is missing?"),
            "{told}"
        );
        assert!(said.status.success(), "{told}");
        assert!(said.stdout.starts_with(b"Action(MoveOn, "));
    }
    let said = asked(&stage, sentence, "");
    assert_eq!(said.status.code(), Some(2));
}

/// The nodes of the test's robot.
const NODES: [&str; 3] = ["controller", "perception", "planner"];

#[test]
fn who_watches_sees_who_lives_what_flows_and_what_was_said() {
    let stage = Stage::both("watched");
    let mut watch = stage
        .command(&["watch", "--json"])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(watch.stdout.take().unwrap()).lines();
    // An observer that starts later does not receive earlier replies.
    lines.next().unwrap().unwrap();
    let refused = stage.say(&["put the green block on the blue block"]);
    assert_eq!(refused.status.code(), Some(2));
    let view: Value = lines
        .map(|line| serde_json::from_str(&line.unwrap()).unwrap())
        .find(|view: &Value| {
            let nodes = view["nodes"].as_array().unwrap();
            let is_heard = |name| nodes.iter().any(|node| node["node"] == name);
            NODES.into_iter().all(is_heard)
                && view["scene"]["count"] != 0
                && !view["replies"][0].is_null()
        })
        .unwrap();
    signal(watch.id(), "-TERM");
    assert!(watch.wait().unwrap().success());
    let nodes = view["nodes"].as_array().unwrap();
    for name in NODES {
        let node = nodes.iter().find(|node| node["node"] == name).unwrap();
        assert_eq!(
            (&node["lives"], &node["restarts"], &node["rejected"]),
            (&true.into(), &0.into(), &0.into())
        );
    }
    assert_eq!(view["objects"], 2);
    let said = view["replies"][0]["said"].as_str().unwrap();
    assert!(said.starts_with("no_such_object: step 1"), "{said}");

    // On a busy machine not all of them are received in the half second that it takes.
    let begun = Instant::now();
    loop {
        let text = done(&stage.command(&["watch", "--once"]).output().unwrap());
        assert!(text.starts_with("robot left\n"), "{text}");
        let parts = [
            "restarts  rejected",
            "planner     idle",
            "2 objects in the last scene",
            " ms",
        ];
        if parts.iter().all(|part| text.contains(part)) {
            break;
        }
        assert!(begun.elapsed() < HANGS, "{text}");
    }
}

#[test]
fn no_planner_and_a_second_one_are_told_of() {
    let mut stage = Stage::new("second");
    refused(
        &stage.say(&[SENTENCE]),
        &["robot `left` has no planner; start one: nsrm serve --robot left"],
    );
    // Programs read the kind.
    let json = refused(&stage.say(&["--json", SENTENCE]), &["no planner"]);
    assert_eq!(json["error"]["kind"], "no_planner");
    let first = stage.start("serve", "planning");
    let process = stage.processes[first].id();
    let second = stage.command(&["serve"]).output().unwrap();
    refused(
        &second,
        &[&format!(
            "robot `left`: `plan` is already served by process {process}; choose another robot \
             name, or stop that process"
        )],
    );
}

#[test]
fn ctrl_c_stops_the_robot_too() {
    let stage = Stage::both("ctrl-c");
    stage.works.store(false, Ordering::Relaxed);
    let (code, message) = stage.interrupt_when_under_way();
    assert_eq!(code, Some(2));
    assert_eq!(message, "nsrm: stopping the robot …\nnsrm: cancelled\n");
}

#[test]
fn a_killed_planner_is_detected_and_another_takes_its_place() {
    let mut stage = Stage::new("killed");
    stage.start("perceive", "perceiving");
    let planner = stage.start("serve", "planning");
    stage.works.store(false, Ordering::Relaxed);
    // Its silence is detected. A live node would send three hundred heartbeats meanwhile.
    let limits = CONFIG.replace("silence_ms = 3600000", "silence_ms = 30000");
    let lines = format!("{limits}{}", stage.memory.as_toml());
    stage.bench.write("robot.toml", lines);
    let (say, _printed) = stage.say_and_wait_for_the_way();
    // A command that was sent is executed, whichever process has died since.
    while stage.taken.load(Ordering::Relaxed) == 0 {
        std::thread::yield_now();
    }
    stage.processes[planner].kill().unwrap();
    stage.processes[planner].wait().unwrap();
    let ended = say.wait_with_output().unwrap();
    assert_eq!(ended.status.code(), Some(2));
    let message = String::from_utf8(ended.stderr).unwrap();
    assert_eq!(
        message,
        "nsrm: the planner of robot `left` died or hangs; check the robot, then restart the \
         planner\n"
    );
    stage.works.store(true, Ordering::Relaxed);
    stage.start("serve", "planning");
    let said = done(&stage.say(&[SENTENCE]));
    assert!(said.ends_with("\ndone\n"), "{said}");
}

#[test]
fn bad_configurations_are_told_of() {
    let stage = Stage::new("config");
    let serve = |content: &str| {
        stage.bench.write("bad.toml", content);
        stage.bench.run(&["serve", "--config", "bad.toml"])
    };
    refused(
        &stage.bench.run(&["serve", "--config", "no.toml"]),
        &["no.toml: No such file"],
    );
    refused(&serve("robot = \"Left/1\""), &["'L' in a robot's name"]);
    refused(
        &serve("[limits]\ntolerance_mm = 0"),
        &["limits: tolerance: must be"],
    );
    refused(
        &serve("[limits]\nmoved_mm = -1"),
        &["limits: moved: must be"],
    );
    refused(
        &serve("[limits]\nattempts = 0"),
        &["limits: attempts: must be"],
    );
    refused(
        &serve("[limits]\nscene_age_ms = 0"),
        &["limits: scene age: must be"],
    );
    refused(
        &serve("[shared_memory]\nprefix = \"a/b\""),
        &["shared_memory.prefix = \"a/b\""],
    );
    refused(
        &serve("[shared_memory]\nroot = \"here\""),
        &["shared_memory.root = \"here\": must be an absolute path"],
    );
    let typo = serve("[limits]\nretry = 3");
    let message = String::from_utf8(typo.stderr).unwrap();
    assert_eq!(typo.status.code(), Some(2));
    assert!(
        message.contains("line 2") && message.contains("`retry`"),
        "{message}"
    );
}

/// iceoryx2's errors name what could not be created, but not why.
#[test]
fn what_keeps_processes_from_meeting_is_found() {
    let (memory, bench) = (IsolatedMemory::new("meeting"), Bench::new());
    let serve_in = |root: &str| {
        let prefix = memory.prefix();
        let places = format!("[shared_memory]\nroot = {root:?}\nprefix = {prefix:?}\n");
        bench.write("robot.toml", places);
        ["serve", "--config", "robot.toml"]
    };
    // The log has a line before the message.
    let ends_with = |ended: &Output, cause: &str| {
        let message = String::from_utf8_lossy(&ended.stderr);
        assert_eq!(ended.status.code(), Some(2), "{message}");
        let last = message.lines().last().unwrap_or_default();
        assert!(
            last.starts_with("nsrm: robot `robot`: ") && last.contains(cause),
            "{message}"
        );
    };
    ends_with(
        &bench.run(&serve_in("/proc/nothing")),
        "the shared-memory folder /proc/nothing cannot be created or written to: No such file",
    );
    let long = bench.path(&"long".repeat(20));
    ends_with(
        &bench.run(&serve_in(long.to_str().unwrap())),
        "is too long for the sockets in it",
    );
    // One limit after the other, since what fails first depends on how many files are left.
    let short = bench.path("m");
    let serve = serve_in(short.to_str().unwrap());
    for most in 24..34 {
        let few = Command::new("sh")
            .args(["-c", &format!("ulimit -n {most}; exec \"$@\""), "sh"])
            .arg(env!("CARGO_BIN_EXE_nsrm"))
            .args(serve)
            .current_dir(bench.folder.path())
            .output();
        ends_with(&few.unwrap(), &format!("of at most {most} open files"));
    }
}
