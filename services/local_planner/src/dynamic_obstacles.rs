//! Where tracked obstacles will be: discs that drive on and grow less and less certain.

use crate::lanes::data::narrow;
use crate::situation::Future;
use nalgebra::{Point2, Vector2};
use zeronav_msgs::Pose;
use zeronav_msgs::foresight::{FORESEEN_MAX, Foreseen};
use zeronav_msgs::obstacles::{OBSTACLES_MAX, Obstacle};

/// [m/s] below which a tracked obstacle is static: an obstacle like any other.
pub(crate) const STATIC_MPS: f64 = 0.1;

/// [m/s] from which a tracked obstacle surely moves: slower ones may be the end of a wall that the
/// robot passes, and are not waited for.
const WALKING_MPS: f64 = 0.3;

/// [m] within which a dynamic obstacle may be what is in the way, or leave the way soon.
pub(crate) const NEAR_M: f64 = 2.5;

/// Share of its speed by which a tracked obstacle's radius grows at least: who walks may turn.
const TURNS_SHARE: f64 = 0.1;

/// [m] around a tracked obstacle within which points of the scan are its own.
const OWN_POINTS_M: f64 = 0.12;

/// Standard deviations of a predicted position that are added to the radius.
const GROWTH_SIGMAS: f64 = 1.0;

/// [m/s] by which a predicted radius grows at least, if not by [`TURNS_SHARE`] of the speed.
const GROWTH_MPS_MIN: f64 = 0.08;

/// [m] by which a predicted radius grows at most, so that gaps of a crowd stay open.
const GROWTH_M_MAX: f64 = 0.5;

/// [m] within which a tracked obstacle is one of those whose future is told.
const SAME_M: f64 = 0.6;

/// [m] away is what has vanished.
const GONE_M: f64 = 1.0e6;

/// A tracked obstacle, relative to the robot's centre along the axes of the map.
#[derive(Debug, Clone, Copy)]
struct Track {
    at: Point2<f64>,
    velocity: (f64, f64),
    speed_mps: f64,
    radius_m: f64,
    /// Mean variance of the position after `t`: `p0 + p1 t + p2 t^2`. [m^2]
    variance: [f64; 3],
    /// Place among the futures that are told.
    told: Option<usize>,
}

impl Track {
    fn walks(&self) -> bool {
        self.speed_mps >= WALKING_MPS
    }

    /// Centre and grown radius after `elapsed_s`, as predicted. [m]
    fn after(&self, elapsed_s: f64) -> (Point2<f64>, f64) {
        let at = Point2::new(
            self.at.x + self.velocity.0 * elapsed_s,
            self.at.y + self.velocity.1 * elapsed_s,
        );
        let [p0, p1, p2] = self.variance;
        let variance = p0 + (p1 + p2 * elapsed_s) * elapsed_s;
        let grown_m = (GROWTH_SIGMAS * variance.max(0.0).sqrt())
            .max(GROWTH_MPS_MIN.max(TURNS_SHARE * self.speed_mps) * elapsed_s)
            .min(GROWTH_M_MAX);
        (at, self.radius_m + grown_m)
    }
}

/// True when a dynamic obstacle is near a place in the map.
pub(crate) fn is_dynamic_near(obstacles: &[Obstacle], place: &Pose) -> bool {
    nearest_dynamic(obstacles, place).is_some()
}

/// The nearest dynamic obstacle that is near a place in the map.
pub(crate) fn nearest_dynamic<'a>(obstacles: &'a [Obstacle], place: &Pose) -> Option<&'a Obstacle> {
    let near = obstacles.iter().filter_map(|obstacle| {
        let away_m = (obstacle.x_m - place.x_m).hypot(obstacle.y_m - place.y_m);
        let is_dynamic = obstacle.vx_mps.hypot(obstacle.vy_mps) >= STATIC_MPS;
        (away_m < NEAR_M && is_dynamic).then_some((away_m, obstacle))
    });
    let nearest = near.min_by(|a, b| a.0.total_cmp(&b.0));
    nearest.map(|(_, obstacle)| obstacle)
}

