//! The observed scene: objects with their locations and embeddings, and the camera (`S_I` of the
//! paper), in the layout of shared memory and the C interface.
//!
//! [`RawScene`] is unchecked data from any source. [`Scene`] is checked: every number in it is
//! finite, every box is ordered and inside the image, every depth positive, every id non-zero and
//! unique.

mod error;

pub use error::{ObjectFault, SceneError};

use core::mem::{offset_of, size_of};

use crate::camera::Camera;
use crate::capacity::MAX_OBJECTS;
use crate::model::{LOCATION, Model, OBJECT_EMBEDDING};

/// Version of the layout of [`RawScene`].
pub const SCENE_SCHEMA: u32 = 1;
/// [`SceneHeader::frame`]: the camera's pose is given in the world's frame. The
/// only one of schema 1.
pub const FRAME_WORLD: u32 = 0;

/// The header of a scene.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SceneHeader {
    /// [`SCENE_SCHEMA`].
    pub schema: u32,
    /// Frame of reference of the camera's pose: [`FRAME_WORLD`].
    pub frame: u32,
    /// [`Model::tag`] of the model whose encoder computed the embeddings.
    pub model_tag: u64,
    /// Sequence number: increases with each scene of one publisher.
    pub sequence: u64,
    /// When the image was taken, nanoseconds on the publisher's clock.
    pub timestamp_ns: u64,
}

/// An object in the camera's view.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObservedObject {
    /// Id of the object, the same in all scenes; not zero.
    pub id: u32,
    /// Box corners x1, y1, x2, y2 as fractions of the image's width and height,
    /// then the mean depth of its visible pixels in metres.
    pub location: [f32; LOCATION],
    /// The crop encoder's embedding; see [`crate::vision::encode`].
    pub embedding: [f32; OBJECT_EMBEDDING],
}

impl ObservedObject {
    /// All zero, as in the unused places of a scene.
    pub const EMPTY: Self = Self {
        id: 0,
        location: [0.0; LOCATION],
        embedding: [0.0; OBJECT_EMBEDDING],
    };

    /// The mean depth of its visible pixels, metres.
    pub(crate) const fn depth_m(&self) -> f32 {
        let [.., depth_m] = self.location;
        depth_m
    }
}

/// A scene from outside: fixed size, no pointers, no padding. It may contain anything until
/// [`Scene::new`] has checked it.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RawScene {
    /// The header.
    pub header: SceneHeader,
    /// The camera.
    pub camera: Camera,
    /// The number of valid entries in `objects`.
    pub count: u32,
    /// The objects; entries after the first `count` are ignored.
    pub objects: [ObservedObject; MAX_OBJECTS],
}

// No padding: the fields fill the structs exactly, in this order.
const _: () = {
    assert!(size_of::<SceneHeader>() == 32);
    assert!(size_of::<Camera>() == 52);
    assert!(size_of::<ObservedObject>() == 4 * (1 + LOCATION + OBJECT_EMBEDDING));
    assert!(offset_of!(RawScene, camera) == 32);
    assert!(offset_of!(RawScene, count) == 84);
    assert!(offset_of!(RawScene, objects) == 88);
    assert!(size_of::<RawScene>() == 88 + MAX_OBJECTS * size_of::<ObservedObject>());
};

/// A checked scene. The same bytes as its [`RawScene`].
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scene {
    raw: RawScene,
}

impl RawScene {
    /// A scene without objects, as `model`'s planner expects it.
    ///
    /// ```
    /// use nsrm_core::{Camera, RawScene, Scene};
    /// use nsrm_core::scene::ObservedObject;
    /// use nsrm_core::model::OBJECT_EMBEDDING;
    /// use nsrm_tabletop::TABLETOP;
    ///
    /// let camera = Camera {
    ///     width: 640,
    ///     height: 480,
    ///     fx: 600.0,
    ///     fy: 600.0,
    ///     cx: 320.0,
    ///     cy: 240.0,
    ///     position: [0.5, 0.0, 1.0], // straight above the table
    ///     orientation: [1.0, 0.0, 0.0, 0.0], // x, y, z, w
    /// };
    /// let mut raw = RawScene::empty(&TABLETOP, camera);
    /// raw.push(ObservedObject {
    ///     id: 7,
    ///     location: [0.4, 0.4, 0.45, 0.5, 0.97], // box and depth
    ///     embedding: [0.0; OBJECT_EMBEDDING], // what vision::encode makes of its crop
    /// }).expect("room for an object");
    /// let scene = Scene::new(raw, &TABLETOP)?;
    /// assert_eq!(scene.objects()[0].id, 7);
    /// # Ok::<(), nsrm_core::SceneError>(())
    /// ```
    pub const fn empty(model: &Model<'_>, camera: Camera) -> Self {
        Self {
            header: SceneHeader {
                schema: SCENE_SCHEMA,
                frame: FRAME_WORLD,
                model_tag: model.tag(),
                sequence: 0,
                timestamp_ns: 0,
            },
            camera,
            count: 0,
            objects: [ObservedObject::EMPTY; MAX_OBJECTS],
        }
    }

