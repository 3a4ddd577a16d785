//! Maps, obstacles, paths and rollouts.

use crate::{COVARIANCE, PLACE, SPEED, lengths, ranges, short, wire};
use zeronav_msgs::GridGeometry;
use zeronav_msgs::foresight::{Foreseen, Foresight};
use zeronav_msgs::map::{COST_UNKNOWN, CostModel, MapCell, MapInfo, MapTile};
use zeronav_msgs::message::Refusal;
use zeronav_msgs::obstacles::{Obstacle, Obstacles};
use zeronav_msgs::path::{Path, PathStatus, Waypoint};
use zeronav_msgs::rollouts::{Rollout, Rollouts};

/// A map of 40 x 30 cells: two tiles.
fn map() -> MapInfo {
    MapInfo {
        geometry: GridGeometry {
            resolution_m: 0.05,
            width: 40,
            height: 30,
            ..GridGeometry::default()
        },
        revision: 1,
        parts: 1,
        n_tiles: 1,
        clearance_limit_mm: 500,
        ..MapInfo::default()
    }
}

#[test]
// long: one line for each field
fn maps() {
    ranges(
        map(),
        |map| map.check(&[MapTile::default()], 60),
        &[
            (
                "origin_x_m",
                |it, value| it.geometry.origin_x_m = value,
                PLACE,
            ),
            (
                "origin_y_m",
                |it, value| it.geometry.origin_y_m = value,
                PLACE,
            ),
            (
                "resolution_m",
                |it, value| it.geometry.resolution_m = value,
                [1.0e-3, 10.0],
            ),
            (
                "map_from_odom",
                |it, value| it.map_from_odom.x_m = value,
                PLACE,
            ),
            (
                "covariance",
                |it, value| it.covariance[5] = value,
                COVARIANCE,
            ),
            (
                "inscribed_radius_m",
                |it, value| it.cost_model.inscribed_radius_m = value,
                [0.0, 100.0],
            ),
            (
                "padding_m",
                |it, value| it.cost_model.padding_m = value,
                [0.0, 100.0],
            ),
            (
                "inflation_radius_m",
                |it, value| it.cost_model.inflation_radius_m = value,
                [0.0, 100.0],
            ),
            (
                "scaling_per_m",
                |it, value| it.cost_model.scaling_per_m = value,
                [0.0, 1.0e6],
            ),
            ("way_out", |it, value| it.way_out.until_m[1] = value, PLACE),
            (
                "way_out.radius_m",
                |it, value| it.way_out.radius_m = value,
                [0.0, PLACE[1]],
            ),
        ],
    );
    let changed = |change: fn(&mut MapInfo)| {
        let mut info = map();
        change(&mut info);
        info.check(&[MapTile::default()], 60)
    };
    let out = |field| Err(Refusal::OutOfRange(field));
    assert_eq!(changed(|it| it.geometry.width = 0), out("width"));
    assert_eq!(changed(|it| it.geometry.width = 8193), out("width"));
    assert_eq!(changed(|it| it.geometry.height = 0), out("height"));
    assert_eq!(changed(|it| it.geometry.height = 8192), Ok(()));
    assert_eq!(changed(|it| it.geometry.height = 8193), out("height"));
    assert_eq!(changed(|it| it.revision = 0), Err(Refusal::Identity));
    assert_eq!(changed(|it| it.parts = 0), out("part"));
    assert_eq!(changed(|it| (it.part, it.parts) = (2, 3)), Ok(()));
    assert_eq!(changed(|it| (it.part, it.parts) = (3, 3)), out("part"));
    assert_eq!(
        changed(|it| it.clearance_limit_mm = 0),
        out("clearance_limit_mm")
    );
    assert_eq!(changed(|it| it.clearance_limit_mm = 65_535), Ok(()));
    assert_eq!(
        changed(|it| it.clearance_limit_mm = 65_536),
        out("clearance_limit_mm")
    );
    assert_eq!(changed(|it| it.current = 1), Ok(()));
    assert_eq!(changed(|it| it.current = 2), Err(Refusal::Code("current")));
    lengths(("tiles", 0, 60), MapTile::default(), |n_tiles, tiles| {
        MapInfo { n_tiles, ..map() }.check(tiles, 60)
    });
}

