//! What a run answers on its control socket.

use super::reach::{Reach, may_have_room};
use super::session::Session;
use crate::control::request::{GoalReport, Reply, Request, RunReport, ServiceReport};
use crate::orders::Order;
use crate::why::{self, Now};
use nalgebra::Point2;
use std::collections::BTreeMap;
use zeronav_casts::Cast;
use zeronav_measure::result::moment::Moment;
use zeronav_msgs::Pose;
use zeronav_msgs::role::Role;
use zeronav_msgs::task::GOALS_MAX;
use zeronav_msgs::time::{nanoseconds, seconds};
use zeronav_scenario::zones;
use zeronav_scenario::{GoalSpec, TIME_LIMIT_S_MAX, TOLERANCE};
use zeronav_supervise::occupant::file_name;
use zeronav_supervise::stack::Stack;

/// Room around the robot at a pose that is offered in place of one that cannot be. [m]
const OFFERED_CLEARANCE_M: f64 = 0.1;

/// How far the yaw of a pose that is offered in place of an estimate may be off. [rad]
const ESTIMATE_YAW_RAD: f64 = 0.25;

/// Slower than this the time that is left cannot be told. [m/s]
const MOVING_MPS: f64 = 0.02;

/// Entries that a list in a report has at most, so that it stays one short line.
pub(super) const LISTED_MAX: usize = 16;

/// The last ones of a list.
fn newest<T: Clone>(all: &[T]) -> Vec<T> {
    all[all.len().saturating_sub(LISTED_MAX)..].to_vec()
}

/// What a client does that the scenario does not know of; `None` when the run goes on as it would.
fn interference(request: &Request) -> Option<&'static str> {
    match request {
        Request::Ps
        | Request::GoalStatus { .. }
        | Request::SwapStatus { .. }
        | Request::Why { .. }
        | Request::Zones
        | Request::Pause
        | Request::Resume
        | Request::Step { .. }
        | Request::Speed { .. }
        // Says so by itself.
        | Request::Down => None,
        Request::Goal { .. } | Request::Cancel { .. } => Some("goals were given or cancelled by hand"),
        Request::Pose { .. } => Some("a pose was given by hand"),
        Request::Obstacle { .. } => Some("obstacles were changed by hand"),
        Request::ZoneAdd { .. } | Request::ZoneRemove { .. } => Some("zones were changed by hand"),
        Request::Fault { .. } | Request::Heal { .. } => Some("faults were made or ended by hand"),
        Request::Swap { .. } | Request::SwapCancel => Some("services were swapped by hand"),
    }
}

