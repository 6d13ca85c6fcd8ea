//! The read-only memory of a model, by array.

use std::fmt;

use nsrm_core::model::Model;

use crate::statics::{model_record, statics};
use crate::tree::Node;

/// Read-only memory of a model, array by array.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct MemoryReport {
    /// Numbers, in the order of [`nsrm_core::model::Model`].
    pub arrays: Vec<ArraySize>,
    /// Text of words and names, in bytes.
    pub texts: usize,
    /// References, lengths and padding on this machine's architecture, in bytes; about half with
    /// 32-bit pointers.
    pub tables: usize,
}

/// Read-only memory of one array, or of one field in all entries of a table.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct ArraySize {
    /// Path in [`nsrm_core::model::Model`].
    pub path: String,
    /// Numbers in it.
    pub count: usize,
    /// Bytes of these numbers.
    pub bytes: usize,
}

impl MemoryReport {
    /// The total, in bytes.
    pub fn total(&self) -> usize {
        self.arrays.iter().map(|array| array.bytes).sum::<usize>() + self.texts + self.tables
    }

    fn add(&mut self, path: &str, node: &Node) {
        match node {
            Node::Scalar { bytes, .. } => self.add_scalar(path, *bytes),
            Node::Text(text) => self.texts += text.len(),
            Node::Reference(_) | Node::Variant(..) => {}
            Node::Array(elements) => {
                for element in elements {
                    self.add(path, element);
                }
            }
            Node::Record(_, fields) => {
                for (field, node) in fields {
                    self.add(&format!("{path}.{field}"), node);
                }
            }
        }
    }

    fn add_scalar(&mut self, path: &str, bytes: usize) {
        match self.arrays.iter_mut().find(|array| array.path == path) {
            Some(array) => {
                array.count += 1;
                array.bytes += bytes;
            }
            None => self.arrays.push(ArraySize {
                path: path.into(),
                count: 1,
                bytes,
            }),
        }
    }
}

/// Counts the statics that [`crate::rust_source`] writes for this model.
pub fn memory_report(model: &Model<'_>) -> MemoryReport {
    let mut report = MemoryReport {
        arrays: Vec::new(),
        texts: 0,
        tables: 0,
    };
    let Node::Record(_, fields) = model_record(model) else {
        return report;
    };
    let mut size = size_of_val(model);
    for (field, node) in &fields {
        report.add(field, node);
    }
    for part in statics(model) {
        report.add(part.path, &part.node);
        size += part.size;
    }
    let numbers: usize = report.arrays.iter().map(|array| array.bytes).sum();
    report.tables = size.saturating_sub(numbers);
    report
}

impl fmt::Display for MemoryReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{:>9}  {:>7}  array", "bytes", "numbers")?;
        for ArraySize { path, count, bytes } in &self.arrays {
            writeln!(f, "{bytes:>9}  {count:>7}  {path}")?;
        }
        writeln!(f, "{:>9}  {:>7}  texts", self.texts, "")?;
        writeln!(f, "{:>9}  {:>7}  references and padding", self.tables, "")?;
        write!(f, "{:>9}  {:>7}  total", self.total(), "")
    }
}
