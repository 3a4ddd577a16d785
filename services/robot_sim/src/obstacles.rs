//! Scripted obstacles: when they are there and where.

use crate::bounce::Bounce;
use nalgebra::Point2;
use zeronav_casts::Cast;
use zeronav_msgs::Pose;
use zeronav_msgs::pose::wrap_angle;
use zeronav_msgs::time::{nanoseconds, seconds};
use zeronav_world::spec::Trigger;
use zeronav_world::track::Track;
use zeronav_world::{Convex, World};

/// A scripted obstacle in the course of a run.
///
/// It appears once: at the start, at its time, or when the robot came near (latched). It exists
/// from that moment to `lasts_s` later, and moves without turning, from its appearance or from a
/// moment of its own.
#[derive(Debug, Clone)]
pub struct Obstacle {
    /// In its own frame.
    form: Convex,
    /// Where it appears, `map_from_shape`.
    start: Pose,
    way: ObstacleMotion,
    appears: Latch,
    lasts_ns: Option<u64>,
    /// The newest placement: its `from_run_ns` and its pose.
    placed_from: Option<(u64, Pose)>,
    /// When it begins to move; `None` = when it appears.
    starts: Option<Latch>,
}

/// How it moves.
#[derive(Debug, Clone)]
enum ObstacleMotion {
    /// Not at all, or along waypoints.
    Walk(Route),
    /// Straight, and off what it meets.
    Bounce(Bounce),
    /// As it was recorded.
    Play(Track),
}

/// A moment that comes by itself or with the robot.
#[derive(Debug, Clone, Copy)]
struct Latch {
    near: Option<(Point2<f64>, f64)>,
    run_ns: Option<u64>,
}

impl Latch {
    fn new(trigger: Option<&Trigger>) -> Self {
        let near = trigger
            .and_then(|trigger| trigger.robot_near.as_ref())
            .map(|near| (Point2::from(near.point_m), near.distance_m));
        let at_s = trigger.and_then(|trigger| trigger.at_s).unwrap_or(0.0);
        Self {
            run_ns: near.is_none().then(|| nanoseconds(at_s)),
            near,
        }
    }

    fn notice(&mut self, robot: Point2<f64>, run_ns: u64) {
        if self.run_ns.is_none()
            && let Some((point, distance_m)) = self.near
            && (robot - point).norm() <= distance_m
        {
            self.run_ns = Some(run_ns);
        }
    }
}

impl Obstacle {
    /// The obstacle that the world describes, before the run.
    #[must_use]
    pub fn new(obstacle: &zeronav_world::Obstacle) -> Self {
        let spec = &obstacle.spec;
        let start = obstacle.shape.pose();
        let way = if let Some(velocity_mps) = spec.bounces_mps {
            let radius_m = obstacle
                .shape
                .form()
                .form()
                .as_ball()
                .map_or(0.0, |ball| ball.radius);
            ObstacleMotion::Bounce(Bounce::new(start.point(), velocity_mps.into(), radius_m))
        } else if spec.track.is_empty() {
            let (from, speed_mps) = (start.point(), spec.speed_mps);
            ObstacleMotion::Walk(Route::new(from, &spec.waypoints_m, speed_mps, spec.repeat))
        } else {
            ObstacleMotion::Play(Track::new(&spec.track, spec.repeat, spec.track_from_s))
        };
        Self {
            form: obstacle.shape.form().clone(),
            start: Pose::new(start.x_m, start.y_m, wrap_angle(start.yaw_rad)),
            way,
            appears: Latch::new(spec.appears.as_ref()),
            lasts_ns: spec.lasts_s.map(nanoseconds),
            placed_from: None,
            starts: spec
                .starts
                .as_ref()
                .map(|trigger| Latch::new(Some(trigger))),
        }
    }

    /// An obstacle that is nowhere until it is placed.
    #[must_use]
    pub(crate) fn absent(form: Convex) -> Self {
        Self {
            form,
            start: Pose::default(),
            way: ObstacleMotion::Walk(Route::new(Point2::origin(), &[], 0.0, false)),
            appears: Latch {
                near: None,
                run_ns: Some(u64::MAX),
            },
            lasts_ns: None,
            placed_from: None,
            starts: None,
        }
    }

