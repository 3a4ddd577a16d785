//! Acceptance tests of the rows that mapping owes, named by their keys.

use crate::support::{Rng, Room, config, description};
use nalgebra::Point2;
use zeronav_mapping::clearance::ClearanceField;
use zeronav_mapping::regularise::RegularisationConfig;
use zeronav_mapping::virtual_obstacles::{RingShape, VirtualConfig, VirtualKind};
use zeronav_mapping::{Mapper, MappingConfig};
use zeronav_msgs::map::{FLAG_REGULARISED, FLAG_STATIC, FLAG_VIRTUAL};
use zeronav_msgs::{Cell, GridGeometry};

fn flagged(mapper: &Mapper, flag: u8) -> Vec<(i32, i32)> {
    let (width, height) = mapper.geometry().size();
    (0..height)
        .flat_map(|y| (0..width).map(move |x| (x, y)))
        .filter(|(x, y)| mapper.view().get(Cell::new(*x, *y)).unwrap().flags & flag != 0)
        .collect()
}

fn mapper(room: &Room, change: impl FnOnce(&mut MappingConfig)) -> Mapper {
    let mut config = config(room);
    change(&mut config);
    Mapper::new(&config, Some(&room.as_static_map()), &description()).unwrap()
}

fn inside(rect: (i32, i32, i32, i32)) -> impl Fn(&(i32, i32)) -> bool {
    move |(x, y)| (rect.0..rect.2).contains(x) && (rect.1..rect.3).contains(y)
}

/// What stands at a place in metres is in the map's cell of that place, and nowhere else: places, cells and
/// indices are written down here by hand, not by the formulas of the grid. The index map of the Bao paper
/// is tested where it is used, in `tests/papers`.
#[test]
fn c_grid_a_place_in_metres_is_its_cell_of_the_map() {
    // 5 cm cells whose lower left corner is at (-3, 1.25): column, row, centre [m], index.
    for (x, y, x_m, y_m, index) in [
        (0, 0, -2.975, 1.275, 0_usize),
        (29, 0, -1.525, 1.275, 29),
        (0, 19, -2.975, 2.225, 570),
        (11, 3, -2.425, 1.425, 101),
        (29, 19, -1.525, 2.225, 599),
    ] {
        let mut room = Room::empty(30, 20);
        room.fill(x, y, x + 1, y + 1, true);
        let mapper = mapper(&room, |_| {});
        assert_eq!(flagged(&mapper, FLAG_STATIC), [(x, y)]);
        assert_eq!(mapper.view().cells[index].flags & FLAG_STATIC, FLAG_STATIC);
        let geometry = mapper.geometry();
        for (dx, dy) in [(0.0, 0.0), (-0.024, 0.024), (0.024, -0.024)] {
            let place = Point2::new(x_m + dx, y_m + dy);
            assert_eq!(geometry.cell_at(place), Some(Cell::new(x, y)), "{place}");
        }
        let centre = geometry.centre_of(Cell::new(x, y));
        assert!((centre - Point2::new(x_m, y_m)).norm() < 1e-12, "{centre}");
    }
}

/// Every cell of three grids: cell to metres and back, and an index of its own.
#[test]
fn c_grid_round_trips_of_every_cell() {
    for (width, height, resolution_m) in [(30_u32, 20_u32, 1.0), (97, 41, 0.05), (1, 64, 0.1)] {
        let geometry = GridGeometry {
            origin_x_m: -3.7,
            origin_y_m: 12.1,
            resolution_m,
            width,
            height,
        };
        let (n_x, n_y) = geometry.size();
        let mut seen = vec![false; geometry.len()];
        for cell in (0..n_y).flat_map(|y| (0..n_x).map(move |x| Cell::new(x, y))) {
            assert_eq!(geometry.cell_at(geometry.centre_of(cell)), Some(cell));
            let index = geometry.index_of(cell).unwrap();
            assert!(!seen[index], "{cell:?} twice");
            seen[index] = true;
        }
        assert!(seen.iter().all(|seen| *seen));
    }
}

/// Exact Euclidean distance to the nearest obstacle square on 100 random maps, against brute
/// force, after additions and after removals.
#[test]
fn c_edt_equals_brute_force_on_100_random_maps() {
    let mut rng = Rng(11);
    for map in 0..100 {
        let (width, height) = (5 + rng.below(40), 5 + rng.below(40));
        let geometry = GridGeometry {
            origin_x_m: 0.0,
            origin_y_m: 0.0,
            resolution_m: 0.05,
            width: width.cast_unsigned(),
            height: height.cast_unsigned(),
        };
        let limit = 2.0 + f64::from(rng.below(20));
        let mut field = ClearanceField::new(&geometry, limit);
        let mut obstacles: Vec<Cell> = Vec::new();
        for _ in 0..=rng.below(width * height / 8) {
            let cell = Cell::new(rng.below(width), rng.below(height));
            if !obstacles.contains(&cell) {
                obstacles.push(cell);
                field.set(geometry.index_of(cell).unwrap(), true);
                field.add(cell);
            }
        }
        for half in [false, true] {
            if half {
                for gone in obstacles.drain(obstacles.len() / 2..) {
                    field.set(geometry.index_of(gone).unwrap(), false);
                    let one = zeronav_msgs::CellRect {
                        min: gone,
                        max: Cell::new(gone.x + 1, gone.y + 1),
                    };
                    field.recompute(&one.grown(field.reach(), &geometry));
                }
            }
            for y in 0..height {
                for x in 0..width {
                    let gap = |a: i32, b: i32| (f64::from((a - b).abs()) - 0.5).max(0.0);
                    let exact = obstacles
                        .iter()
                        .map(|o| gap(o.x, x).hypot(gap(o.y, y)))
                        .fold(f64::INFINITY, f64::min);
                    let index = geometry.index_of(Cell::new(x, y)).unwrap();
                    let distance = f64::from(field.squares()[index]).sqrt() / 2.0;
                    if exact < limit {
                        assert!((distance - exact).abs() < 1e-9, "map {map}: ({x}, {y})");
                    } else {
                        assert!(distance >= limit - 1e-9, "map {map}: ({x}, {y})");
                    }
                }
            }
        }
    }
}

