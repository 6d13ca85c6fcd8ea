//! What was half made when its maker was killed, which iceoryx2 leaves for ever: services,
//! which then nobody can open or make any more, segments of shared memory, at which others
//! wait for ever, sockets, nodes and connections, whose files stay.

use std::fs::{File, Metadata};
use std::io::ErrorKind;
use std::os::unix::fs::MetadataExt as _;
use std::os::unix::net::UnixDatagram;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use iceoryx2::config::Config;
use iceoryx2::node::{NodeState, NodeView as _};
use iceoryx2::prelude::*;
use iceoryx2::service::Service;
use iceoryx2::service::service_hash::ServiceHash;

use super::folder;

/// Making any of them takes a millisecond; what is half made for so long stays so.
const GIVEN_UP: Duration = Duration::from_secs(1);

/// Where Linux keeps named segments of shared memory.
pub(super) const SEGMENTS: &str = "/dev/shm";
/// All permissions of a file.
const ACCESS: u32 = 0o777;
/// Those of a node's context until the node is made.
const BEGUN: u32 = 0o200;
/// Permission of the owner to read, which a segment gets when it is made.
const OWNER_READ: u32 = 0o400;

/// Removes segments that were begun and given up; whether there are some that are being
/// made, or may be.
///
/// To be called before iceoryx2 looks at what the dead have left: it waits without end for
/// a segment that is still empty. Who waits so is freed by the next one that calls this.
///
/// Anyone may put files there. Those of others than this user and who owns the folder in which
/// the processes meet are none of a robot's.
pub(super) fn remove_segments(config: &Config, now: SystemTime) -> bool {
    let mut being_made = false;
    for (path, segment) in segments(config) {
        if segment.len() == 0 || segment.mode() & OWNER_READ == 0 {
            let is_gone = was_given_up(&path, now) && std::fs::remove_file(path).is_ok();
            being_made |= !is_gone;
        }
    }
    being_made
}

/// Removes segments between two ports of processes that were both killed, which iceoryx2
/// leaves now and then; nothing in them tells whose they were.
///
/// They are nobody's where this node is the only one that there is, they are older than that,
/// and no process has them in its memory: another folder of nodes may use the same names.
pub(super) fn remove_connections(node: &Node<ipc::Service>) {
    let config = node.config();
    let suffix = config.global.service.connection_suffix.to_string();
    let now = SystemTime::now();
    if !is_alone(node) {
        return;
    }
    for (path, segment) in segments(config) {
        let is_old = segment.modified().is_ok_and(|made| is_given_up(made, now));
        if is_old && path.to_string_lossy().ends_with(&suffix) && !is_mapped(&path) {
            let _ = std::fs::remove_file(path);
        }
    }
}

/// Segments of shared memory that a robot's processes may have made, with what the system
/// tells of them; without those that have gone meanwhile.
fn segments(config: &Config) -> impl Iterator<Item = (PathBuf, Metadata)> {
    let prefix = config.global.prefix.to_string();
    let user = rustix::process::geteuid().as_raw();
    let meeting = folder(config).metadata().map_or(user, |it| it.uid());
    let entries = std::fs::read_dir(SEGMENTS).into_iter().flatten().flatten();
    entries.filter_map(move |entry| {
        let is_named_so = entry.file_name().to_string_lossy().starts_with(&prefix);
        let segment = is_named_so.then(|| entry.metadata().ok()).flatten()?;
        let is_ours = [user, meeting].contains(&segment.uid());
        is_ours.then(|| (entry.path(), segment))
    })
}

/// Whether there is no other node, dead ones included.
fn is_alone(node: &Node<ipc::Service>) -> bool {
    let mut others = false;
    let listed = Node::<ipc::Service>::list(node.config(), |state| {
        others |= !matches!(&state, NodeState::Alive(view) if view.id() == node.id());
        CallbackProgression::Continue
    });
    listed.is_ok() && !others
}

/// Whether a process has a segment in its memory, of those that this one may look into.
fn is_mapped(segment: &Path) -> bool {
    let segment = segment.to_string_lossy();
    let mut processes = std::fs::read_dir("/proc").into_iter().flatten().flatten();
    processes.any(|process| {
        let maps = std::fs::read_to_string(process.path().join("maps"));
        maps.is_ok_and(|maps| maps.lines().any(|line| line.ends_with(&*segment)))
    })
}

/// Removes a service that was begun and given up; whether it was one.
///
/// One process at a time does so, and only to what was begun long enough ago: what another
/// one has begun anew meanwhile is left to it.
pub(super) fn remove_service(
    node: &Node<ipc::Service>,
    name: &ServiceName,
    pattern: MessagingPattern,
) -> bool {
    let config = node.config();
    let folder = PathBuf::from(config.global.service_dir().to_string());
    // The folder itself is the lock, so that none is left behind.
    let Ok(lock) = File::open(&folder) else {
        return false;
    };
    if lock.try_lock().is_err() {
        return false;
    }
    let file = folder.join(file_name(config, name, pattern));
    if !was_given_up(&file, SystemTime::now()) || is_usable(config, name, pattern) {
        return false;
    }
    // SAFETY: nobody uses the service: it is used through its dynamic part, which is not
    // there. Nobody makes it: that would have taken a thousandth of its age.
    let removed = unsafe { node.force_remove_service(name, pattern) };
    // What is not even readable yet is not removed by that.
    removed == Ok(true) || std::fs::remove_file(file).is_ok()
}

