//! What a killed process has left half created: a service is created again, a node removed.

use std::fs::Permissions;
use std::io::{BufRead as _, BufReader};
use std::os::unix::fs::PermissionsExt as _;
use std::os::unix::net::UnixDatagram;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, SystemTime};

use nsrm_ipc::message::{Feedback, Role};
use nsrm_ipc::service::{Receiver, Robot, Sender, ServiceError, set_global_config};
use nsrm_tests::isolated_memory::IsolatedMemory;

fn join(role: Role, memory: &IsolatedMemory) -> Robot {
    Robot::join("left".parse().unwrap(), role, &memory.config).unwrap()
}

/// The files that describe services.
fn described(memory: &IsolatedMemory) -> Vec<PathBuf> {
    let folder = memory.root().join("services");
    let files = std::fs::read_dir(folder).unwrap();
    files.map(|file| file.unwrap().path()).collect()
}

/// As they stand when their maker is killed between the two parts of a service: there is no
/// second one.
fn break_all(memory: &IsolatedMemory) {
    for segment in std::fs::read_dir("/dev/shm").unwrap().flatten() {
        let name = segment.file_name().into_string().unwrap();
        if name.starts_with(memory.prefix()) && name.ends_with(".dynamic") {
            std::fs::remove_file(segment.path()).unwrap();
        }
    }
}

/// Makes it so old that it counts as abandoned.
fn age(file: &Path) {
    date(file, SystemTime::now() - Duration::from_secs(60));
}

/// Keeps it from becoming old while the test runs, even on a slow machine: it dates from the
/// future, as if the clock had been set back since.
fn keep_young(file: &Path) {
    date(file, SystemTime::now() + Duration::from_secs(3600));
}

fn date(file: &Path, made: SystemTime) {
    let file = std::fs::File::open(file).unwrap();
    file.set_modified(made).unwrap();
}

fn sends(sender: &Sender<Feedback>, receiver: &Receiver<Feedback>) -> bool {
    let feedback = Feedback {
        plan: 1,
        sequence: 1,
        timestamp_ns: 1,
        command: 1,
        outcome: 1,
        objects: [0; 2],
    };
    sender.send(&feedback).unwrap();
    receiver.receive().unwrap().is_some()
}

#[test]
fn what_was_begun_and_given_up_is_made_anew() {
    let memory = IsolatedMemory::new("half-made");
    let dead = join(Role::Controller, &memory);
    let lost = dead.sender::<Feedback>().unwrap();
    break_all(&memory);
    for file in described(&memory) {
        age(&file);
    }
    let (one, other) = (
        join(Role::Controller, &memory),
        join(Role::Planner, &memory),
    );
    let sender = one.sender::<Feedback>().unwrap();
    let receiver = other.receiver::<Feedback>().unwrap();
    assert!(sends(&sender, &receiver));
    // The process that had started it and is alive after all reaches nobody.
    assert!(!sends(&lost, &receiver));
}

#[test]
fn what_is_just_being_made_is_left_alone() {
    let memory = IsolatedMemory::new("being-made");
    let maker = join(Role::Controller, &memory);
    let service = maker.sender::<Feedback>().unwrap();
    break_all(&memory);
    let before = described(&memory);
    for file in &before {
        keep_young(file);
    }
    let refused = join(Role::Planner, &memory).receiver::<Feedback>();
    assert!(
        matches!(refused, Err(ServiceError::Iceoryx { .. })),
        "{refused:?}"
    );
    assert_eq!(described(&memory).len(), before.len());
    drop(service);
}