    /// Changes what it covers, in its own frame.
    pub(crate) fn take_form(&mut self, form: Convex) {
        self.form = form;
    }

    /// Puts it at `pose`, where it is from `from_run_ns` to before `until_run_ns` (`None` = to
    /// the end), whatever its script says. Said again with the same `from_run_ns` and `pose`,
    /// only the end changes.
    pub fn place(&mut self, pose: Pose, from_run_ns: u64, until_run_ns: Option<u64>) {
        if self.placed_from != Some((from_run_ns, pose)) {
            self.placed_from = Some((from_run_ns, pose));
            self.start = Pose::new(pose.x_m, pose.y_m, wrap_angle(pose.yaw_rad));
            self.way = ObstacleMotion::Walk(Route::new(self.start.point(), &[], 0.0, false));
            self.starts = None;
            self.appears = Latch {
                near: None,
                run_ns: Some(from_run_ns),
            };
        }
        self.lasts_ns = until_run_ns.map(|until_ns| until_ns.saturating_sub(from_run_ns));
    }

    /// Appears or starts now, at `run_ns`, if it waits for the robot and the robot's centre is
    /// near enough.
    pub fn notice(&mut self, robot: Point2<f64>, run_ns: u64) {
        self.appears.notice(robot, run_ns);
        if let Some(starts) = &mut self.starts {
            starts.notice(robot, run_ns);
        }
    }

    /// Looks as far ahead as `run_ns` at what it will bounce off in `world`. What bounces can be
    /// asked about its pose up to there, and back for as long as the slowest lidar turns.
    pub fn look_ahead(&mut self, world: &World, run_ns: u64) {
        let moved_s = self.moved_s(run_ns);
        if let ObstacleMotion::Bounce(bounce) = &mut self.way {
            bounce.look_ahead(world, moved_s);
        }
    }

    /// Run time at which it appears or appeared; `None` while it waits for the robot. [ns]
    #[must_use]
    pub const fn appears_run_ns(&self) -> Option<u64> {
        self.appears.run_ns
    }

    /// Run time from which it is gone; `None` = it stays, or has not appeared. [ns]
    #[must_use]
    pub(crate) fn vanishes_run_ns(&self) -> Option<u64> {
        let lasts_ns = self.lasts_ns?;
        Some(self.appears.run_ns?.saturating_add(lasts_ns))
    }

    /// The first moment after `run_ns` at which it appears or is somewhere else at once. [ns]
    #[must_use]
    pub fn next_jump_run_ns(&self, run_ns: u64) -> Option<u64> {
        let appears_ns = self.appears.run_ns?;
        if appears_ns > run_ns {
            return Some(appears_ns);
        }
        let from_ns = self.moves_from_run_ns()?;
        let ObstacleMotion::Play(track) = &self.way else {
            return None;
        };
        let moved_s = self.moved_s(run_ns);
        let jump_ns = (track.next_jump_s(moved_s)? * 1.0e9).ceil().to_u64();
        Some(from_ns.saturating_add(jump_ns).max(run_ns + 1))
    }

    /// True from the moment of its appearance until it vanishes.
    #[must_use]
    pub fn exists_at(&self, run_ns: u64) -> bool {
        self.appears.run_ns.is_some_and(|appears_ns| {
            run_ns >= appears_ns
                && self
                    .lasts_ns
                    .is_none_or(|lasts_ns| run_ns - appears_ns < lasts_ns)
        })
    }

    /// `map_from_shape` at `run_ns`, where it appears before that.
    #[must_use]
    pub fn pose_at(&self, run_ns: u64) -> Pose {
        let moved_s = self.moved_s(run_ns);
        let at = match &self.way {
            ObstacleMotion::Walk(route) => route.at(moved_s),
            ObstacleMotion::Bounce(bounce) => bounce.at(moved_s),
            ObstacleMotion::Play(track) => track.at(moved_s),
        };
        Pose::new(at.x, at.y, self.start.yaw_rad)
    }

