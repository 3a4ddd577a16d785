//! Random maps: C-GEN.

use std::collections::BTreeSet;
use zeronav_msgs::Cell;
use zeronav_world::generate::{GenerateError, Generated, generate};
use zeronav_world::spec::{Family, GeneratedSpec};
use zeronav_world::{Occupancy, WorldSpec};

const FAMILIES: [Family; 4] = [
    Family::Iid,
    Family::Blocky { side_cells_max: 4 },
    Family::Concave { side_cells_max: 8 },
    Family::Corridor { width_cells: 2 },
];

fn spec(family: Family, ratio: f64, seed: u64) -> GeneratedSpec {
    GeneratedSpec {
        family,
        size_cells: [30, 20],
        ratio: match family {
            Family::Corridor { .. } => 0.0,
            _ => ratio,
        },
        start_cell: None,
        goal_cell: None,
        seed,
        resolution_m: 1.0,
    }
}

fn drawn(spec: &GeneratedSpec) -> Generated {
    generate(spec).unwrap_or_else(|error| panic!("{spec:?}: {error}"))
}

#[test]
fn c_gen_the_same_seed_gives_the_same_map_and_another_gives_another() {
    for family in FAMILIES {
        let mut maps = BTreeSet::new();
        for seed in 0..20 {
            let spec = spec(family, 0.2, seed);
            let generated = drawn(&spec);
            assert_eq!(generated, drawn(&spec), "{spec:?}");
            maps.insert(
                generated
                    .map
                    .cells
                    .iter()
                    .map(|cell| *cell as u8)
                    .collect::<Vec<u8>>(),
            );
        }
        // Corridors only choose on which side the first gap is.
        let least = if matches!(family, Family::Corridor { .. }) {
            2
        } else {
            20
        };
        assert_eq!(maps.len(), least, "{family:?}");
    }
}

#[test]
fn c_gen_the_ratio_is_exact_and_start_and_goal_stay_free() {
    for family in &FAMILIES[..3] {
        for (ratio, occupied) in [(0.0, 0), (0.15, 90), (0.2, 120), (0.3, 180)] {
            for seed in 0..20 {
                let generated = drawn(&spec(*family, ratio, seed));
                assert_eq!(generated.map.count(Occupancy::Occupied), occupied);
                for cell in [generated.start, generated.goal] {
                    assert_eq!(generated.map.get(cell), Some(Occupancy::Free));
                }
            }
        }
    }
    let mut own = spec(Family::Iid, 0.2, 3);
    (own.start_cell, own.goal_cell) = (Some([4, 7]), Some([20, 1]));
    let generated = drawn(&own);
    assert_eq!(generated.start, Cell::new(4, 7));
    assert_eq!(generated.goal, Cell::new(20, 1));
}

/// Breadth first over the four neighbours, independent of the generator's own search.
fn is_crossed(generated: &Generated) -> bool {
    let mut reached = BTreeSet::from([(generated.start.x, generated.start.y)]);
    let mut ring = vec![generated.start];
    while !ring.is_empty() {
        let mut next_ring = Vec::new();
        for cell in ring {
            for (dx, dy) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
                let next = Cell::new(cell.x + dx, cell.y + dy);
                if generated.map.get(next) == Some(Occupancy::Free)
                    && reached.insert((next.x, next.y))
                {
                    next_ring.push(next);
                }
            }
        }
        ring = next_ring;
    }
    reached.contains(&(generated.goal.x, generated.goal.y))
}

#[test]
fn c_gen_every_map_can_be_crossed_and_the_acceptance_rate_is_reported() {
    let n_maps = 50_u32;
    for family in FAMILIES {
        for ratio in [0.1, 0.2, 0.3] {
            let mut tried = 0;
            for seed in 0..u64::from(n_maps) {
                let generated = drawn(&spec(family, ratio, seed));
                assert!(is_crossed(&generated), "{family:?} {ratio} seed {seed}");
                assert!(generated.tried >= 1);
                tried += generated.tried;
            }
            let rate = f64::from(n_maps) / f64::from(tried);
            eprintln!("{family:?} {ratio}: {n_maps} of {tried} maps accepted, {rate:.3}");
            assert!(rate > 0.02, "{family:?} {ratio}: {rate}");
            // Next to percolation many are lost; corridors are never.
            if matches!(family, Family::Iid) && ratio > 0.25 {
                assert!(rate < 0.95, "{rate}");
            }
            if matches!(family, Family::Corridor { .. }) {
                assert_eq!(tried, n_maps);
            }
        }
    }
}

#[test]
fn c_gen_maps_that_cannot_be_are_refused() {
    let refused = |change: fn(&mut GeneratedSpec)| {
        let mut wrong = spec(Family::Blocky { side_cells_max: 4 }, 0.2, 1);
        change(&mut wrong);
        generate(&wrong).unwrap_err()
    };
    let field = |change| match refused(change) {
        GenerateError::Spec(error) => error.field,
        error @ GenerateError::NoWay { .. } => panic!("{error}"),
    };
    assert_eq!(field(|s| s.size_cells[1] = 0), "size_cells[1]");
    assert_eq!(field(|s| s.size_cells[0] = 9000), "size_cells[0]");
    assert_eq!(field(|s| s.ratio = 1.0), "ratio");
    assert_eq!(field(|s| s.ratio = f64::NAN), "ratio");
    assert_eq!(field(|s| s.goal_cell = Some([30, 0])), "goal_cell");
    assert_eq!(field(|s| s.resolution_m = 0.0), "resolution_m");
    let sides = |s: &mut GeneratedSpec| s.family = Family::Blocky { side_cells_max: 0 };
    assert_eq!(field(sides), "family.side_cells_max");
    let corridors = |s: &mut GeneratedSpec| s.family = Family::Corridor { width_cells: 2 };
    assert_eq!(field(corridors), "ratio");
    // Nearly full: no way, after a bounded number of tries.
    let full = refused(|s| (s.family, s.ratio, s.size_cells) = (Family::Iid, 0.9, [100, 100]));
    assert!(
        matches!(full, GenerateError::NoWay { tried } if tried >= 16),
        "{full}"
    );
}

#[test]
fn c_gen_a_scenario_can_name_a_random_map() {
    let words = "[generated]\nfamily = { kind = \"blocky\" }\nsize_cells = [40, 30]\n\
                 ratio = 0.2\nseed = 5\nresolution_m = 0.25";
    let spec: WorldSpec = toml::from_str(words).unwrap();
    let (world, _) = zeronav_world_files::load(&spec).unwrap();
    let map = world.static_map().unwrap();
    assert_eq!(map.count(Occupancy::Occupied), 240);
    assert!((world.geometry().resolution_m - 0.25).abs() < 1e-12);
    let written = toml::to_string(&spec).unwrap();
    assert_eq!(toml::from_str::<WorldSpec>(&written), Ok(spec));
}
