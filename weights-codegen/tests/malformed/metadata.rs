//! Bytes that are not a model file, and metadata that are missing, malformed or out of range.

use nsrm_codegen::{ModelError, OwnedModel};
use serde_json::json;

use crate::common::{self, ModelFile};
use crate::{assert_message, refused, refused_domain};

#[test]
fn not_safetensors() {
    for bytes in [
        &b""[..],
        b"\x00",
        b"PK\x03\x04 a zip file, say",
        &[0xff; 64],
    ] {
        let error = OwnedModel::from_bytes(bytes).expect_err("a refusal");
        assert!(
            matches!(error, ModelError::NotSafetensors { .. }),
            "{error:?}"
        );
        assert_message(
            &error,
            &["not a safetensors file", "pass the model.safetensors"],
        );
    }
}

#[test]
fn truncated() {
    let bytes = ModelFile::random(1).bytes();
    let error = OwnedModel::from_bytes(&bytes[..bytes.len() - 1]).expect_err("a refusal");
    assert!(
        matches!(error, ModelError::NotSafetensors { .. }),
        "{error:?}"
    );
}

#[test]
fn missing_metadata() {
    let keys = [
        "schema",
        "domain",
        "vocabulary",
        "dimensions",
        "thresholds",
        "work_space",
        "placed_orientation",
        "training_camera",
        "training",
        "metrics",
    ];
    for key in keys {
        let error = refused(|file| drop(file.metadata.remove(key)), &[key, "found none"]);
        assert_eq!(error, ModelError::MissingMetadata { key });
    }
}

#[test]
fn missing_hash() {
    let bytes = ModelFile::random(1).bytes();
    let key = b"\"hash\"";
    let at = bytes.windows(key.len()).position(|window| window == key);
    let mut bytes = bytes.clone();
    bytes[at.expect("the key") + 1] = b'H';
    let error = OwnedModel::from_bytes(&bytes).expect_err("a refusal");
    assert_eq!(error, ModelError::MissingMetadata { key: "hash" });
}

#[test]
fn another_schema() {
    for (got, advice) in [
        ("1", "train again"),
        ("2", "`cargo harness convert FILE`"),
        ("3", "`cargo harness convert FILE`"),
        ("4", "`cargo harness convert FILE`"),
        ("5", "`cargo harness convert FILE`"),
        ("6", "`cargo harness convert FILE`"),
        ("7", "`cargo harness convert FILE`"),
        ("8", "`cargo harness convert FILE`"),
    ] {
        let spoil = |file: &mut ModelFile| drop(file.metadata.insert("schema".into(), got.into()));
        let parts = ["`schema`", "expected 9", &format!("{got:?}"), advice];
        let error = refused(spoil, &parts);
        let got = got.into();
        assert_eq!(error, ModelError::Schema { expected: 9, got });
    }
}

#[test]
fn metadata_that_is_no_json() {
    for key in [
        "domain",
        "vocabulary",
        "dimensions",
        "thresholds",
        "work_space",
        "metrics",
    ] {
        let spoil = |file: &mut ModelFile| drop(file.metadata.insert(key.into(), "{oops".into()));
        let error = refused(spoil, &[key, "expected the JSON", "line 1"]);
        assert!(
            matches!(error, ModelError::NotJson { key: k, .. } if k == key),
            "{error:?}"
        );
    }
}

#[test]
fn metadata_of_another_form() {
    let error = refused(
        |file| file.set("work_space", json!({"min": [0, 0]})),
        &["work_space"],
    );
    assert!(
        matches!(
            error,
            ModelError::NotJson {
                key: "work_space",
                ..
            }
        ),
        "{error:?}"
    );
    let error = refused_domain(
        |domain| domain["attribute"][0]["view"] = json!("infrared"),
        &["`domain`", "infrared", "brightness"],
    );
    assert!(
        matches!(error, ModelError::NotJson { key: "domain", .. }),
        "{error:?}"
    );
}

