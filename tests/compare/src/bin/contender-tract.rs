//! tract on the same graphs as ONNX Runtime, or faster ones.

#![forbid(unsafe_code)]

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Result;
use nsrm_compare::{
    Contender, Inputs, Job, Numbers, Outputs, Prepared, Tensor, Work, locked_version, serve,
};
use tract_onnx::prelude::{
    Framework as _, InferenceModelExt as _, IntoRunnable as _, IntoTValue as _, TValue, TVec,
    Tensor as Array, TypedRunnableModel,
};

struct Tract {
    folder: PathBuf,
}

impl Contender for Tract {
    fn version(&self) -> String {
        format!("tract-onnx {}", locked_version("tract-onnx"))
    }

    fn prepare(&mut self, job: Job, inputs: &Inputs) -> Result<Prepared> {
        // A panic of the optimiser, too, is a graph that it cannot take.
        let graph = match job {
            // Six times as fast here; slower in ONNX Runtime.
            Job::Crops => "crops-split",
            _ => job.name(),
        };
        let path = self.folder.join(format!("{graph}.onnx"));
        let tensors = inputs.of(job)?;
        let loaded = std::panic::catch_unwind(|| Loaded::new(&path, &tensors));
        Ok(match loaded {
            Ok(Ok(loaded)) => Prepared::Ready(Box::new(loaded)),
            Ok(Err(error)) => Prepared::Missing(first_line(&format!("{error:#}"))),
            Err(_) => Prepared::Missing("it panics on this graph".to_owned()),
        })
    }
}

/// A graph with its inputs. Each run has a new state: a kept one would start the GRU where the run before
/// has ended.
struct Loaded {
    plan: Arc<TypedRunnableModel>,
    inputs: TVec<TValue>,
    names: Vec<String>,
}

impl Loaded {
    fn new(path: &Path, tensors: &[Tensor]) -> Result<Self> {
        let model = tract_onnx::onnx().model_for_path(path)?;
        let names = model.output_outlets()?.iter().map(|outlet| {
            let node = &model.nodes()[outlet.node];
            node.name.clone()
        });
        let names = names.collect();
        let plan: Arc<TypedRunnableModel> = model.into_optimized()?.into_runnable()?;
        let inputs: TVec<TValue> = tensors.iter().map(value).collect::<Result<_>>()?;
        // What fails at the first run does so here.
        plan.run(inputs.clone())?;
        Ok(Self {
            plan,
            inputs,
            names,
        })
    }
}

impl Work for Loaded {
    fn run(&mut self) -> Result<()> {
        std::hint::black_box(self.plan.run(self.inputs.clone())?);
        Ok(())
    }

    fn outputs(&mut self) -> Result<Outputs> {
        let values = self.plan.run(self.inputs.clone())?;
        let mut outputs = Outputs::default();
        for (name, value) in self.names.iter().zip(values) {
            let numbers = value.cast_to::<f32>()?;
            let numbers = numbers.to_plain_array_view::<f32>()?;
            outputs = outputs.with(name, numbers.iter().copied().collect());
        }
        Ok(outputs)
    }
}

fn value(tensor: &Tensor) -> Result<TValue> {
    let shape = tensor.shape.as_slice();
    let array = match &tensor.numbers {
        Numbers::Real(numbers) => Array::from_shape(shape, numbers)?,
        Numbers::Index(numbers) => Array::from_shape(shape, numbers)?,
        Numbers::Flag(numbers) => Array::from_shape(shape, numbers)?,
    };
    Ok(array.into_tvalue())
}

fn first_line(text: &str) -> String {
    text.lines().next().unwrap_or_default().to_owned()
}

fn main() -> Result<()> {
    serve(|folder| {
        Ok(Tract {
            folder: folder.to_owned(),
        })
    })
}
