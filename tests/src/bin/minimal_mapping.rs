//! A minimal mapping: the static map, or an empty one, with the hits of all scans. A hit is forgotten
//! when a later beam passes through it.

use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::process::ExitCode;
use zeronav_msgs::header::{Header, Id, Parents};
use zeronav_msgs::health::REASON_SCAN;
use zeronav_msgs::map::{
    COST_CIRCUMSCRIBED_MAX, COST_INSCRIBED, COST_LETHAL, COST_UNKNOWN, FLAG_SENSED, FLAG_STATIC,
    FLAG_UNKNOWN, MapInfo, TILES_PER_UPDATE_MAX, tiles_of,
};
use zeronav_msgs::obstacles::Obstacles;
use zeronav_msgs::pose::Pose;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::SpanKind;
use zeronav_msgs::topics::{
    EVENT_NEED_KEYFRAME, MapKeyframe, MapObstacles, MapUpdate, RobotDescription, RobotScan,
};
use zeronav_msgs::{Cell, GridGeometry, MapCell, MapTile};
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{
    Draft, Due, Latest, OdometryReader, Sent, Service, Shell, StartError, Trigger, View, Writer,
};
use zeronav_world::{Occupancy, StaticMap};
use zeronav_world_files::map_file;

/// Where clearance is saturated. [mm]
const LIMIT_MM: u16 = 1000;
/// How near to a static obstacle a hit is taken for one on it. [mm]
const EXPLAINED_MM: u16 = 100;
/// Time without a scan after which the map is not current. [ns]
const STALE_NS: u64 = 500_000_000;

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Config {
    /// ROS map file; it brings its own area and resolution.
    static_map: Option<PathBuf>,
    /// Lower left and upper right corner of the map without a file. [m]
    area_m: Option<[[f64; 2]; 2]>,
    /// Side of its cells. [m]
    resolution_m: Option<f64>,
}

struct MinimalMapping {
    map: StaticMap,
    /// Clearance of every cell from the static map alone. [mm]
    static_mm: Vec<u16>,
    /// The cells that scans have hit and the static map does not explain.
    sensed: Vec<bool>,
    /// The cells around an obstacle that it is nearer to than the limit, and how near. [mm]
    disc: Vec<(i32, i32, u16)>,
    /// The whole map, and the tiles of it that have not been sent yet.
    tiles: Vec<MapTile>,
    unsent: Vec<usize>,
    /// The newest revision, and the tick and run time [ns] that it answers.
    revision: Id,
    tick: u64,
    run_ns: u64,
    description: Latest<RobotDescription>,
    odometry: OdometryReader,
    scan: Latest<RobotScan>,
    update: Writer<MapUpdate>,
    keyframe: Writer<MapKeyframe>,
    obstacles: Writer<MapObstacles>,
    keyframe_wanted: bool,
    /// Scans are still received.
    current: bool,
}

impl Service for MinimalMapping {
    const ROLE: Role = Role::Mapping;
    type Config = Config;

    fn open(shell: &mut Shell, config: Config) -> Result<Self, StartError> {
        let map = static_map(&config)?;
        let disc = disc(map.geometry.resolution_m);
        let mut static_mm = vec![LIMIT_MM; map.geometry.len()];
        for cell in cells_of(&map.geometry) {
            if map.get(cell) == Some(Occupancy::Occupied) {
                put_obstacle(&mut static_mm, &disc, &map.geometry, cell);
            }
        }
        let (columns, rows) = tiles_of(&map.geometry);
        let peer = shell.peer();
        Ok(Self {
            tiles: (0..columns * rows)
                .map(|n| MapTile {
                    tile_x: n % columns,
                    tile_y: n / columns,
                    cells: [MapCell::unknown(0); 1024],
                })
                .collect(),
            unsent: Vec::new(),
            revision: Id::NONE,
            tick: 0,
            run_ns: 0,
            description: peer.latest()?,
            odometry: OdometryReader::open(peer)?,
            scan: peer.latest()?,
            update: peer.writer(TILES_PER_UPDATE_MAX)?,
            keyframe: peer.writer(columns as usize * rows as usize)?,
            obstacles: peer.writer(1)?,
            keyframe_wanted: true,
            current: true,
            map,
            sensed: vec![false; static_mm.len()],
            static_mm,
            disc,
        })
    }

