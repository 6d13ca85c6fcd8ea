use super::segments::Segments;
use super::{
    Acceptability, Encoder, Parsed, Reader, Span, Splitter, StepDecisions, choose_action,
    choose_group,
};
use crate::capacity::MAX_GROUPS;
use crate::dsl::{Argument, Description, Step};
use crate::model::{INSTRUCTION, Model, WordEmbeddings};
use crate::nn::{Choice, Linear};
use crate::refusal::{Decision, Quantity, Refusal};
use core::task::Poll;

/// Parses a sentence; each [`ParsingTask::poll`] does a bounded unit of work: reads one word, feeds
/// one token to the splitter or to one direction of the encoder, which also judges its
/// acceptability, or runs one decoder. All scratch memory is in here.
///
/// If words are misspelt, each reading of the sentence, at most [`crate::MAX_READINGS`], is parsed in turn.
/// All that make sense must mean the same program; otherwise, or if none makes sense, the first
/// misspelt word is refused as unknown.
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
    segments: Segments,
    encoder: Encoder,
    acceptability: Acceptability,
    parsed: Parsed,
    /// The reading of the sentence that is parsed, from 0.
    reading: usize,
    /// Of how many.
    readings: usize,
    /// The first reading that makes sense, if there are several.
    accepted: Option<Parsed>,
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
            segments: Segments::new(),
            encoder: Encoder::new(),
            acceptability: Acceptability::new(),
            parsed: Parsed::empty(model),
            reading: 0,
            readings: 1,
            accepted: None,
            stage,
        }
    }

    /// Does one piece of work. Once it is done, every further call gives the same
    /// result again.
    pub fn poll(&mut self) -> Poll<Result<&Parsed, Refusal>> {
        self.stage = match self.advance(self.stage) {
            Ok(Stage::Parsed) => self.end_reading(None),
            Ok(stage) => stage,
            Err(refusal) => self.end_reading(Some(refusal)),
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

    /// A reading of the sentence was parsed or refused: on to the next one, if there is any.
    fn end_reading(&mut self, refusal: Option<Refusal>) -> Stage {
        self.readings = self.readings.max(self.reader.readings());
        let Some(correction) = self.reader.corrections().first() else {
            return Stage::Done(refusal);
        };
        let unknown = Refusal::UnknownWord {
            span: correction.span(),
        };
        match refusal {
            None => {
                let _ = self
                    .parsed
                    .corrections
                    .extend_from_slice(self.reader.corrections());
                let accepted = self.accepted.get_or_insert_with(|| self.parsed.clone());
                if accepted.program != self.parsed.program {
                    return Stage::Done(Some(unknown));
                }
            }
            // No reading makes these go away.
            Some(
                Refusal::UnknownWord { .. }
                | Refusal::SentenceTooLong { .. }
                | Refusal::NotFinite { .. }
                | Refusal::InvalidModel,
            ) => return Stage::Done(refusal),
            Some(_) => {}
        }
        self.reading = self.reading.saturating_add(1);
        if self.reading < self.readings {
            return self.begin_reading();
        }
        match self.accepted.take() {
            Some(accepted) => {
                self.parsed = accepted;
                Stage::Done(None)
            }
            None => Stage::Done(Some(unknown)),
        }
    }

    fn begin_reading(&mut self) -> Stage {
        self.reader = match Reader::nth(self.sentence.as_ref(), self.reading) {
            Ok(reader) => reader,
            Err(refusal) => return Stage::Done(Some(refusal)),
        };
        self.splitter = Splitter::new();
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

    fn split(&mut self, token: usize) -> Result<Stage, Refusal> {
        let behind = token.saturating_add(1);
        let Some(next) = self.embeddings(behind) else {
            // Nothing follows: what remains is the last step.
            self.segments.end(behind, self.splitter.survival())?;
            return Ok(Stage::Step { step: 0 });
        };
        let this = self.embeddings(token).ok_or(Refusal::InvalidModel)?;
        let after_next = self.embeddings(behind.saturating_add(1));
        let hazard = self
            .splitter
            .hazard(&self.model.language, this, next, after_next);
        if !hazard.is_finite() {
            return Err(not_finite(self.segments.count(), Quantity::Split));
        }
        if let Some(probability) = self.splitter.decide(hazard) {
            self.segments.end(behind, probability)?;
            self.splitter = Splitter::new();
        }
        Ok(Stage::Split { token: behind })
    }

    fn begin_step(&mut self, step: usize) -> Result<Stage, Refusal> {
        let Some(probability) = self.segments.probability(step) else {
            return Ok(Stage::Parsed);
        };
        let tokens = self.reader.tokens();
        let groups = self.segments.groups(step, tokens).count();
        let span = self.segments.span(step, tokens);
        if groups < MAX_GROUPS {
            return Err(Refusal::IncompleteStep {
                step: step as u8,
                references: groups as u8,
                span,
            });
        }
        if groups > MAX_GROUPS {
            return Err(Refusal::TooManyReferences {
                step: step as u8,
                span,
                limit: MAX_GROUPS as u8,
            });
        }
        self.sure(step, Decision::Split, probability)?;
        self.encoder.clear();
        self.acceptability.clear();
        Ok(Stage::Forward {
            step,
            token: self.segments.tokens(step).start,
        })
    }

    fn forward(&mut self, step: usize, token: usize) -> Result<Stage, Refusal> {
        let end = self.segments.tokens(step).end;
        let (embeddings, group) = self.token(token)?;
        let language = &self.model.language;
        // Their numbers were checked when the sentence was read and the step began.
        let _ = self.encoder.forward(language, embeddings, group);
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
        let (embeddings, group) = self.token(token)?;
        let language = &self.model.language;
        self.encoder.backward(language, embeddings, group);
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

    fn action(&mut self, step: usize) -> Result<Stage, Refusal> {
        self.check_words(step)?;
        let choice = choose_action(self.model.actions, &self.encoder.instruction());
        let action = self.decide(step, Decision::Action, choice)?;
        Ok(Stage::Object { step, action })
    }

    fn check_words(&self, step: usize) -> Result<(), Refusal> {
        let probability = self.acceptability.probability();
        if !probability.is_finite() {
            return Err(not_finite(step, Quantity::Words));
        }
        let threshold = self.model.header.thresholds.decision;
        if probability >= threshold {
            return Ok(());
        }
        let token = self.segments.tokens(step).start + self.acceptability.least();
        let token = self.reader.tokens().get(token);
        Err(Refusal::UnclearWords {
            step: step as u8,
            span: token.ok_or(Refusal::InvalidModel)?.span,
            probability,
            threshold,
        })
    }

    fn argument(
        &self,
        step: usize,
        argument: Argument,
        decoder: &Linear<INSTRUCTION, INSTRUCTION>,
    ) -> Result<Decided, Refusal> {
        let instruction = self.encoder.instruction();
        let choice = choose_group(decoder, &instruction, self.encoder.groups());
        self.decide(step, Decision::Argument(argument), choice)
    }

    fn end_step(
        &mut self,
        step: usize,
        action: Decided,
        object: Decided,
        reference: Decided,
    ) -> Result<Stage, Refusal> {
        let (description, span) = self.group(step, object.index)?;
        if object.index == reference.index {
            return Err(Refusal::SameReference {
                step: step as u8,
                span,
            });
        }
        let split = self.segments.probability(step);
        let (reference_description, reference_span) = self.group(step, reference.index)?;
        let decisions = StepDecisions {
            span: self.segments.span(step, self.reader.tokens()),
            object_span: span,
            reference_span,
            split: split.ok_or(Refusal::InvalidModel)?,
            words: self.acceptability.probability(),
            action: action.probability,
            object: object.probability,
            reference: reference.probability,
        };
        let symbols = Step {
            action: u8::try_from(action.index).map_err(|_| Refusal::InvalidModel)?,
            object: description,
            reference: reference_description,
        };
        // As many places as segments.
        let _ = self.parsed.program.push(symbols);
        let _ = self.parsed.decisions.push(decisions);
        Ok(Stage::Step {
            step: step.saturating_add(1),
        })
    }

    /// A decoder's choice, refused when it is not finite or below the threshold.
    fn decide(&self, step: usize, decision: Decision, choice: Choice) -> Result<Decided, Refusal> {
        let quantity = match decision {
            Decision::Split => Quantity::Split,
            Decision::Action => Quantity::Action,
            Decision::Argument(argument) => Quantity::Argument(argument),
        };
        let index = choice.index().ok_or(not_finite(step, quantity))?;
        let probability = choice.probability();
        self.sure(step, decision, probability)?;
        Ok(Decided { index, probability })
    }

    fn sure(&self, step: usize, decision: Decision, probability: f32) -> Result<(), Refusal> {
        let threshold = self.model.header.thresholds.decision;
        if probability >= threshold {
            return Ok(());
        }
        Err(Refusal::Unsure {
            step: step as u8,
            decision,
            probability,
            threshold,
        })
    }

    fn embeddings(&self, token: usize) -> Option<&'m WordEmbeddings> {
        self.reader.tokens().get(token)?.embeddings(self.model)
    }

    fn token(&self, token: usize) -> Result<(&'m WordEmbeddings, bool), Refusal> {
        let token = self
            .reader
            .tokens()
            .get(token)
            .ok_or(Refusal::InvalidModel)?;
        let embeddings = token.embeddings(self.model).ok_or(Refusal::InvalidModel)?;
        Ok((embeddings, token.description().is_some()))
    }

    fn group(&self, step: usize, index: usize) -> Result<(Description, Span), Refusal> {
        self.segments
            .groups(step, self.reader.tokens())
            .nth(index)
            .map(|(description, span)| (*description, span))
            .ok_or(Refusal::InvalidModel)
    }
}

const fn not_finite(step: usize, quantity: Quantity) -> Refusal {
    Refusal::NotFinite {
        step: step as u8,
        quantity,
    }
}
