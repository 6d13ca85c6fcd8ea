use nsrm_core::nn::Conv;

use crate::error::ModelError;
use crate::tensors::Tensors;
use crate::tree::{Describe, Node};

/// Reads `{name}.weight [OUTPUT, INPUT, KERNEL, KERNEL]` and `{name}.bias [OUTPUT]`.
pub(crate) fn conv<const INPUT: usize, const OUTPUT: usize, const KERNEL: usize>(
    tensors: &mut Tensors,
    name: &str,
) -> Result<Conv<INPUT, OUTPUT, KERNEL>, ModelError> {
    let weight = tensors.take(&format!("{name}.weight"), &[OUTPUT, INPUT, KERNEL, KERNEL])?;
    let at = |output, input, row, column| {
        weight[((output * INPUT + input) * KERNEL + row) * KERNEL + column]
    };
    Ok(Conv::new()
        .with_weight(std::array::from_fn(|input| {
            std::array::from_fn(|row| {
                std::array::from_fn(|column| {
                    std::array::from_fn(|output| at(output, input, row, column))
                })
            })
        }))
        .with_bias(tensors.vector(&format!("{name}.bias"))?))
}

impl<const INPUT: usize, const OUTPUT: usize, const KERNEL: usize> Describe
    for Conv<INPUT, OUTPUT, KERNEL>
{
    fn describe(&self) -> Node {
        let Self { weight, bias, .. } = self;
        Node::record(
            "Conv",
            [("weight", weight.describe()), ("bias", bias.describe())],
        )
    }
}
