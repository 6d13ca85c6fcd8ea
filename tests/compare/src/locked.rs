use serde::Deserialize;

const LOCK: &str = include_str!("../Cargo.lock");

#[derive(Deserialize)]
struct Lock {
    package: Vec<Package>,
}

#[derive(Deserialize)]
struct Package {
    name: String,
    version: String,
}

/// The version of a package that this program was built with.
pub fn locked_version(package: &str) -> String {
    let lock: Option<Lock> = toml::from_str(LOCK).ok();
    let packages = lock.into_iter().flat_map(|lock| lock.package);
    let mut found = packages.filter(|found| found.name == package);
    found
        .next()
        .map_or_else(|| "?".to_owned(), |found| found.version)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lock_file_has_the_versions() {
        assert_eq!(locked_version("nsrm-compare"), env!("CARGO_PKG_VERSION"));
        assert_eq!(locked_version("unheard-of"), "?");
    }
}
