//! Tensors that are missing, of the wrong shape or type, or with invalid values.

use nsrm_codegen::{ModelError, OwnedModel};

use crate::common::ModelFile;
use crate::{SpoilFile, refused};

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
    let spoils: [(&str, SpoilFile); 2] = [
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
