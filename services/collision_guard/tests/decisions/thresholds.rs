//! Where an input stops being good, on both sides of each limit, and with which command a ramp begins.

use zeronav_collision_guard::{Guard, GuardConfig, GuardInputs, OdometryInput, ScanInput};
use zeronav_msgs::command::{Intervention, Validity, VelocityCommand, VelocityRequest};
use zeronav_msgs::description::{Corner, Description};
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::scan::Scan;

const MS: u64 = 1_000_000;
const TICK_NS: u64 = 20 * MS;
const N_BEAMS: u32 = 21;

fn robot() -> Description {
    Description {
        v_mps_max: 1.0,
        v_mps_min: -0.5,
        w_radps_max: 2.0,
        a_mps2_max: 1.0,
        brake_mps2: 2.0,
        alpha_radps2_max: 3.0,
        inscribed_radius_m: 0.25,
        circumscribed_radius_m: 0.25,
        angle_min_rad: -1.0,
        angle_increment_rad: 0.1,
        range_m_max: 10.0,
        scan_period_ns: 100 * MS,
        n_beams: N_BEAMS,
        ..Description::default()
    }
}

/// What the guard gets in a period; the tests change a field each.
struct Inputs {
    scan: Scan,
    ranges: Vec<f32>,
    ages_ms: [u64; 3],
    odometry: Odometry,
    /// Whether there is a request.
    asked: bool,
    /// None for a disc.
    corners: Vec<Corner>,
}

impl Inputs {
    fn new() -> Self {
        Self {
            scan: Scan {
                n_beams: N_BEAMS,
                angle_min_rad: -1.0,
                angle_increment_rad: 0.1,
                range_m_max: 10.0,
                ..Scan::default()
            },
            ranges: vec![f32::INFINITY; N_BEAMS as usize],
            ages_ms: [0; 3],
            odometry: Odometry::default(),
            asked: true,
            corners: Vec::new(),
        }
    }

    /// The answer in this tick, from 1, to a request to drive so.
    fn decide(&self, guard: &mut Guard, tick: u64, [v_mps, w_radps]: [f64; 2]) -> VelocityCommand {
        let request = VelocityRequest {
            v_mps,
            w_radps,
            validity: Validity::Drive.code(),
            ..VelocityRequest::default()
        };
        let robot = Description {
            n_corners: u32::try_from(self.corners.len()).expect("a few"),
            ..robot()
        };
        let [request_ns, scan_ns, odometry_ns] = self.ages_ms.map(|ms| ms * MS);
        guard.decide(&GuardInputs {
            robot: Some((&robot, &self.corners)),
            request: self.asked.then_some((request, request_ns)),
            scan: Some(ScanInput {
                scan: &self.scan,
                ranges: &self.ranges,
                id: tick,
                run_ns: tick * TICK_NS,
                age_ns: scan_ns,
                odom_from_base: Some(self.odometry.pose),
            }),
            odometry: Some(OdometryInput {
                odometry: &self.odometry,
                id: tick,
                run_ns: tick * TICK_NS,
                age_ns: odometry_ns,
            }),
            period_ns: TICK_NS,
            stopping: false,
        })
    }

    fn first(&self) -> Intervention {
        let mut guard = Guard::new(GuardConfig::default());
        let command = self.decide(&mut guard, 1, [0.1, 0.0]);
        command.intervention().expect("a known intervention")
    }
}

/// What comes of the inputs after this change.
fn with(change: impl FnOnce(&mut Inputs)) -> Intervention {
    let mut inputs = Inputs::new();
    change(&mut inputs);
    inputs.first()
}

#[test]
fn an_input_is_good_until_its_age() {
    use Intervention::{None, OdometryStale, RequestStale, ScanStale};
    for (n, limit_ms, stale) in [
        (0, 100, RequestStale),
        (1, 350, ScanStale),
        (2, 100, OdometryStale),
    ] {
        assert_eq!(with(|it| it.ages_ms[n] = limit_ms - 1), None, "{stale}");
        assert_eq!(with(|it| it.ages_ms[n] = limit_ms + 1), stale);
    }
}

