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
pub struct Ears<const N: usize> {
    listeners: Vec<Listener<ipc::Service>, N>,
    /// Which have rung, with that still in their sockets.
    rang: [bool; N],
}

impl<const N: usize> Ears<N> {
    pub(super) const fn new(listeners: Vec<Listener<ipc::Service>, N>) -> Self {
        Self {
            listeners,
            rang: [false; N],
        }
    }

    /// Sleeps until something rings, a signal comes or this time has passed.
    ///
    /// The first call behind one that something has woken returns at once: what came
    /// meanwhile may have found the bell still ringing, and is to be looked for.
    pub fn wait(&mut self, longest: Duration) -> Result<(), ListenerWaitError> {
        if self.rang.contains(&true) {
            for (listener, rang) in self.listeners.iter().zip(&mut self.rang) {
                if core::mem::take(rang) {
                    hear_out(listener)?;
                }
            }
            return Ok(());
        }
        let bells = self.listeners.iter().map(|listener| {
            // SAFETY: it is open as long as the listener, which outlives this.
            let bell =
                unsafe { BorrowedFd::borrow_raw(listener.file_descriptor().native_handle()) };
            PollFd::from_borrowed_fd(bell, PollFlags::IN)
        });
        let mut bells: Vec<_, N> = bells.collect();
        // What is too long for it is for ever.
        let longest = Timespec::try_from(longest).ok();
        match poll(&mut bells, longest.as_ref()) {
            Ok(_) => {
                for (bell, rang) in bells.iter().zip(&mut self.rang) {
                    *rang = !bell.revents().is_empty();
                }
                Ok(())
            }
            Err(Errno::INTR) => Ok(()),
            Err(_) => Err(ListenerWaitError::InternalFailure),
        }
    }

    /// Whether something has rung since this was asked last. Never waits.
    pub fn try_wait(&mut self) -> Result<bool, ListenerWaitError> {
        self.rang = [false; N];
        let mut any = false;
        for listener in &self.listeners {
            any |= hear_out(listener)?;
        }
        Ok(any)
    }
}

/// Lets a bell ring again; whether it has.
fn hear_out(listener: &Listener<ipc::Service>) -> Result<bool, ListenerWaitError> {
    match listener.try_wait(|_| {}) {
        Ok(times) => Ok(times > 0),
        Err(ListenerWaitError::InterruptSignal) => Ok(false),
        Err(error) => Err(error),
    }
}
