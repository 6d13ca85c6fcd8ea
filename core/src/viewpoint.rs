//! Any camera's view as the training's camera would have it. The action simulator predicts in the
//! image of one camera, and what it has learned holds nowhere else: with a camera at another distance
//! it would place objects centimetres off.
//!
//! What the scene's camera observes is taken to the world, and from there to the image of the training's
//! camera, as far to the side of the table as the scene's camera stands: what is left for the viewer is
//! left there. A predicted location goes the same way back.

use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};

use crate::camera::Camera;
use crate::model::{LOCATION, Model, PixelToCamera, WorkSpace};

/// How much lower than in training the camera may stand, as seen from an object: 12°, in radians. From
/// 20° lower, two of 80 plans moved another block, since the crops look different; from 10°, none of 198.
const LOWER: f32 = 0.21;

/// The scene's camera and that of the training.
///
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/observed/mod.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use nsrm_core::viewpoint::Viewpoint;
/// use nsrm_tabletop::TABLETOP;
///
/// # let scene = scene(&TABLETOP);
/// let mut camera = *scene.camera();
/// let same = Viewpoint::new(&TABLETOP, &camera);
/// let location = scene.objects()[0].location;
/// assert_eq!(same.to_training(&location), location);
/// camera.position[2] += 0.3;
/// let higher = Viewpoint::new(&TABLETOP, &camera);
/// let back = higher.from_training(&higher.to_training(&location));
/// assert!(back.iter().zip(location).all(|(back, there)| (back - there).abs() < 1e-4));
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Viewpoint<'m> {
    map: &'m PixelToCamera,
    /// The inverse of the map's first three columns, by rows.
    inverse: [Vector3<f32>; 3],
    scene: View,
    training: View,
    is_same: bool,
}

/// A camera and its pose.
#[derive(Debug, Clone, Copy)]
struct View {
    camera: Camera,
    world_from_camera: Isometry3<f32>,
}

impl<'m> Viewpoint<'m> {
    /// * `camera`: that of the scene, which is valid
    pub fn new(model: &Model<'m>, camera: &Camera) -> Self {
        let learned = model.header.training_camera;
        let is_same = learned == *camera;
        let (scene, learned) = (View::new(camera), View::new(&learned));
        let training = if is_same {
            learned
        } else {
            learned.turned_to(&scene, &model.header.work_space)
        };
        Self {
            map: model.camera,
            inverse: inverse(model.camera),
            scene,
            training,
            is_same,
        }
    }

    /// The camera of the training, turned about the middle of the work space to where the scene's
    /// stands.
    pub const fn training(&self) -> &Camera {
        &self.training.camera
    }

    /// A location in the image of the scene's camera as the training's would have it: its position in
    /// the world is the same. The height of its box is that of a cube, seen from there.
    ///
    /// Without any change if the scene's camera is that of the training. Not finite if the location
    /// isn't, or is in the plane of a camera.
    ///
    /// Cost: two deprojections and two square roots.
    pub fn to_training(&self, location: &[f32; LOCATION]) -> [f32; LOCATION] {
        self.reproject(location, &self.scene, &self.training)
    }

    /// The inverse of [`Viewpoint::to_training`].
    pub fn from_training(&self, location: &[f32; LOCATION]) -> [f32; LOCATION] {
        self.reproject(location, &self.training, &self.scene)
    }

    /// Whether the centre of a location lies in the image of the training's camera, and the scene's
    /// camera sees it from hardly lower.
    ///
    /// * `location`: in that image, as [`Viewpoint::to_training`] gives it
    pub(crate) fn contains(&self, location: &[f32; LOCATION]) -> bool {
        let [x1, y1, x2, y2, depth] = *location;
        let centre = [0.5 * (x1 + x2), 0.5 * (y1 + y2)];
        let is_inside = depth > 0.0 && centre.iter().all(|part| (0.0..=1.0).contains(part));
        if self.is_same || !is_inside {
            return is_inside;
        }
        let place = self.training.camera.locate(self.map, location);
        self.training.elevation(&place) - self.scene.elevation(&place) <= LOWER
    }

