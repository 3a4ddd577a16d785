//! The kinds of worlds. A kind is a function and a row of [`KINDS`].

use super::robots::{self, Body};
use super::scene::{Aim, Scene, WALL_M};
use core::f64::consts::{FRAC_PI_2, PI};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use toml::Table;
use zeronav_msgs::Pose;
use zeronav_robot_description::RobotPreset;
use zeronav_world::spec::{ObstacleSpec, ShapeSpec};

/// A kind of worlds.
pub(super) struct Kind {
    /// For names and groups.
    pub(super) label: &'static str,
    /// Draws one.
    pub(super) draw: fn(&mut Pcg64Mcg) -> Scene,
}

/// All kinds: world N is of kind N modulo their number.
pub(super) const KINDS: [Kind; 12] = [
    kind("beside_wall", beside_wall),
    kind("dock", dock),
    kind("reverse", reverse),
    kind("corner", corner),
    kind("far_door", far_door),
    kind("late_drive", late_drive),
    kind("wheel_slip", wheel_slip),
    kind("blind_lidar", blind_lidar),
    kind("pause", pause),
    kind("slow_turner", slow_turner),
    kind("oncoming", oncoming),
    kind("short_returns", short_returns),
];

const fn kind(label: &'static str, draw: fn(&mut Pcg64Mcg) -> Scene) -> Kind {
    Kind { label, draw }
}

/// Of the usual hall. [m]
const HALL_M: [f64; 2] = [14.0, 8.0];

/// A robot stands beside a wall, parallel to it, and has to leave.
fn beside_wall(random: &mut Pcg64Mcg) -> Scene {
    let body = robots::with_corners(random);
    let gap_m = random.random_range(0.02..0.25);
    let left = random.random_bool(0.5);
    let off_m = WALL_M + gap_m + body.side_m;
    let y_m = if left { HALL_M[1] - off_m } else { off_m };
    let goal = match random.random_range(0..3) {
        0 => Aim::place(10.0, y_m),
        1 => Aim::place(
            random.random_range(7.0..12.0),
            random.random_range(2.0..6.0),
        ),
        _ => Aim::place(random.random_range(1.5..3.0), random.random_range(2.0..6.0)),
    };
    let title = format!("{} stands {gap_m:.3} m beside a wall", body.name);
    let mut scene = Scene::hall(title, HALL_M, body);
    scene.start = Pose::new(4.5, y_m, 0.0);
    scene.goals = vec![goal];
    scene
}

/// The goal is parallel to a wall and beside it.
fn dock(random: &mut Pcg64Mcg) -> Scene {
    let body = robots::with_corners(random);
    let gap_m = random.random_range(0.06..0.12);
    let yaw_rad = if random.random_bool(0.5) { 0.0 } else { PI };
    let title = format!(
        "{} has to stop parallel to a wall, {gap_m:.3} m beside it",
        body.name
    );
    let y_m = WALL_M + gap_m + body.side_m;
    let mut scene = Scene::hall(title, HALL_M, body);
    scene.start = Pose::new(
        random.random_range(2.0..12.0),
        random.random_range(2.5..6.5),
        random.random_range(-PI..PI),
    );
    scene.goals = vec![Aim {
        pose: Pose::new(random.random_range(5.0..9.0), y_m, yaw_rad),
        tolerance_m: 0.1,
        yaw_tolerance_rad: 0.2,
    }];
    scene
}

