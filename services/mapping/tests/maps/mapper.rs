//! Scans into maps: what must be marked, what must be cleared, what must stay, and when nothing
//! may happen.

use crate::support::{Rng, Room, config, description};
use zeronav_casts::Cast;
use zeronav_mapping::{Integrated, Mapper, MappingConfig, MappingError};
use zeronav_msgs::map::{
    COST_INSCRIBED, COST_LETHAL, COST_UNKNOWN, FLAG_SENSED, FLAG_STATIC, FLAG_UNKNOWN,
};
use zeronav_msgs::scan::Scan;
use zeronav_msgs::{Cell, MapCell, Pose};
use zeronav_world::Occupancy;

/// A map that knows the room as it is now.
fn knowing(room: &Room) -> Mapper {
    Mapper::new(&config(room), Some(&room.as_static_map()), &description()).unwrap()
}

/// A map that knows nothing.
fn ignorant(room: &Room) -> Mapper {
    Mapper::new(&config(room), None, &description()).unwrap()
}

fn look(mapper: &mut Mapper, room: &Room, from: &Pose) -> Integrated {
    let (scan, ranges) = room.scan(from);
    scan.check(&ranges).unwrap();
    mapper.integrate(from, &scan, &ranges)
}

fn cell(mapper: &Mapper, x: i32, y: i32) -> MapCell {
    mapper.view().get(Cell::new(x, y)).unwrap()
}

fn is_sensed(mapper: &Mapper, x: i32, y: i32) -> bool {
    let cell = cell(mapper, x, y);
    let sensed = cell.flags & FLAG_SENSED != 0;
    assert!(!sensed || (cell.cost == COST_LETHAL && cell.clearance_mm == 0));
    sensed
}

/// One beam along +x.
fn beam(range_m: f32) -> (Scan, [f32; 1]) {
    let scan = Scan {
        n_beams: 1,
        angle_increment_rad: 0.1,
        range_m_min: 0.1,
        range_m_max: 12.0,
        ..Scan::default()
    };
    (scan, [range_m])
}

#[test]
fn one_scan_marks_what_appears() {
    let mut room = Room::walled(200, 100, 3);
    let mut mapper = knowing(&room);
    let from = room.pose(50.5, 50.5, 0.3);
    for _ in 0..20 {
        assert_eq!(look(&mut mapper, &room, &from), Integrated::default());
    }
    room.fill(100, 46, 106, 55, true);
    let integrated = look(&mut mapper, &room, &from);
    // The face towards the robot; beams that meet its ends may count half a cell beside them.
    assert!((9..=11).contains(&integrated.marked), "{integrated:?}");
    for y in 46..55 {
        assert!(is_sensed(&mapper, 100, y), "row {y}");
    }
    // The centre may not come closer than the inscribed radius and 2 cm: 0.175 m and 0.225 m.
    assert_eq!(cell(&mapper, 96, 50).cost, COST_INSCRIBED);
    assert_eq!(cell(&mapper, 95, 50).cost, 247);
}

#[test]
fn what_vanishes_is_cleared_within_half_a_second() {
    for (scans_seen, scans_to_clear) in [(1, 2), (2, 4), (50, 4)] {
        let mut room = Room::walled(200, 100, 3);
        let mut mapper = knowing(&room);
        let from = room.pose(50.5, 50.5, 0.0);
        let free = mapper.cells().to_vec();
        room.fill(100, 46, 106, 55, true);
        for _ in 0..scans_seen {
            look(&mut mapper, &room, &from);
        }
        room.fill(100, 46, 106, 55, false);
        let mut scans = 0;
        while mapper.cells() != free {
            look(&mut mapper, &room, &from);
            scans += 1;
            assert!(scans <= 5, "0.5 s at 10 Hz");
        }
        assert_eq!(scans, scans_to_clear, "seen {scans_seen} times");
    }
}

