//! Our own contender. Its jobs are those of `nsrm-bench`: what users call, with all checks.

use std::hint::black_box;

use anyhow::{Context as _, Result};
use nsrm_core::dsl::Description;
use nsrm_core::language::{Encoder, Splitter, Token};
use nsrm_core::model::{LOCATION, OBJECT_EMBEDDING, WordEmbeddings};
use nsrm_core::vision::{Crop, encode};
use nsrm_core::{Planner, Scene, action};
use nsrm_tabletop::TABLETOP;

use crate::{Contender, Inputs, Job, ONE_STEP, Outputs, Prepared, Table, Work};

/// Our inference, built as this program is: with core's feature `vectors` or without.
#[derive(Debug)]
pub struct Ours {
    table: Table,
    words: Words,
}

/// Each token's embeddings, and whether it is a group of concept words.
type Words = Vec<(WordEmbeddings, bool)>;

impl Ours {
    /// With the built-in model, which is also the one that the others get as a file.
    pub fn new() -> Result<Self> {
        let table = Table::new()?;
        let words = table.tokens.iter().map(|token| {
            let embeddings = token.embeddings(&TABLETOP);
            let embeddings = embeddings.context("a token of this model")?;
            Ok((embeddings, token.filters().is_some()))
        });
        let words = words.collect::<Result<_>>()?;
        Ok(Self { table, words })
    }
}

impl Contender for Ours {
    fn version(&self) -> String {
        let vectors = if cfg!(feature = "vectors") {
            "with"
        } else {
            "without"
        };
        format!("nsrm-core {vectors} the feature `vectors`")
    }

    fn prepare(&mut self, job: Job, _inputs: &Inputs) -> Result<Prepared> {
        let (words, crops) = (self.words.clone(), self.table.crops.clone());
        Ok(match job {
            Job::Plan => {
                let (scene, tokens) = (self.table.scene, self.table.tokens.clone());
                let given = plan_outputs(&scene, &tokens)?;
                ready(given, move || {
                    let planner = Planner::new(black_box(&TABLETOP));
                    planner.plan(black_box(&scene), black_box(ONE_STEP))
                })
            }
            Job::Encoder => {
                let mut encoder = Encoder::new();
                let instruction = encoded(&mut encoder, &words).to_vec();
                let given = Outputs::default().with("instruction", instruction);
                let given = given.with("groups", encoder.groups().concat());
                ready(given, move || encoded(&mut encoder, black_box(&words)))
            }
            Job::Splitter => {
                let mut given = Vec::new();
                hazards(&words, |hazard| given.push(hazard));
                let given = Outputs::default().with("hazards", given);
                ready(given, move || {
                    hazards(black_box(&words), |hazard| {
                        black_box(hazard);
                    });
                })
            }
            Job::Simulator => {
                let objects = self.table.scene.objects();
                let places = [0, 1].map(|at| objects[at].location);
                let given = Outputs::default().with("location", simulated(&places).to_vec());
                ready(given, move || simulated(black_box(&places)))
            }
            Job::Crop => embedded(crops.into_iter().take(1).collect()),
            Job::Crops => embedded(crops),
        })
    }
}

/// A job that does `run` and always gives the same.
struct Given<F> {
    run: F,
    outputs: Outputs,
}

impl<T, F: FnMut() -> T> Work for Given<F> {
    fn run(&mut self) -> Result<()> {
        black_box((self.run)());
        Ok(())
    }

    fn outputs(&mut self) -> Result<Outputs> {
        Ok(self.outputs.clone())
    }
}

fn ready<T>(outputs: Outputs, run: impl FnMut() -> T + 'static) -> Prepared {
    Prepared::Ready(Box::new(Given { run, outputs }))
}

fn plan_outputs(scene: &Scene, tokens: &[Token]) -> Result<Outputs> {
    let plan = Planner::new(&TABLETOP).plan(scene, ONE_STEP)?;
    let [(_, understood, planned)] = &plan.numbered().collect::<Vec<_>>()[..] else {
        anyhow::bail!("the sentence has more than one step");
    };
    let group = |description: &Description| -> Result<f32> {
        let mut tokens = tokens.iter();
        let at = tokens.position(|token| token.filters() == Some(description.filters()));
        Ok(at.context("the description is not in the sentence")? as f32)
    };
    let groups = [group(&understood.object)?, group(&understood.reference)?];
    let objects = [planned.object.index, planned.reference.index].map(f32::from);
    let outputs = Outputs::default().with("action", vec![f32::from(planned.action)]);
    // The step ends with the sentence.
    let outputs = outputs.with("split", vec![tokens.len() as f32 - 1.0]);
    let outputs = outputs.with("groups", groups.to_vec());
    let outputs = outputs.with("objects", objects.to_vec());
    Ok(outputs.with("location", planned.location.to_vec()))
}

fn encoded(encoder: &mut Encoder, words: &Words) -> [f32; nsrm_core::model::INSTRUCTION] {
    encoder.clear();
    for (embeddings, group) in words {
        encoder.forward(&TABLETOP.language, &embeddings.encoder, *group);
    }
    for (embeddings, group) in words.iter().rev() {
        encoder.backward(&TABLETOP.language, &embeddings.encoder, *group);
    }
    encoder.instruction()
}

fn hazards(words: &Words, mut each: impl FnMut(f32)) {
    let mut splitter = Splitter::new();
    let mut rest = words.as_slice();
    while let [(token, _), behind @ ..] = rest {
        let ahead = behind.iter().map(|(token, _)| token.splitter);
        each(splitter.hazard(&TABLETOP.language, &token.splitter, ahead));
        rest = behind;
    }
}

fn simulated([object, reference]: &[[f32; LOCATION]; 2]) -> [f32; LOCATION] {
    let action = black_box(&TABLETOP.actions[0]);
    action::simulate(TABLETOP.simulator, action, object, reference)
}

/// Crops one after another, as a scene is observed.
fn embedded(crops: Vec<Crop>) -> Prepared {
    let embed = |crop: &Crop| -> [f32; OBJECT_EMBEDDING] { encode(&TABLETOP, crop) };
    let given = crops.iter().flat_map(embed).collect();
    ready(Outputs::default().with("embeddings", given), move || {
        for crop in black_box(&crops) {
            black_box(embed(crop));
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_job_runs_and_gives_numbers() {
        let inputs = Inputs::new(&Table::new().unwrap()).unwrap();
        let mut ours = Ours::new().unwrap();
        for (job, count) in Job::ALL.into_iter().zip([11, 288, 12, 5, 64, 384]) {
            let Prepared::Ready(mut work) = ours.prepare(job, &inputs).unwrap() else {
                panic!("{job} is missing");
            };
            work.run().unwrap();
            let numbers = work.outputs().unwrap().numbers(job, &inputs).unwrap();
            assert_eq!(numbers.len(), count, "{job}");
            assert!(numbers.iter().all(|number| number.is_finite()), "{job}");
        }
    }
}
