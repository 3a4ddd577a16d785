//! The data in `tests/data` is what its command makes, and small.

#[path = "../../examples/test_data/files.rs"]
mod files;

use super::data;
use std::collections::BTreeSet;
use std::path::Path;

/// Everything shipped is at most this large. [bytes]
const BYTES_MAX: usize = 300_000;

#[test]
fn the_shipped_data_is_drawn_again_bit_for_bit() {
    let folder = data::shipped_data("");
    let made = files::all().unwrap();
    let sum: usize = made.values().map(Vec::len).sum();
    assert!(sum <= BYTES_MAX, "{sum} bytes");
    for (name, bytes) in &made {
        let shipped =
            std::fs::read(folder.join(name)).unwrap_or_else(|why| panic!("{name}: {why}"));
        assert!(
            shipped == *bytes,
            "{name} differs: run the command of tests/data/README.md"
        );
    }
    let by_hand = ["README.md", "folder.rs"].map(str::to_owned);
    let names: BTreeSet<String> = made.into_keys().chain(by_hand).collect();
    let mut listed = listed(&folder, "");
    // Made by a command of their own; the system tests read them.
    listed.retain(|name| !name.starts_with("recordings/"));
    assert_eq!(listed, names);
}

/// The paths of all files below a folder.
fn listed(folder: &Path, prefix: &str) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let entry = entry.unwrap();
        let name = format!("{prefix}{}", entry.file_name().to_str().unwrap());
        if entry.path().is_dir() {
            names.extend(listed(&entry.path(), &format!("{name}/")));
        } else {
            names.insert(name);
        }
    }
    names
}
