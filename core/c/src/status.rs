use core::ffi::{CStr, c_char};

/// What a function returns: not negative if it did what it says.
#[repr(i32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// Done.
    Ok = 0,
    /// More calls of `nsrm_poll` are needed.
    Pending = 1,
    /// The sentence is refused; `nsrm_refusal_message` says why.
    Refused = 2,
    /// The scene or the image is invalid; `nsrm_refusal_message` or `nsrm_observer_message` says why.
    InvalidInput = 3,
    /// The text did not fit and was cut: it takes as many bytes as was written to `needed`.
    Truncated = 4,
    /// A pointer is null.
    ErrorNull = -1,
    /// A pointer is not aligned as its type must be.
    ErrorMisaligned = -2,
    /// A text is not UTF-8.
    ErrorNotUtf8 = -3,
    /// A struct's `size` is not that of this library's header: header and library differ.
    ErrorStructSize = -4,
    /// Nothing was begun in this memory, or what was begun has another result.
    ErrorNotBegun = -5,
    /// Another call uses this memory at the moment.
    ErrorBusy = -6,
    /// It is not done: call `nsrm_poll` until it no longer returns `NSRM_PENDING`.
    ErrorNotDone = -7,
    /// This is not a model.
    ErrorNotAModel = -8,
    /// An index is greater than the last one.
    ErrorIndex = -9,
    /// A size or a count is greater than its limit.
    ErrorTooLarge = -10,
}

impl Status {
    const ALL: [Self; 15] = [
        Self::Ok,
        Self::Pending,
        Self::Refused,
        Self::InvalidInput,
        Self::Truncated,
        Self::ErrorNull,
        Self::ErrorMisaligned,
        Self::ErrorNotUtf8,
        Self::ErrorStructSize,
        Self::ErrorNotBegun,
        Self::ErrorBusy,
        Self::ErrorNotDone,
        Self::ErrorNotAModel,
        Self::ErrorIndex,
        Self::ErrorTooLarge,
    ];

    const fn text(self) -> &'static CStr {
        match self {
            Self::Ok => c"done",
            Self::Pending => c"not done yet: call nsrm_poll again",
            Self::Refused => c"the sentence is refused: nsrm_refusal_message says why",
            Self::InvalidInput => {
                c"the scene or the image is invalid: nsrm_refusal_message or nsrm_observer_message says why"
            }
            Self::Truncated => c"the text did not fit into the buffer and was cut",
            Self::ErrorNull => c"a pointer is null",
            Self::ErrorMisaligned => c"a pointer is not aligned as its type must be",
            Self::ErrorNotUtf8 => c"the text is not UTF-8",
            Self::ErrorStructSize => {
                c"the size of a struct is not set, or nsrm.h is of another version than the library"
            }
            Self::ErrorNotBegun => {
                c"nothing was begun in this memory, or what was begun has another result"
            }
            Self::ErrorBusy => c"another call uses this memory at the moment",
            Self::ErrorNotDone => c"there is no result yet: call nsrm_poll to the end",
            Self::ErrorNotAModel => c"the pointer does not point to a model",
            Self::ErrorIndex => c"the index is greater than the last one",
            Self::ErrorTooLarge => c"a size or a count is greater than its limit",
        }
    }
}

/// The meaning of a status, for a person; "unknown status" for any other number. Never null.
#[unsafe(no_mangle)]
pub extern "C" fn nsrm_status_text(status: i32) -> *const c_char {
    let known = Status::ALL.iter().find(|known| **known as i32 == status);
    known
        .map_or(c"unknown status", |known| known.text())
        .as_ptr()
}

/// Runs what may fail: `Ok` is success, `Err` any other status.
pub(crate) fn status(run: impl FnOnce() -> Result<(), Status>) -> Status {
    run().err().unwrap_or(Status::Ok)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_status_has_a_text_of_its_own() {
        let mut texts: Vec<_> = Status::ALL.iter().map(|status| status.text()).collect();
        texts.sort_unstable();
        texts.dedup();
        assert_eq!(texts.len(), Status::ALL.len());
        for number in [-11, 5, i32::MIN] {
            // SAFETY: it is a text with a zero behind it.
            let text = unsafe { CStr::from_ptr(nsrm_status_text(number)) };
            assert_eq!(text, c"unknown status");
        }
    }
}
