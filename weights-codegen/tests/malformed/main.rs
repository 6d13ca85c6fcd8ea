//! Each malformation has its own variant and message.

#[path = "../common/mod.rs"]
mod common;
mod domain;
mod metadata;
mod rewriting;
mod tensors;

use common::ModelFile;
use nsrm_codegen::ModelError;
use serde_json::Value;

type SpoilDomain = fn(&mut Value);
type SpoilFile = fn(&mut ModelFile);

/// The refusal of a sound file after `spoil`; its message must hold `parts`.
fn refused(spoil: impl FnOnce(&mut ModelFile), parts: &[&str]) -> ModelError {
    let mut file = ModelFile::random(1);
    spoil(&mut file);
    let error = file.refusal();
    assert_message(&error, parts);
    error
}

fn refused_domain(spoil: impl FnOnce(&mut Value), parts: &[&str]) -> ModelError {
    let mut domain = common::domain();
    spoil(&mut domain);
    refused(|file| file.set("domain", domain), parts)
}

fn assert_message(error: &ModelError, parts: &[&str]) {
    let message = error.to_string();
    for part in parts {
        assert!(message.contains(part), "{message:?} lacks {part:?}");
    }
}

#[test]
fn a_sound_file_is_read() {
    let owned = ModelFile::random(1).load();
    assert_eq!(owned.as_model().check(), Ok(()));
}
