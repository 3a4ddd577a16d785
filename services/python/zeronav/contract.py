"""The contract between the processes of zeronav: messages, codes, topics.

Written by `cargo run -p zeronav-msgs --example bindings`; changes belong into the crate `msgs`.
Importing this module computes size, offsets and schema hash of every message again and compares.
"""

from enum import IntEnum

from .layout import Message, Topic, f32, f64, i32, u8, u16, u32, u64, verify


class EndReason(IntEnum):
    NONE = 0
    UNREACHABLE = 1
    GOAL_BLOCKED = 2
    GOAL_OUTSIDE_MAP = 3
    STUCK = 4
    NO_PATH = 5
    REPLACED = 6
    POSE_UNKNOWN = 7


class HealthState(IntEnum):
    STARTING = 0
    READY = 1
    DEGRADED = 2
    STOPPING = 3


class Intervention(IntEnum):
    NONE = 0
    CLAMPED = 1
    REFUSED = 2
    REQUEST_STALE = 3
    SCAN_STALE = 4
    ODOMETRY_STALE = 5
    SLOWED = 6
    STOPPED_SHORT = 7
    ZONE_SLOWED = 8
    ZONE_STOPPED = 9
    ZONES_MISSING = 10


class ObstacleSource(IntEnum):
    NONE = 0
    STATIC_MAP = 1
    LIDAR = 2
    TRACKED = 3
    UNKNOWN = 4
    KEEPOUT = 5


class PathBlock(IntEnum):
    NONE = 0
    ROBOT = 1
    GOAL = 2
    PATH_BEFORE = 3
    CLOSED = 4
    OBSTACLE = 5


class PathCause(IntEnum):
    NONE = 0
    GOAL = 1
    OBSTACLE = 2
    REQUEST = 3
    SHORTCUT = 4
    NEXT_GOAL = 5
    IMPROVED = 6


class PathStatus(IntEnum):
    NO_GOAL = 0
    FOUND = 1
    START_OUTSIDE_MAP = 2
    START_BLOCKED = 3
    GOAL_OUTSIDE_MAP = 4
    GOAL_BLOCKED = 5
    UNREACHABLE = 6
    UNREACHABLE_CORNER = 7
    DEAD_END = 8
    OUT_OF_BUDGET = 9
    TOO_LONG = 10


class PlannerInput(IntEnum):
    NONE = 0
    ODOMETRY = 1
    SCAN = 2
    MAP = 3
    PATH = 4
    DESCRIPTION = 5
    POSE = 6


class PoseCertainty(IntEnum):
    UNKNOWN = 0
    UNCONFIRMED = 1
    CONFIRMED = 2


class RecoveryReason(IntEnum):
    NONE = 0
    BLOCKED = 1
    NO_PROGRESS = 2
    DYNAMIC_OBSTACLE = 3
    TIMED_OUT = 4
    STUCK = 5
    OUT_OF_ATTEMPTS = 6


class RequestCause(IntEnum):
    NONE = 0
    FREE = 1
    GOAL = 2
    CORNER = 3
    CRITICS = 4
    AGEING = 5
    HEADING = 6
    TURN = 7
    TURN_WAIT = 8
    ARRIVE = 9
    GOAL_YAW = 10
    BLOCKED = 11
    STALE = 12
    ASK_FOR_PATH = 13
    BACK_UP = 14
    ROTATE = 15
    WAIT = 16
    GIVE_UP = 17
    CLEARANCE_CRITIC = 18
    PATH_CRITIC = 19
    PROGRESS_CRITIC = 20
    DYNAMIC_OBSTACLE_CRITIC = 21
    SMOOTHNESS_CRITIC = 22
    STOPPING_DISTANCE = 23
    TIMED_SEARCH = 24
    POTENTIAL_FIELD = 25
    YIELD = 26
    MANOEUVRE = 27
    NO_FIT = 28
    SEEK_POSE = 29
    SPEED_ZONE = 30


class RequestReason(IntEnum):
    NONE = 0
    BLOCKED = 1
    OFF_PATH = 2
    NO_PROGRESS = 3


class Role(IntEnum):
    LAUNCH = 1
    ROBOT = 2
    MAPPING = 3
    GLOBAL_PLANNER = 4
    LOCAL_PLANNER = 5
    COLLISION_GUARD = 6
    TAP = 7


class RolloutOutcome(IntEnum):
    NONE = 0
    CHOSEN = 1
    COSTLIER = 2
    COLLISION = 3
    MOVING_COLLISION = 4
    NO_STOP = 5


class RunMode(IntEnum):
    NONE = 0
    REAL_TIME = 1
    LOCKSTEP = 2


class TopicFaultKind(IntEnum):
    NONE = 0
    DROP = 1
    DELAY = 2
    CORRUPT = 3


class SpanKind(IntEnum):
    IDLE = 1
    ANSWER = 2
    EXTRA = 3
    APPLIED = 4


class StuckCause(IntEnum):
    NONE = 0
    BLOCKED = 1
    NO_PROGRESS = 2
    TOO_MANY_ATTEMPTS = 3


class TaskKind(IntEnum):
    NONE = 0
    GO = 1
    CANCEL = 2


class TaskState(IntEnum):
    IDLE = 0
    ACTIVE = 1
    REACHED = 2
    FAILED = 3
    CANCELLED = 4


class Validity(IntEnum):
    NO_PATH = 0
    DRIVE = 1
    AT_GOAL = 2
    BLOCKED = 3
    STALE = 4
    NO_REQUEST = 5
    STOPPED = 6


class ZoneKind(IntEnum):
    NONE = 0
    KEEPOUT = 1
    SPEED_LIMIT = 2
    SPEED_PERCENT = 3
    COST = 4
    LANE = 5


SHADOW_EPOCH_MIN = 8388608
COORDINATE_M_MAX = 1000000
SPEED_MAX = 1000
CLOCK_OFFSET_MS_MAX = 10000
DELAY_STEP_NS = 10000
DELAY_US_MAX = 10000000
SHARE_ALL = 1000000
FORESIGHT_PERCEIVE = 1
FORESIGHT_PREDICT = 2
EVENT_MAX = 63
EVENT_NEED_KEYFRAME = 40
NODES_MAX = 24
READERS_MAX = 12
WRITERS_MAX = 4
SIDE_CELLS_MAX = 8192
TILE_CELLS = 32
COST_FREE = 0
COST_CIRCUMSCRIBED_MAX = 252
COST_INSCRIBED = 253
COST_LETHAL = 254
COST_UNKNOWN = 255
FLAG_STATIC = 1
FLAG_SENSED = 2
FLAG_VIRTUAL = 4
FLAG_REGULARISED = 8
FLAG_UNKNOWN = 16
FLAG_KEEPOUT = 32
FORM_BYTES_MAX = 200
USER_BORROWED = 2
USER_BUFFER = 32
USER_BYTES_MAX = 65536
USER_NAME_BYTES_MAX = 40
USER_POOL = 58
ACTUATION_DELAY_NS_MAX = 2000000000
ZONES_MAX = 128
ZONE_CORNERS_MAX = 16
ZONE_COST_MAX = 252
ZONE_NAME_BYTES = 32
ZONE_PARTS_MAX = 512
ZONE_PERCENT_MIN = 1
ZONE_SPEED_MPS_MIN = 0.01
OBSTACLE_RADIUS_M_MAX = 10
ROLLOUT_COST_MAX = 1000000000
ROLLOUT_POINTS_MAX = 12
REASON_SCAN = 1
REASON_ODOMETRY = 2
REASON_MAP = 4
REASON_PATH = 8
REASON_REQUEST = 16
REASON_REFUSED = 32
REASON_NO_LOAN = 64
REASON_TOO_LONG = 128
REASON_ZONES = 4096


class Parents(Message):
    """The messages that the author itself took in for this one; 0 = none. Everything further back
    is found by joining spans."""

    NAME = "zeronav.Parents.v1"
    SIZE = 48
    SCHEMA = 0xc9a84854d50f7859
    OFFSETS = (0, 8, 16, 24, 32, 40)
    _fields_ = [
        # [id] Id on `robot/odometry`.
        ("odometry", u64),
        # [id] Id on `robot/scan`.
        ("scan", u64),
        # [id] Revision of the map.
        ("map", u64),
        # [id] Id on `plan/path`.
        ("path", u64),
        # [id] Id on `plan/request` for a path, on `control/velocity_request` for a command and for
        # rollouts.
        ("request", u64),
        # [id] Id on `task/goal`.
        ("goal", u64),
    ]