#[test]
fn a_request_of_exactly_its_age_is_good() {
    assert_eq!(with(|it| it.ages_ms[0] = 100), Intervention::None);
}

/// The first beam may be 0.02 rad off, and so may the last.
#[test]
fn a_scan_has_the_geometry_of_the_description() {
    use Intervention::{None, ScanStale};
    for (first_off, last_off, expected) in [
        (0.019, 0.019, None),
        (-0.019, -0.019, None),
        (0.021, 0.0, ScanStale),
        (-0.021, 0.0, ScanStale),
        (0.0, 0.019, None),
        (0.0, 0.021, ScanStale),
        (0.0, -0.021, ScanStale),
        (-0.015, 0.015, None),
        (0.015, -0.015, None),
        (-0.015, 0.025, ScanStale),
    ] {
        let found = with(|it| {
            it.scan.angle_min_rad = -1.0 + first_off;
            it.scan.angle_increment_rad = 0.1 + (last_off - first_off) / 20.0;
        });
        assert_eq!(found, expected, "{first_off} and {last_off} rad");
    }
    let beam_more = with(|it| {
        it.scan.n_beams += 1;
        it.ranges.push(f32::INFINITY);
    });
    assert_eq!(beam_more, ScanStale);
}

#[test]
fn a_scan_that_does_not_describe_its_ranges_is_not_used() {
    use Intervention::{None, ScanStale};
    assert_eq!(with(|_| ()), None);
    assert_eq!(with(|it| it.ranges.truncate(20)), ScanStale);
    assert_eq!(with(|it| it.ranges.clear()), ScanStale);
    assert_eq!(with(|it| it.scan.range_m_max = f32::NAN), ScanStale);
}

/// Of 21 beams 3 are more than a tenth, 2 are less.
#[test]
fn a_scan_with_too_few_valid_beams_is_blind() {
    let valid = |n: usize| {
        with(|it| {
            it.ranges.fill(f32::NAN);
            it.ranges[..n].fill(f32::INFINITY);
        })
    };
    assert_eq!(valid(2), Intervention::ScanStale);
    assert_eq!(valid(3), Intervention::None);
}

/// A pose that stays while the twist moves is believed for as long as odometry may be old.
#[test]
fn odometry_that_stands_while_it_moves_is_stale() {
    let mut guard = Guard::new(GuardConfig::default());
    let mut inputs = Inputs::new();
    inputs.odometry.v_mps = 0.1;
    // The second is the first that is the same: from then on 100 ms are five ticks.
    for tick in 1..=7 {
        let command = inputs.decide(&mut guard, tick, [0.1, 0.0]);
        assert_eq!(command.intervention(), Some(Intervention::None), "{tick}");
    }
    let command = inputs.decide(&mut guard, 8, [0.1, 0.0]);
    assert_eq!(command.intervention(), Some(Intervention::OdometryStale));
}

/// The first command of a ramp after a request for `last` of a robot that does `measured` now.
fn ramp(last: [f64; 2], measured: [f64; 2]) -> [f64; 2] {
    let mut guard = Guard::new(GuardConfig::default());
    let mut inputs = Inputs::new();
    let command = inputs.decide(&mut guard, 1, last);
    assert_eq!(command.intervention(), Some(Intervention::None));
    [inputs.odometry.v_mps, inputs.odometry.w_radps] = measured;
    inputs.asked = false;
    let command = inputs.decide(&mut guard, 2, last);
    assert_eq!(command.intervention(), Some(Intervention::RequestStale));
    [command.v_mps, command.w_radps]
}

