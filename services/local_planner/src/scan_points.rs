//! From a scan to points in `base` as it is now.

use crate::motion::Twist;
use nalgebra::{Isometry2, Point2};
use zeronav_msgs::Pose;
use zeronav_msgs::scan::{BEAMS_MAX, Scan};

/// Hits of the newest scan. Deskewed once when the scan comes, carried forward in every period.
#[derive(Debug, Clone)]
pub struct ScanPoints {
    at_capture: Vec<Point2<f64>>,
    now: Vec<Point2<f64>>,
}

impl Default for ScanPoints {
    fn default() -> Self {
        Self {
            at_capture: Vec::with_capacity(BEAMS_MAX),
            now: Vec::with_capacity(BEAMS_MAX),
        }
    }
}

impl ScanPoints {
    /// Takes in a scan. `twist` is the robot's while the lidar turned; beam `i` was captured
    /// `(n - 1 - i) * time_increment_s` before the last one, which is the scan's capture. Ranges
    /// that are no hits (no return, invalid, outside the sensor's limits) give no point.
    pub fn take(&mut self, scan: &Scan, ranges: &[f32], base_from_laser: &Pose, twist: Twist) {
        self.at_capture.clear();
        let beam_s = f64::from(scan.time_increment_s);
        let last = f64::from(scan.n_beams.saturating_sub(1));
        let mut elapsed_s = -last * beam_s;
        for (i, &range) in ranges.iter().take(BEAMS_MAX).enumerate() {
            if scan.is_hit(range) {
                let (sin, cos) = scan.angle_of(i).sin_cos();
                let range_m = f64::from(range);
                let in_base = base_from_laser.transform(Point2::new(range_m * cos, range_m * sin));
                let at_capture = if beam_s > 0.0 {
                    twist.arc(elapsed_s).transform(in_base)
                } else {
                    in_base
                };
                self.at_capture.push(at_capture);
            }
            elapsed_s += beam_s;
        }
    }

    /// Forgets the scan.
    pub fn clear(&mut self) {
        self.at_capture.clear();
        self.now.clear();
    }

    /// The points in `base` of now. [m] Both poses are `odom_from_base`: at the scan's capture and
    /// now.
    pub fn carry(&mut self, at_capture: &Pose, now: &Pose) -> &[Point2<f64>] {
        let now_from_capture: Isometry2<f64> = now.isometry().inv_mul(&at_capture.isometry());
        self.now.clear();
        self.now
            .extend(self.at_capture.iter().map(|point| now_from_capture * point));
        &self.now
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scan(time_increment_s: f32) -> Scan {
        Scan {
            n_beams: 4,
            angle_increment_rad: core::f32::consts::FRAC_PI_2,
            time_increment_s,
            range_m_min: 0.1,
            range_m_max: 10.0,
            ..Scan::default()
        }
    }

    #[test]
    fn hits_become_points_and_the_rest_does_not() {
        let mut points = ScanPoints::default();
        let ranges = [1.0, f32::INFINITY, f32::NAN, 2.0];
        points.take(&scan(0.0), &ranges, &Pose::new(0.2, 0.0, 0.0), Twist::REST);
        let found = points.carry(&Pose::default(), &Pose::default());
        assert_eq!(found.len(), 2);
        assert!((found[0] - Point2::new(1.2, 0.0)).norm() < 1e-6);
        assert!((found[1] - Point2::new(0.2, -2.0)).norm() < 1e-6);
    }

    #[test]
    fn points_stand_still_while_the_robot_moves() {
        let mut points = ScanPoints::default();
        points.take(&scan(0.0), &[1.0; 4], &Pose::default(), Twist::REST);
        let now = Pose::new(0.5, 0.0, core::f64::consts::FRAC_PI_2);
        let found = points.carry(&Pose::default(), &now);
        assert!((found[0] - Point2::new(0.0, -0.5)).norm() < 1e-6);
    }

    #[test]
    fn early_beams_are_moved_to_the_capture() {
        let mut points = ScanPoints::default();
        // 1 m/s ahead, 0.1 s per beam: beam 0 was seen 0.3 m further back.
        let twist = Twist::new(1.0, 0.0);
        points.take(&scan(0.1), &[2.0; 4], &Pose::default(), twist);
        let found = points.carry(&Pose::default(), &Pose::default());
        assert!((found[0] - Point2::new(1.7, 0.0)).norm() < 1e-6);
        assert!((found[3] - Point2::new(0.0, -2.0)).norm() < 1e-6);
    }
}