class Stamps(Message):
    """The author's own clock readings, [ns] of `CLOCK_MONOTONIC`."""

    NAME = "zeronav.Stamps.v1"
    SIZE = 24
    SCHEMA = 0x0d8040dff7baaf0f
    OFFSETS = (0, 8, 16)
    _fields_ = [
        # [ns] Return from the wait.
        ("woken_ns", u64),
        # [ns] All inputs taken in, work begins.
        ("started_ns", u64),
        # [ns] Just before the message was sent.
        ("published_ns", u64),
    ]


class Header(Message):
    """Fixed header of every message."""

    NAME = "zeronav.Header.v2"
    SIZE = 128
    SCHEMA = 0x127a2a8d11a040a2
    OFFSETS = (0, 2, 4, 8, 12, 16, 24, 32, 40, 48, 96, 120)
    _fields_ = [
        # Code of the author's `Role`.
        ("role", u16),
        # [number] Which robot; 0, because one domain is one robot.
        ("robot", u16),
        # [number] Low 32 bits of the topic's schema hash.
        ("schema", u32),
        # [number] Which clock the stamps belong to; 0 = the host of launch.
        ("clock", u32),
        # Written as 0, ignored by readers.
        ("spare", u32),
        # [id] Identity, see `Id`.
        ("id", u64),
        # [tick] Control tick that the message answers; 0 = an idle output before the first tick.
        # That of a keyframe is the tick of its revision.
        ("tick", u64),
        # Run time of that tick, for a scan of its capture. [ns]
        ("run_ns", u64),
        # When the newest sensor data in it was captured, `CLOCK_MONOTONIC`; 0 = none. [ns]
        ("capture_ns", u64),
        # What it was made from.
        ("parents", Parents),
        # When it was made.
        ("stamps", Stamps),
        # [number] Checksum of everything else in the message, see `crate::checksum`.
        ("checksum", u64),
    ]


class Pose(Message):
    """Position and yaw of one frame in another."""

    NAME = "zeronav.Pose.v1"
    SIZE = 24
    SCHEMA = 0x026c68dfa3277c78
    OFFSETS = (0, 8, 16)
    _fields_ = [
        # [m]
        ("x_m", f64),
        # [m]
        ("y_m", f64),
        # [rad] counter-clockwise from +x.
        ("yaw_rad", f64),
    ]


class Description(Message):
    """What the robot is. The slice holds the corners of a convex footprint, counter-clockwise in
    `base`; an empty slice is a disc of `circumscribed_radius_m`."""

    NAME = "zeronav.Description.v2"
    SIZE = 144
    SCHEMA = 0x96a0516fd40ddf35
    OFFSETS = (0, 8, 16, 24, 32, 40, 48, 56, 64, 88, 96, 104, 112, 120, 128, 136, 140)
    _fields_ = [
        # [m] largest disc around the origin of `base` inside the footprint, > 0.
        ("inscribed_radius_m", f64),
        # [m] smallest disc around the origin of `base` that holds the footprint.
        ("circumscribed_radius_m", f64),
        # [m/s] fastest forward speed, > 0.
        ("v_mps_max", f64),
        # [m/s] fastest backward speed as a number <= 0; 0 = never backwards.
        ("v_mps_min", f64),
        # [rad/s] fastest yaw rate either way, > 0.
        ("w_radps_max", f64),
        # [m/s^2] largest acceleration, > 0.
        ("a_mps2_max", f64),
        # [m/s^2] deceleration that braking can rely on, > 0.
        ("brake_mps2", f64),
        # [rad/s^2] largest yaw acceleration, > 0.
        ("alpha_radps2_max", f64),
        # `base_from_laser`.
        ("base_from_laser", Pose),
        # [rad] direction of beam 0 in `laser`.
        ("angle_min_rad", f64),
        # [rad] step from beam to beam.
        ("angle_increment_rad", f64),
        # [m] closest valid range.
        ("range_m_min", f64),
        # [m] farthest valid range.
        ("range_m_max", f64),
        # [ns] from scan to scan.
        ("scan_period_ns", u64),
        # [ns] from a command's arrival to its taking effect; until then the commands before it are
        # obeyed.
        ("actuation_delay_ns", u64),
        # [count] Beams of a scan.
        ("n_beams", u32),
        # [count] Corners in the slice, 0 = disc.
        ("n_corners", u32),
    ]


class RobotDescriptionEnvelope(Message):
    """Header and fixed fields of the topic's messages."""

    NAME = "zeronav.robot.description.v1"
    SIZE = 272
    SCHEMA = 0x6e64a288bef5faec
    OFFSETS = (0, 128)
    _fields_ = [
        # The header.
        ("header", Header),
        # The fixed fields.
        ("meta", Description),
    ]


class Corner(Message):
    """A corner of the footprint."""

    NAME = "zeronav.Corner.v1"
    SIZE = 16
    SCHEMA = 0x6890156a2f0f11c1
    OFFSETS = (0, 8)
    _fields_ = [
        # [m] in `base`.
        ("x_m", f64),
        # [m] in `base`.
        ("y_m", f64),
    ]


class Scan(Message):
    """Fixed fields of a scan. The slice holds one range per beam: [m] in the `laser` frame, +inf =
    no return within `range_max_m`, NaN = invalid. Beam `i` points to `angle_min_rad + i *
    angle_increment_rad`. The header's capture is that of the last beam."""

    NAME = "zeronav.Scan.v1"
    SIZE = 32
    SCHEMA = 0xcc817f81a2050ae0
    OFFSETS = (0, 4, 8, 12, 16, 20, 24, 28)
    _fields_ = [
        # [number] Which sensor, from 0.
        ("sensor", u32),
        # [count] Number of beams, equal to the length of the slice.
        ("n_beams", u32),
        # [rad] direction of beam 0.
        ("angle_min_rad", f32),
        # [rad] step from beam to beam, not 0, positive = counter-clockwise.
        ("angle_increment_rad", f32),
        # [s] time from beam to beam, 0 = all at once.
        ("time_increment_s", f32),
        # [m] closest valid range.
        ("range_m_min", f32),
        # [m] farthest valid range.
        ("range_m_max", f32),
        # Written as 0.
        ("spare", u32),
    ]


class RobotScanEnvelope(Message):
    """Header and fixed fields of the topic's messages."""

    NAME = "zeronav.robot.scan.v1"
    SIZE = 160
    SCHEMA = 0xacf1bce78b014166
    OFFSETS = (0, 128)
    _fields_ = [
        # The header.
        ("header", Header),
        # The fixed fields.
        ("meta", Scan),
    ]


class Odometry(Message):
    """Pose and twist by odometry."""

    NAME = "zeronav.Odometry.v1"
    SIZE = 72
    SCHEMA = 0x964730218dedfa83
    OFFSETS = (0, 24, 32, 40, 64, 68)
    _fields_ = [
        # `odom_from_base`.
        ("pose", Pose),
        # [m/s] forward speed in `base`.
        ("v_mps", f64),
        # [rad/s] yaw rate in `base`, counter-clockwise.
        ("w_radps", f64),
        # [m^2, m^2, rad^2] variances of x, y and yaw, >= 0.
        ("variance", f64 * 3),
        # [flag] 1 when a scan belongs to this tick, 0 when not.
        ("scan_due", u32),
        # Written as 0.
        ("spare", u32),
    ]


class RobotOdometryEnvelope(Message):
    """Header and fixed fields of the topic's messages."""

    NAME = "zeronav.robot.odometry.v1"
    SIZE = 200
    SCHEMA = 0x898ef86160c7c41f
    OFFSETS = (0, 128)
    _fields_ = [
        # The header.
        ("header", Header),
        # The fixed fields.
        ("meta", Odometry),
    ]


class GridGeometry(Message):
    """Where a grid lies in the map frame. Row-major, `width x height`, half-open cells, origin at
    the outer corner of cell (0, 0), columns along +x, rows along +y."""

    NAME = "zeronav.GridGeometry.v1"
    SIZE = 32
    SCHEMA = 0xbeb89aec645e2897
    OFFSETS = (0, 8, 16, 24, 28)
    _fields_ = [
        # [m] map frame, outer corner of cell (0, 0).
        ("origin_x_m", f64),
        # [m] map frame, outer corner of cell (0, 0).
        ("origin_y_m", f64),
        # [m] side of a cell, > 0.
        ("resolution_m", f64),
        # [count] Columns, 1 to `SIDE_CELLS_MAX`.
        ("width", u32),
        # [count] Rows, 1 to `SIDE_CELLS_MAX`.
        ("height", u32),
    ]


