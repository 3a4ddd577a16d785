//! Why the robot of a running stack does what it does now, by a guest that only reads.

use super::around::{Around, Missing};
use super::past;
use crate::control::request::{self, Reply, RunReport};
use crate::running::Running;
use crate::topics::tap::{PAUSE, Tap};
use std::time::{Duration, Instant};
use zeronav_measure::result::moment::{Command, Moment, Obstacle, Path, Request};
use zeronav_msgs::health::HealthState;
use zeronav_msgs::role::Role;
use zeronav_msgs::time::seconds;
use zeronav_msgs::topics::{
    ControlRequest, HealthTopic, MapObstacles, PlanPath, RobotCommand, health_of,
};
use zeronav_observe::health::{Condition, Heart};
use zeronav_shell::clock::now_ns;
use zeronav_shell::{Latest, Peer, Roster, StartError, printable};

/// Longest wait for what every stage sends several times a second.
const WAIT: Duration = Duration::from_millis(600);

/// A restart is told for so long after it. [s]
const RESTART_S: f64 = 2.0;

/// How a service is missing of which only the link is heard.
const CUT: &str = "is on another host and cannot be heard: the way there is cut";

/// What is read.
struct Readers {
    request: Latest<ControlRequest>,
    command: Latest<RobotCommand>,
    path: Latest<PlanPath>,
    obstacles: Latest<MapObstacles>,
    health: Vec<(Role, Latest<HealthTopic>)>,
    /// The geometry of the path, and the run time at which it was new, if that was seen. [ns]
    geometry: (u64, Option<u64>),
}

impl Readers {
    fn open(peer: &Peer) -> Result<Self, StartError> {
        let mut health = Vec::new();
        for role in Role::SERVICES {
            if let Some(row) = health_of(role) {
                health.push((role, peer.latest_on(row)?));
            }
        }
        Ok(Self {
            request: peer.latest()?,
            command: peer.latest()?,
            path: peer.latest()?,
            obstacles: peer.latest()?,
            health,
            geometry: (0, None),
        })
    }

    fn poll(&mut self, roster: &Roster) {
        self.request.poll(roster);
        self.command.poll(roster);
        self.obstacles.poll(roster);
        for (_, health) in &mut self.health {
            health.poll(roster);
        }
        if self.path.poll(roster)
            && let Some(view) = self.path.get()
            && self.geometry.0 != view.meta.geometry
        {
            let is_new = view.meta.geometry == view.header.id;
            let new_ns = is_new.then_some(view.header.run_ns);
            self.geometry = (view.meta.geometry, new_ns);
        }
    }

    /// True when nothing more is to be waited for.
    fn are_complete(&self) -> bool {
        self.request.get().is_some() && self.command.get().is_some() && self.path.get().is_some()
    }

    fn moment(&self) -> Moment {
        let obstacles = self.obstacles.get();
        let request = self.request.get().and_then(|view| {
            let named = view.meta.obstacle;
            let known = obstacles.iter().flat_map(|view| view.items.iter());
            let mut known = known.filter(|obstacle| named != 0 && obstacle.track == named);
            Request::of(view.meta, known.next().map(Obstacle::of))
        });
        let command = self.command.get();
        let path = self.path.get();
        let new_s = self.geometry.1.map(seconds);
        Moment {
            time_s: seconds(command.map_or(0, |view| view.header.run_ns)),
            request,
            command: command.and_then(|view| Command::of(view.meta)),
            path: path.and_then(|view| Path::of(view.meta, new_s)),
            // A local planner that was started again knows nothing of what its predecessor was given.
            task: None,
            zone: None,
        }
    }

    /// Services that do not answer.
    fn silent(&self, now_ns: u64) -> Vec<Missing> {
        let heart = |health: &Latest<HealthTopic>| {
            let view = health.get();
            view.map_or_else(Heart::default, |view| Heart::of(view.header, view.meta))
        };
        let all = self.health.iter();
        all.filter_map(|(role, health)| missing(*role, &heart(health), now_ns))
            .collect()
    }
}

