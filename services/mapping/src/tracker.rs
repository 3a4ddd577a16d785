//! What moves: clusters of scan points, followed from scan to scan.
//!
//! A track begins with a cluster that the map does not explain, is confirmed by the third hit and
//! is called moving when its speed is clear of its uncertainty, it has come some way, and it was
//! seen to leave where it was or to enter what was free (`past_scans.rs`): the visible end
//! of a wall slides along when the robot drives past, but nothing is ever seen through it.

use crate::beams::{Beam, Beams};
use crate::clusters::{Cluster, Clusters};
use crate::fit::{Fit, Place, disc_through, fit};
use crate::form::Form;
use crate::near_points::noise_m;
use crate::past_scans::PastScans;
use crate::track::Track;
use nalgebra::{Matrix2, Point2, Vector2};
use zeronav_casts::Cast;
use zeronav_msgs::Pose;
use zeronav_msgs::obstacles::{OBSTACLES_MAX, Obstacle};
use zeronav_msgs::scan::Scan;
use zeronav_msgs::time::{nanoseconds, seconds};
use zeronav_params::parameters;

/// 99 % of a chi-squared variable with two degrees of freedom lie below.
const GATE: f64 = 9.21;

/// Clusters farther than this from where a track should be are not even looked at. [m]
const NEAR_M: f64 = 1.2;

/// Scans with a hit that confirm a track.
const HITS_TO_CONFIRM: u32 = 3;

/// How far from where a track should be its points may lie, for what its place and form are not
/// known. [m]
const RESTLESS_MARGIN_M: f64 = 0.15;

/// How long after something moved more of it is expected. [s]
const MOTION_LASTS_S: f64 = 5.0;

/// Standard deviations of the yaw by which a static obstacle may seem to have moved.
const YAW_SIGMAS: f64 = 2.0;

/// Standard deviation of a point of a scan across what it lies on. [m]
const POINT_SIGMA_M: f64 = 0.02;

/// How long what moves keeps an acceleration. [s]
const ACCELERATION_LASTS_S: f64 = 0.1;

/// Standard deviations of a hit by which what is seen to have moved must have moved, where that is more than the
/// configuration's gap.
const GAP_SIGMAS: f64 = 5.0;

/// Share of a cluster's points that must be seen to have moved, and the least number.
const SEEN_MOVING: (f64, usize) = (0.25, 2);

/// Fewest points of a cluster: two would be found on every edge between near and far beams.
const POINTS_MIN: usize = 3;

/// Time after the last hit at which a track ends: three scans of a lidar at 10 Hz. [s]
const COAST_S: f64 = 0.3;

/// The same for an occluded track, which is kept so that it can be re-associated. [s]
const HIDDEN_S: f64 = 1.5;

/// Standard deviations of the filter's speed above which a track may be called moving.
const MOVING_SIGMAS: f64 = 2.0;

/// Distance that a track must have moved before it is called moving: more than the noise of a
/// centre. [m]
const MOVING_DISTANCE_M: f64 = 0.1;

/// Speed below which a track that moved comes to rest, above the noise of a static one's. [m/s]
const REST_SPEED_MPS: f64 = 0.15;

/// Time at rest after which a track is static again, so that a short stop does not end it. [s]
const REST_S: f64 = 1.0;

parameters! {
    /// What is taken for a moving obstacle.
    #[derive(Copy)]
    pub struct TrackingConfig {
        /// Whether anything is tracked.
        enabled: bool = true;
        /// Distance between neighbouring points of one cluster, besides twice the distance of
        /// beams; and how far around a point an earlier scan must have seen free space for the
        /// point to be new.
        gap_m: f64 = 0.1, [1.0e-3, 10.0] "m";
        /// Largest radius of a moving obstacle.
        radius_m_max: f64 = 0.6, [1.0e-3, 10.0] "m";
        /// Range beyond which nothing is tracked: points lie far apart there.
        range_m_max: f64 = 12.0, [0.1, 1.0e3] "m";
        /// Distance from an obstacle of the static map within which points belong to that obstacle.
        static_margin_m: f64 = 0.15, [0.0, 1.0] "m";
        /// Standard deviation of a measured centre.
        position_sigma_m: f64 = 0.02, [1.0e-3, 1.0] "m";
        /// Standard deviation of an obstacle's acceleration.
        acceleration_sigma_mps2: f64 = 1.0, [1.0e-3, 100.0] "m/s^2";
    }
}

