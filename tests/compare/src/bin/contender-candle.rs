//! The model written by hand with candle's tensors, from the model file.

#![forbid(unsafe_code)]

#[path = "../candle/mod.rs"]
mod candle;

use std::path::Path;

use anyhow::Result;
use candle::{Named, Network};
use candle_core::{Device, Tensor as Array};
use nsrm_compare::{
    Contender, Inputs, Job, Numbers, Outputs, Prepared, Tensor, Work, locked_version, serve,
};

struct Candle(Network);

impl Candle {
    fn new(folder: &Path) -> Result<Self> {
        Ok(Self(Network::read(&folder.join("model.safetensors"))?))
    }
}

impl Contender for Candle {
    fn version(&self) -> String {
        format!("candle-core {}", locked_version("candle-core"))
    }

    fn prepare(&mut self, job: Job, inputs: &Inputs) -> Result<Prepared> {
        let network = self.0.clone();
        let tensors: Vec<Array> = inputs.of(job)?.iter().map(array).collect::<Result<_>>()?;
        let [first, rest @ ..] = &tensors[..] else {
            anyhow::bail!("{job} has no inputs");
        };
        let (first, rest) = (first.clone(), rest.to_vec());
        Ok(match (job, &rest[..]) {
            (Job::Plan, [filters, embeddings, locations]) => {
                let filters = filters.to_vec2::<u8>()?;
                let (embeddings, locations) = (embeddings.clone(), locations.to_vec2::<f32>()?);
                ready(move || Ok(network.plan(&first, &filters, &embeddings, &locations)?))
            }
            (Job::Encoder, []) => {
                let words = first.squeeze(1)?;
                ready(move || Ok(vec![("states", network.encoder(&words)?)]))
            }
            (Job::Splitter, []) => {
                let words = first.squeeze(1)?;
                ready(move || Ok(vec![("hazards", network.hazards(&words)?)]))
            }
            (Job::Simulator, [pair]) => {
                let (action, pair) = (first.to_vec1::<u32>()?, pair.to_vec2::<f32>()?.concat());
                ready(move || {
                    let (object, reference) = pair.split_at(5);
                    let location = network.moved(action[0] as usize, object, reference)?;
                    Ok(vec![("location", location)])
                })
            }
            (Job::Crop | Job::Crops, []) => {
                ready(move || Ok(vec![("embeddings", network.embeddings(&first)?)]))
            }
            _ => anyhow::bail!("{job} has {} inputs", tensors.len()),
        })
    }
}

struct Running<F>(F);

impl<F: FnMut() -> Result<Named>> Work for Running<F> {
    fn run(&mut self) -> Result<()> {
        std::hint::black_box((self.0)()?);
        Ok(())
    }

    fn outputs(&mut self) -> Result<Outputs> {
        let mut outputs = Outputs::default();
        for (name, tensor) in (self.0)()? {
            outputs = outputs.with(name, tensor.flatten_all()?.to_vec1()?);
        }
        Ok(outputs)
    }
}

fn ready(run: impl FnMut() -> Result<Named> + 'static) -> Prepared {
    Prepared::Ready(Box::new(Running(run)))
}

fn array(tensor: &Tensor) -> Result<Array> {
    let shape = tensor.shape.as_slice();
    Ok(match &tensor.numbers {
        Numbers::Real(numbers) => Array::from_slice(numbers, shape, &Device::Cpu)?,
        Numbers::Index(numbers) => {
            let numbers: Vec<u32> = numbers
                .iter()
                .map(|&n| u32::try_from(n))
                .collect::<Result<_, _>>()?;
            Array::from_vec(numbers, shape, &Device::Cpu)?
        }
        Numbers::Flag(numbers) => {
            let numbers: Vec<u8> = numbers.iter().map(|&flag| u8::from(flag)).collect();
            Array::from_vec(numbers, shape, &Device::Cpu)?
        }
    })
}

fn main() -> Result<()> {
    serve(Candle::new)
}
