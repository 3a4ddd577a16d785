//! Laws of the guard over random sequences of inputs, and each of its reasons once.

use proptest::prelude::*;
use zeronav_collision_guard::{Guard, GuardConfig, GuardInputs, OdometryInput, ScanInput};
use zeronav_msgs::Pose;
use zeronav_msgs::command::{Intervention, Validity, VelocityCommand, VelocityRequest};
use zeronav_msgs::description::Description;
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::scan::Scan;

const PERIOD_NS: u64 = 20_000_000;
const PERIOD_S: f64 = 0.02;
const MS: u64 = 1_000_000;
const OLD: u64 = 10_000 * MS;

fn robot() -> Description {
    Description {
        v_mps_max: 1.0,
        v_mps_min: -0.2,
        w_radps_max: 1.8,
        a_mps2_max: 1.0,
        brake_mps2: 1.5,
        alpha_radps2_max: 3.0,
        inscribed_radius_m: 0.25,
        circumscribed_radius_m: 0.25,
        angle_increment_rad: 0.1,
        range_m_max: 10.0,
        scan_period_ns: 100 * MS,
        n_beams: 4,
        ..Description::default()
    }
}

fn scan(n_beams: u32) -> Scan {
    Scan {
        n_beams,
        angle_increment_rad: 0.1,
        range_m_max: 10.0,
        ..Scan::default()
    }
}

fn drive(v_mps: f64, w_radps: f64) -> VelocityRequest {
    VelocityRequest {
        v_mps,
        w_radps,
        validity: Validity::Drive.code(),
        ..VelocityRequest::default()
    }
}

/// Everything present and fresh; the tests spoil one field each.
#[derive(Debug, Clone)]
struct Period {
    robot: Option<Description>,
    request: Option<(VelocityRequest, u64)>,
    scan: Option<(Scan, Vec<f32>, u64)>,
    odometry: Option<(Odometry, u64)>,
    stopping: bool,
}

impl Period {
    fn fresh(request: VelocityRequest) -> Self {
        Self {
            robot: Some(robot()),
            request: Some((request, 3 * MS)),
            scan: Some((scan(4), vec![9.0, f32::INFINITY, 8.0, f32::NAN], 30 * MS)),
            odometry: Some((Odometry::default(), 2 * MS)),
            stopping: false,
        }
    }

    fn decide(&self, bench: &mut Bench) -> VelocityCommand {
        bench.decide(self, PERIOD_NS)
    }
}

/// A guard, and a robot that does at once what it is told.
struct Bench {
    guard: Guard,
    count: u64,
    moves: (f64, f64),
    pose: Pose,
}

impl Bench {
    fn decide(&mut self, period: &Period, period_ns: u64) -> VelocityCommand {
        self.count += 1;
        let (id, run_ns) = (self.count, self.count * PERIOD_NS);
        let odometry = period.odometry.map(|(odometry, age_ns)| {
            let moving = Odometry {
                pose: self.pose,
                v_mps: odometry.v_mps + self.moves.0,
                w_radps: odometry.w_radps + self.moves.1,
                ..odometry
            };
            (moving, age_ns)
        });
        let command = self.guard.decide(&GuardInputs {
            robot: period.robot.as_ref().map(|robot| (robot, &[][..])),
            request: period.request,
            scan: period
                .scan
                .as_ref()
                .map(|(scan, ranges, age_ns)| ScanInput {
                    scan,
                    ranges,
                    id,
                    run_ns,
                    age_ns: *age_ns,
                    odom_from_base: Some(self.pose),
                }),
            odometry: odometry.as_ref().map(|(odometry, age_ns)| OdometryInput {
                odometry,
                id,
                run_ns,
                age_ns: *age_ns,
            }),
            period_ns,
            stopping: period.stopping,
        });
        self.moves = (command.v_mps, command.w_radps);
        // Odometry that stood still while it moves would be refused: a step to and fro.
        self.pose.x_m = if self.pose.x_m > 0.0 { 0.0 } else { 0.001 };
        command
    }
}