/// A scan as the tracker sees it.
#[derive(Debug, Clone, Copy)]
pub struct ScanView<'a> {
    /// As it came.
    pub scan: &'a Scan,
    /// As they came. [m]
    pub ranges: &'a [f32],
    /// The same as beams of some frame.
    pub beams: &'a Beams,
    /// Where that frame lies in the map.
    pub map_from_frame: Pose,
    /// Where the laser was at the end of the scan.
    pub map_from_laser: Pose,
    /// Run time of the capture. [ns]
    pub run_ns: u64,
    /// How much variance the yaw has gathered so far; 0 where the pose is exact. [rad^2]
    pub yaw_variance: f64,
}

/// A cluster that may be an obstacle of its own.
#[derive(Debug, Clone, Copy)]
struct Detection {
    cluster: Cluster,
    fit: Fit,
    /// The track that it belongs to.
    track: Option<usize>,
}

/// Tracks and the memory they are kept with. See the module's description.
#[derive(Debug)]
pub struct Tracker {
    config: TrackingConfig,
    clusters: Clusters,
    past: PastScans,
    tracks: Vec<Track>,
    next_number: u64,
    run_ns: u64,
    /// Of the last scan. [rad^2]
    yaw_variance: f64,
    /// Standard deviation of the last scan's hits across what they lie on. [m]
    noise_m: f64,
    /// Scratch: its hits. [m]
    hits: Vec<Point2<f64>>,
    /// When something moved last. [ns]
    moved_ns: Option<u64>,
    seen: Vec<Detection>,
    /// Squared Mahalanobis distance, track, place in `seen`.
    pairs: Vec<(f64, usize, usize)>,
    /// One entry per beam: it ended on something that moves.
    moving_beams: Vec<bool>,
}

impl Tracker {
    /// No tracks.
    #[must_use]
    pub fn new(config: &TrackingConfig) -> Self {
        Self {
            config: *config,
            clusters: Clusters::default(),
            past: PastScans::default(),
            tracks: Vec::with_capacity(OBSTACLES_MAX),
            next_number: 1,
            run_ns: 0,
            yaw_variance: 0.0,
            noise_m: 0.0,
            hits: Vec::new(),
            moved_ns: None,
            seen: Vec::new(),
            pairs: Vec::new(),
            moving_beams: Vec::new(),
        }
    }

    /// Forgets everything that was followed; numbers are not given again.
    pub fn restart(&mut self) {
        *self = Self {
            next_number: self.next_number,
            ..Self::new(&self.config)
        };
    }

