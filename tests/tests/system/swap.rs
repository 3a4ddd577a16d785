//! Other binaries in the seats: minimal ones that keep the contract, and ones that break it.

use rustix::process::Signal;
use serde_json::Value;
use std::path::{Path, PathBuf};
use zeronav_msgs::command::{Intervention, Validity, VelocityCommand};
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::{
    ControlRequest, GroundTruth, HealthTopic, RobotCommand, RobotDescription, Topic, health_of,
};
use zeronav_msgs::truth::Truth;
use zeronav_shell::roster_reader::RosterReader;
use zeronav_shell::{Domain, Latest, Peer, Stream};
use zeronav_tests::{Ended, Zeronav, is_alive, leftovers, real_time_turn, send_signal, zeronav};

/// Through a door into the other room: around two corners and past a screen.
const TWO_ROOMS: &str = r#"
base = ["two_rooms", "porter"]
start = [1.5, 4.5, 0.0]
run.time_limit_s = 120.0
[[goals]]
pose = [12.0, 4.5, 0.0]
"#;

/// Eight metres down an aisle.
const AISLE: &str = r#"
base = ["warehouse", "porter"]
start = [4.0, 6.425, 0.0]
run.time_limit_s = 60.0
[[goals]]
pose = [12.5, 6.425, 0.0]
"#;

/// A folder with a scenario in which others sit in these seats.
fn scenario(rest: &str, seats: &[(&str, &str)]) -> tempfile::TempDir {
    let seats: Vec<String> = seats
        .iter()
        .map(|(seat, binary)| format!("[services.{seat}]\nbinary = \"{binary}\"\n"))
        .collect();
    let seats = seats.concat();
    let text = format!("title = \"other binaries in the seats\"\n{rest}{seats}");
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
    folder
}

/// How a run keeps time.
const REAL_TIME: [&str; 4] = ["run", "./it.toml", "--headless", "--json"];
const LOCKSTEP: [&str; 5] = ["run", "./it.toml", "--lockstep", "--headless", "--json"];

fn start(mode: &[&str], rest: &str, seats: &[(&str, &str)]) -> Zeronav {
    Zeronav::start_in(scenario(rest, seats), mode)
}

fn lockstep(rest: &str, seats: &[(&str, &str)]) -> Ended {
    start(&LOCKSTEP, rest, seats).finish()
}

/// What the result says of a seat's process.
fn service<'a>(result: &'a Value, seat: &str) -> &'a Value {
    let services = result["services"].as_array().expect("services");
    let found = services.iter().find(|service| service["name"] == seat);
    found.unwrap_or_else(|| panic!("no {seat}: {result:#}"))
}

/// Everything that must hold after a drive that arrived with these binaries in these seats.
fn arrived(ended: &Ended, seats: &[(&str, &str)]) -> Value {
    let result = ended.expect(0);
    assert_eq!(result["verdict"], "pass", "{result:#}");
    assert_eq!(result["reached"], true, "{result:#}");
    assert_eq!(result["contacts"], 0, "{result:#}");
    for (seat, binary) in seats {
        assert_eq!(service(&result, seat)["binary"], *binary);
    }
    result
}

fn metres(result: &Value, key: &str) -> f64 {
    result[key].as_f64().expect("metres")
}

#[test]
fn straight_line_service_takes_the_planners_seat() {
    let arguments = ["run", "swap_planner", "--lockstep", "--headless", "--json"];
    let ended = zeronav(&arguments);
    let result = arrived(&ended, &[("global_planner", "straight_line_service")]);
    let plans = result["plans"].as_array().expect("plans");
    assert!(!plans.is_empty(), "{result:#}");
    for plan in plans {
        assert_eq!(plan["planner"], "straight_line", "{plan:#}");
        assert_eq!(plan["points_m"].as_array().map(Vec::len), Some(2));
    }
    assert_eq!(service(&result, "global_planner")["key"], "straight_line");
    for stock in ["c_astar", "mpgaa"] {
        assert!(!ended.stdout.contains(stock), "{result:#}");
    }
}

#[test]
fn a_straight_line_through_the_racks_is_a_dead_end() {
    let seats = [("global_planner", "straight_line_service")];
    let behind_the_racks = AISLE.replace("[12.5, 6.425, 0.0]", "[12.5, 13.575, 0.0]");
    let result = lockstep(&behind_the_racks, &seats).expect(1);
    assert_eq!(result["outcome"], "no_path", "{result:#}");
    assert_eq!(result["contacts"], 0, "{result:#}");
    assert!(metres(&result, "driven_m") < 0.01, "{result:#}");
    let plans = result["plans"].as_array().expect("plans");
    assert_eq!(
        plans.len(),
        1,
        "a failure that continues is not reported again: {plans:#?}"
    );
    assert_eq!(plans[0]["status"], "dead_end");
}

