//! The faults that go on, those that will come, and what became of the others.

use super::ballast::Ballast;
use crate::prepare::Prepared;
use std::collections::VecDeque;
use zeronav_measure::result::fault::FaultResult;
use zeronav_msgs::role::Role;
use zeronav_msgs::time::seconds;
use zeronav_scenario::fault_plan::{Pace, Schedule, Sight};
use zeronav_scenario::{FAULTS_MAX, StackFault};

/// A fault that goes on.
#[derive(Debug)]
pub(super) struct Active {
    pub(super) id: u64,
    pub(super) fault: StackFault,
    /// The process that it was done to: its seat and epoch.
    pub(super) process: Option<(Role, u32)>,
    /// What fills a file system.
    pub(super) _ballast: Option<Ballast>,
}

/// Lockstep: the robot waits at its tick until the seat of a broken process has a successor, so that
/// nothing depends on how long that takes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hold {
    pub(super) role: Role,
    pub(super) epoch: u32,
    pub(super) tick: u64,
}

/// The faults of a run.
#[derive(Debug)]
pub(super) struct Faults {
    pub(super) schedule: Schedule,
    pub(super) active: Vec<Active>,
    pub(super) hold: Option<Hold>,
    /// The oldest go first.
    pub(super) records: VecDeque<FaultResult>,
    pub(super) last_id: u64,
    /// Where the robot was seen last.
    pub(super) last: Sight,
    pub(super) pace: Pace,
}

impl Faults {
    pub(super) fn new(prepared: &Prepared) -> Self {
        let robot = &prepared.scenario.robot;
        let tick_ns = prepared.scenario.run.tick_ns();
        let start = prepared.scenario.start;
        let v_mps_max = robot.v_mps_max.max(robot.v_mps_min.abs());
        Self {
            schedule: Schedule::new(&prepared.faults, tick_ns),
            active: Vec::new(),
            hold: None,
            records: VecDeque::new(),
            last_id: 0,
            last: Sight {
                tick: 0,
                centre_m: [start.x_m, start.y_m],
            },
            pace: Pace {
                step_m_max: v_mps_max * seconds(tick_ns),
                // The truth comes at the rate of the lidar.
                ticks: prepared.scan_period_ns().div_ceil(tick_ns.max(1)),
            },
        }
    }

    /// Every fault that is remembered, the oldest first.
    pub(super) fn results(&self) -> Vec<FaultResult> {
        self.records.iter().cloned().collect()
    }

    pub(super) fn record(&mut self, record: FaultResult) {
        if self.records.len() == FAULTS_MAX {
            self.records.pop_front();
        }
        self.records.push_back(record);
    }

    pub(super) fn record_of(&mut self, id: u64) -> Option<&mut FaultResult> {
        self.records.iter_mut().rfind(|record| record.id == id)
    }
}
