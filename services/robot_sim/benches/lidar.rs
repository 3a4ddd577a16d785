//! Time of one scan of 720 beams: among 300 shapes, and on a grid map of 600 x 400 cells; and of
//! one of a lidar that turns while the robot moves. For grid maps also 720 bare rays and one contact
//! of a disc, ours beside parry's voxels on the same cells.

use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::{Point2, Vector2};
use parry2d::math::{IVector, Pose2, Vector};
use parry2d::query::{self, Ray, RayCast as _};
use parry2d::shape::{Ball, Voxels};
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;
use std::hint::black_box;
use zeronav_casts::Cast;
use zeronav_msgs::{GridGeometry, Pose};
use zeronav_robot_description::{LidarPreset, LidarSpec};
use zeronav_robot_sim::lidar::Lidar;
use zeronav_robot_sim::solid_grid::SolidGrid;
use zeronav_world::{Convex, Footprint, Occupancy, Shape, ShapeSpec, StaticMap, World, WorldSpec};

const SEED: u64 = 1;

fn lidar() -> Lidar {
    let spec = LidarSpec {
        pose: [0.1, 0.0, 0.0],
        sigma_m: 0.01,
        ..LidarSpec::exact(720, 10.0, 0.1..30.0)
    };
    Lidar::new(&spec, SEED)
}

fn presets_lidar() -> Lidar {
    Lidar::new(&LidarPreset::RplidarA1.lidar(), SEED)
}

/// A room of 20 x 20 m: four walls, and half discs, half turned boxes.
fn room(rng: &mut Pcg64Mcg, n_shapes: usize) -> Vec<Convex> {
    let mut specs = vec![];
    for (centre_m, size_m) in [
        ([10.0, 0.0], [0.1, 20.0]),
        ([-10.0, 0.0], [0.1, 20.0]),
        ([0.0, 10.0], [20.0, 0.1]),
        ([0.0, -10.0], [20.0, 0.1]),
    ] {
        specs.push(ShapeSpec::Box {
            centre_m,
            size_m,
            yaw_rad: 0.0,
        });
    }
    while specs.len() < n_shapes {
        let centre_m = [rng.random_range(-9.5..9.5), rng.random_range(-9.5..9.5)];
        if f64::hypot(centre_m[0], centre_m[1]) < 1.0 {
            continue;
        }
        specs.push(if specs.len() % 2 == 0 {
            ShapeSpec::Disc {
                centre_m,
                radius_m: rng.random_range(0.05..0.3),
            }
        } else {
            ShapeSpec::Box {
                centre_m,
                size_m: [rng.random_range(0.1..0.6), rng.random_range(0.1..0.6)],
                yaw_rad: rng.random_range(-3.0..3.0),
            }
        });
    }
    specs
        .iter()
        .filter_map(|spec| Shape::new(spec).ok())
        .map(|shape| shape.placed().clone())
        .collect()
}

/// 30 x 20 m at 5 cm: a border, and `n_blocks` solid blocks of half a metre.
fn hall(rng: &mut Pcg64Mcg, n_blocks: usize) -> StaticMap {
    let (width, height) = (600_usize, 400_usize);
    let mut map = StaticMap::free(GridGeometry {
        origin_x_m: -15.0,
        origin_y_m: -10.0,
        resolution_m: 0.05,
        width: 600,
        height: 400,
    });
    let mut fill = |x0: usize, y0: usize, w: usize, h: usize| {
        for y in y0..(y0 + h).min(height) {
            for x in x0..(x0 + w).min(width) {
                map.cells[y * width + x] = Occupancy::Occupied;
            }
        }
    };
    fill(0, 0, width, 1);
    fill(0, height - 1, width, 1);
    fill(0, 0, 1, height);
    fill(width - 1, 0, 1, height);
    for _ in 0..n_blocks {
        let (x, y) = (rng.random_range(0..590), rng.random_range(0..390));
        if (280..320).contains(&x) && (180..220).contains(&y) {
            continue;
        }
        fill(x, y, 10, 10);
    }
    map
}

/// The occupied cells of a map as voxels, in coordinates that begin at the map's origin.
fn voxels(map: &StaticMap) -> Voxels {
    let width = map.geometry.width as usize;
    let occupied = |n: &usize| map.cells[*n] == Occupancy::Occupied;
    let number = |n: usize| i64::try_from(n).unwrap_or(i64::MAX);
    let cells: Vec<IVector> = (0..map.cells.len())
        .filter(occupied)
        .map(|n| IVector::new(number(n % width), number(n / width)))
        .collect();
    Voxels::new(Vector::splat(map.geometry.resolution_m), &cells)
}

