use super::super::case::{Manner, Rule};
use super::super::future::{Mover, walker};
use super::super::oracle::robot::{Abilities, State};
use super::super::turns;
use super::*;
use zeronav_msgs::Pose;
use zeronav_robot_description::RobotPreset;
use zeronav_scenario::GoalSpec;
use zeronav_world::spec::ShapeSpec;
use zeronav_world::{Footprint, World, WorldSpec};

/// Half of the robot's length and width. [m]
const HALF_M: [f64; 2] = [0.254, 0.215];

/// The top speed [m/s], the acceleration [m/s^2], the yaw rate [rad/s] and the yaw acceleration
/// [rad/s^2] of the robot.
const LIMITS: [f64; 4] = [2.0, 3.0, 4.0, 8.0];

/// Time for 10 m from a stand: 2/3 s and 2/3 m to top speed, and 28/3 m at 2 m/s. [s]
const OPTIMUM_S: f64 = 16.0 / 3.0;

fn jackal() -> Abilities {
    let robot = RobotPreset::Jackal.robot();
    Abilities::new(&robot, &robot.footprint().unwrap())
}

fn wall(lower_m: [f64; 2], upper_m: [f64; 2]) -> ShapeSpec {
    let middle = |axis: usize| 0.5 * (lower_m[axis] + upper_m[axis]);
    let side = |axis: usize| upper_m[axis] - lower_m[axis];
    ShapeSpec::Box {
        centre_m: [middle(0), middle(1)],
        size_m: [side(0), side(1)],
        yaw_rad: 0.0,
    }
}

fn hall(shapes: &[ShapeSpec]) -> World {
    let spec = WorldSpec {
        shapes: shapes.to_vec(),
        ..WorldSpec::area([0.0, 0.0], [14.0, 6.0])
    };
    World::new(&spec, None).unwrap()
}

/// A way from (1, y) to within 1 m of (12, y).
fn way(world: &World, movers: &[Mover], [y, yaw]: [f64; 2], limit_s: f64) -> Option<Route> {
    let task = Task {
        world,
        movers,
        abilities: &jackal(),
        start: Pose::new(1.0, y, yaw),
        goal_m: [12.0, y],
        tolerance_m: 1.0,
        time_limit_s: limit_s,
    };
    search::find(&task, &AtomicBool::new(false))
}

/// Least distance of the robot's rectangle from the discs of 0.3 m, looked at every millisecond. [m]
fn least_m(way: &Route, movers: &[Mover]) -> f64 {
    let mut least_m = f64::INFINITY;
    for ends in way.states.windows(2) {
        for part in 0..5 {
            let share = f64::from(part) / 5.0;
            let between = |a: f64, b: f64| a + share * (b - a);
            let [a, b] = [ends[0], ends[1]];
            let t_s = between(a.t_s, b.t_s);
            let (sin, cos) = between(a.yaw_rad, b.yaw_rad).sin_cos();
            for (centre_m, radius_m) in movers.iter().filter_map(|mover| mover.at(t_s)) {
                let dx = centre_m[0] - between(a.at_m[0], b.at_m[0]);
                let dy = centre_m[1] - between(a.at_m[1], b.at_m[1]);
                let along = ((cos * dx + sin * dy).abs() - HALF_M[0]).max(0.0);
                let across = ((cos * dy - sin * dx).abs() - HALF_M[1]).max(0.0);
                least_m = least_m.min(along.hypot(across) - radius_m);
            }
        }
    }
    least_m
}

/// Checks that a robot with these limits can drive the way.
fn check_motion(way: &Route) {
    let [v_max, a_max, w_max, alpha_max] = LIMITS;
    let first = way.states[0];
    assert!(first.v_mps.abs() < 1e-12 && first.w_radps.abs() < 1e-12);
    for ends in way.states.windows(2) {
        let [a, b]: [State; 2] = [ends[0], ends[1]];
        let step_s = b.t_s - a.t_s;
        assert!((step_s - 0.005).abs() < 1e-9);
        assert!((0.0..=v_max + 1e-9).contains(&b.v_mps), "{b:?}");
        assert!(b.w_radps.abs() <= w_max + 1e-9, "{b:?}");
        assert!((b.v_mps - a.v_mps).abs() <= a_max * step_s * 1.0001);
        assert!((b.w_radps - a.w_radps).abs() <= alpha_max * step_s * 1.0001);
        let turned = b.yaw_rad - a.yaw_rad;
        assert!((turned - 0.5 * (a.w_radps + b.w_radps) * step_s).abs() < 1e-9);
        // It goes where it looks, as fast as it says.
        let (sin, cos) = (0.5 * (a.yaw_rad + b.yaw_rad)).sin_cos();
        let along_m = 0.5 * (a.v_mps + b.v_mps) * step_s;
        assert!((b.at_m[0] - a.at_m[0] - along_m * cos).abs() < 1e-6);
        assert!((b.at_m[1] - a.at_m[1] - along_m * sin).abs() < 1e-6);
    }
}