class CostModel(Message):
    """How the cost of a known cell follows from its clearance, see `CostModel::cost`."""

    NAME = "zeronav.CostModel.v1"
    SIZE = 32
    SCHEMA = 0x01d4e2011a0c58ac
    OFFSETS = (0, 8, 16, 24)
    _fields_ = [
        # [m] of the robot's inscribed circle, >= 0.
        ("inscribed_radius_m", f64),
        # [m] added to the inscribed radius, >= 0.
        ("padding_m", f64),
        # [m] of clearance beyond which a cell is free, >= 0.
        ("inflation_radius_m", f64),
        # [1/m] by which the cost falls, >= 0.
        ("scaling_per_m", f64),
    ]


class WayOut(Message):
    """The straight way by which a robot that is in a keepout zone is let out."""

    NAME = "zeronav.WayOut.v1"
    SIZE = 40
    SCHEMA = 0x21ddf890191647f2
    OFFSETS = (0, 16, 32)
    _fields_ = [
        # [m] map frame, where it begins.
        ("from_m", f64 * 2),
        # [m] map frame, where it ends, outside of all keepout zones.
        ("until_m", f64 * 2),
        # [m] to either side of the line between them; 0 = no way is open.
        ("radius_m", f64),
    ]


class MapInfo(Message):
    """Fixed fields of map messages. The slice holds tiles."""

    NAME = "zeronav.MapInfo.v3"
    SIZE = 200
    SCHEMA = 0x60e694f4ef19010a
    OFFSETS = (0, 32, 40, 64, 112, 114, 116, 120, 124, 128, 160)
    _fields_ = [
        # Where the grid lies.
        ("geometry", GridGeometry),
        # [id] Revision that the map has after this message: the id of the update's last part.
        ("revision", u64),
        # `map_from_odom`.
        ("map_from_odom", Pose),
        # Covariance of the pose of `base` in the map, against where that began, upper triangle by
        # rows. [m, m, rad] Its deviations also say how far the pose is known
        # (`MapInfo::certainty`).
        ("covariance", f64 * 6),
        # [number] Which part of the revision this is, from 0.
        ("part", u16),
        # [count] Parts of the revision, at least 1; 1 in a keyframe.
        ("parts", u16),
        # [count] Tiles in the slice.
        ("n_tiles", u32),
        # [mm] at which clearance is saturated.
        ("clearance_limit_mm", u32),
        # [flag] 1 when scans keep coming, 0 when the map is not current.
        ("current", u32),
        # How the cost of a cell follows from its clearance.
        ("cost_model", CostModel),
        # The way out of a keepout zone, whose cells are open.
        ("way_out", WayOut),
    ]


class MapUpdateEnvelope(Message):
    """Header and fixed fields of the topic's messages."""

    NAME = "zeronav.map.update.v1"
    SIZE = 328
    SCHEMA = 0x05b193d5f4cfde27
    OFFSETS = (0, 128)
    _fields_ = [
        # The header.
        ("header", Header),
        # The fixed fields.
        ("meta", MapInfo),
    ]


class MapCell(Message):
    """One cell. `cost` and `clearance_mm` come from obstacles that are static, by the static map
    or by what the lidar saw; those that move are on `map/obstacles` alone."""

    NAME = "zeronav.MapCell.v2"
    SIZE = 4
    SCHEMA = 0x4244a9fed47926c9
    OFFSETS = (0, 1, 2)
    _fields_ = [
        # [number] As in Nav2: 0 free, 253 inscribed, 254 lethal, 255 unknown.
        ("cost", u8),
        # [bits] Sum of the `FLAG_` bits.
        ("flags", u8),
        # [mm] from the cell's centre to the nearest obstacle square, rounded down, saturated at
        # the map's limit; 0 inside an obstacle.
        ("clearance_mm", u16),
    ]


class MapTile(Message):
    """32 x 32 cells, row-major. Cells beyond the map's edge are unknown and ignored."""

    NAME = "zeronav.MapTile.v2"
    SIZE = 4104
    SCHEMA = 0x551fd6366a7dfec1
    OFFSETS = (0, 4, 8)
    _fields_ = [
        # [number] Column of tiles, from 0.
        ("tile_x", u32),
        # [number] Row of tiles, from 0.
        ("tile_y", u32),
        # The cells.
        ("cells", MapCell * 1024),
    ]


class MapKeyframeEnvelope(Message):
    """Header and fixed fields of the topic's messages."""

    NAME = "zeronav.map.keyframe.v1"
    SIZE = 328
    SCHEMA = 0x243114dd09615064
    OFFSETS = (0, 128)
    _fields_ = [
        # The header.
        ("header", Header),
        # The fixed fields.
        ("meta", MapInfo),
    ]


class Obstacles(Message):
    """Fixed fields of the list of tracked obstacles."""

    NAME = "zeronav.Obstacles.v1"
    SIZE = 8
    SCHEMA = 0x6e48a45e27e1d95f
    OFFSETS = (0,)
    _fields_ = [
        # [count] Number of obstacles, equal to the length of the slice.
        ("n_obstacles", u64),
    ]


class MapObstaclesEnvelope(Message):
    """Header and fixed fields of the topic's messages."""

    NAME = "zeronav.map.obstacles.v1"
    SIZE = 136
    SCHEMA = 0x9117b28eef3c2bdd
    OFFSETS = (0, 128)
    _fields_ = [
        # The header.
        ("header", Header),
        # The fixed fields.
        ("meta", Obstacles),
    ]


class Obstacle(Message):
    """A tracked obstacle: a disc with constant velocity."""

    NAME = "zeronav.Obstacle.v2"
    SIZE = 144
    SCHEMA = 0x8c5365a47ca1daff
    OFFSETS = (0, 8, 16, 24, 32, 40, 48, 56, 64)
    _fields_ = [
        # [number] Stays with the track as long as it lives.
        ("track", u64),
        # [m] `map` frame.
        ("x_m", f64),
        # [m] `map` frame.
        ("y_m", f64),
        # [m/s] `map` frame.
        ("vx_mps", f64),
        # [m/s] `map` frame.
        ("vy_mps", f64),
        # [m] 0 to `OBSTACLE_RADIUS_M_MAX`.
        ("radius_m", f64),
        # [s] since the track began.
        ("age_s", f64),
        # [s] since the last scan that showed it: where it is now is predicted. 0 while it is seen.
        ("unseen_s", f64),
        # Covariance of (x, y, vx, vy), upper triangle by rows. [m^2, m^2/s, m^2/s^2]
        ("covariance", f64 * 10),
    ]


class Path(Message):
    """Fixed fields of a path. Search statistics are counts, never times. A message with an
    unchanged path repeats the waypoints and says by its parents how current it is."""

    NAME = "zeronav.Path.v5"
    SIZE = 144
    SCHEMA = 0xa7edfb8ed361ed11
    OFFSETS = (0, 24, 26, 28, 32, 40, 48, 56, 64, 72, 80, 88, 96, 104, 112, 120, 122, 124, 128)
    _fields_ = [
        # [text] Key of the planner in lower case, padded with 0.
        ("planner", u8 * 24),
        # Code of `PathStatus`.
        ("status", u16),
        # Code of `PathCause` of the geometry.
        ("cause", u16),
        # [count] Waypoints in the slice.
        ("n_waypoints", u32),
        # [id] Id of the message that brought this geometry or failure first; its own id when new.
        ("geometry", u64),
        # [id] Map revision that the search used; the header's parent is the one it was checked
        # with.
        ("searched_map", u64),
        # [count] Nodes taken from the open list and closed.
        ("expanded", u64),
        # [count] Nodes put into the open list.
        ("generated", u64),
        # [count] Neighbours looked at, repeats counted.
        ("evaluated", u64),
        # [count] Longest open list.
        ("peak_open", u64),
        # [m] length, >= 0.
        ("length_m", f64),
        # [-] Cost in the planner's own measure, >= 0.
        ("cost", f64),
        # [-] No path costs less, in the same measure; 0 = not known. At most `cost`.
        ("bound", f64),
        # [number] Goal that it leads to, by `crate::task::Goal::id`.
        ("goal", u64),
        # [m] from the last waypoint to the goal, >= 0: above 0 when the goal's own place cannot be
        # reached and the nearest one within its tolerance that can is taken.
        ("beside_goal_m", f64),
        # Code of `PathBlock`: which cell made this path another one, made it end beside the goal,
        # or left no path. May be left 0.
        ("block", u16),
        # Code of `ObstacleSource` of the obstacle in that cell or nearest to it. May be left 0.
        ("source", u16),
        # Written as 0.
        ("spare", u16 * 2),
        # [m] x and y of the centre of that cell, `map` frame.
        ("block_m", f64 * 2),
    ]


class PlanPathEnvelope(Message):
    """Header and fixed fields of the topic's messages."""

    NAME = "zeronav.plan.path.v1"
    SIZE = 272
    SCHEMA = 0x14c041652310caa2
    OFFSETS = (0, 128)
    _fields_ = [
        # The header.
        ("header", Header),
        # The fixed fields.
        ("meta", Path),
    ]


