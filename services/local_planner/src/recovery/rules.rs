//! The transitions between behaviours, as a table.
//!
//! In each period the first rule that holds is taken. The table in the README is generated from it.
//! Two transitions are not in it because they leave every behaviour: another goal restarts with
//! `Follow`, and a task without progress for `task.stuck_s` ends in `GiveUp`.

use super::behaviour::{Behaviour, Facts, Reason};
use super::options::RecoveryConfig;

/// What the rules are about.
#[derive(Debug, Clone, Copy)]
pub(super) struct View<'a> {
    pub(super) facts: &'a Facts,
    pub(super) config: &'a RecoveryConfig,
    /// [s] since the behaviour began.
    pub(super) lasted_s: f64,
    /// [s] without an admissible motion.
    pub(super) blocked_s: f64,
    /// [s] of turning on the spot without a pause.
    pub(super) turning_s: f64,
    /// [s] since the last manoeuvre, wait or question ended.
    pub(super) since_tried_s: f64,
    /// Something was tried since the robot last came closer.
    pub(super) escalated: bool,
    /// The path is another one than when the behaviour began, and a motion along it is admissible.
    pub(super) another_path: bool,
}

/// Where a transition leads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Next {
    /// To this behaviour.
    Go(Behaviour),
    /// To this behaviour as one of the goal's attempts; `GiveUp` when none is left.
    Attempt(Behaviour),
    /// `AskForPath`, or the next rung when `asks` paths did not help.
    Escalate,
    /// The same with `asks` questions allowed again.
    EscalateAfresh,
    /// The next rung that is possible: `Manoeuvre`, `BackUp` three times, `Rotate`, `Wait`, and again.
    Climb,
}

