// A table as a camera sees it, for examples and documentation: four blocks and their boxes. A robot
// has a camera and a detector instead.

use nsrm_core::vision::{Detection, ObservationTask, RgbImage, Stamp};
use nsrm_core::{Camera, Model, Scene};

/// Beyond the table, looking down at it and back at the robot.
pub(crate) const CAMERA: Camera = Camera {
    width: 640,
    height: 480,
    fx: 936.0,
    fy: 936.0,
    cx: 320.0,
    cy: 240.0,
    position: [1.3, 0.0, 0.8], // world frame, metres
    orientation: [0.6395828, 0.6395828, -0.30155238, -0.30155238], // x, y, z, w
};

/// Corners x1, y1, x2, y2 in pixels and mean depth in metres of a small green block, a magenta lego
/// block, a small yellow block and a small red one: objects 1 to 4.
const BOXES: [([u32; 4], f32); 4] = [
    ([421, 287, 465, 338], 1.1078603),
    ([482, 258, 542, 320], 1.1306365),
    ([398, 254, 438, 301], 1.1561292),
    ([212, 308, 254, 359], 1.0804999),
];

/// The pixels of the boxes, one box after the other, from `tests/trials/scene/camera.png`.
const PIXELS: &[u8] = include_bytes!("blocks.rgb");

pub(crate) fn scene(model: &Model<'_>) -> Scene {
    let (width, height) = (CAMERA.width, CAMERA.height);
    let stride = 3 * width as usize;
    let mut image = vec![128; stride * height as usize];
    let mut rest = PIXELS;
    let mut detections = Vec::new();
    for (id, ([x1, y1, x2, y2], depth_m)) in (1..).zip(BOXES) {
        let row_bytes = 3 * (x2 - x1) as usize;
        for row in y1..y2 {
            let (pixels, behind) = rest.split_at(row_bytes);
            let first = row as usize * stride + 3 * x1 as usize;
            image[first..][..row_bytes].copy_from_slice(pixels);
            rest = behind;
        }
        let across = |pixel: u32| pixel as f32 / width as f32;
        let down = |pixel: u32| pixel as f32 / height as f32;
        let location = [across(x1), down(y1), across(x2), down(y2), depth_m];
        detections.push(Detection::whole(id, location));
    }
    let image = RgbImage::new(&image, width, height, stride).expect("an image");
    ObservationTask::new(model, image, CAMERA, &detections, Stamp::default())
        .and_then(ObservationTask::finish)
        .expect("a scene in order")
}
