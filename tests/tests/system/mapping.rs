//! What mapping promises to the rest of the stack, through the real processes.

use serde_json::Value;
use std::path::Path;
use zeronav_msgs::health::REASON_SCAN;
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::{HealthTopic, MapUpdate, health_of};
use zeronav_shell::roster_reader::RosterReader;
use zeronav_shell::{Domain, Latest, Peer, Stream};
use zeronav_tests::{Zeronav, real_time_turn, workspace, zeronav};
use zeronav_world::Occupancy;

/// Drives a scenario of this project in lockstep: it arrives and touches nothing.
#[track_caller]
fn drives(name: &str) -> Value {
    let file = workspace().join(format!("tests/scenarios/{name}.toml"));
    let file = file.to_str().expect("a path");
    let result = zeronav(&["run", file, "--lockstep", "--headless", "--json"]).expect(0);
    assert_eq!(result["verdict"], "pass", "{result:#}");
    assert_eq!(result["reached"], true, "{result:#}");
    assert_eq!(result["contacts"], 0, "{result:#}");
    result
}

/// The robot leaves the first window, and two runs are the same.
#[track_caller]
fn leaves_its_window(name: &str) {
    let (first, again) = (drives(name), drives(name));
    let driven_m = first["driven_m"].as_f64().expect("metres");
    assert!(driven_m > 20.0, "{driven_m} m");
    let track: Vec<[f64; 2]> = serde_json::from_value(first["track_m"].clone()).expect("points");
    let farthest_m = track.iter().map(|[x, _]| *x).fold(0.0, f64::max);
    assert!(
        farthest_m > 10.9 + 10.0,
        "{farthest_m} m, the window ended at 10.9 m"
    );
    assert!(first["run_hash"].is_string());
    assert_eq!(first["run_hash"], again["run_hash"]);
}

#[test]
fn rolling_map_follows_the_robot() {
    leaves_its_window("drive_rolling_window");
}

#[test]
fn growing_map_follows_the_robot() {
    leaves_its_window("drive_growing_window");
}

/// A folder with this scenario as `it.toml`.
fn scenario(text: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
    folder
}

const BLACKOUT: &str = r#"
title = "The lidar goes silent in the aisle"
base = ["warehouse", "porter"]
start = [4.0, 6.425, 0.0]
run.time_limit_s = 60.0
[[robot.faults]]
kind = "lidar_blackout"
begins = { at_s = 4.0 }
lasts_s = 2.0
[[goals]]
pose = [12.5, 6.425, 0.0]
[expect]
outcome = "reached"
contacts_max = 0
"#;

/// A guest that reads what mapping says.
struct Tap {
    roster: RosterReader,
    update: Stream<MapUpdate>,
    health: Latest<HealthTopic>,
}

impl Tap {
    fn on(root: &Path) -> Self {
        let domain = Domain::join(root).expect("the domain is there");
        let peer = Peer::join(domain, Role::Tap, 1).expect("guests are welcome");
        let mapping = health_of(Role::Mapping).expect("its heartbeat");
        Self {
            roster: RosterReader::open(&peer).expect("the roster"),
            update: peer.stream().expect("the updates"),
            health: peer.latest_on(mapping).expect("mapping's heartbeat"),
        }
    }

    /// Whether the newest of the updates that have come calls the map current, and whether the
    /// heartbeat names the scan as a reason.
    fn listen(&mut self, current: &mut Option<bool>) -> bool {
        self.roster.poll();
        let roster = self.roster.roster();
        self.update.drain(roster, |view| {
            *current = Some(view.meta.current == 1);
        });
        self.health.poll(roster);
        let reasons = self.health.get().map_or(0, |health| health.meta.reasons);
        reasons & REASON_SCAN != 0
    }
}

