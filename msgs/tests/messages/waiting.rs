//! What a reader of the map does with updates that come before the keyframe they belong to.

use zeronav_msgs::header::Id;
use zeronav_msgs::map::{MapInfo, MapTile};
use zeronav_msgs::replica::{MapReplica, Step};
use zeronav_msgs::{Cell, GridGeometry, MapCell};

type Message = (Id, MapInfo, Vec<MapTile>);

/// Writes a map of one tile; every revision changes a cell.
struct Writer {
    epoch: u32,
    count: u32,
    geometry: GridGeometry,
    cells: Vec<MapCell>,
}

impl Writer {
    /// With its first revision out.
    fn new(epoch: u32) -> Self {
        let geometry = GridGeometry {
            origin_x_m: 0.0,
            origin_y_m: 0.0,
            resolution_m: 0.05,
            width: 32,
            height: 32,
        };
        let cells = vec![MapCell::unknown(500); geometry.len()];
        let mut writer = Self {
            epoch,
            count: 0,
            geometry,
            cells,
        };
        writer.revise();
        writer
    }

    /// The update of the next revision.
    fn revise(&mut self) -> Message {
        self.count += 1;
        let x = i32::try_from(self.count).expect("few revisions");
        let index = self.geometry.index_of(Cell::new(x, 0)).expect("inside");
        self.cells[index] = MapCell {
            cost: 7,
            flags: 0,
            clearance_mm: 100,
        };
        self.whole()
    }

    /// The newest revision: of a map of one tile, update and keyframe are alike.
    fn whole(&self) -> Message {
        let mut tile = MapTile::default();
        tile.fill_from(&self.geometry, &self.cells);
        let id = Id::new(self.epoch, u64::from(self.count));
        let info = MapInfo {
            geometry: self.geometry,
            revision: id.0,
            parts: 1,
            n_tiles: 1,
            ..MapInfo::default()
        };
        (id, info, vec![tile])
    }
}

#[track_caller]
fn keep(replica: &mut MapReplica, (id, info, tiles): &Message) {
    assert_eq!(replica.update(*id, info, tiles), Step::Kept);
}

#[track_caller]
fn apply(replica: &mut MapReplica, (_, info, tiles): &Message) {
    assert_eq!(replica.keyframe(info, tiles), Step::Applied);
}

/// The replica shows this revision of the writer's map.
#[track_caller]
fn assert_shows(replica: &MapReplica, (id, info, tiles): &Message) {
    assert_eq!(replica.revision(), *id);
    let view = replica.view().expect("a map");
    assert_eq!(*view.geometry, info.geometry);
    let mut shown = MapTile::default();
    shown.fill_from(view.geometry, view.cells);
    assert_eq!(shown.cells, tiles[0].cells);
}

#[test]
fn all_updates_that_waited_count_with_the_keyframe() {
    let mut writer = Writer::new(1);
    let mut replica = MapReplica::new();
    let keyframe = writer.whole();
    let updates: Vec<Message> = (0..3).map(|_| writer.revise()).collect();
    for update in &updates {
        keep(&mut replica, update);
    }
    apply(&mut replica, &keyframe);
    assert_shows(&replica, &updates[2]);
    assert!(!replica.needs_keyframe());
}

#[test]
fn updates_behind_a_lost_one_wait_for_the_next_keyframe() {
    let mut writer = Writer::new(1);
    let mut replica = MapReplica::new();
    let early = writer.whole();
    let lost = writer.revise();
    let updates = [writer.revise(), writer.revise()];
    for update in &updates {
        keep(&mut replica, update);
    }
    apply(&mut replica, &early);
    assert_shows(&replica, &early);
    assert!(replica.needs_keyframe());
    // The keyframe of the lost revision closes the gap.
    apply(&mut replica, &lost);
    assert_shows(&replica, &updates[1]);
    assert!(!replica.needs_keyframe());
}

#[test]
fn an_update_of_a_map_elsewhere_waits_for_the_keyframe_of_that_place() {
    let mut writer = Writer::new(1);
    let mut replica = MapReplica::new();
    let before = writer.whole();
    writer.geometry.origin_x_m = 1.6;
    let moved = writer.revise();
    keep(&mut replica, &moved);
    apply(&mut replica, &before);
    assert_shows(&replica, &before);
    assert!(replica.needs_keyframe());
    apply(&mut replica, &moved);
    assert_shows(&replica, &moved);
    assert!(!replica.needs_keyframe());
}

/// Ids of the process that is obeyed after a rollback are lower than those that waited.
#[test]
fn updates_of_a_writer_that_is_no_longer_obeyed_do_not_hold_up_those_of_the_other() {
    let (mut old, mut new) = (Writer::new(1), Writer::new(2));
    let mut replica = MapReplica::new();
    for _ in 0..2 {
        keep(&mut replica, &new.revise());
    }
    let keyframe = old.whole();
    let updates = [old.revise(), old.revise()];
    for update in &updates {
        keep(&mut replica, update);
    }
    apply(&mut replica, &keyframe);
    assert_shows(&replica, &updates[1]);
    assert!(!replica.needs_keyframe());
}
