//! Mapping as a process: answers every scan with the tiles that changed.

use std::process::ExitCode;
use zeronav_mapping::{Mapper, MappingConfig, TileIndex, all_tiles};
use zeronav_msgs::grid::GridGeometry;
use zeronav_msgs::header::{Id, Parents};
use zeronav_msgs::health::{REASON_ODOMETRY, REASON_SCAN};
use zeronav_msgs::map::{MapInfo, TILES_PER_UPDATE_MAX, tiles_of};
use zeronav_msgs::pose::Pose;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::SpanKind;
use zeronav_msgs::topics::{
    EVENT_NEED_KEYFRAME, MapKeyframe, MapUpdate, RobotDescription, RobotOdometry, RobotScan,
};
use zeronav_shell::clock::now_ns;
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{
    Cycle, Draft, Latest, Sent, Service, Shell, StartError, Stream, Track, Writer,
};
use zeronav_world::StaticMap;

/// Least time between two keyframes. [ns]
const KEYFRAME_PAUSE_NS: u64 = 50_000_000;

/// Age of the newest scan from which the map is not current. [ns]
const STALE_NS: u64 = 500_000_000;

struct MappingService {
    config: MappingConfig,
    static_map: Option<StaticMap>,
    geometry: GridGeometry,
    mapper: Option<Mapper>,
    description: Latest<RobotDescription>,
    odometry: Stream<RobotOdometry>,
    scan: Latest<RobotScan>,
    update: Writer<MapUpdate>,
    keyframe: Writer<MapKeyframe>,
    track: Track,
    /// Tiles that changed and are not out yet.
    tiles: Vec<TileIndex>,
    /// Revision that readers can have.
    revision: Id,
    answered_tick: u64,
    keyframe_wanted: bool,
    keyframe_ns: u64,
    scan_came_ns: u64,
}

impl Service for MappingService {
    const ROLE: Role = Role::Mapping;
    type Config = MappingConfig;

    fn open(shell: &mut Shell, config: MappingConfig) -> Result<Self, StartError> {
        let unusable =
            |error: &dyn core::fmt::Display| StartError::Usage(format!("configuration: {error}"));
        let static_map = match &config.static_map {
            Some(file) => {
                let loaded =
                    zeronav_world::map_file::load(file).map_err(|error| unusable(&error))?;
                for warning in &loaded.warnings {
                    tracing::warn!("{warning}");
                }
                Some(loaded.map)
            }
            None => None,
        };
        let geometry = match &static_map {
            Some(map) => map.geometry,
            None => config.geometry().map_err(|error| unusable(&error))?,
        };
        let (columns, rows) = tiles_of(&geometry);
        let peer = shell.peer();
        Ok(Self {
            config,
            static_map,
            geometry,
            mapper: None,
            description: peer.latest()?,
            odometry: peer.stream()?,
            scan: peer.latest()?,
            update: peer.writer(TILES_PER_UPDATE_MAX)?,
            keyframe: peer.writer(columns as usize * rows as usize)?,
            track: Track::default(),
            tiles: Vec::with_capacity(columns as usize * rows as usize),
            revision: Id::NONE,
            answered_tick: 0,
            keyframe_wanted: false,
            keyframe_ns: 0,
            scan_came_ns: 0,
        })
    }

    fn wake(&mut self, shell: &mut Shell, rung: Rung) -> Result<Option<u64>, StartError> {
        self.keyframe.refresh();
        let roster = shell.roster();
        self.description.poll(roster);
        // Odometry first: it is sent after the scan of its tick, so that the scan is there, too.
        let track = &mut self.track;
        self.odometry
            .drain(roster, |view| track.push(view.header, view.meta));
        if self.scan.poll(roster) {
            self.scan_came_ns = shell.woken_ns();
        }
        shell.totals(
            self.odometry.refused() + self.scan.refused() + self.description.refused(),
            self.scan.superseded(),
        );
        if !shell.roster().has_clock() || !self.start(shell)? {
            return Ok(None);
        }
        let tick = self.scan.tick();
        if tick > self.answered_tick {
            // Until the odometry around the capture is there, too.
            if let Some(odom_from_base) = self.pose_of_scan() {
                self.answer(shell, &odom_from_base);
            }
        }
        let silent = shell.woken_ns().saturating_sub(self.scan_came_ns) > STALE_NS;
        shell.reason(REASON_SCAN, silent && !shell.roster().lockstep());
        shell.reason(REASON_ODOMETRY, tick > self.answered_tick);
        self.keyframe_wanted |= rung.has(EVENT_NEED_KEYFRAME);
        self.send_keyframe_if_due(shell);
        Ok(None)
    }
}

