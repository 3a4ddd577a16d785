//! How fast zones let the robot drive: where it is, and so that it is slow enough where it will be.

use nalgebra::Point2;
use zeronav_msgs::ZoneSet;
use zeronav_msgs::description::Description;

/// Distance of two points of the path that are looked at, and the most of them: where the way is longer, they lie
/// farther apart. [m]
const STEP_M: f64 = 0.05;
const POINTS_MAX: u32 = 200;

/// Share of the robot's deceleration that slows it down before a zone.
const COMFORT_SHARE: f64 = 0.7;

/// [s] between a command and its effect, for which the speed stays.
const REACTION_S: f64 = 0.1;

/// The fastest speed that zones allow a robot at `here` whose path goes on through `ahead(arc)` [m];
/// infinite when they set none. [m/s]
pub(crate) fn zone_mps(
    zones: Option<&ZoneSet>,
    robot: &Description,
    here: Point2<f64>,
    ahead: impl Fn(f64) -> Point2<f64>,
) -> f64 {
    let Some(zones) = zones else {
        return f64::INFINITY;
    };
    let limit_mps = |at: Point2<f64>| {
        let limit = zones.limit_at(at, robot.v_mps_max);
        limit.map_or(f64::INFINITY, |limit| limit.limit_mps)
    };
    let decel_mps2 = COMFORT_SHARE * robot.brake_mps2;
    let most_m = robot.v_mps_max * REACTION_S + robot.v_mps_max.powi(2) / (2.0 * decel_mps2);
    let step_m = STEP_M.max(most_m / f64::from(POINTS_MAX));
    let steps = (1..=POINTS_MAX).map(|n| f64::from(n) * step_m);
    let on_way = steps
        .take_while(|arc_m| *arc_m <= most_m + step_m)
        .map(|arc_m| {
            let there_mps = limit_mps(ahead(arc_m));
            if there_mps.is_finite() {
                let brake_m = (arc_m - step_m - there_mps * REACTION_S).max(0.0);
                (there_mps.powi(2) + 2.0 * decel_mps2 * brake_m).sqrt()
            } else {
                there_mps
            }
        });
    on_way.fold(limit_mps(here), f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_robot::robot;
    use zeronav_msgs::zones::{ZoneKind, ZonePart, Zones};

    #[test]
    fn the_robot_is_slow_enough_when_it_gets_to_a_zone() {
        let corners = [[2.0, -1.0], [3.0, -1.0], [3.0, 1.0], [2.0, 1.0]];
        let part = ZonePart::new("ramp", ZoneKind::SpeedLimit, 0.3, &corners);
        let zones = ZoneSet::of(
            &Zones {
                revision: 1,
                n_parts: 1,
                ..Zones::default()
            },
            &[part],
        );
        let robot = robot();
        let at = |x_m: f64| {
            let ahead = |arc_m: f64| Point2::new(x_m + arc_m, 0.0);
            zone_mps(Some(&zones), &robot, Point2::new(x_m, 0.0), ahead)
        };
        assert!(at(-2.0).is_infinite(), "{}", at(-2.0));
        assert!((at(2.5) - 0.3).abs() < 1e-9 && (at(1.97) - 0.3).abs() < 1e-6);
        assert!(at(3.1).is_infinite(), "behind it");
        let (mut before, mut x_m) = (f64::INFINITY, 1.0);
        while x_m < 2.0 {
            let now = at(x_m);
            assert!(now <= before && now >= 0.3);
            // It can follow at its deceleration.
            if before.is_finite() {
                assert!(before.powi(2) - now.powi(2) <= 2.0 * robot.brake_mps2 * 0.05 + 1e-9);
            }
            (before, x_m) = (now, x_m + 0.05);
        }
        // A fast one looks as far ahead as it needs to brake.
        let fast = Description {
            v_mps_max: 5.0,
            brake_mps2: 1.5,
            ..robot
        };
        let ahead = |arc_m: f64| Point2::new(arc_m - 8.8, 0.0);
        let far = zone_mps(Some(&zones), &fast, ahead(0.0), ahead);
        assert!((4.5..5.0).contains(&far), "{far}");
    }
}
