//! A stack that is up, for tests that ask it to do something.

use crate::{Zeronav, leftovers, zeronav};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// A stack that is up.
pub struct Up {
    /// The process of `zeronav up`.
    pub stack: Zeronav,
    /// Root folder of its domain.
    pub root: String,
}

impl Up {
    /// Brings a stack up in a folder of its own and waits until it is ready.
    ///
    /// # Panics
    /// When it does not get ready.
    #[must_use]
    pub fn start(arguments: &[&str]) -> Self {
        let folder = tempfile::tempdir().expect("a working folder");
        Self::start_in(folder, arguments)
    }

    /// [`Self::start`] in this folder.
    ///
    /// # Panics
    /// As [`Self::start`].
    #[must_use]
    pub fn start_in(folder: tempfile::TempDir, arguments: &[&str]) -> Self {
        let arguments = [&["up", "--headless", "--json"], arguments].concat();
        let mut stack = Zeronav::start_in(folder, &arguments);
        stack.wait_until("it is ready", |stack| {
            let report = stack.report();
            report.is_some_and(|report| report["ready"] == true)
        });
        let root = stack.domains().pop().expect("a domain");
        let root = root.display().to_string();
        Self { stack, root }
    }

    /// Runs a command on this stack and returns what it printed.
    ///
    /// # Panics
    /// When it ends with another code.
    #[track_caller]
    #[allow(
        clippy::must_use_candidate,
        reason = "commands are run for what they do"
    )]
    pub fn ask(&self, arguments: &[&str], code: i32) -> String {
        let ended = zeronav(&[arguments, &["--domain", &self.root]].concat());
        assert_eq!(
            ended.code(),
            code,
            "{arguments:?}: {}{}",
            ended.stdout,
            ended.stderr
        );
        format!("{}{}", ended.stdout, ended.stderr)
    }

    /// The JSON objects that a command printed, one per line.
    ///
    /// # Panics
    /// When it ends with another code, or printed something else.
    #[track_caller]
    #[must_use]
    pub fn lines(&self, arguments: &[&str], code: i32) -> Vec<Value> {
        let text = self.ask(&[arguments, &["--json"]].concat(), code);
        let lines = text.lines();
        let read = |line| serde_json::from_str(line).unwrap_or_else(|_| panic!("{text}"));
        lines.map(read).collect()
    }

    /// What it says of itself.
    ///
    /// # Panics
    /// When it does not answer.
    #[must_use]
    pub fn status(&self) -> Value {
        self.stack.report().expect("it answers")
    }

    /// Waits until the state of a goal is `outcome`.
    pub fn wait_for_outcome(&mut self, what: &str, outcome: &str) {
        self.stack.wait_until(what, |stack| {
            let report = stack.report();
            report.is_some_and(|report| report["goal"]["outcome"] == outcome)
        });
    }

    /// Ends it and returns its result.
    ///
    /// # Panics
    /// When it does not end well, or leaves something behind.
    #[allow(
        clippy::must_use_candidate,
        reason = "most tests end it to see that it ends"
    )]
    pub fn down(self) -> Value {
        let said = self.ask(&["down"], 0);
        assert!(said.contains("is down"), "{said}");
        let ended = self.stack.finish();
        let result = ended.expect(0);
        assert_eq!(result["outcome"], "down");
        assert_eq!(leftovers(Path::new(&self.root)), Vec::<PathBuf>::new());
        result
    }
}
