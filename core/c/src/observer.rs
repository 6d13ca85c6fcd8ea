use core::ffi::c_char;
use core::task::Poll;

use nsrm_core::vision::{self, ImageError, ObservationTask, RgbImage, Stamp};
use nsrm_core::{RawScene, SceneError};

use crate::capacity::MAX_OBJECTS;
use crate::memory::Slot;
use crate::model::{self, ModelHandle};
use crate::pointers;
use crate::scene::{Camera, Detection, Scene};
use crate::status::{Status, status};
use crate::text::write_text;

/// Bytes of an observer.
pub const OBSERVER_BYTES: usize = 17_408;

/// Memory of an observer, which the caller owns; as a task's.
#[repr(C)]
#[derive(Clone, Copy)]
pub union ObserverMemory {
    /// Aligns it.
    pub alignment: u64,
    /// Its bytes.
    pub bytes: [u8; OBSERVER_BYTES],
}

// Never less than needed, and on 64 bits little more.
const _: () = {
    assert!(align_of::<Slot<Work>>() <= align_of::<ObserverMemory>());
    assert!(size_of::<Slot<Work>>() <= size_of::<ObserverMemory>());
    assert!(usize::BITS < 64 || size_of::<Slot<Work>>() + 512 > size_of::<ObserverMemory>());
};

/// An image: red, green and blue, a byte each, row by row from the top.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Image {
    /// The pixels.
    pub pixels: *const u8,
    /// Bytes that `pixels` points to.
    pub length: usize,
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Bytes from the start of one row to that of the next; at least `3 * width`.
    pub stride: usize,
}

// All in the caller's memory, of which there is enough for the largest.
#[allow(clippy::large_enum_variant)]
enum Work {
    Observing(ObservationTask<'static>),
    InvalidImage(ImageError),
    InvalidScene(SceneError),
}

/// Of no version of a scene.
const NO_SCHEMA: u32 = 0;

const fn slot(observer: *mut ObserverMemory) -> *mut Slot<Work> {
    observer.cast()
}

/// Begins to make a scene from an image and what a detector has found in it; `nsrm_observe_poll` does
/// the work.
///
/// Returns `NSRM_PENDING`, `NSRM_INVALID_INPUT` if the image or the number of detections is invalid, or
/// an error.
///
/// * `camera`: whose image it is, calibrated
/// * `detections`, `count`: at most `NSRM_MAX_OBJECTS`
/// * `sequence`: increases with each scene
/// * `timestamp_ns`: when the image was taken, nanoseconds
///
/// The model, the pixels and the detections must stay where they are, unchanged, until it is done.
///
/// # Safety
/// Each pointer is null or valid, and points to as much as it says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nsrm_observe_begin(
    observer: *mut ObserverMemory,
    model: *const ModelHandle,
    image: *const Image,
    camera: *const Camera,
    detections: *const Detection,
    count: usize,
    sequence: u64,
    timestamp_ns: u64,
) -> Status {
    let mut first = Status::Pending;
    // SAFETY: the caller's promises.
    let begun = unsafe {
        Slot::begin(slot(observer), || {
            let model = model::model(model)?;
            let image = pointers::read(image)?;
            let camera = (*pointers::read(camera)?).into();
            if count > MAX_OBJECTS {
                return Err(Status::ErrorTooLarge);
            }
            // The same bytes.
            let detections = pointers::array(detections.cast::<vision::Detection>(), count)?;
            let pixels = pointers::array(image.pixels, image.length)?;
            let image = match RgbImage::new(pixels, image.width, image.height, image.stride) {
                Ok(image) => image,
                Err(error) => {
                    first = Status::InvalidInput;
                    return Ok(Work::InvalidImage(error));
                }
            };
            let stamp = Stamp {
                sequence,
                timestamp_ns,
            };
            let task = ObservationTask::new(model, image, camera, detections, stamp);
            Ok(task.map_or_else(
                |error| {
                    first = Status::InvalidInput;
                    Work::InvalidScene(error)
                },
                Work::Observing,
            ))
        })
    };
    begun.err().unwrap_or(first)
}

fn advance(work: &mut Work) -> Result<Option<nsrm_core::Scene>, Status> {
    match work {
        Work::Observing(task) => match task.poll() {
            Poll::Pending => Ok(None),
            Poll::Ready(Ok(scene)) => Ok(Some(scene)),
            Poll::Ready(Err(_)) => Err(Status::InvalidInput),
        },
        _ => Err(Status::InvalidInput),
    }
}

/// Encodes one object. Returns `NSRM_PENDING` until it is done, then `NSRM_OK`, or `NSRM_INVALID_INPUT`;
/// the scene is written only with `NSRM_OK`.
///
/// # Safety
/// `observer` is null, or memory in which something was begun, or that is all zero; `scene` is null or
/// valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nsrm_observe_poll(
    observer: *mut ObserverMemory,
    scene: *mut Scene,
) -> Status {
    // SAFETY: the caller's promises.
    let polled = unsafe {
        Slot::with(slot(observer), |work| match advance(work)? {
            None => Ok(Status::Pending),
            Some(observed) => {
                pointers::write(scene.cast::<RawScene>(), *observed.raw()).map(|()| Status::Ok)
            }
        })
    };
    polled.unwrap_or_else(|error| error)
}

/// Makes a scene at once: `nsrm_observe_begin`, then `nsrm_observe_poll` to the end. Unless it returns
/// `NSRM_OK`, the scene is one that no planner accepts.
///
/// # Safety
/// As theirs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nsrm_observe(
    observer: *mut ObserverMemory,
    model: *const ModelHandle,
    image: *const Image,
    camera: *const Camera,
    detections: *const Detection,
    count: usize,
    sequence: u64,
    timestamp_ns: u64,
    scene: *mut Scene,
) -> Status {
    // SAFETY: the caller's promises.
    unsafe {
        if let Err(error) = pointers::check(scene) {
            return error;
        }
        (&raw mut (*scene).schema).write(NO_SCHEMA);
        let mut status = nsrm_observe_begin(
            observer,
            model,
            image,
            camera,
            detections,
            count,
            sequence,
            timestamp_ns,
        );
        while status == Status::Pending {
            status = nsrm_observe_poll(observer, scene);
        }
        status
    }
}

/// Why an observer has no scene, for a person; see `nsrm_refusal_message`.
///
/// # Safety
/// As `nsrm_observe_poll`'s; `buffer` points to `size` bytes, `needed` is null or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nsrm_observer_message(
    observer: *mut ObserverMemory,
    buffer: *mut c_char,
    size: usize,
    needed: *mut usize,
) -> Status {
    // SAFETY: the caller's promises.
    status(|| unsafe {
        Slot::with(slot(observer), |work| match work {
            Work::InvalidImage(error) => write_text(error, buffer, size, needed),
            Work::InvalidScene(error) => write_text(error, buffer, size, needed),
            Work::Observing(task) => match task.poll() {
                Poll::Pending => Err(Status::ErrorNotDone),
                Poll::Ready(Ok(_)) => Err(Status::ErrorNotBegun),
                Poll::Ready(Err(error)) => write_text(&error, buffer, size, needed),
            },
        })
    })
}

/// `NSRM_OBSERVER_BYTES` of the library: compare it with the header's.
#[unsafe(no_mangle)]
pub extern "C" fn nsrm_observer_bytes() -> usize {
    OBSERVER_BYTES
}
