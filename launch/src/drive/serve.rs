//! What a run answers on its control socket.

use super::session::Session;
use crate::supervise::control::{Reply, Request, RunReport, Server, ServiceReport};
use crate::supervise::occupant::file_name;
use crate::supervise::stack::Stack;
use nalgebra::Point2;
use std::collections::BTreeMap;
use zeronav_msgs::Pose;
use zeronav_msgs::role::Role;
use zeronav_msgs::task::Goal;
use zeronav_msgs::time::seconds;
use zeronav_world::Tolerance;

impl Session<'_> {
    /// Answers the clients that have asked since the last look.
    pub(super) fn serve(&mut self, stack: &mut Stack, server: &mut Server) {
        server.serve(|request| match request {
            Request::Ps => Reply::Run(self.run_report(stack)),
            Request::Goal {
                pose: [x, y, yaw],
                tolerance_m,
                yaw_tolerance_rad,
            } => {
                let goal = Goal {
                    pose: Pose::new(x, y, yaw),
                    tolerance_m,
                    yaw_tolerance_rad,
                    id: 0,
                };
                match self.redirect(stack, goal) {
                    Ok(()) => Reply::Done,
                    Err(why) => Reply::Error(why),
                }
            }
        });
    }

    /// Sends the robot to a goal given by hand, or says why it cannot go there.
    fn redirect(&mut self, stack: &mut Stack, goal: Goal) -> Result<(), String> {
        let Goal {
            pose,
            tolerance_m,
            yaw_tolerance_rad,
            ..
        } = goal;
        let numbers = [pose.x_m, pose.y_m, pose.yaw_rad];
        let tolerances = [tolerance_m, yaw_tolerance_rad];
        let usable = numbers.iter().all(|value| value.is_finite())
            && (tolerances.iter()).all(|value| (1.0e-3..=1.0e3).contains(value));
        if !usable {
            return Err("a goal needs finite numbers and tolerances of 0.001 to 1000".to_owned());
        }
        if self.shuttle.is_some() {
            return Err("the run makes trials and takes no other goal".to_owned());
        }
        let at = format!("({}, {})", pose.x_m, pose.y_m);
        let world = &self.prepared.world;
        if !world.contains(Point2::new(pose.x_m, pose.y_m)) {
            return Err(format!("{at} is not on the map"));
        }
        let tolerance = Tolerance {
            distance_m: tolerance_m,
            yaw_rad: yaw_tolerance_rad,
        };
        let footprint = &self.prepared.footprint;
        if world.free_pose_near(footprint, &pose, tolerance).is_none() {
            return Err(format!(
                "the robot finds no room within {tolerance_m} m of {at}; the run goes on as before"
            ));
        }
        let from_tick = stack.roster.control.lease + 1;
        let left = self.left();
        let time_s = seconds(self.collector.run_ns.saturating_sub(self.goals_run_ns));
        self.redirects.give(time_s, &goal, left);
        self.send(stack, vec![goal], from_tick);
        Ok(())
    }

    fn run_report(&self, stack: &mut Stack) -> RunReport {
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
                }
            })
            .collect();
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
            });
        }
        RunReport {
            scenario: self.prepared.scenario.name.clone(),
            domain: stack.root().display().to_string(),
            folder: std::path::absolute(&self.prepared.directory).unwrap_or_default(),
            pid: std::process::id(),
            mode: self.prepared.mode.to_string(),
            time_s: seconds(self.collector.run_ns),
            task: self
                .report()
                .map_or_else(|| "waiting".to_owned(), |report| report.state.to_string()),
            services,
        }
    }
}
