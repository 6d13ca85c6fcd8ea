//! Text in a message: a length and an array; the length may be wrong.

/// Why bytes of a message are not text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum TextFault {
    /// The length exceeds the array.
    Length,
    /// Not UTF-8.
    Utf8,
}

/// The first `length` bytes as text.
pub(crate) fn read(length: u32, bytes: &[u8]) -> Result<&str, TextFault> {
    let bytes = usize::try_from(length)
        .ok()
        .and_then(|length| bytes.get(..length))
        .ok_or(TextFault::Length)?;
    core::str::from_utf8(bytes).map_err(|_| TextFault::Utf8)
}

/// An array of bytes for text; a text that does not fit is cut after a whole character.
pub(crate) struct Clamped<const LENGTH: usize> {
    pub(crate) bytes: [u8; LENGTH],
    pub(crate) length: u32,
    full: bool,
}

impl<const LENGTH: usize> Clamped<LENGTH> {
    /// As much of a text as fits.
    pub(crate) fn new(text: impl core::fmt::Display) -> Self {
        const { assert!(LENGTH <= u32::MAX as usize) };
        let mut clamped = Self {
            bytes: [0; LENGTH],
            length: 0,
            full: false,
        };
        // Writing never fails: see `write_str`. A `Display` that fails leaves what it has written.
        let _ = core::fmt::write(&mut clamped, format_args!("{text}"));
        clamped
    }
}

impl<const LENGTH: usize> core::fmt::Write for Clamped<LENGTH> {
    fn write_str(&mut self, text: &str) -> core::fmt::Result {
        let start = self.length as usize;
        let fitting = whole_characters(text, LENGTH - start);
        if !self.full {
            self.bytes[start..start + fitting].copy_from_slice(&text.as_bytes()[..fitting]);
            // At most LENGTH, which fits.
            self.length += fitting as u32;
        }
        self.full |= fitting < text.len();
        Ok(())
    }
}

/// The number of bytes of the longest prefix of `text`, in whole characters, that fits into
/// `limit`.
fn whole_characters(text: &str, limit: usize) -> usize {
    let mut length = limit.min(text.len());
    while !text.is_char_boundary(length) {
        length -= 1;
    }
    length
}

#[cfg(test)]
mod tests {
    use super::{Clamped, TextFault, read};

    #[test]
    fn text_is_cut_at_a_whole_character_and_nothing_follows() {
        let text = Clamped::<6>::new(format_args!("ab{}{}", "çdé", "x"));
        assert_eq!(read(text.length, &text.bytes), Ok("abçd"));
        let text = Clamped::<6>::new("abçdx");
        assert_eq!(read(text.length, &text.bytes), Ok("abçdx"));
    }

    #[test]
    fn a_length_beyond_the_array_and_broken_utf8_are_refused() {
        assert_eq!(read(5, b"four"), Err(TextFault::Length));
        assert_eq!(read(u32::MAX, b"four"), Err(TextFault::Length));
        assert_eq!(read(2, "aç".as_bytes()), Err(TextFault::Utf8));
        assert_eq!(read(0, b"four"), Ok(""));
    }
}
