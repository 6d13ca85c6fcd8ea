//! Plans and refusals for a person: sentences written through `core::fmt`, without
//! allocation, off the bounded path.

mod calibration;
mod plan;
mod refusal;
mod unknown_word;
