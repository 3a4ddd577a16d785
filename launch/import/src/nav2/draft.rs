//! The scenario that comes of an import, and its text.

use std::collections::BTreeMap;
use std::fmt::Write;
use toml::Value;

/// Tables in the order in which they are written; the first is the scenario itself.
const TABLES: [&str; 9] = [
    "",
    "world",
    "robot",
    "robot.lidar",
    "services.robot",
    "services.robot.config.ros",
    "services.mapping.config",
    "services.global_planner.config",
    "services.local_planner.config",
];

/// Widest line of the description. [characters]
const WIDTH: usize = 100;

/// A scenario in the making: fields by their paths, each with where its value comes from.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Draft {
    values: BTreeMap<&'static str, (Value, String)>,
    /// What is said of it in its first lines.
    pub(super) head: String,
    pub(super) title: String,
}

/// A text without what would end a comment or a line of a terminal.
pub(super) fn plain(text: &str) -> String {
    let is_plain = |it: char| {
        !it.is_control() && !matches!(it, '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    text.chars()
        .map(|it| if is_plain(it) { it } else { '?' })
        .collect()
}

impl Draft {
    /// Gives a field its value, and says where it comes from.
    pub fn set(&mut self, path: &'static str, value: impl Into<Value>, note: impl Into<String>) {
        self.values.insert(path, (value.into(), note.into()));
    }

    /// Takes a field out.
    pub(super) fn unset(&mut self, path: &str) {
        self.values.remove(path);
    }

    /// The value of a field.
    #[must_use]
    pub fn get(&self, path: &str) -> Option<&Value> {
        self.values.get(path).map(|(value, _)| value)
    }

    /// The number in a field.
    #[must_use]
    pub fn number(&self, path: &str) -> Option<f64> {
        self.get(path)?.as_float()
    }

    /// The text in a field.
    #[must_use]
    pub fn text(&self, path: &str) -> Option<&str> {
        self.get(path)?.as_str()
    }

    /// The text of the scenario's file.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut text = String::new();
        for line in wrapped(&self.head) {
            let _ = writeln!(text, "# {line}");
        }
        let _ = writeln!(text, "title = {}", Value::from(plain(&self.title)));
        for table in TABLES {
            let within = |path: &str| key_in(table, path).map(str::to_owned);
            let mut lines = Vec::new();
            for (path, (value, note)) in &self.values {
                if let Some(key) = within(path) {
                    lines.push(line(&key, value, note));
                }
            }
            if !lines.is_empty() && !table.is_empty() {
                let _ = writeln!(text, "\n[{table}]");
            }
            text.extend(lines);
        }
        text + &self.goal()
    }

    /// A goal as an example: where to is for the user to say.
    fn goal(&self) -> String {
        let mut text = "\n# No goal is in it: give one with `zeronav goal`, or here:\n# [[goals]]\n# pose = [2.0, 0.0, 0.0]\n".to_owned();
        for key in ["tolerance_m", "yaw_tolerance_rad"] {
            if let Some((value, note)) = self.values.get(format!("goals.{key}").as_str()) {
                text += "# ";
                text += &line(key, value, note);
            }
        }
        text
    }
}

/// The key of a path in the deepest of the tables that hold it; `None` when that is another one.
fn key_in<'a>(table: &str, path: &'a str) -> Option<&'a str> {
    let below = |table: &str| {
        if table.is_empty() {
            return Some(path);
        }
        path.strip_prefix(table)?.strip_prefix('.')
    };
    let deeper = |other: &&str| other.len() > table.len() && below(other).is_some();
    let key = below(table)?;
    let is_goal = path.starts_with("goals.");
    (!is_goal && !TABLES.iter().any(deeper)).then_some(key)
}

fn line(key: &str, value: &Value, note: &str) -> String {
    let note = plain(note);
    let note = if note.is_empty() {
        note
    } else {
        format!("  # {note}")
    };
    format!("{key} = {value}{note}\n")
}

/// The lines of a text. A word that is longer has a line of its own.
fn wrapped(text: &str) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in plain(text).split_whitespace() {
        let last = lines.last_mut().map_or(0, |line| line.chars().count());
        match lines.last_mut() {
            Some(line) if last == 0 => line.push_str(word),
            Some(line) if last + 1 + word.chars().count() <= WIDTH => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_come_back_from_the_text_whatever_the_names_in_the_file_were() {
        let mut draft = Draft {
            head: "made of a\nfile \"x\"".to_owned(),
            title: "a \"robot\"\nof mine".to_owned(),
            ..Draft::default()
        };
        draft.set("robot.v_mps_max", 0.5, "FollowPath\n[world]\nx = 1");
        draft.set("robot.lidar.rate_hz", 10.0, "");
        draft.set(
            "services.local_planner.config.dwa.speeds",
            20_i64,
            "vx_samples",
        );
        draft.set("services.robot.binary", "zeronav-ros2", "");
        draft.set("static_map", false, "");
        draft.set(
            "goals.tolerance_m",
            0.25,
            "xy_goal_tolerance\nrobot.v_mps_max = 9.0",
        );
        let table: toml::Table = draft.to_toml().parse().expect("TOML");
        assert_eq!(table["robot"]["v_mps_max"].as_float(), Some(0.5));
        assert_eq!(table["robot"]["lidar"]["rate_hz"].as_float(), Some(10.0));
        let dwa = &table["services"]["local_planner"]["config"]["dwa"];
        assert_eq!(dwa["speeds"].as_integer(), Some(20));
        assert_eq!(
            table["services"]["robot"]["binary"].as_str(),
            Some("zeronav-ros2")
        );
        assert_eq!(table["title"].as_str(), Some("a \"robot\"?of mine"));
        assert!(table.get("goals").is_none() && table.get("world").is_none());
        assert_eq!(table["static_map"].as_bool(), Some(false));
    }

    #[test]
    fn every_table_but_the_first_is_within_no_earlier_deeper_one() {
        for (index, table) in TABLES.iter().enumerate() {
            let earlier = &TABLES[..index];
            assert!(
                !earlier
                    .iter()
                    .any(|it| it.starts_with(&format!("{table}.")) && !table.is_empty())
            );
        }
    }
}
