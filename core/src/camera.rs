//! From the image to the world (section III): a location, in fractions of the
//! image and metres along the optical axis, to a point in the world's frame.
//!
//! The camera is a pinhole without distortion. Its optical frame: x right, y
//! down, z forward; pixel (i, j) is sampled at (i + ½, j + ½). The world's frame:
//! robot base at the origin, x forward, y left, z up, metres.

use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion};
use thiserror::Error;

use crate::model::{LOCATION, PixelToCamera};
use crate::nn::{dot, is_unit};

/// Intrinsics and pose of the camera. Plain data, with the same bytes in shared memory;
/// [`Camera::check`] tells whether it is valid.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Camera {
    /// Width of the image in pixels.
    pub width: u32,
    /// Height of the image in pixels.
    pub height: u32,
    /// Focal length along x in pixels.
    pub fx: f32,
    /// Focal length along y in pixels.
    pub fy: f32,
    /// x of the principal point in pixels, from the image's left edge.
    pub cx: f32,
    /// y of the principal point in pixels, from the image's upper edge.
    pub cy: f32,
    /// Origin of the optical frame in the world's frame, metres.
    pub position: [f32; 3],
    /// Orientation of the optical frame in the world's frame: x, y, z, w.
    pub orientation: [f32; 4],
}

