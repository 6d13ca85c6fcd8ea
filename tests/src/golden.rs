//! The trainer's golden vectors, `tests/golden`: arrays by name, and the cases that refer to them.
//! `tests/golden/README.md` describes them.

use std::path::PathBuf;

use nsrm_core::Camera;
use safetensors::{Dtype, SafeTensors};
use serde_json::Value;

/// Arrays and cases.
pub struct Golden {
    bytes: Vec<u8>,
    /// `cases.json`.
    pub cases: Value,
}

/// An array of `f32`, row-major.
#[derive(Debug, Clone)]
pub struct Array {
    /// Its name in the file, for messages.
    pub name: String,
    /// Its dimensions.
    pub shape: Vec<usize>,
    /// Its values.
    pub values: Vec<f32>,
}

impl Golden {
    /// The committed vectors.
    ///
    /// # Panics
    /// If they are missing: a test without its vectors must not pass.
    pub fn read() -> Self {
        let read = |name: &str| {
            let path = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
                .join("golden")
                .join(name);
            std::fs::read(&path).unwrap_or_else(|error| {
                panic!(
                    "{}: {error}; write it with cargo harness golden",
                    path.display()
                )
            })
        };
        let cases = serde_json::from_slice(&read("cases.json")).expect("cases.json is JSON");
        Self {
            bytes: read("golden.safetensors"),
            cases,
        }
    }

    /// An array, by name; integers become `f32`, which holds these exactly.
    ///
    /// # Panics
    /// If there is none of that name.
    pub fn array(&self, name: &str) -> Array {
        let tensors = SafeTensors::deserialize(&self.bytes).expect("golden.safetensors");
        let tensor = tensors
            .tensor(name)
            .unwrap_or_else(|_| panic!("golden.safetensors has no {name}"));
        let words = || tensor.data().as_chunks::<4>().0.iter();
        let values = match tensor.dtype() {
            Dtype::F32 => words().map(|word| f32::from_le_bytes(*word)).collect(),
            Dtype::I32 => words()
                .map(|word| i32::from_le_bytes(*word) as f32)
                .collect(),
            Dtype::U8 => tensor.data().iter().map(|byte| f32::from(*byte)).collect(),
            other => panic!("{name}: element type {other:?}"),
        };
        Array {
            name: name.to_owned(),
            shape: tensor.shape().to_vec(),
            values,
        }
    }

    /// Panics unless `got` is `expected` within the tolerance of this name.
    pub fn close(&self, tolerance: &str, got: &[f32], expected: &[f32], what: &str) {
        assert_eq!(got.len(), expected.len(), "{what}: lengths");
        let named = &self.cases["tolerances"][tolerance];
        let number = |part: &str| {
            let value = named[part].as_f64();
            value.unwrap_or_else(|| panic!("cases.json: no tolerance {tolerance}.{part}"))
        };
        let (absolute, relative) = (number("absolute"), number("relative"));
        for (index, (&got, &expected)) in got.iter().zip(expected).enumerate() {
            let difference = f64::from(got) - f64::from(expected);
            let allowed = absolute + relative * f64::from(expected).abs();
            assert!(
                difference.abs() <= allowed,
                "{what}[{index}]: got {got}, the trainer has {expected}; {tolerance} allows {allowed:e}"
            );
        }
    }
}

impl Array {
    /// The rows: all values with the same first index, in order.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &[f32]> {
        let count = self.shape.first().copied().unwrap_or(0);
        let length = self.values.len().checked_div(count).unwrap_or(0);
        (0..count).map(move |row| &self.values[row * length..(row + 1) * length])
    }

    /// Converts row-major `[ROWS, COLUMNS]` to columns, as in core's layers.
    ///
    /// # Panics
    /// If it has another shape.
    pub fn columns<const ROWS: usize, const COLUMNS: usize>(&self) -> [[f32; ROWS]; COLUMNS] {
        assert_eq!(self.shape, [ROWS, COLUMNS], "{}", self.name);
        std::array::from_fn(|column| std::array::from_fn(|row| self.values[row * COLUMNS + column]))
    }

    /// All values as a fixed array.
    ///
    /// # Panics
    /// If there are more or fewer.
    pub fn fixed<const LENGTH: usize>(&self) -> [f32; LENGTH] {
        fixed(&self.values)
    }
}

/// A slice as a fixed array.
///
/// # Panics
/// If it has another length.
pub fn fixed<const LENGTH: usize>(values: &[f32]) -> [f32; LENGTH] {
    values
        .try_into()
        .unwrap_or_else(|_| panic!("{} values, expected {LENGTH}", values.len()))
}

/// A camera of `cases.json`.
///
/// # Panics
/// If it is invalid.
pub fn camera(case: &Value) -> Camera {
    let number = |name: &str| case[name].as_f64().expect(name) as f32;
    let list = |name: &str| -> Vec<f32> {
        let values = numbers(&case[name]).into_iter();
        values.map(|value| value as f32).collect()
    };
    Camera {
        width: number("width") as u32,
        height: number("height") as u32,
        fx: number("fx"),
        fy: number("fy"),
        cx: number("cx"),
        cy: number("cy"),
        position: fixed(&list("position")),
        orientation: fixed(&list("orientation")),
    }
}

/// A list of numbers of `cases.json`.
///
/// # Panics
/// If it is invalid.
pub fn numbers(value: &Value) -> Vec<f64> {
    let values = value.as_array().expect("a list").iter();
    values
        .map(|number| number.as_f64().expect("a number"))
        .collect()
}