/// The robot has to back off, from a wall before its nose or out of an aisle in which it cannot turn.
fn reverse(random: &mut Pcg64Mcg) -> Scene {
    let body = robots::with_corners(random).with_reverse();
    if random.random_bool(0.5) {
        let gap_m = random.random_range(0.03..0.1);
        let title = format!("{} stands {gap_m:.3} m before a wall", body.name);
        let x_m = WALL_M + gap_m + body.front_m;
        let mut scene = Scene::hall(title, HALL_M, body);
        scene.start = Pose::new(x_m, random.random_range(3.0..5.0), PI);
        scene.goals = vec![Aim::place(8.0, random.random_range(2.0..6.0))];
        return scene;
    }
    let length_m = random.random_range(4.0..16.0);
    // Room for a turn takes more than its length; beside it there are 10 cm and more.
    let narrow_m = 2.0 * body.side_m + 0.2;
    let width_m = random.random_range(narrow_m..narrow_m.max(body.length_m() - 0.05) + 0.01);
    let title = format!(
        "{} drives into an aisle of {length_m:.1} m x {width_m:.2} m and out",
        body.name
    );
    let [deep_m, y_m] = [WALL_M + body.front_m.max(body.rear_m) + 0.4, 4.0];
    let mut scene = Scene::hall(title, [length_m + 6.0, 8.0], body);
    scene.block([WALL_M, WALL_M], [length_m, y_m - 0.5 * width_m]);
    scene.block([WALL_M, y_m + 0.5 * width_m], [length_m, 8.0 - WALL_M]);
    scene.static_map = random.random_bool(0.5);
    scene.start = Pose::new(length_m + 3.0, y_m, PI);
    let inside = Aim {
        pose: Pose::new(deep_m, y_m, PI),
        tolerance_m: 0.15,
        yaw_tolerance_rad: 0.3,
    };
    scene.goals = vec![inside, Aim::place(length_m + 3.0, y_m)];
    // Backwards it is slow.
    scene.extra_s = 30.0 + length_m / 0.1;
    scene
}

/// A long robot has to turn the corner of a corridor.
fn corner(random: &mut Pcg64Mcg) -> Scene {
    let (body, narrow_m) = match random.random_range(0..4) {
        0 => (Body::rectangle([0.6, 0.6, 0.25]), 1.15),
        1 => (Body::rectangle([0.85, 0.85, 0.3]), 1.25),
        2 => (Body::rectangle([1.2, 0.3, 0.35]), 1.5),
        _ => (Body::preset(RobotPreset::Jackal), 0.65),
    };
    let body = if random.random_bool(0.5) {
        body.with_reverse()
    } else {
        body
    };
    let width_m = narrow_m + random.random_range(0.0..0.4);
    let title = format!(
        "{} turns a corner of a corridor of {width_m:.2} m",
        body.name
    );
    let [front_m, rear_m] = [body.front_m, body.rear_m];
    let inner_m = [8.0 - width_m, 1.0 + width_m];
    let [x_m, y_m] = [8.0 - 0.5 * width_m, 1.0 + 0.5 * width_m];
    let mut scene = Scene {
        boxes: Vec::new(),
        ..Scene::hall(title, [9.0, 9.0], body)
    };
    scene.block([0.0, 0.0], [9.0, 1.0]);
    scene.block([8.0, 1.0], [9.0, 9.0]);
    scene.block([0.0, 1.0], [0.5, inner_m[1]]);
    scene.block([0.0, inner_m[1]], [inner_m[0], 9.0]);
    scene.block([inner_m[0], 8.5], [8.0, 9.0]);
    let aim = |pose| Aim {
        pose,
        tolerance_m: 0.15,
        yaw_tolerance_rad: 0.3,
    };
    if random.random_bool(0.5) {
        scene.start = Pose::new(0.9 + rear_m, y_m, 0.0);
        scene.goals = vec![aim(Pose::new(x_m, 8.1 - front_m, FRAC_PI_2))];
    } else {
        scene.start = Pose::new(x_m, 8.1 - rear_m, -FRAC_PI_2);
        scene.goals = vec![aim(Pose::new(0.9 + front_m, y_m, PI))];
    }
    scene.static_map = random.random_bool(0.5);
    scene.extra_s = 60.0;
    scene
}

/// A door far away: beams that hit its edges return from before and behind.
fn far_door(random: &mut Pcg64Mcg) -> Scene {
    let body = robots::any(random);
    let least_m = (2.0 * body.side_m + 0.2).max(0.75);
    let width_m = random.random_range(least_m..1.4);
    let thick_m = random.random_range(0.1..0.8);
    let door_m = random.random_range(4.0..14.0);
    let title = format!(
        "{} looks for a door of {width_m:.2} m from far away",
        body.name
    );
    let mut scene = Scene::hall(title, [18.0, 18.0], body);
    scene.wall_with_door([9.0, thick_m], [door_m, width_m]);
    scene.start = Pose::new(
        random.random_range(1.5..3.0),
        random.random_range(2.0..16.0),
        random.random_range(-PI..PI),
    );
    scene.goals = vec![Aim::place(12.5, random.random_range(3.0..15.0))];
    scene
}