class Waypoint(Message):
    """A pose on the path."""

    NAME = "zeronav.Waypoint.v1"
    SIZE = 24
    SCHEMA = 0xd99fefdb1fc0e96c
    OFFSETS = (0, 8, 16, 20)
    _fields_ = [
        # [m] `map` frame.
        ("x_m", f64),
        # [m] `map` frame.
        ("y_m", f64),
        # [rad] direction to the next waypoint; at the last one the goal's yaw.
        ("yaw_rad", f32),
        # [m] clearance when the path was made, saturated at the map's limit.
        ("clearance_m", f32),
    ]


class PlanRequest(Message):
    """Fixed fields of a request; the slice is empty."""

    NAME = "zeronav.PlanRequest.v1"
    SIZE = 16
    SCHEMA = 0x9645c77274163223
    OFFSETS = (0, 2, 8)
    _fields_ = [
        # Code of `RequestReason`.
        ("reason", u16),
        # Written as 0.
        ("spare", u16 * 3),
        # [m] along the path from the robot to what blocks it, >= 0.
        ("blocked_arc_m", f64),
    ]


class PlanRequestEnvelope(Message):
    """Header and fixed fields of the topic's messages."""

    NAME = "zeronav.plan.request.v1"
    SIZE = 144
    SCHEMA = 0x9823a2af3f319c98
    OFFSETS = (0, 128)
    _fields_ = [
        # The header.
        ("header", Header),
        # The fixed fields.
        ("meta", PlanRequest),
    ]


class Task(Message):
    """Fixed fields of a task. The slice holds the goals in order."""

    NAME = "zeronav.Task.v1"
    SIZE = 16
    SCHEMA = 0x522fec02901e38bd
    OFFSETS = (0, 2, 4, 8)
    _fields_ = [
        # Code of `TaskKind`.
        ("kind", u16),
        # Written as 0.
        ("spare", u16),
        # [count] Goals in the slice.
        ("n_goals", u32),
        # [tick] First tick at which it holds; 0 = at once.
        ("from_tick", u64),
    ]


class TaskGoalEnvelope(Message):
    """Header and fixed fields of the topic's messages."""

    NAME = "zeronav.task.goal.v1"
    SIZE = 144
    SCHEMA = 0x257e3065e7d763f5
    OFFSETS = (0, 128)
    _fields_ = [
        # The header.
        ("header", Header),
        # The fixed fields.
        ("meta", Task),
    ]


class Goal(Message):
    """A goal."""

    NAME = "zeronav.Goal.v1"
    SIZE = 48
    SCHEMA = 0x30bd1a6fabf4d638
    OFFSETS = (0, 24, 32, 40)
    _fields_ = [
        # `map_from_base` to reach.
        ("pose", Pose),
        # [m] how close counts, > 0.
        ("tolerance_m", f64),
        # [rad] how close the yaw must be; >= pi = any yaw.
        ("yaw_tolerance_rad", f64),
        # [number] The sender's own number for it, not 0.
        ("id", u64),
    ]


class TaskStatus(Message):
    """Fixed fields of the status. The slice holds one entry per goal that has ended."""

    NAME = "zeronav.TaskStatus.v3"
    SIZE = 64
    SCHEMA = 0xe2d4217383846950
    OFFSETS = (0, 2, 4, 8, 16, 24, 32, 36, 38, 40, 56, 58, 60)
    _fields_ = [
        # Code of `TaskState`.
        ("state", u16),
        # Code of `EndReason`; while it waits, that for which the goal will end.
        ("reason", u16),
        # [count] Goals that have ended.
        ("n_ended", u32),
        # [id] Id on `task/goal` of the task.
        ("task", u64),
        # [number] `Goal::id` of the current goal, 0 = none.
        ("goal", u64),
        # [m] along the path, or straight without one; >= 0.
        ("remaining_m", f64),
        # [count] Manoeuvres and waits of the recovery since the task began.
        ("recoveries", u32),
        # Code of `StuckCause`, with the reason `stuck`.
        ("cause", u16),
        # Code of `PathBlock`: the cell because of which the task failed, or waits. May be left 0.
        ("block", u16),
        # [m] x and y of the centre of that cell, `map` frame.
        ("block_m", f64 * 2),
        # Code of `ObstacleSource` of the obstacle in that cell or nearest to it. May be left 0.
        ("source", u16),
        # [s] for which it waits at most for that obstacle to go, rounded up; 0 = it does not wait.
        ("waits_s", u16),
        # Written as 0.
        ("spare", u16 * 2),
    ]


class TaskStatusEnvelope(Message):
    """Header and fixed fields of the topic's messages."""

    NAME = "zeronav.task.status.v1"
    SIZE = 192
    SCHEMA = 0xee37965966771ef6
    OFFSETS = (0, 128)
    _fields_ = [
        # The header.
        ("header", Header),
        # The fixed fields.
        ("meta", TaskStatus),
    ]


class GoalEnd(Message):
    """End of a goal."""

    NAME = "zeronav.GoalEnd.v1"
    SIZE = 24
    SCHEMA = 0x51ab02aad6f25101
    OFFSETS = (0, 8, 16, 18, 20)
    _fields_ = [
        # [number] `Goal::id`.
        ("goal", u64),
        # [tick] Tick at which it ended.
        ("tick", u64),
        # Code of `TaskState`.
        ("state", u16),
        # Code of `EndReason`.
        ("reason", u16),
        # Written as 0.
        ("spare", u32),
    ]


class PoseEstimate(Message):
    """Where the robot is, as a person says, or as mapping knew before it ended: mapping puts it
    there. Two poses of the same moment, so that it does not matter when the message is read."""

    NAME = "zeronav.PoseEstimate.v2"
    SIZE = 64
    SCHEMA = 0x8f02f66fe57a1203
    OFFSETS = (0, 24, 48, 56, 58)
    _fields_ = [
        # `map_from_base`.
        ("map_from_base", Pose),
        # `odom_from_base` of the same moment.
        ("odom_from_base", Pose),
        # [tick] First tick at which it holds.
        ("from_tick", u64),
        # Code of `PoseCertainty`: `unconfirmed` from a person; `unknown` = the robot is lost and
        # stands.
        ("certainty", u16),
        # Written as 0.
        ("spare", u16 * 3),
    ]


class TaskPoseEnvelope(Message):
    """Header and fixed fields of the topic's messages."""

    NAME = "zeronav.task.pose.v1"
    SIZE = 192
    SCHEMA = 0xd64ffcd8bac8f901
    OFFSETS = (0, 128)
    _fields_ = [
        # The header.
        ("header", Header),
        # The fixed fields.
        ("meta", PoseEstimate),
    ]


class Zones(Message):
    """Fixed fields of the zones. The slice holds their parts, those of a zone one after the
    other."""

    NAME = "zeronav.Zones.v1"
    SIZE = 24
    SCHEMA = 0x70041535f3509961
    OFFSETS = (0, 8, 16)
    _fields_ = [
        # [number] Grows with every change, from 1.
        ("revision", u64),
        # [tick] First tick at which they hold; 0 = at once.
        ("from_tick", u64),
        # [count] Parts in the slice.
        ("n_parts", u64),
    ]


class TaskZonesEnvelope(Message):
    """Header and fixed fields of the topic's messages."""

    NAME = "zeronav.task.zones.v1"
    SIZE = 152
    SCHEMA = 0x7726ed377bc84d3a
    OFFSETS = (0, 128)
    _fields_ = [
        # The header.
        ("header", Header),
        # The fixed fields.
        ("meta", Zones),
    ]


class ZonePart(Message):
    """A polygon of a zone. Its edges may not cross; inside is what an odd number of edges
    encloses."""

    NAME = "zeronav.ZonePart.v1"
    SIZE = 304
    SCHEMA = 0x3e34c3fe1a2a1211
    OFFSETS = (0, 32, 288, 296, 298, 300)
    _fields_ = [
        # [text] Name of the zone, padded with 0.
        ("name", u8 * 32),
        # [m] x and y of the corners, `map` frame; those beyond `n_corners` are 0.
        ("corners_m", f64 * 2 * 16),
        # [m/s, -] by kind: a speed, percent, or a cost of 1 to 252; 0 for a keepout zone.
        ("value", f64),
        # Code of `ZoneKind`.
        ("kind", u16),
        # [count] Corners, at least 3.
        ("n_corners", u16),
        # Written as 0.
        ("spare", u32),
    ]


