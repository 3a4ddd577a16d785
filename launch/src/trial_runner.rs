//! Trials: an obstacle is dropped before the robot again and again while it drives to and fro.
//!
//! A trial begins when nothing is left of the last one: the map shows no cell of the obstacle, and
//! the path leads through where it will stand. The obstacle appears at a phase of the lidar's turn
//! that is drawn uniformly, and is taken away as soon as a command has answered it.

use crate::collect::{Collector, sensed_at};
use crate::disturbance::Reading;
use nalgebra::Point2;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use zeronav_measure::index::PathRecord;
use zeronav_measure::result::trials::Disturbance;
use zeronav_measure::{Event, EventOutcome, Records, judge};
use zeronav_msgs::Pose;
use zeronav_msgs::path::PathStatus;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::Span;
use zeronav_msgs::truth::Placement;
use zeronav_scenario::{GoalSpec, TrialsSpec};
use zeronav_world::{Shape, World};

/// Run time between the decision to drop the obstacle and the first moment at which it may
/// appear: the robot has read the message by then. [ns]
const LEAD_NS: u64 = 60_000_000;

/// Run time for which the records of an answered trial are still gathered. [ns]
const SETTLE_NS: u64 = 200_000_000;

/// Run time without a finished trial after which the stack is given up. [ns]
const STUCK_NS: u64 = 90_000_000_000;

/// Farthest that the robot may be beside the line when an obstacle is dropped. [m]
const BESIDE_M_MAX: f64 = 0.6;

/// What launch does next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Step {
    /// Wait.
    Wait,
    /// Tell the robot's world.
    Place(Placement),
    /// All trials are over.
    Done,
    /// No trial has come to an end for too long.
    Stuck,
}

/// An obstacle that was dropped.
#[derive(Debug, Clone, Copy)]
struct Dropped {
    placement: Placement,
    /// Record of the path that was followed then.
    path_span: Option<Span>,
    path_id: u64,
    /// Monotonic time before which no record of the trial was made. [ns]
    began_ns: u64,
    /// Run time at which its answer was seen. [ns]
    answered_run_ns: Option<u64>,
}

/// The trials that one drive shall make.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Quota {
    /// How many.
    pub n: usize,
    /// Draws their phases.
    pub seed: u64,
    /// Trials that other drives have made.
    pub before: usize,
    /// Trials of all drives.
    pub total: usize,
    /// The drive, counted from 1: each has a recording of its own.
    pub round: usize,
}

/// One trial that counts.
#[derive(Debug, Clone)]
pub(crate) struct Trial {
    /// What became of its obstacle.
    pub event: Event,
    /// What disturbed the machine from the decision to drop the obstacle to its answer.
    pub disturbance: Option<Disturbance>,
}

/// What trials need to know of world and robot.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Course<'a> {
    /// The scenario's words.
    pub spec: &'a TrialsSpec,
    /// The world.
    pub world: &'a World,
    /// Of the swept robot. [m]
    pub radius_m: f64,
    /// From scan to scan. [ns]
    pub scan_period_ns: u64,
    /// Time after which a trial counts as unanswered. [ns]
    pub deadline_ns: u64,
}

/// The trials of one drive.
#[derive(Debug)]
pub(crate) struct TrialRunner<'a> {
    course: Course<'a>,
    index: usize,
    shape: &'a Shape,
    wanted: usize,
    random: Pcg64Mcg,
    leg: usize,
    dropped: Option<Dropped>,
    /// Where the last obstacle stood.
    last: Option<Pose>,
    ended_run_ns: u64,
    trials: Vec<Trial>,
    /// The kernel's counters when the obstacle was dropped.
    before: Option<Reading>,
    disturbance: Option<Disturbance>,
    missed: u64,
}

impl<'a> TrialRunner<'a> {
    /// `wanted` trials, their phases drawn from `seed`; `None` without such an obstacle.
    #[must_use]
    pub(crate) fn new(course: Course<'a>, wanted: usize, seed: u64) -> Option<Self> {
        let obstacles = course.world.obstacles();
        let named = |obstacle: &zeronav_world::Obstacle| obstacle.spec.name == course.spec.obstacle;
        let index = obstacles.iter().position(named)?;
        Some(Self {
            course,
            index,
            shape: &obstacles.get(index)?.shape,
            wanted,
            random: Pcg64Mcg::seed_from_u64(seed),
            leg: 0,
            dropped: None,
            last: None,
            ended_run_ns: 0,
            trials: Vec::with_capacity(wanted),
            before: None,
            disturbance: None,
            missed: 0,
        })
    }