#[test]
fn an_empty_hall_takes_hardly_more_than_the_time_that_it_must() {
    let straight = way(&hall(&[]), &[], [3.0, 0.0], 60.0).unwrap();
    check_motion(&straight);
    let time_s = straight.time_s();
    assert!(
        (OPTIMUM_S - 1e-9..OPTIMUM_S + 0.03).contains(&time_s),
        "{time_s}"
    );
    assert!((straight.length_m() - 10.0).abs() < 0.02);
    assert!(straight.clearance_m.is_infinite());
    // A robot that looks away turns first: half a turn takes it pi / 4 + 4 / 8 s.
    let turned = way(&hall(&[]), &[], [3.0, PI], 60.0).unwrap();
    check_motion(&turned);
    let time_s = turned.time_s();
    let turn_s = PI / 4.0 + 0.5;
    assert!(
        (OPTIMUM_S + 0.3..OPTIMUM_S + turn_s + 0.2).contains(&time_s),
        "{time_s}"
    );
    // What must take longer than the limit is not found.
    assert!(way(&hall(&[]), &[], [3.0, 0.0], OPTIMUM_S - 0.01).is_none());
}

#[test]
fn somebody_who_crosses_is_let_through_or_passed() {
    let world = hall(&[]);
    // He is in the middle of the way when the robot would be there.
    let crossing = [Mover::walking(&[[0.0, 6.0, 0.0], [6.0, 6.0, 6.0]])];
    let straight = way(&world, &[], [3.0, 0.0], 60.0).unwrap();
    assert!(least_m(&straight, &crossing) < -0.1);
    let around = way(&world, &crossing, [3.0, 0.0], 60.0).unwrap();
    check_motion(&around);
    let least_m = least_m(&around, &crossing);
    assert!(least_m > 0.005, "{least_m}");
    assert!((least_m - around.clearance_m).abs() < 0.005);
    let time_s = around.time_s();
    assert!(
        (OPTIMUM_S - 1e-9..OPTIMUM_S + 1.0).contains(&time_s),
        "{time_s}"
    );
}

#[test]
fn who_fills_a_corridor_is_only_passed_where_there_is_a_niche() {
    // 0.7 m between the walls; a robot cannot turn in it.
    let above = wall([0.0, 3.35], [14.0, 6.0]);
    let below = |from_m: f64, to_m: f64| wall([from_m, 0.0], [to_m, 2.65]);
    let comes = [Mover::walking(&[[0.0, 13.0, 3.0], [26.0, 0.0, 3.0]])];
    let closed = hall(&[above.clone(), below(0.0, 14.0)]);
    assert!(way(&closed, &[], [3.0, 0.0], 60.0).is_some());
    assert!(way(&closed, &comes, [3.0, 0.0], 60.0).is_none());
    let niche = hall(&[above, below(0.0, 4.0), below(7.0, 14.0)]);
    let found = way(&niche, &comes, [3.0, 0.0], 60.0).unwrap();
    check_motion(&found);
    let clearance_m = least_m(&found, &comes);
    assert!(clearance_m > 0.005, "{clearance_m}");
    // Nobody is passed before the niche, which he has left when the robot goes on.
    assert!(found.time_s() > OPTIMUM_S + 3.0);
}

#[test]
fn the_same_question_has_the_same_answer() {
    let crowd: Vec<Mover> = (0..12)
        .map(f64::from)
        .map(|n| {
            let (x, from, to) = (2.5 + 0.7 * n, 6.0 * (n % 2.0), 6.0 - 6.0 * (n % 2.0));
            let until_s = 6.0 + 0.37 * n;
            Mover::walking(&[[0.0, x, from], [until_s, x, to], [2.0 * until_s, x, from]])
        })
        .collect();
    let world = hall(&[wall([6.0, 2.0], [6.5, 4.0])]);
    let [first, second] = [0, 1].map(|_| way(&world, &crowd, [3.0, 0.0], 60.0).unwrap());
    assert_eq!(first, second);
    check_motion(&first);
    let least_m = least_m(&first, &crowd);
    assert!(least_m > 0.005, "{least_m}");
}

fn case(folder: &tempfile::TempDir) -> Case {
    Case {
        world: "hall".to_owned(),
        class: None,
        seed: 1,
        scenario: folder.path().join("it.toml"),
        time_limit_s: 30.0,
        rule: Rule {
            success: Success::Arrival {
                goal_m: [9.0, 2.0],
                tolerance_m: 1.0,
                standing_counts: true,
            },
            optimal_time_s: Some(3.5),
            reference_m: Some(7.0),
            future_is_known: true,
            way: turns::OutlineWay::NotSearched,
        },
        manner: Manner::default(),
    }
}

