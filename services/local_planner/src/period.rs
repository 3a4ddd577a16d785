//! One control period of the local planner.

use crate::account::Account;
use crate::behaviours::{Behaviours, Moment};
use crate::config::LocalPlannerConfig;
use crate::dynamic_obstacles::is_dynamic_near;
use crate::explain::{self, Circumstances};
use crate::inputs::{Inputs, PathInput};
use crate::obstruction::{Known, Obstruction};
use crate::outputs::Outputs;
use crate::past_hits::PastHits;
use crate::pilot::Pilot;
use crate::progress::{PathTracker, Place};
use crate::recovery::{Behaviour, Facts, Recovery, Transition};
use crate::requests::{PathRequests, RequestInputs};
use crate::seek_pose::PoseSeeker;
use crate::situation::{Decision, Room, Situation};
use crate::staleness::{Ages, StaleInput, ageing, speed_factor};
pub use crate::table::BuildError;
use crate::table::controller;
use crate::task::{Planned, TaskInputs, TaskMachine, TaskStep};
use crate::zone_speed::zone_mps;
use nalgebra::Point2;
use zeronav_motion::{Ahead, Twist, stop_distance_m, towards_rest};
use zeronav_msgs::Pose;
use zeronav_msgs::command::{RecoveryReason, RequestCause, Validity};
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::path::{PathStatus, Waypoint};
use zeronav_msgs::request::PlanRequest;
use zeronav_msgs::rollouts::{Rollout, Rollouts};
use zeronav_msgs::stages::{Stage, StageTimer};
use zeronav_msgs::task::{Goal, GoalEnd, Task, TaskState, TaskStatus};
use zeronav_msgs::time::seconds;

/// [m] beyond the robot's outer circle within which an obstacle is what stops it.
const OBSTRUCTION_M: f64 = 0.3;

/// The local planner: a task, a pilot with the configured controller, and the rules around them.
pub struct LocalPlanner {
    config: LocalPlannerConfig,
    task: TaskMachine,
    pilot: Pilot,
    requests: PathRequests,
    tracker: PathTracker,
    /// `None` = the controller is left alone.
    recovery: Option<Recovery>,
    seeker: Option<PoseSeeker>,
    account: Account,
    /// Where the robot does not get on: where an obstacle is on its path, or where it stands without an
    /// admissible motion. `map` frame [m]
    stopped_at: Option<Point2<f64>>,
    /// Why the recovery does what it does.
    reason: RecoveryReason,
    behaviours: Behaviours,
    /// Requested last; ramps to rest start here.
    last: Twist,
    /// The last period turned on the spot.
    turns: bool,
    /// Of an outline with corners.
    past: PastHits,
    /// Room for the scan as of when a command takes effect.
    room: Room,
}

/// How the robot moves: as measured, or as it will when it stands but a command on its way moves it.
fn moves(odometry: &Odometry, ahead: Option<Ahead>) -> Twist {
    let measured = Twist::measured(odometry);
    let then = ahead.map_or(measured, |ahead| ahead.twist);
    if measured.is_stopped() {
        then
    } else {
        measured
    }
}

/// A path that leads to the current goal, and the robot's place on it.
#[derive(Clone, Copy)]
struct Route<'a> {
    geometry: u64,
    waypoints: &'a [Waypoint],
    place: Place,
}

impl LocalPlanner {
    /// A local planner without a task.
    ///
    /// # Errors
    /// [`BuildError`] when the configuration is not usable.
    pub fn new(config: &LocalPlannerConfig) -> Result<Self, BuildError> {
        zeronav_params::check(config)?;
        let row = controller(&config.controller)?;
        let recovers = config.recovery.enabled && (config.recovery.for_papers || !row.of_a_paper);
        Ok(Self {
            config: config.clone(),
            task: TaskMachine::new(config.task),
            pilot: (row.build)(config),
            requests: PathRequests::new(config.requests),
            tracker: PathTracker::new(),
            recovery: recovers.then(|| Recovery::new(config.recovery)),
            seeker: (config.recovery.seek_pose).then(PoseSeeker::default),
            account: Account::of(0),
            stopped_at: None,
            reason: RecoveryReason::None,
            behaviours: Behaviours::new(config.recovery, config.dwa.safety_margin_m),
            last: Twist::REST,
            turns: false,
            past: PastHits::default(),
            room: Room::default(),
        })
    }

