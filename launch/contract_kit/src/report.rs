//! What came out, clause by clause, printed as soon as it is known.

use super::clause::{Clause, Verdict};
use serde::Serialize;
use zeronav_console::environment;
use zeronav_console::terminal::say;
use zeronav_shell::printable;

/// One line of the report.
#[derive(Debug, Clone, Serialize)]
pub struct Line {
    /// Number of the clause.
    pub clause: usize,
    /// Its name.
    pub name: &'static str,
    /// What came out.
    pub verdict: Verdict,
    /// What was measured, or why it failed or was skipped.
    pub why: String,
}

/// The lines so far.
#[derive(Debug, Default)]
pub struct Report {
    lines: Vec<Line>,
    silent: bool,
}

impl Report {
    /// An empty one; a silent one prints nothing.
    pub fn new(silent: bool) -> Self {
        Self {
            lines: Vec::new(),
            silent,
        }
    }

    /// Adds what came out for a clause: `Ok` with what was measured, `Err` with why not.
    pub fn add(&mut self, clause: Clause, result: Result<String, String>) {
        match result {
            Ok(seen) => self.push(clause, Verdict::Ok, seen),
            Err(why) => {
                // Most clauses have a time limit.
                let busy =
                    environment::busy().map_or_else(String::new, |busy| format!(" ({busy})"));
                self.push(clause, Verdict::Failed, why + &busy);
            }
        }
    }

    /// Adds a clause that was not tested.
    pub fn skip(&mut self, clause: Clause, why: &str) {
        self.push(clause, Verdict::Skipped, why.to_owned());
    }

    /// [`Self::skip`] for all of these that have no line yet.
    pub fn skip_rest(&mut self, clauses: &[Clause], why: &str) {
        for clause in clauses {
            if !self.lines.iter().any(|line| line.clause == clause.number()) {
                self.skip(*clause, why);
            }
        }
    }

    fn push(&mut self, clause: Clause, verdict: Verdict, why: String) {
        if !self.silent {
            let (word, why) = (verdict.label(), printable(&why).into_owned());
            say(&format!("{word:8}{clause}: {why}\n"));
        }
        self.lines.push(Line {
            clause: clause.number(),
            name: clause.name(),
            verdict,
            why,
        });
    }

    /// True when no clause failed.
    pub fn passes(&self) -> bool {
        !(self.lines.iter()).any(|line| line.verdict == Verdict::Failed)
    }

    /// The lines, by the number of their clause.
    pub fn lines(&self) -> Vec<Line> {
        let mut lines = self.lines.clone();
        lines.sort_by_key(|line| line.clause);
        lines
    }
}
