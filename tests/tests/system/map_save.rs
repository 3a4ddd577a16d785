//! `zeronav map save`: what a run has mapped, saved while it drives, is the same map when it is
//! loaded, with the same costs, and the next run drives on it.

use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use zeronav_casts::Cast;
use zeronav_msgs::map::{COST_INSCRIBED, COST_UNKNOWN, MapInfo};
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::MapKeyframe;
use zeronav_msgs::{Cell, Id, MapCell};
use zeronav_shell::roster_reader::RosterReader;
use zeronav_shell::{Domain, Latest, Peer};
use zeronav_tests::up::Up;
use zeronav_tests::{Zeronav, real_time_turn, zeronav};
use zeronav_world::{Occupancy, StaticMap};
use zeronav_world_files::map_file;

/// A box that no map knows stands beside the aisle.
const SCENARIO: &str = "title = \"test\"\nbase = [\"warehouse\", \"porter\"]\n\
                        start = [4.0, 6.425, 0.0]\n\
                        [[world.obstacles]]\nname = \"box\"\n\
                        shape = { kind = \"box\", centre_m = [8.2, 7.1], size_m = [0.4, 0.4] }\n";

/// A map as mapping has sent it, by its revision.
type Revisions = BTreeMap<String, (MapInfo, Vec<MapCell>)>;

/// A member of the run that reads every keyframe.
struct Watcher {
    peer: Peer,
    roster: RosterReader,
    keyframes: Latest<MapKeyframe>,
    revisions: Revisions,
}

impl Watcher {
    fn join(root: &Path) -> Self {
        let domain = Domain::join(root).expect("the domain");
        let peer = Peer::join(domain, Role::Tap, 1).expect("a place");
        let mut roster = RosterReader::open(&peer).expect("the roster");
        roster.await_known().expect("the roster");
        let keyframes = peer.latest().expect("the map");
        Self {
            peer,
            roster,
            keyframes,
            revisions: Revisions::new(),
        }
    }

    /// Takes in what has come.
    fn look(&mut self) {
        self.roster.poll();
        if self.keyframes.poll(self.roster.roster())
            && let Some(view) = self.keyframes.get()
        {
            let mut cells = vec![MapCell::default(); view.meta.geometry.len()];
            for tile in view.items {
                tile.copy_to(&view.meta.geometry, &mut cells);
            }
            let revision = Id(view.meta.revision).to_string();
            self.revisions.insert(revision, (*view.meta, cells));
        }
        self.keyframes.release();
    }

    fn leave(self) -> Revisions {
        drop((self.keyframes, self.roster));
        let _ = self.peer.leave().close();
        self.revisions
    }
}

/// Distance from the centre of `cell` to the nearest occupied square, at most `limit_m`. [m]
fn clearance_m(map: &StaticMap, cell: Cell, limit_m: f64) -> f64 {
    let resolution_m = map.geometry.resolution_m;
    let reach = (limit_m / resolution_m).ceil().to_i32() + 1;
    let mut least_m = limit_m;
    for y in cell.y - reach..=cell.y + reach {
        for x in cell.x - reach..=cell.x + reach {
            if map.get(Cell::new(x, y)) == Some(Occupancy::Occupied) {
                let beyond = |a: i32, b: i32| (f64::from((a - b).abs()) - 0.5).max(0.0);
                let away = f64::hypot(beyond(x, cell.x), beyond(y, cell.y));
                least_m = least_m.min(away * resolution_m);
            }
        }
    }
    least_m
}

