use core::fmt;

use crate::calibration::{CalibrationFault, Cause, Measured};

impl fmt::Display for CalibrationFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.cause {
            Some(cause) => write!(f, "{cause}: ")?,
            None => f.write_str("what is seen disagrees with the camera's calibration: ")?,
        }
        let Self {
            object,
            measured_m,
            expected_m,
            ..
        } = self;
        match self.quantity {
            Measured::Height => write!(
                f,
                "object {object} is seen at a height of {measured_m:.3} m, but would rest at \
                 {expected_m:.3} m"
            ),
            Measured::Width => write!(
                f,
                "object {object} looks {measured_m:.3} m wide, but the nearest size of the domain \
                 is {expected_m:.3} m wide"
            ),
            Measured::Rise => write!(
                f,
                "the table seems to rise by {measured_m:.3} m to object {object} from the other \
                 side of the image, but is level"
            ),
        }?;
        write!(
            f,
            " ({} of {} objects disagree); ",
            self.disagreeing, self.whole
        )?;
        f.write_str(match self.cause {
            Some(Cause::DepthsInMillimetres) => "divide the depths by 1000",
            Some(Cause::PositionInMillimetres) => "divide the camera's position by 1000",
            Some(Cause::LengthsInMillimetres) => {
                "divide the depths and the camera's position by 1000"
            }
            Some(Cause::OrientationWxyz) => "put w last",
            Some(Cause::PoseInverted) => "invert the camera's pose",
            Some(Cause::AxesOfOpenGl) => "turn the camera's frame by 180 degrees about its x axis",
            None => self.advice(),
        })
    }
}

impl CalibrationFault {
    /// What may be wrong, where no other unit or convention explains it.
    fn advice(&self) -> &'static str {
        match self.quantity {
            Measured::Height if self.measured_m > self.expected_m => {
                "the camera's pose may be too high, or depths too short: calibrate the camera \
                 again, and see that nothing holds or covers the object"
            }
            Measured::Height => {
                "the camera's pose may be too low, or depths too long: calibrate the camera \
                 again, and see that nothing covers the object"
            }
            Measured::Width => {
                "the focal length, the image's size or the depths may be wrong: calibrate the \
                 camera again, and see that nothing covers the object"
            }
            Measured::Rise => "the camera's orientation may be wrong: calibrate the camera again",
        }
    }
}

impl fmt::Display for Cause {
    /// What it looks like, and what is wanted.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::DepthsInMillimetres => "depths look like millimetres; NSRM wants metres",
            Self::PositionInMillimetres => {
                "the camera's position looks like millimetres; NSRM wants metres"
            }
            Self::LengthsInMillimetres => {
                "depths and the camera's position look like millimetres; NSRM wants metres"
            }
            Self::OrientationWxyz => {
                "the camera's orientation looks like w, x, y, z; NSRM wants x, y, z, w"
            }
            Self::PoseInverted => {
                "the camera's pose looks like that of the world in the camera's frame; NSRM wants \
                 that of the camera in the world's frame"
            }
            Self::AxesOfOpenGl => {
                "the camera's axes look like those of OpenGL, y up and z backward; NSRM wants \
                 y down and z forward"
            }
        })
    }
}
