//! What each message changes of what was heard, whoever brings it.

use super::{
    Collector, MOVING_MPS, MOVING_RADPS, Placed, SENSED_MAX, SIGHTS_MAX, SPANS_MAX, TRACKED_MAX,
    sensed_at,
};
use crate::film;
use zeronav_measure::index::{PathRecord, Sensed, Sighting};
use zeronav_measure::result::moment::Task;
use zeronav_measure::run_totals::{Fact, TaskReport};
use zeronav_measure::shadow_answers::AHEAD_TICKS;
use zeronav_msgs::header::Id;
use zeronav_msgs::path::PathStatus;
use zeronav_msgs::replica::Step;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::{Span, SpanKind};
use zeronav_msgs::task::{Goal, TaskState};
use zeronav_msgs::topics::{
    ControlRequest, GroundTruth, MapKeyframe, MapObstacles, MapUpdate, PlanPath, RobotCommand,
    RobotDescription, RobotOdometry, RobotScan, TaskState as Status,
};
use zeronav_msgs::truth::{Truth, TruthObstacle};
use zeronav_scenario::fault_plan::Sight;
use zeronav_shell::View;

impl Collector {
    /// What is known of the ticks by the records so far; in lockstep the robot goes as far as the `lease`.
    pub(crate) fn settle(&mut self, lease: Option<u64>) {
        let robot_tick = self.robot_tick();
        // In lockstep the robot goes as far as it is leased, and records may be far apart.
        self.last_tick = lease.unwrap_or(robot_tick.saturating_add(AHEAD_TICKS));
        self.aside.settle(robot_tick, self.last_tick);
    }

    /// Takes in a record; in lockstep no answer can be to a tick after the `lease`.
    pub(crate) fn span(&mut self, span: &Span, lease: Option<u64>) {
        let is_answer = span.kind() == Some(SpanKind::Answer);
        if is_answer && lease.is_some_and(|lease| span.tick > lease) {
            return;
        }
        self.aside.note(span);
        if !self.aside.counts(span) {
            return;
        }
        self.recoveries.note(span);
        self.hash.add(span);
        let scanned = span.role == Role::Robot.code() && span.scan != 0;
        if scanned && matches!(span.kind(), Some(SpanKind::Answer | SpanKind::Extra)) {
            self.scan_tick = self.scan_tick.max(span.tick);
        }
        if is_answer {
            let answered = self.answered.entry(span.role).or_default();
            *answered = (*answered).max(span.tick);
        }
        if self.records.spans.len() == SPANS_MAX {
            self.records.spans.drain(..SPANS_MAX / 4);
            self.spans_dropped += SPANS_MAX as u64 / 4;
        }
        self.records.spans.push(*span);
    }

    /// Takes in what the robot is.
    pub(crate) fn description(&mut self, view: View<'_, RobotDescription>) {
        self.film.description(view.meta, view.items);
        self.v_mps_max = view.meta.v_mps_max;
        self.totals.lag.description(view.meta);
    }

    /// Takes in the goals of a task that begins. Numbers of goals are not used again.
    pub(crate) fn goals(&mut self, goals: &[Goal]) {
        self.reached.clear();
        self.film.goals(self.run_ns, goals, &self.reached);
    }

    /// Takes in what is so.
    pub(crate) fn truth(&mut self, view: View<'_, GroundTruth>, placed: Placed<'_>) {
        let (tick, run_ns) = (view.header.tick, view.header.run_ns);
        self.film.truth(run_ns, &view.meta.pose, || {
            let there = view.items.iter();
            let bodies = there.filter_map(|item| placed(item.index as usize, &item.pose));
            bodies.map(|body| film::outline(&body.outline())).collect()
        });
        self.sightings(run_ns, view.meta, view.items);
        if self.sights.len() < SIGHTS_MAX {
            let pose = view.meta.pose;
            let centre_m = [pose.x_m, pose.y_m];
            self.sights.push(Sight { tick, centre_m });
        }
        let fact = Fact::Truth(*view.meta, view.items.to_vec());
        self.totals.ingest(tick, run_ns, fact);
    }

    /// Takes in what the local planner asks for.
    pub(crate) fn request(&mut self, view: View<'_, ControlRequest>) {
        self.film.request(view.header.id, view.meta);
        (self.reasons).request(view.header.tick, view.header.run_ns, view.meta);
    }

