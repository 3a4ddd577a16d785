//! A robot that may be anywhere: it finds itself where the map tells places apart, and never believes in one of equal places.

use crate::support::{Rng, Room, description, observed};
use core::f64::consts::PI;
use zeronav_casts::Cast;
use zeronav_mapping::localisation::StartPose;
use zeronav_mapping::{Mapping, MappingConfig, Sought};
use zeronav_msgs::Pose;
use zeronav_msgs::certainty::PoseCertainty;
use zeronav_msgs::map::{MapInfo, MapView};
use zeronav_msgs::pose::wrap_angle;

/// A robot in a room, what mapping makes of its scans, ten a second, and what odometry says.
pub(crate) struct Robot {
    pub(crate) room: Room,
    pub(crate) mapping: Mapping,
    pub(crate) truth: Pose,
    odometry: Pose,
    /// What odometry says of its variances.
    pub(crate) odometry_variance: [f64; 3],
    rng: Rng,
    pub(crate) n_scans: u64,
    /// It is checked after every answer.
    checks: bool,
}

impl Robot {
    /// A robot at `truth`. Odometry begins at its own origin.
    pub(crate) fn new(room: &Room, config: &MappingConfig, truth: Pose, seed: u64) -> Self {
        let map = room.as_static_map();
        Self {
            room: room.clone(),
            mapping: Mapping::new(config, Some(&map), &description(), &[]).expect("a map"),
            truth,
            odometry: Pose::default(),
            odometry_variance: [1.0e-4; 3],
            rng: Rng(seed),
            n_scans: 0,
            checks: true,
        }
    }

    /// One that may be anywhere.
    fn unknown(room: &Room, truth: Pose, seed: u64) -> Self {
        let mut config = MappingConfig::default();
        config.localisation.start = StartPose::Unknown;
        Self::new(room, &config, truth, seed)
    }

    /// One that is told that it is at `told`.
    pub(crate) fn told(room: &Room, truth: Pose, told: Pose, seed: u64) -> Self {
        let mut config = MappingConfig::default();
        config.localisation.map_from_odom = [told.x_m, told.y_m, told.yaw_rad];
        Self::new(room, &config, truth, seed)
    }

    /// Moves, and takes in a scan.
    pub(crate) fn step(&mut self, motion: Pose) {
        self.truth = self.truth.then(&motion);
        self.odometry = self.odometry.then(&motion);
        self.n_scans += 1;
        let (scan, mut ranges) = self.room.scan(&self.truth);
        for range_m in &mut ranges {
            let noisy = (f64::from(*range_m) + 0.01 * self.rng.normal()).to_f32();
            let is_lost = self.rng.below(100) == 0;
            *range_m = if is_lost { f32::INFINITY } else { noisy };
        }
        let seen = observed(
            (&scan, &ranges),
            self.n_scans,
            self.odometry,
            self.odometry_variance,
        );
        self.mapping.take_in(&seen);
        // After the answer, or at the next scan: that makes no difference.
        if self.checks {
            let said = self.info();
            self.mapping.check();
            assert_eq!(self.info(), said);
        }
        assert_eq!(self.certainty().is_known(), !self.mapping.is_uncertain());
    }

    /// Is told before the next scan that it is at `told`, and how far that is known.
    pub(crate) fn relocate(&mut self, told: Pose, certainty: PoseCertainty) {
        let (scan, ranges) = self.room.scan(&self.truth);
        let (n, odometry) = (self.n_scans + 1, self.odometry);
        let next = observed((&scan, &ranges), n, odometry, self.odometry_variance);
        let map_from_odom = Pose::from(told.isometry() * odometry.isometry().inverse());
        self.mapping.relocate(map_from_odom, certainty, &next);
    }

    /// What its map says of its pose.
    pub(crate) fn info(&self) -> MapInfo {
        let (map_from_odom, covariance) = self.mapping.map_from_odom();
        MapInfo {
            map_from_odom,
            covariance,
            ..MapInfo::default()
        }
    }

    pub(crate) fn certainty(&self) -> PoseCertainty {
        self.info().certainty()
    }

