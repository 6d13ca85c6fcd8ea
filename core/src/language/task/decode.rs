//! From a step's encoded words to its symbols: action, roles of its groups, and arguments.

use core::num::NonZeroU16;

use super::{Decided, ParsingTask, Stage, not_finite};
use crate::capacity::{ARGUMENTS, MAX_GROUPS, MAX_RELATIONS};
use crate::dsl::{Argument, Description, Filters, Quantifier, Relation, RelationKind, Step};
use crate::language::compounds::before_group;
use crate::language::perspectives::turned;
use crate::language::pronouns::antecedent;
use crate::language::tokens::KeptKind;
use crate::language::{
    GroupRole, Span, StepDecisions, Token, TokenKind, choose_action, choose_group, choose_role,
};
use crate::model::{INSTRUCTION, Model};
use crate::nn::{Choice, Dense};
use crate::refusal::{Decision, Quantity, Refusal};

impl<T: AsRef<str>> ParsingTask<'_, T> {
    pub(super) fn action(&mut self, step: usize) -> Result<Stage, Refusal> {
        self.check_words(step)?;
        let choice = choose_action(self.model.actions, &self.encoder.instruction());
        let action = self.decide(step, Decision::Action, choice)?;
        Ok(Stage::Role { step, action })
    }

    pub(super) fn role(&mut self, step: usize, action: Decided) -> Result<Stage, Refusal> {
        let group = self.roles.count();
        let states = self.encoder.groups();
        let state = states.get(group).ok_or(Refusal::InvalidModel)?;
        let choice = choose_role(self.model, state, group == 0);
        let Decided { index, probability } = self.decide(step, Decision::Relation, choice)?;
        let role = GroupRole::of(index, self.model.actions.len());
        let role = role.ok_or(Refusal::InvalidModel)?;
        let role = self.compounded(step, group, role, action.index)?;
        self.roles.push(role, probability);
        if self.roles.count() < self.encoder.groups().len() {
            return Ok(Stage::Role { step, action });
        }
        // A step describes two objects, however many they are related to.
        self.check_described(step, self.roles.heads().count(), ARGUMENTS)?;
        Ok(Stage::Object { step, action })
    }

    /// Refuses a step that does not describe from [`ARGUMENTS`] to `limit` objects.
    pub(super) fn check_described(
        &self,
        step: usize,
        described: usize,
        limit: usize,
    ) -> Result<(), Refusal> {
        let span = self.segments.span(step, self.reader.tokens());
        if described < ARGUMENTS {
            return Err(Refusal::IncompleteStep {
                step: step as u8,
                references: described as u8,
                span,
            });
        }
        if described > limit {
            return Err(Refusal::TooManyReferences {
                step: step as u8,
                span,
                limit: limit as u8,
            });
        }
        Ok(())
    }

    fn check_words(&mut self, step: usize) -> Result<(), Refusal> {
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
        self.note(Err(Refusal::UnclearWords {
            step: step as u8,
            span: token.ok_or(Refusal::InvalidModel)?.span,
            probability,
            threshold,
        }));
        Ok(())
    }

    pub(super) fn argument(
        &mut self,
        step: usize,
        argument: Argument,
        decoder: Dense<'_, INSTRUCTION, INSTRUCTION>,
    ) -> Result<Decided, Refusal> {
        let instruction = self.encoder.instruction();
        let states = self.encoder.groups();
        let heads = self.roles.heads().filter_map(|head| states.get(head));
        let choice = choose_group(&decoder, &instruction, heads);
        self.decide(step, Decision::Argument(argument), choice)
    }

    pub(super) fn end_step(
        &mut self,
        step: usize,
        action: Decided,
        object: Decided,
        reference: Decided,
    ) -> Result<Stage, Refusal> {
        let (description, span) = self.described(step, object.index)?;
        if object.index == reference.index {
            return Err(Refusal::SameReference {
                step: step as u8,
                span,
            });
        }
        let split = self.segments.probability(step);
        let (reference_description, reference_span) = self.described(step, reference.index)?;
        // "Put it on the red one", when the red one was moved before.
        let is_same = description.says_same(&reference_description);
        let mut tokens = self.segments.groups(step, self.reader.tokens());
        let pronoun = tokens.find(|token| token.filters().is_none());
        if let Some(pronoun) = pronoun
            && (is_same || antecedent(&self.parsed.program).is_none())
        {
            // It is refused if the words make sense to the end.
            self.unclear.get_or_insert((step as u8, pronoun.span));
        }
        let chosen = self.compound_action(step, action.index, reference.index)?;
        self.check_exceptions(step, [&description, &reference_description])?;
        let distance_mm = self.distance_mm(step, chosen, reference.index)?;
        let is_shift = distance_mm.is_some() && reference_description.relations().is_empty();
        if has_itself(&description) {
            return Err(self.unclear(step, span));
        }
        // "All red blocks on each other".
        let is_several = matches!(
            description.filters().quantifier(),
            Some(Quantifier::All | Quantifier::Both)
        );
        let is_among = is_several && self.model.compound(chosen).is_none();
        if has_itself(&reference_description) && !is_shift && !is_among {
            return Err(self.unclear(step, reference_span));
        }
        let is_between = self.model.is_between(chosen);
        // "Between the two red ones".
        let is_pair = is_between && is_both(&reference_description);
        let are_paired = is_paired(self.model, &description, false)
            && is_paired(self.model, &reference_description, is_between && !is_pair);
        if !are_paired || (is_several && is_between) {
            return Err(self.unclear_compound(step));
        }
        check_table(
            self.model,
            chosen,
            [&description, &reference_description],
            step,
            [span, reference_span],
        )?;
        let single = if is_pair {
            Description::new()
        } else {
            reference_description
        };
        check_single(&description, &single, step, [span, reference_span])?;
        let decisions = StepDecisions {
            span: self.segments.span(step, self.reader.tokens()),
            object_span: span,
            reference_span,
            split: split.ok_or(Refusal::InvalidModel)?,
            words: self.acceptability.probability(),
            action: action.probability,
            relations: self.roles.probability(),
            object: object.probability,
            reference: reference.probability,
        };
        let symbols = Step {
            action: chosen,
            object: description,
            reference: reference_description,
            distance_mm,
        };
        let symbols = match self.reader.is_opposite() {
            true => turned(self.model, &symbols).ok_or(self.unclear(step, span))?,
            false => symbols,
        };
        // As many places as segments.
        let _ = self.parsed.program.push(symbols);
        let _ = self.parsed.decisions.push(decisions);
        Ok(Stage::Step {
            step: step.saturating_add(1),
        })
    }

    /// A decoder's choice, refused when it is not finite and doubted below the threshold.
    fn decide(
        &mut self,
        step: usize,
        decision: Decision,
        choice: Choice,
    ) -> Result<Decided, Refusal> {
        let quantity = match decision {
            Decision::Split => Quantity::Split,
            Decision::Action => Quantity::Action,
            Decision::Relation => Quantity::Relation,
            Decision::Argument(argument) => Quantity::Argument(argument),
        };
        let index = choice.index().ok_or(not_finite(step, quantity))?;
        let probability = choice.probability();
        let sure = self.sure(step, decision, probability);
        self.note(sure);
        Ok(Decided { index, probability })
    }

    pub(super) fn sure(
        &self,
        step: usize,
        decision: Decision,
        probability: f32,
    ) -> Result<(), Refusal> {
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

    /// The tokens of a step.
    fn tokens(&self, step: usize) -> &[Token] {
        let tokens = self.reader.tokens().get(self.segments.tokens(step));
        tokens.unwrap_or_default()
    }

    /// A group's role, with the compound that was said in place of its relation: "the block next to the blue
    /// one". In "… the one next to the blue one", the compound may as well be the step's action; where the
    /// network takes its words for both, the step is refused.
    fn compounded(
        &self,
        step: usize,
        group: usize,
        role: GroupRole,
        action: usize,
    ) -> Result<GroupRole, Refusal> {
        let said = before_group(self.tokens(step), group);
        let (Some(related), Some(compound)) = (role.action(), said.clone().last()) else {
            return Ok(role);
        };
        let read = self.model.read_action(compound);
        if read != Some(related) {
            return Ok(role);
        }
        let kind = RelationKind::Action(compound);
        match role {
            GroupRole::StandsFor(_) if said.count() < ARGUMENTS => {
                if read.map(usize::from) == Some(action) {
                    return Err(self.unclear_compound(step));
                }
                Ok(GroupRole::StandsFor(kind))
            }
            GroupRole::StandsFor(_) => Ok(GroupRole::StandsFor(kind)),
            _ => Ok(GroupRole::Restricts(kind)),
        }
    }

    /// A step's action, or the compound that was said before the reference in its place. Each compound of
    /// the step must be this one, or a relation of a group.
    ///
    /// * `reference`: which of the heads it is
    fn compound_action(&self, step: usize, action: usize, reference: usize) -> Result<u8, Refusal> {
        let action = u8::try_from(action).map_err(|_| Refusal::InvalidModel)?;
        let tokens = self.tokens(step);
        let is_compound = |token: &&Token| matches!(token.kind, TokenKind::Compound { .. });
        let said = tokens.iter().filter(is_compound).count();
        if said == 0 {
            return Ok(action);
        }
        let is_one = |action: u8| self.model.compound(action).is_some();
        let group = self.roles.chain(reference).ok_or(Refusal::InvalidModel)?;
        let related = self.roles.related_by(is_one);
        let role = self.roles.get(group.start).and_then(GroupRole::action);
        let own = role.is_some_and(is_one);
        let mut before = before_group(tokens, group.start);
        let meant = match (before.next(), own) {
            // The relation that stands for the reference is the last one.
            (Some(_), true) if before.next().is_none() => None,
            (Some(first), _) => Some(first),
            (None, _) => None,
        };
        let meant = meant.filter(|compound| self.model.read_action(*compound) == Some(action));
        if related.saturating_add(usize::from(meant.is_some())) < said {
            return Err(self.unclear_compound(step));
        }
        Ok(meant.unwrap_or(action))
    }

    /// Refuses a step in which a compound stands where it means nothing.
    fn unclear_compound(&self, step: usize) -> Refusal {
        let tokens = self.tokens(step).iter();
        let mut said = tokens.filter(|token| matches!(token.kind, TokenKind::Compound { .. }));
        let span = said.next().map(|token| token.span);
        self.unclear(step, span.unwrap_or(Span { start: 0, end: 0 }))
    }

    /// The distance that a step says; refused where it is none of where its object is put beside another one.
    ///
    /// * `reference`: which of the heads it is
    fn distance_mm(
        &self,
        step: usize,
        action: u8,
        reference: usize,
    ) -> Result<Option<NonZeroU16>, Refusal> {
        let tokens = self.segments.tokens(step);
        let mut said = self.reader.distances().iter();
        let mut said = said.by_ref().filter(|distance| distance.is_in(&tokens));
        let Some(distance) = said.next() else {
            return Ok(None);
        };
        let group = self.roles.chain(reference).ok_or(Refusal::InvalidModel)?;
        let is_of_reference = distance.is_of(&group, &tokens, self.reader.tokens());
        if said.next().is_some() || !is_of_reference || !self.model.puts_aside(action) {
            return Err(self.unclear(step, distance.span));
        }
        Ok(Some(distance.mm))
    }

    /// Refuses words of a step that mean nothing there.
    fn unclear(&self, step: usize, span: Span) -> Refusal {
        Refusal::UnclearWords {
            step: step as u8,
            span,
            probability: 0.0,
            threshold: self.model.header.thresholds.decision,
        }
    }

    /// Refuses a reading of a pronoun that is not meant; what the sentence lacks is told of the reading
    /// in which it is a word like any other.
    pub(super) fn not_meant(&self, step: usize) -> Refusal {
        Refusal::IncompleteStep {
            step: step as u8,
            references: 1,
            span: self.segments.span(step, self.reader.tokens()),
        }
    }

    /// The description that a head begins, and its place from its first word to its last.
    fn described(&self, step: usize, head: usize) -> Result<(Description, Span), Refusal> {
        let chain = self.roles.chain(head).ok_or(Refusal::InvalidModel)?;
        let groups = self.segments.groups(step, self.reader.tokens());
        let groups = groups.skip(chain.start).take(chain.len());
        let spans = || groups.clone().map(|token| token.span);
        let (first, last) = spans()
            .next()
            .zip(spans().last())
            .ok_or(Refusal::InvalidModel)?;
        let span = Span {
            start: first.start,
            end: last.end,
        };
        let antecedent = antecedent(&self.parsed.program);
        let mut filters = [Filters::new(); MAX_GROUPS];
        for (place, token) in filters.iter_mut().zip(groups.clone()) {
            if chain.len() > 1 && token.filters().is_none() {
                // "Beside the red block, on its right" is no block to the right of another one, and a
                // pronoun is not restricted: nobody says "it left of the red block".
                return Err(self.not_meant(step));
            }
            let filters = token.filters().map(Filters::distinct);
            *place = filters.or(antecedent).unwrap_or_default();
        }
        let description = self.roles.describe(chain, &filters);
        let description = description.ok_or(Refusal::TooManyRelations {
            step: step as u8,
            span,
            limit: MAX_RELATIONS as u8,
        })?;
        let mut exceptions = self.reader.kept(KeptKind::Exception);
        let exception = exceptions.find(|exception| exception.is_of(first));
        let except = exception.map(|exception| exception.filters);
        let description = description.excepting(except.unwrap_or_default());
        let description = self.paired(step, groups, description)?;
        Ok((description, span))
    }

    /// A description with what else follows "between", which belongs to the last of its groups.
    fn paired<'t>(
        &self,
        step: usize,
        groups: impl Iterator<Item = &'t Token>,
        mut description: Description,
    ) -> Result<Description, Refusal> {
        let mut second = None;
        for group in groups {
            if second.is_some() {
                return Err(self.unclear(step, group.span));
            }
            let mut pairs = self.reader.kept(KeptKind::Second);
            second = pairs.find(|pair| pair.is_of(group.span));
        }
        let Some(second) = second else {
            return Ok(description);
        };
        let relation = Relation {
            kind: RelationKind::And,
            to: second.filters.distinct(),
        };
        match description.relate(relation) {
            Ok(()) => Ok(description),
            Err(_) => Err(self.unclear_compound(step)),
        }
    }

    /// Refuses a step in which something is left out of anything but its object and its reference.
    fn check_exceptions(
        &self,
        step: usize,
        descriptions: [&Description; ARGUMENTS],
    ) -> Result<(), Refusal> {
        let groups = self.segments.groups(step, self.reader.tokens());
        let exceptions = self.reader.kept(KeptKind::Exception);
        let is_of = |span: Span| exceptions.clone().any(|exception| exception.is_of(span));
        let mut excepted = groups.filter(|group| is_of(group.span));
        let meant = descriptions.into_iter();
        let meant = meant.filter(|description| description.except().is_some());
        match excepted.clone().nth(meant.count()) {
            Some(_) => {
                let group = excepted.next().ok_or(Refusal::InvalidModel)?;
                Err(self.unclear(step, group.span))
            }
            None => Ok(()),
        }
    }
}

