//! Zones on the map: closed to planners, unseen by scans.

use crate::support::{Room, config, description};
use nalgebra::Point2;
use zeronav_mapping::window::{WindowConfig, WindowMode};
use zeronav_mapping::{Mapper, Mapping, Observation};
use zeronav_msgs::map::{COST_LETHAL, FLAG_KEEPOUT, FLAG_SENSED, FLAG_STATIC, ObstacleSource};
use zeronav_msgs::zones::{ZoneKind, ZonePart, Zones};
use zeronav_msgs::{MapCell, ZoneSet};

/// Side of the cells of a [`Room`]. [m]
const CELL_M: f64 = 0.05;

fn zones(revision: u64, parts: &[ZonePart]) -> ZoneSet {
    let message = Zones {
        revision,
        n_parts: parts.len() as u64,
        ..Zones::default()
    };
    message.check(parts).unwrap();
    ZoneSet::of(&message, parts)
}

/// A rectangle between two corners of cells.
fn rect(room: &Room, kind: ZoneKind, value: f64, [x0, y0, x1, y1]: [f64; 4]) -> ZonePart {
    let at = |x: f64, y: f64| {
        let pose = room.pose(x, y, 0.0);
        [pose.x_m, pose.y_m]
    };
    let corners = [at(x0, y0), at(x1, y0), at(x1, y1), at(x0, y1)];
    ZonePart::new(&format!("{kind} {x0} {y0}"), kind, value, &corners)
}

fn keepout(room: &Room, corners: [f64; 4]) -> ZonePart {
    rect(room, ZoneKind::Keepout, 0.0, corners)
}

/// A room of 120 x 100 cells, and its map after a scan from the middle of its left half.
fn seen() -> (Room, Mapper) {
    let room = Room::walled(120, 100, 3);
    let mut mapper = Mapper::new(&config(&room), None, &description()).unwrap();
    look(&room, &mut mapper);
    (room, mapper)
}

fn look(room: &Room, mapper: &mut Mapper) {
    let from = room.pose(30.5, 50.5, 0.0);
    let (scan, ranges) = room.scan(&from);
    for _ in 0..4 {
        mapper.integrate(&from, &scan, &ranges);
    }
}

fn at(mapper: &Mapper, room: &Room, x: f64, y: f64) -> MapCell {
    let point = room.pose(x, y, 0.0).point();
    let cell = mapper.geometry().cell_at(point).unwrap();
    mapper.view().get(cell).unwrap()
}

#[test]
fn a_keepout_zone_is_an_obstacle_to_planners_until_it_goes() {
    let (room, mut mapper) = seen();
    let before = mapper.cells().to_vec();
    mapper.set_zones(&zones(1, &[keepout(&room, [60.0, 40.0, 70.0, 60.0])]));
    let inside = at(&mapper, &room, 65.5, 50.5);
    assert_eq!((inside.cost, inside.flags), (COST_LETHAL, FLAG_KEEPOUT));
    assert_eq!(inside.source(), ObstacleSource::Keepout);
    let beside = at(&mapper, &room, 72.5, 50.5);
    assert_eq!(beside.clearance_mm, 125, "as beside a wall");
    assert!(beside.blocks_centre() && beside.flags == 0);
    // Its map file knows nothing of it.
    let file = mapper.as_static_map();
    let point = room.pose(65.5, 50.5, 0.0).point();
    assert_eq!(file.at(point), Some(zeronav_world::Occupancy::Free));
    mapper.set_zones(&zones(2, &[]));
    assert_eq!(mapper.cells(), before);
}

#[test]
fn scans_neither_clear_nor_mark_a_zone() {
    let (room, mut mapper) = seen();
    let set = zones(1, &[keepout(&room, [60.0, 40.0, 70.0, 60.0])]);
    mapper.set_zones(&set);
    let closed = mapper.cells().to_vec();
    look(&room, &mut mapper);
    assert_eq!(mapper.cells(), closed, "the beams pass through it");
    // What stands in it is seen, goes, and leaves it closed.
    let mut with_box = Room::walled(120, 100, 3);
    with_box.fill(64, 48, 66, 52, true);
    look(&with_box, &mut mapper);
    assert_eq!(
        at(&mapper, &room, 64.5, 50.5).flags,
        FLAG_KEEPOUT | FLAG_SENSED
    );
    for _ in 0..5 {
        look(&room, &mut mapper);
    }
    assert_eq!(mapper.cells(), closed);
}