    /// Stands for some scans until `until` holds; after how many.
    pub(crate) fn stand_until(
        &mut self,
        most: usize,
        until: impl Fn(&Mapping) -> bool,
    ) -> Option<usize> {
        (1..=most).find(|_| {
            self.step(Pose::default());
            until(&self.mapping)
        })
    }

    /// How far mapping is off. [m, rad]
    pub(crate) fn off(&self) -> (f64, f64) {
        let pose = self.mapping.map_from_odom().0.then(&self.odometry);
        let turned = wrap_angle(pose.yaw_rad - self.truth.yaw_rad).abs();
        (pose.distance_m(&self.truth), turned)
    }

    #[track_caller]
    pub(crate) fn is_found(&self, what: &str) {
        let (off_m, off_rad) = self.off();
        assert!(
            off_m < 0.1 && off_rad < 0.05,
            "{what}: {off_m} m, {off_rad} rad off"
        );
    }
}

fn is_known(mapping: &Mapping) -> bool {
    !mapping.is_uncertain()
}

/// A hall of 10 m x 7 m with a corner cut off, a wall with a door, a pillar and a cupboard: no two places look alike.
pub(crate) fn hall() -> Room {
    let mut room = Room::walled(200, 140, 2);
    room.fill(150, 100, 200, 140, true);
    room.fill(80, 0, 83, 60, true);
    room.fill(80, 85, 83, 140, true);
    room.fill(30, 90, 38, 98, true);
    room.fill(110, 2, 140, 14, true);
    room
}

/// Free places of the hall, in cells.
const PLACES: [(f64, f64); 6] = [
    (25.0, 30.0),
    (60.0, 110.0),
    (70.0, 20.0),
    (120.0, 70.0),
    (180.0, 30.0),
    (95.0, 120.0),
];

#[test]
fn a_robot_that_wakes_anywhere_finds_itself() {
    let hall = hall();
    for seed in 1..=3 {
        let mut rng = Rng(seed);
        for (x, y) in PLACES {
            let mut draw = |most: i32| f64::from(rng.below(1000)) * 0.001 * f64::from(most);
            let truth = hall.pose(x + draw(6), y + draw(6), wrap_angle(draw(7)));
            let what = format!("seed {seed}, {truth:?}");
            let mut robot = Robot::unknown(&hall, truth, seed);
            let found = robot.stand_until(60, is_known);
            assert!(found.is_some(), "{what}: {:?}", robot.mapping.sought());
            robot.is_found(&what);
            assert_eq!(robot.mapping.sought(), Sought::Not);
            // It stays found, and its map is not spoilt.
            assert_eq!(robot.stand_until(40, Mapping::is_uncertain), None, "{what}");
            robot.is_found(&what);
        }
    }
}

/// It drives while it is looked for, as somebody pushes it.
#[test]
fn a_robot_that_moves_meanwhile_is_found_where_it_is_then() {
    let hall = hall();
    let mut robot = Robot::unknown(&hall, hall.pose(25.0, 30.0, 0.3), 5);
    for n in 0..60 {
        robot.step(Pose::new(0.03, 0.0, if n % 20 < 10 { 0.02 } else { -0.02 }));
        if is_known(&robot.mapping) {
            robot.is_found("moving");
            return;
        }
    }
    panic!("{:?}", robot.mapping.sought());
}

#[test]
fn two_equal_rooms_are_ambiguous_and_never_certain() {
    let mut rooms = Room::walled(240, 100, 2);
    rooms.fill(118, 0, 122, 100, true);
    for left in [0, 120] {
        rooms.fill(left + 30, 60, left + 45, 80, true);
        rooms.fill(left + 80, 10, left + 86, 30, true);
    }
    for seed in 1..=2 {
        let mut robot = Robot::unknown(&rooms, rooms.pose(60.0, 45.0, 0.4), seed);
        // Long enough for luck to strike, if it could.
        let known = robot.stand_until(200, is_known);
        assert_eq!(known, None, "seed {seed}: {:?}", robot.off());
        assert!(matches!(robot.mapping.sought(), Sought::Ambiguous(2..)));
    }
}

