//! A robot that was told where it is: it is sure of that once the map has explained what it sees, and not before.

use crate::lost::{Robot, hall};
use crate::support::Room;
use core::f64::consts::PI;
use zeronav_mapping::window::WindowMode;
use zeronav_mapping::{Mapping, MappingConfig};
use zeronav_msgs::Pose;
use zeronav_msgs::certainty::PoseCertainty;
use zeronav_msgs::map::MapView;

/// A hall that the lidar does not reach across, with three pillars of 1 m: from its middle they take few beams.
fn bare_hall() -> Room {
    let mut hall = Room::walled(800, 800, 2);
    for (x, y) in [(520, 440), (460, 300), (600, 340)] {
        hall.fill(x, y, x + 20, y + 20, true);
    }
    hall
}

/// Drives straight on by 0.1 m a scan until it is said of its pose what is asked for; after how many scans.
fn drive_until(robot: &mut Robot, certainty: PoseCertainty) -> Option<usize> {
    (1..=60).find(|_| {
        robot.step(Pose::new(0.1, 0.0, 0.0));
        robot.certainty() == certainty
    })
}

#[test]
fn a_robot_that_sees_enough_of_its_map_is_sure_at_once() {
    let hall = hall();
    let truth = hall.pose(120.0, 70.0, 0.2);
    let mut robot = Robot::told(&hall, truth, truth, 1);
    assert_eq!(robot.certainty(), PoseCertainty::Unconfirmed);
    // What a scan says of the pose counts from the next one on.
    for certainty in [PoseCertainty::Unconfirmed, PoseCertainty::Confirmed] {
        robot.step(Pose::default());
        assert_eq!(robot.certainty(), certainty);
    }
    robot.is_found("told");
}

#[test]
fn few_beams_confirm_nothing_before_it_has_driven() {
    let hall = bare_hall();
    let truth = hall.pose(400.0, 400.0, 0.0);
    let mut robot = Robot::told(&hall, truth, truth, 1);
    let unconfirmed = |robot: &Robot| robot.certainty() == PoseCertainty::Unconfirmed;
    for _ in 0..100 {
        robot.step(Pose::default());
        assert!(unconfirmed(&robot), "it stands and sees the same again");
    }
    let confirmed = drive_until(&mut robot, PoseCertainty::Confirmed);
    assert!(confirmed.is_some_and(|n| n > 10), "{confirmed:?}");
    robot.is_found("told");
}

#[test]
fn few_beams_contradict_a_wrong_place_once_it_has_driven() {
    let hall = bare_hall();
    let truth = hall.pose(400.0, 400.0, 0.0);
    let told = truth.then(&Pose::new(2.0, 0.0, PI));
    let mut robot = Robot::told(&hall, truth, told, 1);
    assert_eq!(robot.stand_until(50, Mapping::is_uncertain), None);
    let mut steps = (1..=60).map(|_| {
        robot.step(Pose::new(0.1, 0.0, 0.0));
        robot.certainty()
    });
    let last = steps.find(|it| *it != PoseCertainty::Unconfirmed);
    assert_eq!(last, Some(PoseCertainty::Unknown));
}

/// The search for another place begins with the first scans.
#[test]
fn a_place_in_a_wall_is_given_up_at_once() {
    let hall = hall();
    let truth = hall.pose(120.0, 70.0, 0.2);
    let mut robot = Robot::told(&hall, truth, hall.pose(160.0, 110.0, 0.2), 1);
    let lost = robot.stand_until(10, Mapping::is_uncertain);
    assert!(lost.is_some(), "{:?}", robot.certainty());
}

/// After a restart the first scan of a process comes late in a run, and is one scan.
#[test]
fn the_first_scan_alone_gives_no_place_up() {
    let hall = hall();
    let truth = hall.pose(120.0, 70.0, 0.2);
    let mut robot = Robot::told(&hall, truth, hall.pose(160.0, 110.0, 0.2), 1);
    robot.n_scans = 1000;
    for _ in 0..3 {
        robot.step(Pose::default());
        assert_eq!(robot.certainty(), PoseCertainty::Unconfirmed);
    }
}

/// Where odometry begins in the frame of the map nothing was told, however exact it is.
#[test]
fn where_odom_is_map_there_is_nothing_to_confirm() {
    let mut hall = bare_hall();
    (hall.geometry.origin_x_m, hall.geometry.origin_y_m) = (-20.0, -20.0);
    let mut robot = Robot::told(&hall, Pose::default(), Pose::default(), 1);
    for variance in [0.0, 1.0e-4] {
        robot.odometry_variance = [variance; 3];
        robot.step(Pose::default());
        assert_eq!(robot.certainty(), PoseCertainty::Confirmed);
    }
}