    /// From now on keeps what a period looks at, or no longer. Nothing is decided by it.
    pub fn record(&mut self, on: bool) {
        self.pilot.record(on);
    }

    /// For `debug/rollouts`: what the last period looked at, while that is kept; `None` when it looked
    /// at nothing new.
    #[must_use]
    pub fn rollouts(&self) -> Option<(Rollouts, &[Rollout])> {
        self.pilot.rollouts()
    }

    /// What times the stages of [`Self::step`]; off unless the caller has put another one there.
    pub fn timer(&mut self) -> &mut StageTimer {
        &mut self.pilot.timer
    }

    /// Takes in a task by its id on `task/goal`; repeats are ignored.
    pub fn accept_task(&mut self, id: u64, task: &Task, goals: &[Goal]) {
        self.task.accept(id, task, goals);
    }

    /// Takes in how far the local planner that is obeyed has come with the task, while this one is
    /// not.
    pub fn follow(&mut self, status: &TaskStatus, ends: &[GoalEnd]) {
        self.task.follow(status, ends);
        if status.task == self.task.status().0.task {
            self.account.follow(self.task.subject(), status);
        }
    }

    /// The task's status and the ends of its goals.
    #[must_use]
    pub fn status(&self) -> (TaskStatus, &[GoalEnd]) {
        let (status, ends) = self.task.status();
        let status = self.account.complete(self.task.subject(), status);
        (status, ends)
    }

    /// The current goal.
    #[must_use]
    pub fn goal(&self) -> Option<&Goal> {
        self.task.goal()
    }

    /// One control period: the task first, then the twist, then whether a path is needed. Tick 0 is
    /// the idle output, by which nothing is judged.
    pub fn step(&mut self, inputs: &Inputs<'_>) -> Outputs {
        if inputs.tick == 0 {
            return Outputs::idle(&inputs.ages);
        }
        let map_from_base = inputs.map_from_base();
        let mut route = self.route(inputs, map_from_base);
        let ahead = inputs.ahead();
        let (was_active, waited) = (self.task.state() == TaskState::Active, self.task.waits());
        let step = self.task.step(&TaskInputs {
            tick: inputs.tick,
            run_ns: inputs.run_ns,
            robot: map_from_base.zip(inputs.odometry.map(|odometry| moves(odometry, ahead))),
            path: inputs.path.and_then(|input| Planned::of(input.path)),
            remaining: route.map(|route| (route.place.remaining_m, route.geometry)),
            turns: self.turns,
            certainty: inputs.certainty,
            given_up: matches!(self.behaviour(), Behaviour::GiveUp(_)),
            seeks_pose: (self.seeker.as_ref()).is_some_and(|it| it.is_seeking(inputs.run_ns)),
            moves_at_goal: self
                .task
                .goal()
                .is_some_and(|goal| is_dynamic_near(inputs.obstacles.0, &goal.pose)),
        });
        let has_failed = step.changed && self.task.state() == TaskState::Failed && was_active;
        if has_failed || waited || self.task.waits() {
            let is_blocked = has_failed || self.task.waits();
            let told = is_blocked.then(|| self.obstruction(inputs, map_from_base, step));
            let told = told.unwrap_or(Obstruction::NONE);
            self.account.blocked(self.task.subject(), told);
        }
        if step.changed {
            self.stopped_at = None;
            // The goal may be another one now.
            route = self.route(inputs, map_from_base);
        }
        if let Some(odometry) = inputs.odometry {
            let behaviour = self.behaviour();
            self.behaviours
                .note(behaviour, &odometry.pose, odometry.v_mps);
        }
        let behaviour = self.behaviour();
        let driven = self.drive(inputs, (map_from_base, ahead), route, step);
        let (decision, recovery, stale) = match driven {
            Ok((decision, recovery)) => (decision, recovery, None),
            Err((validity, stale)) => {
                let (rest, recovery) = self.idle(inputs, validity, step);
                (rest, recovery, stale)
            }
        };
        self.last = Twist::new(decision.v_mps, decision.w_radps);
        self.turns = decision.turns;
        let ageing = ageing(&self.ages(inputs), &self.config.staleness);
        let about = Circumstances {
            ages: &inputs.ages,
            obstacles: inputs.obstacles.0,
            stale,
            ageing,
            behaviour,
            reason: self.reason,
            map_from_base,
        };
        let request = explain::request(&decision, &about);
        if let Some(change) = &recovery {
            self.account.note(self.task.subject(), change.to);
            self.reason = explain::reason_of(change.reason);
        }
        Outputs {
            request,
            plan_request: self.ask(inputs, route, step, &decision),
            status_changed: step.changed,
            stale,
            ageing,
            recovery,
            rollouts: decision.rollouts,
            blocked_arc_m: decision.blocked_arc_m,
            cross_track_m: route.map_or(0.0, |route| route.place.cross_track_m),
        }
    }

