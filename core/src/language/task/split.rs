//! From the words of a sentence to its steps. A split of which the splitter is unsure is settled by
//! what makes sense: the sentence is parsed with the splitter's decision, and with the other one.

use super::{ParsingTask, Stage, not_finite};
use crate::language::segments::Segments;
use crate::language::splitter::{SPLIT_HAZARD, Splitter};
use crate::language::{Parsed, Token};
use crate::refusal::{Decision, Quantity, Refusal};

/// What is known about the decision that is in doubt.
#[derive(Debug, Clone)]
pub(super) struct Doubts {
    /// The least sure decision in the step that has not ended yet.
    least: Option<Doubt>,
    doubt: Option<Doubt>,
    /// How it ended with the splitter's decision; `None` while that is parsed.
    own: Option<Attempt>,
}

/// Whether a step ends at a token, of which the splitter is not sure.
#[derive(Debug, Clone, Copy)]
struct Doubt {
    step: usize,
    token: usize,
    /// That the splitter's decision is right, ½ or more.
    probability: f32,
}

/// How the parsing of a sentence ended.
#[derive(Debug, Clone)]
struct Attempt {
    parsed: Parsed,
    refusal: Option<Refusal>,
}

impl Doubts {
    pub(super) const fn new() -> Self {
        Self {
            least: None,
            doubt: None,
            own: None,
        }
    }

    /// Whether the step ends at a token with this hazard, and with which probability.
    fn decide(&mut self, step: usize, token: usize, hazard: f32) -> (bool, f32) {
        let ends = hazard > SPLIT_HAZARD;
        let reversed = self.own.as_ref().and(self.doubt);
        if reversed.is_some_and(|doubt| doubt.token == token) {
            return (!ends, 1.0);
        }
        let probability = if ends { hazard } else { 1.0 - hazard };
        if self
            .least
            .is_none_or(|least| probability < least.probability)
        {
            self.least = Some(Doubt {
                step,
                token,
                probability,
            });
        }
        (ends, probability)
    }

    /// A step ends with this probability. If it is below the threshold, its least sure decision is
    /// in doubt from now on, if none is yet; returns the probability that the others are right.
    fn end_step(&mut self, probability: f32, threshold: f32) -> f32 {
        match self.least.take() {
            Some(least) if probability < threshold && self.doubt.is_none() => {
                self.doubt = Some(least);
                probability / least.probability
            }
            _ => probability,
        }
    }
}

impl Attempt {
    /// How much sense the words make as they were split: the probability of all that was decided
    /// about the steps, until the end or the refusal; 0 for a step that no command has.
    fn sense(&self) -> f32 {
        let steps =
            self.parsed.decisions.iter().map(|step| {
                step.words * step.action * step.relations * step.object * step.reference
            });
        let refused = match self.refusal {
            None => 1.0,
            Some(
                Refusal::UnclearWords { probability, .. } | Refusal::Unsure { probability, .. },
            ) => probability,
            Some(_) => 0.0,
        };
        steps.product::<f32>() * refused
    }
}

impl<T: AsRef<str>> ParsingTask<'_, T> {
    /// Whether a step ends at a token; from the first token to the last.
    pub(super) fn split(&mut self, token: usize) -> Result<Stage, Refusal> {
        let (model, tokens) = (self.model, self.reader.tokens());
        let behind = token.saturating_add(1);
        let Some(ahead) = tokens.get(behind..).filter(|ahead| !ahead.is_empty()) else {
            // Nothing follows: what remains is the last step.
            self.end_segment(behind, self.splitter.survival())?;
            return Ok(Stage::Step { step: 0 });
        };
        let ahead = ahead
            .iter()
            .map_while(|token: &Token| token.embeddings(model));
        let (this, _) = self.token(token)?;
        let hazard = self.splitter.hazard(&model.language, this, ahead);
        let step = self.segments.count();
        if !hazard.is_finite() {
            return Err(not_finite(step, Quantity::Split));
        }
        let (ends, probability) = self.doubts.decide(step, token, hazard);
        if let Some(probability) = self.splitter.follow(ends, probability) {
            self.end_segment(behind, probability)?;
            self.splitter = Splitter::new();
        }
        Ok(Stage::Split { token: behind })
    }

    fn end_segment(&mut self, behind: usize, probability: f32) -> Result<(), Refusal> {
        let threshold = self.model.header.thresholds.decision;
        let probability = self.doubts.end_step(probability, threshold);
        self.segments.end(behind, probability)
    }

    /// The sentence was parsed or refused as it was split: the other way is next, if there is one.
    pub(super) fn end_attempt(&mut self, refusal: Option<Refusal>) -> Stage {
        let Some(doubt) = self.doubts.doubt else {
            return self.end_reading(refusal);
        };
        let parsed = &mut self.parsed;
        if let Some(own) = self.doubts.own.take() {
            let parsed = core::mem::replace(parsed, Parsed::empty(self.model));
            let refusal = self.settle(doubt, own, Attempt { parsed, refusal });
            return self.end_reading(refusal);
        }
        let refused_before = refusal.is_some() && parsed.decisions.len() < doubt.step;
        if refused_before || refusal.is_some_and(is_final) {
            return self.end_reading(refusal);
        }
        let parsed = core::mem::replace(parsed, Parsed::empty(self.model));
        self.doubts.own = Some(Attempt { parsed, refusal });
        self.splitter = Splitter::new();
        self.segments = Segments::new();
        Stage::Split { token: 0 }
    }

    /// Chooses one of two ways to split the sentence: by Bayes' rule, from how sure the splitter is
    /// and how much sense they make.
    fn settle(&mut self, doubt: Doubt, own: Attempt, reversed: Attempt) -> Option<Refusal> {
        let weights = [
            doubt.probability * own.sense(),
            (1.0 - doubt.probability) * reversed.sense(),
        ];
        let parsed = own.refusal.is_none() && reversed.refusal.is_none();
        // Words between two steps may belong to either.
        let same = parsed && own.parsed.program == reversed.parsed.program;
        let share = match weights {
            _ if same => 1.0,
            [0.0, 0.0] => doubt.probability,
            [own, reversed] => own / (own + reversed),
        };
        let (chosen, share) = if share >= 0.5 {
            (own, share)
        } else {
            (reversed, 1.0 - share)
        };
        self.parsed = chosen.parsed;
        if let Some(decisions) = self.parsed.decisions.get_mut(doubt.step) {
            decisions.split *= share;
        }
        let decisions = self.parsed.decisions.get(doubt.step);
        let split = decisions.map_or(share, |decisions| decisions.split);
        let unsure = self.sure(doubt.step, Decision::Split, split);
        unsure.err().or(chosen.refusal)
    }
}

