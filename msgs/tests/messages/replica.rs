//! A reader's map ends up equal to the writer's, whatever it missed.

use proptest::prelude::*;
use zeronav_msgs::header::Id;
use zeronav_msgs::map::{CostModel, MapInfo, MapTile, tiles_of};
use zeronav_msgs::obstacles::Obstacle;
use zeronav_msgs::replica::{MapReplica, PENDING_MAX, Step};
use zeronav_msgs::{Cell, GridGeometry, MapCell};

const GEOMETRY: GridGeometry = GridGeometry {
    origin_x_m: 0.0,
    origin_y_m: 0.0,
    resolution_m: 0.05,
    width: 100,
    height: 70,
};

/// A writer's side of the map: edits, updates and keyframes.
struct Writer {
    epoch: u32,
    count: u64,
    cells: Vec<MapCell>,
}

type Update = (Id, MapInfo, Vec<MapTile>);

impl Writer {
    fn new(epoch: u32) -> Self {
        Self {
            epoch,
            count: 0,
            cells: vec![MapCell::unknown(500); GEOMETRY.len()],
        }
    }

    fn info(&self, n_tiles: usize) -> MapInfo {
        MapInfo {
            geometry: GEOMETRY,
            revision: Id::new(self.epoch, self.count).0,
            parts: 1,
            n_tiles: u32::try_from(n_tiles).expect("few tiles"),
            clearance_limit_mm: 1000,
            current: 1,
            ..MapInfo::default()
        }
    }

    fn tile(&self, tile_x: u32, tile_y: u32) -> MapTile {
        let mut tile = MapTile {
            tile_x,
            tile_y,
            ..MapTile::default()
        };
        tile.fill_from(&GEOMETRY, &self.cells);
        tile
    }

    /// Sets one cell and gives the update for it.
    fn set(&mut self, x: u32, y: u32, cost: u8) -> Update {
        let cell = Cell::new(x.cast_signed(), y.cast_signed());
        let index = GEOMETRY.index_of(cell).expect("inside");
        self.cells[index] = MapCell {
            cost,
            flags: 2,
            clearance_mm: u16::from(cost),
        };
        self.count += 1;
        let tiles = vec![self.tile(x / 32, y / 32)];
        (Id::new(self.epoch, self.count), self.info(1), tiles)
    }

    fn keyframe(&self) -> (MapInfo, Vec<MapTile>) {
        let (columns, rows) = tiles_of(&GEOMETRY);
        let tiles: Vec<MapTile> = (0..rows)
            .flat_map(|y| (0..columns).map(move |x| (x, y)))
            .map(|(x, y)| self.tile(x, y))
            .collect();
        (self.info(tiles.len()), tiles)
    }
}

fn assert_equal(replica: &MapReplica, writer: &Writer) {
    let view = replica.view().expect("a map");
    assert_eq!(view.cells, writer.cells, "the copies differ");
    assert_eq!(replica.revision(), Id::new(writer.epoch, writer.count));
    assert!(!replica.needs_keyframe());
}

fn started() -> (Writer, MapReplica) {
    let mut writer = Writer::new(1);
    let mut replica = MapReplica::new();
    let first = writer.set(0, 0, 1);
    assert_eq!(replica.update(first.0, &first.1, &first.2), Step::Kept);
    let (info, tiles) = writer.keyframe();
    assert_eq!(replica.keyframe(&info, &tiles), Step::Applied);
    assert_equal(&replica, &writer);
    (writer, replica)
}

#[test]
fn a_reader_that_slept_through_a_hundred_updates_is_equal_again() {
    let (mut writer, mut replica) = started();
    let mut queue: Vec<Update> = (0..100).map(|n| writer.set(n, n % 70, 200)).collect();
    // The queue of a stream keeps the last 32.
    for (id, info, tiles) in queue.drain(68..) {
        assert_eq!(replica.update(id, &info, &tiles), Step::Kept);
    }
    assert!(replica.needs_keyframe());
    assert_eq!(replica.gaps(), 1);
    let (info, tiles) = writer.keyframe();
    let late = writer.set(7, 7, 77);
    replica.update(late.0, &late.1, &late.2);
    assert_eq!(replica.keyframe(&info, &tiles), Step::Applied);
    assert_equal(&replica, &writer);
}