#[test]
fn tiles() {
    let changed = |change: fn(&mut MapTile)| {
        let mut tile = MapTile::default();
        change(&mut tile);
        map().check(&[tile], 60)
    };
    let out = |field| Err(Refusal::OutOfRange(field));
    assert_eq!(changed(|it| it.tile_x = 1), Ok(()));
    assert_eq!(changed(|it| it.tile_x = 2), out("tile"));
    assert_eq!(changed(|it| it.tile_y = 1), out("tile"));
    assert_eq!(changed(|it| it.cells[1023].clearance_mm = 500), Ok(()));
    assert_eq!(changed(|it| it.cells[1023].clearance_mm = 501), out("cell"));
    assert_eq!(changed(|it| it.cells[0].flags = 0b11_1111), Ok(()));
    assert_eq!(changed(|it| it.cells[0].flags = 0b100_0000), out("cell"));
}

/// Costs as Nav2 has them, at both sides of every step.
#[test]
fn costs_follow_the_clearance() {
    let model = CostModel {
        inscribed_radius_m: 0.2,
        padding_m: 0.05,
        inflation_radius_m: 0.6,
        scaling_per_m: 4.0,
    };
    for (clearance_m, cost) in [
        (-1.0, 254),
        (0.0, 254),
        (0.001, 253),
        (0.2, 253),
        (0.22, 253),
        (0.249_99, 253),
        (0.25, 252),
        // 252 exp(-4 x 0.1) = 168.9, 252 exp(-4 x 0.35) = 62.1
        (0.35, 168),
        (0.6, 62),
        (0.601, 0),
        (9.0, 0),
    ] {
        assert_eq!(model.cost(clearance_m), cost, "{clearance_m} m");
    }
    let bare = CostModel {
        padding_m: 0.0,
        ..model
    };
    assert_eq!(
        [0.2, 0.200_01, 0.201].map(|m| bare.cost(m)),
        [253, 251, 250]
    );
    let cell = MapCell {
        clearance_mm: 1250,
        ..MapCell::unknown(0)
    };
    assert!((cell.clearance_m() - 1.25).abs() < 1e-12);
    let blocks =
        [0, 252, 253, 254, COST_UNKNOWN].map(|cost| MapCell { cost, ..cell }.blocks_centre());
    assert_eq!(blocks, [false, false, true, true, false]);
}

#[test]
fn obstacles() {
    ranges(
        Obstacle::default(),
        |obstacle| Obstacles { n_obstacles: 1 }.check(&[*obstacle]),
        &[
            ("x_m", |it, value| it.x_m = value, PLACE),
            ("y_m", |it, value| it.y_m = value, PLACE),
            ("vx_mps", |it, value| it.vx_mps = value, SPEED),
            ("vy_mps", |it, value| it.vy_mps = value, SPEED),
            ("radius_m", |it, value| it.radius_m = value, [0.0, 10.0]),
            ("age_s", |it, value| it.age_s = value, [0.0, 1.0e9]),
            ("unseen_s", |it, value| it.unseen_s = value, [0.0, 1.0e9]),
            (
                "covariance",
                |it, value| it.covariance[9] = value,
                COVARIANCE,
            ),
        ],
    );
    lengths(
        ("obstacles", 0, 128),
        Obstacle::default(),
        |n, obstacles| {
            Obstacles {
                n_obstacles: u64::from(n),
            }
            .check(obstacles)
        },
    );
    let guess = [0.0, 0.3, 0.31].map(|unseen_s| {
        Obstacle {
            unseen_s,
            ..Obstacle::default()
        }
        .is_guess()
    });
    assert_eq!(guess, [false, false, true]);
}

#[test]
fn what_moves_in_the_future() {
    ranges(
        (
            Foresight {
                n_obstacles: 1,
                ..Foresight::default()
            },
            Foreseen::default(),
        ),
        |(meta, obstacle)| meta.check(&[*obstacle]),
        &[
            ("pose", |it, value| it.0.pose.y_m = value, PLACE),
            ("vx_mps", |it, value| it.1.vx_mps = value, SPEED),
            ("vy_mps", |it, value| it.1.vy_mps = value, SPEED),
            ("radius_m", |it, value| it.1.radius_m = value, [0.0, 10.0]),
            ("lasts_s", |it, value| it.1.lasts_s = value, [0.0, 1.0e9]),
            ("x_m or y_m", |it, value| it.1.x_m[63] = value, PLACE),
            ("x_m or y_m", |it, value| it.1.y_m[63] = value, PLACE),
        ],
    );
    lengths(
        ("obstacles", 0, 128),
        Foreseen::default(),
        |n, obstacles| {
            Foresight {
                n_obstacles: u64::from(n),
                ..Foresight::default()
            }
            .check(obstacles)
        },
    );
}