/// Why a camera is invalid; the first fault found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum CameraError {
    /// A number is infinite or not a number; the field's name.
    #[error("camera: {0} is not a finite number")]
    NotFinite(&'static str),
    /// A size or focal length is zero or negative; the field's name.
    #[error("camera: {0} must be greater than 0")]
    NotPositive(&'static str),
    /// The orientation's length is not 1 within [`crate::nn::LENGTH_TOLERANCE`].
    #[error("camera: orientation (x, y, z, w) must be a quaternion of length 1")]
    NotNormalised,
}

impl Camera {
    /// Checks that all numbers are finite, sizes and focal lengths positive, and the orientation of
    /// length 1.
    ///
    /// ```
    /// use nsrm_core::Camera;
    /// use nsrm_core::camera::CameraError;
    ///
    /// let mut camera = Camera {
    ///     width: 640,
    ///     height: 480,
    ///     fx: 600.0,
    ///     fy: 600.0,
    ///     cx: 320.0,
    ///     cy: 240.0,
    ///     position: [0.5, 0.0, 1.0],
    ///     orientation: [1.0, 0.0, 0.0, 0.0],
    /// };
    /// assert_eq!(camera.check(), Ok(()));
    /// camera.orientation = [1.0, 1.0, 0.0, 0.0];
    /// assert_eq!(camera.check(), Err(CameraError::NotNormalised));
    /// ```
    pub fn check(&self) -> Result<(), CameraError> {
        let numbers = [
            ("fx", self.fx),
            ("fy", self.fy),
            ("cx", self.cx),
            ("cy", self.cy),
        ];
        for (field, number) in numbers {
            if !number.is_finite() {
                return Err(CameraError::NotFinite(field));
            }
        }
        if !self.position.iter().all(|number| number.is_finite()) {
            return Err(CameraError::NotFinite("position"));
        }
        if !self.orientation.iter().all(|number| number.is_finite()) {
            return Err(CameraError::NotFinite("orientation"));
        }
        let positive = [
            ("width", self.width > 0),
            ("height", self.height > 0),
            ("fx", self.fx > 0.0),
            ("fy", self.fy > 0.0),
        ];
        for (field, is_positive) in positive {
            if !is_positive {
                return Err(CameraError::NotPositive(field));
            }
        }
        if !is_unit(&self.orientation) {
            return Err(CameraError::NotNormalised);
        }
        Ok(())
    }

    /// Transforms a point from the optical frame to the world frame.
    ///
    /// ```
    /// use nsrm_core::Camera;
    /// use nsrm_core::nalgebra::Point3;
    ///
    /// // A metre above the table, looking straight down: z of the optical frame is down, too.
    /// let camera = Camera {
    ///     position: [0.5, 0.0, 1.0],
    ///     orientation: [1.0, 0.0, 0.0, 0.0],
    ///     ..Camera::default()
    /// };
    /// let seen = camera.world_from_camera() * Point3::new(0.1, 0.0, 0.96);
    /// assert!((seen - Point3::new(0.6, 0.0, 0.04)).norm() < 1e-6);
    /// ```
    pub fn world_from_camera(&self) -> Isometry3<f32> {
        let [x, y, z] = self.position;
        Isometry3::from_parts(Translation3::new(x, y, z), rotation(&self.orientation))
    }

    /// The centre of the object at `location`: world frame, metres.
    ///
    /// The box's centre and size are deprojected at the mean depth; a learned linear map then gives
    /// the object's centre, which lies behind the visible surface.
    ///
    /// * `location`: x1, y1, x2, y2 as fractions of the image, mean depth in metres
    ///
    /// Cost: 18 multiply-adds, four divisions and one rotation.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/observed/mod.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # use nsrm_tabletop::TABLETOP;
    /// # let scene = scene(&TABLETOP);
    /// let object = &scene.objects()[0];
    /// let centre = scene.camera().locate(TABLETOP.camera, &object.location);
    /// assert!(centre.z > 0.0 && centre.z < 0.05); // it stands on the table
    /// # Ok(())
    /// # }
    /// ```
    pub fn locate(&self, map: &PixelToCamera, location: &[f32; LOCATION]) -> Point3<f32> {
        self.world_from_camera() * self.locate_in_camera(map, location)
    }

    /// As [`Camera::locate`], in the camera's frame.
    pub(crate) fn locate_in_camera(
        &self,
        map: &PixelToCamera,
        location: &[f32; LOCATION],
    ) -> Point3<f32> {
        Self::centre(map, &self.deproject(location))
    }

    /// What [`PixelToCamera`] maps: x and y of the box's centre, its depth, width and height at that
    /// depth, metres; 1.
    pub(crate) fn deproject(&self, location: &[f32; LOCATION]) -> [f32; 6] {
        let [x1, y1, x2, y2, depth] = *location;
        let (width, height) = (self.width as f32, self.height as f32);
        [
            ((x1 + x2) * 0.5 * width - self.cx) / self.fx * depth,
            ((y1 + y2) * 0.5 * height - self.cy) / self.fy * depth,
            depth,
            self.width_m(location),
            (y2 - y1) * height / self.fy * depth,
            1.0,
        ]
    }

    /// The location with these numbers, in the order of [`Camera::deproject`].
    pub(crate) fn project(&self, &[x, y, depth, width_m, height_m]: &[f32; 5]) -> [f32; LOCATION] {
        let (across, down) = (self.fx / self.width as f32, self.fy / self.height as f32);
        let centre_x = x / depth * across + self.cx / self.width as f32;
        let centre_y = y / depth * down + self.cy / self.height as f32;
        let half_width = 0.5 * width_m / depth * across;
        let half_height = 0.5 * height_m / depth * down;
        [
            centre_x - half_width,
            centre_y - half_height,
            centre_x + half_width,
            centre_y + half_height,
            depth,
        ]
    }

    /// The object's centre in the camera's frame, from what [`Camera::deproject`] gives.
    pub(crate) fn centre(map: &PixelToCamera, deprojected: &[f32; 6]) -> Point3<f32> {
        let [x, y, z] = map.weight.map(|row| dot(&row, deprojected));
        Point3::new(x, y, z)
    }

    /// The width of the box at `location` at its mean depth, metres.
    pub(crate) fn width_m(&self, location: &[f32; LOCATION]) -> f32 {
        let [x1, _, x2, _, depth] = *location;
        (x2 - x1) * self.width as f32 / self.fx * depth
    }
}

/// The rotation of a quaternion (x, y, z, w) of length about 1, normalised.
pub(crate) fn rotation(quaternion: &[f32; 4]) -> UnitQuaternion<f32> {
    let [x, y, z, w] = *quaternion;
    UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Looks straight down from 1 m: image right = world −y, image down = world −x.
    fn downward() -> Camera {
        let half = core::f32::consts::FRAC_1_SQRT_2;
        Camera {
            width: 640,
            height: 480,
            fx: 500.0,
            fy: 400.0,
            cx: 320.0,
            cy: 240.0,
            position: [0.5, 0.1, 1.0],
            orientation: [half, -half, 0.0, 0.0],
        }
    }

    #[test]
    fn a_pixel_is_deprojected_and_taken_to_the_world() {
        // x = X + 0.5·W, y = Y, z = D + 0.25.
        let map = PixelToCamera {
            weight: [
                [1.0, 0.0, 0.0, 0.5, 0.0, 0.0],
                [0.0, 1.0, 0.0, 0.0, 0.0, 0.0],
                [0.0, 0.0, 1.0, 0.0, 0.0, 0.25],
            ],
        };
        let point = downward().locate(&map, &[0.5, 0.625, 0.75, 0.875, 0.5]);
        // Centre (400, 360) px, box 160 × 120 px: X = 0.08, Y = 0.15, W = 0.16;
        // in the camera (0.16, 0.15, 0.75); the camera's x is −y, y is −x, z is −z.
        let expected = Point3::new(0.5 - 0.15, 0.1 - 0.16, 1.0 - 0.75);
        assert!((point - expected).norm() < 1e-6, "{point}");
    }

    #[test]
    fn each_fault_is_named() {
        assert_eq!(downward().check(), Ok(()));
        let broken = |change: fn(&mut Camera)| {
            let mut camera = downward();
            change(&mut camera);
            camera.check()
        };
        let not_finite = |field| Err(CameraError::NotFinite(field));
        let not_positive = |field| Err(CameraError::NotPositive(field));
        assert_eq!(broken(|c| c.fx = f32::NAN), not_finite("fx"));
        assert_eq!(broken(|c| c.cy = f32::INFINITY), not_finite("cy"));
        assert_eq!(broken(|c| c.position[2] = f32::NAN), not_finite("position"));
        assert_eq!(
            broken(|c| c.orientation[0] = f32::NAN),
            not_finite("orientation")
        );
        assert_eq!(broken(|c| c.fy = -1.0), not_positive("fy"));
        assert_eq!(broken(|c| c.height = 0), not_positive("height"));
        assert_eq!(
            broken(|c| c.orientation = [0.0; 4]),
            Err(CameraError::NotNormalised)
        );
        assert_eq!(
            broken(|c| c.orientation[3] = 0.1),
            Err(CameraError::NotNormalised)
        );
    }
}
