//! What is known of a stack, from its messages and from what it says of itself. Pure: every moment
//! comes from outside.

use super::events::Events;
use super::latency::Latency;
use super::totals::Totals;
use super::view::{CompanionLine, RunLine, ServiceLine, View};
use crate::control::request::{CompanionReport, RunReport};
use std::collections::BTreeMap;
use zeronav_msgs::command::{Intervention, VelocityCommand};
use zeronav_msgs::header::Header;
use zeronav_msgs::health::{Health, HealthState};
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::path::{Path, PathCause, PathStatus};
use zeronav_msgs::role::Role;
use zeronav_msgs::span::Span;
use zeronav_msgs::task::{EndReason, TaskState, TaskStatus};
use zeronav_msgs::time::seconds;
use zeronav_observe::health::Heart;
use zeronav_observe::usage::{Meter, Reading, Usage};
use zeronav_shell::printable;

/// One message, as far as it is looked into.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Heard {
    /// A heartbeat.
    Beat(Header, Health),
    /// A path, new or repeated.
    Path(Header, Path),
    /// What the guard lets the wheels do.
    Command(Header, VelocityCommand),
    /// What became of the task.
    Task(Header, TaskStatus),
    /// Where the wheels say the robot is.
    Odometry(Header, Odometry),
    /// Anything else.
    Other,
}

/// Whose usage a reading is.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Whose {
    /// The process in a seat.
    Seat(Role),
    /// The companion of this name.
    Companion(String),
    /// This view's own.
    Own,
}

/// What is known of a stack.
#[derive(Debug)]
pub(crate) struct Model {
    totals: Totals,
    latency: Latency,
    events: Events,
    hearts: BTreeMap<Role, Heart>,
    meters: BTreeMap<Whose, Meter>,
    /// The last that the stack has said of itself.
    report: RunReport,
    has_report: bool,
    run_ns: u64,
    odometry: Option<Odometry>,
    task: Option<TaskStatus>,
    is_lockstep: bool,
}

impl Model {
    /// Nothing is known of a stack with these topics yet.
    pub(crate) fn new(topics: Vec<&'static str>, is_lockstep: bool) -> Self {
        Self {
            totals: Totals::new(topics),
            latency: Latency::default(),
            events: Events::default(),
            hearts: BTreeMap::new(),
            meters: BTreeMap::new(),
            report: RunReport::default(),
            has_report: false,
            run_ns: 0,
            odometry: None,
            task: None,
            is_lockstep,
        }
    }

    /// A message was read on the topic at `index`, sent at `sent_ns`, after `missed` that were not.
    pub(super) fn count(&mut self, index: usize, bytes: usize, sent_ns: u64, missed: u64) {
        self.totals.add(index, bytes, sent_ns, missed);
    }

    /// Looks into a message.
    pub(crate) fn ingest(&mut self, heard: &Heard) {
        match heard {
            Heard::Beat(header, beat) => self.beat(header, beat),
            Heard::Path(header, path) => self.path(header, path),
            Heard::Command(header, command) => {
                let does = command.intervention().unwrap_or(Intervention::None);
                if does != Intervention::None && header.tick > 0 {
                    self.events.guard(header.run_ns, does.label());
                }
            }
            Heard::Task(header, task) => self.task(header, task),
            Heard::Odometry(header, odometry) => {
                self.run_ns = self.run_ns.max(header.run_ns);
                self.odometry = Some(*odometry);
            }
            Heard::Other => {}
        }
    }

    /// Takes in a record; in lockstep there are no latencies.
    pub(crate) fn span(&mut self, span: &Span) {
        if !self.is_lockstep {
            self.latency.span(span);
        }
    }

    fn beat(&mut self, header: &Header, beat: &Health) {
        let Some(role) = header.role() else {
            return;
        };
        let heart = Heart::of(header, beat);
        let before = core::mem::replace(self.hearts.entry(role).or_default(), heart);
        let (was, is) = (before.beat.state(), beat.state());
        if before.epoch != 0 && before.epoch != heart.epoch {
            let text = format!("{role}: epoch {} after {}", heart.epoch, before.epoch);
            self.events.add(self.run_ns, "state", text);
        } else if before.epoch == heart.epoch && (was != is || before.beat.reasons != beat.reasons)
        {
            let reasons = heart.reasons().join(", ");
            let mut text = format!("{role}: {}", is.map_or("unknown", HealthState::label));
            if !reasons.is_empty() {
                text = format!("{text} ({reasons})");
            }
            self.events.add(self.run_ns, "state", text);
        }
    }

    fn path(&mut self, header: &Header, path: &Path) {
        let Some((status, cause)) = path.status().zip(path.cause()) else {
            return;
        };
        if path.geometry != header.id || status == PathStatus::NoGoal {
            return;
        }
        let length = match status {
            PathStatus::Found => format!(", {:.1} m", path.length_m),
            _ => String::new(),
        };
        let text = format!("{status}{length} by {}, cause {cause}", path.planner());
        self.events.add(header.run_ns, "path", text);
        if cause == PathCause::Obstacle && status == PathStatus::Found {
            self.latency
                .path(header.id, header.parents.map, header.run_ns);
        }
    }

    fn task(&mut self, header: &Header, task: &TaskStatus) {
        let before = self.task.replace(*task);
        let same = |before: &TaskStatus| {
            (before.task, before.state, before.reason) == (task.task, task.state, task.reason)
        };
        if before.as_ref().is_some_and(same) {
            return;
        }
        let state = task.state().unwrap_or(TaskState::Idle);
        let reason = task.reason().unwrap_or(EndReason::None);
        let text = match reason {
            EndReason::None => state.label().to_owned(),
            _ => format!("{state}: {reason}"),
        };
        self.events.add(header.run_ns, "task", text);
    }