class VelocityRequest(Message):
    """Fixed fields of a velocity request; the slice is empty. What explains it may be left 0."""

    NAME = "zeronav.VelocityRequest.v2"
    SIZE = 64
    SCHEMA = 0x52796979ebc296da
    OFFSETS = (0, 8, 16, 18, 20, 22, 24, 32, 40, 48, 56)
    _fields_ = [
        # [m/s] forward speed in `base`.
        ("v_mps", f64),
        # [rad/s] yaw rate in `base`.
        ("w_radps", f64),
        # Code of `Validity`.
        ("validity", u16),
        # Code of `RequestCause`.
        ("cause", u16),
        # Code of `PlannerInput`: the one that is old, with the causes `ageing` and `stale`.
        ("input", u16),
        # Code of `RecoveryReason`, with the causes of the recovery.
        ("recovery", u16),
        # [m] length of the arc on which the author can still stop, >= 0.
        ("braking_arc_m", f64),
        # [ms, ms, ms, ms] ages of odometry, scan, map and path when it was made; 65535 = never
        # received, or older. All 0 with the cause `none` = not told.
        ("ages_ms", u16 * 4),
        # [m/s] fastest forward speed that the cause allows, >= 0; 0 = it sets none.
        ("limit_mps", f64),
        # [m] along the path to the first obstacle on it, >= 0; 0 = none in sight.
        ("blocked_arc_m", f64),
        # [number] Track of the nearest dynamic obstacle on `map/obstacles` within 2.5 m; 0 = none.
        ("obstacle", u64),
    ]


class ControlVelocityRequestEnvelope(Message):
    """Header and fixed fields of the topic's messages."""

    NAME = "zeronav.control.velocity_request.v1"
    SIZE = 192
    SCHEMA = 0x1e9b1577c6df1c6d
    OFFSETS = (0, 128)
    _fields_ = [
        # The header.
        ("header", Header),
        # The fixed fields.
        ("meta", VelocityRequest),
    ]


class VelocityCommand(Message):
    """Fixed fields of a velocity command; the slice is empty. What explains it may be left 0."""

    NAME = "zeronav.VelocityCommand.v2"
    SIZE = 48
    SCHEMA = 0x20dd54cf4bae24fe
    OFFSETS = (0, 8, 16, 18, 20, 22, 24, 40)
    _fields_ = [
        # [m/s] forward speed in `base`.
        ("v_mps", f64),
        # [rad/s] yaw rate in `base`.
        ("w_radps", f64),
        # Code of `Validity`.
        ("validity", u16),
        # Code of `Intervention`.
        ("intervention", u16),
        # [number] Beam towards the point that decided, counted from 1, in a scan taken where the
        # robot is now; 0 = no point decided.
        ("beam", u16),
        # Written as 0.
        ("spare", u16),
        # [m] x and y of the point of a scan that is nearest to the way that was asked for and not
        # free, in `base` of now; with the interventions `slowed` and `stopped_short`.
        ("point_m", f64 * 2),
        # [m] least distance between the outline and that point on that way, at most the margin and
        # the slow zone of the guard; below 0 inside the outline.
        ("point_clearance_m", f64),
    ]


class RobotVelocityCommandEnvelope(Message):
    """Header and fixed fields of the topic's messages."""

    NAME = "zeronav.robot.velocity_command.v1"
    SIZE = 176
    SCHEMA = 0x8e98cd5f4071e2f9
    OFFSETS = (0, 128)
    _fields_ = [
        # The header.
        ("header", Header),
        # The fixed fields.
        ("meta", VelocityCommand),
    ]


class RunClock(Message):
    """Fixed fields of the clock; the slice is empty. Written once, before any child starts."""

    NAME = "zeronav.RunClock.v3"
    SIZE = 32
    SCHEMA = 0xd07a700a20640937
    OFFSETS = (0, 2, 4, 6, 8, 16, 24)
    _fields_ = [
        # Code of `RunMode`.
        ("mode", u16),
        # [flag] 1 = services time the stages of their cycles and say it in their records; 0 = they
        # read no clock for it. Always 0 in lockstep.
        ("stages", u16),
        # [bits] What services are told of what moves on `sim/foresight`: 1 = mapping what there
        # is, 2 = the local planner what will be; 0 in earnest.
        ("foresight", u16),
        # Written as 0.
        ("spare", u16),
        # [number] Seed of everything random in the run.
        ("seed", u64),
        # [ns] `CLOCK_MONOTONIC` at run time 0.
        ("zero_ns", u64),
        # [ns] of run time from tick to tick.
        ("tick_ns", u64),
    ]


class RunClockEnvelope(Message):
    """Header and fixed fields of the topic's messages."""

    NAME = "zeronav.run.clock.v1"
    SIZE = 160
    SCHEMA = 0x9ed1e77c674af3f4
    OFFSETS = (0, 128)
    _fields_ = [
        # The header.
        ("header", Header),
        # The fixed fields.
        ("meta", RunClock),
    ]


class TopicFault(Message):
    """A topic whose messages are disturbed on purpose on their way to each service that reads it,
    in real time only: lockstep waits for every message."""

    NAME = "zeronav.TopicFault.v1"
    SIZE = 16
    SCHEMA = 0x5f8cd93dd9ae3a0d
    OFFSETS = (0, 2, 4, 8, 12)
    _fields_ = [
        # [number] of the topic.
        ("topic", u16),
        # Code of `TopicFaultKind`.
        ("kind", u16),
        # [ppm] of the messages that are dropped or corrupted.
        ("share", u32),
        # [us] by which each message is late.
        ("delay_us", u32),
        # [number] Seed of which messages, and which bits.
        ("seed", u32),
    ]


class RunControl(Message):
    """Fixed fields of the control message. The slice holds the roster."""

    NAME = "zeronav.RunControl.v3"
    SIZE = 88
    SCHEMA = 0xfd6f5df11a6a068e
    OFFSETS = (0, 8, 10, 12, 16, 24)
    _fields_ = [
        # [tick] Highest tick that the robot may start, lockstep only.
        ("lease", u64),
        # [flag] 1 = the robot shall stand and run time stops.
        ("paused", u16),
        # [flag] 1 = the run is ending: stop the robot.
        ("stopping", u16),
        # [count] Seats in the slice.
        ("n_seats", u32),
        # [number] Revision of `task/zones` that holds; 0 = there were never any.
        ("zones", u64),
        # Topics that are disturbed on purpose; all zero in earnest.
        ("topic_faults", TopicFault * 4),
    ]


class RunControlEnvelope(Message):
    """Header and fixed fields of the topic's messages."""

    NAME = "zeronav.run.control.v1"
    SIZE = 216
    SCHEMA = 0xc8de769278752ee7
    OFFSETS = (0, 128)
    _fields_ = [
        # The header.
        ("header", Header),
        # The fixed fields.
        ("meta", RunControl),
    ]


class Seat(Message):
    """One seat of the roster. Two processes can run in it: one is obeyed, the other is warm. At
    which tick the one takes over from the other is said in advance, so that no message is heard
    twice and none is missed."""

    NAME = "zeronav.Seat.v3"
    SIZE = 56
    SCHEMA = 0x5c3114b8201013cc
    OFFSETS = (0, 2, 4, 8, 16, 24, 32, 40, 48, 52)
    _fields_ = [
        # Code of the `Role`.
        ("role", u16),
        # [10 us] by which the seat delays each of its answers; 0 in earnest. A delay put in on
        # purpose must appear in this seat's hop and nowhere else.
        ("delay", u16),
        # [number] The epoch that is obeyed in this seat from `since_tick` on; 0 = none yet.
        ("epoch", u32),
        # [tick] First tick at which the seat is empty.
        ("off_tick", u64),
        # [tick] First tick at which it is taken again; `off_tick == on_tick` = never empty.
        ("on_tick", u64),
        # [tick] Messages of ticks below this one are not heard by `epoch`.
        ("hear_tick", u64),
        # [tick] First tick at which `epoch` is obeyed; before it, `other` is.
        ("since_tick", u64),
        # [tick] `other` answers from this tick on, and hears no message of an earlier one.
        ("other_tick", u64),
        # [number] Epoch of the second process in this seat: a newcomer that is not obeyed yet, or
        # a predecessor that still runs; 0 = none.
        ("other", u32),
        # [ms] by which the clocks of its processes are put forward on purpose; 0 in earnest.
        ("clock_offset_ms", i32),
    ]