fn u_shape() -> Room {
    let mut room = Room::empty(80, 60);
    // Open towards the robot in the west: pocket of 8 x 10 cells.
    room.fill(40, 20, 50, 22, true);
    room.fill(40, 32, 50, 34, true);
    room.fill(48, 20, 50, 34, true);
    room
}

fn at(mapper: &Mapper, x: i32, y: i32) -> Point2<f64> {
    mapper.geometry().centre_of(Cell::new(x, y))
}

fn on(config: &mut MappingConfig) {
    config.regularisation = RegularisationConfig {
        enabled: true,
        ..RegularisationConfig::default()
    };
}

#[test]
fn tn_reg_a_u_on_the_line_becomes_its_rectangle() {
    let room = u_shape();
    let mut mapper = mapper(&room, on);
    let before = mapper.cells().to_vec();
    let line = (at(&mapper, 5, 27), at(&mapper, 75, 27));
    for _ in 0..2 {
        // Looking again changes nothing.
        mapper.regularise(Some(line));
        let expected: Vec<(i32, i32)> = (22..32)
            .flat_map(|y| (40..48).map(move |x| (x, y)))
            .collect();
        assert_eq!(flagged(&mapper, FLAG_REGULARISED), expected);
        assert_eq!(mapper.rectangles().len(), 1);
    }
    // Costs, clearances and the obstacles themselves stay; without a line all is as it was.
    for (new, old) in mapper.cells().iter().zip(&before) {
        assert_eq!((new.cost, new.clearance_mm), (old.cost, old.clearance_mm));
        assert_eq!(new.flags & !FLAG_REGULARISED, old.flags);
    }
    mapper.regularise(None);
    assert_eq!(mapper.cells(), before);
}

#[test]
fn tn_reg_off_the_line_and_behind_the_robot_nothing_changes() {
    let room = u_shape();
    let mut mapper = mapper(&room, on);
    let before = mapper.cells().to_vec();
    let beside = (at(&mapper, 5, 40), at(&mapper, 75, 40));
    // The line to the goal only: what lies behind the robot is not on it.
    let behind = (at(&mapper, 60, 27), at(&mapper, 75, 27));
    for line in [beside, behind] {
        mapper.regularise(Some(line));
        assert_eq!(mapper.cells(), before);
    }
}

#[test]
fn tn_reg_never_swallows_robot_or_goal_and_respects_its_limit() {
    let room = u_shape();
    for (config, from, to) in [
        // The robot in the pocket, the goal in the pocket, and a rectangle of 140 of 4800 cells
        // with a limit of one per cent.
        (0.25, (44, 27), (75, 27)),
        (0.25, (5, 27), (44, 27)),
        (0.01, (5, 27), (75, 27)),
    ] {
        let mut mapper = mapper(&room, |c| {
            on(c);
            c.regularisation.area_share_max = config;
        });
        let line = (at(&mapper, from.0, from.1), at(&mapper, to.0, to.1));
        mapper.regularise(Some(line));
        assert_eq!(flagged(&mapper, FLAG_REGULARISED), []);
    }
    // And off by configuration.
    let mut off = mapper(&room, |_| ());
    let line = (at(&off, 5, 27), at(&off, 75, 27));
    off.regularise(Some(line));
    assert_eq!(flagged(&off, FLAG_REGULARISED), []);
}

#[test]
fn tn_reg_a_diagonal_chain_is_one_group_and_a_corner_is_a_hit() {
    let mut room = Room::empty(40, 40);
    for n in 0..6 {
        room.fill(20 + n, 12 + n, 21 + n, 13 + n, true);
    }
    let mut mapper = mapper(&room, on);
    // Along the anti-diagonal, through the corner between two cells of the chain.
    let line = (at(&mapper, 14, 24), at(&mapper, 32, 6));
    mapper.regularise(Some(line));
    let rects = mapper.rectangles();
    assert_eq!(rects.len(), 1);
    assert_eq!(
        (rects[0].min, rects[0].max),
        (Cell::new(20, 12), Cell::new(26, 18))
    );
}

