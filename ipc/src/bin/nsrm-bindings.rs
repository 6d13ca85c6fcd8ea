//! Generates the messages' layout table, C header and Python module from the structs.

use std::path::Path;

use nsrm_ipc::bindings;

fn main() -> std::io::Result<()> {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    for (file, text) in bindings::files() {
        let path = package.join(file);
        std::fs::write(&path, text)?;
        println!("{}", path.display());
    }
    Ok(())
}
