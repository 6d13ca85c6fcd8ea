//! A model file with another least confidence is that file in everything else.

mod common;

use common::ModelFile;
use nsrm_codegen::{ModelError, OwnedModel, with_confidence};

#[test]
fn only_the_confidence_changes_and_the_identity_with_it() {
    let bytes = ModelFile::flat().bytes();
    let before = OwnedModel::from_bytes(&bytes).expect("a model");
    let written = with_confidence(&bytes, 0.98).expect("a model");
    let after = OwnedModel::from_bytes(&written).expect("a model");
    let (before, after) = (before.as_model(), after.as_model());
    let thresholds = after.header.thresholds;
    assert_eq!(thresholds, before.header.thresholds.with_confidence(0.98));
    assert_ne!(after.tag(), before.tag());
    // Set back, it has the same arrays: the whole model is printed.
    let header = after.header.with_thresholds(before.header.thresholds);
    let header = header.with_identity(before.header.identity);
    assert_eq!(
        format!("{:?}", after.with_header(header)),
        format!("{before:?}")
    );
    // The same bytes each time, and an earlier confidence is replaced.
    assert_eq!(with_confidence(&written, 0.98), Ok(written));
}

#[test]
fn what_is_no_confidence_or_no_model_is_refused() {
    let bytes = ModelFile::flat().bytes();
    for confidence in [-0.1, 1.1, f32::NAN] {
        let error = with_confidence(&bytes, confidence).expect_err("no confidence");
        assert!(
            matches!(
                error,
                ModelError::Threshold {
                    name: "confidence",
                    ..
                }
            ),
            "{error}"
        );
    }
    let mut damaged = bytes.clone();
    *damaged.last_mut().expect("tensors") ^= 1;
    let error = with_confidence(&damaged, 0.98).expect_err("damaged");
    assert!(matches!(error, ModelError::Hash { .. }), "{error}");
    assert!(with_confidence(&bytes[..7], 0.98).is_err());
}