    /// Because of what the task has just failed: the global planner says why there is no path, else
    /// it is the obstacle nearest to where the robot does not get on.
    fn obstruction(
        &self,
        inputs: &Inputs<'_>,
        map_from_base: Option<Pose>,
        step: TaskStep,
    ) -> Obstruction {
        let told = inputs.path.and_then(|path| Obstruction::told_by(path.path));
        let found = || {
            let at = self.stopped_at.filter(|_| step.stuck)?;
            let reach_m = inputs.robot?.0.circumscribed_radius_m + OBSTRUCTION_M;
            let known = Known {
                map_from_base: map_from_base?,
                map: inputs.map.map(|(_, map)| map),
                obstacles: inputs.obstacles.0,
                scan_points_in_base: inputs.scan_points_in_base,
            };
            known.nearest(at, reach_m)
        };
        told.or_else(found).unwrap_or(Obstruction::NONE)
    }

    /// Notes where the robot does not get on. A manoeuvre says nothing about that.
    fn note_stop(&mut self, decision: &Decision, route: Route<'_>, robot: &Pose) {
        let on_path = decision.blocked_arc_m.map(|ahead_m| {
            let arc_m = route.place.arc_m + ahead_m;
            self.tracker.point_at(route.waypoints, arc_m)
        });
        self.stopped_at = match on_path.or(decision.against) {
            Some(at) => Some(at),
            None if decision.validity == Validity::Blocked => Some(robot.point()),
            None if self.behaviour().is_manoeuvre() => self.stopped_at,
            None => None,
        };
    }

