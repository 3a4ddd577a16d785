//! Closed loops: a robot that obeys within its accelerations, a lidar, and what they went through.

#![allow(dead_code, reason = "every test file uses its part of this one")]

pub(crate) mod cart;
pub(crate) mod whole;
mod world;

use nalgebra::{Point2, Vector2};
use zeronav_casts::Cast;
use zeronav_local_planner::pilot::Pilot;
use zeronav_local_planner::situation::{Decision, Future, Situation};
use zeronav_motion::{Twist, reachable, stop_distance_m};
use zeronav_msgs::Pose;
use zeronav_msgs::command::Validity;
use zeronav_msgs::description::{Corner, Description};
use zeronav_msgs::obstacles::Obstacle;
use zeronav_msgs::path::Waypoint;
use zeronav_msgs::task::Goal;

pub(crate) use world::{Block, Map, block};

/// Control period. [s]
pub(crate) const PERIOD_S: f64 = 0.02;

/// A disc robot.
pub(crate) fn disc(
    radius_m: f64,
    v_mps: f64,
    a_mps2: f64,
    w_radps: f64,
    alpha_radps2: f64,
) -> Robot {
    Robot {
        description: Description {
            inscribed_radius_m: radius_m,
            circumscribed_radius_m: radius_m,
            v_mps_max: v_mps,
            w_radps_max: w_radps,
            a_mps2_max: a_mps2,
            brake_mps2: a_mps2,
            alpha_radps2_max: alpha_radps2,
            ..Description::default()
        },
        corners: Vec::new(),
    }
}

/// The Clearpath Jackal's outline.
pub(crate) fn jackal() -> Robot {
    let corner = |(x_m, y_m)| Corner { x_m, y_m };
    Robot {
        description: Description {
            inscribed_radius_m: 0.215,
            circumscribed_radius_m: 0.254_f64.hypot(0.215),
            v_mps_max: 1.0,
            v_mps_min: -0.3,
            w_radps_max: 2.0,
            a_mps2_max: 1.5,
            brake_mps2: 2.0,
            alpha_radps2_max: 4.0,
            n_corners: 4,
            ..Description::default()
        },
        corners: [
            (0.254, 0.215),
            (-0.254, 0.215),
            (-0.254, -0.215),
            (0.254, -0.215),
        ]
        .map(corner)
        .to_vec(),
    }
}

#[derive(Debug, Clone)]
pub(crate) struct Robot {
    pub(crate) description: Description,
    pub(crate) corners: Vec<Corner>,
}

impl Robot {
    /// Points on the outline in `base`, 5 mm apart; for a disc none.
    fn outline(&self) -> Vec<Point2<f64>> {
        let n = self.corners.len();
        let at = |i: usize| Point2::new(self.corners[i % n].x_m, self.corners[i % n].y_m);
        (0..n)
            .flat_map(|i| {
                let (a, b) = (at(i), at(i + 1));
                let steps = ((b - a).norm() / 0.005).ceil().to_u32();
                (0..steps).map(move |k| a + (b - a) * (f64::from(k) / f64::from(steps)))
            })
            .collect()
    }
}

/// A path from its corners.
pub(crate) fn path(corners: &[(f64, f64)]) -> Vec<Waypoint> {
    let mut waypoints: Vec<Waypoint> = corners
        .iter()
        .map(|&(x_m, y_m)| Waypoint {
            x_m,
            y_m,
            ..Waypoint::default()
        })
        .collect();
    for i in 1..waypoints.len() {
        let (a, b) = (waypoints[i - 1], waypoints[i]);
        waypoints[i - 1].yaw_rad = (b.y_m - a.y_m).atan2(b.x_m - a.x_m).to_f32();
    }
    waypoints
}

/// A goal at the end of `path`.
pub(crate) fn goal_at(
    path: &[Waypoint],
    tolerance_m: f64,
    yaw_rad: f64,
    yaw_tolerance_rad: f64,
) -> Goal {
    let end = path.last().expect("a path");
    Goal {
        pose: Pose::new(end.x_m, end.y_m, yaw_rad),
        tolerance_m,
        yaw_tolerance_rad,
        id: 1,
    }
}

