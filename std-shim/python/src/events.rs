//! What the closed loop has come to, as plain values.

use nsrm::json::action_name;
use nsrm_core::Model;
use nsrm_ipc::executive;
use nsrm_ipc::message::Outcome;
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::errors;
use crate::plan::Plan;

/// Nothing to do until something arrives or time passes.
#[pyclass(frozen, module = "nsrm")]
pub(crate) struct Waiting;

/// Some work was done; more is left.
#[pyclass(frozen, module = "nsrm")]
pub(crate) struct Working;

/// The sentence was parsed, and its steps grounded from the next one on.
#[pyclass(frozen, get_all, module = "nsrm")]
pub(crate) struct Planned {
    plan: Py<Plan>,
    first: usize,
}

/// A command for the controller.
#[pyclass(frozen, get_all, module = "nsrm")]
pub(crate) struct Command {
    plan: u64,
    command: u32,
    until_ns: u64,
    step: u8,
    steps: u8,
    action: String,
    object_id: u32,
    reference_id: u32,
    confidence: f32,
    position: (f32, f32, f32),
    orientation: (f32, f32, f32, f32),
    location: Py<PyArray1<f32>>,
    keep: Vec<u32>,
}

/// Send the controller a stop of this command.
#[pyclass(frozen, eq, get_all, module = "nsrm")]
#[derive(PartialEq)]
pub(crate) struct Stop {
    plan: u64,
    command: u32,
}

/// Other objects are moved aside before a step's object is moved.
#[pyclass(frozen, eq, get_all, module = "nsrm")]
#[derive(PartialEq)]
pub(crate) struct Clearing {
    step: u8,
    object_id: u32,
    first: (u32, u32),
}

/// A step succeeded.
#[pyclass(frozen, eq, get_all, module = "nsrm")]
#[derive(PartialEq)]
pub(crate) struct Reached {
    step: u8,
    off_m: f32,
}

/// A step will be retried.
#[pyclass(frozen, get_all, module = "nsrm")]
pub(crate) struct Again {
    step: u8,
    why: Py<Failure>,
}

/// The sentence was executed, or why not.
#[pyclass(frozen, get_all, module = "nsrm")]
pub(crate) struct Ended {
    why: Option<Py<Failure>>,
}

/// Why a sentence was not executed, or a step is retried.
#[pyclass(frozen, get_all, module = "nsrm")]
pub(crate) struct Failure {
    kind: String,
    message: String,
    step: Option<u8>,
    object_id: Option<u32>,
    off_m: Option<f32>,
    outcome: Option<u32>,
    objects: (u32, u32),
    refusal: Option<Py<PyAny>>,
}

macro_rules! shown {
    ($($name:ident: $($field:ident),*;)*) => {$(
        #[pymethods]
        impl $name {
            fn __repr__(&self) -> String {
                #[allow(unused_mut, reason = "some have no fields")]
                let mut fields: Vec<String> = Vec::new();
                $(fields.push(format!(concat!(stringify!($field), "={:?}"), self.$field));)*
                format!("{}({})", stringify!($name), fields.join(", "))
            }
        }
    )*};
}

shown! {
    Waiting: ;
    Working: ;
    Command: plan, command, step, object_id, reference_id, position;
    Stop: plan, command;
    Clearing: step, object_id, first;
    Reached: step, off_m;
}

#[pymethods]
impl Planned {
    fn __repr__(&self) -> String {
        format!("Planned(first={})", self.first)
    }
}

#[pymethods]
impl Again {
    fn __repr__(&self) -> String {
        format!("Again(step={}, why={:?})", self.step, self.why.get().kind)
    }
}

#[pymethods]
impl Ended {
    fn __repr__(&self) -> String {
        let kind = self.why.as_ref().map(|why| &why.get().kind);
        format!("Ended(why={kind:?})")
    }
}

#[pymethods]
impl Failure {
    fn __str__(&self) -> &str {
        &self.message
    }

    fn __repr__(&self) -> String {
        format!("Failure({:?}, {:?})", self.kind, self.message)
    }
}

