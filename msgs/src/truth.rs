//! `sim/ground_truth`: what is really so. It goes to launch alone, never to a service.

use crate::message;
use crate::message::{COORDINATE_M_MAX, Refusal, SPEED_MAX, ZeroCopySend, ensure, number};
use crate::pose::Pose;

/// Most scripted obstacles of a world.
pub const TRUTH_OBSTACLES_MAX: usize = 256;

message! {
    /// Fixed fields of the truth at one tick. The slice holds the scripted obstacles that exist.
    pub struct Truth = "zeronav.Truth.v1" {
        /// True `map_from_base`.
        pub pose: Pose,
        /// [m/s] true forward speed.
        pub v_mps: f64,
        /// [rad/s] true yaw rate.
        pub w_radps: f64,
        /// [m] from the footprint to the nearest thing; 0 in contact; capped at 1000.
        pub clearance_m: f64,
        /// [m] driven since the start.
        pub driven_m: f64,
        /// 1 while the footprint touches something.
        pub in_contact: u32,
        /// Contacts that began while the robot moved faster than 0.05 m/s.
        pub contacts_moving: u32,
        /// Contacts that began while it stood.
        pub contacts_standing: u32,
        /// Obstacles in the slice.
        pub n_obstacles: u32,
        /// Id of the scan of this tick, 0 = none.
        pub scan: u64,
        /// [ns] run time lost because the simulator was late.
        pub slipped_ns: u64,
    }
}

message! {
    /// Truth about one scripted obstacle.
    pub struct TruthObstacle = "zeronav.TruthObstacle.v1" {
        /// Place in the scenario's list, from 0.
        pub index: u32,
        /// Beams of this tick's scan that ended on it.
        pub beams: u32,
        /// [ns] run time at which it was due to appear.
        pub appeared_run_ns: u64,
        /// [ns] `CLOCK_MONOTONIC` of that moment.
        pub appeared_ns: u64,
        /// Where it is, `map` frame.
        pub pose: Pose,
    }
}

impl Truth {
    /// Accepts finite truth.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self, obstacles: &[TruthObstacle]) -> Result<(), Refusal> {
        ensure(
            obstacles.len() == self.n_obstacles as usize && obstacles.len() <= TRUTH_OBSTACLES_MAX,
            Refusal::Length("obstacles"),
        )?;
        self.pose.check("pose")?;
        number(self.v_mps, -SPEED_MAX, SPEED_MAX, "v_mps")?;
        number(self.w_radps, -SPEED_MAX, SPEED_MAX, "w_radps")?;
        number(self.clearance_m, 0.0, 1000.0, "clearance_m")?;
        number(self.driven_m, 0.0, COORDINATE_M_MAX, "driven_m")?;
        ensure(self.in_contact <= 1, Refusal::Code("in_contact"))?;
        for obstacle in obstacles {
            ensure(
                (obstacle.index as usize) < TRUTH_OBSTACLES_MAX,
                Refusal::OutOfRange("index"),
            )?;
            obstacle.pose.check("obstacle.pose")?;
        }
        Ok(())
    }
}
