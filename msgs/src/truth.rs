//! `sim/ground_truth` and `sim/placement`: what is really so, and what launch makes so. Both are
//! between launch and the simulator; no other service sees them.

use crate::message;
use crate::message::{COORDINATE_M_MAX, Refusal, SPEED_MAX, ZeroCopySend, ensure, number};
use crate::pose::Pose;

/// Most scripted obstacles of a world.
pub const TRUTH_OBSTACLES_MAX: usize = 256;

/// Largest side of an obstacle that is put into the world. [m]
pub const SIZE_M_MAX: f64 = 1000.0;

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
        /// [flag] 1 while the footprint touches something.
        pub in_contact: u32,
        /// [count] Contacts that began while the robot moved faster than 0.05 m/s.
        pub contacts_moving: u32,
        /// [count] Contacts that began while it stood.
        pub contacts_standing: u32,
        /// [count] Obstacles in the slice.
        pub n_obstacles: u32,
        /// [id] Id of the scan of this tick, 0 = none.
        pub scan: u64,
        /// [ns] run time lost because the simulator was late.
        pub slipped_ns: u64,
    }
}

message! {
    /// Truth about one scripted obstacle.
    pub struct TruthObstacle = "zeronav.TruthObstacle.v1" {
        /// [number] Place in the scenario's list, from 0.
        pub index: u32,
        /// [count] Beams of this tick's scan that ended on it.
        pub beams: u32,
        /// [ns] run time at which it was due to appear.
        pub appeared_run_ns: u64,
        /// [ns] `CLOCK_MONOTONIC` of that moment.
        pub appeared_ns: u64,
        /// Where it is, `map` frame.
        pub pose: Pose,
    }
}

message! {
    /// Fixed fields of the placements.
    pub struct Placements = "zeronav.Placements.v1" {
        /// [count] Placements in the slice.
        pub n_placements: u64,
    }
}

message! {
    /// Puts an obstacle somewhere for a time, whatever its script says. Until `from_run_ns`
    /// it does what it did before. A later placement with the same `from_run_ns` and `pose` changes
    /// only how long it stays.
    pub struct Placement = "zeronav.Placement.v2" {
        /// [number] Place in the scenario's list, from 0; one behind the last adds an obstacle.
        pub index: u32,
        /// Written as 0.
        pub spare: u32,
        /// [ns] run time from which it is there; in lockstep of a tick above the lease.
        pub from_run_ns: u64,
        /// [ns] run time from which it is gone; 0 = it stays.
        pub until_run_ns: u64,
        /// `map_from_shape` while it is there.
        pub pose: Pose,
        /// [m] of the rectangle that it becomes, along x, or diameter of a disc; 0 = the shape that it
        /// has.
        pub size_x_m: f64,
        /// [m] along y; 0 = a disc.
        pub size_y_m: f64,
    }
}

impl Placements {
    /// Accepts placements of obstacles that a scenario can have.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self, placements: &[Placement]) -> Result<(), Refusal> {
        ensure(
            placements.len() as u64 == self.n_placements && placements.len() <= TRUTH_OBSTACLES_MAX,
            Refusal::Length("placements"),
        )?;
        for placement in placements {
            ensure(
                (placement.index as usize) < TRUTH_OBSTACLES_MAX,
                Refusal::OutOfRange("index"),
            )?;
            placement.pose.check("pose")?;
            number(placement.size_x_m, 0.0, SIZE_M_MAX, "size_x_m")?;
            number(placement.size_y_m, 0.0, SIZE_M_MAX, "size_y_m")?;
        }
        Ok(())
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