    /// Follows everything into a scan. Points for which `is_background` holds are the map's.
    pub fn follow(&mut self, view: &ScanView<'_>, is_background: impl Fn(Point2<f64>) -> bool) {
        self.moving_beams.clear();
        self.moving_beams.resize(view.ranges.len(), false);
        let dt_s = seconds(view.run_ns.saturating_sub(self.run_ns));
        self.run_ns = view.run_ns;
        self.yaw_variance = view.yaw_variance;
        self.hits.clear();
        self.hits
            .extend(view.beams.as_slice().iter().filter_map(Beam::point));
        self.noise_m = noise_m(&self.hits);
        self.end_lost();
        let acceleration_m2ps3 = self.config.acceleration_sigma_mps2.powi(2) * ACCELERATION_LASTS_S;
        for track in &mut self.tracks {
            track.just_moving = false;
            track.filter.predict(dt_s, acceleration_m2ps3);
        }
        self.clusters.find(
            view.beams,
            &view.map_from_frame,
            (self.config.gap_m, self.config.range_m_max),
            is_background,
        );
        let eye = view.map_from_laser.point();
        self.look(eye);
        self.associate(eye);
        let sweep = view.beams.sweep().seen_from(&view.map_from_frame);
        self.past.push(view.scan, view.ranges, &sweep, view.run_ns);
        for n in 0..self.seen.len() {
            match self.seen[n].track {
                Some(track) => self.hit(track, n, eye),
                None => self.begin(n, eye),
            }
        }
        let now_ns = view.run_ns;
        let mut tracks = self.tracks.iter();
        if tracks.any(|track| track.moving && track.hit_ns == now_ns) {
            self.moved_ns = Some(view.run_ns);
        }
    }

    /// Forgets what was followed, and follows these into a scan: they move.
    pub(crate) fn replace(&mut self, view: &ScanView<'_>, tracks: impl Iterator<Item = Track>) {
        (self.run_ns, self.yaw_variance) = (view.run_ns, view.yaw_variance);
        self.tracks.clear();
        self.tracks.extend(tracks);
        if !self.tracks.is_empty() {
            self.moved_ns = Some(view.run_ns);
        }
        let map_from_frame = view.map_from_frame.isometry();
        let tracks = &self.tracks;
        let ends = view.beams.as_slice().iter().map(Beam::point);
        self.moving_beams.clear();
        self.moving_beams.extend(ends.map(|end| {
            end.is_some_and(|end| {
                let end = map_from_frame * end;
                tracks.iter().any(|track| {
                    let reach_m = track.form.radius_m + RESTLESS_MARGIN_M;
                    (end - track.filter.position()).norm_squared() <= reach_m * reach_m
                })
            })
        }));
    }

    /// True per beam of the last scan when it ended on something that moves.
    #[must_use]
    pub fn moving_beams(&self) -> &[bool] {
        &self.moving_beams
    }

    /// True when something moves at `run_ns`, or did a moment ago: who comes into view is not known
    /// to move at once.
    #[must_use]
    pub fn sees_motion(&self, run_ns: u64) -> bool {
        let ago_ns = |moved_ns| run_ns.saturating_sub(moved_ns);
        self.moved_ns
            .is_some_and(|moved_ns| ago_ns(moved_ns) <= nanoseconds(MOTION_LASTS_S))
    }

    /// True when a point of the map is where something should be at `run_ns` that moves, or that
    /// seems to, however uncertain that is.
    #[must_use]
    pub fn may_be_dynamic_at(&self, point_in_map: Point2<f64>, run_ns: u64) -> bool {
        let ahead_s = seconds(run_ns.saturating_sub(self.run_ns));
        self.tracks.iter().any(|track| {
            let place = track.filter.position() + track.filter.velocity() * ahead_s;
            let reach_m = track.form.radius_m + RESTLESS_MARGIN_M;
            (point_in_map - place).norm_squared() <= reach_m * reach_m
                && (track.moving || track.filter.velocity().norm() > REST_SPEED_MPS)
        })
    }

    /// Calls `see` with the places, and how far around them, at which something was seen before
    /// the last scan showed that it moves.
    pub fn new_trails(&self, mut see: impl FnMut(Point2<f64>, f64)) {
        for track in self.tracks.iter().filter(|track| track.just_moving) {
            for place in track.trail.iter() {
                see(place, track.form.radius_m);
            }
        }
    }