/// Commands take effect late, as the robot's description says.
fn late_drive(random: &mut Pcg64Mcg) -> Scene {
    let delay_s = 0.05 * f64::from(random.random_range(1..11));
    let body = robots::any(random).with("actuation_delay_s", delay_s);
    let title = format!("{}: commands take effect after {delay_s:.2} s", body.name);
    if random.random_bool(0.5) {
        return slalom(title, body);
    }
    // What it takes to stop: until the scan, the command and its effect, and for braking.
    let stop_m = body.v_mps * (0.2 + delay_s) + body.v_mps * body.v_mps / (2.0 * body.brake_mps2);
    let near_m = 0.3;
    let at_m = 6.2 - (stop_m + 0.15) - body.front_m + near_m;
    let mut scene = Scene::hall(title, HALL_M, body);
    scene.drop_box([6.5, 4.0], [0.6, 1.0], [at_m, 4.0], near_m);
    scene.start = Pose::new(1.5, 4.0, 0.0);
    scene.goals = vec![Aim::place(12.5, 4.0)];
    scene
}

/// The wheels spin, or odometry jumps.
fn wheel_slip(random: &mut Pcg64Mcg) -> Scene {
    let body = robots::any(random)
        .with("odometry", true)
        .with("slip", true);
    let mut fault = Table::new();
    let mut begins = Table::new();
    begins.insert("driven_m".into(), random.random_range(1.0..4.0).into());
    fault.insert("begins".into(), begins.into());
    let jumps = random.random_range(0..4) == 0;
    let (what, extra_s) = if jumps {
        let shift = [
            random.random_range(-1.0..1.0),
            random.random_range(-0.5..0.5),
            random.random_range(-0.3..0.3),
        ];
        fault.insert("kind".into(), "odometry_jump".into());
        fault.insert("shift".into(), shift.to_vec().into());
        ("odometry jumps".to_owned(), 30.0)
    } else {
        let ratio = random.random_range(0.5..1.0);
        let lasts_s = [1.0, 3.0, 8.0, 20.0][random.random_range(0..4)];
        fault.insert("kind".into(), "slip".into());
        fault.insert("lasts_s".into(), lasts_s.into());
        fault.insert("forward_ratio".into(), ratio.into());
        fault.insert(
            "turn_ratio".into(),
            (if random.random_bool(0.5) { ratio } else { 0.0 }).into(),
        );
        (
            format!("wheels spin by {ratio:.2} for {lasts_s:.0} s"),
            30.0 + 2.0 * lasts_s,
        )
    };
    let title = format!("{}: {what}", body.name);
    let mut scene = Scene::hall(title, HALL_M, body);
    scene.wall_with_door([6.9, 0.2], [4.0, 1.0]);
    scene.block([3.0, 6.0], [4.0, 7.0]);
    scene.block([10.0, 1.0], [11.0, 2.0]);
    scene.static_map = random.random_bool(0.5);
    scene.faults = vec![fault];
    scene.start = Pose::new(1.5, 4.0, 0.0);
    scene.goals = vec![Aim {
        tolerance_m: 0.25,
        ..Aim::place(12.0, 4.0)
    }];
    scene.extra_s = extra_s;
    scene
}

/// No beam returns for some time, and something is put in the way.
fn blind_lidar(random: &mut Pcg64Mcg) -> Scene {
    let body = robots::any(random);
    let lasts_s = random.random_range(3.0..12.0);
    let title = format!("{}: no beam returns for {lasts_s:.1} s", body.name);
    let mut fault = Table::new();
    let mut begins = Table::new();
    begins.insert("driven_m".into(), random.random_range(0.5..2.0).into());
    fault.insert("kind".into(), "lidar_blackout".into());
    fault.insert("begins".into(), begins.into());
    fault.insert("lasts_s".into(), lasts_s.into());
    fault.insert("looks".into(), "no_return".into());
    let mut scene = Scene::hall(title, HALL_M, body);
    scene.drop_box([7.0, 4.0], [0.5, 1.5], [4.0, 4.0], 0.3);
    scene.faults = vec![fault];
    scene.static_map = random.random_bool(0.5);
    scene.start = Pose::new(1.5, 4.0, 0.0);
    scene.goals = vec![Aim::place(12.0, random.random_range(2.0..6.0))];
    scene.extra_s = 20.0 + lasts_s;
    scene
}