#[test]
fn a_ramp_begins_where_the_robot_is_and_no_faster_than_its_last_command() {
    // 20 ms of braking are 0.04 m/s, and of turning 0.06 rad/s; 60 ms ahead are 0.12 m/s, 0.18 rad/s.
    for (last, measured, first) in [
        // As fast as commanded, on its arc.
        ([0.5, 0.5], [0.5, 0.5], [0.46, 0.46]),
        // Slower than commanded: from its own speed.
        ([0.8, 0.8], [0.5, 0.5], [0.46, 0.46]),
        // Faster: below its speed by as much, up to the lead.
        ([0.45, 0.0], [0.5, 0.0], [0.41, 0.0]),
        ([0.1, 0.0], [0.5, 0.0], [0.34, 0.0]),
        ([-0.35, 0.0], [-0.4, 0.0], [-0.31, 0.0]),
        // The yaw rate is that of the arc for the speed that it has.
        ([0.45, 0.1], [0.5, 0.5], [0.41, 0.46]),
        // On the spot: from the last command, as near as the robot can have followed.
        ([0.0, 1.0], [0.0, 0.9], [0.0, 0.94]),
        ([0.0, 1.0], [0.0, 0.5], [0.0, 0.62]),
        ([0.0, 0.1], [0.0, 0.5], [0.0, 0.26]),
        ([0.0, -1.0], [0.0, -0.5], [0.0, -0.62]),
    ] {
        let found = ramp(last, measured);
        let off = (found[0] - first[0]).abs().max((found[1] - first[1]).abs());
        assert!(off < 1e-9, "{last:?} at {measured:?}: {found:?}");
    }
}

/// A ramp is given up with the next request that is obeyed: the one after it begins at the speed of then.
#[test]
fn a_second_ramp_does_not_go_on_from_the_first() {
    let mut guard = Guard::new(GuardConfig::default());
    let mut inputs = Inputs::new();
    let mut speeds_mps = Vec::new();
    for (tick, asked, measured_mps) in [
        (1, true, 0.5),
        // 40 ms of braking.
        (2, false, 0.5),
        (3, false, 0.46),
        (4, true, 0.5),
        (5, false, 0.5),
    ] {
        inputs.odometry.v_mps = measured_mps;
        inputs.odometry.pose.x_m += 0.02 * measured_mps;
        inputs.asked = asked;
        speeds_mps.push(inputs.decide(&mut guard, tick, [0.5, 0.0]).v_mps);
    }
    for (found, expected) in speeds_mps.iter().zip([0.5, 0.46, 0.42, 0.5, 0.46]) {
        assert!((found - expected).abs() < 1e-9, "{speeds_mps:?}");
    }
}

#[test]
fn a_request_that_stops_coming_is_stale_however_many_came_before() {
    for n in 1..=3 {
        let mut guard = Guard::new(GuardConfig::default());
        let mut inputs = Inputs::new();
        for tick in 1..=n {
            inputs.decide(&mut guard, tick, [0.0, 0.0]);
        }
        inputs.asked = false;
        let command = inputs.decide(&mut guard, n + 1, [0.0, 0.0]);
        assert_eq!(
            command.intervention(),
            Some(Intervention::RequestStale),
            "{n}"
        );
    }
}

#[test]
fn another_footprint_of_the_same_robot_holds_from_the_next_command_on() {
    let mut guard = Guard::new(GuardConfig::default());
    let mut inputs = Inputs::new();
    // Half a metre ahead.
    inputs.ranges[10] = 0.5;
    for (tick, front_m, expected) in [
        (1, 0.3, Intervention::None),
        (2, 0.495, Intervention::StoppedShort),
        (3, 0.3, Intervention::None),
    ] {
        inputs.corners = [(front_m, 0.2), (-0.2, 0.2), (-0.2, -0.2), (front_m, -0.2)]
            .map(|(x_m, y_m)| Corner { x_m, y_m })
            .to_vec();
        let command = inputs.decide(&mut guard, tick, [0.1, 0.0]);
        assert_eq!(command.intervention(), Some(expected), "{front_m} m");
    }
}
