//! Whole control periods: from messages to requests.

use crate::support::{Map, PERIOD_S, block, disc, path};
use nalgebra::Point2;
use zeronav_local_planner::period::BuildError;
use zeronav_local_planner::situation::Future;
use zeronav_local_planner::staleness::{Ages, StaleInput};
use zeronav_local_planner::{Inputs, LocalPlanner, LocalPlannerConfig, Outputs, PathInput};
use zeronav_motion::{InFlight, Twist, reachable};
use zeronav_msgs::Pose;
use zeronav_msgs::certainty::PoseCertainty;
use zeronav_msgs::command::{PlannerInput, RequestCause, Validity};
use zeronav_msgs::map::ObstacleSource;
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::path::{Path, PathBlock, PathStatus, Waypoint};
use zeronav_msgs::request::RequestReason;
use zeronav_msgs::task::{EndReason, Goal, StuckCause, Task, TaskKind, TaskState, TaskStatus};

const PERIOD_NS: u64 = 20_000_000;
const MS: u64 = 1_000_000;

/// A robot in an empty hall whose map frame is one metre beside the odometry's.
struct Bench {
    planner: LocalPlanner,
    robot: crate::support::Robot,
    map: Map,
    odometry: Odometry,
    path: Option<(Path, Vec<Waypoint>)>,
    ages: Ages,
    in_flight: InFlight,
    /// Hits of the scan, `map` frame. [m]
    hits: Vec<Point2<f64>>,
    tick: u64,
    certainty: PoseCertainty,
}

fn found(goal: u64, geometry: u64, corners: &[(f64, f64)]) -> (Path, Vec<Waypoint>) {
    let waypoints = path(corners);
    let fields = Path {
        status: PathStatus::Found.code(),
        n_waypoints: u32::try_from(waypoints.len()).unwrap_or(0),
        geometry,
        goal,
        ..Path::default()
    };
    (fields, waypoints)
}

impl Bench {
    fn new() -> Self {
        let walls = [block(0.0, 0.0, 8.0, 0.2), block(0.0, 3.8, 8.0, 4.0)];
        Self {
            planner: LocalPlanner::new(&LocalPlannerConfig::default()).expect("the defaults"),
            robot: disc(0.25, 0.8, 1.0, 1.8, 3.0),
            map: Map::of(&walls, 8.0, 4.0, 0.25),
            odometry: Odometry {
                pose: Pose::new(0.0, 2.0, 0.0),
                ..Odometry::default()
            },
            path: None,
            ages: Ages {
                scan_ns: Some(20 * MS),
                odometry_ns: Some(MS),
                map_ns: Some(40 * MS),
                obstacles_ns: Some(40 * MS),
                path_ns: Some(40 * MS),
            },
            in_flight: InFlight::default(),
            hits: Vec::new(),
            tick: 0,
            certainty: PoseCertainty::Confirmed,
        }
    }

    fn go(&mut self, id: u64, x_m: f64) {
        let goal = Goal {
            pose: Pose::new(x_m, 2.0, 0.0),
            tolerance_m: 0.15,
            yaw_tolerance_rad: 4.0,
            id,
        };
        let task = Task {
            kind: TaskKind::Go.code(),
            n_goals: 1,
            ..Task::default()
        };
        self.planner.accept_task(id, &task, &[goal]);
    }

    fn step(&mut self) -> Outputs {
        self.tick += 1;
        self.answer()
    }

    fn answer(&mut self) -> Outputs {
        let robot = &self.robot;
        let map_from_odom = Pose::new(1.0, 0.0, 0.0);
        let base_from_map = map_from_odom.then(&self.odometry.pose).isometry().inverse();
        let hits: Vec<Point2<f64>> = self.hits.iter().map(|hit| base_from_map * hit).collect();
        let outputs = self.planner.step(&Inputs {
            tick: self.tick,
            run_ns: self.tick * PERIOD_NS,
            period_s: PERIOD_S,
            robot: Some((&robot.description, &robot.corners)),
            odometry: Some(&self.odometry),
            map: Some((map_from_odom, self.map.view())),
            path: self
                .path
                .as_ref()
                .map(|(path, waypoints)| PathInput { path, waypoints }),
            certainty: self.certainty,
            map_cells: 1,
            obstacles: (&[], 0.0),
            future: Future::default(),
            scan_points_in_base: &hits,
            in_flight: &self.in_flight,
            zones: None,
            ages: self.ages,
            stopping: false,
        });
        assert_eq!(outputs.request.check(), Ok(()));
        let from = Twist::new(self.odometry.v_mps, self.odometry.w_radps);
        let wanted = match outputs.request.validity() {
            Some(Validity::Drive) => Twist::new(outputs.request.v_mps, outputs.request.w_radps),
            _ => Twist::REST,
        };
        let next = reachable(&robot.description, from, wanted, PERIOD_S);
        self.odometry.pose = self.odometry.pose.then(&next.arc(PERIOD_S));
        (self.odometry.v_mps, self.odometry.w_radps) = (next.v_mps, next.w_radps);
        outputs
    }

