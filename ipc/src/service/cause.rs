use std::fs;

use iceoryx2::config::Config;
use rustix::fs::{Access, access};
use rustix::process::{Resource, getrlimit};

use super::folder;

/// What the path of a socket may have at most, bytes: Linux's `sockaddr_un`, without the zero
/// at its end.
const SOCKET_PATH: usize = 107;
/// What iceoryx2 puts behind folder and prefix: a slash, a number, and `.event`.
const SOCKET_NAME: usize = 1 + 31 + 6;
/// Files that iceoryx2 opens together, and closes again when the last can't be had.
const TOGETHER: u64 = 16;

/// What iceoryx2 could not say when something failed, if it can be found: its errors tell
/// what could not be made, and not why.
pub(super) fn likely_cause(config: &Config) -> Option<String> {
    let folder = folder(config);
    let shown = folder.display();
    if let Err(error) = fs::create_dir_all(&folder)
        .and_then(|()| Ok(access(&folder, Access::WRITE_OK | Access::EXEC_OK)?))
    {
        return Some(format!(
            "the processes meet in {shown}, which can't be made or written to: {error}; choose \
             another folder: `root` under [shared_memory] in a configuration"
        ));
    }
    let length = folder.as_os_str().len() + config.global.prefix.to_string().len() + SOCKET_NAME;
    if length > SOCKET_PATH {
        return Some(format!(
            "the path of {shown}, where the processes meet, is too long for sockets in it, by \
             {} bytes or so; choose a shorter one: `root` under [shared_memory] in a configuration",
            length - SOCKET_PATH
        ));
    }
    let most = getrlimit(Resource::Nofile).current?;
    // Apart from the one that lists them.
    let open = fs::read_dir("/proc/self/fd").ok()?.count() as u64 - 1;
    (open + TOGETHER > most).then(|| {
        format!(
            "of the {most} files that this process may have open, {open} are, and more are \
             needed: allow it more with `ulimit -n`"
        )
    })
}
