//! One thing that is followed from scan to scan.

use crate::fit::Place;
use crate::form::Form;
use crate::kalman::ConstantVelocity;
use nalgebra::{Matrix2, Point2, Vector2};
use zeronav_msgs::message::SPEED_MAX;
use zeronav_msgs::obstacles::Obstacle;
use zeronav_msgs::time::seconds;

/// Standard deviation of the speed of what has just appeared. [m/s]
const NEW_SPEED_SIGMA_MPS: f64 = 1.0;

/// Places that are remembered.
const TRAIL_MAX: usize = 32;

/// The last places of a track.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Trail {
    places: [Point2<f64>; TRAIL_MAX],
    pushed: usize,
}

impl Trail {
    /// Adds a place.
    pub(crate) fn push(&mut self, place: Point2<f64>) {
        self.places[self.pushed % TRAIL_MAX] = place;
        self.pushed += 1;
    }

    /// The places, in no order that matters.
    pub(crate) fn iter(&self) -> impl Iterator<Item = Point2<f64>> + '_ {
        self.places[..self.pushed.min(TRAIL_MAX)].iter().copied()
    }
}

/// See the module's description.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Track {
    number: u64,
    /// Where it is and how it moves.
    pub filter: ConstantVelocity,
    /// What it looks like.
    pub form: Form,
    /// Scans that saw it.
    pub hits: u32,
    /// Run time of the first hit. [ns]
    pub born_ns: u64,
    /// Run time of the last hit. [ns]
    pub hit_ns: u64,
    /// Where it began, or came to rest.
    pub born_at: Point2<f64>,
    /// [`crate::tracker::ScanView::yaw_variance`] then. [rad^2]
    pub born_yaw_variance: f64,
    /// It moves.
    pub moving: bool,
    /// The last scan showed that it moves.
    pub just_moving: bool,
    /// Run time since which it has been slow. [ns]
    pub slow_since_ns: u64,
    /// Where it was.
    pub trail: Trail,
}

impl Track {
    /// What is told of it instead of seen, `map` frame: as well known as can be.
    #[must_use]
    pub(crate) fn told(
        number: u64,
        radius_m: f64,
        (at, velocity): (Point2<f64>, Vector2<f64>),
        now: (u64, f64),
    ) -> Self {
        let place = Place {
            centre: at,
            covariance: Matrix2::zeros(),
        };
        let mut track = Self::new(number, Form::disc(radius_m), &place, now);
        track.filter = ConstantVelocity::exact(at, velocity);
        track.moving = true;
        track
    }

    /// Begins with what was seen of it at run time `run_ns`, with the yaw's doubt of then.
    #[must_use]
    pub(crate) fn new(
        number: u64,
        form: Form,
        place: &Place,
        (run_ns, yaw_variance): (u64, f64),
    ) -> Self {
        let mut trail = Trail {
            places: [Point2::origin(); TRAIL_MAX],
            pushed: 0,
        };
        trail.push(place.centre);
        Self {
            number,
            filter: ConstantVelocity::new(place.centre, &place.covariance, NEW_SPEED_SIGMA_MPS),
            form,
            hits: 1,
            born_ns: run_ns,
            hit_ns: run_ns,
            born_at: place.centre,
            born_yaw_variance: yaw_variance,
            moving: false,
            just_moving: false,
            slow_since_ns: run_ns,
            trail,
        }
    }

    /// As `map/obstacles` says it at run time `run_ns`.
    #[must_use]
    pub(crate) fn obstacle(&self, run_ns: u64) -> Obstacle {
        let (place, velocity) = (self.filter.position(), self.filter.velocity());
        Obstacle {
            track: self.number,
            x_m: place.x,
            y_m: place.y,
            vx_mps: velocity.x.clamp(-SPEED_MAX, SPEED_MAX),
            vy_mps: velocity.y.clamp(-SPEED_MAX, SPEED_MAX),
            radius_m: self.form.radius_m,
            age_s: seconds(run_ns.saturating_sub(self.born_ns)),
            unseen_s: seconds(run_ns.saturating_sub(self.hit_ns)),
            covariance: self.filter.upper_triangle(),
        }
    }
}
