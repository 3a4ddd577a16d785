//! Companions: processes beside the stack that a scenario asks for, and on which nothing in it waits.

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::PathBuf;
use zeronav_msgs::Role;
use zeronav_world::error::SpecError;

/// Most companions of a run, so that the topics keep places for readers of their own.
pub const COMPANIONS_MAX: usize = 8;

/// Most restarts of a companion.
pub const RESTARTS_MAX: u32 = 100;

/// Restarts of a companion unless said otherwise.
pub const RESTARTS: u32 = 3;

/// Name of the companion that is the live page; launch starts it itself.
pub const VIEWER: &str = "viewer";

/// Name of the companion that records the run (`--record`); launch starts it itself.
pub const RECORDER: &str = "recorder";

/// Longest name. [characters]
const NAME_CHARS_MAX: usize = 32;

/// A process beside the stack.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CompanionSpec {
    /// Name or path of the binary. A path that leads to a file from the folder of the scenario is absolute,
    /// any other is as it was written.
    pub binary: PathBuf,
    /// What it finds in its configuration file.
    #[serde(default)]
    pub config: toml::Table,
    /// How often it is started again when it ends with failure, 0 to [`RESTARTS_MAX`].
    #[serde(default = "restarts")]
    pub restarts: u32,
}

const fn restarts() -> u32 {
    RESTARTS
}

/// Everything that is wrong with the companions of a scenario, by field.
pub(super) fn check(companions: &BTreeMap<String, CompanionSpec>) -> Vec<SpecError> {
    let mut wrong = Vec::new();
    if companions.len() > COMPANIONS_MAX {
        let why = format!("{} companions, at most {COMPANIONS_MAX}", companions.len());
        wrong.push(SpecError::new("companions", why));
    }
    for (name, companion) in companions {
        let field = format!("companions.{name}");
        wrong.extend(refusal(name).map(|why| SpecError::new(field.clone(), why)));
        if companion.restarts > RESTARTS_MAX {
            let why = format!("must be 0 to {RESTARTS_MAX}, not {}", companion.restarts);
            wrong.push(SpecError::new(format!("{field}.restarts"), why));
        }
    }
    wrong
}

/// Why a companion cannot have this name: logs, configurations and tables name it beside the seats.
pub(super) fn refusal(name: &str) -> Option<String> {
    let is_word = name.starts_with(|first: char| first.is_ascii_lowercase())
        && name.len() <= NAME_CHARS_MAX
        && name
            .bytes()
            .all(|byte| byte.is_ascii_lowercase() || byte.is_ascii_digit() || byte == b'_');
    if !is_word {
        return Some(format!(
            "a name is a letter a to z and up to {} more of a to z, 0 to 9 and _",
            NAME_CHARS_MAX - 1
        ));
    }
    let of_launch = [VIEWER, RECORDER].contains(&name) || Role::from_label(name).is_some();
    of_launch.then(|| format!("`{name}` is the name of a part of the stack: choose another one"))
}

/// The JSON schema of `[companions]`.
pub(super) fn schema() -> Value {
    json!({
        "type": "object",
        "maxProperties": COMPANIONS_MAX,
        "propertyNames": { "pattern": format!("^[a-z][a-z0-9_]{{0,{}}}$", NAME_CHARS_MAX - 1) },
        "additionalProperties": {
            "type": "object",
            "additionalProperties": false,
            "properties": {
                "binary": { "type": "string" },
                "config": { "type": "object" },
                "restarts": {
                    "type": "integer", "minimum": 0, "maximum": RESTARTS_MAX, "default": RESTARTS,
                },
            },
            "required": ["binary"],
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn companions(names: &[&str], restarts: u32) -> BTreeMap<String, CompanionSpec> {
        let spec = CompanionSpec {
            binary: "b".into(),
            config: toml::Table::new(),
            restarts,
        };
        let named = |name: &&str| ((*name).to_owned(), spec.clone());
        names.iter().map(named).collect()
    }

    #[test]
    fn names_are_words_that_nothing_else_in_the_stack_has() {
        assert_eq!(check(&companions(&["nearest", "a_1"], RESTARTS_MAX)), []);
        let long = "a".repeat(NAME_CHARS_MAX + 1);
        for bad in [
            "", "Nearest", "1a", "a-b", "a.b", "mapping", "launch", "tap", VIEWER, RECORDER, &long,
        ] {
            let wrong = check(&companions(&[bad], 0));
            assert_eq!(wrong.len(), 1, "{bad:?}");
            assert_eq!(wrong[0].field, format!("companions.{bad}"));
        }
    }

    #[test]
    fn number_and_restarts_have_ceilings() {
        let names: Vec<String> = (0..=COMPANIONS_MAX).map(|n| format!("a{n}")).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        assert_eq!(check(&companions(&names[1..], 0)), []);
        let wrong = check(&companions(&names, 0));
        assert_eq!(wrong[0].field, "companions");
        let wrong = check(&companions(&["a"], RESTARTS_MAX + 1));
        assert_eq!(wrong[0].field, "companions.a.restarts");
    }
}