#[test]
fn a_hundred_zones_that_come_and_go_leave_what_a_new_map_would_have() {
    let (room, mut mapper) = seen();
    let mut state = 7_u64;
    let mut draw = |most: u64| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        f64::from(u32::try_from((state >> 33) % most).unwrap())
    };
    let mut parts: Vec<ZonePart> = Vec::new();
    for revision in 1..=25 {
        if parts.len() >= 100 {
            parts.drain(..40);
        }
        for _ in 0..8 {
            let (x, y) = (draw(118), draw(98));
            let corners = [x, y, x + 1.0 + draw(9), y + 1.0 + draw(9)];
            let part = match draw(10) {
                n if n < 7.0 => keepout(&room, corners),
                n if n < 9.0 => rect(&room, ZoneKind::Cost, 1.0 + draw(252), corners),
                _ => rect(&room, ZoneKind::Lane, 1.0 + draw(60), corners),
            };
            parts.push(part);
        }
        mapper.set_zones(&zones(revision, &parts));
        if revision % 6 == 0 {
            look(&room, &mut mapper);
        }
    }
    assert_eq!(parts.len(), 80);
    let (_, mut fresh) = seen();
    for _ in 0..5 {
        look(&room, &mut fresh);
    }
    fresh.set_zones(&zones(1, &parts));
    look(&room, &mut mapper);
    let differ = (mapper.cells().iter().zip(fresh.cells())).filter(|(one, other)| one != other);
    assert_eq!(differ.count(), 0);
}

#[test]
fn zones_stay_where_they_are_when_the_map_moves() {
    let (room, mut mapper) = seen();
    mapper.set_zones(&zones(1, &[keepout(&room, [60.0, 40.0, 70.0, 60.0])]));
    let mut geometry = *mapper.geometry();
    geometry.origin_x_m += 20.0 * CELL_M;
    let moved = mapper.moved(&geometry, zeronav_msgs::Cell::new(20, 0), &config(&room));
    assert_eq!(at(&moved, &room, 65.5, 50.5).flags, FLAG_KEEPOUT);
    assert_eq!(at(&moved, &room, 72.5, 50.5).clearance_mm, 125);
    // A successor that learns the map takes the zone for no obstacle of the world.
    let fresh = Mapper::new(&config(&room), None, &description()).unwrap();
    let learnt = fresh.learnt(&mapper.view(), &config(&room)).unwrap();
    assert_eq!(
        at(&learnt, &room, 65.5, 50.5),
        MapCell {
            flags: 0,
            ..at(&learnt, &room, 65.5, 45.5)
        }
    );
    assert_eq!(
        at(&learnt, &room, 65.5, 50.5).flags & (FLAG_SENSED | FLAG_STATIC),
        0
    );
}

#[test]
fn lanes_and_costs_raise_what_free_cells_cost() {
    let (room, mut mapper) = seen();
    let lane = rect(&room, ZoneKind::Lane, 90.0, [10.0, 45.0, 110.0, 55.0]);
    let wet = rect(&room, ZoneKind::Cost, 200.0, [80.0, 45.0, 90.0, 55.0]);
    mapper.set_zones(&zones(1, &[lane, wet]));
    let cost = |x, y| at(&mapper, &room, x, y).cost;
    assert_eq!(
        [cost(50.5, 50.5), cost(50.5, 30.5), cost(85.5, 50.5)],
        [0, 90, 200]
    );
    assert_eq!(cost(50.5, 2.5), COST_LETHAL, "a wall is a wall");
}

/// A robot at a place, and the map after its scan.
fn drive_to(mapping: &mut Mapping, room: &Room, (x, y): (f64, f64), n: u64) {
    let from = room.pose(x, y, 0.0);
    let (scan, ranges) = room.scan(&from);
    mapping.take_in(&Observation {
        scan: &scan,
        ranges: &ranges,
        run_ns: n * 100_000_000,
        odom_from_base_first: from,
        odom_from_base: from,
        odometry_variance: [0.0; 3],
        goal: None,
        told: None,
    });
    mapping.let_out(&from);
}

