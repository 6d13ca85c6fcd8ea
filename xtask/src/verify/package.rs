//! The published crates.

use std::fs;
use std::path::PathBuf;

use anyhow::{Context as _, Result};

use super::context::Context;
use super::step::Step;

/// Their manifests have `rust-version` and everything else that users see.
const PUBLISHED: [&str; 7] = [
    "nsrm-vectors",
    "nsrm-core",
    "nsrm-tabletop",
    "nsrm-c",
    "nsrm-codegen",
    "nsrm-ipc",
    "nsrm",
];

/// Packages each crate and builds it from its package, as if those that it depends on were published.
pub(super) fn steps(context: &Context) -> Result<Vec<Step>> {
    // A published version never changes. So cargo would take what it unpacked and built in the
    // last run of this check, for packages of the same version.
    forget_unpacked()?;
    let mut steps = Vec::new();
    if context.project().target().join("package").exists() {
        steps.push(of_each(Step::cargo(&["clean", "--quiet"])));
    }
    let package = of_each(Step::cargo(&["package", "--locked", "--allow-dirty"]));
    steps.push(package.with_workspace_profile());
    Ok(steps)
}

fn of_each(step: Step) -> Step {
    let packages = PUBLISHED.map(|package| format!("--package={package}"));
    packages.into_iter().fold(step, Step::argument)
}

/// Removes the sources of our packages from cargo's cache. None of them comes from a registry.
fn forget_unpacked() -> Result<()> {
    let home = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    let home = home.or_else(|| Some(std::env::home_dir()?.join(".cargo")));
    let Some(Ok(registries)) = home.map(|home| fs::read_dir(home.join("registry/src"))) else {
        return Ok(());
    };
    for registry in registries {
        for folder in fs::read_dir(registry?.path())? {
            let folder = folder?;
            if folder.file_name().to_str().is_some_and(is_ours) {
                let path = folder.path();
                fs::remove_dir_all(&path)
                    .with_context(|| format!("removing {}", path.display()))?;
            }
        }
    }
    Ok(())
}

/// Whether a folder has one of our packages: a name and a version.
fn is_ours(folder: &str) -> bool {
    PUBLISHED.iter().any(|package| {
        let version = folder.strip_prefix(package);
        let version = version.and_then(|rest| rest.strip_prefix('-'));
        version.is_some_and(|version| version.starts_with(|first: char| first.is_ascii_digit()))
    })
}

#[cfg(test)]
mod tests {
    use super::is_ours;

    #[test]
    fn only_our_packages_are_forgotten() {
        for (folder, expected) in [
            ("nsrm-core-0.1.0", true),
            ("nsrm-0.1.0", true),
            ("nsrm-core-extra-0.1.0", false),
            ("nsrmx-0.1.0", false),
            ("libm-0.2.16", false),
        ] {
            assert_eq!(is_ours(folder), expected, "{folder}");
        }
    }
}
