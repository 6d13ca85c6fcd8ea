use heapless::Vec;

use super::cause::Reading;
use crate::camera::Camera;
use crate::capacity::MAX_OBJECTS;
use crate::model::{LOCATION, Model};
use crate::scene::{ObservedObject, Scene};

/// The smallest apparent width of an object as a share of the shorter edge of its base, and the
/// greatest as a share of the base's diagonal: for whole objects 0.986 and 1.104 were observed.
const NARROWEST: f32 = 0.96;
const WIDEST: f32 = 1.15;
/// An object that is higher than another one by this share of the smallest height may stand on it,
const HIGHER: f32 = 0.25;
/// if its horizontal distance is less than this share of the longest edge: partly covered objects
/// were observed up to 0.53 of it away from those on top of them; neighbours are at least 0.87
/// apart.
const ASIDE: f32 = 0.75;
/// Pixels between two boxes that don't overlap.
pub(crate) const APART_PX: f32 = 2.0;

/// Where the objects of a scene are, and what each rests on.
#[derive(Debug, Clone)]
pub(super) struct Arrangement {
    objects: Vec<Seen, MAX_OBJECTS>,
}

/// An observed object.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seen {
    pub(super) id: u32,
    /// Of its centre, world frame, metres.
    position: [f32; 3],
    /// Of its centre to the right of the optical axis, metres.
    pub(super) across_m: f32,
    pub(super) width_m: f32,
    /// No nearer object overlaps it in the image.
    is_whole: bool,
    /// `None` until lower objects have theirs.
    rest: Option<Rest>,
}

/// Where an object of one of the sizes rests.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rest {
    /// Height of its centre, metres.
    pub(super) height_m: f32,
    /// Height of its upper face, metres.
    top_m: f32,
    /// On the table, not on another object.
    pub(super) is_on_table: bool,
    /// Whether the object's width is possible for this size.
    pub(super) fits: bool,
    /// Shorter edge of the base, metres.
    narrow_m: f32,
    /// How far above it the object is observed, metres.
    pub(super) off_m: f32,
}

impl Arrangement {
    /// The objects of a scene in this interpretation of its numbers.
    pub(super) fn new(model: &Model<'_>, scene: &Scene, reading: &Reading) -> Self {
        let mut objects = Vec::new();
        for object in scene.objects() {
            let mut others = scene.objects().iter();
            let is_whole = !others.any(|other| covers(&reading.camera, other, object));
            // As many places as a scene has objects.
            let _ = objects.push(Seen::new(model, object, reading, is_whole));
        }
        let mut arrangement = Self { objects };
        let bounds = Bounds::of(model);
        for _ in scene.objects() {
            arrangement.settle_lowest(model, &bounds);
        }
        arrangement
    }

    /// Determines what the lowest undetermined object rests on.
    fn settle_lowest(&mut self, model: &Model<'_>, bounds: &Bounds) {
        let unsettled = self.objects.iter().enumerate();
        let lowest = unsettled
            .filter(|(_, seen)| seen.rest.is_none())
            .min_by(|(_, one), (_, other)| one.height_m().total_cmp(&other.height_m()));
        let Some((index, seen)) = lowest else {
            return;
        };
        let rest = seen.rest_on(self.support(seen, bounds), model);
        if let Some(seen) = self.objects.get_mut(index) {
            seen.rest = rest;
        }
    }

    /// What the object stands on: the highest object below it; `None` for the table.
    fn support(&self, seen: &Seen, bounds: &Bounds) -> Option<Rest> {
        let [x, y, z] = seen.position;
        let below = self.objects.iter().filter(|other| {
            let [other_x, other_y, other_z] = other.position;
            other.rest.is_some()
                && other_z + HIGHER * bounds.lowest_m <= z
                && length_m(x - other_x, y - other_y) < ASIDE * bounds.widest_m
        });
        below
            .max_by(|one, other| one.height_m().total_cmp(&other.height_m()))
            .and_then(|support| support.rest)
    }

