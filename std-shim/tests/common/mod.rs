//! A model designed by hand, a scene that it understands, and the command.
//!
//! The tests must not depend on what the committed model has learned, so only the names and shapes
//! are taken from its file. In the designed model the first group of concept words describes the
//! object to move, the second the reference; "right" and "left" select the action, otherwise it is
//! `MoveOn`; a step begins at "then". An object has the colour with the greatest share in its mean
//! colour; all objects are small. The sub-goal of an object is the place of its reference. The
//! camera looks down on the table; objects are cubes of 4 cm, seen at the depth of their centres.

// Not every test has processes.
#[allow(dead_code)]
#[cfg(feature = "command")]
pub(crate) mod stage;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use nsrm_codegen::{ModelError, OwnedModel};
use nsrm_tests::picture::write_png;
use serde_json::{Value, json};

/// A model file as names, shapes and values.
pub(crate) struct ModelFile {
    pub(crate) metadata: BTreeMap<String, String>,
    tensors: BTreeMap<String, (Vec<usize>, Vec<f32>)>,
}

/// Path of the committed model.
pub(crate) fn pretrained() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../weights-codegen/tabletop/tabletop.safetensors")
}

impl ModelFile {
    /// The committed model's domain and shapes, all values zero.
    fn blank() -> Self {
        let bytes = std::fs::read(pretrained()).expect("the committed model");
        let (length, rest) = bytes.split_first_chunk().expect("a header");
        let header = &rest[..u64::from_le_bytes(*length) as usize];
        let mut header: BTreeMap<String, Value> = serde_json::from_slice(header).expect("JSON");
        let metadata = header.remove("__metadata__").expect("metadata");
        let tensors = header.into_iter().map(|(name, entry)| {
            let shape: Vec<usize> =
                serde_json::from_value(entry["shape"].clone()).expect("a shape");
            let count = shape.iter().product();
            (name, (shape, vec![0.0; count]))
        });
        let mut file = Self {
            tensors: tensors.collect(),
            metadata: serde_json::from_value(metadata).expect("strings"),
        };
        file.metadata.remove("hash");
        file
    }

    /// The model that this module's documentation describes.
    pub(crate) fn designed() -> Self {
        let mut file = Self::blank();
        let vocabulary: Vec<String> =
            serde_json::from_str(&file.metadata["vocabulary"]).expect("words");
        // Embeddings: each meaning has its own element.
        for (row, word) in vocabulary.iter().enumerate() {
            let place = match word.as_str() {
                "[[X]]" => 0,
                "right" => 1,
                "left" => 2,
                _ => 3,
            };
            file.set("language.embedding.weight", &[row, place], 1.0);
            if word == "then" {
                file.set("language.splitter.embedding.weight", &[row, 0], 1.0);
            }
        }
        // Hidden unit `u` moves half of the way to 1 at a word with element `u`, and keeps its value
        // at all others: unit 0 counts the groups so far, 0.5, 0.75, …
        let cell = "language.encoder.forward.weight_ih";
        for unit in 0..3 {
            file.set(cell, &[96 + unit, unit], 10.0);
            for place in (0..4).filter(|&place| place != unit) {
                file.set(cell, &[48 + unit, place], 30.0);
            }
        }
        file.set("language.object_decoder.bias", &[0], -100.0);
        file.set("language.reference_decoder.bias", &[0], 100.0);
        file.set("language.acceptability.output.bias", &[0], 20.0);
        file.set("language.action_decoder.bias", &[0], 20.0);
        file.fill("language.relation_decoder.bias", -20.0);
        file.set("language.action_decoder.weight", &[1, 1], 100.0);
        file.set("language.action_decoder.weight", &[2, 2], 100.0);
        file.set("language.splitter.hidden.weight", &[0, 32], 10.0);
        file.set("language.splitter.hazard.weight", &[0, 0], 40.0);
        file.set("language.splitter.hazard.bias", &[0], -20.0);
        file.set_vision();
        file.fill("action.simulator.location_scale", 1.0);
        for row in 0..3 {
            file.set("camera.weight", &[row, row], 1.0);
        }
        file.set_json("thresholds", json!({"match_score": 0.75, "decision": 0.5}));
        let (min, max) = ([-9.0, -9.0, 0.0], [9.0, 9.0, 9.0]);
        file.set_json("work_space", json!({"min": min, "max": max}));
        file.set_json("training_camera", scene()["camera"].clone());
        file
    }

