//! What is observed: objects with their locations and embeddings, and the camera
//! (`S_I` of the paper), in the layout that shared memory and the C interface use.
//!
//! [`RawScene`] is bytes that anyone may have written. [`Scene`] is one that was
//! checked; from then on every number in it is finite, every box is ordered and
//! inside the image, every depth positive, every id non-zero and its own.

use core::fmt;
use core::mem::{offset_of, size_of};

use crate::camera::{Camera, CameraError};
use crate::capacity::MAX_OBJECTS;
use crate::model::{LOCATION, Model, OBJECT_EMBEDDING};

/// Version of the layout of [`RawScene`].
pub const SCENE_SCHEMA: u32 = 1;
/// [`SceneHeader::frame`]: the camera's pose is given in the world's frame. The
/// only one of schema 1.
pub const FRAME_WORLD: u32 = 0;

/// What a scene says of itself.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SceneHeader {
    /// [`SCENE_SCHEMA`].
    pub schema: u32,
    /// Frame of reference of the camera's pose: [`FRAME_WORLD`].
    pub frame: u32,
    /// [`Model::tag`] of the model whose encoder made the embeddings.
    pub model_tag: u64,
    /// Counts up with each scene of one publisher.
    pub sequence: u64,
    /// When the image was taken, nanoseconds on the publisher's clock.
    pub timestamp_ns: u64,
}

/// An object as the camera sees it.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObservedObject {
    /// Who it is across scenes; not zero.
    pub id: u32,
    /// Box corners x1, y1, x2, y2 as fractions of the image's width and height,
    /// then the mean depth of its visible pixels in metres.
    pub location: [f32; LOCATION],
    /// What the crop encoder made of it; see [`crate::vision::encode`].
    pub embedding: [f32; OBJECT_EMBEDDING],
}

impl ObservedObject {
    /// All zero: what stands in the unused places of a scene.
    pub const EMPTY: Self = Self {
        id: 0,
        location: [0.0; LOCATION],
        embedding: [0.0; OBJECT_EMBEDDING],
    };
}

/// A scene as it comes from outside: fixed size, no pointers, no padding.
/// Anything may stand in it until [`Scene::new`] has checked it.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RawScene {
    /// What the scene says of itself.
    pub header: SceneHeader,
    /// The camera that saw it.
    pub camera: Camera,
    /// How many of `objects` are there.
    pub count: u32,
    /// The objects; what stands behind the first `count` is not looked at.
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

/// What of an object is wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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

/// Why a scene is refused; the first fault found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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

impl RawScene {
    /// A scene without objects, as `model`'s planner expects it.
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

    /// Puts an object behind those that are there; gives it back when the scene
    /// is full. What the object says is checked by [`Scene::new`].
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

    /// Whether this is a scene that a planner on `model` can read.
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

    /// The camera that saw them.
    pub const fn camera(&self) -> &Camera {
        &self.raw.camera
    }

    /// What the scene says of itself.
    pub const fn header(&self) -> &SceneHeader {
        &self.raw.header
    }

    /// The bytes to publish.
    pub const fn raw(&self) -> &RawScene {
        &self.raw
    }
}

/// What is wrong with a location, if anything is.
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
mod tests {
    use std::string::ToString;

    use super::*;
    use crate::fixture;

    fn changed(change: impl FnOnce(&mut RawScene)) -> Result<(), SceneError> {
        let model = fixture::model();
        let mut raw = *fixture::scene(&model).raw();
        change(&mut raw);
        Scene::new(raw, &model).map(|_| ())
    }

    #[test]
    fn what_the_scene_says_of_itself_is_checked() {
        assert_eq!(changed(|_| ()), Ok(()));
        assert_eq!(
            changed(|raw| raw.header.schema = 2),
            Err(SceneError::Schema { got: 2 })
        );
        assert_eq!(
            changed(|raw| raw.header.frame = 1),
            Err(SceneError::Frame { got: 1 })
        );
        let tag = fixture::model().tag();
        assert_eq!(
            changed(|raw| raw.header.model_tag = 5),
            Err(SceneError::ModelTag {
                expected: tag,
                got: 5
            })
        );
        assert_eq!(
            changed(|raw| raw.camera.fy = f32::NAN),
            Err(SceneError::Camera(CameraError::NotFinite("fy")))
        );
        for count in [17, u32::MAX] {
            assert_eq!(
                changed(|raw| raw.count = count),
                Err(SceneError::TooManyObjects { count })
            );
        }
    }

    #[test]
    fn each_fault_of_an_object_is_named() {
        let fault = |change: fn(&mut ObservedObject)| {
            let error = changed(|raw| change(&mut raw.objects[1])).unwrap_err();
            let SceneError::Object {
                index: 1, fault, ..
            } = error
            else {
                panic!("{error}");
            };
            fault
        };
        assert_eq!(fault(|o| o.id = 0), ObjectFault::ZeroId);
        assert_eq!(fault(|o| o.id = 11), ObjectFault::RepeatedId);
        assert_eq!(
            fault(|o| o.location[4] = f32::INFINITY),
            ObjectFault::LocationNotFinite
        );
        assert_eq!(
            fault(|o| o.embedding[63] = f32::NAN),
            ObjectFault::EmbeddingNotFinite
        );
        assert_eq!(fault(|o| o.location[3] = 0.1), ObjectFault::BoxNotOrdered);
        assert_eq!(
            fault(|o| o.location[0] = -0.01),
            ObjectFault::BoxOutsideImage
        );
        assert_eq!(
            fault(|o| o.location[3] = 1.01),
            ObjectFault::BoxOutsideImage
        );
        assert_eq!(
            fault(|o| o.location[4] = 0.0),
            ObjectFault::DepthNotPositive
        );
        assert_eq!(
            changed(|raw| raw.objects[2].id = 12)
                .unwrap_err()
                .to_string(),
            "scene: object 12 (place 2): id is already taken by an object before it"
        );
    }

    #[test]
    fn what_stands_behind_the_objects_is_not_looked_at() {
        assert_eq!(changed(|raw| raw.objects[3].id = 11), Ok(()));
        assert_eq!(
            changed(|raw| raw.objects[15].location[0] = f32::NAN),
            Ok(())
        );
    }

    #[test]
    fn a_full_scene_gives_the_next_object_back() {
        let model = fixture::model();
        let mut raw = RawScene::empty(&model, fixture::camera());
        for id in 1..=16 {
            let object = fixture::object(id, fixture::RED, fixture::SMALL, 0.5, 0.5);
            assert_eq!(raw.push(object), Ok(()));
        }
        assert!(raw.push(ObservedObject::EMPTY).is_err());
        let scene = Scene::new(raw, &model).unwrap();
        assert_eq!((scene.objects().len(), scene.objects()[15].id), (16, 16));
    }
}