/// How the process in a seat does not answer at a moment, or why it makes the robot stand; `None` when it does
/// neither.
pub(crate) fn missing(role: Role, heart: &Heart, now_ns: u64) -> Option<Missing> {
    let how = match heart.condition(now_ns) {
        Condition::Absent => "has not answered yet",
        Condition::Silent => "does not answer any more",
        Condition::Beats(Some(HealthState::Starting)) => "is starting",
        Condition::Beats(_) if heart.is_cut() => CUT,
        Condition::Beats(_) => heart.stands(role)?,
    };
    Some(Missing {
        role: role.to_string(),
        how: how.to_owned(),
    })
}

/// What holds now.
///
/// # Errors
/// One line when the stack cannot be read.
pub(super) fn now(stack: &Running) -> Result<(Moment, Around), String> {
    let mut tap = Tap::join(Some(stack.root()))?;
    let mut readers = tap.open(Readers::open)?;
    let began = Instant::now();
    loop {
        readers.poll(tap.poll());
        // Two looks at least: the newest of each.
        if began.elapsed() >= WAIT || (readers.are_complete() && began.elapsed() > WAIT / 4) {
            break;
        }
        std::thread::sleep(PAUSE);
    }
    let control = tap.poll().control;
    let mut moment = readers.moment();
    let mut around = Around {
        paused: control.paused == 1,
        stopping: control.stopping == 1,
        missing: readers.silent(now_ns()),
        faults: Vec::new(),
    };
    drop(readers);
    tap.leave();
    add(&mut around, &stack.report()?);
    // Nothing is kept yet of a stack that has just begun.
    if let Ok(Reply::Why(kept)) = stack.ask(&request::Request::Why { ago_s: 0.0 }) {
        let since_s = moment.time_s - kept.time_s;
        moment.task = kept.task.map(|task| task.after(since_s));
        moment.zone = kept.zone.filter(|_| moment.zone_told().is_some());
    }
    Ok((moment, around))
}

/// What held so long ago. [s]
///
/// # Errors
/// One line when the stack does not answer or keeps nothing of that time.
pub(super) fn ago(stack: &Running, ago_s: f64) -> Result<(Moment, Around), String> {
    let Reply::Why(moment) = stack.ask(&request::Request::Why { ago_s })? else {
        return Err(stack.refusal("the answer is not what was asked for"));
    };
    let report = stack.report()?;
    let around = past::around(&report.restarts, &report.faults, moment.time_s);
    Ok((*moment, around))
}

/// Adds what the stack says of itself.
fn add(around: &mut Around, report: &RunReport) {
    around.paused |= report.paused;
    for missing in around.missing.iter_mut().filter(|it| it.how == CUT) {
        let service = report.services.iter().find(|it| it.role == missing.role);
        if let Some(host) = service.and_then(|service| service.host.as_deref()) {
            missing.how = format!(
                "on {} cannot be heard: the way there is cut",
                printable(host)
            );
        }
    }
    for restart in &report.restarts {
        if report.time_s - restart.time_s > RESTART_S {
            continue;
        }
        around
            .missing
            .retain(|missing| missing.role != restart.service);
        around.missing.push(Missing {
            role: restart.service.clone(),
            how: format!(
                "ended at {:.2} s ({}) and was started again",
                restart.time_s, restart.how
            ),
        });
    }
    for fault in report.faults.iter().filter(|fault| fault.until_s.is_none()) {
        // A kill is over at once, a stop with the restart.
        let lasts = fault.kind == "slow" || report.time_s - fault.time_s <= RESTART_S;
        if fault.why.is_none() && lasts {
            let fault = format!("{} {} {}", fault.kind, fault.target, fault.figures);
            around.faults.push(fault.trim_end().to_owned());
        }
    }
}