class Truth(Message):
    """Fixed fields of the truth at one tick. The slice holds the scripted obstacles that exist."""

    NAME = "zeronav.Truth.v1"
    SIZE = 88
    SCHEMA = 0xbf306f77685c2baa
    OFFSETS = (0, 24, 32, 40, 48, 56, 60, 64, 68, 72, 80)
    _fields_ = [
        # True `map_from_base`.
        ("pose", Pose),
        # [m/s] true forward speed.
        ("v_mps", f64),
        # [rad/s] true yaw rate.
        ("w_radps", f64),
        # [m] from the footprint to the nearest thing; 0 in contact; capped at 1000.
        ("clearance_m", f64),
        # [m] driven since the start.
        ("driven_m", f64),
        # [flag] 1 while the footprint touches something.
        ("in_contact", u32),
        # [count] Contacts that began while the robot moved faster than 0.05 m/s.
        ("contacts_moving", u32),
        # [count] Contacts that began while it stood.
        ("contacts_standing", u32),
        # [count] Obstacles in the slice.
        ("n_obstacles", u32),
        # [id] Id of the scan of this tick, 0 = none.
        ("scan", u64),
        # [ns] run time lost because the simulator was late.
        ("slipped_ns", u64),
    ]


class SimGroundTruthEnvelope(Message):
    """Header and fixed fields of the topic's messages."""

    NAME = "zeronav.sim.ground_truth.v1"
    SIZE = 216
    SCHEMA = 0xa5c52b7bd0a6d5b1
    OFFSETS = (0, 128)
    _fields_ = [
        # The header.
        ("header", Header),
        # The fixed fields.
        ("meta", Truth),
    ]


class TruthObstacle(Message):
    """Truth about one scripted obstacle."""

    NAME = "zeronav.TruthObstacle.v1"
    SIZE = 48
    SCHEMA = 0xadb3b9b564924e97
    OFFSETS = (0, 4, 8, 16, 24)
    _fields_ = [
        # [number] Place in the scenario's list, from 0.
        ("index", u32),
        # [count] Beams of this tick's scan that ended on it.
        ("beams", u32),
        # [ns] run time at which it was due to appear.
        ("appeared_run_ns", u64),
        # [ns] `CLOCK_MONOTONIC` of that moment.
        ("appeared_ns", u64),
        # Where it is, `map` frame.
        ("pose", Pose),
    ]


class Foresight(Message):
    """Fixed fields of the foresight. The slice holds what moves."""

    NAME = "zeronav.Foresight.v1"
    SIZE = 32
    SCHEMA = 0x37ad2d72e7b328f8
    OFFSETS = (0, 24)
    _fields_ = [
        # True `map_from_base` at the capture of the scan.
        ("pose", Pose),
        # [count] Obstacles in the slice.
        ("n_obstacles", u64),
    ]


class SimForesightEnvelope(Message):
    """Header and fixed fields of the topic's messages."""

    NAME = "zeronav.sim.foresight.v1"
    SIZE = 160
    SCHEMA = 0xfc490b748f05115a
    OFFSETS = (0, 128)
    _fields_ = [
        # The header.
        ("header", Header),
        # The fixed fields.
        ("meta", Foresight),
    ]


class Foreseen(Message):
    """An obstacle that moves: where it is, and where it will be."""

    NAME = "zeronav.Foreseen.v1"
    SIZE = 1064
    SCHEMA = 0xc66ce90421372d9a
    OFFSETS = (0, 8, 16, 24, 32, 40, 552)
    _fields_ = [
        # [number] Place in the scenario's list, from 0.
        ("index", u64),
        # [m/s] `map` frame.
        ("vx_mps", f64),
        # [m/s] `map` frame.
        ("vy_mps", f64),
        # [m] 0 to 10. For other shapes: radius of the enclosing disc.
        ("radius_m", f64),
        # [s] until it vanishes; 1e9 = it stays.
        ("lasts_s", f64),
        # [m] `map` frame, now and every 0.1 s from now on.
        ("x_m", f64 * 64),
        # [m] `map` frame, at the same times.
        ("y_m", f64 * 64),
    ]


class Placements(Message):
    """Fixed fields of the placements."""

    NAME = "zeronav.Placements.v1"
    SIZE = 8
    SCHEMA = 0x2e0ab29d04752af7
    OFFSETS = (0,)
    _fields_ = [
        # [count] Placements in the slice.
        ("n_placements", u64),
    ]


class SimPlacementEnvelope(Message):
    """Header and fixed fields of the topic's messages."""

    NAME = "zeronav.sim.placement.v1"
    SIZE = 136
    SCHEMA = 0x5688a38a4f2c86ba
    OFFSETS = (0, 128)
    _fields_ = [
        # The header.
        ("header", Header),
        # The fixed fields.
        ("meta", Placements),
    ]


class Placement(Message):
    """Puts an obstacle somewhere for a time, whatever its script says. Until `from_run_ns` it does
    what it did before. A later placement with the same `from_run_ns` and `pose` changes only how
    long it stays."""

    NAME = "zeronav.Placement.v2"
    SIZE = 64
    SCHEMA = 0x17e47a193d65891f
    OFFSETS = (0, 4, 8, 16, 24, 48, 56)
    _fields_ = [
        # [number] Place in the scenario's list, from 0; one behind the last adds an obstacle.
        ("index", u32),
        # Written as 0.
        ("spare", u32),
        # [ns] run time from which it is there; in lockstep of a tick above the lease.
        ("from_run_ns", u64),
        # [ns] run time from which it is gone; 0 = it stays.
        ("until_run_ns", u64),
        # `map_from_shape` while it is there.
        ("pose", Pose),
        # [m] of the rectangle that it becomes, along x, or diameter of a disc; 0 = the shape that
        # it has.
        ("size_x_m", f64),
        # [m] along y; 0 = a disc.
        ("size_y_m", f64),
    ]


class Rollouts(Message):
    """Fixed fields of the rollouts of a control period: a spread over all, with the chosen one and
    the cheapest of every reason. A period that goes on with an older choice sends none."""

    NAME = "zeronav.Rollouts.v1"
    SIZE = 40
    SCHEMA = 0xc99b51e227a7b107
    OFFSETS = (0, 8, 16)
    _fields_ = [
        # [count] Number of rollouts, equal to the length of the slice.
        ("n_rollouts", u64),
        # [count] Motions that the local planner looked at, 0 = not told.
        ("n_looked_at", u64),
        # Where the rollouts begin: the robot in the map.
        ("map_from_base", Pose),
    ]


class DebugRolloutsEnvelope(Message):
    """Header and fixed fields of the topic's messages."""

    NAME = "zeronav.debug.rollouts.v1"
    SIZE = 168
    SCHEMA = 0x8db4eb9a99d34beb
    OFFSETS = (0, 128)
    _fields_ = [
        # The header.
        ("header", Header),
        # The fixed fields.
        ("meta", Rollouts),
    ]


class Rollout(Message):
    """A motion as far as it was looked at, at most as far as what it leads into."""

    NAME = "zeronav.Rollout.v1"
    SIZE = 112
    SCHEMA = 0xbff1df21de2f4ddf
    OFFSETS = (0, 4, 8, 12, 14, 16, 64)
    _fields_ = [
        # [m/s] forward speed that it goes towards at first, in `base`.
        ("v_mps", f32),
        # [rad/s] yaw rate that it goes towards at first, in `base`.
        ("w_radps", f32),
        # [-] what it costs, in the controller's own unit; less is better. 0 = not rated.
        ("cost", f32),
        # Code of `RolloutOutcome`.
        ("outcome", u16),
        # [count] Number of points, at most `ROLLOUT_POINTS_MAX`; the others are 0.
        ("n_points", u16),
        # [m] x of its points in the `map` frame; the first one is where the robot is.
        ("x_m", f32 * 12),
        # [m] y of its points in the `map` frame.
        ("y_m", f32 * 12),
    ]


class Health(Message):
    """Fixed fields of the heartbeat; the slice is empty."""

    NAME = "zeronav.Health.v1"
    SIZE = 48
    SCHEMA = 0x044997d7e555e1f6
    OFFSETS = (0, 8, 10, 12, 16, 20, 24, 32, 40)
    _fields_ = [
        # [count] Grows with every wake (at least every 50 ms, also when idle) and with long work.
        ("progress", u64),
        # Code of `HealthState`.
        ("state", u16),
        # Written as 0.
        ("spare", u16),
        # [bits] Sum of the reason bits.
        ("reasons", u32),
        # [number] Process id.
        ("pid", u32),
        # Written as 0.
        ("spare2", u32),
        # [count] Messages refused since the start.
        ("refused", u64),
        # [count] Inputs overtaken by newer ones since the start.
        ("superseded", u64),
        # Run time lost because the process was late, robot only. [ns]
        ("slipped_ns", u64),
    ]


class HealthEnvelope(Message):
    """Header and fixed fields of the topic's messages."""

    NAME = "zeronav.health.v1"
    SIZE = 176
    SCHEMA = 0x266f209a3c745475
    OFFSETS = (0, 128)
    _fields_ = [
        # The header.
        ("header", Header),
        # The fixed fields.
        ("meta", Health),
    ]


