//! A free place on the table: beside an object that stands there, or beside the one that a sentence names,
//! where one of several actions of the model puts things. So the learned simulator says where it is, as of any
//! other sub-goal. And the place halfway between two objects, if it is free.

use core::num::NonZeroU16;

use nalgebra::Point3;

use super::Grounding;
use super::distance::at_distance;
use super::resolve::Within;
use super::sight::{HIDDEN, ON_TOP_M, Sight, is_hidden};
use crate::action::simulate;
use crate::grounding::Chosen;
use crate::model::LOCATION;
use crate::refusal::Refusal;

/// The least distance of a free place from any other object, as a share of its distance from the one
/// that it is beside. The distance beside an object, about 75 mm for a larger block beside a smaller
/// one, keeps two apart side by side; where corners may meet, two larger blocks of 60 mm need 85 mm.
const CLEAR: f32 = 1.15;

/// The least gap between an object and each of those that it is put between: the arm's fingers, which open along the
/// longer way, need none, and sub-goals are a few millimetres off.
const LEAST_GAP_M: f32 = 0.01;

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
    let distance_m2 = aside_m2(&within.place(&put), &within.place(beside));
    if !is_clear(
        object,
        &put,
        &[neighbour],
        CLEAR * CLEAR * distance_m2,
        within,
    ) {
        return Ok(None);
    }
    // What stands behind a nearer object might not be seen.
    let others = within.locations.get(..within.scene.objects().len());
    if is_hidden(&put, others.unwrap_or_default().iter().copied(), HIDDEN) {
        return Ok(None);
    }
    Ok(Some(aside_m2(&within.place(&put), &within.place(from))))
}

/// Where an object is halfway between two others that stand on the table, and are seen whole.
///
/// * `object`: index of the object that is put there
/// * `reference`: one of the two, described together with the other one
/// * `part`: index of the action that tells how far it is from what it stands beside
///
/// Cost: an action twice, and each object compared with all others.
#[inline(never)]
pub(super) fn between(
    object: usize,
    reference: &Grounding,
    part: u8,
    within: &Within<'_>,
) -> Result<[f32; LOCATION], Refusal> {
    let Within {
        model, viewpoint, ..
    } = within;
    let step = within.step as u8;
    let id = |index: usize| {
        let object = within.scene.objects().get(index);
        object.map_or(0, |object| object.id)
    };
    let no_room = Refusal::NoRoomOnTable {
        step,
        object: id(object),
    };
    let second = within.second(reference).ok_or(Refusal::InvalidModel)?;
    let action = model.actions.get(usize::from(part));
    let action = action.ok_or(Refusal::InvalidModel)?;
    let location = |index: usize| within.locations.get(index).ok_or(Refusal::InvalidModel);
    let from = location(object)?;
    let ends = [usize::from(reference.index), second];
    let mut puts = [*from; 2];
    let mut places = [Point3::origin(); 2];
    let mut farthest_m2 = 0.0_f32;
    for ((end, put), place) in ends.into_iter().zip(&mut puts).zip(&mut places) {
        if end == object {
            let object = id(object);
            return Err(Refusal::SameObject { step, object });
        }
        if !within.is_on_table(end) {
            let object = id(end);
            return Err(Refusal::NotOnTable { step, object });
        }
        if Sight::of(end, within).is_rough {
            let object = id(end);
            return Err(Refusal::HiddenReference { step, object });
        }
        let end = location(end)?;
        *place = within.place(end);
        *put = simulate(model.simulator, action, from, end);
        farthest_m2 = farthest_m2.max(aside_m2(&within.place(put), place));
    }
    let [one, other] = places;
    let needed_m =
        libm::sqrtf(farthest_m2) - 1e-3 * f32::from(model.distances.usual_mm) + LEAST_GAP_M;
    let half_m = 0.5 * libm::sqrtf(aside_m2(&one, &other));
    // Not if one of them is no number.
    let is_wide = half_m >= needed_m;
    if !is_wide {
        return Err(no_room);
    }
    let [put, _] = puts;
    let (halfway, at) = (nalgebra::center(&one, &other), within.place(&put));
    let put = viewpoint.shifted(&put, halfway.x - at.x, halfway.y - at.y);
    // Behind one of the two it is seen past the edges, as what is put behind a single one.
    let others = within.locations.iter().take(within.scene.objects().len());
    let others = others
        .enumerate()
        .filter(|(index, _)| *index != object && !ends.contains(index));
    let others = others.map(|(_, location)| *location);
    let is_free = is_clear(object, &put, &ends, CLEAR * CLEAR * farthest_m2, within)
        && !is_hidden(&put, others, HIDDEN);
    is_free.then_some(put).ok_or(no_room)
}

/// Whether a place is on the table, inside the work space, in sight, and so far from all objects but these, and what
/// they carry.
///
/// * `object`: index of the object that is put there
/// * `put`: the place
/// * `near`: indices of the objects that it's beside
/// * `least_m2`: the square of the distance, square metres
fn is_clear(
    object: usize,
    put: &[f32; LOCATION],
    near: &[usize],
    least_m2: f32,
    within: &Within<'_>,
) -> bool {
    let Within {
        model, viewpoint, ..
    } = within;
    let place = within.place(put);
    let is_on_table = model
        .on_table_below_m()
        .is_some_and(|below_m| place.z < below_m);
    let is_inside = model.header.work_space.contains(&place.into());
    if !is_on_table || !is_inside || !viewpoint.contains(put) {
        return false;
    }
    let others = within.locations.get(..within.scene.objects().len());
    let (on_top_m, _) = ON_TOP_M;
    let mut apart = others.unwrap_or_default().iter().enumerate();
    apart.all(|(index, other)| {
        let other = within.place(other);
        // What it is beside may carry others.
        let is_beside = near.iter().any(|near| {
            let near = within.locations.get(*near);
            let near = near.map(|near| aside_m2(&within.place(near), &other));
            near.is_some_and(|near_m2| near_m2 < on_top_m * on_top_m)
        });
        index == object || is_beside || aside_m2(&place, &other) >= least_m2
    })
}

/// The square of the distance of two points along the table, square metres.
fn aside_m2(one: &Point3<f32>, other: &Point3<f32>) -> f32 {
    let [x, y, _]: [f32; 3] = (one - other).into();
    x * x + y * y
}
