use anyhow::{Context as _, Result, ensure};
use nsrm_core::model::{ENCODER_HIDDEN, INSTRUCTION};

use crate::{Inputs, Job, Numbers};

/// How far a contender's number may be from ours: absolute, or relative to our greatest number of
/// that job, whichever allows more.
pub const TOLERANCE: f32 = 1e-4;

/// What a job gave, by name.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Outputs(Vec<(String, Vec<f32>)>);

impl Outputs {
    /// Adds one; integers stand as numbers.
    #[must_use]
    pub fn with(mut self, name: &str, numbers: Vec<f32>) -> Self {
        self.0.push((name.to_owned(), numbers));
        self
    }

    /// Each with its name.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &[f32])> {
        let named = self.0.iter();
        named.map(|(name, numbers)| (name.as_str(), numbers.as_slice()))
    }

    fn get(&self, name: &str) -> Result<&[f32]> {
        let mut named = self.iter();
        let found = named.find(|(other, _)| *other == name);
        Ok(found.with_context(|| format!("no output {name}"))?.1)
    }

    /// All numbers of a job in the order that is the same for all contenders.
    pub fn numbers(&self, job: Job, inputs: &Inputs) -> Result<Vec<f32>> {
        let names: &[&str] = match job {
            Job::Plan => &["action", "split", "groups", "objects", "location"],
            Job::Encoder => return self.encoded(inputs),
            Job::Splitter => &["hazards"],
            Job::Simulator => &["location"],
            Job::Crop | Job::Crops => &["embeddings"],
        };
        let numbers = names.iter().map(|name| self.get(name));
        Ok(numbers.collect::<Result<Vec<_>>>()?.concat())
    }

    /// The instruction's embedding, and the states at groups, which is what ours keeps of all states.
    fn encoded(&self, inputs: &Inputs) -> Result<Vec<f32>> {
        if let Ok(instruction) = self.get("instruction") {
            return Ok([instruction, self.get("groups")?].concat());
        }
        let states = self.get("states")?.as_chunks::<INSTRUCTION>().0;
        let (first, last) = states.first().zip(states.last()).context("no states")?;
        let mut numbers = [&last[..ENCODER_HIDDEN], &first[ENCODER_HIDDEN..]].concat();
        let Numbers::Index(tokens) = &inputs.get("tokens")?.numbers else {
            anyhow::bail!("tokens are not indices");
        };
        for (state, token) in states.iter().zip(tokens) {
            if *token == 0 {
                numbers.extend_from_slice(state);
            }
        }
        Ok(numbers)
    }
}

/// How far two contenders' numbers are from each other, as a multiple of what is allowed: at most 1 if
/// they agree.
pub(crate) fn disagreement(ours: &[f32], theirs: &[f32]) -> Result<f32> {
    ensure!(
        ours.len() == theirs.len(),
        "{} numbers instead of {}",
        theirs.len(),
        ours.len()
    );
    let greatest = ours
        .iter()
        .fold(1.0_f32, |most, number| most.max(number.abs()));
    let differences = ours.iter().zip(theirs).map(|(a, b)| (a - b).abs());
    let mut furthest = 0.0_f32;
    for difference in differences {
        if difference.is_nan() {
            return Ok(f32::INFINITY);
        }
        furthest = furthest.max(difference);
    }
    Ok(furthest / (TOLERANCE * greatest))
}

impl Outputs {
    /// Fails unless these agree with ours within [`TOLERANCE`].
    pub fn check(&self, ours: &Self, job: Job, inputs: &Inputs) -> Result<()> {
        let of = disagreement(&ours.numbers(job, inputs)?, &self.numbers(job, inputs)?)?;
        ensure!(
            of <= 1.0,
            "its numbers are {of:.1} times as far from ours as is allowed"
        );
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Table;

    #[test]
    fn what_is_allowed_grows_with_the_greatest_number() {
        assert!(disagreement(&[0.5, -0.1], &[0.5, -0.100_09]).unwrap() < 1.0);
        assert!(disagreement(&[0.5, -0.1], &[0.5, -0.1002]).unwrap() > 1.0);
        assert!(disagreement(&[100.0, 0.1], &[100.0, 0.105]).unwrap() < 1.0);
        assert!(disagreement(&[1.0], &[1.0, 2.0]).is_err());
    }

    #[test]
    fn a_nan_never_agrees() {
        for numbers in [[f32::NAN, 0.0], [0.0, f32::NAN]] {
            assert!(disagreement(&[0.0, 0.0], &numbers).unwrap() > 1.0);
        }
    }

    /// Both halves, and the two groups' states, come from their own rows.
    #[test]
    fn all_states_give_what_ours_keeps() {
        let inputs = Inputs::new(&Table::new().unwrap()).unwrap();
        let states = (0..12).flat_map(|token| {
            (0..INSTRUCTION).map(move |unit| token as f32 + unit as f32 / 1000.0)
        });
        let outputs = Outputs::default().with("states", states.collect());
        let numbers = outputs.numbers(Job::Encoder, &inputs).unwrap();
        assert_eq!(numbers.len(), 3 * INSTRUCTION);
        let places = [0, ENCODER_HIDDEN, INSTRUCTION, 2 * INSTRUCTION];
        assert_eq!(places.map(|at| numbers[at]), [11.0, 0.048, 3.0, 10.0]);
    }
}
