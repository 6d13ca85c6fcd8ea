//! Scales a box of an image to a crop: first along rows, then along columns.

use super::RgbImage;
use crate::model::CROP;
use crate::nn::{Kernel, widest};

/// A pixel of the image along one axis, and its share in a pixel of the crop.
#[derive(Clone, Copy)]
struct Tap {
    /// Its index, times the step of the axis.
    at: u32,
    weight: f32,
}

/// Two samples, each between two neighbouring pixels.
type Taps = [Tap; 4];

/// A row of the image, scaled: red, green, blue, and a number without meaning, so that a pixel is a
/// vector.
type Line = [[f32; 4]; CROP];

/// Fills a crop's channels, from 0 to 1, with a box of an image.
///
/// * `bounds`: corners x1, y1, x2, y2 as fractions of the image's width and height, in order and
///   within 0..=1
pub(super) fn resample(
    image: &RgbImage<'_>,
    bounds: &[f32; 4],
    channels: &mut [[[f32; CROP]; CROP]; 3],
) {
    widest(Resample {
        image,
        bounds,
        channels,
    });
}

/// See [`resample`].
struct Resample<'a> {
    image: &'a RgbImage<'a>,
    bounds: &'a [f32; 4],
    channels: &'a mut [[[f32; CROP]; CROP]; 3],
}

impl Kernel for Resample<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let image = self.image;
        let [x1, y1, x2, y2] = *self.bounds;
        let [red, green, blue] = self.channels;
        let columns = taps(x1, x2, image.width(), 3);
        let rows = taps(y1, y2, image.height(), 1);
        // The taps of a row are two neighbours or the same, so that two lines are enough: those of even
        // and those of odd rows.
        let mut lines = [(None, [[0.0; 4]; CROP]); 2];
        let maps = red.iter_mut().zip(green).zip(blue);
        for (((red, green), blue), taps) in maps.zip(&rows) {
            let mut sum = [[0.0; 4]; CROP];
            for tap in taps {
                let [even, odd] = &mut lines;
                let (held, line) = if tap.at % 2 == 0 { even } else { odd };
                if *held != Some(tap.at) {
                    scale_row(image, tap.at, &columns, line);
                    *held = Some(tap.at);
                }
                let values = line.as_flattened();
                for (sum, value) in sum.as_flattened_mut().iter_mut().zip(values) {
                    *sum += tap.weight * value;
                }
            }
            let places = red.iter_mut().zip(green).zip(blue);
            for (((red, green), blue), [r, g, b, _]) in places.zip(sum) {
                [*red, *green, *blue] = [r, g, b].map(|value| value * (1.0 / 255.0));
            }
        }
    }
}

/// One row of the image, scaled to the crop's columns.
#[inline(always)]
fn scale_row(image: &RgbImage<'_>, row: u32, columns: &[Taps; CROP], line: &mut Line) {
    let pixels = image.bytes_from(row as usize);
    for (place, taps) in line.iter_mut().zip(columns) {
        let mut sum = [0.0; 4];
        for tap in taps {
            let rest = pixels.get(tap.at as usize..).unwrap_or_default();
            let pixel = rest.first_chunk().copied().unwrap_or_else(|| last(rest));
            for (sum, value) in sum.iter_mut().zip(pixel) {
                *sum += tap.weight * f32::from(value);
            }
        }
        *place = sum;
    }
}

/// The last pixel of the image, behind which nothing comes.
#[cold]
fn last(bytes: &[u8]) -> [u8; 4] {
    match *bytes {
        [red, green, blue] => [red, green, blue, 0],
        _ => [0; 4],
    }
}

/// The taps of all pixels of the crop along one axis: each is the mean of the samples at ¼ and ¾ of
/// its width, which lie between the centres of two pixels of the image, or at its edge.
///
/// * `from`, `to`: the box's edges as fractions of `pixels`, at most 65,535
/// * `step`: from one pixel to the next
#[inline(always)]
fn taps(from: f32, to: f32, pixels: u32, step: u32) -> [Taps; CROP] {
    let last = pixels.saturating_sub(1);
    let sample = |index: usize| {
        let fraction = (index as f32 + 0.5) / (2 * CROP) as f32;
        // At least −0.5: half a pixel before the centre of the first.
        let position = (from + fraction * (to - from)) * pixels as f32 - 0.5;
        // Rounded down: what is rounded towards 0 is positive.
        let before = ((position + 1.0) as u32).saturating_sub(1);
        let share = if position < 0.0 {
            0.0
        } else {
            position - before as f32
        };
        let at = |pixel: u32| pixel.min(last).wrapping_mul(step);
        [
            Tap {
                at: at(before),
                weight: 0.5 * (1.0 - share),
            },
            Tap {
                at: at(before.saturating_add(1)),
                weight: 0.5 * share,
            },
        ]
    };
    core::array::from_fn(|pixel| {
        let [[a, b], [c, d]] = [2 * pixel, 2 * pixel + 1].map(sample);
        [a, b, c, d]
    })
}
