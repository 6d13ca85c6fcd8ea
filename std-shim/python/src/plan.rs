//! Programs and plans, as plain values.

use std::num::NonZeroU16;

use nsrm::json::{action_name, description};
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::values::Described;

/// One step of a program: names of the domain.
#[pyclass(frozen, eq, get_all, module = "nsrm")]
#[derive(Clone, PartialEq)]
pub(crate) struct Step {
    action: String,
    object: Described,
    reference: Described,
    distance_mm: Option<u16>,
}

impl Step {
    fn new(model: &nsrm_core::Model<'_>, step: &nsrm_core::dsl::Step) -> Self {
        Self {
            action: action_name(model, step.action).to_owned(),
            object: Described(description(model, &step.object)),
            reference: Described(description(model, &step.reference)),
            distance_mm: step.distance_mm.map(NonZeroU16::get),
        }
    }
}

#[pymethods]
impl Step {
    fn __repr__(&self) -> String {
        let Self {
            action,
            object,
            reference,
            distance_mm,
        } = self;
        let distance = distance_mm.map_or(String::new(), |mm| format!(", distance_mm={mm}"));
        format!("Step(action={action:?}, object={object}, reference={reference}{distance})")
    }
}

/// A misspelt word, and what it was read as.
#[pyclass(frozen, eq, get_all, module = "nsrm")]
#[derive(Clone, PartialEq)]
pub(crate) struct Correction {
    word: String,
    read_as: String,
    explanation: String,
}

#[pymethods]
impl Correction {
    fn __str__(&self) -> &str {
        &self.explanation
    }

    fn __repr__(&self) -> String {
        let Self { word, read_as, .. } = self;
        format!("Correction(word={word:?}, read_as={read_as:?})")
    }
}

/// What a sentence says is to be done.
#[pyclass(frozen, eq, get_all, module = "nsrm")]
#[derive(Clone, PartialEq)]
pub(crate) struct Program {
    steps: Vec<Step>,
    notation: String,
    corrections: Vec<Correction>,
}

impl Program {
    pub(crate) fn new(
        model: &nsrm_core::Model<'_>,
        program: &nsrm_core::Program,
        corrections: &[nsrm_core::language::Correction],
        sentence: &str,
    ) -> Self {
        let correction = |each: &nsrm_core::language::Correction| Correction {
            word: each.span().of(sentence).unwrap_or_default().to_owned(),
            read_as: each.read_as(model).to_owned(),
            explanation: each.explain(model, sentence).to_string(),
        };
        Self {
            corrections: corrections.iter().map(correction).collect(),
            steps: program
                .steps()
                .iter()
                .map(|s| Step::new(model, s))
                .collect(),
            notation: program.notation(model).to_string(),
        }
    }
}

#[pymethods]
impl Program {
    fn __repr__(&self) -> String {
        format!("Program({:?})", self.notation)
    }

    fn __str__(&self) -> &str {
        &self.notation
    }
}

/// A step of a plan: what it says, the objects meant, and the sub-goal.
#[pyclass(frozen, get_all, module = "nsrm")]
pub(crate) struct PlannedStep {
    action: String,
    object: Described,
    reference: Described,
    distance_mm: Option<u16>,
    object_id: u32,
    reference_id: u32,
    object_anchor_ids: Vec<u32>,
    reference_anchor_ids: Vec<u32>,
    object_score: f32,
    reference_score: f32,
    confidence: f32,
    position: (f32, f32, f32),
    orientation: (f32, f32, f32, f32),
    location: Py<PyArray1<f32>>,
    explanation: String,
}

#[pymethods]
impl PlannedStep {
    fn __repr__(&self) -> String {
        format!("PlannedStep({:?})", self.explanation)
    }
}

/// What is to be done in a scene.
#[pyclass(frozen, get_all, module = "nsrm")]
pub(crate) struct Plan {
    program: Py<Program>,
    steps: Vec<Py<PlannedStep>>,
    confidence: f32,
}

impl Plan {
    pub(crate) fn new(
        py: Python<'_>,
        model: &nsrm_core::Model<'_>,
        plan: &nsrm_core::Plan,
        sentence: &str,
    ) -> PyResult<Self> {
        let program = Program::new(model, plan.program(), plan.corrections(), sentence);
        let steps = plan.numbered().map(|(number, understood, planned)| {
            let Step {
                action,
                object,
                reference,
                distance_mm,
            } = Step::new(model, understood);
            let pose = &planned.sub_goal.pose;
            let position: [f32; 3] = pose.translation.vector.into();
            let orientation: [f32; 4] = pose.rotation.coords.into();
            let step = PlannedStep {
                action,
                object,
                reference,
                distance_mm,
                object_id: planned.object.object,
                reference_id: planned.reference.object,
                object_anchor_ids: planned.object.anchors().to_vec(),
                reference_anchor_ids: planned.reference.anchors().to_vec(),
                object_score: planned.object.score,
                reference_score: planned.reference.score,
                confidence: planned.confidence.joint(),
                position: position.into(),
                orientation: orientation.into(),
                location: PyArray1::from_slice(py, &planned.location).unbind(),
                explanation: plan.explain_step(model, number).to_string(),
            };
            Py::new(py, step)
        });
        Ok(Self {
            steps: steps.collect::<PyResult<_>>()?,
            confidence: plan.confidence(),
            program: Py::new(py, program)?,
        })
    }
}

#[pymethods]
impl Plan {
    fn __repr__(&self) -> String {
        format!("Plan({:?})", self.program.get().notation)
    }
}
