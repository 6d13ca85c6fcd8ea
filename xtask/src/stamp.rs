//! Stamps: files with the hash of a step's inputs, written only when the step has succeeded.

use std::fs;
use std::hash::{DefaultHasher, Hasher};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

/// Hash of inputs, valid in this checkout only. If another toolchain hashes differently, the
/// step runs once more.
#[derive(Default)]
pub(crate) struct Inputs(DefaultHasher);

impl Inputs {
    /// Adds a text.
    pub(crate) fn text(&mut self, text: &str) -> &mut Self {
        self.0.write_usize(text.len());
        self.0.write(text.as_bytes());
        self
    }

    /// Adds the content of a file, or of all files below a folder in the order of
    /// their names, with their paths.
    pub(crate) fn path(&mut self, path: &Path) -> Result<&mut Self> {
        if path.is_dir() {
            let mut entries = fs::read_dir(path)
                .with_context(|| format!("reading {}", path.display()))?
                .map(|entry| Ok(entry?.path()))
                .collect::<Result<Vec<PathBuf>>>()?;
            entries.sort();
            for entry in entries {
                if entry.file_name().is_none_or(|name| !is_made(name)) {
                    self.path(&entry)?;
                }
            }
        } else {
            let content = fs::read(path).with_context(|| format!("reading {}", path.display()))?;
            self.text(&path.to_string_lossy());
            self.0.write_usize(content.len());
            self.0.write(&content);
        }
        Ok(self)
    }

    /// The hash as hexadecimal digits.
    pub(crate) fn finish(&self) -> String {
        format!("{:016x}", self.0.finish())
    }
}

/// Whether a file is made by tools.
fn is_made(name: &std::ffi::OsStr) -> bool {
    matches!(
        name.to_str(),
        Some("target" | "__pycache__" | ".pytest_cache" | ".ruff_cache")
    )
}

/// A file that records the inputs of the last successful run of a step.
pub(crate) struct Stamp(PathBuf);

impl Stamp {
    /// The stamp at this path, written or not.
    pub(crate) fn at(path: PathBuf) -> Self {
        Self(path)
    }

    /// Whether the step has succeeded with these inputs.
    pub(crate) fn holds(&self, inputs: &str) -> bool {
        fs::read_to_string(&self.0).is_ok_and(|written| written == inputs)
    }

    /// Removes the stamp, before the step starts.
    pub(crate) fn clear(&self) -> Result<()> {
        match fs::remove_file(&self.0) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                Err(error).with_context(|| format!("removing {}", self.0.display()))
            }
            _ => Ok(()),
        }
    }

    /// Records that the step has succeeded with these inputs.
    pub(crate) fn write(&self, inputs: &str) -> Result<()> {
        fs::write(&self.0, inputs).with_context(|| format!("writing {}", self.0.display()))
    }
}

#[cfg(test)]
mod tests {
    use super::{Inputs, Stamp};

    #[test]
    fn a_change_in_any_file_changes_the_hash_and_made_files_do_not() {
        let folder = std::env::temp_dir().join(format!("xtask-stamp-{}", std::process::id()));
        std::fs::create_dir_all(folder.join("inner/__pycache__")).unwrap();
        std::fs::write(folder.join("inner/a.py"), "1").unwrap();
        let hash = || Inputs::default().path(&folder).unwrap().finish();
        let first = hash();
        std::fs::write(folder.join("inner/__pycache__/a.pyc"), "made").unwrap();
        assert_eq!(first, hash());
        std::fs::write(folder.join("inner/a.py"), "2").unwrap();
        assert_ne!(first, hash());

        let stamp = Stamp::at(folder.join("stamp"));
        assert!(!stamp.holds(&first));
        stamp.write(&first).unwrap();
        assert!(stamp.holds(&first) && !stamp.holds("other"));
        stamp.clear().unwrap();
        stamp.clear().unwrap();
        assert!(!stamp.holds(&first));
        std::fs::remove_dir_all(folder).unwrap();
    }
}