/// Removes the last of dead nodes that iceoryx2 fails to remove: tags that they had begun to
/// write, which are in the way of removing the folder behind them. That they have gone from
/// their services before shows in that the node's description has.
pub(super) fn remove_tags(config: &Config, now: SystemTime) {
    let folder = PathBuf::from(config.global.node_dir().to_string());
    let _ = Node::<ipc::Service>::list(config, |state| {
        if let NodeState::Dead(node) = state
            && node.details().is_none()
        {
            let folder = folder.join(node.id().value().to_string());
            if was_given_up(&folder, now) {
                let _ = std::fs::remove_dir_all(folder);
            }
        }
        CallbackProgression::Continue
    });
}

/// Removes what nodes have left that were killed while they began or ended, or while another
/// one that was killed, too, buried them: files without the three that every node has that
/// lives or that iceoryx2 will bury, or whose third was never finished.
pub(super) fn remove_nodes(config: &Config) {
    let folder = PathBuf::from(config.global.node_dir().to_string());
    let (prefix, suffix) = (config.global.prefix, config.global.node.monitor_suffix);
    let (prefix, suffix) = (prefix.to_string(), suffix.to_string());
    let now = SystemTime::now();
    // What can't be looked at or removed now is so by the next node that joins.
    for entry in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let is_folder = entry.file_type().is_ok_and(|kind| kind.is_dir());
        // A node's folder has its number for a name, its files have more around it.
        let number = if is_folder {
            name.as_str()
        } else {
            let behind = name.strip_prefix(&prefix).unwrap_or_default();
            behind.split_once(&suffix).map_or("", |(number, _)| number)
        };
        let file = |end: &str| folder.join(format!("{prefix}{number}{suffix}{end}"));
        let is_whole = file("").exists()
            && file("_owner_lock").exists()
            && file("_context")
                .metadata()
                .is_ok_and(|context| context.mode() & ACCESS != BEGUN);
        if number.is_empty() || is_whole || !was_given_up(&entry.path(), now) {
            continue;
        }
        let _ = if is_folder {
            std::fs::remove_dir_all(entry.path())
        } else {
            std::fs::remove_file(entry.path())
        };
    }
}

/// Removes sockets by which nobody is woken any more: what was killed between making one and
/// noting that it has, or while it was buried, leaves it.
pub(super) fn remove_sockets(config: &Config) {
    let folder = PathBuf::from(config.global.root_path().to_string());
    let prefix = config.global.prefix.to_string();
    let suffix = config.global.service.event_connection_suffix.to_string();
    let now = SystemTime::now();
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let is_one = name.starts_with(&prefix) && name.ends_with(&suffix);
        if is_one && was_given_up(&entry.path(), now) && is_nobodys(&entry.path()) {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// Whether no process holds the other end; nothing is sent to who does.
fn is_nobodys(socket: &Path) -> bool {
    let connected = UnixDatagram::unbound().and_then(|own| own.connect(socket));
    connected.is_err_and(|error| error.kind() == ErrorKind::ConnectionRefused)
}

/// The file in which a service is described.
fn file_name(config: &Config, name: &ServiceName, pattern: MessagingPattern) -> String {
    let hash = ServiceHash::new::<<ipc::Service as Service>::ServiceNameHasher>(name, pattern);
    let (prefix, suffix) = (
        config.global.prefix,
        config.global.service.static_config_storage_suffix,
    );
    format!("{prefix}{}{suffix}", hash.as_str())
}

fn was_given_up(file: &Path, now: SystemTime) -> bool {
    let begun = file.metadata().and_then(|it| it.modified());
    begun.is_ok_and(|begun| is_given_up(begun, now))
}

/// Whether what was begun then is given up by now.
fn is_given_up(begun: SystemTime, now: SystemTime) -> bool {
    now.duration_since(begun).is_ok_and(|age| age > GIVEN_UP)
}

fn is_usable(config: &Config, name: &ServiceName, pattern: MessagingPattern) -> bool {
    // What can't be looked at for another reason is not touched.
    ipc::Service::details(name, config, pattern).map_or(true, |found| {
        found.is_some_and(|service| service.dynamic_details.is_some())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_half_made_is_given_up_after_a_second() {
        let begun = SystemTime::UNIX_EPOCH + Duration::from_secs(1_000_000);
        let nanosecond = Duration::from_nanos(1);
        for age in [Duration::ZERO, Duration::from_millis(1), GIVEN_UP] {
            assert!(!is_given_up(begun, begun + age), "{age:?}");
        }
        for age in [GIVEN_UP + nanosecond, Duration::from_secs(60)] {
            assert!(is_given_up(begun, begun + age), "{age:?}");
        }
        // The clock was set back since.
        for ahead in [nanosecond, Duration::from_secs(60)] {
            assert!(!is_given_up(begun + ahead, begun), "{ahead:?}");
        }
    }
}