/// Along a bare corridor every place looks alike.
#[test]
fn nobody_knows_where_along_a_corridor_it_is() {
    let mut corridor = Room::walled(1200, 40, 2);
    corridor.n_beams = 360;
    let truth = corridor.pose(600.0, 20.0, 0.2);
    let mut robot = Robot::unknown(&corridor, truth, 3);
    assert_eq!(robot.stand_until(150, is_known), None, "{:?}", robot.off());
    let sought = robot.mapping.sought();
    assert!(
        matches!(sought, Sought::Ambiguous(2..) | Sought::TooMany),
        "{sought:?}"
    );
    // One that was told where it is is not lost there.
    let mut robot = Robot::told(&corridor, truth, truth, 3);
    assert_eq!(robot.stand_until(100, Mapping::is_uncertain), None);
}

#[test]
fn who_is_told_a_wrong_place_is_lost_within_three_seconds_and_found() {
    let hall = hall();
    for (seed, (x, y)) in (1..).zip(PLACES) {
        let truth = hall.pose(x, y, 0.2);
        let told = truth.then(&Pose::new(2.0, 0.0, PI));
        let mut robot = Robot::told(&hall, truth, told, seed);
        let lost = robot.stand_until(30, Mapping::is_uncertain);
        assert!(lost.is_some(), "{truth:?} is taken for {told:?}");
        let found = robot.stand_until(70, is_known);
        assert!(found.is_some(), "{truth:?}: {:?}", robot.mapping.sought());
        robot.is_found(&format!("{truth:?}"));
    }
}

/// Boxes stand before and cupboards have gone from about a third of what the lidar sees.
#[test]
fn moved_furniture_is_no_reason_to_be_lost() {
    let hall = hall();
    let truth = hall.pose(120.0, 70.0, 0.2);
    let mut changed = hall.clone();
    changed.fill(110, 2, 140, 14, false);
    for (x, y) in [(100, 40), (140, 90), (150, 40)] {
        changed.fill(x, y, x + 12, y + 12, true);
    }
    let (_, before) = hall.scan(&truth);
    let (_, after) = changed.scan(&truth);
    let moved = before
        .iter()
        .zip(&after)
        .filter(|(a, b)| (**a - **b).abs() > 0.2);
    let n_moved = moved.count();
    assert!((200..280).contains(&n_moved), "{n_moved} of 720 beams");
    let mut robot = Robot::told(&hall, truth, truth, 4);
    robot.room = changed.clone();
    assert_eq!(robot.stand_until(150, Mapping::is_uncertain), None);
    robot.is_found("it knows");
    let mut robot = Robot::unknown(&hall, truth, 4);
    robot.room = changed;
    let found = robot.stand_until(60, is_known);
    assert!(found.is_some(), "{:?}", robot.mapping.sought());
    robot.is_found("it wakes");
}

/// Who stands in a ring of boxes sees nothing of the map: that is no place, and no reason to be lost.
#[test]
fn what_is_on_no_map_is_nowhere() {
    let hall = hall();
    let truth = hall.pose(120.0, 70.0, 0.2);
    let mut ring = hall.clone();
    ring.fill(98, 48, 142, 92, true);
    ring.fill(101, 52, 138, 90, false);
    let mut robot = Robot::told(&hall, truth, truth, 4);
    // It has known where it is before.
    assert_eq!(robot.stand_until(10, Mapping::is_uncertain), None);
    robot.room = ring.clone();
    assert_eq!(robot.stand_until(150, Mapping::is_uncertain), None);
    let mut robot = Robot::unknown(&hall, truth, 4);
    robot.room = ring;
    assert_eq!(robot.stand_until(150, is_known), None, "{:?}", robot.off());
}

