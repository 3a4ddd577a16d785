//! What happens in a run, from what its topics say. Pure.

use crate::scene::{Event, Rounded};
use std::collections::BTreeMap;
use zeronav_msgs::certainty::PoseCertainty;
use zeronav_msgs::command::Intervention;
use zeronav_msgs::header::Id;
use zeronav_msgs::path::{Path, PathCause, PathStatus};
use zeronav_msgs::role::Role;
use zeronav_msgs::run::Seat;
use zeronav_msgs::task::{EndReason, Goal, GoalEnd, StuckCause, TaskState, TaskStatus};
use zeronav_msgs::time::seconds;

/// An intervention that begins again within this time is the same one. [ns] of run time
const SAME_INTERVENTION_NS: u64 = 1_000_000_000;

/// Most events that wait to be sent.
const WAITING_MAX: usize = 256;

/// Tells what happens.
#[derive(Debug, Default)]
pub(crate) struct Events {
    waiting: Vec<Event>,
    /// Run time of what was taken in last. [ns]
    now_ns: u64,
    geometry: Id,
    /// Intervention that goes on or was the last, and when it was seen last.
    guard: Option<(Intervention, u64)>,
    goal: u64,
    ended: usize,
    task: u64,
    /// The newest one without goals.
    cancel: u64,
    recoveries: u32,
    seats: BTreeMap<u16, Seat>,
    paused: Option<bool>,
    silent: BTreeMap<u16, bool>,
    certainty: Option<PoseCertainty>,
}

impl Events {
    /// Run time goes on.
    pub(crate) fn at(&mut self, run_ns: u64) {
        self.now_ns = self.now_ns.max(run_ns);
    }

    /// What has happened since the last call.
    pub(crate) fn take(&mut self) -> Vec<Event> {
        core::mem::take(&mut self.waiting)
    }

    fn tell(&mut self, kind: &'static str, text: String) {
        self.tell_with(kind, text, Vec::new());
    }

