use crate::model::{Action, INSTRUCTION};
use crate::nn::{Choice, Dense, dot};

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
///
/// * `groups`: the states at those that describe an object of the step, not one that another is
///   related to
pub fn choose_group<'g>(
    decoder: &Dense<'_, INSTRUCTION, INSTRUCTION>,
    instruction: &[f32; INSTRUCTION],
    groups: impl IntoIterator<Item = &'g [f32; INSTRUCTION]>,
) -> Choice {
    let sought = decoder.apply(instruction);
    let mut choice = Choice::new();
    for group in groups {
        choice.offer(dot(&sought, group));
    }
    choice
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture;

    #[test]
    fn an_argument_is_the_group_most_like_the_decoded_vector() {
        let mut decoder = fixture::linear();
        // c[95] = 2·emb[3] + 0.5; transposed it would be c[3].
        decoder.weight[3][95] = 2.0;
        decoder.bias[95] = 0.5;
        let mut instruction = [0.0; INSTRUCTION];
        instruction[3] = 1.0;
        let mut groups = [[0.0; INSTRUCTION]; 3];
        (groups[0][95], groups[1][95], groups[2][3]) = (0.2, 0.6, 100.0);
        let choice = choose_group(&Dense::F32(&decoder), &instruction, &groups);
        assert_eq!(choice.index(), Some(1));
        // Logits 0.5, 1.5 and 0.
        let expected = 1.0 / (1.0 + libm::expf(-1.0) + libm::expf(-1.5));
        assert!((choice.probability() - expected).abs() < 1e-6);
    }

    #[test]
    fn an_action_is_the_greatest_logit() {
        let model = fixture::model();
        let mut instruction = [0.0; INSTRUCTION];
        assert_eq!(choose_action(model.actions, &instruction).index(), Some(0));
        instruction[3] = 0.75;
        let choice = choose_action(model.actions, &instruction);
        assert_eq!(choice.index(), Some(1));
        // 20·0.75 against the other's bias of 10.
        let expected = 1.0 / (1.0 + libm::expf(-5.0));
        assert!((choice.probability() - expected).abs() < 1e-6);
    }
}
