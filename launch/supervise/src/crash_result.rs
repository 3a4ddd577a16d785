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

/// What launch read when it could not read memory any more.
#[derive(Debug)]
pub(super) struct Unread {
    pub topic: String,
    /// The services that may have written the topic.
    pub authors: Vec<String>,
}

/// Puts `result`, a JSON object, into the `folder` of its run, unless launch has written one. `damaged`:
/// segments, and the processes that may have damaged each.
pub(super) fn write(
    folder: &Path,
    mut result: File,
    damaged: &[(Damaged, Vec<String>)],
    unread: Option<&Unread>,
) {
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
    if let Some(why) = in_words(damaged).or_else(|| unread.map(Unread::in_words)) {
        result.insert("outcome".to_owned(), MEMORY_DAMAGED.into());
        result.insert("reason".to_owned(), why.into());
    }
    let Ok(text) = serde_json::to_string_pretty(&result) else {
        return;
    };
    let _ = Folder::open(folder)
        .and_then(|folder| folder.write(FILE, (text + "\n").as_bytes(), Replace::No));
}

impl Unread {
    /// A segment that begins as it should may be overwritten behind that.
    fn in_words(&self) -> String {
        let Self { topic, authors } = self;
        let whose = match &authors[..] {
            [] => "the stack".to_owned(),
            [author] => author.clone(),
            several => format!("one of {}", several.join(", ")),
        };
        format!(
            "shared memory of {whose} was cut off or overwritten: launch crashed while it read {topic}"
        )
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_authors_of_what_could_not_be_read_are_named() {
        let said = |authors: &[&str]| {
            let unread = Unread {
                topic: "it".to_owned(),
                authors: authors.iter().map(|author| (*author).to_owned()).collect(),
            };
            unread.in_words()
        };
        let end = "was cut off or overwritten: launch crashed while it read it";
        for (authors, whose) in [
            (&[][..], "the stack"),
            (&["mapping (pid 7)"], "mapping (pid 7)"),
            (&["a (pid 1)", "b (pid 2)"], "one of a (pid 1), b (pid 2)"),
        ] {
            assert_eq!(said(authors), format!("shared memory of {whose} {end}"));
        }
    }
}