    fn wake(&mut self, shell: &mut Shell, rung: Rung) -> Result<(), StartError> {
        self.keyframe.refresh();
        let roster = shell.roster();
        self.odometry.poll(roster);
        self.description.poll(roster);
        self.scan.poll(roster);
        shell.count(&[&self.odometry, &self.scan, &self.description]);
        if self.description.get().is_none() {
            return Ok(());
        }
        // A scan is answered once the odometry of its capture has been received.
        let scan_run_ns = self.scan.get().map(|view| view.header.run_ns);
        let trigger = Trigger {
            tick: self.scan.tick(),
            complete: scan_run_ns.is_some_and(|ns| self.odometry.history().pose_at(ns).is_some()),
            ..Trigger::default()
        };
        for due in shell.due(&trigger) {
            self.answer(shell, due);
        }
        self.send_stale(shell);
        self.keyframe_wanted |= rung.has(EVENT_NEED_KEYFRAME);
        if self.keyframe_wanted && self.unsent.is_empty() {
            let draft = Draft {
                tick: self.tick,
                run_ns: self.run_ns,
                ..shell.begin(Due::IDLE, 0, 0, Parents::default())
            };
            let info = self.info(self.revision, self.tiles.len());
            let sent = shell.send(&draft, &mut self.keyframe, info, &self.tiles);
            self.keyframe_wanted = sent.is_none();
        }
        Ok(())
    }
}

impl MinimalMapping {
    /// Makes the map from the static one and the newest scan, and sends what changed.
    fn answer(&mut self, shell: &mut Shell, due: Due) {
        let (Some(description), scan) = (self.description.get(), self.scan.get()) else {
            return;
        };
        let scan = scan.filter(|_| due.kind == SpanKind::Answer);
        let header = scan.map_or_else(Header::default, |view| *view.header);
        let parents = Parents {
            odometry: self.odometry.id().0,
            scan: header.id,
            ..Parents::default()
        };
        let draft = shell.begin(due, header.run_ns, header.capture_ns, parents);
        let work = scan.map_or(0, |view| u64::from(view.meta.n_beams));
        if scan.is_some() {
            // What moves is not told from what stands.
            shell.send(&draft, &mut self.obstacles, Obstacles::default(), &[]);
            self.current = true;
        }
        let geometry = &self.map.geometry;
        let mut clearance_mm = self.static_mm.clone();
        if let (Some(scan), Some(odom_from_base)) =
            (scan, self.odometry.history().pose_at(header.run_ns))
        {
            let map_from_laser = odom_from_base.then(&description.meta.base_from_laser);
            sense(
                &mut self.sensed,
                &self.static_mm,
                geometry,
                &map_from_laser,
                &scan,
            );
        }
        for (cell, _) in cells_of(geometry)
            .zip(&self.sensed)
            .filter(|(_, sensed)| **sensed)
        {
            put_obstacle(&mut clearance_mm, &self.disc, geometry, cell);
        }
        let inscribed_mm = 1000.0 * description.meta.inscribed_radius_m;
        let cells: Vec<MapCell> = (self.map.cells.iter().zip(&self.sensed).zip(&clearance_mm))
            .map(|((known, sensed), mm)| cell_of(*known, *sensed, *mm, inscribed_mm))
            .collect();
        for (index, old) in self.tiles.iter_mut().enumerate() {
            let mut tile = *old;
            tile.fill_from(geometry, &cells);
            if tile != *old && !self.unsent.contains(&index) {
                self.unsent.push(index);
            }
            *old = tile;
        }
        let output = self.send(shell, &draft);
        shell.finish(&draft, output, work);
    }