/// Refuses a step in which the table is anything but what the object is put on, or what an object
/// stands on.
///
/// * `descriptions`: of the object and of the reference
/// * `spans`: their places
fn check_table(
    model: &Model<'_>,
    action: u8,
    descriptions: [&Description; ARGUMENTS],
    step: usize,
    spans: [Span; ARGUMENTS],
) -> Result<(), Refusal> {
    let puts_on = model.table.action;
    let is_misused = |index: usize, description: &Description| {
        let mut relations = description.relations().iter().rev();
        let is_innermost_on = relations
            .next()
            .is_none_or(|innermost| !innermost.to.is_table() || innermost.kind == on(model));
        let is_place = index > 0 && action == puts_on && description.relations().is_empty();
        (description.filters().is_table() && !is_place)
            || !is_innermost_on
            || relations.any(|relation| relation.to.is_table())
    };
    let [object, reference] = descriptions;
    // "Take it off the table" says where it is, and not where to.
    let is_there = matches!(object.relations(), [relation] if relation.to.is_table());
    if is_there && reference.filters().is_table() {
        let [span, _] = spans;
        return Err(Refusal::OnlyOnTable {
            step: step as u8,
            span,
        });
    }
    let mut described = descriptions.into_iter().enumerate().zip(spans);
    match described.find(|((index, description), _)| is_misused(*index, description)) {
        Some((_, span)) => Err(Refusal::OnlyOnTable {
            step: step as u8,
            span,
        }),
        None => Ok(()),
    }
}

