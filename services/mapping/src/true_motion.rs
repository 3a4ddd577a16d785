//! What moves as the simulator tells it, in place of what is tracked: for a run that measures what
//! perception costs.

use crate::track::Track;
use crate::tracker::{ScanView, Tracker};
use nalgebra::{Point2, Vector2};
use zeronav_msgs::Pose;
use zeronav_msgs::foresight::Foreseen;
use zeronav_msgs::obstacles::OBSTACLES_MAX;

/// What moves at the capture of a scan.
#[derive(Debug, Clone, Copy)]
pub struct TrueMotion<'a> {
    /// True `map_from_base` then.
    pub pose: Pose,
    /// What moves, in the true map.
    pub obstacles: &'a [Foreseen],
}

impl TrueMotion<'_> {
    /// Makes the tracks those that are told. The robot is not quite where it thinks it is: what moves
    /// lies around it as it really does.
    pub(crate) fn teach(&self, tracker: &mut Tracker, view: &ScanView<'_>) {
        let map_from_true = view.map_from_frame.isometry() * self.pose.isometry().inverse();
        let now = (view.run_ns, view.yaw_variance);
        let tracks = self.obstacles.iter().take(OBSTACLES_MAX).map(|obstacle| {
            let at = map_from_true * Point2::new(obstacle.x_m[0], obstacle.y_m[0]);
            let velocity = map_from_true * Vector2::new(obstacle.vx_mps, obstacle.vy_mps);
            Track::told(obstacle.index + 1, obstacle.radius_m, (at, velocity), now)
        });
        tracker.replace(view, tracks);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beams::{Beams, Sweep};
    use crate::tracker::TrackingConfig;
    use core::f64::consts::FRAC_PI_2;
    use zeronav_msgs::foresight::FORESEEN_STEPS;
    use zeronav_msgs::obstacles::Obstacle;
    use zeronav_msgs::scan::Scan;

    /// A person in the true map.
    fn walker(index: u64, at_m: [f64; 2], velocity_mps: [f64; 2]) -> Foreseen {
        Foreseen {
            index,
            vx_mps: velocity_mps[0],
            vy_mps: velocity_mps[1],
            radius_m: 0.25,
            x_m: [at_m[0]; FORESEEN_STEPS],
            y_m: [at_m[1]; FORESEEN_STEPS],
            ..Foreseen::default()
        }
    }

    /// Tells a tracker what moves, `run_ns` into the run: the tracks, and the beams that end on them.
    /// The lidar is the robot's centre. One beam ends 2 m ahead, one 2 m to the left.
    fn tell(
        tracker: &mut Tracker,
        run_ns: u64,
        truth: Pose,
        thought: Pose,
        obstacles: &[Foreseen],
    ) -> (Vec<Obstacle>, Vec<bool>) {
        let scan = Scan {
            n_beams: 2,
            angle_increment_rad: 1.570_796_4,
            range_m_min: 0.1,
            range_m_max: 10.0,
            ..Scan::default()
        };
        let ranges = [2.0; 2];
        let mut beams = Beams::default();
        beams.cast(&scan, &ranges, &Sweep::still(Pose::default()));
        let view = ScanView {
            scan: &scan,
            ranges: &ranges,
            beams: &beams,
            map_from_frame: thought,
            map_from_laser: thought,
            run_ns,
            yaw_variance: 0.0,
        };
        let told = TrueMotion {
            pose: truth,
            obstacles,
        };
        told.teach(tracker, &view);
        let tracks = tracker.obstacles().collect();
        (tracks, tracker.moving_beams().to_vec())
    }

    fn is_near(found: [f64; 2], expected: [f64; 2]) -> bool {
        (found[0] - expected[0]).hypot(found[1] - expected[1]) < 1e-6
    }

    #[test]
    fn what_is_told_lies_around_the_robot_as_it_really_does() {
        let mut tracker = Tracker::new(&TrackingConfig::default());
        let truth = Pose::new(5.0, 3.0, FRAC_PI_2);
        // Mapping is a metre off and turned by a quarter.
        let thought = Pose::new(6.0, 3.0, 0.0);
        // Really 2.2 m ahead of the robot, walking to its left at 1 m/s.
        let ahead = walker(7, [5.0, 5.2], [-1.0, 0.0]);
        let (tracks, moving) = tell(&mut tracker, 100, truth, thought, &[ahead]);
        let [track] = tracks[..] else {
            panic!("{tracks:?}")
        };
        assert!(is_near([track.x_m, track.y_m], [8.2, 3.0]), "{track:?}");
        assert!(is_near([track.vx_mps, track.vy_mps], [0.0, 1.0]));
        assert!((track.radius_m - 0.25).abs() < 1e-12);
        assert_eq!(track.track, 8);
        assert!(track.covariance.iter().all(|value| *value == 0.0));
        assert_eq!(moving, [true, false], "the beam ahead ends on it");
        assert!(tracker.sees_motion(100));
    }

    #[test]
    fn tracks_are_replaced_by_what_is_told() {
        let mut tracker = Tracker::new(&TrackingConfig::default());
        let here = Pose::default();
        let people = [
            walker(0, [2.0, 0.0], [1.0, 0.0]),
            walker(3, [0.0, 2.0], [0.0, 1.0]),
        ];
        let (tracks, moving) = tell(&mut tracker, 100, here, here, &people);
        let numbers: Vec<u64> = tracks.iter().map(|track| track.track).collect();
        assert_eq!(numbers, [1, 4]);
        assert_eq!(moving, [true, true]);
        // One has gone, the other has gone on.
        let left = walker(3, [0.0, 4.0], [0.0, 1.0]);
        let (tracks, moving) = tell(&mut tracker, 200, here, here, &[left]);
        let [track] = tracks[..] else {
            panic!("{tracks:?}")
        };
        assert_eq!(track.track, 4);
        assert!(is_near([track.x_m, track.y_m], [0.0, 4.0]), "{track:?}");
        assert_eq!(moving, [false, false]);
        let (tracks, _) = tell(&mut tracker, 300, here, here, &[]);
        assert!(tracks.is_empty());
    }
}