/// The tracked obstacles that move, as of one period.
#[derive(Debug, Clone, Default)]
pub(crate) struct DynamicObstacles {
    tracks: Vec<Track>,
    /// Futures that are told, and how old they are. [s]
    told: Vec<Foreseen>,
    told_age_s: f64,
    /// [s] by which they are ahead of the scan.
    ahead_s: f64,
    yaw_rad: f64,
    /// Centres and radii at the ends of the steps of a rollout, steps x tracks. [m]
    table: Vec<[f32; 3]>,
    /// The same as of now.
    current: Vec<[f32; 3]>,
}

impl DynamicObstacles {
    /// Takes in obstacles in the map frame, `age_s` after they were so and `ahead_s` after the scan,
    /// and the future of those that it is told of.
    pub(crate) fn take(
        &mut self,
        obstacles: &[Obstacle],
        (age_s, ahead_s): (f64, f64),
        future: &Future<'_>,
        map_from_base: &Pose,
    ) {
        self.ahead_s = ahead_s;
        self.yaw_rad = map_from_base.yaw_rad;
        self.tracks.clear();
        self.told.clear();
        self.told.extend(future.obstacles.iter().take(FORESEEN_MAX));
        self.told_age_s = future.age_s;
        let centre = map_from_base.point();
        for obstacle in obstacles.iter().take(OBSTACLES_MAX) {
            let speed_mps = obstacle.vx_mps.hypot(obstacle.vy_mps);
            let told = self.told_of(obstacle, age_s);
            if speed_mps < STATIC_MPS && told.is_none() {
                continue;
            }
            let c = &obstacle.covariance;
            // Upper triangle by rows: xx xy xvx xvy, yy yvx yvy, vxvx vxvy, vyvy.
            let [p0, p1, p2] = [0.5 * (c[0] + c[4]), c[2] + c[6], 0.5 * (c[7] + c[9])];
            self.tracks.push(Track {
                at: Point2::new(
                    obstacle.x_m + obstacle.vx_mps * age_s - centre.x,
                    obstacle.y_m + obstacle.vy_mps * age_s - centre.y,
                ),
                velocity: (obstacle.vx_mps, obstacle.vy_mps),
                speed_mps,
                radius_m: obstacle.radius_m,
                variance: [
                    p0 + p1 * age_s + p2 * age_s * age_s,
                    p1 + 2.0 * p2 * age_s,
                    p2,
                ],
                told,
            });
        }
    }

    /// Place among the futures of an obstacle that was so `age_s` ago.
    fn told_of(&self, obstacle: &Obstacle, age_s: f64) -> Option<usize> {
        let then_s = self.told_age_s - age_s;
        let away = self.told.iter().enumerate().filter_map(|(n, told)| {
            let [x, y] = told.at(then_s)?;
            Some((n, (x - obstacle.x_m).hypot(y - obstacle.y_m)))
        });
        let nearest = away.min_by(|a, b| a.1.total_cmp(&b.1));
        nearest
            .filter(|(_, away_m)| *away_m < SAME_M)
            .map(|(n, _)| n)
    }

    /// Centre and radius of a track after `elapsed_s`: as told, else as predicted. [m]
    fn after(&self, track: &Track, elapsed_s: f64) -> (Point2<f64>, f64) {
        let told = track.told.and_then(|told| self.told.get(told));
        let Some(told) = told else {
            return track.after(elapsed_s);
        };
        let now = told.at(self.told_age_s);
        let then = told.at(self.told_age_s + elapsed_s);
        match now.zip(then) {
            Some((now, then)) => {
                let way = Vector2::new(then[0] - now[0], then[1] - now[1]);
                (track.at + way, track.radius_m)
            }
            None => (Point2::new(GONE_M, GONE_M), 0.0),
        }
    }

