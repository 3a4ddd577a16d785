//! A walker who stops: called moving while it walks, not any more once it has stood for a while,
//! and again when it goes on; and one who passes behind a wall.

use nalgebra::{Point2, Vector2};
use zeronav_casts::Cast;
use zeronav_mapping::beams::{Beams, Sweep};
use zeronav_mapping::tracker::{ScanView, Tracker, TrackingConfig};
use zeronav_msgs::Pose;
use zeronav_msgs::obstacles::Obstacle;
use zeronav_msgs::scan::Scan;

const PERIOD_NS: u64 = 100_000_000;
const BEAMS: u16 = 720;
const RADIUS_M: f64 = 0.3;

/// y of the wall that may stand between the laser and the disc. [m]
const WALL_Y_M: f64 = 1.5;

/// A laser at the origin and a disc before it, in the open or partly behind a wall.
struct Scene {
    tracker: Tracker,
    beams: Beams,
    at: Point2<f64>,
    /// From where to where along x the wall goes. [m]
    wall: Option<(f64, f64)>,
    rng: crate::support::Rng,
    n: u64,
}

impl Scene {
    fn new() -> Self {
        Self {
            tracker: Tracker::new(&TrackingConfig::default()),
            beams: Beams::default(),
            at: Point2::new(-2.0, 3.0),
            wall: None,
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
                let wall_m = WALL_Y_M / sin;
                let on_wall = |(from, to): (f64, f64)| (from..=to).contains(&(wall_m * cos));
                if sin > 0.0 && self.wall.is_some_and(on_wall) {
                    return wall_m.to_f32();
                }
                let along = self.at.coords.dot(&Vector2::new(cos, sin));
                let squared = RADIUS_M.powi(2) - (self.at.coords.norm_squared() - along * along);
                if along > 0.0 && squared > 0.0 {
                    (along - squared.sqrt() + 0.01 * self.rng.normal()).to_f32()
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
            yaw_variance: 0.0,
        };
        let is_wall = |at: Point2<f64>| (at.y - WALL_Y_M).abs() < 0.1;
        self.tracker.follow(&view, is_wall);
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

#[test]
fn who_passes_behind_a_wall_is_predicted_until_he_comes_out() {
    // From x = -0.3 to 0.3 m at y = 1.5 m it hides what is between -0.6 and 0.6 m at y = 3 m.
    let mut scene = Scene::new();
    scene.wall = Some((-0.3, 0.3));
    let mut guessed = 0;
    let mut numbers = Vec::new();
    for n in 0..40 {
        scene.walk(1, 1.0);
        let [walker] = scene.moving()[..] else {
            assert!(n < 10, "lost at {}: {:?}", scene.at, scene.moving());
            continue;
        };
        let off_m = (walker.x_m - scene.at.x).hypot(walker.y_m - scene.at.y);
        assert!(off_m < 0.3, "{off_m} m off at {}: {walker:?}", scene.at);
        guessed += u32::from(walker.unseen_s > 0.05);
        numbers.push(walker.track);
    }
    // 0.6 m of the way he is hidden as a whole.
    assert!((3..=9).contains(&guessed), "{guessed}");
    numbers.dedup();
    assert_eq!(numbers.len(), 1, "one track: {numbers:?}");
}

#[test]
fn who_does_not_come_out_is_given_up() {
    let mut scene = Scene::new();
    scene.wall = Some((-0.3, 3.0));
    scene.walk(25, 1.0);
    let [hidden] = scene.moving()[..] else {
        panic!("{:?}", scene.moving());
    };
    let sigma_m = hidden.covariance[0].sqrt();
    assert!(hidden.unseen_s > 0.3 && sigma_m > 0.1, "{hidden:?}");
    scene.walk(20, 1.0);
    assert_eq!(scene.moving(), []);
}
