//! The world of the trials: four blocks of an image, which are painted where they are placed.
//!
//! `scene/` was written by `cargo demo --seed 4`.

use std::io::Cursor;
use std::path::Path;

use anyhow::{Context as _, Result, ensure};
use nsrm::read_scene_text;
use nsrm_ipc::message::{CameraFrame, CameraMessage, DetectedBox};
use nsrm_tabletop::TABLETOP;

use crate::journal::Moves;

const SCENE: &[u8] = include_bytes!("../scene/scene.json");
const PICTURE: &[u8] = include_bytes!("../scene/camera.png");

/// Sentences that work whatever was said before. Only one block is moved, next to others: in this
/// world nothing falls, and occlusion is not simulated.
pub(crate) const SENTENCES: [&str; 5] = [
    "put the yellow block to the left of the red block",
    "put the yellow block to the right of the small red block",
    "put the yellow block to the left of the green block",
    "put the yellow block to the left of the green block then put the yellow block to the left of \
     the red block",
    "put the yellow block to the right of the red block then put the yellow block to the left of \
     the green block then put the yellow block to the left of the red block",
];

/// Sentences that are refused in any state of the world.
pub(crate) const REFUSED: [&str; 2] = [
    "put the purple block on the magenta block",
    "put the yellow block under the magenta block",
];

#[derive(Debug, Clone)]
struct Block {
    found: DetectedBox,
    /// `[rows][columns][3]`
    patch: Vec<u8>,
    columns: usize,
}

/// The blocks and the camera.
#[derive(Debug, Clone)]
pub(crate) struct World {
    camera: CameraMessage,
    blocks: Vec<Block>,
    /// `[height][width][3]`
    table: Vec<u8>,
}

/// Red, green and blue of the scene's image, row by row.
fn picture(width: u32, height: u32) -> Result<Vec<u8>> {
    let mut reader = png::Decoder::new(Cursor::new(PICTURE)).read_info()?;
    let mut pixels = vec![0; 3 * (width * height) as usize];
    let size = reader.output_buffer_size();
    ensure!(size == Some(pixels.len()), "another size");
    reader.next_frame(&mut pixels)?;
    Ok(pixels)
}

impl World {
    /// The initial world.
    pub(crate) fn new() -> Result<Self> {
        let scene = read_scene_text(Path::new("scene.json"), SCENE, &TABLETOP)?;
        let (width, height) = (scene.camera.width, scene.camera.height);
        let picture = picture(width, height).context("camera.png")?;
        let color = |x: usize, y: usize| -> [u8; 3] {
            let at = 3 * (y * width as usize + x);
            [picture[at], picture[at + 1], picture[at + 2]]
        };
        let blocks = scene.detections.iter().map(|detection| {
            let found = DetectedBox::whole(detection.id, detection.location);
            let [left, top, right, bottom] = pixels(&found.visible, width, height);
            let patch = (top..bottom).flat_map(|y| (left..right).map(move |x| (x, y)));
            Block {
                found,
                patch: patch.flat_map(|(x, y)| color(x, y)).collect(),
                columns: right - left,
            }
        });
        let blocks = blocks.collect();
        // The lower left corner shows the bare table.
        let table = color(0, height as usize - 1);
        Ok(Self {
            blocks,
            table: table.repeat((width * height) as usize),
            camera: scene.camera.into(),
        })
    }

    /// The world according to a journal; [`World::follow`] reads later events.
    pub(crate) fn of(journal: &Path) -> Result<(Self, Moves)> {
        let (mut world, mut moves) = (Self::new()?, Moves::of(journal)?);
        world.follow(&mut moves)?;
        Ok((world, moves))
    }

    /// Applies the moves since the last call.
    pub(crate) fn follow(&mut self, moves: &mut Moves) -> Result<()> {
        while let Some((object, location)) = moves.next()? {
            self.put(object, location);
        }
        Ok(())
    }

    /// Moves a block to a location in the image; returns whether the block exists.
    pub(crate) fn put(&mut self, object: u32, location: [f32; 5]) -> bool {
        let mut blocks = self.blocks.iter_mut();
        let Some(block) = blocks.find(|block| block.found.id == object) else {
            return false;
        };
        block.found = DetectedBox::whole(block.found.id, location);
        true
    }

    /// Bytes of a frame's image.
    pub(crate) const fn bytes(&self) -> usize {
        // As many pixels as the table has, seven bytes each.
        self.table.len() / 3 * 7
    }

    /// The header of a frame.
    pub(crate) fn header(&self, sequence: u64, timestamp_ns: u64) -> CameraFrame {
        let mut header = CameraFrame {
            sequence,
            timestamp_ns,
            camera: self.camera,
            count: self.blocks.len() as u32,
            ..CameraFrame::default()
        };
        for (place, block) in header.boxes.iter_mut().zip(&self.blocks) {
            *place = block.found;
        }
        header
    }

    /// Paints the image; only the boxes have a depth.
    pub(crate) fn paint(&self, image: &mut [u8]) {
        let CameraMessage { width, height, .. } = self.camera;
        image[..self.table.len()].copy_from_slice(&self.table);
        let mut blocks: Vec<&Block> = self.blocks.iter().collect();
        blocks.sort_by(|one, other| depth_m(other).total_cmp(&depth_m(one)));
        for block in blocks {
            let [left, top, right, bottom] = pixels(&block.found.visible, width, height);
            let rows = block.patch.len() / 3 / block.columns;
            for y in top..bottom {
                let row = (y - top) * rows / (bottom - top);
                for x in left..right {
                    let column = (x - left) * block.columns / (right - left);
                    let (from, to) = (
                        3 * (row * block.columns + column),
                        3 * (y * width as usize + x),
                    );
                    image[to..to + 3].copy_from_slice(&block.patch[from..from + 3]);
                }
            }
        }
    }
}

/// Left, top, right and bottom in pixels, inside the image and not empty.
fn depth_m(block: &Block) -> f32 {
    let [.., depth_m] = block.found.location;
    depth_m
}

fn pixels(corners: &[f32; 4], width: u32, height: u32) -> [usize; 4] {
    let [x1, y1, x2, y2] = *corners;
    let span = |from: f32, to: f32, size: u32| {
        // Not negative: `as` converts negative values to 0.
        let from = ((from * size as f32).round() as usize).min(size as usize - 1);
        let to = ((to * size as f32).round() as usize).clamp(from + 1, size as usize);
        (from, to)
    };
    let ((left, right), (top, bottom)) = (span(x1, x2, width), span(y1, y2, height));
    [left, top, right, bottom]
}
