//! The hash of a model file detects every change of its content. The hash that binds scenes to a
//! model depends on exactly what the model's results depend on.

mod common;

use std::collections::BTreeMap;

use common::ModelFile;
use nsrm_codegen::{ModelError, OwnedModel};
use proptest::prelude::*;
use serde_json::{Value, json};

fn sound() -> &'static ModelFile {
    static FILE: std::sync::OnceLock<ModelFile> = std::sync::OnceLock::new();
    FILE.get_or_init(|| {
        let mut file = ModelFile::flat();
        let bytes = file.bytes();
        file.metadata = metadata_of(&bytes);
        file
    })
}

/// The metadata of a file, including its hash.
fn metadata_of(bytes: &[u8]) -> BTreeMap<String, String> {
    let (header, _) = parts(bytes);
    let header: Value = serde_json::from_slice(header).expect("JSON");
    serde_json::from_value(header["__metadata__"].clone()).expect("strings")
}

/// The header, and the bytes of the tensors.
fn parts(bytes: &[u8]) -> (&[u8], &[u8]) {
    let (length, rest) = bytes.split_first_chunk().expect("eight bytes");
    rest.split_at(u64::from_le_bytes(*length) as usize)
}

/// The refusal of a file whose hash was taken before `change`.
#[track_caller]
fn refused_after(what: &str, change: impl FnOnce(&mut BTreeMap<String, String>)) {
    let mut file = sound().clone();
    change(&mut file.metadata);
    match OwnedModel::from_bytes(&file.bytes()) {
        Err(error @ ModelError::Hash { .. }) => {
            let message = error.to_string();
            assert!(message.contains("changed or damaged"), "{message}");
        }
        other => panic!("{what}: {other:?}"),
    }
}

#[test]
fn every_entry_of_the_metadata_is_covered() {
    let entries = sound().metadata.iter();
    for (key, value) in entries.filter(|(key, _)| !["hash", "schema"].contains(&&***key)) {
        for at in [0, value.len() / 2, value.len() - 1] {
            refused_after(&format!("{key}, byte {at}"), |metadata| {
                let mut bytes = value.clone().into_bytes();
                bytes[at] ^= 1;
                let changed = String::from_utf8(bytes).expect("ASCII");
                metadata.insert(key.clone(), changed);
            });
        }
        refused_after(&format!("no {key}"), |metadata| {
            metadata.remove(key);
        });
    }
}

#[test]
fn what_would_pass_for_another_model_is_refused() {
    for (key, said, instead) in [
        ("thresholds", "0.75", "0.25"),
        ("domain", "amber", "umber"),
        ("work_space", "-0.5", "-9.5"),
        ("placed_orientation", "0.0,1.0", "1.0,0.0"),
        ("training_camera", "500.0", "501.0"),
        ("dimensions", "\"encoder_hidden\":48,", ""),
        ("metrics", "0.5", "0.9"),
        ("training", "3", "4"),
    ] {
        refused_after(key, |metadata| {
            let value = metadata.get_mut(key).expect("an entry");
            assert!(value.contains(said), "{key}: {value}");
            *value = value.replacen(said, instead, 1);
        });
    }
    refused_after("another entry", |metadata| {
        metadata.insert("license".into(), "none".into());
    });
    refused_after("an entry under another name", |metadata| {
        let metrics = metadata.remove("metrics").expect("an entry");
        metadata.insert("metrics ".into(), metrics);
    });
    refused_after("a letter of the key as the value's first", |metadata| {
        let value = metadata.remove("metrics").expect("an entry");
        metadata.insert("metric".into(), format!("s{value}"));
    });
}

/// A JSON object's text with its entries in the opposite order.
fn reversed(object: &BTreeMap<String, Value>) -> String {
    let entries = object.iter().rev().map(|(key, value)| {
        let value = match key.as_str() {
            "__metadata__" => reversed(&serde_json::from_value(value.clone()).expect("an object")),
            _ => value.to_string(),
        };
        format!("{}: {value}", json!(key))
    });
    format!("{{{}}}", entries.collect::<Vec<_>>().join(", "))
}

#[test]
fn the_order_of_entries_is_free() {
    let bytes = sound().bytes();
    let (header, tensors) = parts(&bytes);
    let other = reversed(&serde_json::from_slice(header).expect("an object"));
    assert_ne!(other.as_bytes(), header);
    let length = (other.len() as u64).to_le_bytes();
    let other = [&length, other.as_bytes(), tensors].concat();
    let other = OwnedModel::from_bytes(&other).expect("the same model");
    assert_eq!(format!("{other:?}"), format!("{:?}", sound().load()));
}

#[test]
fn scenes_are_tied_to_what_results_depend_on() {
    let tag_after = |change: &dyn Fn(&mut ModelFile)| {
        let mut file = ModelFile::flat();
        change(&mut file);
        file.load().as_model().tag()
    };
    let tag = tag_after(&|_| ());
    let told: [(&str, Value); 2] = [
        ("metrics", json!({"program": 0.9})),
        ("training", json!({"seed": 4})),
    ];
    for (key, value) in told {
        assert_eq!(
            tag_after(&|file| file.set(key, value.clone())),
            tag,
            "{key}"
        );
    }
    let mut other = common::domain();
    other["name"] = json!("rack");
    let (min, max) = ([0.25, -0.5, 0.0], [0.75, 0.5, 0.5]);
    let mut camera = common::training_camera();
    camera["cx"] = json!(321);
    for (key, value) in [
        ("domain", other),
        ("thresholds", json!({"match_score": 0.5, "decision": 0.5})),
        ("work_space", json!({"min": min, "max": max})),
        ("placed_orientation", json!([0.0, 0.0, 1.0, 0.0])),
        ("training_camera", camera),
    ] {
        assert_ne!(
            tag_after(&|file| file.set(key, value.clone())),
            tag,
            "{key}"
        );
    }
    let weight = |file: &mut ModelFile| file.set_value("camera.weight", 17, 2.0);
    assert_ne!(tag_after(&weight), tag);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// A change that does not alter the content (a space between two entries) may be accepted.
    #[test]
    fn a_changed_header_says_the_same_or_is_refused(
        at in 0..parts(&sound().bytes()).0.len(), mask in 1..=u8::MAX
    ) {
        let mut bytes = sound().bytes();
        bytes[8 + at] ^= mask;
        if OwnedModel::from_bytes(&bytes).is_ok() {
            prop_assert_eq!(metadata_of(&bytes), sound().metadata.clone());
        }
    }
}
