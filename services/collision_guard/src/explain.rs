//! Which point of a scan slowed or stopped the robot, in the terms of the message. Nothing is decided
//! by it.

use crate::sweep::Nearest;
use nalgebra::{Point2, Vector2};
use zeronav_casts::Cast;
use zeronav_msgs::command::VelocityCommand;
use zeronav_msgs::description::Description;

/// The command with the point that decided, in `base`, and its distance to the outline. [m]
pub(crate) fn explained(
    command: VelocityCommand,
    decider: Option<(Vector2<f64>, f64)>,
    description: Option<&Description>,
) -> VelocityCommand {
    let Some(((point, clearance_m), description)) = decider.zip(description) else {
        return command;
    };
    VelocityCommand {
        beam: beam_towards(description, point),
        point_m: point.into(),
        point_clearance_m: clearance_m,
        ..command
    }
}

/// What ends the first way that is not free, else what comes nearest to any. [m]
pub(crate) fn decider(ways: &[Nearest]) -> Option<(Vector2<f64>, f64)> {
    let blocked = ways.iter().find(|way| !way.is_free && way.hit.is_some());
    let hits = ways.iter().filter_map(|way| way.hit);
    let nearest = || hits.min_by(|a, b| a.1.total_cmp(&b.1));
    blocked.map_or_else(nearest, |way| way.hit)
}

/// The beam towards a point in `base`, from 1; 0 when none of the lidar's beams goes there.
fn beam_towards(description: &Description, point: Vector2<f64>) -> u16 {
    let base_from_laser = description.base_from_laser.isometry();
    let in_laser = base_from_laser.inverse_transform_point(&Point2::from(point));
    let angle_rad = in_laser.y.atan2(in_laser.x) - description.angle_min_rad;
    let step_rad = description.angle_increment_rad;
    // Half a beam before the first one belongs to it, too.
    let turned_rad = (angle_rad + 0.5 * step_rad).rem_euclid(core::f64::consts::TAU);
    let beam = (turned_rad / step_rad).floor();
    if !(0.0..f64::from(description.n_beams)).contains(&beam) {
        return 0;
    }
    beam.to_u16() + 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::FRAC_PI_2;

    #[test]
    fn beams_are_counted_from_one_and_only_where_there_are_some() {
        let description = Description {
            n_beams: 181,
            angle_min_rad: -FRAC_PI_2,
            angle_increment_rad: FRAC_PI_2 / 90.0,
            ..Description::default()
        };
        let beam = |x_m: f64, y_m: f64| beam_towards(&description, Vector2::new(x_m, y_m));
        assert_eq!(beam(0.0, -2.0), 1);
        assert_eq!(beam(2.0, 0.0), 91);
        assert_eq!(beam(0.0, 2.0), 181);
        assert_eq!(beam(-2.0, 0.1), 0, "behind");
    }

    #[test]
    fn what_ends_a_way_decides_before_what_comes_nearer_to_another() {
        let near = |x_m: f64, clearance_m, is_free| Nearest {
            hit: Some((Vector2::new(x_m, 0.0), clearance_m)),
            is_free,
        };
        let nothing = Nearest {
            hit: None,
            is_free: true,
        };
        let ways = [near(1.0, 0.01, true), near(2.0, 0.02, false), nothing];
        assert_eq!(
            decider(&ways).map(|(_, clearance_m)| clearance_m),
            Some(0.02)
        );
        assert_eq!(
            decider(&ways[..1]).map(|(_, clearance_m)| clearance_m),
            Some(0.01)
        );
        assert_eq!(decider(&[nothing]), None);
    }
}
