use core::ops::Range;

use heapless::Vec;

use crate::capacity::MAX_GROUPS;
use crate::dsl::{Description, Filters, Relation, RelationKind};
use crate::model::{INSTRUCTION, Model};
use crate::nn::{Choice, dot};

/// What a group of concept words is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum GroupRole {
    /// It describes an object of the step: "the red block".
    Plain,
    /// It restricts what is described before it, which is in this relation to it: "left of the
    /// yellow one".
    Restricts(RelationKind),
    /// It describes what an object of the step, which has no values of its own, is in this relation
    /// to: "the block left of the yellow one".
    StandsFor(RelationKind),
}

impl GroupRole {
    /// What an index of [`choose_role`] means; `None` if it is none.
    ///
    /// * `actions`: how many the model has
    pub fn of(index: usize, actions: usize) -> Option<Self> {
        let Some(index) = index.checked_sub(1) else {
            return Some(Self::Plain);
        };
        let relations = actions.saturating_add(SUPERLATIVES);
        match index.checked_sub(relations) {
            None => Some(Self::Restricts(kind(index, actions)?)),
            Some(index) => Some(Self::StandsFor(kind(index, actions)?)),
        }
    }

    /// The action or compound by which the group is related to another object, if it is.
    pub(super) const fn action(self) -> Option<u8> {
        match self {
            Self::Restricts(RelationKind::Action(action))
            | Self::StandsFor(RelationKind::Action(action)) => Some(action),
            _ => None,
        }
    }

    /// Whether it begins the description of an object of the step.
    const fn is_head(self) -> bool {
        !matches!(self, Self::Restricts(_))
    }
}

/// Relations of every model beside those of its actions.
pub(crate) const SUPERLATIVES: usize = ORDER.len();
/// Their order; they follow the actions.
const ORDER: [RelationKind; 2] = [RelationKind::Nearest, RelationKind::Farthest];

/// The relation with this index; `None` if it is none.
fn kind(index: usize, actions: usize) -> Option<RelationKind> {
    match index.checked_sub(actions) {
        None => Some(RelationKind::Action(u8::try_from(index).ok()?)),
        Some(superlative) => ORDER.get(superlative).copied(),
    }
}

/// The relation decoder: softmax over 0 for [`GroupRole::Plain`] and a logit for each relation, an
/// action's or a superlative, and each of its two directions, `w·state + b`. The index is that of
/// [`GroupRole::of`]: first all that restrict, then all that stand for an object.
///
/// * `state`: the encoder's, at the group
/// * `is_first`: nothing is described before the group, which it could restrict
///
/// Cost: `2·96` multiply-adds and two exponentials a relation.
pub fn choose_role(model: &Model<'_>, state: &[f32; INSTRUCTION], is_first: bool) -> Choice {
    let mut choice = Choice::new();
    choice.offer(0.0);
    for ([restricts, _], [bias, _]) in decoders(model) {
        if is_first {
            choice.skip();
        } else {
            choice.offer(dot(restricts, state) + bias);
        }
    }
    for ([_, stands_for], [_, bias]) in decoders(model) {
        choice.offer(dot(stands_for, state) + bias);
    }
    choice
}

/// The rows of each relation, with their biases.
fn decoders<'m>(
    model: &Model<'m>,
) -> impl Iterator<Item = (&'m [[f32; INSTRUCTION]; 2], [f32; 2])> {
    let of_actions = model
        .actions
        .iter()
        .map(|action| (&action.relation_decoder, action.relation_bias));
    let superlatives = [model.language.nearest, model.language.farthest];
    of_actions.chain(superlatives.map(|each| (&each.decoder, each.bias)))
}

/// The roles of a step's groups, in the order of the sentence.
///
/// A *head* begins the description of an object of the step; the groups that follow it up to the
/// next head are the chain of its relations.
#[derive(Debug, Clone)]
pub(super) struct Roles {
    roles: Vec<GroupRole, MAX_GROUPS, u8>,
    /// That all are right.
    probability: f32,
}

