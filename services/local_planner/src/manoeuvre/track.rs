//! Driving a manoeuvre that has been found, piece by piece: a law of path following along arcs, and
//! turns on the spot between them.

use super::motions::Motion;
use crate::turn;
use zeronav_motion::Twist;
use zeronav_msgs::Pose;
use zeronav_msgs::description::Description;
use zeronav_msgs::pose::wrap_angle;

/// Most poses of a manoeuvre.
const POSES: usize = 2048;

/// [m] and [rad] from pose to pose.
const SPACING_M: f64 = 0.02;
const SPACING_RAD: f64 = 0.05;

/// [m/s] fastest speed of a manoeuvre, and [m/s] backwards of a robot that does not see where it goes.
const FASTEST_MPS: f64 = 0.5;
const BLIND_MPS: f64 = 0.1;

/// [m/s] with no clearance at all, and [1/s] more per metre of it.
const TIGHT_MPS: f64 = 0.08;
const PER_CLEARANCE_HZ: f64 = 4.0;

/// Share of the robot's braking with which a piece ends.
const COMFORT_SHARE: f64 = 0.5;

/// [1/m^2] and [1/m] of the law of path following: critically damped within a quarter of a metre.
const BESIDE: f64 = 16.0;
const ASKEW: f64 = 8.0;

/// [m] before the end of a piece at which it counts as driven, and [rad] of a turn.
const DRIVEN_M: f64 = 0.008;
const TURNED_RAD: f64 = 0.02;

/// Poses ahead that a turn aims at: less than half a turn.
const TURN_AHEAD: usize = 40;

/// [rad/s] below which a turn has ended.
const STANDING_RADPS: f64 = 0.15;

/// Share of the yaw rate that arcs use; the rest is for keeping to them.
const TURN_SHARE: f64 = 0.7;

/// [m] beside the manoeuvre beyond which the robot has lost it.
const LOST_M: f64 = 0.15;

/// Poses ahead among which the nearest is looked for.
const AHEAD: usize = 15;

/// A pose of the manoeuvre and the motion that led there.
#[derive(Debug, Clone, Copy)]
struct Point {
    odom_from_base: Pose,
    /// +1 ahead, -1 back, 0 on the spot.
    direction: f64,
    /// [1/m], of a turn on the spot its side: +1 left, -1 right.
    curvature: f64,
    /// [m]
    clearance_m: f64,
}

/// Where a robot on a manoeuvre is to go next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Step {
    /// Towards this twist.
    Towards(Twist),
    /// It is at the end.
    Done,
    /// It is too far from it.
    Lost,
}

/// A manoeuvre in the frame of odometry, and how far the robot has come.
#[derive(Debug, Clone)]
pub(crate) struct Track {
    points: Vec<Point>,
    at: usize,
}

impl Track {
    pub(crate) fn new() -> Self {
        Self {
            points: Vec::with_capacity(POSES),
            at: 0,
        }
    }

    /// Takes in motions with their clearances that begin at `odom_from_base`.
    pub(crate) fn take(&mut self, odom_from_base: &Pose, motions: &[(Motion, f64)]) {
        self.points.clear();
        self.at = 0;
        let mut from = *odom_from_base;
        for (motion, clearance_m) in motions {
            let steps = (motion.length_m / SPACING_M)
                .max(motion.turn_rad.abs() / SPACING_RAD)
                .ceil()
                .max(1.0);
            let mut step = 1.0;
            while step <= steps && self.points.len() < POSES {
                self.points.push(Point {
                    odom_from_base: from.then(&motion.at(step / steps)),
                    direction: motion.direction,
                    curvature: if motion.direction == 0.0 {
                        motion.turn_rad.signum()
                    } else {
                        motion.curvature
                    },
                    clearance_m: *clearance_m,
                });
                step += 1.0;
            }
            from = from.then(&motion.at(1.0));
        }
    }

    /// Poses that the robot has passed.
    pub(crate) const fn driven(&self) -> usize {
        self.at
    }