    fn tell_with(&mut self, kind: &'static str, text: String, hops_us: Vec<(&'static str, f64)>) {
        if self.waiting.len() < WAITING_MAX {
            self.waiting.push(Event {
                time_s: Rounded::thousandths(seconds(self.now_ns)),
                kind,
                text,
                hops_us,
            });
        }
    }

    /// A message of `plan/path`; true when its geometry is new.
    pub(crate) fn path(&mut self, path: &Path) -> bool {
        if path.geometry == 0 || Id(path.geometry) == self.geometry {
            return false;
        }
        self.geometry = Id(path.geometry);
        let (status, cause) = (path.status(), path.cause());
        if status == Some(PathStatus::NoGoal) {
            return true;
        }
        let cause = cause.map_or("unknown", PathCause::label);
        let planner = path.planner();
        let text = if status == Some(PathStatus::Found) {
            let (length_m, expanded) = (path.length_m, path.expanded);
            format!("{cause}: {length_m:.1} m by {planner}, {expanded} expanded")
        } else {
            let status = status.map_or("unknown", PathStatus::label);
            format!("{cause}: none, {status}, by {planner}")
        };
        self.tell("path", text);
        true
    }

    /// The first command on a new path has reached the wheels, after these hops from the capture of
    /// the scan.
    pub(crate) fn replanned(&mut self, hops_us: Vec<(&'static str, f64)>) {
        let sum_us: f64 = hops_us.iter().map(|(_, us)| us).sum();
        let text = format!("new path at the wheels after {:.2} ms", sum_us / 1.0e3);
        self.tell_with("path", text, hops_us);
    }

    /// A command of the guard.
    pub(crate) fn command(&mut self, intervention: Option<Intervention>, run_ns: u64) {
        use Intervention::{Clamped, None as Nothing};
        let Some(now) = intervention.filter(|now| !matches!(now, Nothing | Clamped)) else {
            return;
        };
        let same = self.guard.is_some_and(|(before, seen_ns)| {
            before == now && run_ns.saturating_sub(seen_ns) < SAME_INTERVENTION_NS
        });
        self.guard = Some((now, run_ns));
        if !same {
            self.tell("guard", now.label().replace('_', " "));
        }
    }

    /// A message of `task/goal`.
    pub(crate) fn task(&mut self, id: Id, goals: &[Goal]) {
        if goals.is_empty() {
            // It ends the task before it, whose status tells how; launch sends one after every end.
            self.cancel = id.0;
            return;
        }
        if id.0 == self.task {
            return;
        }
        self.task = id.0;
        (self.ended, self.goal, self.recoveries) = (0, 0, 0);
        match goals {
            [goal] => {
                let (x_m, y_m) = (goal.pose.x_m, goal.pose.y_m);
                self.tell("goal", format!("to {x_m:.2}, {y_m:.2}"));
            }
            goals => self.tell("goal", format!("{} goals", goals.len())),
        }
    }

    /// A message of `task/status`.
    pub(crate) fn status(&mut self, status: &TaskStatus, ended: &[GoalEnd]) {
        if status.task != self.task.max(self.cancel) && status.task != self.task {
            return;
        }
        for end in ended.iter().skip(self.ended) {
            let state = TaskState::from_code(end.state).map_or("ended", TaskState::label);
            let reason = EndReason::from_code(end.reason).filter(|why| *why != EndReason::None);
            let cause = status.cause().filter(|cause| *cause != StuckCause::None);
            let mut text = state.to_owned();
            if let Some(reason) = reason {
                text = format!("{text}: {}", reason.label().replace('_', " "));
            }
            if let (Some(EndReason::Stuck), Some(cause)) = (reason, cause) {
                text = format!("{text}, {}", cause.label().replace('_', " "));
            }
            self.tell("goal", text);
        }
        self.ended = self.ended.max(ended.len());
        if status.recoveries > self.recoveries {
            self.tell("recovery", format!("number {}", status.recoveries));
        }
        self.recoveries = status.recoveries;
    }

    /// What launch says about the seats.
    pub(crate) fn seats(&mut self, seats: &[Seat], paused: bool) {
        if let Some(before) = self.paused.replace(paused)
            && before != paused
        {
            let text = if paused {
                "run time held"
            } else {
                "run time goes on"
            };
            self.tell("pause", text.to_owned());
        }
        for seat in seats {
            let Some(role) = Role::from_code(seat.role) else {
                continue;
            };
            let Some(before) = self.seats.insert(seat.role, *seat) else {
                continue;
            };
            if seat.epoch != before.epoch {
                let is_swap = seat.other == before.epoch || before.other == seat.epoch;
                let (kind, what) = if is_swap {
                    ("swap", "taken over")
                } else {
                    ("restart", "restarted")
                };
                self.tell(kind, format!("{role} {what} by epoch {}", seat.epoch));
            } else if seat.other != before.other && seat.other != 0 {
                self.tell("swap", format!("{role} compared with epoch {}", seat.other));
            }
            if seat.delay != before.delay {
                let delay_ms = seconds(seat.delay_ns()) * 1.0e3;
                let text = match seat.delay {
                    0 => format!("{role} no longer slowed"),
                    _ => format!("{role} slowed by {delay_ms} ms"),
                };
                self.tell("fault", text);
            }
        }
    }

    /// How far the robot knows where it is.
    pub(crate) fn certainty(&mut self, certainty: PoseCertainty) {
        let before = self.certainty.replace(certainty);
        if before.unwrap_or(PoseCertainty::Confirmed) == certainty {
            return;
        }
        let text = match certainty {
            PoseCertainty::Unknown => "the robot does not know where it is",
            PoseCertainty::Unconfirmed => "where the robot was told to be is not confirmed",
            PoseCertainty::Confirmed => "the robot knows where it is",
        };
        self.tell("pose", text.to_owned());
    }

    /// Whether a seat beats its heart.
    pub(crate) fn heart(&mut self, role: Role, silent: bool) {
        let before = self.silent.insert(role.code(), silent);
        if before == Some(!silent) {
            let text = if silent { "silent" } else { "answers again" };
            self.tell("fault", format!("{role} {text}"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(events: &mut Events) -> Vec<(&'static str, String)> {
        let taken = events.take().into_iter();
        taken.map(|event| (event.kind, event.text)).collect()
    }

    #[test]
    fn a_repeated_path_is_no_event_and_a_new_one_has_its_cause() {
        let mut events = Events::default();
        let mut path = Path::new("jps", PathStatus::Found, PathCause::Obstacle, 1, &[]);
        (path.geometry, path.length_m) = (Id::new(1, 4).0, 2.5);
        assert!(events.path(&path));
        assert!(!events.path(&path));
        path.geometry = Id::new(1, 9).0;
        path.status = PathStatus::Unreachable.code();
        assert!(events.path(&path));
        let events_sent = texts(&mut events);
        assert_eq!(events_sent.len(), 2);
        assert_eq!(events_sent[0].1, "obstacle: 2.5 m by jps, 0 expanded");
        assert_eq!(events_sent[1].1, "obstacle: none, unreachable, by jps");
    }

    #[test]
    fn a_new_path_at_the_wheels_has_its_hops() {
        let mut events = Events::default();
        events.replanned(vec![("robot", 400.0), ("to_mapping", 100.0)]);
        let events_sent = events.take();
        assert_eq!(events_sent[0].text, "new path at the wheels after 0.50 ms");
        assert_eq!(events_sent[0].hops_us[1], ("to_mapping", 100.0));
    }

    #[test]
    fn an_intervention_counts_once_until_it_has_been_over() {
        let mut events = Events::default();
        let slowed = Some(Intervention::Slowed);
        for run_ns in [0, 20_000_000, 40_000_000] {
            events.command(slowed, run_ns);
            events.command(Some(Intervention::None), run_ns + 1);
        }
        events.command(slowed, 3_000_000_000);
        events.command(Some(Intervention::StoppedShort), 3_000_000_001);
        let events_sent = texts(&mut events);
        let words: Vec<&str> = events_sent.iter().map(|(_, text)| text.as_str()).collect();
        assert_eq!(words, ["slowed", "slowed", "stopped short"]);
    }

    #[test]
    fn the_outcome_of_a_goal_is_told_once_and_is_not_cancelled_after_it() {
        let mut events = Events::default();
        let (first, cancel) = (Id::new(1, 4), Id::new(1, 5));
        let ended = |state: TaskState| GoalEnd {
            state: state.code(),
            ..GoalEnd::default()
        };
        let status = |id: Id| TaskStatus {
            task: id.0,
            ..TaskStatus::default()
        };
        let goals = [Goal::default()];
        events.task(first, &goals);
        events.status(&status(first), &[ended(TaskState::Reached)]);
        events.task(cancel, &[]);
        events.status(&status(cancel), &[ended(TaskState::Reached)]);
        events.task(Id::new(1, 6), &goals);
        events.task(Id::new(1, 7), &[]);
        events.status(&status(Id::new(1, 7)), &[ended(TaskState::Cancelled)]);
        let events_sent = texts(&mut events);
        let words: Vec<&str> = events_sent.iter().map(|(_, text)| text.as_str()).collect();
        assert_eq!(
            words,
            ["to 0.00, 0.00", "reached", "to 0.00, 0.00", "cancelled"]
        );
    }

    #[test]
    fn a_robot_that_is_lost_and_found_is_told_and_one_that_never_was_is_not() {
        use PoseCertainty::{Confirmed, Unconfirmed, Unknown};
        let mut events = Events::default();
        events.certainty(Confirmed);
        assert!(events.take().is_empty());
        for certainty in [Unknown, Unknown, Confirmed, Confirmed, Unconfirmed] {
            events.certainty(certainty);
        }
        let said: Vec<String> = texts(&mut events).into_iter().map(|it| it.1).collect();
        let expected = [
            "the robot does not know where it is",
            "the robot knows where it is",
            "where the robot was told to be is not confirmed",
        ];
        assert_eq!(said, expected);
    }

    #[test]
    fn restarts_swaps_and_delays_are_told_apart() {
        let seat = |epoch, other, delay| Seat {
            role: Role::Mapping.code(),
            epoch,
            other,
            delay,
            ..Seat::default()
        };
        let mut events = Events::default();
        for seat in [
            seat(1, 0, 0),
            seat(2, 0, 0),
            seat(2, 3, 0),
            seat(3, 2, 0),
            seat(3, 0, 200),
            seat(3, 0, 0),
        ] {
            events.seats(&[seat], false);
        }
        events.seats(&[], true);
        let events_sent = texts(&mut events);
        let kinds: Vec<&str> = events_sent.iter().map(|(kind, _)| *kind).collect();
        assert_eq!(
            kinds,
            ["restart", "swap", "swap", "fault", "fault", "pause"]
        );
        assert_eq!(events_sent[3].1, "mapping slowed by 2 ms");
    }
}
