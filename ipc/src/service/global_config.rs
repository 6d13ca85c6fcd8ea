use std::fs::File;
use std::io::{self, Write as _};
use std::os::fd::AsRawFd as _;

use iceoryx2::config::Config;
use iceoryx2::prelude::{FilePath, SemanticString};
use rustix::fs::{MemfdFlags, memfd_create};

/// Makes a configuration other than iceoryx2's default the global one of this process, if it has
/// none yet.
///
/// iceoryx2 0.10 searches for the remains of nodes that were killed before they had recorded their
/// configuration in the global location of the searching process; without this, such files stay for
/// ever. The global configuration can be set only by a file.
///
/// ```no_run
/// use iceoryx2::config::Config;
/// use nsrm_ipc::service::set_global_config;
///
/// let mut config = Config::default();
/// config.global.prefix = "left_".try_into().expect("a valid name");
/// // First of all: it is refused once anything has used the global configuration.
/// set_global_config(&config)?;
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn set_global_config(config: &Config) -> io::Result<()> {
    let (root, prefix) = (config.global.root_path(), config.global.prefix);
    let text = format!(
        "[global]\nroot-path = {:?}\nprefix = {:?}\n",
        root.to_string(),
        prefix.to_string()
    );
    // In memory: a named file in a shared folder may belong to another user.
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
