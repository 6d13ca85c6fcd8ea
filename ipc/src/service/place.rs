use std::fs::File;
use std::io::{self, Write as _};

use iceoryx2::config::Config;
use iceoryx2::prelude::{FilePath, SemanticString};

/// Makes a place other than iceoryx2's usual one this process's own, if it has none yet.
///
/// What a node has left that was killed before it had written down where it lives, iceoryx2
/// 0.10 looks for at the place that is global to who looks: without this, such files stay
/// for ever. The global place can be set by a file alone, which is removed again.
pub fn settle(config: &Config) -> io::Result<()> {
    let (root, prefix) = (config.global.root_path(), config.global.prefix);
    let text = format!(
        "[global]\nroot-path = {:?}\nprefix = {:?}\n",
        root.to_string(),
        prefix.to_string()
    );
    let path = std::env::temp_dir().join(format!("nsrm-place-{}.toml", std::process::id()));
    let mut file = File::options().write(true).create_new(true).open(&path)?;
    let set = file.write_all(text.as_bytes()).and_then(|()| {
        let path = path.as_os_str().as_encoded_bytes();
        let path = FilePath::new(path).map_err(|error| io::Error::other(format!("{error:?}")))?;
        Config::setup_global_config_from_file(&path)
            .map_err(|error| io::Error::other(format!("{error:?}")))
    });
    std::fs::remove_file(&path)?;
    set.map(|_| ())
}