    #[track_caller]
    fn check(&mut self, validity: Validity, stale: Option<StaleInput>) -> Outputs {
        let outputs = self.step();
        assert_eq!(outputs.request.validity(), Some(validity));
        assert_eq!(outputs.stale, stale);
        outputs
    }
}

#[test]
fn from_idle_to_the_goal() {
    let mut bench = Bench::new();
    bench.check(Validity::NoPath, None);
    bench.go(5, 6.0);
    assert!(bench.check(Validity::NoPath, None).status_changed);
    bench.path = Some(found(4, 1, &[(1.0, 2.0), (2.0, 2.0)]));
    bench.check(Validity::NoPath, None);
    bench.path = Some(found(5, 2, &[(1.0, 2.0), (6.0, 2.0)]));
    bench.check(Validity::Drive, None);
    let mut causes = Vec::new();
    for _ in 0..600 {
        let request = bench.step().request;
        causes.extend(request.cause());
        causes.dedup();
    }
    bench.check(Validity::AtGoal, None);
    let expected = [
        RequestCause::Free,
        RequestCause::Goal,
        RequestCause::Arrive,
        RequestCause::None,
    ];
    assert_eq!(causes, expected, "what decided, in order");
    let (status, ends) = bench.planner.status();
    assert_eq!(status.state(), Some(TaskState::Reached));
    assert_eq!(ends.len(), 1);
    assert!(
        (bench.odometry.pose.x_m - 5.0).abs() < 0.15,
        "map is 1 m beside odom"
    );
}

/// A successor that knows task, map and pose when it starts: its idle output has run time 0.
#[test]
fn a_successor_does_not_count_the_time_before_its_first_tick_as_stalled() {
    let mut bench = Bench::new();
    bench.go(5, 6.0);
    bench.path = Some(found(5, 2, &[(1.0, 2.0), (6.0, 2.0)]));
    let idle = bench.answer();
    assert_eq!(idle.request.validity(), Some(Validity::NoPath));
    assert_eq!(idle.request.v_mps.to_bits(), 0.0_f64.to_bits());
    assert!(idle.plan_request.is_none());
    // A minute into the run, longer than `stuck_s`.
    bench.tick = 3000;
    bench.check(Validity::Drive, None);
    let state = bench.planner.status().0.state();
    assert_eq!(state, Some(TaskState::Active));
}

#[test]
fn a_robot_that_does_not_know_where_it_is_brakes_and_says_so() {
    let mut bench = Bench::new();
    bench.go(5, 7.0);
    bench.path = Some(found(5, 1, &[(1.0, 2.0), (7.0, 2.0)]));
    for _ in 0..50 {
        bench.step();
    }
    assert!(bench.odometry.v_mps > 0.3);
    bench.certainty = PoseCertainty::Unknown;
    let outputs = bench.check(Validity::Stale, Some(StaleInput::Pose));
    assert_eq!(outputs.request.input(), Some(PlannerInput::Pose));
    for _ in 0..100 {
        bench.step();
    }
    assert!(bench.odometry.v_mps.abs() < 1.0e-9);
    bench.certainty = PoseCertainty::Confirmed;
    for _ in 0..50 {
        bench.step();
    }
    assert!(bench.odometry.v_mps > 0.3, "it goes on");
}

