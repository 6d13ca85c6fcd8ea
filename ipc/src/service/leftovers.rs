//! Removes what killed processes left half created, which iceoryx2 leaves for ever: services, which
//! then nobody can open or create; segments of shared memory, on which others wait for ever;
//! sockets, nodes and connections, whose files stay.

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

use super::open::folder;

/// Creating any of them takes a millisecond; after this time, one that is half created is
/// abandoned.
const GIVEN_UP: Duration = Duration::from_secs(1);

/// Where Linux keeps named segments of shared memory.
pub(super) const SEGMENTS: &str = "/dev/shm";
/// All permissions of a file.
const ACCESS: u32 = 0o777;
/// The permissions of a node's context until the node is created.
const BEGUN: u32 = 0o200;
/// Read permission of the owner, which a segment gets when it is complete.
const OWNER_READ: u32 = 0o400;

/// Removes abandoned segments; returns whether some are, or may be, still being created.
///
/// Call it before iceoryx2 cleans up dead nodes: it waits endlessly for a segment that is still
/// empty. A process that waits is freed when another one calls this.
///
/// Anyone can put files there. Only files of this user and of the owner of the shared-memory folder
/// can belong to a robot.
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

/// Removes segments between two ports of processes that were both killed, which iceoryx2 sometimes
/// leaves; nothing in them identifies their owner.
///
/// They are orphaned if this node is the only one, they are older than it, and no process has them
/// mapped: another folder of nodes may use the same names.
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

/// Segments of shared memory that may belong to a robot's processes, with their metadata; without
/// those that disappear meanwhile.
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

/// Whether there is no other node, not even a dead one.
fn is_alone(node: &Node<ipc::Service>) -> bool {
    let mut others = false;
    let listed = Node::<ipc::Service>::list(node.config(), |state| {
        others |= !matches!(&state, NodeState::Alive(view) if view.id() == node.id());
        CallbackProgression::Continue
    });
    listed.is_ok() && !others
}

/// Whether any process that this one may inspect has a segment mapped.
fn is_mapped(segment: &Path) -> bool {
    let segment = segment.to_string_lossy();
    let mut processes = std::fs::read_dir("/proc").into_iter().flatten().flatten();
    processes.any(|process| {
        let maps = std::fs::read_to_string(process.path().join("maps"));
        maps.is_ok_and(|maps| maps.lines().any(|line| line.ends_with(&*segment)))
    })
}

/// Removes an abandoned service; returns whether it was one.
///
/// Only one process at a time does so, and only if the service was started long enough ago: one
/// that another process has started meanwhile is left alone.
pub(super) fn remove_service(
    node: &Node<ipc::Service>,
    name: &ServiceName,
    pattern: MessagingPattern,
) -> bool {
    let config = node.config();
    let folder = PathBuf::from(config.global.service_dir().to_string());
    // The folder itself is the lock, so that no lock file is left behind.
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
    // That does not remove files that are not even readable yet.
    removed == Ok(true) || std::fs::remove_file(file).is_ok()
}

/// Removes the remains of dead nodes that iceoryx2 fails to remove: half-written tags, which block
/// the removal of their folder. A missing node description shows that the node has already been
/// removed from its services.
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

/// Removes the remains of nodes that were killed while they started, ended or were cleaned up by a
/// process that was also killed: files without the three that every node has that is alive or that
/// iceoryx2 will clean up, or whose third file was never finished.
pub(super) fn remove_nodes(config: &Config) {
    let folder = PathBuf::from(config.global.node_dir().to_string());
    let (prefix, suffix) = (config.global.prefix, config.global.node.monitor_suffix);
    let (prefix, suffix) = (prefix.to_string(), suffix.to_string());
    let now = SystemTime::now();
    // What cannot be inspected or removed now is left to the next node that joins.
    for entry in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let is_folder = entry.file_type().is_ok_and(|kind| kind.is_dir());
        // A node's folder is named by its number; its files add a prefix and a suffix.
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

/// Removes orphaned sockets: left by processes that were killed between creating and registering
/// one, or during their cleanup.
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

/// Whether no process holds the other end; sends nothing.
fn is_nobodys(socket: &Path) -> bool {
    let connected = UnixDatagram::unbound().and_then(|own| own.connect(socket));
    connected.is_err_and(|error| error.kind() == ErrorKind::ConnectionRefused)
}

/// The file that describes a service.
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

/// Whether something started at that time counts as abandoned now.
fn is_given_up(begun: SystemTime, now: SystemTime) -> bool {
    now.duration_since(begun).is_ok_and(|age| age > GIVEN_UP)
}

fn is_usable(config: &Config, name: &ServiceName, pattern: MessagingPattern) -> bool {
    // What cannot be inspected for another reason is left alone.
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