impl Roles {
    pub(super) const fn new() -> Self {
        Self {
            roles: Vec::new(),
            probability: 1.0,
        }
    }

    /// The role of the next group. A step with more groups than places is refused before.
    pub(super) fn push(&mut self, role: GroupRole, probability: f32) {
        let _ = self.roles.push(role);
        self.probability *= probability;
    }

    /// How many groups have one.
    pub(super) fn count(&self) -> usize {
        self.roles.len()
    }

    /// The probability that all are right.
    pub(super) const fn probability(&self) -> f32 {
        self.probability
    }

    /// How many groups are in a relation that this holds of.
    pub(super) fn related_by(&self, holds: impl Fn(u8) -> bool) -> usize {
        let roles = self.roles.iter();
        roles
            .filter(|role| role.action().is_some_and(&holds))
            .count()
    }

    /// The role of a group.
    pub(super) fn get(&self, group: usize) -> Option<GroupRole> {
        self.roles.get(group).copied()
    }

    /// The groups that begin a description.
    pub(super) fn heads(&self) -> impl Iterator<Item = usize> {
        let roles = self.roles.iter().enumerate();
        roles.filter_map(|(group, role)| role.is_head().then_some(group))
    }

    /// The groups of the description that the `head`th head begins, counted from 0.
    pub(super) fn chain(&self, head: usize) -> Option<Range<usize>> {
        let mut heads = self.heads().skip(head);
        let first = heads.next()?;
        Some(first..heads.next().unwrap_or(self.roles.len()))
    }

    /// The description by the groups of a chain; `None` if it has too many relations.
    ///
    /// * `filters`: of each group of the chain
    pub(super) fn describe(&self, chain: Range<usize>, filters: &[Filters]) -> Option<Description> {
        let roles = self.roles.get(chain).unwrap_or_default();
        let mut description = Description::new();
        for (role, &to) in roles.iter().zip(filters) {
            match *role {
                GroupRole::Plain => description = Description::of(to),
                GroupRole::Restricts(kind) | GroupRole::StandsFor(kind) => {
                    description.relate(Relation { kind, to }).ok()?;
                }
            }
        }
        Some(description)
    }
}

#[cfg(test)]
mod tests {
    use super::RelationKind::{Action, Farthest, Nearest};
    use super::*;
    use crate::fixture::{self, filters};
    use crate::model;

