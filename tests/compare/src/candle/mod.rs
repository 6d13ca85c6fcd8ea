//! The network in candle: products for all tokens or objects at once wherever the model allows it.

mod layers;

use std::collections::HashMap;
use std::path::Path;

use candle_core::{D, Device, Result, Tensor};
use candle_nn::ops::sigmoid;
use nsrm_core::model::{LOOKAHEAD, VIEW_EMBEDDING, View};
use nsrm_tabletop::TABLETOP;

use layers::{Gru, Linear, ViewEncoder};

/// A job's results by name.
pub(crate) type Named = Vec<(&'static str, Tensor)>;

/// Factor on the simulator's output.
const SIMULATOR_SCALE: f32 = 0.1;

/// All parameters, ready for products.
#[derive(Debug, Clone)]
pub(crate) struct Network {
    words: Tensor,
    splitter_words: Tensor,
    encoder: Gru,
    splitter: Gru,
    hazard_state: Tensor,
    hazard_ahead: Linear,
    hazard: Linear,
    action: Linear,
    arguments: Linear,
    color: ViewEncoder,
    brightness: ViewEncoder,
    operators: Vec<Operator>,
    simulator: [Linear; 3],
    mean: Vec<f32>,
    scale: Vec<f32>,
}

#[derive(Debug, Clone)]
struct Operator {
    view: usize,
    hidden: Linear,
    output: Linear,
    /// `[16, values]`, each of length 1.
    concepts: Tensor,
}

impl Network {
    /// From the model file.
    pub(crate) fn read(path: &Path) -> Result<Self> {
        let file = candle_core::safetensors::load(path, &Device::Cpu)?;
        let get = |name: &str| tensor(&file, name);
        let linear = |name: &str| Linear::read(&file, name);
        let hidden = get("language.splitter.hidden.weight")?.t()?;
        let state = get("language.splitter.gru.bias_n")?.elem_count();
        let ahead = hidden.narrow(0, state, hidden.dim(0)? - state)?;
        let mut operators = Vec::new();
        let mut first = 0;
        for (at, attribute) in TABLETOP.attributes.iter().enumerate() {
            let name = attribute.name;
            let of = TABLETOP.concepts.iter();
            let values = of
                .filter(|concept| usize::from(concept.attribute) == at)
                .count();
            let concepts = get("vision.concept.weight")?.narrow(0, first, values)?;
            let lengths = concepts.sqr()?.sum_keepdim(1)?.sqrt()?;
            operators.push(Operator {
                view: match attribute.view {
                    View::Color => 0,
                    _ => VIEW_EMBEDDING,
                },
                hidden: linear(&format!("vision.operator.{name}.hidden"))?,
                output: linear(&format!("vision.operator.{name}.output"))?,
                concepts: concepts.broadcast_div(&lengths)?.t()?.contiguous()?,
            });
            first += values;
        }
        Ok(Self {
            words: get("language.embedding.weight")?,
            splitter_words: get("language.splitter.embedding.weight")?,
            encoder: Gru::read(
                &file,
                &["language.encoder.forward", "language.encoder.backward"],
            )?,
            splitter: Gru::read(&file, &["language.splitter.gru"])?,
            hazard_state: hidden.narrow(0, 0, state)?.contiguous()?,
            hazard_ahead: Linear::new(ahead.contiguous()?, get("language.splitter.hidden.bias")?),
            hazard: linear("language.splitter.hazard")?,
            action: linear("language.action_decoder")?,
            arguments: linear("language.object_decoder")?
                .beside(&linear("language.reference_decoder")?)?,
            color: ViewEncoder::read(&file, "vision.color")?,
            brightness: ViewEncoder::read(&file, "vision.brightness")?,
            operators,
            simulator: [
                linear("action.simulator.input")?,
                linear("action.simulator.hidden")?,
                linear("action.simulator.output")?,
            ],
            mean: get("action.simulator.location_mean")?.to_vec1()?,
            scale: get("action.simulator.location_scale")?.to_vec1()?,
        })
    }

    /// Words `[T, 32]` to states `[T, 96]`.
    pub(crate) fn encoder(&self, words: &Tensor) -> Result<Tensor> {
        let states = self.encoder.states(words)?;
        Tensor::cat(&[states.get(0)?, states.get(1)?], 1)
    }

    /// Words `[T, 24]` to hazards `[T, 1]`.
    pub(crate) fn hazards(&self, words: &Tensor) -> Result<Tensor> {
        let (count, width) = words.dims2()?;
        let states = self.splitter.states(words)?.get(0)?;
        let padded = words.pad_with_zeros(0, 0, LOOKAHEAD)?;
        let ahead: Vec<Tensor> = (1..=LOOKAHEAD)
            .map(|first| padded.narrow(0, first, count))
            .collect::<Result<_>>()?;
        let ahead = Tensor::cat(&ahead, 1)?;
        debug_assert_eq!(ahead.dims(), [count, LOOKAHEAD * width]);
        let hidden = self.hazard_ahead.apply(&ahead)?;
        let hidden = (hidden + states.matmul(&self.hazard_state)?)?.tanh()?;
        sigmoid(&self.hazard.apply(&hidden)?)
    }

    /// A sentence of one step about objects, to its program, objects and location.
    pub(crate) fn plan(
        &self,
        tokens: &Tensor,
        filters: &[Vec<u8>],
        embeddings: &Tensor,
        locations: &[Vec<f32>],
    ) -> Result<Named> {
        let hazards = self.hazards(&self.splitter_words.index_select(tokens, 0)?)?;
        let hazards = hazards.flatten_all()?.to_vec1::<f32>()?;
        let last = hazards.len() - 1;
        let split = hazards[..last].iter().position(|&hazard| hazard > 0.5);

        let states = self.encoder(&self.words.index_select(tokens, 0)?)?;
        let half = states.dim(1)? / 2;
        let ahead = states.narrow(0, last, 1)?.narrow(1, 0, half)?;
        let back = states.narrow(0, 0, 1)?.narrow(1, half, half)?;
        let instruction = Tensor::cat(&[ahead, back], 1)?;
        let logits = self.action.apply(&instruction)?;
        let action = greatest(&logits.flatten_all()?.to_vec1()?, |_| true);
        let sought = self.arguments.apply(&instruction)?.reshape((2, 2 * half))?;
        let logits = sought.matmul(&states.t()?)?.to_vec2::<f32>()?;
        let tokens = tokens.to_vec1::<u32>()?;
        let groups: Vec<usize> = logits
            .iter()
            .map(|logits| greatest(logits, |token| tokens[token] == 0))
            .collect();

        let cosines = self.cosines(embeddings)?.to_vec2::<f32>()?;
        let objects: Vec<usize> = groups
            .iter()
            .map(|&group| {
                let scores = cosines.iter().map(|cosines| {
                    let chosen = cosines.iter().zip(&filters[group]);
                    let chosen = chosen.filter(|(_, flag)| **flag != 0);
                    chosen.fold(1.0_f32, |least, (cosine, _)| least.min(*cosine))
                });
                greatest(&scores.collect::<Vec<_>>(), |_| true)
            })
            .collect();
        let location = self.moved(action, &locations[objects[0]], &locations[objects[1]])?;
        Ok(vec![
            ("action", indices(&[action])?),
            ("split", indices(&[split.unwrap_or(last)])?),
            ("groups", indices(&groups)?),
            ("objects", indices(&objects)?),
            ("location", location),
        ])
    }

    /// Embeddings `[M, 64]` to cosines `[M, C]`.
    fn cosines(&self, embeddings: &Tensor) -> Result<Tensor> {
        let width = embeddings.dim(1)? / 2;
        let cosines = self.operators.iter().map(|operator| {
            let view = embeddings.narrow(1, operator.view, width)?.contiguous()?;
            let feature = operator.hidden.apply(&view)?.relu()?;
            let feature = operator.output.apply(&feature)?;
            let length = feature.sqr()?.sum_keepdim(1)?.sqrt()?;
            feature.matmul(&operator.concepts)?.broadcast_div(&length)
        });
        Tensor::cat(&cosines.collect::<Result<Vec<_>>>()?, 1)
    }

    /// The location of the moved object `[5]`.
    pub(crate) fn moved(&self, action: usize, object: &[f32], reference: &[f32]) -> Result<Tensor> {
        let (object, reference) = (centred(object), centred(reference));
        let [input, hidden, output] = &self.simulator;
        let actions = input.inputs()? - 2 * object.len();
        let mut seen: Vec<f32> = (0..actions)
            .map(|other| f32::from(u8::from(other == action)))
            .collect();
        for location in [&object, &reference] {
            let standard = location.iter().zip(self.mean.iter().zip(&self.scale));
            seen.extend(standard.map(|(value, (mean, scale))| (value - mean) / scale));
        }
        let count = seen.len();
        let seen = Tensor::from_vec(seen, (1, count), &Device::Cpu)?;
        let seen = hidden.apply(&input.apply(&seen)?.tanh()?)?.tanh()?;
        let change: Vec<f32> = output.apply(&seen)?.flatten_all()?.to_vec1()?;
        let base = [
            reference[0],
            reference[1],
            object[2],
            object[3],
            reference[4],
        ];
        let mut at = [0.0; 5];
        for (place, (base, change)) in at.iter_mut().zip(base.iter().zip(change)) {
            *place = base + SIMULATOR_SCALE * change;
        }
        let [x, y, width, height, depth] = at;
        let (half_width, half_height) = (width / 2.0, height / 2.0);
        let corners = [
            x - half_width,
            y - half_height,
            x + half_width,
            y + half_height,
            depth,
        ];
        Tensor::from_slice(&corners, 5, &Device::Cpu)
    }

    /// Crops `[N, 3, 32, 32]` to embeddings `[N, 64]`.
    pub(crate) fn embeddings(&self, crops: &Tensor) -> Result<Tensor> {
        let gray = crops.max_keepdim(1)?;
        let flat = gray.flatten_from(1)?;
        let flat = flat.broadcast_sub(&flat.mean_keepdim(D::Minus1)?)?;
        let deviation = (flat.sqr()?.mean_keepdim(D::Minus1)?.sqrt()? + 0.02)?;
        let gray = flat.broadcast_div(&deviation)?.reshape(gray.shape())?;
        let views = [
            self.color.apply(&(crops - 0.5)?)?,
            self.brightness.apply(&gray)?,
        ];
        Tensor::cat(&views, 1)
    }
}

/// The tensor of a name in the model file.
fn tensor(file: &HashMap<String, Tensor>, name: &str) -> Result<Tensor> {
    let found = file.get(name).cloned();
    found.ok_or_else(|| candle_core::Error::Msg(format!("the model file lacks {name}")))
}

/// Of the places that may be chosen, the first with the greatest number.
fn greatest(numbers: &[f32], may: impl Fn(usize) -> bool) -> usize {
    let mut best = None;
    for (at, &number) in numbers.iter().enumerate() {
        if may(at) && best.is_none_or(|(_, most)| number > most) {
            best = Some((at, number));
        }
    }
    best.map_or(0, |(at, _)| at)
}

fn indices(indices: &[usize]) -> Result<Tensor> {
    let numbers: Vec<f32> = indices.iter().map(|&index| index as f32).collect();
    Tensor::from_vec(numbers, indices.len(), &Device::Cpu)
}

/// Corners and depth to centre, size and depth.
fn centred(location: &[f32]) -> [f32; 5] {
    let [x1, y1, x2, y2, depth] = *location else {
        return [f32::NAN; 5];
    };
    [(x1 + x2) / 2.0, (y1 + y2) / 2.0, x2 - x1, y2 - y1, depth]
}
