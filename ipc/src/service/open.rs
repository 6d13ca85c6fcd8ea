//! Opens services and creates their ports, with retries while other processes, live or dead, are in
//! the way, and errors that say who is.

use core::fmt::Debug;
use core::time::Duration;
use std::os::unix::fs::MetadataExt as _;
use std::path::PathBuf;
use std::time::Instant;

use iceoryx2::config::Config;
use iceoryx2::node::{NodeState, NodeView};
use iceoryx2::prelude::*;
use tracing::warn;

use super::cause::likely_cause;
use super::fault::Fault;
use super::{Robot, ServiceError, leftovers};

/// How long to wait for a service that another process is creating or removing; long enough to
/// detect that it is abandoned.
pub(super) const IN_FLUX: Duration = Duration::from_secs(4);
/// How long to wait between two tries.
pub(super) const BETWEEN_TRIES: Duration = Duration::from_millis(10);
/// The timeout of one try.
pub(super) const TRY: Duration = Duration::from_millis(100);

impl Robot {
    /// Creates a port of a service. If a dead process still has the slot, waits until it is cleaned
    /// up, by this process or by another one that has started to.
    ///
    /// * `full`: the error if there is none
    pub(super) fn create_port<T, E: Into<Fault>>(
        &self,
        service: &'static str,
        full: impl Fn(&Self, &'static str) -> ServiceError,
        take: impl Fn() -> Result<T, E>,
    ) -> Result<T, ServiceError> {
        let begun = Instant::now();
        let fault = loop {
            match take() {
                Ok(taken) => return Ok(taken),
                Err(_) if begun.elapsed() < IN_FLUX && self.has_dead() => {
                    self.cleanup_dead_nodes();
                    std::thread::sleep(BETWEEN_TRIES);
                }
                Err(error) => break error.into(),
            }
        };
        Err(match fault {
            Fault::Other(says) => self.iceoryx(service, says),
            _ => full(self, service),
        })
    }

    /// Whether there are dead processes that are not cleaned up yet.
    fn has_dead(&self) -> bool {
        let mut found = false;
        // A process that cannot be inspected delays nobody.
        let _ = Node::<ipc::Service>::list(self.node.config(), |state| {
            found = matches!(state, NodeState::Dead(_));
            if found {
                CallbackProgression::Stop
            } else {
                CallbackProgression::Continue
            }
        });
        found
    }

    /// Opens a service; retries while another process creates or removes it.
    pub(super) fn open<T, E: Into<Fault>>(
        &self,
        service: &'static str,
        pattern: MessagingPattern,
        open: impl Fn(iceoryx2::service::builder::Builder<ipc::Service>) -> Result<T, E>,
    ) -> Result<T, ServiceError> {
        let name = format!("nsrm/v1/{}/{service}", self.name);
        let robot = || self.name.clone();
        let name = ServiceName::new(&name).map_err(|error| self.fault(service, &error))?;
        let begun = Instant::now();
        let fault = loop {
            match open(self.node.service_builder(&name)).map_err(Into::into) {
                Ok(opened) => return Ok(opened),
                Err(Fault::InFlux) => {
                    // Also checked after the timeout, by a process that was delayed.
                    if leftovers::remove_service(&self.node, &name, pattern) {
                        warn!(%name, "removed a service that a dead process had left half created");
                    } else if begun.elapsed() >= IN_FLUX {
                        break Fault::InFlux;
                    }
                    std::thread::sleep(BETWEEN_TRIES);
                }
                Err(fault) => break fault,
            }
        };
        let robot = robot();
        if let Some(folder) = folder_of_other(self.node.config()) {
            return Err(ServiceError::OtherUser {
                robot,
                service,
                folder,
            });
        }
        Err(match fault {
            Fault::OtherVersion => ServiceError::OtherVersion { robot, service },
            Fault::OtherUser => ServiceError::OtherUser {
                robot,
                service,
                folder: folder(self.node.config()),
            },
            Fault::Full => ServiceError::Full { robot, service },
            Fault::InFlux => self.iceoryx(
                service,
                "another process keeps creating or removing it".into(),
            ),
            Fault::Other(says) => self.iceoryx(service, says),
        })
    }

    /// An error of iceoryx2 as ours.
    pub(crate) fn fault(&self, service: &'static str, error: &dyn Debug) -> ServiceError {
        self.iceoryx(service, format!("{error:?}"))
    }

    fn iceoryx(&self, service: &'static str, says: String) -> ServiceError {
        ServiceError::Iceoryx {
            robot: self.name.clone(),
            service,
            says,
            cause: likely_cause(self.node.config()),
        }
    }

    pub(super) fn full(&self, service: &'static str) -> ServiceError {
        let robot = self.name.clone();
        ServiceError::Full { robot, service }
    }

    /// The only slot is taken, by the process whose node has the same name.
    pub(super) fn taken(&self, service: &'static str) -> ServiceError {
        let mut process = None;
        // A process that cannot be inspected isn't named.
        let _ = Node::<ipc::Service>::list(self.node.config(), |state| {
            if let NodeState::Alive(view) = state
                && view.id() != self.node.id()
                && let Some(details) = view.details()
                && details.name() == self.node.name()
            {
                process = u32::try_from(details.process_id().value()).ok();
                return CallbackProgression::Stop;
            }
            CallbackProgression::Continue
        });
        ServiceError::Taken {
            robot: self.name.clone(),
            service,
            process,
        }
    }
}

/// The folder in which iceoryx2 keeps its files.
pub(super) fn folder(config: &Config) -> PathBuf {
    String::from_utf8_lossy(config.global.root_path().as_bytes())
        .as_ref()
        .into()
}

/// That folder, if it belongs to another user: iceoryx2 gives no other user access to its files and
/// its shared memory, and has no specific error for that. Root has access to everything.
pub(super) fn folder_of_other(config: &Config) -> Option<PathBuf> {
    let folder = folder(config);
    let owner = std::fs::metadata(&folder).ok()?.uid();
    let user = rustix::process::geteuid();
    (!user.is_root() && owner != user.as_raw()).then_some(folder)
}
