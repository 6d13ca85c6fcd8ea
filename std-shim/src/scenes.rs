//! Scenes from files: a JSON file with camera and boxes, and its image or crops.

use std::fs::File;
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};

use nsrm_core::model::Model;
use nsrm_core::scene::{ObjectFault, ObservedObject};
use nsrm_core::vision::{self, Crop, Detection, ObservationTask, RgbImage, Stamp};
use nsrm_core::{Camera, MAX_OBJECTS, RawScene, Scene, SceneError};
use png::DecodingError;
use serde::Deserialize;
use thiserror::Error;

use crate::png_file::{self, Picture};

/// Schema version of the scene file.
const SCHEMA: u32 = 1;

/// Why a scene file cannot be used.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SceneFileError {
    /// A file cannot be read.
    #[error("{}: cannot read it: {source}", .path.display())]
    Read {
        /// Its path.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The scene file is not JSON, or has the wrong structure.
    #[error("{}: expected a scene as JSON: {source}", .path.display())]
    Json {
        /// Its path.
        path: PathBuf,
        /// Where and why.
        source: serde_json::Error,
    },
    /// The scene file has an unsupported schema version.
    #[error(
        "{}: schema: expected {SCHEMA}, got {got}; write the file with the tools of this version",
        .path.display()
    )]
    Schema {
        /// Its path.
        path: PathBuf,
        /// The version of the file.
        got: u32,
    },
    /// The scene file names no image, and no folder of crops was given.
    #[error(
        "{}: image: none is named; name one or give a folder with --crops",
        .path.display()
    )]
    NoImage {
        /// Its path.
        path: PathBuf,
    },
    /// An image cannot be decoded.
    #[error("{}: expected a PNG image: {source}", .path.display())]
    Image {
        /// Its path.
        path: PathBuf,
        /// Why.
        source: DecodingError,
    },
    /// A decoded image has an invalid size.
    #[error("{}: {source}", .path.display())]
    Pixels {
        /// Its path.
        path: PathBuf,
        /// Why.
        source: vision::ImageError,
    },
    /// The scene is invalid.
    #[error("{}: {source}", .path.display())]
    Scene {
        /// Path of the scene file.
        path: PathBuf,
        /// What is wrong.
        source: SceneError,
    },
}

#[derive(Deserialize)]
#[serde(expecting = "an object with schema, camera, image and objects")]
struct SceneFile {
    schema: u32,
    camera: CameraEntry,
    image: Option<PathBuf>,
    objects: Vec<ObjectEntry>,
}

#[derive(Deserialize)]
#[serde(expecting = "a camera: width, height, fx, fy, cx, cy, position, orientation")]
struct CameraEntry {
    width: u32,
    height: u32,
    fx: f32,
    fy: f32,
    cx: f32,
    cy: f32,
    position: [f32; 3],
    orientation: [f32; 4],
}

#[derive(Deserialize)]
#[serde(expecting = "an object of the scene: id, box, depth")]
struct ObjectEntry {
    id: u32,
    #[serde(rename = "box")]
    bounds: [f32; 4],
    depth: f32,
}

impl CameraEntry {
    fn camera(&self) -> Camera {
        Camera {
            width: self.width,
            height: self.height,
            fx: self.fx,
            fy: self.fy,
            cx: self.cx,
            cy: self.cy,
            position: self.position,
            orientation: self.orientation,
        }
    }
}

impl ObjectEntry {
    fn detection(&self) -> Detection {
        let [x1, y1, x2, y2] = self.bounds;
        Detection::whole(self.id, [x1, y1, x2, y2, self.depth])
    }
}

/// Reads a scene file and encodes its objects with `model`.
///
/// The file is JSON:
/// `{"schema": 1, "camera": {"width", "height", "fx", "fy", "cx", "cy", "position":
/// [x, y, z], "orientation": [x, y, z, w]}, "image": "initial.png", "objects":
/// [{"id": 1, "box": [x1, y1, x2, y2], "depth": 0.93}]}`.
///
/// * `crops`: a folder with a file `<id>.png` for each object, cut out at its box, of any size;
///   without it, the boxes are cut out of `image`, whose path is relative to the scene file
///
/// # Errors
/// [`SceneFileError`] for files that cannot be read or decoded and for scenes that
/// core refuses.
pub fn read_scene(
    path: impl AsRef<Path>,
    crops: Option<&Path>,
    model: &Model<'_>,
) -> Result<Scene, SceneFileError> {
    let path = path.as_ref();
    let bytes = std::fs::read(path).map_err(|source| read_error(path, source))?;
    let SceneText {
        camera,
        image,
        detections,
    } = read_scene_text(path, &bytes, model)?;
    let refused = |source| SceneFileError::Scene {
        path: path.into(),
        source,
    };
    match (crops, &image) {
        (Some(folder), _) => from_crops(folder, &detections, camera, model, refused),
        (None, Some(name)) => {
            let name = path.parent().unwrap_or(Path::new("")).join(name);
            let pixels = Pixels::read(&name)?;
            ObservationTask::new(
                model,
                pixels.image()?,
                camera,
                &detections,
                Stamp::default(),
            )
            .and_then(ObservationTask::finish)
            .map_err(refused)
        }
        (None, None) => Err(SceneFileError::NoImage { path: path.into() }),
    }
}

