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
