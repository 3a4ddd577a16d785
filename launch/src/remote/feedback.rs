//! What becomes of a goal, in words and for scripts.

use crate::control::request::GoalReport;
use crate::exit::{EXIT_FAIL, EXIT_PASS};
use crate::orders::{ACTIVE, QUEUED};
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
                format!(
                    "goal {id}: {way}{time}{goals}, {} recoveries, {:.1} s\n",
                    self.recoveries, self.elapsed_s
                )
            }
            outcome => {
                let why = match self.why.as_str() {
                    "" => String::new(),
                    why => format!(": {}", printable(why)),
                };
                let outcome = printable(outcome);
                format!("goal {id}: {outcome}, {:.1} s{why}\n", self.elapsed_s)
            }
        }
    }
}