fn guard() -> Bench {
    Bench {
        guard: Guard::new(GuardConfig::default()),
        count: 0,
        moves: (0.0, 0.0),
        pose: Pose::default(),
    }
}

/// Drives at 0.6 m/s, then lives through `period`: its answer and whether it was a ramp step.
#[track_caller]
fn check_ramp(period: &Period, validity: Validity, intervention: Intervention) {
    let mut guard = guard();
    let before = Period::fresh(drive(0.6, 0.3)).decide(&mut guard);
    assert_eq!(before.validity(), Some(Validity::Drive));
    let after = period.decide(&mut guard);
    assert_eq!(after.validity(), Some(validity));
    assert_eq!(after.intervention(), Some(intervention));
    assert!((after.v_mps - (0.6 - 1.5 * PERIOD_S)).abs() < 1e-12);
    assert!((after.w_radps / after.v_mps - 0.5).abs() < 1e-12);
}

#[test]
fn a_good_request_passes_as_it_is() {
    let command = Period::fresh(drive(0.6, -0.4)).decide(&mut guard());
    assert_eq!(command.validity(), Some(Validity::Drive));
    assert_eq!(command.intervention(), Some(Intervention::None));
    assert!((command.v_mps - 0.6).abs() < 1e-15 && (command.w_radps + 0.4).abs() < 1e-15);
}

#[test]
fn too_fast_is_clamped_on_the_same_arc() {
    let command = Period::fresh(drive(4.0, 2.0)).decide(&mut guard());
    assert_eq!(command.intervention(), Some(Intervention::Clamped));
    assert!((command.v_mps - 1.0).abs() < 1e-12 && (command.w_radps - 0.5).abs() < 1e-12);
}

#[test]
fn before_any_request_the_command_is_zero() {
    let mut period = Period::fresh(drive(0.0, 0.0));
    period.request = None;
    let command = period.decide(&mut guard());
    assert_eq!(command.validity(), Some(Validity::NoRequest));
    assert_eq!(command.intervention(), Some(Intervention::None));
    assert!(command.v_mps == 0.0 && command.w_radps == 0.0);
}

#[test]
fn every_lost_input_has_its_name() {
    let mut lost = Period::fresh(drive(0.6, 0.3));
    lost.request = None;
    check_ramp(&lost, Validity::Stale, Intervention::RequestStale);
    lost = Period::fresh(drive(0.6, 0.3));
    lost.request = Some((drive(0.6, 0.3), 101 * MS));
    check_ramp(&lost, Validity::Stale, Intervention::RequestStale);
    lost = Period::fresh(drive(0.6, 0.3));
    lost.scan = None;
    check_ramp(&lost, Validity::Stale, Intervention::ScanStale);
    lost.scan = Some((scan(4), vec![9.0; 4], 351 * MS));
    check_ramp(&lost, Validity::Stale, Intervention::ScanStale);
    lost = Period::fresh(drive(0.6, 0.3));
    lost.odometry = None;
    check_ramp(&lost, Validity::Stale, Intervention::OdometryStale);
    lost.odometry = Some((Odometry::default(), 101 * MS));
    check_ramp(&lost, Validity::Stale, Intervention::OdometryStale);
}

