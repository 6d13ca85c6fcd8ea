//! The check of a scene against the camera's calibration, with the pretrained model and scenes
//! rendered by the harness: a scene of a calibrated camera gets a plan, in any orientation of the
//! world; any other scene is refused with the cause.

use nsrm_core::calibration::{CalibrationFault, Cause, Measured};
use nsrm_core::model::LOCATION;
use nsrm_core::scene::ObservedObject;
use nsrm_core::{Camera, Planner, RawScene, Refusal, Scene};
use nsrm_ipc::message::CameraFrame;
use nsrm_ipc::node::see;
use nsrm_tabletop::TABLETOP;
use nsrm_tests::golden::{Golden, camera, fixed};
use nsrm_tests::picture;
use proptest::collection::vec;
use proptest::prelude::*;

/// The number of golden scenes that are unchanged renderings of the harness.
const RENDERED: usize = 3;
/// The greatest number of objects in such a scene.
const MOST: usize = 6;

/// What the camera sees of a scene, and the camera.
#[derive(Debug, Clone)]
struct Seen {
    camera: Camera,
    locations: Vec<[f32; LOCATION]>,
}

fn rendered(number: usize) -> Seen {
    let golden = Golden::read();
    let locations = golden.array(&format!("scene.{number}.locations"));
    assert!(locations.rows().len() <= MOST);
    Seen {
        camera: camera(&golden.cases["scenes"][number]["camera"]),
        locations: locations.rows().map(fixed).collect(),
    }
}

impl Seen {
    fn check(&self) -> Result<(), Refusal> {
        let mut raw = RawScene::empty(&TABLETOP, self.camera);
        for (id, location) in (1..).zip(&self.locations) {
            let object = ObservedObject {
                id,
                location: *location,
                ..ObservedObject::EMPTY
            };
            raw.push(object).expect("at most MAX_OBJECTS");
        }
        let scene = Scene::new(raw, &TABLETOP).expect("a scene in order");
        Planner::new(&TABLETOP).check(&scene)
    }

    fn fault(&self) -> CalibrationFault {
        match self.check() {
            Err(Refusal::Calibration(fault)) => fault,
            other => panic!("{other:?}"),
        }
    }

    /// The same in a world that is rotated about the vertical axis and shifted along the table.
    fn moved(&self, yaw_rad: f32, [along, across]: [f32; 2]) -> Self {
        let (sin, cos) = yaw_rad.sin_cos();
        let [x, y, z] = self.camera.position;
        let (half_sin, half_cos) = (0.5 * yaw_rad).sin_cos();
        let [i, j, k, w] = self.camera.orientation;
        let camera = Camera {
            position: [cos * x - sin * y + along, sin * x + cos * y + across, z],
            // The rotation (0, 0, sin, cos), times the camera's own.
            orientation: [
                half_cos * i - half_sin * j,
                half_cos * j + half_sin * i,
                half_cos * k + half_sin * w,
                half_cos * w - half_sin * k,
            ],
            ..self.camera
        };
        Self {
            camera,
            ..self.clone()
        }
    }

    fn higher(mut self, by_m: f32) -> Self {
        self.camera.position[2] += by_m;
        self
    }

    fn with_depths(mut self, factor: f32) -> Self {
        for location in &mut self.locations {
            location[4] *= factor;
        }
        self
    }
}

fn any_yaw_and_shift() -> impl Strategy<Value = (f32, [f32; 2])> {
    (-3.2_f32..3.2, [-20.0_f32..20.0, -20.0_f32..20.0])
}

/// The noise of a detector: half a pixel at each side of a box, 1.5 mm of depth.
fn noise() -> impl Strategy<Value = Vec<[f32; LOCATION]>> {
    let sides = [-0.5_f32..0.5, -0.5..0.5, -0.5..0.5, -0.5..0.5];
    let one = (sides, -0.0015_f32..0.0015).prop_map(|([x1, y1, x2, y2], depth)| {
        [x1 / 640.0, y1 / 480.0, x2 / 640.0, y2 / 480.0, depth]
    });
    vec(one, MOST)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, ..ProptestConfig::default() })]

    #[test]
    fn what_is_calibrated_passes_wherever_the_world_begins(
        number in 0..RENDERED,
        (yaw_rad, shift) in any_yaw_and_shift(),
        noise in noise(),
    ) {
        let mut seen = rendered(number).moved(yaw_rad, shift);
        for (location, noise) in seen.locations.iter_mut().zip(&noise) {
            for (number, noise) in location.iter_mut().zip(noise) {
                *number += noise;
            }
        }
        prop_assert_eq!(seen.check(), Ok(()));
    }

    #[test]
    fn a_height_that_is_off_is_found_wherever_the_world_begins(
        number in 0..RENDERED,
        (yaw_rad, shift) in any_yaw_and_shift(),
        by_m in 0.015_f32..0.5,
        is_higher: bool,
    ) {
        let by_m = if is_higher { by_m } else { -by_m };
        let fault = rendered(number).moved(yaw_rad, shift).higher(by_m).fault();
        prop_assert_eq!(fault.quantity, Measured::Height);
        prop_assert!((fault.measured_m - fault.expected_m - by_m).abs() < 0.012, "{:?}", fault);
    }

    #[test]
    fn depths_that_are_off_are_found(number in 0..RENDERED, percent in 3.0_f32..10.0) {
        let fault = rendered(number).with_depths(1.0 - 0.01 * percent).fault();
        prop_assert!(fault.measured_m > fault.expected_m || fault.quantity == Measured::Width);
        let fault = rendered(number).with_depths(1.0 + 0.01 * percent).fault();
        prop_assert!(fault.measured_m < fault.expected_m || fault.quantity == Measured::Width);
    }
}

/// A frame of a camera process with its orientation as w, x, y, z, or with depths in millimetres:
/// the client of the planner is told.
#[test]
fn frames_in_other_units_and_conventions_are_told_as_such() {
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let picture = picture::squares();
    let mut image = picture.pixels.clone();
    image.resize(picture.pixels.len() / 3 * 7, 0);
    let check = |frame: &CameraFrame| {
        let message = see(&TABLETOP, frame, &image).expect("a frame in order");
        let scene = message.to_scene(&TABLETOP).expect("a scene in order");
        Planner::new(&TABLETOP).check(&scene)
    };
    let cause = |frame: &CameraFrame| match check(frame) {
        Err(Refusal::Calibration(fault)) => fault.cause,
        other => panic!("{other:?}"),
    };
    let mut frame = picture.frame();
    frame.camera.orientation = [half, -half, 0.0, 0.0];
    assert_eq!(check(&frame), Ok(()));
    let mut w_first = frame;
    w_first.camera.orientation.rotate_right(1);
    assert_eq!(cause(&w_first), Some(Cause::OrientationWxyz));
    let mut millimetres = frame;
    for found in &mut millimetres.boxes {
        found.location[4] *= 1000.0;
    }
    assert_eq!(cause(&millimetres), Some(Cause::DepthsInMillimetres));
}