    /// Appends an object; returns it if the scene is full. [`Scene::new`] checks its values.
    // An object handed back is as big as it is.
    #[allow(clippy::result_large_err)]
    pub fn push(&mut self, object: ObservedObject) -> Result<(), ObservedObject> {
        let place = usize::try_from(self.count)
            .ok()
            .and_then(|count| self.objects.get_mut(count));
        let Some(place) = place else {
            return Err(object);
        };
        *place = object;
        self.count += 1;
        Ok(())
    }

    /// Checks that a planner with `model` can read the scene.
    ///
    /// Cost: one pass over the numbers and `count²/2` comparisons of ids.
    pub fn check(&self, model: &Model<'_>) -> Result<(), SceneError> {
        let SceneHeader {
            schema,
            frame,
            model_tag,
            ..
        } = self.header;
        if schema != SCENE_SCHEMA {
            return Err(SceneError::Schema { got: schema });
        }
        if frame != FRAME_WORLD {
            return Err(SceneError::Frame { got: frame });
        }
        if model_tag != model.tag() {
            return Err(SceneError::ModelTag {
                expected: model.tag(),
                got: model_tag,
            });
        }
        self.camera.check()?;
        let objects = usize::try_from(self.count)
            .ok()
            .and_then(|count| self.objects.get(..count))
            .ok_or(SceneError::TooManyObjects { count: self.count })?;
        for (index, object) in objects.iter().enumerate() {
            let repeated = objects
                .iter()
                .take(index)
                .any(|before| before.id == object.id);
            let fault = if object.id == 0 {
                Some(ObjectFault::ZeroId)
            } else if repeated {
                Some(ObjectFault::RepeatedId)
            } else if !object.embedding.iter().all(|number| number.is_finite()) {
                Some(ObjectFault::EmbeddingNotFinite)
            } else {
                location_fault(&object.location)
            };
            if let Some(fault) = fault {
                return Err(SceneError::Object {
                    // Below MAX_OBJECTS.
                    index: index as u8,
                    id: object.id,
                    fault,
                });
            }
        }
        Ok(())
    }
}

impl Scene {
    /// Checks a scene from outside; see [`RawScene::check`].
    ///
    /// ```
    /// use nsrm_core::{Camera, RawScene, Scene, SceneError};
    /// use nsrm_core::camera::CameraError;
    /// use nsrm_tabletop::TABLETOP;
    ///
    /// // Nobody has filled in the camera.
    /// let raw = RawScene::empty(&TABLETOP, Camera::default());
    /// let fault = Scene::new(raw, &TABLETOP).unwrap_err();
    /// assert_eq!(fault, SceneError::Camera(CameraError::NotPositive("width")));
    /// ```
    pub fn new(raw: RawScene, model: &Model<'_>) -> Result<Self, SceneError> {
        raw.check(model)?;
        Ok(Self { raw })
    }

    /// The objects, at most [`MAX_OBJECTS`].
    pub fn objects(&self) -> &[ObservedObject] {
        // `count` was checked: never more than there are.
        self.raw
            .objects
            .get(..self.raw.count as usize)
            .unwrap_or_default()
    }

    /// The camera.
    pub const fn camera(&self) -> &Camera {
        &self.raw.camera
    }

    /// The header.
    pub const fn header(&self) -> &SceneHeader {
        &self.raw.header
    }

    /// The bytes to publish.
    pub const fn raw(&self) -> &RawScene {
        &self.raw
    }
}

/// What is wrong with a location, if anything.
pub(crate) fn location_fault(location: &[f32; LOCATION]) -> Option<ObjectFault> {
    let [x1, y1, x2, y2, depth] = *location;
    if !location.iter().all(|number| number.is_finite()) {
        Some(ObjectFault::LocationNotFinite)
    } else if !(x1 < x2 && y1 < y2) {
        Some(ObjectFault::BoxNotOrdered)
    } else if x1 < 0.0 || y1 < 0.0 || x2 > 1.0 || y2 > 1.0 {
        Some(ObjectFault::BoxOutsideImage)
    } else if depth <= 0.0 {
        Some(ObjectFault::DepthNotPositive)
    } else {
        None
    }
}

#[cfg(test)]
mod tests;
