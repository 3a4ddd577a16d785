//! Collisions and clearance of paths against the true shapes: C-COLL.

use nalgebra::Point2;
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;
use zeronav_msgs::GridGeometry;
use zeronav_world::{Occupancy, ShapeSpec, StaticMap, World, WorldSpec};

/// A map of cells of `resolution_m` with these occupied.
fn world(resolution_m: f64, occupied: &[(usize, usize)], shapes: Vec<ShapeSpec>) -> World {
    let geometry = GridGeometry {
        origin_x_m: 0.0,
        origin_y_m: 0.0,
        resolution_m,
        width: 20,
        height: 20,
    };
    let mut map = StaticMap::free(geometry);
    for (x, y) in occupied {
        map.cells[y * 20 + x] = Occupancy::Occupied;
    }
    let spec = WorldSpec {
        shapes,
        ..WorldSpec::of_map("drawn here")
    };
    World::new(&spec, Some(map)).expect("a world")
}

fn path(points: &[[f64; 2]]) -> Vec<Point2<f64>> {
    points.iter().map(|at| Point2::from(*at)).collect()
}

#[test]
fn c_coll_a_path_that_clips_a_corner_by_a_hundredth_of_a_cell_collides() {
    for resolution_m in [0.05, 1.0] {
        let world = world(resolution_m, &[(10, 10)], Vec::new());
        // A diagonal past the corner (11, 11); the distance from it is s / sqrt 2 cells.
        let diagonal = |s: f64| {
            let cells = [[8.0, 14.0 + s], [14.0 + s, 8.0]];
            path(&cells.map(|at| at.map(|value| value * resolution_m)))
        };
        let clearance = |s: f64| world.polyline_clearance_m(&diagonal(s)) / resolution_m;
        assert!(clearance(-0.01).abs() < 1e-15, "clips by 0.01 cell");
        assert!((clearance(0.01) - 0.01 / 2.0_f64.sqrt()).abs() < 1e-9);
        // As an area of radius r: the clearance must exceed it.
        assert!(clearance(0.3) < 0.22 && clearance(0.32) > 0.22);
    }
}

#[test]
fn c_coll_touching_is_colliding_and_inside_too() {
    let world = world(1.0, &[(10, 10)], Vec::new());
    let clearance = |points: &[[f64; 2]]| world.polyline_clearance_m(&path(points));
    assert!(
        clearance(&[[5.0, 11.0], [15.0, 11.0]]).abs() < 1e-15,
        "along the edge"
    );
    assert!(
        clearance(&[[10.2, 10.2], [10.8, 10.7]]).abs() < 1e-15,
        "inside"
    );
    assert!(clearance(&[[10.5, 10.5]]).abs() < 1e-15, "a point inside");
    assert!((clearance(&[[10.5, 12.5]]) - 1.5).abs() < 1e-12);
    assert!((clearance(&[[0.0, 11.5], [20.0, 11.5]]) - 0.5).abs() < 1e-12);
    assert!(clearance(&[]).is_infinite());
    // Two obstacles that meet at a corner let no path through.
    let gate = super_gate();
    assert!(gate.polyline_clearance_m(&path(&[[9.0, 13.0], [13.0, 9.0]])) < 1e-12);
}

fn super_gate() -> World {
    world(1.0, &[(10, 10), (11, 11)], Vec::new())
}

#[test]
fn c_coll_clearance_equals_that_of_points_along_the_path() {
    let seed = 4;
    eprintln!("seed {seed}");
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let (mut collided, mut clear) = (0, 0);
    for case in 0..200 {
        let occupied: Vec<(usize, usize)> = (0..12)
            .map(|_| (rng.random_range(0..20), rng.random_range(0..20)))
            .collect();
        let disc = ShapeSpec::Disc {
            centre_m: [rng.random_range(0.0..20.0), rng.random_range(0.0..20.0)],
            radius_m: rng.random_range(0.1..2.0),
        };
        let turned = ShapeSpec::Box {
            centre_m: [rng.random_range(0.0..20.0), rng.random_range(0.0..20.0)],
            size_m: [rng.random_range(0.1..3.0), rng.random_range(0.1..3.0)],
            yaw_rad: rng.random_range(-3.0..3.0),
        };
        let world = world(1.0, &occupied, vec![disc, turned]);
        let mut corner = || [rng.random_range(0.0..20.0), rng.random_range(0.0..20.0)];
        let way = path(&[corner(), corner(), corner()]);
        let found = world.polyline_clearance_m(&way);
        let mut sampled = f64::INFINITY;
        for pair in way.windows(2) {
            let steps = 400;
            for step in 0..=steps {
                let along = f64::from(step) / f64::from(steps);
                let at = pair[0] + (pair[1] - pair[0]) * along;
                sampled = sampled.min(world.point_distance_m(at));
            }
        }
        // Between two samples at most half of 28 m / 400 is lost.
        assert!(
            found <= sampled + 1e-6,
            "case {case}: {found} above {sampled}"
        );
        assert!(
            found >= sampled - 0.036,
            "case {case}: {found} below {sampled}"
        );
        collided += usize::from(sampled <= 0.0);
        clear += usize::from(found > 0.0);
    }
    assert!(collided > 30 && clear > 20, "{collided} {clear}");
}
