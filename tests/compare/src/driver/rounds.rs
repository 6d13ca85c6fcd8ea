//! Times the contenders in turn.

use anyhow::Result;
use indicatif::{ProgressBar, ProgressStyle};
use nsrm_compare::Job;

use super::Missing;
use super::child::Child;
use super::times::{Percentiles, Times};

/// How much is timed: in each round of a job every contender has one block of runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Rounds {
    /// Blocks of each contender.
    pub(crate) blocks: usize,
    /// Timed runs of a block.
    pub(crate) runs: usize,
    /// Runs before those, after which caches hold this contender's data again.
    pub(crate) warm_up: usize,
}

/// The times of a contender's job.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Measured {
    pub(crate) contender: &'static str,
    pub(crate) job: Job,
    pub(crate) times: Percentiles,
}

impl Rounds {
    /// Enough for the time that one run of 10,000 exceeds.
    pub(crate) const FULL: Self = Self {
        blocks: 500,
        runs: 200,
        warm_up: 20,
    };
    /// Enough to see that everything works.
    pub(crate) const QUICK: Self = Self {
        blocks: 25,
        runs: 100,
        warm_up: 20,
    };

    /// Times all jobs, except those that a contender cannot express.
    pub(crate) fn run(self, children: &mut [Child], missing: &[Missing]) -> Result<Vec<Measured>> {
        let style =
            ProgressStyle::with_template("{msg:>10} {wide_bar} {percent:>3} % ({eta} left)");
        let bar = ProgressBar::new((Job::ALL.len() * self.blocks) as u64).with_style(style?);
        let mut measured = Vec::new();
        for job in Job::ALL {
            bar.set_message(job.name());
            if bar.is_hidden() {
                eprintln!("timing {job}");
            }
            measured.extend(self.job(job, children, missing, &bar)?);
        }
        bar.finish_and_clear();
        Ok(measured)
    }

    fn job(
        self,
        job: Job,
        children: &mut [Child],
        missing: &[Missing],
        bar: &ProgressBar,
    ) -> Result<Vec<Measured>> {
        let can = |child: &&mut Child| {
            let mut missing = missing.iter();
            !missing.any(|entry| entry.job == job && entry.contender == child.name())
        };
        let mut able: Vec<&mut Child> = children.iter_mut().filter(can).collect();
        let mut times = able
            .iter()
            .map(|_| Times::new())
            .collect::<Result<Vec<_>>>()?;
        let count = able.len();
        for block in 0..self.blocks {
            // Each comes first equally often: none always follows the same one.
            for turn in 0..count {
                let at = turn_of(block, turn, count);
                able[at].time(job, self.warm_up)?;
                times[at].add(&able[at].time(job, self.runs)?)?;
            }
            bar.inc(1);
        }
        let measured = able.iter().zip(&times).map(|(child, times)| Measured {
            contender: child.name(),
            job,
            times: times.percentiles(),
        });
        Ok(measured.collect())
    }
}

/// Whose turn it is: forward and backward in turn, from another one each time.
fn turn_of(block: usize, turn: usize, count: usize) -> usize {
    let turn = if block.is_multiple_of(2) {
        turn
    } else {
        count - 1 - turn
    };
    (turn + block / 2) % count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_block_has_everyone_once_and_everyone_is_first_in_turn() {
        let count = 5;
        let mut first = vec![0; count];
        for block in 0..2 * count {
            let mut order: Vec<_> = (0..count).map(|turn| turn_of(block, turn, count)).collect();
            first[order[0]] += 1;
            order.sort_unstable();
            assert_eq!(order, [0, 1, 2, 3, 4]);
        }
        assert_eq!(first, [2; 5]);
    }
}
