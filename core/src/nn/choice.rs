use super::activation;

/// Softmax and argmax over logits that come one by one: no scratch, any number.
///
/// The probability of the greatest logit `m` is `1 / Σ exp(l_i − m)`; the sum is
/// rescaled when a greater logit comes. Of equal logits the first wins.
///
/// ```
/// use nsrm_core::nn::Choice;
/// let mut choice = Choice::new();
/// for logit in [0.0, 3.0_f32.ln(), f32::ln(1.0)] {
///     choice.offer(logit);
/// }
/// assert_eq!(choice.index(), Some(1));
/// assert!((choice.probability() - 0.6).abs() < 1e-6);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Choice {
    offered: usize,
    index: usize,
    greatest: f32,
    sum: f32,
    finite: bool,
}

impl Choice {
    /// Nothing offered yet.
    pub const fn new() -> Self {
        Self {
            offered: 0,
            index: 0,
            greatest: f32::NEG_INFINITY,
            sum: 0.0,
            finite: true,
        }
    }

    /// Takes the next logit into account. Cost: one exponential.
    pub fn offer(&mut self, logit: f32) {
        self.finite &= logit.is_finite();
        if logit > self.greatest {
            self.sum = self.sum * activation::exp(self.greatest - logit) + 1.0;
            self.greatest = logit;
            self.index = self.offered;
        } else {
            self.sum += activation::exp(logit - self.greatest);
        }
        self.offered = self.offered.wrapping_add(1);
    }

    /// Leaves the next index out: it is not chosen, and those behind it keep theirs.
    pub fn skip(&mut self) {
        self.offered = self.offered.wrapping_add(1);
    }

    /// Index of the greatest logit, in the order of offering; `None` if none was offered or one was
    /// not finite.
    pub fn index(&self) -> Option<usize> {
        (self.sum > 0.0 && self.finite).then_some(self.index)
    }

    /// Probability of the greatest logit; meaningful where [`Choice::index`] is `Some`.
    pub fn probability(&self) -> f32 {
        1.0 / self.sum
    }
}

impl Default for Choice {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn choose(logits: &[f32]) -> Choice {
        let mut choice = Choice::new();
        logits.iter().for_each(|&logit| choice.offer(logit));
        choice
    }

    #[test]
    fn the_order_changes_the_index_alone() {
        let (up, down) = (choose(&[1.0, 2.0, 4.0]), choose(&[4.0, 2.0, 1.0]));
        assert_eq!((up.index(), down.index()), (Some(2), Some(0)));
        // 1 / (1 + e^-2 + e^-3)
        for choice in [up, down] {
            assert!((choice.probability() - 0.843_795).abs() < 1e-6);
        }
    }

    #[test]
    fn a_tie_goes_to_the_first_and_a_lone_logit_is_certain() {
        let tie = choose(&[-1.0, 7.0, 7.0]);
        assert_eq!(tie.index(), Some(1));
        assert!((tie.probability() - 0.499_916).abs() < 1e-5);
        assert_eq!(choose(&[-3e38]).probability(), 1.0);
    }

    #[test]
    fn a_skipped_index_is_not_chosen() {
        let mut choice = Choice::new();
        choice.skip();
        assert_eq!(choice.index(), None);
        choice.offer(1.0);
        choice.skip();
        choice.offer(2.0);
        assert_eq!(choice.index(), Some(3));
        // 1 / (1 + e^-1)
        assert!((choice.probability() - 0.731_059).abs() < 1e-6);
    }

    #[test]
    fn great_logits_do_not_overflow_and_what_is_not_finite_is_seen() {
        assert_eq!(choose(&[-3e38, 3e38]).probability(), 1.0);
        assert_eq!(choose(&[]).index(), None);
        assert_eq!(choose(&[1.0, f32::NAN]).index(), None);
        assert_eq!(choose(&[f32::INFINITY, 0.0]).index(), None);
    }
}
