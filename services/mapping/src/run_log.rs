//! What mapping logs of a run: jumps of the pose correction, and how many obstacles move.

use zeronav_mapping::Sought;
use zeronav_msgs::pose::{Pose, wrap_angle};

/// Least run time between two lines. [ns]
const PAUSE_NS: u64 = 1_000_000_000;

/// Change of the correction that is logged. [m]
const STEP_M: f64 = 0.1;

/// The same of its yaw. [rad]
const STEP_RAD: f64 = 0.05;

/// What was logged last.
#[derive(Debug, Default)]
pub(crate) struct RunLog {
    map_from_odom: Pose,
    n_moving: usize,
    sought: Sought,
    due_ns: u64,
}

impl RunLog {
    /// Logs when the robot is looked for on the whole map, and what came of it.
    pub(crate) fn log_sought(&mut self, tick: u64, sought: Sought) {
        let before = core::mem::replace(&mut self.sought, sought);
        if sought == before {
            return;
        }
        match sought {
            Sought::Not => tracing::info!(tick, "the robot knows where it is again"),
            Sought::Everywhere => tracing::warn!(
                tick,
                "the robot does not know where it is: it is looked for on the whole map"
            ),
            Sought::Ambiguous(places) => tracing::warn!(
                tick,
                places,
                "the robot does not know where it is: several places fit what it sees"
            ),
            Sought::TooMany => tracing::warn!(
                tick,
                "the robot does not know where it is: too many places fit a little to look at all of them"
            ),
            Sought::Nowhere => tracing::warn!(
                tick,
                "the robot does not know where it is: no place on the map fits what it sees"
            ),
        }
    }

    /// Logs what has changed since the last line, a line a second at most.
    pub(crate) fn log(&mut self, tick: u64, run_ns: u64, map_from_odom: &Pose, n_moving: usize) {
        let from = &self.map_from_odom;
        let turn_rad = wrap_angle(map_from_odom.yaw_rad - from.yaw_rad).abs();
        let corrected = from.distance_m(map_from_odom) > STEP_M || turn_rad > STEP_RAD;
        if run_ns < self.due_ns || (!corrected && n_moving == self.n_moving) {
            return;
        }
        self.due_ns = run_ns + PAUSE_NS;
        if corrected {
            let Pose { x_m, y_m, yaw_rad } = *map_from_odom;
            tracing::info!(tick, x_m, y_m, yaw_rad, "odometry corrected");
            self.map_from_odom = *map_from_odom;
        }
        if n_moving != self.n_moving {
            tracing::info!(
                tick,
                from = self.n_moving,
                to = n_moving,
                "moving obstacles"
            );
            self.n_moving = n_moving;
        }
    }
}