/// The state after a process was killed before it held the lock that shows that it is alive.
#[test]
fn a_node_that_was_begun_and_given_up_is_removed() {
    let memory = IsolatedMemory::new("half-a-node");
    let lives = join(Role::Planner, &memory);
    let nodes = memory.root().join("nodes");
    let entries = || std::fs::read_dir(&nodes).unwrap().count();
    let own = entries();
    let dead = |number: &str| {
        let folder = nodes.join(number);
        std::fs::create_dir(&folder).unwrap();
        std::fs::write(folder.join("node.details"), "{}").unwrap();
        folder
    };
    let (old, new) = (dead("4711"), dead("4712"));
    let file = |name: &str| {
        let file = nodes.join(format!("{}{name}", memory.prefix()));
        std::fs::write(&file, "").unwrap();
        file
    };
    let watched = file("4711.node_monitor_context");
    // The process that cleaned up this one was killed after the first of three files.
    let half_removed = ["4713.node_monitor_context", "4713.node_monitor_owner_lock"].map(file);
    // This one was killed before it set the permissions of its context, which show that it is alive.
    let begun = [
        "4715.node_monitor",
        "4715.node_monitor_owner_lock",
        "4715.node_monitor_context",
    ];
    let begun = begun.map(file);
    let of_begun = dead("4715");
    std::fs::set_permissions(&begun[2], Permissions::from_mode(0o200)).unwrap();
    let old_ones = [&old, &watched, &of_begun]
        .into_iter()
        .chain(&half_removed)
        .chain(&begun);
    for part in old_ones.clone() {
        age(part);
    }
    keep_young(&new);
    let other = join(Role::Perception, &memory);
    for part in old_ones {
        assert!(!part.exists(), "{}", part.display());
    }
    assert!(new.exists());
    // The files of the other one, and of the live one, are there.
    assert_eq!(entries(), 2 * own + 1);
    assert!(lives.receiver::<Feedback>().is_ok() && other.sender::<Feedback>().is_ok());
    std::fs::remove_dir_all(new).unwrap();
}

/// A controller at work.
fn controller(memory: &IsolatedMemory) -> Child {
    let mut child = Command::new(env!("CARGO_BIN_EXE_node"))
        .arg("controller")
        .args(memory.arguments())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let stdout = BufReader::new(child.stdout.take().unwrap());
    assert_eq!(stdout.lines().next().unwrap().unwrap(), "at work");
    child
}

/// The state after the process that cleaned it up was killed, too, with a tag half written.
#[test]
fn the_last_of_a_dead_node_is_removed() {
    let memory = IsolatedMemory::new("half-removed");
    // For the whole process: no other test in this file may do so, or clean up a dead process.
    set_global_config(&memory.config).unwrap();
    let heir = join(Role::Planner, &memory);
    let nodes = memory.root().join("nodes");
    let folders = || {
        let entries = std::fs::read_dir(&nodes).unwrap().flatten();
        let paths = entries.map(|entry| entry.path());
        paths.filter(|path| path.is_dir()).collect::<Vec<_>>()
    };
    let own = folders();
    let begun = SystemTime::now();
    let mut child = controller(&memory);
    child.kill().unwrap();
    child.wait().unwrap();
    let mut folders = folders().into_iter();
    let folder = folders.find(|it| !own.contains(it)).unwrap();
    for file in std::fs::read_dir(&folder).unwrap().flatten() {
        if file.file_name().to_string_lossy().ends_with(".details") {
            std::fs::remove_file(file.path()).unwrap();
        }
    }
    let tag = format!("{}4711.service_tag", memory.prefix());
    // A file that is being written is not readable, so iceoryx2 does not see it.
    std::fs::write(folder.join("unfinished"), tag).unwrap();
    // On a clock that stands still nothing becomes old.
    heir.cleanup_dead_nodes_at(begun);
    assert!(folder.exists());
    // Removing a file from a folder makes the folder young again.
    age(&folder);
    heir.cleanup_dead_nodes();
    heir.cleanup_dead_nodes();
    assert!(!folder.exists());
    drop(heir);
    let left = memory.left_behind();
    assert!(
        !left.iter().any(|name| name.contains("/nodes/")),
        "{left:?}"
    );
    memory.clear();
}