/// What a closed loop drives: a pilot, or the whole local planner.
pub(crate) trait Drive {
    fn decide(&mut self, situation: &Situation<'_>) -> Decision;
}

impl Drive for Pilot {
    fn decide(&mut self, situation: &Situation<'_>) -> Decision {
        self.decide(situation)
    }
}

/// One closed loop.
pub(crate) struct Loop {
    pub(crate) robot: Robot,
    /// What is really there.
    pub(crate) blocks: Vec<Block>,
    /// What the map knows.
    pub(crate) map: Map,
    pub(crate) pose: Pose,
    pub(crate) twist: Twist,
    pub(crate) path: Vec<Waypoint>,
    pub(crate) geometry: u64,
    pub(crate) goal: Goal,
    /// [s]
    pub(crate) time_s: f64,
    /// [m] least distance between the outline and any block so far.
    pub(crate) least_m: f64,
    /// [m] driven.
    pub(crate) driven_m: f64,
    /// Commands so far.
    pub(crate) history: Vec<Decision>,
    /// Tracked obstacles, as the controller is told of them.
    pub(crate) obstacles: Vec<Obstacle>,
    /// Periods between a decision and its effect.
    pub(crate) delay: usize,
    outline: Vec<Point2<f64>>,
}

impl Loop {
    pub(crate) fn new(
        robot: Robot,
        blocks: &[Block],
        size: (f64, f64),
        pose: Pose,
        path: Vec<Waypoint>,
    ) -> Self {
        let map = Map::of(blocks, size.0, size.1, robot.description.inscribed_radius_m);
        let goal = goal_at(&path, 0.15, 0.0, 4.0);
        Self {
            outline: robot.outline(),
            robot,
            blocks: blocks.to_vec(),
            map,
            pose,
            twist: Twist::REST,
            path,
            geometry: 1,
            goal,
            time_s: 0.0,
            least_m: f64::INFINITY,
            driven_m: 0.0,
            history: Vec::new(),
            obstacles: Vec::new(),
            delay: 0,
        }
    }

    /// Another path.
    pub(crate) fn replan(&mut self, path: Vec<Waypoint>) {
        self.path = path;
        self.geometry += 1;
        self.goal = goal_at(&self.path, 0.15, 0.0, 4.0);
    }

    /// Hits of a 360-beam lidar at the centre, in `base`.
    pub(crate) fn scan(&self) -> Vec<Point2<f64>> {
        let from = self.pose.point();
        (0..360)
            .filter_map(|i| {
                let angle = f64::from(i).to_radians();
                let (sin, cos) = (self.pose.yaw_rad + angle).sin_cos();
                let range = self
                    .blocks
                    .iter()
                    .filter_map(|block| block.range_m(from, Vector2::new(cos, sin)))
                    .fold(f64::INFINITY, f64::min);
                (range < 10.0).then(|| Point2::new(range * angle.cos(), range * angle.sin()))
            })
            .collect()
    }

    /// Distance between the outline and the blocks; <= 0 is contact. [m]
    pub(crate) fn distance_m(&self, pose: &Pose) -> f64 {
        let centre = self
            .blocks
            .iter()
            .map(|block| block.distance_m(pose.point()))
            .fold(f64::INFINITY, f64::min);
        if self.outline.is_empty() {
            return centre - self.robot.description.circumscribed_radius_m;
        }
        if centre > self.robot.description.circumscribed_radius_m + 0.3 {
            return centre - self.robot.description.circumscribed_radius_m;
        }
        let points = self.outline.iter().map(|point| {
            let at = pose.transform(*point);
            let distances = self.blocks.iter().map(|block| block.distance_m(at));
            distances.fold(f64::INFINITY, f64::min)
        });
        points.fold(f64::INFINITY, f64::min)
    }

