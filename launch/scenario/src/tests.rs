//! Scenarios as users write them: what is read, and the line that names what is wrong.

mod building;
mod zones;

use super::{Library, Outcome, Scenario, ScenarioError};
use std::path::PathBuf;
use tempfile::TempDir;
use zeronav_msgs::{Pose, Role};

/// Lines count: the tests below name them.
const GOOD: &str = r#"title = "Test"
start = [1.0, 2.0, 0.5]
[world]
area_m = [[0.0, 0.0], [10.0, 5.0]]
[[world.shapes]]
kind = "box"
centre_m = [5.0, 4.0]
size_m = [1.0, 1.0]
[[world.obstacles]]
name = "crate"
shape = { kind = "disc", centre_m = [8.0, 4.0], radius_m = 0.5 }
appears = { at_s = 3 }
[robot]
radius_m = 0.25
v_mps_max = 1.0
w_radps_max = 2.0
a_mps2_max = 1.0
alpha_radps2_max = 4.0
[robot.lidar]
n_beams = 360
rate_hz = 10.0
range_m_min = 0.1
range_m_max = 12.0
[[goals]]
pose = [9.0, 1.0, 0]
"#;

/// A working folder of its own.
struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn write(&self, name: &str, text: &str) -> PathBuf {
        let file = self.0.path().join(name);
        std::fs::create_dir_all(file.parent().unwrap()).unwrap();
        std::fs::write(&file, text).unwrap();
        file
    }

    fn load(&self, name: &str) -> Result<Scenario, ScenarioError> {
        Scenario::load_from(&Library::of(self.0.path()), name)
    }
}

fn load(text: &str) -> Result<Scenario, ScenarioError> {
    let folder = Folder::new();
    folder.write("test.toml", text);
    folder.load("test.toml")
}

/// Replaces `from` in the good scenario and expects an error at `line` about `field`.
#[track_caller]
fn refused(from: &str, to: &str, line: usize, field: &str, why: &str) {
    assert!(GOOD.contains(from), "{from:?} is not in the scenario");
    let folder = Folder::new();
    let file = folder.write("test.toml", &GOOD.replacen(from, to, 1));
    let error = folder
        .load("test.toml")
        .and_then(|scenario| scenario.validate())
        .expect_err(to)
        .to_string();
    let place = format!("scenario {}:{line}: {field}: ", file.display());
    assert!(error.starts_with(&place), "{error}\ninstead of {place}");
    assert!(error.contains(why), "{error:?} without {why:?}");
    assert!(!error.contains('\n'), "{error:?} has several lines");
}

#[test]
fn what_is_not_said_has_a_default() {
    let scenario = load(GOOD).unwrap();
    assert_eq!(scenario.name, "test");
    assert_eq!(scenario.start, Pose::new(1.0, 2.0, 0.5));
    assert!((scenario.run.time_limit_s - 120.0).abs() < 1e-12);
    assert!((scenario.run.tick_hz - 50.0).abs() < 1e-12);
    assert_eq!(scenario.run.seed, 1);
    assert!(scenario.static_map);
    let goal = scenario.goals[0].message(7);
    assert_eq!((goal.pose, goal.id), (Pose::new(9.0, 1.0, 0.0), 7));
    assert!((goal.tolerance_m - 0.25).abs() < 1e-12);
    assert!((goal.yaw_tolerance_rad - core::f64::consts::PI).abs() < 1e-12);
    assert_eq!(scenario.expect.outcome, Outcome::Reached);
    assert_eq!(scenario.expect.contacts_max, 0);
    assert_eq!(scenario.expect.obstacle_replans_max, None);
    for role in Role::SERVICES {
        let service = scenario.services.of(role).unwrap();
        assert!(service.binary.is_none() && service.config.is_empty());
    }
    let checked = scenario.validate().unwrap();
    assert_eq!(checked.world.shapes().len(), 1);
    assert!(checked.warnings.is_empty());
}

#[test]
fn services_carry_any_configuration() {
    let text = format!(
        "{GOOD}[services.global_planner]\nconfig.planner = \"c_astar\"\nconfig.weight = 2\n\
         [services.mapping]\nbinary = \"my-mapping\"\n"
    );
    let scenario = load(&text).unwrap();
    let config = &scenario.services.of(Role::GlobalPlanner).unwrap().config;
    assert_eq!(config["planner"].as_str(), Some("c_astar"));
    assert_eq!(config["weight"].as_integer(), Some(2));
    let binary = scenario.services.of(Role::Mapping).unwrap().binary.clone();
    assert_eq!(binary, Some("my-mapping".into()));
    assert!(scenario.services.of(Role::Launch).is_none());
}

