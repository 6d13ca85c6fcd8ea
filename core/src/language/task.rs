mod decode;
mod split;

use super::phrases::PhraseMatcher;
use super::reader::Reading;
use super::relations::Roles;
use super::segments::Segments;
use super::tokens::unclear;
use super::{Acceptability, Encoder, Parsed, Reader, Span, Splitter, TokenKind};
use crate::capacity::{MAX_GROUPS, MAX_READINGS, MAX_STEP_TOKENS};
use crate::dsl::Argument;
use crate::model::{Model, WORD};
use crate::refusal::{Decision, LengthUnit, Quantity, Refusal};
use core::task::Poll;
use split::{Splits, is_final};

/// Parses a sentence; each [`ParsingTask::poll`] does a bounded unit of work: reads one word, feeds
/// one token to the splitter or to one direction of the encoder, which also judges its
/// acceptability, or runs one decoder. All scratch memory is in here.
///
/// If words are misspelt, or pronouns may stand for what the step before moved, each reading of the
/// sentence, at most [`crate::MAX_READINGS`], is parsed in turn. All that make sense must mean the same
/// program; otherwise, or if none makes sense, the first misspelt word is refused as unknown, or the
/// pronoun as unclear. A sentence whose words make no sense is read once more without words that it can do without
/// ([`crate::model::Simplification`]). If it is not clear where a step
/// ends, or its words make no sense, the reading is parsed with each of at most [`crate::MAX_SPLITS`]
/// − 1 of the splitter's decisions reversed, and the most probable way is taken.
///
/// `T` is the sentence: borrowed (`&str`), or owned, such as a
/// [`heapless::String`], where the task outlives the call that began it.
///
/// ```
/// use core::task::Poll;
///
/// use nsrm_core::language::ParsingTask;
/// use nsrm_tabletop::TABLETOP;
///
/// let mut task = ParsingTask::new(&TABLETOP, "put the red block on the blue block");
/// let parsed = loop {
///     if let Poll::Ready(result) = task.poll() {
///         break result?.clone();
///     }
/// };
/// assert!(parsed.decisions()[0].action > 0.8);
/// # Ok::<(), nsrm_core::Refusal>(())
/// ```
#[derive(Debug, Clone)]
pub struct ParsingTask<'m, T> {
    model: &'m Model<'m>,
    sentence: T,
    reader: Reader,
    splitter: Splitter,
    splits: Splits,
    segments: Segments,
    encoder: Encoder,
    acceptability: Acceptability,
    roles: Roles,
    parsed: Parsed,
    /// The reading of the sentence that is parsed.
    reading: Reading,
    /// Of how many.
    readings: usize,
    /// The first reading that makes sense, if there are several.
    accepted: Option<Parsed>,
    /// Why the first one of the others makes none.
    refused: Option<Refusal>,
    /// Why the sentence makes none as it stands, while it is read without what it can do without.
    as_it_stands: Option<Refusal>,
    /// The first decision that is not sure enough, as the sentence is split now.
    doubt: Option<Refusal>,
    /// The first pronoun that means nothing, as the sentence is split now, and its step.
    unclear: Option<(u8, Span)>,
    stage: Stage,
}

/// The state of a parsing task. Tokens are counted over the whole sentence, steps from 0.
#[derive(Debug, Clone, Copy)]
enum Stage {
    Read,
    Split {
        token: usize,
    },
    /// A step is about to be encoded.
    Step {
        step: usize,
    },
    Forward {
        step: usize,
        token: usize,
    },
    /// Tokens from the step's first up to `before` are still to come.
    Backward {
        step: usize,
        before: usize,
    },
    Action {
        step: usize,
    },
    /// The next group's role is to be chosen.
    Role {
        step: usize,
        action: Decided,
    },
    Object {
        step: usize,
        action: Decided,
    },
    Reference {
        step: usize,
        action: Decided,
        object: Decided,
    },
    /// This reading of the sentence is parsed.
    Parsed,
    Done(Option<Refusal>),
}