#[test]
fn tn_reg_groups_are_found_anew_when_obstacles_come() {
    let mut room = u_shape();
    let known = room.as_static_map();
    let mut config = config(&room);
    on(&mut config);
    config.regularisation.groups_max = 2;
    let mut mapper = Mapper::new(&config, Some(&known), &description()).unwrap();
    let line = (at(&mapper, 5, 27), at(&mapper, 75, 27));
    mapper.regularise(Some(line));
    assert_eq!(mapper.rectangles().len(), 1);
    // A box in front of the U, seen by the lidar: a second group, nearer.
    room.fill(25, 24, 28, 31, true);
    let from = room.pose(8.5, 27.5, 0.0);
    for _ in 0..3 {
        let (scan, ranges) = room.scan(&from);
        mapper.integrate(&from, &scan, &ranges);
    }
    mapper.regularise(Some(line));
    assert_eq!(mapper.rectangles().len(), 2);
    let near = mapper.rectangles()[0];
    assert!(near.min.x <= 26 && near.max.x <= 29, "{near:?}");
    // Gone again.
    room.fill(25, 24, 28, 31, false);
    for _ in 0..5 {
        let (scan, ranges) = room.scan(&from);
        mapper.integrate(&from, &scan, &ranges);
    }
    mapper.regularise(Some(line));
    assert_eq!(mapper.rectangles().len(), 1);
}

fn ring(radius_cells: i32, shape: RingShape) -> impl FnOnce(&mut MappingConfig) {
    move |config| {
        config.virtual_obstacles = VirtualConfig {
            kind: VirtualKind::Ring,
            radius_cells,
            shape,
        };
    }
}

#[test]
fn bao_full_rings_are_counted_by_hand() {
    let mut room = Room::empty(30, 30);
    room.fill(10, 10, 11, 11, true);
    room.fill(20, 5, 22, 7, true);
    for (radius, shape, expected) in [
        (1, RingShape::EightNeighbour, 8 + 12),
        (1, RingShape::FourNeighbour, 4 + 8),
        (2, RingShape::EightNeighbour, 24 + 32),
        (2, RingShape::FourNeighbour, 12 + 20),
    ] {
        let mapper = mapper(&room, ring(radius, shape));
        assert_eq!(mapper.n_virtual(), expected, "{radius} {shape:?}");
        let cells = flagged(&mapper, FLAG_VIRTUAL);
        assert_eq!(cells.len(), expected);
        let is_obstacle = |cell: &(i32, i32)| {
            mapper.view().get(Cell::new(cell.0, cell.1)).unwrap().flags & FLAG_STATIC != 0
        };
        assert!(!cells.iter().any(is_obstacle));
    }
}

#[test]
fn bao_full_closes_gaps_of_one_and_two_cells_and_no_wider_one() {
    for (gap, closed) in [(1, true), (2, true), (3, false)] {
        let mut room = Room::empty(40, 30);
        room.fill(20, 0, 21, 15, true);
        room.fill(20, 15 + gap, 21, 30, true);
        let mapper = mapper(&room, ring(1, RingShape::EightNeighbour));
        let cells = flagged(&mapper, FLAG_VIRTUAL);
        let in_gap = cells
            .iter()
            .filter(|cell| inside((20, 15, 21, 15 + gap))(cell));
        assert_eq!(
            in_gap.count() == gap.unsigned_abs() as usize,
            closed,
            "{gap}"
        );
    }
}

#[test]
fn bao_full_the_ring_follows_what_comes_and_goes() {
    let mut room = Room::walled(80, 60, 1);
    let mut mapper = mapper(&room, ring(2, RingShape::EightNeighbour));
    let before = flagged(&mapper, FLAG_VIRTUAL);
    room.fill(40, 25, 46, 31, true);
    let from = room.pose(20.5, 30.5, 0.0);
    let look = |mapper: &mut Mapper, room: &Room| {
        let (scan, ranges) = room.scan(&from);
        mapper.integrate(&from, &scan, &ranges);
    };
    for _ in 0..3 {
        look(&mut mapper, &room);
    }
    let with_box = flagged(&mapper, FLAG_VIRTUAL);
    assert!(with_box.len() > before.len() + 20);
    assert_eq!(with_box.len(), mapper.n_virtual());
    room.fill(40, 25, 46, 31, false);
    for _ in 0..5 {
        look(&mut mapper, &room);
    }
    assert_eq!(flagged(&mapper, FLAG_VIRTUAL), before);
}

/// The cells that the corner rule of the planners forbids, by hand: a single obstacle
/// keeps diagonal moves out of its four orthogonal neighbours.
#[test]
fn bao_full_corner_cells_are_flagged_for_display() {
    let mut room = Room::empty(20, 20);
    room.fill(10, 10, 11, 11, true);
    let mapper = mapper(&room, |config| {
        config.virtual_obstacles.kind = VirtualKind::Corners;
    });
    assert_eq!(
        flagged(&mapper, FLAG_VIRTUAL),
        [(10, 9), (9, 10), (11, 10), (10, 11)]
    );
    assert_eq!(mapper.n_virtual(), 4);
}
