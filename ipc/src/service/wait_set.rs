use core::time::Duration;
use std::os::fd::BorrowedFd;

use heapless::Vec;
use iceoryx2::port::listener::{Listener, ListenerWaitError};
use iceoryx2::prelude::{FileDescriptorBased as _, ipc};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;

/// Is woken by what rings at some services.
///
/// iceoryx2's own ways of waiting empty the bells' sockets by two to four calls of the system
/// before they return, and who was woken looks for its message behind them. Here that is left
/// for the next wait.
#[derive(Debug)]
pub struct WaitSet<const N: usize> {
    listeners: Vec<Listener<ipc::Service>, N>,
}

impl<const N: usize> WaitSet<N> {
    pub(super) const fn new(listeners: Vec<Listener<ipc::Service>, N>) -> Self {
        Self { listeners }
    }

    /// Sleeps until something rings, a signal comes or this time has passed; whether there may
    /// be something to look for.
    ///
    /// The first call behind one that something has woken hears its bell out and returns at
    /// once: what came meanwhile may have found it still ringing.
    ///
    /// Cost: two calls of the system for each service before it sleeps, none behind it.
    /// Errors: [`ListenerWaitError::InternalFailure`] if the system lets nobody wait; a signal
    /// is none.
    pub fn wait(&self, longest: Duration) -> Result<bool, ListenerWaitError> {
        // All of them and each time: one that rings just while it is heard out may lose its
        // sound, and iceoryx2 would take it for one that still rings.
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
        // What is too long for it is for ever.
        let longest = Timespec::try_from(longest).ok();
        match poll(&mut notifiers, longest.as_ref()) {
            Ok(how_many) => Ok(how_many > 0),
            Err(Errno::INTR) => Ok(false),
            Err(_) => Err(ListenerWaitError::InternalFailure),
        }
    }

    /// Whether something has rung since this was asked last, or heard out. Never waits.
    /// Errors: as [`WaitSet::wait`].
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