    /// What the robot knows when its scan hits `scan`.
    pub(crate) fn situation<'a>(&'a self, scan: &'a [Point2<f64>]) -> Situation<'a> {
        Situation {
            map_from_base: self.pose,
            v_mps: self.twist.v_mps,
            w_radps: self.twist.w_radps,
            robot: &self.robot.description,
            corners: &self.robot.corners,
            path: &self.path,
            path_geometry: self.geometry,
            map: Some(self.map.view()),
            map_cells: 1,
            obstacles: &self.obstacles,
            obstacles_age_s: 0.0,
            future: Future::default(),
            scan_points_in_base: scan,
            past_hits_in_base: &[],
            goal: &self.goal,
            speed_factor: 1.0,
            zone_mps: f64::INFINITY,
            period_s: PERIOD_S,
            ahead_s: 0.0,
        }
    }

    /// One control period.
    pub(crate) fn step(&mut self, controller: &mut dyn Drive) -> Decision {
        let scan = self.scan();
        let decision = controller.decide(&self.situation(&scan));
        self.history.push(decision);
        let applied = self
            .history
            .len()
            .checked_sub(1 + self.delay)
            .map_or(Twist::REST, |i| {
                Twist::new(self.history[i].v_mps, self.history[i].w_radps)
            });
        let next = reachable(&self.robot.description, self.twist, applied, PERIOD_S);
        let mean = Twist::new(
            0.5 * (self.twist.v_mps + next.v_mps),
            0.5 * (self.twist.w_radps + next.w_radps),
        );
        let moved = mean.arc(PERIOD_S);
        let at = self.pose.transform(Point2::new(moved.x_m, moved.y_m));
        self.pose = Pose::new(at.x, at.y, self.pose.yaw_rad + moved.yaw_rad);
        self.twist = next;
        self.driven_m += mean.v_mps.abs() * PERIOD_S;
        self.time_s += PERIOD_S;
        self.least_m = self.least_m.min(self.distance_m(&self.pose));
        decision
    }

    /// Runs until the robot says it is at the goal; false when it does not within `limit_s`.
    pub(crate) fn run(&mut self, controller: &mut dyn Drive, limit_s: f64) -> bool {
        let end_s = self.time_s + limit_s;
        while self.time_s < end_s {
            if self.step(controller).validity == Validity::AtGoal && self.twist.is_stopped() {
                return true;
            }
        }
        false
    }

    /// Changes of direction of the yaw rate per metre, small ones not counted.
    pub(crate) fn weaving_per_m(&self) -> f64 {
        let mut last = 0.0_f64;
        let mut changes = 0.0;
        for decision in &self.history {
            if decision.w_radps.abs() > 0.05 {
                changes += f64::from(u8::from(last * decision.w_radps < 0.0));
                last = decision.w_radps;
            }
        }
        changes / self.driven_m.max(0.1)
    }

    /// Every command is a number within the limits, follows the one before within the
    /// accelerations, and leaves room to brake in the real world along its arc.
    pub(crate) fn check_command(&self, before: Twist, pose: &Pose, decision: &Decision) {
        let robot = &self.robot.description;
        let (v, w) = (decision.v_mps, decision.w_radps);
        assert!(v.is_finite() && w.is_finite());
        assert!(v >= robot.v_mps_min - 1e-9 && v <= robot.v_mps_max + 1e-9);
        assert!(w.abs() <= robot.w_radps_max + 1e-9);
        let rate = robot.a_mps2_max.max(robot.brake_mps2) * PERIOD_S + 1e-9;
        assert!((v - before.v_mps).abs() <= rate, "{v} after {before:?}");
        let rate = robot.alpha_radps2_max * PERIOD_S + 1e-9;
        assert!((w - before.w_radps).abs() <= rate, "{w} after {before:?}");
        // Braking along the arc ends before contact.
        let stop_m = stop_distance_m(robot, v, 0.0);
        let steps = 40;
        if v.abs() > 0.05 {
            for step in 0..=steps {
                let share = stop_m * f64::from(step) / f64::from(steps);
                let moved = Twist::new(v, w).arc(share / v.abs());
                let at = pose.transform(Point2::new(moved.x_m, moved.y_m));
                let there = Pose::new(at.x, at.y, pose.yaw_rad + moved.yaw_rad);
                assert!(
                    self.distance_m(&there) > 0.0,
                    "no room to brake from {v}, {w}"
                );
            }
        }
    }
}
