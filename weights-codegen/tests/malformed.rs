//! One malformation, one variant, one message.

mod common;

use common::ModelFile;
use nsrm_codegen::{ModelError, OwnedModel};
use serde_json::{Value, json};

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
            &["not a safetensors file", "give the model.safetensors"],
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
    let error = refused(
        |file| file.set("schema", json!(1)),
        &["`schema`", "expected 2", "\"1\""],
    );
    let got = "1".into();
    assert_eq!(error, ModelError::Schema { expected: 2, got });
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
fn empty_lists() {
    let spoils: [SpoilDomain; 5] = [
        |domain| domain["attribute"] = json!([]),
        |domain| domain["action"] = json!([]),
        |domain| domain["attribute"][1]["values"] = json!([]),
        |domain| domain["attribute"][1]["values"][0]["words"] = json!([]),
        |domain| domain["action"][1]["phrases"] = json!([]),
    ];
    for spoil in spoils {
        let error = refused_domain(spoil, &["must not be empty", "train again"]);
        assert!(matches!(error, ModelError::Empty { .. }), "{error:?}");
    }
}

#[test]
fn more_names_than_an_index_holds() {
    let value = |n: usize| json!({"name": format!("v{n}"), "words": [format!("v{n}")]});
    let action = |n: usize| json!({"name": format!("a{n}"), "phrases": ["onto"]});
    let attribute =
        |n: usize| json!({"name": format!("t{n}"), "view": "color", "values": [value(n)]});
    let spoils: [(&str, &str, Vec<Value>); 3] = [
        (
            "concepts",
            "/attribute/0/values",
            (0..253).map(value).collect(),
        ),
        ("actions", "/action", (0..257).map(action).collect()),
        (
            "attribute types",
            "/attribute",
            (0..257).map(attribute).collect(),
        ),
    ];
    for (what, place, list) in spoils {
        let spoil = |domain: &mut Value| *domain.pointer_mut(place).expect("a list") = json!(list);
        let error = refused_domain(spoil, &["at most 256", what, "got 257"]);
        assert_eq!(
            error,
            ModelError::TooMany {
                what,
                limit: 256,
                got: 257
            }
        );
    }
}

#[test]
fn more_words_than_an_index_holds() {
    let nouns: Vec<String> = (0..70_000).map(|n| format!("n{n}")).collect();
    let spoil = |domain: &mut Value| domain["grammar"]["nouns"] = json!(nouns);
    let error = refused_domain(spoil, &["at most 65536 words"]);
    assert!(matches!(
        error,
        ModelError::TooMany {
            what: "words",
            limit: 65_536,
            ..
        }
    ));
}

#[test]
fn names_that_stand_there_twice() {
    let spoils: [(&str, &str, SpoilDomain); 5] = [
        ("attribute type", "tint", |domain| {
            domain["attribute"][1]["name"] = json!("tint")
        }),
        ("concept", "teal", |domain| {
            domain["attribute"][1]["values"][0]["name"] = json!("teal");
        }),
        ("action", "Stack", |domain| {
            domain["action"][1]["name"] = json!("Stack")
        }),
        ("word", "teal", |domain| {
            domain["attribute"][1]["values"][0]["words"] = json!(["teal"]);
        }),
        ("word", "teal", |domain| {
            domain["grammar"]["nouns"] = json!(["teal"])
        }),
    ];
    for (what, name, spoil) in spoils {
        let error = refused_domain(spoil, &[what, name, "twice"]);
        assert_eq!(
            error,
            ModelError::Duplicate {
                what,
                name: name.into()
            }
        );
    }
}

#[test]
fn words_that_no_sentence_contains() {
    for word in ["Jar", "", "two words", "jar.", "'jar", "a,b"] {
        let spoil =
            |domain: &mut Value| domain["attribute"][0]["values"][1]["words"] = json!([word]);
        let error = refused_domain(spoil, &["no sentence can contain"]);
        assert_eq!(error, ModelError::UnreadableWord { word: word.into() });
    }
    let error = refused_domain(
        |domain| domain["grammar"]["nouns"] = json!(["Jar"]),
        &["Jar"],
    );
    assert_eq!(error, ModelError::UnreadableWord { word: "Jar".into() });
}

