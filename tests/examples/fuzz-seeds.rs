//! Writes the seeds of the fuzz targets and their dictionaries:
//!
//! ```sh
//! cargo run -p nsrm-tests --example fuzz-seeds -- target/fuzz/seeds tests/fuzz/dictionaries
//! ```

use std::path::Path;
use std::{env, fs, io};

use nsrm_tests::fuzz::{TARGETS, seeds};

fn main() -> io::Result<()> {
    let mut folders = env::args().skip(1);
    let (Some(inputs), Some(dictionaries)) = (folders.next(), folders.next()) else {
        return Err(io::Error::other(
            "a folder for the seeds and one for the dictionaries, please",
        ));
    };
    fs::create_dir_all(&dictionaries)?;
    for target in TARGETS {
        let folder = Path::new(&inputs).join(target.name);
        fs::create_dir_all(&folder)?;
        for (number, seed) in seeds::of(target.name).iter().enumerate() {
            fs::write(folder.join(format!("seed-{number:02}")), seed)?;
        }
        let words = seeds::dictionary(target.name);
        if !words.is_empty() {
            let lines: String = words.iter().map(|word| line(word)).collect();
            let file = Path::new(&dictionaries).join(format!("{}.dict", target.name));
            fs::write(file, lines)?;
        }
    }
    Ok(())
}

/// A word as libFuzzer reads it.
fn line(word: &str) -> String {
    let escaped = word.replace('\\', "\\\\").replace('"', "\\\"");
    format!("\"{escaped}\"\n")
}
