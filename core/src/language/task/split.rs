//! From the words of a sentence to its steps. Where the splitter is unsure or its steps make no sense,
//! the sentence is also parsed with each of its least sure decisions reversed.

use heapless::Vec;

use super::{ParsingTask, Stage, not_finite};
use crate::capacity::MAX_SPLITS;
use crate::language::segments::Segments;
use crate::language::splitter::{Splitter, decision};
use crate::language::{Parsed, Token};
use crate::refusal::{Decision, Quantity, Refusal};

/// A decision of the splitter that is more probable than this is never reversed: where the steps
/// make no sense, the prior alone would otherwise not keep a far-fetched split from being obeyed.
const CERTAIN: f32 = 0.98;

/// The ways in which one reading of a sentence is split: that of the splitter first, then with one
/// decision reversed.
#[derive(Debug, Clone)]
pub(super) struct Splits {
    /// The least sure decisions of the splitter, the least sure first.
    doubts: Vec<Doubt, { MAX_SPLITS - 1 }, u8>,
    /// Whether the end of a step is less probable than it must be.
    is_unclear: bool,
    /// The probability of all other decisions together.
    others: f32,
    /// How many ways were parsed to the end.
    parsed: usize,
    /// The most probable one of them.
    best: Option<Attempt>,
    /// The weights of all of them.
    total: f32,
    /// How the first one ended.
    refusal: Option<Refusal>,
}

/// Whether a step ends at a token, of which the splitter is not certain.
#[derive(Debug, Clone, Copy)]
struct Doubt {
    step: usize,
    token: usize,
    /// That the splitter's decision is right, ½ or more.
    probability: f32,
}

/// How the parsing of one way ended.
#[derive(Debug, Clone)]
struct Attempt {
    parsed: Parsed,
    refusal: Option<Refusal>,
    /// The step with the decision that this way is about.
    step: usize,
    /// In proportion to its probability.
    weight: f32,
}

impl Splits {
    pub(super) const fn new() -> Self {
        Self {
            doubts: Vec::new(),
            is_unclear: false,
            others: 1.0,
            parsed: 0,
            best: None,
            total: 0.0,
            refusal: None,
        }
    }

    /// The decision that is reversed in the way that is being parsed.
    fn reversed(&self) -> Option<Doubt> {
        self.doubts.get(self.parsed.checked_sub(1)?).copied()
    }

    /// Whether a decision is reversed in the way that is being parsed; else it is the splitter's own.
    pub(super) fn is_reversed(&self) -> bool {
        self.parsed > 0
    }

    /// The sentence is split as the splitter decided, into steps with ends of these probabilities.
    fn end(&mut self, probabilities: impl Iterator<Item = f32> + Clone, threshold: f32) {
        self.is_unclear = probabilities
            .clone()
            .any(|probability| probability < threshold);
        let doubts = self.doubts.iter().map(|doubt| doubt.probability);
        self.others = probabilities.product::<f32>() / doubts.product::<f32>();
    }

    /// Whether the step ends at a token with this hazard, and with which probability.
    fn decide(&mut self, step: usize, token: usize, hazard: f32) -> (bool, f32) {
        let (ends, probability) = decision(hazard);
        match self.reversed() {
            Some(doubt) if doubt.token == token => return (!ends, 1.0),
            Some(_) => {}
            None => self.note(Doubt {
                step,
                token,
                probability,
            }),
        }
        (ends, probability)
    }

    /// Keeps a decision if it is one of the least sure.
    fn note(&mut self, doubt: Doubt) {
        if doubt.probability > CERTAIN {
            return;
        }
        let mut surer = doubt;
        for kept in &mut self.doubts {
            if surer.probability < kept.probability {
                core::mem::swap(kept, &mut surer);
            }
        }
        // If there is no place, the surest is left out.
        let _ = self.doubts.push(surer);
    }

    /// Takes the end of one way into account.
    ///
    /// * `sense`: how much its steps make
    fn add(&mut self, parsed: Parsed, refusal: Option<Refusal>, sense: f32) {
        let (step, prior) = match self.reversed() {
            Some(Doubt {
                step, probability, ..
            }) => (step, (1.0 - probability) / probability),
            None => (self.doubts.first().map_or(0, |doubt| doubt.step), 1.0),
        };
        let weight = prior * sense;
        if self.parsed == 0 {
            self.refusal = refusal;
        }
        self.parsed = self.parsed.saturating_add(1);
        self.total += weight;
        match &mut self.best {
            // Words between two steps may belong to either.
            Some(best)
                if best.refusal.is_none()
                    && refusal.is_none()
                    && best.parsed.program == parsed.program =>
            {
                best.weight += weight;
            }
            Some(best) if best.weight >= weight => {}
            best => {
                *best = Some(Attempt {
                    parsed,
                    refusal,
                    step,
                    weight,
                });
            }
        }
    }
}

