//! The model file's tensors: read, checked, and taken by name and shape.

use std::collections::BTreeMap;

use safetensors::{Dtype, SafeTensors};

use crate::error::ModelError;

/// Tensors not yet taken. Each is `f32` and finite.
///
/// Every layer takes its own by name and shape; any tensor left at the end is not part of the
/// architecture.
pub(crate) struct Tensors {
    entries: BTreeMap<String, Tensor>,
}

struct Tensor {
    shape: Vec<usize>,
    /// Row-major.
    values: Vec<f32>,
}

impl Tensors {
    pub(crate) fn read(file: &SafeTensors<'_>) -> Result<Self, ModelError> {
        let mut entries = BTreeMap::new();
        for (name, view) in file.iter() {
            if view.dtype() != Dtype::F32 {
                return Err(ModelError::ElementType {
                    name: name.into(),
                    got: format!("{:?}", view.dtype()),
                });
            }
            let (bytes, _) = view.data().as_chunks::<4>();
            let values = bytes.iter().copied().map(f32::from_le_bytes).collect();
            let shape = view.shape().to_vec();
            entries.insert(name.to_owned(), Tensor { shape, values });
        }
        for (name, tensor) in &entries {
            let wrong = tensor.values.iter().position(|value| !value.is_finite());
            if let Some(index) = wrong {
                return Err(ModelError::NotFinite {
                    name: name.clone(),
                    index,
                    got: format!("{:?}", tensor.values[index]),
                });
            }
        }
        Ok(Self { entries })
    }

    /// The values of a tensor in row-major order; `expected.product()` of them.
    pub(crate) fn take(&mut self, name: &str, expected: &[usize]) -> Result<Vec<f32>, ModelError> {
        let tensor = self
            .entries
            .remove(name)
            .ok_or_else(|| ModelError::MissingTensor {
                name: name.into(),
                expected: expected.to_vec(),
            })?;
        if tensor.shape != expected {
            return Err(ModelError::Shape {
                name: name.into(),
                expected: expected.to_vec(),
                got: tensor.shape,
            });
        }
        Ok(tensor.values)
    }

    /// A tensor of shape `[N]`.
    pub(crate) fn vector<const N: usize>(&mut self, name: &str) -> Result<[f32; N], ModelError> {
        let values = self.take(name, &[N])?;
        Ok(std::array::from_fn(|index| values[index]))
    }

    /// The rows of a tensor of shape `[count, N]`.
    pub(crate) fn rows<const N: usize>(
        &mut self,
        name: &str,
        count: usize,
    ) -> Result<Vec<[f32; N]>, ModelError> {
        let values = self.take(name, &[count, N])?;
        let (rows, _) = values.as_chunks::<N>();
        Ok(rows.to_vec())
    }

    /// The columns of a tensor of shape `[ROWS, COLUMNS]`.
    pub(crate) fn columns<const ROWS: usize, const COLUMNS: usize>(
        &mut self,
        name: &str,
    ) -> Result<[[f32; ROWS]; COLUMNS], ModelError> {
        let values = self.take(name, &[ROWS, COLUMNS])?;
        Ok(std::array::from_fn(|column| {
            std::array::from_fn(|row| values[row * COLUMNS + column])
        }))
    }

    /// Refuses tensors that nothing has taken.
    pub(crate) fn finish(self) -> Result<(), ModelError> {
        match self.entries.into_keys().next() {
            Some(name) => Err(ModelError::ExtraTensor { name }),
            None => Ok(()),
        }
    }
}
