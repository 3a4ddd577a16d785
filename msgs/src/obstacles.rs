//! `map/obstacles`: tracked dynamic obstacles.

use crate::message;
use crate::message::{COORDINATE_M_MAX, Refusal, SPEED_MAX, ZeroCopySend, ensure, number};

/// Most tracked obstacles.
pub const OBSTACLES_MAX: usize = 128;

/// Largest radius of a tracked obstacle, which bounds the work of stamping it on a map. [m]
pub const OBSTACLE_RADIUS_M_MAX: f64 = 10.0;

/// A tracked obstacle that has not been seen for this long is a guess. More than three scans at 10 Hz. [s]
const GUESSED_FROM_S: f64 = 0.31;

message! {
    /// Fixed fields of the list of tracked obstacles.
    pub struct Obstacles = "zeronav.Obstacles.v1" {
        /// [count] Number of obstacles, equal to the length of the slice.
        pub n_obstacles: u64,
    }
}

message! {
    /// A tracked obstacle: a disc with constant velocity.
    pub struct Obstacle = "zeronav.Obstacle.v2" {
        /// [number] Stays with the track as long as it lives.
        pub track: u64,
        /// [m] `map` frame.
        pub x_m: f64,
        /// [m] `map` frame.
        pub y_m: f64,
        /// [m/s] `map` frame.
        pub vx_mps: f64,
        /// [m/s] `map` frame.
        pub vy_mps: f64,
        /// [m] 0 to [`OBSTACLE_RADIUS_M_MAX`].
        pub radius_m: f64,
        /// [s] since the track began.
        pub age_s: f64,
        /// [s] since the last scan that showed it: where it is now is predicted. 0 while it is seen.
        pub unseen_s: f64,
        /// Covariance of (x, y, vx, vy), upper triangle by rows. [m^2, m^2/s, m^2/s^2]
        pub covariance: [f64; 10],
    }
}

impl Obstacle {
    /// True when it has not been seen for so long that it says where the obstacle may be, not that
    /// something moves there: it is hidden, and its place is predicted.
    #[must_use]
    pub fn is_guess(&self) -> bool {
        self.unseen_s >= GUESSED_FROM_S
    }
}

impl Obstacles {
    /// Accepts lists of finite obstacles.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self, obstacles: &[Obstacle]) -> Result<(), Refusal> {
        ensure(
            obstacles.len() as u64 == self.n_obstacles && obstacles.len() <= OBSTACLES_MAX,
            Refusal::Length("obstacles"),
        )?;
        let limit = COORDINATE_M_MAX;
        for obstacle in obstacles {
            number(obstacle.x_m, -limit, limit, "x_m")?;
            number(obstacle.y_m, -limit, limit, "y_m")?;
            number(obstacle.vx_mps, -SPEED_MAX, SPEED_MAX, "vx_mps")?;
            number(obstacle.vy_mps, -SPEED_MAX, SPEED_MAX, "vy_mps")?;
            number(obstacle.radius_m, 0.0, OBSTACLE_RADIUS_M_MAX, "radius_m")?;
            number(obstacle.age_s, 0.0, 1.0e9, "age_s")?;
            number(obstacle.unseen_s, 0.0, 1.0e9, "unseen_s")?;
            for value in obstacle.covariance {
                number(value, -1.0e12, 1.0e12, "covariance")?;
            }
        }
        Ok(())
    }
}
