//! ONNX Runtime through the crate `ort`: one thread, all optimisations, inputs and outputs bound.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail};
use nsrm_compare::{
    Contender, Inputs, Job, Numbers, Outputs, Prepared, Tensor, Work, locked_version, serve,
};
use ort::environment::Environment;
use ort::session::builder::GraphOptimizationLevel;
use ort::session::{IoBinding, Session};
use ort::value::{DynTensor, DynValue, Tensor as Value, ValueType};

struct OnnxRuntime {
    folder: PathBuf,
    library: PathBuf,
    environment: Environment,
}

impl OnnxRuntime {
    fn new(folder: &Path) -> Result<Self> {
        let library = std::env::var_os("ORT_DYLIB_PATH");
        let library = PathBuf::from(library.context("ORT_DYLIB_PATH is not set")?);
        Ok(Self {
            folder: folder.to_owned(),
            environment: ort::init_from(&library)?.build()?,
            library,
        })
    }

    fn session(&self, job: Job) -> ort::Result<Session> {
        Session::builder(&self.environment)?
            .with_intra_threads(1)?
            .with_inter_threads(1)?
            .with_optimization_level(GraphOptimizationLevel::All)?
            .commit_from_file(self.folder.join(format!("{job}.onnx")))
    }
}

impl Contender for OnnxRuntime {
    fn version(&self) -> String {
        // libonnxruntime.so.1.2.3
        let name = self
            .library
            .file_name()
            .unwrap_or_default()
            .to_string_lossy();
        let (_, version) = name.split_once(".so.").unwrap_or(("", "?"));
        format!(
            "ONNX Runtime {version} through ort {}",
            locked_version("ort")
        )
    }

    fn prepare(&mut self, job: Job, inputs: &Inputs) -> Result<Prepared> {
        let session = self.session(job)?;
        let mut binding = session.create_binding()?;
        for tensor in inputs.of(job)? {
            binding.bind_input(tensor.name.clone(), &value(tensor)?)?;
        }
        let mut names = Vec::new();
        for output in session.outputs() {
            let ValueType::Tensor { ty, shape, .. } = output.dtype() else {
                bail!("{}: no tensor", output.name());
            };
            let place = DynTensor::new(session.allocator(), *ty, shape.clone())?;
            binding.bind_output(output.name(), place)?;
            names.push(output.name().to_owned());
        }
        Ok(Prepared::Ready(Box::new(Bound {
            session,
            binding,
            names,
        })))
    }
}

/// A graph with its inputs and outputs in memory.
struct Bound {
    session: Session,
    binding: IoBinding,
    names: Vec<String>,
}

impl Work for Bound {
    fn run(&mut self) -> Result<()> {
        self.session.run_binding(&self.binding)?;
        Ok(())
    }

    fn outputs(&mut self) -> Result<Outputs> {
        let values = self.session.run_binding(&self.binding)?;
        let mut outputs = Outputs::default();
        for name in &self.names {
            outputs = outputs.with(name, numbers(&values[name.as_str()])?);
        }
        Ok(outputs)
    }
}

fn value(tensor: Tensor) -> Result<DynValue> {
    let shape = tensor.shape;
    Ok(match tensor.numbers {
        Numbers::Real(numbers) => Value::from_array((shape, numbers))?.into_dyn(),
        Numbers::Index(numbers) => Value::from_array((shape, numbers))?.into_dyn(),
        Numbers::Flag(numbers) => Value::from_array((shape, numbers))?.into_dyn(),
    })
}

fn numbers(value: &DynValue) -> Result<Vec<f32>> {
    if let Ok((_, numbers)) = value.try_extract_tensor::<f32>() {
        return Ok(numbers.to_vec());
    }
    let (_, numbers) = value.try_extract_tensor::<i64>()?;
    Ok(numbers.iter().map(|&number| number as f32).collect())
}

fn main() -> Result<()> {
    serve(OnnxRuntime::new)
}