#[test]
fn errors_of_reading_name_line_and_field() {
    refused("title =", "titel =", 1, "titel", "unknown field");
    refused("title = \"Test\"\n", "", 1, "title", "is missing");
    refused(
        "v_mps_max = 1.0",
        "v_max = 1.0",
        15,
        "robot.v_max",
        "unknown",
    );
    refused("v_mps_max = 1.0\n", "", 13, "robot.v_mps_max", "is missing");
    refused(
        "v_mps_max = 1.0",
        "v_mps_max = \"x\"",
        15,
        "robot.v_mps_max",
        "string",
    );
    refused(
        "n_beams = 360",
        "n_beams = -1",
        20,
        "robot.lidar.n_beams",
        "-1",
    );
    refused("[1.0, 2.0, 0.5]", "[1.0, 2.0]", 2, "start", "length");
    refused("area_m", "arena_m", 4, "world.arena_m", "unknown field");
    refused("\"box\"", "\"bax\"", 6, "world.shapes[0].kind", "bax");
    refused(
        "radius_m = 0.5 }",
        "radius = 0.5 }",
        11,
        "world.obstacles[0].shape",
        "radius",
    );
    refused(
        "at_s = 3",
        "at = 3",
        12,
        "world.obstacles[0].appears.at",
        "unknown",
    );
    refused(
        "[[goals]]",
        "[[goals]]\ntolerance = 1",
        25,
        "goals[0].tolerance",
        "unknown",
    );
    refused(
        "[robot]",
        "[services.wheels]\n[robot]",
        13,
        "services.wheels",
        "unknown",
    );
    refused(
        "[robot]",
        "[expect]\noutcome = \"won\"\n[robot]",
        14,
        "expect.outcome",
        "won",
    );
    let broken = load("title = \"x\"\nstart = [1,\n[world]\n").unwrap_err();
    assert!(matches!(broken, ScenarioError::Syntax { .. }), "{broken}");
    assert!(broken.to_string().contains("test.toml:"), "{broken}");
}

// long: one table of wrong values and what is said of each
#[test]
fn errors_of_meaning_name_line_and_field() {
    refused("\"Test\"", "\" \"", 1, "title", "empty");
    refused(
        "v_mps_max = 1.0",
        "v_mps_max = -1",
        15,
        "robot.v_mps_max",
        "-1",
    );
    refused("radius_m = 0.25\n", "", 13, "robot.radius_m", "footprint_m");
    refused("= 360", "= 5000", 20, "robot.lidar.n_beams", "2 to 4096");
    refused(
        "rate_hz = 10.0",
        "rate_hz = 60.0",
        1,
        "run.tick_hz",
        "60 scans",
    );
    let run = "[run]\ntick_hz = 5\n[robot]";
    refused("[robot]", run, 14, "run.tick_hz", "lidar's 10 scans");
    refused(
        "[robot]",
        "[run]\ntick_hz = 2e3\n[robot]",
        14,
        "run.tick_hz",
        "1000",
    );
    refused(
        "[robot]",
        "[run]\ntime_limit_s = nan\n[robot]",
        14,
        "run.time_limit_s",
        "NaN",
    );
    refused(
        "size_m = [1.0, 1.0]",
        "size_m = [1.0, 0]",
        8,
        "world.shapes[0].size_m[1]",
        "0",
    );
    refused(
        "radius_m = 0.5",
        "radius_m = inf",
        11,
        "world.obstacles[0].shape.radius_m",
        "inf",
    );
    refused(
        "{ at_s = 3 }",
        "{}",
        12,
        "world.obstacles[0].appears",
        "exactly one",
    );
    refused(
        "at_s = 3",
        "at_s = -3",
        12,
        "world.obstacles[0].appears.at_s",
        "-3",
    );
    refused(
        "[10.0, 5.0]]",
        "[1000.0, 5.0]]",
        4,
        "world.area_m",
        "8192 cells",
    );
    refused(
        "[10.0, 5.0]]",
        "[300.0, 300.0]]",
        4,
        "world.area_m",
        "tiles",
    );
    refused(
        "area_m = [[0.0, 0.0], [10.0, 5.0]]\n",
        "",
        3,
        "world.area_m",
        "missing",
    );
    let absent = "[world]\nmap = \"absent.yaml\"\nresolution_m = 1.0 #";
    let why = "absent.yaml";
    refused("[world]\narea_m =", absent, 4, "world.map", why);
    let twice = "[[world.obstacles]]\nname = \"crate\"\n\
                 shape = { kind = \"disc\", centre_m = [8.0, 4.0], radius_m = 0.5 }\n[robot]";
    refused(
        "[robot]",
        twice,
        14,
        "world.obstacles[1].name",
        "obstacles[0]",
    );
}

