//! Our inference as a user of crate `nsrm` has it: on vectors as wide as the processor's.

#![forbid(unsafe_code)]

use nsrm_compare::{ours::Ours, serve};

fn main() -> anyhow::Result<()> {
    serve(|_| Ours::new())
}
