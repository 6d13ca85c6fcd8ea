//! The two hashes of a model file: over its whole content, and over what its results depend on.
//!
//! The rule is in `docs/decisions/core.md`; the exporter's is `nsrm_harness/learning/hashes.py`,
//! and `tests/golden/hash.json` has an example for both.

use std::collections::{BTreeMap, HashMap};

use safetensors::SafeTensors;
use sha2::{Digest, Sha256};

use crate::error::ModelError;
use crate::hexadecimal;

/// The metadata entry that holds the file's hash.
pub(crate) const HASH: &str = "hash";
/// Entries about training and metrics; no plan depends on them.
const TOLD: [&str; 2] = ["training", "metrics"];

/// Refuses a file whose content does not match its hash.
pub(crate) fn verify(
    file: &SafeTensors<'_>,
    metadata: &HashMap<String, String>,
) -> Result<(), ModelError> {
    let named = metadata
        .get(HASH)
        .ok_or(ModelError::MissingMetadata { key: HASH })?;
    let is_digit = |digit: u8| matches!(digit, b'0'..=b'9' | b'a'..=b'f');
    if named.len() != 64 || !named.bytes().all(is_digit) {
        return Err(ModelError::HashForm { got: named.clone() });
    }
    let got = file_hash(file, metadata);
    if *named != got {
        let expected = named.clone();
        return Err(ModelError::Hash { expected, got });
    }
    Ok(())
}

/// The hash of the whole content, except the hash itself, as the file has it.
pub(crate) fn file_hash(file: &SafeTensors<'_>, metadata: &HashMap<String, String>) -> String {
    hexadecimal(&digest(file, metadata, &[HASH]))
}

/// The hash of what the model's results depend on; independent of its description.
pub(crate) fn identity(file: &SafeTensors<'_>, metadata: &HashMap<String, String>) -> [u8; 32] {
    let [training, metrics] = TOLD;
    digest(file, metadata, &[HASH, training, metrics])
}

fn digest(
    file: &SafeTensors<'_>,
    metadata: &HashMap<String, String>,
    left_out: &[&str],
) -> [u8; 32] {
    let mut hasher = Sha256::new();
    let entries = metadata.iter();
    let entries: BTreeMap<_, _> = entries
        .filter(|(key, _)| !left_out.contains(&key.as_str()))
        .collect();
    number(&mut hasher, entries.len());
    for (key, value) in entries {
        text(&mut hasher, key);
        text(&mut hasher, value);
    }
    let tensors: BTreeMap<_, _> = file.iter().collect();
    number(&mut hasher, tensors.len());
    for (name, tensor) in tensors {
        text(&mut hasher, name);
        number(&mut hasher, tensor.shape().len());
        for &dimension in tensor.shape() {
            number(&mut hasher, dimension);
        }
        hasher.update(tensor.data());
    }
    hasher.finalize().into()
}

fn number(hasher: &mut Sha256, number: usize) {
    hasher.update((number as u64).to_le_bytes());
}

/// Its length first, so that the boundary between two texts counts, too.
fn text(hasher: &mut Sha256, text: &str) {
    number(hasher, text.len());
    hasher.update(text);
}

#[cfg(test)]
mod tests {
    use safetensors::Dtype;
    use safetensors::tensor::TensorView;
    use serde_json::Value;

    use super::*;

    #[test]
    fn the_golden_example_has_its_hashes() {
        let example: Value = serde_json::from_str(include_str!("../../tests/golden/hash.json"))
            .expect("the example is JSON");
        let metadata: HashMap<String, String> =
            serde_json::from_value(example["metadata"].clone()).expect("texts");
        let tensors: BTreeMap<String, (Vec<usize>, Vec<f32>)> =
            serde_json::from_value(example["tensors"].clone()).expect("shapes and values");
        let tensors: BTreeMap<_, (_, Vec<u8>)> = tensors
            .into_iter()
            .map(|(name, (shape, values))| {
                let bytes = values.iter().flat_map(|value| value.to_le_bytes());
                (name, (shape, bytes.collect()))
            })
            .collect();
        let views = tensors.iter().map(|(name, (shape, bytes))| {
            let view = TensorView::new(Dtype::F32, shape.clone(), bytes);
            (name, view.expect("as many values as the shape says"))
        });
        let bytes = safetensors::serialize(views, Some(metadata.clone())).expect("a file");
        let file = SafeTensors::deserialize(&bytes).expect("a file");
        assert_eq!(example["hash"], file_hash(&file, &metadata));
        assert_eq!(
            example["identity"],
            hexadecimal(&identity(&file, &metadata))
        );
    }
}
