//! Any scene file gives a scene or a typed error, never a panic.

use nsrm::{AnyModel, read_scene};
use proptest::prelude::*;
use serde_json::{Map, Number, Value};

/// Any JSON, of a limited size.
fn json() -> impl Strategy<Value = Value> {
    let leaf = prop_oneof![
        Just(Value::Null),
        any::<bool>().prop_map(Value::from),
        any::<i64>().prop_map(Value::from),
        any::<f64>().prop_map(|x| Number::from_f64(x).map_or(Value::Null, Value::Number)),
        ".{0,8}".prop_map(Value::from),
    ];
    leaf.prop_recursive(3, 24, 6, |inner| {
        prop_oneof![
            proptest::collection::vec(inner.clone(), 0..6).prop_map(Value::from),
            proptest::collection::btree_map(".{0,4}", inner, 0..6)
                .prop_map(|map| Value::Object(Map::from_iter(map))),
        ]
    })
}

/// A scene of the right structure with arbitrary numbers.
fn scene() -> impl Strategy<Value = Value> {
    let number = || {
        prop_oneof![
            -1.5..1.5f64,
            any::<f64>().prop_filter("finite", |x| x.is_finite())
        ]
    };
    let numbers = move |count| proptest::collection::vec(number(), count);
    let object = (any::<u32>(), numbers(4), number()).prop_map(
        |(id, corners, depth)| serde_json::json!({"id": id, "box": corners, "depth": depth}),
    );
    let camera = (any::<[u32; 2]>(), numbers(4), numbers(3), numbers(4)).prop_map(
        |([width, height], intrinsics, position, orientation)| {
            serde_json::json!({
                "width": width, "height": height,
                "fx": intrinsics[0], "fy": intrinsics[1], "cx": intrinsics[2], "cy": intrinsics[3],
                "position": position, "orientation": orientation,
            })
        },
    );
    (camera, proptest::collection::vec(object, 0..20)).prop_map(|(camera, objects)| {
        serde_json::json!({"schema": 1, "camera": camera, "image": "x.png", "objects": objects})
    })
}

fn read(bytes: &[u8]) -> bool {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.json");
    std::fs::write(&path, bytes).expect("a file");
    read_scene(&path, None, &AnyModel::Pretrained.model()).is_ok()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn any_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..256)) {
        prop_assert!(!read(&bytes));
    }

    #[test]
    fn any_json(json in json()) {
        prop_assert!(!read(json.to_string().as_bytes()));
    }

    #[test]
    fn any_numbers(scene in scene()) {
        // There is no image.
        prop_assert!(!read(scene.to_string().as_bytes()));
    }

    #[test]
    fn any_image(bytes in proptest::collection::vec(any::<u8>(), 0..256), signed in any::<bool>()) {
        let folder = tempfile::tempdir().expect("a folder");
        let mut image = if signed { b"\x89PNG\r\n\x1a\n".to_vec() } else { Vec::new() };
        image.extend(bytes);
        std::fs::write(folder.path().join("x.png"), image).expect("a file");
        let scene = serde_json::json!({
            "schema": 1,
            "camera": {
                "width": 4, "height": 4, "fx": 1, "fy": 1, "cx": 2, "cy": 2,
                "position": [0, 0, 0], "orientation": [0, 0, 0, 1],
            },
            "image": "x.png",
            "objects": [{"id": 1, "box": [0, 0, 1, 1], "depth": 1}],
        });
        let path = folder.path().join("scene.json");
        std::fs::write(&path, scene.to_string()).expect("a file");
        prop_assert!(read_scene(&path, None, &AnyModel::Pretrained.model()).is_err());
    }
}
