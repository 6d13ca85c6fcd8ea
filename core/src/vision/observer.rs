use super::{Crop, RgbImage, encode_in_place, recolor, uncovered};
use crate::camera::Camera;
use crate::capacity::MAX_OBJECTS;
use crate::model::{LOCATION, Model, OBJECT_EMBEDDING};
use crate::scene::{ObservedObject, RawScene, Scene, SceneError};
use core::task::Poll;

/// A detected object. Plain data without padding.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Detection {
    /// Id of the object, the same in all scenes; not zero.
    pub id: u32,
    /// Corners x1, y1, x2, y2, as fractions of the image, of the box around its visible part: its
    /// crop.
    pub visible: [f32; 4],
    /// Corners of the box around the whole object, including hidden parts as far as they are known,
    /// then the mean depth of its pixels in metres: its location.
    pub location: [f32; LOCATION],
}

impl Detection {
    /// A detection of an object that is completely visible as far as is known.
    pub const fn whole(id: u32, location: [f32; LOCATION]) -> Self {
        let [x1, y1, x2, y2, _] = location;
        Self {
            id,
            visible: [x1, y1, x2, y2],
            location,
        }
    }
}

/// The image that a scene is made from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Stamp {
    /// Sequence number: increases with each scene.
    pub sequence: u64,
    /// When the image was taken, nanoseconds on the publisher's clock.
    pub timestamp_ns: u64,
}

/// Makes a scene from an image; each [`ObservationTask::poll`] encodes one crop. An object that a nearer one
/// covers in part has two: its colour is told from what is [`uncovered`]. All state between
/// calls is in here; one call needs about 16 KiB of stack.
///
/// ```
/// use core::task::Poll;
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/observed/mod.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use nsrm_core::vision::{Detection, ObservationTask, RgbImage, Stamp};
/// # let (model, camera) = (&nsrm_tabletop::TABLETOP, CAMERA);
/// # let pixels = &[128; 640 * 480 * 3];
///
/// let image = RgbImage::new(pixels, camera.width, camera.height, 3 * camera.width as usize)?;
/// let detections = [Detection::whole(1, [0.25, 0.5, 0.3, 0.6, 0.9])];
/// let mut task = ObservationTask::new(model, image, camera, &detections, Stamp::default())?;
/// let scene = loop {
///     if let Poll::Ready(scene) = task.poll() {
///         break scene?;
///     }
/// };
/// assert_eq!(scene.objects().len(), 1);
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone)]
pub struct ObservationTask<'a> {
    model: &'a Model<'a>,
    image: RgbImage<'a>,
    detections: &'a [Detection],
    crop: Crop,
    /// What the next object looks like, if its colour is still to be told.
    encoded: Option<[f32; OBJECT_EMBEDDING]>,
    scene: RawScene,
}

impl<'a> ObservationTask<'a> {
    /// Starts a task; refuses a model without vision, an image of another size than the camera's and
    /// more than [`MAX_OBJECTS`] detections.
    pub fn new(
        model: &'a Model<'a>,
        image: RgbImage<'a>,
        camera: Camera,
        detections: &'a [Detection],
        stamp: Stamp,
    ) -> Result<Self, SceneError> {
        if model.vision.is_none() {
            return Err(SceneError::NoVision);
        }
        let (expected, got) = (
            [camera.width, camera.height],
            [image.width(), image.height()],
        );
        if expected != got {
            return Err(SceneError::ImageSize { expected, got });
        }
        if detections.len() > MAX_OBJECTS {
            return Err(SceneError::TooManyObjects {
                count: u32::try_from(detections.len()).unwrap_or(u32::MAX),
            });
        }
        let mut scene = RawScene::empty(model, camera);
        scene.header.sequence = stamp.sequence;
        scene.header.timestamp_ns = stamp.timestamp_ns;
        Ok(Self {
            model,
            image,
            detections,
            crop: Crop::BLACK,
            encoded: None,
            scene,
        })
    }

    /// Encodes the next crop, or checks the whole scene when none is left. Once it is
    /// done, every further call returns the same result.
    ///
    /// Cost: one crop and [`super::ENCODE_MULTIPLY_ADDS`], or one [`RawScene::check`].
    pub fn poll(&mut self) -> Poll<Result<Scene, SceneError>> {
        let index = self.scene.count as usize;
        let Some(&Detection {
            id,
            visible,
            location,
        }) = self.detections.get(index)
        else {
            return self.checked();
        };
        let part = uncovered(self.detections, index);
        let bounds = part.filter(|_| self.encoded.is_some());
        if let Err(fault) = self.crop.fill(&self.image, &bounds.unwrap_or(visible)) {
            return Poll::Ready(Err(SceneError::Object {
                // Below MAX_OBJECTS.
                index: index as u8,
                id,
                fault,
            }));
        }
        let embedding = match self.encoded.take() {
            Some(mut encoded) => {
                recolor(self.model, &mut encoded, &mut self.crop);
                encoded
            }
            None => encode_in_place(self.model, &mut self.crop),
        };
        if part.is_some() && bounds.is_none() {
            self.encoded = Some(embedding);
            return Poll::Pending;
        }
        let object = ObservedObject {
            id,
            location,
            embedding,
        };
        // Never full: the number of detections was checked.
        let _ = self.scene.push(object);
        Poll::Pending
    }

    // Not inlined, so that the encoder and the copy of the scene use the same stack.
    #[inline(never)]
    fn checked(&self) -> Poll<Result<Scene, SceneError>> {
        Poll::Ready(Scene::new(self.scene, self.model))
    }

