//! Layers in candle, with the parameters of the model file.

use std::collections::HashMap;

use candle_core::{Result, Tensor};
use candle_nn::ops::sigmoid;

use super::tensor;

/// `x·W + b`, with the weight transposed beforehand.
#[derive(Debug, Clone)]
pub(crate) struct Linear {
    weight: Tensor,
    bias: Tensor,
}

impl Linear {
    /// * `weight`: `[inputs, outputs]`
    pub(crate) fn new(weight: Tensor, bias: Tensor) -> Self {
        Self { weight, bias }
    }

    pub(crate) fn read(file: &HashMap<String, Tensor>, name: &str) -> Result<Self> {
        let weight = tensor(file, &format!("{name}.weight"))?.t()?.contiguous()?;
        Ok(Self::new(weight, tensor(file, &format!("{name}.bias"))?))
    }

    /// Both layers' outputs, one after the other.
    pub(crate) fn beside(&self, other: &Self) -> Result<Self> {
        Ok(Self {
            weight: Tensor::cat(&[&self.weight, &other.weight], 1)?.contiguous()?,
            bias: Tensor::cat(&[&self.bias, &other.bias], 0)?,
        })
    }

    pub(crate) fn inputs(&self) -> Result<usize> {
        self.weight.dim(0)
    }

    pub(crate) fn apply(&self, rows: &Tensor) -> Result<Tensor> {
        rows.matmul(&self.weight)?.broadcast_add(&self.bias)
    }
}

/// One cell, or two of which the second runs backward; both take each step together.
#[derive(Debug, Clone)]
pub(crate) struct Gru {
    /// `[D, I, 3H]`
    weight_ih: Tensor,
    /// `[D, 1, 3H]`
    bias: Tensor,
    /// `[D, H, 3H]`
    weight_hh: Tensor,
    /// `[D, 1, H]`
    bias_n: Tensor,
}

impl Gru {
    pub(crate) fn read(file: &HashMap<String, Tensor>, names: &[&str]) -> Result<Self> {
        let stacked = |part: &str| {
            let parts = names.iter().map(|name| {
                let tensor = tensor(file, &format!("{name}.{part}"))?;
                match tensor.rank() {
                    1 => tensor.unsqueeze(0),
                    _ => tensor.t()?.contiguous(),
                }
            });
            Tensor::stack(&parts.collect::<Result<Vec<_>>>()?, 0)
        };
        Ok(Self {
            weight_ih: stacked("weight_ih")?,
            bias: stacked("bias")?,
            weight_hh: stacked("weight_hh")?,
            bias_n: stacked("bias_n")?,
        })
    }

    /// Words `[T, I]` to states `[D, T, H]`.
    pub(crate) fn states(&self, words: &Tensor) -> Result<Tensor> {
        let (cells, _, hidden) = self.bias_n.dims3()?;
        let count = words.dim(0)?;
        let inputs = match cells {
            1 => words.unsqueeze(0)?,
            _ => Tensor::stack(&[words, &words.flip(&[0])?], 0)?,
        };
        let gates = inputs.matmul(&self.weight_ih)?.broadcast_add(&self.bias)?;
        let mut state = self.bias_n.zeros_like()?;
        let mut states = Vec::with_capacity(count);
        for token in 0..count {
            let gate = gates.narrow(1, token, 1)?;
            let product = state.matmul(&self.weight_hh)?;
            let both = (gate.narrow(2, 0, 2 * hidden)? + product.narrow(2, 0, 2 * hidden)?)?;
            let both = sigmoid(&both.contiguous()?)?;
            let (reset, update) = (both.narrow(2, 0, hidden)?, both.narrow(2, hidden, hidden)?);
            let product = (product.narrow(2, 2 * hidden, hidden)? + &self.bias_n)?;
            let new = (gate.narrow(2, 2 * hidden, hidden)? + (reset * product)?)?.tanh()?;
            state = (&new + (update * (state - &new)?)?)?;
            states.push(state.clone());
        }
        if cells == 1 {
            return Tensor::cat(&states, 1);
        }
        let of = |cell| states.iter().map(move |state| state.get(cell));
        let ahead: Vec<Tensor> = of(0).collect::<Result<_>>()?;
        let back: Vec<Tensor> = of(1).rev().collect::<Result<_>>()?;
        Tensor::stack(&[Tensor::cat(&ahead, 0)?, Tensor::cat(&back, 0)?], 0)
    }
}

/// The network of one view of a crop. Strides are equal to kernels, so that each convolution is a
/// product with the patches as rows.
#[derive(Debug, Clone)]
pub(crate) struct ViewEncoder {
    patch: Linear,
    merge: Linear,
    dense: Linear,
}

impl ViewEncoder {
    pub(crate) fn read(file: &HashMap<String, Tensor>, name: &str) -> Result<Self> {
        let get = |part: &str| tensor(file, &format!("{name}.{part}"));
        let rows = |weight: Tensor| weight.flatten_from(1)?.t()?.contiguous();
        let patch = get("patch.weight")?;
        // Maps are by row, column, channel from here on.
        let merge = get("merge.weight")?.permute((0, 2, 3, 1))?.contiguous()?;
        let dense = get("dense.weight")?;
        let dense = dense.reshape((dense.dim(0)?, merge.dim(0)?, ()))?;
        Ok(Self {
            patch: Linear::new(rows(patch)?, get("patch.bias")?),
            merge: Linear::new(rows(merge)?, get("merge.bias")?),
            dense: Linear::new(
                rows(dense.transpose(1, 2)?.contiguous()?)?,
                get("dense.bias")?,
            ),
        })
    }

    /// `[N, channels, 32, 32]` to `[N, 32]`.
    pub(crate) fn apply(&self, view: &Tensor) -> Result<Tensor> {
        let (count, channels, side, _) = view.dims4()?;
        let side = side / 4;
        let cells = view.reshape((count, channels, side, 4, side, 4))?;
        let cells = cells.permute((0, 2, 4, 1, 3, 5))?;
        let hidden = self
            .patch
            .apply(&cells.reshape((count * side * side, ()))?)?
            .relu()?;
        let side = side / 2;
        let channels = hidden.dim(1)?;
        let cells = hidden.reshape((count, side, 2, side, 2, channels))?;
        let cells = cells.permute((0, 1, 3, 2, 4, 5))?;
        let hidden = self
            .merge
            .apply(&cells.reshape((count * side * side, ()))?)?
            .relu()?;
        self.dense.apply(&hidden.reshape((count, ()))?)?.relu()
    }
}