    /// Where the scan has met it.
    fn seen(&self, track: &Track) -> Point2<f64> {
        let (vx_mps, vy_mps) = track.velocity;
        track.at - Vector2::new(vx_mps, vy_mps) * self.ahead_s
    }

    /// True when a point in `base` belongs to one of them.
    pub(crate) fn owns(&self, point_in_base: Point2<f64>) -> bool {
        if self.tracks.is_empty() {
            return false;
        }
        let (sin, cos) = self.yaw_rad.sin_cos();
        let local = Point2::new(
            cos * point_in_base.x - sin * point_in_base.y,
            sin * point_in_base.x + cos * point_in_base.y,
        );
        self.tracks.iter().any(|track| {
            (local - self.seen(track)).norm_squared() <= (track.radius_m + OWN_POINTS_M).powi(2)
        })
    }

    /// True when one that walks is nearer to the robot's centre than this. [m]
    pub(crate) fn is_within(&self, reach_m: f64) -> bool {
        let mut tracks = self.tracks.iter().filter(|track| track.walks());
        tracks.any(|track| track.at.coords.norm() < reach_m + track.radius_m)
    }

    /// Least distance between a disc of this radius around the robot that stays where it is and
    /// what moves, after `elapsed_s`. Infinite without. [m]
    pub(crate) fn around_m(&self, radius_m: f64, elapsed_s: f64) -> f64 {
        let tracks = self.tracks.iter().filter(|track| track.walks());
        tracks.fold(f64::INFINITY, |least, track| {
            let (at, of_track_m) = self.after(track, elapsed_s);
            least.min(at.coords.norm() - of_track_m - radius_m)
        })
    }

    /// Velocity, in the map frame, of the obstacle that a point in `base` belongs to; zero for
    /// static ones. [m/s]
    pub(crate) fn velocity_at(&self, point_in_base: Point2<f64>) -> Vector2<f64> {
        let (sin, cos) = self.yaw_rad.sin_cos();
        let local = Point2::new(
            cos * point_in_base.x - sin * point_in_base.y,
            sin * point_in_base.x + cos * point_in_base.y,
        );
        self.tracks
            .iter()
            .find(|track| (local - self.seen(track)).norm() <= track.radius_m + OWN_POINTS_M)
            .map_or_else(Vector2::zeros, |track| {
                Vector2::new(track.velocity.0, track.velocity.1)
            })
    }

    /// Predicts every track at the ends of `n` steps that begin `delay_s` from now.
    pub(crate) fn tabulate(&mut self, n: usize, step_s: f64, delay_s: f64) {
        let mut current = core::mem::take(&mut self.current);
        current.clear();
        current.extend(self.tracks.iter().map(|track| {
            let (at, radius_m) = self.after(track, delay_s);
            [narrow(at.x), narrow(at.y), narrow(radius_m)]
        }));
        self.current = current;
        let mut table = core::mem::take(&mut self.table);
        table.clear();
        let mut elapsed_s = delay_s;
        for _ in 0..n {
            elapsed_s += step_s;
            table.extend(self.tracks.iter().map(|track| {
                let (at, radius_m) = self.after(track, elapsed_s);
                [narrow(at.x), narrow(at.y), narrow(radius_m)]
            }));
        }
        self.table = table;
    }

    /// The discs at the end of a step of [`Self::tabulate`]: x, y, radius. [m]
    pub(crate) fn at_step(&self, step: usize) -> &[[f32; 3]] {
        let n = self.tracks.len();
        self.table.get(step * n..(step + 1) * n).unwrap_or(&[])
    }

    /// The discs of now, in the order of [`Self::at_step`].
    pub(crate) fn now(&self) -> &[[f32; 3]] {
        &self.current
    }

