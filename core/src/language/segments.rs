use core::ops::Range;

use heapless::Vec;

use super::{Span, Token};
use crate::capacity::MAX_STEPS;
use crate::refusal::Refusal;

/// Which tokens of a sentence belong to which step. Steps count from 0.
#[derive(Debug, Clone)]
pub(super) struct Segments {
    segments: Vec<Segment, MAX_STEPS, u8>,
}

/// The tokens of one step: from the end of the previous step to `end`, without the first ones that only connect it
/// to that step.
#[derive(Debug, Clone, Copy)]
struct Segment {
    connecting: usize,
    end: usize,
    probability: f32,
}

impl Segments {
    pub(super) const fn new() -> Self {
        Self {
            segments: Vec::new(),
        }
    }

    /// The next step ends before token `end`, with this probability.
    pub(super) fn end(&mut self, end: usize, probability: f32) -> Result<(), Refusal> {
        let segment = Segment {
            connecting: 0,
            end,
            probability,
        };
        self.segments
            .push(segment)
            .map_err(|_| Refusal::TooManySteps {
                limit: MAX_STEPS as u8,
            })
    }

    /// The first tokens of a step, so many, only connect it to the previous one: from now on they are no part of it.
    pub(super) fn connect(&mut self, step: usize, tokens: usize) {
        if let Some(segment) = self.segments.get_mut(step) {
            segment.connecting = tokens;
        }
    }

    /// How many steps have ended.
    pub(super) fn count(&self) -> usize {
        self.segments.len()
    }

    /// The probability that the step ends there; `None` after the last step.
    pub(super) fn probability(&self, step: usize) -> Option<f32> {
        self.segments.get(step).map(|segment| segment.probability)
    }

    /// Those of all steps.
    pub(super) fn probabilities(&self) -> impl Iterator<Item = f32> + Clone {
        self.segments.iter().map(|segment| segment.probability)
    }

    /// The places of the step's tokens in the sentence.
    pub(super) fn tokens(&self, step: usize) -> Range<usize> {
        let end_of = |step: usize| self.segments.get(step).map_or(0, |segment| segment.end);
        let start = step.checked_sub(1).map_or(0, end_of);
        let connecting = self
            .segments
            .get(step)
            .map_or(0, |segment| segment.connecting);
        start.saturating_add(connecting)..end_of(step)
    }

    /// The step's place in the sentence.
    ///
    /// * `sentence`: all tokens
    pub(super) fn span(&self, step: usize, sentence: &[Token]) -> Span {
        let tokens = sentence.get(self.tokens(step)).unwrap_or_default();
        // Those of towers and rows are in another order.
        let spans = tokens.iter().map(|token| token.span);
        Span {
            start: spans.clone().map(|span| span.start).min().unwrap_or(0),
            end: spans.map(|span| span.end).max().unwrap_or(0),
        }
    }

    /// The step's groups of concept words, and its pronouns that are read as groups.
    ///
    /// * `sentence`: all tokens
    pub(super) fn groups<'t>(
        &self,
        step: usize,
        sentence: &'t [Token],
    ) -> impl Iterator<Item = &'t Token> + Clone + use<'t> {
        let tokens = sentence.get(self.tokens(step)).unwrap_or_default();
        tokens.iter().filter(|token| token.is_group())
    }
}