/// How much sense the words make as they were split: the probability of all that was decided about
/// the steps.
fn sense(parsed: &Parsed) -> f32 {
    let steps = parsed
        .decisions
        .iter()
        .map(|step| step.words * step.action * step.relations * step.object * step.reference);
    steps.product()
}

impl<T: AsRef<str>> ParsingTask<'_, T> {
    /// Whether a step ends at a token; from the first token to the last.
    pub(super) fn split(&mut self, token: usize) -> Result<Stage, Refusal> {
        let (model, tokens) = (self.model, self.reader.tokens());
        let behind = token.saturating_add(1);
        let Some(ahead) = tokens.get(behind..).filter(|ahead| !ahead.is_empty()) else {
            // Nothing follows: what remains is the last step.
            self.segments.end(behind, self.splitter.survival())?;
            if !self.splits.is_reversed() {
                let threshold = model.header.thresholds.decision;
                self.splits.end(self.segments.probabilities(), threshold);
            }
            return Ok(Stage::Step { step: 0 });
        };
        let word = |token: &Token| model.embeddings.splitter(token.embedding()?);
        let this = tokens
            .get(token)
            .and_then(word)
            .ok_or(Refusal::InvalidModel)?;
        let ahead = ahead.iter().map_while(word);
        let hazard = self.splitter.hazard(&model.language, &this, ahead);
        let step = self.segments.count();
        if !hazard.is_finite() {
            return Err(not_finite(step, Quantity::Split));
        }
        let (ends, probability) = self.splits.decide(step, token, hazard);
        if let Some(probability) = self.splitter.follow(ends, probability) {
            self.segments.end(behind, probability)?;
            self.splitter = Splitter::new();
        }
        Ok(Stage::Split { token: behind })
    }

    /// The sentence was parsed to its end as it was split, or it has a step that no command has:
    /// another way is next, if there is one.
    pub(super) fn end_way(&mut self, error: Option<Refusal>) -> Stage {
        if error.is_some_and(is_final) {
            return self.end_reading(error);
        }
        let unclear = self.unclear.take();
        let refusal = self.doubt.take().or(error);
        if refusal.is_none()
            && let Some((step, span)) = unclear
        {
            return self.end_reading(Some(Refusal::UnclearPronoun { step, span }));
        }
        let is_clear = !self.splits.is_reversed() && !self.splits.is_unclear;
        if refusal.is_none() && is_clear {
            return self.end_reading(None);
        }
        let parsed = core::mem::replace(&mut self.parsed, Parsed::empty(self.model));
        let sense = if error.is_none() { sense(&parsed) } else { 0.0 };
        self.splits.add(parsed, refusal, sense);
        if self.splits.reversed().is_some() {
            self.splitter = Splitter::new();
            self.segments = Segments::new();
            return Stage::Split { token: 0 };
        }
        let refusal = self.settle();
        self.end_reading(refusal)
    }

    /// Chooses the most probable way to split the sentence, by Bayes' rule: from how sure the
    /// splitter is, and how much sense its steps make.
    fn settle(&mut self) -> Option<Refusal> {
        let splits = &mut self.splits;
        let Some(best) = splits.best.take() else {
            return Some(Refusal::InvalidModel);
        };
        let share = if splits.total > 0.0 {
            best.weight / splits.total
        } else {
            // No way makes sense.
            splits.doubts.first().map_or(1.0, |doubt| doubt.probability)
        };
        let (split, own, is_unclear) = (share * splits.others, splits.refusal, splits.is_unclear);
        self.parsed = best.parsed;
        for (step, decisions) in self.parsed.decisions.iter_mut().enumerate() {
            if step == best.step || decisions.split < split {
                decisions.split = split;
            }
        }
        let unsure = self.sure(best.step, Decision::Split, split).err();
        if is_unclear {
            unsure.or(best.refusal)
        } else {
            unsure.or(best.refusal).and(own)
        }
    }
}