class Span(Message):
    """A self-contained record of one cycle. Sent without a header."""

    NAME = "zeronav.Span.v3"
    SIZE = 152
    SCHEMA = 0x9df02c0f69b58fcf
    OFFSETS = (0, 2, 4, 8, 16, 24, 32, 40, 48, 56, 64, 72, 80, 88, 96, 104, 108, 112, 120, 128,
        136)
    _fields_ = [
        # Code of the `Role`.
        ("role", u16),
        # Code of `SpanKind`.
        ("kind", u16),
        # [number] Epoch of the process.
        ("epoch", u32),
        # [tick] Tick that was answered.
        ("tick", u64),
        # [id] Inputs: id on `robot/odometry`, or the robot's own tick.
        ("odometry", u64),
        # [id] Inputs: id on `robot/scan`; from the robot: the scan it published.
        ("scan", u64),
        # [id] Inputs: revision of the map.
        ("map", u64),
        # [id] Inputs: id on `plan/path`.
        ("path", u64),
        # [id] Inputs: id of the request, or of the velocity command that the robot applied.
        ("request", u64),
        # [id] Inputs: id on `task/goal`.
        ("goal", u64),
        # [id] Id of the main message that was published; 0 = none.
        ("output", u64),
        # [ns] Moment of the data that came in: the scan's capture; for the robot its own.
        ("capture_ns", u64),
        # [ns] return from the wait.
        ("woken_ns", u64),
        # [ns] inputs taken in.
        ("started_ns", u64),
        # [ns] main message sent.
        ("published_ns", u64),
        # [count] Inputs that a newer one had overtaken, in this cycle.
        ("superseded", u32),
        # [count] Work done in units of the role: beams, expansions, rollouts.
        ("work", u32),
        # [number] FNV-1a of what the cycle published (headers without stamps, and payload);
        # lockstep only.
        ("hash", u64),
        # [ns] between the wake and the end of the cycle in which the thread did not run: it was
        # preempted, waited for a page, or slept for a delay put in on purpose.
        ("off_processor_ns", u64),
        # Robot only, real time: `CLOCK_MONOTONIC_RAW` at `capture_ns`, of a command that was
        # applied at `started_ns`; 0 = none. [ns]
        ("raw_ns", u64),
        # [ns] Times of the stages of the role (`Stage::of`), one after the other from `started_ns`
        # on and by the same clock; what is left until `published_ns` belongs to none. 0 = did not
        # run, or was not timed (`stages` of `run/clock`).
        ("stages_ns", u32 * 4),
    ]


class UserMessage(Message):
    """Fixed fields of a message on a user's own topic; the slice holds its bytes."""

    NAME = "zeronav.UserMessage.v1"
    SIZE = 8
    SCHEMA = 0x8b22ab13735b6140
    OFFSETS = (0,)
    _fields_ = [
        # [number] FNV-1a of the text of the form.
        ("form", u64),
    ]


class UserEnvelope(Message):
    """Header and fixed fields of a message on a user's own topic."""

    NAME = "zeronav.user.v1"
    SIZE = 136
    SCHEMA = 0x64a9cb430099747a
    OFFSETS = (0, 128)
    _fields_ = [
        # The header.
        ("header", Header),
        # The fixed fields.
        ("meta", UserMessage),
    ]


ROBOT_DESCRIPTION = Topic(
    number=0,
    name="robot/description",
    discipline="latched",
    envelope=RobotDescriptionEnvelope,
    item=Corner,
    writers=(Role.ROBOT,),
    rings=(Role.MAPPING, Role.GLOBAL_PLANNER, Role.LOCAL_PLANNER, Role.COLLISION_GUARD),
    rings_in_lockstep=(),
    len_max=32,
    buffer=2,
    pool=59,
    schema=0x4269f1a2e0ce4de2,
)

ROBOT_SCAN = Topic(
    number=1,
    name="robot/scan",
    discipline="latest",
    envelope=RobotScanEnvelope,
    item=f32,
    writers=(Role.ROBOT,),
    rings=(Role.MAPPING, Role.LOCAL_PLANNER),
    rings_in_lockstep=(),
    len_max=4096,
    buffer=2,
    pool=58,
    schema=0x7caddf9ddb10ba5c,
)

ROBOT_ODOMETRY = Topic(
    number=2,
    name="robot/odometry",
    discipline="stream",
    envelope=RobotOdometryEnvelope,
    item=u8,
    writers=(Role.ROBOT,),
    rings=(Role.LOCAL_PLANNER, Role.COLLISION_GUARD),
    rings_in_lockstep=(Role.MAPPING, Role.GLOBAL_PLANNER),
    len_max=1,
    buffer=32,
    pool=46,
    schema=0x539bfa04c81d517b,
)

MAP_UPDATE = Topic(
    number=3,
    name="map/update",
    discipline="stream",
    envelope=MapUpdateEnvelope,
    item=MapTile,
    writers=(Role.MAPPING,),
    rings=(Role.GLOBAL_PLANNER, Role.LOCAL_PLANNER),
    rings_in_lockstep=(),
    len_max=60,
    buffer=32,
    pool=46,
    schema=0xc6a1406d687e61c3,
)

MAP_KEYFRAME = Topic(
    number=4,
    name="map/keyframe",
    discipline="latched",
    envelope=MapKeyframeEnvelope,
    item=MapTile,
    writers=(Role.MAPPING,),
    rings=(Role.GLOBAL_PLANNER, Role.LOCAL_PLANNER),
    rings_in_lockstep=(),
    len_max=16384,
    buffer=2,
    pool=4,
    schema=0x1228f06e42e1b3f0,
)

MAP_OBSTACLES = Topic(
    number=5,
    name="map/obstacles",
    discipline="latest",
    envelope=MapObstaclesEnvelope,
    item=Obstacle,
    writers=(Role.MAPPING,),
    rings=(),
    rings_in_lockstep=(),
    len_max=128,
    buffer=2,
    pool=58,
    schema=0xea9d1f73e5827ded,
)

PLAN_PATH = Topic(
    number=6,
    name="plan/path",
    discipline="latest",
    envelope=PlanPathEnvelope,
    item=Waypoint,
    writers=(Role.GLOBAL_PLANNER,),
    rings=(Role.LOCAL_PLANNER,),
    rings_in_lockstep=(),
    len_max=2048,
    buffer=2,
    pool=58,
    schema=0x98746698aac9e113,
)

PLAN_REQUEST = Topic(
    number=7,
    name="plan/request",
    discipline="latest",
    envelope=PlanRequestEnvelope,
    item=u8,
    writers=(Role.LOCAL_PLANNER,),
    rings=(Role.GLOBAL_PLANNER,),
    rings_in_lockstep=(),
    len_max=1,
    buffer=2,
    pool=58,
    schema=0x904f8c1a2cb8a816,
)

TASK_GOAL = Topic(
    number=8,
    name="task/goal",
    discipline="latched",
    envelope=TaskGoalEnvelope,
    item=Goal,
    writers=(Role.LAUNCH,),
    rings=(Role.GLOBAL_PLANNER, Role.LOCAL_PLANNER),
    rings_in_lockstep=(),
    len_max=64,
    buffer=2,
    pool=59,
    schema=0x91f13d6d71f9fd5b,
)

TASK_STATUS = Topic(
    number=9,
    name="task/status",
    discipline="latched",
    envelope=TaskStatusEnvelope,
    item=GoalEnd,
    writers=(Role.LOCAL_PLANNER,),
    rings=(Role.GLOBAL_PLANNER,),
    rings_in_lockstep=(),
    len_max=64,
    buffer=2,
    pool=59,
    schema=0x5c1beab4fcb50bb2,
)

TASK_POSE = Topic(
    number=24,
    name="task/pose",
    discipline="latched",
    envelope=TaskPoseEnvelope,
    item=u8,
    writers=(Role.LAUNCH,),
    rings=(Role.MAPPING,),
    rings_in_lockstep=(),
    len_max=1,
    buffer=2,
    pool=59,
    schema=0xd5e6227b7f2b7155,
)

TASK_ZONES = Topic(
    number=27,
    name="task/zones",
    discipline="latched",
    envelope=TaskZonesEnvelope,
    item=ZonePart,
    writers=(Role.LAUNCH,),
    rings=(Role.MAPPING, Role.LOCAL_PLANNER, Role.COLLISION_GUARD),
    rings_in_lockstep=(),
    len_max=512,
    buffer=2,
    pool=59,
    schema=0x69d4f97669679555,
)

