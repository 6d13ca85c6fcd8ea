//! The least confidence at which few accepted plans are wrong.

use nsrm::risk::{self, Judged, RiskLimit};
use numpy::{PyReadonlyArray1, PyUntypedArrayMethods as _};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::errors::{ModelError, argument};

/// What is accepted at a confidence.
#[pyclass(frozen, eq, get_all, module = "nsrm")]
#[derive(Clone, PartialEq)]
pub(crate) struct Accepted {
    threshold: f32,
    count: usize,
    wrong: usize,
    bound: f64,
}

impl From<risk::Accepted> for Accepted {
    fn from(accepted: risk::Accepted) -> Self {
        Self {
            threshold: accepted.threshold,
            count: accepted.count,
            wrong: accepted.wrong,
            bound: accepted.bound,
        }
    }
}

#[pymethods]
impl Accepted {
    fn __repr__(&self) -> String {
        let Self {
            threshold,
            count,
            wrong,
            bound,
        } = self;
        format!("Accepted(threshold={threshold}, count={count}, wrong={wrong}, bound={bound:.6})")
    }
}

/// Judged plans from two arrays; NaN if the sentence was refused.
fn judged(
    confidences: &PyReadonlyArray1<'_, f32>,
    right: &PyReadonlyArray1<'_, bool>,
) -> PyResult<Vec<Judged>> {
    if confidences.len() != right.len() {
        let (got, expected) = (right.len(), confidences.len());
        let problem = format!("expected {expected} values, as many as confidences, got {got}");
        return Err(argument("right", problem));
    }
    let pairs = confidences.as_array().into_iter().copied();
    let pairs = pairs.zip(right.as_array().into_iter().copied());
    Ok(pairs
        .map(|(confidence, right)| Judged {
            confidence: (!confidence.is_nan()).then_some(confidence),
            right,
        })
        .collect())
}

#[pyfunction]
#[pyo3(signature = (confidences, right, wrong = None, level = None))]
pub(crate) fn least_confidence(
    confidences: PyReadonlyArray1<'_, f32>,
    right: PyReadonlyArray1<'_, bool>,
    wrong: Option<f64>,
    level: Option<f64>,
) -> PyResult<Accepted> {
    let usual = RiskLimit::default();
    let limit = RiskLimit {
        wrong: wrong.unwrap_or(usual.wrong),
        level: level.unwrap_or(usual.level),
    };
    let found = risk::least_confidence(&judged(&confidences, &right)?, limit);
    found
        .map(Accepted::from)
        .map_err(|error| argument("risk", error))
}

#[pyfunction]
#[pyo3(signature = (confidences, right, level = None))]
pub(crate) fn accepted(
    confidences: PyReadonlyArray1<'_, f32>,
    right: PyReadonlyArray1<'_, bool>,
    level: Option<f64>,
) -> PyResult<Vec<Accepted>> {
    let level = level.unwrap_or(RiskLimit::default().level);
    let rows = risk::accepted(&judged(&confidences, &right)?, level);
    let rows = rows.map_err(|error| argument("level", error))?;
    Ok(rows.map(Accepted::from).into())
}

#[pyfunction]
pub(crate) fn with_confidence<'py>(
    py: Python<'py>,
    model: &[u8],
    confidence: f32,
) -> PyResult<Bound<'py, PyBytes>> {
    match nsrm::with_confidence(model, confidence) {
        Ok(written) => Ok(PyBytes::new(py, &written)),
        Err(error) => Err(ModelError::new_err(error.to_string())),
    }
}
