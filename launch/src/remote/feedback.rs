//! What becomes of a goal, in words and for scripts.

use crate::control::request::GoalReport;
use crate::orders::{ACTIVE, QUEUED};
use zeronav_console::exit::{EXIT_FAIL, EXIT_PASS};
use zeronav_shell::printable;

impl GoalReport {
    /// True once it ended, well or not.
    pub(crate) fn is_over(&self) -> bool {
        self.outcome != QUEUED && self.outcome != ACTIVE
    }

    /// The exit code of a command that waited for it.
    pub(crate) fn exit_code(&self) -> u8 {
        if self.outcome == "reached" {
            EXIT_PASS
        } else {
            EXIT_FAIL
        }
    }

    /// One line.
    pub(crate) fn in_words(&self) -> String {
        let id = self.id;
        match self.outcome.as_str() {
            QUEUED => format!("goal {id}: queued, {} before it\n", self.before),
            ACTIVE => {
                let way = self.distance_remaining_m.map_or_else(
                    || "on its way".to_owned(),
                    |way_m| format!("{way_m:.1} m left"),
                );
                let time = self
                    .time_remaining_s
                    .map_or_else(String::new, |time_s| format!(", {time_s:.0} s"));
                let goals = if self.goals_left > 1 {
                    format!(", {} goals", self.goals_left)
                } else {
                    String::new()
                };
                let waits = match self.waits_s {
                    0 => String::new(),
                    waits_s => format!(", waits {waits_s} s more: {}", printable(&self.why)),
                };
                format!(
                    "goal {id}: {way}{time}{goals}, {} recoveries, {:.1} s{waits}\n",
                    self.recoveries, self.elapsed_s
                )
            }
            outcome => {
                let why = match self.why.as_str() {
                    "" => String::new(),
                    why => format!(": {}", printable(why)),
                };
                let outcome = printable(outcome);
                let recoveries = match self.recoveries {
                    0 => String::new(),
                    recoveries => format!(", {recoveries} recoveries"),
                };
                let elapsed_s = self.elapsed_s;
                format!("goal {id}: {outcome}, {elapsed_s:.1} s{recoveries}{why}\n")
            }
        }
    }
}