/// Where that is asked for, and until it knows.
#[test]
fn a_robot_that_does_not_know_where_it_is_may_look_around() {
    let mut bench = Bench::new();
    let mut config = LocalPlannerConfig::default();
    config.recovery.seek_pose = true;
    bench.planner = LocalPlanner::new(&config).expect("usable");
    bench.go(5, 7.0);
    bench.path = Some(found(5, 1, &[(1.0, 2.0), (7.0, 2.0)]));
    bench.certainty = PoseCertainty::Unknown;
    let stood = (1..=200).take_while(|_| bench.step().request.validity() == Some(Validity::Stale));
    assert!((140..160).contains(&stood.count()));
    let outputs = bench.check(Validity::Drive, None);
    assert_eq!(outputs.request.cause(), Some(RequestCause::SeekPose));
    for _ in 0..100 {
        bench.step();
    }
    assert!(bench.odometry.w_radps > 0.5 && bench.odometry.v_mps.abs() < 1.0e-9);
    bench.certainty = PoseCertainty::Confirmed;
    let outputs = bench.check(Validity::Drive, None);
    assert_ne!(outputs.request.cause(), Some(RequestCause::SeekPose));
}

#[test]
fn old_inputs_slow_down_and_stop_on_a_ramp() {
    let mut bench = Bench::new();
    bench.go(5, 7.0);
    bench.path = Some(found(5, 1, &[(1.0, 2.0), (7.0, 2.0)]));
    for _ in 0..100 {
        bench.step();
    }
    assert!(bench.odometry.v_mps > 0.75);
    let free = bench.step().request;
    assert_eq!(free.cause(), Some(RequestCause::Free), "{free:?}");
    bench.ages.scan_ns = Some(340 * MS);
    for _ in 0..50 {
        let request = bench.check(Validity::Drive, None).request;
        assert_eq!(request.cause(), Some(RequestCause::Ageing), "{request:?}");
        assert_eq!(request.input(), Some(PlannerInput::Scan));
        assert!(
            request.limit_mps > 0.0 && request.limit_mps < 0.35,
            "{request:?}"
        );
        assert_eq!(request.ages_ms[1], 340);
    }
    assert!(bench.odometry.v_mps < 0.35);
    bench.ages.scan_ns = Some(360 * MS);
    let before = bench.odometry.v_mps;
    let outputs = bench.check(Validity::Stale, Some(StaleInput::Scan));
    assert!(outputs.request.v_mps > before - 0.03, "a ramp, not a jump");
    let told = (outputs.request.cause(), outputs.request.input());
    assert_eq!(told, (Some(RequestCause::Stale), Some(PlannerInput::Scan)));
    bench.ages.scan_ns = Some(20 * MS);
    bench.check(Validity::Drive, None);
    bench.ages.map_ns = None;
    bench.check(Validity::Stale, Some(StaleInput::Map));
}

#[test]
fn a_robot_off_its_path_asks_for_another() {
    let mut bench = Bench::new();
    bench.go(5, 6.0);
    bench.path = Some(found(5, 1, &[(1.0, 2.9), (6.0, 2.9)]));
    let request = bench.step().plan_request.expect("0.9 m off");
    assert_eq!(request.reason(), Some(RequestReason::OffPath));
    assert_eq!(bench.step().plan_request, None, "not in every period");
}

#[test]
fn unusable_configurations_are_refused() {
    let unknown = LocalPlannerConfig {
        controller: "teb".to_owned(),
        ..LocalPlannerConfig::default()
    };
    let error = LocalPlanner::new(&unknown).err();
    assert!(matches!(error, Some(BuildError::Controller(_))));
    let mut config = LocalPlannerConfig::default();
    config.dwa.speeds = 0;
    assert!(matches!(
        LocalPlanner::new(&config).err(),
        Some(BuildError::Config(_))
    ));
}

