//! Action decoder's and relation decoder's rows, and action simulator (section IV-D).

use nsrm_core::model::{INSTRUCTION, LOCATION, SIMULATOR_HIDDEN, Superlative};
use nsrm_core::nn::Linear;

use super::finite;
use crate::error::ModelError;
use crate::nn::linear;
use crate::tensors::Tensors;

/// The trainer multiplies the simulator's output by this.
const OUTPUT_SCALE: f64 = 0.1;

/// The parameters of one action.
#[derive(Debug)]
pub(crate) struct FoldedAction {
    pub(crate) decoder: [f32; INSTRUCTION],
    pub(crate) decoder_bias: f32,
    pub(crate) relation_decoder: [[f32; INSTRUCTION]; 2],
    pub(crate) relation_bias: [f32; 2],
    pub(crate) simulator_bias: [f32; SIMULATOR_HIDDEN],
}

/// The parameters of all actions, and what the tensors of some contain, too.
#[derive(Debug)]
pub(crate) struct FoldedActions {
    pub(crate) actions: Vec<FoldedAction>,
    pub(crate) nearest: Box<Superlative>,
    pub(crate) farthest: Box<Superlative>,
    pub(crate) simulator: FoldedSimulator,
}

/// The parameters of all actions' simulator.
#[derive(Debug)]
pub(crate) struct FoldedSimulator {
    pub(crate) input: [[f32; SIMULATOR_HIDDEN]; 2 * LOCATION],
    pub(crate) hidden: Box<Linear<SIMULATOR_HIDDEN, SIMULATOR_HIDDEN>>,
    pub(crate) output: Linear<SIMULATOR_HIDDEN, LOCATION>,
}

/// The number of superlatives.
const SUPERLATIVES: usize = 2;

/// Reads the action decoder, the relation decoder and the simulator.
///
/// With `x = (location - mean) / scale`, the first layer `W·[onehot, x] + b`
/// becomes `Σ_j location[j]·(W_j / scale[j])` and, for each action, the constant
/// `b + W_action - Σ_j W_j·mean[j] / scale[j]`.
///
/// * `count`: number of actions
pub(crate) fn read(tensors: &mut Tensors, count: usize) -> Result<FoldedActions, ModelError> {
    const NAME: &str = "action.simulator";
    let decoder = tensors.rows::<INSTRUCTION>("language.action_decoder.weight", count)?;
    let decoder_bias = tensors.take("language.action_decoder.bias", &[count])?;
    // A row for each relation that restricts, those of actions and then the superlatives; then one
    // for each that stands for an object.
    let half = count + SUPERLATIVES;
    let relations = tensors.rows::<INSTRUCTION>("language.relation_decoder.weight", 2 * half)?;
    let relation_bias = tensors.take("language.relation_decoder.bias", &[2 * half])?;
    let rows = |relation: usize| [relations[relation], relations[half + relation]];
    let biases = |relation: usize| [relation_bias[relation], relation_bias[half + relation]];
    let superlative = |relation: usize| {
        let superlative = Superlative::new().with_decoder(rows(relation));
        Box::new(superlative.with_bias(biases(relation)))
    };
    let width = count + 2 * LOCATION;
    let weight = tensors.take(&format!("{NAME}.input.weight"), &[SIMULATOR_HIDDEN, width])?;
    let bias = tensors.vector::<SIMULATOR_HIDDEN>(&format!("{NAME}.input.bias"))?;
    let mean = tensors.vector::<LOCATION>(&format!("{NAME}.location_mean"))?;
    let scale = tensors.vector::<LOCATION>(&format!("{NAME}.location_scale"))?;
    if let Some(index) = scale.iter().position(|&scale| scale <= 0.0) {
        return Err(ModelError::LocationScale {
            index,
            got: scale[index],
        });
    }
    let weight_at = |row: usize, column: usize| f64::from(weight[row * width + column]);
    let scaled = |row, column| weight_at(row, count + column) / f64::from(scale[column % LOCATION]);
    let shift: [f64; SIMULATOR_HIDDEN] = std::array::from_fn(|row| {
        let shares = (0..2 * LOCATION).map(|j| scaled(row, j) * f64::from(mean[j % LOCATION]));
        f64::from(bias[row]) - shares.sum::<f64>()
    });
    let input = std::array::from_fn(|column| std::array::from_fn(|row| scaled(row, column) as f32));
    let mut output: Linear<SIMULATOR_HIDDEN, LOCATION> =
        linear(tensors, &format!("{NAME}.output"))?;
    for value in output
        .weight
        .as_flattened_mut()
        .iter_mut()
        .chain(&mut output.bias)
    {
        *value = (f64::from(*value) * OUTPUT_SCALE) as f32;
    }
    let simulator = FoldedSimulator {
        input,
        hidden: Box::new(linear(tensors, &format!("{NAME}.hidden"))?),
        output,
    };
    finite("simulator.input", simulator.input.as_flattened())?;
    let actions = decoder
        .into_iter()
        .zip(decoder_bias)
        .enumerate()
        .map(|(action, (decoder, decoder_bias))| {
            let simulator_bias =
                std::array::from_fn(|row| (shift[row] + weight_at(row, action)) as f32);
            finite("actions.simulator_bias", &simulator_bias)?;
            Ok(FoldedAction {
                decoder,
                decoder_bias,
                relation_decoder: rows(action),
                relation_bias: biases(action),
                simulator_bias,
            })
        })
        .collect::<Result<Vec<FoldedAction>, ModelError>>()?;
    Ok(FoldedActions {
        actions,
        nearest: superlative(count),
        farthest: superlative(count + 1),
        simulator,
    })
}