    /// Least distance between an outline and the discs after `elapsed_s`, when the robot then
    /// is at `pose` (in the `base` of now). `distance_m` is the signed distance of a point in
    /// `base` from the outline. Infinite without obstacles. [m]
    pub(crate) fn margin_m(
        &self,
        pose: &Pose,
        elapsed_s: f64,
        distance_m: impl Fn(Point2<f64>) -> f64,
    ) -> f64 {
        let base = Pose::new(0.0, 0.0, self.yaw_rad);
        let local_from_base = base.then(pose).isometry().inverse();
        self.tracks.iter().fold(f64::INFINITY, |least, track| {
            let (at, radius_m) = self.after(track, elapsed_s);
            least.min(distance_m(local_from_base * at) - radius_m)
        })
    }

    /// [s] until the discs of the robot (with `radius_m`) and of a track touch when both go on,
    /// `velocity` being the robot's along the axes of the map; infinite when they do not.
    pub(crate) fn contact_s(&self, velocity: (f64, f64), radius_m: f64) -> f64 {
        self.tracks.iter().fold(f64::INFINITY, |least, track| {
            let (vx, vy) = (track.velocity.0 - velocity.0, track.velocity.1 - velocity.1);
            let sum_m = radius_m + track.radius_m;
            let c = track.at.coords.norm_squared() - sum_m * sum_m;
            let (a, b) = (vx * vx + vy * vy, track.at.x * vx + track.at.y * vy);
            if c <= 0.0 {
                return 0.0;
            }
            let root = b * b - a * c;
            if b >= 0.0 || a < 1.0e-12 || root < 0.0 {
                least
            } else {
                least.min((-b - root.sqrt()) / a)
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cart() -> Obstacle {
        Obstacle {
            track: 1,
            x_m: 12.0,
            y_m: 3.0,
            vx_mps: 0.0,
            vy_mps: -1.0,
            radius_m: 0.4,
            covariance: [0.01, 0.0, 0.0, 0.0, 0.01, 0.0, 0.0, 0.04, 0.0, 0.04],
            ..Obstacle::default()
        }
    }

    #[test]
    fn discs_drive_on_and_grow() {
        let mut moving = DynamicObstacles::default();
        moving.take(
            &[cart()],
            (0.5, 0.0),
            &Future::default(),
            &Pose::new(10.0, 1.0, 0.3),
        );
        moving.tabulate(10, 0.1, 0.0);
        // After 1 s: 2 m ahead, 0.5 m aside; sigma^2 = 0.01 + 0.04 * 1.5^2.
        let [x, y, radius] = moving.at_step(9)[0];
        assert!((x - 2.0).abs() < 1e-5 && (y - 0.5).abs() < 1e-5);
        assert!(
            (f64::from(radius) - (0.4 + 0.1_f64.sqrt())).abs() < 1e-5,
            "{radius}"
        );
        let radii: Vec<f32> = (0..10).map(|step| moving.at_step(step)[0][2]).collect();
        assert!(radii.windows(2).all(|pair| pair[1] > pair[0]));
        let far = moving.margin_m(&Pose::default(), 100.0, |point| point.coords.norm() - 0.25);
        assert!((far - (98.5_f64.hypot(2.0) - 0.25 - 0.9)).abs() < 1e-9);
    }

    #[test]
    fn what_stands_is_not_moving_and_points_have_owners() {
        let mut standing = cart();
        standing.vy_mps = 0.0;
        let mut moving = DynamicObstacles::default();
        moving.take(
            &[standing],
            (0.0, 0.0),
            &Future::default(),
            &Pose::new(10.0, 1.0, 0.0),
        );
        assert!(moving.tracks.is_empty());
        moving.take(
            &[cart()],
            (0.0, 0.0),
            &Future::default(),
            &Pose::new(10.0, 1.0, core::f64::consts::FRAC_PI_2),
        );
        // In base the cart is at (2, -2).
        assert!(moving.owns(Point2::new(2.0, -1.6)));
        assert!(!moving.owns(Point2::new(2.0, -1.4)));
    }

    #[test]
    fn contacts_come_when_discs_meet() {
        let mut moving = DynamicObstacles::default();
        moving.take(
            &[cart()],
            (0.0, 0.0),
            &Future::default(),
            &Pose::new(12.0, 0.0, 0.0),
        );
        assert!((moving.contact_s((0.0, 0.0), 0.3) - 2.3).abs() < 1e-9);
        assert!((moving.contact_s((0.0, 1.0), 0.3) - 1.15).abs() < 1e-9);
        assert!(moving.contact_s((1.0, 0.0), 0.3).is_infinite());
    }

    /// What is told of the cart, 0.5 s old: it turns to the east in a second from then.
    fn told_cart() -> Foreseen {
        let mut told = Foreseen {
            radius_m: 0.4,
            lasts_s: 4.0,
            ..Foreseen::default()
        };
        let places = told.x_m.iter_mut().zip(&mut told.y_m);
        for ((x_m, y_m), step) in places.zip(0_u32..) {
            let elapsed_s = 0.1 * f64::from(step);
            *x_m = 12.0 + (elapsed_s - 1.0).max(0.0);
            *y_m = 3.0 - elapsed_s.min(1.0);
        }
        told
    }

    #[test]
    fn a_track_goes_the_way_that_is_told_until_it_vanishes() {
        let told = [told_cart()];
        let future = Future {
            obstacles: &told,
            age_s: 0.5,
        };
        // Tracked 0.1 m beside where it really is.
        let tracked = Obstacle {
            x_m: 12.1,
            ..cart()
        };
        let mut moving = DynamicObstacles::default();
        moving.take(&[tracked], (0.5, 0.0), &future, &Pose::new(10.0, 1.0, 0.3));
        moving.tabulate(40, 0.1, 0.0);
        let near = |step: usize, x_m: f32, y_m: f32| {
            let [x, y, radius] = moving.at_step(step)[0];
            assert!(
                (x - x_m).abs() < 1e-5 && (y - y_m).abs() < 1e-5,
                "{x}, {y} after step {step}"
            );
            assert!((radius - 0.4).abs() < 1e-6, "it is certain");
        };
        near(4, 2.1, 1.0);
        near(14, 3.1, 1.0);
        near(33, 5.0, 1.0);
        // 4 s after it was told it is gone.
        let apart_m = |elapsed_s| {
            let there = Pose::new(5.0, 1.0, 0.0);
            let moving = DynamicObstacles {
                yaw_rad: 0.0,
                ..moving.clone()
            };
            moving.margin_m(&there, elapsed_s, |point| point.coords.norm() - 0.25)
        };
        assert!(apart_m(3.4) < 0.0);
        assert!(apart_m(3.6) > 1.0e5);
        assert!(moving.at_step(35)[0][0] > 1.0e5);
    }

    #[test]
    fn only_tracks_near_what_is_told_follow_it() {
        let told = [told_cart()];
        let future = Future {
            obstacles: &told,
            age_s: 0.0,
        };
        let far = Obstacle {
            x_m: 12.7,
            ..cart()
        };
        // It stands still for now, and will not.
        let waiting = Obstacle {
            vy_mps: 0.0,
            ..cart()
        };
        let standing = Obstacle { vy_mps: 0.0, ..far };
        let mut moving = DynamicObstacles::default();
        let here = Pose::new(10.0, 1.0, 0.0);
        moving.take(&[far, waiting, standing], (0.0, 0.0), &future, &here);
        moving.tabulate(20, 0.1, 0.0);
        let [[x, y, _], [told_x, told_y, _]] = moving.at_step(19) else {
            panic!("{:?}", moving.tracks)
        };
        assert!((x - 2.7).abs() < 1e-5 && y.abs() < 1e-5, "{x}, {y}");
        assert!((told_x - 3.0).abs() < 1e-5 && (told_y - 1.0).abs() < 1e-5);
    }
}