    /// Greatest speed on its way; jumps are none. [m/s]
    #[must_use]
    pub fn speed_mps(&self) -> f64 {
        match &self.way {
            ObstacleMotion::Walk(route) => route.speed_mps,
            ObstacleMotion::Bounce(bounce) => bounce.speed_mps(),
            ObstacleMotion::Play(track) => track.speed_mps_max(),
        }
    }

    /// What it covers at `run_ns`, `map` frame. No allocation.
    #[must_use]
    pub fn placed_at(&self, run_ns: u64) -> Convex {
        self.form.placed(&self.pose_at(run_ns))
    }

    fn moves_from_run_ns(&self) -> Option<u64> {
        let appears_ns = self.appears.run_ns?;
        match &self.starts {
            Some(starts) => starts.run_ns.map(|starts_ns| starts_ns.max(appears_ns)),
            None => Some(appears_ns),
        }
    }

    /// How long it has been moving. [s]
    fn moved_s(&self, run_ns: u64) -> f64 {
        let from_ns = self.moves_from_run_ns();
        seconds(from_ns.map_or(0, |from_ns| run_ns.saturating_sub(from_ns)))
    }
}

/// A chain of points that is walked at constant speed.
#[derive(Debug, Clone)]
struct Route {
    /// The point where it begins, then the waypoints, then, to repeat, the first waypoint again.
    points: Vec<Point2<f64>>,
    /// Distance along the route from its start to each point. [m]
    at_m: Vec<f64>,
    /// Distance along the route from its start to the first waypoint, where a repeated round begins. [m]
    lead_m: f64,
    /// Length of a round that repeats; `None` when the walk ends at the last waypoint. [m]
    round_m: Option<f64>,
    speed_mps: f64,
}

impl Route {
    fn new(from: Point2<f64>, waypoints_m: &[[f64; 2]], speed_mps: f64, repeat: bool) -> Self {
        let mut points = vec![from];
        points.extend(waypoints_m.iter().map(|at| Point2::from(*at)));
        if repeat && points.len() > 1 {
            points.push(points[1]);
        }
        let mut at_m = vec![0.0];
        for pair in points.windows(2) {
            let so_far_m = at_m.last().copied().unwrap_or(0.0);
            at_m.push(so_far_m + (pair[1] - pair[0]).norm());
        }
        let lead_m = at_m.get(1).copied().unwrap_or(0.0);
        let round_m = at_m.last().copied().unwrap_or(0.0) - lead_m;
        Self {
            points,
            at_m,
            lead_m,
            round_m: (repeat && round_m > 0.0).then_some(round_m),
            speed_mps,
        }
    }