#[test]
fn another_writer_is_followed_and_so_is_the_one_before_after_a_rollback() {
    let (mut old, mut replica) = started();
    let mut new = Writer::new(2);
    let first = new.set(3, 3, 33);
    assert_eq!(replica.update(first.0, &first.1, &first.2), Step::Kept);
    assert!(replica.needs_keyframe());
    let (info, tiles) = new.keyframe();
    assert_eq!(replica.keyframe(&info, &tiles), Step::Applied);
    assert_equal(&replica, &new);
    // Which of the two is obeyed is the reader's business; its ids are lower.
    let back = old.set(9, 9, 99);
    assert_eq!(replica.update(back.0, &back.1, &back.2), Step::Kept);
    assert!(replica.needs_keyframe());
    let (info, tiles) = old.keyframe();
    assert_eq!(replica.keyframe(&info, &tiles), Step::Applied);
    assert_equal(&replica, &old);
}

#[test]
fn a_restarted_writer_is_followed_from_its_first_keyframe_on() {
    let (_, mut replica) = started();
    let mut new = Writer::new(2);
    new.set(3, 3, 33);
    let (info, tiles) = new.keyframe();
    // Its updates may be a long time coming: nothing changes.
    replica.take_changed();
    assert_eq!(replica.keyframe(&info, &tiles), Step::Applied);
    assert_equal(&replica, &new);
    // Any of its cells may be another one now.
    let all = replica.take_changed();
    assert_eq!(all.len(), 1);
    assert_eq!(
        (all[0].min, all[0].max),
        (Cell::new(0, 0), Cell::new(100, 70))
    );
    // Another one of the same says nothing new.
    assert_eq!(replica.keyframe(&info, &tiles), Step::Ignored);
    let (id, info, tiles) = new.set(4, 4, 44);
    assert_eq!(replica.update(id, &info, &tiles), Step::Applied);
    assert_equal(&replica, &new);
}

#[test]
fn a_replica_that_forgot_its_step_regains_it_with_the_revision_that_it_has() {
    let (writer, mut replica) = started();
    replica.resync();
    assert!(replica.needs_keyframe());
    let (info, tiles) = writer.keyframe();
    assert_eq!(replica.keyframe(&info, &tiles), Step::Applied);
    assert_equal(&replica, &writer);
}

/// The same map with its origin elsewhere, as a rolling window sends it.
fn elsewhere(mut info: MapInfo, origin_x_m: f64) -> MapInfo {
    info.geometry.origin_x_m = origin_x_m;
    info
}

#[test]
fn a_map_that_moves_is_followed_whatever_comes_first() {
    for keyframe_first in [true, false] {
        let (mut writer, mut replica) = started();
        let (stale, stale_tiles) = writer.keyframe();
        let (id, info, _) = writer.set(5, 5, 55);
        let moving = MapInfo {
            n_tiles: 0,
            ..elsewhere(info, 1.6)
        };
        let (whole, tiles) = writer.keyframe();
        let whole = elsewhere(whole, 1.6);
        if keyframe_first {
            assert_eq!(replica.keyframe(&whole, &tiles), Step::Applied);
            assert_eq!(replica.update(id, &moving, &[]), Step::Ignored);
        } else {
            assert_eq!(replica.update(id, &moving, &[]), Step::Kept);
            assert!(replica.needs_keyframe());
            assert_eq!(replica.keyframe(&whole, &tiles), Step::Applied);
        }
        assert_equal(&replica, &writer);
        assert_eq!(replica.info().geometry, whole.geometry);
        assert_eq!(replica.gaps(), u64::from(!keyframe_first));
        // One from before the move does not bring the old place back.
        assert_eq!(replica.keyframe(&stale, &stale_tiles), Step::Ignored);
        let (id, info, tiles) = writer.set(6, 6, 66);
        let step = replica.update(id, &elsewhere(info, 1.6), &tiles);
        assert_eq!(step, Step::Applied);
        assert_equal(&replica, &writer);
    }
}

