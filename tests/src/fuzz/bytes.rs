//! Messages from bytes and back, and bytes read piece by piece.

use nsrm_ipc::message::Message;

/// A message of these bytes; zeros where they end too early. Returns the rest.
pub(super) fn message<T: Message>(bytes: &[u8]) -> (T, &[u8]) {
    let (own, rest) = bytes.split_at(bytes.len().min(size_of::<T>()));
    let mut filled = vec![0; size_of::<T>()];
    filled[..own.len()].copy_from_slice(own);
    // SAFETY: as many bytes as `T` has are read, from wherever they lie. `Message` is
    // implemented by `nsrm_ipc`'s macro alone, for structs of integers, floats, arrays
    // and such structs, of which any bytes are a value.
    let message = unsafe { filled.as_ptr().cast::<T>().read_unaligned() };
    (message, rest)
}

/// The bytes of a message.
pub(super) fn bytes_of<T: Message>(message: &T) -> &[u8] {
    let start = std::ptr::from_ref(message).cast::<u8>();
    // SAFETY: the message's own bytes, borrowed as long as it; it has no padding, or the
    // macro would not compile, so that every one of them is initialised.
    unsafe { std::slice::from_raw_parts(start, size_of::<T>()) }
}

/// Bytes read from the front; zeros after the last.
#[derive(Debug, Clone, Copy)]
pub(super) struct Script<'a>(&'a [u8]);

impl<'a> Script<'a> {
    pub(super) const fn new(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    pub(super) const fn is_at_end(&self) -> bool {
        self.0.is_empty()
    }

    /// The next `count` bytes, fewer at the end.
    pub(super) fn take(&mut self, length: usize) -> &'a [u8] {
        let (taken, rest) = self.0.split_at(self.0.len().min(length));
        self.0 = rest;
        taken
    }

    /// All that is left.
    pub(super) const fn rest(&self) -> &'a [u8] {
        self.0
    }

    pub(super) fn array<const LENGTH: usize>(&mut self) -> [u8; LENGTH] {
        let mut array = [0; LENGTH];
        let taken = self.take(LENGTH);
        array[..taken.len()].copy_from_slice(taken);
        array
    }

    pub(super) fn byte(&mut self) -> u8 {
        let [byte] = self.array();
        byte
    }
}

#[cfg(test)]
mod tests {
    use super::{Script, bytes_of, message};
    use nsrm_ipc::message::{Feedback, Outcome};

    #[test]
    fn a_message_comes_back_and_a_short_one_ends_in_zeros() {
        let feedback = Feedback {
            plan: 7,
            sequence: 1,
            timestamp_ns: 2,
            command: 3,
            outcome: Outcome::Reached as u32,
            objects: [0; 2],
        };
        let bytes = [bytes_of(&feedback), b"behind"].concat();
        let (back, rest): (Feedback, _) = message(&bytes);
        assert_eq!((back, rest), (feedback, &b"behind"[..]));
        let (short, rest): (Feedback, _) = message(&bytes[..8]);
        assert_eq!((short.plan, short.outcome, rest), (7, 0, &[][..]));
    }

    #[test]
    fn a_script_goes_on_in_zeros() {
        let mut script = Script::new(&[1, 2, 3]);
        assert_eq!(script.byte(), 1);
        assert_eq!(script.array(), [2, 3, 0, 0]);
        assert!(script.is_at_end() && script.byte() == 0);
    }
}