#[test]
fn malformed_inputs_count_as_lost() {
    let mut bad = Period::fresh(drive(0.6, 0.3));
    bad.scan = Some((scan(3), vec![1.0], 0));
    check_ramp(&bad, Validity::Stale, Intervention::ScanStale);
    bad.scan = Some((scan(4), vec![f32::NAN; 4], 0));
    check_ramp(&bad, Validity::Stale, Intervention::ScanStale);
    // Fewer beams than the robot's lidar has, and another field of view.
    bad.scan = Some((scan(3), vec![9.0; 3], 0));
    check_ramp(&bad, Validity::Stale, Intervention::ScanStale);
    let turned = Scan {
        angle_min_rad: 0.5,
        ..scan(4)
    };
    bad.scan = Some((turned, vec![9.0; 4], 0));
    check_ramp(&bad, Validity::Stale, Intervention::ScanStale);
    bad.scan = Some((scan(0), Vec::new(), 0));
    check_ramp(&bad, Validity::Stale, Intervention::ScanStale);
    bad = Period::fresh(drive(0.6, 0.3));
    let odometry = Odometry {
        v_mps: f64::NAN,
        ..Odometry::default()
    };
    bad.odometry = Some((odometry, 0));
    check_ramp(&bad, Validity::Stale, Intervention::OdometryStale);
}

#[test]
fn requests_that_are_no_numbers_are_refused() {
    for request in [
        drive(f64::NAN, 0.0),
        drive(0.1, f64::INFINITY),
        VelocityRequest {
            validity: 999,
            ..drive(0.1, 0.1)
        },
        VelocityRequest {
            braking_arc_m: f64::NAN,
            ..drive(0.1, 0.1)
        },
    ] {
        check_ramp(
            &Period::fresh(request),
            Validity::Stale,
            Intervention::Refused,
        );
    }
}

#[test]
fn a_stop_keeps_its_meaning_and_ramps() {
    for validity in [Validity::AtGoal, Validity::Blocked, Validity::NoPath] {
        let request = VelocityRequest {
            validity: validity.code(),
            ..drive(0.9, 0.9)
        };
        check_ramp(&Period::fresh(request), validity, Intervention::None);
    }
    let mut stopping = Period::fresh(drive(0.9, 0.0));
    stopping.stopping = true;
    check_ramp(&stopping, Validity::Stopped, Intervention::None);
}

#[test]
fn a_second_answer_in_the_same_tick_does_not_brake_twice() {
    let mut guard = guard();
    Period::fresh(drive(0.6, 0.0)).decide(&mut guard);
    let mut nothing = Period::fresh(drive(0.6, 0.0));
    nothing.request = None;
    assert!((guard.decide(&nothing, 0).v_mps - 0.6).abs() < 1e-15);
}

#[test]
fn without_a_description_nothing_moves() {
    let mut guard = guard();
    let mut period = Period::fresh(drive(0.6, 0.3));
    period.robot = None;
    let command = period.decide(&mut guard);
    assert!(command.v_mps == 0.0 && command.w_radps == 0.0);
    assert_eq!(command.intervention(), Some(Intervention::Refused));
}

#[test]
fn another_description_holds_from_the_next_command_on() {
    let mut guard = guard();
    let mut period = Period::fresh(drive(0.9, 0.0));
    assert!((period.decide(&mut guard).v_mps - 0.9).abs() < 1e-12);
    period.robot = Some(Description {
        v_mps_max: 0.5,
        ..robot()
    });
    let command = period.decide(&mut guard);
    assert_eq!(command.intervention(), Some(Intervention::Clamped));
    assert!((command.v_mps - 0.5).abs() < 1e-12);
}

/// A robot that is slowing down follows its commands late: a ramp that began at its speed would
/// ask it to speed up again.
#[test]
fn a_ramp_of_a_robot_that_slows_down_begins_below_its_last_command() {
    let mut guard = guard();
    Period::fresh(drive(0.5, 0.0)).decide(&mut guard);
    guard.moves = (0.56, 0.0);
    let mut lost = Period::fresh(drive(0.5, 0.0));
    lost.request = None;
    let command = lost.decide(&mut guard);
    assert_eq!(command.intervention(), Some(Intervention::RequestStale));
    assert!(
        (command.v_mps - (0.5 - 1.5 * PERIOD_S)).abs() < 1e-12,
        "{}",
        command.v_mps
    );
}