#[test]
fn no_group_token() {
    for (vocabulary, got) in [(json!([]), ""), (json!(["the", "[[X]]"]), "the")] {
        let error = refused(
            |file| file.set("vocabulary", vocabulary),
            &["[[X]]", "first entry"],
        );
        assert_eq!(error, ModelError::GroupToken { got: got.into() });
    }
}

fn vocabulary(change: impl FnOnce(&mut Vec<&str>)) -> Value {
    let mut words = vec!["[[X]]"];
    words.extend(common::WORDS);
    change(&mut words);
    json!(words)
}

#[test]
fn a_vocabulary_that_is_not_the_domains() {
    let words = vocabulary(|words| words[3] = "mug");
    let error = refused(
        |file| file.set("vocabulary", words),
        &["lacks \"jar\"", "has besides \"mug\"", "train again"],
    );
    let (missing, extra) = (vec!["jar".into()], vec!["mug".into()]);
    assert_eq!(error, ModelError::Vocabulary { missing, extra });
}

#[test]
fn a_long_difference_is_cut_short() {
    let error = refused(
        |file| file.set("vocabulary", json!(["[[X]]"])),
        &["and 1 more"],
    );
    assert!(matches!(error, ModelError::Vocabulary { ref missing, .. } if missing.len() == 9));
}

#[test]
fn a_word_twice_in_the_vocabulary() {
    let words = vocabulary(|words| words.push("the"));
    let error = refused(|file| file.set("vocabulary", words), &["\"the\"", "twice"]);
    let what = "word of the vocabulary";
    assert_eq!(
        error,
        ModelError::Duplicate {
            what,
            name: "the".into()
        }
    );
}

#[test]
fn a_vocabulary_out_of_order() {
    let words = vocabulary(|words| words.swap(2, 3));
    let error = refused(
        |file| file.set("vocabulary", words),
        &["\"jar\" before \"beside\""],
    );
    let (first, second) = ("jar".into(), "beside".into());
    assert_eq!(error, ModelError::VocabularyOrder { first, second });
}

#[test]
fn every_missing_tensor_is_named() {
    for (name, tensor) in ModelFile::random(1).tensors {
        let error = refused(
            |file| drop(file.tensors.remove(&name)),
            &[&name, "no such tensor"],
        );
        let expected = tensor.shape;
        assert_eq!(error, ModelError::MissingTensor { name, expected });
    }
}

#[test]
fn an_extra_tensor() {
    let name = "vision.operator.shape.hidden.bias";
    let error = refused(
        |file| {
            let copy = file.tensor("vision.operator.tint.hidden.bias").clone();
            file.tensors.insert(name.into(), copy);
        },
        &[name, "architecture has no such tensor"],
    );
    assert_eq!(error, ModelError::ExtraTensor { name: name.into() });
}

#[test]
fn every_wrong_shape_is_named() {
    for (name, tensor) in ModelFile::random(1).tensors {
        let mut got = tensor.shape.clone();
        got.push(1);
        let spoil = |file: &mut ModelFile| file.tensor(&name).shape.push(1);
        let error = refused(spoil, &[&name, &format!("{got:?}")]);
        let expected = tensor.shape;
        assert_eq!(
            error,
            ModelError::Shape {
                name,
                expected,
                got
            }
        );
    }
}

#[test]
fn a_transposed_shape() {
    let name = "language.encoder.forward.weight_ih";
    let error = refused(
        |file| file.tensor(name).shape.reverse(),
        &[name, "[144, 32]", "[32, 144]"],
    );
    let (expected, got) = (vec![144, 32], vec![32, 144]);
    assert_eq!(
        error,
        ModelError::Shape {
            name: name.into(),
            expected,
            got
        }
    );
}

