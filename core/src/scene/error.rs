use core::fmt;

use super::{FRAME_WORLD, SCENE_SCHEMA};
use crate::camera::CameraError;
use crate::capacity::MAX_OBJECTS;

/// What of an object is wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum ObjectFault {
    /// The id is 0.
    ZeroId,
    /// An object before it has the same id.
    RepeatedId,
    /// A number of its location is infinite or not a number.
    LocationNotFinite,
    /// A number of its embedding is infinite or not a number.
    EmbeddingNotFinite,
    /// Not x1 < x2 and y1 < y2.
    BoxNotOrdered,
    /// A corner lies outside 0..=1.
    BoxOutsideImage,
    /// The depth is zero or negative.
    DepthNotPositive,
}

impl fmt::Display for ObjectFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::ZeroId => "id must not be 0",
            Self::RepeatedId => "id is already taken by an object before it",
            Self::LocationNotFinite => "box or depth is not a finite number",
            Self::EmbeddingNotFinite => "embedding is not finite",
            Self::BoxNotOrdered => "box must have x1 < x2 and y1 < y2",
            Self::BoxOutsideImage => "box must lie inside the image: fractions from 0 to 1",
            Self::DepthNotPositive => "depth must be greater than 0",
        })
    }
}

impl core::error::Error for ObjectFault {}

/// Why a scene is refused; the first fault found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum SceneError {
    /// Another layout than [`SCENE_SCHEMA`].
    Schema {
        /// What the scene says.
        got: u32,
    },
    /// Another frame of reference than [`FRAME_WORLD`].
    Frame {
        /// What the scene says.
        got: u32,
    },
    /// The embeddings were made by another model.
    ModelTag {
        /// Tag of the model that is to read the scene.
        expected: u64,
        /// What the scene says.
        got: u64,
    },
    /// The camera is not one.
    Camera(CameraError),
    /// More than [`MAX_OBJECTS`].
    TooManyObjects {
        /// How many were given.
        count: u32,
    },
    /// An object is not one.
    Object {
        /// Its place in the scene, from 0.
        index: u8,
        /// Its id.
        id: u32,
        /// What is wrong with it.
        fault: ObjectFault,
    },
    /// The image has another size than the camera says.
    ImageSize {
        /// Width and height that the camera says, in pixels.
        expected: [u32; 2],
        /// Width and height of the image, in pixels.
        got: [u32; 2],
    },
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Schema { got } => {
                write!(f, "scene: schema {got}, but {SCENE_SCHEMA} is what is read")
            }
            Self::Frame { got } => write!(
                f,
                "scene: frame of reference {got}, but only {FRAME_WORLD} (world) is known"
            ),
            Self::ModelTag { expected, got } => write!(
                f,
                "scene: embeddings of model {got:016x}, but the planner's is {expected:016x}; \
                 encode the crops with the same model"
            ),
            Self::Camera(error) => error.fmt(f),
            Self::TooManyObjects { count } => {
                write!(f, "scene: {count} objects, at most {MAX_OBJECTS} are read")
            }
            Self::Object { index, id, fault } => {
                write!(f, "scene: object {id} (place {index}): {fault}")
            }
            Self::ImageSize { expected, got } => write!(
                f,
                "scene: the image is {}×{} pixels, but the camera says {}×{}",
                got[0], got[1], expected[0], expected[1]
            ),
        }
    }
}

impl core::error::Error for SceneError {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        match self {
            Self::Camera(error) => Some(error),
            _ => None,
        }
    }
}

impl From<CameraError> for SceneError {
    fn from(error: CameraError) -> Self {
        Self::Camera(error)
    }
}
