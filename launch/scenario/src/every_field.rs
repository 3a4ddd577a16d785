//! Every field that a scenario can have: a number that cannot be and a misspelt name are found in
//! each of them. The fields are those of the shipped scenarios and of the ones below; that none is
//! left out is seen from what the deserialiser expects.

use super::{Library, Scenario};
use std::collections::{BTreeMap, BTreeSet};
use tempfile::TempDir;
use toml::{Table, Value};
use zeronav_msgs::Role;

/// Fields that no shipped scenario has.
pub(super) const OTHERS: [&str; 6] = [
    r#"
title = "All that is optional"
description = "d"
group = "g"
start = [1.0, 2.0, 0.5]
static_map = true
[run]
time_limit_s = 10.0
tick_hz = 50.0
seed = 1
[world]
area_m = [[0.0, 0.0], [10.0, 5.0]]
resolution_m = 0.05
[[world.shapes]]
kind = "box"
centre_m = [5.0, 4.0]
size_m = [1.0, 1.0]
yaw_rad = 0.1
[[world.shapes]]
kind = "polygon"
corners_m = [[8.0, 1.0], [9.0, 1.0], [8.5, 1.5]]
[[world.obstacles]]
name = "walks"
shape = { kind = "disc", centre_m = [8.0, 4.0], radius_m = 0.3 }
appears = { at_s = 3.0 }
lasts_s = 5.0
waypoints_m = [[8.0, 3.0]]
speed_mps = 1.0
repeat = true
starts = { robot_near = { point_m = [5.0, 2.0], distance_m = 1.0 } }
[[world.obstacles]]
name = "bounces"
shape = { kind = "disc", centre_m = [8.0, 2.5], radius_m = 0.1 }
bounces_mps = [0.5, 0.5]
starts = { at_s = 1.0 }
[[world.obstacles]]
name = "was recorded"
shape = { kind = "disc", centre_m = [3.0, 4.0], radius_m = 0.1 }
track = [[0.0, 3.0, 4.0], [1.0, 3.5, 4.0]]
track_from_s = 0.0
[robot]
preset = "jackal"
radius_m = 0.25
v_mps_max = 1.0
v_mps_min = -0.5
w_radps_max = 2.0
a_mps2_max = 1.0
brake_mps2 = 1.0
alpha_radps2_max = 4.0
command_timeout_s = 0.2
actuation_delay_s = 0.1
[robot.slip]
forward_ratio = 0.1
turn_ratio = 0.1
sigma_ratio = 0.1
[robot.odometry]
distance_per_distance = 0.01
distance_per_turn = 0.01
turn_per_turn = 0.01
turn_per_distance = 0.01
gyro = true
[robot.lidar]
preset = "utm_30lx"
pose = [0.1, 0.0, 0.0]
n_beams = 360
fov_rad = 4.0
rate_hz = 10.0
range_m_min = 0.1
range_m_max = 12.0
motion_distortion = true
sigma_m = 0.01
sigma_ratio = 0.01
quantum_m = 0.01
dropout_ratio = 0.01
dropout_as = "no_return"
short_ratio = 0.01
short_mean_m = 1.0
edge_ratio = 0.1
[[robot.faults]]
kind = "lidar_blackout"
begins = { at_s = 1.0 }
lasts_s = 1.0
looks = "silent"
[[robot.faults]]
kind = "lidar_frozen"
begins = { driven_m = 1.0 }
lasts_s = 1.0
[[robot.faults]]
kind = "lidar_turned"
begins = { at_s = 1.0 }
lasts_s = 1.0
angle_rad = 0.1
[[robot.faults]]
kind = "odometry_jump"
begins = { at_s = 1.0 }
shift = [0.1, 0.0, 0.0]
[[robot.faults]]
kind = "slip"
begins = { at_s = 1.0 }
lasts_s = 1.0
forward_ratio = 0.5
turn_ratio = 0.5
[[goals]]
pose = [9.0, 3.0, 0.0]
tolerance_m = 0.3
yaw_tolerance_rad = 0.3
[services.robot]
binary = "b"
config.x = 1
[services.mapping]
binary = "b"
config.x = 1
[services.global_planner]
binary = "b"
config.x = 1
[services.local_planner]
binary = "b"
config.x = 1
[services.collision_guard]
binary = "b"
config.x = 1
[restart]
per_service = 1
per_run = 1
window_s = 60.0
hang_after_s = 0.5
absent_ticks = 1
[[faults]]
kind = "kill"
service = "mapping"
begins = { at_s = 1.0 }
[[faults]]
kind = "stop"
service = "mapping"
begins = { robot_near = { point_m = [5.0, 2.0], distance_m = 1.0 } }
lasts_s = 1.0
[[faults]]
kind = "slow"
service = "mapping"
by_ms = 1.0
begins = { at_s = 1.0 }
lasts_s = 1.0
[[faults]]
kind = "drop"
topic = 'plan/path'
share = 0.5
begins.at_s = 1.0
lasts_s = 1.0
[[faults]]
kind = "clock"
service = "mapping"
by_ms = -20.0
begins.at_s = 1.0
lasts_s = 1.0
[random_faults]
count = 3
from_s = 1.0
until_s = 5.0
seed = 1
kinds = ["kill"]
services = ["mapping"]
[[swaps]]
service = "mapping"
at_s = 1.0
binary = "b"
config.x = 1
shadow_s = 1.0
keep_s = 1.0
require = "p99<2ms"
[expect]
outcome = "reached"
contacts_max = 0
obstacle_replans_min = 0
obstacle_replans_max = 1
driven_m_min = 1.0
goal_distance_m_max = 1.0
interventions_min = { stopped_short = 1 }
restarts_min = 1
[trials]
obstacle = "bounces"
goals = [
    { pose = [1.0, 2.5, 0.0], tolerance_m = 0.3, yaw_tolerance_rad = 0.3 },
    { pose = [9.0, 2.5, 0.0], tolerance_m = 0.3, yaw_tolerance_rad = 0.3 },
]
line_m = [[3.0, 2.5], [7.0, 2.5]]
ahead_m = 1.0
"#,
    r#"
title = "Recorded people"
start = [1.0, 2.0, 0.5]
[world]
pedestrians = { file = "absent.csv", from_s = 1.0, duration_s = 1.0, radius_m = 0.3 }
[robot]
preset = "jackal"
footprint_m = [[0.2, 0.2], [-0.2, 0.2], [-0.2, -0.2], [0.2, -0.2]]
"#,
    r#"
title = "A world of DynaBARN"
start = [1.0, 2.0, 0.5]
[world]
dynabarn = { file = "absent.csv", phase_s = 1.0 }
[robot]
preset = "jackal"
"#,
    r#"
title = "Files"
start = [1.0, 2.0, 0.5]
[world]
map = "absent.yaml"
barn = "absent.csv"
[robot]
preset = "jackal"
"#,
    r#"
title = "A random map"
start = [1.0, 2.0, 0.5]
[world.generated]
family = { kind = "blocky", side_cells_max = 2 }
size_cells = [20, 20]
ratio = 0.1
start_cell = [0, 0]
goal_cell = [19, 19]
seed = 1
resolution_m = 1.0
[robot]
preset = "jackal"
"#,
    r#"
title = "Corridors"
start = [1.0, 2.0, 0.5]
[world.generated]
family = { kind = "corridor", width_cells = 2 }
size_cells = [20, 20]
ratio = 0.0
resolution_m = 1.0
[robot]
preset = "jackal"
[foresight]
perceive = "truth"
predict = "truth"
"#,
];