    fn taught<'a>(actions: &'a [model::Action<'a>]) -> Model<'a> {
        fixture::model().with_actions(actions)
    }

    #[test]
    fn a_role_is_the_greatest_logit_and_the_first_group_restricts_nothing() {
        let mut actions = [fixture::model().actions[0], fixture::model().actions[1]];
        actions[1].relation_decoder[0][5] = 2.0;
        actions[1].relation_bias[0] = 0.5;
        actions[0].relation_decoder[1][95] = 4.0;
        actions[0].relation_bias[1] = 0.25;
        let mut state = [0.0; INSTRUCTION];
        state[5] = 0.75;
        // 2·0.75 + 0.5 against 0 and 0.25.

        let choice = choose_role(&taught(&actions), &state, false);
        let expected = 1.0 / (1.0 + libm::expf(-2.0) + libm::expf(-1.75));
        assert!((choice.probability() - expected).abs() < 1e-6);
        let role = |choice: Choice| GroupRole::of(choice.index().unwrap(), 2);
        assert_eq!(role(choice), Some(GroupRole::Restricts(Action(1))));
        let first = choose_role(&taught(&actions), &state, true);
        assert_eq!(role(first), Some(GroupRole::StandsFor(Action(0))));
        let expected = 1.0 / (1.0 + libm::expf(-0.25));
        assert!((first.probability() - expected).abs() < 1e-6);
        // A model that was not taught relations.
        let untaught = choose_role(&fixture::model(), &state, false);
        assert_eq!(role(untaught), Some(GroupRole::Plain));
        assert_eq!(untaught.probability(), 1.0);
        let mut broken = actions;
        broken[1].relation_bias[1] = f32::NAN;
        assert_eq!(choose_role(&taught(&broken), &state, true).index(), None);
    }

    #[test]
    fn superlatives_stand_behind_the_actions() {
        let model = fixture::model();
        let (mut nearest, mut farthest) = (*model.language.nearest, *model.language.farthest);
        nearest.decoder[1][95] = 4.0;
        farthest.decoder[0][5] = 4.0;
        farthest.bias[0] = 0.5;
        let language = model.language.with_nearest(&nearest);
        let taught = model.with_language(language.with_farthest(&farthest));
        let mut state = [0.0; INSTRUCTION];
        (state[5], state[95]) = (1.0, 6.0);
        let role = |is_first| {
            let choice = choose_role(&taught, &state, is_first);
            GroupRole::of(choice.index().unwrap(), 2)
        };
        assert_eq!(role(false), Some(GroupRole::Restricts(Farthest)));
        assert_eq!(role(true), Some(GroupRole::StandsFor(Nearest)));
        let mut broken = nearest;
        broken.bias[0] = f32::NAN;
        let broken = taught.with_language(taught.language.with_nearest(&broken));
        assert_eq!(choose_role(&broken, &state, false).index(), None);
    }

    #[test]
    fn indices_are_plain_then_restricting_then_standing_for() {
        let roles: [_; 10] = core::array::from_fn(|index| GroupRole::of(index, 2));
        assert_eq!(
            roles,
            [
                Some(GroupRole::Plain),
                Some(GroupRole::Restricts(Action(0))),
                Some(GroupRole::Restricts(Action(1))),
                Some(GroupRole::Restricts(Nearest)),
                Some(GroupRole::Restricts(Farthest)),
                Some(GroupRole::StandsFor(Action(0))),
                Some(GroupRole::StandsFor(Action(1))),
                Some(GroupRole::StandsFor(Nearest)),
                Some(GroupRole::StandsFor(Farthest)),
                None
            ]
        );
    }

    fn described(roles: &Roles, head: usize) -> Option<Description> {
        let groups: std::vec::Vec<_> = (0..6).map(|concept| filters(&[concept])).collect();
        let chain = roles.chain(head).unwrap();
        roles.describe(chain.clone(), &groups[chain])
    }

    #[test]
    fn a_head_and_what_restricts_it_are_one_description() {
        use GroupRole::{Plain, Restricts, StandsFor};
        let mut roles = Roles::new();
        for role in [
            Plain,
            Restricts(Action(1)),
            StandsFor(Nearest),
            Restricts(Action(1)),
        ] {
            roles.push(role, 0.5);
        }
        assert_eq!(roles.probability(), 0.0625);
        assert!(roles.heads().eq([0, 2]));
        assert_eq!((roles.chain(0), roles.chain(1)), (Some(0..2), Some(2..4)));
        assert_eq!(roles.chain(2), None);
        let relation = |kind, concept| Relation {
            kind,
            to: filters(&[concept]),
        };
        let first = described(&roles, 0).unwrap();
        assert_eq!(first.filters(), &filters(&[0]));
        assert_eq!(first.relations(), [relation(Action(1), 1)]);
        let second = described(&roles, 1).unwrap();
        assert_eq!(second.filters(), &Filters::new());
        assert_eq!(
            second.relations(),
            [relation(Nearest, 2), relation(Action(1), 3)]
        );
    }

    #[test]
    fn a_chain_has_so_many_relations_and_no_more() {
        let chain = |head| {
            let mut roles = Roles::new();
            roles.push(head, 1.0);
            roles.push(GroupRole::Restricts(Action(0)), 1.0);
            roles.push(GroupRole::Restricts(Farthest), 1.0);
            described(&roles, 0)
        };
        assert!(chain(GroupRole::Plain).is_some());
        assert_eq!(chain(GroupRole::StandsFor(Action(1))), None);
    }
}