#[test]
fn a_way_is_a_row_without_contacts() {
    let folder = walker("");
    let go_on = AtomicBool::new(false);
    let rows = rows(&[case(&folder)], 2, false, &go_on).unwrap();
    let [row] = &rows[..] else {
        panic!("{rows:?}");
    };
    assert!(row.success && row.arrived && !row.is_at_fault(), "{row:?}");
    assert_eq!((row.contacts_moving, row.unavoidable), (0, Some(0)));
    assert!(row.time_s.unwrap() > row.clock_s.unwrap());
    assert!((0.99..1.2).contains(&row.path_ratio.unwrap()), "{row:?}");
    assert!(row.clearance_m_min.unwrap() > 0.0);
    // At 1 m/s at most, 7 m take more than 7 s: OT / T, T up to 8 OT.
    assert!((0.35..0.5).contains(&row.score.unwrap()), "{row:?}");
    let limited = Case {
        time_limit_s: 5.0,
        ..case(&folder)
    };
    let none = &super::rows(&[limited], 1, false, &go_on).unwrap()[0];
    assert_eq!(none.cause.as_deref(), Some("none found"));
    assert_eq!((none.success, none.score), (false, Some(0.0)));
}

#[test]
fn what_depends_on_the_robot_is_refused_before_anything_is_planned() {
    let folder = walker("starts = { robot_near = { point_m = [1.0, 1.0], distance_m = 1.0 } }");
    let refused = rows(&[case(&folder)], 1, false, &AtomicBool::new(false)).unwrap_err();
    let SuiteError::Usage(line) = refused else {
        panic!("{refused:?}");
    };
    assert!(line.contains("walker") && !line.contains('\n'), "{line}");
    let folder = walker("");
    let mut case = case(&folder);
    case.rule.success = Success::Expectations;
    // It has no goal.
    assert!(rows(&[case], 1, false, &AtomicBool::new(false)).is_err());
}

/// The way of a rectangle, from a pose to a pose and a yaw, in a hall with these walls.
fn outline_way(
    half_m: [f64; 2],
    shapes: &[ShapeSpec],
    from: Pose,
    to: Pose,
) -> Option<turns::Turns> {
    let robot = RobotPreset::Jackal.robot();
    let [x, y] = half_m;
    let footprint = Footprint::polygon(&[[-x, -y], [x, -y], [x, y], [-x, y]]).unwrap();
    let abilities = Abilities::new(&robot, &footprint);
    let goal = GoalSpec {
        pose: to,
        tolerance_m: 0.1,
        yaw_tolerance_rad: 0.1,
    };
    turns::find(&hall(shapes), &abilities, from, &goal)
}

#[test]
fn the_way_of_an_outline_takes_no_less_than_the_straight_line_and_its_turns() {
    let open = outline_way(
        [0.6, 0.25],
        &[],
        Pose::new(1.5, 3.0, 0.0),
        Pose::new(11.5, 3.0, 0.0),
    );
    let open = open.unwrap();
    // 10 m less the tolerance at 2 m/s.
    assert!((4.94..5.1).contains(&open.time_s), "{open:?}");
    assert!((9.89..10.1).contains(&open.length_m), "{open:?}");
    let about = outline_way(
        [0.6, 0.25],
        &[],
        Pose::new(3.0, 3.0, 0.0),
        Pose::new(3.0, 3.0, 3.0),
    );
    let [.., w_max, _] = LIMITS;
    let about = about.unwrap();
    assert!(
        (2.9 / w_max - 0.01..3.1 / w_max).contains(&about.time_s),
        "{about:?}"
    );
}

#[test]
fn an_outline_turns_a_corner_only_where_it_fits() {
    // A corridor of 1.2 m along the lower edge, and one of the same width up along the right.
    let corner = |width_m: f64| {
        [
            wall([0.0, 1.0 + width_m], [12.8 - width_m, 6.0]),
            wall([0.0, 0.0], [14.0, 1.0]),
            wall([12.8, 1.0], [14.0, 6.0]),
        ]
    };
    let around = |half_m, width_m: f64| {
        let from = Pose::new(2.0, 1.0 + 0.5 * width_m, 0.0);
        let to = Pose::new(12.8 - 0.5 * width_m, 4.5, 0.5 * PI);
        outline_way(half_m, &corner(width_m), from, to)
    };
    assert!(around([0.6, 0.25], 1.2).is_some());
    // 1.2 m x 0.5 m gets around no corner of two corridors that are narrower than 0.92 m.
    assert!(around([0.6, 0.25], 0.8).is_none());
    // A door that is narrower than the robot is none.
    let door = [wall([6.0, 0.0], [6.2, 2.76]), wall([6.0, 3.24], [6.2, 6.0])];
    let (from, to) = (Pose::new(2.0, 3.0, 0.0), Pose::new(10.0, 3.0, 0.0));
    assert!(outline_way([0.6, 0.25], &door, from, to).is_none());
    assert!(outline_way([0.6, 0.22], &door, from, to).is_some());
}