CONTROL_VELOCITY_REQUEST = Topic(
    number=10,
    name="control/velocity_request",
    discipline="latest",
    envelope=ControlVelocityRequestEnvelope,
    item=u8,
    writers=(Role.LOCAL_PLANNER,),
    rings=(Role.COLLISION_GUARD,),
    rings_in_lockstep=(),
    len_max=1,
    buffer=2,
    pool=58,
    schema=0xbca40804cf7a583b,
)

ROBOT_VELOCITY_COMMAND = Topic(
    number=11,
    name="robot/velocity_command",
    discipline="latest",
    envelope=RobotVelocityCommandEnvelope,
    item=u8,
    writers=(Role.COLLISION_GUARD,),
    rings=(Role.ROBOT,),
    rings_in_lockstep=(),
    len_max=1,
    buffer=2,
    pool=58,
    schema=0x00d63076348ff2bd,
)

RUN_CLOCK = Topic(
    number=12,
    name="run/clock",
    discipline="latched",
    envelope=RunClockEnvelope,
    item=u8,
    writers=(Role.LAUNCH,),
    rings=(Role.ROBOT, Role.MAPPING, Role.GLOBAL_PLANNER, Role.LOCAL_PLANNER,
        Role.COLLISION_GUARD),
    rings_in_lockstep=(),
    len_max=1,
    buffer=2,
    pool=59,
    schema=0x2e21d988789afa53,
)

RUN_CONTROL = Topic(
    number=13,
    name="run/control",
    discipline="latched",
    envelope=RunControlEnvelope,
    item=Seat,
    writers=(Role.LAUNCH,),
    rings=(Role.ROBOT, Role.MAPPING, Role.GLOBAL_PLANNER, Role.LOCAL_PLANNER,
        Role.COLLISION_GUARD),
    rings_in_lockstep=(),
    len_max=16,
    buffer=2,
    pool=59,
    schema=0x0832878dcde34582,
)

SIM_GROUND_TRUTH = Topic(
    number=14,
    name="sim/ground_truth",
    discipline="latest",
    envelope=SimGroundTruthEnvelope,
    item=TruthObstacle,
    writers=(Role.ROBOT,),
    rings=(),
    rings_in_lockstep=(),
    len_max=256,
    buffer=2,
    pool=58,
    schema=0x1e53b96e61365535,
)

SIM_FORESIGHT = Topic(
    number=26,
    name="sim/foresight",
    discipline="latest",
    envelope=SimForesightEnvelope,
    item=Foreseen,
    writers=(Role.ROBOT,),
    rings=(),
    rings_in_lockstep=(),
    len_max=128,
    buffer=2,
    pool=58,
    schema=0x0c5d3692f4580ad9,
)

SIM_PLACEMENT = Topic(
    number=22,
    name="sim/placement",
    discipline="latest",
    envelope=SimPlacementEnvelope,
    item=Placement,
    writers=(Role.LAUNCH,),
    rings=(Role.ROBOT,),
    rings_in_lockstep=(),
    len_max=256,
    buffer=2,
    pool=58,
    schema=0x7b6be6082eb79558,
)

DEBUG_ROLLOUTS = Topic(
    number=25,
    name="debug/rollouts",
    discipline="latest",
    envelope=DebugRolloutsEnvelope,
    item=Rollout,
    writers=(Role.LOCAL_PLANNER,),
    rings=(),
    rings_in_lockstep=(),
    len_max=64,
    buffer=2,
    pool=58,
    schema=0x9c632191d0f72eac,
)

HEALTH_ROBOT = Topic(
    number=16,
    name="health/robot",
    discipline="latest",
    envelope=HealthEnvelope,
    item=u8,
    writers=(Role.ROBOT,),
    rings=(),
    rings_in_lockstep=(),
    len_max=1,
    buffer=2,
    pool=58,
    schema=0x3479845f530eb3c6,
)

HEALTH_MAPPING = Topic(
    number=17,
    name="health/mapping",
    discipline="latest",
    envelope=HealthEnvelope,
    item=u8,
    writers=(Role.MAPPING,),
    rings=(),
    rings_in_lockstep=(),
    len_max=1,
    buffer=2,
    pool=58,
    schema=0x714d8d90f31678b8,
)

HEALTH_GLOBAL_PLANNER = Topic(
    number=18,
    name="health/global_planner",
    discipline="latest",
    envelope=HealthEnvelope,
    item=u8,
    writers=(Role.GLOBAL_PLANNER,),
    rings=(),
    rings_in_lockstep=(),
    len_max=1,
    buffer=2,
    pool=58,
    schema=0x807e7f5586b4ce42,
)

HEALTH_LOCAL_PLANNER = Topic(
    number=19,
    name="health/local_planner",
    discipline="latest",
    envelope=HealthEnvelope,
    item=u8,
    writers=(Role.LOCAL_PLANNER,),
    rings=(),
    rings_in_lockstep=(),
    len_max=1,
    buffer=2,
    pool=58,
    schema=0x4f81d396ef28bf9e,
)

HEALTH_COLLISION_GUARD = Topic(
    number=20,
    name="health/collision_guard",
    discipline="latest",
    envelope=HealthEnvelope,
    item=u8,
    writers=(Role.COLLISION_GUARD,),
    rings=(),
    rings_in_lockstep=(),
    len_max=1,
    buffer=2,
    pool=58,
    schema=0x708ae803c9a76d58,
)

RUN_SPANS = Topic(
    number=21,
    name="run/spans",
    discipline="records",
    envelope=None,
    item=Span,
    writers=(Role.ROBOT, Role.MAPPING, Role.GLOBAL_PLANNER, Role.LOCAL_PLANNER,
        Role.COLLISION_GUARD),
    rings=(),
    rings_in_lockstep=(Role.ROBOT,),
    len_max=1,
    buffer=1024,
    pool=1038,
    schema=0x9070cc0c5473c554,
)

TOPICS = (
    ROBOT_DESCRIPTION,
    ROBOT_SCAN,
    ROBOT_ODOMETRY,
    MAP_UPDATE,
    MAP_KEYFRAME,
    MAP_OBSTACLES,
    PLAN_PATH,
    PLAN_REQUEST,
    TASK_GOAL,
    TASK_STATUS,
    TASK_POSE,
    TASK_ZONES,
    CONTROL_VELOCITY_REQUEST,
    ROBOT_VELOCITY_COMMAND,
    RUN_CLOCK,
    RUN_CONTROL,
    SIM_GROUND_TRUTH,
    SIM_FORESIGHT,
    SIM_PLACEMENT,
    DEBUG_ROLLOUTS,
    HEALTH_ROBOT,
    HEALTH_MAPPING,
    HEALTH_GLOBAL_PLANNER,
    HEALTH_LOCAL_PLANNER,
    HEALTH_COLLISION_GUARD,
    RUN_SPANS,
)

HEALTH = {
    Role.ROBOT: HEALTH_ROBOT,
    Role.MAPPING: HEALTH_MAPPING,
    Role.GLOBAL_PLANNER: HEALTH_GLOBAL_PLANNER,
    Role.LOCAL_PLANNER: HEALTH_LOCAL_PLANNER,
    Role.COLLISION_GUARD: HEALTH_COLLISION_GUARD,
}

for _message in (
    Parents,
    Stamps,
    Header,
    Pose,
    Description,
    RobotDescriptionEnvelope,
    Corner,
    Scan,
    RobotScanEnvelope,
    Odometry,
    RobotOdometryEnvelope,
    GridGeometry,
    CostModel,
    WayOut,
    MapInfo,
    MapUpdateEnvelope,
    MapCell,
    MapTile,
    MapKeyframeEnvelope,
    Obstacles,
    MapObstaclesEnvelope,
    Obstacle,
    Path,
    PlanPathEnvelope,
    Waypoint,
    PlanRequest,
    PlanRequestEnvelope,
    Task,
    TaskGoalEnvelope,
    Goal,
    TaskStatus,
    TaskStatusEnvelope,
    GoalEnd,
    PoseEstimate,
    TaskPoseEnvelope,
    Zones,
    TaskZonesEnvelope,
    ZonePart,
    VelocityRequest,
    ControlVelocityRequestEnvelope,
    VelocityCommand,
    RobotVelocityCommandEnvelope,
    RunClock,
    RunClockEnvelope,
    TopicFault,
    RunControl,
    RunControlEnvelope,
    Seat,
    Truth,
    SimGroundTruthEnvelope,
    TruthObstacle,
    Foresight,
    SimForesightEnvelope,
    Foreseen,
    Placements,
    SimPlacementEnvelope,
    Placement,
    Rollouts,
    DebugRolloutsEnvelope,
    Rollout,
    Health,
    HealthEnvelope,
    Span,
    UserMessage,
    UserEnvelope,
):
    verify(_message)
for _topic in TOPICS:
    _topic.verify()