    /// Mean red, green and blue of the colour view, minus their mean, in the concept space.
    fn set_vision(&mut self) {
        for channel in 0..3 {
            for pixel in 0..16 {
                let (row, column) = (pixel / 4, pixel % 4);
                let place = [channel, channel, row, column];
                self.set("vision.color.patch.weight", &place, 1.0 / 16.0);
                self.set(
                    "vision.color.dense.weight",
                    &[channel, 16 * channel + pixel],
                    1.0 / 16.0,
                );
            }
            // The view has 0.5 subtracted, and the output must not be negative.
            self.set("vision.color.patch.bias", &[channel], 0.5);
            for pixel in 0..4 {
                let place = [channel, channel, pixel / 2, pixel % 2];
                self.set("vision.color.merge.weight", &place, 0.25);
            }
            self.set(
                "vision.operator.color.hidden.weight",
                &[channel, channel],
                1.0,
            );
            for row in 0..3 {
                let share = if row == channel { 2.0 } else { -1.0 };
                self.set(
                    "vision.operator.color.output.weight",
                    &[row, channel],
                    share,
                );
                // red, green and blue are the first three concepts.
                self.set("vision.concept.weight", &[channel, row], share);
            }
        }
        // The other colours have directions that no object has.
        for concept in 3..7 {
            self.set("vision.concept.weight", &[concept, concept], 1.0);
        }
        // lego, small.
        self.set("vision.concept.weight", &[7, 1], 1.0);
        self.set("vision.concept.weight", &[8, 0], 1.0);
        self.set("vision.operator.size.output.bias", &[0], 1.0);
    }

    pub(crate) fn set_json(&mut self, key: &str, value: Value) {
        self.metadata.insert(key.into(), value.to_string());
    }

    pub(crate) fn set(&mut self, name: &str, place: &[usize], value: f32) {
        let (shape, values) = self.tensors.get_mut(name).expect("a tensor");
        assert_eq!(shape.len(), place.len(), "{name}");
        let index = place.iter().zip(&*shape).fold(0, |index, (place, length)| {
            assert!(place < length, "{name}");
            index * length + place
        });
        values[index] = value;
    }

    pub(crate) fn fill(&mut self, name: &str, value: f32) {
        self.tensors.get_mut(name).expect("a tensor").1.fill(value);
    }

    /// The file, with the hash that the loader expects.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        let file = self.with_hash(&"0".repeat(64));
        match OwnedModel::from_bytes(&file) {
            Err(ModelError::Hash { got, .. }) => self.with_hash(&got),
            other => panic!("a hash of zeros: {other:?}"),
        }
    }

    fn with_hash(&self, hash: &str) -> Vec<u8> {
        let mut content: Vec<u8> = Vec::new();
        let mut header = serde_json::Map::new();
        for (name, (shape, values)) in &self.tensors {
            let start = content.len();
            content.extend(values.iter().flat_map(|value| value.to_le_bytes()));
            let offsets = [start, content.len()];
            let entry = json!({"dtype": "F32", "shape": shape, "data_offsets": offsets});
            header.insert(name.clone(), entry);
        }
        let mut metadata = self.metadata.clone();
        metadata.insert("hash".into(), hash.into());
        header.insert("__metadata__".into(), json!(metadata));
        let header = Value::Object(header).to_string();
        let mut file = (header.len() as u64).to_le_bytes().to_vec();
        file.extend(header.bytes());
        file.extend(content);
        file
    }
}

/// A folder with a designed model and a scene: a red object (id 1), two green ones
/// (2, 5) and a blue one (3).
pub(crate) struct Bench {
    pub(crate) folder: tempfile::TempDir,
}

