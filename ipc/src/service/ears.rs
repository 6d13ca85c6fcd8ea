use core::cell::Cell;
use core::time::Duration;
use std::os::fd::{AsFd as _, BorrowedFd, OwnedFd};

use heapless::Vec;
use iceoryx2::port::listener::{Listener, ListenerWaitError};
use iceoryx2::prelude::{FileDescriptorBased as _, ipc};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::{Errno, read};
use rustix::time::{
    Itimerspec, TimerfdClockId, TimerfdFlags, TimerfdTimerFlags, timerfd_create, timerfd_settime,
};

/// More services than that nobody listens to, and a clock.
const MOST: usize = 8;

/// Is woken by what rings at some services.
///
/// iceoryx2's own ways of waiting empty the bells' sockets by two to four calls of the system
/// before they return, and who was woken looks for its message behind them. Here that is left
/// for the next wait.
#[derive(Debug)]
pub struct Ears<const N: usize> {
    listeners: Vec<Listener<ipc::Service>, N>,
    /// Ends a sleep in which nothing rings. It goes on by itself: a time that is set anew for
    /// each sleep and unset by who wakes costs that one microseconds.
    clock: OwnedFd,
    /// Between two strokes of the clock; none at first.
    period: Cell<Duration>,
}

impl<const N: usize> Ears<N> {
    /// Errors: those of the system, which has no file left for the clock.
    pub(super) fn new(listeners: Vec<Listener<ipc::Service>, N>) -> Result<Self, Errno> {
        const { assert!(N < MOST) }
        let flags = TimerfdFlags::CLOEXEC | TimerfdFlags::NONBLOCK;
        Ok(Self {
            listeners,
            clock: timerfd_create(TimerfdClockId::Monotonic, flags)?,
            period: Cell::new(Duration::ZERO),
        })
    }

    /// Sleeps until something rings or a signal comes, but no longer than this time, often
    /// less; whether there may be something to look for.
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
        self.strike_every(longest)
            .map_err(|_| ListenerWaitError::InternalFailure)?;
        let bells = self.listeners.iter().map(|listener| {
            // SAFETY: it is open as long as the listener, which outlives this.
            unsafe { BorrowedFd::borrow_raw(listener.file_descriptor().native_handle()) }
        });
        let all = bells.chain([self.clock.as_fd()]);
        let mut all: Vec<_, MOST> = all
            .map(|each| PollFd::from_borrowed_fd(each, PollFlags::IN))
            .collect();
        match poll(&mut all, None) {
            Ok(how_many) => {
                let has_struck = all.last().is_some_and(|clock| !clock.revents().is_empty());
                if has_struck {
                    let _ = read(&self.clock, &mut [0_u8; 8]);
                }
                Ok(how_many > usize::from(has_struck))
            }
            Err(Errno::INTR) => Ok(false),
            Err(_) => Err(ListenerWaitError::InternalFailure),
        }
    }

    fn strike_every(&self, period: Duration) -> Result<(), Errno> {
        // None would stop it.
        let period = period.max(Duration::from_nanos(1));
        if self.period.replace(period) == period {
            return Ok(());
        }
        // What is too long for it is for ever.
        let never = Timespec {
            tv_sec: 0,
            tv_nsec: 0,
        };
        let each = Timespec::try_from(period).unwrap_or(never);
        let times = Itimerspec {
            it_interval: each,
            it_value: each,
        };
        timerfd_settime(&self.clock, TimerfdTimerFlags::empty(), &times).map(drop)
    }

    /// Whether something has rung since this was asked last, or heard out. Never waits.
    /// Errors: as [`Ears::wait`].
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