    /// When scans have stopped coming, one more revision marks the map as not current.
    fn send_stale(&mut self, shell: &mut Shell) {
        let newest = self.scan.received().unwrap_or_default();
        let silent = !shell.roster().lockstep()
            && shell.woken_ns().saturating_sub(newest.came_ns) > STALE_NS;
        shell.reason(REASON_SCAN, silent);
        if silent && self.current && newest.tick > 0 {
            self.current = false;
            let due = Due {
                tick: newest.tick,
                kind: SpanKind::Extra,
            };
            let parents = Parents::default();
            let draft = shell.begin(due, newest.run_ns, newest.capture_ns, parents);
            let sent = self.send(shell, &draft);
            shell.finish(&draft, sent, 0);
        }
    }

    fn info(&self, revision: Id, n_tiles: usize) -> MapInfo {
        MapInfo {
            geometry: self.map.geometry,
            revision: revision.0,
            parts: 1,
            n_tiles: u32::try_from(n_tiles).unwrap_or(u32::MAX),
            clearance_limit_mm: u32::from(LIMIT_MM),
            current: u32::from(self.current),
            ..MapInfo::default()
        }
    }

    /// Sends the unsent tiles as one revision, at least one message, in as many parts as it takes.
    /// What could not be sent for lack of memory is part of the next revision.
    fn send(&mut self, shell: &mut Shell, draft: &Draft) -> Option<Sent> {
        let parts = self.unsent.len().div_ceil(TILES_PER_UPDATE_MAX).max(1);
        let revision = Id(self.update.next_id().0 + parts as u64 - 1);
        let mut sent = None;
        for part in 0..parts {
            let indices = self.unsent.iter().skip(part * TILES_PER_UPDATE_MAX);
            let indices = indices.take(TILES_PER_UPDATE_MAX);
            let tiles: Vec<MapTile> = indices.map(|index| self.tiles[*index]).collect();
            let info = MapInfo {
                part: u16::try_from(part).unwrap_or(u16::MAX),
                parts: u16::try_from(parts).unwrap_or(u16::MAX),
                ..self.info(revision, tiles.len())
            };
            sent = shell.send(draft, &mut self.update, info, &tiles);
            sent?;
        }
        self.unsent.clear();
        self.revision = revision;
        (self.tick, self.run_ns) = (draft.tick, draft.run_ns);
        sent
    }
}

/// The map that the configuration names.
fn static_map(config: &Config) -> Result<StaticMap, StartError> {
    let unusable =
        |why: &dyn core::fmt::Display| StartError::Usage(format!("configuration: {why}"));
    if let Some(file) = &config.static_map {
        let loaded = map_file::load(file).map_err(|error| unusable(&error))?;
        return Ok(loaded.map);
    }
    let [[x0, y0], [x1, y1]] = (config.area_m).ok_or_else(|| unusable(&"area_m is missing"))?;
    let resolution_m = config.resolution_m.unwrap_or(0.05);
    let cells = |length_m: f64| whole((length_m / resolution_m - 1.0e-6).ceil());
    let geometry = GridGeometry {
        origin_x_m: x0,
        origin_y_m: y0,
        resolution_m,
        width: cells(x1 - x0),
        height: cells(y1 - y0),
    };
    geometry.check().map_err(|error| unusable(&error))?;
    Ok(StaticMap::free(geometry))
}

/// Every cell, in the order of their indices.
fn cells_of(geometry: &GridGeometry) -> impl Iterator<Item = Cell> + use<> {
    let (width, height) = geometry.size();
    (0..height).flat_map(move |y| (0..width).map(move |x| Cell::new(x, y)))
}