/// The global planner forgets its plan with the goal, and launch cancels after every end.
#[test]
fn a_task_that_failed_keeps_the_cell_that_blocked_it_until_the_next_one() {
    let mut bench = Bench::new();
    bench.go(1, 6.0);
    let closed = |status: PathStatus, block: PathBlock| Path {
        status: status.code(),
        goal: 1,
        block: block.code(),
        block_m: [4.0, 2.5],
        source: ObstacleSource::StaticMap.code(),
        ..Path::default()
    };
    bench.path = Some((closed(PathStatus::Unreachable, PathBlock::Closed), vec![]));
    for _ in 0..100 {
        bench.step();
    }
    let told = |bench: &Bench| {
        let (status, ends) = bench.planner.status();
        assert_eq!(status.check(ends), Ok(()));
        (
            status.state(),
            status.block(),
            status.block_m,
            status.source(),
        )
    };
    let expected = (
        Some(TaskState::Failed),
        Some(PathBlock::Closed),
        [4.0, 2.5],
        Some(ObstacleSource::StaticMap),
    );
    assert_eq!(told(&bench), expected);
    bench.path = Some((closed(PathStatus::NoGoal, PathBlock::None), vec![]));
    let cancel = Task {
        kind: TaskKind::Cancel.code(),
        ..Task::default()
    };
    bench.planner.accept_task(2, &cancel, &[]);
    for _ in 0..10 {
        bench.step();
    }
    assert_eq!(bench.planner.status().0.task, 2);
    assert_eq!(told(&bench), expected);
    bench.go(3, 6.0);
    bench.step();
    let (state, block, ..) = told(&bench);
    assert_eq!(
        (state, block),
        (Some(TaskState::Active), Some(PathBlock::None))
    );
}

/// A potential field leads to where it holds the robot, in front of a wall that the path goes around.
#[test]
fn controllers_that_do_not_follow_the_path_name_what_keeps_them_from_the_goal() {
    for controller in ["ju_apf", "lwx_apf", "ju_r6", "zm_rep"] {
        let config = LocalPlannerConfig {
            controller: controller.to_owned(),
            ..LocalPlannerConfig::default()
        };
        let mut bench = Bench::new();
        bench.planner = LocalPlanner::new(&config).expect(controller);
        bench.hits = (0..40)
            .map(|n| Point2::new(4.0, 1.2 + 0.04 * f64::from(n)))
            .collect();
        bench.go(1, 6.0);
        bench.path = Some(found(
            1,
            1,
            &[(1.0, 2.0), (1.5, 3.2), (6.0, 3.2), (6.0, 2.0)],
        ));
        let is_over = |bench: &Bench| bench.planner.status().0.state() != Some(TaskState::Active);
        for _ in 0..10_000 {
            bench.step();
            if is_over(&bench) && bench.tick > 1 {
                break;
            }
        }
        let (status, _) = bench.planner.status();
        assert_eq!(status.reason(), Some(EndReason::Stuck), "{controller}");
        assert_eq!(status.block(), Some(PathBlock::Obstacle), "{controller}");
        assert_eq!(status.source(), Some(ObstacleSource::Lidar), "{controller}");
        let [x_m, y_m] = status.block_m;
        assert!(
            (x_m - 4.0).abs() < 0.1 && (y_m - 2.0).abs() < 0.85,
            "{controller}: {x_m} {y_m}"
        );
    }
}

#[test]
fn a_newcomer_goes_on_with_what_was_tried_for_the_task_and_why_it_failed() {
    let mut bench = Bench::new();
    bench.go(1, 6.0);
    bench.path = Some(found(1, 1, &[(1.0, 2.0), (6.0, 2.0)]));
    bench.step();
    let status = |task, state: TaskState| TaskStatus {
        state: state.code(),
        reason: EndReason::None.code(),
        task,
        goal: 1,
        recoveries: 3,
        cause: StuckCause::Blocked.code(),
        block: PathBlock::Obstacle.code(),
        block_m: [4.0, 2.5],
        source: ObstacleSource::Lidar.code(),
        ..TaskStatus::default()
    };
    // Of another task nothing is taken over.
    bench.planner.follow(&status(9, TaskState::Active), &[]);
    assert_eq!(bench.planner.status().0.recoveries, 0);
    bench.planner.follow(&status(1, TaskState::Active), &[]);
    let (own, ends) = bench.planner.status();
    assert_eq!(own.recoveries, 3);
    assert_eq!(own.cause(), Some(StuckCause::Blocked));
    assert_eq!(own.source(), Some(ObstacleSource::Lidar));
    assert_eq!(own.check(ends), Ok(()));
    // The next task begins with nothing.
    bench.go(2, 6.0);
    bench.step();
    bench.step();
    let (own, _) = bench.planner.status();
    assert_eq!((own.task, own.recoveries, own.source), (2, 0, 0));
}
