//! What moves and where it will be, for a run that measures what perception and prediction cost.

use super::Simulator;
use crate::obstacles::Obstacle;
use zeronav_msgs::foresight::{
    FORESEEN_MAX, FORESEEN_STEP_S, FORESEEN_STEPS, Foreseen, Foresight, LASTS_S_MAX,
};
use zeronav_msgs::message::SPEED_MAX;
use zeronav_msgs::obstacles::OBSTACLE_RADIUS_M_MAX;
use zeronav_msgs::time::{nanoseconds, seconds};
use zeronav_world::World;

/// Time over which a velocity is measured. [ns]
const VELOCITY_NS: u64 = 10_000_000;

impl Simulator {
    /// What moves, and where it will be, as of the scan that fell due in the last step: the nearest
    /// ones. `obstacles` becomes those.
    pub fn foresee(&self, obstacles: &mut Vec<Foreseen>) -> Foresight {
        let run_ns = self.due.map_or(self.run_ns, |due| due.capture_run_ns);
        let pose = self.history.at(run_ns);
        obstacles.clear();
        let all = (0..).zip(&self.obstacles);
        obstacles.extend(all.filter_map(|(index, it)| foreseen(index, it, &self.world, run_ns)));
        let away_m = |it: &Foreseen| (it.x_m[0] - pose.x_m).hypot(it.y_m[0] - pose.y_m);
        obstacles.sort_by(|a, b| away_m(a).total_cmp(&away_m(b)));
        obstacles.truncate(FORESEEN_MAX);
        Foresight {
            pose,
            n_obstacles: obstacles.len() as u64,
        }
    }
}

/// Where an obstacle is at `run_ns` and later; `None` when it is not there, or never moves. What waits
/// for the robot is taken to stay where it is.
fn foreseen(index: u64, obstacle: &Obstacle, world: &World, run_ns: u64) -> Option<Foreseen> {
    if !obstacle.exists_at(run_ns) || obstacle.speed_mps() <= 0.0 {
        return None;
    }
    let step_ns = nanoseconds(FORESEEN_STEP_S);
    let mut future = obstacle.clone();
    future.look_ahead(world, run_ns + step_ns * FORESEEN_STEPS as u64);
    let mut foreseen = Foreseen {
        index,
        radius_m: radius_m(obstacle, run_ns),
        lasts_s: obstacle.vanishes_run_ns().map_or(LASTS_S_MAX, |until_ns| {
            seconds(until_ns.saturating_sub(run_ns)).min(LASTS_S_MAX)
        }),
        ..Foreseen::default()
    };
    let places = foreseen.x_m.iter_mut().zip(&mut foreseen.y_m);
    for ((x_m, y_m), step) in places.zip(0_u64..) {
        let pose = future.pose_at(run_ns + step * step_ns);
        (*x_m, *y_m) = (pose.x_m, pose.y_m);
    }
    // What jumps in a moment moves as it did before.
    let jumps = obstacle
        .next_jump_run_ns(run_ns)
        .is_some_and(|jump_ns| jump_ns <= run_ns + VELOCITY_NS);
    let (from_ns, to_ns) = if jumps {
        (run_ns.saturating_sub(VELOCITY_NS), run_ns)
    } else {
        (run_ns, run_ns + VELOCITY_NS)
    };
    let way = future.pose_at(to_ns).point() - future.pose_at(from_ns).point();
    let velocity = way / seconds((to_ns - from_ns).max(1));
    foreseen.vx_mps = velocity.x.clamp(-SPEED_MAX, SPEED_MAX);
    foreseen.vy_mps = velocity.y.clamp(-SPEED_MAX, SPEED_MAX);
    Some(foreseen)
}

/// Radius of the disc around its centre that it covers. [m]
fn radius_m(obstacle: &Obstacle, run_ns: u64) -> f64 {
    let placed = obstacle.placed_at(run_ns);
    let radius_m = if let Some(ball) = placed.form().as_ball() {
        ball.radius
    } else {
        let centre = obstacle.pose_at(run_ns).point();
        let corners = placed.corners().map(|corner| (corner - centre).norm());
        corners.fold(0.0, f64::max)
    };
    radius_m.min(OBSTACLE_RADIUS_M_MAX)
}
