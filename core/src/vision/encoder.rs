use super::Crop;
use crate::model::{
    CROP, MERGE_CHANNELS, MERGED, Model, OBJECT_EMBEDDING, PATCH_CHANNELS, VIEW_EMBEDDING,
    ViewEncoder,
};
use crate::nn::relu_all;

/// Subtracted from red, green and blue, as in training.
const COLOR_CENTRE: f32 = 0.5;
/// Added to the deviation of the brightness, so that a flat crop stays flat.
const LEAST_CONTRAST: f32 = 0.02;
/// Share of red, green and blue in brightness (ITU-R BT.601).
const LUMA: [f32; 3] = [0.299, 0.587, 0.114];

/// An object's embedding `emb(o)` (section IV-C): what the colour view is encoded
/// to, then what the brightness view is. Never negative.
///
/// * colour view: red, green and blue less 0.5
/// * brightness view: `(y − mean) / (deviation + 0.02)` over the crop, so that an
///   operator that reads it alone can't tell colours
///
/// Cost: 229,376 multiply-adds. Stack: about 14 KiB.
pub fn encode(model: &Model<'_>, crop: &Crop) -> [f32; OBJECT_EMBEDDING] {
    let mut color = crop.clone();
    for value in color.channels.as_flattened_mut().as_flattened_mut() {
        *value -= COLOR_CENTRE;
    }
    let color = encode_view(model.vision.color, &color.channels);
    let brightness = encode_view(model.vision.brightness, &[brightness(crop)]);
    let mut embedding = [0.0; OBJECT_EMBEDDING];
    for (place, value) in embedding
        .iter_mut()
        .zip(color.into_iter().chain(brightness))
    {
        *place = value;
    }
    embedding
}

fn encode_view<const CHANNELS: usize>(
    encoder: &ViewEncoder<CHANNELS>,
    view: &[[[f32; CROP]; CROP]; CHANNELS],
) -> [f32; VIEW_EMBEDDING] {
    let mut patches: [[[f32; 8]; 8]; PATCH_CHANNELS] = encoder.patch.apply(view);
    patches.iter_mut().flatten().for_each(relu_all);
    let merged: [[[f32; 4]; 4]; MERGE_CHANNELS] = encoder.merge.apply(&patches);
    let mut flat = [0.0; MERGED];
    for (place, value) in flat.iter_mut().zip(merged.iter().flatten().flatten()) {
        *place = *value;
    }
    relu_all(&mut flat);
    let mut embedding = encoder.dense.apply(&flat);
    relu_all(&mut embedding);
    embedding
}

fn brightness(crop: &Crop) -> [[f32; CROP]; CROP] {
    let mut view = [[0.0; CROP]; CROP];
    for (map, share) in crop.channels.iter().zip(LUMA) {
        let values = map.iter().flatten();
        for (place, value) in view.iter_mut().flatten().zip(values) {
            *place += share * value;
        }
    }
    const PIXELS: f32 = (CROP * CROP) as f32;
    let mean = view.iter().flatten().sum::<f32>() / PIXELS;
    let squares = view
        .iter()
        .flatten()
        .map(|value| (value - mean) * (value - mean));
    let deviation = libm::sqrtf(squares.sum::<f32>() / PIXELS);
    for value in view.iter_mut().flatten() {
        *value = (*value - mean) / (deviation + LEAST_CONTRAST);
    }
    view
}
