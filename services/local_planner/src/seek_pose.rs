//! Small safe motions of a robot that does not know where it is: several places may fit what it sees from where it stands,
//! and one of them alone what it sees next.
//!
//! As the recoveries of Nav2 would be called by hand after a global localisation, spin and then drive on heading: once around on the
//! spot where the lidar does not see all around, then short ways, each towards where the scan leaves most room, straight on before back,
//! and a pause after each.
//! Nothing but the scan and odometry is used, and the robot stays where it is without room.

use crate::inputs::Inputs;
use crate::situation::Decision;
use crate::turn::rate_radps;
use core::f64::consts::{FRAC_PI_2, PI, TAU};
use nalgebra::{Point2, Vector2};
use zeronav_motion::{Twist, reachable, stop_distance_m};
use zeronav_msgs::Pose;
use zeronav_msgs::command::{RequestCause, Validity};
use zeronav_msgs::description::Description;
use zeronav_msgs::pose::wrap_angle;
use zeronav_msgs::time::seconds;

/// How long the robot stands before its first motion, so that it is looked for with what it sees, and before the others:
/// it is looked for on the way, too. [s]
const PAUSE_S: (f64, f64) = (3.0, 1.0);

/// Fastest motion. [m/s, rad/s]
const SLOW: (f64, f64) = (0.3, 1.0);

/// Length of a way, and the least that is worth it. [m]
const WAY_M: (f64, f64) = (1.5, 0.5);

/// What is kept free around the outer circle, beside the way and at its end. [m]
const MARGIN_M: f64 = 0.1;

/// Time until a command takes effect. [s]
const REACTION_S: f64 = 0.2;

/// Directions that are looked at.
const DIRECTIONS: u32 = 24;

/// A turn that ends within this is done. [rad]
const ALIGNED_RAD: f64 = 0.05;

/// Motions for one time of not knowing.
const MOTIONS_MAX: u32 = 20;

/// A scan that leaves out less than this sees all around. [rad]
const UNSEEN_RAD: f64 = 0.1;

/// It no longer seeks when it was not asked for so long. [ns]
const ASKED_NS: u64 = 500_000_000;

/// What the robot does.
#[derive(Debug, Clone, Copy)]
enum Motion {
    /// It stands since a run time. [ns]
    Pause { since_ns: u64 },
    /// It turns by what is left, left positive, from the yaw at which odometry was. [rad]
    Turn {
        left_rad: f64,
        yaw_rad: f64,
        then_m: f64,
    },
    /// It drives straight on from where odometry was.
    Drive { from: Pose, way_m: f64 },
}

/// What is known in a control period.
#[derive(Clone, Copy)]
struct Surroundings<'a> {
    run_ns: u64,
    odom_from_base: Pose,
    robot: &'a Description,
    /// Hits of the scan in `base`. [m]
    points: &'a [Point2<f64>],
    /// Requested last.
    last: Twist,
    period_s: f64,
}

/// Moves a robot that does not know where it is.
#[derive(Debug, Clone, Default)]
pub(crate) struct PoseSeeker {
    motion: Option<Motion>,
    n_motions: u32,
    /// Run time at which it was asked last while the robot does not know where it is. [ns]
    asked_ns: Option<u64>,
}

impl PoseSeeker {
    /// True while the robot does not know where it is and has motions left to find out: it is not stuck then.
    pub(crate) fn is_seeking(&self, run_ns: u64) -> bool {
        let asked = self.asked_ns.map(|at_ns| run_ns.saturating_sub(at_ns));
        self.n_motions < MOTIONS_MAX && asked.is_some_and(|ago_ns| ago_ns < ASKED_NS)
    }

    /// The next motion of a robot that does not know where it is, from what was requested last; `None` = it stands, or
    /// knows.
    pub(crate) fn decide(&mut self, inputs: &Inputs<'_>, last: Twist) -> Option<Decision> {
        if inputs.certainty.is_known() {
            *self = Self::default();
            return None;
        }
        self.asked_ns = Some(inputs.run_ns);
        let (robot, _) = inputs.robot?;
        let (twist, turns) = self.step(&Surroundings {
            run_ns: inputs.run_ns,
            odom_from_base: inputs.odometry?.pose,
            robot,
            points: inputs.scan_points_in_base,
            last,
            period_s: inputs.period_s,
        })?;
        Some(Decision {
            v_mps: twist.v_mps,
            w_radps: twist.w_radps,
            validity: Validity::Drive,
            braking_arc_m: stop_distance_m(robot, twist.v_mps, 0.0),
            turns,
            rollouts: 0,
            blocked_arc_m: None,
            against: None,
            cause: RequestCause::SeekPose,
            limit_mps: 0.0,
        })
    }

