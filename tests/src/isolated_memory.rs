//! A corner of the machine's shared memory that no other test or robot uses.

use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

use iceoryx2::config::Config;
use iceoryx2::prelude::{FileName, Path, SemanticString};
use nsrm_ipc::message::Role;
use nsrm_ipc::service::Robot;

/// A process's place at a robot.
pub fn join(robot: &str, role: Role, config: &Config) -> Robot {
    let name = robot.parse().expect("a robot's name");
    Robot::join(name, role, config).expect("a place to meet")
}

/// For nodes that are to meet under this folder, with names that begin so.
///
/// # Panics
/// Where they are too long for iceoryx2.
pub fn config(root: &str, prefix: &str) -> Config {
    let mut config = Config::default();
    let path = Path::new(root.as_bytes()).expect("a path of moderate length");
    config.global.set_root_path(&path);
    config.global.prefix = FileName::new(prefix.as_bytes()).expect("a short name");
    config
}

/// What a test's nodes share; what they leave behind is removed with it. To be made
/// before them, so that it goes after them.
#[derive(Debug)]
pub struct IsolatedMemory {
    /// For nodes that are to meet here.
    pub config: Config,
    root: PathBuf,
    prefix: String,
}

impl IsolatedMemory {
    /// A corner of this name, of this process alone.
    pub fn new(test: &str) -> Self {
        // The folder's path and the prefix stand in paths of sockets, of 107 bytes at most: the
        // name of the test is in one of them.
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

    /// What its names in shared memory begin with.
    pub fn prefix(&self) -> &str {
        &self.prefix
    }

    /// What tells another process where to meet: the folder, and what names in shared
    /// memory begin with; for [`config`].
    pub fn arguments(&self) -> [&str; 2] {
        let root = self.root.to_str().expect("a path in UTF-8");
        [root, &self.prefix]
    }

    /// The lines of a configuration file by which a command meets here.
    pub fn as_toml(&self) -> String {
        let root = self.root.to_str().expect("a path in UTF-8");
        format!(
            "[shared_memory]\nroot = {root:?}\nprefix = {:?}\n",
            self.prefix
        )
    }

    /// What lies in shared memory and in files under its name, apart from the one segment
    /// that iceoryx2 keeps for all nodes to come.
    pub fn left_behind(&self) -> Vec<String> {
        let entries = std::fs::read_dir("/dev/shm").expect("shared memory");
        let mut left: Vec<String> = entries
            .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
            .filter(|name| name.starts_with(&self.prefix) && !name.ends_with(".global_mgmt"))
            .collect();
        let mut folders = vec![self.root.clone()];
        while let Some(folder) = folders.pop() {
            // What is gone was not left.
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
    /// Removes what lies under its name.
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
        // A test that fails has told enough.
        assert!(
            std::thread::panicking() || left.is_empty(),
            "left behind: {left:?}"
        );
    }
}