/// The shipped scenarios with their defaults written out, and the ones above.
pub(super) fn documents() -> Vec<Table> {
    let library = Library::of("/nowhere");
    let shipped = library.list().into_iter().map(|listed| {
        let scenario = Scenario::load_from(&library, &listed.name).unwrap();
        let mut table = Table::try_from(&scenario).unwrap();
        table.remove("name");
        table
    });
    let others = OTHERS.iter().map(|text| text.parse().unwrap());
    // One shadow at a time.
    let shadows = Role::SERVICES.into_iter().map(|role| {
        let text = format!(
            "title = \"A shadow and a schedule\"\nstart = [3.0, 2.5, 0.0]\n\
             [world]\narea_m = [[0.0, 0.0], [10.0, 5.0]]\n[services.{role}.shadow]\nbinary = \"b\"\nconfig.x = 1\n\
             [services.{role}.scheduling]\npolicy = \"fifo\"\npriority = 5\nnice = 0\ncpus = [0]\nlock_memory = true\n"
        );
        text.parse().unwrap()
    });
    others.chain(shadows).chain(shipped).collect()
}

/// A step to a value.
#[derive(Debug, Clone, PartialEq)]
enum Step {
    Key(String),
    Index(usize),
}

/// The way to a value, and how it reads with and without the numbers of lists.
#[derive(Debug, Clone, Default)]
struct Way(Vec<Step>);

