//! What counts of a run: everything up to the tick of its end and nothing after it, however far
//! the robot has come when launch hears of the end.
//!
//! What was heard is held back for as many ticks as the robot can be ahead of the news. When the
//! end is known, what is held is taken in up to it, and so is what comes later about ticks before
//! it; the rest is dropped. So the same run gives the same totals whatever the load.

use crate::command_lag::LagSeen;
use crate::result::moment::{Blocked, Task};
use crate::{Motion, TruthComparison};
use std::collections::{HashMap, VecDeque};
use zeronav_msgs::certainty::PoseCertainty;
use zeronav_msgs::command::Intervention;
use zeronav_msgs::obstacles::Obstacle;
use zeronav_msgs::pose::Pose;
use zeronav_msgs::task::{EndReason, StuckCause, TaskState};
use zeronav_msgs::truth::{Truth, TruthObstacle};

/// Ticks for which a fact is held back: far more than the robot can be ahead of launch.
const HOLD_TICKS: u64 = 128;

/// Distance between two points of the drawn track. [m]
const TRACK_STEP_M: f64 = 0.05;

/// Points of the drawn track at most.
const TRACK_POINTS_MAX: usize = 50_000;

/// The simulator looks no farther: at this distance nothing is near. [m]
const CLEARANCE_M_MAX: f64 = 1000.0;

/// What the local planner says of the task.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TaskReport {
    /// Id of the task.
    pub task: u64,
    /// Its state.
    pub state: TaskState,
    /// Why it ended.
    pub reason: EndReason,
    /// Tick of the end, until then the tick at which this was said.
    pub tick: u64,
    /// Way left. [m]
    pub remaining_m: f64,
    /// Manoeuvres and waits of the recovery since the task began.
    pub recoveries: u32,
    /// Why it got stuck.
    pub cause: StuckCause,
    /// The cell because of which it failed, or waits.
    pub blocked: Option<Blocked>,
    /// For which it waits at most. [s]
    pub waits_s: u16,
}

impl TaskReport {
    /// What became of it.
    #[must_use]
    pub const fn outcome(&self) -> Task {
        Task {
            state: self.state,
            reason: self.reason,
            stuck: self.cause,
            blocked: self.blocked,
            waits_s: self.waits_s,
        }
    }
}

/// Something that was heard.
#[derive(Debug, Clone)]
pub enum Fact {
    /// What was really so.
    Truth(Truth, Vec<TruthObstacle>),
    /// What the guard did to a request. While the last tick is answered launch may already stop the
    /// robot, so the commands of that tick do not count.
    Command(Option<Intervention>),
    /// `odom_from_base` at a tick with a scan.
    Odometry(Pose),
    /// What mapping saw moving in the scan with this id.
    Moving(u64, Vec<Obstacle>),
    /// Where mapping placed the scan with this id: `map_from_odom`, and how far it knew that.
    Placed(u64, Pose, PoseCertainty),
    /// What the local planner said of the task.
    Task(TaskReport),
}

/// The totals, and what is held back from them.
#[derive(Debug, Default)]
pub struct RunTotals {
    /// What mapping said against what was so.
    pub comparison: TruthComparison,
    /// After how long the wheels obey.
    pub lag: LagSeen,
    /// How the robot really moved, and what became of it.
    pub motion: Motion,
    /// Where the robot really drove. [m]
    pub track_m: Vec<[f64; 2]>,
    /// The newest truth.
    pub truth: Option<Truth>,
    /// Smallest clearance of all; `None` when nothing was ever near. [m]
    pub clearance_m_min: Option<f64>,
    /// Scripted obstacles as they were last: index and pose.
    pub obstacles: HashMap<usize, Pose>,
    /// What became of the task.
    pub task: Option<TaskReport>,
    /// Tick, run time [ns] and fact, in the order in which they were heard.
    held: VecDeque<(u64, u64, Fact)>,
    newest_tick: u64,
    end_tick: Option<u64>,
}

impl RunTotals {
    /// Takes in a fact about a tick and its run time. [ns]
    pub fn ingest(&mut self, tick: u64, run_ns: u64, fact: Fact) {
        if self.end_tick.is_some() {
            self.settle(tick, run_ns, fact);
            return;
        }
        self.newest_tick = self.newest_tick.max(tick);
        self.held.push_back((tick, run_ns, fact));
        while let Some((tick, ..)) = self.held.front()
            && tick.saturating_add(HOLD_TICKS) < self.newest_tick
        {
            if let Some((tick, run_ns, fact)) = self.held.pop_front() {
                self.settle(tick, run_ns, fact);
            }
        }
    }

    /// The run ended at this tick: nothing after it counts.
    pub fn end_at(&mut self, tick: u64) {
        self.end_tick = Some(tick);
        for (tick, run_ns, fact) in core::mem::take(&mut self.held) {
            self.settle(tick, run_ns, fact);
        }
    }

    /// Nothing more is heard, and nobody says when the run ended: all that was heard counts.
    pub fn end(&mut self) {
        if self.end_tick.is_none() {
            self.end_at(u64::MAX);
        }
    }

    /// Why the robot got stuck, if it did.
    #[must_use]
    pub fn stuck_cause(&self) -> Option<StuckCause> {
        let cause = self.task?.cause;
        (cause != StuckCause::None).then_some(cause)
    }

    /// Distance driven. [m]
    #[must_use]
    pub fn driven_m(&self) -> f64 {
        self.truth.map_or(0.0, |truth| truth.driven_m)
    }

