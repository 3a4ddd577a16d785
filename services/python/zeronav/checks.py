"""Accepts received messages that mean something: the checks of the crate `msgs`, in its order.

`tests/tests/system/python_checks.rs` compares both, word by word.
"""

import math
import unicodedata

import numpy as np

from . import contract as c
from .layout import checksum

TINY = 2.2250738585072014e-308
CHECKSUM = "the checksum does not fit"
# Largest coordinate of a point of a scan, in `base`. [m]
POINT_M_MAX = 1e3
FLAGS_ALL = (1 << 6) - 1


class Refused(Exception):
    """Why a message was dropped."""


def number(value, low, high, field):
    """Accepts finite numbers, alone or in an array, from `low` to `high`."""
    if isinstance(value, np.ndarray):
        if value.size == 0:
            return
        lowest, highest = float(value.min()), float(value.max())
    else:
        lowest = highest = value
    if not (math.isfinite(lowest) and math.isfinite(highest)):
        raise Refused(f"{field} is not a finite number")
    if lowest < low or highest > high:
        raise Refused(f"{field} is out of range")


def ensure(condition, why):
    """Accepts True."""
    if not condition:
        raise Refused(why)


def code(kind, value, field):
    """Accepts the codes of `kind`, alone or in an array."""
    values = np.unique(value) if isinstance(value, np.ndarray) else (value,)
    known = kind._value2member_map_
    ensure(all(int(one) in known for one in values), f"unknown code in {field}")


def length(items, told, most, field):
    """Accepts slices as long as the fixed fields tell."""
    ensure(len(items) == told and len(items) <= most, f"wrong number of {field}")


def pose(value, field):
    """Accepts finite poses inside the range of coordinates, yaw within ten turns."""
    limit = c.COORDINATE_M_MAX
    x, y, yaw = (
        (value["x_m"], value["y_m"], value["yaw_rad"])
        if isinstance(value, np.ndarray)
        else (value.x_m, value.y_m, value.yaw_rad)
    )
    number(x, -limit, limit, field)
    number(y, -limit, limit, field)
    number(yaw, -62.9, 62.9, field)


def header(topic, head):
    """Accepts headers of this domain, of this contract, written by a role that may."""
    ensure(head.schema == topic.schema & 0xFFFF_FFFF, "schema hash of another contract")
    ensure(head.robot == 0 and head.clock == 0, "not of this domain")
    code(c.Role, head.role, "role")
    ensure(head.role in topic.writers, "written by a role that may not write this topic")
    ensure(head.id >> 40 > 0 and head.id & ((1 << 40) - 1) > 0, "identity without epoch or count")


def _description(meta, corners):
    length(corners, meta.n_corners, c.ROBOT_DESCRIPTION.len_max, "corners")
    ensure(len(corners) == 0 or len(corners) >= 3, "wrong number of corners")
    number(corners["x_m"], -100, 100, "corner")
    number(corners["y_m"], -100, 100, "corner")
    number(meta.inscribed_radius_m, 1e-3, 100, "inscribed_radius_m")
    number(meta.circumscribed_radius_m, meta.inscribed_radius_m, 150, "circumscribed_radius_m")
    number(meta.v_mps_min, -c.SPEED_MAX, 0, "v_mps_min")
    for field in ("v_mps_max", "w_radps_max", "a_mps2_max", "brake_mps2", "alpha_radps2_max"):
        number(getattr(meta, field), TINY, c.SPEED_MAX, field)
    pose(meta.base_from_laser, "base_from_laser")
    number(meta.angle_min_rad, -12.6, 12.6, "angle_min_rad")
    number(meta.angle_increment_rad, -1.6, 1.6, "angle_increment_rad")
    number(meta.range_m_min, 0, 1e3, "range_m_min")
    number(meta.range_m_max, meta.range_m_min, 1e3, "range_m_max")
    ensure(meta.scan_period_ns > 0, "scan_period_ns is out of range")
    ensure(
        meta.actuation_delay_ns <= c.ACTUATION_DELAY_NS_MAX,
        "actuation_delay_ns is out of range",
    )
    ensure(1 <= meta.n_beams <= c.ROBOT_SCAN.len_max, "n_beams is out of range")


def _scan(meta, ranges):
    length(ranges, meta.n_beams, c.ROBOT_SCAN.len_max, "beams")
    number(meta.angle_min_rad, -12.6, 12.6, "angle_min_rad")
    number(meta.angle_increment_rad, -1.6, 1.6, "angle_increment_rad")
    ensure(abs(meta.angle_increment_rad) > 1e-6, "angle_increment_rad is out of range")
    number(meta.time_increment_s, 0, 1, "time_increment_s")
    number(meta.range_m_min, 0, 1e3, "range_m_min")
    number(meta.range_m_max, meta.range_m_min, 1e3, "range_m_max")
    ensure(not (ranges < 0).any(), "ranges are out of range")