    /// Takes in what the stack says of itself.
    pub(super) fn report(&mut self, report: RunReport) {
        let before = core::mem::replace(&mut self.report, report);
        for restart in &self.report.restarts {
            if !before.restarts.contains(restart) {
                let text = format!("{}: {}", restart.service, restart.how);
                let text = printable(&text).into_owned();
                self.events.add_at(restart.time_s, "restart", text);
            }
        }
        for fault in &self.report.faults {
            let known = before.faults.iter().find(|known| known.id == fault.id);
            let what = format!("{} {} {}", fault.kind, fault.target, fault.figures);
            let what = printable(what.trim_end()).into_owned();
            if known.is_none() {
                self.events.add_at(fault.time_s, "fault", what.clone());
            }
            if let Some(until_s) = fault.until_s
                && known.is_none_or(|known| known.until_s.is_none())
            {
                self.events.add_at(until_s, "fault", what + " is over");
            }
        }
        if let Some(swap) = &self.report.swap {
            let is_known = (before.swap.as_ref())
                .is_some_and(|known| (known.id, &known.state) == (swap.id, &swap.state));
            if !is_known {
                let text = format!("{} to {}: {}", swap.role, swap.binary, swap.state);
                self.events
                    .add_at(self.report.time_s, "swap", printable(&text).into_owned());
            }
        }
        self.forget_companions();
        self.has_report = true;
    }

    /// Processes that are to be read.
    pub(super) fn pids(&self) -> Vec<(Whose, u32)> {
        let hearts = self.hearts.iter();
        let seats = hearts.map(|(role, heart)| (Whose::Seat(*role), heart.beat.pid));
        let companions = (self.report.companions.iter())
            .filter(|companion| companion.pid != 0)
            .map(|companion| (Whose::Companion(companion.name.clone()), companion.pid));
        let own = [(Whose::Own, std::process::id())];
        seats.chain(companions).chain(own).collect()
    }

    /// Takes in a reading of a process; `None` when it is gone.
    pub(super) fn read(&mut self, whose: Whose, reading: Option<Reading>) {
        self.meters.entry(whose).or_default().read(reading);
    }

    /// Forgets companions that the stack does not have any more.
    fn forget_companions(&mut self) {
        let companions = &self.report.companions;
        self.meters.retain(|whose, _| match whose {
            Whose::Companion(name) => companions.iter().any(|companion| companion.name == *name),
            Whose::Seat(_) | Whose::Own => true,
        });
    }

    /// Brings rates and latencies up to this moment. [ns]
    pub(crate) fn refresh(&mut self, now_ns: u64) {
        self.totals.mark(now_ns);
        if !self.is_lockstep {
            self.latency.refresh(now_ns);
        }
    }

    /// What is shown at this moment. [ns]
    pub(crate) fn view(&self, now_ns: u64) -> View {
        let services = Role::SERVICES.map(|role| self.service(role, now_ns));
        View {
            run: self.run(),
            services: services.to_vec(),
            companions: self.companions(),
            topics: self.totals.lines(now_ns),
            window_s: self.totals.window_s(),
            reaction: self.latency.reaction(),
            replanning: self.latency.replanning().cloned(),
            events: self.events.lines(),
            own: self.usage(&Whose::Own, std::process::id()),
        }
    }

    fn run(&self) -> RunLine {
        let report = &self.report;
        let task = self.task.as_ref();
        let state = task.and_then(TaskStatus::state);
        RunLine {
            scenario: printable(&report.scenario).into_owned(),
            domain: printable(&report.domain).into_owned(),
            mode: printable(&report.mode).into_owned(),
            time_s: seconds(self.run_ns).max(report.time_s),
            tick: report.tick,
            paused: report.paused,
            task: state.unwrap_or(TaskState::Idle).label().to_owned(),
            remaining_m: task
                .filter(|_| state == Some(TaskState::Active))
                .map(|task| task.remaining_m),
            v_mps: self.odometry.map(|odometry| odometry.v_mps),
        }
    }

    fn service(&self, role: Role, now_ns: u64) -> ServiceLine {
        let heart = self.hearts.get(&role).copied().unwrap_or_default();
        let beat = &heart.beat;
        let services = self.report.services.iter();
        let of_seat = || services.clone().filter(|it| it.role == role.label());
        let restarts = of_seat().map(|service| service.restarts).max();
        let host = of_seat().find_map(|service| service.host.as_deref());
        ServiceLine {
            role: role.label(),
            host: host.map(|host| printable(host).into_owned()),
            epoch: heart.epoch,
            restarts: restarts.filter(|_| self.has_report),
            state: heart.condition(now_ns).label(),
            usage: self.usage(&Whose::Seat(role), beat.pid),
            rejected: beat.refused,
            superseded: beat.superseded,
            reasons: heart.reasons(),
        }
    }

    fn companions(&self) -> Vec<CompanionLine> {
        let line = |companion: &CompanionReport| CompanionLine {
            name: printable(&companion.name).into_owned(),
            state: printable(&companion.state).into_owned(),
            restarts: companion.starts.saturating_sub(1),
            usage: self.usage(&Whose::Companion(companion.name.clone()), companion.pid),
            end: printable(&companion.end).into_owned(),
        };
        self.report.companions.iter().map(line).collect()
    }

    /// What a process takes by its readings.
    fn usage(&self, whose: &Whose, pid: u32) -> Usage {
        let nothing = Meter::default();
        self.meters.get(whose).unwrap_or(&nothing).usage(pid)
    }
}

#[cfg(test)]
mod tests;