impl Way {
    fn then(&self, step: Step) -> Self {
        Self(self.0.iter().cloned().chain([step]).collect())
    }

    /// `goals[].pose[]`.
    fn kind(&self) -> String {
        let word = |step: &Step| match step {
            Step::Key(key) => format!(".{key}"),
            Step::Index(_) => "[]".to_owned(),
        };
        let words: String = self.0.iter().map(word).collect();
        words.trim_start_matches('.').to_owned()
    }

    /// The innermost name.
    fn name(&self) -> &str {
        for step in self.0.iter().rev() {
            if let Step::Key(key) = step {
                return key;
            }
        }
        ""
    }

    fn value<'a>(&self, root: &'a mut Value) -> &'a mut Value {
        self.0.iter().fold(root, |value, step| match step {
            Step::Key(key) => &mut value[key.as_str()],
            Step::Index(index) => &mut value[*index],
        })
    }
}

/// All values below `value`, tables and lists, too.
fn walk(value: &Value, way: &Way, visit: &mut impl FnMut(&Way, &Value)) {
    visit(way, value);
    match value {
        // What a service is told is its own affair.
        Value::Table(_) if way.kind().ends_with(".config") => {}
        Value::Table(table) => {
            for (key, value) in table {
                walk(value, &way.then(Step::Key(key.clone())), visit);
            }
        }
        Value::Array(list) => {
            for (index, value) in list.iter().enumerate() {
                walk(value, &way.then(Step::Index(index)), visit);
            }
        }
        _ => {}
    }
}

/// A folder to read changed scenarios from.
struct Desk(TempDir);

impl Desk {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn said_of(&self, document: &Value) -> String {
        let text = toml::to_string(document).unwrap();
        std::fs::write(self.0.path().join("it.toml"), text).unwrap();
        let read = Scenario::load_from(&Library::of(self.0.path()), "./it.toml");
        let checked = read.and_then(|scenario| {
            let checked = scenario.validate()?;
            // What a run makes of the numbers before it starts anything.
            let _ = (scenario.run.tick_ns(), scenario.run.time_limit_ns());
            let _ = scenario.restart.hang_after();
            Ok(checked)
        });
        checked.map_or_else(|error| error.to_string(), |_| String::new())
    }

    /// What is wrong with the document after `change` to the value at `way`; empty for nothing.
    fn complaint(&self, document: &Value, way: &Way, change: impl FnOnce(&mut Value)) -> String {
        let mut changed = document.clone();
        change(way.value(&mut changed));
        let complaint = self.said_of(&changed);
        // What is wrong with the document itself, such as a file that is not there, is said besides.
        let second = complaint.lines().nth(1);
        let of_document = second.map(|_| self.said_of(document)).unwrap_or_default();
        let what = |line: &str| line.splitn(3, ':').last().map(str::to_owned);
        let own = |line: &&str| !of_document.lines().any(|known| what(known) == what(line));
        let complaint = complaint.lines().filter(own).collect::<Vec<_>>().join("\n");
        assert!(!complaint.contains('\n'), "{complaint:?} has several lines");
        assert!(complaint.len() < 1000, "too long: {complaint}");
        complaint
    }
}

