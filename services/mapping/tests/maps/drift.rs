//! The pose on a map that begins empty, by a lidar that is short-sighted and noisy: what a map of its own
//! scans tells must not lead it away from what odometry knows well.

use crate::pose::{Lidar, look, world_of};
use crate::support::{Rng, description};
use zeronav_mapping::{Mapping, MappingConfig, Observation};
use zeronav_msgs::Pose;

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

/// Along the hall and through the door, 4.4 cm a scan; how far mapping and odometry are off in the end. [m]
fn drive(seed: u64) -> (f64, f64) {
    let world = world_of(HALL);
    let config = MappingConfig {
        area_m: Some([[-2.0, -2.0], [18.0, 18.0]]),
        ..MappingConfig::default()
    };
    let mut mapping = Mapping::new(&config, None, &description(), &[]).expect("a map");
    let mut rng = Rng(seed);
    let mut truth = Pose::new(2.5, 2.2, 0.5);
    let mut odometry = truth;
    let mut off_m = 0.0;
    for n in 1..=270_u32 {
        let step_m = 0.044;
        truth = truth.then(&Pose::new(step_m, 0.0, 0.0));
        // 1 cm and 0.01 rad in 1 m.
        let erred = |rng: &mut Rng| 0.01 * f64::sqrt(step_m) * rng.normal();
        let step = Pose::new(step_m + erred(&mut rng), 0.0, erred(&mut rng));
        odometry = odometry.then(&step);
        let (scan, ranges) = look(&LIDAR, &world, &truth, &mut rng);
        mapping.take_in(&Observation {
            scan: &scan,
            ranges: &ranges,
            run_ns: u64::from(n) * 200_000_000,
            odom_from_base_first: odometry,
            odom_from_base: odometry,
            odometry_variance: [1.0e-5 * f64::from(n); 3],
            goal: None,
            told: None,
        });
        off_m = mapping.map_from_odom().0.then(&odometry).distance_m(&truth);
    }
    (off_m, odometry.distance_m(&truth))
}

#[test]
fn a_short_sighted_robot_is_not_led_away_by_its_own_map() {
    let (off_m, by_odometry_m): (Vec<f64>, Vec<f64>) = (1..=8).map(drive).unzip();
    let mean_m = |off_m: &[f64]| off_m.iter().sum::<f64>() / 8.0;
    // Cells led it away by 0.46 m.
    assert!(
        mean_m(&off_m) < mean_m(&by_odometry_m),
        "{off_m:?} {by_odometry_m:?}"
    );
    assert!(off_m.iter().all(|off_m| *off_m < 0.36), "{off_m:?}");
}
