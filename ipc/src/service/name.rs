use core::fmt;
use core::str::FromStr;

use heapless::String;
use thiserror::Error;

/// The greatest length of a robot's name, characters.
pub const MAX_NAME: usize = 32;

/// The name of a robot: a part of every service's name, so that several robots on one machine don't
/// receive each other's messages.
///
/// ```
/// use nsrm_ipc::service::{RobotName, RobotNameError};
///
/// let name: RobotName = "left-arm".parse()?;
/// assert_eq!(name.as_str(), "left-arm");
/// assert_eq!("Left".parse::<RobotName>(), Err(RobotNameError::Letter('L')));
/// # Ok::<(), RobotNameError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct RobotName(String<MAX_NAME>);

impl RobotName {
    /// The name.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for RobotName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// Why a robot's name is invalid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum RobotNameError {
    /// Empty, or too long.
    #[error("a robot's name must have from 1 to {MAX_NAME} characters")]
    Length,
    /// A character other than small letters, digits, `-` and `_`.
    #[error("{0:?} in a robot's name: allowed are a to z, 0 to 9, \"-\" and \"_\"")]
    Letter(char),
}

impl FromStr for RobotName {
    type Err = RobotNameError;

    fn from_str(name: &str) -> Result<Self, RobotNameError> {
        let is_fine = |letter: char| {
            letter.is_ascii_lowercase() || letter.is_ascii_digit() || matches!(letter, '-' | '_')
        };
        if let Some(letter) = name.chars().find(|letter| !is_fine(*letter)) {
            return Err(RobotNameError::Letter(letter));
        }
        let name = String::try_from(name).map_err(|_| RobotNameError::Length)?;
        if name.is_empty() {
            return Err(RobotNameError::Length);
        }
        Ok(Self(name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_could_be_taken_for_others_are_refused() {
        for name in ["left", "panda-2", "a_b", &"x".repeat(MAX_NAME)] {
            assert_eq!(name.parse::<RobotName>().unwrap().as_str(), name);
        }
        for name in ["", &"x".repeat(MAX_NAME + 1)] {
            assert_eq!(name.parse::<RobotName>(), Err(RobotNameError::Length));
        }
        for (name, letter) in [
            ("left/camera", '/'),
            ("Left", 'L'),
            ("a b", ' '),
            ("ä", 'ä'),
        ] {
            let refused = name.parse::<RobotName>();
            assert_eq!(refused, Err(RobotNameError::Letter(letter)));
        }
    }
}
