//! A corner of the machine's shared memory that no other test or robot uses.

use std::path::PathBuf;

use iceoryx2::config::Config;
use iceoryx2::prelude::{FileName, Path, SemanticString};

/// What a test's nodes share; what they leave behind is removed with it. To be made
/// before them, so that it goes after them.
#[derive(Debug)]
pub struct Corner {
    /// For nodes that are to meet here.
    pub config: Config,
    root: PathBuf,
    prefix: String,
}

impl Corner {
    /// A corner of this name, of this process alone.
    pub fn new(test: &str) -> Self {
        let name = format!("nsrm-test-{}-{test}", std::process::id());
        let root = std::env::temp_dir().join(&name);
        let prefix = format!("{name}_");
        let mut config = Config::default();
        let path = root.to_str().expect("a path in UTF-8").as_bytes();
        config
            .global
            .set_root_path(&Path::new(path).expect("a path of moderate length"));
        config.global.prefix = FileName::new(prefix.as_bytes()).expect("a short name");
        Self {
            config,
            root,
            prefix,
        }
    }

    /// The lines of a configuration file by which a command meets here.
    pub fn as_toml(&self) -> String {
        let root = self.root.to_str().expect("a path in UTF-8");
        format!(
            "[shared_memory]\nroot = {root:?}\nprefix = {:?}\n",
            self.prefix
        )
    }

    /// What lies in shared memory under its name, apart from the one segment that
    /// iceoryx2 keeps for all nodes to come.
    pub fn left_behind(&self) -> Vec<String> {
        let entries = std::fs::read_dir("/dev/shm").expect("shared memory");
        entries
            .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
            .filter(|name| name.starts_with(&self.prefix) && !name.ends_with(".global_mgmt"))
            .collect()
    }
}

impl Drop for Corner {
    fn drop(&mut self) {
        let left = self.left_behind();
        let shared = std::fs::read_dir("/dev/shm").expect("shared memory");
        for entry in shared.flatten() {
            if entry
                .file_name()
                .to_string_lossy()
                .starts_with(&self.prefix)
            {
                let _ = std::fs::remove_file(entry.path());
            }
        }
        let _ = std::fs::remove_dir_all(&self.root);
        // A test that fails has told enough.
        assert!(
            std::thread::panicking() || left.is_empty(),
            "left behind: {left:?}"
        );
    }
}