#[test]
fn minimal_mapping_drives_two_rooms() {
    let seats = [("mapping", "minimal_mapping")];
    arrived(&lockstep(TWO_ROOMS, &seats), &seats);
}

#[test]
fn minimal_mapping_without_a_static_map_shows_the_scan() {
    let seats = [("mapping", "minimal_mapping")];
    // A wall that no map shows crosses the straight line.
    let unmapped = r#"
base = "porter"
start = [1.0, 3.0, 0.0]
static_map = false
[world]
area_m = [[0.0, 0.0], [8.0, 6.0]]
resolution_m = 0.05
shapes = [{ kind = "box", centre_m = [4.0, 2.5], size_m = [0.2, 2.0] }]
[[goals]]
pose = [7.0, 3.0, 0.0]
[expect]
obstacle_replans_min = 0
"#;
    let result = arrived(&lockstep(unmapped, &seats), &seats);
    assert!(
        metres(&result, "driven_m") > 6.2,
        "it drove through the wall: {result:#}"
    );
}

#[test]
fn minimal_local_planner_drives_two_rooms() {
    let seats = [("local_planner", "minimal_local_planner")];
    arrived(&lockstep(TWO_ROOMS, &seats), &seats);
}

#[test]
fn minimal_local_planner_stops_for_a_dropped_obstacle() {
    let seats = [("local_planner", "minimal_local_planner")];
    let blocked = format!(
        r#"{AISLE}
[[world.obstacles]]
name = "load"
shape = {{ kind = "box", centre_m = [9.0, 6.425], size_m = [0.8, 2.05] }}
appears = {{ robot_near = {{ point_m = [7.5, 6.425], distance_m = 0.5 }} }}
"#
    );
    // The aisle is shut; the way around leads through the north aisle and back.
    let result = arrived(&lockstep(&blocked.replace("60.0", "240.0"), &seats), &seats);
    assert!(metres(&result, "driven_m") > 40.0, "{result:#}");
}

#[test]
fn minimal_guard_drives_two_rooms() {
    let seats = [("collision_guard", "minimal_guard")];
    arrived(&lockstep(TWO_ROOMS, &seats), &seats);
}

#[test]
fn minimal_robot_is_driven() {
    let seats = [("robot", "minimal_robot")];
    let result = arrived(&lockstep(TWO_ROOMS, &seats), &seats);
    // Its world is empty, but the map is not: the stack drives around the screen.
    assert!(metres(&result, "driven_m") > 11.0, "{result:#}");
}

const ALL_MINIMAL: [(&str, &str); 5] = [
    ("robot", "minimal_robot"),
    ("mapping", "minimal_mapping"),
    ("global_planner", "straight_line_service"),
    ("local_planner", "minimal_local_planner"),
    ("collision_guard", "minimal_guard"),
];

#[test]
fn minimal_stack_drives_without_stock_services_and_repeats() {
    let first = arrived(&lockstep(AISLE, &ALL_MINIMAL), &ALL_MINIMAL);
    let second = arrived(&lockstep(AISLE, &ALL_MINIMAL), &ALL_MINIMAL);
    assert!(first["run_hash"].is_string(), "{first:#}");
    assert_eq!(first["run_hash"], second["run_hash"]);
}

#[test]
fn minimal_stack_drives_in_real_time() {
    let _turn = real_time_turn();
    let result = arrived(
        &start(&REAL_TIME, AISLE, &ALL_MINIMAL).finish(),
        &ALL_MINIMAL,
    );
    let latency = &result["latency"];
    assert!(
        latency["reaction"]["n"].as_u64().expect("a number") > 20,
        "{latency:#}"
    );
}

#[test]
fn killed_minimal_services_restart() {
    for (seat, _) in &ALL_MINIMAL[1..] {
        let mut run = start(&LOCKSTEP, AISLE, &ALL_MINIMAL);
        run.wait_until("the robot is on its way", |run| {
            let report = run.report().unwrap_or_default();
            let services = report["services"].as_array().cloned().unwrap_or_default();
            let victim = services.iter().find(|service| service["role"] == *seat);
            let pid = victim.and_then(|service| u32::try_from(service["pid"].as_u64()?).ok());
            let on_its_way = report["time_s"].as_f64().is_some_and(|time_s| time_s > 0.5);
            on_its_way && pid.is_some_and(|pid| send_signal(pid, Signal::KILL))
        });
        let result = arrived(&run.finish(), &ALL_MINIMAL);
        let restarts = result["restarts"].as_array().expect("restarts");
        assert_eq!(restarts.len(), 1, "{restarts:#?}");
        assert_eq!(restarts[0]["service"], *seat);
    }
}

