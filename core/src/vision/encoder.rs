use super::Crop;
use crate::model::{
    CROP, MERGE_CHANNELS, MERGED, Model, OBJECT_EMBEDDING, PATCH_CHANNELS, VIEW_EMBEDDING,
    ViewEncoder,
};
use crate::nn::{Kernel, relu_all, widest};

/// Subtracted from red, green and blue, as in training.
const COLOR_CENTRE: f32 = 0.5;
/// Added to the deviation of the brightness, so that a flat crop stays flat.
const LEAST_CONTRAST: f32 = 0.02;

/// Multiply-adds of one [`encode`]: both views through three layers each.
pub const ENCODE_MULTIPLY_ADDS: usize = CROP * CROP * 4 * PATCH_CHANNELS
    + 2 * (64 * PATCH_CHANNELS * MERGE_CHANNELS)
    + 2 * MERGED * VIEW_EMBEDDING;

/// An object's embedding `emb(o)` (section IV-C): the embedding of the colour view, then that of
/// the brightness view. Never negative.
///
/// * colour view: red, green and blue less 0.5
/// * brightness view: `(y − mean) / (deviation + 0.02)` over the crop, where y is the
///   greatest of red, green and blue, so that an operator that reads it alone cannot
///   tell colours and a blue block's studs stand out as a white one's do
///
/// Cost: [`ENCODE_MULTIPLY_ADDS`] multiply-adds. Stack: about 28 KiB on x86-64, of
/// which [`encode_in_place`] saves 12.
///
/// ```
/// use nsrm_core::vision::{Crop, RgbImage, encode};
/// use nsrm_tabletop::TABLETOP;
///
/// let pixels = [255; 3 * 40 * 40];
/// let image = RgbImage::new(&pixels, 40, 40, 3 * 40)?;
/// let crop = Crop::from_rgb(&image, &[0.0, 0.0, 1.0, 1.0])?;
/// let embedding = encode(&TABLETOP, &crop);
/// assert!(embedding.iter().all(|value| *value >= 0.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn encode(model: &Model<'_>, crop: &Crop) -> [f32; OBJECT_EMBEDDING] {
    encode_in_place(model, &mut crop.clone())
}

/// [`encode`] without a copy of the crop, whose content is overwritten. NaN from a model without
/// vision: no scene accepts it.
#[inline(never)]
pub fn encode_in_place(model: &Model<'_>, crop: &mut Crop) -> [f32; OBJECT_EMBEDDING] {
    let Some(vision) = model.vision else {
        return [f32::NAN; OBJECT_EMBEDDING];
    };
    let light = encode_brightness(vision.brightness, crop);
    let color = encode_color(vision.color, crop);
    let mut embedding = [0.0; OBJECT_EMBEDDING];
    for (place, value) in embedding.iter_mut().zip(color.into_iter().chain(light)) {
        *place = value;
    }
    embedding
}

/// Replaces the embedding of the colour view by that of another crop, whose content is overwritten: of the
/// part of an object that no other one covers.
#[inline(never)]
pub fn recolor(model: &Model<'_>, embedding: &mut [f32; OBJECT_EMBEDDING], crop: &mut Crop) {
    if let Some(vision) = model.vision {
        let color = encode_color(vision.color, crop);
        for (place, value) in embedding.iter_mut().zip(color) {
            *place = value;
        }
    }
}

fn encode_color(encoder: &ViewEncoder<'_, 3>, crop: &mut Crop) -> [f32; VIEW_EMBEDDING] {
    for value in crop.channels.as_flattened_mut().as_flattened_mut() {
        *value -= COLOR_CENTRE;
    }
    encode_view(encoder, &crop.channels)
}

#[inline(never)]
fn encode_brightness(encoder: &ViewEncoder<'_, 1>, crop: &Crop) -> [f32; VIEW_EMBEDDING] {
    let mut view = [[[0.0; CROP]; CROP]];
    let [map] = &mut view;
    widest(Brightness { crop, view: map });
    encode_view(encoder, &view)
}

// Not inlined, so that both views use the same stack.
#[inline(never)]
fn encode_view<const CHANNELS: usize>(
    encoder: &ViewEncoder<'_, CHANNELS>,
    view: &[[[f32; CROP]; CROP]; CHANNELS],
) -> [f32; VIEW_EMBEDDING] {
    let mut patches = [[[0.0; PATCH_CHANNELS]; CROP / 4]; CROP / 4];
    encoder.patch.apply(view, &mut patches);
    patches.iter_mut().flatten().for_each(relu_all);
    let mut merged = [[[0.0; MERGE_CHANNELS]; CROP / 8]; CROP / 8];
    encoder.merge.apply(&patches, &mut merged);
    merged.iter_mut().flatten().for_each(relu_all);
    let Some(flat) = merged.as_flattened().as_flattened().first_chunk::<MERGED>() else {
        const { assert!(MERGED == MERGE_CHANNELS * 4 * 4) };
        return [0.0; VIEW_EMBEDDING];
    };
    let mut embedding = encoder.dense.apply(flat);
    relu_all(&mut embedding);
    embedding
}

