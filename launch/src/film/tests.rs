use super::*;
use serde_json::Value;
use zeronav_msgs::certainty::PoseCertainty::{Confirmed, Unknown};
use zeronav_msgs::header::Id;
use zeronav_msgs::map::{FLAG_SENSED, MapCell, MapInfo};
use zeronav_msgs::path::PathStatus;
use zeronav_msgs::{Cell, GridGeometry};

const TICK_NS: u64 = 20_000_000;

/// Room of all samples together, and what stands around them. [bytes]
const ALL_BYTES: usize = 2_600_000;

/// Noise that is the same in every run.
struct Noise(u32);

impl Noise {
    fn next(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        self.0 >> 16
    }

    /// 0 to 1.
    fn share(&mut self) -> f64 {
        f64::from(self.next()) / 65_536.0
    }
}

fn tile(x: u32, y: u32, noise: &mut Noise) -> MapTile {
    let mut tile = MapTile {
        tile_x: x,
        tile_y: y,
        cells: [MapCell::default(); 1024],
    };
    for _ in 0..40 {
        let at = noise.next() as usize % 1024;
        tile.cells[at].flags = FLAG_SENSED;
    }
    tile
}

fn info(revision: u64, side: u32) -> MapInfo {
    MapInfo {
        geometry: GridGeometry {
            origin_x_m: -1.0,
            origin_y_m: -2.0,
            resolution_m: 0.05,
            width: 32 * side,
            height: 32 * side,
        },
        revision,
        parts: 1,
        ..MapInfo::default()
    }
}

/// The film of a drive of so many seconds in which everything changes all the time.
pub(crate) fn busy_drive(duration_s: u64) -> Film {
    const SIDE: u32 = 10;
    let mut noise = Noise(1);
    let mut film = Film::default();
    let mut replica = MapReplica::new();
    let keyframe: Vec<MapTile> = (0..SIDE * SIDE)
        .map(|at| tile(at % SIDE, at / SIDE, &mut noise))
        .collect();
    replica.keyframe(&info(Id::new(1, 1).0, SIDE), &keyframe);
    film.description(&Description::default(), &[]);
    film.written_all();
    film.placed(0, Pose::default());
    let none = BTreeSet::new();
    film.goals(0, &[Goal::default()], &none);
    let ranges_m: Vec<f32> = (0..720_u16).map(|at| 1.0 + f32::from(at) / 100.0).collect();
    let scan = Scan {
        n_beams: 720,
        range_m_max: 20.0,
        angle_increment_rad: 0.008,
        ..Scan::default()
    };
    let mut revision = 1;
    for tick in 0..duration_s * 50 {
        let run_ns = tick * TICK_NS;
        let pose = Pose::new(100.0 * noise.share(), 100.0 * noise.share(), 3.0);
        let body = || vec![vec![zeronav_viewer::scene::point(pose.x_m, 1.0); 12]; 4];
        film.truth(run_ns, &pose, body);
        let odometry = Odometry {
            pose,
            v_mps: noise.share(),
            ..Odometry::default()
        };
        film.odometry(tick, run_ns, &odometry);
        let intervention = if tick % 2 == 0 {
            Intervention::Slowed
        } else {
            Intervention::None
        };
        let command = VelocityCommand {
            v_mps: noise.share(),
            intervention: intervention.code(),
            ..VelocityCommand::default()
        };
        film.request(tick, &VelocityRequest::default());
        film.command(run_ns, tick, &command);
        if tick % 5 == 0 {
            film.scan(tick, run_ns, &scan, &ranges_m);
            let obstacle = Obstacle {
                x_m: 100.0 * noise.share(),
                ..Obstacle::default()
            };
            film.tracked(run_ns, &[obstacle; 8]);
            let is_lost = (tick / 50).is_multiple_of(2);
            film.certainty(run_ns, [Confirmed, Unknown][usize::from(is_lost)]);
            let at = [noise.next() % SIDE, noise.next() % SIDE];
            let tiles = [tile(at[0], at[1], &mut noise)];
            revision += 1;
            let id = Id::new(1, revision);
            replica.update(id, &info(id.0, SIDE), &tiles);
            film.written(&tiles);
        }
        film.look_at_map(run_ns, &replica);
        if tick % 100 == 0 {
            let path = Path {
                status: PathStatus::Found.code(),
                geometry: tick,
                length_m: 100.0 * noise.share(),
                ..Path::default()
            };
            film.path(run_ns, &path, &[Waypoint::default(); 200]);
        }
    }
    film.end();
    film
}

fn scene(film: &Film, until_ns: u64) -> Value {
    let cut = Cut {
        scenario: "busy",
        mode: "lockstep",
        from_ns: 0,
        until_ns,
    };
    serde_json::to_value(film.scene(&cut).expect("a scene")).expect("JSON")
}