#[test]
// long: one line for each field
fn paths() {
    let path = Path {
        status: PathStatus::Found.code(),
        n_waypoints: 1,
        cost: 5.0,
        ..Path::default()
    };
    ranges(
        (path, Waypoint::default()),
        |(path, waypoint)| path.check(&[*waypoint]),
        &[
            ("block_m", |it, value| it.0.block_m[1] = value, PLACE),
            ("length_m", |it, value| it.0.length_m = value, [0.0, 1.0e9]),
            ("cost", |it, value| it.0.cost = value, [0.0, 1.0e15]),
            ("bound", |it, value| it.0.bound = value, [0.0, 5.0]),
            (
                "beside_goal_m",
                |it, value| it.0.beside_goal_m = value,
                [0.0, 1.0e9],
            ),
            ("x_m", |it, value| it.1.x_m = value, PLACE),
            ("y_m", |it, value| it.1.y_m = value, PLACE),
            (
                "yaw_rad",
                |it, value| it.1.yaw_rad = short(value),
                [-6.3, 6.3].map(wire),
            ),
            (
                "clearance_m",
                |it, value| it.1.clearance_m = short(value),
                [0.0, 1.0e3],
            ),
        ],
    );
    lengths(
        ("waypoints", 1, 2048),
        Waypoint::default(),
        |n_waypoints, waypoints| {
            let status = PathStatus::Found.code();
            Path {
                status,
                n_waypoints,
                ..Path::default()
            }
            .check(waypoints)
        },
    );
    let without = Path {
        status: PathStatus::Unreachable.code(),
        ..Path::default()
    };
    assert_eq!(without.check(&[]), Ok(()));
    let with = Path {
        n_waypoints: 1,
        ..without
    };
    assert_eq!(
        with.check(&[Waypoint::default()]),
        Err(Refusal::Length("waypoints"))
    );
    let coded = |change: fn(&mut Path)| {
        let mut path = without;
        change(&mut path);
        path.check(&[])
    };
    assert_eq!(coded(|it| it.status = 11), Err(Refusal::Code("status")));
    assert_eq!(coded(|it| it.cause = 7), Err(Refusal::Code("cause")));
    assert_eq!(coded(|it| it.block = 6), Err(Refusal::Code("block")));
    assert_eq!(coded(|it| it.source = 6), Err(Refusal::Code("source")));
    assert_eq!(
        coded(|it| it.planner = Path::planner_bytes("theta_star")),
        Ok(())
    );
    assert_eq!(
        coded(|it| it.planner[3] = b' '),
        Err(Refusal::OutOfRange("planner"))
    );
    assert_eq!(
        coded(|it| it.planner[3] = 0xff),
        Err(Refusal::OutOfRange("planner"))
    );
}

fn rollout() -> Rollout {
    Rollout {
        n_points: 1,
        ..Rollout::default()
    }
}

#[test]
fn rollouts() {
    ranges(
        (
            Rollouts {
                n_rollouts: 1,
                ..Rollouts::default()
            },
            rollout(),
        ),
        |(meta, rollout)| meta.check(&[*rollout]),
        &[
            (
                "map_from_base",
                |it, value| it.0.map_from_base.x_m = value,
                PLACE,
            ),
            ("v_mps", |it, value| it.1.v_mps = short(value), SPEED),
            ("w_radps", |it, value| it.1.w_radps = short(value), SPEED),
            (
                "cost",
                |it, value| it.1.cost = short(value),
                [-1.0e9, 1.0e9],
            ),
            ("x_m", |it, value| it.1.x_m[11] = short(value), PLACE),
            ("y_m", |it, value| it.1.y_m[11] = short(value), PLACE),
        ],
    );
    lengths(("rollouts", 0, 64), rollout(), |n, rollouts| {
        Rollouts {
            n_rollouts: u64::from(n),
            ..Rollouts::default()
        }
        .check(rollouts)
    });
    let points = |n_points| {
        let meta = Rollouts {
            n_rollouts: 1,
            ..Rollouts::default()
        };
        meta.check(&[Rollout {
            n_points,
            ..rollout()
        }])
    };
    let wrong = Err(Refusal::OutOfRange("n_points"));
    assert_eq!([0, 1, 12, 13].map(points), [wrong, Ok(()), Ok(()), wrong]);
    let two = Rollout {
        n_points: 2,
        x_m: [1.5; 12],
        y_m: [2.5; 12],
        ..rollout()
    };
    assert_eq!(two.points_m().collect::<Vec<_>>(), [[1.5, 2.5]; 2]);
}
