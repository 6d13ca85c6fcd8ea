use crate::model::{Action, INSTRUCTION};
use crate::nn::{Choice, Linear, dot};

/// The action decoder (section IV-B): softmax over a logit for each action,
/// `w_a·emb(Λ) + b_a`.
///
/// Cost: `96` multiply-adds and one exponential an action.
pub fn choose_action(actions: &[Action<'_>], instruction: &[f32; INSTRUCTION]) -> Choice {
    let mut choice = Choice::new();
    for action in actions {
        choice.offer(dot(&action.decoder, instruction) + action.decoder_bias);
    }
    choice
}

/// An argument decoder (section IV-B): `c = W·emb(Λ) + b`, then softmax over its
/// dot product with the encoder's state at each concept group.
///
/// Cost: `96²` multiply-adds, and 96 and one exponential a group.
pub fn choose_group(
    decoder: &Linear<INSTRUCTION, INSTRUCTION>,
    instruction: &[f32; INSTRUCTION],
    groups: &[[f32; INSTRUCTION]],
) -> Choice {
    let sought = decoder.apply(instruction);
    let mut choice = Choice::new();
    for group in groups {
        choice.offer(dot(&sought, group));
    }
    choice
}
