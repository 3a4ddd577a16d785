//! Scenarios with the fields that no shipped one has.

/// Fields that no shipped scenario has.
pub(crate) const OTHERS: [&str; 7] = [
    r#"
title = "All that is optional"
description = "d"
group = "g"
start = [1.0, 2.0, 0.5]
static_map = true
[run]
time_limit_s = 10.0
tick_hz = 50.0
seed = 1
[world]
area_m = [[0.0, 0.0], [10.0, 5.0]]
resolution_m = 0.05
[[world.shapes]]
kind = "box"
centre_m = [5.0, 4.0]
size_m = [1.0, 1.0]
yaw_rad = 0.1
[[world.shapes]]
kind = "polygon"
corners_m = [[8.0, 1.0], [9.0, 1.0], [8.5, 1.5]]
[[world.obstacles]]
name = "walks"
shape = { kind = "disc", centre_m = [8.0, 4.0], radius_m = 0.3 }
appears = { at_s = 3.0 }
lasts_s = 5.0
waypoints_m = [[8.0, 3.0]]
speed_mps = 1.0
repeat = true
starts = { robot_near = { point_m = [5.0, 2.0], distance_m = 1.0 } }
[[world.obstacles]]
name = "bounces"
shape = { kind = "disc", centre_m = [8.0, 2.5], radius_m = 0.1 }
bounces_mps = [0.5, 0.5]
starts = { at_s = 1.0 }
[[world.obstacles]]
name = "was recorded"
shape = { kind = "disc", centre_m = [3.0, 4.0], radius_m = 0.1 }
track = [[0.0, 3.0, 4.0], [1.0, 3.5, 4.0]]
track_from_s = 0.0
[robot]
preset = "jackal"
radius_m = 0.25
v_mps_max = 1.0
v_mps_min = -0.5
w_radps_max = 2.0
a_mps2_max = 1.0
brake_mps2 = 1.0
alpha_radps2_max = 4.0
command_timeout_s = 0.2
actuation_delay_s = 0.1
[robot.slip]
forward_ratio = 0.1
turn_ratio = 0.1
sigma_ratio = 0.1
[robot.odometry]
distance_per_distance = 0.01
distance_per_turn = 0.01
turn_per_turn = 0.01
turn_per_distance = 0.01
gyro = true
[robot.lidar]
preset = "utm_30lx"
pose = [0.1, 0.0, 0.0]
n_beams = 360
fov_rad = 4.0
rate_hz = 10.0
range_m_min = 0.1
range_m_max = 12.0
motion_distortion = true
sigma_m = 0.01
sigma_ratio = 0.01
quantum_m = 0.01
dropout_ratio = 0.01
dropout_as = "no_return"
short_ratio = 0.01
short_mean_m = 1.0
edge_ratio = 0.1
[[robot.faults]]
kind = "lidar_blackout"
begins = { at_s = 1.0 }
lasts_s = 1.0
looks = "silent"
[[robot.faults]]
kind = "lidar_frozen"
begins = { driven_m = 1.0 }
lasts_s = 1.0
[[robot.faults]]
kind = "lidar_turned"
begins = { at_s = 1.0 }
lasts_s = 1.0
angle_rad = 0.1
[[robot.faults]]
kind = "odometry_jump"
begins = { at_s = 1.0 }
shift = [0.1, 0.0, 0.0]
[[robot.faults]]
kind = "slip"
begins = { at_s = 1.0 }
lasts_s = 1.0
forward_ratio = 0.5
turn_ratio = 0.5
[[goals]]
pose = [9.0, 3.0, 0.0]
tolerance_m = 0.3
yaw_tolerance_rad = 0.3
[services.robot]
binary = "b"
config.x = 1
[services.mapping]
binary = "b"
config.x = 1
[services.global_planner]
binary = "b"
config.x = 1
[services.local_planner]
binary = "b"
config.x = 1
[services.collision_guard]
binary = "b"
config.x = 1
[restart]
per_service = 1
per_run = 1
window_s = 60.0
hang_after_s = 0.5
absent_ticks = 1
[[faults]]
kind = "kill"
service = "collision_guard"
begins = { at_s = 1.0 }
[[faults]]
kind = "stop"
service = "collision_guard"
begins = { robot_near = { point_m = [5.0, 2.0], distance_m = 1.0 } }
lasts_s = 1.0
[[faults]]
kind = "slow"
service = "mapping"
by_ms = 1.0
begins = { at_s = 1.0 }
lasts_s = 1.0
[[faults]]
kind = "drop"
topic = 'plan/path'
share = 0.5
begins.at_s = 1.0
lasts_s = 1.0
[[faults]]
kind = "clock"
service = "mapping"
by_ms = -20.0
begins.at_s = 1.0
lasts_s = 1.0
[random_faults]
count = 3
from_s = 1.0
until_s = 5.0
seed = 1
kinds = ["kill"]
services = ["collision_guard"]
[[swaps]]
service = "mapping"
at_s = 1.0
binary = "b"
config.x = 1
shadow_s = 1.0
keep_s = 1.0
require = "p99<2ms"
[companions.watcher]
binary = "b"
config.x = 1
restarts = 1
[hosts.robot]
seats = ["robot", "collision_guard"]
connect = "tls/base:7447"
keys = "keys"
[hosts.base]
seats = ["mapping", "global_planner", "local_planner"]
listen = "tls/0.0.0.0:7447"
keys = "keys"
[expect]
outcome = "reached"
contacts_max = 0
obstacle_replans_min = 0
obstacle_replans_max = 1
driven_m_min = 1.0
goal_distance_m_max = 1.0
interventions_min = { stopped_short = 1 }
restarts_min = 1
[trials]
obstacle = "bounces"
goals = [
    { pose = [1.0, 2.5, 0.0], tolerance_m = 0.3, yaw_tolerance_rad = 0.3 },
    { pose = [9.0, 2.5, 0.0], tolerance_m = 0.3, yaw_tolerance_rad = 0.3 },
]
line_m = [[3.0, 2.5], [7.0, 2.5]]
ahead_m = 1.0
"#,
    r#"
title = "Recorded people"
start = [1.0, 2.0, 0.5]
[world]
pedestrians = { file = "absent.csv", from_s = 1.0, duration_s = 1.0, radius_m = 0.3 }
[robot]
preset = "jackal"
footprint_m = [[0.2, 0.2], [-0.2, 0.2], [-0.2, -0.2], [0.2, -0.2]]
"#,
    r#"
title = "A world of DynaBARN"
start = [1.0, 2.0, 0.5]
[world]
dynabarn = { file = "absent.csv", phase_s = 1.0 }
[robot]
preset = "jackal"
"#,
    r#"
title = "Files"
start = [1.0, 2.0, 0.5]
[world]
map = "absent.yaml"
barn = "absent.csv"
[robot]
preset = "jackal"
"#,
    r#"
title = "A random map"
start = [1.0, 2.0, 0.5]
[world.generated]
family = { kind = "blocky", side_cells_max = 2 }
size_cells = [20, 20]
ratio = 0.1
start_cell = [0, 0]
goal_cell = [19, 19]
seed = 1
resolution_m = 1.0
[robot]
preset = "jackal"
"#,
    r#"
title = "Corridors"
start = [1.0, 2.0, 0.5]
[world.generated]
family = { kind = "corridor", width_cells = 2 }
size_cells = [20, 20]
ratio = 0.0
resolution_m = 1.0
[robot]
preset = "jackal"
[foresight]
perceive = "truth"
predict = "truth"
"#,
    r#"
title = "Zones: of every number one that is of use, then every field of every kind"
start = [1.0, 2.0, 0.5]
[world]
area_m = [[0.0, 0.0], [10.0, 5.0]]
[robot]
preset = "turtlebot3_burger"
[[zones]]
name = "slow"
kind = "speed_limit"
polygon = [[2.0, 0.0], [3.0, 0.0], [3.0, 1.0]]
limit_mps = 0.3
[[zones]]
name = "half"
kind = "speed_limit"
polygon = [[2.0, 0.0], [3.0, 0.0], [3.0, 1.0]]
percent = 50.0
[[zones]]
name = "wet"
kind = "cost"
polygon = [[2.0, 0.0], [3.0, 0.0], [3.0, 1.0]]
cost = 100.0
[[zones]]
name = "all of keepout"
kind = "keepout"
polygon = [[2.0, 0.0], [3.0, 0.0], [3.0, 1.0]]
mask = "floor.yaml"
limit_mps = 0.3
percent = 50.0
cost = 10.0
[[zones]]
name = "all of speed_limit"
kind = "speed_limit"
polygon = [[2.0, 0.0], [3.0, 0.0], [3.0, 1.0]]
mask = "floor.yaml"
limit_mps = 0.3
percent = 50.0
cost = 10.0
[[zones]]
name = "all of cost"
kind = "cost"
polygon = [[2.0, 0.0], [3.0, 0.0], [3.0, 1.0]]
mask = "floor.yaml"
limit_mps = 0.3
percent = 50.0
cost = 10.0
[[zones]]
name = "all of lane"
kind = "lane"
polygon = [[2.0, 0.0], [3.0, 0.0], [3.0, 1.0]]
mask = "floor.yaml"
limit_mps = 0.3
percent = 50.0
cost = 10.0
"#,
];