#[test]
fn a_revision_in_parts_counts_when_the_last_part_is_in() {
    let (mut writer, mut replica) = started();
    let before = replica.view().expect("a map").cells.to_vec();
    let (a, mut a_info, a_tiles) = writer.set(1, 1, 11);
    let (b, mut b_info, b_tiles) = writer.set(99, 69, 12);
    (a_info.parts, b_info.parts, b_info.part) = (2, 2, 1);
    assert_eq!(replica.update(a, &a_info, &a_tiles), Step::Kept);
    assert_eq!(
        replica.view().expect("a map").cells,
        before,
        "half a revision is shown"
    );
    assert_eq!(replica.update(b, &b_info, &b_tiles), Step::Applied);
    assert_equal(&replica, &writer);
}

#[test]
fn waiting_is_bounded_and_a_keyframe_with_missing_tiles_is_no_keyframe() {
    let mut writer = Writer::new(1);
    let mut replica = MapReplica::new();
    for n in 0..3 * PENDING_MAX {
        let (id, info, tiles) = writer.set(u32::try_from(n % 90).expect("small"), 5, 9);
        replica.update(id, &info, &tiles);
    }
    let (mut info, mut tiles) = writer.keyframe();
    tiles.pop();
    info.n_tiles -= 1;
    assert_eq!(replica.keyframe(&info, &tiles), Step::Ignored);
    let (info, tiles) = writer.keyframe();
    assert_eq!(replica.keyframe(&info, &tiles), Step::Applied);
    assert_equal(&replica, &writer);
}

proptest! {
    /// Any losses, any keyframes in between: after one more keyframe the copies are equal, and at
    /// no time does the replica show anything but a revision that the writer had.
    #[test]
    fn equal_after_any_losses(
        events in prop::collection::vec((0_u32..100, 0_u32..70, 0_u8..=255, 0_u8..10), 1..300),
    ) {
        let mut writer = Writer::new(1);
        let mut replica = MapReplica::new();
        let mut past: Vec<Vec<MapCell>> = vec![writer.cells.clone()];
        for (x, y, cost, fate) in events {
            let (id, info, tiles) = writer.set(x, y, cost);
            past.push(writer.cells.clone());
            if fate > 0 {
                replica.update(id, &info, &tiles);
            }
            if fate == 9 && replica.needs_keyframe() {
                let (info, tiles) = writer.keyframe();
                replica.keyframe(&info, &tiles);
            }
            if let Some(view) = replica.view() {
                let count = usize::try_from(replica.revision().count()).expect("small");
                prop_assert_eq!(view.cells, past[count].as_slice());
            }
        }
        if replica.needs_keyframe() {
            let (info, tiles) = writer.keyframe();
            prop_assert_eq!(replica.keyframe(&info, &tiles), Step::Applied);
        }
        // The last update may have been lost without a successor that tells; one more does.
        let (id, info, tiles) = writer.set(1, 1, 1);
        replica.update(id, &info, &tiles);
        if replica.needs_keyframe() {
            let (info, tiles) = writer.keyframe();
            replica.keyframe(&info, &tiles);
        }
        prop_assert_eq!(replica.view().expect("a map").cells, writer.cells.as_slice());
    }
}

/// A cost model whose costs fall over 0.4 m.
const MODEL: CostModel = CostModel {
    inscribed_radius_m: 0.2,
    padding_m: 0.0,
    inflation_radius_m: 0.6,
    scaling_per_m: 4.0,
};

fn disc(x_m: f64, y_m: f64, radius_m: f64) -> Obstacle {
    Obstacle {
        x_m,
        y_m,
        radius_m,
        ..Obstacle::default()
    }
}