    /// The next step of a robot at `odom_from_base` with this measured twist.
    pub(crate) fn step(
        &mut self,
        robot: &Description,
        odom_from_base: &Pose,
        twist: Twist,
    ) -> Step {
        while let Some(point) = self.points.get(self.at) {
            let rest = &self.points[self.at..];
            let alike = |other: &&Point| {
                let same = |a: f64, b: f64| a.total_cmp(&b).is_eq();
                same(other.direction, point.direction)
                    && (point.direction != 0.0 || same(other.curvature, point.curvature))
            };
            let n = rest.iter().take_while(alike).count();
            if point.odom_from_base.distance_m(odom_from_base) > LOST_M {
                return Step::Lost;
            }
            let end = self.at + n;
            let wanted = if point.direction == 0.0 {
                self.turn(robot, odom_from_base, end, twist)
            } else {
                self.drive(robot, odom_from_base, end)
            };
            if let Some(wanted) = wanted {
                return Step::Towards(wanted);
            }
            self.at = end;
        }
        Step::Done
    }

    /// The twist of a turn on the spot up to the point before `end`; `None` when it is done.
    fn turn(
        &mut self,
        robot: &Description,
        odom_from_base: &Pose,
        end: usize,
        twist: Twist,
    ) -> Option<Twist> {
        let side = self.points[self.at].curvature;
        let left_rad = |point: &Point| {
            side * wrap_angle(point.odom_from_base.yaw_rad - odom_from_base.yaw_rad)
        };
        while self.at + 1 < end && left_rad(&self.points[self.at]) < TURNED_RAD {
            self.at += 1;
        }
        let aim = (self.at + TURN_AHEAD).min(end - 1);
        let left_rad = left_rad(&self.points[aim]);
        let is_done = self.at + 1 == end && left_rad < TURNED_RAD;
        (!is_done || twist.w_radps.abs() > STANDING_RADPS)
            .then(|| Twist::new(0.0, turn::rate_radps(robot, side * left_rad)))
    }

    /// The twist along the arcs up to the point before `end`; `None` when they are driven.
    fn drive(&mut self, robot: &Description, odom_from_base: &Pose, end: usize) -> Option<Twist> {
        let from = odom_from_base.point();
        let distance_m = |point: &Point| (point.odom_from_base.point() - from).norm();
        let ahead = &self.points[self.at..end.min(self.at + AHEAD)];
        let nearest = (0..ahead.len())
            .min_by(|a, b| distance_m(&ahead[*a]).total_cmp(&distance_m(&ahead[*b])))?;
        self.at += nearest;
        let point = self.points[self.at];
        let there = point.odom_from_base;
        let offset = there.isometry().inverse() * from;
        let askew_rad = wrap_angle(odom_from_base.yaw_rad - there.yaw_rad);
        let between = self.points[self.at..end].windows(2);
        let way_m: f64 = between
            .map(|pair| pair[0].odom_from_base.distance_m(&pair[1].odom_from_base))
            .sum();
        let left_m = way_m - point.direction * offset.x;
        if left_m < DRIVEN_M {
            return None;
        }
        let v_mps = point.direction * speed_mps(robot, &point, left_m);
        let w_radps =
            v_mps * point.curvature - BESIDE * v_mps * offset.y - ASKEW * v_mps.abs() * askew_rad;
        let most = robot.w_radps_max;
        Some(Twist::new(v_mps, w_radps.clamp(-most, most)))
    }
}

/// The speed on an arc with so much of it left. [m/s]
fn speed_mps(robot: &Description, point: &Point, left_m: f64) -> f64 {
    let fastest_mps = if point.direction > 0.0 {
        robot.v_mps_max
    } else if sees_behind(robot) {
        -robot.v_mps_min
    } else {
        BLIND_MPS.min(-robot.v_mps_min)
    };
    let turning_mps = TURN_SHARE * robot.w_radps_max / point.curvature.abs().max(1.0e-3);
    let ending_mps = (2.0 * COMFORT_SHARE * robot.brake_mps2.min(robot.a_mps2_max) * left_m).sqrt();
    FASTEST_MPS
        .min(fastest_mps)
        .min(turning_mps)
        .min(ending_mps)
        .min(TIGHT_MPS + PER_CLEARANCE_HZ * point.clearance_m.max(0.0))
}

