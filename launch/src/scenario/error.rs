//! What is wrong with a scenario, in one line that says where.

use std::path::PathBuf;

/// Why a scenario cannot be read or cannot work.
#[derive(Debug, thiserror::Error)]
pub enum ScenarioError {
    /// There is none of this name.
    #[error("there is no scenario `{name}`{}; `zeronav list` names all", guess(closest.as_deref()))]
    Unknown {
        /// What was asked for.
        name: String,
        /// The known name that looks most like it.
        closest: Option<String>,
    },
    /// A file cannot be opened or read.
    #[error("scenario {}: {source}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The text is not TOML.
    #[error("scenario {file}:{line}: not valid TOML: {why}")]
    Syntax {
        /// The file as the user knows it.
        file: String,
        /// Line, from 1.
        line: usize,
        /// What the parser says.
        why: String,
    },
    /// A value is missing, unknown, of the wrong type, or cannot be.
    #[error("scenario {file}:{line}: {field}: {why}")]
    Field {
        /// The file as the user knows it: the scenario's or one that it builds on.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Path of the value, such as `world.shapes[3].size_m`.
        field: String,
        /// What is wrong and what would be right.
        why: String,
    },
}

fn guess(closest: Option<&str>) -> String {
    closest.map_or_else(String::new, |name| format!(", did you mean `{name}`?"))
}

/// The candidate that takes the fewest edits to become `name`, when these are few enough to be a
/// slip of the pen.
pub(super) fn closest<'a>(name: &str, candidates: &'a [String]) -> Option<&'a str> {
    candidates
        .iter()
        .map(|candidate| (edits(name, candidate), candidate.as_str()))
        .min()
        .filter(|(n, candidate)| {
            let half = candidate.chars().count().div_ceil(2);
            *n <= half || candidate.contains(name) && name.len() > 2
        })
        .map(|(_, candidate)| candidate)
}

/// Levenshtein's distance: insertions, deletions and replacements from one word to the other.
fn edits(from: &str, to: &str) -> usize {
    let to: Vec<char> = to.chars().collect();
    let mut row: Vec<usize> = (0..=to.len()).collect();
    for (i, a) in from.chars().enumerate() {
        let mut diagonal = i;
        row[0] = i + 1;
        for (j, b) in to.iter().enumerate() {
            let replaced = diagonal + usize::from(a != *b);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[to.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edits_are_counted() {
        assert_eq!(edits("kitten", "sitting"), 3);
        assert_eq!(edits("", "abc"), 3);
        assert_eq!(edits("same", "same"), 0);
    }

    #[test]
    fn slips_are_understood_and_other_words_are_not() {
        let known = ["blocked_aisle", "open_aisle", "sealed"].map(str::to_owned);
        assert_eq!(closest("blocked_ailse", &known), Some("blocked_aisle"));
        assert_eq!(closest("seald", &known), Some("sealed"));
        assert_eq!(closest("quicksort", &known), None);
        assert_eq!(closest("x", &[]), None);
    }
}