/// Box corners of the objects in pixels, with ids and colours.
const OBJECTS: [(u32, [u32; 4], [u8; 3]); 4] = [
    (1, [64, 120, 96, 144], [200, 20, 20]),
    (2, [320, 240, 352, 264], [20, 180, 20]),
    (3, [480, 360, 512, 384], [20, 20, 200]),
    (5, [160, 240, 192, 264], [30, 190, 30]),
];
/// Of the camera: image right is the world's −y, image down its −x.
pub(crate) const POSITION: [f32; 3] = [0.5, 0.0, DEPTH_M + 0.02];
pub(crate) const ORIENTATION: [f32; 4] = {
    let half = std::f32::consts::FRAC_1_SQRT_2;
    [half, -half, 0.0, 0.0]
};
/// At which a box of 32 pixels is 4 cm wide.
pub(crate) const DEPTH_M: f32 = 0.625;
const WIDTH: u32 = 640;
const HEIGHT: u32 = 480;

/// The scene file; its image is `initial.png`.
pub(crate) fn scene() -> Value {
    let objects = OBJECTS.map(|(id, [x1, y1, x2, y2], _)| {
        let (width, height) = (f64::from(WIDTH), f64::from(HEIGHT));
        let corners = [
            f64::from(x1) / width,
            f64::from(y1) / height,
            f64::from(x2) / width,
            f64::from(y2) / height,
        ];
        json!({"id": id, "box": corners, "depth": DEPTH_M})
    });
    json!({
        "schema": 1,
        "camera": {
            "width": WIDTH, "height": HEIGHT, "fx": 500.0, "fy": 500.0, "cx": 320.0, "cy": 240.0,
            "position": POSITION, "orientation": ORIENTATION,
        },
        "image": "initial.png",
        "objects": objects,
    })
}

impl Bench {
    pub(crate) fn new() -> Self {
        Self::with(&ModelFile::designed())
    }

    pub(crate) fn with(model: &ModelFile) -> Self {
        let bench = Self {
            folder: tempfile::tempdir().expect("a folder"),
        };
        bench.write("model.safetensors", model.bytes());
        bench.write("scene.json", scene().to_string());
        let mut image = [120, 110, 100].repeat((WIDTH * HEIGHT) as usize);
        std::fs::create_dir(bench.path("crops")).expect("a folder");
        for (id, [x1, y1, x2, y2], color) in OBJECTS {
            let [width, height] = [x2 - x1, y2 - y1];
            for y in y1..y2 {
                let begin = 3 * (y * WIDTH + x1) as usize;
                let row = &mut image[begin..begin + 3 * width as usize];
                row.copy_from_slice(&color.repeat(width as usize));
            }
            let crop = color.repeat((width * height) as usize);
            write_png(
                &bench.path(&format!("crops/{id}.png")),
                [width, height],
                &crop,
            );
        }
        write_png(&bench.path("initial.png"), [WIDTH, HEIGHT], &image);
        bench
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).expect("a file");
    }

    /// Runs `nsrm` in the folder.
    pub(crate) fn run(&self, arguments: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_nsrm"))
            .current_dir(self.folder.path())
            .args(arguments)
            .output()
            .expect("the command starts")
    }

    /// `nsrm plan` with the designed model on `scene.json`.
    pub(crate) fn plan(&self, sentence: &str, options: &[&str]) -> Output {
        let mut arguments = vec![
            "plan",
            "--scene",
            "scene.json",
            "--model",
            "model.safetensors",
        ];
        arguments.extend(options);
        arguments.extend(["--", sentence]);
        self.run(&arguments)
    }
}

/// What it printed, when it succeeded.
#[track_caller]
pub(crate) fn done(output: &Output) -> String {
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{message}");
    assert_eq!(message, "");
    String::from_utf8(output.stdout.clone()).expect("text")
}

/// Exit code 2 and one line on stderr that holds `parts`; what it printed, as JSON.
#[track_caller]
pub(crate) fn refused(output: &Output, parts: &[&str]) -> Value {
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert_eq!(message.trim_end().lines().count(), 1, "{message}");
    assert!(message.starts_with("nsrm: "), "{message}");
    for part in parts {
        assert!(message.contains(part), "{message:?} lacks {part:?}");
    }
    serde_json::from_slice(&output.stdout).unwrap_or_default()
}