impl Failure {
    fn new(
        py: Python<'_>,
        model: &Model<'_>,
        sentence: &str,
        why: &executive::Failure,
    ) -> PyResult<Py<Self>> {
        use executive::Failure as Why;
        let refusal = match why {
            Why::Refused(refusal) => Some(errors::refused(py, model, None, refusal, sentence)),
            _ => None,
        };
        let refusal = refusal.map(|error| error.into_value(py).into_any());
        let message = match why {
            Why::Refused(refusal) => refusal.in_context(model, sentence).to_string(),
            _ => why.to_string(),
        };
        let step = match *why {
            Why::NotAccepted { step }
            | Why::Unanswered { step }
            | Why::NoOutcome { step }
            | Why::ControllerLost { step }
            | Why::Unsuccessful { step, .. }
            | Why::NotThere { step, .. }
            | Why::NotSeen { step, .. }
            | Why::OtherObject { step, .. } => Some(step),
            _ => None,
        };
        let (object_id, off_m) = match *why {
            Why::NotThere { object, off_m, .. } => (Some(object), Some(off_m)),
            Why::NotSeen { object, .. } => (Some(object), None),
            Why::OtherObject { found, .. } => (Some(found), None),
            _ => (None, None),
        };
        let (outcome, objects) = match *why {
            Why::Unsuccessful {
                outcome, objects, ..
            } => (Some(outcome), objects),
            _ => (None, [0; 2]),
        };
        let failure = Self {
            kind: why.kind().to_owned(),
            message,
            step,
            object_id,
            off_m,
            outcome: outcome.map(|outcome: Outcome| outcome as u32),
            objects: objects.into(),
            refusal,
        };
        Py::new(py, failure)
    }
}

/// An event as a Python object.
pub(crate) fn to_python<'py>(
    py: Python<'py>,
    model: &Model<'_>,
    sentence: &str,
    event: &executive::Event,
) -> PyResult<Bound<'py, PyAny>> {
    use executive::Event;
    let failure = |why| Failure::new(py, model, sentence, why);
    Ok(match event {
        Event::Waiting => Bound::new(py, Waiting)?.into_any(),
        Event::Working => Bound::new(py, Working)?.into_any(),
        Event::Planned(plan) => {
            let first = plan.first();
            let plan = Py::new(py, Plan::new(py, model, plan, sentence)?)?;
            Bound::new(py, Planned { plan, first })?.into_any()
        }
        Event::Command(command) => Bound::new(py, self::command(py, model, command))?.into_any(),
        &Event::Stop(id) => {
            let (plan, command) = (id.plan, id.command);
            Bound::new(py, Stop { plan, command })?.into_any()
        }
        &Event::Clearing {
            step,
            object,
            first,
        } => {
            let (object_id, first) = (object, first.into());
            let clearing = Clearing {
                step,
                object_id,
                first,
            };
            Bound::new(py, clearing)?.into_any()
        }
        &Event::Reached { step, off_m } => Bound::new(py, Reached { step, off_m })?.into_any(),
        Event::Again { step, why } => {
            let (step, why) = (*step, failure(why)?);
            Bound::new(py, Again { step, why })?.into_any()
        }
        Event::Ended(result) => {
            let why = result.as_ref().err().map(failure).transpose()?;
            Bound::new(py, Ended { why })?.into_any()
        }
    })
}

fn command(py: Python<'_>, model: &Model<'_>, command: &executive::Command) -> Command {
    let planned = &command.planned;
    let pose = &planned.sub_goal.pose;
    let position: [f32; 3] = pose.translation.vector.into();
    let orientation: [f32; 4] = pose.rotation.coords.into();
    Command {
        plan: command.id.plan,
        command: command.id.command,
        until_ns: command.until_ns,
        step: command.step,
        steps: command.steps,
        action: action_name(model, planned.action).to_owned(),
        object_id: planned.object.object,
        reference_id: planned.reference.object,
        confidence: planned.confidence.joint(),
        position: position.into(),
        orientation: orientation.into(),
        location: PyArray1::from_slice(py, &planned.location).unbind(),
        keep: command.keep.into_iter().filter(|id| *id != 0).collect(),
    }
}
