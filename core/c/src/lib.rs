//! The C interface of `nsrm-core`: everything that `include/nsrm.h` declares.
//!
//! All memory is the caller's, and nothing here allocates or panics. Each function checks its
//! pointers for null and alignment, the numbers behind them once, and the text for UTF-8; it cannot
//! check that a pointer points to as much memory as it should.
//!
//! `examples/header.rs` writes the header from this crate, and `tests/header.rs` compares it.
#![cfg_attr(not(any(feature = "vectors", panic = "unwind", test)), no_std)]
// What the header declares is public there; no Rust crate uses it.
#![allow(unreachable_pub)]

mod capacity;
mod memory;
mod model;
#[cfg(feature = "vision")]
mod observer;
mod plan;
mod pointers;
mod program;
mod refusal;
mod scene;
mod status;
mod task;
mod text;

/// What `nsrm-core` proves not to happen: without a standard library somebody must say so.
#[cfg(not(any(feature = "vectors", panic = "unwind", test)))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
