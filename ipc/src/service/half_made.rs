//! What was half made when its maker was killed, which iceoryx2 leaves for ever: services,
//! which then nobody can open or make any more, and nodes, whose files stay.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::time::Duration;

use iceoryx2::config::Config;
use iceoryx2::node::{NodeState, NodeView as _};
use iceoryx2::prelude::*;
use iceoryx2::service::Service;
use iceoryx2::service::service_hash::ServiceHash;

/// Making either takes a millisecond; what is half made for so long stays so.
const GIVEN_UP: Duration = Duration::from_secs(1);

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
    if !was_given_up(&file) || is_usable(config, name, pattern) {
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
pub(super) fn remove_tags(config: &Config) {
    let folder = PathBuf::from(config.global.node_dir().to_string());
    let _ = Node::<ipc::Service>::list(config, |state| {
        if let NodeState::Dead(node) = state
            && node.details().is_none()
        {
            let folder = folder.join(node.id().value().to_string());
            if was_given_up(&folder) {
                let _ = std::fs::remove_dir_all(folder);
            }
        }
        CallbackProgression::Continue
    });
}

/// Removes what nodes have left that were killed between writing down who they are and
/// showing that they live: a folder of that number, and nothing that is watched for its
/// death.
pub(super) fn remove_nodes(config: &Config) {
    let folder = PathBuf::from(config.global.node_dir().to_string());
    // What can't be looked at or removed now is so by the next node that joins.
    for node in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
        let number = node.file_name();
        let watched = format!(
            "{}{}{}",
            config.global.prefix,
            number.to_string_lossy(),
            config.global.node.monitor_suffix
        );
        let is_folder = node.file_type().is_ok_and(|kind| kind.is_dir());
        if is_folder && was_given_up(&node.path()) && !folder.join(watched).exists() {
            let _ = std::fs::remove_dir_all(node.path());
        }
    }
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

fn was_given_up(file: &Path) -> bool {
    let begun = file.metadata().and_then(|it| it.modified());
    begun
        .ok()
        .and_then(|begun| begun.elapsed().ok())
        .is_some_and(|age| age > GIVEN_UP)
}

fn is_usable(config: &Config, name: &ServiceName, pattern: MessagingPattern) -> bool {
    // What can't be looked at for another reason is not touched.
    ipc::Service::details(name, config, pattern).map_or(true, |found| {
        found.is_some_and(|service| service.dynamic_details.is_some())
    })
}
