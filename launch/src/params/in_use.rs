//! The values that a running stack uses: what the process in a seat was started with.
//!
//! Its binary is asked with `--print-config` and the configuration file that stands on its command
//! line, so that defaults are shown, too.

use crate::remote::cli::StackArgs;
use crate::running;
use std::ffi::{OsStr, OsString};
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use zeronav_console::exit::EXIT_PASS;
use zeronav_console::terminal::{say, say_json, usage};
use zeronav_msgs::role::Role;
use zeronav_supervise::question;

/// Prints the value at the path `key`, or all values of the process in the seat `role`.
pub(super) fn show(role: Role, key: Option<&str>, stack: &StackArgs) -> ExitCode {
    let printed = match printed(role, stack.domain.as_deref()) {
        Ok(printed) => printed,
        Err(problem) => return usage(&problem),
    };
    let values: toml::Table = match toml::from_str(&printed) {
        Ok(values) => values,
        Err(error) => {
            return usage(&format!(
                "{role} prints no configuration: {}",
                error.message()
            ));
        }
    };
    let Some(key) = key else {
        if stack.json {
            say_json(&values);
        } else {
            say(&printed);
        }
        return ExitCode::from(EXIT_PASS);
    };
    match at(&values, key) {
        Some(value) if stack.json => say_json(value),
        Some(value) => say(&format!("{}\n", value.to_string().trim_end())),
        None => {
            return usage(&format!(
                "{role} uses no parameter `{key}`; `zeronav params {role} --running` shows all"
            ));
        }
    }
    ExitCode::from(EXIT_PASS)
}

/// The value at a path of keys with dots between them.
fn at<'a>(values: &'a toml::Table, path: &str) -> Option<&'a toml::Value> {
    let mut keys = path.split('.');
    let mut value = values.get(keys.next()?)?;
    for key in keys {
        value = value.get(key)?;
    }
    Some(value)
}

/// The configuration of the process in the seat, as its binary prints it.
///
/// # Errors
/// One line when no stack runs, when the seat is empty, or about its binary.
fn printed(role: Role, domain: Option<&Path>) -> Result<String, String> {
    let report = running::find(domain)?.report()?;
    let of_seat = |service: &&crate::control::request::ServiceReport| service.role == role.label();
    let pid = report.services.iter().find(of_seat).map(|it| it.pid);
    let pid = pid.ok_or_else(|| format!("no process is in the seat of {role}"))?;
    let line = std::fs::read(format!("/proc/{pid}/cmdline"))
        .map_err(|error| format!("the command line of {role} (pid {pid}): {error}"))?;
    let question = Question::of(&line).ok_or_else(|| {
        format!("{role} (pid {pid}) was started without --config: it uses its defaults")
    })?;
    let binary = question.binary(pid);
    let arguments: Vec<&OsStr> = question.arguments.iter().map(OsString::as_os_str).collect();
    question::ask(&binary, &arguments).map_err(|silence| format!("{}: {silence}", binary.display()))
}

/// How a process is asked what it was started with.
#[derive(Debug, PartialEq, Eq)]
struct Question {
    /// Its program, as it was called.
    program: PathBuf,
    /// What an interpreter needs to find the script, and the flags of the question.
    arguments: Vec<OsString>,
}

impl Question {
    /// The question to a process with this command line, whose arguments end with a zero byte each;
    /// `None` without a configuration file.
    fn of(line: &[u8]) -> Option<Self> {
        let words: Vec<&OsStr> = (line.split(|byte| *byte == 0))
            .map(OsStr::from_bytes)
            .collect();
        let flags = words.iter().position(|word| {
            let flag = word.as_bytes();
            flag == b"--domain" || flag.starts_with(b"--domain=")
        })?;
        let config = words.iter().position(|word| *word == "--config")?;
        let (program, script) = words[..flags].split_first()?;
        let mut arguments: Vec<OsString> = script.iter().map(OsString::from).collect();
        arguments.extend(["--print-config".into(), "--config".into()]);
        arguments.push((*words.get(config + 1)?).into());
        Some(Self {
            program: PathBuf::from(program),
            arguments,
        })
    }

    /// The program that runs: as it was called when that is still the same file, since an
    /// interpreter finds its environment by its name, else the very file of the process.
    fn binary(&self, pid: u32) -> PathBuf {
        let exe = PathBuf::from(format!("/proc/{pid}/exe"));
        let same = |path: &Path| {
            let file = |path: &Path| std::fs::canonicalize(path).ok();
            file(path).is_some() && file(path) == file(&exe)
        };
        if self.program.is_absolute() && same(&self.program) {
            self.program.clone()
        } else {
            exe
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(words: &[&str]) -> Vec<u8> {
        let words = words.iter().flat_map(|word| [word.as_bytes(), &[0]]);
        words.flatten().copied().collect()
    }

    #[test]
    fn scripts_are_asked_through_their_interpreter() {
        let flags = ["--domain", "/d", "--epoch", "2", "--config", "/d/it.toml"];
        let native = Question::of(&line(&[&["/bin/planner"], &flags[..]].concat()));
        let native = native.expect("a question");
        assert_eq!(native.program, Path::new("/bin/planner"));
        let asked = ["--print-config", "--config", "/d/it.toml"];
        assert_eq!(native.arguments, asked);
        let script = Question::of(&line(&[&["python3", "astar.py"], &flags[..]].concat()));
        let script = script.expect("a question").arguments;
        assert_eq!(script, [&["astar.py"], &asked[..]].concat());
        assert_eq!(
            Question::of(&line(&["/bin/planner", "--domain", "/d"])),
            None
        );
        assert_eq!(Question::of(b""), None);
    }

    #[test]
    fn values_are_found_by_their_path() {
        let values = toml::from_str("a = 1.5\n[b]\nc = \"text\"\n").expect("TOML");
        assert_eq!(at(&values, "a"), Some(&toml::Value::Float(1.5)));
        assert_eq!(
            at(&values, "b.c").map(ToString::to_string).as_deref(),
            Some("\"text\"")
        );
        for missing in ["", "x", "a.c", "b.c.d", "b."] {
            assert_eq!(at(&values, missing), None, "{missing}");
        }
    }
}
