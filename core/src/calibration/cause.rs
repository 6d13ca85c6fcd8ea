use nalgebra::{Isometry3, Quaternion, UnitQuaternion};

use crate::camera::Camera;
use crate::scene::Scene;

/// A unit or convention other than ours that a scene seems to use.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Cause {
    /// Depths are in millimetres.
    DepthsInMillimetres,
    /// The camera's position is in millimetres.
    PositionInMillimetres,
    /// Both are.
    LengthsInMillimetres,
    /// The camera's orientation is w, x, y, z. Not detected if the camera also looks down on the
    /// table when this is read as x, y, z, w, as with some cameras that look straight down.
    OrientationWxyz,
    /// The camera's pose takes the world's frame to the camera's.
    PoseInverted,
    /// The camera's frame is that of OpenGL: y up, z backward.
    AxesOfOpenGl,
}

/// An interpretation of a scene's numbers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reading {
    pub(super) camera: Camera,
    /// The factor on depths.
    pub(super) depth_scale: f32,
}

impl Reading {
    /// Our units and conventions.
    pub(super) const fn as_given(camera: &Camera) -> Self {
        Self {
            camera: *camera,
            depth_scale: 1.0,
        }
    }
}

impl Cause {
    /// All of them, the likelier ones first.
    pub(crate) const ALL: [Self; 6] = [
        Self::DepthsInMillimetres,
        Self::PositionInMillimetres,
        Self::LengthsInMillimetres,
        Self::OrientationWxyz,
        Self::PoseInverted,
        Self::AxesOfOpenGl,
    ];

    /// The name in snake case, as in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::DepthsInMillimetres => "depths_in_millimetres",
            Self::PositionInMillimetres => "position_in_millimetres",
            Self::LengthsInMillimetres => "lengths_in_millimetres",
            Self::OrientationWxyz => "orientation_wxyz",
            Self::PoseInverted => "pose_inverted",
            Self::AxesOfOpenGl => "axes_of_opengl",
        }
    }

    /// Whether it is plausible: millimetres only if a length exceeds [`FAR_M`], which no distance
    /// of a camera from its objects or its robot does in metres.
    pub(super) fn is_possible(self, scene: &Scene) -> bool {
        let far = |length: f32| length.abs() > FAR_M;
        let depths = || scene.objects().iter().any(|object| far(object.depth_m()));
        let position = || scene.camera().position.into_iter().any(far);
        match self {
            Self::DepthsInMillimetres => depths(),
            Self::PositionInMillimetres => position(),
            Self::LengthsInMillimetres => depths() && position(),
            Self::OrientationWxyz | Self::PoseInverted | Self::AxesOfOpenGl => true,
        }
    }

    /// The scene with this camera in our units and conventions.
    pub(super) fn reading(self, camera: &Camera) -> Reading {
        let mut reading = Reading::as_given(camera);
        let camera = &mut reading.camera;
        match self {
            Self::DepthsInMillimetres => reading.depth_scale = METRES,
            Self::PositionInMillimetres => camera.position = in_metres(camera.position),
            Self::LengthsInMillimetres => {
                reading.depth_scale = METRES;
                camera.position = in_metres(camera.position);
            }
            Self::OrientationWxyz => {
                let [w, x, y, z] = camera.orientation;
                camera.orientation = [x, y, z, w];
            }
            Self::PoseInverted => set_pose(camera, camera.world_from_camera().inverse()),
            Self::AxesOfOpenGl => {
                // Half a turn about x.
                let half = UnitQuaternion::new_unchecked(Quaternion::new(0.0, 1.0, 0.0, 0.0));
                set_pose(camera, camera.world_from_camera() * half);
            }
        }
        reading
    }
}

/// Lengths above this are not in metres.
const FAR_M: f32 = 10.0;
/// A millimetre in metres.
const METRES: f32 = 0.001;

fn in_metres(millimetres: [f32; 3]) -> [f32; 3] {
    millimetres.map(|length| length * METRES)
}

fn set_pose(camera: &mut Camera, world_from_camera: Isometry3<f32>) {
    camera.position = world_from_camera.translation.vector.into();
    camera.orientation = world_from_camera.rotation.coords.into();
}
