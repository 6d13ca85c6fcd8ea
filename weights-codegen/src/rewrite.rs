//! Writes a model file with another threshold.

use std::collections::HashMap;

use safetensors::SafeTensors;
use serde_json::{Map, Value};

use crate::error::ModelError;
use crate::hash;
use crate::metadata;

/// The entry of a safetensors header that holds the metadata.
const METADATA: &str = "__metadata__";
const THRESHOLDS: &str = "thresholds";
/// The tensors begin at a multiple of this.
const ALIGNMENT: usize = 8;

/// The bytes of a model file with another least confidence of a plan. Its hash and its identity
/// follow; everything else stays.
///
/// # Errors
/// A [`ModelError`] if the file is invalid or the confidence outside 0 to 1.
pub fn with_confidence(bytes: &[u8], confidence: f32) -> Result<Vec<u8>, ModelError> {
    let not_safetensors = |reason: String| ModelError::NotSafetensors { reason };
    let file =
        SafeTensors::deserialize(bytes).map_err(|error| not_safetensors(error.to_string()))?;
    let (length, entries) =
        SafeTensors::read_metadata(bytes).map_err(|error| not_safetensors(error.to_string()))?;
    let mut entries = entries.metadata().clone().unwrap_or_default();
    metadata::check_schema(&entries)?;
    hash::verify(&file, &entries)?;
    set_confidence(&mut entries, confidence)?;
    entries.insert(hash::HASH.into(), hash::file_hash(&file, &entries));

    let (header, tensors) = bytes[size_of::<u64>()..].split_at(length);
    let mut header: Map<String, Value> =
        serde_json::from_slice(header).map_err(|error| not_safetensors(error.to_string()))?;
    let entries: Map<String, Value> = entries
        .into_iter()
        .map(|(key, text)| (key, text.into()))
        .collect();
    header.insert(METADATA.into(), entries.into());
    let mut text = Value::from(header).to_string().into_bytes();
    text.resize(text.len().next_multiple_of(ALIGNMENT), b' ');
    let mut written = (text.len() as u64).to_le_bytes().to_vec();
    written.extend(text);
    written.extend(tensors);
    Ok(written)
}

fn set_confidence(
    entries: &mut HashMap<String, String>,
    confidence: f32,
) -> Result<(), ModelError> {
    metadata::in_range("confidence", confidence)?;
    let missing = ModelError::MissingMetadata { key: THRESHOLDS };
    let text = entries.get_mut(THRESHOLDS).ok_or(missing)?;
    let mut thresholds: Map<String, Value> =
        serde_json::from_str(text).map_err(|error| ModelError::NotJson {
            key: THRESHOLDS,
            reason: error.to_string(),
        })?;
    // With the decimals of the f32: 0.98, not 0.9800000190734863.
    let decimal = confidence
        .to_string()
        .parse()
        .unwrap_or(f64::from(confidence));
    thresholds.insert("confidence".into(), decimal.into());
    *text = Value::from(thresholds).to_string();
    Ok(())
}