/// The state after a process was killed between creating a segment and setting its size; iceoryx2
/// would wait for the size for ever.
#[test]
fn a_segment_that_was_begun_and_given_up_is_removed() {
    let memory = IsolatedMemory::new("half-a-segment");
    let lives = join(Role::Planner, &memory);
    let segment = |name: &str| {
        let path = Path::new("/dev/shm").join(format!("{}{name}.connection", memory.prefix()));
        std::fs::write(&path, "").unwrap();
        path
    };
    let (old, new) = (segment("1_2"), segment("3_4"));
    age(&old);
    keep_young(&new);
    assert!(!lives.cleanup_dead_nodes());
    assert!(!old.exists() && new.exists());
    age(&new);
    assert!(lives.cleanup_dead_nodes());
    assert!(!new.exists());
}

/// A possible state after the processes of both of its ports were killed.
#[test]
fn a_connection_that_is_nobodys_is_removed() {
    let memory = IsolatedMemory::new("connections");
    let segment = |name: &str| {
        let path = Path::new("/dev/shm").join(format!("{}{name}.connection", memory.prefix()));
        std::fs::write(&path, "between two ports").unwrap();
        keep_young(&path);
        path
    };
    let (nobodys, used, young) = (segment("1_2"), segment("3_4"), segment("5_6"));
    // Mapped by another process: it may belong to a robot with another folder.
    let mut user = Command::new("python3")
        .args(["-c", MAPS, used.to_str().unwrap()])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut said = BufReader::new(user.stdout.take().unwrap()).lines();
    assert_eq!(said.next().unwrap().unwrap(), "mapped");
    let other = join(Role::Planner, &memory);
    for old in [&nobodys, &used] {
        age(old);
    }
    // As long as there are other processes it may be theirs.
    let second = join(Role::Controller, &memory);
    assert!(nobodys.exists());
    drop((other, second));
    drop(join(Role::Planner, &memory));
    assert!(!nobodys.exists() && used.exists() && young.exists());
    drop(user.stdin.take());
    assert!(user.wait().unwrap().success());
    drop(join(Role::Planner, &memory));
    assert!(!used.exists() && young.exists());
    std::fs::remove_file(young).unwrap();
}

/// A process that maps a file until it is told to end.
const MAPS: &str = "import mmap, sys
with open(sys.argv[1], 'r+b') as file, mmap.mmap(file.fileno(), 0):
    print('mapped', flush=True)
    sys.stdin.read()
";

/// The state after a process was killed before it registered a socket that it had created.
#[test]
fn a_socket_that_is_nobodys_is_removed() {
    let memory = IsolatedMemory::new("sockets");
    let lives = join(Role::Controller, &memory);
    let wait_set = lives.wait_set(["sub_goal"]).unwrap();
    let path = |name: &str| memory.root().join(format!("{}{name}", memory.prefix()));
    let (nobodys, young) = (path("4711.event"), path("4712.event"));
    for socket in [&nobodys, &young] {
        drop(UnixDatagram::bind(socket).unwrap());
    }
    let sockets = || {
        let entries = std::fs::read_dir(memory.root()).unwrap().flatten();
        let names = entries.map(|entry| entry.path());
        names.filter(|path| path.extension().is_some_and(|it| it == "event"))
    };
    for socket in sockets() {
        // As `age` and `keep_young`; a socket cannot be opened.
        let made = if socket == young {
            "1 hour"
        } else {
            "1 minute ago"
        };
        let mut touch = Command::new("touch");
        touch.args(["-d", made]).arg(socket);
        assert!(touch.status().unwrap().success());
    }
    assert_eq!(sockets().count(), 3);
    let notifier = join(Role::Planner, &memory).notifier("sub_goal").unwrap();
    assert!(!nobodys.exists() && young.exists());
    // The socket of a live process is older, and is still there.
    assert_eq!(sockets().count(), 2);
    notifier.notify();
    assert_eq!(wait_set.try_wait(), Ok(true));
    std::fs::remove_file(young).unwrap();
}
