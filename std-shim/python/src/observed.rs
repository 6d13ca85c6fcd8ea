//! Many observations at once, for evaluation: what is seen is kept apart from the model,
//! so that several models plan on the same.

use std::num::NonZero;
use std::thread;

use nsrm_core::scene::ObservedObject;
use nsrm_core::vision::{self, Crop, Detection};
use nsrm_core::{Model, Plan, Planner, RawScene, Refusal, Scene, SceneError};
use numpy::{AllowTypeChange, PyArrayLike1, ndarray};
use pyo3::prelude::*;

use crate::arrays::{Image, Numbers, detections};
use crate::camera::Camera;
use crate::errors::argument;

/// An object with its crop, and with that of the part that no nearer one covers.
struct Seen {
    detection: Detection,
    crop: Crop,
    uncovered: Option<Crop>,
}

/// Crops and locations of the objects in one image: what every model sees of it.
#[pyclass(frozen, module = "nsrm")]
pub(crate) struct Observed {
    objects: Vec<Seen>,
    camera: nsrm_core::Camera,
}

#[pymethods]
impl Observed {
    #[new]
    fn new(
        py: Python<'_>,
        image: &Bound<'_, PyAny>,
        ids: Vec<u32>,
        boxes: Numbers<'_, ndarray::Ix2>,
        depths: PyArrayLike1<'_, f32, AllowTypeChange>,
        camera: &Camera,
    ) -> PyResult<Self> {
        let image = Image::new(image)?;
        let pixels = image.pixels()?;
        let detections = detections(ids, &boxes, &depths)?;
        let objects = py.detach(|| {
            let objects = detections.iter().enumerate();
            objects
                .map(|(row, &detection)| {
                    let cut = |bounds: &[f32; 4]| {
                        Crop::from_rgb(&pixels, bounds).map_err(|fault| (row, fault))
                    };
                    let part = vision::uncovered(&detections, row);
                    Ok(Seen {
                        detection,
                        crop: cut(&detection.visible)?,
                        uncovered: part.as_ref().map(cut).transpose()?,
                    })
                })
                .collect::<Result<_, _>>()
        });
        Ok(Self {
            objects: objects
                .map_err(|(row, fault)| argument("boxes", format!("row {row}: {fault}")))?,
            camera: camera.inner,
        })
    }

    fn __len__(&self) -> usize {
        self.objects.len()
    }

    fn __repr__(&self) -> String {
        let ids: Vec<u32> = (self.objects.iter())
            .map(|seen| seen.detection.id)
            .collect();
        format!("Observed(ids={ids:?})")
    }
}

impl Observed {
    fn plan(&self, model: &Model<'_>, sentence: &str) -> Result<Outcome, SceneError> {
        let objects = self.objects.iter().map(|seen| {
            let mut embedding = vision::encode(model, &seen.crop);
            if let Some(part) = &seen.uncovered {
                vision::recolor(model, &mut embedding, &mut part.clone());
            }
            ObservedObject {
                id: seen.detection.id,
                location: seen.detection.location,
                embedding,
            }
        });
        let scene = checked_scene(model, self.camera, objects)?;
        Ok(Planner::new(model).plan(&scene, sentence))
    }
}

/// What comes of one sentence.
pub(crate) type Outcome = Result<Plan, Refusal>;

/// A scene of these objects, as core checks it.
pub(crate) fn checked_scene(
    model: &Model<'_>,
    camera: nsrm_core::Camera,
    objects: impl ExactSizeIterator<Item = ObservedObject>,
) -> Result<Box<Scene>, SceneError> {
    let count = objects.len().try_into().unwrap_or(u32::MAX);
    let mut scene = RawScene::empty(model, camera);
    for object in objects {
        if scene.push(object).is_err() {
            return Err(SceneError::TooManyObjects { count });
        }
    }
    Scene::new(scene, model).map(Box::new)
}

/// Plans each sentence in the scene beside it, on all processors. Fails with the index of
/// the first scene that core refuses.
pub(crate) fn plan_all(
    model: &Model<'_>,
    jobs: &[(&Observed, String)],
) -> Result<Vec<Outcome>, (usize, SceneError)> {
    let processors = thread::available_parallelism().map_or(1, NonZero::get);
    let share = jobs.len().div_ceil(processors).max(1);
    let plan = |(first, share): (usize, &[(&Observed, String)])| {
        let plans = share.iter().zip(first..);
        plans
            .map(|((observed, sentence), index)| {
                let plan = observed.plan(model, sentence);
                plan.map_err(|error| (index, error))
            })
            .collect::<Result<Vec<_>, _>>()
    };
    let parts = thread::scope(|scope| {
        let shares = (0..).step_by(share).zip(jobs.chunks(share));
        let threads: Vec<_> = shares.map(|part| scope.spawn(move || plan(part))).collect();
        let joined = threads.into_iter().map(|thread| match thread.join() {
            Ok(part) => part,
            Err(panic) => std::panic::resume_unwind(panic),
        });
        joined.collect::<Result<Vec<_>, _>>()
    })?;
    Ok(parts.into_iter().flatten().collect())
}
