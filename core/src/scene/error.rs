use thiserror::Error;

use super::{FRAME_WORLD, SCENE_SCHEMA};
use crate::camera::CameraError;
use crate::capacity::MAX_OBJECTS;

/// What is wrong with an object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ObjectFault {
    /// The id is 0.
    #[error("id must not be 0")]
    ZeroId,
    /// An object before it has the same id.
    #[error("id is already taken by an object before it")]
    RepeatedId,
    /// A number of its location is infinite or NaN.
    #[error("box or depth is not a finite number")]
    LocationNotFinite,
    /// A number of its embedding is infinite or NaN.
    #[error("embedding is not finite")]
    EmbeddingNotFinite,
    /// Not x1 < x2 and y1 < y2.
    #[error("box must have x1 < x2 and y1 < y2")]
    BoxNotOrdered,
    /// A corner lies outside 0..=1.
    #[error("box must lie inside the image: fractions from 0 to 1")]
    BoxOutsideImage,
    /// The depth is zero or negative.
    #[error("depth must be greater than 0")]
    DepthNotPositive,
}

/// Why a scene is invalid; the first fault found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum SceneError {
    /// A layout other than [`SCENE_SCHEMA`].
    #[error("scene: schema {got}, but {SCENE_SCHEMA} is what is read")]
    Schema {
        /// The value in the scene.
        got: u32,
    },
    /// A frame of reference other than [`FRAME_WORLD`].
    #[error("scene: frame of reference {got}, but only {FRAME_WORLD} (world) is known")]
    Frame {
        /// The value in the scene.
        got: u32,
    },
    /// The embeddings were computed by another model.
    #[error(
        "scene: embeddings of model {got:016x}, but the planner's is {expected:016x}; \
         encode the crops with the same model"
    )]
    ModelTag {
        /// Tag of the model that reads the scene.
        expected: u64,
        /// The value in the scene.
        got: u64,
    },
    /// The camera is invalid.
    #[error("{0}")]
    Camera(#[from] CameraError),
    /// More than [`MAX_OBJECTS`].
    #[error("scene: {count} objects, at most {MAX_OBJECTS} are read")]
    TooManyObjects {
        /// The number given.
        count: u32,
    },
    /// An object is invalid.
    #[error("scene: object {id} (place {index}): {fault}")]
    Object {
        /// Its place in the scene, from 0.
        index: u8,
        /// Its id.
        id: u32,
        /// What is wrong with it.
        fault: ObjectFault,
    },
    /// The model is one [without vision](crate::Model::without_vision).
    #[error("scene: the model has no vision; make scenes with the whole model")]
    NoVision,
    /// The size of the image differs from the camera's.
    #[error(
        "scene: the image is {}×{} pixels, but the camera says {}×{}",
        got[0], got[1], expected[0], expected[1]
    )]
    ImageSize {
        /// Width and height of the camera, in pixels.
        expected: [u32; 2],
        /// Width and height of the image, in pixels.
        got: [u32; 2],
    },
}