#[test]
fn only_cells_that_became_others_are_announced() {
    let (mut writer, mut replica) = started();
    replica.take_changed();
    // The first lies in a tile that the map's edge cuts; the second time it is as it was.
    for (x, y, expected) in [
        (97, 66, Some((97, 66))),
        (97, 66, None),
        (0, 31, Some((0, 31))),
    ] {
        let (id, info, tiles) = writer.set(x, y, 11);
        assert_eq!(replica.update(id, &info, &tiles), Step::Applied);
        let changed = replica.take_changed();
        let found = changed.first().map(|rect| (rect.min, rect.max));
        let one = expected.map(|(x, y)| (Cell::new(x, y), Cell::new(x + 1, y + 1)));
        assert_eq!((found, changed.len()), (one, usize::from(one.is_some())));
    }
    // Two cells of a tile: the rectangle around both.
    writer.cells[GEOMETRY.index_of(Cell::new(40, 33)).expect("inside")].cost = 12;
    let (id, info, tiles) = writer.set(35, 50, 12);
    assert_eq!(replica.update(id, &info, &tiles), Step::Applied);
    let changed = replica.take_changed();
    assert_eq!(changed.len(), 1);
    let expected = (Cell::new(35, 33), Cell::new(41, 51));
    assert_eq!((changed[0].min, changed[0].max), expected);
}

#[test]
fn stamped_discs_block_by_the_cost_model_and_leave_no_trace() {
    let (mut writer, mut replica) = started();
    writer.cells.fill(MapCell {
        clearance_mm: 1000,
        ..MapCell::default()
    });
    writer.epoch = 2;
    let _ = writer.set(20, 20, 7);
    writer.cells[GEOMETRY.index_of(Cell::new(70, 30)).expect("inside")] = MapCell::unknown(1000);
    writer.cells[GEOMETRY.index_of(Cell::new(62, 30)).expect("inside")] = MapCell::unknown(1000);
    writer.cells[GEOMETRY.index_of(Cell::new(65, 30)).expect("inside")] = MapCell::unknown(1000);
    let (mut info, tiles) = writer.keyframe();
    info.cost_model = MODEL;
    assert_eq!(replica.keyframe(&info, &tiles), Step::Applied);
    replica.take_changed();

    // Centre of cell (60, 30).
    replica.stamp(&[disc(3.025, 1.525, 0.1)]);
    let cell = |replica: &MapReplica, x| {
        replica
            .view()
            .expect("a map")
            .get(Cell::new(x, 30))
            .expect("inside")
    };
    let values = |cell: MapCell| (cell.cost, cell.clearance_mm);
    assert_eq!(values(cell(&replica, 60)), (254, 0));
    assert_eq!(values(cell(&replica, 58)), (254, 0));
    assert_eq!(values(cell(&replica, 57)), (253, 50));
    // 0.3 m: 252 exp(-0.4) = 168.9.
    assert_eq!(values(cell(&replica, 52)), (168, 300));
    assert_eq!(values(cell(&replica, 45)), (0, 650));
    // 0.15 m: within the inscribed radius nothing is left unknown.
    assert_eq!(values(cell(&replica, 65)), (253, 150));
    // Unknown cells stay unknown unless they are blocked.
    assert_eq!(values(cell(&replica, 62)), (254, 0));
    assert_eq!(values(cell(&replica, 70)), (255, 400));
    // As far as it reaches: 1.1 m around it, 1.0 m of that by the limit of the clearance.
    let changed = replica.take_changed();
    let reached: Vec<_> = changed.iter().map(|rect| (rect.min, rect.max)).collect();
    assert_eq!(reached, [(Cell::new(38, 8), Cell::new(83, 53))]);

    // The same disc elsewhere: nothing is left of where it was.
    replica.stamp(&[disc(1.025, 1.525, 0.1), disc(1.1, 1.6, 0.01)]);
    assert_eq!(values(cell(&replica, 60)), (0, 1000));
    assert_eq!(values(cell(&replica, 20)), (254, 0));
    assert_eq!(replica.take_changed().len(), 3);
    replica.stamp(&[]);
    assert_equal(&replica, &writer);
}