fn any_speed() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => -3.0..3.0,
        1 => Just(f64::NAN),
        1 => Just(f64::INFINITY),
        1 => Just(1.0e300),
        1 => any::<f64>(),
    ]
}

prop_compose! {
    fn any_period()(
        v in any_speed(),
        w in any_speed(),
        validity in 0u16..9,
        ages in prop::array::uniform3(prop_oneof![4 => 0..90 * MS, 1 => Just(OLD)]),
        present in prop::array::uniform3(prop::bool::weighted(0.9)),
        stopping in prop::bool::weighted(0.05),
        range in prop_oneof![2 => 5.0f32..20.0, 1 => any::<f32>()],
    ) -> Period {
        Period {
            robot: Some(robot()),
            request: present[0].then_some((
                VelocityRequest { validity, ..drive(v, w) },
                ages[0],
            )),
            scan: present[1].then_some((scan(4), vec![range; 4], ages[1])),
            odometry: present[2].then_some((Odometry::default(), ages[2])),
            stopping,
        }
    }
}

proptest! {
    #[test]
    fn commands_are_numbers_within_the_limits_and_ramps_are_ramps(
        periods in prop::collection::vec(any_period(), 1..60),
    ) {
        let (mut guard, robot) = (guard(), robot());
        let mut last = (0.0, 0.0);
        for period in &periods {
            let command = period.decide(&mut guard);
            prop_assert!(command.check().is_ok());
            prop_assert!(command.v_mps >= robot.v_mps_min && command.v_mps <= robot.v_mps_max);
            prop_assert!(command.w_radps.abs() <= robot.w_radps_max);
            if command.validity() != Some(Validity::Drive) {
                // The robot of this bench does at once what it is told, so a ramp starts there.
                let dv = command.v_mps - last.0;
                let dw = command.w_radps - last.1;
                prop_assert!(dv.abs() <= robot.brake_mps2 * PERIOD_S + 1e-12);
                prop_assert!(dw.abs() <= robot.alpha_radps2_max * PERIOD_S + 1e-12);
                prop_assert!(command.v_mps.abs() <= last.0.abs());
                prop_assert!(command.w_radps.abs() <= last.1.abs());
            }
            last = (command.v_mps, command.w_radps);
        }
    }

    #[test]
    fn only_a_fresh_drive_of_numbers_drives(period in any_period()) {
        let mut guard = guard();
        let command = period.decide(&mut guard);
        if command.validity() == Some(Validity::Drive) {
            prop_assert!(period.robot.is_some());
            let (request, age) = period.request.expect("a request drove");
            prop_assert!(request.check().is_ok() && age <= 100 * MS);
            prop_assert!(period.scan.is_some_and(|(_, _, age)| age <= 350 * MS));
            prop_assert!(period.odometry.is_some_and(|(_, age)| age <= 100 * MS));
            prop_assert!(!period.stopping);
        } else {
            prop_assert!(command.v_mps == 0.0 && command.w_radps == 0.0);
        }
    }

    #[test]
    fn silence_always_ends_at_rest_in_braking_time(
        v in -0.2f64..1.0,
        w in -1.8f64..1.8,
        lost in 0usize..3,
    ) {
        let (mut guard, robot) = (guard(), robot());
        Period::fresh(drive(v, w)).decide(&mut guard);
        let mut period = Period::fresh(drive(v, w));
        match lost {
            0 => period.request = None,
            1 => period.scan = None,
            _ => period.odometry = None,
        }
        let needed_s = v.abs() / robot.brake_mps2 + w.abs() / robot.alpha_radps2_max;
        let mut elapsed_s = 0.0;
        let mut command = period.decide(&mut guard);
        while elapsed_s < needed_s + 2.0 * PERIOD_S {
            command = period.decide(&mut guard);
            elapsed_s += PERIOD_S;
        }
        prop_assert!(command.v_mps == 0.0 && command.w_radps == 0.0);
    }
}
