//! The command `nsrm`.

mod calibrate;
mod robot;

use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use nsrm::dialogue::Question;
use nsrm::{AnyModel, info_json, info_text, json, read_scene};
use nsrm_codegen::hexadecimal;
use nsrm_core::language::Correction;
use nsrm_core::nn::Precision;
use nsrm_core::{Planner, Refusal, Scene};
use serde_json::Value;

/// Parse sentences into programs and plan sub-goals in scenes, with a learned model.
///
/// Exit code 0 on success, 2 if the sentence is refused or the input is invalid.
#[derive(Parser)]
#[command(name = "nsrm", version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Print the program of a sentence.
    Parse {
        /// The sentence, as one argument.
        sentence: String,
        #[command(flatten)]
        options: Options,
    },
    /// Print the plan for a sentence in a scene.
    Plan {
        /// The scene file (JSON).
        #[arg(long)]
        scene: PathBuf,
        /// Folder with a crop <id>.png per object, instead of the image.
        #[arg(long, value_name = "DIR")]
        crops: Option<PathBuf>,
        /// The sentence, as one argument.
        sentence: String,
        #[command(flatten)]
        options: Options,
    },
    /// Print a model's domain, dimensions, memory and metrics.
    Info {
        /// The model file (safetensors); the built-in model by default.
        model: Option<PathBuf>,
        /// Round the weights as a controller's model is: f32 (as trained) or int8.
        #[arg(long, value_name = "TYPE", default_value = Precision::F32.name())]
        precision: Precision,
        /// Print JSON.
        #[arg(long)]
        json: bool,
    },
    /// Check a model file.
    Check {
        /// The model file (safetensors).
        model: PathBuf,
        /// Print JSON.
        #[arg(long)]
        json: bool,
    },
    /// Find the least confidence at which few of the accepted commands are wrong.
    ///
    /// Plans your own sentences in your own scenes, and judges the plans by what was meant. Then it
    /// guarantees the limit for sentences and scenes like these. Exit code 2 if they guarantee it at
    /// no confidence.
    Calibrate(calibrate::Calibrate),
    #[command(flatten)]
    Robot(robot::RobotCommand),
}

#[derive(clap::Args)]
struct Options {
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// The model file (safetensors); the built-in model by default.
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Round the weights as a controller's model is: f32 (as trained) or int8.
    #[arg(long, value_name = "TYPE", default_value = Precision::F32.name())]
    precision: Precision,
}

/// Why a command failed: as text and as JSON.
struct Failure {
    message: String,
    json: Value,
}

impl Failure {
    /// * `scene`: where the sentence was planned, if it was
    fn refused(
        model: &nsrm_core::Model<'_>,
        scene: Option<&Scene>,
        refusal: Refusal,
        sentence: &str,
    ) -> Self {
        let mut message = refusal.in_context(model, sentence).to_string();
        let mut json = json::refusal(model, &refusal, sentence);
        if let Some(question) = Question::after(model, scene, &refusal, sentence) {
            json["refused"]["question"] = json::question(&question);
            // Otherwise the message says it already.
            if matches!(
                refusal,
                Refusal::Ambiguous { .. } | Refusal::NoSuchObject { .. }
            ) {
                let _ = write!(message, "; {question}");
            }
        }
        Self { message, json }
    }
}

impl<E: std::error::Error> From<E> for Failure {
    fn from(error: E) -> Self {
        let message = error.to_string();
        Self {
            json: json::error(&message),
            message,
        }
    }
}

fn main() -> ExitCode {
    let command = Arguments::parse().command;
    let as_json = match &command {
        Command::Parse { options, .. } | Command::Plan { options, .. } => options.json,
        Command::Info { json, .. } | Command::Check { json, .. } => *json,
        Command::Calibrate(command) => command.json,
        Command::Robot(command) => command.wants_json(),
    };
    match run(&command) {
        // Events of a robot were printed as they happened.
        Ok(text) if text.is_empty() => ExitCode::SUCCESS,
        Ok(text) => print(&text),
        Err(failure) => {
            eprintln!("nsrm: {}", failure.message);
            if as_json {
                print(&failure.json.to_string());
            }
            ExitCode::from(2)
        }
    }
}

