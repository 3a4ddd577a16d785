//! Tracked obstacles against the truth: how soon, how well, and how often for nothing.
//!
//! Used where the truth is known: in simulated runs, and in the tests of mapping.

use nalgebra::{Point2, Vector2};
use zeronav_casts::Cast;
use zeronav_msgs::obstacles::Obstacle;
use zeronav_msgs::time::seconds;
use zeronav_msgs::truth::TruthObstacle;

/// A tracked obstacle is this one when it is no farther from it. [m]
pub const SAME_M: f64 = 0.6;

/// A true obstacle slower than this does not move. [m/s]
pub const MOVING_MPS: f64 = 0.1;

/// Beams on a moving obstacle from which on it should be found.
pub const BEAMS_MIN: u32 = 3;

/// A true obstacle from scan to scan.
#[derive(Debug, Clone, Copy)]
struct Followed {
    index: u32,
    at: Point2<f64>,
    run_ns: u64,
    /// Since when it has moved and been seen without being found. [ns]
    wanted_ns: Option<u64>,
    found: bool,
}

/// What the comparison of a run came to.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TrackingReport {
    /// From the first scan with three beams on a moving obstacle to the first in which it is
    /// tracked, for each time one came into sight. [s]
    pub delays_s: Vec<f64>,
    /// Moving obstacles that were seen for more than a second and never found.
    pub missed: usize,
    /// Root of the mean squared error of the velocity vector, from half a second after it was
    /// found on; 0 without a sample. [m/s]
    pub velocity_rmse_mps: f64,
    /// Samples of it.
    pub velocity_samples: usize,
    /// Tracks that were called moving where nothing moved; guesses do not count.
    pub false_tracks: usize,
    /// Time that was looked at. [s]
    pub duration_s: f64,
}

/// Compares scan by scan. See the module's description.
#[derive(Debug, Default)]
pub struct TrackingScore {
    followed: Vec<Followed>,
    began_ns: Option<u64>,
    false_numbers: Vec<u64>,
    squares: f64,
    report: TrackingReport,
}

impl TrackingScore {
    /// Takes in the truth of a scan captured at run time `run_ns` and what was tracked in it.
    pub fn add(&mut self, run_ns: u64, truth: &[TruthObstacle], tracked: &[Obstacle]) {
        let began_ns = *self.began_ns.get_or_insert(run_ns);
        self.report.duration_s = seconds(run_ns.saturating_sub(began_ns));
        let place = |obstacle: &Obstacle| Point2::new(obstacle.x_m, obstacle.y_m);
        let mut movers: Vec<Point2<f64>> = Vec::new();
        for one in truth {
            let at = one.pose.point();
            let known = self.followed.iter().position(|old| old.index == one.index);
            let Some(known) = known else {
                self.followed.push(Followed {
                    index: one.index,
                    at,
                    run_ns,
                    wanted_ns: None,
                    found: false,
                });
                movers.push(at);
                continue;
            };
            let followed = &mut self.followed[known];
            let dt_s = seconds(run_ns.saturating_sub(followed.run_ns));
            if dt_s <= 0.0 {
                continue;
            }
            let velocity = (at - followed.at) / dt_s;
            (followed.at, followed.run_ns) = (at, run_ns);
            let nearest = tracked
                .iter()
                .filter(|obstacle| (place(obstacle) - at).norm() <= SAME_M)
                .min_by(|a, b| {
                    let far = |obstacle: &Obstacle| (place(obstacle) - at).norm();
                    far(a).total_cmp(&far(b))
                });
            if velocity.norm() < MOVING_MPS {
                // What has just stopped may be called moving for a while.
                movers.push(at);
                followed.wanted_ns = None;
                followed.found = false;
                continue;
            }
            movers.push(at);
            let seen = one.beams >= BEAMS_MIN;
            if followed.wanted_ns.is_none() && seen && !followed.found {
                followed.wanted_ns = Some(run_ns);
            }
            match (followed.wanted_ns, nearest) {
                (Some(since_ns), Some(_)) if !followed.found => {
                    followed.found = true;
                    let delay_s = seconds(run_ns.saturating_sub(since_ns));
                    self.report.delays_s.push(delay_s);
                }
                (Some(since_ns), None) if !seen => {
                    let lasted_s = seconds(run_ns.saturating_sub(since_ns));
                    self.report.missed += usize::from(!followed.found && lasted_s > 1.0);
                    followed.wanted_ns = None;
                    followed.found = false;
                }
                (Some(since_ns), Some(found)) => {
                    let settled = seconds(run_ns.saturating_sub(since_ns)) > 0.9;
                    if settled && seen {
                        let error = Vector2::new(found.vx_mps, found.vy_mps) - velocity;
                        self.squares += error.norm_squared();
                        self.report.velocity_samples += 1;
                    }
                }
                _ => {}
            }
        }
        for obstacle in tracked.iter().filter(|one| !one.is_guess()) {
            let near = |at: &Point2<f64>| (place(obstacle) - at).norm() <= 2.0 * SAME_M;
            if !movers.iter().any(near) && !self.false_numbers.contains(&obstacle.track) {
                self.false_numbers.push(obstacle.track);
            }
        }
    }

    /// What it came to so far.
    #[must_use]
    pub fn report(&self) -> TrackingReport {
        let samples = self.report.velocity_samples.max(1).to_f64();
        TrackingReport {
            velocity_rmse_mps: (self.squares / samples).sqrt(),
            false_tracks: self.false_numbers.len(),
            ..self.report.clone()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::Pose;

    #[test]
    fn delay_error_and_false_tracks_are_counted() {
        let mut score = TrackingScore::default();
        for n in 0..40_u32 {
            let t = 0.1 * f64::from(n);
            let truth = TruthObstacle {
                index: 3,
                beams: 8,
                pose: Pose::new(1.0 + t, 2.0, 0.0),
                ..TruthObstacle::default()
            };
            let tracked = Obstacle {
                track: 7,
                x_m: 1.0 + t,
                y_m: 2.1,
                vx_mps: 1.2,
                ..Obstacle::default()
            };
            let ghost = Obstacle {
                track: 8 + u64::from(n / 20),
                x_m: -5.0,
                ..Obstacle::default()
            };
            let guess = Obstacle {
                track: 11,
                unseen_s: 0.5,
                ..ghost
            };
            let found = if n < 5 {
                vec![]
            } else {
                vec![tracked, ghost, guess]
            };
            score.add(u64::from(n) * 100_000_000, &[truth], &found);
        }
        let report = score.report();
        assert_eq!(report.delays_s.len(), 1);
        // It was first known to move in the second scan, and found in the sixth.
        assert!((report.delays_s[0] - 0.4).abs() < 1e-9, "{report:?}");
        assert!((report.velocity_rmse_mps - 0.2).abs() < 1e-9, "{report:?}");
        assert_eq!((report.false_tracks, report.missed), (2, 0));
        assert!((report.duration_s - 3.9).abs() < 1e-9);
    }
}
