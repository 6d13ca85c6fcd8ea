//! Sentences in scenes, with what they mean: read, planned and judged.

use std::fs::File;
use std::io::{self, BufRead as _, BufReader};
use std::path::{Path, PathBuf};

use nsrm::risk::Judged;
use nsrm::{SceneFileError, read_scene};
use nsrm_core::{Model, Plan, Planner, Scene};
use serde::Deserialize;
use thiserror::Error;

/// A line of the file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Case {
    scene: PathBuf,
    crops: Option<PathBuf>,
    sentence: String,
    // Without a default: what has to be refused says so.
    #[serde(deserialize_with = "Option::deserialize")]
    steps: Option<Vec<Meant>>,
}

/// A step as it was meant.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Meant {
    action: String,
    object_id: u32,
    reference_id: u32,
}

/// Why the file cannot be used.
#[derive(Debug, Error)]
pub(crate) enum CasesError {
    #[error("{}: {source}", .path.display())]
    Read { path: PathBuf, source: io::Error },
    #[error("{}:{line}: {problem}", .path.display())]
    Line {
        path: PathBuf,
        line: usize,
        problem: LineProblem,
    },
}

/// Why a line is no case.
#[derive(Debug, Error)]
pub(crate) enum LineProblem {
    #[error("expected {{\"scene\": FILE, \"sentence\": TEXT, \"steps\": LIST or null}}: {0}")]
    Json(String),
    #[error(transparent)]
    Scene(#[from] SceneFileError),
    #[error("unknown action {action:?}; the model has {known}")]
    Action { action: String, known: String },
    #[error("the scene has no object {0}")]
    Object(u32),
}

impl From<serde_json::Error> for LineProblem {
    /// Without the parser's own line, which is always the first.
    fn from(error: serde_json::Error) -> Self {
        let text = error.to_string();
        let what = text
            .rsplit_once(" at line ")
            .map_or(&*text, |(what, _)| what);
        Self::Json(format!("{what} (column {})", error.column()))
    }
}

/// Plans the sentences of a file and judges the plans.
pub(crate) fn judge(path: &Path, model: &Model<'_>) -> Result<Vec<Judged>, CasesError> {
    let failed = |source| CasesError::Read {
        path: path.to_owned(),
        source,
    };
    let file = BufReader::new(File::open(path).map_err(failed)?);
    let lines: Vec<String> = file.lines().collect::<Result<_, _>>().map_err(failed)?;
    let mut bench = Bench {
        folder: path.parent().unwrap_or(Path::new("")),
        model,
        scene: None,
    };
    let mut judged = Vec::new();
    for (line, text) in (1..).zip(&lines) {
        super::progress(line, lines.len());
        if text.trim().is_empty() {
            continue;
        }
        judged.push(bench.judge(text).map_err(|problem| CasesError::Line {
            path: path.to_owned(),
            line,
            problem,
        })?);
    }
    Ok(judged)
}

/// The model, and the scene of the last case: sentences of one scene usually follow each other.
struct Bench<'a> {
    folder: &'a Path,
    model: &'a Model<'a>,
    scene: Option<((PathBuf, Option<PathBuf>), Scene)>,
}

impl Bench<'_> {
    fn judge(&mut self, text: &str) -> Result<Judged, LineProblem> {
        let case: Case = serde_json::from_str(text)?;
        let files = (case.scene, case.crops);
        let scene = match self.scene.take() {
            Some((known, scene)) if known == files => scene,
            _ => {
                let crops = files.1.as_ref().map(|crops| self.folder.join(crops));
                read_scene(self.folder.join(&files.0), crops.as_deref(), self.model)?
            }
        };
        let (_, scene) = self.scene.insert((files, scene));
        for meant in case.steps.iter().flatten() {
            check(meant, self.model, scene)?;
        }
        let plan = Planner::new(self.model).plan(scene, &case.sentence).ok();
        Ok(Judged {
            confidence: plan.as_ref().map(Plan::confidence),
            right: plan.is_some_and(|plan| means(self.model, &plan, case.steps.as_deref())),
        })
    }
}

/// A meaning that no plan can have would count as a mistake of the model.
fn check(meant: &Meant, model: &Model<'_>, scene: &Scene) -> Result<(), LineProblem> {
    let names: Vec<&str> = (0..=u8::MAX)
        .map_while(|index| model.action_name(index))
        .collect();
    if !names.contains(&meant.action.as_str()) {
        return Err(LineProblem::Action {
            action: meant.action.clone(),
            known: names.join(", "),
        });
    }
    for object in [meant.object_id, meant.reference_id] {
        if !scene.objects().iter().any(|seen| seen.id == object) {
            return Err(LineProblem::Object(object));
        }
    }
    Ok(())
}

/// Whether a plan does what was meant; nothing is right for a sentence without a meaning.
fn means(model: &Model<'_>, plan: &Plan, meant: Option<&[Meant]>) -> bool {
    let Some(meant) = meant else { return false };
    meant.len() == plan.steps().len()
        && meant
            .iter()
            .zip(plan.numbered())
            .all(|(meant, (_, understood, planned))| {
                // "Next to" is planned as the action that puts the object there.
                let mut actions = [understood.action, planned.action].into_iter();
                actions.any(|action| model.action_name(action) == Some(&meant.action))
                    && planned.object.object == meant.object_id
                    && planned.reference.object == meant.reference_id
            })
}
