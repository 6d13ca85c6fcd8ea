use std::fs;

use iceoryx2::config::Config;
use rustix::fs::{Access, access};
use rustix::io::Errno;
use rustix::process::{Resource, getrlimit};

use super::open::folder;

/// The longest path of a socket, bytes: Linux's `sockaddr_un`, without the terminating zero.
const SOCKET_PATH: usize = 107;
/// What iceoryx2 appends to folder and prefix, bytes: a slash, a number of about 31 digits, and
/// `.event`.
const SOCKET_NAME: usize = 1 + 31 + 6;
/// How many files may have been closed again after the open that failed; more than 8 were observed.
const CLOSED_AGAIN: u64 = 16;

/// The likely cause of a failure, if one is found: errors of iceoryx2 name what could not be
/// created, but not why. Changes nothing.
pub(super) fn likely_cause(config: &Config) -> Option<String> {
    if let Some(most) = getrlimit(Resource::Nofile).current {
        let open = open_files(most);
        if open.saturating_add(CLOSED_AGAIN) > most {
            return Some(format!(
                "{open} of at most {most} open files are in use, and more are needed: raise the \
                 limit with `ulimit -n`"
            ));
        }
    }
    let folder = folder(config);
    let shown = folder.display();
    // iceoryx2 creates it before anything in it.
    if let Err(error) = access(&folder, Access::WRITE_OK | Access::EXEC_OK) {
        return Some(format!(
            "the shared-memory folder {shown} cannot be created or written to: {error}; choose \
             another one: `root` under [shared_memory] in the configuration"
        ));
    }
    let length = folder.as_os_str().len() + config.global.prefix.to_string().len() + SOCKET_NAME;
    (length > SOCKET_PATH).then(|| {
        format!(
            "the path of the shared-memory folder {shown} is too long for the sockets in it, by \
             about {} bytes; choose a shorter one: `root` under [shared_memory] in the \
             configuration",
            length - SOCKET_PATH
        )
    })
}

/// How many files this process has open, of at most `most`.
fn open_files(most: u64) -> u64 {
    match fs::read_dir("/proc/self/fd") {
        // Without the one that lists them.
        Ok(entries) => (entries.count() as u64).saturating_sub(1),
        // No file descriptor is left for listing them.
        Err(error) if error.raw_os_error() == Some(Errno::MFILE.raw_os_error()) => most,
        Err(_) => 0,
    }
}