    fn reproject(&self, location: &[f32; LOCATION], from: &View, to: &View) -> [f32; LOCATION] {
        if self.is_same {
            return *location;
        }
        let [x, y, depth, width_m, height_m, one] = from.camera.deproject(location);
        let seen = Camera::centre(self.map, &[x, y, depth, width_m, height_m, one]);
        let place = from.world_from_camera * seen;
        let height_m = height_m / from.share_of_height(&place) * to.share_of_height(&place);
        self.project(&place, width_m, height_m, to)
    }

    /// A location in the image of the training's camera, if the object is shifted along the table.
    ///
    /// * `x_m`, `y_m`: by how much, in the world
    ///
    /// Cost: a deprojection, a projection and two square roots.
    pub(crate) fn shifted(
        &self,
        location: &[f32; LOCATION],
        x_m: f32,
        y_m: f32,
    ) -> [f32; LOCATION] {
        let view = &self.training;
        let deprojected = view.camera.deproject(location);
        let [_, _, _, width_m, height_m, _] = deprojected;
        let place = view.world_from_camera * Camera::centre(self.map, &deprojected);
        let to = Point3::new(place.x + x_m, place.y + y_m, place.z);
        let height_m = height_m / view.share_of_height(&place) * view.share_of_height(&to);
        self.project(&to, width_m, height_m, view)
    }

    /// The location of a box in the image of a camera.
    ///
    /// * `place`: of its centre, in the world
    fn project(
        &self,
        place: &Point3<f32>,
        width_m: f32,
        height_m: f32,
        camera: &View,
    ) -> [f32; LOCATION] {
        // What of the position the map's first three columns have to give.
        let offset = Camera::centre(self.map, &[0.0, 0.0, 0.0, width_m, height_m, 1.0]);
        let rest = camera.world_from_camera.inverse_transform_point(place) - offset;
        let [x, y, depth] = self.inverse.map(|row| row.dot(&rest));
        camera.camera.project(&[x, y, depth, width_m, height_m])
    }

    /// The location of a cube in the image of the training's camera.
    ///
    /// * `place`: of its centre, in the world
    ///
    /// Cost: a projection and four square roots.
    pub(crate) fn locate(&self, place: &Point3<f32>, edge_m: f32) -> [f32; LOCATION] {
        let height_m = edge_m * self.training.share_of_height(place);
        self.project(place, edge_m, height_m, &self.training)
    }
}

impl View {
    fn new(camera: &Camera) -> Self {
        Self {
            camera: *camera,
            world_from_camera: camera.world_from_camera(),
        }
    }

    /// This view turned about the vertical through the middle of the work space, so that it looks in
    /// the direction of another one.
    fn turned_to(self, other: &Self, work_space: &WorkSpace) -> Self {
        let ([ax, ay], [bx, by]) = (self.ahead(), other.ahead());
        let (cosine, sine) = (ax * bx + ay * by, ax * by - ay * bx);
        // Half the angle; opposite directions give a half turn.
        let (w, z) = if 1.0 + cosine > 1e-6 {
            (1.0 + cosine, sine)
        } else {
            (0.0, 1.0)
        };
        let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, 0.0, 0.0, z));
        let [x, y] = work_space.middle();
        let middle = Vector3::new(x, y, 0.0);
        let pose = self.world_from_camera;
        let position = turn * (pose.translation.vector - middle) + middle;
        let rotation = turn * pose.rotation;
        Self {
            camera: Camera {
                position: position.into(),
                orientation: rotation.coords.into(),
                ..self.camera
            },
            world_from_camera: Isometry3::from_parts(Translation3::from(position), rotation),
        }
    }

    /// The horizontal direction away from the viewer, of length 1: forwards and upwards in the image,
    /// one of which has a horizontal part however far the camera is tilted; x if none has.
    fn ahead(&self) -> [f32; 2] {
        let [x, y, _]: [f32; 3] =
            (self.world_from_camera.rotation * Vector3::new(0.0, -1.0, 1.0)).into();
        let length = libm::sqrtf(x * x + y * y);
        if length > 1e-6 {
            [x / length, y / length]
        } else {
            [1.0, 0.0]
        }
    }

    /// The angle above the horizon under which a place sees the camera.
    fn elevation(&self, place: &Point3<f32>) -> f32 {
        let [x, y, z]: [f32; 3] = (place.coords - self.world_from_camera.translation.vector).into();
        libm::atan2f(-z, libm::sqrtf(x * x + y * y))
    }

    /// The apparent height of a cube at a place as a share of its edge: its front and its upper face.
    fn share_of_height(&self, place: &Point3<f32>) -> f32 {
        let [x, y, z]: [f32; 3] = (place.coords - self.world_from_camera.translation.vector).into();
        let aside = libm::sqrtf(x * x + y * y);
        let distance = libm::sqrtf(x * x + y * y + z * z);
        // Less only from below the table.
        ((aside - z) / distance).max(0.5)
    }
}

