//! The distribution of a job's times.

use anyhow::Result;
use hdrhistogram::Histogram;

/// Percentiles of a job's times in microseconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Percentiles {
    /// Half of all runs take at most this.
    pub(crate) p50_us: f64,
    /// 99 of 100 runs take at most this.
    pub(crate) p99_us: f64,
    /// 9,999 of 10,000 runs take at most this.
    pub(crate) p9999_us: f64,
}

/// Times in nanoseconds, to three digits.
#[derive(Debug, Clone)]
pub(crate) struct Times(Histogram<u64>);

impl Times {
    /// No times yet.
    pub(crate) fn new() -> Result<Self> {
        Ok(Self(Histogram::new(3)?))
    }

    /// Adds those of a block.
    pub(crate) fn add(&mut self, times: &[u64]) -> Result<()> {
        for &time in times {
            self.0.record(time)?;
        }
        Ok(())
    }

    /// The percentiles so far.
    pub(crate) fn percentiles(&self) -> Percentiles {
        let at = |share| self.0.value_at_quantile(share) as f64 / 1000.0;
        Percentiles {
            p50_us: at(0.5),
            p99_us: at(0.99),
            p9999_us: at(0.9999),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_times_within_which_that_share_lies() {
        let mut times = Times::new().unwrap();
        // 1 to 10,000 µs, in two blocks and not in order.
        let all: Vec<u64> = (1..=10_000).rev().map(|us| 1000 * us).collect();
        let (late, early) = all.split_at(4_000);
        times.add(late).unwrap();
        times.add(early).unwrap();
        let got = times.percentiles();
        for (got, expected) in [
            (got.p50_us, 5_000.0),
            (got.p99_us, 9_900.0),
            (got.p9999_us, 9_999.0),
        ] {
            assert!((got / expected - 1.0_f64).abs() < 2e-3, "{got} {expected}");
        }
    }

    #[test]
    fn short_times_are_exact() {
        let mut times = Times::new().unwrap();
        times.add(&[21, 22, 23]).unwrap();
        assert_eq!(times.percentiles().p50_us, 0.022);
    }
}