/// Whether no other way to read or to split the sentence makes a refusal go away.
pub(super) const fn is_final(refusal: Refusal) -> bool {
    matches!(
        refusal,
        Refusal::UnknownWord { .. }
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

    const DOUBT: Doubt = Doubt {
        step: 0,
        token: 3,
        probability: 0.625,
    };

    fn parse(model: &Model<'_>, sentence: &str) -> Result<Parsed, Refusal> {
        let mut task = ParsingTask::new(model, sentence);
        loop {
            if let Poll::Ready(result) = task.poll() {
                return result.cloned();
            }
        }
    }

    /// A sentence with one step, parsed with this probability of its words.
    fn attempt(model: &Model<'_>, sentence: &str, words: f32) -> Attempt {
        let mut parsed = parse(model, sentence).unwrap();
        parsed.decisions[0].words = words;
        Attempt {
            parsed,
            refusal: None,
        }
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
    fn words_between_two_steps_may_belong_to_either() {
        let model = fixture::model();
        let mut task = ParsingTask::new(&model, "");
        let [own, reversed] = [0.75, 0.5].map(|words| attempt(&model, "put red on green", words));
        assert_eq!(task.settle(DOUBT, own, reversed), None);
        let decisions = task.parsed.decisions[0];
        assert!((decisions.split - 1.0).abs() < 1e-3 && decisions.words == 0.75);
    }

    #[test]
    fn of_two_programs_that_make_sense_one_must_be_far_likelier() {
        let model = fixture::model();
        let mut task = ParsingTask::new(&model, "");
        let mut settle = |own, reversed| {
            let own = attempt(&model, "put red on green", own);
            let reversed = attempt(&model, "put green on red", reversed);
            let refusal = task.settle(DOUBT, own, reversed);
            (refusal, task.parsed.decisions[0].split)
        };
        // 0.625 · 0.5 against 0.375 · 0.75.
        let (refusal, split) = settle(0.5, 0.75);
        let unsure = Refusal::Unsure {
            step: 0,
            decision: Decision::Split,
            probability: split,
            threshold: 0.6,
        };
        assert_eq!(refusal, Some(unsure));
        assert!((split - 0.526).abs() < 1e-3, "{split}");
        // 0.625 · 0.75 against 0.375 · 0.25.
        let (refusal, split) = settle(0.75, 0.25);
        assert_eq!(refusal, None);
        assert!((split - 0.833).abs() < 1e-3, "{split}");
    }

    #[test]
    fn the_less_likely_split_is_chosen_if_only_that_makes_sense() {
        let model = fixture::model();
        let mut task = ParsingTask::new(&model, "");
        let mut own = attempt(&model, "put red on green", 1.0);
        let threshold = 0.6;
        own.refusal = Some(Refusal::Unsure {
            step: 0,
            decision: Decision::Action,
            probability: 0.1,
            threshold,
        });
        let reversed = attempt(&model, "put green on red", 1.0);
        let program = reversed.parsed.program.clone();
        assert_eq!(task.settle(DOUBT, own, reversed), None);
        assert_eq!(task.parsed.program, program);
    }
}
