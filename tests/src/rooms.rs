//! The scenario that many tests drive: a small robot in a room.

/// An empty room with its lower-left corner in the origin, and a robot in it. The time limit is in
/// the scenario as it is written; `world` holds more lines of its section. The text ends in section
/// `[robot]`, so that a test can add sections of its own.
#[must_use]
pub fn room(size_m: [f64; 2], start: [f64; 3], time_limit_s: f64, world: &str) -> String {
    let [width_m, height_m] = size_m;
    format!(
        r#"
title = "A room"
start = {start:?}

[run]
time_limit_s = {time_limit_s:?}

[world]
area_m = [[0.0, 0.0], [{width_m:?}, {height_m:?}]]
{world}

[robot]
radius_m = 0.2
v_mps_max = 1.0
w_radps_max = 2.0
a_mps2_max = 1.0
alpha_radps2_max = 4.0
lidar = {{ n_beams = 180, rate_hz = 10.0, range_m_min = 0.05, range_m_max = 12.0 }}
"#
    )
}

/// A drive of 3.5 m along the lower wall of a room, past what `world` puts there.
#[must_use]
pub fn short_drive(world: &str) -> String {
    let goal = "\n[[goals]]\npose = [4.5, 1.0, 0.0]\n";
    room([6.0, 4.0], [1.0, 1.0, 0.0], 30.0, world) + goal
}

/// A drive of 7 m along an aisle of the warehouse. A box appears in its middle before the robot, so that the
/// path is cut, and leaves room enough on one side.
#[must_use]
pub fn box_in_an_aisle() -> String {
    r#"
title = "A box beside the way"
base = ["warehouse", "porter"]
start = [5.0, 6.425, 0.0]

[run]
time_limit_s = 60.0

[[goals]]
pose = [12.0, 6.425, 0.0]

[[world.obstacles]]
name = "box"
shape = { kind = "box", centre_m = [9.8, 6.15], size_m = [0.6, 0.7] }
appears = { robot_near = { point_m = [7.0, 6.425], distance_m = 0.3 } }

[expect]
outcome = "reached"
contacts_max = 0
obstacle_replans_min = 1
"#
    .to_owned()
}

/// A folder with `blocked_aisle` as `it.toml`, in which trials begin after two metres: the robot drives towards
/// where the load may fall.
///
/// # Panics
/// When the scenario reads otherwise, or the folder cannot be made.
#[must_use]
pub fn aisle_for_trials() -> tempfile::TempDir {
    let mut text = crate::shipped("blocked_aisle");
    for (from, to) in [
        ("start = [3.0, 8.5, 0.0]", "start = [16.0, 6.425, 3.1416]"),
        (
            "line_m = [[8.0, 6.425], [22.0, 6.425]]",
            "line_m = [[8.0, 6.425], [10.5, 6.425]]",
        ),
    ] {
        assert!(text.contains(from), "{from}: {text}");
        text = text.replace(from, to);
    }
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
    folder
}
