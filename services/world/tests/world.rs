//! A world is asked, with answers worked out by hand.

use core::f64::consts::{FRAC_PI_2, PI};
use zeronav_msgs::{Cell, GridGeometry, Pose};
use zeronav_world::spec::{Near, Trigger};
use zeronav_world::{
    Footprint, ObstacleSpec, Occupancy, ShapeSpec, StaticMap, Tolerance, World, WorldSpec,
};

fn a_box(centre_m: [f64; 2], size_m: [f64; 2]) -> ShapeSpec {
    ShapeSpec::Box {
        centre_m,
        size_m,
        yaw_rad: 0.0,
    }
}

fn spec(shapes: Vec<ShapeSpec>) -> WorldSpec {
    WorldSpec {
        resolution_m: 0.1,
        shapes,
        ..WorldSpec::area([0.0, 0.0], [10.0, 5.0])
    }
}

fn obstacle(name: &str, shape: ShapeSpec) -> ObstacleSpec {
    ObstacleSpec::standing(name, shape)
}

/// A map file's world of 1 m cells: a wall in column 4 with a gap in row 2.
fn grid_world(shapes: Vec<ShapeSpec>) -> World {
    let geometry = GridGeometry {
        origin_x_m: -1.0,
        origin_y_m: 0.0,
        resolution_m: 1.0,
        width: 10,
        height: 5,
    };
    let mut map = StaticMap::free(geometry);
    for y in [0, 1, 3, 4] {
        map.cells[y * 10 + 4] = Occupancy::Occupied;
    }
    map.cells[0] = Occupancy::Unknown;
    let mut spec = spec(shapes);
    spec.area_m = None;
    spec.map = Some("wall.yaml".into());
    World::new(&spec, Some(map)).unwrap()
}

#[track_caller]
fn near(actual: f64, expected: f64) {
    assert!(
        (actual - expected).abs() < 1e-9,
        "{actual} instead of {expected}"
    );
}

#[test]
fn distances_are_from_the_outline_to_the_nearest_thing() {
    let world = World::new(
        &spec(vec![
            a_box([5.0, 2.5], [1.0, 5.0]),
            ShapeSpec::Disc {
                centre_m: [1.0, 4.0],
                radius_m: 0.5,
            },
        ]),
        None,
    )
    .unwrap();
    let disc = Footprint::disc(0.25).unwrap();
    near(world.distance_m(&disc, &Pose::new(3.0, 1.0, 0.0)), 1.25);
    near(world.distance_m(&disc, &Pose::new(1.0, 2.0, 0.0)), 1.25);
    assert!(!world.touches(&disc, &Pose::new(4.2, 1.0, 0.0)));
    assert!(world.touches(&disc, &Pose::new(4.3, 1.0, 0.0)));
    near(world.point_distance_m([5.0, 1.0].into()), 0.0);
    // A long robot touches with its nose only when it looks that way.
    let long = Footprint::polygon(&[[-0.2, -0.2], [1.0, -0.2], [1.0, 0.2], [-0.2, 0.2]]).unwrap();
    near(world.distance_m(&long, &Pose::new(3.4, 1.0, 0.0)), 0.1);
    near(world.distance_m(&long, &Pose::new(3.4, 1.0, PI)), 0.9);
    near(
        world.distance_m(&long, &Pose::new(3.4, 1.0, FRAC_PI_2)),
        0.9,
    );
}

#[test]
fn an_empty_world_is_infinitely_far() {
    let world = World::new(&spec(Vec::new()), None).unwrap();
    let disc = Footprint::disc(0.25).unwrap();
    assert!(world.distance_m(&disc, &Pose::default()).is_infinite());
    assert!(!world.touches(&disc, &Pose::default()));
    assert_eq!((world.geometry().width, world.geometry().height), (100, 50));
    assert!(world.static_map().is_none());
    assert_eq!(world.rasterise().count(Occupancy::Free), 5000);
}

