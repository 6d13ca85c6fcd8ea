//! Isolated shared memory, which no other test or robot uses.

use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

use iceoryx2::config::Config;
use iceoryx2::prelude::{FileName, Path, SemanticString};
use nsrm_ipc::message::Role;
use nsrm_ipc::service::Robot;

/// A process as a member of a robot.
pub fn join(robot: &str, role: Role, config: &Config) -> Robot {
    let name = robot.parse().expect("a robot's name");
    Robot::join(name, role, config).expect("a place to meet")
}

/// The configuration of nodes that share this folder and this prefix of names.
///
/// # Panics
/// If they are too long for iceoryx2.
pub fn config(root: &str, prefix: &str) -> Config {
    let mut config = Config::default();
    let path = Path::new(root.as_bytes()).expect("a path of moderate length");
    config.global.set_root_path(&path);
    config.global.prefix = FileName::new(prefix.as_bytes()).expect("a short name");
    config
}

/// The shared memory of a test's nodes; removes what they leave behind when it is dropped. Create
/// it before them, so that it is dropped after them.
#[derive(Debug)]
pub struct IsolatedMemory {
    /// The configuration of its nodes.
    pub config: Config,
    root: PathBuf,
    prefix: String,
}

impl IsolatedMemory {
    /// Isolated memory with this name, only for this process.
    pub fn new(test: &str) -> Self {
        // The folder's path and the prefix are part of the paths of sockets, which have at most 107
        // bytes: only one of them contains the name of the test.
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let process = std::process::id();
        let root = std::env::temp_dir().join(format!("nsrm-test-{process}-{count}"));
        let prefix = format!("nsrm-test-{process}-{test}_");
        Self {
            config: config(root.to_str().expect("a path in UTF-8"), &prefix),
            root,
            prefix,
        }
    }

    /// The folder of its files.
    pub fn root(&self) -> &std::path::Path {
        &self.root
    }

    /// The prefix of its names in shared memory.
    pub fn prefix(&self) -> &str {
        &self.prefix
    }

    /// The arguments of [`config`] for another process: the folder, and the prefix of names in
    /// shared memory.
    pub fn arguments(&self) -> [&str; 2] {
        let root = self.root.to_str().expect("a path in UTF-8");
        [root, &self.prefix]
    }

    /// The lines of a configuration file that make a command use it.
    pub fn as_toml(&self) -> String {
        let root = self.root.to_str().expect("a path in UTF-8");
        format!(
            "[shared_memory]\nroot = {root:?}\nprefix = {:?}\n",
            self.prefix
        )
    }

    /// The shared memory and files under its name, except the one segment that iceoryx2 keeps for
    /// all future nodes.
    pub fn left_behind(&self) -> Vec<String> {
        let entries = std::fs::read_dir("/dev/shm").expect("shared memory");
        let mut left: Vec<String> = entries
            .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
            .filter(|name| name.starts_with(&self.prefix) && !name.ends_with(".global_mgmt"))
            .collect();
        let mut folders = vec![self.root.clone()];
        while let Some(folder) = folders.pop() {
            // A file that is gone was not left behind.
            for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
                if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
                    folders.push(entry.path());
                } else {
                    left.push(entry.path().display().to_string());
                }
            }
        }
        left
    }
}

impl IsolatedMemory {
    /// Removes everything under its name.
    pub fn clear(&self) {
        let shared = std::fs::read_dir("/dev/shm").expect("shared memory");
        for entry in shared.flatten() {
            let name = entry.file_name();
            if name.to_string_lossy().starts_with(&self.prefix) {
                let _ = std::fs::remove_file(entry.path());
            }
        }
        let _ = std::fs::remove_dir_all(&self.root);
    }
}

impl Drop for IsolatedMemory {
    fn drop(&mut self) {
        let left = self.left_behind();
        self.clear();
        // A failing test has reported enough.
        assert!(
            std::thread::panicking() || left.is_empty(),
            "left behind: {left:?}"
        );
    }
}
