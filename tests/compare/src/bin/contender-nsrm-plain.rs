//! Our inference with the vectors that every x86-64 has.

#![forbid(unsafe_code)]

use nsrm_compare::{ours::Ours, serve};

fn main() -> anyhow::Result<()> {
    serve(|_| Ours::new())
}
