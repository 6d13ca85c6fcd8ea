use nsrm_core::model;

use super::index;
use crate::domain::{Distances, Domain};
use crate::error::ModelError;

/// What core reads as slices of [`model::Distances`].
#[derive(Default)]
pub(super) struct DistanceParts<'a> {
    sides: Vec<u8>,
    units: Vec<model::DistanceUnit<'a>>,
    numbers: Vec<model::DistanceNumber<'a>>,
    before: Vec<&'a str>,
    behind: Vec<&'a str>,
    from: Vec<&'a str>,
    beside: &'a str,
    unless: Vec<&'a str>,
    shifts: Vec<model::DistanceShift<'a>>,
    origins: Vec<&'a str>,
    usual_mm: u16,
}

impl<'a> DistanceParts<'a> {
    pub(super) fn new(domain: &'a Domain) -> Result<Self, ModelError> {
        let Some(distances) = &domain.distances else {
            return Ok(Self::default());
        };
        let Distances {
            sides,
            units,
            numbers,
            before,
            behind,
            from,
            beside,
            unless,
            shifts,
            origins,
            usual_mm,
        } = distances;
        let [before, behind, from, unless, origins] = [before, behind, from, unless, origins]
            .map(|texts| texts.iter().map(String::as_str).collect());
        let unit = |(text, mm): (&'a String, &f32)| {
            let unit = model::DistanceUnit::new();
            unit.with_text(text).with_mm(*mm)
        };
        let number = |(text, value): (&'a String, &f32)| {
            let number = model::DistanceNumber::new();
            number.with_text(text).with_value(*value)
        };
        let side = |name: &String| {
            // Always there: it was checked.
            let found = domain.action_index(name).unwrap_or_default();
            index("actions", found)
        };
        let mut said = Vec::new();
        for (name, texts) in shifts {
            let action = side(name)?;
            let shift = |text: &'a String| {
                let shift = model::DistanceShift::new();
                shift.with_text(text).with_action(action)
            };
            said.extend(texts.iter().map(shift));
        }
        said.sort_unstable_by_key(|shift| shift.text);
        Ok(Self {
            sides: sides.iter().map(side).collect::<Result<_, _>>()?,
            units: units.iter().map(unit).collect(),
            numbers: numbers.iter().map(number).collect(),
            before,
            behind,
            from,
            beside,
            unless,
            shifts: said,
            origins,
            usual_mm: *usual_mm,
        })
    }

    pub(super) fn lent(&self) -> model::Distances<'_> {
        model::Distances::new()
            .with_sides(&self.sides)
            .with_units(&self.units)
            .with_numbers(&self.numbers)
            .with_before(&self.before)
            .with_behind(&self.behind)
            .with_from(&self.from)
            .with_beside(self.beside)
            .with_unless(&self.unless)
            .with_shifts(&self.shifts)
            .with_origins(&self.origins)
            .with_usual_mm(self.usual_mm)
    }
}
