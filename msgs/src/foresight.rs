//! `sim/foresight`: what moves and where it will be, as the simulator knows it. Sent in a run that
//! measures what perception and prediction cost, and in no other.

use crate::message;
use crate::message::{COORDINATE_M_MAX, Refusal, SPEED_MAX, ZeroCopySend, ensure, number};
use crate::obstacles::{OBSTACLE_RADIUS_M_MAX, OBSTACLES_MAX};
use crate::pose::Pose;
use zeronav_casts::Cast;

/// Bit of [`RunClock::foresight`](crate::run::RunClock::foresight): mapping follows what the simulator
/// says instead of what it tracks.
pub const FORESIGHT_PERCEIVE: u16 = 1;

/// Bit of [`RunClock::foresight`](crate::run::RunClock::foresight): the local planner predicts what the
/// simulator says.
pub const FORESIGHT_PREDICT: u16 = 2;

/// Most obstacles of a message: the nearest ones.
pub const FORESEEN_MAX: usize = OBSTACLES_MAX;

/// Places of each of them in the future.
pub const FORESEEN_STEPS: usize = 64;

/// Time from place to place. [s]
pub const FORESEEN_STEP_S: f64 = 0.1;

/// What stays to the end of time lasts so long. [s]
pub const LASTS_S_MAX: f64 = 1.0e9;

message! {
    /// Fixed fields of the foresight. The slice holds what moves.
    pub struct Foresight = "zeronav.Foresight.v1" {
        /// True `map_from_base` at the capture of the scan.
        pub pose: Pose,
        /// [count] Obstacles in the slice.
        pub n_obstacles: u64,
    }
}

message! {
    /// An obstacle that moves: where it is, and where it will be.
    pub struct Foreseen = "zeronav.Foreseen.v1" {
        /// [number] Place in the scenario's list, from 0.
        pub index: u64,
        /// [m/s] `map` frame.
        pub vx_mps: f64,
        /// [m/s] `map` frame.
        pub vy_mps: f64,
        /// [m] 0 to 10. For other shapes: radius of the enclosing disc.
        pub radius_m: f64,
        /// [s] until it vanishes; 1e9 = it stays.
        pub lasts_s: f64,
        /// [m] `map` frame, now and every 0.1 s from now on.
        pub x_m: [f64; FORESEEN_STEPS],
        /// [m] `map` frame, at the same times.
        pub y_m: [f64; FORESEEN_STEPS],
    }
}

impl Foresight {
    /// Accepts lists of finite obstacles.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self, obstacles: &[Foreseen]) -> Result<(), Refusal> {
        ensure(
            obstacles.len() as u64 == self.n_obstacles && obstacles.len() <= FORESEEN_MAX,
            Refusal::Length("obstacles"),
        )?;
        self.pose.check("pose")?;
        let limit = COORDINATE_M_MAX;
        for obstacle in obstacles {
            number(obstacle.vx_mps, -SPEED_MAX, SPEED_MAX, "vx_mps")?;
            number(obstacle.vy_mps, -SPEED_MAX, SPEED_MAX, "vy_mps")?;
            number(obstacle.radius_m, 0.0, OBSTACLE_RADIUS_M_MAX, "radius_m")?;
            number(obstacle.lasts_s, 0.0, LASTS_S_MAX, "lasts_s")?;
            for value in obstacle.x_m.iter().chain(&obstacle.y_m) {
                number(*value, -limit, limit, "x_m or y_m")?;
            }
        }
        Ok(())
    }
}