#[test]
fn cells_of_a_map_file_are_solid_squares() {
    let world = grid_world(Vec::new());
    // The wall's cells cover x 3 to 4.
    assert_eq!(world.occupied_rectangles().len(), 2);
    let disc = Footprint::disc(0.25).unwrap();
    near(world.distance_m(&disc, &Pose::new(2.0, 1.0, 0.0)), 0.75);
    near(world.distance_m(&disc, &Pose::new(3.5, 2.5, 0.0)), 0.25);
    assert!(world.touches(&disc, &Pose::new(3.5, 2.2, 0.0)));
    // The unknown cell is not.
    near(world.distance_m(&disc, &Pose::new(-0.5, 0.5, 0.0)), 3.25);
    assert!(world.contains([-1.0, 0.0].into()));
    assert!(!world.contains([9.0, 0.5].into()));
}

#[test]
fn shapes_are_drawn_into_a_map_file() {
    let world = grid_world(vec![
        a_box([-0.5, 0.5], [0.2, 0.2]),
        a_box([6.0, 2.5], [0.2, 0.2]),
    ]);
    let map = world.rasterise();
    assert_eq!(map.get(Cell::new(0, 0)), Some(Occupancy::Occupied));
    assert_eq!(map.get(Cell::new(6, 2)), Some(Occupancy::Occupied));
    assert_eq!(map.get(Cell::new(7, 2)), Some(Occupancy::Occupied));
    assert_eq!(map.count(Occupancy::Occupied), 4 + 3);
    assert_eq!(
        world.static_map().unwrap().count(Occupancy::Occupied),
        4,
        "the map file's own cells stay as they are"
    );
    let disc = Footprint::disc(0.25).unwrap();
    near(world.distance_m(&disc, &Pose::new(6.0, 3.5, 0.0)), 0.65);
}

#[test]
fn obstacles_count_only_where_they_are() {
    let mut spec = spec(vec![a_box([9.5, 2.5], [1.0, 5.0])]);
    spec.obstacles = vec![
        obstacle("crate", a_box([5.0, 2.5], [1.0, 1.0])),
        obstacle("drum", a_box([2.0, 2.5], [1.0, 1.0])),
    ];
    let world = World::new(&spec, None).unwrap();
    let disc = Footprint::disc(0.5).unwrap();
    let at = Pose::new(7.0, 2.5, 0.0);
    near(world.distance_m(&disc, &at), 1.5);
    near(world.distance_with_obstacles_m(&disc, &at, []), 1.5);
    let crate_at = |x: f64, yaw: f64| [(0, Pose::new(x, 2.5, yaw))];
    near(
        world.distance_with_obstacles_m(&disc, &at, crate_at(5.0, 0.0)),
        1.0,
    );
    near(
        world.distance_with_obstacles_m(&disc, &at, crate_at(6.0, 0.0)),
        0.0,
    );
    let turned = 1.5 - 0.5_f64.sqrt();
    near(
        world.distance_with_obstacles_m(&disc, &at, crate_at(5.0, PI / 4.0)),
        turned,
    );
    near(world.distance_with_obstacles_m(&disc, &at, [(7, at)]), 1.5);
    assert!(world.obstacles()[0].is_there_from_the_start());
}

#[test]
fn a_free_pose_is_found_through_a_narrow_gap_only_when_it_is_wide_enough() {
    // Two walls leave 0.52 m around y = 1.3, beside the goal.
    let walls = |gap_m: f64| {
        let low = 1.3 - gap_m / 2.0;
        let high = 1.3 + gap_m / 2.0;
        spec(vec![
            a_box([5.0, low - 5.0], [20.0, 10.0]),
            a_box([5.0, high + 5.0], [20.0, 10.0]),
        ])
    };
    let disc = Footprint::disc(0.25).unwrap();
    let tolerance = Tolerance {
        distance_m: 0.4,
        yaw_rad: PI,
    };
    let goal = Pose::new(5.0, 1.0, 0.3);
    let wide = World::new(&walls(0.51), None).unwrap();
    let pose = wide.free_pose_near(&disc, &goal, tolerance).unwrap();
    assert!(!wide.touches(&disc, &pose));
    assert!(pose.distance_m(&goal) <= 0.4);
    near(pose.yaw_rad, 0.3);
    let narrow = World::new(&walls(0.49), None).unwrap();
    assert_eq!(narrow.free_pose_near(&disc, &goal, tolerance), None);
    let strict = Tolerance {
        distance_m: 0.2,
        yaw_rad: PI,
    };
    assert_eq!(wide.free_pose_near(&disc, &goal, strict), None);
}

