//! What the services and companions of a run are started with, for its recording: each binary is asked for the values
//! that it uses, so that defaults are there, too.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use toml::Value;
use zeronav_console::artifacts;
use zeronav_files::Folder;
use zeronav_supervise::question;

/// The file in the run's folder.
const FILE: &str = "parameters.json";

/// Longest value that is written whole: not that of a world. [characters]
const VALUE_CHARS_MAX: usize = 2000;

/// A program and the configuration that it is started with.
#[derive(Debug)]
pub(crate) struct Asked<'a> {
    /// Its seat, or its name.
    pub name: String,
    pub binary: &'a Path,
    pub config: PathBuf,
}

/// Writes `parameters.json` into `folder`: for each of these programs its values by their path. One that says nothing
/// usable is left out, aloud.
///
/// # Errors
/// One line when the file cannot be written.
pub(crate) fn write(folder: &Folder, asked: &[Asked<'_>]) -> Result<PathBuf, String> {
    let mut all: BTreeMap<&str, BTreeMap<String, String>> = BTreeMap::new();
    let answers: Vec<_> = std::thread::scope(|scope| {
        let threads: Vec<_> = asked
            .iter()
            .map(|asked| std::thread::Builder::new().spawn_scoped(scope, || values(asked)))
            .collect();
        let answers = threads.into_iter().zip(asked);
        answers
            .map(
                |(thread, asked)| match thread.map(std::thread::ScopedJoinHandle::join) {
                    Ok(Ok(answer)) => answer,
                    // Without room for a thread.
                    Ok(Err(_)) | Err(_) => values(asked),
                },
            )
            .collect()
    });
    for (answer, asked) in answers.into_iter().zip(asked) {
        match answer {
            Ok(values) => {
                all.insert(&asked.name, values);
            }
            Err(why) => {
                tracing::warn!(of = asked.name, why, "no parameters in the recording");
            }
        }
    }
    let text = serde_json::to_string_pretty(&all).map_err(|error| error.to_string())?;
    artifacts::write_in(folder, FILE, &text)?;
    Ok(folder.path().join(FILE))
}

fn values(asked: &Asked<'_>) -> Result<BTreeMap<String, String>, String> {
    let arguments: [&OsStr; 3] = [
        "--print-config".as_ref(),
        "--config".as_ref(),
        asked.config.as_os_str(),
    ];
    let printed = question::ask(asked.binary, &arguments).map_err(|silence| silence.to_string())?;
    let table: toml::Table =
        toml::from_str(&printed).map_err(|error| error.message().to_owned())?;
    let mut values = BTreeMap::new();
    flatten("", Value::Table(table), &mut values);
    Ok(values)
}

/// The values in a table by their path, with dots between the keys.
fn flatten(path: &str, value: Value, to: &mut BTreeMap<String, String>) {
    match value {
        Value::Table(table) => {
            for (key, value) in table {
                let dot = if path.is_empty() { "" } else { "." };
                flatten(&format!("{path}{dot}{key}"), value, to);
            }
        }
        value => {
            let text = value.to_string();
            let n = text.chars().count();
            let text = if n > VALUE_CHARS_MAX {
                format!("({n} characters, see the scenario)")
            } else {
                text
            };
            to.insert(path.to_owned(), text);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_named_by_their_path() {
        let table: toml::Table =
            toml::from_str("a = 1.5\nlist = [1, 2]\n[b.c]\nd = \"text\"\ne = true\n").unwrap();
        let mut values = BTreeMap::new();
        flatten("", Value::Table(table), &mut values);
        let found: Vec<(&str, &str)> = values.iter().map(|(k, v)| (&**k, &**v)).collect();
        let expected = [
            ("a", "1.5"),
            ("b.c.d", "\"text\""),
            ("b.c.e", "true"),
            ("list", "[1, 2]"),
        ];
        assert_eq!(found, expected);
        let long = Value::Array(vec![Value::Integer(1); 5000]);
        flatten("world", long, &mut values);
        assert_eq!(values["world"], "(15000 characters, see the scenario)");
    }

    #[test]
    fn a_program_that_answers_nothing_usable_is_left_out() {
        let place = tempfile::tempdir().unwrap();
        let folder = Folder::open(place.path()).unwrap();
        let asked = |name: &str, binary| Asked {
            name: name.to_owned(),
            binary: Path::new(binary),
            config: "a".into(),
        };
        let all = [
            asked("echo", "/bin/echo"),
            asked("true", "/bin/true"),
            asked("none", "/nowhere"),
        ];
        let file = write(&folder, &all).unwrap();
        let text = std::fs::read_to_string(file).unwrap();
        let read: BTreeMap<String, BTreeMap<String, String>> = serde_json::from_str(&text).unwrap();
        // An empty table; what echo prints is no TOML.
        assert_eq!(read, [("true".to_owned(), BTreeMap::new())].into());
    }
}
