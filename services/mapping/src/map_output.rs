//! How mapping publishes the map: the tiles that changed as revisions, all tiles as keyframes, and
//! what moves as tracked obstacles.

use zeronav_mapping::{Mapping, TileIndex, all_tiles};
use zeronav_msgs::header::{Id, Parents};
use zeronav_msgs::map::{MapInfo, TILES_PER_UPDATE_MAX, tiles_of};
use zeronav_msgs::obstacles::{OBSTACLES_MAX, Obstacle, Obstacles};
use zeronav_msgs::topics::{MapKeyframe, MapObstacles, MapUpdate};
use zeronav_shell::clock::now_ns;
use zeronav_shell::{Draft, Due, Peer, Sent, Shell, StartError, Writer};

/// Least time between two keyframes. [ns]
const KEYFRAME_PAUSE_NS: u64 = 50_000_000;

/// Writes `map/update`, `map/keyframe` and `map/obstacles`.
pub(crate) struct MapOutput {
    /// Scans are still received.
    pub(crate) current: bool,
    update: Writer<MapUpdate>,
    keyframe: Writer<MapKeyframe>,
    tracked: Writer<MapObstacles>,
    /// Of the newest message.
    obstacles: Vec<Obstacle>,
    /// Tiles that changed and were not sent yet.
    tiles: Vec<TileIndex>,
    /// Revision that readers can have, and the tick and run time [ns] that it answers.
    revision: Id,
    tick: u64,
    run_ns: u64,
    keyframe_wanted: bool,
    /// When the last keyframe was sent; 0 = the next one is not held back.
    keyframe_ns: u64,
}

impl MapOutput {
    /// Opens the topics for a map of up to `most_tiles` tiles.
    pub(crate) fn open(peer: &Peer, most_tiles: usize) -> Result<Self, StartError> {
        Ok(Self {
            current: true,
            update: peer.writer(TILES_PER_UPDATE_MAX)?,
            keyframe: peer.writer(most_tiles)?,
            tracked: peer.writer(OBSTACLES_MAX)?,
            obstacles: Vec::with_capacity(OBSTACLES_MAX),
            tiles: Vec::with_capacity(most_tiles),
            revision: Id::NONE,
            tick: 0,
            run_ns: 0,
            keyframe_wanted: false,
            keyframe_ns: 0,
        })
    }

    /// Brings the last keyframe to readers that joined since.
    pub(crate) fn refresh(&self) {
        self.keyframe.refresh();
    }

    /// Asks for a keyframe, after the pause.
    pub(crate) fn want_keyframe(&mut self) {
        self.keyframe_wanted = true;
    }

    /// Sends the tracked obstacles; how many there are.
    pub(crate) fn send_obstacles(
        &mut self,
        shell: &mut Shell,
        draft: &Draft,
        mapping: &Mapping,
    ) -> usize {
        self.obstacles.clear();
        self.obstacles.extend(mapping.obstacles());
        let tracked = Obstacles {
            n_obstacles: self.obstacles.len() as u64,
        };
        shell.send(draft, &mut self.tracked, tracked, &self.obstacles);
        self.obstacles.len()
    }

    /// Sends the changed tiles as one revision, in as many parts as it takes. Tiles that could not
    /// be sent for lack of memory are part of the next revision.
    pub(crate) fn send(
        &mut self,
        shell: &mut Shell,
        draft: &Draft,
        mapping: &mut Mapping,
    ) -> Option<Sent> {
        mapping.mapper_mut().take_dirty_tiles(&mut self.tiles);
        self.send_revision(shell, draft, mapping)
    }

    /// Sends a map whose grid has moved: an empty revision, and at once a keyframe, without which
    /// readers have no map.
    pub(crate) fn send_moved(
        &mut self,
        shell: &mut Shell,
        draft: &Draft,
        mapping: &mut Mapping,
    ) -> Option<Sent> {
        mapping.mapper_mut().take_dirty_tiles(&mut self.tiles);
        self.tiles.clear();
        let geometry = mapping.mapper().geometry();
        let (width, height) = (geometry.width, geometry.height);
        tracing::info!(width, height, "the map moves to the robot");
        let sent = self.send_revision(shell, draft, mapping);
        self.keyframe_ns = 0;
        self.keyframe_wanted = true;
        self.send_keyframe_if_due(shell, mapping);
        sent
    }

    fn send_revision(
        &mut self,
        shell: &mut Shell,
        draft: &Draft,
        mapping: &Mapping,
    ) -> Option<Sent> {
        let mapper = mapping.mapper();
        let parts = self.tiles.len().div_ceil(TILES_PER_UPDATE_MAX).max(1);
        let last_id = Id(self.update.next_id().0 + parts as u64 - 1);
        let info = self.info(last_id, mapping);
        let mut sent = None;
        for part in 0..parts {
            let from = part * TILES_PER_UPDATE_MAX;
            let until = (from + TILES_PER_UPDATE_MAX).min(self.tiles.len());
            let tiles = &self.tiles[from..until];
            sent = shell.send_with(draft, &mut self.update, tiles.len(), |slot| {
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
            sent?;
        }
        self.tiles.clear();
        self.revision = last_id;
        (self.tick, self.run_ns) = (draft.tick, draft.run_ns);
        sent
    }

    /// Sends a keyframe when one is wanted and the pause is over.
    pub(crate) fn send_keyframe_if_due(&mut self, shell: &mut Shell, mapping: &Mapping) {
        let now = now_ns();
        let due = self.keyframe_ns == 0 || now - self.keyframe_ns >= KEYFRAME_PAUSE_NS;
        // Tiles that wait for memory are in the map but not in the revision.
        if !(self.keyframe_wanted && due && self.tiles.is_empty()) {
            return;
        }
        let mapper = mapping.mapper();
        let (columns, rows) = tiles_of(mapper.geometry());
        let info = self.info(self.revision, mapping);
        // The same map again: it does not count for the run's hash.
        let draft = Draft {
            tick: self.tick,
            run_ns: self.run_ns,
            ..shell.begin(Due::IDLE, 0, 0, Parents::default())
        };
        let n_tiles = columns * rows;
        let sent = shell.send_with(&draft, &mut self.keyframe, n_tiles as usize, |slot| {
            for (tile, index) in slot.iter_mut().zip(all_tiles(mapper.geometry())) {
                mapper.fill_tile(index, tile);
            }
            MapInfo { n_tiles, ..info }
        });
        if sent.is_some() {
            self.keyframe_wanted = false;
            self.keyframe_ns = now;
        }
    }

    fn info(&self, revision: Id, mapping: &Mapping) -> MapInfo {
        let (map_from_odom, covariance) = mapping.map_from_odom();
        MapInfo {
            geometry: *mapping.mapper().geometry(),
            revision: revision.0,
            map_from_odom,
            covariance,
            clearance_limit_mm: u32::from(mapping.mapper().clearance_limit_mm()),
            parts: 1,
            current: u32::from(self.current),
            cost_model: mapping.mapper().cost_model(),
            way_out: mapping.mapper().way_out().unwrap_or_default(),
            ..MapInfo::default()
        }
    }
}
