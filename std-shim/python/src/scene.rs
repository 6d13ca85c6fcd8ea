//! What is observed.

use nsrm_core::vision::Crop;
use numpy::{AllowTypeChange, PyArray1, PyArray2, PyArray3, PyArrayLike1, ndarray};
use pyo3::prelude::*;

use crate::arrays::{Image, numbers};
use crate::errors::argument;

/// A checked scene; made by `Model.observe` or `Model.scene_from_embeddings`.
#[pyclass(frozen, module = "nsrm")]
pub(crate) struct Scene {
    pub(crate) inner: Box<nsrm_core::Scene>,
}

#[pymethods]
impl Scene {
    /// Ids of the objects: uint32 [N].
    #[getter]
    fn ids<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        let ids: Vec<u32> = self
            .inner
            .objects()
            .iter()
            .map(|object| object.id)
            .collect();
        PyArray1::from_vec(py, ids)
    }

    /// Box corners and mean depths: float32 [N, 5].
    #[getter]
    fn locations<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f32>> {
        let rows = self.inner.objects().iter().map(|object| object.location);
        PyArray2::from_owned_array(py, ndarray::arr2(&rows.collect::<Vec<_>>()))
    }

    /// Embeddings of the crops: float32 [N, 64].
    #[getter]
    fn embeddings<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f32>> {
        let rows = self.inner.objects().iter().map(|object| object.embedding);
        PyArray2::from_owned_array(py, ndarray::arr2(&rows.collect::<Vec<_>>()))
    }

    fn __len__(&self) -> usize {
        self.inner.objects().len()
    }

    fn __repr__(&self) -> String {
        let ids: Vec<u32> = self
            .inner
            .objects()
            .iter()
            .map(|object| object.id)
            .collect();
        format!("Scene(ids={ids:?})")
    }
}

/// What the encoder sees of a box: float32 [3, 32, 32], 0 to 1.
#[pyfunction]
pub(crate) fn crop<'py>(
    py: Python<'py>,
    image: &Bound<'py, PyAny>,
    r#box: PyArrayLike1<'py, f32, AllowTypeChange>,
) -> PyResult<Bound<'py, PyArray3<f32>>> {
    let image = Image::new(image)?;
    let bounds = numbers("box", &r#box)?;
    let crop = Crop::from_rgb(&image.pixels()?, &bounds).map_err(|fault| argument("box", fault))?;
    Ok(PyArray3::from_owned_array(
        py,
        ndarray::arr3(&crop.channels),
    ))
}
