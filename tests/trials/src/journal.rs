//! The journal: events of all processes in one file, one line of JSON each.
//!
//! A line is written by one call to a file opened for appending: a killed process has written it or
//! not, and lines of several processes don't mix. It also is the simulated world: a block is where
//! the last line about it says.

use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use nsrm_ipc::clock::now_ns;
use serde_json::{Value, json};

/// Writes as one process.
#[derive(Debug)]
pub(crate) struct Journal {
    path: PathBuf,
    file: File,
    who: &'static str,
}

impl Journal {
    /// Opens a file for appending, or creates it.
    pub(crate) fn open(path: &Path, who: &'static str) -> Result<Self> {
        let file = File::options().append(true).create(true).open(path);
        Ok(Self {
            path: path.to_owned(),
            file: file.with_context(|| path.display().to_string())?,
            who,
        })
    }

    /// The same file, for another writer.
    pub(crate) fn also(&self, who: &'static str) -> Result<Self> {
        Self::open(&self.path, who)
    }

    /// Writes a line; `more` is an object.
    pub(crate) fn write(&self, what: &str, more: Value) -> Result<()> {
        let mut line = json!({
            "t": now_ns(),
            "who": self.who,
            "pid": std::process::id(),
            "what": what,
        });
        if let (Value::Object(line), Value::Object(more)) = (&mut line, more) {
            line.extend(more);
        }
        let line = format!("{line}\n");
        (&self.file)
            .write_all(line.as_bytes())
            .with_context(|| self.path.display().to_string())
    }
}

/// Reads moves as they are written.
#[derive(Debug)]
pub(crate) struct Moves {
    reader: BufReader<File>,
    /// An incomplete line.
    begun: String,
}

impl Moves {
    /// Reads from the start.
    pub(crate) fn of(path: &Path) -> Result<Self> {
        let file = File::open(path).with_context(|| path.display().to_string())?;
        Ok(Self {
            reader: BufReader::new(file),
            begun: String::new(),
        })
    }

    /// The next block that was moved, and its new location in the image.
    pub(crate) fn next(&mut self) -> Result<Option<(u32, [f32; 5])>> {
        while self.reader.read_line(&mut self.begun)? > 0 && self.begun.ends_with('\n') {
            let line: Value = serde_json::from_str(&self.begun).context("the journal")?;
            self.begun.clear();
            if line["what"] == "moved" {
                let location = serde_json::from_value(line["location"].clone())?;
                let object = line["object"].as_u64().unwrap_or_default();
                return Ok(Some((u32::try_from(object)?, location)));
            }
        }
        Ok(None)
    }
}
