//! How fast the same networks are elsewhere: each contender is a process of its own that computes the
//! same [`Job`]s on the same [`Inputs`], and the driver (`src/main.rs`) times them in turn.
//!
//! * [`Job`]: what is computed;
//! * [`Inputs`]: what it is computed from, written to a file once;
//! * [`serve`]: a contender's side of the protocol, and [`Contender`] and [`Work`], which it is made of;
//! * [`ours`]: our own contender, with and without wide vectors;
//! * [`Outputs`]: what was computed, in one form for all.

mod inputs;
mod job;
mod locked;
pub mod ours;
mod outputs;
mod protocol;
mod scene;

pub use inputs::{Inputs, Numbers, Tensor};
pub use job::Job;
pub use locked::locked_version;
pub use outputs::{Outputs, TOLERANCE};
pub use protocol::{Contender, Prepared, Work, serve};
pub use scene::{ONE_STEP, Table};