/// Whether a description names the object that is moved, which it may only as that from which this is moved, or as any of
/// several.
fn has_itself(description: &Description) -> bool {
    let mut relations = description.relations().iter();
    description.filters().is_itself() || relations.any(|relation| relation.to.is_itself())
}

/// How an object is related to the table that it stands on.
const fn on(model: &Model<'_>) -> RelationKind {
    RelationKind::Action(model.table.action)
}

/// Refuses a step in which several objects are meant other than those to be moved, or of which one is
/// the nearest or the farthest.
///
/// * `spans`: the places of both descriptions
fn check_single(
    object: &Description,
    reference: &Description,
    step: usize,
    [span, reference_span]: [Span; ARGUMENTS],
) -> Result<(), Refusal> {
    let is_several = |filters: &Filters| filters.quantifier().is_some();
    let has_several = |description: &Description| {
        let mut relations = description.relations().iter();
        relations.any(|relation| is_several(&relation.to))
    };
    let own = object.relations().first().map(|relation| relation.kind);
    let is_compared = matches!(own, Some(RelationKind::Nearest | RelationKind::Farthest));
    let span = if has_several(object) || (is_several(object.filters()) && is_compared) {
        span
    } else if is_several(reference.filters()) || has_several(reference) {
        reference_span
    } else {
        return Ok(());
    };
    let step = step as u8;
    Err(Refusal::SeveralReferences { step, span })
}

/// Whether a description is of two objects that look alike: "both red ones".
fn is_both(description: &Description) -> bool {
    description.filters().quantifier() == Some(Quantifier::Both)
        && description.relations().is_empty()
}

/// Whether two objects are described behind each "between", and nowhere else.
///
/// * `is_between`: whether the description is of what follows one
fn is_paired(model: &Model<'_>, description: &Description, mut is_between: bool) -> bool {
    for relation in description.relations() {
        if (relation.kind == RelationKind::And) != is_between {
            return false;
        }
        is_between = match relation.kind {
            RelationKind::Action(action) => model.is_between(action),
            _ => false,
        };
    }
    !is_between
}
