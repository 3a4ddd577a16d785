//! The pose on a map that begins empty, by a lidar that is short-sighted and noisy: what a map of its own
//! scans tells must not lead it away from what odometry knows well.

use crate::pose::{Lidar, look, world_of};
use crate::support::{Rng, description};
use zeronav_mapping::{Mapping, MappingConfig, Observation};
use zeronav_msgs::Pose;
use zeronav_world::World;

/// As the smallest robots carry it.
const LIDAR: Lidar = Lidar {
    n_beams: 360,
    range_m_max: 3.5,
    sigma_m: 0.005,
    sigma_ratio: 0.017,
};

/// A hall of 16 m x 6 m, askew to the cells of the map, and a wall of 20 cm with a door across it.
const HALL: &str = r#"
[world]
area_m = [[-2.0, -2.0], [18.0, 18.0]]
resolution_m = 0.05
shapes = [
    { kind = "box", centre_m = [9.35, 2.67], size_m = [16.0, 0.2], yaw_rad = 0.5 },
    { kind = "box", centre_m = [6.48, 7.93], size_m = [16.0, 0.2], yaw_rad = 0.5 },
    { kind = "box", centre_m = [8.75, 3.77], size_m = [0.2, 2.5], yaw_rad = 0.5 },
    { kind = "box", centre_m = [7.07, 6.83], size_m = [0.2, 2.5], yaw_rad = 0.5 },
]
"#;

/// A robot with such a lidar on its way.
struct Drive {
    world: World,
    mapping: Mapping,
    rng: Rng,
    truth: Pose,
    odometry: Pose,
    n: u32,
}

impl Drive {
    /// On a map that begins empty, or on the whole map.
    fn new(world: &str, config: &MappingConfig, start: Pose, seed: u64) -> Self {
        let world = world_of(world);
        let map = world.rasterise();
        let known = config.area_m.is_none().then_some(&map);
        let mapping = Mapping::new(config, known, &description(), &[]).expect("a map");
        Self {
            world,
            mapping,
            rng: Rng(seed),
            truth: start,
            odometry: start,
            n: 0,
        }
    }

    /// A scan 0.2 s later. Odometry errs by 1 cm and 0.01 rad in 1 m, beside what the wheels lose.
    fn go(&mut self, moved: &Pose, wheels: &Pose) {
        self.n += 1;
        self.truth = self.truth.then(moved);
        let mut erred = || 0.01 * wheels.x_m.sqrt() * self.rng.normal();
        let step = Pose::new(wheels.x_m + erred(), 0.0, wheels.yaw_rad + erred());
        self.odometry = self.odometry.then(&step);
        let (scan, ranges) = look(&LIDAR, &self.world, &self.truth, &mut self.rng);
        self.mapping.take_in(&Observation {
            scan: &scan,
            ranges: &ranges,
            run_ns: u64::from(self.n) * 200_000_000,
            odom_from_base_first: self.odometry,
            odom_from_base: self.odometry,
            odometry_variance: [1.0e-5 * f64::from(self.n); 3],
            goal: None,
            told: None,
        });
    }

    /// How far the pose is off. [m]
    fn off_m(&self) -> f64 {
        let pose = self.mapping.map_from_odom().0.then(&self.odometry);
        pose.distance_m(&self.truth)
    }

    /// How far it may be off by its covariance: the larger of both deviations. [m]
    fn sigma_m(&self) -> f64 {
        let [xx, _, _, yy, _, _] = self.mapping.map_from_odom().1;
        xx.max(yy).sqrt()
    }
}

/// Along the hall and through the door, 4.4 cm a scan.
fn drive(config: &MappingConfig, seed: u64) -> Drive {
    let mut drive = Drive::new(HALL, config, Pose::new(2.5, 2.2, 0.5), seed);
    for _ in 0..270 {
        let step = Pose::new(0.044, 0.0, 0.0);
        drive.go(&step, &step);
    }
    drive
}

fn empty() -> MappingConfig {
    MappingConfig {
        area_m: Some([[-2.0, -2.0], [18.0, 18.0]]),
        ..MappingConfig::default()
    }
}

#[test]
fn a_short_sighted_robot_is_not_led_away_by_its_own_map() {
    let drives = (1..=8).map(|seed| drive(&empty(), seed));
    let (off_m, by_odometry_m): (Vec<f64>, Vec<f64>) = drives
        .map(|drive| (drive.off_m(), drive.odometry.distance_m(&drive.truth)))
        .unzip();
    let mean_m = |off_m: &[f64]| off_m.iter().sum::<f64>() / 8.0;
    // Cells led it away by 0.46 m.
    assert!(
        mean_m(&off_m) < mean_m(&by_odometry_m),
        "{off_m:?} {by_odometry_m:?}"
    );
    assert!(off_m.iter().all(|off_m| *off_m < 0.36), "{off_m:?}");
}

/// A map of its own making follows the robot, and cannot tell how far it has drifted; a static map can.
#[test]
fn the_covariance_says_how_far_the_robot_has_drifted_on_its_own_map() {
    for seed in 1..=8 {
        let drive = drive(&empty(), seed);
        let (off_m, sigma_m) = (drive.off_m(), drive.sigma_m());
        eprintln!("seed {seed}: {off_m} {sigma_m}");
        assert!(off_m < 3.0 * sigma_m, "seed {seed}: {off_m} {sigma_m}");
    }
    let drive = drive(&MappingConfig::default(), 1);
    let (off_m, sigma_m) = (drive.off_m(), drive.sigma_m());
    eprintln!("static: {off_m} {sigma_m}");
    assert!(sigma_m < 0.05 && off_m < 0.1, "{off_m} {sigma_m}");
}

/// Along the hall with wheels that spin for 8 s and then hold.
fn spin(config: &MappingConfig, seed: u64) -> Drive {
    let mut drive = Drive::new(HALL, config, Pose::new(2.5, 2.2, 0.5), seed);
    for n in 0..170 {
        let wheels = Pose::new(0.044, 0.0, 0.0);
        let share = if (90..130).contains(&n) { 0.1 } else { 1.0 };
        drive.go(&Pose::new(share * wheels.x_m, 0.0, 0.0), &wheels);
    }
    drive
}

/// By a lidar like this one walls seem to move while wheels spin: they must not be left out as what moves.
#[test]
fn a_short_sighted_robot_notices_that_its_wheels_spin() {
    for seed in 1..=6 {
        let drive = spin(&empty(), seed);
        let (off_m, odometry_m) = (drive.off_m(), drive.odometry.distance_m(&drive.truth));
        eprintln!("seed {seed}: {off_m} {odometry_m}");
        assert!(odometry_m > 1.3, "seed {seed}: {odometry_m}");
        assert!(off_m < 0.3, "seed {seed}: {off_m}");
    }
}

/// Nothing moves, and the wheels hold: the noise of the lidar is no motion.
#[test]
fn a_short_sighted_robot_sees_nothing_move_where_nothing_moves() {
    for seed in 1..=6 {
        let mut drive = Drive::new(HALL, &empty(), Pose::new(2.5, 2.2, 0.5), seed);
        let mut moving = Vec::new();
        for _ in 0..200 {
            let step = Pose::new(0.044, 0.0, 0.0);
            drive.go(&step, &step);
            moving.extend(drive.mapping.obstacles());
        }
        assert!(moving.is_empty(), "seed {seed}: {moving:?}");
    }
}