#[test]
fn a_robot_inside_is_let_out_on_the_shortest_way_that_no_wall_bars() {
    let mut room = Room::walled(120, 100, 3);
    // Above the robot, where the zone would be left soonest.
    room.fill(40, 56, 60, 58, true);
    let mut mapping = Mapping::new(&config(&room), None, &description(), &[]).unwrap();
    for n in 0..4 {
        drive_to(&mut mapping, &room, (50.5, 50.5), n);
    }
    let set = zones(1, &[keepout(&room, [30.0, 30.0, 64.0, 60.0])]);
    mapping.set_zones(&set);
    let cell = |mapping: &Mapping, x, y| at(mapping.mapper(), &room, x, y);
    assert_eq!(cell(&mapping, 50.5, 50.5).cost, COST_LETHAL);
    drive_to(&mut mapping, &room, (50.5, 50.5), 5);
    assert!(mapping.mapper().way_out().is_some());
    // To the right, and nowhere else.
    for x in 50..75 {
        let on_way = cell(&mapping, f64::from(x) + 0.5, 50.5);
        assert!(!on_way.blocks_centre(), "{x}: {on_way:?}");
    }
    assert_eq!(
        cell(&mapping, 55.5, 50.5).flags,
        FLAG_KEEPOUT,
        "it is told all the same"
    );
    assert_eq!(cell(&mapping, 36.5, 50.5).cost, COST_LETHAL);
    assert_eq!(cell(&mapping, 50.5, 36.5).cost, COST_LETHAL);
    // Behind the robot it is closed again.
    for (n, x) in [55.5, 60.5, 66.5].into_iter().enumerate() {
        drive_to(&mut mapping, &room, (x, 50.5), 6 + n as u64);
        assert!(mapping.mapper().way_out().is_some(), "{x}");
    }
    drive_to(&mut mapping, &room, (76.5, 50.5), 10);
    assert!(mapping.mapper().way_out().is_none());
    assert_eq!(cell(&mapping, 55.5, 50.5).cost, COST_LETHAL);
    // And it does not open for one that passes by.
    drive_to(&mut mapping, &room, (66.5, 50.5), 11);
    assert!(mapping.mapper().way_out().is_none());
}

#[test]
fn a_way_out_that_is_blocked_or_leads_out_no_more_is_given_up_for_another() {
    let room = Room::walled(120, 100, 3);
    let mut mapping = Mapping::new(&config(&room), None, &description(), &[]).unwrap();
    mapping.set_zones(&zones(1, &[keepout(&room, [20.0, 30.0, 64.0, 70.0])]));
    for n in 0..4 {
        drive_to(&mut mapping, &room, (50.5, 50.5), n);
    }
    let is_open = |mapping: &Mapping, x, y| !at(mapping.mapper(), &room, x, y).blocks_centre();
    assert!(is_open(&mapping, 63.5, 50.5) && !is_open(&mapping, 50.5, 31.5));
    // The zone grows, so that the way ends in it: out above is nearer now.
    mapping.set_zones(&zones(2, &[keepout(&room, [20.0, 30.0, 90.0, 66.0])]));
    drive_to(&mut mapping, &room, (50.5, 50.5), 4);
    assert!(!is_open(&mapping, 63.5, 50.5) && is_open(&mapping, 50.5, 64.5));
    // Somebody puts a box there.
    let mut with_box = Room::walled(120, 100, 3);
    with_box.fill(40, 58, 60, 60, true);
    for n in 5..9 {
        drive_to(&mut mapping, &with_box, (50.5, 50.5), n);
    }
    assert!(!is_open(&mapping, 50.5, 64.5) && is_open(&mapping, 50.5, 31.5));
}

#[test]
fn a_window_that_follows_the_robot_keeps_the_zones() {
    let room = Room::walled(480, 120, 3);
    let mut config = config(&room);
    if let Some([_, high]) = &mut config.area_m {
        high[0] -= 12.0;
    }
    config.window = WindowConfig {
        mode: WindowMode::Rolling,
        margin_m: 2.0,
        tiles_max: 200,
    };
    let mut mapping = Mapping::new(&config, None, &description(), &[]).unwrap();
    let set = zones(1, &[keepout(&room, [250.0, 20.0, 255.0, 100.0])]);
    mapping.set_zones(&set);
    for n in 0..40_u32 {
        let place = (40.5 + 5.0 * f64::from(n), 60.5);
        drive_to(&mut mapping, &room, place, u64::from(n));
    }
    let point: Point2<f64> = room.pose(252.5, 60.5, 0.0).point();
    let cell = mapping.mapper().geometry().cell_at(point).unwrap();
    assert_eq!(mapping.mapper().view().get(cell).unwrap().cost, COST_LETHAL);
}