/// Writes to stdout; does not panic if the reader has closed it.
fn print(text: &str) -> ExitCode {
    use std::io::Write as _;
    match writeln!(std::io::stdout(), "{text}") {
        Ok(()) => ExitCode::SUCCESS,
        Err(_) => ExitCode::FAILURE,
    }
}

fn run(command: &Command) -> Result<String, Failure> {
    match command {
        Command::Parse { sentence, options } => {
            let any = open(options.model.as_ref(), options.precision)?;
            let model = any.model();
            let parsed = Planner::new(&model)
                .parse(sentence)
                .map_err(|refusal| Failure::refused(&model, None, refusal, sentence))?;
            Ok(if options.json {
                json::parsed(&model, &parsed, sentence).to_string()
            } else {
                let mut lines = vec![parsed.program().notation(&model).to_string()];
                lines.extend(corrections_text(&model, parsed.corrections(), sentence));
                lines.join("\n")
            })
        }
        Command::Plan {
            scene,
            crops,
            sentence,
            options,
        } => {
            let any = open(options.model.as_ref(), options.precision)?;
            let model = any.model();
            let scene = read_scene(scene, crops.as_deref(), &model)?;
            let plan = Planner::new(&model)
                .plan(&scene, sentence)
                .map_err(|refusal| Failure::refused(&model, Some(&scene), refusal, sentence))?;
            Ok(if options.json {
                json::plan(&model, &plan, sentence).to_string()
            } else {
                plan_text(&model, &plan, sentence)
            })
        }
        Command::Info {
            model,
            precision,
            json,
        } => {
            let any = open(model.as_ref(), *precision)?;
            Ok(if *json {
                info_json(&any).to_string()
            } else {
                info_text(&any)
            })
        }
        Command::Calibrate(command) => Ok(command.run()?),
        Command::Robot(command) => command.run().map(|()| String::new()),
        Command::Check { model: path, json } => {
            let any = AnyModel::load(path)?;
            let model = any.model();
            let identity = hexadecimal(&model.header.identity);
            Ok(if *json {
                serde_json::json!({"domain": model.header.domain, "identity": identity}).to_string()
            } else {
                let domain = model.header.domain;
                format!(
                    "{}: valid; domain {domain}, identity {identity}",
                    path.display()
                )
            })
        }
    }
}

fn open(path: Option<&PathBuf>, precision: Precision) -> Result<AnyModel, Failure> {
    match path {
        Some(path) => Ok(AnyModel::load_as(path, precision)?),
        None => Ok(AnyModel::pretrained(precision)),
    }
}

/// The program, then each step's explanation and sub-goal.
fn corrections_text<'a>(
    model: &'a nsrm_core::Model<'a>,
    corrections: &'a [Correction],
    sentence: &'a str,
) -> impl Iterator<Item = String> + 'a {
    corrections
        .iter()
        .map(move |each| each.explain(model, sentence).to_string())
}

fn plan_text(model: &nsrm_core::Model<'_>, plan: &nsrm_core::Plan, sentence: &str) -> String {
    let mut lines = vec![plan.program().notation(model).to_string()];
    lines.extend(corrections_text(model, plan.corrections(), sentence));
    for (number, _, planned) in plan.numbered() {
        let goal = planned.sub_goal;
        lines.push(plan.explain_step(model, number).to_string());
        let [x, y, z]: [f32; 3] = goal.pose.translation.vector.into();
        let [qx, qy, qz, qw]: [f32; 4] = goal.pose.rotation.coords.into();
        lines.push(format!(
            "  object {} to ({x:.3}, {y:.3}, {z:.3}) m, orientation ({qx:.3}, {qy:.3}, {qz:.3}, {qw:.3})",
            goal.object
        ));
    }
    lines.join("\n")
}
