//! Writes `include/nsrm.h` from the crate: `cargo run -p nsrm-c --example header`.

use std::error::Error;
use std::path::Path;

/// Where it belongs, in the package.
pub(crate) const FILE: &str = "include/nsrm.h";

fn main() -> Result<(), Box<dyn Error>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(FILE);
    std::fs::write(&path, header()?)?;
    println!("{}", path.display());
    Ok(())
}

/// The header's text.
pub(crate) fn header() -> Result<String, Box<dyn Error>> {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(package.join("cbindgen.toml"))?;
    let mut bytes = Vec::new();
    cbindgen::generate_with_config(package, config)?.write(&mut bytes);
    let text = String::from_utf8(bytes)?;
    let text = text
        // Constants of an enum are named after it.
        .replace("NSRM_STATUS_T_", "NSRM_")
        .replace("NSRM_REFUSAL_KIND_T_", "NSRM_REFUSAL_")
        .replace("NSRM_PROPERTY_KIND_T_", "NSRM_PROPERTY_")
        .replace("NSRM_RELATION_KIND_T_", "NSRM_RELATION_")
        // A heading of rustdoc.
        .replace(" * # Safety\n", " * Safety:\n");
    Ok(short_comments(&text))
}

/// With each comment of a single line in one line.
fn short_comments(text: &str) -> String {
    let mut short = String::new();
    let mut lines = text.lines().peekable();
    while let Some(line) = lines.next() {
        if line.trim_start() != "/**" {
            short += line;
            short.push('\n');
            continue;
        }
        let mut comment = Vec::new();
        for line in lines.by_ref() {
            if line.trim_start() == "*/" {
                break;
            }
            comment.push(line);
        }
        let indent = &line[..line.len() - "/**".len()];
        if let [only] = comment[..] {
            let said = only.trim_start().trim_start_matches("* ");
            short += &format!("{indent}/** {said} */\n");
        } else {
            short += &format!("{line}\n{}\n{indent} */\n", comment.join("\n"));
        }
    }
    short
}
