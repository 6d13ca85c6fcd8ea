//! The model with its planner.

use core::task::Poll;
use std::path::PathBuf;
use std::sync::Arc;

use nsrm::{AnyModel, info_json};
use nsrm_core::Planner;
use nsrm_core::model::OBJECT_EMBEDDING;
use nsrm_core::nn::{Precision, UnknownPrecision};
use nsrm_core::scene::ObservedObject;
use nsrm_core::vision::{self, ObservationTask, Stamp};
use numpy::{AllowTypeChange, PyArray1, PyArrayLike1, ndarray};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{self, Image, Numbers, detections, location, numbers, rows};
use crate::camera::Camera;
use crate::errors::{self, argument};
use crate::observed::{Observed, checked_scene, plan_all};
use crate::plan::{Plan, Program};
use crate::scene::Scene;
use crate::values::to_python;

/// A trained model: the one that is built in, or one from a file.
#[pyclass(frozen, module = "nsrm")]
pub(crate) struct Model {
    inner: Arc<AnyModel>,
}

impl Model {
    /// For what outlives a call.
    pub(crate) fn share(&self) -> Arc<AnyModel> {
        Arc::clone(&self.inner)
    }
}

fn precision_of(name: &str) -> PyResult<Precision> {
    let parsed: Result<Precision, UnknownPrecision> = name.parse();
    parsed.map_err(|error| argument("precision", format!("{error}, got {name:?}")))
}

#[pymethods]
impl Model {
    /// The model that is built in: the domain `tabletop`.
    #[staticmethod]
    #[pyo3(signature = (precision = "f32"))]
    fn pretrained(precision: &str) -> PyResult<Self> {
        let inner = AnyModel::pretrained(precision_of(precision)?);
        Ok(Self {
            inner: Arc::new(inner),
        })
    }

    /// A model file (safetensors), checked; its weights rounded to a precision.
    #[staticmethod]
    #[pyo3(signature = (path, precision = "f32"))]
    fn load(py: Python<'_>, path: PathBuf, precision: &str) -> PyResult<Self> {
        let precision = precision_of(precision)?;
        let loaded = py.detach(|| AnyModel::load_as(path, precision));
        let inner = Arc::new(loaded.map_err(errors::load)?);
        Ok(Self { inner })
    }