#[test]
fn the_nearest_free_pose_keeps_its_clearance_and_lies_on_the_map() {
    // A block of 2 m by 2 m around (5, 2.5).
    let world = World::new(&spec(vec![a_box([5.0, 2.5], [2.0, 2.0])]), None).unwrap();
    let disc = Footprint::disc(0.25).unwrap();
    let goal = Pose::new(5.2, 2.5, 0.3);
    let pose = world
        .nearest_free_pose(&disc, &goal, PI, 0.1, |_| true)
        .unwrap();
    assert!(world.distance_m(&disc, &pose) >= 0.1);
    // 0.8 m to the right side of the block, the radius and the clearance, at most a ring more.
    let way_m = pose.distance_m(&goal);
    assert!((1.15..=1.25).contains(&way_m), "{way_m} m");
    near(pose.yaw_rad, 0.3);
    let outside = Pose::new(900.0, -900.0, 0.0);
    let pose = world
        .nearest_free_pose(&disc, &outside, PI, 0.0, |_| true)
        .unwrap();
    assert!(world.contains(pose.point()), "{pose:?}");
    assert_eq!(
        world.nearest_free_pose(&disc, &goal, PI, 50.0, |_| true),
        None
    );
}

#[test]
fn a_long_robot_fits_only_with_a_yaw_that_the_goal_allows() {
    // A corridor along x, 0.6 m wide.
    let world = World::new(
        &spec(vec![
            a_box([5.0, 1.1], [20.0, 2.2]),
            a_box([5.0, 3.9], [20.0, 2.2]),
        ]),
        None,
    )
    .unwrap();
    let long = Footprint::polygon(&[[-0.5, -0.2], [0.5, -0.2], [0.5, 0.2], [-0.5, 0.2]]).unwrap();
    let across = Pose::new(5.0, 2.5, FRAC_PI_2);
    let tolerance = |yaw_rad| Tolerance {
        distance_m: 0.1,
        yaw_rad,
    };
    let found = world.free_pose_near(&long, &across, tolerance(PI)).unwrap();
    assert!(!world.touches(&long, &found));
    assert_eq!(world.free_pose_near(&long, &across, tolerance(0.5)), None);
}

#[test]
fn a_goal_beside_the_map_has_no_free_pose() {
    let world = World::new(&spec(Vec::new()), None).unwrap();
    let disc = Footprint::disc(0.25).unwrap();
    let tolerance = Tolerance {
        distance_m: 0.25,
        yaw_rad: PI,
    };
    let beside = Pose::new(10.3, 2.0, 0.0);
    assert_eq!(world.free_pose_near(&disc, &beside, tolerance), None);
    let just_beside = Pose::new(10.2, 2.0, 0.0);
    let pose = world.free_pose_near(&disc, &just_beside, tolerance);
    assert!(pose.unwrap().x_m < 10.0);
}

#[track_caller]
fn refused(field: &str, change: impl FnOnce(&mut WorldSpec)) {
    let mut wrong = spec(vec![a_box([1.0, 1.0], [1.0, 1.0])]);
    wrong.obstacles = vec![obstacle("crate", a_box([5.0, 2.5], [1.0, 1.0]))];
    assert!(World::new(&wrong, None).is_ok());
    change(&mut wrong);
    assert_eq!(World::new(&wrong, None).unwrap_err().field, field);
}