def _odometry(meta, items):
    length(items, 0, 0, "items")
    pose(meta.pose, "pose")
    number(meta.v_mps, -c.SPEED_MAX, c.SPEED_MAX, "v_mps")
    number(meta.w_radps, -c.SPEED_MAX, c.SPEED_MAX, "w_radps")
    for variance in meta.variance:
        number(variance, 0, 1e12, "variance")
    ensure(meta.scan_due <= 1, "unknown code in scan_due")


def geometry(value):
    """Accepts grids that cells and tiles can live with."""
    limit = c.COORDINATE_M_MAX
    number(value.origin_x_m, -limit, limit, "origin_x_m")
    number(value.origin_y_m, -limit, limit, "origin_y_m")
    number(value.resolution_m, 1e-3, 10, "resolution_m")
    ensure(1 <= value.width <= c.SIDE_CELLS_MAX, "width is out of range")
    ensure(1 <= value.height <= c.SIDE_CELLS_MAX, "height is out of range")


def _map(meta, tiles, tiles_max):
    geometry(meta.geometry)
    pose(meta.map_from_odom, "map_from_odom")
    for value in meta.covariance:
        number(value, -1e12, 1e12, "covariance")
    for value in (*meta.way_out.from_m, *meta.way_out.until_m):
        number(value, -c.COORDINATE_M_MAX, c.COORDINATE_M_MAX, "way_out")
    number(meta.way_out.radius_m, 0, c.COORDINATE_M_MAX, "way_out.radius_m")
    ensure(meta.revision != 0, "identity without epoch or count")
    ensure(1 <= meta.parts and meta.part < meta.parts, "part is out of range")
    ensure(1 <= meta.clearance_limit_mm <= 0xFFFF, "clearance_limit_mm is out of range")
    ensure(meta.current <= 1, "unknown code in current")
    model = meta.cost_model
    number(model.inscribed_radius_m, 0, 100, "inscribed_radius_m")
    number(model.padding_m, 0, 100, "padding_m")
    number(model.inflation_radius_m, 0, 100, "inflation_radius_m")
    number(model.scaling_per_m, 0, 1e6, "scaling_per_m")
    length(tiles, meta.n_tiles, tiles_max, "tiles")
    side = c.TILE_CELLS
    columns, rows = -(-meta.geometry.width // side), -(-meta.geometry.height // side)
    on_map = (tiles["tile_x"] < columns) & (tiles["tile_y"] < rows)
    ensure(on_map.all(), "tile is out of range")
    cells = tiles["cells"]
    ensure((cells["clearance_mm"] <= meta.clearance_limit_mm).all(), "cell is out of range")
    ensure((cells["flags"] <= FLAGS_ALL).all(), "cell is out of range")


def _map_update(meta, tiles):
    _map(meta, tiles, c.MAP_UPDATE.len_max)


def _map_keyframe(meta, tiles):
    _map(meta, tiles, c.MAP_KEYFRAME.len_max)


def _obstacles(meta, obstacles):
    length(obstacles, meta.n_obstacles, c.MAP_OBSTACLES.len_max, "obstacles")
    limit = c.COORDINATE_M_MAX
    for field, low, high in (
        ("x_m", -limit, limit),
        ("y_m", -limit, limit),
        ("vx_mps", -c.SPEED_MAX, c.SPEED_MAX),
        ("vy_mps", -c.SPEED_MAX, c.SPEED_MAX),
        ("radius_m", 0, c.OBSTACLE_RADIUS_M_MAX),
        ("age_s", 0, 1e9),
        ("unseen_s", 0, 1e9),
        ("covariance", -1e12, 1e12),
    ):
        number(obstacles[field], low, high, field)


def _path(meta, waypoints):
    code(c.PathStatus, meta.status, "status")
    code(c.PathCause, meta.cause, "cause")
    code(c.PathBlock, meta.block, "block")
    code(c.ObstacleSource, meta.source, "source")
    for along in meta.block_m:
        number(along, -c.COORDINATE_M_MAX, c.COORDINATE_M_MAX, "block_m")
    length(waypoints, meta.n_waypoints, c.PLAN_PATH.len_max, "waypoints")
    found = meta.status == c.PathStatus.FOUND
    ensure(found == (len(waypoints) > 0), "wrong number of waypoints")
    ensure(all(byte == 0 or 33 <= byte <= 126 for byte in meta.planner), "planner is out of range")
    number(meta.length_m, 0, 1e9, "length_m")
    number(meta.cost, 0, 1e15, "cost")
    number(meta.bound, 0, meta.cost, "bound")
    number(meta.beside_goal_m, 0, 1e9, "beside_goal_m")
    limit = c.COORDINATE_M_MAX
    number(waypoints["x_m"], -limit, limit, "x_m")
    number(waypoints["y_m"], -limit, limit, "y_m")
    number(waypoints["yaw_rad"], -6.3, 6.3, "yaw_rad")
    number(waypoints["clearance_m"], 0, 1e3, "clearance_m")


def _plan_request(meta, items):
    length(items, 0, 0, "items")
    code(c.RequestReason, meta.reason, "reason")
    number(meta.blocked_arc_m, 0, 1e6, "blocked_arc_m")


def _task(meta, goals):
    code(c.TaskKind, meta.kind, "kind")
    length(goals, meta.n_goals, c.TASK_GOAL.len_max, "goals")
    ensure((meta.kind == c.TaskKind.GO) == (len(goals) > 0), "wrong number of goals")
    pose(goals["pose"], "pose")
    number(goals["tolerance_m"], 1e-3, 1e3, "tolerance_m")
    number(goals["yaw_tolerance_rad"], 1e-3, 1e3, "yaw_tolerance_rad")
    ensure((goals["id"] != 0).all(), "id is out of range")


def _pose_estimate(meta, items):
    length(items, 0, 0, "items")
    pose(meta.map_from_base, "map_from_base")
    pose(meta.odom_from_base, "odom_from_base")
    code(c.PoseCertainty, meta.certainty, "certainty")


# Least and most of the value of a zone.
ZONE_VALUES = {
    c.ZoneKind.KEEPOUT: (0, 0),
    c.ZoneKind.SPEED_LIMIT: (c.ZONE_SPEED_MPS_MIN, c.SPEED_MAX),
    c.ZoneKind.SPEED_PERCENT: (c.ZONE_PERCENT_MIN, 100),
    c.ZoneKind.COST: (1, c.ZONE_COST_MAX),
    c.ZoneKind.LANE: (1, c.ZONE_COST_MAX),
}


def _zone_name(padded):
    """The name of a part; empty when it is no text."""
    name, _, rest = padded.partition(b"\0")
    try:
        text = name.decode()
    except UnicodeDecodeError:
        return ""
    is_word = not rest.strip(b"\0") and all(unicodedata.category(one) != "Cc" for one in text)
    return text if is_word else ""


def _zones(meta, parts):
    ensure(meta.revision != 0, "identity without epoch or count")
    length(parts, meta.n_parts, c.ZONE_PARTS_MAX, "parts")
    n_zones, before = 0, None
    for part in parts:
        kind = int(part["kind"])
        code(c.ZoneKind, kind, "zone.kind")
        name = part["name"].tobytes()
        ensure(_zone_name(name), "zone.name is out of range")
        ensure(kind != c.ZoneKind.NONE, "unknown code in zone.kind")
        number(float(part["value"]), *ZONE_VALUES[c.ZoneKind(kind)], "zone.value")
        ensure(3 <= part["n_corners"] <= c.ZONE_CORNERS_MAX, "wrong number of zone.corners")
        number(part["corners_m"], -c.COORDINATE_M_MAX, c.COORDINATE_M_MAX, "zone.corners_m")
        n_zones += name != before
        before = name
    ensure(n_zones <= c.ZONES_MAX, "wrong number of zones")


def _task_status(meta, ended):
    code(c.TaskState, meta.state, "state")
    code(c.EndReason, meta.reason, "reason")
    code(c.StuckCause, meta.cause, "cause")
    code(c.PathBlock, meta.block, "block")
    code(c.ObstacleSource, meta.source, "source")
    for along in meta.block_m:
        number(along, -c.COORDINATE_M_MAX, c.COORDINATE_M_MAX, "block_m")
    length(ended, meta.n_ended, c.TASK_STATUS.len_max, "ends")
    code(c.TaskState, ended["state"], "end.state")
    code(c.EndReason, ended["reason"], "end.reason")
    number(meta.remaining_m, 0, 1e9, "remaining_m")


def _twist(meta):
    code(c.Validity, meta.validity, "validity")
    number(meta.v_mps, -c.SPEED_MAX, c.SPEED_MAX, "v_mps")
    number(meta.w_radps, -c.SPEED_MAX, c.SPEED_MAX, "w_radps")


def _velocity_request(meta, items):
    length(items, 0, 0, "items")
    code(c.RequestCause, meta.cause, "cause")
    code(c.PlannerInput, meta.input, "input")
    code(c.RecoveryReason, meta.recovery, "recovery")
    _twist(meta)
    number(meta.braking_arc_m, 0, 1e6, "braking_arc_m")
    number(meta.limit_mps, 0, c.SPEED_MAX, "limit_mps")
    number(meta.blocked_arc_m, 0, 1e6, "blocked_arc_m")


def _velocity_command(meta, items):
    length(items, 0, 0, "items")
    _twist(meta)
    code(c.Intervention, meta.intervention, "intervention")
    ensure(meta.beam <= c.ROBOT_SCAN.len_max, "beam is out of range")
    for along in (*meta.point_m, meta.point_clearance_m):
        number(along, -POINT_M_MAX, POINT_M_MAX, "point_m")


def _rollouts(meta, rollouts):
    length(rollouts, meta.n_rollouts, c.DEBUG_ROLLOUTS.len_max, "rollouts")
    pose(meta.map_from_base, "map_from_base")
    outcomes, points = rollouts["outcome"], rollouts["n_points"]
    code(c.RolloutOutcome, outcomes, "outcome")
    number(rollouts["v_mps"], -c.SPEED_MAX, c.SPEED_MAX, "v_mps")
    number(rollouts["w_radps"], -c.SPEED_MAX, c.SPEED_MAX, "w_radps")
    number(rollouts["cost"], -c.ROLLOUT_COST_MAX, c.ROLLOUT_COST_MAX, "cost")
    in_range = (points >= 1) & (points <= c.ROLLOUT_POINTS_MAX)
    ensure(in_range.all(), "n_points is out of range")
    number(rollouts["x_m"], -c.COORDINATE_M_MAX, c.COORDINATE_M_MAX, "x_m")
    number(rollouts["y_m"], -c.COORDINATE_M_MAX, c.COORDINATE_M_MAX, "y_m")
    chosen = np.count_nonzero(outcomes == c.RolloutOutcome.CHOSEN)
    ensure(chosen <= 1, "wrong number of chosen rollouts")


def _run_clock(meta, items):
    length(items, 0, 0, "items")
    code(c.RunMode, meta.mode, "mode")
    known = c.FORESIGHT_PERCEIVE | c.FORESIGHT_PREDICT
    ensure(meta.foresight <= known, "unknown code in foresight")
    ensure(1_000_000 <= meta.tick_ns <= 1_000_000_000, "tick_ns is out of range")


def _run_control(meta, seats):
    length(seats, meta.n_seats, c.RUN_CONTROL.len_max, "seats")
    ensure(meta.paused <= 1, "unknown code in paused")
    ensure(meta.stopping <= 1, "unknown code in stopping")
    for fault in meta.topic_faults:
        code(c.TopicFaultKind, fault.kind, "topic_fault.kind")
        ensure(fault.share <= c.SHARE_ALL, "topic_fault.share is out of range")
        ensure(fault.delay_us <= c.DELAY_US_MAX, "topic_fault.delay_us is out of range")
    code(c.Role, seats["role"], "seat.role")
    ensure((seats["off_tick"] <= seats["on_tick"]).all(), "seat.on_tick is out of range")
    offset_ms = np.abs(seats["clock_offset_ms"].astype(np.int64))
    ensure((offset_ms <= c.CLOCK_OFFSET_MS_MAX).all(), "seat.clock_offset_ms is out of range")


def _health(meta, items):
    length(items, 0, 0, "items")
    code(c.HealthState, meta.state, "state")


CHECKS = {
    c.ROBOT_DESCRIPTION: _description,
    c.ROBOT_SCAN: _scan,
    c.ROBOT_ODOMETRY: _odometry,
    c.MAP_UPDATE: _map_update,
    c.MAP_KEYFRAME: _map_keyframe,
    c.MAP_OBSTACLES: _obstacles,
    c.PLAN_PATH: _path,
    c.PLAN_REQUEST: _plan_request,
    c.TASK_GOAL: _task,
    c.TASK_STATUS: _task_status,
    c.TASK_POSE: _pose_estimate,
    c.TASK_ZONES: _zones,
    c.CONTROL_VELOCITY_REQUEST: _velocity_request,
    c.ROBOT_VELOCITY_COMMAND: _velocity_command,
    c.DEBUG_ROLLOUTS: _rollouts,
    c.RUN_CLOCK: _run_clock,
    c.RUN_CONTROL: _run_control,
    **{topic: _health for topic in c.HEALTH.values()},
}


def decode(topic, envelope, items):
    """Accepts a message of `topic`; raises `Refused` with the first thing that is wrong."""
    header(topic, envelope.header)
    ensure(len(items) <= topic.len_max, "wrong number of items")
    ensure(checksum(bytes(envelope), items) == envelope.header.checksum, CHECKSUM)
    CHECKS[topic](envelope.meta, items)