#[test]
fn no_return_clears_and_an_invalid_beam_does_nothing() {
    let room = Room::empty(200, 40);
    let mut mapper = ignorant(&room);
    let from = room.pose(20.5, 20.5, 0.0);
    let (scan, hit) = beam(2.0);
    mapper.integrate(&from, &scan, &hit);
    assert!(is_sensed(&mapper, 61, 20));
    for nothing in [f32::NAN, 0.05, 12.1] {
        for _ in 0..20 {
            let integrated = mapper.integrate(&from, &scan, &[nothing]);
            assert_eq!(integrated, Integrated::default(), "{nothing}");
        }
    }
    assert!(is_sensed(&mapper, 61, 20));
    assert_eq!(cell(&mapper, 190, 20).cost, COST_UNKNOWN);
    for _ in 0..2 {
        mapper.integrate(&from, &scan, &[f32::INFINITY]);
    }
    assert!(!is_sensed(&mapper, 61, 20));
    assert_eq!(
        cell(&mapper, 190, 20),
        MapCell {
            cost: 0,
            flags: 0,
            clearance_mm: 1000
        }
    );
}

#[test]
fn a_beam_clears_only_what_it_left_and_only_within_range() {
    let room = Room::empty(400, 40);
    let mut mapper = ignorant(&room);
    let from = room.pose(20.5, 20.5, 0.0);
    // Returned from the face between columns 59 and 60, and from the middle of column 60.
    for (range_m, last_free, marked) in [(1.975, 59, 60), (1.98, 59, 60), (2.024, 59, 61)] {
        let mut mapper = ignorant(&room);
        let (scan, hit) = beam(range_m);
        mapper.integrate(&from, &scan, &hit);
        let known = (0..400).filter(|x| cell(&mapper, *x, 20).flags & FLAG_UNKNOWN == 0);
        let expected: Vec<i32> = (20..=last_free).chain([marked]).collect();
        assert_eq!(known.collect::<Vec<_>>(), expected, "{range_m}");
        assert!(is_sensed(&mapper, marked, 20));
    }
    let (scan, hit) = beam(12.0);
    let short = MappingConfig {
        obstacle_range_m: 5.0,
        raytrace_range_m: 6.0,
        ..config(&room)
    };
    let mut near = Mapper::new(&short, None, &description()).unwrap();
    assert_eq!(near.integrate(&from, &scan, &hit).marked, 0);
    let revealed = near.integrate(&from, &scan, &hit).revealed + 120;
    assert_eq!(revealed, 120, "6 m of cells, once");
    assert_eq!(mapper.integrate(&from, &scan, &hit).marked, 1);
}

#[test]
fn what_a_scan_marks_its_other_beams_do_not_clear() {
    // A post of a third of a cell: one beam hits it, many pass through its cell.
    let room = Room::empty(100, 40);
    let mut mapper = ignorant(&room);
    let from = room.pose(10.5, 20.5, 0.0);
    let scan = Scan {
        n_beams: 41,
        angle_min_rad: -0.01,
        angle_increment_rad: 0.0005,
        range_m_min: 0.1,
        range_m_max: 12.0,
        ..Scan::default()
    };
    let mut ranges = [f32::INFINITY; 41];
    ranges[3] = 1.525;
    for _ in 0..30 {
        mapper.integrate(&from, &scan, &ranges);
        assert!(is_sensed(&mapper, 41, 20));
    }
    // And its cell changes by one miss only when none of them hits it.
    ranges[3] = f32::INFINITY;
    for _ in 0..3 {
        assert_eq!(mapper.integrate(&from, &scan, &ranges).cleared, 0);
    }
    assert_eq!(mapper.integrate(&from, &scan, &ranges).cleared, 1);
}

#[test]
fn beside_an_obstacle_the_second_hit_marks() {
    let room = Room::empty(100, 40);
    let mut mapper = ignorant(&room);
    let from = room.pose(10.5, 20.5, 0.0);
    let (scan, far) = beam(1.525);
    mapper.integrate(&from, &scan, &far);
    assert!(is_sensed(&mapper, 41, 20));
    // One hit in the cell before it is forgotten, two in a row are not.
    let (_, near) = beam(1.475);
    assert_eq!(mapper.integrate(&from, &scan, &near), Integrated::default());
    assert_eq!(mapper.integrate(&from, &scan, &far), Integrated::default());
    assert_eq!(mapper.integrate(&from, &scan, &near), Integrated::default());
    assert_eq!(mapper.integrate(&from, &scan, &near).marked, 1);
    assert!(is_sensed(&mapper, 40, 20));
    // Two cells before it, in the open, one is enough.
    let (_, open) = beam(1.375);
    assert_eq!(mapper.integrate(&from, &scan, &open).marked, 1);
    assert!(is_sensed(&mapper, 38, 20));
}