#[test]
fn without_scans_map_and_health_report_not_current() {
    let _turn = real_time_turn();
    let arguments = ["run", "./it.toml", "--headless", "--json"];
    let mut run = Zeronav::start_in(scenario(BLACKOUT), &arguments);
    run.wait_until("every service knows its domain", |run| {
        run.children().len() == 5 && run.domains().len() == 1
    });
    let mut tap = Tap::on(&run.domains().pop().expect("a domain"));
    let mut current = None;
    for (when, wanted) in [("before", true), ("during", false), ("after", true)] {
        run.wait_until(&format!("the map is right {when} the blackout"), |_| {
            let silent = tap.listen(&mut current);
            current == Some(wanted) && silent != wanted
        });
    }
    drop(tap);
    let result = run.finish().expect(0);
    assert_eq!(result["contacts"], 0, "{result:#}");
    assert_eq!(result["reached"], true, "{result:#}");
}

/// Where the walkers cross. [m]
const CROSSINGS_M: [f64; 2] = [6.0, 8.5];

const WALKERS: &str = r#"
title = "Two people cross"
start = [1.5, 4.0, 0.0]
base = ["porter"]
run.time_limit_s = 60.0
[world]
area_m = [[0.0, 0.0], [12.0, 8.0]]
shapes = [
    { kind = "box", centre_m = [6.0, 0.1], size_m = [12.0, 0.2] },
    { kind = "box", centre_m = [6.0, 7.9], size_m = [12.0, 0.2] },
    { kind = "box", centre_m = [0.1, 4.0], size_m = [0.2, 7.6] },
    { kind = "box", centre_m = [11.9, 4.0], size_m = [0.2, 7.6] },
]
[[world.obstacles]]
name = "up"
shape = { kind = "disc", centre_m = [6.0, 1.2], radius_m = 0.3 }
waypoints_m = [[6.0, 6.8]]
speed_mps = 0.8
[[world.obstacles]]
name = "down"
shape = { kind = "disc", centre_m = [8.5, 6.8], radius_m = 0.3 }
waypoints_m = [[8.5, 1.2]]
speed_mps = 0.8
[[goals]]
pose = [10.5, 4.0, 0.0]
[expect]
outcome = "reached"
contacts_max = 0
"#;

#[test]
fn passed_pedestrians_leave_no_trail_on_the_map() {
    let saved = tempfile::tempdir().expect("a folder");
    let folder = saved.path().display();
    let text = format!("{WALKERS}\n[services.mapping.config]\nsave_to = \"{folder}\"\n");
    let arguments = ["run", "./it.toml", "--lockstep", "--headless", "--json"];
    let result = Zeronav::start_in(scenario(&text), &arguments)
        .finish()
        .expect(0);
    assert_eq!(result["contacts"], 0, "{result:#}");
    assert!(
        result["tracking"]["found"].as_u64() >= Some(2),
        "{result:#}"
    );

    let file = saved.path().join("map.yaml");
    let map = zeronav_world_files::map_file::load(&file)
        .expect("the map")
        .map;
    let mut seen = 0;
    // Each stops at one end; the first 0.8 m are walked before tracking can confirm it.
    for (x, from, to) in [(CROSSINGS_M[0], 20, 60), (CROSSINGS_M[1], 20, 60)] {
        for y in from..to {
            for across in -8..=8 {
                let at = [x + f64::from(across) * 0.05, f64::from(y) * 0.1];
                let cell = map.geometry.unbounded_cell_at(at.into());
                let index = map.geometry.index_of(cell).expect("on the map");
                assert_ne!(map.cells[index], Occupancy::Occupied, "a trail at {at:?}");
                seen += 1;
            }
        }
    }
    assert!(seen > 1000, "{seen} cells");

    let plans = result["plans"].as_array().expect("plans");
    let last = plans.last().expect("a plan");
    let points: Vec<[f64; 2]> = serde_json::from_value(last["points_m"].clone()).expect("points");
    let length_m: f64 = points
        .windows(2)
        .map(|pair| f64::hypot(pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]))
        .sum();
    let (first, end) = (points[0], points[points.len() - 1]);
    let straight_m = f64::hypot(end[0] - first[0], end[1] - first[1]);
    assert!(
        first[0] < CROSSINGS_M[1],
        "the last path crosses no trail: {points:?}"
    );
    assert!(
        length_m < 1.1 * straight_m,
        "{length_m} m for {straight_m} m"
    );
    let time_s = &result["time_s"];
    eprintln!("{time_s} s, {} paths, {}", plans.len(), result["tracking"]);
}