/// The same 720 rays, and the same disc beside a wall, through our grid and through voxels.
fn grids(criterion: &mut Criterion) {
    let map = hall(&mut Pcg64Mcg::seed_from_u64(SEED), 60);
    let (grid, voxels) = (SolidGrid::new(&map), voxels(&map));
    let eye = Point2::new(0.02, 0.03);
    let from_origin = Vector::new(eye.x + 15.0, eye.y + 10.0);
    let directions: Vec<Vector2<f64>> = (0..720)
        .map(|n| std::f64::consts::TAU * f64::from(n) / 720.0)
        .map(|angle| Vector2::new(angle.cos(), angle.sin()))
        .collect();
    let ours = || {
        let ray = |direction: &Vector2<f64>| grid.cast(eye, *direction, 30.0);
        directions.iter().filter_map(ray).sum::<f64>()
    };
    let theirs = || {
        let ray = |direction: &Vector2<f64>| {
            let ray = Ray::new(from_origin, Vector::new(direction.x, direction.y));
            voxels.cast_local_ray(&ray, 30.0, true)
        };
        directions.iter().filter_map(ray).sum::<f64>()
    };
    let (a, b) = (ours(), theirs());
    assert!(
        (a - b).abs() < 1.0e-6 * a,
        "the two see another map: {a} and {b}"
    );
    criterion.bench_function("720 bare rays, 600 x 400 cells, grid", |bencher| {
        bencher.iter(|| black_box(ours()));
    });
    criterion.bench_function("720 bare rays, 600 x 400 cells, voxels", |bencher| {
        bencher.iter(|| black_box(theirs()));
    });
    let disc = Ball::new(0.25);
    let in_voxels = Pose2::from_translation(from_origin);
    criterion.bench_function("a disc touches, 600 x 400 cells, voxels", |bencher| {
        bencher.iter(|| {
            query::intersection_test(black_box(&in_voxels), &disc, &Pose2::IDENTITY, &voxels)
        });
    });
    let world = World::new(&WorldSpec::of_map("hall.yaml"), Some(map)).expect("a world");
    let footprint = Footprint::disc(0.25).expect("a disc");
    let on_map = Pose::new(eye.x, eye.y, 0.0);
    criterion.bench_function("a disc touches, 600 x 400 cells, rectangles", |bencher| {
        bencher.iter(|| world.touches(&footprint, black_box(&on_map)));
    });
}

fn scans(criterion: &mut Criterion) {
    let mut rng = Pcg64Mcg::seed_from_u64(SEED);
    let mut lidar = lidar();
    let mut ranges = vec![0.0; 720];
    let at = Pose::new(0.02, 0.03, 0.4);
    for n_shapes in [60, 300] {
        let shapes = room(&mut rng, n_shapes);
        criterion.bench_function(&format!("720 beams, {n_shapes} shapes"), |bencher| {
            bencher.iter(|| {
                let mut exposure = lidar.expose(black_box(&at));
                for shape in &shapes {
                    exposure.add_shape(shape, None);
                }
                exposure.finish(1, black_box(&mut ranges), &mut [])
            });
        });
    }
    let mut turning = presets_lidar();
    let mut swept = vec![0.0; turning.header().n_beams as usize];
    let shapes = room(&mut rng, 300);
    // 1 m/s and 1 rad/s.
    let moving = |age_ns: u64| {
        let age_s = age_ns.to_f64() * 1.0e-9;
        Pose::new(0.02 - age_s, 0.03, 0.4 - age_s)
    };
    criterion.bench_function("RPLidar A1 turning, 300 shapes, all noise", |bencher| {
        bencher.iter(|| {
            let mut exposure = turning.sweep(black_box(moving));
            for shape in &shapes {
                exposure.add_shape(shape, None);
            }
            exposure.finish(1, black_box(&mut swept), &mut [])
        });
    });
    for n_blocks in [0, 60] {
        let grid = SolidGrid::new(&hall(&mut rng, n_blocks));
        let name = format!("720 beams, 600 x 400 cells, {n_blocks} blocks");
        criterion.bench_function(&name, |bencher| {
            bencher.iter(|| {
                let mut exposure = lidar.expose(black_box(&at));
                exposure.add_grid(&grid);
                exposure.finish(1, black_box(&mut ranges), &mut [])
            });
        });
    }
}

criterion_group!(benches, scans, grids);
criterion_main!(benches);