    /// The next twist of a robot that does not know where it is, and whether it turns on the spot; `None` = it stands.
    fn step(&mut self, at: &Surroundings<'_>) -> Option<(Twist, bool)> {
        let motion = self.motion.get_or_insert(Motion::Pause {
            since_ns: at.run_ns,
        });
        if let Motion::Pause { since_ns } = *motion {
            let paused_s = seconds(at.run_ns.saturating_sub(since_ns));
            let is_first = self.n_motions == 0;
            let pause_s = if is_first { PAUSE_S.0 } else { PAUSE_S.1 };
            if paused_s < pause_s || self.n_motions >= MOTIONS_MAX {
                return None;
            }
            let next = begin(is_first, at);
            self.n_motions += 1;
            *motion = next.unwrap_or(Motion::Pause {
                since_ns: at.run_ns,
            });
        }
        let yaw_now_rad = at.odom_from_base.yaw_rad;
        match motion {
            Motion::Pause { .. } => return None,
            Motion::Turn {
                left_rad,
                yaw_rad,
                then_m,
            } => {
                *left_rad -= wrap_angle(yaw_now_rad - *yaw_rad);
                *yaw_rad = yaw_now_rad;
                if left_rad.abs() > ALIGNED_RAD && can_turn(at) {
                    let w_radps = rate_radps(at.robot, *left_rad).clamp(-SLOW.1, SLOW.1);
                    return Some((moved(at, Twist::new(0.0, w_radps)), true));
                }
                if *then_m > 0.0 && left_rad.abs() <= ALIGNED_RAD {
                    *motion = Motion::Drive {
                        from: at.odom_from_base,
                        way_m: *then_m,
                    };
                    return Some((moved(at, Twist::REST), false));
                }
            }
            Motion::Drive { from, way_m } => {
                let v_mps = SLOW.0.min(at.robot.v_mps_max);
                let need_m = stop_distance_m(at.robot, v_mps, REACTION_S);
                let driven_m = from.distance_m(&at.odom_from_base);
                if driven_m < *way_m && free_m(at, 0.0) > need_m {
                    return Some((moved(at, Twist::new(v_mps, 0.0)), false));
                }
            }
        }
        self.motion = Some(Motion::Pause {
            since_ns: at.run_ns,
        });
        None
    }
}

/// The next motion: once around at first, where that shows more, then towards where there is most room.
fn begin(is_first: bool, at: &Surroundings<'_>) -> Option<Motion> {
    let yaw_rad = at.odom_from_base.yaw_rad;
    let seen_rad = at.robot.angle_increment_rad.abs() * f64::from(at.robot.n_beams);
    if is_first && seen_rad < TAU - UNSEEN_RAD && can_turn(at) {
        return Some(Motion::Turn {
            left_rad: TAU,
            yaw_rad,
            then_m: 0.0,
        });
    }
    let directions =
        (0..DIRECTIONS).map(|n| wrap_angle(TAU * f64::from(n) / f64::from(DIRECTIONS)));
    let (longest_m, least_m) = WAY_M;
    // What lies behind was seen on the way here.
    let worth = |direction_rad: f64| {
        let free_m = free_m(at, direction_rad).min(4.0 * longest_m);
        let share = if direction_rad.abs() > FRAC_PI_2 {
            0.25
        } else {
            1.0 - 0.1 * direction_rad.abs() / PI
        };
        (share * free_m, direction_rad, free_m)
    };
    let (_, direction_rad, free_m) = directions
        .map(worth)
        .filter(|(.., free_m)| *free_m >= least_m)
        .max_by(|one, other| one.0.total_cmp(&other.0))?;
    Some(Motion::Turn {
        left_rad: direction_rad,
        yaw_rad,
        then_m: free_m.min(longest_m),
    })
}

/// The twist of this period on the way to `wanted`.
fn moved(at: &Surroundings<'_>, wanted: Twist) -> Twist {
    reachable(at.robot, at.last, wanted, at.period_s)
}

/// True when the robot can turn on the spot whatever its outline is.
fn can_turn(at: &Surroundings<'_>) -> bool {
    let radius_m = at.robot.circumscribed_radius_m;
    at.points.iter().all(|it| it.coords.norm() > radius_m)
}

