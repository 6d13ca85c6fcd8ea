//! The closed loop between scenes and a controller.

use std::sync::Arc;

use nsrm::AnyModel;
use nsrm_core::refusal::LengthUnit;
use nsrm_core::{MAX_SENTENCE_BYTES, Refusal};
use nsrm_ipc::executive::{self, Mode, Sentence};
use nsrm_ipc::message::{Feedback, SceneMessage};
use pyo3::prelude::*;
use self_cell::self_cell;

use crate::errors::{self, NsrmError, argument};
use crate::events::to_python;
use crate::limits::Limits;
use crate::model::Model;
use crate::scene::Scene;

type CoreModel<'a> = nsrm_core::Model<'a>;
type Loop<'a> = executive::Executive<'a>;

self_cell!(
    /// A model as core reads it, with the data that it borrows.
    struct Read {
        owner: Arc<AnyModel>,
        #[covariant]
        dependent: CoreModel,
    }
);

self_cell!(
    /// The executive with its model.
    struct Cell {
        owner: Read,
        #[not_covariant]
        dependent: Loop,
    }
);

/// Executes one sentence at a time: returns what to do, and takes the results.
#[pyclass(module = "nsrm")]
pub(crate) struct Executive {
    cell: Cell,
    /// The current sentence, for messages.
    sentence: String,
}

#[pymethods]
impl Executive {
    #[new]
    #[pyo3(signature = (model, limits = None, first_plan = 1))]
    fn new(model: &Model, limits: Option<&Limits>, first_plan: u64) -> Self {
        let limits = limits.map_or_else(executive::Limits::default, Limits::inner);
        let read = Read::new(model.share(), |any| any.model());
        Self {
            cell: Cell::new(read, |read| {
                executive::Executive::new(read.borrow_dependent(), limits, first_plan)
            }),
            sentence: String::new(),
        }
    }

    /// Number of the plan that is being executed.
    #[getter]
    fn plan(&self) -> Option<u64> {
        self.cell.with_dependent(|_, executive| executive.plan())
    }

    /// Starts a sentence; returns the number of its plan.
    #[pyo3(signature = (sentence, mode = "closed_loop"))]
    fn ask(&mut self, py: Python<'_>, sentence: String, mode: &str) -> PyResult<u64> {
        let mode = match mode {
            "closed_loop" => Mode::ClosedLoop,
            "open_loop" => Mode::OpenLoop,
            "plan_only" => Mode::PlanOnly,
            _ => {
                let problem = format!("expected closed_loop, open_loop or plan_only, got {mode:?}");
                return Err(argument("mode", problem));
            }
        };
        let Ok(short) = Sentence::try_from(sentence.as_str()) else {
            let too_long = Refusal::SentenceTooLong {
                limit: MAX_SENTENCE_BYTES as u16,
                unit: LengthUnit::Bytes,
            };
            let model = self.cell.borrow_owner().borrow_dependent();
            return Err(errors::refused(py, model, None, &too_long, &sentence));
        };
        let asked = self
            .cell
            .with_dependent_mut(|_, executive| executive.ask(short, mode));
        let plan = asked.map_err(|busy| NsrmError::new_err(busy.to_string()))?;
        self.sentence = sentence;
        Ok(plan)
    }

    /// Takes a scene that has arrived; returns why it is rejected, if it is.
    fn on_scene(&mut self, scene: &Scene, taken_ns: u64, now_ns: u64) -> Option<String> {
        let message = SceneMessage {
            timestamp_ns: taken_ns,
            ..SceneMessage::from(&*scene.inner)
        };
        let seen = self
            .cell
            .with_dependent_mut(|_, executive| executive.on_scene(&message, now_ns));
        seen.err().map(|fault| fault.to_string())
    }

    /// Takes the outcome of a command.
    #[pyo3(signature = (plan, command, outcome, now_ns, *, at_ns = None, objects = (0, 0)))]
    fn on_feedback(
        &mut self,
        plan: u64,
        command: u32,
        outcome: u32,
        now_ns: u64,
        at_ns: Option<u64>,
        objects: (u32, u32),
    ) -> PyResult<()> {
        let feedback = Feedback {
            plan,
            sequence: 0,
            timestamp_ns: at_ns.unwrap_or(now_ns),
            command,
            outcome,
            objects: objects.into(),
        };
        let heard = self
            .cell
            .with_dependent_mut(|_, executive| executive.on_feedback(&feedback, now_ns));
        heard.map_err(|error| NsrmError::new_err(error.to_string()))
    }

    /// Cancels the sentence.
    fn cancel(&mut self) {
        self.cell
            .with_dependent_mut(|_, executive| executive.cancel());
    }

    /// The controller died, hangs, or was replaced.
    fn on_controller_lost(&mut self) {
        self.cell
            .with_dependent_mut(|_, executive| executive.on_controller_lost());
    }

    /// The last command could not be delivered.
    fn on_command_undelivered(&mut self) {
        self.cell
            .with_dependent_mut(|_, executive| executive.on_command_undelivered());
    }

    /// Does one unit of work; returns its result.
    fn poll<'py>(&mut self, py: Python<'py>, now_ns: u64) -> PyResult<Bound<'py, PyAny>> {
        let sentence = &self.sentence;
        self.cell.with_dependent_mut(|read, executive| {
            let event = executive.poll(now_ns);
            to_python(py, read.borrow_dependent(), sentence, &event)
        })
    }

    fn __repr__(&self) -> String {
        format!("Executive(plan={:?})", self.plan())
    }
}