/// Somebody stands in the only door, or a cart on the goal, and goes again.
fn pause(random: &mut Pcg64Mcg) -> Scene {
    let body = robots::any(random);
    let lasts_s = random.random_range(3.0..25.0);
    let at_s = random.random_range(0.0..3.0);
    let in_door = random.random_bool(0.6);
    let place = if in_door {
        "in the only door"
    } else {
        "on the goal"
    };
    let title = format!("{}: somebody stands {place} for {lasts_s:.1} s", body.name);
    let least_m = 2.0 * body.side_m + 0.3;
    let width_m = random.random_range(least_m..least_m + 0.4);
    let mut scene = Scene::hall(title, HALL_M, body);
    scene.wall_with_door([6.9, 0.2], [4.0, width_m]);
    let (centre_m, radius_m) = if in_door {
        ([7.0, 4.0], 0.3)
    } else {
        ([12.0, 4.0], 0.4)
    };
    scene.visitor(ShapeSpec::Disc { centre_m, radius_m }, at_s, lasts_s);
    scene.static_map = random.random_bool(0.5);
    scene.start = Pose::new(2.0, 4.0, 0.0);
    scene.goals = vec![Aim::place(12.0, 4.0)];
    scene.extra_s = lasts_s;
    scene
}

/// A robot that turns slowly has to face about.
fn slow_turner(random: &mut Pcg64Mcg) -> Scene {
    let w_radps = random.random_range(0.08..0.3);
    let body = Body::disc(0.25)
        .with("w_radps_max", w_radps)
        .with("alpha_radps2_max", 0.2);
    let title = format!("a robot that turns at {w_radps:.2} rad/s at most");
    let mut scene = Scene::hall(title, HALL_M, body);
    scene.start = Pose::new(3.0, 4.0, random.random_range(-PI..PI));
    scene.goals = vec![Aim {
        pose: Pose::new(
            random.random_range(5.0..10.0),
            random.random_range(2.0..6.0),
            random.random_range(-PI..PI),
        ),
        tolerance_m: 0.2,
        yaw_tolerance_rad: 0.1,
    }];
    scene.extra_s = 60.0;
    scene
}

/// Somebody comes towards the robot in a corridor where two fit beside each other.
fn oncoming(random: &mut Pcg64Mcg) -> Scene {
    let body = robots::any(random);
    let width_m = random.random_range(2.0..2.4);
    let speed_mps = random.random_range(0.4..0.9);
    let title = format!(
        "{}: somebody comes at {speed_mps:.2} m/s in a corridor of {width_m:.2} m",
        body.name
    );
    let middle_m = WALL_M + 0.5 * width_m;
    let y_m = middle_m + random.random_range(-0.2..0.2);
    let mut scene = Scene::hall(title, [20.0, width_m + 2.0 * WALL_M], body);
    let shape = ShapeSpec::Disc {
        centre_m: [17.0, y_m],
        radius_m: 0.3,
    };
    scene.obstacles.push(ObstacleSpec {
        waypoints_m: vec![[1.0, y_m]],
        speed_mps,
        ..ObstacleSpec::standing("person", shape)
    });
    scene.start = Pose::new(2.0, middle_m, 0.0);
    scene.goals = vec![Aim::place(18.0, middle_m)];
    scene.extra_s = 30.0;
    scene
}

/// Rain or dust: beams return from before what is there.
fn short_returns(random: &mut Pcg64Mcg) -> Scene {
    let ratio = random.random_range(0.01..0.05);
    let body = robots::any(random).with_lidar("short_ratio", ratio);
    let title = format!(
        "{}: {:.1} % of the beams return short",
        body.name,
        100.0 * ratio
    );
    slalom(title, body)
}

/// Three walls to get around, one after the other.
fn slalom(title: String, body: Body) -> Scene {
    let mut scene = Scene::hall(title, HALL_M, body);
    scene.block([4.0, 1.0], [4.4, 5.0]);
    scene.block([7.0, 3.0], [7.4, 7.8]);
    scene.block([10.0, 0.2], [10.4, 5.0]);
    scene.start = Pose::new(1.5, 2.0, 0.0);
    scene.goals = vec![Aim {
        pose: Pose::new(12.5, 2.0, 0.0),
        tolerance_m: 0.15,
        yaw_tolerance_rad: 0.3,
    }];
    scene
}
