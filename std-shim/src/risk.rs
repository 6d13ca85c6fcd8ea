//! The least confidence of a plan at which few of the accepted plans are wrong, with a guarantee.
//!
//! Plans of sentences whose meaning is known are judged. For each of [`THRESHOLDS`], those at least
//! as confident give an upper bound on the share of wrong ones among all plans that would be
//! accepted (Clopper and Pearson, exact for any number). The bounds hold together, because each has
//! an equal part of the allowed error (Bonferroni), so the smallest threshold whose bound keeps
//! the limit can be taken: Learn then Test (Angelopoulos et al., 2021), for a risk that counts.
//!
//! The guarantee is for sentences and scenes like the judged ones, drawn independently.
//!
//! ```
//! use nsrm::risk::{Judged, RiskLimit, least_confidence};
//!
//! let judged = vec![Judged { confidence: Some(0.97), right: true }; 1000];
//! let limit = RiskLimit { wrong: 0.01, level: 0.95 };
//! assert_eq!(least_confidence(&judged, limit)?.threshold, 0.0);
//! # Ok::<(), nsrm::risk::RiskError>(())
//! ```

use statrs::distribution::{Beta, ContinuousCDF};
use thiserror::Error;

/// The thresholds that are tried. Fixed beforehand, as the guarantee demands.
pub const THRESHOLDS: [f32; 10] = [0.0, 0.5, 0.8, 0.9, 0.95, 0.98, 0.99, 0.995, 0.998, 0.999];

/// The plan of a sentence whose meaning is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Judged {
    /// [`nsrm_core::Plan::confidence`]; `None` if the sentence was refused.
    pub confidence: Option<f32>,
    /// Whether the plan does what was meant. A sentence that means nothing has no right plan.
    pub right: bool,
}

/// What is to be guaranteed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RiskLimit {
    /// The greatest share of wrong plans among those that are accepted: above 0, below 1.
    pub wrong: f64,
    /// The probability with which it is kept, over the choice of the judged sentences: above 0,
    /// below 1.
    pub level: f64,
}

impl Default for RiskLimit {
    /// At most one of a thousand, with a probability of 95 %.
    fn default() -> Self {
        Self {
            wrong: 0.001,
            level: 0.95,
        }
    }
}

impl RiskLimit {
    /// Checks that it is a share and a probability.
    ///
    /// # Errors
    /// [`RiskError::Limit`] if one of them is outside its range.
    pub fn check(&self) -> Result<(), RiskError> {
        let inside = |share: f64| share > 0.0 && share < 1.0;
        if inside(self.wrong) && inside(self.level) {
            return Ok(());
        }
        Err(RiskError::Limit(*self))
    }
}

/// What is accepted at a threshold.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Accepted {
    /// Plans of at least this confidence are accepted.
    pub threshold: f32,
    /// How many are accepted.
    pub count: usize,
    /// How many of those are wrong.
    pub wrong: usize,
    /// The greatest share of wrong ones that agrees with these numbers, at the limit's level for
    /// all thresholds together.
    pub bound: f64,
}

/// Why there is no such threshold.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum RiskError {
    /// The limit is not a share, or its level not a probability.
    #[error(
        "expected a limit and a level between 0 and 1, got a limit of {} and a level of {}",
        .0.wrong, .0.level
    )]
    Limit(RiskLimit),
    /// Even without a wrong plan, so few say too little.
    #[error(
        "{accepted} accepted plans are too few for this limit; at least {needed} are needed: judge \
         more sentences, or set a greater limit"
    )]
    TooFew {
        /// How many are accepted at the lowest threshold.
        accepted: usize,
        /// How many would do if none were wrong.
        needed: usize,
    },
    /// At each threshold, too many are wrong or too few accepted.
    #[error(
        "no threshold keeps the limit; at the best one, {}, {} of {} plans are wrong, and the share \
         of wrong ones may be {:.5}: judge more sentences, or set a greater limit",
        .best.threshold, .best.wrong, .best.count, .best.bound
    )]
    NotKept {
        /// The threshold with the smallest bound.
        best: Accepted,
    },
}

/// The smallest of [`THRESHOLDS`] that keeps the limit.
///
/// # Errors
/// [`RiskError`] if the judged plans cannot guarantee the limit at any threshold.
pub fn least_confidence(judged: &[Judged], limit: RiskLimit) -> Result<Accepted, RiskError> {
    limit.check()?;
    let rows = accepted(judged, limit.level)?;
    if let Some(row) = rows.iter().find(|row| row.bound <= limit.wrong) {
        return Ok(*row);
    }
    let needed = (error_of_each(limit.level).ln() / (1.0 - limit.wrong).ln()).ceil() as usize;
    let [all, ..] = rows;
    if all.count < needed {
        return Err(RiskError::TooFew {
            accepted: all.count,
            needed,
        });
    }
    let best = rows
        .into_iter()
        .reduce(|best, row| if row.bound < best.bound { row } else { best })
        .unwrap_or(all);
    Err(RiskError::NotKept { best })
}