impl MappingService {
    /// Makes the map once the robot is known; true when there is one.
    fn start(&mut self, shell: &mut Shell) -> Result<bool, StartError> {
        if self.mapper.is_some() {
            return Ok(true);
        }
        let Some(description) = self.description.get() else {
            return Ok(false);
        };
        let mapper = Mapper::new(
            &self.config,
            self.static_map.take().as_ref(),
            description.meta,
        )
        .map_err(|error| StartError::Usage(format!("configuration: {error}")))?;
        self.mapper = Some(mapper);
        // The first revision is the static map: an empty update, and a keyframe that holds it.
        let draft = shell.draft(0, 0, 0, Parents::default());
        let output = self.send_updates(shell, &draft);
        self.keyframe_wanted = true;
        self.send_keyframe_if_due(shell);
        shell.finish(&Cycle {
            kind: SpanKind::Idle,
            draft,
            output,
            work: 0,
        });
        shell.ready();
        Ok(true)
    }

    /// `odom_from_base` at the capture of the newest scan.
    fn pose_of_scan(&self) -> Option<Pose> {
        let scan = self.scan.get()?;
        self.track.pose_at(scan.header.run_ns)
    }

    fn answer(&mut self, shell: &mut Shell, odom_from_base: &Pose) {
        let (Some(scan), Some(description), Some(mapper)) =
            (self.scan.get(), self.description.get(), &mut self.mapper)
        else {
            return;
        };
        let header = scan.header;
        let parents = Parents {
            odometry: self.track.newest().map_or(0, |moment| moment.id.0),
            scan: header.id,
            ..Parents::default()
        };
        let tick = header.tick;
        let work = u64::from(scan.meta.n_beams);
        let draft = shell.draft(tick, header.run_ns, header.capture_ns, parents);
        let map_from_laser = odom_from_base.then(&description.meta.base_from_laser);
        mapper.integrate(&map_from_laser, scan.meta, scan.items);
        mapper.take_dirty_tiles(&mut self.tiles);
        let output = self.send_updates(shell, &draft);
        self.answered_tick = tick;
        shell.finish(&Cycle {
            kind: SpanKind::Answer,
            draft,
            output,
            work,
        });
    }

    fn info(&self, revision: Id) -> MapInfo {
        MapInfo {
            geometry: self.geometry,
            revision: revision.0,
            clearance_limit_mm: self
                .mapper
                .as_ref()
                .map_or(1, |mapper| u32::from(mapper.clearance_limit_mm())),
            parts: 1,
            current: 1,
            ..MapInfo::default()
        }
    }

    /// Sends the changed tiles as one revision, in as many parts as it takes. What could not be
    /// sent for lack of memory goes out with the next revision.
    fn send_updates(&mut self, shell: &mut Shell, draft: &Draft) -> Option<Sent> {
        let parts = self.tiles.len().div_ceil(TILES_PER_UPDATE_MAX).max(1);
        let last_id = Id(self.update.next_id().0 + parts as u64 - 1);
        let info = self.info(last_id);
        let mapper = self.mapper.as_ref()?;
        let mut sent = None;
        for part in 0..parts {
            let from = part * TILES_PER_UPDATE_MAX;
            let until = (from + TILES_PER_UPDATE_MAX).min(self.tiles.len());
            let tiles = &self.tiles[from..until];
            let published = self.update.publish_with(draft, tiles.len(), |slot| {
                for (tile, index) in slot.iter_mut().zip(tiles) {
                    mapper.fill_tile(*index, tile);
                }
                MapInfo {
                    part: u16::try_from(part).unwrap_or(u16::MAX),
                    parts: u16::try_from(parts).unwrap_or(u16::MAX),
                    n_tiles: u32::try_from(tiles.len()).unwrap_or(u32::MAX),
                    ..info
                }
            });
            sent = shell.sent(&self.update, published);
            sent?;
        }
        self.tiles.clear();
        self.revision = last_id;
        sent
    }

    fn send_keyframe_if_due(&mut self, shell: &mut Shell) {
        let now = now_ns();
        let due = self.keyframe_ns == 0 || now - self.keyframe_ns >= KEYFRAME_PAUSE_NS;
        // Tiles that wait for memory are in the map but not in the revision.
        let (Some(mapper), true, true, true) = (
            &self.mapper,
            self.keyframe_wanted,
            due,
            self.tiles.is_empty(),
        ) else {
            return;
        };
        let (columns, rows) = tiles_of(mapper.geometry());
        let info = self.info(self.revision);
        let draft = shell.draft(0, 0, 0, Parents::default());
        let n_tiles = columns * rows;
        let published = self
            .keyframe
            .publish_with(&draft, n_tiles as usize, |slot| {
                for (tile, index) in slot.iter_mut().zip(all_tiles(mapper.geometry())) {
                    mapper.fill_tile(index, tile);
                }
                MapInfo { n_tiles, ..info }
            });
        if shell.sent(&self.keyframe, published).is_some() {
            self.keyframe_wanted = false;
            self.keyframe_ns = now;
        }
    }
}

fn main() -> ExitCode {
    zeronav_shell::run::<MappingService>()
}
