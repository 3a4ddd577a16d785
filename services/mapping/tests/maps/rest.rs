//! A walker who stops: called moving while it walks, not any more once it has stood for a while,
//! and again when it goes on.

use nalgebra::{Point2, Vector2};
use zeronav_mapping::beams::{Beams, Sweep};
use zeronav_mapping::tracker::{ScanView, Tracker, TrackingConfig};
use zeronav_msgs::Pose;
use zeronav_msgs::obstacles::Obstacle;
use zeronav_msgs::scan::Scan;

const PERIOD_NS: u64 = 100_000_000;
const BEAMS: u16 = 720;
const RADIUS_M: f64 = 0.3;

/// A laser at the origin and a disc in the open before it.
struct Scene {
    tracker: Tracker,
    beams: Beams,
    at: Point2<f64>,
    rng: crate::support::Rng,
    n: u64,
}

impl Scene {
    fn new() -> Self {
        Self {
            tracker: Tracker::new(&TrackingConfig::default()),
            beams: Beams::default(),
            at: Point2::new(-2.0, 3.0),
            rng: crate::support::Rng(3),
            n: 0,
        }
    }

    fn run_ns(&self) -> u64 {
        self.n * PERIOD_NS
    }

    /// So many scans while the disc moves along x.
    fn walk(&mut self, scans: u32, speed_mps: f64) {
        for _ in 0..scans {
            self.n += 1;
            self.at.x += 0.1 * speed_mps;
            self.look();
        }
    }

    #[allow(clippy::cast_possible_truncation, reason = "ranges are f32")]
    fn look(&mut self) {
        let scan = Scan {
            n_beams: u32::from(BEAMS),
            angle_min_rad: -std::f32::consts::PI,
            angle_increment_rad: std::f32::consts::TAU / f32::from(BEAMS),
            range_m_min: 0.1,
            range_m_max: 12.0,
            ..Scan::default()
        };
        let ranges: Vec<f32> = (0..usize::from(BEAMS))
            .map(|beam| {
                let (sin, cos) = scan.angle_of(beam).sin_cos();
                let along = self.at.coords.dot(&Vector2::new(cos, sin));
                let squared = RADIUS_M.powi(2) - (self.at.coords.norm_squared() - along * along);
                if along > 0.0 && squared > 0.0 {
                    (along - squared.sqrt() + 0.01 * self.rng.normal()) as f32
                } else {
                    f32::INFINITY
                }
            })
            .collect();
        let here = Pose::default();
        self.beams.cast(&scan, &ranges, &Sweep::still(here));
        let view = ScanView {
            scan: &scan,
            ranges: &ranges,
            beams: &self.beams,
            map_from_frame: here,
            map_from_laser: here,
            run_ns: self.run_ns(),
            yaw_doubt: 0.0,
        };
        self.tracker.follow(&view, |_| false);
    }

    fn moving(&self) -> Vec<Obstacle> {
        self.tracker.obstacles().collect()
    }
}

#[test]
fn who_stops_is_called_moving_no_longer_and_who_goes_on_is() {
    let mut scene = Scene::new();
    scene.walk(10, 1.0);
    let [walker] = scene.moving()[..] else {
        panic!("{:?}", scene.moving());
    };
    assert!((walker.vx_mps - 1.0).abs() < 0.2, "{walker:?}");
    assert!(scene.tracker.moving_beams().contains(&true));
    // Rest takes a second to be believed; by three it is, with the track held all along.
    scene.walk(5, 0.0);
    assert_eq!(scene.moving().len(), 1, "a short stop is no rest");
    scene.walk(25, 0.0);
    assert_eq!(scene.moving(), []);
    assert!(!scene.tracker.moving_beams().contains(&true));
    scene.walk(10, 1.0);
    assert_eq!(scene.moving().len(), 1);
}

#[test]
fn motion_is_expected_for_a_while_and_not_for_ever() {
    let mut scene = Scene::new();
    assert!(!scene.tracker.sees_motion(scene.run_ns()));
    scene.walk(10, 1.0);
    assert!(scene.tracker.sees_motion(scene.run_ns()));
    scene.walk(30, 0.0);
    assert_eq!(scene.moving(), []);
    assert!(scene.tracker.sees_motion(scene.run_ns()), "more may follow");
    scene.walk(60, 0.0);
    assert!(!scene.tracker.sees_motion(scene.run_ns()));
}

#[test]
fn who_is_gone_is_forgotten_with_its_beams() {
    let mut scene = Scene::new();
    scene.walk(10, 1.0);
    assert_eq!(scene.moving().len(), 1);
    scene.at = Point2::new(0.0, 50.0);
    scene.walk(2, 0.0);
    assert_eq!(scene.moving().len(), 1, "it may be hidden for a moment");
    assert!(!scene.tracker.moving_beams().contains(&true));
    scene.walk(4, 0.0);
    assert_eq!(scene.moving(), []);
}
