//! Tracks against the truth, scan by scan.
//!
//! A *sight* is the time from the first scan that shows enough of something that moves to the last,
//! with gaps of at most [`GAP_S`]; what stops, jumps, vanishes or hides for longer and comes back is
//! a new one.

use super::ellipse;
use super::pairs::pairs;
use super::tally::{AFTER_S, AHEAD_S, Event, Failing, JUDGED, Tally};
use nalgebra::{Point2, Vector2};
use std::collections::{BTreeMap, BTreeSet};
use zeronav_measure::{MOVING_MPS, SAME_M};
use zeronav_msgs::obstacles::Obstacle;
use zeronav_msgs::time::{nanoseconds, seconds};

/// Speed from which on something static moves; it does until it is slower than [`MOVING_MPS`].
/// [m/s]
const STARTS_MPS: f64 = 0.2;

/// Longest time out of sight within one sight: how long a track outlives its last hit. [s]
const GAP_S: f64 = 0.3;

/// Sights that are shorter need not be found. [s]
const LONG_S: f64 = 1.0;

/// How long a track must be gone, or another's, to be lost or swapped; and how long a track that was
/// nothing from the start may be published. [s]
const AWAY_S: f64 = 0.1;

/// How long a track that was something may outlive it. [s]
const OUTLIVES_S: f64 = 0.5;

/// How long what has stopped may be called moving. [s]
const STANDS_S: f64 = 2.0;

/// Predictions and ellipses are looked at once in this time: neighbouring scans say the same. [s]
const SAMPLE_S: f64 = 0.1;

/// How long after each of `AFTER_S` a scan that shows the obstacle may come. [s]
const LATE_S: f64 = 0.1;

/// What is true of an obstacle in a scan, in mapping's map.
#[derive(Debug, Clone, Copy)]
pub(super) struct Truth {
    /// Which obstacle; another one after a jump.
    pub(super) number: u64,
    /// The scan shows enough of it, within the range in which anything is tracked.
    pub(super) seen: bool,
    /// [m]
    pub(super) at: Point2<f64>,
    /// [m/s]
    pub(super) velocity: Vector2<f64>,
    /// Where it is after each of `AHEAD_S`, if it is still there. [m]
    pub(super) ahead: [Option<Point2<f64>>; 3],
}

/// A true obstacle from scan to scan.
#[derive(Debug, Default)]
struct Followed {
    moves: bool,
    /// When it moved last. [ns]
    moved_ns: Option<u64>,
    /// Number of its track in the last scan.
    track: Option<u64>,
    sight: Option<Sight>,
}

#[derive(Debug)]
struct Sight {
    began_ns: u64,
    seen_ns: u64,
    /// Where it was seen last. [m]
    at: Point2<f64>,
    found: bool,
    /// The track that follows it.
    held: Option<u64>,
    /// Since when another one does, or none. [ns]
    away_ns: Option<u64>,
    /// Which of `AFTER_S` comes next.
    next: usize,
}

/// A published track that may be nothing.
#[derive(Debug, Default)]
struct Doubt {
    /// Since when it is nothing that moves. [ns]
    since_ns: Option<u64>,
    was_something: bool,
    counted: bool,
}

/// Compares. See the module's description.
#[derive(Debug, Default)]
pub(super) struct Score {
    followed: BTreeMap<u64, Followed>,
    /// Which obstacle a track followed last.
    owners: BTreeMap<u64, u64>,
    doubts: BTreeMap<u64, Doubt>,
    began_ns: Option<u64>,
    last_ns: u64,
    tally: Tally,
}

impl Score {
    /// Takes in what is true of a scan that was captured at `run_ns`, and what was tracked in it.
    pub(super) fn add(&mut self, run_ns: u64, truths: &[Truth], tracks: &[Obstacle]) {
        let first = self.began_ns.is_none();
        let began_ns = *self.began_ns.get_or_insert(run_ns);
        let step_s = if first {
            0.0
        } else {
            seconds(run_ns.saturating_sub(self.last_ns))
        };
        let sample_ns = nanoseconds(SAMPLE_S);
        let samples = first || run_ns / sample_ns != self.last_ns / sample_ns;
        self.last_ns = run_ns;
        self.tally.run_s = seconds(run_ns.saturating_sub(began_ns));
        let places: Vec<Point2<f64>> = truths.iter().map(|truth| truth.at).collect();
        let ends: Vec<Point2<f64>> = tracks
            .iter()
            .map(|track| ellipse::place(track, 0.0))
            .collect();
        let of_truth = pairs(&places, &ends, |p, t| {
            let followed = self.followed.get(&truths[p].number);
            followed.is_some_and(|followed| followed.track == Some(tracks[t].track))
        });
        let here: BTreeSet<u64> = truths.iter().map(|truth| truth.number).collect();
        let (here, gone) = core::mem::take(&mut self.followed)
            .into_iter()
            .partition(|(number, _)| here.contains(number));
        self.followed = here;
        self.close_all(gone);
        for (truth, pair) in truths.iter().zip(&of_truth) {
            let track = pair.and_then(|pair| tracks.get(pair));
            let sees = self.follow(run_ns, step_s, truth, track);
            if let Some(track) = track.filter(|_| samples && sees) {
                self.sample(truth, track);
            }
        }
        self.doubt(run_ns, truths, tracks, &of_truth);
    }