/// What a decoder chose, and its probability.
#[derive(Debug, Clone, Copy)]
struct Decided {
    index: usize,
    probability: f32,
}

impl<'m, T: AsRef<str>> ParsingTask<'m, T> {
    /// Nothing done yet.
    pub fn new(model: &'m Model<'m>, sentence: T) -> Self {
        let (reader, stage) = match Reader::new(sentence.as_ref()) {
            Ok(reader) => (reader, Stage::Read),
            Err(refusal) => (Reader::empty(), Stage::Done(Some(refusal))),
        };
        Self {
            model,
            sentence,
            reader,
            splitter: Splitter::new(),
            splits: Splits::new(),
            segments: Segments::new(),
            encoder: Encoder::new(),
            acceptability: Acceptability::new(),
            roles: Roles::new(),
            parsed: Parsed::empty(model),
            reading: Reading::default(),
            readings: 1,
            accepted: None,
            refused: None,
            as_it_stands: None,
            doubt: None,
            unclear: None,
            stage,
        }
    }

    /// Does one piece of work. Once it is done, every further call gives the same
    /// result again.
    pub fn poll(&mut self) -> Poll<Result<&Parsed, Refusal>> {
        self.stage = match self.advance(self.stage) {
            Ok(Stage::Parsed) => self.end_way(None),
            Ok(stage) => stage,
            Err(refusal) => self.end_way(Some(refusal)),
        };
        match self.stage {
            Stage::Done(None) => Poll::Ready(Ok(&self.parsed)),
            Stage::Done(Some(refusal)) => Poll::Ready(Err(refusal)),
            _ => Poll::Pending,
        }
    }

    /// The sentence.
    pub const fn sentence(&self) -> &T {
        &self.sentence
    }

    fn advance(&mut self, stage: Stage) -> Result<Stage, Refusal> {
        match stage {
            Stage::Read => self.read(),
            Stage::Split { token } => self.split(token),
            Stage::Step { step } => self.begin_step(step),
            Stage::Forward { step, token } => self.forward(step, token),
            Stage::Backward { step, before } => self.backward(step, before),
            Stage::Action { step } => self.action(step),
            Stage::Role { step, action } => self.role(step, action),
            Stage::Object { step, action } => {
                let decoder = self.model.language.object_decoder;
                let object = self.argument(step, Argument::Object, decoder)?;
                Ok(Stage::Reference {
                    step,
                    action,
                    object,
                })
            }
            Stage::Reference {
                step,
                action,
                object,
            } => {
                let decoder = self.model.language.reference_decoder;
                let reference = self.argument(step, Argument::Reference, decoder)?;
                self.end_step(step, action, object, reference)
            }
            Stage::Parsed | Stage::Done(_) => Ok(stage),
        }
    }

    /// A reading of the sentence was parsed or refused: on to the next one, if there is any. Once it is refused
    /// as it stands, it is read without what it can do without.
    fn end_reading(&mut self, refusal: Option<Refusal>) -> Stage {
        match self.next_reading(refusal) {
            Stage::Done(Some(refusal)) if self.may_be_simplified(refusal) => {
                self.as_it_stands = Some(refusal);
                (self.readings, self.refused) = (1, None);
                self.reading = Reading {
                    number: 0,
                    is_simplified: true,
                };
                self.begin_reading()
            }
            Stage::Done(Some(refusal)) => Stage::Done(self.as_it_stands.or(Some(refusal))),
            stage => stage,
        }
    }

    /// Whether a sentence that is refused so may make sense without what it can do without: its words make none,
    /// and it does not make sense in two ways.
    fn may_be_simplified(&self, refusal: Refusal) -> bool {
        let makes_none = matches!(
            refusal,
            Refusal::UnknownWord { .. }
                | Refusal::UnclearWords { .. }
                | Refusal::IncompleteStep { .. }
                | Refusal::Unsure { .. }
        );
        makes_none
            && !self.reading.is_simplified
            && self.accepted.is_none()
            // Both together have no more than these.
            && self.readings <= MAX_READINGS / 2
            && !self.model.simplification.is_empty()
    }