#[test]
fn every_number_has_a_range() {
    let (desk, mut seen) = (Desk::new(), BTreeSet::new());
    for document in documents().into_iter().map(Value::Table) {
        let mut numbers = Vec::new();
        walk(&document, &Way::default(), &mut |way, value| {
            let is_number = value.is_float() || value.is_integer();
            if is_number && !way.kind().contains(".config") && seen.insert(way.kind()) {
                numbers.push((way.clone(), value.is_float()));
            }
        });
        for (way, is_float) in numbers {
            let (nan, infinite) = (f64::NAN, f64::INFINITY);
            for wrong in [nan, infinite, -infinite, 1.0e300, -1.0e300] {
                let complaint = desk.complaint(&document, &way, |value| *value = wrong.into());
                let place = way.kind();
                assert!(!complaint.is_empty(), "{place} = {wrong:?} was accepted");
                let named = !is_float || complaint.contains(way.name());
                assert!(named, "{place} = {wrong:?} is not named: {complaint}");
            }
            // These may be, but nothing may panic.
            for odd in [-1_i64, 0, i64::MAX] {
                #[allow(clippy::cast_precision_loss, reason = "any number will do")]
                let as_read = if is_float {
                    Value::from(odd as f64)
                } else {
                    Value::from(odd)
                };
                desk.complaint(&document, &way, |value| *value = as_read);
            }
        }
    }
    assert!(seen.len() > 80, "only {} numbers were found", seen.len());
}

#[test]
fn every_list_of_fixed_length_is_counted() {
    let (desk, mut seen) = (Desk::new(), BTreeSet::new());
    for document in documents().into_iter().map(Value::Table) {
        let mut lists = Vec::new();
        walk(&document, &Way::default(), &mut |way, value| {
            let of_numbers = value.as_array().is_some_and(|list| {
                !list.is_empty() && list.iter().all(|item| item.is_float() || item.is_integer())
            });
            if of_numbers && seen.insert(way.kind()) {
                lists.push(way.clone());
            }
        });
        for way in lists {
            let complaint = desk.complaint(&document, &way, |value| {
                let list = value.as_array_mut().unwrap();
                list.push(list[0].clone());
            });
            assert!(!complaint.is_empty(), "{} may be longer", way.kind());
        }
    }
    assert!(seen.contains("start") && seen.contains("world.shapes[].centre_m"));
}

/// The words between backticks.
fn quoted(text: &str) -> impl Iterator<Item = &str> {
    text.split('`').skip(1).step_by(2)
}

#[test]
fn every_misspelt_field_is_found_and_no_field_is_left_out() {
    const UNKNOWN: &str = "zqzqzqzqzqzq";
    let desk = Desk::new();
    let documents: Vec<Value> = documents().into_iter().map(Value::Table).collect();
    // Which fields there are in each table, by its place and, where tables differ in kind, that.
    let mut fields: BTreeMap<(String, String), BTreeSet<String>> = BTreeMap::new();
    let mut tables = Vec::new();
    for document in &documents {
        walk(document, &Way::default(), &mut |way, value| {
            let Some(table) = value
                .as_table()
                .filter(|_| !way.kind().ends_with(".config"))
            else {
                return;
            };
            let kind = table.get("kind").and_then(Value::as_str).unwrap_or("");
            let known = fields.entry((way.kind(), kind.to_owned())).or_default();
            if table.keys().any(|key| !known.contains(key)) {
                known.extend(table.keys().cloned());
                tables.push((document, way.clone(), table.clone(), kind.to_owned()));
            }
        });
    }
    for (document, way, table, kind) in tables {
        let place = way.kind();
        let complaint = desk.complaint(document, &way, |value| {
            let table = value.as_table_mut().unwrap();
            table.insert(UNKNOWN.to_owned(), 1.into());
        });
        assert!(
            complaint.contains(UNKNOWN),
            "unknown in {place}: {complaint:?}"
        );
        // A list of labels is checked against other words.
        if let Some((_, expected)) = complaint.split_once(", expected ") {
            let known = &fields[&(place.clone(), kind)];
            for field in quoted(expected) {
                let bases = place.is_empty() && ["base", "variant", "variants"].contains(&field);
                assert!(
                    bases || known.contains(field),
                    "no test has {place}.{field}"
                );
            }
        }
        for key in table.keys().filter(|key| *key != "kind") {
            let complaint = desk.complaint(document, &way, |value| {
                let table = value.as_table_mut().unwrap();
                let old = table.remove(key).unwrap();
                table.insert(format!("{key}x"), old);
            });
            let said = format!("did you mean `{key}`?");
            assert!(complaint.contains(&said), "{place}.{key}x: {complaint:?}");
        }
    }
}