    /// What it came to.
    pub(super) fn finish(mut self) -> Tally {
        let all = core::mem::take(&mut self.followed);
        self.close_all(all);
        self.tally
    }

    /// Goes on with an obstacle; true when it moves in sight.
    fn follow(
        &mut self,
        run_ns: u64,
        step_s: f64,
        truth: &Truth,
        track: Option<&Obstacle>,
    ) -> bool {
        let number = truth.number;
        let mut followed = self.followed.remove(&number).unwrap_or_default();
        let speed_mps = truth.velocity.norm();
        followed.moves = speed_mps
            >= if followed.moves {
                MOVING_MPS
            } else {
                STARTS_MPS
            };
        if followed.moves {
            followed.moved_ns = Some(run_ns);
        }
        followed.track = track.map(|track| track.track);
        let hidden = |sight: &Sight| run_ns.saturating_sub(sight.seen_ns) > nanoseconds(GAP_S);
        if !followed.moves || followed.sight.as_ref().is_some_and(hidden) {
            self.close(number, followed.sight.take());
        }
        let sees = truth.seen && followed.moves;
        if sees {
            if followed.sight.is_some() {
                self.tally.in_sight_s += step_s;
            } else {
                self.tally.sights += 1;
            }
            let sight = followed.sight.get_or_insert(Sight {
                began_ns: run_ns,
                seen_ns: run_ns,
                at: truth.at,
                found: false,
                held: None,
                away_ns: None,
                next: 0,
            });
            (sight.seen_ns, sight.at) = (run_ns, truth.at);
            self.find(run_ns, truth, track, sight);
            self.look_early(run_ns, truth, track, sight);
            self.hold(run_ns, truth, track, sight);
        }
        self.followed.insert(number, followed);
        sees
    }

    /// The first track of a sight.
    fn find(&mut self, run_ns: u64, truth: &Truth, track: Option<&Obstacle>, sight: &mut Sight) {
        if let (false, Some(track)) = (sight.found, track) {
            sight.found = true;
            let delay_s = seconds(run_ns.saturating_sub(sight.began_ns));
            self.tally.delays_s.push(delay_s);
            self.take(run_ns, truth, track.track, sight);
        }
    }

    /// The velocity shortly after the first sight.
    fn look_early(
        &mut self,
        run_ns: u64,
        truth: &Truth,
        track: Option<&Obstacle>,
        sight: &mut Sight,
    ) {
        let since_ns = run_ns.saturating_sub(sight.began_ns);
        while let Some(after_s) = AFTER_S.get(sight.next) {
            if since_ns < nanoseconds(*after_s) {
                return;
            }
            let early = &mut self.tally.early[sight.next];
            sight.next += 1;
            if since_ns > nanoseconds(after_s + LATE_S) {
                continue;
            }
            let Some(track) = track else {
                early.untracked += 1;
                continue;
            };
            let velocity = Vector2::new(track.vx_mps, track.vy_mps);
            let angle_rad = velocity
                .perp(&truth.velocity)
                .atan2(velocity.dot(&truth.velocity));
            early.errors_mps.push((velocity - truth.velocity).norm());
            early
                .too_fast_mps
                .push(velocity.norm() - truth.velocity.norm());
            early.headings_deg.push(angle_rad.to_degrees().abs());
        }
    }