/// Beams come back from something that is not there. With three in a hundred a second one comes from the
/// same cell every other second, and a third one never.
#[test]
fn a_lone_return_needs_a_third_one() {
    let room = Room::walled(200, 100, 3);
    let from = room.pose(50.5, 50.5, 0.3);
    let (scan, clean) = room.scan(&from);
    let n_sensed = |mapper: &Mapper| {
        let cells = mapper.cells().iter();
        cells.filter(|cell| cell.flags & FLAG_SENSED != 0).count()
    };
    let with = |beams: &[usize], range_m: f32| {
        let mut ranges = clean.clone();
        for beam in beams {
            ranges[*beam] = range_m;
        }
        ranges
    };
    let mut mapper = knowing(&room);
    for beam in [0, 100, 333, 719] {
        mapper.integrate(&from, &scan, &with(&[beam], 0.8));
        assert_eq!(n_sensed(&mapper), 0, "beam {beam}");
        mapper.integrate(&from, &scan, &clean);
    }
    // It is doubted again each time and never accepted, nor are two in a row.
    for _ in 0..3 {
        for _ in 0..2 {
            mapper.integrate(&from, &scan, &with(&[333], 0.8));
            assert_eq!(n_sensed(&mapper), 0);
        }
        mapper.integrate(&from, &scan, &clean);
    }
    for _ in 0..2 {
        mapper.integrate(&from, &scan, &with(&[333], 0.8));
        assert_eq!(n_sensed(&mapper), 0);
    }
    // A pole that one beam sees stays where it is.
    mapper.integrate(&from, &scan, &with(&[333], 0.8));
    assert_eq!(n_sensed(&mapper), 1);
    for _ in 0..4 {
        mapper.integrate(&from, &scan, &clean);
    }
    assert_eq!(n_sensed(&mapper), 0);
    // Three neighbours see it: it is there at once, also across the seam of the turn. Two may be drops of
    // rain, and are there with the third scan.
    for three in [[500, 501, 502], [719, 0, 1]] {
        let mut mapper = knowing(&room);
        mapper.integrate(&from, &scan, &with(&three, 0.8));
        assert!(n_sensed(&mapper) > 0, "beams {three:?}");
        let mut mapper = knowing(&room);
        for n in [0, 1, 2] {
            mapper.integrate(&from, &scan, &with(&three[..2], 0.8));
            assert_eq!(n_sensed(&mapper) > 0, n > 1, "beams {three:?}");
        }
    }
}

#[test]
fn the_static_map_stays_whatever_scans_say() {
    let room = Room::walled(100, 60, 2);
    let mut mapper = knowing(&room);
    let before = mapper.cells().to_vec();
    let nothing_there = Room::empty(100, 60);
    let from = room.pose(50.0, 30.0, 1.0);
    for _ in 0..20 {
        assert_eq!(
            look(&mut mapper, &nothing_there, &from),
            Integrated::default()
        );
    }
    assert_eq!(mapper.cells(), before);
    let wall = cell(&mapper, 0, 30);
    assert_eq!(
        wall,
        MapCell {
            cost: COST_LETHAL,
            flags: FLAG_STATIC,
            clearance_mm: 0
        }
    );
}

#[test]
fn hits_on_mapped_walls_are_no_news() {
    let room = Room::walled(120, 80, 1);
    let mut mapper = knowing(&room);
    let mut rng = Rng(1);
    for _ in 0..100 {
        // A pose that is wrong by up to 2 cm, and 1 cm of noise.
        let from = room.pose(60.0, 40.0, 0.4);
        let error = Pose {
            x_m: from.x_m + 0.02,
            y_m: from.y_m - 0.01,
            ..from
        };
        let (scan, mut ranges) = room.scan(&from);
        noise(&mut ranges, &mut rng, 0.01);
        assert_eq!(
            mapper.integrate(&error, &scan, &ranges),
            Integrated::default()
        );
    }
}