#[test]
fn robots_and_lidars_start_from_presets() {
    let from = GOOD.find("[robot]").unwrap();
    let until = GOOD.find("[[goals]]").unwrap();
    let with = |robot: &str| format!("{}{robot}\n{}", &GOOD[..from], &GOOD[until..]);
    let text = with("[robot]\npreset = \"turtlebot3_burger\"\nv_mps_max = 0.2");
    let burger = load(&text).unwrap().robot;
    assert!((burger.v_mps_max - 0.2).abs() < 1e-12);
    assert_eq!((burger.radius_m, burger.lidar.n_beams), (Some(0.105), 360));
    let text = with("[robot]\npreset = \"jackal\"\n[robot.lidar]\npreset = \"utm_30lx\"");
    let jackal = load(&text).unwrap().robot;
    assert!((jackal.lidar.range_m_max - 30.0).abs() < 1e-12);
    for name in ["turtlebot2", "turtlebot3_burger", "jackal"] {
        let text = GOOD.replacen("title", &format!("base = [\"{name}\"]\ntitle"), 1);
        assert!((load(&text).unwrap().robot.v_mps_max - 1.0).abs() < 1e-12);
        let from = text.find("[robot]").unwrap();
        let bare = format!("{}{}", &text[..from], &GOOD[until..]);
        assert!(load(&bare).unwrap().robot.odometry.is_some(), "{name}");
    }
    refused(
        "[robot]",
        "[robot]\npreset = \"roomba\"",
        14,
        "robot.preset",
        "roomba",
    );
    refused(
        "n_beams = 360",
        "dropout_ratio = 2\nn_beams = 360",
        20,
        "robot.lidar.dropout_ratio",
        "2",
    );
    refused(
        "radius_m = 0.25",
        "radius_m = 0.25\nslip.turn_ratio = 1",
        15,
        "robot.slip.turn_ratio",
        "0.9",
    );
}

#[test]
fn worlds_of_data_sets_are_named_by_their_files() {
    let folder = Folder::new();
    let barn = folder.write("data/world.csv", "x_m,y_m,r_m\n-2.25,6.0,0.075\n");
    let text = GOOD
        .replacen("[world]", "[world]\nbarn = \"data/world.csv\"", 1)
        .replacen("area_m = [[0.0, 0.0], [10.0, 5.0]]\n", "", 1)
        .replacen("[9.0, 1.0, 0]", "[-2.25, 9.0, 0]", 1)
        .replacen("[1.0, 2.0, 0.5]", "[-2.25, 3.0, 0]", 1);
    folder.write("test.toml", &text);
    let scenario = folder.load("test.toml").unwrap();
    assert_eq!(scenario.world.barn.as_deref(), Some(barn.as_path()));
    assert_eq!(scenario.validate().unwrap().world.shapes().len(), 2);
    folder.write("data/world.csv", "x_m,y_m,r_m\n-2.25,6.0,x\n");
    let error = scenario.validate().unwrap_err().to_string();
    assert!(error.contains("test.toml:4: world.barn: "), "{error}");
    assert!(error.contains("world.csv:2: "), "{error}");
    let absent = "[world]\npedestrians = { file = \"absent.csv\" }";
    refused("[world]", absent, 4, "world.pedestrians.file", "absent.csv");
    refused(
        "[world]",
        "[world]\ngenerated = { family = { kind = \"iid\" }, size_cells = [1, 5] }",
        4,
        "world.generated.size_cells[0]",
        "2 to",
    );
}

#[test]
fn starts_and_goals_must_have_room() {
    refused(
        "[1.0, 2.0, 0.5]",
        "[5.0, 3.3, 0]",
        2,
        "start",
        "world.shapes[0]: move start",
    );
    refused(
        "[1.0, 2.0, 0.5]",
        "[-1.0, 2.0, 0]",
        2,
        "start",
        "beside the map",
    );
    refused("[1.0, 2.0, 0.5]", "[1.0, nan, 0]", 2, "start[1]", "NaN");
    refused(
        "[9.0, 1.0, 0]",
        "[5.0, 4.0, 0]",
        25,
        "goals[0].pose",
        "no room within 0.25 m",
    );
    refused(
        "[9.0, 1.0, 0]",
        "[9.0, 9.0, 0]",
        25,
        "goals[0].pose",
        "beside the map",
    );
    refused(
        "pose = [9.0, 1.0, 0]",
        "pose = [9.0, 1.0, 0]\ntolerance_m = 0",
        26,
        "goals[0].tolerance_m",
        "0.001",
    );
    // With a tolerance that reaches out of the shape there is room.
    let wide = GOOD.replace("[9.0, 1.0, 0]", "[5.0, 4.0, 0]\ntolerance_m = 1.0");
    load(&wide).unwrap().validate().unwrap();
}

