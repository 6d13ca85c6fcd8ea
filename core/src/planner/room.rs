//! A free place on the table: beside an object that stands there, or beside the one that a sentence names,
//! where one of several actions of the model puts things. So the learned simulator says where it is, as of any
//! other sub-goal.

use core::num::NonZeroU16;

use nalgebra::Point3;

use super::Grounding;
use super::distance::at_distance;
use super::resolve::Within;
use super::sight::{HIDDEN, ON_TOP_M, Sight, is_hidden};
use crate::action::simulate;
use crate::grounding::Chosen;
use crate::refusal::Refusal;

/// The least distance of a free place from any other object, as a share of its distance from the one
/// that it is beside. The distance beside an object, about 75 mm for a larger block beside a smaller
/// one, keeps two apart side by side; where corners may meet, two larger blocks of 60 mm need 85 mm.
const CLEAR: f32 = 1.15;

/// Tries the places beside each object or a single one, and keeps the nearest free one, beside one that is
/// seen whole if there is any. Each [`Room::poll`] tries one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Room {
    /// The only object beside which a place is sought, and the compound that says where.
    only: Option<(Grounding, u8)>,
    /// How far from that object, if the sentence says it.
    distance_mm: Option<NonZeroU16>,
    /// How many places were tried.
    tried: usize,
    best: Option<Free>,
}

/// A free place.
#[derive(Debug, Clone, Copy)]
struct Free {
    beside: Beside,
    /// Whether what it is beside is seen in part only, and so where it is only roughly.
    is_rough: bool,
    /// Square of its distance from where the object stands, square metres.
    off_m2: f32,
}

/// A place beside an object of the scene.
#[derive(Debug, Clone, Copy)]
pub(super) struct Beside {
    /// The action that puts things there: index in the model.
    pub(super) action: u8,
    /// That object.
    pub(super) neighbour: Grounding,
}

impl Room {
    /// Nothing tried yet, beside any object.
    pub(super) const fn anywhere() -> Self {
        Self::sought(None)
    }

    /// Nothing tried yet, beside one object.
    ///
    /// * `compound`: as of [`crate::Model::compound`]
    /// * `distance_mm`: that of the step
    pub(super) const fn beside(
        object: Grounding,
        compound: u8,
        distance_mm: Option<NonZeroU16>,
    ) -> Self {
        let room = Self::sought(Some((object, compound)));
        Self {
            distance_mm,
            ..room
        }
    }

    const fn sought(only: Option<(Grounding, u8)>) -> Self {
        Self {
            only,
            distance_mm: None,
            tried: 0,
            best: None,
        }
    }

    /// Tries the next place; the best free one once all were tried.
    ///
    /// * `object`: index of the object to be put there
    ///
    /// Cost: an action, the place of each object three times, and each compared four times with all others.
    #[inline(never)]
    pub(super) fn poll(
        &mut self,
        object: usize,
        within: &Within<'_>,
    ) -> Result<Option<Beside>, Refusal> {
        let objects = within.scene.objects();
        let (sides, neighbour) = match self.only {
            None => (within.model.table.sides, None),
            Some((neighbour, compound)) => {
                let compound = within.model.compound(compound);
                let compound = compound.ok_or(Refusal::InvalidModel)?;
                (compound.parts, Some(neighbour))
            }
        };
        // At least one side: the model was checked.
        let round = self.tried.checked_div(sides.len());
        let round = round.ok_or(Refusal::InvalidModel)?;
        let index = match neighbour {
            None => round,
            Some(neighbour) if round == 0 => neighbour.index.into(),
            Some(_) => objects.len(),
        };
        let side = self.tried.checked_rem(sides.len());
        let side = side.and_then(|side| sides.get(side));
        let (Some(beside), Some(&action)) = (objects.get(index), side) else {
            let id = objects.get(object).map_or(0, |object| object.id);
            let best = self.best.ok_or(Refusal::NoRoomOnTable {
                step: within.step as u8,
                object: id,
            })?;
            return Ok(Some(best.beside));
        };
        self.tried = self.tried.saturating_add(1);
        if index != object
            && within.is_on_table(index)
            && let Some(off_m2) = free(object, index, action, self.distance_mm, within)?
        {
            let Sight { is_rough, .. } = Sight::of(index, within);
            let is_worse = |other: Free| (other.is_rough, other.off_m2) <= (is_rough, off_m2);
            if self.best.is_some_and(is_worse) {
                return Ok(None);
            }
            let certain = Chosen {
                index,
                score: 1.0,
                probability: 1.0,
            };
            let any = Grounding::new(beside.id, index as u8, &certain);
            self.best = Some(Free {
                beside: Beside {
                    action,
                    neighbour: neighbour.unwrap_or(any),
                },
                is_rough,
                off_m2,
            });
        }
        Ok(None)
    }
}

/// The square of the distance between an object and where an action would put it beside another one, if
/// that place is on the table, inside the work space, in sight, and free.
fn free(
    object: usize,
    neighbour: usize,
    action: u8,
    distance_mm: Option<NonZeroU16>,
    within: &Within<'_>,
) -> Result<Option<f32>, Refusal> {
    let Within {
        model, viewpoint, ..
    } = within;
    // Always there: the model was checked, and both are objects of the scene.
    let action = model.actions.get(usize::from(action));
    let action = action.ok_or(Refusal::InvalidModel)?;
    let location = |index: usize| within.locations.get(index).ok_or(Refusal::InvalidModel);
    let (from, beside) = (location(object)?, location(neighbour)?);
    if !viewpoint.contains(beside) {
        return Ok(None);
    }
    let mut put = simulate(model.simulator, action, from, beside);
    if let Some(mm) = distance_mm {
        put = at_distance(model, viewpoint, &put, beside, mm);
    }
    let place = within.place(&put);
    let is_on_table = model
        .on_table_below_m()
        .is_some_and(|below_m| place.z < below_m);
    let is_inside = model.header.work_space.contains(&place.into());
    if !is_on_table || !is_inside || !viewpoint.contains(&put) {
        return Ok(None);
    }
    let others = within.locations.get(..within.scene.objects().len());
    let others = others.unwrap_or_default();
    let beside = within.place(beside);
    let least_m2 = CLEAR * CLEAR * aside_m2(&place, &beside);
    let (on_top_m, _) = ON_TOP_M;
    let mut apart = others.iter().enumerate();
    let is_free = apart.all(|(index, other)| {
        let other = within.place(other);
        // What it is beside may carry others.
        let is_beside = aside_m2(&beside, &other) < on_top_m * on_top_m;
        index == object || is_beside || aside_m2(&place, &other) >= least_m2
    });
    // What stands behind a nearer object might not be seen.
    if !is_free || is_hidden(&put, others.iter().copied(), HIDDEN) {
        return Ok(None);
    }
    Ok(Some(aside_m2(&place, &within.place(from))))
}

/// The square of the distance of two points along the table, square metres.
fn aside_m2(one: &Point3<f32>, other: &Point3<f32>) -> f32 {
    let [x, y, _]: [f32; 3] = (one - other).into();
    x * x + y * y
}
