use crate::{SimConfig, Simulator};
use zeronav_msgs::Pose;
use zeronav_robot_description::{Begin, Blackout};
use zeronav_robot_description::{FaultSpec, LidarSpec, RobotSpec};
use zeronav_world::{ShapeSpec, World, WorldSpec};

fn world_of(config: &SimConfig) -> World {
    World::new(&config.world, None).expect("a world")
}

const TICK: u64 = 20_000_000;

/// A robot that drives along the x axis at 1 m/s past a disc on its left, scans at 10 Hz.
struct Drive {
    robot: Simulator,
    ranges: Vec<f32>,
}

impl Drive {
    fn with(faults: Vec<FaultSpec>) -> Self {
        let config = SimConfig {
            start: [0.0, 0.0, 0.0],
            world: WorldSpec {
                shapes: vec![ShapeSpec::Disc {
                    centre_m: [4.0, 3.0],
                    radius_m: 0.5,
                }],
                ..WorldSpec::area([-20.0, -20.0], [20.0, 20.0])
            },
            robot: RobotSpec {
                a_mps2_max: 100.0,
                faults,
                ..RobotSpec::exact(0.25, 1.0, 3.0, LidarSpec::exact(360, 10.0, 0.1..10.0))
            },
        };
        let mut robot = Simulator::new(&config, world_of(&config), 1, TICK).expect("a simulator");
        robot.set_command(1.0, 0.0);
        Self {
            robot,
            ranges: vec![0.0; 360],
        }
    }

    /// Drives to `tick`; every scan on the way is taken. True when the last tick sent one.
    fn reach_tick(&mut self, tick: u64) -> bool {
        let mut sent = false;
        while self.robot.run_ns() < tick * TICK {
            self.robot.step(self.robot.run_ns() + TICK, 0);
            let due = self.robot.scan_due();
            sent = self.robot.scan(&mut self.ranges).is_some();
            assert_eq!(due.is_some(), sent);
            assert_eq!(self.robot.odometry().scan_due(), sent);
        }
        sent
    }

    fn true_pose(&mut self) -> Pose {
        self.robot.truth(&mut Vec::new()).pose
    }
}

fn blackout(begins: Begin, looks: Blackout) -> FaultSpec {
    FaultSpec::LidarBlackout {
        begins,
        lasts_s: Some(0.2),
        looks,
    }
}

#[test]
fn a_silent_lidar_sends_no_scans_and_then_does_again() {
    let mut drive = Drive::with(vec![blackout(Begin::at(0.3), Blackout::Silent)]);
    // Scans at 0.1 s, 0.2 s, ...: those at 0.3 s and 0.4 s are not sent, the truth still is.
    for (tick, sent) in [(5, true), (10, true), (15, false), (20, false), (25, true)] {
        assert_eq!(drive.reach_tick(tick), sent, "tick {tick}");
        assert!(drive.robot.truth_due());
    }
}

#[test]
fn a_fault_after_a_distance_begins_with_the_next_tick() {
    // 0.25 m at 1 m/s, but for the first tick's half millimetre and so: just after 0.25 s.
    let mut drive = Drive::with(vec![blackout(Begin::after(0.25), Blackout::Invalid)]);
    drive.reach_tick(10);
    assert!(drive.ranges.iter().all(|range| !range.is_nan()));
    drive.reach_tick(15);
    assert!(drive.ranges.iter().all(|range| range.is_nan()));
    drive.reach_tick(25);
    assert!(drive.ranges.iter().all(|range| !range.is_nan()));
}

#[test]
fn a_covered_lidar_sees_nothing_come_back() {
    let mut drive = Drive::with(vec![blackout(Begin::at(0.3), Blackout::NoReturn)]);
    drive.reach_tick(10);
    assert!(drive.ranges.iter().any(|range| range.is_finite()));
    drive.reach_tick(15);
    assert!(drive.ranges.iter().all(|range| *range == f32::INFINITY));
}

#[test]
fn a_frozen_lidar_repeats_its_last_scan() {
    let mut drive = Drive::with(vec![FaultSpec::LidarFrozen {
        begins: Begin::at(0.3),
        lasts_s: Some(0.2),
    }]);
    drive.reach_tick(10);
    let last = drive.ranges.clone();
    for tick in [15, 20] {
        drive.reach_tick(tick);
        assert_eq!(drive.ranges, last, "tick {tick}");
        // Asking again changes nothing.
        assert!(drive.robot.scan(&mut drive.ranges).is_some());
        assert_eq!(drive.ranges, last, "tick {tick}");
    }
    drive.reach_tick(25);
    assert_ne!(drive.ranges, last);
}

#[test]
fn a_turned_lidar_sees_the_same_elsewhere() {
    let turned = FaultSpec::LidarTurned {
        begins: Begin::at(0.0),
        lasts_s: None,
        // Ten beams.
        angle_rad: 10.0_f64.to_radians(),
    };
    let (mut turned, mut straight) = (Drive::with(vec![turned]), Drive::with(Vec::new()));
    turned.reach_tick(20);
    straight.reach_tick(20);
    let mut seen = 0;
    for beam in 0..360 {
        let (found, expected) = (turned.ranges[beam], straight.ranges[(beam + 10) % 360]);
        seen += u32::from(expected.is_finite());
        let same = (found - expected).abs() < 1e-4 || found.total_cmp(&expected).is_eq();
        assert!(same, "beam {beam}: {found}, not {expected}");
    }
    assert!(seen >= 10, "{seen} beams on the disc");
}

#[test]
fn odometry_jumps_once_and_the_robot_does_not() {
    let jump = FaultSpec::OdometryJump {
        begins: Begin::at(0.5),
        shift: [0.2, 0.3, 0.5],
    };
    let (mut drive, mut straight) = (Drive::with(vec![jump]), Drive::with(Vec::new()));
    drive.reach_tick(24);
    straight.reach_tick(24);
    let before = drive.robot.odometry().pose;
    assert!(
        before.distance_m(&straight.true_pose()) < 1e-9,
        "{before:?}"
    );
    drive.reach_tick(25);
    let after = drive.robot.odometry().pose;
    assert!((after.x_m - before.x_m - 0.22).abs() < 1e-9, "{after:?}");
    assert!((after.y_m - 0.3).abs() < 1e-9 && (after.yaw_rad - 0.5).abs() < 1e-9);
    drive.reach_tick(50);
    straight.reach_tick(50);
    // It drives on along the yaw that it believes in.
    let end = drive.robot.odometry().pose;
    assert!((end.distance_m(&after) - 0.5).abs() < 1e-9, "{end:?}");
    assert_eq!(drive.true_pose(), straight.true_pose());
}

#[test]
fn on_a_slippery_floor_wheels_turn_for_nothing() {
    let slip = FaultSpec::Slip {
        begins: Begin::at(0.2),
        lasts_s: Some(0.4),
        forward_ratio: 1.0,
        turn_ratio: 0.0,
    };
    let (mut drive, mut straight) = (Drive::with(vec![slip]), Drive::with(Vec::new()));
    drive.reach_tick(50);
    straight.reach_tick(50);
    let full_m = straight.true_pose().x_m;
    assert!((drive.true_pose().x_m - (full_m - 0.4)).abs() < 1e-9);
    assert!((drive.robot.odometry().pose.x_m - full_m).abs() < 1e-9);
}
