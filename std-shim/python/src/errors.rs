//! Exceptions, each with the core's message.

use nsrm::LoadError;
use nsrm::dialogue;
use nsrm::json::refusal_details;
use nsrm_core::{Refusal, Scene};
use pyo3::create_exception;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use serde_json::Value;

use crate::dialogue::Question;
use crate::values::to_python;

create_exception!(
    nsrm,
    NsrmError,
    PyValueError,
    "The base of this module's exceptions; its subclasses say what was wrong."
);
create_exception!(
    nsrm,
    Refused,
    NsrmError,
    "The sentence was refused; `kind` and `details` say why, `suggestion` and `question` what to say \
     instead."
);
create_exception!(nsrm, ModelError, NsrmError, "A model file cannot be used.");
create_exception!(
    nsrm,
    SceneError,
    NsrmError,
    "The observed scene is invalid."
);

/// A wrong argument: its name, what was expected and what was given.
pub(crate) fn argument(name: &str, problem: impl std::fmt::Display) -> PyErr {
    NsrmError::new_err(format!("{name}: {problem}"))
}

/// An observation that core refuses.
pub(crate) fn scene(error: impl std::error::Error) -> PyErr {
    SceneError::new_err(error.to_string())
}

/// A model file that cannot be used.
pub(crate) fn load(error: LoadError) -> PyErr {
    ModelError::new_err(error.to_string())
}

/// A refusal with `kind`, `details`, `suggestion`, `question` and the message for a person.
///
/// * `scene`: where the sentence was planned, if it was
pub(crate) fn refused(
    py: Python<'_>,
    model: &nsrm_core::Model<'_>,
    scene: Option<&Scene>,
    refusal: &Refusal,
    sentence: &str,
) -> PyErr {
    let error = Refused::new_err(refusal.in_context(model, sentence).to_string());
    let details = Value::Object(refusal_details(model, refusal, sentence));
    let question = |py| {
        let asked = dialogue::Question::after(model, scene, refusal, sentence);
        let asked = asked.map(|question| Py::new(py, Question::new(question)));
        asked.transpose()
    };
    let set = |error: &PyErr| -> PyResult<()> {
        let value = error.value(py);
        value.setattr("kind", refusal.kind())?;
        value.setattr("suggestion", refusal.suggestion(model, sentence))?;
        value.setattr("question", question(py)?)?;
        value.setattr("details", to_python(py, &details)?)
    };
    match set(&error) {
        Ok(()) => error,
        Err(failure) => failure,
    }
}