impl Session<'_> {
    /// Answers the clients that have asked since the last look.
    pub(super) fn serve(&mut self, stack: &mut Stack) {
        let Some(mut server) = self.clients.server.take() else {
            return;
        };
        server.serve(|request| self.answer(stack, request).unwrap_or_else(Reply::Error));
        self.clients.server = Some(server);
    }

    fn answer(&mut self, stack: &mut Stack, request: Request) -> Result<Reply, String> {
        let is_question = matches!(
            request,
            Request::Ps
                | Request::GoalStatus { .. }
                | Request::SwapStatus { .. }
                | Request::Why { .. }
                | Request::Zones
        );
        if self.phase.is_ending() && !is_question {
            return Err("the stack is ending".to_owned());
        }
        let interference = interference(&request);
        let reply = self.carry_out(stack, request)?;
        self.clients.interferences.extend(interference);
        Ok(reply)
    }

    fn carry_out(&mut self, stack: &mut Stack, request: Request) -> Result<Reply, String> {
        match request {
            Request::Ps => return Ok(Reply::Run(Box::new(self.run_report(stack)))),
            Request::Goal {
                goals,
                repeats,
                time_limit_s,
                now,
            } => {
                let order = self.order(&goals, repeats, time_limit_s)?;
                let id = self.take_order(stack, order, now)?;
                return self.goal_report(id).map(Reply::Goal);
            }
            Request::GoalStatus { id } => return self.goal_report(id).map(Reply::Goal),
            Request::Why { ago_s } => return self.moment(ago_s).map(Reply::Why),
            Request::Zones => return Ok(Reply::Zones(self.zones.specs())),
            Request::ZoneAdd { zone } => self.add_zone(stack, zone)?,
            Request::ZoneRemove { name } => self.remove_zone(stack, &name)?,
            Request::Cancel { id } => self.cancel(stack, id)?,
            Request::Pause => self.pause(stack)?,
            Request::Resume => self.resume(stack)?,
            Request::Step { ticks } => self.step(ticks)?,
            Request::Speed { factor } => self.set_speed(stack, factor)?,
            Request::Pose { pose } => self.relocate(stack, pose)?,
            Request::Obstacle { name, change } => self.place(stack, &name, &change)?,
            Request::Fault { fault } => self.order_fault(stack, &fault)?,
            Request::Heal { target } => self.heal(stack, target.as_deref())?,
            Request::Swap { order } => {
                if self.trial_runner.is_some() {
                    return Err("the run measures latencies; a swap would change them".to_owned());
                }
                let lease = stack.roster.control.lease;
                let result = self.begin_swap(stack, order, lease)?;
                return Ok(Reply::Swap(Box::new(result)));
            }
            Request::SwapStatus { id } => {
                let result = self.swaps.result(id).cloned();
                let result =
                    result.ok_or("no such swap is known; the newest 100 are remembered")?;
                return Ok(Reply::Swap(Box::new(result)));
            }
            Request::SwapCancel => self.cancel_swap(stack)?,
            Request::Down => self.clients.asked_for_end = true,
        }
        Ok(Reply::Done)
    }

    /// What the stages said so long ago. [s]
    fn moment(&self, ago_s: f64) -> Result<Box<Moment>, String> {
        let at_s = seconds(self.collector.run_ns) - ago_s;
        let moment = self.collector.reasons.at(nanoseconds(at_s));
        let none = || format!("no history for {ago_s} s ago, the run time {at_s:.2} s");
        moment.map(Box::new).ok_or_else(none)
    }

    /// The order of a client, or why the robot cannot carry it out.
    fn order(
        &self,
        goals: &[GoalSpec],
        repeats: bool,
        time_limit_s: Option<f64>,
    ) -> Result<Order, String> {
        if self.trial_runner.is_some() {
            return Err("the run makes trials and takes no other goal".to_owned());
        }
        if goals.is_empty() || goals.len() > GOALS_MAX {
            return Err(format!("1 to {GOALS_MAX} goals, not {}", goals.len()));
        }
        let usable = |limit: &f64| *limit > 0.0 && *limit <= TIME_LIMIT_S_MAX;
        if let Some(limit) = time_limit_s.filter(|limit| !usable(limit)) {
            return Err(format!(
                "a time limit is above 0 and at most {TIME_LIMIT_S_MAX} s, not {limit}"
            ));
        }
        for goal in goals {
            self.check_goal(goal)?;
        }
        let time_limit_ns = time_limit_s.map(|limit_s| (limit_s * 1.0e9).to_u64());
        Ok(Order {
            goals: goals.iter().map(|goal| goal.message(0)).collect(),
            repeats,
            time_limit_ns,
        })
    }

    fn check_goal(&self, goal: &GoalSpec) -> Result<(), String> {
        let GoalSpec {
            pose, tolerance_m, ..
        } = goal;
        let numbers = [pose.x_m, pose.y_m, pose.yaw_rad];
        let tolerances = [*tolerance_m, goal.yaw_tolerance_rad];
        let [least, most] = TOLERANCE;
        let usable = numbers.iter().all(|value| value.is_finite())
            && (tolerances.iter()).all(|value| (least..=most).contains(value));
        if !usable {
            return Err("a goal needs finite numbers and tolerances of 0.001 to 1000".to_owned());
        }
        let at = format!("({}, {})", pose.x_m, pose.y_m);
        let (world, footprint) = (&self.prepared.world, &self.prepared.footprint);
        let set = &self.collector.zones;
        let map = self.collector.replica.view();
        let has_room = || {
            let in_world = world.free_pose_near(footprint, pose, goal.tolerance());
            let on_map = |map| may_have_room(&map, pose.point(), *tolerance_m);
            in_world.is_some() && map.is_none_or(on_map)
        };
        let why = if !world.contains(pose.point()) {
            format!("{at} is not on the map")
        } else if let Some(why) = zones::keeps_out(set, footprint, pose, *tolerance_m) {
            why
        } else if !has_room() {
            format!("the robot finds no room within {tolerance_m} m of {at}")
        } else {
            return Ok(());
        };
        let robot = self.collector.estimate();
        let is_outside = |at| zones::is_outside(set, footprint, at);
        let yaw_rad = goal.yaw_tolerance_rad;
        let hint = match map.zip(robot) {
            Some((map, robot)) => {
                let reach = Reach::from(&map, robot.point(), set);
                self.nearest(pose, yaw_rad, |at| reach.contains(at) && is_outside(at))
            }
            None if set.keepout_at(pose.point()).is_some() => {
                self.nearest(pose, yaw_rad, is_outside)
            }
            None => "where it can drive to is not known before its first map".to_owned(),
        };
        Err(format!("{why}; {hint}; the robot goes on as before"))
    }

    /// Accepts a pose where the robot can be.
    pub(super) fn check_pose(&self, pose: &Pose) -> Result<(), String> {
        pose.check("pose").map_err(|error| error.to_string())?;
        let at = format!("({}, {})", pose.x_m, pose.y_m);
        let (world, footprint) = (&self.prepared.world, &self.prepared.footprint);
        let why = if !world.contains(pose.point()) {
            format!("{at} is not on the map")
        } else if world.touches(footprint, pose) {
            format!("at {at} the robot would be in an obstacle")
        } else {
            return Ok(());
        };
        Err(format!(
            "{why}; {}; the robot goes on as before",
            self.nearest(pose, ESTIMATE_YAW_RAD, |_| true)
        ))
    }

    /// The accepted free pose that is nearest to one that is not free, in words.
    fn nearest(&self, pose: &Pose, yaw_rad: f64, accepts: impl Fn(Point2<f64>) -> bool) -> String {
        let (world, footprint) = (&self.prepared.world, &self.prepared.footprint);
        let nearest =
            world.nearest_free_pose(footprint, pose, yaw_rad, OFFERED_CLEARANCE_M, accepts);
        nearest.map_or_else(
            || "no free pose that it can drive to is near".to_owned(),
            |pose| {
                let (x_m, y_m, yaw_rad) = (pose.x_m, pose.y_m, pose.yaw_rad);
                format!("the nearest free pose is {x_m:.2} {y_m:.2} {yaw_rad:.2}")
            },
        )
    }

    fn goal_report(&self, id: u64) -> Result<GoalReport, String> {
        let (outcome, took_ns) = (self.orders.outcome(id))
            .ok_or_else(|| format!("no goal {id} is known; the newest 1000 are remembered"))?;
        let began = self.orders.current().filter(|(current, _)| *current == id);
        let report = self.report().filter(|_| began.is_some());
        let distance_remaining_m = report.map(|report| report.remaining_m);
        let odometry = self.collector.odometry;
        let speed_mps = odometry.map_or(0.0, |odometry| odometry.v_mps.abs());
        Ok(GoalReport {
            id,
            outcome: outcome.to_owned(),
            before: self.orders.n_before(id),
            goals_left: began.map_or(0, |_| self.left().len()),
            elapsed_s: seconds(began.map_or(took_ns, |(_, began_run_ns)| {
                self.collector.run_ns.saturating_sub(began_run_ns)
            })),
            distance_remaining_m,
            time_remaining_s: distance_remaining_m
                .filter(|_| speed_mps > MOVING_MPS)
                .map(|distance_m| distance_m / speed_mps),
            recoveries: report.map_or(self.orders.recoveries(id), |report| report.recoveries),
            why: report
                .and_then(|report| why::failure(&report.outcome()))
                .unwrap_or_else(|| self.orders.why(id).to_owned()),
            waits_s: report.map_or(0, |report| report.waits_s),
        })
    }

    /// The process beside one in its seat.
    fn beside_report(&self, stack: &mut Stack) -> Option<ServiceReport> {
        let beside = stack.beside.as_mut()?;
        Some(ServiceReport {
            role: beside.role.to_string(),
            pid: beside.pid(),
            epoch: beside.epoch,
            state: "beside".to_owned(),
            progress: 0,
            memory_peak_bytes: beside.memory_peak_bytes(),
            binary: file_name(&beside.binary),
            restarts: self.restarter.starts(beside.role) - 1,
            host: self.prepared.host_of(beside.role),
        })
    }

    /// The processes in the seats, and one beside them.
    fn service_reports(&self, stack: &mut Stack) -> Vec<ServiceReport> {
        stack.heartbeats();
        let health: BTreeMap<Role, (String, u64)> = stack
            .taps
            .health
            .iter()
            .filter_map(|(role, health)| {
                let beat = health.get()?.meta;
                Some((*role, (beat.state()?.to_string(), beat.progress)))
            })
            .collect();
        let state = |role: Role| {
            let said = health.get(&role).cloned();
            said.unwrap_or_else(|| ("starting".to_owned(), 0))
        };
        let mut services: Vec<ServiceReport> = stack
            .children
            .iter_mut()
            .map(|child| {
                let (state, progress) = state(child.role);
                ServiceReport {
                    role: child.role.to_string(),
                    pid: child.pid(),
                    epoch: child.epoch,
                    state,
                    progress,
                    memory_peak_bytes: child.memory_peak_bytes(),
                    binary: file_name(&child.binary),
                    restarts: self.restarter.starts(child.role) - 1,
                    host: self.prepared.host_of(child.role),
                }
            })
            .collect();
        services.extend(self.beside_report(stack));
        for (role, occupant) in &stack.occupants {
            if self.prepared.binaries.contains_key(role) {
                continue;
            }
            let (state, progress) = state(*role);
            services.push(ServiceReport {
                role: role.to_string(),
                pid: occupant.pid,
                epoch: occupant.epoch,
                state,
                progress,
                memory_peak_bytes: 0,
                binary: occupant.binary.clone(),
                restarts: self.restarter.starts(*role) - 1,
                host: None,
            });
        }
        services
    }

    fn run_report(&self, stack: &mut Stack) -> RunReport {
        let truth = self.collector.truth.as_ref();
        let mut report = RunReport {
            scenario: self.prepared.scenario.name.clone(),
            domain: stack.root().display().to_string(),
            folder: std::path::absolute(&self.prepared.directory).unwrap_or_default(),
            pid: std::process::id(),
            mode: self.prepared.mode.to_string(),
            ready: self.phase.is_ready(),
            paused: self.run_time.is_paused,
            stands: self.stands(stack),
            binaries: self.listed_binaries(),
            speed: self.run_time.speed.factor(),
            time_s: seconds(self.collector.run_ns),
            tick: self.collector.robot_tick(),
            pose: truth.map(|truth| [truth.pose.x_m, truth.pose.y_m, truth.pose.yaw_rad]),
            estimate: (self.collector.estimate()).map(|pose| [pose.x_m, pose.y_m, pose.yaw_rad]),
            contacts: truth.map(|truth| truth.contacts_moving + truth.contacts_standing),
            task: self
                .report()
                .map_or_else(|| "waiting".to_owned(), |report| report.state.to_string()),
            goal: (self.orders.current()).and_then(|(id, _)| self.goal_report(id).ok()),
            goals_waiting: self.orders.n_waiting(),
            swap: self.swaps.result(None).cloned(),
            services: self.service_reports(stack),
            companions: self.companions.reports(),
            restarts: newest(self.restarter.records()),
            faults: newest(&self.faults.results()),
            why: String::new(),
        };
        report.why = self.why(stack, &report);
        report
    }

    /// True when a paused lockstep stack has answered every tick that it may do.
    fn stands(&self, stack: &Stack) -> bool {
        let is_held = self.run_time.is_paused && self.phase.is_ready() && self.lockstep();
        is_held && (self.collector).all_answered(self.run_time.hold_tick, &stack.roster)
    }

    /// Why the robot does what it does; empty before the stages have said anything.
    fn why(&self, stack: &Stack, report: &RunReport) -> String {
        let moment = self.collector.reasons.at(self.collector.run_ns);
        let odometry = self.collector.odometry;
        let now = Now {
            stopping: stack.roster.control.stopping == 1,
            twist: odometry.map(|odometry| [odometry.v_mps, odometry.w_radps]),
            ages_ms: self.collector.reasons.ages_ms(),
        };
        moment.map_or_else(String::new, |moment| why::line(moment, &now, report))
    }
}
