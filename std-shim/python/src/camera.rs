//! The camera.

use nsrm_core::camera;
use numpy::{AllowTypeChange, PyArrayLike1};
use pyo3::prelude::*;

use crate::arrays::numbers;
use crate::errors::scene;

/// Intrinsics in pixels; pose of the optical frame (x right, y down, z forward) in
/// the world's frame: metres and a quaternion x, y, z, w.
#[pyclass(frozen, eq, module = "nsrm", from_py_object)]
#[derive(Clone, PartialEq)]
pub(crate) struct Camera {
    pub(crate) inner: camera::Camera,
}

#[pymethods]
impl Camera {
    #[new]
    #[allow(clippy::too_many_arguments, reason = "keywords in Python")]
    fn new(
        width: u32,
        height: u32,
        fx: f32,
        fy: f32,
        cx: f32,
        cy: f32,
        position: PyArrayLike1<'_, f32, AllowTypeChange>,
        orientation: PyArrayLike1<'_, f32, AllowTypeChange>,
    ) -> PyResult<Self> {
        let inner = camera::Camera {
            width,
            height,
            fx,
            fy,
            cx,
            cy,
            position: numbers("position", &position)?,
            orientation: numbers("orientation", &orientation)?,
        };
        inner.check().map_err(scene)?;
        Ok(Self { inner })
    }

    #[getter]
    fn width(&self) -> u32 {
        self.inner.width
    }

    #[getter]
    fn height(&self) -> u32 {
        self.inner.height
    }

    #[getter]
    fn fx(&self) -> f32 {
        self.inner.fx
    }

    #[getter]
    fn fy(&self) -> f32 {
        self.inner.fy
    }

    #[getter]
    fn cx(&self) -> f32 {
        self.inner.cx
    }

    #[getter]
    fn cy(&self) -> f32 {
        self.inner.cy
    }

    #[getter]
    fn position(&self) -> (f32, f32, f32) {
        self.inner.position.into()
    }

    #[getter]
    fn orientation(&self) -> (f32, f32, f32, f32) {
        self.inner.orientation.into()
    }

    fn __repr__(&self) -> String {
        let camera::Camera {
            width,
            height,
            fx,
            fy,
            cx,
            cy,
            position,
            orientation,
        } = self.inner;
        format!(
            "Camera(width={width}, height={height}, fx={fx}, fy={fy}, cx={cx}, cy={cy}, \
             position={position:?}, orientation={orientation:?})"
        )
    }
}