/// What is accepted at each of [`THRESHOLDS`], with bounds that hold together at a level.
///
/// # Errors
/// [`RiskError::Limit`] if the level is not a probability between 0 and 1.
pub fn accepted(judged: &[Judged], level: f64) -> Result<[Accepted; THRESHOLDS.len()], RiskError> {
    let usual = RiskLimit::default();
    RiskLimit { level, ..usual }.check()?;
    Ok(THRESHOLDS.map(|threshold| {
        let plans = judged.iter().filter(|plan| {
            let confidence = plan.confidence;
            confidence.is_some_and(|confidence| confidence >= threshold)
        });
        let (mut count, mut wrong) = (0, 0);
        for plan in plans {
            count += 1;
            wrong += usize::from(!plan.right);
        }
        Accepted {
            threshold,
            count,
            wrong,
            bound: upper_bound(wrong, count, error_of_each(level)),
        }
    }))
}

/// The allowed error of each threshold's bound.
fn error_of_each(level: f64) -> f64 {
    (1.0 - level) / THRESHOLDS.len() as f64
}

/// The share that is exceeded with a probability of at most `error`, after `wrong` of `count`.
fn upper_bound(wrong: usize, count: usize, error: f64) -> f64 {
    if wrong == count {
        return 1.0;
    }
    // Never fails: both parameters are at least 1.
    Beta::new(wrong as f64 + 1.0, (count - wrong) as f64)
        .map_or(1.0, |beta| beta.inverse_cdf(1.0 - error))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plans(confidence: f32, right: usize, wrong: usize) -> Vec<Judged> {
        let plan = |right| Judged {
            confidence: Some(confidence),
            right,
        };
        let right = std::iter::repeat_n(plan(true), right);
        right
            .chain(std::iter::repeat_n(plan(false), wrong))
            .collect()
    }

    #[test]
    fn bounds_are_those_of_clopper_and_pearson() {
        // Without a wrong one the bound is 1 - error^(1/count); the others are SciPy's beta.ppf.
        for (wrong, count, error, expected) in [
            (0, 2995, 0.05, 1.0 - 0.05_f64.powf(1.0 / 2995.0)),
            (1, 100, 0.025, 0.054_459_39),
            (10, 100, 0.025, 0.176_222_7),
            (5, 5, 0.05, 1.0),
            (0, 0, 0.05, 1.0),
        ] {
            let bound = upper_bound(wrong, count, error);
            assert!(
                (bound - expected).abs() < 1e-6,
                "{wrong} of {count}: {bound}"
            );
        }
    }

    #[test]
    fn the_smallest_threshold_that_keeps_the_limit_is_taken() {
        let limit = RiskLimit::default();
        let good = plans(0.9995, 6000, 0);
        assert_eq!(least_confidence(&good, limit).unwrap().threshold, 0.0);
        // Refused sentences count nowhere.
        let refused = Judged {
            confidence: None,
            right: false,
        };
        let with_refused = [good.clone(), vec![refused; 100]].concat();
        assert_eq!(least_confidence(&with_refused, limit).unwrap().count, 6000);
        // Three wrong ones of little confidence have to be refused, and right ones with them.
        let doubtful = [good, plans(0.85, 100, 3)].concat();
        let found = least_confidence(&doubtful, limit).unwrap();
        assert_eq!((found.threshold, found.count, found.wrong), (0.9, 6000, 0));
        assert!(found.bound <= limit.wrong);
    }

    #[test]
    fn what_cannot_be_guaranteed_is_an_error() {
        let limit = RiskLimit::default();
        let needed = 5296;
        let accepted = needed - 1;
        assert_eq!(
            least_confidence(&plans(0.9995, accepted, 0), limit),
            Err(RiskError::TooFew { accepted, needed })
        );
        assert!(least_confidence(&plans(0.9995, needed, 0), limit).is_ok());
        let error = least_confidence(&plans(0.97, 6000, 60), limit).unwrap_err();
        assert!(matches!(error, RiskError::NotKept { best } if best.wrong == 60));
        for (wrong, level) in [(0.0, 0.95), (1.0, 0.95), (0.1, 1.0), (0.1, f64::NAN)] {
            let limit = RiskLimit { wrong, level };
            let error = least_confidence(&[], limit).unwrap_err();
            assert!(matches!(error, RiskError::Limit(..)), "{error}");
        }
    }
}