    /// Domain, dimensions, capacities, sizes, thresholds, training and metrics.
    fn info<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &info_json(&self.inner))
    }

    /// What a sentence says is to be done, whatever the scene.
    fn parse(&self, py: Python<'_>, sentence: &str) -> PyResult<Program> {
        let model = self.inner.model();
        let result = py.detach(|| Planner::new(&model).parse(sentence));
        match result {
            Ok(parsed) => {
                let (program, corrections) = (parsed.program(), parsed.corrections());
                Ok(Program::new(&model, program, corrections, sentence))
            }
            Err(refusal) => Err(errors::refused(py, &model, None, &refusal, sentence)),
        }
    }

    /// Refuses a scene in which what is seen disagrees with the camera's calibration.
    fn check(&self, py: Python<'_>, scene: &Scene) -> PyResult<()> {
        let model = self.inner.model();
        let checked = py.detach(|| Planner::new(&model).check(&scene.inner));
        checked.map_err(|refusal| errors::refused(py, &model, None, &refusal, ""))
    }

    /// A plan for a sentence in a scene, or for what is left of it from step `first` on, from 0.
    #[pyo3(signature = (scene, sentence, first = 0))]
    fn plan(&self, py: Python<'_>, scene: &Scene, sentence: &str, first: usize) -> PyResult<Plan> {
        let model = self.inner.model();
        let planner = Planner::new(&model);
        let result = py.detach(|| {
            if first == 0 {
                return planner.plan(&scene.inner, sentence);
            }
            let parsed = planner.parse(sentence)?;
            let mut task = planner.begin_grounding(&*scene.inner, &parsed, first);
            loop {
                if let Poll::Ready(plan) = task.poll() {
                    return plan.cloned();
                }
            }
        });
        match result {
            Ok(plan) => Plan::new(py, &model, &plan, sentence),
            Err(refusal) => {
                let scene = Some(&*scene.inner);
                Err(errors::refused(py, &model, scene, &refusal, sentence))
            }
        }
    }

    /// A scene from an image and the boxes that a detector found in it.
    #[allow(clippy::too_many_arguments, reason = "keywords in Python")]
    fn observe(
        &self,
        py: Python<'_>,
        image: &Bound<'_, PyAny>,
        ids: Vec<u32>,
        boxes: Numbers<'_, ndarray::Ix2>,
        depths: PyArrayLike1<'_, f32, AllowTypeChange>,
        camera: &Camera,
    ) -> PyResult<Scene> {
        let image = Image::new(image)?;
        let pixels = image.pixels()?;
        let detections = detections(ids, &boxes, &depths)?;
        let model = self.inner.model();
        let scene = py.detach(|| {
            ObservationTask::new(&model, pixels, camera.inner, &detections, Stamp::default())
                .and_then(ObservationTask::finish)
                .map(Box::new)
        });
        let inner = scene.map_err(errors::scene)?;
        Ok(Scene { inner })
    }

    /// A scene from embeddings that this model's encoder made before.
    #[allow(clippy::too_many_arguments, reason = "keywords in Python")]
    fn scene_from_embeddings(
        &self,
        ids: Vec<u32>,
        boxes: Numbers<'_, ndarray::Ix2>,
        depths: PyArrayLike1<'_, f32, AllowTypeChange>,
        embeddings: Numbers<'_, ndarray::Ix2>,
        camera: &Camera,
    ) -> PyResult<Scene> {
        let model = self.inner.model();
        let embeddings = rows::<OBJECT_EMBEDDING>("embeddings", &embeddings, ids.len())?;
        let detections = detections(ids, &boxes, &depths)?;
        let objects = detections.iter().zip(embeddings);
        let objects = objects.map(|(detection, embedding)| ObservedObject {
            id: detection.id,
            location: detection.location,
            embedding,
        });
        let inner = checked_scene(&model, camera.inner, objects).map_err(errors::scene)?;
        Ok(Scene { inner })
    }

    /// A plan or a refusal for each sentence in the observation beside it; on all processors.
    fn plan_all<'py>(
        &self,
        py: Python<'py>,
        observed: Vec<PyRef<'py, Observed>>,
        sentences: Vec<String>,
    ) -> PyResult<Vec<Bound<'py, PyAny>>> {
        if observed.len() != sentences.len() {
            let (scenes, got) = (observed.len(), sentences.len());
            let problem = format!("expected one for each of {scenes} observations, got {got}");
            return Err(argument("sentences", problem));
        }
        let model = self.inner.model();
        let seen = observed.iter().map(|one| &**one);
        let jobs: Vec<(&Observed, String)> = seen.zip(sentences).collect();
        let outcomes = py.detach(|| plan_all(&model, &jobs));
        let outcomes = outcomes.map_err(|(index, error)| {
            errors::SceneError::new_err(format!("observed[{index}]: {error}"))
        })?;
        let results = outcomes.iter().zip(&jobs);
        results
            .map(|(outcome, (_, sentence))| match outcome {
                Ok(plan) => Ok(Py::new(py, Plan::new(py, &model, plan, sentence)?)?.into_any()),
                Err(refusal) => {
                    let error = errors::refused(py, &model, None, refusal, sentence);
                    Ok(error.into_value(py).into_any())
                }
            })
            .map(|result: PyResult<Py<PyAny>>| result.map(|value| value.into_bound(py)))
            .collect()
    }

    /// The embedding of a crop: float32 [64].
    fn encode_crop<'py>(
        &self,
        py: Python<'py>,
        crop: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray1<f32>>> {
        let crop = arrays::crop(crop)?;
        let model = self.inner.model();
        let embedding = py.detach(|| vision::encode(&model, &crop));
        Ok(PyArray1::from_slice(py, &embedding))
    }

    /// The cosine of an embedding with every concept, by its name.
    fn similarities<'py>(
        &self,
        py: Python<'py>,
        embedding: PyArrayLike1<'py, f32, AllowTypeChange>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let embedding = numbers("embedding", &embedding)?;
        let model = self.inner.model();
        let similarities = PyDict::new(py);
        for (index, concept) in (0..=u8::MAX).zip(model.concepts) {
            let similarity = vision::similarity(&model, &embedding, index);
            similarities.set_item(concept.name, similarity)?;
        }
        Ok(similarities)
    }

    /// Where the moved object will be seen after an action: float32 [5].
    ///
    /// All locations are in the image of the training's camera (`info()["training_camera"]`).
    fn simulate<'py>(
        &self,
        py: Python<'py>,
        action: &str,
        object_location: PyArrayLike1<'py, f32, AllowTypeChange>,
        reference_location: PyArrayLike1<'py, f32, AllowTypeChange>,
    ) -> PyResult<Bound<'py, PyArray1<f32>>> {
        let model = self.inner.model();
        let object = location("object_location", &object_location)?;
        let reference = location("reference_location", &reference_location)?;
        let known = model.actions.iter().find(|known| known.name == action);
        let known = known.ok_or_else(|| {
            let names: Vec<&str> = model.actions.iter().map(|known| known.name).collect();
            let problem = format!("expected one of {}, got {action:?}", names.join(", "));
            argument("action", problem)
        })?;
        let result = nsrm_core::action::simulate(model.simulator, known, &object, &reference);
        Ok(PyArray1::from_slice(py, &result))
    }

    /// The centre of the object seen at a location, world frame, metres: float32 [3].
    #[pyo3(signature = (location, camera))]
    fn locate<'py>(
        &self,
        py: Python<'py>,
        location: PyArrayLike1<'py, f32, AllowTypeChange>,
        camera: &Camera,
    ) -> PyResult<Bound<'py, PyArray1<f32>>> {
        let seen = arrays::location("location", &location)?;
        let centre = camera.inner.locate(self.inner.model().camera, &seen);
        Ok(PyArray1::from_slice(py, centre.coords.as_slice()))
    }

    fn __repr__(&self) -> String {
        let model = self.inner.model();
        format!(
            "Model(domain={:?}, tag={:016x})",
            model.header.domain,
            model.tag()
        )
    }
}
