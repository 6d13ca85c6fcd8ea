//! Memory of the caller in which something lives between calls.

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicU32, Ordering};

use crate::pointers;
use crate::status::Status;

/// Nobody uses it: something was begun. Any other value is memory in which nothing was.
const BEGUN: u32 = 0x4e53_524d;
/// A call uses it.
const BUSY: u32 = 0x4e53_5242;

/// A value in the caller's memory, and whether it is used. It is never dropped: it must own nothing that
/// lies elsewhere.
#[repr(C)]
pub(crate) struct Slot<T> {
    state: AtomicU32,
    value: UnsafeCell<MaybeUninit<T>>,
}

impl<T> Slot<T> {
    /// Puts a value here, over whatever was here. It is made only if no other call uses the memory.
    ///
    /// # Safety
    /// If it is neither null nor misaligned, it points to memory for a slot.
    pub(crate) unsafe fn begin(
        slot: *mut Self,
        make: impl FnOnce() -> Result<T, Status>,
    ) -> Result<(), Status> {
        // SAFETY: the caller's promise; every bit pattern is a slot.
        let slot: &Self = unsafe { pointers::read(slot) }?;
        if slot.state.swap(BUSY, Ordering::Acquire) == BUSY {
            return Err(Status::ErrorBusy);
        }
        let result = make().map(|value| {
            // SAFETY: the state says that nobody else uses it.
            unsafe { &mut *slot.value.get() }.write(value);
        });
        let state = if result.is_ok() { BEGUN } else { 0 };
        slot.state.store(state, Ordering::Release);
        result
    }

    /// Uses the value.
    ///
    /// # Safety
    /// As [`Slot::begin`]'s.
    pub(crate) unsafe fn with<R>(
        slot: *mut Self,
        run: impl FnOnce(&mut T) -> Result<R, Status>,
    ) -> Result<R, Status> {
        // SAFETY: the caller's promise; every bit pattern is a slot.
        let slot: &Self = unsafe { pointers::read(slot) }?;
        let taken = slot
            .state
            .compare_exchange(BEGUN, BUSY, Ordering::Acquire, Ordering::Relaxed);
        match taken {
            Ok(_) => {
                // SAFETY: the state says that there is a value, and that nobody else uses it.
                let result = run(unsafe { (*slot.value.get()).assume_init_mut() });
                slot.state.store(BEGUN, Ordering::Release);
                result
            }
            Err(BUSY) => Err(Status::ErrorBusy),
            Err(_) => Err(Status::ErrorNotBegun),
        }
    }
}