// long: one line per value that can be wrong
#[test]
#[allow(
    clippy::too_many_lines,
    reason = "one line per value that can be wrong"
)]
fn every_wrong_value_is_named() {
    refused("area_m", |w| w.area_m = None);
    refused("area_m", |w| w.area_m = Some([[5.0, 0.0], [0.0, 5.0]]));
    refused("area_m", |w| w.area_m = Some([[0.0, 0.0], [900.0, 5.0]]));
    refused("area_m[1][0]", |w| {
        w.area_m = Some([[0.0, 0.0], [f64::NAN, 5.0]]);
    });
    refused("resolution_m", |w| w.resolution_m = 0.0);
    refused("map", |w| w.map = Some("not_read.yaml".into()));
    refused("shapes[1].size_m[0]", |w| {
        w.shapes.push(a_box([0.0, 0.0], [-1.0, 1.0]));
    });
    let wrong_obstacle =
        |change: fn(&mut ObstacleSpec)| move |w: &mut WorldSpec| change(&mut w.obstacles[0]);
    refused("obstacles[0].name", wrong_obstacle(|o| o.name.clear()));
    refused(
        "obstacles[0].shape.size_m[1]",
        wrong_obstacle(|o| o.shape = a_box([0.0, 0.0], [1.0, 0.0])),
    );
    refused(
        "obstacles[0].lasts_s",
        wrong_obstacle(|o| o.lasts_s = Some(-1.0)),
    );
    refused(
        "obstacles[0].speed_mps",
        wrong_obstacle(|o| o.waypoints_m = vec![[1.0, 1.0]]),
    );
    refused(
        "obstacles[0].speed_mps",
        wrong_obstacle(|o| o.speed_mps = 1.0),
    );
    refused("obstacles[0].repeat", wrong_obstacle(|o| o.repeat = true));
    refused(
        "obstacles[0].track_from_s",
        wrong_obstacle(|o| o.track_from_s = 1.0),
    );
    refused(
        "obstacles[0].starts",
        wrong_obstacle(|o| {
            o.starts = Some(Trigger {
                at_s: Some(1.0),
                robot_near: None,
            });
        }),
    );
    refused(
        "obstacles[0].bounces_mps",
        wrong_obstacle(|o| o.bounces_mps = Some([1.0, 0.0])),
    );
    refused(
        "obstacles[0].bounces_mps[1]",
        wrong_obstacle(|o| o.bounces_mps = Some([1.0, f64::NAN])),
    );
    refused(
        "obstacles[0].track[1][0]",
        wrong_obstacle(|o| o.track = vec![[0.0, 1.0, 1.0], [0.0, 2.0, 2.0]]),
    );
    refused(
        "obstacles[0].track",
        wrong_obstacle(|o| o.track = vec![[0.0, 1.0, 1.0], [1.0e-6, 2.0, 2.0]]),
    );
    refused(
        "obstacles[0].track",
        wrong_obstacle(|o| {
            o.track = vec![[0.0, 1.0, 1.0], [1.0, 2.0, 2.0]];
            (o.waypoints_m, o.speed_mps) = (vec![[1.0, 1.0]], 1.0);
        }),
    );
    refused(
        "obstacles[0].appears",
        wrong_obstacle(|o| {
            o.appears = Some(Trigger {
                at_s: None,
                robot_near: None,
            });
        }),
    );
    refused(
        "obstacles[0].appears.robot_near.distance_m",
        wrong_obstacle(|o| {
            o.appears = Some(Trigger {
                at_s: None,
                robot_near: Some(Near {
                    point_m: [0.0, 0.0],
                    distance_m: 0.0,
                }),
            });
        }),
    );
    refused(
        "obstacles[0].appears",
        wrong_obstacle(|o| {
            o.appears = Some(Trigger {
                at_s: Some(1.0),
                robot_near: Some(Near {
                    point_m: [0.0, 0.0],
                    distance_m: 1.0,
                }),
            });
        }),
    );
    refused("obstacles[1].name", |w| {
        w.obstacles.push(w.obstacles[0].clone());
    });
    refused("obstacles", |w| {
        w.obstacles = (0..257)
            .map(|n| obstacle(&n.to_string(), a_box([1.0, 1.0], [1.0, 1.0])))
            .collect();
    });
}

#[test]
fn a_static_map_that_contradicts_itself_is_refused() {
    let mut with_map = spec(Vec::new());
    with_map.area_m = None;
    with_map.map = Some("map.yaml".into());
    let geometry = *grid_world(Vec::new()).geometry();
    let mut short = StaticMap::free(geometry);
    short.cells.pop();
    assert_eq!(World::new(&with_map, Some(short)).unwrap_err().field, "map");
    let empty = StaticMap::free(GridGeometry {
        width: 0,
        ..geometry
    });
    assert_eq!(World::new(&with_map, Some(empty)).unwrap_err().field, "map");
    let good = || Some(StaticMap::free(geometry));
    assert!(World::new(&with_map, good()).is_ok());
    with_map.area_m = Some([[0.0, 0.0], [1.0, 1.0]]);
    assert_eq!(World::new(&with_map, good()).unwrap_err().field, "area_m");
    assert_eq!(World::new(&spec(Vec::new()), None).map(|_| ()), Ok(()));
}
