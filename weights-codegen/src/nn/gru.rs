use nsrm_core::nn::Gru;

use crate::error::ModelError;
use crate::tensors::Tensors;
use crate::tree::{Describe, Node};

/// The input part of a GRU cell, which is folded into each word.
pub(crate) struct Gates {
    /// `[3·HIDDEN, INPUT]`, row-major; gates ordered reset, update, new.
    weight_ih: Vec<f32>,
    /// `[3·HIDDEN]`, added to the product.
    bias: Vec<f32>,
}

impl Gates {
    /// `W_ih·e + b`, summed in `f64`.
    ///
    /// * `embedding`: `[INPUT]`
    /// * returns the reset, update and new gate's shares, `[HIDDEN]` each
    pub(crate) fn fold<const HIDDEN: usize, const INPUT: usize>(
        &self,
        embedding: &[f32; INPUT],
    ) -> [[f32; HIDDEN]; 3] {
        std::array::from_fn(|gate| {
            std::array::from_fn(|unit| {
                let row = gate * HIDDEN + unit;
                let weights = &self.weight_ih[row * INPUT..][..INPUT];
                let product: f64 = weights
                    .iter()
                    .zip(embedding)
                    .map(|(&weight, &value)| f64::from(weight) * f64::from(value))
                    .sum();
                (product + f64::from(self.bias[row])) as f32
            })
        })
    }
}

/// Reads `{name}.weight_ih [3·HIDDEN, INPUT]`, `{name}.weight_hh [3·HIDDEN, HIDDEN]`,
/// `{name}.bias [3·HIDDEN]` and `{name}.bias_n [HIDDEN]`.
pub(crate) fn gru<const HIDDEN: usize, const INPUT: usize>(
    tensors: &mut Tensors,
    name: &str,
) -> Result<(Gates, Gru<HIDDEN>), ModelError> {
    let rows = 3 * HIDDEN;
    let weight_ih = tensors.take(&format!("{name}.weight_ih"), &[rows, INPUT])?;
    let weight_hh = tensors.take(&format!("{name}.weight_hh"), &[rows, HIDDEN])?;
    let bias = tensors.take(&format!("{name}.bias"), &[rows])?;
    let recurrent = Gru::new()
        .with_weight_hh(std::array::from_fn(|column| {
            std::array::from_fn(|gate| {
                std::array::from_fn(|unit| weight_hh[(gate * HIDDEN + unit) * HIDDEN + column])
            })
        }))
        .with_bias_n(tensors.vector(&format!("{name}.bias_n"))?);
    Ok((Gates { weight_ih, bias }, recurrent))
}

impl<const HIDDEN: usize> Describe for Gru<HIDDEN> {
    fn describe(&self) -> Node {
        let Self {
            weight_hh, bias_n, ..
        } = self;
        Node::record(
            "Gru",
            [
                ("weight_hh", weight_hh.describe()),
                ("bias_n", bias_n.describe()),
            ],
        )
    }
}
