//! One thing that is followed from scan to scan.

use crate::config::seconds;
use crate::fit::Fit;
use crate::kalman::ConstantVelocity;
use crate::tracker::TrackingConfig;
use nalgebra::Point2;
use zeronav_msgs::message::SPEED_MAX;
use zeronav_msgs::obstacles::Obstacle;

/// Standard deviation of the speed of what has just appeared. [m/s]
const NEW_SPEED_SIGMA_MPS: f64 = 1.0;

/// Most hits that the radius is a mean of; more and it follows what is seen.
const RADIUS_HITS_MAX: f64 = 20.0;

/// Places that are remembered.
const TRAIL_MAX: usize = 32;

/// The last places of a track.
#[derive(Debug, Clone, Copy)]
pub struct TrailOfTrack {
    places: [Point2<f64>; TRAIL_MAX],
    pushed: usize,
}

impl TrailOfTrack {
    /// Adds a place.
    pub fn push(&mut self, place: Point2<f64>) {
        self.places[self.pushed % TRAIL_MAX] = place;
        self.pushed += 1;
    }

    /// The places, in no order that matters.
    pub fn iter(&self) -> impl Iterator<Item = Point2<f64>> + '_ {
        self.places[..self.pushed.min(TRAIL_MAX)].iter().copied()
    }
}

/// See the module's description.
#[derive(Debug, Clone, Copy)]
pub struct Track {
    number: u64,
    /// Where it is and how it moves.
    pub filter: ConstantVelocity,
    /// How far it reaches from its centre. [m]
    pub radius_m: f64,
    radius_hits: f64,
    /// Above 0 for round things.
    roundness: i32,
    /// Scans that saw it.
    pub hits: u32,
    /// Run time of the first hit. [ns]
    pub born_ns: u64,
    /// Run time of the last hit. [ns]
    pub hit_ns: u64,
    /// Where it began, or came to rest.
    pub born_at: Point2<f64>,
    /// [`crate::tracker::ScanView::yaw_doubt`] then. [rad^2]
    pub born_yaw_doubt: f64,
    /// It moves.
    pub moving: bool,
    /// The last scan showed that it moves.
    pub just_moving: bool,
    /// Run time since which it has been slow. [ns]
    pub slow_since_ns: u64,
    /// Where it was.
    pub trail: TrailOfTrack,
}

impl Track {
    /// Begins with what was seen at run time `run_ns`, with the yaw's doubt of then.
    #[must_use]
    pub fn new(
        number: u64,
        fit: &Fit,
        (run_ns, yaw_doubt): (u64, f64),
        config: &TrackingConfig,
    ) -> Self {
        let (place, roundness) = match fit {
            Fit::Circle { centre, .. } => (*centre, 1),
            Fit::Segment { middle, .. } => (*middle, 0),
        };
        let mut trail = TrailOfTrack {
            places: [Point2::origin(); TRAIL_MAX],
            pushed: 0,
        };
        trail.push(place);
        Self {
            number,
            filter: ConstantVelocity::new(place, config.position_sigma_m, NEW_SPEED_SIGMA_MPS),
            radius_m: fit.radius_m(),
            radius_hits: 1.0,
            roundness,
            hits: 1,
            born_ns: run_ns,
            hit_ns: run_ns,
            born_at: place,
            born_yaw_doubt: yaw_doubt,
            moving: false,
            just_moving: false,
            slow_since_ns: run_ns,
            trail,
        }
    }

    /// True when it is taken for a disc.
    #[must_use]
    pub fn is_round(&self) -> bool {
        self.roundness > 0
    }

    /// Learns its form from what was seen of it.
    pub fn see(&mut self, fit: &Fit, hidden: bool) {
        let vote = match fit {
            Fit::Circle { .. } => 1,
            Fit::Segment { .. } => -1,
        };
        self.roundness = (self.roundness + vote).clamp(-5, 5);
        let fits = self.is_round() == matches!(fit, Fit::Circle { .. });
        if fits && !hidden {
            self.radius_hits = (self.radius_hits + 1.0).min(RADIUS_HITS_MAX);
            self.radius_m += (fit.radius_m() - self.radius_m) / self.radius_hits;
        }
    }

    /// As `map/obstacles` says it at run time `run_ns`.
    #[must_use]
    pub fn obstacle(&self, run_ns: u64) -> Obstacle {
        let (place, velocity) = (self.filter.position(), self.filter.velocity());
        Obstacle {
            track: self.number,
            x_m: place.x,
            y_m: place.y,
            vx_mps: velocity.x.clamp(-SPEED_MAX, SPEED_MAX),
            vy_mps: velocity.y.clamp(-SPEED_MAX, SPEED_MAX),
            radius_m: self.radius_m,
            age_s: seconds(run_ns.saturating_sub(self.born_ns)),
            covariance: self.filter.upper_triangle(),
        }
    }
}
