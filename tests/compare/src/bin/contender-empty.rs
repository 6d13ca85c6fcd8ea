//! Does nothing: what it takes is the clock's own time and the machine's noise.

use std::hint::black_box;

use anyhow::Result;
use nsrm_compare::{Contender, Inputs, Job, Outputs, Prepared, Work, serve};

struct Empty;

impl Contender for Empty {
    fn version(&self) -> String {
        "nothing but the clock".to_owned()
    }

    fn prepare(&mut self, _job: Job, _inputs: &Inputs) -> Result<Prepared> {
        Ok(Prepared::Ready(Box::new(Self)))
    }
}

impl Work for Empty {
    fn run(&mut self) -> Result<()> {
        black_box(());
        Ok(())
    }

    fn outputs(&mut self) -> Result<Outputs> {
        Ok(Outputs::default())
    }
}

fn main() -> Result<()> {
    serve(|_| Ok(Empty))
}
