//! numpy arrays in: element type and shape checked, with what was expected and what
//! was given in the message. Any memory layout will do; images and crops that are not
//! C-contiguous are copied.

use nsrm_core::model::{CROP, LOCATION};
use nsrm_core::vision::{Crop, Detection, RgbImage};
use nsrm_core::{MAX_OBJECTS, SceneError};
use numpy::{
    AllowTypeChange, PyArray3, PyArrayLike, PyArrayLike1, PyArrayMethods, PyReadonlyArray3,
    PyUntypedArray, PyUntypedArrayMethods, ndarray,
};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

use crate::errors::argument;

/// Numbers that numpy can make an array of `f32` of.
pub(crate) type Numbers<'py, D> = PyArrayLike<'py, f32, D, AllowTypeChange>;

/// Exactly `N` numbers.
pub(crate) fn numbers<const N: usize>(
    name: &str,
    value: &PyArrayLike1<'_, f32, AllowTypeChange>,
) -> PyResult<[f32; N]> {
    let values: Vec<f32> = value.as_array().iter().copied().collect();
    let count = values.len();
    values
        .try_into()
        .map_err(|_| argument(name, format!("expected {N} numbers, got {count}")))
}

/// As many rows of `N` numbers as there are ids.
pub(crate) fn rows<const N: usize>(
    name: &str,
    value: &Numbers<'_, ndarray::Ix2>,
    count: usize,
) -> PyResult<Vec<[f32; N]>> {
    let array = value.as_array();
    if array.dim() != (count, N) {
        let got = array.shape();
        let problem = format!("expected shape [{count}, {N}] for {count} ids, got {got:?}");
        return Err(argument(name, problem));
    }
    let rows = array.outer_iter();
    Ok(rows
        .map(|row| std::array::from_fn(|index| row[index]))
        .collect())
}

/// Boxes and depths put together, one for each id.
pub(crate) fn detections(
    ids: Vec<u32>,
    boxes: &Numbers<'_, ndarray::Ix2>,
    depths: &PyArrayLike1<'_, f32, AllowTypeChange>,
) -> PyResult<Vec<Detection>> {
    let count = ids.len();
    if count > MAX_OBJECTS {
        let count = count.try_into().unwrap_or(u32::MAX);
        return Err(crate::errors::scene(SceneError::TooManyObjects { count }));
    }
    let boxes = rows::<4>("boxes", boxes, count)?;
    let depths: Vec<f32> = depths.as_array().iter().copied().collect();
    if depths.len() != count {
        let got = depths.len();
        let problem = format!("expected {count} numbers for {count} ids, got {got}");
        return Err(argument("depths", problem));
    }
    let detections = ids.into_iter().zip(boxes).zip(depths);
    Ok(detections
        .map(|((id, [x1, y1, x2, y2]), depth)| Detection::whole(id, [x1, y1, x2, y2, depth]))
        .collect())
}

/// An image: `uint8 [height, width, 3]`.
pub(crate) struct Image<'py> {
    array: PyReadonlyArray3<'py, u8>,
}

impl<'py> Image<'py> {
    pub(crate) fn new(value: &Bound<'py, PyAny>) -> PyResult<Self> {
        let array = typed::<u8>("image", "uint8 [height, width, 3]", value)?;
        if array.shape().get(2) != Some(&3) {
            let got = array.shape();
            let problem = format!("expected shape [height, width, 3], got {got:?}");
            return Err(argument("image", problem));
        }
        Ok(Self { array })
    }

    /// The pixels as core sees them.
    pub(crate) fn pixels(&self) -> PyResult<RgbImage<'_>> {
        let slice = in_order("image", &self.array)?;
        let (height, width) = (self.array.shape()[0], self.array.shape()[1]);
        let side = |pixels: usize| u32::try_from(pixels).unwrap_or(u32::MAX);
        RgbImage::new(slice, side(width), side(height), width.saturating_mul(3))
            .map_err(crate::errors::scene)
    }
}

/// A crop: `float32 [3, 32, 32]`.
pub(crate) fn crop(value: &Bound<'_, PyAny>) -> PyResult<Crop> {
    let array = typed::<f32>("crop", "float32 [3, 32, 32]", value)?;
    if array.shape() != [3, CROP, CROP] {
        let problem = format!("expected shape [3, 32, 32], got {:?}", array.shape());
        return Err(argument("crop", problem));
    }
    let values = in_order("crop", &array)?;
    let mut crop = Crop::BLACK;
    let places = crop.channels.as_flattened_mut().as_flattened_mut();
    places.copy_from_slice(values);
    if values.iter().all(|value| value.is_finite()) {
        return Ok(crop);
    }
    Err(argument("crop", "expected finite values"))
}

/// A location: x1, y1, x2, y2, depth; finite.
pub(crate) fn location(
    name: &str,
    value: &PyArrayLike1<'_, f32, AllowTypeChange>,
) -> PyResult<[f32; LOCATION]> {
    let location = numbers(name, value)?;
    if location.iter().all(|number: &f32| number.is_finite()) {
        return Ok(location);
    }
    Err(argument(name, "expected finite numbers"))
}

/// The array, C-contiguous.
fn typed<'py, T: numpy::Element + Clone>(
    name: &str,
    expected: &str,
    value: &Bound<'py, PyAny>,
) -> PyResult<PyReadonlyArray3<'py, T>> {
    let array: PyReadonlyArray3<'py, T> = value.extract().map_err(|_| {
        let got = match value.cast::<PyUntypedArray>() {
            Ok(array) => format!("{} {:?}", array.dtype(), array.shape()),
            Err(_) => value.get_type().to_string(),
        };
        PyTypeError::new_err(format!(
            "{name}: expected a numpy array {expected}, got {got}"
        ))
    })?;
    if array.is_c_contiguous() {
        return Ok(array);
    }
    let copy = array.as_array().as_standard_layout().into_owned();
    Ok(PyArray3::from_owned_array(value.py(), copy).readonly())
}

fn in_order<'a, T: numpy::Element>(
    name: &str,
    array: &'a PyReadonlyArray3<'_, T>,
) -> PyResult<&'a [T]> {
    array.as_slice().map_err(|error| argument(name, error))
}