#[test]
fn the_film_of_an_hour_keeps_its_budget_and_shows_all_of_it() {
    let hour_ns = 3_600_000_000_000;
    let film = busy_drive(3600);
    let scene = scene(&film, hour_ns);
    let bytes = scene.to_string().len();
    assert!(bytes < ALL_BYTES, "{bytes} bytes");
    assert!(film.rates().thinned, "{:?}", film.rates());
    let frames = scene["frames"].as_array().expect("frames");
    let time_s = |frame: &Value| frame["time_s"].as_f64().expect("a time");
    assert!(frames.len() > 500, "{}", frames.len());
    assert!(time_s(&frames[0]) < 1.0 && time_s(&frames[frames.len() - 1]) > 3590.0);
    assert!(
        frames
            .windows(2)
            .all(|pair| time_s(&pair[0]) < time_s(&pair[1]))
    );
    for key in [
        "scan",
        "obstacles",
        "bodies",
        "path",
        "map",
        "control",
        "truth",
        "certainty",
    ] {
        let times: Vec<f64> = frames
            .iter()
            .filter(|frame| !frame[key].is_null())
            .map(time_s)
            .collect();
        // A map that is another one everywhere, all the time, takes the most room of all.
        let (n, until_s) = if key == "map" {
            (8, 3000.0)
        } else {
            (50, 3500.0)
        };
        assert!(times.len() > n, "{key}: {}", times.len());
        let last_s = times[times.len() - 1];
        assert!(last_s > until_s, "{key}: {last_s}");
    }
    let (kept, left_out) = film.interventions();
    assert_eq!(kept.len() as u64 + left_out, 90_000);
    assert_eq!(kept.len(), INTERVENTIONS_MAX);
}

#[test]
fn a_short_film_is_whole_and_ends_with_the_run() {
    let film = busy_drive(20);
    assert!(!film.rates().thinned);
    let scene = scene(&film, 10_000_000_000);
    let frames = scene["frames"].as_array().expect("frames");
    assert_eq!(frames.len(), 101, "ten a second, to the end");
    let n = |key: &str| frames.iter().filter(|frame| !frame[key].is_null()).count();
    assert_eq!((n("truth"), n("control"), n("scan")), (101, 101, 51));
    // It is lost and found in turns, a second each.
    let certainty = frames
        .iter()
        .filter_map(|frame| frame["certainty"].as_str());
    let certainty: Vec<&str> = certainty.collect();
    assert_eq!(certainty[..3], ["unknown", "confirmed", "unknown"]);
    assert_eq!(certainty.len(), 11);
    assert_eq!(frames[0]["goals"].as_array().map(Vec::len), Some(1));
    let grid = &frames[0]["map"]["grid"];
    assert_eq!(
        (&grid[0], &grid[3]),
        (&Value::from(-1.0), &Value::from(320))
    );
    assert_eq!(
        frames[0]["map"]["tiles"].as_array().map(Vec::len),
        Some(100)
    );
    assert_eq!(
        frames[0]["scan"]["ranges_mm"].as_array().map(Vec::len),
        Some(180)
    );
}

#[test]
fn tiles_of_the_map_come_when_they_have_changed() {
    let mut noise = Noise(3);
    let mut film = Film::default();
    let mut replica = MapReplica::new();
    let tiles: Vec<MapTile> = (0..4).map(|at| tile(at % 2, at / 2, &mut noise)).collect();
    replica.keyframe(&info(Id::new(1, 1).0, 2), &tiles);
    film.written_all();
    film.look_at_map(0, &replica);
    // The same again, one of them with another cell.
    let mut changed = tiles.clone();
    let cell = Cell::new(5, 0);
    let flags = &mut changed[3].cells[usize::try_from(cell.x).expect("a column")].flags;
    *flags ^= FLAG_SENSED;
    replica.update(Id::new(1, 2), &info(Id::new(1, 2).0, 2), &changed);
    film.written(&changed);
    film.look_at_map(MAP_NS - 1, &replica);
    assert_eq!(film.maps.samples().len(), 1, "not yet");
    film.look_at_map(MAP_NS, &replica);
    let sizes: Vec<usize> = (film.maps.samples().iter())
        .map(|(_, patch)| patch.tiles.len())
        .collect();
    assert_eq!(sizes, [4, 1]);
    // A map that has moved is shown from the beginning.
    let mut moved = info(Id::new(1, 3).0, 2);
    moved.geometry.origin_x_m = 5.0;
    replica.keyframe(&moved, &tiles);
    film.written_all();
    film.look_at_map(MAP_NS + 1, &replica);
    let (_, patch) = film.maps.samples().last().expect("a patch");
    assert!(patch.grid.is_some());
    assert_eq!(patch.tiles.len(), 4);
}

#[test]
fn a_command_shows_its_request_whichever_is_heard_first() {
    let request = VelocityRequest {
        v_mps: 0.5,
        ..VelocityRequest::default()
    };
    // Both are read in turns: some requests come after so many commands.
    let shown = |early: usize| {
        let mut film = Film::default();
        for ids in [1, 2, 3, 4].chunks(early.max(1)) {
            let hear_requests = |film: &mut Film| {
                for id in ids {
                    film.request(*id, &request);
                }
            };
            if early == 0 {
                hear_requests(&mut film);
            }
            for id in ids {
                film.command(id * POSE_NS, *id, &VelocityCommand::default());
            }
            if early > 0 {
                hear_requests(&mut film);
            }
        }
        // Of this one the request is never heard.
        film.command(5 * POSE_NS, 5, &VelocityCommand::default());
        film.end();
        film.controls.samples().to_vec()
    };
    let late = shown(0);
    let speeds: Vec<Rounded> = late.iter().map(|(_, it)| it.request[0]).collect();
    let [asked, nothing] = [0.5, 0.0].map(|v_mps| point(v_mps, 0.0)[0]);
    assert_eq!(speeds, [asked, asked, asked, asked, nothing]);
    for early in 1..=4 {
        assert_eq!(shown(early), late, "{early} commands come first");
    }
}