#[test]
fn other_element_types() {
    let name = "vision.color.patch.bias";
    for (dtype, bytes) in [("F16", 48), ("F64", 192), ("I32", 96), ("U8", 24)] {
        let error = refused(
            |file| {
                file.tensor(name).dtype = dtype;
                file.tensor(name).bytes = vec![0; bytes];
            },
            &[name, "expected elements F32", dtype, "float32"],
        );
        let got = dtype.into();
        assert_eq!(
            error,
            ModelError::ElementType {
                name: name.into(),
                got
            }
        );
    }
}

#[test]
fn values_that_are_not_finite() {
    let name = "language.splitter.gru.weight_hh";
    for (value, got) in [
        (f32::NAN, "NaN"),
        (f32::INFINITY, "inf"),
        (f32::NEG_INFINITY, "-inf"),
    ] {
        let spoil = |file: &mut ModelFile| file.set_value(name, 77, value);
        let error = refused(spoil, &[name, got, "position 77"]);
        let (name, got) = (name.into(), got.into());
        assert_eq!(
            error,
            ModelError::NotFinite {
                name,
                index: 77,
                got
            }
        );
    }
}

#[test]
fn products_that_overflow() {
    let spoils: [(&str, SpoilFile); 4] = [
        ("words.forward_gates", |file| {
            file.set_value("language.embedding.weight", 0, 1e30);
            file.set_value("language.encoder.forward.weight_ih", 0, 1e30);
        }),
        ("words.hazard_next", |file| {
            file.set_value("language.splitter.embedding.weight", 24, 1e20);
            file.set_value("language.splitter.hidden.weight", 32, 1e30);
        }),
        ("simulator.input", |file| {
            file.set_value("action.simulator.location_scale", 0, 1e-10);
            file.set_value("action.simulator.input.weight", 2, 1e30);
        }),
        ("actions.simulator_bias", |file| {
            file.set_value("action.simulator.location_mean", 1, 1e30);
            file.set_value("action.simulator.input.weight", 3, 1e30);
        }),
    ];
    for (name, spoil) in spoils {
        let error = refused(spoil, &[name, "does not fit an f32"]);
        assert_eq!(error, ModelError::FoldedNotFinite { name: name.into() });
    }
}

#[test]
fn a_concept_without_direction() {
    let spoil = |file: &mut ModelFile| {
        (0..16).for_each(|index| file.set_value("vision.concept.weight", 4 * 16 + index, 0.0));
    };
    let error = refused(spoil, &["vision.concept.weight", "\"tiny\"", "length 0"]);
    let concept = "tiny".into();
    assert_eq!(
        error,
        ModelError::ConceptLength {
            concept,
            length: 0.0
        }
    );
}

#[test]
fn a_scale_that_is_not_positive() {
    for got in [0.0, -0.25] {
        let name = "action.simulator.location_scale";
        let spoil = |file: &mut ModelFile| file.set_value(name, 3, got);
        let error = refused(spoil, &[name, "positive", "position 3"]);
        assert_eq!(error, ModelError::LocationScale { index: 3, got });
    }
}

#[test]
fn a_hash_of_another_form() {
    let long = "0".repeat(66);
    for got in ["", "abc", &"g".repeat(64), &long, &"é".repeat(32)] {
        let spoil = |file: &mut ModelFile| drop(file.metadata.insert("hash".into(), got.into()));
        let error = refused(spoil, &["`hash`", "64 hexadecimal digits"]);
        assert_eq!(error, ModelError::HashForm { got: got.into() });
    }
}

#[test]
fn tensors_that_are_not_those_of_the_hash() {
    let expected = "00".repeat(32);
    let spoil = |file: &mut ModelFile| drop(file.metadata.insert("hash".into(), expected.clone()));
    let error = refused(spoil, &[&expected, "changed or damaged"]);
    assert!(matches!(error, ModelError::Hash { expected: e, .. } if e == expected));
    // One flipped bit in the last value of the file.
    let mut bytes = ModelFile::random(1).bytes();
    let last = bytes.len() - 4;
    bytes[last] ^= 1;
    let error = OwnedModel::from_bytes(&bytes).expect_err("a refusal");
    assert!(matches!(error, ModelError::Hash { .. }), "{error:?}");
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
