//! The motions that a manoeuvre is made of: arcs ahead and back, and turns on the spot.

use zeronav_casts::Cast;
use zeronav_motion::Twist;
use zeronav_msgs::Pose;
use zeronav_msgs::description::Description;
use zeronav_msgs::pose::wrap_angle;

/// Curvatures of arcs, either way round. [1/m] The flat ones leave a wall that the robot stands beside
/// without its rear corner swinging into it.
const CURVATURES: [f64; 5] = [0.05, 0.15, 0.4, 1.0, 2.2];

/// [1/m] up to which an arc is flat.
const FLAT: f64 = 0.1;

/// [m] shortest arc, and [rad] that an arc turns at least: each leads to another cell of the search.
const ARC_M: f64 = 0.1;
const ARC_RAD: f64 = 0.07;

/// [m] a straight piece, besides the shortest.
const STRAIGHT_M: f64 = 0.4;

/// [rad] turns on the spot.
const TURNS_RAD: [f64; 2] = [0.07, 0.35];

/// [m] and [rad] within which poses are the same.
const SAME_M: f64 = 0.01;
const SAME_RAD: f64 = 0.01;

/// Cost of a metre back and of a radian on the spot, in metres ahead.
const BACK: f64 = 1.5;
pub(crate) const TURN: f64 = 0.35;

/// [m] by which any point of the outline moves from one checked pose to the next.
const SPACING_M: f64 = 0.04;

/// A motion with constant speeds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Motion {
    /// +1 ahead, -1 back, 0 on the spot.
    pub(crate) direction: f64,
    /// Of an arc, left positive. [1/m]
    pub(crate) curvature: f64,
    /// Driven, >= 0. [m]
    pub(crate) length_m: f64,
    /// Turned, left positive. [rad]
    pub(crate) turn_rad: f64,
    /// Poses to check.
    pub(crate) steps: u32,
}

impl Motion {
    /// An arc for an outline that reaches so far. [m]
    pub(super) fn arc(direction: f64, curvature: f64, length_m: f64, reach_m: f64) -> Self {
        let turn_rad = direction * curvature * length_m;
        Self {
            direction,
            curvature,
            length_m,
            turn_rad,
            steps: steps(length_m + turn_rad.abs() * reach_m),
        }
    }

    /// A turn on the spot.
    pub(super) fn turn(turn_rad: f64, reach_m: f64) -> Self {
        Self {
            direction: 0.0,
            curvature: 0.0,
            length_m: 0.0,
            turn_rad,
            steps: steps(turn_rad.abs() * reach_m),
        }
    }

    /// True for one on which no corner swings.
    pub(crate) fn is_flat(&self) -> bool {
        self.direction != 0.0 && self.curvature.abs() <= FLAT
    }

    /// The motion that undoes it.
    pub(crate) fn undone(self) -> Self {
        Self {
            direction: -self.direction,
            turn_rad: -self.turn_rad,
            ..self
        }
    }

    /// What it costs: metres ahead, and as many for a metre back and a radian on the spot.
    pub(crate) fn cost(&self) -> f64 {
        if self.direction > 0.0 {
            self.length_m
        } else if self.direction < 0.0 {
            BACK * self.length_m
        } else {
            TURN * self.turn_rad.abs()
        }
    }

    /// Where a share of the motion leads, in the `base` before it.
    pub(crate) fn at(&self, share: f64) -> Pose {
        Twist::new(self.direction * self.length_m, self.turn_rad).arc(share)
    }
}

/// Turn, drive straight ahead (+1) or back (-1), turn: from one pose to another, without what is not
/// needed. With any yaw there is no second turn.
pub(crate) fn straight(
    from: &Pose,
    to: &Pose,
    (any_yaw, reach_m): (bool, f64),
    direction: f64,
) -> [Option<Motion>; 3] {
    let way = to.point() - from.point();
    let length_m = way.norm();
    let mut yaw_rad = from.yaw_rad;
    let mut first = None;
    if length_m > SAME_M {
        let facing_rad = wrap_angle((way * direction).y.atan2((way * direction).x) - yaw_rad);
        first = (facing_rad.abs() > SAME_RAD).then(|| Motion::turn(facing_rad, reach_m));
        yaw_rad += facing_rad;
    }
    let drive = (length_m > SAME_M).then(|| Motion::arc(direction, 0.0, length_m, reach_m));
    let last_rad = wrap_angle(to.yaw_rad - yaw_rad);
    let is_turned = any_yaw || last_rad.abs() <= SAME_RAD;
    [
        first,
        drive,
        (!is_turned).then(|| Motion::turn(last_rad, reach_m)),
    ]
}