/// The content of a scene file, without its image.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneText {
    /// The camera.
    pub camera: Camera,
    /// The image's path in the file, if it has one.
    pub image: Option<PathBuf>,
    /// The objects: ids and boxes.
    pub detections: Vec<Detection>,
}

/// Reads the text of a scene file and checks everything that can be checked without the image;
/// opens no file.
///
/// * `path`: where the bytes come from, for errors
///
/// # Errors
/// As [`read_scene`].
pub fn read_scene_text(
    path: &Path,
    bytes: &[u8],
    model: &Model<'_>,
) -> Result<SceneText, SceneFileError> {
    let file: SceneFile = serde_json::from_slice(bytes).map_err(|source| SceneFileError::Json {
        path: path.into(),
        source,
    })?;
    if file.schema != SCHEMA {
        return Err(SceneFileError::Schema {
            path: path.into(),
            got: file.schema,
        });
    }
    let camera = file.camera.camera();
    let detections: Vec<Detection> = file.objects.iter().map(ObjectEntry::detection).collect();
    check(&detections, camera, model).map_err(|source| SceneFileError::Scene {
        path: path.into(),
        source,
    })?;
    Ok(SceneText {
        camera,
        image: file.image,
        detections,
    })
}

/// Everything that can be checked without the image.
fn check(detections: &[Detection], camera: Camera, model: &Model<'_>) -> Result<(), SceneError> {
    blank(detections, camera, model)?.check(model)
}

/// The scene with zero embeddings.
fn blank(
    detections: &[Detection],
    camera: Camera,
    model: &Model<'_>,
) -> Result<RawScene, SceneError> {
    let mut scene = RawScene::empty(model, camera);
    for &Detection { id, location, .. } in detections {
        let object = ObservedObject {
            id,
            location,
            ..ObservedObject::EMPTY
        };
        let count = detections.len().try_into().unwrap_or(u32::MAX);
        scene
            .push(object)
            .map_err(|_| SceneError::TooManyObjects { count })?;
    }
    Ok(scene)
}

fn from_crops(
    folder: &Path,
    detections: &[Detection],
    camera: Camera,
    model: &Model<'_>,
    refused: impl Fn(SceneError) -> SceneFileError,
) -> Result<Scene, SceneFileError> {
    let mut scene = blank(detections, camera, model).map_err(&refused)?;
    for (index, object) in scene.objects.iter_mut().enumerate().take(detections.len()) {
        let pixels = Pixels::read(&folder.join(format!("{}.png", object.id)))?;
        let fault = |fault: ObjectFault| {
            refused(SceneError::Object {
                // Below MAX_OBJECTS.
                index: index.min(MAX_OBJECTS) as u8,
                id: object.id,
                fault,
            })
        };
        let crop = Crop::from_rgb(&pixels.image()?, &[0.0, 0.0, 1.0, 1.0]).map_err(fault)?;
        object.embedding = vision::encode(model, &crop);
    }
    Scene::new(scene, model).map_err(refused)
}

/// A decoded image.
struct Pixels {
    path: PathBuf,
    picture: Picture,
}

impl Pixels {
    /// Decodes a PNG file; transparency is dropped.
    fn read(path: &Path) -> Result<Self, SceneFileError> {
        let file = File::open(path).map_err(|source| read_error(path, source))?;
        let decoded = png_file::decode(BufReader::new(file));
        let picture = decoded.map_err(|source| SceneFileError::Image {
            path: path.into(),
            source,
        })?;
        Ok(Self {
            path: path.into(),
            picture,
        })
    }

    fn image(&self) -> Result<RgbImage<'_>, SceneFileError> {
        let Picture { width, height, rgb } = &self.picture;
        RgbImage::new(rgb, *width, *height, 3 * *width as usize).map_err(|source| {
            SceneFileError::Pixels {
                path: self.path.clone(),
                source,
            }
        })
    }
}

fn read_error(path: &Path, source: io::Error) -> SceneFileError {
    SceneFileError::Read {
        path: path.into(),
        source,
    }
}