proptest! {
    /// Whatever is stamped between updates, cells are those of the writer when it is lifted, every
    /// cell that differs from before was announced, and stamping never makes a cell safer.
    #[test]
    fn stamps_are_lifted_by_the_next_revision(
        edits in prop::collection::vec((0_u32..100, 0_u32..70, 0_u8..=254), 1..20),
        discs in prop::collection::vec((-1.0..6.0, -1.0..4.5, 0.0..1.0), 0..6),
    ) {
        let (mut writer, mut replica) = started();
        let discs: Vec<Obstacle> = discs.iter().map(|(x, y, r)| disc(*x, *y, *r)).collect();
        for (n, (x, y, cost)) in edits.into_iter().enumerate() {
            let before = replica.view().expect("a map").cells.to_vec();
            let (id, mut info, tiles) = writer.set(x, y, cost);
            info.cost_model = MODEL;
            prop_assert_eq!(replica.update(id, &info, &tiles), Step::Applied);
            prop_assert_eq!(replica.view().expect("a map").cells, &writer.cells[..]);
            replica.stamp(&discs[n % (discs.len() + 1)..]);
            let changed = replica.take_changed();
            let cells = replica.view().expect("a map").cells;
            for (index, (cell, own)) in cells.iter().zip(&writer.cells).enumerate() {
                let at = Cell::new(
                    i32::try_from(index % 100).expect("small"),
                    i32::try_from(index / 100).expect("small"),
                );
                prop_assert!(cell.clearance_mm <= own.clearance_mm);
                prop_assert!(cell.cost >= own.cost || own.cost == 255);
                let announced = changed.iter().any(|rect| rect.contains(at));
                prop_assert!(announced || *cell == before[index], "{:?}", at);
            }
        }
    }
}

/// A writer that repeats a part, or whose revision holds more tiles than the map, is not followed
/// until its next keyframe: otherwise it could fill the memory of its readers.
#[test]
fn parts_out_of_order_or_without_end_are_not_collected() {
    let repeated: &[u16] = &[0, 1, 1];
    // The map has 4 x 3 tiles.
    let endless: Vec<u16> = (0..13).collect();
    for parts in [repeated, &endless] {
        let (mut writer, mut replica) = started();
        for (n, part) in parts.iter().enumerate() {
            let (id, info, tiles) = writer.set(1, 1, 9);
            let info = MapInfo {
                part: *part,
                parts: 100,
                ..info
            };
            let expected = if n + 1 == parts.len() {
                Step::Ignored
            } else {
                Step::Kept
            };
            assert_eq!(replica.update(id, &info, &tiles), expected, "part {n}");
        }
        assert!(replica.needs_keyframe());
        assert_eq!(replica.gaps(), 1);
        let (info, tiles) = writer.keyframe();
        assert_eq!(replica.keyframe(&info, &tiles), Step::Applied);
        assert_equal(&replica, &writer);
    }
}

#[test]
fn tiles_out_of_place_are_no_keyframe() {
    let (writer, _) = started();
    let (info, right) = writer.keyframe();
    let (columns, rows) = (4, 3);
    assert_eq!(right.len(), columns * rows);
    assert_eq!(MapReplica::new().keyframe(&info, &right), Step::Applied);
    for (a, b) in [(0, 1), (0, columns), (columns - 1, columns)] {
        let mut tiles = right.clone();
        tiles.swap(a, b);
        let mut replica = MapReplica::new();
        assert_eq!(
            replica.keyframe(&info, &tiles),
            Step::Ignored,
            "{a} and {b}"
        );
        assert!(replica.view().is_none());
    }
    // The one in place of the other, once in each direction alone.
    for (tile_x, tile_y) in [(1, 0), (0, 1)] {
        let mut tiles = right.clone();
        (tiles[0].tile_x, tiles[0].tile_y) = (tile_x, tile_y);
        assert_eq!(MapReplica::new().keyframe(&info, &tiles), Step::Ignored);
    }
}

/// Cells that a keyframe has replaced are not put back over it.
#[test]
fn a_keyframe_forgets_what_was_stamped() {
    let (mut writer, mut replica) = started();
    replica.stamp(&[disc(2.0, 1.5, 0.2)]);
    writer.epoch = 2;
    let _ = writer.set(40, 30, 9);
    let (info, tiles) = writer.keyframe();
    assert_eq!(replica.keyframe(&info, &tiles), Step::Applied);
    replica.stamp(&[]);
    assert_equal(&replica, &writer);
    assert_eq!(replica.take_changed().len(), 1, "all of the map, once");
}
