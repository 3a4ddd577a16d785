//! The scenarios of this program do what their descriptions say: checked on the drawn world, so
//! that a moved rack is found here and not in a run that takes minutes.

use super::{Checked, Library, Outcome, Scenario};
use std::collections::VecDeque;
use tempfile::TempDir;
use zeronav_msgs::{Cell, Pose};
use zeronav_world::{Convex, ShapeSpec, WorldSpec};

/// The built-in scenario, read from a folder without files.
fn built_in(name: &str) -> (Scenario, Checked) {
    let empty = TempDir::new().unwrap();
    let scenario = Scenario::load_from(&Library::of(empty.path()), name).unwrap();
    let checked = scenario.validate().unwrap();
    (scenario, checked)
}

/// True when a disc of the robot's size plus `margin_m` gets from `from` to `to` past all static
/// things and, when asked, past the obstacles where they appear. Breadth first over cell centres.
fn leads_to(checked: &Checked, from: &Pose, to: &Pose, obstacles: bool, margin_m: f64) -> bool {
    let world = &checked.world;
    let geometry = world.geometry();
    let radius_m = checked.footprint.inscribed_radius_m() + margin_m;
    let free = |cell: Cell| {
        let centre = geometry.centre_of(cell);
        let disc = Convex::disc(centre, radius_m);
        let there =
            |obstacle: &zeronav_world::Obstacle| disc.distance_m(obstacle.shape.placed()) <= 0.0;
        world.contains(centre)
            && world.convex_distance_m(&disc, 1.0) > 0.0
            && !(obstacles && world.obstacles().iter().any(there))
    };
    let (Some(start), Some(goal)) = (geometry.cell_at(from.point()), geometry.cell_at(to.point()))
    else {
        return false;
    };
    let mut seen = vec![false; geometry.len()];
    let mut queue = VecDeque::from([start]);
    while let Some(cell) = queue.pop_front() {
        if cell == goal {
            return true;
        }
        for (dx, dy) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
            let next = Cell::new(cell.x + dx, cell.y + dy);
            if let Some(index) = geometry.index_of(next)
                && !seen[index]
            {
                seen[index] = true;
                if free(next) {
                    queue.push_back(next);
                }
            }
        }
    }
    false
}

fn goal(scenario: &Scenario) -> Pose {
    scenario.goals[0].pose
}

/// The world with another thing in it.
fn with(scenario: &Scenario, shape: ShapeSpec) -> Checked {
    let mut changed = scenario.clone();
    changed.world = WorldSpec {
        shapes: scenario
            .world
            .shapes
            .iter()
            .cloned()
            .chain([shape])
            .collect(),
        ..scenario.world.clone()
    };
    changed.validate().unwrap()
}

fn plug(x: f64, y: f64) -> ShapeSpec {
    ShapeSpec::Box {
        centre_m: [x, y],
        size_m: [0.5, 2.05],
        yaw_rad: 0.0,
    }
}

#[test]
fn the_drawn_files_and_the_built_in_ones_are_the_same() {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    let (here, nowhere) = (Library::of(root), Library::of("/nowhere"));
    let names = |library: &Library| -> Vec<String> {
        library.list().into_iter().map(|one| one.name).collect()
    };
    assert_eq!(names(&here), names(&nowhere));
    for name in names(&nowhere) {
        let scenario = Scenario::load_from(&nowhere, &name).unwrap();
        assert!(scenario.world.map.is_none(), "{name} needs a map file");
        assert!(!scenario.description.is_empty(), "{name}");
        let file = Scenario::load_from(&here, &name).unwrap();
        assert_eq!(file.world, scenario.world, "{name}");
        assert!(!scenario.group.is_empty(), "{name} is in no group");
        scenario.validate().unwrap();
    }
}

#[test]
fn the_readme_names_every_scenario() {
    let readme = include_str!("../../README.md");
    for listed in Library::of("/nowhere").list() {
        let name = format!("`{}`", listed.name);
        assert!(
            readme.contains(&name),
            "launch/README.md does not name {name}"
        );
    }
}

