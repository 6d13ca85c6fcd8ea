//! `nsrm calibrate`: the least confidence that keeps a limit on wrong commands, found on a user's
//! own sentences and scenes.

mod cases;

use std::fs;
use std::io::{self, IsTerminal as _, Write as _};
use std::path::{Path, PathBuf};

use nsrm::risk::{Accepted, Judged, RiskError, RiskLimit, accepted, least_confidence};
use nsrm::{AnyModel, LoadError, ModelError, with_confidence};
use serde_json::{Value, json};
use thiserror::Error;

use cases::{CasesError, judge};

/// What the command is asked to do.
#[derive(clap::Args)]
pub(crate) struct Calibrate {
    /// Sentences with their meanings: a file of JSON lines, each {"scene": FILE, "sentence": TEXT,
    /// "steps": [{"action": NAME, "object_id": N, "reference_id": N}, ...]}, with "steps": null
    /// for what has to be refused, and with "crops": DIR if the scene names no image. Paths are
    /// relative to this file.
    cases: PathBuf,
    /// The greatest accepted share of wrong commands among those that are carried out.
    #[arg(long, value_name = "SHARE", default_value_t = RiskLimit::default().wrong)]
    risk: f64,
    /// The probability with which the limit is kept.
    #[arg(long, value_name = "PROBABILITY", default_value_t = RiskLimit::default().level)]
    level: f64,
    /// The model file (safetensors); the built-in model by default.
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Write the model with the confidence that was found to this file.
    #[arg(long, value_name = "FILE", requires = "model")]
    out: Option<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    pub(crate) json: bool,
}

/// Why nothing was calibrated.
#[derive(Debug, Error)]
pub(crate) enum CalibrateError {
    #[error(transparent)]
    Load(#[from] LoadError),
    #[error(transparent)]
    Cases(#[from] CasesError),
    #[error(transparent)]
    Risk(#[from] RiskError),
    #[error("{}: {source}", .path.display())]
    Model { path: PathBuf, source: ModelError },
    #[error("{}: {source}", .path.display())]
    File { path: PathBuf, source: io::Error },
}

impl Calibrate {
    /// Judges the plans of all cases, finds the confidence, and writes the model if asked to.
    pub(crate) fn run(&self) -> Result<String, CalibrateError> {
        let limit = RiskLimit {
            wrong: self.risk,
            level: self.level,
        };
        // First, before minutes of work.
        limit.check()?;
        let any = match &self.model {
            Some(path) => AnyModel::load(path)?,
            None => AnyModel::Pretrained,
        };
        let mut model = any.model();
        // All plans are judged, also those that an earlier calibration would refuse.
        model.header.thresholds.confidence = 0.0;
        let judged = judge(&self.cases, &model)?;
        let rows = accepted(&judged, limit.level)?;
        let found = least_confidence(&judged, limit).inspect_err(|_| {
            if !self.json {
                // Who has closed stdout doesn't need it.
                let _ = writeln!(io::stdout(), "{}", table(&rows));
            }
        })?;
        if let (Some(from), Some(to)) = (&self.model, &self.out) {
            write_model(from, to, found.threshold)?;
        }
        Ok(if self.json {
            report(&judged, &rows, &found, limit).to_string()
        } else {
            format!(
                "{} sentences, {} planned\n{}\nleast confidence {}: of the accepted commands, at \
                 most {} % are wrong, with a probability of {} %",
                judged.len(),
                rows[0].count,
                table(&rows),
                found.threshold,
                percent(limit.wrong),
                percent(limit.level)
            )
        })
    }
}

/// Shows how far it is, to a person at a terminal.
fn progress(done: usize, all: usize) {
    let mut terminal = io::stderr();
    if terminal.is_terminal() && (done.is_multiple_of(50) || done == all) {
        let _ = write!(terminal, "\r{done} of {all} sentences");
        if done == all {
            let _ = writeln!(terminal);
        }
    }
}

fn table(rows: &[Accepted]) -> String {
    let mut text = format!(
        "{:>10}  {:>8}  {:>6}  {:>10}",
        "confidence", "accepted", "wrong", "at most"
    );
    for row in rows {
        text += &format!(
            "\n{:>10}  {:>8}  {:>6}  {:>8.3} %",
            row.threshold,
            row.count,
            row.wrong,
            100.0 * row.bound
        );
    }
    text
}

fn report(judged: &[Judged], rows: &[Accepted], found: &Accepted, limit: RiskLimit) -> Value {
    let row = |row: &Accepted| {
        json!({
            "confidence": nsrm::json::decimal(row.threshold),
            "accepted": row.count,
            "wrong": row.wrong,
            "bound": row.bound,
        })
    };
    json!({
        "sentences": judged.len(),
        "risk": limit.wrong,
        "level": limit.level,
        "thresholds": rows.iter().map(row).collect::<Vec<_>>(),
        "found": row(found),
    })
}

fn percent(share: f64) -> f64 {
    // 0.001 is 0.1 %, not 0.1000000001 %.
    (share * 1e8).round() / 1e6
}

/// Writes the file as a whole or not at all.
fn write_model(from: &Path, to: &Path, confidence: f32) -> Result<(), CalibrateError> {
    let failed = |path: &Path| {
        let path = path.to_owned();
        |source| CalibrateError::File { path, source }
    };
    let bytes = fs::read(from).map_err(failed(from))?;
    let bytes = with_confidence(&bytes, confidence).map_err(|source| CalibrateError::Model {
        path: from.to_owned(),
        source,
    })?;
    let mut part = to.as_os_str().to_owned();
    part.push(".part");
    let part = PathBuf::from(part);
    fs::write(&part, bytes).map_err(failed(&part))?;
    fs::rename(&part, to).map_err(failed(to))
}