fn steps(swept_m: f64) -> u32 {
    (swept_m / SPACING_M).ceil().max(1.0).to_u32()
}

/// Every motion of a robot whose outline reaches so far [m], for a search that goes from where the robot
/// stands or, `undone`, from where it is to arrive.
pub(crate) fn motions(robot: &Description, reach_m: f64, undone: bool, found: &mut Vec<Motion>) {
    found.clear();
    for direction in [1.0, -1.0] {
        if direction < 0.0 && robot.v_mps_min >= 0.0 {
            continue;
        }
        found.push(Motion::arc(direction, 0.0, ARC_M, reach_m));
        found.push(Motion::arc(direction, 0.0, STRAIGHT_M, reach_m));
        for curvature in CURVATURES {
            let length_m = ARC_M.max(ARC_RAD / curvature);
            for side in [1.0, -1.0] {
                found.push(Motion::arc(direction, side * curvature, length_m, reach_m));
            }
        }
    }
    for turn_rad in TURNS_RAD {
        for side in [1.0, -1.0] {
            found.push(Motion::turn(side * turn_rad, reach_m));
        }
    }
    if undone {
        for motion in found {
            *motion = motion.undone();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_robot_that_drives_backwards_has_arcs_back() {
        let mut found = Vec::new();
        let mut robot = Description::default();
        motions(&robot, 0.5, false, &mut found);
        assert_eq!(found.len(), 16);
        assert!(found.iter().all(|motion| motion.direction >= 0.0));
        robot.v_mps_min = -0.3;
        motions(&robot, 0.5, false, &mut found);
        assert_eq!(found.len(), 28);
        let ends = found.iter().map(|motion| motion.at(1.0).x_m);
        assert!(ends.fold(f64::INFINITY, f64::min) < -1.3);
    }

    #[test]
    fn what_is_undone_leads_back() {
        let mut found = Vec::new();
        let robot = Description::default();
        motions(&robot, 0.5, true, &mut found);
        // Arriving ahead is undone by going back.
        assert!(found.iter().all(|motion| motion.direction <= 0.0));
        for motion in found {
            let back = motion.at(1.0).then(&motion.undone().at(1.0));
            assert!(back.x_m.abs() + back.y_m.abs() + back.yaw_rad.abs() < 1e-12);
        }
    }

    #[test]
    fn a_straight_way_turns_drives_and_turns() {
        let from = Pose::new(1.0, 2.0, 0.3);
        let to = Pose::new(2.0, 1.0, 2.0);
        for direction in [1.0, -1.0] {
            let way = straight(&from, &to, (false, 0.5), direction);
            let end = (way.iter().flatten()).fold(from, |pose, motion| pose.then(&motion.at(1.0)));
            assert!(end.distance_m(&to) < 1e-9, "{end:?}");
            assert!(wrap_angle(end.yaw_rad - 2.0).abs() < 1e-9, "{end:?}");
        }
        let way = straight(&from, &from, (false, 0.5), 1.0);
        assert!(way.iter().all(Option::is_none));
    }

    #[test]
    fn an_arc_ends_where_its_curvature_leads() {
        let arc = Motion::arc(-1.0, 0.5, 1.0, 0.5);
        let end = arc.at(1.0);
        // Half a radian on a circle of two metres, backwards, with the centre on the left.
        assert!((end.x_m + 2.0 * 0.5_f64.sin()).abs() < 1e-12, "{end:?}");
        assert!((end.y_m - 2.0 * (1.0 - 0.5_f64.cos())).abs() < 1e-12);
        assert!((end.yaw_rad + 0.5).abs() < 1e-12);
        // A corner half a metre away moves by 1.25 m.
        assert_eq!(arc.steps, 32);
    }
}