/// The inverse of the map's first three columns, by rows; not finite if there is none.
fn inverse(map: &PixelToCamera) -> [Vector3<f32>; 3] {
    let [a, b, c] = map.weight.map(|[x, y, z, ..]| Vector3::new(x, y, z));
    let columns = [b.cross(&c), c.cross(&a), a.cross(&b)];
    let determinant = a.dot(&b.cross(&c));
    let [p, q, r] = columns.map(|column| column / determinant);
    [
        Vector3::new(p.x, q.x, r.x),
        Vector3::new(p.y, q.y, r.y),
        Vector3::new(p.z, q.z, r.z),
    ]
}

#[cfg(test)]
mod tests {
    use std::boxed::Box;

    use super::*;
    use crate::fixture;

    /// A map with every term, close to the identity.
    const MAP: PixelToCamera = PixelToCamera {
        weight: [
            [1.01, 0.02, -0.01, 0.03, -0.02, 0.001],
            [-0.02, 0.97, 0.03, 0.05, 0.04, -0.002],
            [0.01, 0.04, 1.02, 0.2, 0.15, 0.005],
        ],
    };

    fn model() -> Model<'static> {
        Model {
            camera: Box::leak(Box::new(MAP)),
            ..fixture::model()
        }
    }

    /// Looks at the middle of the work space, upright.
    ///
    /// * `azimuth`: to which side of it the camera stands; 0 is +x
    /// * `elevation`: above the horizon, both in degrees
    fn around(azimuth: f32, elevation: f32, distance_m: f32) -> Camera {
        let (azimuth, tilt) = (azimuth.to_radians(), (90.0 - elevation).to_radians());
        let z = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), azimuth);
        // Straight down, image right towards +y; then tilted, then turned.
        let down = UnitQuaternion::from_quaternion(Quaternion::new(0.0, 1.0, 1.0, 0.0));
        let tilted = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), tilt);
        let rotation = z * tilted * down;
        let position = rotation * Vector3::new(0.0, 0.0, -distance_m) + Vector3::new(0.5, 0.0, 0.0);
        Camera {
            width: 640,
            height: 480,
            fx: 500.0,
            fy: 520.0,
            cx: 330.0,
            cy: 235.0,
            position: position.into(),
            orientation: rotation.coords.into(),
        }
    }

    /// A block in the image of [`around`]'s cameras.
    const SEEN: [f32; LOCATION] = [0.4, 0.3, 0.5, 0.42, 0.9];

    fn is_near(left: &[f32], right: &[f32]) -> bool {
        left.len() == right.len() && left.iter().zip(right).all(|(l, r)| (l - r).abs() < 1e-4)
    }

    #[test]
    fn the_place_in_the_world_stays() {
        let model = model();
        for azimuth in [0.0, 30.0, -120.0, 180.0] {
            for (elevation, distance_m) in [(20.0, 1.2), (45.0, 0.7), (90.0, 1.0)] {
                let camera = around(azimuth, elevation, distance_m);
                let viewpoint = Viewpoint::new(&model, &camera);
                let seen = viewpoint.to_training(&SEEN);
                let [before, after] = [
                    camera.locate(model.camera, &SEEN),
                    viewpoint.training().locate(model.camera, &seen),
                ];
                assert!(
                    (before - after).norm() < 1e-4,
                    "{azimuth} {elevation}: {before} {after}"
                );
                let width_m = viewpoint.training().width_m(&seen);
                assert!((width_m - camera.width_m(&SEEN)).abs() < 1e-5);
                assert!(is_near(&viewpoint.from_training(&seen), &SEEN));
            }
        }
    }

    #[test]
    fn the_camera_of_the_training_changes_nothing() {
        let model = model();
        let viewpoint = Viewpoint::new(&model, &model.header.training_camera);
        assert_eq!(*viewpoint.training(), model.header.training_camera);
        assert_eq!(viewpoint.to_training(&SEEN), SEEN);
        assert_eq!(viewpoint.from_training(&SEEN), SEEN);
    }

    #[test]
    fn left_stays_left_wherever_the_viewer_stands() {
        let mut model = model();
        model.header.training_camera = around(0.0, 40.0, 1.2);
        let position = |camera: &Camera| Vector3::from(camera.position);
        for azimuth in [0.0, 90.0, 180.0, -135.0] {
            let camera = around(azimuth, 40.0, 1.2);
            let viewpoint = Viewpoint::new(&model, &camera);
            let offset = position(viewpoint.training()) - position(&camera);
            assert!(offset.norm() < 1e-5, "{azimuth}: {offset}");
            assert!(is_near(&viewpoint.to_training(&SEEN), &SEEN), "{azimuth}");
        }
    }

    /// A cube's image: from above its upper face, from the side its front.
    #[test]
    fn the_height_of_a_box_is_that_of_a_cube() {
        let share = |elevation: f32| {
            let view = View::new(&around(60.0, elevation, 1.5));
            view.share_of_height(&Point3::new(0.5, 0.0, 0.0))
        };
        for (elevation, expected) in [
            (0.0, 1.0),
            (30.0, 0.5 + libm::sqrtf(0.75)),
            (45.0, core::f32::consts::SQRT_2),
            (90.0, 1.0),
        ] {
            let got = share(elevation);
            assert!((got - expected).abs() < 1e-4, "{elevation}: {got}");
        }
    }

    #[test]
    fn a_camera_without_a_direction_is_turned_nowhere() {
        // Looks up and ahead at once: forwards and upwards in the image cancel out.
        let up = Camera {
            orientation: [-0.382_683_43, 0.0, 0.0, 0.923_879_5],
            ..around(0.0, 45.0, 1.0)
        };
        let ahead = View::new(&up).ahead();
        assert!((ahead[0].abs() + ahead[1].abs()).is_finite());
        let moved = Viewpoint::new(&model(), &up).to_training(&SEEN);
        assert!(moved.iter().all(|number| number.is_finite()));
    }

    #[test]
    fn a_map_without_an_inverse_gives_no_numbers() {
        let flat = PixelToCamera {
            weight: [[1.0; 6]; 3],
        };
        let model = Model {
            camera: Box::leak(Box::new(flat)),
            ..fixture::model()
        };
        let camera = around(10.0, 50.0, 1.0);
        let moved = Viewpoint::new(&model, &camera).to_training(&SEEN);
        assert!(!moved.iter().all(|number| number.is_finite()));
    }

    #[test]
    fn what_the_camera_of_the_training_would_not_see_is_outside() {
        let model = model();
        let viewpoint = Viewpoint::new(&model, &fixture::camera());
        assert!(viewpoint.contains(&SEEN));
        assert!(!viewpoint.contains(&[0.9, 0.3, 1.2, 0.4, 0.9]));
        assert!(!viewpoint.contains(&[0.4, -0.3, 0.5, 0.2, 0.9]));
        assert!(!viewpoint.contains(&[0.4, 0.3, 0.5, 0.4, -0.9]));
        assert!(!viewpoint.contains(&[f32::NAN; LOCATION]));
    }

    #[test]
    fn what_is_seen_from_much_lower_is_outside() {
        let mut model = model();
        model.header.training_camera = around(0.0, 40.0, 1.2);
        for (elevation, expected) in [(90.0, true), (40.0, true), (30.0, true), (25.0, false)] {
            let viewpoint = Viewpoint::new(&model, &around(20.0, elevation, 1.2));
            let seen = viewpoint.to_training(&[0.48, 0.45, 0.54, 0.52, 1.19]);
            assert_eq!(viewpoint.contains(&seen), expected, "{elevation}");
        }
    }
}