#[test]
fn saved_map_has_the_costs_of_the_running_one_and_carries_the_next_run() {
    let _turn = real_time_turn();
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("it.toml"), SCENARIO).expect("written");
    // It stays up: saving may take longer than the drive.
    let mut up = Up::start_in(folder, &["./it.toml"]);
    up.ask(&["goal", "14", "6.425", "0"], 0);
    up.stack.wait_until("the robot is on its way", |stack| {
        let report = stack.report().unwrap_or_default();
        report["goal"]["elapsed_s"].as_f64() > Some(5.0)
    });
    let domain = up.root.clone();
    let root = Path::new(&domain);
    let maps = tempfile::tempdir().expect("a folder");
    let file = maps.path().join("new/seen.yaml");
    let file = file.to_str().expect("a path");

    let mut watcher = Watcher::join(root);
    let mut saving = Zeronav::start(&["map", "save", file, "--domain", &domain, "--json"]);
    while !saving.has_ended() {
        watcher.look();
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    watcher.look();
    let revisions = watcher.leave();
    let saved = saving.finish().expect(0);
    let revision = saved["revision"].as_str().expect("a revision");
    let sent = revisions.get(revision);
    let (info, cells) = sent.expect("the keyframe of this revision");

    let loaded = map_file::load(Path::new(file)).expect("our own file");
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let map = loaded.map;
    assert_eq!(map.geometry, info.geometry);
    costs_are_equal(&map, info, cells);
    for (name, wanted) in [
        ("occupied", Occupancy::Occupied),
        ("free", Occupancy::Free),
        ("unknown", Occupancy::Unknown),
    ] {
        assert_eq!(saved[name], map.count(wanted), "{saved:#}");
    }
    // What the lidar has seen is in it.
    let at = |x_m: f64, y_m: f64| map.at([x_m, y_m].into());
    let seen = (0..8).any(|n| at(8.025 + 0.05 * f64::from(n), 6.925) == Some(Occupancy::Occupied));
    assert!(seen, "the box is not in the map");
    let again = up.ask(&["map", "save", file], 2);
    assert!(again.contains("--force"), "{again}");
    up.ask(&["map", "save", file, "--force"], 0);
    let result = up.down();
    assert_eq!(result["contacts"], 0, "{result:#}");

    let next = drive_on(Path::new(file));
    assert_eq!(next["reached"], true, "{next:#}");
    assert_eq!(next["contacts"], 0, "{next:#}");
}

/// Every cost of the running map follows from the loaded one by the running map's cost model.
fn costs_are_equal(map: &StaticMap, info: &MapInfo, cells: &[MapCell]) {
    let limit_m = f64::from(info.clearance_limit_mm) / 1000.0;
    let (width, height) = map.geometry.size();
    let mut index = 0;
    for y in 0..height {
        for x in 0..width {
            let clearance_m = clearance_m(map, Cell::new(x, y), limit_m);
            let known = info.cost_model.cost(clearance_m);
            let unknown = map.cells[index] == Occupancy::Unknown;
            let cost = if unknown && known < COST_INSCRIBED {
                COST_UNKNOWN
            } else {
                known
            };
            assert_eq!(cost, cells[index].cost, "({x}, {y}), {clearance_m} m");
            index += 1;
        }
    }
}

/// A run in lockstep whose world is this map file.
fn drive_on(map: &Path) -> Value {
    let folder = tempfile::tempdir().expect("a folder");
    let text = format!(
        "title = \"test\"\nbase = [\"porter\"]\nstart = [4.0, 6.425, 0.0]\n\
         [[goals]]\npose = [14.0, 6.425, 0.0]\n\
         [world]\nmap = \"{}\"\n",
        map.display()
    );
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
    let arguments = ["run", "./it.toml", "--lockstep", "--headless", "--json"];
    Zeronav::start_in(folder, &arguments).finish().expect(0)
}

#[test]
fn mistakes_are_answered_in_one_line() {
    let gone = ["--domain", "/dev/shm/zn_nothing000"];
    for (file, said) in [
        ("hall", "ends in .yaml"),
        ("/dev/null/hall.yaml", "Not a directory"),
        ("hall.yaml", "the run is over or was never started"),
    ] {
        let ended = zeronav(&[&["map", "save", file], &gone[..]].concat());
        assert_eq!(ended.code(), 2, "{file}: {}", ended.stderr);
        assert!(ended.stderr.contains(said), "{file}: {}", ended.stderr);
        assert_eq!(ended.stderr.lines().count(), 1, "{}", ended.stderr);
    }
}
