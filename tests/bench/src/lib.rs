//! The jobs whose time and instructions are measured: a table with six blocks, and sentences of one,
//! three and eight steps about them.

pub mod call_graph;
pub mod callgrind;
pub mod firmware;
pub mod growth;

use std::hint::black_box;
use std::io::Cursor;
use std::path::Path;

use nsrm::read_scene_text;
use nsrm_core::vision::{Crop, Detection, ObservationTask, RgbImage, Stamp, encode};
use nsrm_core::{Camera, Model, Planner, Scene};
use nsrm_tabletop::TABLETOP;

/// Written by `cargo demo --seed 7`.
const SCENE: &[u8] = include_bytes!("../scene/scene.json");
const PICTURE: &[u8] = include_bytes!("../scene/camera.png");

/// Twelve tokens.
pub const ONE_STEP: &str = "now put the blue block to the left of the small yellow block";
/// Three steps.
pub const THREE_STEPS: &str = "put the blue block to the left of the small yellow block, then put \
    the magenta block on the blue block, then put the small yellow block on the yellow lego block";
/// The most steps of a sentence.
pub const EIGHT_STEPS: &str = "put the blue block to the left of the small yellow block, then put \
    the magenta block on the blue block, then put the small yellow block on the yellow lego block, \
    then put the magenta block to the left of the small yellow block, then put the blue block to \
    the right of the yellow lego block, then put the blue block to the left of the small yellow \
    block, then put the magenta block on the blue block, then put the magenta block to the left of \
    the small yellow block";

/// A job; see [`Table::run`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Job {
    /// A plan of [`ONE_STEP`].
    PlanOneStep,
    /// A plan of [`THREE_STEPS`].
    PlanThreeSteps,
    /// A plan of [`EIGHT_STEPS`].
    PlanEightSteps,
    /// The program of [`ONE_STEP`].
    ParseOneStep,
    /// One crop out of the image.
    CutCrop,
    /// One crop's embedding.
    EncodeCrop,
    /// From the image to the scene of six objects.
    ObserveSixObjects,
}

impl Job {
    /// All jobs.
    pub const ALL: [Self; 7] = [
        Self::PlanOneStep,
        Self::PlanThreeSteps,
        Self::PlanEightSteps,
        Self::ParseOneStep,
        Self::CutCrop,
        Self::EncodeCrop,
        Self::ObserveSixObjects,
    ];

    /// Its name in tables and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::PlanOneStep => "plan-1-step",
            Self::PlanThreeSteps => "plan-3-steps",
            Self::PlanEightSteps => "plan-8-steps",
            Self::ParseOneStep => "parse-1-step",
            Self::CutCrop => "cut-crop",
            Self::EncodeCrop => "encode-crop",
            Self::ObserveSixObjects => "observe-6-objects",
        }
    }
}

/// What a camera sees, and what was made of it.
#[derive(Debug)]
pub struct Table {
    model: &'static Model<'static>,
    pixels: Vec<u8>,
    camera: Camera,
    detections: Vec<Detection>,
    scene: Scene,
    crop: Crop,
}

impl Table {
    /// The table with six blocks, as the built-in model sees it.
    ///
    /// # Panics
    /// If the committed scene is not in order.
    pub fn new() -> Self {
        Self::of(&TABLETOP)
    }

    /// The same of another model of its domain.
    ///
    /// # Panics
    /// If the committed scene is not in order.
    pub fn of(model: &'static Model<'static>) -> Self {
        let file = read_scene_text(Path::new("scene.json"), SCENE, model).expect("scene.json");
        let mut reader = png::Decoder::new(Cursor::new(PICTURE))
            .read_info()
            .expect("camera.png");
        let (width, height) = (file.camera.width, file.camera.height);
        let mut pixels = vec![0; 3 * (width * height) as usize];
        reader.next_frame(&mut pixels).expect("camera.png");
        let image = image(&pixels, &file.camera);
        let scene = observe(model, image, file.camera, &file.detections);
        let crop = Crop::from_rgb(&image, &file.detections[0].visible).expect("a crop");
        Self {
            model,
            pixels,
            camera: file.camera,
            detections: file.detections,
            scene,
            crop,
        }
    }