    /// What follows a reading.
    fn next_reading(&mut self, refusal: Option<Refusal>) -> Stage {
        self.readings = self.readings.max(self.reader.readings());
        let unknown = self.reader.corrections().first();
        let unknown = unknown.map(|correction| Refusal::UnknownWord {
            span: correction.span(),
        });
        if self.readings == 1 && unknown.is_none() {
            return Stage::Done(refusal);
        }
        match refusal {
            None => {
                let _ = self
                    .parsed
                    .corrections
                    .extend_from_slice(self.reader.corrections());
                let accepted = self.accepted.get_or_insert_with(|| self.parsed.clone());
                if accepted.program != self.parsed.program {
                    let unclear = unknown.or(self.ambiguous_pronoun());
                    return Stage::Done(unclear.or(Some(self.two_readings())));
                }
            }
            Some(refusal) if is_final(refusal) && !self.may_be_known(refusal) => {
                return Stage::Done(Some(refusal));
            }
            Some(refusal) => {
                self.refused.get_or_insert(refusal);
            }
        }
        self.reading.number = self.reading.number.saturating_add(1);
        if self.reading.number < self.readings {
            return self.begin_reading();
        }
        match self.accepted.take() {
            Some(accepted) => {
                self.parsed = accepted;
                Stage::Done(None)
            }
            None => Stage::Done(unknown.or(self.refused)),
        }
    }

    /// Whether an unknown word may be known in another reading, or was in one before: those of a tower or of what
    /// is counted, for instance, which only some readings replace.
    fn may_be_known(&self, refusal: Refusal) -> bool {
        let is_last = self.reading.number.saturating_add(1) >= self.readings;
        let is_known = self.accepted.is_some() || self.refused.is_some();
        matches!(refusal, Refusal::UnknownWord { .. }) && (is_known || !is_last)
    }

    /// Refuses the first pronoun of this reading, which makes sense in another way, too.
    fn ambiguous_pronoun(&self) -> Option<Refusal> {
        let mut tokens = self.reader.tokens().iter();
        let pronoun = tokens.position(|token| token.kind == TokenKind::Pronoun)?;
        let mut steps = 0..self.segments.count();
        Some(Refusal::UnclearPronoun {
            step: steps.position(|step| self.segments.tokens(step).contains(&pronoun))? as u8,
            span: self.reader.tokens().get(pronoun)?.span,
        })
    }

    /// Refuses the first step, for the sentence makes sense in two ways.
    fn two_readings(&self) -> Refusal {
        let span = self.segments.span(0, self.reader.tokens());
        unclear(self.model, span)
    }

    fn begin_reading(&mut self) -> Stage {
        self.reader = match Reader::nth(self.sentence.as_ref(), self.reading) {
            Ok(reader) => reader,
            Err(refusal) => return Stage::Done(Some(refusal)),
        };
        self.splitter = Splitter::new();
        self.splits = Splits::new();
        self.segments = Segments::new();
        self.parsed = Parsed::empty(self.model);
        Stage::Read
    }

    fn read(&mut self) -> Result<Stage, Refusal> {
        if self.reader.advance(self.model, self.sentence.as_ref())? {
            Ok(Stage::Read)
        } else if self.reader.tokens().is_empty() {
            Err(Refusal::NoWords)
        } else {
            Ok(Stage::Split { token: 0 })
        }
    }