#[test]
fn noise_does_not_flicker() {
    // An unmapped box, faces on cell borders: the worst place for them.
    let mut room = Room::walled(160, 100, 2);
    let mut mapper = knowing(&room);
    room.fill(90, 40, 110, 60, true);
    let mut rng = Rng(2);
    let from = room.pose(40.0, 30.0, 0.4);
    let mut flips = 0;
    for n in 0..300 {
        let (scan, mut ranges) = room.scan(&from);
        noise(&mut ranges, &mut rng, 0.01);
        let integrated = mapper.integrate(&from, &scan, &ranges);
        if n >= 10 {
            flips += integrated.marked + integrated.cleared;
        }
    }
    assert!(
        flips <= 290 / 3,
        "{flips} flips in 290 scans of some 40 cells"
    );
}

fn noise(ranges: &mut [f32], rng: &mut Rng, sigma_m: f64) {
    for range_m in ranges.iter_mut().filter(|range_m| range_m.is_finite()) {
        *range_m += (rng.normal() * sigma_m).to_f32();
    }
}

#[test]
fn a_map_without_a_static_one_starts_unknown() {
    let room = Room::walled(100, 80, 2);
    let mut mapper = ignorant(&room);
    assert!(
        mapper
            .cells()
            .iter()
            .all(|cell| *cell == MapCell::unknown(1000))
    );
    let from = room.pose(50.0, 40.0, 0.0);
    let integrated = look(&mut mapper, &room, &from);
    assert!(
        integrated.revealed > 5000 && integrated.marked > 100,
        "{integrated:?}"
    );
    assert_eq!(
        cell(&mapper, 50, 40),
        MapCell {
            cost: 0,
            flags: 0,
            clearance_mm: 1000
        }
    );
    // Behind the wall nothing is known, but it is known to be too close to the wall.
    let behind = cell(&mapper, 0, 40);
    assert_eq!((behind.cost, behind.flags), (COST_INSCRIBED, FLAG_UNKNOWN));
}

#[test]
fn unknown_cells_of_the_static_map_are_unknown() {
    let room = Room::walled(60, 60, 1);
    let mut map = room.as_static_map();
    map.cells[30 * 60 + 30] = Occupancy::Unknown;
    let mut mapper = Mapper::new(&config(&room), Some(&map), &description()).unwrap();
    assert_eq!(cell(&mapper, 30, 30), MapCell::unknown(1000));
    look(&mut mapper, &room, &room.pose(10.5, 30.5, 0.0));
    assert_eq!(cell(&mapper, 30, 30).cost, 0);
}

#[test]
fn poses_beside_the_map_and_broken_ones_do_no_harm() {
    let room = Room::walled(60, 60, 1);
    let mut mapper = ignorant(&room);
    let mut outside = room.pose(-20.0, 30.0, 0.0);
    let (scan, hit) = beam(2.0);
    assert_eq!(mapper.integrate(&outside, &scan, &hit).marked, 1);
    assert!(is_sensed(&mapper, 20, 30));
    outside.x_m = 1.0e6;
    assert_eq!(
        mapper.integrate(&outside, &scan, &hit),
        Integrated::default()
    );
    outside.x_m = f64::NAN;
    assert_eq!(
        mapper.integrate(&outside, &scan, &hit),
        Integrated::default()
    );
}

#[test]
fn what_cannot_be_a_map_is_refused() {
    let room = Room::walled(60, 60, 1);
    let mut map = room.as_static_map();
    map.cells.pop();
    let error = Mapper::new(&config(&room), Some(&map), &description()).unwrap_err();
    assert_eq!(
        error,
        MappingError::StaticMap {
            n_cells: 3599,
            expected: 3600
        }
    );
    let config = MappingConfig::default();
    let error = Mapper::new(&config, None, &description()).unwrap_err();
    assert_eq!(error, MappingError::NoArea);
    map.geometry.resolution_m = -1.0;
    let error = Mapper::new(&config, Some(&map), &description()).unwrap_err();
    assert!(matches!(error, MappingError::Geometry(_)));
}