    /// The model that sees it.
    pub const fn model(&self) -> &'static Model<'static> {
        self.model
    }

    /// The scene of six objects.
    pub const fn scene(&self) -> &Scene {
        &self.scene
    }

    /// What the firmware reads; see `tests/firmware/src/input.rs`.
    pub(crate) fn firmware_input(&self, has_vision: bool, sentences: &[&str]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let put = |bytes: &mut Vec<u8>, numbers: &[f32]| {
            bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
        };
        let raw = self.scene.raw();
        let camera = |bytes: &mut Vec<u8>| {
            let camera = &self.camera;
            bytes.extend([camera.width, camera.height].map(u32::to_le_bytes).concat());
            put(bytes, &[camera.fx, camera.fy, camera.cx, camera.cy]);
            put(bytes, &camera.position);
            put(bytes, &camera.orientation);
        };
        if has_vision {
            camera(&mut bytes);
            bytes.extend((self.detections.len() as u32).to_le_bytes());
            for detection in &self.detections {
                bytes.extend(detection.id.to_le_bytes());
                put(&mut bytes, &detection.visible);
                put(&mut bytes, &detection.location);
            }
            bytes.extend(&self.pixels);
        } else {
            let header = &raw.header;
            bytes.extend([header.schema, header.frame].map(u32::to_le_bytes).concat());
            let numbers = [header.model_tag, header.sequence, header.timestamp_ns];
            bytes.extend(numbers.map(u64::to_le_bytes).concat());
            camera(&mut bytes);
            bytes.extend(raw.count.to_le_bytes());
            for object in &raw.objects {
                bytes.extend(object.id.to_le_bytes());
                put(&mut bytes, &object.location);
                put(&mut bytes, &object.embedding);
            }
        }
        bytes.extend((sentences.len() as u32).to_le_bytes());
        for sentence in sentences {
            bytes.extend((sentence.len() as u32).to_le_bytes());
            bytes.extend(sentence.as_bytes());
        }
        bytes
    }

    /// Does a job once.
    ///
    /// # Panics
    /// If a sentence is refused.
    #[inline(never)]
    pub fn run(&self, job: Job) {
        let planner = Planner::new(black_box(self.model));
        let plan = |sentence: &str| {
            let plan = planner.plan(black_box(&self.scene), black_box(sentence));
            black_box(plan.expect("a plan"));
        };
        let image = image(&self.pixels, &self.camera);
        match job {
            Job::PlanOneStep => plan(ONE_STEP),
            Job::PlanThreeSteps => plan(THREE_STEPS),
            Job::PlanEightSteps => plan(EIGHT_STEPS),
            Job::ParseOneStep => {
                black_box(planner.parse(black_box(ONE_STEP)).expect("a program"));
            }
            Job::CutCrop => {
                let bounds = &self.detections[0].visible;
                black_box(Crop::from_rgb(black_box(&image), bounds).expect("a crop"));
            }
            Job::EncodeCrop => {
                black_box(encode(self.model, black_box(&self.crop)));
            }
            Job::ObserveSixObjects => {
                let image = black_box(image);
                black_box(observe(self.model, image, self.camera, &self.detections));
            }
        }
    }
}

impl Default for Table {
    fn default() -> Self {
        Self::new()
    }
}

fn image<'a>(pixels: &'a [u8], camera: &Camera) -> RgbImage<'a> {
    let stride = 3 * camera.width as usize;
    RgbImage::new(pixels, camera.width, camera.height, stride).expect("an image")
}

fn observe(
    model: &Model<'_>,
    image: RgbImage<'_>,
    camera: Camera,
    detections: &[Detection],
) -> Scene {
    ObservationTask::new(model, image, camera, detections, Stamp::default())
        .and_then(ObservationTask::finish)
        .expect("a scene in order")
}
