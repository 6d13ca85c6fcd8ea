//! Text and files: sentences, scene files, model files.

use core::task::Poll;
use std::path::Path;
use std::sync::LazyLock;

use nsrm::{ModelError, OwnedModel, SceneText, json, read_scene_text};
use nsrm_core::language::Parsed;
use nsrm_core::planner::MAX_POLLS;
use nsrm_core::vision::{ObservationTask, RgbImage, Stamp};
use nsrm_core::{MAX_SENTENCE_BYTES, Model, Plan, Planner, Refusal, Scene};
use nsrm_tabletop::TABLETOP;

use super::bytes::Script;
use super::messages::{check_scene, plan_in};
use super::says;
use crate::picture;
use crate::plans::{check_in, reckless};

/// The squares as the pretrained model sees them.
pub(super) static SQUARES: LazyLock<Scene> = LazyLock::new(|| squares_by(&TABLETOP));

fn squares_by(model: &Model<'_>) -> Scene {
    let picture = picture::squares();
    let [width, height] = picture::SIZE;
    let image = RgbImage::new(&picture.pixels, width, height, 3 * width as usize);
    let image = image.expect("an image");
    let camera = picture::camera();
    let detections = &picture.detections;
    let task = ObservationTask::new(model, image, camera, detections, Stamp::default());
    task.and_then(ObservationTask::finish).expect("a scene")
}

/// A sentence; bytes that are not UTF-8 are replaced.
pub fn sentence(bytes: &[u8]) {
    follow(&String::from_utf8_lossy(bytes));
}

/// Parses and plans a sentence, twice each, with the model as it is and as one that
/// refuses less.
pub(super) fn follow(sentence: &str) {
    let reckless = reckless(TABLETOP, 0.0);
    for model in [&TABLETOP, &reckless] {
        follow_with(model, &SQUARES, sentence);
    }
}

fn follow_with(model: &Model<'_>, scene: &Scene, sentence: &str) {
    let planner = Planner::new(model);
    let parsed = planner.parse(sentence);
    assert_eq!(parsed, planner.parse(sentence));
    let planned = plan_counting(&planner, scene, sentence);
    assert_eq!(planned, planner.plan(scene, sentence));
    match &planned {
        Ok(plan) => {
            assert!(sentence.len() <= MAX_SENTENCE_BYTES);
            check_in(model, scene, plan);
            let program = parsed.as_ref().map(Parsed::program);
            assert_eq!(program, Ok(plan.program()));
            let written = json::plan(model, plan, sentence);
            let steps = written["steps"].as_array().map(Vec::len);
            assert_eq!(steps, Some(plan.steps().len()));
        }
        Err(refusal) => {
            assert!(!matches!(refusal, Refusal::InvalidModel));
            says(&refusal.in_context(model, sentence));
            assert!(json::refusal(model, refusal, sentence).is_object());
        }
    }
    if let Err(refusal) = parsed {
        assert_eq!(planned, Err(refusal));
    }
}

fn plan_counting(planner: &Planner<'_>, scene: &Scene, sentence: &str) -> Result<Plan, Refusal> {
    let mut task = planner.begin(scene, sentence);
    for _ in 0..MAX_POLLS {
        if let Poll::Ready(planned) = task.poll() {
            return planned.cloned();
        }
    }
    panic!("not done after {MAX_POLLS} polls: {sentence:?}");
}

/// The greatest side of the images that are made for a scene file.
const SIDE: u32 = 24;

/// The text of a scene file; then, with a small image, the scene in it.
pub fn scene_file(bytes: &[u8]) {
    let path = Path::new("scene.json");
    let text = match read_scene_text(path, bytes, &TABLETOP) {
        Ok(text) => text,
        Err(error) => {
            assert!(error.to_string().starts_with("scene.json: "), "{error}");
            return;
        }
    };
    let SceneText {
        camera, detections, ..
    } = text;
    assert_eq!(camera.check(), Ok(()));
    let camera = picture::scaled(camera, [1 + camera.width % SIDE, 1 + camera.height % SIDE]);
    let pixels = (camera.width * camera.height) as usize;
    let colours = [204, 23, 23, 23, 51, 204].into_iter().cycle();
    let image: Vec<u8> = colours.take(3 * pixels).collect();
    let stride = 3 * camera.width as usize;
    let image = RgbImage::new(&image, camera.width, camera.height, stride).expect("an image");
    let task = ObservationTask::new(&TABLETOP, image, camera, &detections, Stamp::default());
    match task.and_then(ObservationTask::finish) {
        Ok(scene) => {
            check_scene(&scene);
            plan_in(&scene);
        }
        Err(error) => says(&error),
    }
}

/// The model in the repository.
pub(super) const MODEL: &[u8] =
    include_bytes!("../../../weights-codegen/tabletop/tabletop.safetensors");

/// Length of the file's header, which is JSON, and where its tensors begin.
pub(super) fn header_of(file: &[u8]) -> (&[u8], &[u8]) {
    let (length, rest) = file.split_first_chunk().expect("a model file");
    let length = usize::try_from(u64::from_le_bytes(*length)).expect("a short header");
    rest.split_at(length)
}

/// The file with its hash replaced.
fn with_hash(mut file: Vec<u8>, named: &str, other: &str) -> Vec<u8> {
    let at = file
        .windows(named.len())
        .position(|window| window == named.as_bytes());
    // Not found if the header has it with escapes.
    if let Some(at) = at {
        file[at..at + other.len()].copy_from_slice(other.as_bytes());
    }
    file
}

/// A model file. The first byte says what the others are: the whole file, or a header for the
/// tensors of the pretrained model. A file that only the hash rules out is tried again with the
/// right one.
pub fn model_file(bytes: &[u8]) {
    let mut script = Script::new(bytes);
    let is_whole = script.byte().is_multiple_of(2);
    let bytes = script.rest();
    let file = if is_whole {
        bytes.to_vec()
    } else {
        let length = (bytes.len() as u64).to_le_bytes();
        [&length, bytes, header_of(MODEL).1].concat()
    };
    let read = OwnedModel::from_bytes(&file).or_else(|error| {
        says(&error);
        match error {
            ModelError::Hash { expected, got } => {
                OwnedModel::from_bytes(&with_hash(file, &expected, &got))
            }
            other => Err(other),
        }
    });
    let owned = match read {
        Ok(owned) => owned,
        Err(error) => return says(&error),
    };
    let model = owned.as_model();
    assert_eq!(model.check(), Ok(()));
    let scene = squares_by(&model);
    for action in model.actions {
        let sentence = format!("put the red block {} the blue block", action.phrase);
        follow_with(&model, &scene, &sentence);
    }
}