    fn begin_step(&mut self, step: usize) -> Result<Stage, Refusal> {
        let Some(probability) = self.segments.probability(step) else {
            return Ok(Stage::Parsed);
        };
        let tokens = self.reader.tokens();
        if self.reading.is_simplified && step > 0 {
            let said = PhraseMatcher {
                model: self.model,
                sentence: self.sentence.as_ref(),
            };
            let words = tokens.get(self.segments.tokens(step));
            let connecting = said.connecting(words.unwrap_or_default());
            self.segments.connect(step, connecting);
        }
        let groups = self.segments.groups(step, tokens);
        self.check_described(step, groups.clone().count(), MAX_GROUPS)?;
        let pronouns = groups.filter(|token| token.filters().is_none()).count();
        if pronouns > usize::from(step > 0) {
            // Nothing was moved before, or both of its objects are the same.
            return Err(self.not_meant(step));
        }
        let range = self.segments.tokens(step);
        if range.len() > MAX_STEP_TOKENS {
            return Err(Refusal::SentenceTooLong {
                limit: MAX_STEP_TOKENS as u16,
                unit: LengthUnit::StepTokens,
            });
        }
        // Of the splitter's own way, all steps together are judged.
        if self.splits.is_reversed() {
            let sure = self.sure(step, Decision::Split, probability);
            self.note(sure);
        }
        self.encoder.clear();
        self.acceptability.clear();
        self.roles = Roles::new();
        Ok(Stage::Forward {
            step,
            token: range.start,
        })
    }

    fn forward(&mut self, step: usize, token: usize) -> Result<Stage, Refusal> {
        let end = self.segments.tokens(step).end;
        let (word, group) = self.word(token)?;
        let language = &self.model.language;
        // Their numbers were checked when the sentence was read and the step began.
        let _ = self.encoder.forward(language, &word, group);
        let _ = self.acceptability.ahead(language, self.encoder.ahead());
        let token = token.saturating_add(1);
        Ok(if token < end {
            Stage::Forward { step, token }
        } else {
            Stage::Backward { step, before: end }
        })
    }

    fn backward(&mut self, step: usize, before: usize) -> Result<Stage, Refusal> {
        let token = before.saturating_sub(1);
        let (word, group) = self.word(token)?;
        let language = &self.model.language;
        self.encoder.backward(language, &word, group);
        self.acceptability.behind(language, self.encoder.behind());
        Ok(if token > self.segments.tokens(step).start {
            Stage::Backward {
                step,
                before: token,
            }
        } else {
            Stage::Action { step }
        })
    }

    /// Keeps the first doubt. What follows it is decided all the same: how much sense the steps make
    /// depends on all of it.
    fn note(&mut self, sure: Result<(), Refusal>) {
        self.doubt = self.doubt.or(sure.err());
    }

    /// A token as the encoder's cells read it, and whether it describes an object.
    fn word(&self, token: usize) -> Result<([f32; WORD], bool), Refusal> {
        let token = self.reader.tokens().get(token);
        let token = token.ok_or(Refusal::InvalidModel)?;
        let row = token.embedding().ok_or(Refusal::InvalidModel)?;
        let word = self.model.embeddings.encoder(row);
        Ok((word.ok_or(Refusal::InvalidModel)?, token.is_group()))
    }
}

const fn not_finite(step: usize, quantity: Quantity) -> Refusal {
    Refusal::NotFinite {
        step: step as u8,
        quantity,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture;

    fn parsed<'m>(model: &'m Model<'m>, sentence: &'static str) -> ParsingTask<'m, &'static str> {
        let mut task = ParsingTask::new(model, sentence);
        while task.poll().is_pending() {}
        task
    }

    #[test]
    fn readings_that_mean_different_programs_are_refused() {
        let model = fixture::model();
        let other = parsed(&model, "put green on red").parsed;
        let mut task = parsed(&model, "put red on green");
        (task.reading.number, task.readings, task.accepted) = (1, 2, Some(other));
        let Stage::Done(Some(refusal)) = task.end_reading(None) else {
            panic!("not refused");
        };
        assert_eq!(refusal.kind(), "unclear_words");
        task.accepted = Some(task.parsed.clone());
        assert!(matches!(task.end_reading(None), Stage::Done(None)));
    }
}
