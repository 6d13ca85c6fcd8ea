//! Instructions and stack.

use core::arch::asm;
use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::exception;

/// Counts ticks of the system's timer, which QEMU derives from the number of instructions.
pub struct Clock {
    _timer: SYST,
}

/// The timer has 24 bits, and counts down.
const RANGE: u32 = 1 << 24;

/// How often it began anew.
static ROUNDS: AtomicU32 = AtomicU32::new(0);

#[exception]
fn SysTick() {
    ROUNDS.store(ROUNDS.load(Ordering::Relaxed) + 1, Ordering::Relaxed);
}

impl Clock {
    /// Starts it.
    pub fn start(mut timer: SYST) -> Self {
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(RANGE - 1);
        timer.clear_current();
        timer.enable_interrupt();
        timer.enable_counter();
        Self { _timer: timer }
    }

    /// Ticks while something runs.
    #[inline(never)]
    pub fn ticks<R>(&mut self, run: impl FnOnce() -> R) -> (R, u64) {
        let before = self.now();
        let result = run();
        (result, self.now() - before)
    }

    fn now(&self) -> u64 {
        loop {
            let rounds = ROUNDS.load(Ordering::Relaxed);
            let left = SYST::get_current();
            if rounds == ROUNDS.load(Ordering::Relaxed) {
                return u64::from(rounds) * u64::from(RANGE) + u64::from(RANGE - left);
            }
        }
    }
}

/// What unused stack is filled with.
const UNUSED: u32 = 0x5afe_57ac;

unsafe extern "C" {
    /// The end of static memory; the stack grows down towards it.
    static mut __sheap: u32;
}

#[inline(always)]
fn stack_pointer() -> usize {
    let pointer: usize;
    // SAFETY: reads a register.
    unsafe { asm!("mov {}, sp", out(reg) pointer, options(nomem, nostack, preserves_flags)) };
    pointer
}

/// Bytes of stack that something takes below the caller's.
#[inline(never)]
pub fn stack<R>(run: impl FnOnce() -> R) -> (R, usize) {
    let bottom = (&raw mut __sheap).cast::<u32>();
    // This function's own frame stays as it is.
    let top = (stack_pointer() - 64) as *mut u32;
    let mut word = bottom;
    while word < top {
        // SAFETY: between static memory and the stack nothing lies.
        unsafe {
            word.write_volatile(UNUSED);
            word = word.add(1);
        }
    }
    let result = run();
    let mut word = bottom;
    // SAFETY: as above.
    while word < top && unsafe { word.read_volatile() } == UNUSED {
        // SAFETY: as above.
        word = unsafe { word.add(1) };
    }
    (result, top as usize + 64 - word as usize)
}