/// Whether no other way to read or to split the sentence makes a refusal go away. If a pronoun means
/// nothing where the words make sense, any other way is not what is meant.
pub(super) const fn is_final(refusal: Refusal) -> bool {
    matches!(
        refusal,
        Refusal::UnknownWord { .. }
            | Refusal::UnclearPronoun { .. }
            | Refusal::SentenceTooLong { .. }
            | Refusal::NotFinite { .. }
            | Refusal::InvalidModel
    )
}

#[cfg(test)]
mod tests {
    use core::task::Poll;

    use super::*;
    use crate::fixture;
    use crate::model::Model;

    fn parse(model: &Model<'_>, sentence: &str) -> Result<Parsed, Refusal> {
        let mut task = ParsingTask::new(model, sentence);
        loop {
            if let Poll::Ready(result) = task.poll() {
                return result.cloned();
            }
        }
    }

    /// Ways to parse sentences of one step, each with the probability of its words: the first one
    /// is the splitter's own, of which it is sure with 0.625.
    fn settle(ways: &[(&str, f32)]) -> (Option<Refusal>, Parsed) {
        let model = fixture::model();
        let mut task = ParsingTask::new(&model, "");
        task.splits.is_unclear = true;
        task.splits.note(Doubt {
            step: 0,
            token: 3,
            probability: 0.625,
        });
        for (sentence, words) in ways {
            let mut parsed = parse(&model, sentence).unwrap();
            parsed.decisions[0].words = *words;
            let sense = sense(&parsed);
            task.splits.add(parsed, None, sense);
        }
        let refusal = task.settle();
        (refusal, task.parsed)
    }

    #[test]
    fn a_doubtful_end_is_where_both_parts_make_sense() {
        let model = fixture::model();
        let sentence = "put red on green perhaps put green on red";
        let parsed = parse(&model, sentence).unwrap();
        assert_eq!(parsed.program.steps().len(), 2);
        // Not splitting leaves a step with four descriptions.
        let split = parsed.decisions[0].split;
        assert!((split - 1.0).abs() < 1e-3, "{split}");
        assert_eq!(
            parsed.decisions[0].span.of(sentence),
            Some("put red on green")
        );
    }

    #[test]
    fn a_way_with_a_step_that_no_command_has_does_not_count() {
        // "near" is as likely on as right of, and after "perhaps" nothing is described.
        let refusal = parse(&fixture::model(), "put red near green perhaps put").unwrap_err();
        let Refusal::Unsure { decision, .. } = refusal else {
            panic!("{refusal}");
        };
        assert_eq!(decision, Decision::Action);
    }

    #[test]
    fn words_between_two_steps_may_belong_to_either() {
        let (refusal, parsed) = settle(&[("put red on green", 0.75), ("put red on green", 0.5)]);
        assert_eq!(refusal, None);
        assert!((parsed.decisions[0].split - 1.0).abs() < 1e-3);
        assert_eq!(parsed.decisions[0].words, 0.75);
    }

    #[test]
    fn of_two_programs_that_make_sense_one_must_be_far_likelier() {
        // 0.5 against 0.6 · 0.75.
        let (refusal, parsed) = settle(&[("put red on green", 0.5), ("put green on red", 0.75)]);
        let split = parsed.decisions[0].split;
        let unsure = Refusal::Unsure {
            step: 0,
            decision: Decision::Split,
            probability: split,
            threshold: 0.6,
        };
        assert_eq!(refusal, Some(unsure));
        assert!((split - 0.526).abs() < 1e-3, "{split}");
        // 0.75 against 0.6 · 0.25.
        let (refusal, parsed) = settle(&[("put red on green", 0.75), ("put green on red", 0.25)]);
        let split = parsed.decisions[0].split;
        assert_eq!(refusal, None);
        assert!((split - 0.833).abs() < 1e-3, "{split}");
    }

    #[test]
    fn the_less_likely_way_is_chosen_if_only_that_makes_sense() {
        let (refusal, parsed) = settle(&[("put red on green", 0.01), ("put green on red", 0.99)]);
        assert_eq!(refusal, None);
        let meant = parse(&fixture::model(), "put green on red").unwrap();
        assert_eq!(parsed.program, meant.program);
    }

    #[test]
    fn the_least_sure_decisions_are_kept_in_order() {
        let mut splits = Splits::new();
        for (token, probability) in [0.75, 0.99, 0.6, 0.9, 0.95, 0.5].into_iter().enumerate() {
            splits.note(Doubt {
                step: 0,
                token,
                probability,
            });
        }
        let kept = splits.doubts.iter().map(|doubt| doubt.token);
        assert!(kept.eq([5, 2, 0]));
    }
}
