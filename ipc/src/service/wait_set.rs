use core::time::Duration;
use std::os::fd::BorrowedFd;

use heapless::Vec;
use iceoryx2::port::listener::{Listener, ListenerWaitError};
use iceoryx2::prelude::{FileDescriptorBased as _, ipc};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;

/// A wait set: sleeps until one of several services notifies.
///
/// iceoryx2's own wait functions drain the sockets of the notifiers by two to four system calls
/// before they return, and the woken process gets its message only after that. Here this is left
/// for the next wait.
#[derive(Debug)]
pub struct WaitSet<const N: usize> {
    listeners: Vec<Listener<ipc::Service>, N>,
}

impl<const N: usize> WaitSet<N> {
    pub(super) const fn new(listeners: Vec<Listener<ipc::Service>, N>) -> Self {
        Self { listeners }
    }

    /// Sleeps until a notification or a signal arrives or the time has passed; returns whether
    /// something may have arrived.
    ///
    /// The first call after one that was woken drains its socket and returns at once: a message
    /// that arrived meanwhile may have found the notification still pending.
    ///
    /// Cost: two system calls for each service before it sleeps, none after. Errors:
    /// [`ListenerWaitError::InternalFailure`] if the system cannot wait; a signal is no error.
    pub fn wait(&self, longest: Duration) -> Result<bool, ListenerWaitError> {
        // All of them and each time: a notification that arrives while its socket is drained may be
        // lost, and iceoryx2 would take it for one that is still pending.
        if self.try_wait()? {
            return Ok(true);
        }
        let notifiers = self.listeners.iter().map(|listener| {
            // SAFETY: it is open as long as the listener, which outlives this.
            let notifier =
                unsafe { BorrowedFd::borrow_raw(listener.file_descriptor().native_handle()) };
            PollFd::from_borrowed_fd(notifier, PollFlags::IN)
        });
        let mut notifiers: Vec<_, N> = notifiers.collect();
        // A time that is too long counts as for ever.
        let longest = Timespec::try_from(longest).ok();
        match poll(&mut notifiers, longest.as_ref()) {
            Ok(how_many) => Ok(how_many > 0),
            Err(Errno::INTR) => Ok(false),
            Err(_) => Err(ListenerWaitError::InternalFailure),
        }
    }

    /// Whether a notification has arrived since the last call, or was drained. Never waits. Errors:
    /// as [`WaitSet::wait`].
    pub fn try_wait(&self) -> Result<bool, ListenerWaitError> {
        let mut any = false;
        for listener in &self.listeners {
            match listener.try_wait(|_| {}) {
                Ok(times) => any |= times > 0,
                Err(ListenerWaitError::InterruptSignal) => {}
                Err(error) => return Err(error),
            }
        }
        Ok(any)
    }
}
