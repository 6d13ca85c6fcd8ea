//! From a frame to a scene, as perception makes it.

use heapless::Vec;
use nsrm_core::vision::{Detection, ImageError, ObservationTask, RgbImage, Stamp};
use nsrm_core::{MAX_OBJECTS, Model, SceneError};
use thiserror::Error;

use crate::message::{CameraFrame, CameraFrameError, SceneMessage};

/// Why a frame gives no scene.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum FrameFault {
    /// Invalid frame.
    #[error("{0}")]
    Frame(CameraFrameError),
    /// Invalid image.
    #[error("{0}")]
    Image(ImageError),
    /// Invalid detections.
    #[error("{0}")]
    Scene(SceneError),
}

/// The scene in a frame.
///
/// ```
/// use nsrm_ipc::message::CameraFrame;
/// use nsrm_ipc::node::{FrameFault, see};
/// use nsrm_tabletop::TABLETOP;
///
/// // A frame of another process is only used if all of it is valid.
/// let header = CameraFrame::default();
/// let fault = see(&TABLETOP, &header, &[]).unwrap_err();
/// assert!(matches!(fault, FrameFault::Frame(_)), "{fault}");
/// ```
///
/// * `image`: the bytes after the frame's header; only those of the crops are read
pub fn see(
    model: &Model<'_>,
    header: &CameraFrame,
    image: &[u8],
) -> Result<SceneMessage, FrameFault> {
    let frame = header.read(image).map_err(FrameFault::Frame)?;
    let camera = frame.camera;
    let stride = frame.rgb.len() / camera.height.max(1) as usize;
    let image = RgbImage::new(frame.rgb, camera.width, camera.height, stride);
    let image = image.map_err(FrameFault::Image)?;
    let mut detections: Vec<Detection, MAX_OBJECTS> = Vec::new();
    for found in frame.boxes {
        // It has as many places as a frame has boxes.
        let _ = detections.push(Detection {
            id: found.id,
            visible: found.visible,
            location: found.location,
        });
    }
    let stamp = Stamp {
        sequence: header.sequence,
        timestamp_ns: header.timestamp_ns,
    };
    ObservationTask::new(model, image, camera, &detections, stamp)
        .and_then(ObservationTask::finish)
        .map(|scene| SceneMessage::from(&scene))
        .map_err(FrameFault::Scene)
}