/// One row of the table.
pub(super) struct Rule {
    pub(super) from: &'static [Behaviour],
    /// The condition in words.
    #[cfg_attr(not(test), allow(dead_code, reason = "the README is compared with it"))]
    pub(super) when: &'static str,
    pub(super) holds: fn(&View<'_>) -> bool,
    pub(super) next: Next,
    pub(super) reason: Reason,
}

use Behaviour::{AskForPath, BackUp, Follow, Manoeuvre, Rotate, Wait};
use Next::{Attempt, Climb, Escalate, EscalateAfresh, Go};

/// Every transition of a robot that has a goal and time left.
pub(super) const RULES: &[Rule] = &[
    Rule {
        from: &[Follow],
        when: "the goal is near, and at it there is no room to turn to its yaw",
        holds: |view| view.facts.approach && view.facts.manoeuvrable,
        next: Attempt(Manoeuvre),
        reason: Reason::Approach,
    },
    Rule {
        from: &[Follow],
        when: "no motion admissible for `patience_s`, a dynamic obstacle near, nothing tried yet",
        holds: |view| is_blocked(view) && view.facts.dynamic_obstacle && !view.escalated,
        next: Attempt(Wait),
        reason: Reason::DynamicObstacle,
    },
    Rule {
        from: &[Follow],
        when: "no motion admissible for `patience_s`",
        holds: is_blocked,
        next: Escalate,
        reason: Reason::Blocked,
    },
    Rule {
        from: &[Follow],
        when: "hardly a motion for 3 s, no dynamic obstacle near, no manoeuvre tried in vain here",
        holds: |view| {
            let facts = view.facts;
            facts.hardly_moves && facts.manoeuvrable && !facts.dynamic_obstacle
        },
        next: Attempt(Manoeuvre),
        reason: Reason::NoProgress,
    },
    Rule {
        from: &[Follow],
        when: "no progress for `task.no_progress_s`, nothing tried for `wait_s`, no turn on the spot",
        // An attempt needs time to show, and a turn on the spot comes no closer.
        holds: |view| {
            let tried_lately = view.since_tried_s <= view.config.wait_s;
            view.facts.no_progress && !tried_lately && !view.facts.turns
        },
        next: Escalate,
        reason: Reason::NoProgress,
    },
    Rule {
        from: &[Follow],
        when: "turning on the spot for longer than 2 `manoeuvre_s`, for `manoeuvre_s` without progress",
        holds: |view| {
            let patience_s = 2.0 * view.config.manoeuvre_s;
            view.turning_s > patience_s && view.facts.idle_s > view.config.manoeuvre_s
        },
        next: Escalate,
        reason: Reason::TimedOut,
    },
    Rule {
        from: &[AskForPath],
        when: "another path, a motion is admissible",
        holds: |view| view.another_path,
        next: Go(Follow),
        reason: Reason::AnotherPath,
    },
    Rule {
        from: &[AskForPath],
        when: "longer than `ask_s`, no motion admissible",
        holds: |view| view.lasted_s > view.config.ask_s && view.facts.blocked,
        next: Climb,
        reason: Reason::TimedOut,
    },
    Rule {
        from: &[AskForPath],
        when: "longer than `ask_s`",
        holds: |view| view.lasted_s > view.config.ask_s,
        next: Go(Follow),
        reason: Reason::Cleared,
    },
    Rule {
        from: &[Wait],
        when: "a motion is admissible",
        holds: |view| !view.facts.blocked,
        next: Go(Follow),
        reason: Reason::Cleared,
    },
    Rule {
        from: &[Wait],
        when: "longer than `wait_s`",
        holds: |view| view.lasted_s > view.config.wait_s,
        next: EscalateAfresh,
        reason: Reason::TimedOut,
    },
    Rule {
        from: &[BackUp],
        when: "`back_up_m` driven",
        holds: |view| view.facts.backed_m >= view.config.back_up_m,
        next: Go(Follow),
        reason: Reason::Done,
    },
    Rule {
        from: &[BackUp],
        when: "not free behind",
        holds: |view| !view.facts.free_behind,
        next: Go(Follow),
        reason: Reason::NotFreeBehind,
    },
    Rule {
        from: &[Rotate],
        when: "`rotate_rad` turned",
        holds: |view| view.facts.rotated_rad >= view.config.rotate_rad,
        next: Go(Follow),
        reason: Reason::Done,
    },
    Rule {
        from: &[Rotate],
        when: "no room to turn",
        holds: |view| !view.facts.room_to_turn,
        next: Go(Follow),
        reason: Reason::NoRoomToTurn,
    },
    Rule {
        from: &[Manoeuvre],
        when: "it is driven",
        holds: |view| view.facts.manoeuvred == Some(Reason::Done),
        next: Go(Follow),
        reason: Reason::Done,
    },
    Rule {
        from: &[Manoeuvre],
        when: "none is found",
        holds: |view| view.facts.manoeuvred == Some(Reason::NoManoeuvre),
        next: Go(Follow),
        reason: Reason::NoManoeuvre,
    },
    Rule {
        from: &[Manoeuvre],
        when: "its next piece does not become free",
        holds: |view| view.facts.manoeuvred.is_some(),
        next: Go(Follow),
        reason: Reason::NotFreeAhead,
    },
    Rule {
        from: &[Manoeuvre],
        when: "longer than 10 `manoeuvre_s`",
        holds: |view| view.lasted_s > 10.0 * view.config.manoeuvre_s,
        next: Go(Follow),
        reason: Reason::TimedOut,
    },
    Rule {
        from: &[BackUp, Rotate],
        when: "longer than `manoeuvre_s`",
        holds: |view| view.lasted_s > view.config.manoeuvre_s,
        next: Go(Follow),
        reason: Reason::TimedOut,
    },
];

fn is_blocked(view: &View<'_>) -> bool {
    view.blocked_s > view.config.patience_s
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::fmt::Write as _;

    /// The rules as the README shows them.
    fn as_markdown() -> String {
        let mut table = String::from("| from | when | to | reason |\n|---|---|---|---|\n");
        for rule in RULES {
            let from: Vec<_> = rule.from.iter().map(|from| format!("{from:?}")).collect();
            let to = match rule.next {
                Go(to) | Attempt(to) => format!("{to:?}"),
                Escalate => "AskForPath or next rung".to_owned(),
                EscalateAfresh => "AskForPath".to_owned(),
                Climb => "next rung".to_owned(),
            };
            let (from, when) = (from.join(", "), rule.when);
            writeln!(table, "| {from} | {when} | {to} | {:?} |", rule.reason).expect("a string");
        }
        table
    }

    #[test]
    fn the_readme_shows_the_rules() {
        let readme = include_str!("../../README.md");
        let table = as_markdown();
        assert!(readme.contains(&table), "README.md should contain\n{table}");
    }
}
