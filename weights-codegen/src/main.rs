//! `nsrm-codegen MODEL --out FILE`: static Rust arrays from a trained model.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, ValueEnum};
use nsrm_codegen::{Options, OwnedModel, memory_report, rust_source};
use nsrm_core::nn::Precision;

/// Write a trained model as static Rust arrays for nsrm-core.
#[derive(Parser)]
#[command(name = "nsrm-codegen", version)]
struct Arguments {
    /// The model file (safetensors).
    model: PathBuf,
    /// The Rust source file to write.
    #[arg(long, value_name = "FILE", required_unless_present = "report")]
    out: Option<PathBuf>,
    /// Name of the public static.
    #[arg(long, default_value = "TABLETOP")]
    name: String,
    /// Round the weights of the large layers, one scale a row.
    #[arg(long, value_name = "TYPE")]
    quantise: Option<Rounding>,
    /// Print the read-only memory of each array.
    #[arg(long)]
    report: bool,
    /// Write nothing; exit with code 2 if FILE is out of date.
    #[arg(long, requires = "out")]
    check: bool,
}

/// What weights can be rounded to.
#[derive(Clone, Copy, ValueEnum)]
enum Rounding {
    /// Whole numbers of eight bits.
    Int8,
}

impl From<Rounding> for Precision {
    fn from(rounding: Rounding) -> Self {
        match rounding {
            Rounding::Int8 => Self::Int8,
        }
    }
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("nsrm-codegen: {message}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), String> {
    let options = Options::new(&arguments.name).map_err(|error| error.to_string())?;
    let bytes = std::fs::read(&arguments.model).map_err(at(&arguments.model))?;
    let precision = arguments.quantise.map_or(Precision::F32, Precision::from);
    let model = OwnedModel::from_bytes_as(&bytes, precision).map_err(at(&arguments.model))?;
    if let Some(out) = &arguments.out {
        let source = rust_source(&model, &options);
        if arguments.check {
            let written = std::fs::read(out).map_err(at(out))?;
            if written != source.as_bytes() {
                return Err(format!(
                    "{}: differs from what {} generates; run again without --check",
                    out.display(),
                    arguments.model.display()
                ));
            }
        } else {
            std::fs::write(out, source).map_err(at(out))?;
        }
    }
    if arguments.report {
        println!("{}", memory_report(&model.as_model()));
    }
    Ok(())
}

fn at<E: std::fmt::Display>(path: &Path) -> impl Fn(E) -> String {
    move |error| format!("{}: {error}", path.display())
}
