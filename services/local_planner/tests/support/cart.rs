//! A cart that crosses the way.

use super::{Drive, Loop, block, disc, path};
use zeronav_msgs::Pose;
use zeronav_msgs::obstacles::Obstacle;

/// A cart of 0.4 m in the way of a robot in a hall: where it starts and how fast.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cart {
    pub(crate) from: (f64, f64),
    pub(crate) velocity: (f64, f64),
}

impl Cart {
    /// One that crosses the robot's line from a side (-1 or 1) when an undisturbed robot would be
    /// there.
    pub(crate) fn crossing(speed_mps: f64, meets_at_m: f64, side: f64) -> Self {
        let arrives_s = (meets_at_m - 1.0) / 0.8 + 0.4;
        Self {
            from: (meets_at_m, 4.0 + side * speed_mps * arrives_s),
            velocity: (0.0, -side * speed_mps),
        }
    }
}

/// Drives along the hall while the cart passes: least distance while the robot moved faster than
/// 0.05 m/s, least distance at all, seconds to the goal.
pub(crate) fn cross(controller: &mut dyn Drive, cart: Cart, told: bool) -> (f64, f64, Option<f64>) {
    let hall = [block(0.0, 0.0, 14.0, 0.2), block(0.0, 7.8, 14.0, 8.0)];
    let robot = disc(0.25, 0.8, 1.0, 1.8, 3.0);
    let corners = path(&[(1.0, 4.0), (12.0, 4.0)]);
    let mut run = Loop::new(robot, &hall, (14.0, 8.0), Pose::new(1.0, 4.0, 0.0), corners);
    let radius_m = 0.4;
    let (mut moving_m, mut any_m) = (f64::INFINITY, f64::INFINITY);
    for _ in 0..2000 {
        let (x, y) = (
            cart.from.0 + cart.velocity.0 * run.time_s,
            cart.from.1 + cart.velocity.1 * run.time_s,
        );
        run.obstacles.clear();
        if told {
            run.obstacles.push(Obstacle {
                track: 1,
                x_m: x,
                y_m: y,
                vx_mps: cart.velocity.0,
                vy_mps: cart.velocity.1,
                radius_m,
                covariance: [1e-3, 0.0, 0.0, 0.0, 1e-3, 0.0, 0.0, 0.02, 0.0, 0.02],
                ..Obstacle::default()
            });
        }
        // The lidar sees the cart as a square of its size.
        run.blocks.truncate(2);
        let half_m = 0.7 * radius_m;
        run.blocks
            .push(block(x - half_m, y - half_m, x + half_m, y + half_m));
        run.step(controller);
        let distance_m = (run.pose.x_m - x).hypot(run.pose.y_m - y) - radius_m - 0.25;
        any_m = any_m.min(distance_m);
        if run.twist.v_mps.abs() > 0.05 {
            moving_m = moving_m.min(distance_m);
        }
        if run.pose.distance_m(&run.goal.pose) < run.goal.tolerance_m && run.twist.is_stopped() {
            return (moving_m, any_m, Some(run.time_s));
        }
    }
    (moving_m, any_m, None)
}
