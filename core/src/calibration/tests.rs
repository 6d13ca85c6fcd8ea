use core::task::Poll;
use std::boxed::Box;
use std::string::ToString;

use nalgebra::{UnitQuaternion, Vector3};

use super::*;
use crate::camera::rotation;
use crate::fixture;
use crate::model::{Concept, PixelToCamera};
use crate::scene::{ObservedObject, RawScene};
use crate::{Camera, Planner, Refusal};

/// Edges of the blocks of `tabletop`, metres.
const LEGO: [f32; 3] = [0.06, 0.06, 0.05];
const SMALL: [f32; 3] = [0.04, 0.04, 0.04];

/// Boxes and mean depths of six blocks as the harness's renderer shows them to its default
/// camera (seed 0, scene 30 of the first kind of `harness miscalibration`), ids from 1: three
/// small blocks, a lego block, another one on it, another one.
const SEEN: [[f32; 5]; 6] = [
    [0.590_625, 0.666_666_7, 0.65, 0.770_833_3, 1.065_138_9],
    [0.268_75, 0.679_166_7, 0.340_625, 0.791_666_7, 1.057_087_5],
    [0.478_125, 0.743_75, 0.540_625, 0.858_333_35, 1.019_117_4],
    [0.75, 0.531_25, 0.839_062_5, 0.654_166_64, 1.136_516_9],
    [0.754_687_5, 0.460_416_67, 0.851_562_5, 0.5875, 1.107_736],
    [0.629_687_5, 0.520_833_3, 0.726_562_5, 0.656_25, 1.139_558_4],
];
/// The one that stands on number 4.
const UPPER: usize = 4;

/// The default camera of the harness.
fn camera() -> Camera {
    Camera {
        width: 640,
        height: 480,
        fx: 936.0,
        fy: 936.0,
        cx: 320.0,
        cy: 240.0,
        position: [1.3, 0.0, 0.8],
        orientation: [0.639_582_8, 0.639_582_8, -0.301_552_4, -0.301_552_4],
    }
}

/// The fixture with the sizes of `tabletop` and the map that was fitted for its camera.
fn model() -> Model<'static> {
    let map = PixelToCamera {
        weight: [
            [
                1.008_701, 0.000_057, 0.000_323, -0.002_732, 0.001_901, -0.000_313,
            ],
            [
                -0.000_075, 1.014_861, -0.001_523, -0.018_712, -0.050_688, 0.005_084,
            ],
            [
                0.000_177, -0.006_298, 1.000_126, -0.127_961, 0.386_487, -0.001_869,
            ],
        ],
    };
    let fixture = fixture::model();
    let concepts = fixture.concepts.iter().map(|concept| Concept {
        edges_m: match concept.name {
            "lego" => Some(LEGO),
            "small" => Some(SMALL),
            _ => None,
        },
        ..*concept
    });
    Model {
        camera: Box::leak(Box::new(map)),
        concepts: Box::leak(concepts.collect()),
        ..fixture
    }
}

/// The scene with a changed camera and changed locations.
fn changed(change: impl FnOnce(&mut Camera, &mut [[f32; 5]])) -> Result<(), CalibrationFault> {
    let model = model();
    let (mut camera, mut locations) = (camera(), SEEN);
    change(&mut camera, &mut locations);
    check(&model, &scene_of(&model, camera, &locations))
}

fn scene_of(model: &Model<'_>, camera: Camera, locations: &[[f32; 5]]) -> Scene {
    let mut raw = RawScene::empty(model, camera);
    for (id, location) in (1..).zip(locations) {
        let object = ObservedObject {
            id,
            location: *location,
            ..ObservedObject::EMPTY
        };
        raw.push(object).unwrap();
    }
    Scene::new(raw, model).unwrap()
}

#[track_caller]
fn fault(change: impl FnOnce(&mut Camera, &mut [[f32; 5]])) -> CalibrationFault {
    changed(change).expect_err("a scene that disagrees")
}

/// The camera turned by so many degrees about an axis of its own.
fn turned(camera: &mut Camera, axis: Vector3<f32>, degrees: f32) {
    let turn = UnitQuaternion::from_scaled_axis(axis * degrees.to_radians());
    let orientation = rotation(&camera.orientation) * turn;
    camera.orientation = orientation.coords.into();
}

fn scaled(locations: &mut [[f32; 5]], factor: f32) {
    for location in locations {
        location[4] *= factor;
    }
}

