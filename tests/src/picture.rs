//! An image of coloured squares with its boxes, unlike any image in training: for properties that
//! hold for any image.

use std::fs::File;
use std::path::Path;

use nsrm_core::Camera;
use nsrm_core::vision::Detection;
use nsrm_ipc::message::{CameraFrame, DetectedBox};

/// Width and height in pixels.
pub const SIZE: [u32; 2] = [640, 480];

/// Colours of the squares, from left to right.
const COLORS: [[u8; 3]; 5] = [
    [204, 23, 23],
    [26, 153, 41],
    [23, 51, 204],
    [204, 26, 184],
    [230, 204, 20],
];

/// Side of a square in pixels, and its depth, metres: every second one is a small block, the others
/// are lego blocks, all on the table according to the pretrained model.
const SIDES: [(u32, f32); 2] = [(40, 0.96), (28, 0.97)];

/// An image with a detector's boxes.
#[derive(Debug, Clone)]
pub struct Picture {
    /// `[height][width][3]`.
    pub pixels: Vec<u8>,
    /// One for each square, ids from 1.
    pub detections: Vec<Detection>,
}

impl Picture {
    /// The camera's message for it.
    pub fn frame(&self) -> CameraFrame {
        let mut frame = CameraFrame {
            sequence: 4,
            timestamp_ns: 5,
            camera: camera().into(),
            ..CameraFrame::default()
        };
        for (place, detection) in frame.boxes.iter_mut().zip(&self.detections) {
            *place = DetectedBox::whole(detection.id, detection.location);
            frame.count += 1;
        }
        frame
    }
}

/// A camera that looks straight down from a metre above the table.
pub fn camera() -> Camera {
    Camera {
        width: SIZE[0],
        height: SIZE[1],
        fx: 600.0,
        fy: 600.0,
        cx: 320.0,
        cy: 240.0,
        position: [0.5, 0.0, 1.0],
        orientation: [1.0, 0.0, 0.0, 0.0],
    }
}

/// The same view in an image of another size.
pub fn scaled(camera: Camera, [width, height]: [u32; 2]) -> Camera {
    let across = width as f32 / camera.width as f32;
    let down = height as f32 / camera.height as f32;
    Camera {
        width,
        height,
        fx: across * camera.fx,
        fy: down * camera.fy,
        cx: across * camera.cx,
        cy: down * camera.cy,
        ..camera
    }
}

/// The squares in a row on grey.
pub fn squares() -> Picture {
    let [width, height] = SIZE;
    let mut pixels = vec![128; (width * height * 3) as usize];
    let mut detections = Vec::new();
    for (index, color) in (0..).zip(COLORS) {
        let (side, depth) = SIDES[index as usize % 2];
        let (left, top) = (170 + 60 * index, 200);
        for row in top..top + side {
            for column in left..left + side {
                let at = ((row * width + column) * 3) as usize;
                pixels[at..at + 3].copy_from_slice(&color);
            }
        }
        let location = [
            left as f32 / width as f32,
            top as f32 / height as f32,
            (left + side) as f32 / width as f32,
            (top + side) as f32 / height as f32,
            depth,
        ];
        detections.push(Detection::whole(index + 1, location));
    }
    Picture { pixels, detections }
}

/// Writes red, green and blue of an image, row by row, as a PNG file.
pub fn write_png(path: &Path, [width, height]: [u32; 2], rgb: &[u8]) {
    let file = File::create(path).expect("a file can be made");
    let mut encoder = png::Encoder::new(file, width, height);
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header().expect("a header can be written");
    writer.write_image_data(rgb).expect("pixels can be written");
}