/// Takes in a scan: first every beam frees what it passes through, then every hit is noted.
fn sense(
    sensed: &mut [bool],
    static_mm: &[u16],
    geometry: &GridGeometry,
    map_from_laser: &Pose,
    scan: &View<'_, RobotScan>,
) {
    let hits = (scan.items.iter().enumerate()).filter(|(_, range_m)| scan.meta.is_hit(**range_m));
    let hits: Vec<(f64, f64)> = hits
        .map(|(beam, range_m)| (scan.meta.angle_of(beam), f64::from(*range_m)))
        .collect();
    let index_at = |angle_rad: f64, range_m: f64| {
        let (sin, cos) = angle_rad.sin_cos();
        let at = map_from_laser.then(&Pose::new(range_m * cos, range_m * sin, 0.0));
        geometry.index_of(geometry.cell_at(at.point())?)
    };
    let step_m = 0.5 * geometry.resolution_m;
    for (angle_rad, range_m) in &hits {
        // The cell before the hit may be part of the same thing.
        for step in 0..whole((range_m / step_m - 3.0).max(0.0)) {
            if let Some(index) = index_at(*angle_rad, f64::from(step) * step_m) {
                sensed[index] = false;
            }
        }
    }
    for (angle_rad, range_m) in hits {
        if let Some(index) = index_at(angle_rad, range_m)
            && static_mm[index] > EXPLAINED_MM
        {
            sensed[index] = true;
        }
    }
}

/// Distances from the centres of the cells around it to an obstacle's square, rounded down. [mm]
fn disc(resolution_m: f64) -> Vec<(i32, i32, u16)> {
    let reach = whole((f64::from(LIMIT_MM) / 1000.0 / resolution_m).ceil()).cast_signed();
    let side_mm = |cells: i32| (f64::from(cells.abs()) - 0.5).max(0.0) * resolution_m * 1000.0;
    (-reach..=reach)
        .flat_map(|dy| (-reach..=reach).map(move |dx| (dx, dy)))
        .map(|(dx, dy)| (dx, dy, side_mm(dx).hypot(side_mm(dy)) + 1.0e-6))
        .filter(|(.., mm)| *mm < f64::from(LIMIT_MM))
        .map(|(dx, dy, mm)| (dx, dy, u16::try_from(whole(mm)).unwrap_or(LIMIT_MM)))
        .collect()
}

fn put_obstacle(
    clearance_mm: &mut [u16],
    disc: &[(i32, i32, u16)],
    geometry: &GridGeometry,
    cell: Cell,
) {
    for (dx, dy, mm) in disc {
        if let Some(index) = geometry.index_of(Cell::new(cell.x + dx, cell.y + dy)) {
            clearance_mm[index] = clearance_mm[index].min(*mm);
        }
    }
}

/// A cell of the map. Cost falls evenly from the inscribed radius to the limit.
fn cell_of(known: Occupancy, sensed: bool, clearance_mm: u16, inscribed_mm: f64) -> MapCell {
    let limit_mm = f64::from(LIMIT_MM);
    let share = (limit_mm - f64::from(clearance_mm)) / (limit_mm - inscribed_mm);
    let unknown = known == Occupancy::Unknown && !sensed;
    let cost = if known == Occupancy::Occupied || sensed {
        COST_LETHAL
    } else if f64::from(clearance_mm) <= inscribed_mm {
        COST_INSCRIBED
    } else if unknown {
        COST_UNKNOWN
    } else {
        u8::try_from(whole(f64::from(COST_CIRCUMSCRIBED_MAX) * share))
            .unwrap_or(COST_CIRCUMSCRIBED_MAX)
    };
    MapCell {
        cost,
        flags: u8::from(known == Occupancy::Occupied) * FLAG_STATIC
            + u8::from(sensed) * FLAG_SENSED
            + u8::from(unknown) * FLAG_UNKNOWN,
        clearance_mm,
    }
}

#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "float to int saturates; callers reject what is too large"
)]
fn whole(number: f64) -> u32 {
    number as u32
}

fn main() -> ExitCode {
    zeronav_shell::run::<MinimalMapping>()
}
