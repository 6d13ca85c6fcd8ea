//! Neuro-symbolic robot manipulation: a sentence and a scene in, the program
//! understood and the sub-goals out. `no_std`, no allocation, bounded time.
#![no_std]
#![forbid(unsafe_code)]

pub mod model;
pub mod nn;