    /// Adds a fact to the totals, unless it is later than the end.
    fn settle(&mut self, tick: u64, run_ns: u64, fact: Fact) {
        let end_tick = self.end_tick.unwrap_or(u64::MAX);
        let is_late = match fact {
            // The guard's idle output, before the first tick, depends on what it had received by
            // then.
            Fact::Command(_) => tick == 0 || tick >= end_tick,
            _ => tick > end_tick,
        };
        if is_late {
            return;
        }
        match fact {
            Fact::Truth(truth, obstacles) => self.truth(run_ns, &truth, &obstacles),
            Fact::Command(why) => self.motion.command(run_ns, why),
            Fact::Odometry(pose) => self.comparison.odometry(run_ns, &pose),
            Fact::Moving(scan, tracked) => self.comparison.obstacles(scan, &tracked),
            Fact::Placed(scan, map_from_odom, certainty) => {
                self.comparison.placed(scan, &map_from_odom, certainty);
            }
            Fact::Task(report) => self.task = Some(report),
        }
        self.comparison.compare();
    }

    fn truth(&mut self, run_ns: u64, truth: &Truth, obstacles: &[TruthObstacle]) {
        let here = [truth.pose.x_m, truth.pose.y_m];
        let moved = self
            .track_m
            .last()
            .is_none_or(|last| (last[0] - here[0]).hypot(last[1] - here[1]) >= TRACK_STEP_M);
        if moved && self.track_m.len() < TRACK_POINTS_MAX {
            self.track_m.push(here);
        }
        self.motion.truth(run_ns, truth, obstacles);
        self.comparison
            .truth(run_ns, truth.scan, &truth.pose, obstacles);
        if truth.clearance_m < CLEARANCE_M_MAX {
            let least = self.clearance_m_min.get_or_insert(truth.clearance_m);
            *least = least.min(truth.clearance_m);
        }
        for obstacle in obstacles {
            self.obstacles
                .insert(obstacle.index as usize, obstacle.pose);
        }
        self.truth = Some(*truth);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TICK_NS: u64 = 20_000_000;

    /// One metre a tick along x, nearer and nearer to something, in contact from tick 300 on.
    fn truth(tick: u32) -> Fact {
        let truth = Truth {
            pose: Pose::new(f64::from(tick), 0.0, 0.0),
            driven_m: f64::from(tick),
            clearance_m: 1010.0 - f64::from(tick),
            contacts_moving: u32::from(tick >= 300),
            ..Truth::default()
        };
        Fact::Truth(truth, Vec::new())
    }

    fn ingest(totals: &mut RunTotals, tick: u32, fact: Fact) {
        let tick = u64::from(tick);
        totals.ingest(tick, tick * TICK_NS, fact);
    }

    /// The totals of a run that ends at tick 299, of whose end launch hears `late` ticks later.
    fn run(late: u32) -> RunTotals {
        let mut totals = RunTotals::default();
        for tick in 1..=299 + late {
            ingest(&mut totals, tick, truth(tick));
            let why = if tick % 2 == 1 {
                Intervention::Slowed
            } else {
                Intervention::None
            };
            // The last commands are heard after the end.
            if tick + 3 < 299 + late {
                ingest(&mut totals, tick, Fact::Command(Some(why)));
            }
        }
        totals.end_at(299);
        for tick in 296 + late..=299 + late {
            let why = if tick % 2 == 1 {
                Intervention::Slowed
            } else {
                Intervention::None
            };
            ingest(&mut totals, tick, Fact::Command(Some(why)));
        }
        ingest(&mut totals, 300 + late, truth(300 + late));
        totals
    }

    #[test]
    fn totals_end_with_the_run_however_late_its_end_is_heard() {
        let exact = run(0);
        assert!((exact.driven_m() - 299.0).abs() < 1e-9);
        assert_eq!(exact.truth.map(|truth| truth.contacts_moving), Some(0));
        assert_eq!(exact.motion.contacts, []);
        assert_eq!(exact.track_m.len(), 299);
        assert_eq!(exact.clearance_m_min, Some(711.0));
        // Ticks 1, 3, ... 297: what is said at the last tick does not count.
        assert_eq!(exact.motion.interventions.len(), 149);
        for late in [1, 17, 100] {
            let totals = run(late);
            assert_eq!(totals.truth, exact.truth, "{late} ticks late");
            assert_eq!(totals.track_m, exact.track_m);
            assert_eq!(totals.motion.moments, exact.motion.moments);
            assert_eq!(totals.motion.contacts, exact.motion.contacts);
            assert_eq!(totals.motion.interventions, exact.motion.interventions);
            assert_eq!(totals.clearance_m_min, exact.clearance_m_min);
        }
    }

    #[test]
    fn the_idle_output_of_the_guard_is_no_intervention() {
        let mut totals = RunTotals::default();
        ingest(&mut totals, 0, Fact::Command(Some(Intervention::Refused)));
        ingest(&mut totals, 1, Fact::Command(Some(Intervention::None)));
        totals.end_at(9);
        assert_eq!(totals.motion.interventions, []);
    }

    #[test]
    fn where_nothing_is_near_there_is_no_clearance() {
        let mut totals = RunTotals::default();
        ingest(&mut totals, 1, truth(1));
        ingest(&mut totals, 10, truth(10));
        totals.end_at(9);
        assert_eq!(totals.clearance_m_min, None);
    }
}
