//! One thing that is followed from scan to scan.

use crate::config::seconds;
use crate::fit::Fit;
use crate::kalman::ConstantVelocity;
use nalgebra::{Matrix2, Point2};
use zeronav_msgs::message::SPEED_MAX;
use zeronav_msgs::obstacles::Obstacle;

/// Standard deviation of the speed of what has just appeared. [m/s]
const NEW_SPEED_SIGMA_MPS: f64 = 1.0;

/// Most hits that the radius is a mean of; more and it follows what is seen.
const RADIUS_HITS_MAX: f64 = 20.0;

/// Standard deviation of a radius that was seen once. [m]
const RADIUS_SIGMA_M: f64 = 0.05;

/// Radius of what is half hidden and its standard deviation. [m]
const EXPECTED_RADIUS_M: f64 = 0.3;
const EXPECTED_RADIUS_SIGMA_M: f64 = 0.1;

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
    /// Begins with the form of what was seen at run time `run_ns`, and whether something hid part
    /// of it, with the yaw's doubt of then. Where it is [`Self::begin_at`] says.
    #[must_use]
    pub fn new(number: u64, (fit, hidden): (&Fit, bool), (run_ns, yaw_doubt): (u64, f64)) -> Self {
        let roundness = match fit {
            Fit::Circle { .. } => 1,
            Fit::Segment { half_m, .. } => i32::from(hidden && *half_m <= EXPECTED_RADIUS_M),
        };
        let unknown = hidden && roundness > 0;
        let trail = TrailOfTrack {
            places: [Point2::origin(); TRAIL_MAX],
            pushed: 0,
        };
        Self {
            number,
            filter: ConstantVelocity::new(Point2::origin(), &Matrix2::zeros(), NEW_SPEED_SIGMA_MPS),
            radius_m: if unknown {
                EXPECTED_RADIUS_M
            } else {
                fit.radius_m()
            },
            radius_hits: if unknown { 0.0 } else { 1.0 },
            roundness,
            hits: 1,
            born_ns: run_ns,
            hit_ns: run_ns,
            born_at: Point2::origin(),
            born_yaw_doubt: yaw_doubt,
            moving: false,
            just_moving: false,
            slow_since_ns: run_ns,
            trail,
        }
    }

    /// Begins at a place, with the covariance of its measurement.
    pub fn begin_at(&mut self, place: Point2<f64>, noise: &Matrix2<f64>) {
        self.filter = ConstantVelocity::new(place, noise, NEW_SPEED_SIGMA_MPS);
        self.born_at = place;
        self.trail.push(place);
    }

    /// True when it is taken for a disc.
    #[must_use]
    pub fn is_round(&self) -> bool {
        self.roundness > 0
    }

    /// How well its radius is known. [m]
    #[must_use]
    pub fn radius_sigma_m(&self) -> f64 {
        if self.radius_hits < 1.0 {
            EXPECTED_RADIUS_SIGMA_M
        } else {
            RADIUS_SIGMA_M / self.radius_hits.sqrt()
        }
    }

    /// Learns its form from what was seen of it.
    pub fn see(&mut self, fit: &Fit, hidden: bool) {
        let vote = match fit {
            Fit::Circle { .. } => 1,
            Fit::Segment { .. } => -1,
        };
        // The sliver that is seen of somebody who is half hidden is straight, too.
        let sliver = hidden && vote < 0 && fit.radius_m() <= EXPECTED_RADIUS_M;
        if !sliver {
            self.roundness = (self.roundness + vote).clamp(-5, 5);
        }
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
