//! What a run came to: samples and counts.

use nalgebra::Point2;

/// Times after the first sight at which the velocity is looked at. [s]
pub(super) const AFTER_S: [f64; 3] = [0.2, 0.5, 1.0];

/// How far ahead tracks are predicted. [s]
pub(super) const AHEAD_S: [f64; 3] = [0.5, 1.0, 2.0];

/// Which of `AHEAD_S` the covariance is judged at, too.
pub(super) const JUDGED: usize = 1;

/// Velocities at one time after the first sight.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Early {
    /// Size of the error of the velocity vector. [m/s]
    pub errors_mps: Vec<f64>,
    /// Speed of the track less the true one. [m/s]
    pub too_fast_mps: Vec<f64>,
    /// Size of the angle between the two. [degrees]
    pub headings_deg: Vec<f64>,
    /// Obstacles that were in sight and not yet tracked.
    pub untracked: usize,
}

/// Predictions of one time ahead.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Ahead {
    /// Distance from where the track would be to where the obstacle is then. [m]
    pub errors_m: Vec<f64>,
    /// The same of the true place and velocity: what nobody who goes straight on knows better. [m]
    pub straight_m: Vec<f64>,
}

/// How often the truth lies in the ellipses of the covariance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Inside {
    /// Samples.
    pub n: usize,
    /// In that of one standard deviation.
    pub one: usize,
    /// In that of two.
    pub two: usize,
}

impl Inside {
    /// A sample, as its squared distance in standard deviations.
    pub(super) fn add(&mut self, distance2: f64) {
        self.n += 1;
        self.one += usize::from(distance2 <= 1.0);
        self.two += usize::from(distance2 <= 4.0);
    }
}

/// What went wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Failing {
    /// In sight for more than a second, and never tracked.
    NeverFound,
    /// Its track has ended or strayed, or another number took over.
    Lost,
    /// The track of another obstacle took over.
    Swapped,
    /// A track where nothing moves.
    False,
    /// A second track of something that moves.
    Doubled,
}

/// One thing that went wrong, to look at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Event {
    /// Run time. [ns]
    pub run_ns: u64,
    /// Which obstacle, or else which track.
    pub number: u64,
    /// Where it was, in mapping's map. [m]
    pub at: Point2<f64>,
    /// What it was.
    pub failing: Failing,
}

/// What a run came to.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Tally {
    /// Times that a moving obstacle came into sight.
    pub sights: usize,
    /// From the first scan of a sight to the first in which it is tracked. [s]
    pub delays_s: Vec<f64>,
    /// Sights of more than a second.
    pub long_sights: usize,
    /// The velocity at each of `AFTER_S`.
    pub early: [Early; 3],
    /// Predictions for each of `AHEAD_S`.
    pub ahead: [Ahead; 3],
    /// Where the obstacle is.
    pub now: Inside,
    /// Where it is at `JUDGED`.
    pub then: Inside,
    /// What went wrong, in the order of the scans.
    pub events: Vec<Event>,
    /// Time that obstacles were in sight, all together. [s]
    pub in_sight_s: f64,
    /// Time that was looked at. [s]
    pub run_s: f64,
}

impl Tally {
    /// How often something went wrong.
    #[must_use]
    pub fn count(&self, failing: Failing) -> usize {
        let of_kind = self.events.iter().filter(|event| event.failing == failing);
        of_kind.count()
    }
}