    /// What moves, as `map/obstacles` says it, oldest track first.
    pub fn obstacles(&self) -> impl Iterator<Item = Obstacle> + '_ {
        let moving = self.tracks.iter().filter(|track| track.moving);
        moving.map(|track| track.obstacle(self.run_ns))
    }

    /// Ends the tracks that were not seen for too long.
    fn end_lost(&mut self) {
        let (now_ns, gap_m) = (self.run_ns, self.config.gap_m);
        let newest = self.past.newest();
        self.tracks.retain(|track| {
            let hidden = track.moving
                && newest.is_some_and(|scan| {
                    scan.is_hidden(track.filter.position(), track.form.radius_m + gap_m)
                });
            let lasts_s = if hidden { HIDDEN_S } else { COAST_S };
            now_ns.saturating_sub(track.hit_ns) <= nanoseconds(lasts_s)
        });
    }

    /// Decides which clusters may be obstacles of their own.
    fn look(&mut self, eye: Point2<f64>) {
        self.seen.clear();
        for cluster in self.clusters.as_slice() {
            let points = self.clusters.points(cluster);
            let diameter_m = 2.0 * self.config.radius_m_max;
            let (Some(first), Some(last)) = (points.first(), points.last()) else {
                continue;
            };
            if points.len() < POINTS_MIN || (first.at - last.at).norm() > diameter_m {
                continue;
            }
            let places = points.iter().map(|point| point.at);
            let fitted = fit(places, eye, self.config.radius_m_max);
            if let Some(fit) = fitted.filter(|fit| fit.radius_m() <= self.config.radius_m_max) {
                self.seen.push(Detection {
                    cluster: *cluster,
                    fit,
                    track: None,
                });
            }
        }
    }

    /// Gives clusters to tracks: the nearest pair of all first, each at most once.
    fn associate(&mut self, eye: Point2<f64>) {
        self.pairs.clear();
        for (t, track) in self.tracks.iter().enumerate() {
            for (n, seen) in self.seen.iter().enumerate() {
                let points = self.clusters.points(&seen.cluster);
                let near = points
                    .first()
                    .is_some_and(|point| (point.at - track.filter.position()).norm() < NEAR_M);
                if !near {
                    continue;
                }
                let place = self.measured(&track.form, seen, eye);
                if let Some(distance) = track.filter.distance(place.centre, &place.covariance)
                    && distance <= GATE
                {
                    self.pairs.push((distance, t, n));
                }
            }
        }
        self.pairs
            .sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        for (_, t, n) in &self.pairs {
            let taken = self.seen.iter().any(|seen| seen.track == Some(*t));
            if !taken && self.seen[*n].track.is_none() {
                self.seen[*n].track = Some(*t);
            }
        }
    }

    /// Where something of this form is, judged by a cluster.
    fn measured(&self, form: &Form, seen: &Detection, eye: Point2<f64>) -> Place {
        let variance = self.config.position_sigma_m.max(self.noise_m).powi(2);
        let even = Matrix2::from_diagonal_element(variance);
        let points = self.clusters.points(&seen.cluster);
        let places = points.iter().map(|point| point.at);
        let (middle, along, half_m) = match seen.fit {
            Fit::Circle { centre, radius_m } => (centre, None, radius_m),
            Fit::Segment {
                middle,
                along,
                half_m,
            } => (middle, Some(along), half_m),
        };
        if form.is_round() {
            let radius = (form.radius_m, form.radius_sigma_m());
            if let Some(place) = disc_through(&places, eye, radius, POINT_SIGMA_M) {
                return Place {
                    covariance: even + place.covariance,
                    ..place
                };
            }
        }
        // Of what is partly hidden the middle may lie anywhere along what is seen of it.
        let slides = seen.cluster.hidden || half_m < 0.7 * form.radius_m;
        let across = along.unwrap_or_else(|| {
            let view = (middle - eye).try_normalize(1.0e-9).unwrap_or(Vector2::x());
            Vector2::new(-view.y, view.x)
        });
        let slide = if slides {
            form.radius_m.max(half_m).powi(2)
        } else {
            0.0
        };
        Place {
            centre: middle,
            covariance: even + across * across.transpose() * slide,
        }
    }

    /// Takes a cluster into its track.
    fn hit(&mut self, track: usize, n: usize, eye: Point2<f64>) {
        let seen = self.seen[n];
        let Some(mut followed) = self.tracks.get(track).copied() else {
            return;
        };
        let was_round = followed.form.is_round();
        followed.form.see(&seen.fit, seen.cluster.hidden);
        let place = self.measured(&followed.form, &seen, eye);
        if was_round != followed.form.is_round() {
            followed.born_at += place.centre - followed.filter.position();
            followed.filter.place(place.centre);
        }
        followed.filter.update(place.centre, &place.covariance);
        followed.hits += 1;
        followed.hit_ns = self.run_ns;
        followed.trail.push(followed.filter.position());
        let speed_mps = followed.filter.velocity().norm();
        if followed.moving {
            if speed_mps > REST_SPEED_MPS {
                followed.slow_since_ns = self.run_ns;
            }
            let rests_ns = self.run_ns.saturating_sub(followed.slow_since_ns);
            if rests_ns > nanoseconds(REST_S) {
                followed.moving = false;
                followed.born_at = followed.filter.position();
                followed.born_yaw_variance = self.yaw_variance;
            }
        } else if followed.hits >= HITS_TO_CONFIRM
            && speed_mps > MOVING_SIGMAS * followed.filter.speed_sigma_mps()
            && speed_mps > REST_SPEED_MPS
            && (followed.filter.position() - followed.born_at).norm()
                > MOVING_DISTANCE_M + self.swing_m(&followed, eye)
            && self.is_seen_moving(&followed, &seen.cluster)
        {
            followed.moving = true;
            followed.just_moving = true;
            followed.slow_since_ns = self.run_ns;
        }
        if followed.moving {
            for point in self.clusters.points(&seen.cluster) {
                self.moving_beams[point.beam] = true;
            }
        }
        self.tracks[track] = followed;
    }

    /// How far a static obstacle may seem to have moved since it was first seen because the yaw is not
    /// known so well. [m]
    fn swing_m(&self, track: &Track, eye: Point2<f64>) -> f64 {
        let doubt = (self.yaw_variance - track.born_yaw_variance).max(0.0);
        let range_m = (track.filter.position() - eye).norm();
        YAW_SIGMAS * doubt.sqrt() * range_m
    }

    /// True when enough of a cluster lies where an earlier scan looked through, or the newest one
    /// looks through enough of where it was when the track began.
    fn is_seen_moving(&self, track: &Track, cluster: &Cluster) -> bool {
        let (Some(then), Some(now)) = (self.past.oldest_since(track.born_ns), self.past.newest())
        else {
            return false;
        };
        let ago_s = seconds(now.run_ns().saturating_sub(then.run_ns()));
        let gap_m = self.config.gap_m.max(GAP_SIGMAS * self.noise_m);
        let came = track.filter.velocity() * ago_s;
        let points = self.clusters.points(cluster);
        let mut entered = 0;
        let mut left = 0;
        for point in points {
            entered += usize::from(self.past.saw_through(point.at, gap_m));
            let was_at = point.at - came;
            let was_there = then.ended_at(was_at, gap_m);
            left += usize::from(was_there && now.sees_through(was_at, gap_m));
        }
        let enough = (points.len().to_f64() * SEEN_MOVING.0)
            .ceil()
            .to_usize()
            .max(SEEN_MOVING.1);
        entered.max(left) >= enough
    }

    /// A cluster that belongs to no track begins one, as long as there is room.
    fn begin(&mut self, n: usize, eye: Point2<f64>) {
        if self.tracks.len() < OBSTACLES_MAX {
            let seen = self.seen[n];
            let form = Form::of(&seen.fit, seen.cluster.hidden);
            let place = self.measured(&form, &seen, eye);
            let now = (self.run_ns, self.yaw_variance);
            self.tracks
                .push(Track::new(self.next_number, form, &place, now));
            self.next_number += 1;
        }
    }
}
