//! What mapping says of the world against what is so: where the robot is, and what moves.
//!
//! Truth, tracked obstacles and map updates name the scan that they are about; truth and odometry of
//! one tick carry the same run time. Whatever of a scan is here waits for the rest; one of which a
//! message was lost is left out.

use crate::result::truth::{PoseResult, TrackingResult};
use crate::tracking_score::TrackingScore;
use std::collections::{BTreeMap, VecDeque};
use zeronav_casts::Cast;
use zeronav_msgs::Pose;
use zeronav_msgs::certainty::PoseCertainty;
use zeronav_msgs::obstacles::Obstacle;
use zeronav_msgs::pose::wrap_angle;
use zeronav_msgs::truth::TruthObstacle;
use zeronav_observe::statistics::median;

/// Scans that wait for all their messages at most; the oldest go first.
const WAITING_MAX: usize = 128;

/// The messages about one scan.
#[derive(Debug, Default)]
struct Scan {
    /// With its run time. [ns]
    truth: Option<(u64, Pose, Vec<TruthObstacle>)>,
    tracked: Option<Vec<Obstacle>>,
    /// With how far mapping knew it.
    map_from_odom: Option<(Pose, PoseCertainty)>,
}

impl Scan {
    fn is_whole(&self) -> bool {
        self.truth.is_some() && self.tracked.is_some() && self.map_from_odom.is_some()
    }
}

/// Compares mapping with the truth. See the module's description.
#[derive(Debug, Default)]
pub struct TruthComparison {
    /// By the scans' ids.
    waiting: BTreeMap<u64, Scan>,
    /// Run time [ns] and `odom_from_base` of the ticks with a scan, in order.
    odometry: VecDeque<(u64, Pose)>,
    pose: PoseResult,
    /// The robot knew where it was at the last scan.
    was_known: bool,
    squares_m2: f64,
    score: TrackingScore,
    /// Where every scripted obstacle was first.
    first: BTreeMap<u32, Pose>,
    moving: bool,
}

impl TruthComparison {
    /// Takes in the truth at `run_ns`; only that of scans counts.
    pub fn truth(&mut self, run_ns: u64, scan: u64, pose: &Pose, obstacles: &[TruthObstacle]) {
        if scan == 0 {
            return;
        }
        for obstacle in obstacles {
            let first = *self.first.entry(obstacle.index).or_insert(obstacle.pose);
            self.moving |= first != obstacle.pose;
        }
        let waiting = self.waiting.entry(scan).or_default();
        waiting.truth = Some((run_ns, *pose, obstacles.to_vec()));
    }

    /// Takes in `odom_from_base` at a tick with a scan.
    pub fn odometry(&mut self, run_ns: u64, odom_from_base: &Pose) {
        if self.odometry.len() == WAITING_MAX {
            self.odometry.pop_front();
        }
        self.odometry.push_back((run_ns, *odom_from_base));
    }

    /// Takes in what mapping saw moving in a scan.
    pub fn obstacles(&mut self, scan: u64, tracked: &[Obstacle]) {
        self.waiting.entry(scan).or_default().tracked = Some(tracked.to_vec());
    }

    /// Takes in where mapping has placed a scan, and how far it knew that.
    pub fn placed(&mut self, scan: u64, map_from_odom: &Pose, certainty: PoseCertainty) {
        self.waiting.entry(scan).or_default().map_from_odom = Some((*map_from_odom, certainty));
    }

    /// Compares the scans of which everything is here, the odometry of their tick included. Every
    /// topic is read in order, so what is missing of a scan before one of these has been lost.
    pub fn compare(&mut self) {
        let placed_ns = self.odometry.back().map(|(run_ns, _)| *run_ns);
        let is_whole = |scan: &Scan| {
            let run_ns = scan.truth.as_ref().map(|(run_ns, ..)| *run_ns);
            scan.is_whole() && run_ns <= placed_ns
        };
        let Some(newest) = self.waiting.iter().rev().find(|(_, scan)| is_whole(scan)) else {
            while self.waiting.len() > WAITING_MAX {
                self.waiting.pop_first();
            }
            return;
        };
        let later = self.waiting.split_off(&(newest.0 + 1));
        for scan in core::mem::replace(&mut self.waiting, later).into_values() {
            self.compare_scan(scan);
        }
    }