impl Foreseen {
    /// Where it is `after_s` from the moment of the message, `map` frame; `None` once it has vanished.
    /// Between two places it moves straight, unless they are so far apart that it jumps; beyond the
    /// last one it goes on as it went. [m]
    #[must_use]
    pub fn at(&self, after_s: f64) -> Option<[f64; 2]> {
        /// Way of a step that is no motion. [m]
        const JUMP_M: f64 = 1.0;
        if after_s >= self.lasts_s {
            return None;
        }
        let steps = after_s / FORESEEN_STEP_S;
        let from = steps.max(0.0).to_usize().min(FORESEEN_STEPS - 2);
        let share = steps - from.to_f64();
        let (x, y) = (self.x_m[from], self.y_m[from]);
        let (dx, dy) = (self.x_m[from + 1] - x, self.y_m[from + 1] - y);
        if dx.hypot(dy) > JUMP_M {
            let to = from + usize::from(share >= 1.0);
            return Some([self.x_m[to], self.y_m[to]]);
        }
        Some([x + share * dx, y + share * dy])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_between_the_steps_are_on_the_way() {
        let mut walker = Foreseen {
            lasts_s: LASTS_S_MAX,
            ..Foreseen::default()
        };
        for (step, x_m) in (0_u32..).zip(&mut walker.x_m) {
            // At 1 m/s, and 5 m away from t = 2 s on.
            *x_m = 0.1 * f64::from(step) + if step > 20 { 5.0 } else { 0.0 };
        }
        let near = |after_s: f64, x_m: f64| {
            let [x, y] = walker.at(after_s).expect("a place");
            assert!(
                (x - x_m).abs() < 1e-9 && y.abs() < 1e-12,
                "{x} at {after_s}"
            );
        };
        near(0.0, 0.0);
        near(1.23, 1.23);
        near(-0.05, -0.05);
        // What jumps is in the middle of nowhere at no time.
        near(2.05, 2.0);
        near(2.15, 7.15);
        // Beyond the last place it goes on.
        near(7.0, 12.0);
        walker.lasts_s = 3.0;
        assert!(walker.at(2.9).is_some() && walker.at(3.0).is_none());
    }

    #[test]
    fn both_coordinates_move_and_only_far_ones_jump() {
        let mut walker = Foreseen {
            lasts_s: LASTS_S_MAX,
            ..Foreseen::default()
        };
        // Towards (3, -4), 0.25 m in each step, then one of 0.9 m, then one of more than 1 m.
        for (step, (x_m, y_m)) in (0_u32..).zip(walker.x_m.iter_mut().zip(&mut walker.y_m)) {
            let way_m = match step {
                0..=10 => 0.25 * f64::from(step),
                11 => 3.4,
                _ => 4.75,
            };
            (*x_m, *y_m) = (1.0 + 0.6 * way_m, 2.0 - 0.8 * way_m);
        }
        for (after_s, way_m) in [
            (0.0, 0.0),
            (0.14, 0.35),
            (1.0, 2.5),
            (1.15, 3.4),
            (1.3, 4.75),
        ] {
            let [x, y] = walker.at(after_s).expect("a place");
            let off_m = (x - 1.0 - 0.6 * way_m).hypot(y - 2.0 + 0.8 * way_m);
            assert!(off_m < 1e-9, "({x}, {y}) after {after_s} s");
        }
        let [x, y] = walker.at(1.05).expect("a place");
        assert!(
            (x - 2.77).abs() < 1e-9 && (y + 0.36).abs() < 1e-9,
            "0.9 m is motion: ({x}, {y})"
        );
    }

    #[test]
    fn the_last_steps_are_no_others() {
        let mut walker = Foreseen {
            lasts_s: LASTS_S_MAX,
            ..Foreseen::default()
        };
        // Still for 5 s, then 0.5 m in each step, and 1 m exactly in the last one.
        for (step, x_m) in (0_u32..).zip(&mut walker.x_m) {
            let moved = step.saturating_sub(50);
            *x_m = 0.5 * f64::from(moved) + if step == 63 { 0.5 } else { 0.0 };
        }
        let x_m = |walker: &Foreseen, after_s| walker.at(after_s).expect("a place")[0];
        for (after_s, expected) in [(5.0, 0.0), (5.25, 1.25), (6.25, 6.5), (6.4, 8.0)] {
            let found = x_m(&walker, after_s);
            assert!((found - expected).abs() < 1e-9, "{found} after {after_s} s");
        }
        // What jumps in the last step stays where it came to.
        walker.x_m[63] += 5.0;
        assert!((x_m(&walker, 6.25) - 6.0).abs() < 1e-9);
        assert!((x_m(&walker, 7.0) - 12.0).abs() < 1e-9);
    }
}
