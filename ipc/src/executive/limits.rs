use thiserror::Error;

/// Limits of the closed loop: timeouts, tolerances and retries.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// The greatest age of a scene that is used, nanoseconds since its image was taken.
    pub scene_age_ns: u64,
    /// How long to wait for a usable scene.
    pub scene_wait_ns: u64,
    /// How long the controller may take to accept a command, or a stop.
    pub accept_wait_ns: u64,
    /// How long it may take to execute a command.
    pub move_wait_ns: u64,
    /// How long another node may be silent before it is considered dead.
    pub silence_ns: u64,
    /// How far from its sub-goal an object may be observed, metres.
    pub tolerance_m: f32,
    /// How far apart two observations of an unmoved object may be, metres.
    pub moved_m: f32,
    /// The same for an object that is partly covered by another one, metres.
    pub covered_m: f32,
    /// The greatest number of commands for one step.
    pub attempts: u8,
    /// The greatest number of retries in a whole sentence.
    pub retries: u8,
}

impl Default for Limits {
    /// Scenes at most half a second old; three lost heartbeats, so that a death is detected within
    /// half a second; 15 mm, which is more than an arm may correct a sub-goal from its view of the
    /// support (8 mm across and 12 mm in height), and less than half of the smallest block. Two
    /// observations are compared more strictly than an observation with a sub-goal, since errors of
    /// the model's map from pixels to the world cancel.
    fn default() -> Self {
        Self {
            scene_age_ns: 500_000_000,
            scene_wait_ns: 2_000_000_000,
            accept_wait_ns: 500_000_000,
            move_wait_ns: 60_000_000_000,
            silence_ns: 350_000_000,
            tolerance_m: 0.015,
            moved_m: 0.003,
            covered_m: 0.010,
            attempts: 4,
            retries: 8,
        }
    }
}

/// An invalid limit: it would allow nothing, or everything.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum LimitsError {
    /// A time is zero.
    #[error("{0}: must be longer than 0")]
    Zero(&'static str),
    /// A distance is not a positive number.
    #[error("{0}: must be a positive number of metres")]
    Distance(&'static str),
    /// No command is allowed.
    #[error("attempts: must be 1 or more")]
    NoAttempt,
}

impl Limits {
    /// Checks that the limits are valid.
    ///
    /// ```
    /// use nsrm_ipc::executive::{Limits, LimitsError};
    ///
    /// let limits = Limits { retries: 0, ..Limits::default() };
    /// assert_eq!(limits.check(), Ok(()));
    /// let limits = Limits { tolerance_m: f32::NAN, ..limits };
    /// assert_eq!(limits.check(), Err(LimitsError::Distance("tolerance")));
    /// ```
    pub fn check(&self) -> Result<(), LimitsError> {
        for (name, time) in [
            ("scene age", self.scene_age_ns),
            ("wait for a scene", self.scene_wait_ns),
            ("wait for acceptance", self.accept_wait_ns),
            ("wait for a move", self.move_wait_ns),
            ("silence", self.silence_ns),
        ] {
            if time == 0 {
                return Err(LimitsError::Zero(name));
            }
        }
        for (name, distance_m) in [
            ("tolerance", self.tolerance_m),
            ("moved", self.moved_m),
            ("covered", self.covered_m),
        ] {
            if !(distance_m > 0.0 && distance_m.is_finite()) {
                return Err(LimitsError::Distance(name));
            }
        }
        if self.attempts == 0 {
            return Err(LimitsError::NoAttempt);
        }
        Ok(())
    }
}