    /// Takes in what the guard does.
    pub(crate) fn command(&mut self, view: View<'_, RobotCommand>) {
        let (tick, run_ns) = (view.header.tick, view.header.run_ns);
        self.totals.lag.command(run_ns, view.meta);
        (self.film).command(run_ns, view.header.parents.request, view.meta);
        self.aside.command(tick, self.last_tick);
        self.reasons.command(tick, run_ns, view.meta);
        if !self.zones.is_empty() {
            let zones = self.zones_near(view.meta);
            self.reasons.zones(tick, run_ns, zones);
        }
        (self.totals).ingest(tick, run_ns, Fact::Command(view.meta.intervention()));
    }

    /// Takes in where the wheels say the robot is.
    pub(crate) fn odometry(&mut self, view: View<'_, RobotOdometry>) {
        self.odometry = Some(*view.meta);
        self.totals.lag.odometry(view.header.run_ns, view.meta);
        if view.meta.v_mps.abs() > MOVING_MPS || view.meta.w_radps.abs() > MOVING_RADPS {
            self.first_motion_tick.get_or_insert(view.header.tick);
        }
        self.run_ns = self.run_ns.max(view.header.run_ns);
        (self.film).odometry(view.header.tick, view.header.run_ns, view.meta);
        if view.meta.scan_due() {
            let fact = Fact::Odometry(view.meta.pose);
            (self.totals).ingest(view.header.tick, view.header.run_ns, fact);
        }
    }

    /// Takes in a scan.
    pub(crate) fn scan(&mut self, view: View<'_, RobotScan>) {
        (self.film).scan(view.header.tick, view.header.run_ns, view.meta, view.items);
    }

    /// Takes in what mapping sees moving.
    pub(crate) fn moving(&mut self, view: View<'_, MapObstacles>) {
        self.film.tracked(view.header.run_ns, view.items);
        let scan = view.header.parents.scan;
        (self.reasons).obstacles(view.header.tick, view.header.run_ns, view.items);
        if self.tracked.len() == TRACKED_MAX {
            self.tracked.pop_front();
        }
        self.tracked.push_back((scan, view.items.to_vec()));
        let fact = Fact::Moving(scan, view.items.to_vec());
        (self.totals).ingest(view.header.tick, view.header.run_ns, fact);
    }

    /// Takes in the whole map.
    pub(crate) fn keyframe(&mut self, view: View<'_, MapKeyframe>) {
        self.replica.keyframe(view.meta, view.items);
        self.film.written_all();
    }

    /// Takes in what changed on the map.
    pub(crate) fn update(&mut self, view: View<'_, MapUpdate>, placed: Placed<'_>) {
        let scan = view.header.parents.scan;
        self.film.placed(view.header.tick, view.meta.map_from_odom);
        self.film.written(view.items);
        if scan != 0 && view.meta.is_last_part() {
            self.located = Some((view.header.tick, view.meta.map_from_odom));
            self.certainty = view.meta.certainty();
            self.film.certainty(view.header.run_ns, self.certainty);
            let fact = Fact::Placed(scan, view.meta.map_from_odom, self.certainty);
            (self.totals).ingest(view.header.tick, view.header.run_ns, fact);
        }
        if self.replica.update(view.header.id(), view.meta, view.items) != Step::Applied {
            return;
        }
        let revision = view.header.id();
        if scan != 0 {
            self.updates.0 += 1;
            self.updates.1 += view.items.len() as u64;
        }
        if !self.looks {
            return;
        }
        let is_tracked = self.tracked.iter().any(|(of, _)| *of == scan);
        if is_tracked && self.truth.is_some_and(|truth| truth.scan >= scan) {
            self.look_for_obstacles(revision, scan, placed);
        } else {
            // The truth about the scan, or its obstacles, may still be on their way: look at the
            // next call.
            self.unlooked = Some((revision, scan));
        }
    }

    /// Looks for obstacles on a revision that came before what was to be known of its scan.
    pub(crate) fn look_again(&mut self, placed: Placed<'_>) {
        if let Some((revision, scan)) = self.unlooked.take() {
            self.look_for_obstacles(revision, scan, placed);
        }
    }

    /// Has the film look at the map as it is now.
    pub(crate) fn look_at_map(&mut self) {
        self.film.look_at_map(self.run_ns, &self.replica);
    }

