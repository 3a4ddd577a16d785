//! The result of a run that launch could not end, with what is known of the end.

use std::fs::File;
use std::io::{Read, Seek};
use std::path::Path;
use zeronav_files::{Folder, Replace};
use zeronav_shell::damage::Damaged;

/// Name of a run's result in its folder.
pub const FILE: &str = "result.json";

/// Outcome of a run whose shared memory was damaged.
const MEMORY_DAMAGED: &str = "memory_damaged";

/// Largest result. [bytes]
const BYTES_MAX: u64 = 1 << 20;

/// Puts `result`, a JSON object, into the `folder` of its run, unless launch has written one. `damaged`:
/// segments, and the processes that may have damaged each.
pub(super) fn write(folder: &Path, mut result: File, damaged: &[(Damaged, Vec<String>)]) {
    let mut text = String::new();
    let read = result
        .rewind()
        .and_then(|()| result.take(BYTES_MAX).read_to_string(&mut text));
    let Ok(serde_json::Value::Object(mut result)) = serde_json::from_str(&text) else {
        return;
    };
    if read.is_err() {
        return;
    }
    if let Some(why) = in_words(damaged) {
        result.insert("outcome".to_owned(), MEMORY_DAMAGED.into());
        result.insert("reason".to_owned(), why.into());
    }
    let Ok(text) = serde_json::to_string_pretty(&result) else {
        return;
    };
    let _ = Folder::open(folder)
        .and_then(|folder| folder.write(FILE, (text + "\n").as_bytes(), Replace::No));
}

/// Whose shared memory is damaged; `None` when none is.
fn in_words(damaged: &[(Damaged, Vec<String>)]) -> Option<String> {
    let (first, _) = damaged.first()?;
    let mut authors: Vec<&str> = damaged
        .iter()
        .flat_map(|(_, authors)| authors.iter().map(String::as_str))
        .collect();
    authors.sort_unstable();
    authors.dedup();
    let more = match damaged.len() - 1 {
        0 => String::new(),
        n => format!(" and {n} more"),
    };
    Some(format!(
        "shared memory of {} was cut off or overwritten: {}{more} in /dev/shm",
        if authors.is_empty() {
            "the stack".to_owned()
        } else {
            authors.join(", ")
        },
        first.name
    ))
}
