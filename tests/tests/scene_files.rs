//! Any JSON, and any bytes, as a scene file: a scene that can be planned in or a
//! typed error, never a panic.

use std::path::Path;

use nsrm::{SceneFileError, read_scene};
use nsrm_core::Planner;
use nsrm_tabletop::TABLETOP;
use nsrm_tests::picture::write_png;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::{Index, select};
use serde_json::{Value, json};

/// Writes a scene file beside a small image, and reads it.
fn read(folder: &Path, bytes: &[u8]) -> Result<(), SceneFileError> {
    let path = folder.join("scene.json");
    std::fs::write(&path, bytes).expect("a temporary folder can be written to");
    let scene = read_scene(&path, None, &TABLETOP)?;
    let planned = Planner::new(&TABLETOP).plan(&scene, "put the red block on the blue block");
    if let Ok(plan) = planned {
        for goal in plan.sub_goals() {
            let position = goal.pose.translation.vector;
            assert!(position.iter().all(|number| number.is_finite()));
        }
    }
    Ok(())
}

/// A folder with an image of 8 × 6 pixels.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let pixels = (0..6).flat_map(|y| (0..8).flat_map(move |x| [x * 30, y * 40, 90]));
    let pixels: Vec<u8> = pixels.collect();
    write_png(&folder.path().join("image.png"), [8, 6], &pixels);
    folder
}

/// A scene file as it should be.
fn good() -> Value {
    json!({
        "schema": 1,
        "camera": {
            "width": 8, "height": 6, "fx": 10.0, "fy": 10.0, "cx": 4.0, "cy": 3.0,
            "position": [0.5, 0.0, 1.0], "orientation": [1.0, 0.0, 0.0, 0.0],
        },
        "image": "image.png",
        "objects": [
            {"id": 1, "box": [0.1, 0.2, 0.4, 0.6], "depth": 0.9},
            {"id": 2, "box": [0.5, 0.2, 0.8, 0.6], "depth": 0.9},
        ],
    })
}

fn any_json() -> impl Strategy<Value = Value> {
    let awkward = select(vec![
        json!(0),
        json!(-1),
        json!(1e39),
        json!(-1e300),
        json!(u64::MAX),
        json!(0.5),
        json!("image.png"),
        json!(".."),
    ]);
    let leaf = prop_oneof![
        Just(Value::Null),
        any::<bool>().prop_map(Value::from),
        any::<i64>().prop_map(Value::from),
        any::<f64>().prop_map(Value::from),
        "\\PC{0,8}".prop_map(Value::from),
        awkward,
    ];
    let name = select(vec![
        "schema", "camera", "image", "objects", "id", "box", "depth", "width", "other",
    ]);
    leaf.prop_recursive(4, 32, 6, move |inner| {
        prop_oneof![
            vec(inner.clone(), 0..6).prop_map(Value::from),
            vec((name.clone(), inner), 0..6).prop_map(|entries| {
                let entries = entries
                    .into_iter()
                    .map(|(name, value)| (name.to_owned(), value));
                Value::Object(entries.collect())
            }),
        ]
    })
}

/// The way to every value inside of this one, itself first.
fn places(value: &Value, path: &mut Vec<String>, found: &mut Vec<Vec<String>>) {
    found.push(path.clone());
    let inner: Vec<(String, &Value)> = match value {
        Value::Array(values) => (0..).map(|i: usize| i.to_string()).zip(values).collect(),
        Value::Object(entries) => entries.iter().map(|(k, v)| (k.clone(), v)).collect(),
        _ => return,
    };
    for (name, value) in inner {
        path.push(name);
        places(value, path, found);
        path.pop();
    }
}

/// The scene file as it should be, with one value in it replaced.
fn with_one_replaced(place: &Index, value: Value) -> Value {
    let mut scene = good();
    let mut found = Vec::new();
    places(&scene, &mut Vec::new(), &mut found);
    let path = place.get(&found);
    let mut target = &mut scene;
    for name in path {
        target = match target {
            Value::Array(values) => &mut values[name.parse::<usize>().expect("an index")],
            other => &mut other[name.as_str()],
        };
    }
    *target = value;
    scene
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, ..ProptestConfig::default() })]

    #[test]
    fn any_json_is_a_scene_or_a_typed_error(value in any_json()) {
        let folder = folder();
        let _ = read(folder.path(), value.to_string().as_bytes());
    }

    #[test]
    fn one_wrong_value_makes_a_typed_error_or_no_difference(
        place in any::<Index>(),
        value in any_json(),
    ) {
        let folder = folder();
        let scene = with_one_replaced(&place, value);
        if let Err(error) = read(folder.path(), scene.to_string().as_bytes()) {
            // The message names the file.
            prop_assert!(error.to_string().contains(folder.path().to_str().unwrap()));
        }
    }

    #[test]
    fn any_bytes_are_a_scene_or_a_typed_error(bytes in vec(any::<u8>(), 0..200)) {
        let folder = folder();
        prop_assert!(read(folder.path(), &bytes).is_err());
    }

    #[test]
    fn a_file_that_ends_early_is_a_typed_error(end in any::<Index>()) {
        let folder = folder();
        let text = good().to_string();
        let bytes = &text.as_bytes()[..end.index(text.len())];
        let is_json_error = matches!(
            read(folder.path(), bytes),
            Err(SceneFileError::Json { .. })
        );
        prop_assert!(is_json_error);
    }
}

/// The properties above would hold of a reader that refuses everything.
#[test]
fn the_file_as_it_should_be_is_read() {
    let folder = folder();
    read(folder.path(), good().to_string().as_bytes()).unwrap();
}