/// True when a beam of the lidar points backwards.
pub(crate) fn sees_behind(robot: &Description) -> bool {
    let increment_rad = robot.angle_increment_rad;
    if increment_rad == 0.0 {
        return false;
    }
    let behind_rad = core::f64::consts::PI - robot.base_from_laser.yaw_rad - robot.angle_min_rad;
    let along_rad = (behind_rad * increment_rad.signum()).rem_euclid(core::f64::consts::TAU);
    along_rad <= increment_rad.abs() * f64::from(robot.n_beams)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn robot() -> Description {
        Description {
            v_mps_max: 1.0,
            v_mps_min: -0.3,
            w_radps_max: 2.0,
            a_mps2_max: 1.0,
            brake_mps2: 1.0,
            alpha_radps2_max: 4.0,
            ..Description::default()
        }
    }

    /// Drives motions without error from a pose beside their begin; where that ends.
    fn driven(motions: &[Motion], start: Pose) -> (Pose, Step) {
        let mut track = Track::new();
        let motions: Vec<_> = motions.iter().map(|motion| (*motion, 0.1)).collect();
        track.take(&Pose::new(5.0, 3.0, 1.0), &motions);
        let mut pose = Pose::new(5.0, 3.0, 1.0).then(&start);
        let mut twist = Twist::REST;
        for _ in 0..4000 {
            match track.step(&robot(), &pose, twist) {
                Step::Towards(wanted) => {
                    twist = zeronav_motion::reachable(&robot(), twist, wanted, 0.02);
                    pose = pose.then(&twist.arc(0.02));
                }
                ended => return (pose, ended),
            }
        }
        panic!("it does not end: {pose:?}");
    }

    #[test]
    fn a_manoeuvre_is_driven_to_its_end() {
        let reach_m = 0.5;
        let motions = [
            Motion::arc(1.0, 0.4, 0.5, reach_m),
            Motion::arc(-1.0, -1.0, 0.4, reach_m),
            Motion::turn(2.5, reach_m),
            Motion::turn(1.5, reach_m),
            Motion::arc(-1.0, 0.0, 1.0, reach_m),
        ];
        let begin = Pose::new(5.0, 3.0, 1.0);
        let end = motions
            .iter()
            .fold(begin, |pose, motion| pose.then(&motion.at(1.0)));
        for start in [Pose::default(), Pose::new(0.0, 0.03, -0.03)] {
            let (pose, step) = driven(&motions, start);
            assert_eq!(step, Step::Done);
            assert!(pose.distance_m(&end) < 0.03, "{pose:?} {end:?}");
            let off_rad = wrap_angle(pose.yaw_rad - end.yaw_rad);
            assert!(off_rad.abs() < 0.05, "{off_rad}");
        }
        let (_, step) = driven(&motions, Pose::new(0.0, 0.3, 0.0));
        assert_eq!(step, Step::Lost);
    }

    #[test]
    fn it_is_slow_where_it_does_not_see() {
        let point = |direction| Point {
            odom_from_base: Pose::default(),
            direction,
            curvature: 0.0,
            clearance_m: 1.0,
        };
        let lidar = |from_rad: f64, beams| Description {
            angle_min_rad: from_rad,
            angle_increment_rad: 0.0175,
            n_beams: beams,
            ..robot()
        };
        let back_mps = |robot: &Description| speed_mps(robot, &point(-1.0), 9.0);
        assert!((back_mps(&lidar(-3.1, 360)) - 0.3).abs() < 1e-12);
        assert!((back_mps(&lidar(-2.35, 270)) - BLIND_MPS).abs() < 1e-12);
        // The same lidar turned round.
        let mut turned = lidar(-2.35, 270);
        turned.base_from_laser.yaw_rad = 3.0;
        assert!((back_mps(&turned) - 0.3).abs() < 1e-12);
        assert!((speed_mps(&robot(), &point(1.0), 9.0) - FASTEST_MPS).abs() < 1e-12);
    }
}
