//! Outlines of what was put into a simulated world.

use super::{Rounded, point};
use core::f64::consts::TAU;
use zeronav_msgs::truth::Placement;

/// Corners that stand for a disc.
const DISC_CORNERS: u32 = 24;

/// Outline of a placed obstacle in the map frame, counter-clockwise. [m] `None` when it keeps the
/// shape that the scenario gives it, which no message tells.
#[must_use]
pub fn outline(placement: &Placement) -> Option<Vec<[Rounded; 2]>> {
    let (x_m, y_m) = (placement.size_x_m, placement.size_y_m);
    if x_m <= 0.0 {
        return None;
    }
    let (sin, cos) = placement.pose.yaw_rad.sin_cos();
    let at = |[x, y]: [f64; 2]| {
        let pose = &placement.pose;
        point(pose.x_m + cos * x - sin * y, pose.y_m + sin * x + cos * y)
    };
    let corners: Vec<[f64; 2]> = if y_m > 0.0 {
        let corner = |(x, y)| [0.5 * x_m * x, 0.5 * y_m * y];
        let signs = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        signs.into_iter().map(corner).collect()
    } else {
        let angles = (0..DISC_CORNERS).map(|i| TAU * f64::from(i) / f64::from(DISC_CORNERS));
        angles
            .map(|angle| [0.5 * x_m * angle.cos(), 0.5 * x_m * angle.sin()])
            .collect()
    };
    Some(corners.into_iter().map(at).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::Pose;

    #[test]
    fn boxes_turn_and_discs_are_round() {
        let mut placement = Placement {
            pose: Pose::new(1.0, 2.0, core::f64::consts::FRAC_PI_2),
            size_x_m: 0.4,
            size_y_m: 0.2,
            ..Placement::default()
        };
        let corners = outline(&placement).expect("an outline");
        assert_eq!(corners[0], point(1.1, 1.8));
        assert_eq!(corners[2], point(0.9, 2.2));
        placement.size_y_m = 0.0;
        let disc = outline(&placement).expect("an outline");
        assert_eq!(disc.len(), 24);
        assert_eq!(disc[0], point(1.0, 2.2));
        placement.size_x_m = 0.0;
        assert_eq!(outline(&placement), None);
    }
}