/// Fills `view` with the standardised brightness of a crop.
struct Brightness<'a> {
    crop: &'a Crop,
    view: &'a mut [[f32; CROP]; CROP],
}

impl Kernel for Brightness<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let [red, green, blue] = &self.crop.channels;
        let channels = red.iter().zip(green).zip(blue);
        for (row, ((red, green), blue)) in self.view.iter_mut().zip(channels) {
            let channels = red.iter().zip(green).zip(blue);
            for (place, ((&red, &green), &blue)) in row.iter_mut().zip(channels) {
                *place = greater(greater(red, green), blue);
            }
        }
        let mean = mean(self.view, |value| value);
        let variance = self::mean(self.view, |value| (value - mean) * (value - mean));
        let scale = 1.0 / (libm::sqrtf(variance) + LEAST_CONTRAST);
        for value in self.view.as_flattened_mut() {
            *value = (*value - mean) * scale;
        }
    }
}

#[inline(always)]
fn greater(left: f32, right: f32) -> f32 {
    if left > right { left } else { right }
}

/// Mean over all pixels, column by column, so that rounding errors do not accumulate.
#[inline(always)]
fn mean(view: &[[f32; CROP]; CROP], of: impl Fn(f32) -> f32) -> f32 {
    let mut sums = [0.0; CROP];
    for row in view {
        for (sum, &value) in sums.iter_mut().zip(row) {
            *sum += of(value);
        }
    }
    sums.iter().sum::<f32>() / (CROP * CROP) as f32
}

#[cfg(test)]
mod tests {
    use std::boxed::Box;

    use super::*;
    use crate::fixture;

    fn crop(pixel: impl Fn(usize, usize) -> [f32; 3]) -> Crop {
        let mut crop = Crop::BLACK;
        for row in 0..CROP {
            for column in 0..CROP {
                for (channel, value) in pixel(row, column).into_iter().enumerate() {
                    crop.channels[channel][row][column] = value;
                }
            }
        }
        crop
    }

    fn brightness_of(crop: &Crop) -> [[f32; CROP]; CROP] {
        let mut view = [[0.0; CROP]; CROP];
        widest(Brightness {
            crop,
            view: &mut view,
        });
        view
    }

    #[test]
    fn brightness_is_standardised_and_a_flat_crop_stays_flat() {
        // Left half 0.2, right half 0.6 in every channel: mean 0.4, deviation 0.2.
        let view = brightness_of(&crop(|_, column| [if column < 16 { 0.2 } else { 0.6 }; 3]));
        assert!((view[3][2] + 0.2 / 0.22).abs() < 1e-5, "{}", view[3][2]);
        assert!((view[30][16] - 0.2 / 0.22).abs() < 1e-5);
        // Red 1 above, blue 0.5 below: mean 0.75, deviation 0.25, whatever the colours.
        let view = brightness_of(&crop(|row, _| {
            if row < 16 {
                [1.0, 0.0, 0.0]
            } else {
                [0.0, 0.0, 0.5]
            }
        }));
        assert!((view[0][0] - 0.25 / 0.27).abs() < 1e-5);
        let flat = brightness_of(&crop(|_, _| [0.3; 3]));
        assert!(flat.iter().flatten().all(|value| value.abs() < 1e-4));
    }

    /// One path through the colour view, each step with its own number, and one
    /// through the brightness view.
    #[test]
    fn a_pixel_finds_its_way_through_both_views() {
        let mut model = fixture::model();
        let vision = model.vision.unwrap();
        let mut color = *vision.color;
        // Green of crop pixel (4·5 + 1, 4·2 + 3), then patch (5, 2) of channel 20 is
        // row 1, column 0 of merged pixel (2, 1).
        color.patch.weight[1][1][3][20] = 4.0;
        color.patch.bias[20] = 1.0;
        color.merge.weight[1][0][20][30] = 0.5;
        let mut dense = fixture::linear();
        dense.weight[(2 * 4 + 1) * 32 + 30][7] = 2.0;
        dense.bias[6] = -1.0;
        color.dense = fixture::dense(dense);
        let mut light = *vision.brightness;
        light.patch.weight[0][0][0][1] = 1.0;
        light.merge.weight[0][0][1][2] = 1.0;
        let mut dense = fixture::linear();
        dense.weight[2][9] = 1.0;
        light.dense = fixture::dense(dense);
        model.vision = Some(crate::model::Vision {
            color: Box::leak(Box::new(color)),
            brightness: Box::leak(Box::new(light)),
        });
        let crop = crop(|row, column| match (row, column) {
            (21, 11) => [0.0, 1.0, 0.0],
            (0, 0) => [1.0, 1.0, 1.0],
            _ => [0.0; 3],
        });
        let embedding = encode(&model, &crop);
        let bright = brightness_of(&crop)[0][0];
        for (index, value) in embedding.into_iter().enumerate() {
            let expected = match index {
                // 2·0.5·relu(4·(1 − 0.5) + 1)
                7 => 3.0,
                41 => bright,
                _ => 0.0,
            };
            assert!((value - expected).abs() < 1e-6, "{index}: {value}");
        }
    }
}
