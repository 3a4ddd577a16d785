//! The map against brute force: whatever scans come, every cell and every dirty tile is right.

use crate::support::{Rng, Room, config, description};
use proptest::prelude::*;
use zeronav_casts::Cast;
use zeronav_mapping::{Mapper, MappingConfig, TileIndex, all_tiles};
use zeronav_msgs::Cell;
use zeronav_msgs::map::{
    COST_INSCRIBED, COST_LETHAL, COST_UNKNOWN, FLAG_SENSED, FLAG_STATIC, FLAG_UNKNOWN, MapTile,
};

/// Every cell of the map, computed plainly from the flags of all cells.
fn check_against_brute_force(mapper: &Mapper) {
    let config = MappingConfig::default();
    let geometry = mapper.geometry();
    let (width, height) = geometry.size();
    let all = || (0..height).flat_map(move |y| (0..width).map(move |x| Cell::new(x, y)));
    let obstacles: Vec<Cell> = all()
        .filter(|c| mapper.view().get(*c).unwrap().flags & (FLAG_STATIC | FLAG_SENSED) != 0)
        .collect();
    for at in all() {
        let gap = |a: i32, b: i32| (f64::from((a - b).abs()) - 0.5).max(0.0);
        let clearance_m = obstacles
            .iter()
            .map(|o| gap(o.x, at.x).hypot(gap(o.y, at.y)) * geometry.resolution_m)
            .fold(f64::INFINITY, f64::min);
        let value = mapper.view().get(at).unwrap();
        let exact_mm = (clearance_m * 1000.0).min(config.clearance_limit_m * 1000.0);
        let below_mm = exact_mm - f64::from(value.clearance_mm);
        assert!(
            (-1e-5..1.0).contains(&below_mm),
            "{at:?}: {exact_mm} {value:?}"
        );
        let unknown = value.flags & FLAG_UNKNOWN != 0;
        let spare_m = clearance_m - 0.2 - config.padding_m;
        let cost = if obstacles.contains(&at) {
            COST_LETHAL
        } else if clearance_m <= 0.2 + 1e-9 || spare_m < -1e-9 {
            COST_INSCRIBED
        } else if unknown {
            COST_UNKNOWN
        } else if clearance_m <= config.inflation_radius_m + 1e-9 {
            (252.0 * (-4.0 * spare_m).exp()).to_u8()
        } else {
            0
        };
        assert_eq!(value.cost, cost, "{at:?}: {clearance_m}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// Things come and go at random, the robot moves at random; the map is always what brute force
    /// makes of its own obstacles, and dirty tiles are exactly those that differ.
    #[test]
    fn the_map_is_exact_and_the_tiles_are_right(
        width in 20_u32..100, height in 20_u32..80, seed: u64, mapped: bool,
    ) {
        let mut rng = Rng(seed);
        let mut room = Room::walled(width, height, 2);
        room.n_beams = 180;
        let mut mapper = { let known = mapped.then(|| room.as_static_map()); Mapper::new(&config(&room), known.as_ref(), &description()).unwrap() };
        let mut tiles = Vec::new();
        mapper.take_dirty_tiles(&mut tiles);
        prop_assert!(tiles.is_empty());
        for _ in 0..6 {
            let (x, y) = (rng.below(width.cast_signed()), rng.below(height.cast_signed()));
            let (w, h) = (1 + rng.below(8), 1 + rng.below(8));
            room.fill(x, y, x + w, y + h, rng.below(3) > 0);
            let from = room.pose(
                f64::from(width) * (0.2 + 0.006 * f64::from(rng.below(100))),
                f64::from(height) * (0.2 + 0.006 * f64::from(rng.below(100))),
                f64::from(rng.below(60)) / 10.0 - 3.0,
            );
            let before = mapper.cells().to_vec();
            let (scan, ranges) = room.scan(&from);
            mapper.integrate(&from, &scan, &ranges);
            check_against_brute_force(&mapper);
            tiles.clear();
            mapper.take_dirty_tiles(&mut tiles);
            let differs = |tile: &TileIndex| {
                let (mut old, mut new) = (MapTile::default(), MapTile::default());
                tile.name(&mut old);
                old.fill_from(mapper.geometry(), &before);
                mapper.fill_tile(*tile, &mut new);
                old != new
            };
            let expected: Vec<TileIndex> = all_tiles(mapper.geometry()).filter(differs).collect();
            prop_assert_eq!(&tiles, &expected);
        }
    }
}
