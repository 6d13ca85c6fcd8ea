//! The scene that perception publishes, in core's layout.

#[cfg(feature = "processes")]
use iceoryx2::prelude::ZeroCopySend;
use nsrm_core::camera::Camera;
use nsrm_core::model::{LOCATION, Model, OBJECT_EMBEDDING};
use nsrm_core::scene::{ObservedObject, RawScene, Scene, SceneError, SceneHeader};
use nsrm_core::{MAX_OBJECTS, scene};

use super::layout::message;

message! {
    /// Intrinsics and pose of a camera: pinhole without distortion; see
    /// [`nsrm_core::camera::Camera`].
    #[derive(Default)]
    "nsrm.v1.CameraMessage.8b20698258a5e70e"
    pub struct CameraMessage {
        /// Width of the image in pixels.
        pub width: u32,
        /// Height of the image in pixels.
        pub height: u32,
        /// Focal length along x in pixels.
        pub fx: f32,
        /// Focal length along y in pixels.
        pub fy: f32,
        /// x of the principal point in pixels, from the image's left edge.
        pub cx: f32,
        /// y of the principal point in pixels, from the image's upper edge.
        pub cy: f32,
        /// Origin of the optical frame in the world's frame, metres.
        pub position: [f32; 3],
        /// Orientation of the optical frame in the world's frame: x, y, z, w.
        pub orientation: [f32; 4],
    }
}

message! {
    /// An object in the camera's view.
    "nsrm.v1.ObjectMessage.74f496911c7af3de"
    pub struct ObjectMessage {
        /// Id of the object, the same in all scenes; not zero.
        pub id: u32,
        /// Box corners x1, y1, x2, y2 as fractions of the image's width and
        /// height, then mean depth in metres.
        pub location: [f32; LOCATION],
        /// The crop encoder's embedding.
        pub embedding: [f32; OBJECT_EMBEDDING],
    }
}

message! {
    /// The latest scene (service `scene`). Has the same bytes as core's [`RawScene`];
    /// [`SceneMessage::to_scene`] checks them.
    "nsrm.v1.SceneMessage.44a4c1a31d84fbc0"
    pub struct SceneMessage {
        /// Version of this layout: [`nsrm_core::scene::SCENE_SCHEMA`].
        pub schema: u32,
        /// Frame of reference of the camera's pose.
        pub frame: u32,
        /// Tag of the model whose encoder computed the embeddings.
        pub model_tag: u64,
        /// Sequence number: increases with each scene of one publisher.
        pub sequence: u64,
        /// When the image was taken, nanoseconds on the publisher's clock.
        pub timestamp_ns: u64,
        /// The camera.
        pub camera: CameraMessage,
        /// The number of valid entries in `objects`.
        pub count: u32,
        /// The objects.
        pub objects: [ObjectMessage; MAX_OBJECTS],
    }
}

impl From<CameraMessage> for Camera {
    fn from(message: CameraMessage) -> Self {
        Self {
            width: message.width,
            height: message.height,
            fx: message.fx,
            fy: message.fy,
            cx: message.cx,
            cy: message.cy,
            position: message.position,
            orientation: message.orientation,
        }
    }
}

impl From<Camera> for CameraMessage {
    fn from(camera: Camera) -> Self {
        Self {
            width: camera.width,
            height: camera.height,
            fx: camera.fx,
            fy: camera.fy,
            cx: camera.cx,
            cy: camera.cy,
            position: camera.position,
            orientation: camera.orientation,
        }
    }
}

impl From<&Scene> for SceneMessage {
    fn from(scene: &Scene) -> Self {
        Self::from(scene.raw())
    }
}

impl From<&RawScene> for SceneMessage {
    fn from(raw: &RawScene) -> Self {
        Self {
            schema: raw.header.schema,
            frame: raw.header.frame,
            model_tag: raw.header.model_tag,
            sequence: raw.header.sequence,
            timestamp_ns: raw.header.timestamp_ns,
            camera: raw.camera.into(),
            count: raw.count,
            objects: raw.objects.map(|object| ObjectMessage {
                id: object.id,
                location: object.location,
                embedding: object.embedding,
            }),
        }
    }
}

impl SceneMessage {
    /// Checks the scene for a planner with `model`; copies the 4.5 KB once.
    ///
    /// ```
    /// use nsrm_core::{SceneError, camera::CameraError};
    /// use nsrm_ipc::message::SceneMessage;
    /// use nsrm_tabletop::TABLETOP;
    ///
    /// let message = SceneMessage::from(&nsrm_core::RawScene::empty(&TABLETOP, Default::default()));
    /// let fault = message.to_scene(&TABLETOP).unwrap_err();
    /// assert_eq!(fault, SceneError::Camera(CameraError::NotPositive("width")));
    /// ```
    pub fn to_scene(&self, model: &Model<'_>) -> Result<Scene, SceneError> {
        let raw = RawScene {
            header: SceneHeader {
                schema: self.schema,
                frame: self.frame,
                model_tag: self.model_tag,
                sequence: self.sequence,
                timestamp_ns: self.timestamp_ns,
            },
            camera: self.camera.into(),
            count: self.count,
            objects: self.objects.map(|object| ObservedObject {
                id: object.id,
                location: object.location,
                embedding: object.embedding,
            }),
        };
        Scene::new(raw, model)
    }
}

// The same bytes as core's, so that a scene could be written in place.
const _: () = {
    use core::mem::offset_of;
    assert!(size_of::<SceneMessage>() == size_of::<RawScene>());
    assert!(align_of::<SceneMessage>() == align_of::<RawScene>());
    assert!(offset_of!(SceneMessage, camera) == offset_of!(RawScene, camera));
    assert!(offset_of!(SceneMessage, count) == offset_of!(RawScene, count));
    assert!(offset_of!(SceneMessage, objects) == offset_of!(RawScene, objects));
    assert!(size_of::<ObjectMessage>() == size_of::<ObservedObject>());
    assert!(scene::SCENE_SCHEMA == 1, "the type names say v1");
};
