use nsrm_core::nn::{Gru, Int8Gru};

use crate::error::ModelError;
use crate::tensors::Tensors;
use crate::tree::{Describe, Node};

/// Reads `{name}.weight_ih [3·HIDDEN, INPUT]`, `{name}.weight_hh [3·HIDDEN, HIDDEN]`,
/// `{name}.bias [3·HIDDEN]` and `{name}.bias_n [HIDDEN]`; gates ordered reset, update, new.
pub(crate) fn gru<const INPUT: usize, const HIDDEN: usize>(
    tensors: &mut Tensors,
    name: &str,
) -> Result<Gru<INPUT, HIDDEN>, ModelError> {
    let rows = 3 * HIDDEN;
    let weight_ih = tensors.take(&format!("{name}.weight_ih"), &[rows, INPUT])?;
    let weight_hh = tensors.take(&format!("{name}.weight_hh"), &[rows, HIDDEN])?;
    let bias = tensors.take(&format!("{name}.bias"), &[rows])?;
    Ok(Gru::new()
        .with_weight_ih(columns(&weight_ih))
        .with_bias(std::array::from_fn(|gate| {
            std::array::from_fn(|unit| bias[gate * HIDDEN + unit])
        }))
        .with_weight_hh(columns(&weight_hh))
        .with_bias_n(tensors.vector(&format!("{name}.bias_n"))?))
}

/// The columns of a row-major matrix `[3·HIDDEN, COLUMNS]`, each divided into the three gates.
fn columns<const COLUMNS: usize, const HIDDEN: usize>(
    matrix: &[f32],
) -> [[[f32; HIDDEN]; 3]; COLUMNS] {
    std::array::from_fn(|column| {
        std::array::from_fn(|gate| {
            std::array::from_fn(|unit| matrix[(gate * HIDDEN + unit) * COLUMNS + column])
        })
    })
}

impl<const INPUT: usize, const HIDDEN: usize> Describe for Gru<INPUT, HIDDEN> {
    fn describe(&self) -> Node {
        let Self {
            weight_ih,
            bias,
            weight_hh,
            bias_n,
            ..
        } = self;
        Node::record(
            "Gru",
            [
                ("weight_ih", weight_ih.describe()),
                ("bias", bias.describe()),
                ("weight_hh", weight_hh.describe()),
                ("bias_n", bias_n.describe()),
            ],
        )
    }
}

impl<const INPUT: usize, const HIDDEN: usize> Describe for Int8Gru<INPUT, HIDDEN> {
    fn describe(&self) -> Node {
        let Self {
            weight_ih,
            scale_ih,
            bias,
            weight_hh,
            scale_hh,
            bias_n,
            ..
        } = self;
        Node::record(
            "Int8Gru",
            [
                ("weight_ih", weight_ih.describe()),
                ("scale_ih", scale_ih.describe()),
                ("bias", bias.describe()),
                ("weight_hh", weight_hh.describe()),
                ("scale_hh", scale_hh.describe()),
                ("bias_n", bias_n.describe()),
            ],
        )
    }
}