/// How far the robot can drive in a direction [rad] of `base` before its outer circle is near a hit. [m]
fn free_m(at: &Surroundings<'_>, direction_rad: f64) -> f64 {
    let (sin, cos) = direction_rad.sin_cos();
    let along = Vector2::new(cos, sin);
    let radius_m = at.robot.circumscribed_radius_m + MARGIN_M;
    let on_way = at.points.iter().filter_map(|point| {
        let ahead_m = point.coords.dot(&along);
        let beside_m = point.coords.perp(&along).abs();
        (ahead_m > 0.0 && beside_m < radius_m).then_some(ahead_m - radius_m)
    });
    on_way.fold(f64::INFINITY, f64::min).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hits of a wall along y or x, 5 cm apart. [m]
    fn wall(from: (f64, f64), to: (f64, f64)) -> Vec<Point2<f64>> {
        let (from, to) = (Point2::new(from.0, from.1), Point2::new(to.0, to.1));
        (0..=100)
            .map(|n| from + (to - from) * (f64::from(n) / 100.0))
            .collect()
    }

    /// A robot of 0.3 m with a lidar of so many beams, a degree apart.
    fn robot(n_beams: u32) -> Description {
        Description {
            circumscribed_radius_m: 0.3,
            angle_increment_rad: 1.0_f64.to_radians(),
            n_beams,
            ..crate::test_robot::robot()
        }
    }

    /// Lets a robot that sees ahead among hits of the `odom` frame do as it likes for some seconds; its poses.
    fn drive(hits: &[Point2<f64>], time_s: u32) -> Vec<Pose> {
        drive_as(&robot(270), hits, time_s)
    }

    fn drive_as(robot: &Description, hits: &[Point2<f64>], time_s: u32) -> Vec<Pose> {
        let (mut seeker, mut last, mut pose) =
            (PoseSeeker::default(), Twist::REST, Pose::default());
        let mut poses = vec![pose];
        for tick in 0..u64::from(time_s) * 50 {
            let into_base = pose.isometry().inverse();
            let points: Vec<_> = hits.iter().map(|hit| into_base * hit).collect();
            let at = Surroundings {
                run_ns: tick * 20_000_000,
                odom_from_base: pose,
                robot,
                points: &points,
                last,
                period_s: 0.02,
            };
            last = seeker.step(&at).map_or(Twist::REST, |(twist, turns)| {
                assert!(!turns || twist.v_mps.abs() < 1.0e-9, "{twist:?}");
                twist
            });
            pose = pose.then(&last.arc(0.02));
            let near_m = hits.iter().map(|hit| (hit - pose.point()).norm());
            assert!(near_m.fold(f64::INFINITY, f64::min) > 0.3, "{pose:?}");
            poses.push(pose);
        }
        poses
    }

    fn room() -> Vec<Point2<f64>> {
        let corners = [(-2.0, -2.0), (6.0, -2.0), (6.0, 2.0), (-2.0, 2.0)];
        let next = corners.iter().cycle().skip(1);
        corners
            .iter()
            .zip(next)
            .flat_map(|(a, b)| wall(*a, *b))
            .collect()
    }

    #[test]
    fn it_stands_then_turns_once_around_then_drives_short_ways_where_there_is_room() {
        let poses = drive(&room(), 60);
        assert!(poses[..140].iter().all(|pose| *pose == Pose::default()));
        let turned: f64 = (poses[..520].windows(2))
            .map(|two| wrap_angle(two[1].yaw_rad - two[0].yaw_rad))
            .sum();
        assert!((TAU - 0.2..TAU + 0.2).contains(&turned), "{turned}");
        assert!(poses[520].distance_m(&Pose::default()) < 1.0e-9);
        let farthest_m = poses.iter().map(|pose| pose.x_m).fold(0.0, f64::max);
        assert!((1.0..5.7).contains(&farthest_m), "{farthest_m} m");
    }

    #[test]
    fn it_does_not_turn_around_for_a_lidar_that_sees_all_around() {
        let poses = drive_as(&robot(360), &room(), 12);
        let farthest_m = poses.iter().map(|pose| pose.x_m).fold(0.0, f64::max);
        assert!(farthest_m > 1.0, "{farthest_m} m");
        assert!(poses.iter().all(|pose| pose.yaw_rad.abs() < 0.5));
    }

    #[test]
    fn without_room_it_stays() {
        let box_of = |half: f64| {
            let corners = [(-half, -half), (half, -half), (half, half), (-half, half)];
            let next = corners.iter().cycle().skip(1);
            let walls = corners.iter().zip(next).flat_map(|(a, b)| wall(*a, *b));
            walls.collect::<Vec<_>>()
        };
        let poses = drive(&box_of(0.6), 60);
        assert!(poses.iter().all(|it| it.point().coords.norm() < 1.0e-9));
        assert!(poses.iter().any(|it| it.yaw_rad.abs() > 3.0), "it can turn");
    }

    #[test]
    fn it_gives_up_after_some_motions() {
        let poses = drive(&room(), 400);
        let end = poses.len() - 1;
        assert!(poses[end - 2000..].iter().all(|pose| *pose == poses[end]));
    }
}
