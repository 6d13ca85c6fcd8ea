use core::ffi::c_char;
use core::fmt::{self, Write};

use crate::capacity::MAX_SENTENCE_BYTES;
use crate::pointers;
use crate::status::Status;

/// UTF-8 text without a zero behind it.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Text {
    /// Its bytes; null if there is no text.
    pub data: *const c_char,
    /// How many.
    pub length: usize,
}

impl Text {
    pub(crate) const NONE: Self = Self {
        data: core::ptr::null(),
        length: 0,
    };

    pub(crate) const fn of(text: &'static str) -> Self {
        Self {
            data: text.as_ptr().cast(),
            length: text.len(),
        }
    }
}

/// A sentence. One that is longer than any sentence is cut, and still refused for its length: reading
/// it is bounded work.
///
/// # Safety
/// If the pointer is not null, it points to `length` bytes that nobody writes during `'a`.
pub(crate) unsafe fn sentence<'a>(data: *const c_char, length: usize) -> Result<&'a str, Status> {
    // A character may begin within the limit and end behind it.
    let read = length.min(MAX_SENTENCE_BYTES + char::MAX.len_utf8());
    // SAFETY: the caller's promise.
    let bytes = unsafe { pointers::array(data.cast::<u8>(), read) }?;
    match core::str::from_utf8(bytes) {
        Ok(text) => Ok(text),
        Err(error) if read < length && error.valid_up_to() > MAX_SENTENCE_BYTES => {
            let whole = bytes.get(..error.valid_up_to()).unwrap_or_default();
            core::str::from_utf8(whole).map_err(|_| Status::ErrorNotUtf8)
        }
        Err(_) => Err(Status::ErrorNotUtf8),
    }
}

/// Writes a text with a zero behind it into the caller's buffer, and how many bytes it takes with the
/// zero to `needed`, which may be null. What does not fit is cut between characters.
///
/// # Safety
/// If `buffer` is not null, it points to `size` bytes that nobody else uses; `needed` is valid or null.
pub(crate) unsafe fn write_text(
    text: &dyn fmt::Display,
    buffer: *mut c_char,
    size: usize,
    needed: *mut usize,
) -> Result<(), Status> {
    let mut cut = Cut {
        buffer: buffer.cast(),
        // The zero needs a place.
        room: size.saturating_sub(1),
        length: 0,
        needed: 0,
    };
    if buffer.is_null() && size > 0 {
        return Err(Status::ErrorNull);
    }
    // Writing to `cut` does not fail.
    let _ = write!(cut, "{text}");
    if size > 0 {
        // SAFETY: `length` is at most `size - 1`.
        unsafe { cut.buffer.add(cut.length).write(0) };
    }
    let taken = cut.needed.saturating_add(1);
    if !needed.is_null() {
        // SAFETY: the caller's promise.
        unsafe { pointers::write(needed, taken) }?;
    }
    if taken > size {
        return Err(Status::Truncated);
    }
    Ok(())
}

/// Keeps as much as there is room for, and counts all.
struct Cut {
    buffer: *mut u8,
    room: usize,
    length: usize,
    needed: usize,
}

impl Write for Cut {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let is_whole_so_far = self.needed == self.length;
        self.needed = self.needed.saturating_add(text.len());
        if is_whole_so_far {
            let room = self.room - self.length;
            let mut end = text.len().min(room);
            while !text.is_char_boundary(end) {
                end -= 1;
            }
            // SAFETY: `buffer` has `room` bytes, `length` of which are written.
            unsafe {
                let to = self.buffer.add(self.length);
                to.copy_from_nonoverlapping(text.as_ptr(), end);
            }
            self.length += end;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_cut_between_characters() {
        for (size, kept, status) in [
            (0, "", Err(Status::Truncated)),
            (1, "", Err(Status::Truncated)),
            (3, "aé".get(..1).unwrap(), Err(Status::Truncated)),
            (4, "aé", Err(Status::Truncated)),
            (5, "aéb", Ok(())),
            (9, "aéb", Ok(())),
        ] {
            let mut buffer = [b'x'; 9];
            let mut needed = 0;
            let data: *mut c_char = buffer.as_mut_ptr().cast();
            // SAFETY: the buffer is longer than `size`.
            let got = unsafe { write_text(&"aéb", data, size, &raw mut needed) };
            assert_eq!((got, needed), (status, 5), "{size}");
            if size > 0 {
                let text = buffer.split(|byte| *byte == 0).next();
                assert_eq!(text, Some(kept.as_bytes()), "{size}");
            }
            assert!(buffer.iter().skip(size.max(1)).all(|byte| *byte == b'x'));
        }
    }

    #[test]
    fn a_sentence_that_is_too_long_is_cut_and_still_too_long() {
        let limit = MAX_SENTENCE_BYTES;
        for length in [limit - 1, limit, limit + 1, limit + 2, 3 * limit] {
            let text = "é".repeat(length);
            // SAFETY: these bytes are the text's.
            let read = unsafe { sentence(text.as_ptr().cast(), text.len()) }.unwrap();
            assert!(read.len() > limit && read.len() <= limit + 4, "{length}");
        }
        let broken = [b"put".as_slice(), &[0xff]].concat();
        // SAFETY: these bytes are the text's.
        let read = unsafe { sentence(broken.as_ptr().cast(), broken.len()) };
        assert_eq!(read, Err(Status::ErrorNotUtf8));
    }
}