    /// The current goal.
    #[must_use]
    pub(crate) const fn goal(&self) -> &'a GoalSpec {
        &self.course.spec.goals[self.leg]
    }

    /// The goal was reached: turn around.
    pub(crate) fn turn(&mut self) {
        self.leg = 1 - self.leg;
    }

    /// Trials that are over.
    #[must_use]
    pub(crate) const fn done(&self) -> usize {
        self.trials.len()
    }

    /// Every trial that counts, and how many did not because no path led through the obstacle.
    #[must_use]
    pub(crate) fn into_trials(self) -> (Vec<Trial>, u64) {
        (self.trials, self.missed)
    }

    /// Looks at what was heard and says what to do. `run_ns` is the robot's newest run time.
    pub(crate) fn look(&mut self, collector: &mut Collector, run_ns: u64) -> Step {
        if self.ended_run_ns == 0 {
            self.ended_run_ns = run_ns;
        }
        if let Some(dropped) = self.dropped {
            return self.watch(collector, dropped, run_ns);
        }
        if self.trials.len() >= self.wanted {
            return Step::Done;
        }
        if run_ns.saturating_sub(self.ended_run_ns) > STUCK_NS {
            return Step::Stuck;
        }
        self.start(collector, run_ns)
    }

    /// Takes the kernel's counters after a [`Step::Place`]: once when the obstacle is dropped and
    /// once when it is taken away.
    pub(crate) fn note(&mut self, reading: Reading, records: &Records) {
        let Some(dropped) = self.dropped else {
            return;
        };
        if dropped.placement.until_run_ns == 0 && dropped.answered_run_ns.is_none() {
            self.before = Some(reading);
            return;
        }
        let recent = records.spans.iter().rev();
        let of_trial = recent.take_while(|span| span.started_ns >= dropped.began_ns);
        let before = self.before.take();
        self.disturbance = before.map(|before| reading.since(&before, of_trial));
    }

    /// Begins a trial if everything is in place.
    fn start(&mut self, collector: &Collector, run_ns: u64) -> Step {
        let (Some(truth), Some(map)) = (collector.truth, collector.replica.view()) else {
            return Step::Wait;
        };
        let Some(there) = self.place_ahead(truth.pose.point()) else {
            return Step::Wait;
        };
        let left = self
            .last
            .is_some_and(|last| !sensed_at(&map, &self.shape.placed_at(&last)).is_empty());
        let path = collector.records.paths.last();
        let through = path.is_some_and(|path| {
            path.status == PathStatus::Found
                && self.clearance_m(&there, &path.points_m) <= self.course.radius_m
        });
        let (false, true, Some(path)) = (left, through, path) else {
            return Step::Wait;
        };
        let spans = &collector.records.spans;
        let path_span = spans
            .iter()
            .rev()
            .find(|span| span.role == Role::GlobalPlanner.code() && span.output == path.id);
        let phase_ns = self.random.random_range(0..self.course.scan_period_ns);
        let placement = Placement {
            index: u32::try_from(self.index).unwrap_or(u32::MAX),
            from_run_ns: run_ns + LEAD_NS + phase_ns,
            pose: there,
            ..Placement::default()
        };
        self.dropped = Some(Dropped {
            placement,
            path_span: path_span.copied(),
            path_id: path.id,
            began_ns: spans.last().map_or(0, |span| span.started_ns),
            answered_run_ns: None,
        });
        Step::Place(placement)
    }

    /// Where the obstacle would be dropped before a robot at `robot`; `None` where it is not on
    /// the line.
    fn place_ahead(&self, robot: Point2<f64>) -> Option<Pose> {
        let [from, to] = self.course.spec.line_m.map(Point2::from);
        let other = &self.course.spec.goals[1 - self.leg];
        let way = self.goal().pose.point() - other.pose.point();
        let line = to - from;
        let length_m = line.norm();
        let along = line / length_m;
        let forward = if way.dot(&along) < 0.0 { -1.0 } else { 1.0 };
        let robot_m = (robot - from).dot(&along);
        let beside_m = (robot - from).perp(&along).abs();
        let at_m = robot_m + forward * self.course.spec.ahead_m;
        let there = from + along * at_m;
        let on_line = (0.0..=length_m).contains(&at_m) && beside_m <= BESIDE_M_MAX;
        on_line.then(|| Pose::new(there.x, there.y, self.shape.pose().yaw_rad))
    }

    /// Waits for the answer to the obstacle that was dropped, then for the rest of its records.
    fn watch(&mut self, collector: &mut Collector, dropped: Dropped, run_ns: u64) -> Step {
        let placement = dropped.placement;
        let sighting = collector.records.sightings.iter().find(|sighting| {
            sighting.index == self.index && sighting.appeared_run_ns == placement.from_run_ns
        });
        let event = sighting.map(|sighting| {
            let records = window(&collector.records, &dropped);
            let clearance_m =
                |_, points_m: &[[f64; 2]]| self.clearance_m(&placement.pose, points_m);
            let (radius_m, deadline_ns) = (self.course.radius_m, self.course.deadline_ns);
            judge(&records, sighting, &clearance_m, radius_m, deadline_ns)
        });
        let seen = sighting.is_some_and(|sighting| sighting.first_scan.is_some());
        let outcome = event.as_ref().map(|event| event.outcome);
        let since_ns = run_ns.saturating_sub(placement.from_run_ns);
        if let Some(answered_run_ns) = dropped.answered_run_ns {
            if run_ns.saturating_sub(answered_run_ns) >= SETTLE_NS {
                self.finish(collector, event, run_ns);
            }
            return Step::Wait;
        }
        let answered = matches!(outcome, Some(EventOutcome::Answered | EventOutcome::Early));
        let missed = outcome == Some(EventOutcome::NotInTheWay)
            && seen
            && since_ns > self.course.scan_period_ns + SETTLE_NS;
        let late = since_ns > self.course.deadline_ns;
        if !(answered || missed || late) {
            return Step::Wait;
        }
        self.dropped = Some(Dropped {
            answered_run_ns: Some(run_ns),
            ..dropped
        });
        Step::Place(Placement {
            until_run_ns: run_ns.max(placement.from_run_ns),
            ..placement
        })
    }

    fn finish(&mut self, collector: &mut Collector, event: Option<Event>, run_ns: u64) {
        if let Some(dropped) = self.dropped.take() {
            self.last = Some(dropped.placement.pose);
            collector
                .records
                .sightings
                .retain(|sighting| sighting.appeared_run_ns != dropped.placement.from_run_ns);
        }
        self.ended_run_ns = run_ns;
        let disturbance = self.disturbance.take();
        match event {
            Some(event) if event.outcome != EventOutcome::NotInTheWay => {
                self.trials.push(Trial { event, disturbance });
            }
            // One that the robot never saw, or that no path led through, asks nothing of the stack.
            _ => self.missed += 1,
        }
    }

    fn clearance_m(&self, there: &Pose, points_m: &[[f64; 2]]) -> f64 {
        let polyline: Vec<Point2<f64>> = points_m.iter().copied().map(Point2::from).collect();
        self.shape.polyline_clearance_m(there, &polyline)
    }
}

/// The records of one trial: those since it began, and the path before it.
fn window(records: &Records, dropped: &Dropped) -> Records {
    /// Processes are heard one after the other, so the records of one moment come apart. [ns]
    const SLACK_NS: u64 = 500_000_000;
    let recent = records
        .spans
        .iter()
        .rev()
        .take_while(|span| span.started_ns + SLACK_NS > dropped.began_ns);
    let mut spans: Vec<Span> = recent.copied().collect();
    spans.extend(dropped.path_span);
    spans.reverse();
    let paths: Vec<PathRecord> = records
        .paths
        .iter()
        .rev()
        .take_while(|path| path.id >= dropped.path_id)
        .cloned()
        .collect();
    Records {
        spans,
        paths: paths.into_iter().rev().collect(),
        sightings: Vec::new(),
    }
}

#[cfg(test)]
mod tests;