    /// [`ObservationTask::poll`] to its end.
    pub fn finish(mut self) -> Result<Scene, SceneError> {
        loop {
            if let Poll::Ready(scene) = self.poll() {
                return scene;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture;
    use crate::scene::ObjectFault;
    use crate::vision::encode;

    const DETECTIONS: [Detection; 2] = [
        Detection::whole(4, [0.0, 0.0, 0.5, 0.5, 0.8]),
        // Its upper part is hidden.
        Detection {
            id: 9,
            visible: [0.5, 0.5, 1.0, 1.0],
            location: [0.5, 0.25, 1.0, 1.0, 0.9],
        },
    ];

    #[test]
    fn a_scene_is_made_crop_by_crop() {
        let model = fixture::model();
        let pixels = std::vec![90; 400 * 200 * 3];
        let image = RgbImage::new(&pixels, 400, 200, 1200).unwrap();
        let stamp = Stamp {
            sequence: 3,
            timestamp_ns: 5,
        };
        let begin = || ObservationTask::new(&model, image, fixture::camera(), &DETECTIONS, stamp);
        let mut task = begin().unwrap();
        assert_eq!(task.poll(), Poll::Pending);
        assert_eq!(task.poll(), Poll::Pending);
        let Poll::Ready(Ok(scene)) = task.poll() else {
            panic!("two crops were encoded");
        };
        assert_eq!(task.poll(), Poll::Ready(Ok(scene)));
        assert_eq!(begin().unwrap().finish(), Ok(scene));
        assert_eq!(
            (scene.header().sequence, scene.header().timestamp_ns),
            (3, 5)
        );
        for (object, detection) in scene.objects().iter().zip(&DETECTIONS) {
            assert_eq!(
                (object.id, object.location),
                (detection.id, detection.location)
            );
            let crop = Crop::from_rgb(&image, &detection.visible).unwrap();
            assert_eq!(object.embedding, encode(&model, &crop));
        }
    }

    #[test]
    fn the_colour_of_what_is_covered_is_told_from_the_rest() {
        let model = fixture::model();
        let mut pixels = std::vec![90; 400 * 200 * 3];
        pixels[..400 * 100 * 3].fill(200);
        let image = RgbImage::new(&pixels, 400, 200, 1200).unwrap();
        let behind = Detection::whole(4, [0.25, 0.25, 0.5, 1.0, 0.8]);
        let above = Detection::whole(9, [0.25, 0.0, 0.5, 0.5, 0.7]);
        let camera = fixture::camera();
        let detections = [behind, above];
        let task = ObservationTask::new(&model, image, camera, &detections, Stamp::default());
        let mut task = task.unwrap();
        // Two crops of the first, one of the second.
        for _ in 0..3 {
            assert_eq!(task.poll(), Poll::Pending);
        }
        let Poll::Ready(Ok(scene)) = task.poll() else {
            panic!("three crops were encoded");
        };
        let crop = |bounds| Crop::from_rgb(&image, &bounds).unwrap();
        let mut expected = encode(&model, &crop(behind.visible));
        recolor(&model, &mut expected, &mut crop([0.25, 0.5, 0.5, 1.0]));
        let [first, second] = scene.objects() else {
            panic!("{scene:?}");
        };
        assert_eq!((first.id, first.location), (4, behind.location));
        assert_eq!(first.embedding, expected);
        assert_eq!(second.embedding, encode(&model, &crop(above.visible)));
    }

    #[test]
    fn what_is_no_scene_is_refused() {
        let model = fixture::model();
        let pixels = std::vec![90; 400 * 200 * 3];
        let image = RgbImage::new(&pixels, 400, 200, 1200).unwrap();
        let observe = |image, camera, detections: &[Detection]| {
            ObservationTask::new(&model, image, camera, detections, Stamp::default())?.finish()
        };
        let narrow = RgbImage::new(&pixels, 399, 200, 1200).unwrap();
        assert_eq!(
            observe(narrow, fixture::camera(), &DETECTIONS),
            Err(SceneError::ImageSize {
                expected: [400, 200],
                got: [399, 200]
            })
        );
        assert_eq!(
            observe(image, fixture::camera(), &[DETECTIONS[0]; 17]),
            Err(SceneError::TooManyObjects { count: 17 })
        );
        let fault = |index, id, fault| Err(SceneError::Object { index, id, fault });
        assert_eq!(
            observe(image, fixture::camera(), &[DETECTIONS[0]; 2]),
            fault(1, 4, ObjectFault::RepeatedId)
        );
        for is_hidden in [false, true] {
            let mut detections = DETECTIONS;
            if is_hidden {
                detections[1].location[2] = 0.5;
            } else {
                detections[1].visible[2] = 0.5;
            }
            assert_eq!(
                observe(image, fixture::camera(), &detections),
                fault(1, 9, ObjectFault::BoxNotOrdered)
            );
        }
        let blind = model.without_vision();
        let task = ObservationTask::new(&blind, image, fixture::camera(), &[], Stamp::default());
        assert_eq!(task.err(), Some(SceneError::NoVision));
        assert!(
            encode(&blind, &Crop::BLACK)
                .iter()
                .all(|value| value.is_nan())
        );
        let mut camera = fixture::camera();
        camera.fx = 0.0;
        assert!(matches!(
            observe(image, camera, &DETECTIONS),
            Err(SceneError::Camera(_))
        ));
    }
}