#[test]
fn an_obstacle_at_the_start_counts_only_when_it_is_there_from_the_start() {
    let later = GOOD.replace("[1.0, 2.0, 0.5]", "[8.0, 3.5, 0]");
    load(&later).unwrap().validate().unwrap();
    let at_once = later.replace("at_s = 3", "at_s = 0");
    let error = load(&at_once).unwrap().validate().unwrap_err();
    assert!(
        error.to_string().contains("test.toml:2: start: "),
        "{error}"
    );
    assert!(error.to_string().contains("\"crate\""), "{error}");
}

#[test]
fn what_is_called_unreachable_may_lie_in_a_wall() {
    let goal = GOOD.replace("[9.0, 1.0, 0]", "[5.0, 4.0, 0]");
    let text = format!("{goal}[expect]\noutcome = \"unreachable\"\n");
    load(&text).unwrap().validate().unwrap();
    let (without_goals, _) = GOOD.split_once("[[goals]]").unwrap();
    load(without_goals).unwrap().validate().unwrap();
    let text = format!("{without_goals}[expect]\noutcome = \"unreachable\"\n");
    let error = load(&text).unwrap().validate().unwrap_err();
    assert!(
        error.to_string().contains(":25: expect.outcome: "),
        "{error}"
    );
    let text = format!("{GOOD}[expect]\nobstacle_replans_min = 2\nobstacle_replans_max = 1\n");
    let error = load(&text).unwrap().validate().unwrap_err();
    let place = ":27: expect.obstacle_replans_min: 2 is above";
    assert!(error.to_string().contains(place), "{error}");
}

#[test]
fn faults_and_expectations_are_checked() {
    let with = |more: &str| load(&format!("{GOOD}{more}")).and_then(|own| own.validate());
    for (more, field) in [
        (
            "[[kills]]\nservice = \"mapping\"\nat_s = 1.0\n",
            "kills: is gone: write [[faults]]",
        ),
        (
            "[[faults]]\nkind = \"kill\"\nservice = \"robot\"\nbegins = { at_s = 1.0 }\n",
            "faults[0].service: the robot is not restarted",
        ),
        (
            "[[faults]]\nkind = \"kill\"\nservice = \"mapping\"\n",
            "faults[0].begins: is missing",
        ),
        (
            "[[faults]]\nkind = \"stop\"\nservice = \"mapping\"\nbegins = {}\n",
            "faults[0].begins: give exactly one",
        ),
        (
            "[[faults]]\nkind = \"slow\"\nservice = \"mapping\"\nby_ms = 300.0\n\
             begins = { at_s = 1.0 }\n",
            "faults[0].by_ms: 300 ms would be taken for a hang",
        ),
        (
            "[[faults]]\nkind = \"drop\"\ntopic = \"run/clock\"\nshare = 0.5\nbegins = { at_s = 1.0 }\n",
            "faults[0].topic: ",
        ),
        (
            "[[faults]]\nkind = \"corrupt\"\ntopic = \"plan/path\"\nshare = 0.0\nbegins = { at_s = 1.0 }\n",
            "faults[0].share: ",
        ),
        (
            "[[faults]]\nkind = \"clock\"\nservice = \"robot\"\nby_ms = 1.0\nbegins = { at_s = 1.0 }\n",
            "faults[0].service: the robot is not restarted",
        ),
        (
            "[random_faults]\ncount = 3\nfrom_s = 5.0\nuntil_s = 4.0\n",
            "random_faults.until_s: ",
        ),
        (
            "[random_faults]\ncount = 3\nuntil_s = 4.0\nkinds = [\"kil\"]\n",
            "random_faults.kinds[0]: ",
        ),
        (
            "[expect]\ninterventions_min = { tired = 1 }\n",
            "expect.interventions_min.tired: ",
        ),
        (
            "[expect]\ninterventions_min = { none = 1 }\n",
            "expect.interventions_min.none: ",
        ),
        ("[expect]\ndriven_m_min = nan\n", "expect.driven_m_min: "),
        (
            "[expect]\ngoal_distance_m_max = -1.0\n",
            "expect.goal_distance_m_max: ",
        ),
    ] {
        let error = with(more).unwrap_err().to_string();
        assert!(error.contains(field), "{error}, not {field}");
    }
    let good = "[[faults]]\nkind = \"kill\"\nservice = \"mapping\"\nbegins = { at_s = 1.0 }\n\
                [expect]\noutcome = \"timeout\"\ninterventions_min = { stopped_short = 1 }\n";
    with(good).unwrap();
}
