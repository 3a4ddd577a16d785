//! Turning on the spot: how fast, and which way round.

use zeronav_msgs::description::Description;

/// Share of the yaw rate and the yaw acceleration that a turn uses.
const SHARE: f64 = 0.8;

/// [rad] beyond which both ways round are about as long, and a turn keeps its direction.
const OPPOSITE_RAD: f64 = 2.2;

/// [rad/s] for a turn by `error_rad` (wrapped, left positive) that ends standing:
/// `sqrt(2 alpha error)`, not faster than the robot turns.
pub(crate) fn rate_radps(robot: &Description, error_rad: f64) -> f64 {
    let fastest = SHARE * robot.w_radps_max;
    (2.0 * SHARE * robot.alpha_radps2_max * error_rad.abs())
        .sqrt()
        .min(fastest)
        .copysign(error_rad)
}

/// The error to turn by: `error_rad` the short way, or the long way when that is how a turn in
/// progress goes round and the two are nearly alike. `direction` is +1, -1, or 0 for no turn.
pub(crate) fn committed_rad(error_rad: f64, direction: f64) -> f64 {
    if error_rad.abs() > OPPOSITE_RAD && direction * error_rad < 0.0 {
        error_rad + core::f64::consts::TAU.copysign(direction)
    } else {
        error_rad
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_keeps_its_way_round_near_the_opposite() {
        assert!(committed_rad(3.0, 1.0) > 0.0);
        assert!(committed_rad(-3.0, 1.0) > 3.0);
        assert!(committed_rad(-1.0, 1.0) < 0.0);
        assert!(committed_rad(-3.0, 0.0) < 0.0);
    }

    #[test]
    fn the_rate_ends_at_the_error() {
        let robot = Description {
            w_radps_max: 2.0,
            alpha_radps2_max: 4.0,
            ..Description::default()
        };
        assert!((rate_radps(&robot, 3.0) - 1.6).abs() < 1e-12);
        assert!((rate_radps(&robot, -0.1) + 0.8).abs() < 1e-12);
        assert!(rate_radps(&robot, 0.0).abs() < 1e-12);
    }
}