/// Only what ends within `obstacle_range_m` is judged, and counted.
#[test]
fn walls_beyond_the_range_that_counts_are_no_reason_to_be_lost() {
    let mut far = Room::walled(800, 800, 2);
    far.range_m_max = 30.0;
    let truth = far.pose(400.0, 400.0, 0.3);
    let mut robot = Robot::told(&far, truth, truth, 6);
    assert_eq!(robot.stand_until(60, Mapping::is_uncertain), None);
}

/// A process that takes the seat over knows what the one before it knew, and not more.
#[test]
fn a_successor_is_lost_where_the_predecessor_was() {
    let hall = hall();
    let truth = hall.pose(25.0, 30.0, 0.3);
    let mut robot = Robot::unknown(&hall, truth, 2);
    for n in 0..2 {
        robot.step(Pose::default());
        let (map_from_odom, covariance) = robot.mapping.map_from_odom();
        let mut next = Robot::told(&hall, truth, Pose::default(), 7);
        let mapper = robot.mapping.mapper();
        let info = MapInfo {
            map_from_odom,
            covariance,
            ..MapInfo::default()
        };
        let view = MapView {
            geometry: mapper.geometry(),
            cells: mapper.cells(),
        };
        assert!(next.mapping.resume(&info, &view));
        if n == 0 {
            assert!(next.mapping.is_uncertain());
            let found = next.stand_until(60, is_known);
            assert!(found.is_some(), "{:?}", next.mapping.sought());
            next.is_found("the successor");
            robot.stand_until(60, is_known);
        } else {
            assert!(!next.mapping.is_uncertain());
            next.step(Pose::default());
            next.is_found("the successor of one that knew");
        }
    }
}

/// A person who says where the robot is ends the search.
#[test]
fn who_is_told_where_it_is_is_not_lost() {
    let hall = hall();
    let truth = hall.pose(25.0, 30.0, 0.3);
    let mut robot = Robot::unknown(&hall, truth, 2);
    robot.step(Pose::default());
    assert!(robot.mapping.is_uncertain());
    robot.relocate(truth, PoseCertainty::Unconfirmed);
    assert!(is_known(&robot.mapping));
    assert_eq!(robot.stand_until(50, Mapping::is_uncertain), None);
    robot.is_found("told");
}

/// Without a map there is nothing to be found on.
#[test]
fn an_unknown_start_needs_a_fixed_static_map() {
    let hall = hall();
    let mut config = crate::support::config(&hall);
    config.localisation.start = StartPose::Unknown;
    let error = Mapping::new(&config, None, &description(), &[]).map(|_| ());
    let error = error.expect_err("no map").to_string();
    assert!(error.contains("localisation.start"), "{error}");
}

/// A keyframe may be sent after a check, or before it, as the clock has it: both say the same.
#[test]
fn what_is_said_does_not_depend_on_when_a_scan_is_checked() {
    let hall = hall();
    let truth = hall.pose(120.0, 70.0, 0.2);
    let told = truth.then(&Pose::new(-2.0, 0.3, PI));
    let mut soon = Robot::told(&hall, truth, told, 1);
    let mut late = Robot::told(&hall, truth, told, 1);
    late.checks = false;
    let mut seen = vec![soon.certainty()];
    for n in 0..100 {
        if n == 60 {
            // Its last scan is still to be checked.
            late.relocate(told, PoseCertainty::Unconfirmed);
            soon.relocate(told, PoseCertainty::Unconfirmed);
        }
        for robot in [&mut soon, &mut late] {
            robot.step(Pose::new(0.01, 0.0, 0.02));
        }
        assert_eq!(soon.info(), late.info(), "scan {n}");
        let cells = [&soon, &late].map(|robot| robot.mapping.mapper().cells());
        assert!(cells[0] == cells[1], "scan {n}");
        if seen.last() != Some(&soon.certainty()) {
            seen.push(soon.certainty());
        }
    }
    let (unknown, unconfirmed) = (PoseCertainty::Unknown, PoseCertainty::Unconfirmed);
    let found = [unconfirmed, unknown, PoseCertainty::Confirmed];
    assert_eq!(seen[..3], found, "{seen:?}");
    assert!(seen[3..].starts_with(&[unconfirmed, unknown]), "{seen:?}");
}