#[test]
fn what_agrees_with_the_calibration_passes() {
    assert_eq!(changed(|_, _| ()), Ok(()));
    // So does each object alone, and an empty scene.
    let model = model();
    for (index, location) in SEEN.iter().enumerate() {
        let alone = check(&model, &scene_of(&model, camera(), &[*location]));
        assert_eq!(alone.is_ok(), index != UPPER, "{alone:?}");
    }
    assert_eq!(check(&model, &scene_of(&model, camera(), &[])), Ok(()));
}

#[test]
fn a_pose_that_is_too_high_or_too_low_is_found() {
    for (by_m, sign) in [(0.05, 1.0), (-0.05, -1.0), (0.01, 1.0), (-0.01, -1.0)] {
        let fault = fault(|camera, _| camera.position[2] += by_m);
        assert_eq!(fault.quantity, Measured::Height);
        let off_m = fault.measured_m - fault.expected_m;
        assert!(
            (off_m - by_m).abs() < 0.005 && off_m * sign > 0.0,
            "{fault:?}"
        );
        // All but the covered one, and the one on it, of which the table says nothing.
        assert_eq!((fault.disagreeing, fault.whole), (4, 4), "{fault:?}");
        assert_eq!(fault.cause, None);
    }
}

#[test]
fn depths_that_are_too_short_or_too_long_are_found() {
    for (factor, sign) in [(0.95, 1.0), (1.05, -1.0), (0.98, 1.0), (1.02, -1.0)] {
        let fault = fault(|_, locations| scaled(locations, factor));
        assert_eq!(fault.quantity, Measured::Height, "{fault:?}");
        assert!((fault.measured_m - fault.expected_m) * sign > 0.006);
        assert_eq!(fault.cause, None);
    }
}

#[test]
fn a_camera_that_is_tilted_rolled_or_turned_by_three_degrees_is_found() {
    for degrees in [3.0, -3.0] {
        let pitch = fault(|camera, _| turned(camera, Vector3::x(), degrees));
        assert_eq!(pitch.quantity, Measured::Height);
        assert!((pitch.measured_m - pitch.expected_m).abs() > 0.03);
        for axis in [Vector3::y(), Vector3::z()] {
            let fault = fault(|camera, _| turned(camera, axis, degrees));
            assert_eq!(fault.cause, None, "{axis} {fault:?}");
        }
    }
    // By less, no object is far from the table, but the table is not level.
    let rolled = fault(|camera, _| turned(camera, Vector3::z(), 1.5));
    assert_eq!(rolled.quantity, Measured::Rise);
    assert!(rolled.measured_m > TOLERANCE_M && rolled.measured_m < 0.02);
    assert_eq!((rolled.object, rolled.expected_m), (2, 0.0));
    let back = fault(|camera, _| turned(camera, Vector3::z(), -1.5));
    assert_eq!((back.quantity, back.object), (Measured::Rise, 5));
}

#[test]
fn sizes_that_no_object_has_are_found() {
    let wide = fault(|camera, _| (camera.fx, camera.fy) = (468.0, 468.0));
    assert_eq!(wide.quantity, Measured::Width);
    assert!(wide.measured_m > 0.1, "{wide:?}");
    // The diagonal of the larger block's base.
    assert!((wide.expected_m - 0.06 * core::f32::consts::SQRT_2).abs() < 1e-6);
    let narrow = fault(|camera, _| camera.fx = 1872.0);
    assert_eq!(narrow.quantity, Measured::Width);
    assert!(narrow.measured_m < 0.04 && (narrow.expected_m == 0.04));
}

#[test]
fn millimetres_are_told_as_such() {
    let depths = fault(|_, locations| scaled(locations, 1000.0));
    assert_eq!(depths.cause, Some(Cause::DepthsInMillimetres));
    let position = fault(|camera, _| camera.position = [1300.0, 0.0, 800.0]);
    assert_eq!(position.cause, Some(Cause::PositionInMillimetres));
    let both = fault(|camera, locations| {
        camera.position = [1300.0, 0.0, 800.0];
        scaled(locations, 1000.0);
    });
    assert_eq!(both.cause, Some(Cause::LengthsInMillimetres));
    // Also when the pose is off as well.
    let off = fault(|camera, locations| {
        camera.position[2] += 0.03;
        scaled(locations, 1000.0);
    });
    assert_eq!(off.cause, Some(Cause::DepthsInMillimetres));
}