    fn compare_scan(&mut self, scan: Scan) {
        let (Some((run_ns, truth, obstacles)), Some(tracked), Some((map_from_odom, certainty))) =
            (scan.truth, scan.tracked, scan.map_from_odom)
        else {
            return;
        };
        let odometry = self
            .odometry
            .iter()
            .rev()
            .find(|(then_ns, _)| *then_ns == run_ns);
        let Some((_, odometry)) = odometry.copied() else {
            return;
        };
        let here = map_from_odom.then(&odometry);
        let pose = &mut self.pose;
        let error_m = here.distance_m(&truth);
        let error_rad = wrap_angle(here.yaw_rad - truth.yaw_rad).abs();
        pose.scans += 1;
        pose.error_m_last = error_m;
        pose.error_rad_last = Some(error_rad);
        pose.known_last = Some(certainty.is_confirmed());
        let is_known = certainty.is_known();
        pose.lost += usize::from(core::mem::replace(&mut self.was_known, is_known) && !is_known);
        pose.true_pose_last = [truth.x_m, truth.y_m, truth.yaw_rad];
        pose.error_m_max = pose.error_m_max.max(error_m);
        pose.error_rad_max = pose.error_rad_max.max(error_rad);
        pose.odometry_error_m_max = pose.odometry_error_m_max.max(odometry.distance_m(&truth));
        self.squares_m2 += error_m * error_m;
        self.score.add(run_ns, &obstacles, &tracked);
    }

    /// Where the robot was said to be; `None` before the first scan.
    #[must_use]
    pub fn pose(&self) -> Option<PoseResult> {
        let n = self.pose.scans.to_f64();
        (self.pose.scans > 0).then(|| PoseResult {
            error_m_rms: (self.squares_m2 / n).sqrt(),
            ..self.pose.clone()
        })
    }

