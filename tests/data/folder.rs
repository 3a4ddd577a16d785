//! Where tests find their data. Included by the test programs that need it, because no crate that
//! they share may read files.

#![allow(
    dead_code,
    unreachable_pub,
    reason = "each test program needs a part, and one is a library"
)]

use std::path::{Path, PathBuf};

/// The folder `part` of the data that is shipped with the project.
///
/// # Panics
/// When it is missing.
#[must_use]
pub fn shipped_data(part: &str) -> PathBuf {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut roots = own.ancestors().map(|root| root.join("tests/data"));
    let found = roots.find(|folder| folder.join("README.md").is_file());
    let folder = found.unwrap_or_default().join(part);
    assert!(
        folder.is_dir(),
        "tests/data/{part} is missing: check it out again"
    );
    folder
}

/// The folder `part` of the data sets of others, which only ignored tests ask for.
///
/// # Panics
/// When the environment does not name it, or it is not there: a test that was asked for does not
/// pass by being absent.
#[must_use]
pub fn external_data(part: &str) -> PathBuf {
    let root = std::env::var_os("ZERONAV_DATA").filter(|root| !root.is_empty());
    let root =
        root.expect("ZERONAV_DATA names the folder with the data sets, see tests/data/README.md");
    let folder = PathBuf::from(root).join(part);
    assert!(
        folder.is_dir(),
        "{} is missing, see tests/data/README.md",
        folder.display()
    );
    // Tests run in the folders of their crates, scenarios in others.
    std::path::absolute(&folder).unwrap_or(folder)
}

/// The files of a folder with this ending, by name; an index is none of them.
///
/// # Panics
/// When there are none.
#[must_use]
pub fn files(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let entries =
        std::fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut files: Vec<PathBuf> = entries
        .map(|entry| entry.expect("an entry of a folder").path())
        .filter(|file| file.extension().is_some_and(|own| own == ending))
        .filter(|file| file.file_stem().is_some_and(|stem| stem != "index"))
        .collect();
    files.sort();
    assert!(!files.is_empty(), "no *.{ending} in {}", folder.display());
    files
}