    /// The point reached after `moved_s`.
    fn at(&self, moved_s: f64) -> Point2<f64> {
        let mut way_m = self.speed_mps * moved_s;
        if let Some(round_m) = self.round_m
            && way_m > self.lead_m
        {
            way_m = self.lead_m + (way_m - self.lead_m) % round_m;
        }
        // The leg that holds `way_m`, or the end of the last.
        let next = self.at_m.partition_point(|at_m| *at_m <= way_m);
        let (Some(to), Some(to_m)) = (self.points.get(next), self.at_m.get(next)) else {
            return self.points[self.points.len() - 1];
        };
        let (from, from_m) = (self.points[next - 1], self.at_m[next - 1]);
        from + (to - from) * ((way_m - from_m) / (to_m - from_m))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use parry2d::math::Vec2;
    use zeronav_world::spec::{Near, Trigger};
    use zeronav_world::{ObstacleSpec, Shape, ShapeSpec};

    const SECOND_NS: u64 = 1_000_000_000;

    fn spec() -> ObstacleSpec {
        ObstacleSpec {
            name: "walker".to_owned(),
            shape: ShapeSpec::Box {
                centre_m: [1.0, 2.0],
                size_m: [0.4, 0.2],
                yaw_rad: 0.5,
            },
            waypoints_m: vec![[4.0, 6.0], [4.0, 4.0]],
            speed_mps: 2.0,
            ..ObstacleSpec::standing("", disc_in_middle())
        }
    }

    fn disc_in_middle() -> ShapeSpec {
        ShapeSpec::Disc {
            centre_m: [0.0, 0.0],
            radius_m: 0.5,
        }
    }

    fn obstacle(spec: &ObstacleSpec) -> Obstacle {
        Obstacle::new(&zeronav_world::Obstacle {
            spec: spec.clone(),
            shape: Shape::new(&spec.shape).expect("a shape"),
        })
    }

    #[track_caller]
    fn check_at(obstacle: &Obstacle, run_ns: u64, x_m: f64, y_m: f64) {
        let at = obstacle.pose_at(run_ns);
        let apart_m = (at.point() - Point2::new(x_m, y_m)).norm();
        assert!(apart_m < 1e-9, "{at:?} instead of {x_m}, {y_m}");
    }

    #[test]
    fn waypoints_are_visited_at_constant_speed_without_turning() {
        // 5 m to the first waypoint, 2 m to the second, at 2 m/s.
        let walker = obstacle(&spec());
        check_at(&walker, 0, 1.0, 2.0);
        check_at(&walker, SECOND_NS, 2.2, 3.6);
        check_at(&walker, 5 * SECOND_NS / 2, 4.0, 6.0);
        check_at(&walker, 3 * SECOND_NS, 4.0, 5.0);
        check_at(&walker, 100 * SECOND_NS, 4.0, 4.0);
        assert!((walker.pose_at(SECOND_NS).yaw_rad - 0.5).abs() < 1e-12);
        let middle = walker.placed_at(3 * SECOND_NS).bounds().center();
        assert!(middle.distance(Vec2::new(4.0, 5.0)) < 1e-9);
    }

    #[test]
    fn a_round_begins_again_at_the_first_waypoint() {
        let mut spec = spec();
        spec.repeat = true;
        let walker = obstacle(&spec);
        // 5 m lead, then rounds of 2 m down and 2 m up.
        check_at(&walker, 7 * SECOND_NS / 2, 4.0, 4.0);
        check_at(&walker, 4 * SECOND_NS, 4.0, 5.0);
        check_at(&walker, 9 * SECOND_NS / 2, 4.0, 6.0);
        check_at(&walker, (4500 + 2000 * 1000 + 250) * 1_000_000, 4.0, 5.5);
        // A round of no length is standing there.
        spec.waypoints_m.truncate(1);
        check_at(&obstacle(&spec), 100 * SECOND_NS, 4.0, 6.0);
        spec.waypoints_m = vec![[4.0, 6.0], [4.0, 6.0]];
        check_at(&obstacle(&spec), 100 * SECOND_NS, 4.0, 6.0);
    }

    #[test]
    fn a_time_is_kept_to_the_nanosecond() {
        let mut spec = spec();
        spec.appears = Some(Trigger {
            at_s: Some(2.005),
            robot_near: None,
        });
        spec.lasts_s = Some(1.0);
        let walker = obstacle(&spec);
        assert_eq!(walker.appears_run_ns(), Some(2_005_000_000));
        assert!(!walker.exists_at(2_004_999_999));
        assert!(walker.exists_at(2_005_000_000));
        assert!(walker.exists_at(3_004_999_999));
        assert!(!walker.exists_at(3_005_000_000));
        check_at(&walker, 2_005_000_000, 1.0, 2.0);
        check_at(&walker, 3_005_000_000, 2.2, 3.6);
    }

    #[test]
    fn a_placement_overrules_the_script_and_can_be_ended() {
        let mut walker = obstacle(&spec());
        let there = Pose::new(7.0, 8.0, 0.25);
        walker.place(there, 5 * SECOND_NS, None);
        assert!(!walker.exists_at(5 * SECOND_NS - 1));
        assert!(walker.exists_at(5 * SECOND_NS) && walker.exists_at(u64::MAX));
        check_at(&walker, 9 * SECOND_NS, 7.0, 8.0);
        assert!((walker.pose_at(9 * SECOND_NS).yaw_rad - 0.25).abs() < 1e-12);
        let middle = walker.placed_at(9 * SECOND_NS).bounds().center();
        assert!(middle.distance(Vec2::new(7.0, 8.0)) < 1e-9);
        // Ended where it is.
        walker.place(there, 5 * SECOND_NS, Some(6 * SECOND_NS));
        assert!(walker.exists_at(6 * SECOND_NS - 1) && !walker.exists_at(6 * SECOND_NS));
        check_at(&walker, 5 * SECOND_NS, 7.0, 8.0);
        walker.place(Pose::default(), 8 * SECOND_NS, None);
        assert!(!walker.exists_at(7 * SECOND_NS) && walker.exists_at(8 * SECOND_NS));
        check_at(&walker, 8 * SECOND_NS, 0.0, 0.0);
        // Moved twice within a tick: the last pose counts.
        walker.place(there, 8 * SECOND_NS, None);
        check_at(&walker, 8 * SECOND_NS, 7.0, 8.0);
    }

    #[test]
    fn nearness_is_latched_once() {
        let mut spec = spec();
        spec.appears = Some(Trigger {
            at_s: None,
            robot_near: Some(Near {
                point_m: [0.0, 0.0],
                distance_m: 1.0,
            }),
        });
        let mut walker = obstacle(&spec);
        walker.notice(Point2::new(1.001, 0.0), SECOND_NS);
        assert_eq!(walker.appears_run_ns(), None);
        assert!(!walker.exists_at(u64::MAX));
        walker.notice(Point2::new(0.6, 0.8), 2 * SECOND_NS);
        assert_eq!(walker.appears_run_ns(), Some(2 * SECOND_NS));
        walker.notice(Point2::new(9.0, 9.0), 3 * SECOND_NS);
        walker.notice(Point2::new(0.0, 0.0), 4 * SECOND_NS);
        assert_eq!(walker.appears_run_ns(), Some(2 * SECOND_NS));
        check_at(&walker, 3 * SECOND_NS, 2.2, 3.6);
    }

    #[test]
    fn a_door_stands_until_it_is_told_to_slide() {
        let mut spec = spec();
        spec.starts = Some(Trigger {
            at_s: None,
            robot_near: Some(Near {
                point_m: [0.0, 0.0],
                distance_m: 1.0,
            }),
        });
        let mut door = obstacle(&spec);
        assert!(door.exists_at(0));
        check_at(&door, 9 * SECOND_NS, 1.0, 2.0);
        door.notice(Point2::new(0.5, 0.0), 10 * SECOND_NS);
        check_at(&door, 10 * SECOND_NS, 1.0, 2.0);
        check_at(&door, 11 * SECOND_NS, 2.2, 3.6);
        // It cannot move before it is there.
        spec.appears = Some(Trigger {
            at_s: Some(5.0),
            robot_near: None,
        });
        spec.starts = Some(Trigger {
            at_s: Some(1.0),
            robot_near: None,
        });
        check_at(&obstacle(&spec), 6 * SECOND_NS, 2.2, 3.6);
    }

    #[test]
    fn a_recorded_track_is_played_from_any_moment_and_jumps_are_known() {
        let spec = ObstacleSpec {
            track: vec![[0.0, 0.0, 0.0], [4.0, 8.0, 0.0]],
            track_from_s: 1.0,
            repeat: true,
            ..ObstacleSpec::standing("cylinder", disc_in_middle())
        };
        let cylinder = obstacle(&spec);
        check_at(&cylinder, 0, 2.0, 0.0);
        check_at(&cylinder, SECOND_NS, 4.0, 0.0);
        assert!((cylinder.speed_mps() - 2.0).abs() < 1e-12);
        assert_eq!(cylinder.next_jump_run_ns(0), Some(3 * SECOND_NS));
        assert_eq!(
            cylinder.next_jump_run_ns(3 * SECOND_NS),
            Some(7 * SECOND_NS)
        );
        check_at(&cylinder, 3 * SECOND_NS, 0.0, 0.0);
    }
}