    /// What moved; `None` when nothing did.
    #[must_use]
    pub fn tracking(&self) -> Option<TrackingResult> {
        if !self.moving {
            return None;
        }
        let report = self.score.report();
        let delays_s = report.delays_s;
        let made_up = report.false_tracks.to_f64();
        Some(TrackingResult {
            found: delays_s.len(),
            missed: report.missed,
            detection_delay_s_median: median(delays_s.iter().copied()),
            detection_delay_s_max: delays_s.iter().copied().max_by(f64::total_cmp),
            velocity_rmse_mps: (report.velocity_samples > 0).then_some(report.velocity_rmse_mps),
            velocity_samples: report.velocity_samples,
            false_moving: report.false_tracks,
            false_moving_per_min: 60.0 * made_up / report.duration_s.max(1.0),
            duration_s: report.duration_s,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A walker along x at 1 m/s, and a robot that is 3 cm and 0.1 rad beside its odometry.
    fn scan(comparison: &mut TruthComparison, n: u32, lost: bool) {
        let run_ns = u64::from(n) * 100_000_000;
        let at_m = 1.0 + 0.1 * f64::from(n);
        let walker = TruthObstacle {
            beams: 9,
            pose: Pose::new(at_m, 2.0, 0.0),
            ..TruthObstacle::default()
        };
        let id = 40 + u64::from(n);
        comparison.truth(run_ns, id, &Pose::new(0.0, 0.03, 0.1), &[walker]);
        comparison.odometry(run_ns, &Pose::new(0.0, 0.0, 0.0));
        let tracked = Obstacle {
            x_m: at_m,
            y_m: 2.0,
            vx_mps: 1.0,
            ..Obstacle::default()
        };
        comparison.obstacles(
            id,
            if n < 4 {
                &[]
            } else {
                core::slice::from_ref(&tracked)
            },
        );
        if !lost {
            comparison.placed(
                id,
                &Pose::new(0.0, if n == 9 { -0.02 } else { 0.0 }, 0.1),
                match n {
                    5..12 | 28 => PoseCertainty::Unknown,
                    29 => PoseCertainty::Unconfirmed,
                    _ => PoseCertainty::Confirmed,
                },
            );
        }
        comparison.compare();
    }

    #[test]
    fn pose_and_movers_are_compared_scan_by_scan() {
        let mut comparison = TruthComparison::default();
        assert_eq!((comparison.pose(), comparison.tracking()), (None, None));
        for n in 0..30 {
            scan(&mut comparison, n, n == 20);
        }
        let pose = comparison.pose().expect("scans");
        assert_eq!(pose.scans, 29, "one update was lost");
        assert_eq!((pose.lost, pose.known_last), (2, Some(false)));
        assert!((pose.error_m_max - 0.05).abs() < 1e-9, "{pose:?}");
        assert!((pose.error_m_last - 0.03).abs() < 1e-9, "{pose:?}");
        assert!(pose.error_rad_max < 1e-9, "{pose:?}");
        for (actual, expected) in pose.true_pose_last.iter().zip([0.0, 0.03, 0.1]) {
            assert!((actual - expected).abs() < 1e-12, "{pose:?}");
        }
        let rms_m = ((28.0 * 0.0009 + 0.0025) / 29.0_f64).sqrt();
        assert!((pose.error_m_rms - rms_m).abs() < 1e-9, "{pose:?}");
        let tracking = comparison.tracking().expect("a walker");
        assert_eq!(
            (tracking.found, tracking.missed, tracking.false_moving),
            (1, 0, 0)
        );
        let delay_s = tracking.detection_delay_s_median.expect("a delay");
        assert!((delay_s - 0.3).abs() < 1e-9, "{tracking:?}");
        assert!(tracking.velocity_rmse_mps.expect("samples") < 1e-9);
    }

    #[test]
    fn errors_of_the_yaw_go_the_short_way_round() {
        let mut comparison = TruthComparison::default();
        comparison.truth(7, 1, &Pose::new(0.0, 0.0, 3.1), &[]);
        comparison.odometry(7, &Pose::default());
        comparison.odometry(8, &Pose::default());
        comparison.obstacles(1, &[]);
        comparison.placed(1, &Pose::new(0.0, 0.0, -3.1), PoseCertainty::Confirmed);
        comparison.compare();
        let error_rad = comparison.pose().expect("a scan").error_rad_max;
        assert!((error_rad - (core::f64::consts::TAU - 6.2)).abs() < 1e-9);
    }

    #[test]
    fn a_scan_waits_for_its_odometry() {
        let mut comparison = TruthComparison::default();
        comparison.truth(0, 40, &Pose::default(), &[]);
        comparison.obstacles(40, &[]);
        comparison.placed(40, &Pose::default(), PoseCertainty::Confirmed);
        comparison.compare();
        assert_eq!(comparison.pose(), None);
        comparison.odometry(0, &Pose::default());
        comparison.compare();
        assert_eq!(comparison.pose().map(|pose| pose.scans), Some(1));
    }

    #[test]
    fn what_never_becomes_whole_does_not_pile_up() {
        let mut comparison = TruthComparison::default();
        for n in 0..1000 {
            comparison.odometry(n, &Pose::default());
            comparison.truth(n, n + 1, &Pose::default(), &[]);
            comparison.compare();
        }
        assert!(comparison.waiting.len() <= WAITING_MAX);
        assert!(comparison.odometry.len() <= WAITING_MAX);
        assert_eq!(comparison.pose(), None);
    }
}