/// Nobody writes a pose into a scenario to the centimetre, and exact odometry keeps the error.
#[test]
fn a_configured_pose_that_is_a_little_off_is_corrected() {
    let hall = hall();
    let truth = hall.pose(120.0, 70.0, 0.2);
    for variance in [0.0, 1.0e-4] {
        let told = Pose::new(truth.x_m + 0.14, truth.y_m - 0.14, truth.yaw_rad);
        let mut robot = Robot::told(&hall, truth, told, 1);
        robot.odometry_variance = [variance; 3];
        let sure = robot.stand_until(10, |_| false);
        assert_eq!((sure, robot.certainty()), (None, PoseCertainty::Confirmed));
        let (off_m, off_rad) = robot.off();
        assert!(
            off_m < 0.03 && off_rad < 0.02,
            "{variance}: {off_m} m, {off_rad} rad"
        );
    }
}

/// Half a metre off is no inaccuracy: another place may fit as well, so it is looked for everywhere.
#[test]
fn a_configured_pose_that_fits_only_elsewhere_is_looked_for() {
    let hall = hall();
    let truth = hall.pose(120.0, 70.0, 0.2);
    for variance in [0.0, 1.0e-4] {
        let told = Pose::new(truth.x_m + 0.4, truth.y_m - 0.35, truth.yaw_rad);
        let mut robot = Robot::told(&hall, truth, told, 1);
        robot.odometry_variance = [variance; 3];
        assert!(robot.stand_until(25, Mapping::is_uncertain).is_some());
        let knows = |mapping: &Mapping| !mapping.is_uncertain();
        assert!(robot.stand_until(200, knows).is_some());
        let (off_m, off_rad) = robot.off();
        assert!(off_m < 0.05 && off_rad < 0.02, "{off_m} m, {off_rad} rad");
    }
}

/// Who never counts as lost is believed.
#[test]
fn without_a_watch_there_is_nothing_to_confirm() {
    let hall = bare_hall();
    let truth = hall.pose(400.0, 400.0, 0.0);
    let mut config = MappingConfig::default();
    config.localisation.lost_below = 0.0;
    config.localisation.map_from_odom = [truth.x_m, truth.y_m, truth.yaw_rad];
    let mut robot = Robot::new(&hall, &config, truth, 1);
    robot.step(Pose::default());
    assert_eq!(robot.certainty(), PoseCertainty::Confirmed);
}

/// A process that takes the seat over is no surer than the one before it.
#[test]
fn a_successor_has_confirmed_what_its_predecessor_has() {
    let hall = bare_hall();
    let truth = hall.pose(400.0, 400.0, 0.0);
    let mut robot = Robot::told(&hall, truth, truth, 1);
    for expected in [PoseCertainty::Unconfirmed, PoseCertainty::Confirmed] {
        robot.step(Pose::default());
        if expected == PoseCertainty::Confirmed {
            assert!(drive_until(&mut robot, expected).is_some());
        }
        let mut next = Robot::told(&hall, truth, Pose::default(), 7);
        let mapper = robot.mapping.mapper();
        let view = MapView {
            geometry: mapper.geometry(),
            cells: mapper.cells(),
        };
        assert!(next.mapping.resume(&robot.info(), &view));
        assert_eq!(next.certainty(), expected);
    }
}

/// After a restart `launch` tells mapping where the robot was, and how far that was known.
#[test]
fn a_restart_changes_nothing_of_what_is_known() {
    let hall = bare_hall();
    let truth = hall.pose(400.0, 400.0, 0.0);
    for certainty in [PoseCertainty::Unconfirmed, PoseCertainty::Confirmed] {
        let mut robot = Robot::told(&hall, truth, Pose::default(), 1);
        robot.relocate(truth, certainty);
        for _ in 0..20 {
            robot.step(Pose::default());
            assert_eq!(robot.certainty(), certainty);
        }
        robot.is_found("told");
    }
}

#[test]
fn a_lost_robot_stands_and_is_looked_for_after_a_restart() {
    let hall = hall();
    let truth = hall.pose(120.0, 70.0, 0.2);
    let mut robot = Robot::told(&hall, truth, Pose::default(), 1);
    robot.relocate(hall.pose(25.0, 30.0, 1.0), PoseCertainty::Unknown);
    assert_eq!(robot.certainty(), PoseCertainty::Unknown);
    let found = robot.stand_until(60, |mapping| !mapping.is_uncertain());
    assert!(found.is_some_and(|n| n > 10), "{found:?}");
    robot.is_found("looked for");
    // On a map that moves along it is looked for near by.
    let mut config = MappingConfig::default();
    config.window.mode = WindowMode::Rolling;
    let mut robot = Robot::new(&hall, &config, truth, 1);
    robot.relocate(truth, PoseCertainty::Unknown);
    assert_eq!(robot.certainty(), PoseCertainty::Unknown);
    assert!(
        robot
            .stand_until(10, |mapping| !mapping.is_uncertain())
            .is_some()
    );
    robot.is_found("near by");
}
