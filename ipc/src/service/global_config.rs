use std::fs::File;
use std::io::{self, Write as _};
use std::os::fd::AsRawFd as _;

use iceoryx2::config::Config;
use iceoryx2::prelude::{FilePath, SemanticString};
use rustix::fs::{MemfdFlags, memfd_create};

/// Makes a place other than iceoryx2's usual one this process's own, if it has none yet.
///
/// What a node has left that was killed before it had written down where it lives, iceoryx2
/// 0.10 looks for at the place that is global to who looks: without this, such files stay
/// for ever. The global place can be set by a file alone.
pub fn set_global_config(config: &Config) -> io::Result<()> {
    let (root, prefix) = (config.global.root_path(), config.global.prefix);
    let text = format!(
        "[global]\nroot-path = {:?}\nprefix = {:?}\n",
        root.to_string(),
        prefix.to_string()
    );
    // In memory: a file of a name in a folder for all may be another user's.
    let file = memfd_create(c"nsrm-global-config", MemfdFlags::CLOEXEC)?;
    let mut file = File::from(file);
    file.write_all(text.as_bytes())?;
    let path = format!("/proc/self/fd/{}", file.as_raw_fd());
    let path = FilePath::new(path.as_bytes());
    let path = path.map_err(|error| io::Error::other(format!("{error:?}")))?;
    Config::setup_global_config_from_file(&path)
        .map(|_| ())
        .map_err(|error| io::Error::other(format!("{error:?}")))
}
