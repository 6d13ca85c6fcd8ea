//! A client's requests to a robot (services `plan` and `ask`).

#[cfg(feature = "processes")]
use iceoryx2::prelude::ZeroCopySend;
use nsrm_core::MAX_SENTENCE_BYTES;
use thiserror::Error;

use super::layout::message;
use super::numbers::numbers;
use super::text::{self, Clamped, TextFault};
use crate::executive::{Mode, Sentence};

message! {
    /// A request to execute a sentence, or to cancel one.
    "nsrm.v1.PlanRequest.912596fd2fc37f48"
    pub struct PlanRequest {
        /// The client: a unique number.
        pub client: u64,
        /// Number of the request, the client's own.
        pub sequence: u64,
        /// What is requested: the number of a [`Purpose`].
        pub purpose: u32,
        /// Bytes of the sentence; 0 to cancel.
        pub sentence_length: u32,
        /// The sentence in UTF-8.
        pub sentence: [u8; MAX_SENTENCE_BYTES],
    }
}

/// A checked request.
#[derive(Debug, Clone, PartialEq, Eq)]
// There is only one at a time, and it is passed on at once.
#[allow(clippy::large_enum_variant)]
pub enum Asked {
    /// Execute a sentence.
    Follow {
        /// The sentence.
        sentence: Sentence,
        /// How to execute it.
        mode: Mode,
    },
    /// Cancel the request with this number.
    Cancel,
}

/// Why a request is invalid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum PlanRequestError {
    /// More bytes than a request holds.
    #[error(
        "plan request: the sentence has {length} bytes; at most {MAX_SENTENCE_BYTES} are allowed"
    )]
    TooLong {
        /// Bytes of the sentence.
        length: usize,
    },
    /// The sentence is not UTF-8.
    #[error("plan request: the sentence is not UTF-8")]
    Utf8,
    /// Unknown purpose.
    #[error(
        "plan request: unknown purpose {0}; 1 plans, 2 executes, 3 executes without observing, 4 \
         cancels"
    )]
    Purpose(u32),
}

numbers! {
    /// The purpose of a request: [`PlanRequest::purpose`].
    "PlanRequest.purpose"
    pub enum Purpose {
        /// Plan only.
        PlanOnly = 1,
        /// Execute, and observe the scene after each step.
        ClosedLoop = 2,
        /// Execute without observing.
        OpenLoop = 3,
        /// Cancel the request with this number.
        Cancel = 4,
    }
}

impl PlanRequest {
    /// A request to execute a sentence.
    ///
    /// ```
    /// use nsrm_ipc::executive::Mode;
    /// use nsrm_ipc::message::{Asked, PlanRequest};
    ///
    /// let request = PlanRequest::new(1, 7, Mode::ClosedLoop, "put the red block on the blue block")?;
    /// let Asked::Follow { sentence, mode } = request.read()? else {
    ///     panic!("a sentence was asked");
    /// };
    /// assert_eq!((sentence.as_str(), mode), ("put the red block on the blue block", Mode::ClosedLoop));
    /// # Ok::<(), nsrm_ipc::message::PlanRequestError>(())
    /// ```
    pub fn new(
        client: u64,
        sequence: u64,
        mode: Mode,
        sentence: &str,
    ) -> Result<Self, PlanRequestError> {
        let length = sentence.len();
        if length > MAX_SENTENCE_BYTES {
            return Err(PlanRequestError::TooLong { length });
        }
        let purpose = match mode {
            Mode::PlanOnly => Purpose::PlanOnly,
            Mode::ClosedLoop => Purpose::ClosedLoop,
            Mode::OpenLoop => Purpose::OpenLoop,
        };
        let text = Clamped::new(sentence);
        Ok(Self {
            client,
            sequence,
            purpose: purpose as u32,
            sentence_length: text.length,
            sentence: text.bytes,
        })
    }

    /// A request to cancel the request with this number.
    ///
    /// ```
    /// use nsrm_ipc::message::{Asked, PlanRequest};
    ///
    /// assert_eq!(PlanRequest::cancel(1, 7).read(), Ok(Asked::Cancel));
    /// ```
    pub const fn cancel(client: u64, sequence: u64) -> Self {
        Self {
            client,
            sequence,
            purpose: Purpose::Cancel as u32,
            sentence_length: 0,
            sentence: [0; MAX_SENTENCE_BYTES],
        }
    }

    /// Checks the request.
    pub fn read(&self) -> Result<Asked, PlanRequestError> {
        let purpose =
            Purpose::from_number(self.purpose).ok_or(PlanRequestError::Purpose(self.purpose))?;
        let mode = match purpose {
            Purpose::PlanOnly => Mode::PlanOnly,
            Purpose::ClosedLoop => Mode::ClosedLoop,
            Purpose::OpenLoop => Mode::OpenLoop,
            Purpose::Cancel => return Ok(Asked::Cancel),
        };
        let too_long = PlanRequestError::TooLong {
            length: self.sentence_length as usize,
        };
        let text = text::read(self.sentence_length, &self.sentence);
        let text = text.map_err(|fault| match fault {
            TextFault::Length => too_long,
            TextFault::Utf8 => PlanRequestError::Utf8,
        })?;
        let sentence = Sentence::try_from(text).map_err(|_| too_long)?;
        Ok(Asked::Follow { sentence, mode })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(sentence: &str) -> PlanRequest {
        PlanRequest::new(1, 3, Mode::ClosedLoop, sentence).unwrap()
    }

    #[test]
    fn a_sentence_comes_back_or_is_too_long() {
        let longest = "x".repeat(MAX_SENTENCE_BYTES);
        for text in ["put the rötliche block …", &longest] {
            for mode in [Mode::PlanOnly, Mode::ClosedLoop, Mode::OpenLoop] {
                let request = PlanRequest::new(1, 3, mode, text).unwrap();
                let sentence = Sentence::try_from(text).unwrap();
                assert_eq!(request.read(), Ok(Asked::Follow { sentence, mode }));
            }
        }
        let length = MAX_SENTENCE_BYTES + 1;
        let refused = PlanRequest::new(1, 3, Mode::PlanOnly, &"x".repeat(length));
        assert_eq!(refused, Err(PlanRequestError::TooLong { length }));
        assert_eq!(PlanRequest::cancel(1, 3).read(), Ok(Asked::Cancel));
    }

    #[test]
    fn a_received_sentence_is_checked() {
        let mut request = asked("put");
        request.sentence_length = u32::MAX;
        let length = u32::MAX as usize;
        assert_eq!(request.read(), Err(PlanRequestError::TooLong { length }));
        request.sentence_length = 3;
        request.sentence[1] = 0xff;
        assert_eq!(request.read(), Err(PlanRequestError::Utf8));
        for purpose in [0, 5, u32::MAX] {
            let request = PlanRequest {
                purpose,
                ..asked("put")
            };
            assert_eq!(request.read(), Err(PlanRequestError::Purpose(purpose)));
        }
    }
}
