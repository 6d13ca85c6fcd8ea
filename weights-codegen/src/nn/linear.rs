use nsrm_core::nn::{Int8Linear, Linear};

use crate::error::ModelError;
use crate::tensors::Tensors;
use crate::tree::{Describe, Node};

/// Reads `{name}.weight [OUTPUT, INPUT]` and `{name}.bias [OUTPUT]`.
pub(crate) fn linear<const INPUT: usize, const OUTPUT: usize>(
    tensors: &mut Tensors,
    name: &str,
) -> Result<Linear<INPUT, OUTPUT>, ModelError> {
    let mut layer = Linear::new();
    layer.weight = tensors.columns(&format!("{name}.weight"))?;
    layer.bias = tensors.vector(&format!("{name}.bias"))?;
    Ok(layer)
}

impl<const INPUT: usize, const OUTPUT: usize> Describe for Linear<INPUT, OUTPUT> {
    fn describe(&self) -> Node {
        let Self { weight, bias, .. } = self;
        Node::record(
            "Linear",
            [("weight", weight.describe()), ("bias", bias.describe())],
        )
    }
}

impl<const INPUT: usize, const OUTPUT: usize> Describe for Int8Linear<INPUT, OUTPUT> {
    fn describe(&self) -> Node {
        let Self {
            weight,
            scale,
            bias,
            ..
        } = self;
        Node::record(
            "Int8Linear",
            [
                ("weight", weight.describe()),
                ("scale", scale.describe()),
                ("bias", bias.describe()),
            ],
        )
    }
}