#[test]
fn other_conventions_for_a_pose_are_told_as_such() {
    let wxyz = fault(|camera, _| camera.orientation.rotate_right(1));
    assert_eq!(wxyz.cause, Some(Cause::OrientationWxyz));
    // By that mistake an object may lie about as high as the camera, of which a thousandth is
    // no height; but the camera is not so far away that its position may be in millimetres.
    let model = model();
    for location in &SEEN {
        let mut camera = camera();
        camera.orientation.rotate_right(1);
        let fault = check(&model, &scene_of(&model, camera, &[*location])).unwrap_err();
        assert_ne!(fault.cause, Some(Cause::PositionInMillimetres), "{fault:?}");
    }
    let inverted = fault(|camera, _| {
        let pose = camera.world_from_camera().inverse();
        camera.position = pose.translation.vector.into();
        camera.orientation = pose.rotation.coords.into();
    });
    assert_eq!(inverted.cause, Some(Cause::PoseInverted));
    let opengl = fault(|camera, _| turned(camera, Vector3::x(), 180.0));
    assert_eq!(opengl.cause, Some(Cause::AxesOfOpenGl));
}

#[test]
fn one_object_may_be_held_or_hidden_without_anyones_knowing() {
    // Seen 3 cm too near: too high, too.
    let nearer = |index: usize| changed(|_, locations| locations[index][4] -= 0.03);
    for index in [0, 1, 2, 5] {
        assert_eq!(nearer(index), Ok(()), "{index}");
    }
    let two = fault(|_, locations| {
        locations[0][4] -= 0.03;
        locations[1][4] -= 0.03;
    });
    assert_eq!((two.disagreeing, two.whole), (2, 5));
    assert_eq!(two.object, 1);
}

#[test]
fn what_a_hidden_object_bears_counts_only_where_nothing_else_does() {
    let model = model();
    let check = |rows: &[usize]| {
        let locations: std::vec::Vec<_> = rows.iter().map(|row| SEEN[*row]).collect();
        check(&model, &scene_of(&model, camera(), &locations))
    };
    // The tower alone, then without what bears it.
    assert_eq!(check(&[3, UPPER]), Ok(()));
    let fault = check(&[UPPER]).unwrap_err();
    assert_eq!((fault.disagreeing, fault.whole), (1, 1));
    // A tower alone that is 5 cm too high or too low.
    for by_m in [0.05, -0.05] {
        let mut camera = camera();
        camera.position[2] += by_m;
        let scene = scene_of(&model, camera, &[SEEN[3], SEEN[UPPER]]);
        let fault = super::check(&model, &scene).unwrap_err();
        assert_eq!(fault.object, 2, "{fault:?}");
    }
}

#[test]
fn numbers_that_overflow_are_no_agreement() {
    for change in [
        |camera: &mut Camera| camera.position[2] = f32::MAX,
        |camera: &mut Camera| camera.fx = f32::MIN_POSITIVE,
        |camera: &mut Camera| (camera.cy, camera.fy) = (f32::MAX, f32::MIN_POSITIVE),
    ] {
        let fault = fault(|camera, _| change(camera));
        assert!(!fault.to_string().is_empty());
    }
}

#[test]
fn the_message_says_what_is_wrong_where_and_what_to_do() {
    let high = fault(|camera, _| camera.position[2] += 0.05);
    assert_eq!(
        high.to_string(),
        "what is seen disagrees with the camera's calibration: object 1 is seen at a height of \
         0.070 m, but would rest at 0.020 m (4 of 4 objects disagree); the camera's pose may be \
         too high, or depths too short: calibrate the camera again, and see that nothing holds \
         or covers the object"
    );
    let millimetres = fault(|_, locations| scaled(locations, 1000.0));
    let message = millimetres.to_string();
    assert!(
        message.starts_with("depths look like millimetres; NSRM wants metres: object "),
        "{message}"
    );
    assert!(
        message.ends_with("; divide the depths by 1000"),
        "{message}"
    );
}

#[test]
fn planning_refuses_at_once_and_call_by_call() {
    let model = fixture::model();
    let mut raw = *fixture::scene(&model).raw();
    raw.camera.position[2] += 0.05;
    let scene = Scene::new(raw, &model).unwrap();
    let planner = Planner::new(&model);
    let Err(Refusal::Calibration(fault)) = planner.check(&scene) else {
        panic!("it disagrees");
    };
    let refusal = Refusal::Calibration(fault);
    assert_eq!(refusal.kind(), "calibration");
    let refusal = Err(refusal);
    let sentence = "put small red on green";
    assert_eq!(planner.plan(&scene, sentence), refusal);
    let parsed = planner.parse(sentence).unwrap();
    let mut task = planner.begin_grounding(&scene, &parsed, 0);
    let polled = loop {
        if let Poll::Ready(result) = task.poll() {
            break result.cloned();
        }
    };
    assert_eq!(polled, refusal);
}