/// The same with a budget of one restart per service.
fn one_restart(rest: &str) -> String {
    rest.replace("run.time", "restart.per_service = 1\nrun.time")
}

#[test]
fn a_service_that_crashes_at_start_ends_the_run_by_name() {
    let ended = lockstep(&one_restart(AISLE), &[("mapping", "crashes_at_start")]);
    let result = ended.expect(3);
    assert!(ended.stderr.contains("mapping ended"), "{}", ended.stderr);
    // The end of its log says what it said.
    assert!(ended.stderr.contains("could not start"), "{}", ended.stderr);
    assert_eq!(result["outcome"], "service_died");
    assert_eq!(service(&result, "mapping")["binary"], "crashes_at_start");
    assert_eq!(result["contacts"], 0);
}

#[test]
fn a_service_that_hangs_whenever_it_is_started_ends_the_run_by_name() {
    let seats = [("global_planner", "hangs_after_start")];
    let ended = lockstep(&one_restart(AISLE), &seats);
    let result = ended.expect(3);
    assert!(
        ended.stderr.contains("global_planner ended"),
        "{}",
        ended.stderr
    );
    assert!(ended.stderr.contains("no progress"), "{}", ended.stderr);
    assert_eq!(service(&result, "global_planner")["starts"], 2);
    assert_eq!(result["contacts"], 0);
    assert!(
        metres(&result, "driven_m") < 0.01,
        "no goal was sent: {result:#}"
    );
}

#[test]
fn a_service_that_stays_silent_is_not_ready_by_name() {
    let mut run = start(&LOCKSTEP, AISLE, &[("global_planner", "stays_silent")]);
    let (root, children) = running(&mut run);
    let ended = run.finish();
    let result = ended.expect(3);
    assert!(ended.stderr.contains("global_planner"), "{}", ended.stderr);
    for other in ["robot", "mapping", "local_planner", "collision_guard"] {
        let named = format!("not ready in time: {other}");
        assert!(!ended.stderr.contains(&named), "{}", ended.stderr);
    }
    assert_eq!(result["outcome"], "not_ready");
    assert_eq!(result["contacts"], 0);
    nothing_is_left(&root, &children);
}

#[test]
fn a_service_that_writes_another_type_is_refused_by_topic() {
    let ended = lockstep(AISLE, &[("local_planner", "writes_wrong_type")]);
    let result = ended.expect(3);
    for word in ["local_planner", ControlRequest::ROW.name, "type"] {
        assert!(
            ended.stderr.contains(word),
            "`{word}` is not named:\n{}",
            ended.stderr
        );
    }
    assert_eq!(result["outcome"], "service_died");
    assert_eq!(service(&result, "local_planner")["end"], "exit code 3");
}

/// The domain of a run whose five services are there, and their process ids.
fn running(run: &mut Zeronav) -> (PathBuf, Vec<u32>) {
    run.wait_until("every service runs", |run| run.children().len() == 5);
    run.wait_until("every service knows its domain", |run| {
        run.domains().len() == 1
    });
    let children = run.children().into_iter().map(|(pid, _)| pid).collect();
    (run.domains().pop().expect("a domain"), children)
}

#[track_caller]
fn nothing_is_left(root: &Path, children: &[u32]) {
    assert_eq!(leftovers(root), Vec::<PathBuf>::new());
    assert!(
        !children.iter().any(|pid| is_alive(*pid)),
        "a process is left"
    );
}

/// A guest that reads what a run does.
struct Tap {
    roster: RosterReader,
    description: Latest<RobotDescription>,
    request: Latest<ControlRequest>,
    command: Stream<RobotCommand>,
    truth: Stream<GroundTruth>,
    guard: Latest<HealthTopic>,
    commands: Vec<VelocityCommand>,
    truths: Vec<Truth>,
}