#[test]
fn another_dimension() {
    let error = refused(
        |file| file.set("dimensions", json!({"encoder_hidden": 64})),
        &["encoder_hidden = 48", "got 64"],
    );
    let (name, expected, got) = ("encoder_hidden".into(), 48, 64);
    assert_eq!(
        error,
        ModelError::Dimension {
            name,
            expected,
            got
        }
    );
}

#[test]
fn a_hash_of_another_form() {
    let long = "0".repeat(66);
    let capitals = "A".repeat(64);
    for got in [
        "",
        "abc",
        &"g".repeat(64),
        &capitals,
        &long,
        &"é".repeat(32),
    ] {
        let spoil = |file: &mut ModelFile| drop(file.metadata.insert("hash".into(), got.into()));
        let error = refused(spoil, &["`hash`", "64 lower-case hexadecimal digits"]);
        assert_eq!(error, ModelError::HashForm { got: got.into() });
    }
}

#[test]
fn thresholds_out_of_range() {
    let cases = [
        (
            "match_score",
            json!({"match_score": 1.5, "decision": 0.5}),
            1.5,
        ),
        (
            "match_score",
            json!({"match_score": -0.25, "decision": 0.5}),
            -0.25,
        ),
        (
            "decision",
            json!({"match_score": 0.5, "decision": -0.5}),
            -0.5,
        ),
        (
            "decision",
            json!({"match_score": 0.5, "decision": 2.0}),
            2.0,
        ),
    ];
    for (name, thresholds, got) in cases {
        let error = refused(
            |file| file.set("thresholds", thresholds),
            &["thresholds", name],
        );
        assert_eq!(error, ModelError::Threshold { name, got });
    }
}

#[test]
fn an_empty_or_unbounded_work_space() {
    let cases = [
        (
            'x',
            json!({"min": [0.75, -0.5, 0.0], "max": [0.25, 0.5, 0.25]}),
        ),
        (
            'z',
            json!({"min": [0.25, -0.5, 0.5], "max": [0.75, 0.5, 0.5]}),
        ),
        (
            'y',
            json!({"min": [0.25, -1e39, 0.0], "max": [0.75, 0.5, 0.25]}),
        ),
    ];
    for (expected, work_space) in cases {
        let error = refused(|file| file.set("work_space", work_space), &["work_space"]);
        assert!(matches!(error, ModelError::WorkSpace { axis, .. } if axis == expected));
    }
}

#[test]
fn an_orientation_that_is_none() {
    for quaternion in [
        json!([0, 0, 0, 0]),
        json!([1, 0, 0, 1]),
        json!([0, 0, 0, 1e39]),
    ] {
        let spoil = |file: &mut ModelFile| file.set("placed_orientation", quaternion);
        let error = refused(spoil, &["placed_orientation", "unit quaternion"]);
        assert!(
            matches!(error, ModelError::PlacedOrientation { .. }),
            "{error:?}"
        );
    }
}

#[test]
fn a_camera_that_is_none() {
    for (field, value, part) in [
        ("fx", json!(0), "fx must be greater than 0"),
        ("width", json!(0), "width must be greater than 0"),
        (
            "position",
            json!([0, 0, 1e39]),
            "position is not a finite number",
        ),
        ("orientation", json!([1, 0, 0, 1]), "quaternion of length 1"),
    ] {
        let mut camera = common::training_camera();
        camera[field] = value;
        let spoil = |file: &mut ModelFile| file.set("training_camera", camera);
        let error = refused(spoil, &["training_camera", part]);
        assert!(matches!(error, ModelError::TrainingCamera(_)), "{error:?}");
    }
    let mut camera = common::training_camera();
    camera["height"] = json!(-1);
    let spoil = |file: &mut ModelFile| file.set("training_camera", camera);
    let error = refused(spoil, &["training_camera"]);
    assert!(matches!(error, ModelError::NotJson { .. }), "{error:?}");
}
