//! The Rust source: the text is reproducible, and its values are those of the loader.

mod common;
#[allow(unreachable_pub, reason = "written for a public module")]
#[path = "snapshots/shelf.rs"]
mod shelf;

use std::path::Path;

use common::ModelFile;
use nsrm_codegen::{InvalidName, Options, OwnedModel, memory_report, rust_source};
use nsrm_core::nn::Precision;
use nsrm_tabletop::{TABLETOP, TABLETOP_INT8};

fn shelf_source() -> String {
    let options = Options::new("SHELF").expect("a static's name");
    rust_source(&ModelFile::flat().load(), &options)
}

/// After a wanted change of the text: `NSRM_UPDATE_SNAPSHOTS=1 cargo test -p nsrm-codegen`.
#[test]
fn snapshot() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/snapshots/shelf.rs");
    if std::env::var_os("NSRM_UPDATE_SNAPSHOTS").is_some() {
        std::fs::write(&path, shelf_source()).expect("a writable snapshot");
    }
    let written = std::fs::read_to_string(&path).expect("the snapshot");
    for (line, (got, expected)) in shelf_source().lines().zip(written.lines()).enumerate() {
        assert_eq!(got, expected, "line {}", line + 1);
    }
    assert_eq!(shelf_source(), written);
}

#[test]
fn compiled_snapshot_is_the_loaded_model() {
    let owned = ModelFile::flat().load();
    assert_eq!(
        format!("{:?}", shelf::SHELF),
        format!("{:?}", owned.as_model())
    );
    let about: serde_json::Value = serde_json::from_str(shelf::SHELF_ABOUT).expect("JSON");
    assert_eq!(&about["training"], owned.training());
    assert_eq!(&about["metrics"], owned.metrics());
}

/// What is committed in `tabletop` is what the command writes from the committed model.
#[test]
fn pretrained_is_in_step() {
    let tabletop = Path::new(env!("CARGO_MANIFEST_DIR")).join("tabletop");
    let bytes = std::fs::read(tabletop.join("tabletop.safetensors")).expect("the model");
    for (name, file, precision, compiled) in [
        ("TABLETOP", "generated.rs", Precision::F32, TABLETOP),
        ("TABLETOP_INT8", "int8.rs", Precision::Int8, TABLETOP_INT8),
    ] {
        let owned = OwnedModel::from_bytes_as(&bytes, precision).expect("a sound model");
        let written = tabletop.join("src").join(file);
        let written = std::fs::read_to_string(written).expect("the source");
        let options = Options::new(name).expect("a static's name");
        assert!(
            rust_source(&owned, &options) == written,
            "{file} is out of date: CONTRIBUTING.md says how it is written"
        );
        assert!(
            format!("{compiled:?}") == format!("{:?}", owned.as_model()),
            "{name}: statics and loaded model differ"
        );
    }
}

#[test]
fn numbers_read_back_as_the_same_bits() {
    let mut file = ModelFile::random(1);
    let hard = [
        -0.0,
        f32::MIN_POSITIVE,
        1.0e-45,
        16_777_217.0,
        0.1,
        3.4e38,
        -1.175_494_2e-38,
    ];
    for (index, &value) in hard.iter().enumerate() {
        file.set_value("vision.color.dense.bias", index, value);
    }
    let source = rust_source(&file.load(), &Options::new("M").expect("a name"));
    let layer = source.split("static COLOR_DENSE").nth(1);
    let bias = layer.expect("the dense layer").split(".with_bias([").nth(1);
    let bias = bias.expect("its bias");
    let texts = bias.split(']').next().expect("its numbers").split(',');
    let got: Vec<u32> = texts
        .take(hard.len())
        .map(|text| text.trim().parse::<f32>().expect("a number").to_bits())
        .collect();
    assert_eq!(got, hard.map(f32::to_bits));
}

#[test]
fn same_bytes_same_text() {
    let bytes = ModelFile::random(2).bytes();
    let options = Options::new("M").expect("a name");
    let source = || rust_source(&OwnedModel::from_bytes(&bytes).expect("a model"), &options);
    let first = source();
    assert_eq!(first, source());
    let long = first.lines().filter(|line| !line.contains("_ABOUT"));
    assert!(long.map(str::len).max() <= Some(100));
}

#[test]
fn names_of_statics() {
    for name in ["", "tabletop", "1ST", "_A", "A-B", "Ä", "A B"] {
        assert_eq!(Options::new(name), Err(InvalidName { name: name.into() }));
    }
    assert!(Options::new("SHELF_2").is_ok());
}

#[test]
fn memory_is_counted_array_by_array() {
    let report = memory_report(&ModelFile::random(1).load().as_model());
    let bytes = |path: &str| {
        let array = report.arrays.iter().find(|array| array.path == path);
        array.map(|array| (array.count, array.bytes))
    };
    assert_eq!(bytes("language.forward.weight_hh"), Some((6912, 27648)));
    assert_eq!(bytes("embeddings.encoder"), Some((10 * 32, 10 * 128)));
    assert_eq!(bytes("concepts.attribute"), Some((7, 7)));
    assert_eq!(bytes("simulator.input"), Some((640, 2560)));
    let rounded = ModelFile::random(1).load_as(Precision::Int8);
    let rounded = memory_report(&rounded.as_model());
    let cell = rounded
        .arrays
        .iter()
        .find(|array| array.path == "language.forward.weight_hh");
    assert_eq!(cell.map(|array| array.bytes), Some(6912));
    assert!(rounded.total() < report.total() / 2);
    let numbers: usize = report.arrays.iter().map(|array| array.bytes).sum();
    assert_eq!(report.total(), numbers + report.texts + report.tables);
    let text = report.to_string();
    assert!(
        text.ends_with(&format!("{:>9}           total", report.total())),
        "{text}"
    );
}