impl Tap {
    fn on(root: &Path) -> Self {
        let domain = Domain::join(root).expect("the domain is there");
        let peer = Peer::join(domain, Role::Tap, 1).expect("guests are welcome");
        let guard = health_of(Role::CollisionGuard).expect("its heartbeat");
        Self {
            roster: RosterReader::open(&peer).expect("the roster"),
            description: peer.latest().expect("the description"),
            request: peer.latest().expect("the requests"),
            command: peer.stream().expect("the commands"),
            truth: peer.stream().expect("the truth"),
            guard: peer.latest_on(guard).expect("the guard's heartbeat"),
            commands: Vec::new(),
            truths: Vec::new(),
        }
    }

    fn listen(&mut self) {
        self.roster.poll();
        let roster = self.roster.roster();
        self.description.poll(roster);
        self.request.poll(roster);
        self.guard.poll(roster);
        self.command
            .drain(roster, |view| self.commands.push(*view.meta));
        self.truth
            .drain(roster, |view| self.truths.push(*view.meta));
    }
}

#[test]
fn nan_requests_never_reach_the_wheels() {
    let _turn = real_time_turn();
    let mut run = start(&REAL_TIME, AISLE, &[("local_planner", "requests_nan")]);
    let (root, children) = running(&mut run);
    let mut tap = Tap::on(&root);
    run.wait_until("the guard has rejected a hundred requests", |_| {
        tap.listen();
        let refused = tap.guard.get().map_or(0, |health| health.meta.refused);
        refused >= 100 && tap.truths.len() >= 20
    });
    assert!(tap.commands.len() > 50, "the guard answers all the same");
    for command in &tap.commands {
        assert!(
            command.v_mps.abs() + command.w_radps.abs() < 1.0e-12,
            "{command:?}"
        );
        assert_ne!(command.validity(), Some(Validity::Drive), "{command:?}");
    }
    for truth in &tap.truths {
        assert!(
            truth.driven_m < 1.0e-9 && truth.w_radps.abs() < 1.0e-9,
            "{truth:?}"
        );
    }
    drop(tap);
    run.signal(Signal::INT);
    let ended = run.finish();
    let result = ended.expect(130);
    assert_eq!(result["contacts"], 0, "{result:#}");
    nothing_is_left(&root, &children);
}

#[test]
fn flooded_requests_keep_the_robot_within_its_limits() {
    let _turn = real_time_turn();
    let mut run = start(&REAL_TIME, AISLE, &[("local_planner", "floods_requests")]);
    let (root, children) = running(&mut run);
    let mut tap = Tap::on(&root);
    run.wait_until("ten thousand requests have come in", |_| {
        tap.listen();
        let clamped =
            |command: &VelocityCommand| command.intervention() == Some(Intervention::Clamped);
        let turned = tap.truths.iter().any(|truth| truth.w_radps.abs() > 0.1);
        let flooded = tap.request.id().count() >= 10_000 && tap.truths.len() >= 20;
        flooded && turned && tap.commands.iter().any(clamped)
    });
    let robot = *tap.description.get().expect("the robot").meta;
    for command in &tap.commands {
        let (v_mps, w_radps) = (command.v_mps, command.w_radps.abs());
        assert!(
            (robot.v_mps_min..=robot.v_mps_max).contains(&v_mps),
            "{command:?}"
        );
        assert!(w_radps <= robot.w_radps_max, "{command:?}");
    }
    for truth in &tap.truths {
        assert!(
            truth.w_radps.abs() <= robot.w_radps_max + 1.0e-9,
            "{truth:?}"
        );
        assert!(
            truth.driven_m < 1.0e-9,
            "it was asked to turn, not to drive: {truth:?}"
        );
    }
    drop(tap);
    run.signal(Signal::INT);
    let ended = run.finish();
    let result = ended.expect(130);
    assert_eq!(result["contacts"], 0, "{result:#}");
    nothing_is_left(&root, &children);
}

#[test]
fn a_service_that_ignores_sigterm_is_killed_and_nothing_is_left() {
    let _turn = real_time_turn();
    let short = AISLE.replace("60.0", "1.0");
    let mut run = start(&REAL_TIME, &short, &[("local_planner", "ignores_sigterm")]);
    let (root, children) = running(&mut run);
    let ended = run.finish();
    let result = ended.expect(1);
    assert_eq!(result["outcome"], "timeout", "{result:#}");
    assert_eq!(result["contacts"], 0, "{result:#}");
    let end = service(&result, "local_planner")["end"]
        .as_str()
        .expect("an end");
    assert!(end.contains("killed"), "{end}");
    for other in ["robot", "mapping", "global_planner", "collision_guard"] {
        assert_eq!(service(&result, other)["end"], "stopped", "{other}");
    }
    nothing_is_left(&root, &children);
}
