//! What the host gives: the file `input.bin` in the folder where QEMU runs, all numbers little-endian.
//!
//! | bytes | what |
//! |---|---|
//! | 4568 | a scene (`RawScene`); without the feature `vision` |
//! | 52 | the camera; with `vision`, as all up to the image |
//! | 4 | number of objects |
//! | 40 each | a detection: id; box of the visible part; box and depth of the whole |
//! | 3·width·height | the image, RGB |
//! | 4 | number of sentences |
//! | 4 each | bytes of a sentence, which follow |

use cortex_m_semihosting::syscall;

/// The largest input.
const BYTES: usize = 2 << 20;

unsafe extern "C" {
    /// Memory of the board beside what the firmware is measured by: [`BYTES`].
    #[link_name = "_input"]
    static mut INPUT: [u8; BYTES];
}

/// The rest of the input.
pub struct Reader {
    rest: &'static [u8],
}

impl Reader {
    /// Reads the file; `None` if there is none.
    pub fn open() -> Option<Self> {
        let path = b"input.bin\0";
        // Binary, for reading.
        let mode = 1;
        // SAFETY: the arguments are those of the semihosting interface: a path with a zero behind it
        // and its length without, then a file, a buffer and its length.
        let read = unsafe {
            let file = syscall!(OPEN, path.as_ptr(), mode, path.len() - 1);
            if file == usize::MAX {
                return None;
            }
            let not_read = syscall!(READ, file, (&raw mut INPUT), BYTES);
            BYTES - not_read
        };
        // SAFETY: nothing writes it any more, and it is as long.
        let rest = unsafe { core::slice::from_raw_parts((&raw const INPUT).cast::<u8>(), read) };
        Some(Self { rest })
    }

    /// So many bytes.
    pub fn bytes(&mut self, count: usize) -> Option<&'static [u8]> {
        let (taken, rest) = self.rest.split_at_checked(count)?;
        self.rest = rest;
        Some(taken)
    }

    /// An integer.
    pub fn integer(&mut self) -> Option<u32> {
        self.bytes(4)?.try_into().ok().map(u32::from_le_bytes)
    }

    /// So many numbers.
    #[cfg(feature = "vision")]
    pub fn numbers<const COUNT: usize>(&mut self) -> Option<[f32; COUNT]> {
        let mut numbers = [0.0; COUNT];
        for number in &mut numbers {
            *number = f32::from_bits(self.integer()?);
        }
        Some(numbers)
    }

    /// Text behind its length.
    pub fn text(&mut self) -> Option<&'static str> {
        let length = usize::try_from(self.integer()?).ok()?;
        core::str::from_utf8(self.bytes(length)?).ok()
    }
}