    /// The whole objects, and where each rests.
    pub(super) fn whole(&self) -> impl Iterator<Item = (&Seen, &Rest)> {
        let whole = self.objects.iter().filter(|seen| seen.is_whole);
        whole.filter_map(|seen| Some((seen, seen.rest.as_ref()?)))
    }
}

impl Seen {
    fn new(model: &Model<'_>, object: &ObservedObject, reading: &Reading, is_whole: bool) -> Self {
        let [x1, y1, x2, y2, depth] = object.location;
        let location = [x1, y1, x2, y2, depth * reading.depth_scale];
        let camera = &reading.camera;
        let place = camera.locate_in_camera(model.camera, &location);
        let position = camera.world_from_camera() * place;
        Self {
            id: object.id,
            position: position.coords.into(),
            across_m: place.x,
            width_m: camera.width_m(&location),
            is_whole,
            rest: None,
        }
    }

    pub(super) const fn height_m(&self) -> f32 {
        let [_, _, height_m] = self.position;
        height_m
    }

    /// Where it rests with its likeliest size; `None` only if the model has no sizes.
    fn rest_on(&self, support: Option<Rest>, model: &Model<'_>) -> Option<Rest> {
        let base_m = support.map_or(0.0, |support| support.top_m);
        let mut likeliest: Option<Rest> = None;
        for [x, y, z] in sizes(model) {
            let height_m = base_m + 0.5 * z;
            let (least_m, greatest_m) = widths_m([x, y, z]);
            let rest = Rest {
                height_m,
                top_m: base_m + z,
                is_on_table: support.is_none(),
                fits: least_m <= self.width_m && self.width_m <= greatest_m,
                narrow_m: x.min(y),
                off_m: self.height_m() - height_m,
            };
            if likeliest.is_none_or(|before| self.prefers(&rest, &before)) {
                likeliest = Some(rest);
            }
        }
        likeliest
    }

    /// Whether the one is likelier than the other to be where it rests. By its height, or
    /// where others hide a part of it, so that this is uncertain, by its width.
    fn prefers(&self, one: &Rest, other: &Rest) -> bool {
        if one.fits != other.fits {
            one.fits
        } else if self.is_whole || !one.fits {
            one.off_m.abs() < other.off_m.abs()
        } else {
            one.narrow_m > other.narrow_m
        }
    }
}

/// The outermost of the domain's sizes.
struct Bounds {
    /// Longest edge of a base, metres.
    widest_m: f32,
    /// Least height, metres.
    lowest_m: f32,
}

impl Bounds {
    fn of(model: &Model<'_>) -> Self {
        let mut bounds = Self {
            widest_m: 0.0,
            lowest_m: f32::INFINITY,
        };
        for [x, y, z] in sizes(model) {
            bounds.widest_m = bounds.widest_m.max(x).max(y);
            bounds.lowest_m = bounds.lowest_m.min(z);
        }
        bounds
    }
}

/// How wide an upright object with these edges looks from anywhere, at least and at most, metres.
pub(crate) fn widths_m([x, y, _]: [f32; 3]) -> (f32, f32) {
    (NARROWEST * x.min(y), WIDEST * length_m(x, y))
}

/// Edge lengths of the domain's objects, metres.
pub(crate) fn sizes(model: &Model<'_>) -> impl Iterator<Item = [f32; 3]> {
    model.concepts.iter().filter_map(|concept| concept.edges_m)
}

/// Of the hypotenuse over these sides.
pub(super) fn length_m(x: f32, y: f32) -> f32 {
    libm::sqrtf(x * x + y * y)
}

/// Whether the one is nearer than the object and overlaps it in the image.
fn covers(camera: &Camera, one: &ObservedObject, object: &ObservedObject) -> bool {
    let [left, top, right, bottom, depth] = one.location;
    let [x1, y1, x2, y2, own_depth]: [f32; LOCATION] = object.location;
    let (apart_x, apart_y) = (
        APART_PX / camera.width as f32,
        APART_PX / camera.height as f32,
    );
    depth < own_depth
        && left < x2 + apart_x
        && x1 < right + apart_x
        && top < y2 + apart_y
        && y1 < bottom + apart_y
}
