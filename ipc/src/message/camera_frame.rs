//! What a camera publishes: an RGB-D image with a detector's boxes.

#[cfg(feature = "processes")]
use iceoryx2::prelude::ZeroCopySend;
use nsrm_core::MAX_OBJECTS;
use nsrm_core::camera::{Camera, CameraError};
use thiserror::Error;

use super::layout::message;
use super::scene::CameraMessage;

message! {
    /// An object that a detector has found in an image.
    #[derive(Default)]
    "nsrm.v1.DetectedBox.a804d86f803d6e69"
    pub struct DetectedBox {
        /// Id of the object, the same in all frames; not zero.
        pub id: u32,
        /// 0 if it is completely visible, 1 if others are known to hide part of it, 2 if they hide
        /// all of it: it then keeps its earlier appearance, and without one it is left out.
        pub covered: u32,
        /// Corners x1, y1, x2, y2 of the box around its visible part, as fractions of the image's
        /// width and height.
        pub visible: [f32; 4],
        /// Corners of the box around the whole object, including hidden parts as far as they are
        /// known, then the mean depth of its pixels along the optical axis, metres.
        pub location: [f32; 5],
    }
}

impl DetectedBox {
    /// [`DetectedBox::covered`] of a hidden object.
    pub const HIDDEN: u32 = 2;

    /// A box of an object that is completely visible as far as is known.
    pub const fn whole(id: u32, location: [f32; 5]) -> Self {
        let [x1, y1, x2, y2, _] = location;
        Self {
            id,
            covered: 0,
            visible: [x1, y1, x2, y2],
            location,
        }
    }
}

message! {
    /// Header of a frame (service `camera`); the bytes of the image follow as a slice: first the
    /// RGB rows, then the depth rows, both without gaps.
    ///
    /// RGB: three bytes per pixel. Depth: one little-endian `f32` per pixel, metres along the
    /// optical axis, 0 for no measurement.
    #[derive(Default)]
    "nsrm.v1.CameraFrame.5791200141f197a9"
    pub struct CameraFrame {
        /// Sequence number: increases with each frame of one publisher.
        pub sequence: u64,
        /// When the image was taken, nanoseconds on the publisher's clock.
        pub timestamp_ns: u64,
        /// The camera.
        pub camera: CameraMessage,
        /// The number of valid entries in `boxes`.
        pub count: u32,
        /// The detections.
        pub boxes: [DetectedBox; MAX_OBJECTS],
    }
}

/// A checked frame, with its image in place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame<'a> {
    /// The camera.
    pub camera: Camera,
    /// `[height][width][3]`, red, green, blue.
    pub rgb: &'a [u8],
    /// `[height][width]` little-endian `f32`, metres.
    pub depth: &'a [u8],
    /// The detections; their numbers are checked with the scene.
    pub boxes: &'a [DetectedBox],
}

/// Why a camera frame is invalid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum CameraFrameError {
    /// Invalid camera.
    #[error("camera frame: {0}")]
    Camera(CameraError),
    /// More boxes than a scene holds.
    #[error("camera frame: {count} boxes; at most {MAX_OBJECTS} are allowed")]
    TooManyBoxes {
        /// The number in the frame.
        count: u32,
    },
    /// The length of the slice does not match width and height.
    #[error("camera frame: the image has {got} bytes; its width and height need {expected}")]
    ImageLength {
        /// Bytes of RGB and depth for the camera's image size.
        expected: u64,
        /// Bytes of the slice.
        got: u64,
    },
}

impl From<CameraError> for CameraFrameError {
    fn from(error: CameraError) -> Self {
        Self::Camera(error)
    }
}

impl CameraFrame {
    /// Checks the frame; `image` is its slice.
    ///
    /// ```
    /// use nsrm_core::camera::CameraError;
    /// use nsrm_ipc::message::{CameraFrame, CameraFrameError};
    ///
    /// // Nobody has filled in the camera.
    /// let fault = CameraFrame::default().read(&[]).unwrap_err();
    /// assert_eq!(fault, CameraFrameError::Camera(CameraError::NotPositive("width")));
    /// ```
    pub fn read<'a>(&'a self, image: &'a [u8]) -> Result<Frame<'a>, CameraFrameError> {
        let camera = Camera::from(self.camera);
        camera.check()?;
        let boxes = usize::try_from(self.count)
            .ok()
            .and_then(|count| self.boxes.get(..count))
            .ok_or(CameraFrameError::TooManyBoxes { count: self.count })?;
        // At most 2^64: saturates, and then no slice has that length.
        let pixels = u64::from(camera.width) * u64::from(camera.height);
        let (of_rgb, expected) = (pixels.saturating_mul(3), pixels.saturating_mul(7));
        let wrong_length = CameraFrameError::ImageLength {
            expected,
            got: image.len() as u64,
        };
        if expected != image.len() as u64 {
            return Err(wrong_length);
        }
        let (rgb, depth) = usize::try_from(of_rgb)
            .ok()
            .and_then(|length| image.split_at_checked(length))
            .ok_or(wrong_length)?;
        Ok(Frame {
            camera,
            rgb,
            depth,
            boxes,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{CameraFrame, CameraFrameError, DetectedBox};
    use crate::message::CameraMessage;
    use nsrm_core::MAX_OBJECTS;

    fn frame(width: u32, height: u32) -> CameraFrame {
        CameraFrame {
            sequence: 1,
            timestamp_ns: 2,
            camera: CameraMessage {
                width,
                height,
                fx: 500.0,
                fy: 500.0,
                cx: 1.0,
                cy: 1.5,
                position: [0.0; 3],
                orientation: [0.0, 0.0, 0.0, 1.0],
            },
            count: 1,
            boxes: [DetectedBox::whole(1, [0.1, 0.2, 0.3, 0.4, 1.0]); MAX_OBJECTS],
        }
    }

    #[test]
    fn colour_and_depth_lie_one_behind_the_other() {
        let image: Vec<u8> = (0..2 * 3 * 7).collect();
        let frame = frame(2, 3);
        let parts = frame.read(&image).unwrap();
        assert_eq!(parts.rgb, &image[..18]);
        assert_eq!(parts.depth, &image[18..]);
        assert_eq!(parts.boxes.len(), 1);
    }

    #[test]
    fn lengths_that_lie_are_refused() {
        let error = frame(2, 3).read(&[0; 41]).unwrap_err();
        let (expected, got) = (42, 41);
        assert_eq!(error, CameraFrameError::ImageLength { expected, got });
        assert!(frame(u32::MAX, u32::MAX).read(&[0; 42]).is_err());
        let mut many = frame(2, 3);
        many.count = u32::MAX;
        let error = many.read(&[0; 42]).unwrap_err();
        assert_eq!(error, CameraFrameError::TooManyBoxes { count: u32::MAX });
        let mut broken = frame(2, 3);
        broken.camera.fx = f32::NAN;
        assert!(matches!(
            broken.read(&[0; 42]),
            Err(CameraFrameError::Camera(_))
        ));
    }
}
