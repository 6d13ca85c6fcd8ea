//! The model file's `__metadata__`: strings, most of them JSON.

use std::collections::{BTreeMap, HashMap};

use nsrm_core::Camera;
use nsrm_core::model::{self, Thresholds, WorkSpace};
use nsrm_core::nn::LENGTH_TOLERANCE;
use serde::Deserialize;
use serde::de::DeserializeOwned;

use crate::domain::Domain;
use crate::error::ModelError;

/// The checked metadata.
#[derive(Debug)]
pub(crate) struct Metadata {
    pub(crate) domain: Domain,
    /// The group token, then the domain's words, sorted.
    pub(crate) vocabulary: Vec<String>,
    pub(crate) thresholds: Thresholds,
    pub(crate) work_space: WorkSpace,
    pub(crate) placed_orientation: [f32; 4],
    pub(crate) training_camera: Camera,
    pub(crate) training: serde_json::Value,
    pub(crate) metrics: serde_json::Value,
}

#[derive(Deserialize)]
struct ThresholdsText {
    match_score: f32,
    decision: f32,
    #[serde(default)]
    confidence: f32,
}

#[derive(Deserialize)]
struct WorkSpaceText {
    min: [f32; 3],
    max: [f32; 3],
}

#[derive(Deserialize)]
struct CameraText {
    width: u32,
    height: u32,
    fx: f32,
    fy: f32,
    cx: f32,
    cy: f32,
    position: [f32; 3],
    orientation: [f32; 4],
}

/// The architecture's dimensions, by the exporter's names.
const DIMENSIONS: [(&str, usize); 11] = [
    ("word", model::WORD),
    ("encoder_hidden", model::ENCODER_HIDDEN),
    ("splitter_word", model::SPLITTER_WORD),
    ("splitter_hidden", model::SPLITTER_HIDDEN),
    ("crop", model::CROP),
    ("patch_channels", model::PATCH_CHANNELS),
    ("merge_channels", model::MERGE_CHANNELS),
    ("view_embedding", model::VIEW_EMBEDDING),
    ("operator_hidden", model::OPERATOR_HIDDEN),
    ("concept", model::CONCEPT),
    ("simulator_hidden", model::SIMULATOR_HIDDEN),
];

impl Metadata {
    pub(crate) fn read(map: &HashMap<String, String>) -> Result<Self, ModelError> {
        let dimensions: BTreeMap<String, u64> = json(map, "dimensions")?;
        for (name, expected) in DIMENSIONS {
            let expected = expected as u64;
            match dimensions.get(name) {
                Some(&got) if got != expected => {
                    return Err(ModelError::Dimension {
                        name: name.into(),
                        expected,
                        got,
                    });
                }
                _ => {}
            }
        }
        let domain: Domain = json(map, "domain")?;
        domain.check()?;
        let vocabulary: Vec<String> = json(map, "vocabulary")?;
        domain.check_vocabulary(&vocabulary)?;
        Ok(Self {
            domain,
            vocabulary,
            thresholds: thresholds(json(map, "thresholds")?)?,
            work_space: work_space(json(map, "work_space")?)?,
            placed_orientation: orientation(json(map, "placed_orientation")?)?,
            training_camera: camera(json(map, "training_camera")?)?,
            training: json(map, "training")?,
            metrics: json(map, "metrics")?,
        })
    }
}

/// Refuses other schemas, whose hash and entries have other meanings.
pub(crate) fn check_schema(map: &HashMap<String, String>) -> Result<(), ModelError> {
    let schema = text(map, "schema")?;
    if schema == model::SCHEMA.to_string() {
        return Ok(());
    }
    Err(ModelError::Schema {
        expected: model::SCHEMA,
        got: schema.to_owned(),
    })
}

fn text<'a>(map: &'a HashMap<String, String>, key: &'static str) -> Result<&'a str, ModelError> {
    map.get(key)
        .map(String::as_str)
        .ok_or(ModelError::MissingMetadata { key })
}

fn json<T: DeserializeOwned>(
    map: &HashMap<String, String>,
    key: &'static str,
) -> Result<T, ModelError> {
    serde_json::from_str(text(map, key)?).map_err(|error| ModelError::NotJson {
        key,
        reason: error.to_string(),
    })
}

fn thresholds(text: ThresholdsText) -> Result<Thresholds, ModelError> {
    in_range("match_score", text.match_score)?;
    in_range("decision", text.decision)?;
    in_range("confidence", text.confidence)?;
    Ok(Thresholds::new()
        .with_match_score(text.match_score)
        .with_decision(text.decision)
        .with_confidence(text.confidence))
}

pub(crate) fn in_range(name: &'static str, got: f32) -> Result<(), ModelError> {
    if (0.0..=1.0).contains(&got) {
        return Ok(());
    }
    Err(ModelError::Threshold { name, got })
}

fn work_space(text: WorkSpaceText) -> Result<WorkSpace, ModelError> {
    for (index, axis) in ['x', 'y', 'z'].into_iter().enumerate() {
        let (min, max) = (text.min[index], text.max[index]);
        if !(min.is_finite() && max.is_finite() && min < max) {
            return Err(ModelError::WorkSpace { axis, min, max });
        }
    }
    Ok(WorkSpace::new().with_min(text.min).with_max(text.max))
}

fn camera(text: CameraText) -> Result<Camera, ModelError> {
    let camera = Camera {
        width: text.width,
        height: text.height,
        fx: text.fx,
        fy: text.fy,
        cx: text.cx,
        cy: text.cy,
        position: text.position,
        orientation: text.orientation,
    };
    camera.check().map_err(ModelError::TrainingCamera)?;
    Ok(camera)
}

fn orientation(quaternion: [f32; 4]) -> Result<[f32; 4], ModelError> {
    let square = quaternion.iter().map(|x| x * x).sum::<f32>();
    // As in `Model::check`; NaN and infinity fail, too.
    if (square - 1.0).abs() <= LENGTH_TOLERANCE {
        return Ok(quaternion);
    }
    let length = square.sqrt();
    Err(ModelError::PlacedOrientation { length })
}