#[test]
fn the_warehouse_has_exactly_two_ways() {
    let (open, checked) = built_in("open_aisle");
    let (start, goal) = (open.start, goal(&open));
    assert!(leads_to(&checked, &start, &goal, true, 0.5));
    let (south, north) = (plug(15.0, 6.425), plug(15.0, 13.575));
    let south_shut = with(&open, south);
    assert!(leads_to(&south_shut, &start, &goal, true, 0.5));
    let north_shut = with(&open, north.clone());
    assert!(leads_to(&north_shut, &start, &goal, true, 0.5));
    let mut both = open.clone();
    both.world.shapes.push(plug(15.0, 6.425));
    assert!(!leads_to(&with(&both, north), &start, &goal, true, -0.15));
    assert_eq!(open.expect.obstacle_replans_max, Some(0));
}

#[test]
fn the_load_shuts_the_aisle_in_front_of_the_robot() {
    let (blocked, checked) = built_in("blocked_aisle");
    let load = &checked.world.obstacles()[0];
    let near = load.spec.appears.as_ref().unwrap().robot_near.as_ref();
    let near = near.unwrap();
    let radius_m = checked.footprint.inscribed_radius_m();
    // Wherever in the aisle the robot comes along: its nose stops well before the load.
    let load_at = load.shape.placed().bounds();
    for y in [5.4 + radius_m, 6.0, 6.425, 7.0, 7.45 - radius_m] {
        let dy = y - near.point_m[1];
        let x = near.point_m[0] - (near.distance_m.powi(2) - dy * dy).sqrt();
        let gap_m = load_at.mins.x - x - radius_m;
        assert!((2.3..3.0).contains(&gap_m), "{gap_m} m at y {y}");
        assert!(x > 7.0, "already in the aisle");
    }
    // Through the aisle there is no way left, not even for half a robot; around there is.
    let (start, goal) = (blocked.start, goal(&blocked));
    let north_shut = with(&blocked, plug(15.0, 13.575));
    assert!(leads_to(&north_shut, &start, &goal, false, 0.5));
    assert!(!leads_to(&north_shut, &start, &goal, true, -0.13));
    assert!(leads_to(&checked, &start, &goal, true, 0.5));
    assert_eq!(blocked.expect.obstacle_replans_min, Some(1));
}

#[test]
fn the_sealed_room_is_sealed_and_nobody_sees_it_from_the_start() {
    let (sealed, checked) = built_in("sealed");
    let (start, goal) = (sealed.start, goal(&sealed));
    assert_eq!(sealed.expect.outcome, Outcome::Unreachable);
    assert!(leads_to(&checked, &start, &goal, false, 0.2));
    assert!(!leads_to(&checked, &start, &goal, true, -0.2));
    for obstacle in checked.world.obstacles() {
        assert!(obstacle.is_there_from_the_start());
        for corner in obstacle.shape.outline() {
            let steps = 400;
            let hidden = (1..steps).any(|step| {
                let along = f64::from(step) / f64::from(steps);
                let at = start.point() + (corner - start.point()) * along;
                checked.world.point_distance_m(at) <= 0.0
            });
            assert!(hidden, "{} shows a corner {corner}", obstacle.spec.name);
        }
    }
    let (unsealed, checked) = built_in("unsealed");
    assert_eq!(unsealed.expect.outcome, Outcome::Reached);
    assert_eq!(unsealed.world.shapes, sealed.world.shapes);
    assert!(checked.world.obstacles().is_empty());
}

#[test]
fn the_text_of_every_scenario_says_the_same_without_what_it_builds_on() {
    for listed in Library::of("/nowhere").list() {
        let (scenario, _) = built_in(&listed.name);
        let text = scenario.to_toml(42).unwrap();
        let read = Scenario::of_text(&listed.name, &text).unwrap();
        let read = read
            .whole()
            .unwrap_or_else(|error| panic!("{}: {error}", listed.name));
        let mut expected = scenario;
        expected.run.seed = 42;
        let json = |scenario: &Scenario| serde_json::to_value(scenario).unwrap();
        assert_eq!(json(&read), json(&expected), "{}", listed.name);
        // TOML has no number for it.
        let text = expected.to_toml(u64::MAX).unwrap();
        let read = Scenario::of_text(&listed.name, &text).unwrap();
        assert_eq!(read.scenario.run.seed, 42);
    }
}