    /// Whether a found obstacle still has its track.
    fn hold(&mut self, run_ns: u64, truth: &Truth, track: Option<&Obstacle>, sight: &mut Sight) {
        let now = track.map(|track| track.track);
        if sight.held == now {
            sight.away_ns = None;
            return;
        }
        let Some(_) = sight.held else {
            if let Some(now) = now.filter(|_| sight.found) {
                self.take(run_ns, truth, now, sight);
            }
            return;
        };
        let away_ns = *sight.away_ns.get_or_insert(run_ns);
        if run_ns.saturating_sub(away_ns) < nanoseconds(AWAY_S) {
            return;
        }
        let swapped = now.is_some_and(|now| self.take(run_ns, truth, now, sight));
        if !swapped {
            self.fail(run_ns, truth.number, truth.at, Failing::Lost);
        }
        sight.held = now;
        sight.away_ns = None;
    }

    /// From now on the track follows this obstacle; true when it followed another one.
    fn take(&mut self, run_ns: u64, truth: &Truth, track: u64, sight: &mut Sight) -> bool {
        sight.held = Some(track);
        sight.away_ns = None;
        let owner = self.owners.insert(track, truth.number);
        let swapped = owner.is_some_and(|owner| owner != truth.number);
        if swapped {
            self.fail(run_ns, truth.number, truth.at, Failing::Swapped);
        }
        swapped
    }

    /// Places and covariances against the truth.
    fn sample(&mut self, truth: &Truth, track: &Obstacle) {
        self.tally.now.add(ellipse::distance2(track, 0.0, truth.at));
        for (at, (ahead_s, there)) in AHEAD_S.iter().zip(truth.ahead).enumerate() {
            let Some(there) = there else {
                continue;
            };
            let ahead = &mut self.tally.ahead[at];
            let error_m = (ellipse::place(track, *ahead_s) - there).norm();
            ahead.errors_m.push(error_m);
            let straight = truth.at + truth.velocity * *ahead_s;
            ahead.straight_m.push((straight - there).norm());
            if at == JUDGED {
                self.tally
                    .then
                    .add(ellipse::distance2(track, *ahead_s, there));
            }
        }
    }

    /// Which tracks are nothing that moves.
    fn doubt(
        &mut self,
        run_ns: u64,
        truths: &[Truth],
        tracks: &[Obstacle],
        of_truth: &[Option<usize>],
    ) {
        let stands_ns = nanoseconds(STANDS_S);
        let moves = |truth: &Truth| {
            let moved_ns = self
                .followed
                .get(&truth.number)
                .and_then(|one| one.moved_ns);
            moved_ns.is_some_and(|moved_ns| run_ns.saturating_sub(moved_ns) <= stands_ns)
        };
        let mut found = Vec::new();
        for (at, track) in tracks.iter().enumerate() {
            if track.is_guess() {
                continue;
            }
            let own = of_truth.iter().position(|pair| *pair == Some(at));
            let doubt = self.doubts.entry(track.track).or_default();
            if own.is_some_and(|own| moves(&truths[own])) {
                (doubt.since_ns, doubt.was_something) = (None, true);
                continue;
            }
            let since_ns = *doubt.since_ns.get_or_insert(run_ns);
            let grace_s = if doubt.was_something {
                OUTLIVES_S
            } else {
                AWAY_S
            };
            if doubt.counted || run_ns.saturating_sub(since_ns) < nanoseconds(grace_s) {
                continue;
            }
            doubt.counted = true;
            let place = ellipse::place(track, 0.0);
            let near = |truth: &Truth| moves(truth) && (truth.at - place).norm() <= 2.0 * SAME_M;
            let failing = if own.is_none() && truths.iter().any(near) {
                Failing::Doubled
            } else {
                Failing::False
            };
            found.push((track.track, place, failing));
        }
        for (number, at, failing) in found {
            self.fail(run_ns, number, at, failing);
        }
    }

    fn close_all(&mut self, followed: BTreeMap<u64, Followed>) {
        for (number, followed) in followed {
            self.close(number, followed.sight);
        }
    }

    /// The end of a sight.
    fn close(&mut self, number: u64, sight: Option<Sight>) {
        let Some(sight) = sight else {
            return;
        };
        if sight.seen_ns.saturating_sub(sight.began_ns) <= nanoseconds(LONG_S) {
            return;
        }
        self.tally.long_sights += 1;
        if !sight.found {
            self.fail(sight.seen_ns, number, sight.at, Failing::NeverFound);
        }
    }

    fn fail(&mut self, run_ns: u64, number: u64, at: Point2<f64>, failing: Failing) {
        self.tally.events.push(Event {
            run_ns,
            number,
            at,
            failing,
        });
    }
}

#[cfg(test)]
mod tests;