    /// The path when it leads to the current goal.
    fn route<'a>(&mut self, inputs: &Inputs<'a>, map_from_base: Option<Pose>) -> Option<Route<'a>> {
        let goal = self.task.goal()?.id;
        let PathInput { path, waypoints } = inputs
            .path
            .filter(|input| input.path.goal == goal)
            .filter(|input| input.path.status() == Some(PathStatus::Found))?;
        let geometry = path.geometry;
        let place = self
            .tracker
            .advance(geometry, waypoints, map_from_base?.point())?;
        Some(Route {
            geometry,
            waypoints,
            place,
        })
    }

    /// What the robot is about.
    #[must_use]
    pub fn behaviour(&self) -> Behaviour {
        self.recovery
            .as_ref()
            .map_or(Behaviour::Follow, Recovery::behaviour)
    }

    /// Ages of what matters now: a path that never came is no path, not a stale one, and without a
    /// goal none is needed.
    fn ages(&self, inputs: &Inputs<'_>) -> Ages {
        let path_ns = inputs.ages.path_ns.filter(|_| self.task.goal().is_some());
        Ages {
            path_ns: path_ns.or(Some(0)),
            ..inputs.ages
        }
    }

    /// The decision of the controller or the recovery, or why there is nothing to decide.
    fn drive(
        &mut self,
        inputs: &Inputs<'_>,
        (map_from_base, ahead): (Option<Pose>, Option<Ahead>),
        route: Option<Route<'_>>,
        step: TaskStep,
    ) -> Result<(Decision, Option<Transition>), (Validity, Option<StaleInput>)> {
        if inputs.stopping {
            return Err((Validity::Stopped, None));
        }
        let Some(goal) = self.task.goal().copied() else {
            return Err(match self.task.state() {
                TaskState::Reached => (Validity::AtGoal, None),
                TaskState::Cancelled => (Validity::Stopped, None),
                TaskState::Idle | TaskState::Active | TaskState::Failed => (Validity::NoPath, None),
            });
        };
        let stale = |input| (Validity::Stale, Some(input));
        let speed_factor =
            speed_factor(&self.ages(inputs), &self.config.staleness).map_err(stale)?;
        let odometry = inputs.odometry.ok_or(stale(StaleInput::Odometry))?;
        let (_, map) = inputs.map.ok_or(stale(StaleInput::Map))?;
        let map_from_base = map_from_base.ok_or(stale(StaleInput::Map))?;
        let (robot, corners) = inputs.robot.ok_or((Validity::Stale, None))?;
        let sought = (self.seeker.as_mut()).and_then(|seeker| seeker.decide(inputs, self.last));
        if !inputs.certainty.is_known() {
            let sought = sought.ok_or(stale(StaleInput::Pose))?;
            self.pilot
                .overruled(Twist::new(sought.v_mps, sought.w_radps));
            return Ok((sought, self.idle_recovery(inputs, step)));
        }
        let route = route.ok_or((Validity::NoPath, None))?;
        let points = inputs.scan_points_in_base;
        let mut past = core::mem::take(&mut self.past);
        let past_hits_in_base = if corners.is_empty() {
            &[]
        } else {
            let lidar = robot.base_from_laser.point();
            past.after(map, (&map_from_base, inputs.run_ns), (points, lidar))
        };
        let situation = Situation {
            map_from_base,
            v_mps: odometry.v_mps,
            w_radps: odometry.w_radps,
            robot,
            corners,
            path: route.waypoints,
            path_geometry: route.geometry,
            map: Some(map),
            map_cells: inputs.map_cells,
            obstacles: inputs.obstacles.0,
            obstacles_age_s: inputs.obstacles.1,
            future: inputs.future,
            scan_points_in_base: points,
            past_hits_in_base,
            goal: &goal,
            speed_factor,
            zone_mps: zone_mps(inputs.zones, robot, map_from_base.point(), |ahead_m| {
                let arc_m = route.place.arc_m + ahead_m;
                self.tracker.point_at(route.waypoints, arc_m)
            }),
            period_s: inputs.period_s,
            ahead_s: 0.0,
        };
        let driven = match ahead {
            None => self.recover(inputs, &situation, &odometry.pose, step),
            Some(ahead) => {
                // The command is for the robot that it finds.
                let mut room = core::mem::take(&mut self.room);
                let then = situation.ahead(&ahead, &mut room);
                let odom_from_base = odometry.pose.then(&ahead.shift);
                let driven = self.recover(inputs, &then, &odom_from_base, step);
                self.room = room;
                driven
            }
        };
        self.past = past;
        self.note_stop(&driven.0, route, &map_from_base);
        Ok(driven)
    }

    /// The controller's decision, or that of the recovery where that has a manoeuvre of its own.
    fn recover(
        &mut self,
        inputs: &Inputs<'_>,
        situation: &Situation<'_>,
        pose: &Pose,
        step: TaskStep,
    ) -> (Decision, Option<Transition>) {
        self.timer().mark(Stage::Prepare);
        let behaviour = self.behaviour();
        let at = Moment {
            situation,
            odom_from_base: pose,
            tracker: &self.tracker,
            now_s: seconds(inputs.run_ns),
        };
        let decision = self.behaviours.decide(behaviour, &mut self.pilot, &at);
        let Some(recovery) = &mut self.recovery else {
            return (decision, None);
        };
        let facts = Facts {
            now_s: at.now_s,
            goal: situation.goal.id,
            geometry: situation.path_geometry,
            blocked: decision.validity == Validity::Blocked && !behaviour.is_manoeuvre(),
            turns: decision.turns,
            stalled_s: step.stalled_s,
            idle_s: step.idle_s,
            no_progress: step.no_progress,
            stuck: step.stuck,
            dynamic_obstacle: is_dynamic_near(situation.obstacles, &situation.map_from_base),
            ..Facts::default()
        };
        let facts = self
            .behaviours
            .complete(facts, behaviour, &mut self.pilot, &at);
        let transition = recovery.step(&facts);
        if let Some(change) = &transition {
            self.behaviours.change(*change, &mut self.pilot, &at);
        }
        (decision, transition)
    }

    /// The recovery while the robot is idle: it forgets its goal, or learns that the task has failed.
    fn idle_recovery(&mut self, inputs: &Inputs<'_>, step: TaskStep) -> Option<Transition> {
        // Of a robot that does not know where it is everything was tried elsewhere.
        let was_elsewhere =
            !inputs.certainty.is_known() && matches!(self.behaviour(), Behaviour::GiveUp(_));
        let goal = self.task.goal().filter(|_| !was_elsewhere);
        let goal = goal.map_or(0, |goal| goal.id);
        let recovery = self.recovery.as_mut()?;
        recovery.idle(seconds(inputs.run_ns), goal, step.stuck)
    }

    /// The first step of a ramp to rest, and what the recovery makes of that.
    fn idle(
        &mut self,
        inputs: &Inputs<'_>,
        validity: Validity,
        step: TaskStep,
    ) -> (Decision, Option<Transition>) {
        let recovery = self.idle_recovery(inputs, step);
        let rest = self.rest(inputs, validity);
        self.pilot.overruled(Twist::new(rest.v_mps, rest.w_radps));
        (rest, recovery)
    }

    /// A ramp to rest from the last request; zero while the robot's brakes are unknown.
    fn rest(&self, inputs: &Inputs<'_>, validity: Validity) -> Decision {
        let (twist, braking_arc_m) = inputs.robot.map_or((Twist::REST, 0.0), |(robot, _)| {
            let twist = towards_rest(robot, self.last, inputs.period_s);
            (twist, stop_distance_m(robot, twist.v_mps, 0.0))
        });
        Decision {
            v_mps: twist.v_mps,
            w_radps: twist.w_radps,
            validity,
            braking_arc_m,
            turns: false,
            rollouts: 0,
            blocked_arc_m: None,
            against: None,
            cause: RequestCause::None,
            limit_mps: 0.0,
        }
    }

    fn ask(
        &mut self,
        inputs: &Inputs<'_>,
        route: Option<Route<'_>>,
        step: TaskStep,
        decision: &Decision,
    ) -> Option<PlanRequest> {
        let (route, (robot, _)) = route.zip(inputs.robot)?;
        self.requests.step(&RequestInputs {
            run_ns: inputs.run_ns,
            geometry: route.geometry,
            blocked_arc_m: decision.blocked_arc_m,
            stop_distance_m: stop_distance_m(robot, decision.v_mps, self.config.dwa.reaction_s),
            blocked: decision.validity == Validity::Blocked,
            cross_track_m: route.place.cross_track_m,
            no_progress: step.no_progress,
            wanted: self.behaviour() == Behaviour::AskForPath,
        })
    }
}