    /// Takes in a new path, and leaves out repeats of an unchanged one.
    pub(crate) fn path(&mut self, view: View<'_, PlanPath>) {
        if view.meta.status() == Some(PathStatus::Found) {
            self.recoveries.note_path(view.header);
        }
        if view.meta.geometry != view.header.id {
            return;
        }
        let Some((status, cause)) = view.meta.status().zip(view.meta.cause()) else {
            return;
        };
        self.film.path(view.header.run_ns, view.meta, view.items);
        self.closed(view.meta);
        (self.reasons).path(view.header.tick, view.header.run_ns, view.meta);
        self.records.paths.push(PathRecord {
            id: view.header.id,
            map: view.header.parents.map,
            run_ns: view.header.run_ns,
            status,
            cause,
            planner: view.meta.planner().to_owned(),
            length_m: view.meta.length_m,
            beside_goal_m: view.meta.beside_goal_m,
            expanded: view.meta.expanded,
            points_m: view
                .items
                .iter()
                .map(|point| [point.x_m, point.y_m])
                .collect(),
        });
    }

    /// Takes in what the local planner reports about its task.
    pub(crate) fn status(&mut self, view: View<'_, Status>) {
        let Some(told) = Task::of(view.meta) else {
            return;
        };
        let state = told.state;
        let reached = view
            .items
            .iter()
            .filter(|end| end.state == TaskState::Reached.code());
        self.reached.extend(reached.map(|end| end.goal));
        // A task that has ended is said again and again; its end is the end of its last goal.
        let ended = view.items.last().map(|end| end.tick);
        let tick = match state {
            TaskState::Idle | TaskState::Active => view.header.tick,
            _ => ended.unwrap_or(view.header.tick),
        };
        let report = TaskReport {
            task: view.meta.task,
            state,
            reason: told.reason,
            tick,
            remaining_m: view.meta.remaining_m,
            recoveries: view.meta.recoveries,
            cause: told.stuck,
            blocked: told.blocked,
            waits_s: told.waits_s,
        };
        self.task = Some(report);
        (self.film).task(view.header.run_ns, state, &self.reached);
        // The end of a task may be heard with a later message.
        let is_then = tick == view.header.tick;
        let run_ns = if is_then { view.header.run_ns } else { 0 };
        self.reasons.task(tick, run_ns, told);
        self.totals
            .ingest(tick, view.header.run_ns, Fact::Task(report));
    }

    fn sightings(&mut self, run_ns: u64, truth: &Truth, obstacles: &[TruthObstacle]) {
        self.run_ns = self.run_ns.max(run_ns);
        self.truth = Some(*truth);
        for obstacle in obstacles {
            let index = obstacle.index as usize;
            self.obstacles.insert(index, obstacle.pose);
            let sightings = &mut self.records.sightings;
            let at = sightings.iter().position(|sighting| {
                sighting.index == index && sighting.appeared_run_ns == obstacle.appeared_run_ns
            });
            let at = at.unwrap_or_else(|| {
                sightings.push(Sighting {
                    index,
                    appeared_run_ns: obstacle.appeared_run_ns,
                    appeared_ns: obstacle.appeared_ns,
                    ..Sighting::default()
                });
                sightings.len() - 1
            });
            let sighting = &mut sightings[at];
            if obstacle.beams > 0 && truth.scan != 0 {
                sighting.first_beam_scan.get_or_insert(truth.scan);
            }
            if obstacle.beams >= 3 && truth.scan != 0 {
                sighting.first_scan.get_or_insert(truth.scan);
            }
        }
    }

    /// Notes what a revision shows of the obstacles that have been seen.
    fn look_for_obstacles(&mut self, revision: Id, scan: u64, placed: Placed<'_>) {
        let tracked = self.tracked.iter().rfind(|(of, _)| *of == scan);
        let obstacles = tracked.map_or(&[][..], |(_, obstacles)| obstacles);
        self.replica.stamp(obstacles);
        // Only readers that update something of their own need the list.
        self.replica.take_changed();
        let Some(map) = self.replica.view() else {
            return;
        };
        for sighting in &mut self.records.sightings {
            let seen = sighting.first_beam_scan.is_some_and(|first| scan >= first);
            let pose = self.obstacles.get(&sighting.index).filter(|_| seen);
            let Some(obstacle) = pose.and_then(|pose| placed(sighting.index, pose)) else {
                continue;
            };
            let cells_m = sensed_at(&map, &obstacle);
            let due = sighting.first_scan.is_some_and(|first| scan >= first);
            if due && !cells_m.is_empty() {
                sighting.first_map.get_or_insert(revision.0);
            }
            let before = sighting.sensed.last().map(|sensed| &sensed.cells_m[..]);
            if before.unwrap_or_default() != cells_m {
                if sighting.sensed.len() == SENSED_MAX {
                    sighting.sensed.remove(0);
                }
                let map = revision.0;
                sighting.sensed.push(Sensed { map, cells_m });
            }
        }
    }
}
