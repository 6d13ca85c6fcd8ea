//! Scenes and what they are made from, in the bytes of core's structs.

use core::mem::offset_of;

use nsrm_core::{Model, RawScene, SceneError, camera, scene, vision};

use crate::capacity::{EMBEDDING, MAX_OBJECTS};
use crate::model::{self, ModelHandle};
use crate::pointers;
use crate::status::{Status, status};

/// A camera: pinhole without distortion. Its optical frame: x right, y down, z forward. The world's
/// frame: the robot's base at the origin, x forward, y left, z up.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Camera {
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
    /// Orientation of the optical frame in the world's frame: a unit quaternion x, y, z, w.
    pub orientation: [f32; 4],
}

/// An object that a detector has found in an image.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Detection {
    /// Id of the object, the same in all scenes; not zero.
    pub id: u32,
    /// Corners x1, y1, x2, y2 of the box around its visible part, as fractions of the image.
    pub visible: [f32; 4],
    /// Corners of the box around the whole object, including hidden parts as far as they are known,
    /// then the mean depth of its pixels in metres.
    pub location: [f32; 5],
}

/// An object in the camera's view.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Object {
    /// Id of the object, the same in all scenes; not zero.
    pub id: u32,
    /// Box corners x1, y1, x2, y2 as fractions of the image's width and height, then the mean depth of
    /// its visible pixels in metres.
    pub location: [f32; 5],
    /// What `nsrm_observe` computed from its crop.
    pub embedding: [f32; EMBEDDING],
}

/// An observed scene. `nsrm_observe` makes one, and so does a perception process: it has the same bytes
/// as `nsrm_scene_message` of nsrm_messages.h.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scene {
    /// Version of this layout: 1.
    pub schema: u32,
    /// Frame of reference of the camera's pose: 0, the world's.
    pub frame: u32,
    /// Tag of the model that computed the embeddings.
    pub model_tag: u64,
    /// Sequence number: increases with each scene of one publisher.
    pub sequence: u64,
    /// When the image was taken, nanoseconds on the publisher's clock.
    pub timestamp_ns: u64,
    /// The camera.
    pub camera: Camera,
    /// How many objects there are.
    pub count: u32,
    /// The objects; those behind the first `count` are ignored.
    pub objects: [Object; MAX_OBJECTS],
}

/// That a field of one struct lies where that of another does.
macro_rules! same {
    ($ours:ty, $cores:ty: $($field:ident),*) => {
        assert!(size_of::<$ours>() == size_of::<$cores>());
        assert!(align_of::<$ours>() == align_of::<$cores>());
        $(assert!(offset_of!($ours, $field) == offset_of!($cores, $field));)*
    };
}

const _: () = {
    same!(Camera, camera::Camera: width, height, fx, fy, cx, cy, position, orientation);
    same!(Detection, vision::Detection: id, visible, location);
    same!(Object, scene::ObservedObject: id, location, embedding);
    same!(Scene, RawScene: camera, count, objects);
    assert!(offset_of!(RawScene, header) == 0);
    assert!(offset_of!(Scene, schema) == offset_of!(scene::SceneHeader, schema));
    assert!(offset_of!(Scene, frame) == offset_of!(scene::SceneHeader, frame));
    assert!(offset_of!(Scene, model_tag) == offset_of!(scene::SceneHeader, model_tag));
    assert!(offset_of!(Scene, sequence) == offset_of!(scene::SceneHeader, sequence));
    assert!(offset_of!(Scene, timestamp_ns) == offset_of!(scene::SceneHeader, timestamp_ns));
};

impl From<camera::Camera> for Camera {
    fn from(camera: camera::Camera) -> Self {
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

impl From<Camera> for camera::Camera {
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

/// The scene behind a pointer, checked; the outer error is that of the pointer.
///
/// # Safety
/// If it is neither null nor misaligned, it points to a scene that nobody writes while it is used.
pub(crate) unsafe fn checked(
    scene: *const Scene,
    model: &Model<'_>,
) -> Result<Result<&'static scene::Scene, SceneError>, Status> {
    // SAFETY: the same bytes, and the caller's promise.
    let raw = unsafe { pointers::read(scene.cast::<RawScene>()) }?;
    Ok(raw.check(model).map(|()| {
        // SAFETY: a scene is a raw scene that has passed this check, in the same bytes.
        unsafe { &*scene.cast::<scene::Scene>() }
    }))
}

/// A scene without objects, as the model's planner expects it.
///
/// # Safety
/// The pointers are null or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nsrm_scene_init(
    scene: *mut Scene,
    model: *const ModelHandle,
    camera: *const Camera,
) -> Status {
    status(|| {
        // SAFETY: the caller's promises, and the same bytes.
        unsafe {
            let model = model::model(model)?;
            let camera = *pointers::read(camera)?;
            let empty = RawScene::empty(model, camera.into());
            pointers::write(scene.cast::<RawScene>(), empty)
        }
    })
}
