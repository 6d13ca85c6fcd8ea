//! Any bytes give a model or a typed error, never a panic.

mod common;

use common::ModelFile;
use nsrm_codegen::OwnedModel;
use proptest::prelude::*;

fn sound() -> &'static [u8] {
    static BYTES: std::sync::OnceLock<Vec<u8>> = std::sync::OnceLock::new();
    BYTES.get_or_init(|| ModelFile::random(2).bytes())
}

/// Length of the header and of the eight bytes that hold its length.
fn header_length(bytes: &[u8]) -> usize {
    let (length, _) = bytes.split_first_chunk().expect("eight bytes");
    8 + u64::from_le_bytes(*length) as usize
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn any_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..2048)) {
        prop_assert!(OwnedModel::from_bytes(&bytes).is_err());
    }

    #[test]
    fn any_header(text in "\\PC{0,400}", content in proptest::collection::vec(any::<u8>(), 0..64)) {
        let mut bytes = (text.len() as u64).to_le_bytes().to_vec();
        bytes.extend(text.as_bytes());
        bytes.extend(content);
        prop_assert!(OwnedModel::from_bytes(&bytes).is_err());
    }

    #[test]
    fn a_sound_file_cut_off(length in 0..sound().len()) {
        prop_assert!(OwnedModel::from_bytes(&sound()[..length]).is_err());
    }

    #[test]
    fn a_sound_file_with_a_changed_header(
        changes in proptest::collection::vec((0..header_length(sound()), any::<u8>()), 1..4)
    ) {
        let mut bytes = sound().to_vec();
        for (index, byte) in changes {
            bytes[index] = byte;
        }
        // Not every change must be refused: it may only concern the space between two entries.
        let _ = OwnedModel::from_bytes(&bytes);
    }

    #[test]
    fn a_sound_file_with_changed_weights(
        index in header_length(sound())..sound().len(), mask in 1..=u8::MAX
    ) {
        let mut bytes = sound().to_vec();
        bytes[index] ^= mask;
        prop_assert!(OwnedModel::from_bytes(&bytes).is_err());
    }
}
