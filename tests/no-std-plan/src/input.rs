//! What is read from standard input, all numbers little-endian:
//!
//! | bytes | what |
//! |---|---|
//! | 8 | width, height: `u32`, pixels |
//! | 44 | fx, fy, cx, cy, position (3), orientation (4): `f32` |
//! | 4 | number of objects: `u32` |
//! | 24 each | id: `u32`; x1, y1, x2, y2, depth: `f32` |
//! | 4 | bytes of the sentence: `u32` |
//! | so many | the sentence, UTF-8 |
//! | 3·width·height | the image, RGB |

use nsrm_core::vision::Detection;
use nsrm_core::{Camera, MAX_OBJECTS, MAX_SENTENCE_BYTES};

use crate::linux;

/// A sentence and what the camera gives.
pub struct Input<'a> {
    /// The camera.
    pub camera: Camera,
    /// Its image, three bytes a pixel.
    pub pixels: &'a [u8],
    detections: [Detection; MAX_OBJECTS],
    count: usize,
    sentence: [u8; MAX_SENTENCE_BYTES],
    sentence_length: usize,
}

impl<'a> Input<'a> {
    /// All of it, the image into `pixels`; `None` if it is not as described.
    pub fn read(pixels: &'a mut [u8]) -> Option<Self> {
        let camera = Camera {
            width: integer()?,
            height: integer()?,
            fx: number()?,
            fy: number()?,
            cx: number()?,
            cy: number()?,
            position: [number()?, number()?, number()?],
            orientation: [number()?, number()?, number()?, number()?],
        };
        let mut input = Self {
            camera,
            pixels: &[],
            detections: [Detection::whole(0, [0.0; 5]); MAX_OBJECTS],
            count: usize::try_from(integer()?).ok()?,
            sentence: [0; MAX_SENTENCE_BYTES],
            sentence_length: 0,
        };
        for detection in input.detections.get_mut(..input.count)? {
            let id = integer()?;
            let mut location = [0.0; 5];
            for value in &mut location {
                *value = number()?;
            }
            *detection = Detection::whole(id, location);
        }
        input.sentence_length = usize::try_from(integer()?).ok()?;
        fill(input.sentence.get_mut(..input.sentence_length)?)?;
        let bytes = u64::from(camera.width)
            .checked_mul(camera.height.into())?
            .checked_mul(3)?;
        let image = pixels.get_mut(..usize::try_from(bytes).ok()?)?;
        fill(image)?;
        input.pixels = image;
        Some(input)
    }

    /// What a detector found.
    pub fn detections(&self) -> &[Detection] {
        self.detections.get(..self.count).unwrap_or_default()
    }

    /// The sentence; empty if it is not UTF-8.
    pub fn sentence(&self) -> &str {
        let bytes = self.sentence.get(..self.sentence_length);
        core::str::from_utf8(bytes.unwrap_or_default()).unwrap_or_default()
    }
}

fn integer() -> Option<u32> {
    let mut bytes = [0; 4];
    fill(&mut bytes)?;
    Some(u32::from_le_bytes(bytes))
}

fn number() -> Option<f32> {
    integer().map(f32::from_bits)
}

/// Reads as many bytes as there is room for; `None` at the end of the input.
fn fill(mut room: &mut [u8]) -> Option<()> {
    while !room.is_empty() {
        let read = linux::read(room)?;
        room = room.get_mut(read..)?;
    }
    Some(())
}
