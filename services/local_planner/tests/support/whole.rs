//! The whole local planner where a closed loop expects a controller.

use super::Drive;
use zeronav_local_planner::recovery::Transition;
use zeronav_local_planner::situation::{Decision, Future, Situation};
use zeronav_local_planner::staleness::Ages;
use zeronav_local_planner::{Inputs, LocalPlanner, LocalPlannerConfig, PathInput};
use zeronav_motion::{InFlight, Twist};
use zeronav_msgs::Pose;
use zeronav_msgs::certainty::PoseCertainty;
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::path::{Path, PathStatus};
use zeronav_msgs::request::PlanRequest;
use zeronav_msgs::task::{Task, TaskKind, TaskState};

/// A whole local planner in the place of a controller; the map's frame is the odometry's.
pub(crate) struct Whole {
    pub(crate) planner: LocalPlanner,
    tick: u64,
    in_flight: InFlight,
    pub(crate) changes: Vec<Transition>,
    pub(crate) asked: Vec<PlanRequest>,
}

impl Whole {
    pub(crate) fn new(config: &LocalPlannerConfig) -> Self {
        Self {
            planner: LocalPlanner::new(config).expect("a usable configuration"),
            tick: 0,
            in_flight: InFlight::default(),
            changes: Vec::new(),
            asked: Vec::new(),
        }
    }

    pub(crate) fn with(controller: &str) -> Self {
        let mut config = LocalPlannerConfig {
            controller: controller.to_owned(),
            ..LocalPlannerConfig::default()
        };
        config.mppi.samples = 240;
        Self::new(&config)
    }

    pub(crate) fn state(&self) -> Option<TaskState> {
        self.planner.status().0.state()
    }
}

impl Drive for Whole {
    fn decide(&mut self, situation: &Situation<'_>) -> Decision {
        self.tick += 1;
        let task = Task {
            kind: TaskKind::Go.code(),
            n_goals: 1,
            ..Task::default()
        };
        self.planner.accept_task(1, &task, &[*situation.goal]);
        let odometry = Odometry {
            pose: situation.map_from_base,
            v_mps: situation.v_mps,
            w_radps: situation.w_radps,
            ..Odometry::default()
        };
        let fields = Path {
            status: PathStatus::Found.code(),
            n_waypoints: u32::try_from(situation.path.len()).unwrap_or(0),
            geometry: situation.path_geometry,
            goal: situation.goal.id,
            ..Path::default()
        };
        let young = Some(1_000_000);
        let outputs = self.planner.step(&Inputs {
            tick: self.tick,
            run_ns: self.tick * 20_000_000,
            period_s: situation.period_s,
            robot: Some((situation.robot, situation.corners)),
            odometry: Some(&odometry),
            map: situation.map.map(|map| (Pose::default(), map)),
            certainty: PoseCertainty::Confirmed,
            map_cells: situation.map_cells,
            obstacles: (situation.obstacles, situation.obstacles_age_s),
            future: Future::default(),
            path: Some(PathInput {
                path: &fields,
                waypoints: situation.path,
            }),
            scan_points_in_base: situation.scan_points_in_base,
            in_flight: &self.in_flight,
            zones: None,
            ages: Ages {
                scan_ns: young,
                odometry_ns: young,
                map_ns: young,
                obstacles_ns: young,
                path_ns: young,
            },
            stopping: false,
        });
        let command = Twist::new(outputs.request.v_mps, outputs.request.w_radps);
        self.in_flight.send(self.tick * 20_000_000, command);
        self.changes.extend(outputs.recovery);
        self.asked.extend(outputs.plan_request);
        Decision {
            v_mps: outputs.request.v_mps,
            w_radps: outputs.request.w_radps,
            validity: outputs.request.validity().expect("a known code"),
            braking_arc_m: outputs.request.braking_arc_m,
            turns: false,
            rollouts: outputs.rollouts,
            blocked_arc_m: outputs.blocked_arc_m,
            against: None,
            cause: outputs.request.cause().expect("a known code"),
            limit_mps: outputs.request.limit_mps,
        }
    }
}
