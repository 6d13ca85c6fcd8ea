use nsrm_core::nn::{MergeConv, PatchConv};

use crate::error::ModelError;
use crate::tensors::Tensors;
use crate::tree::{Describe, Node};

/// Reads `{name}.weight [OUTPUT, INPUT, 4, 4]` and `{name}.bias [OUTPUT]`.
pub(crate) fn patch_conv<const INPUT: usize, const OUTPUT: usize>(
    tensors: &mut Tensors,
    name: &str,
) -> Result<PatchConv<INPUT, OUTPUT>, ModelError> {
    let weight = Kernels::read::<INPUT, OUTPUT, 4>(tensors, name)?;
    Ok(PatchConv::new()
        .with_weight(std::array::from_fn(|input| {
            std::array::from_fn(|row| {
                std::array::from_fn(|column| {
                    std::array::from_fn(|output| weight.at(output, input, row, column))
                })
            })
        }))
        .with_bias(tensors.vector(&format!("{name}.bias"))?))
}

/// Reads `{name}.weight [OUTPUT, INPUT, 2, 2]` and `{name}.bias [OUTPUT]`.
pub(crate) fn merge_conv<const INPUT: usize, const OUTPUT: usize>(
    tensors: &mut Tensors,
    name: &str,
) -> Result<MergeConv<INPUT, OUTPUT>, ModelError> {
    let weight = Kernels::read::<INPUT, OUTPUT, 2>(tensors, name)?;
    Ok(MergeConv::new()
        .with_weight(std::array::from_fn(|row| {
            std::array::from_fn(|column| {
                std::array::from_fn(|input| {
                    std::array::from_fn(|output| weight.at(output, input, row, column))
                })
            })
        }))
        .with_bias(tensors.vector(&format!("{name}.bias"))?))
}

/// A convolution's weights as the trainer writes them: by output, input, row and column.
struct Kernels {
    weight: Vec<f32>,
    inputs: usize,
    side: usize,
}

impl Kernels {
    fn read<const INPUT: usize, const OUTPUT: usize, const SIDE: usize>(
        tensors: &mut Tensors,
        name: &str,
    ) -> Result<Self, ModelError> {
        let shape = [OUTPUT, INPUT, SIDE, SIDE];
        Ok(Self {
            weight: tensors.take(&format!("{name}.weight"), &shape)?,
            inputs: INPUT,
            side: SIDE,
        })
    }

    fn at(&self, output: usize, input: usize, row: usize, column: usize) -> f32 {
        self.weight[((output * self.inputs + input) * self.side + row) * self.side + column]
    }
}

impl<const INPUT: usize, const OUTPUT: usize> Describe for PatchConv<INPUT, OUTPUT> {
    fn describe(&self) -> Node {
        let Self { weight, bias, .. } = self;
        Node::record(
            "PatchConv",
            [("weight", weight.describe()), ("bias", bias.describe())],
        )
    }
}

impl<const INPUT: usize, const OUTPUT: usize> Describe for MergeConv<INPUT, OUTPUT> {
    fn describe(&self) -> Node {
        let Self { weight, bias, .. } = self;
        Node::record(
            "MergeConv",
            [("weight", weight.describe()), ("bias", bias.describe())],
        )
    }
}
