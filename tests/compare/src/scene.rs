use std::io::Cursor;

use anyhow::{Context as _, Result};
use nsrm_core::language::{Reader, Token};
use nsrm_core::vision::{Crop, Detection, ObservationTask, RgbImage, Stamp};
use nsrm_core::{Camera, Scene};
use nsrm_tabletop::TABLETOP;
use serde::Deserialize;

/// The table of `nsrm-bench`, whose package would turn on wide vectors for all contenders.
const SCENE: &[u8] = include_bytes!("../../bench/scene/scene.json");
const PICTURE: &[u8] = include_bytes!("../../bench/scene/camera.png");

/// Twelve tokens; the sentence of one step of `nsrm-bench`.
pub const ONE_STEP: &str = "now put the blue block to the left of the small yellow block";

/// A table with six blocks, and [`ONE_STEP`] about it.
#[derive(Debug, Clone)]
pub struct Table {
    /// What was observed.
    pub scene: Scene,
    /// The picture of each object.
    pub crops: Vec<Crop>,
    /// The sentence.
    pub tokens: Vec<Token>,
}

/// The part of a scene file that is used here.
#[derive(Deserialize)]
struct SceneFile {
    camera: CameraEntry,
    objects: Vec<ObjectEntry>,
}

#[derive(Deserialize)]
struct CameraEntry {
    width: u32,
    height: u32,
    fx: f32,
    fy: f32,
    cx: f32,
    cy: f32,
    position: [f32; 3],
    orientation: [f32; 4],
}

#[derive(Deserialize)]
struct ObjectEntry {
    id: u32,
    #[serde(rename = "box")]
    corners: [f32; 4],
    depth: f32,
}

impl Table {
    /// From the committed files.
    pub fn new() -> Result<Self> {
        let file: SceneFile = serde_json::from_slice(SCENE).context("scene.json")?;
        let camera = file.camera.camera();
        let mut reader = png::Decoder::new(Cursor::new(PICTURE)).read_info()?;
        let stride = 3 * camera.width as usize;
        let mut pixels = vec![0; stride * camera.height as usize];
        reader.next_frame(&mut pixels).context("camera.png")?;
        let image = RgbImage::new(&pixels, camera.width, camera.height, stride)?;
        let detections: Vec<Detection> = file.objects.iter().map(ObjectEntry::detection).collect();
        let scene = ObservationTask::new(&TABLETOP, image, camera, &detections, Stamp::default())
            .and_then(ObservationTask::finish)?;
        let crops = detections
            .iter()
            .map(|detection| Crop::from_rgb(&image, &detection.visible));
        let crops = crops.collect::<Result<_, _>>()?;
        let mut reader = Reader::new(ONE_STEP)?;
        while reader.advance(&TABLETOP, ONE_STEP)? {}
        Ok(Self {
            scene,
            crops,
            tokens: reader.tokens().to_vec(),
        })
    }
}

impl CameraEntry {
    fn camera(&self) -> Camera {
        Camera {
            width: self.width,
            height: self.height,
            fx: self.fx,
            fy: self.fy,
            cx: self.cx,
            cy: self.cy,
            position: self.position,
            orientation: self.orientation,
        }
    }
}

impl ObjectEntry {
    fn detection(&self) -> Detection {
        let [x1, y1, x2, y2] = self.corners;
        Detection::whole(self.id, [x1, y1, x2, y2, self.depth])
    }
}
