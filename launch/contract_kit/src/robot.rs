//! The robot of the tests: a disc with a differential drive and a lidar.

use super::room::{ROBOT_RADIUS_M, Room, START};
use zeronav_casts::Cast;
use zeronav_msgs::description::Description;
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::pose::{Pose, wrap_angle};
use zeronav_msgs::scan::Scan;

/// Run time of a tick. [ns]
pub(crate) const TICK_NS: u64 = 20_000_000;

/// Ticks from scan to scan.
pub(crate) const SCAN_TICKS: u64 = 5;

const TICK_S: f64 = 0.02;
const BEAMS: u16 = 180;
const STEP_RAD: f64 = core::f64::consts::TAU / BEAMS as f64;
const RANGE_M_MAX: f64 = 12.0;

/// Fastest speed and yaw rate, and what they can change by. [m/s], [rad/s], [m/s^2], [rad/s^2]
const V_MPS_MAX: f64 = 1.0;
const W_RADPS_MAX: f64 = 2.0;
const A_MPS2_MAX: f64 = 1.0;
const ALPHA_RADPS2_MAX: f64 = 4.0;

/// What the robot says of itself.
pub(crate) fn description() -> Description {
    Description {
        inscribed_radius_m: ROBOT_RADIUS_M,
        circumscribed_radius_m: ROBOT_RADIUS_M,
        v_mps_max: V_MPS_MAX,
        v_mps_min: -0.5,
        w_radps_max: W_RADPS_MAX,
        a_mps2_max: A_MPS2_MAX,
        brake_mps2: A_MPS2_MAX,
        alpha_radps2_max: ALPHA_RADPS2_MAX,
        angle_increment_rad: STEP_RAD,
        range_m_min: 0.05,
        range_m_max: RANGE_M_MAX,
        scan_period_ns: SCAN_TICKS * TICK_NS,
        n_beams: u32::from(BEAMS),
        ..Description::default()
    }
}

/// True when a scan belongs to `tick`.
pub(crate) fn scan_due(tick: u64) -> bool {
    tick % SCAN_TICKS == 1
}

/// The robot as it moves. Its odometry has no error: `map_from_odom` is the identity.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Robot {
    /// `map_from_base`.
    pub pose: Pose,
    /// Forward speed. [m/s]
    pub v_mps: f64,
    /// Yaw rate. [rad/s]
    pub w_radps: f64,
    /// Smallest distance to an obstacle so far. [m]
    pub closest_m: f64,
}

impl Robot {
    /// A robot that stands at the start.
    pub(crate) fn new() -> Self {
        Self {
            pose: START,
            v_mps: 0.0,
            w_radps: 0.0,
            closest_m: f64::INFINITY,
        }
    }

    /// Drives for one tick with what is commanded, as far as its wheels can.
    pub(crate) fn step(&mut self, v_mps: f64, w_radps: f64, room: Room) {
        let toward = |now: f64, to: f64, most: f64, rate: f64| {
            let to = if to.is_finite() {
                to.clamp(-most, most)
            } else {
                0.0
            };
            now + (to - now).clamp(-rate * TICK_S, rate * TICK_S)
        };
        self.v_mps = toward(self.v_mps, v_mps, V_MPS_MAX, A_MPS2_MAX);
        self.w_radps = toward(self.w_radps, w_radps, W_RADPS_MAX, ALPHA_RADPS2_MAX);
        let heading = self.pose.yaw_rad + 0.5 * self.w_radps * TICK_S;
        self.pose = Pose::new(
            self.pose.x_m + self.v_mps * TICK_S * heading.cos(),
            self.pose.y_m + self.v_mps * TICK_S * heading.sin(),
            wrap_angle(self.pose.yaw_rad + self.w_radps * TICK_S),
        );
        self.closest_m = (self.closest_m).min(room.distance_m(self.pose.point()) - ROBOT_RADIUS_M);
    }

    /// What its wheels say at `tick`.
    pub(crate) fn odometry(&self, tick: u64) -> Odometry {
        Odometry {
            pose: self.pose,
            v_mps: self.v_mps,
            w_radps: self.w_radps,
            variance: [1.0e-6; 3],
            scan_due: u32::from(scan_due(tick)),
            spare: 0,
        }
    }

    /// One turn of its lidar.
    pub(crate) fn scan(&self, room: Room) -> (Scan, Vec<f32>) {
        let ranges = (0..BEAMS).map(|beam| {
            let angle_rad = self.pose.yaw_rad + f64::from(beam) * STEP_RAD;
            let range_m = room.range_m(self.pose.point(), angle_rad);
            if range_m > RANGE_M_MAX {
                f32::INFINITY
            } else {
                range_m.to_f32()
            }
        });
        let scan = Scan {
            n_beams: u32::from(BEAMS),
            angle_increment_rad: STEP_RAD.to_f32(),
            range_m_min: 0.05,
            range_m_max: RANGE_M_MAX.to_f32(),
            ..Scan::default()
        };
        (scan, ranges.collect())
    }

    /// Speed and yaw rate of a pursuit of the polyline `way_m`: what the kit's own local planner asks.
    pub(crate) fn pursue(&self, way_m: &[[f64; 2]]) -> (f64, f64) {
        let ahead = |point: &&[f64; 2]| {
            let [dx, dy] = [point[0] - self.pose.x_m, point[1] - self.pose.y_m];
            dx * self.pose.yaw_rad.cos() + dy * self.pose.yaw_rad.sin() > 0.15 || dx.hypot(dy) > 0.6
        };
        let Some(to) = way_m.iter().find(ahead) else {
            return (0.0, 0.0);
        };
        let [dx, dy] = [to[0] - self.pose.x_m, to[1] - self.pose.y_m];
        if dx.hypot(dy) < 0.15 {
            return (0.0, 0.0);
        }
        let error = wrap_angle(dy.atan2(dx) - self.pose.yaw_rad);
        let v_mps = if error.abs() > 0.6 { 0.1 } else { 0.7 };
        (v_mps, (2.0 * error).clamp(-W_RADPS_MAX, W_RADPS_MAX))
    }
}
