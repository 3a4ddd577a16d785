// The contract between the processes of zeronav: messages, codes, topics.
//
// Written by `cargo run -p zeronav-msgs --example bindings`; changes belong into the crate `msgs`.
// The compiler checks size, offsets and schema hash of every message.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <tuple>
#include <type_traits>

namespace zeronav {

/// 64-bit FNV-1a of `bytes`, continued from `state`.
constexpr std::uint64_t fnv1a(std::uint64_t state, std::string_view bytes) {
    for (const char byte : bytes) {
        state = (state ^ static_cast<unsigned char>(byte)) * 0x0000'0100'0000'01b3;
    }
    return state;
}

/// 64-bit FNV-1a of the bytes of `number`, the lowest first, continued from `state`.
constexpr std::uint64_t fnv1a_number(std::uint64_t state, std::uint64_t number) {
    for (int byte = 0; byte < 8; ++byte) {
        state = (state ^ ((number >> (8 * byte)) & 0xff)) * 0x0000'0100'0000'01b3;
    }
    return state;
}

/// Start value of the hash.
inline constexpr std::uint64_t FNV_OFFSET = 0xcbf2'9ce4'8422'2325;

/// The schema hash of a type: over names, order, types and offsets.
template <typename T>
struct Schema {
    static constexpr std::uint64_t value = T::SCHEMA;
};
template <typename T, std::size_t N>
struct Schema<T[N]> {
    static constexpr std::uint64_t value = fnv1a_number(fnv1a(Schema<T>::value, "["), N);
};
template <>
struct Schema<std::uint8_t> {
    static constexpr std::uint64_t value = fnv1a(FNV_OFFSET, "u8");
};
template <>
struct Schema<std::uint16_t> {
    static constexpr std::uint64_t value = fnv1a(FNV_OFFSET, "u16");
};
template <>
struct Schema<std::uint32_t> {
    static constexpr std::uint64_t value = fnv1a(FNV_OFFSET, "u32");
};
template <>
struct Schema<std::uint64_t> {
    static constexpr std::uint64_t value = fnv1a(FNV_OFFSET, "u64");
};
template <>
struct Schema<std::int32_t> {
    static constexpr std::uint64_t value = fnv1a(FNV_OFFSET, "i32");
};
template <>
struct Schema<float> {
    static constexpr std::uint64_t value = fnv1a(FNV_OFFSET, "f32");
};
template <>
struct Schema<double> {
    static constexpr std::uint64_t value = fnv1a(FNV_OFFSET, "f64");
};

enum class EndReason : std::uint16_t {
    none = 0,
    unreachable = 1,
    goal_blocked = 2,
    goal_outside_map = 3,
    stuck = 4,
    no_path = 5,
    replaced = 6,
    pose_unknown = 7,
};

enum class HealthState : std::uint16_t {
    starting = 0,
    ready = 1,
    degraded = 2,
    stopping = 3,
};

enum class Intervention : std::uint16_t {
    none = 0,
    clamped = 1,
    refused = 2,
    request_stale = 3,
    scan_stale = 4,
    odometry_stale = 5,
    slowed = 6,
    stopped_short = 7,
    zone_slowed = 8,
    zone_stopped = 9,
    zones_missing = 10,
};

enum class ObstacleSource : std::uint16_t {
    none = 0,
    static_map = 1,
    lidar = 2,
    tracked = 3,
    unknown = 4,
    keepout = 5,
};

enum class PathBlock : std::uint16_t {
    none = 0,
    robot = 1,
    goal = 2,
    path_before = 3,
    closed = 4,
    obstacle = 5,
};

enum class PathCause : std::uint16_t {
    none = 0,
    goal = 1,
    obstacle = 2,
    request = 3,
    shortcut = 4,
    next_goal = 5,
    improved = 6,
};

enum class PathStatus : std::uint16_t {
    no_goal = 0,
    found = 1,
    start_outside_map = 2,
    start_blocked = 3,
    goal_outside_map = 4,
    goal_blocked = 5,
    unreachable = 6,
    unreachable_corner = 7,
    dead_end = 8,
    out_of_budget = 9,
    too_long = 10,
};

enum class PlannerInput : std::uint16_t {
    none = 0,
    odometry = 1,
    scan = 2,
    map = 3,
    path = 4,
    description = 5,
    pose = 6,
};

enum class PoseCertainty : std::uint16_t {
    unknown = 0,
    unconfirmed = 1,
    confirmed = 2,
};

enum class RecoveryReason : std::uint16_t {
    none = 0,
    blocked = 1,
    no_progress = 2,
    dynamic_obstacle = 3,
    timed_out = 4,
    stuck = 5,
    out_of_attempts = 6,
};

enum class RequestCause : std::uint16_t {
    none = 0,
    free = 1,
    goal = 2,
    corner = 3,
    critics = 4,
    ageing = 5,
    heading = 6,
    turn = 7,
    turn_wait = 8,
    arrive = 9,
    goal_yaw = 10,
    blocked = 11,
    stale = 12,
    ask_for_path = 13,
    back_up = 14,
    rotate = 15,
    wait = 16,
    give_up = 17,
    clearance_critic = 18,
    path_critic = 19,
    progress_critic = 20,
    dynamic_obstacle_critic = 21,
    smoothness_critic = 22,
    stopping_distance = 23,
    timed_search = 24,
    potential_field = 25,
    yield = 26,
    manoeuvre = 27,
    no_fit = 28,
    seek_pose = 29,
    speed_zone = 30,
};

enum class RequestReason : std::uint16_t {
    none = 0,
    blocked = 1,
    off_path = 2,
    no_progress = 3,
};

enum class Role : std::uint16_t {
    launch = 1,
    robot = 2,
    mapping = 3,
    global_planner = 4,
    local_planner = 5,
    collision_guard = 6,
    tap = 7,
};

enum class RolloutOutcome : std::uint16_t {
    none = 0,
    chosen = 1,
    costlier = 2,
    collision = 3,
    moving_collision = 4,
    no_stop = 5,
};

enum class RunMode : std::uint16_t {
    none = 0,
    real_time = 1,
    lockstep = 2,
};

enum class TopicFaultKind : std::uint16_t {
    none = 0,
    drop = 1,
    delay = 2,
    corrupt = 3,
};

enum class SpanKind : std::uint16_t {
    idle = 1,
    answer = 2,
    extra = 3,
    applied = 4,
};

enum class StuckCause : std::uint16_t {
    none = 0,
    blocked = 1,
    no_progress = 2,
    too_many_attempts = 3,
};

enum class TaskKind : std::uint16_t {
    none = 0,
    go = 1,
    cancel = 2,
};

enum class TaskState : std::uint16_t {
    idle = 0,
    active = 1,
    reached = 2,
    failed = 3,
    cancelled = 4,
};

enum class Validity : std::uint16_t {
    no_path = 0,
    drive = 1,
    at_goal = 2,
    blocked = 3,
    stale = 4,
    no_request = 5,
    stopped = 6,
};

enum class ZoneKind : std::uint16_t {
    none = 0,
    keepout = 1,
    speed_limit = 2,
    speed_percent = 3,
    cost = 4,
    lane = 5,
};

inline constexpr int SHADOW_EPOCH_MIN = 8388608;
inline constexpr int COORDINATE_M_MAX = 1000000;
inline constexpr int SPEED_MAX = 1000;
inline constexpr int CLOCK_OFFSET_MS_MAX = 10000;
inline constexpr int DELAY_STEP_NS = 10000;
inline constexpr int DELAY_US_MAX = 10000000;
inline constexpr int SHARE_ALL = 1000000;
inline constexpr int FORESIGHT_PERCEIVE = 1;
inline constexpr int FORESIGHT_PREDICT = 2;
inline constexpr int EVENT_MAX = 63;
inline constexpr int EVENT_NEED_KEYFRAME = 40;
inline constexpr int NODES_MAX = 24;
inline constexpr int READERS_MAX = 12;
inline constexpr int WRITERS_MAX = 4;
inline constexpr int SIDE_CELLS_MAX = 8192;
inline constexpr int TILE_CELLS = 32;
inline constexpr int COST_FREE = 0;
inline constexpr int COST_CIRCUMSCRIBED_MAX = 252;
inline constexpr int COST_INSCRIBED = 253;
inline constexpr int COST_LETHAL = 254;
inline constexpr int COST_UNKNOWN = 255;
inline constexpr int FLAG_STATIC = 1;
inline constexpr int FLAG_SENSED = 2;
inline constexpr int FLAG_VIRTUAL = 4;
inline constexpr int FLAG_REGULARISED = 8;
inline constexpr int FLAG_UNKNOWN = 16;
inline constexpr int FLAG_KEEPOUT = 32;
inline constexpr int FORM_BYTES_MAX = 200;
inline constexpr int USER_BORROWED = 2;
inline constexpr int USER_BUFFER = 32;
inline constexpr int USER_BYTES_MAX = 65536;
inline constexpr int USER_NAME_BYTES_MAX = 40;
inline constexpr int USER_POOL = 58;
inline constexpr int ACTUATION_DELAY_NS_MAX = 2000000000;
inline constexpr int ZONES_MAX = 128;
inline constexpr int ZONE_CORNERS_MAX = 16;
inline constexpr int ZONE_COST_MAX = 252;
inline constexpr int ZONE_NAME_BYTES = 32;
inline constexpr int ZONE_PARTS_MAX = 512;
inline constexpr int ZONE_PERCENT_MIN = 1;
inline constexpr double ZONE_SPEED_MPS_MIN = 0.01;
inline constexpr int OBSTACLE_RADIUS_M_MAX = 10;
inline constexpr int ROLLOUT_COST_MAX = 1000000000;
inline constexpr int ROLLOUT_POINTS_MAX = 12;
inline constexpr int REASON_SCAN = 1;
inline constexpr int REASON_ODOMETRY = 2;
inline constexpr int REASON_MAP = 4;
inline constexpr int REASON_PATH = 8;
inline constexpr int REASON_REQUEST = 16;
inline constexpr int REASON_REFUSED = 32;
inline constexpr int REASON_NO_LOAN = 64;
inline constexpr int REASON_TOO_LONG = 128;
inline constexpr int REASON_ZONES = 4096;

/// The messages that the author itself took in for this one; 0 = none. Everything further back is
/// found by joining spans.
struct Parents {
    static constexpr const char* NAME = "zeronav.Parents.v1";
    static constexpr std::uint64_t SCHEMA = 0xc9a84854d50f7859;
    /// [id] Id on `robot/odometry`.
    std::uint64_t odometry{};
    /// [id] Id on `robot/scan`.
    std::uint64_t scan{};
    /// [id] Revision of the map.
    std::uint64_t map{};
    /// [id] Id on `plan/path`.
    std::uint64_t path{};
    /// [id] Id on `plan/request` for a path, on `control/velocity_request` for a command and for
    /// rollouts.
    std::uint64_t request{};
    /// [id] Id on `task/goal`.
    std::uint64_t goal{};
};
static_assert(sizeof(Parents) == 48);
static_assert(std::is_trivially_copyable_v<Parents> && std::is_standard_layout_v<Parents>);
static_assert(offsetof(Parents, odometry) == 0);
static_assert(offsetof(Parents, scan) == 8);
static_assert(offsetof(Parents, map) == 16);
static_assert(offsetof(Parents, path) == 24);
static_assert(offsetof(Parents, request) == 32);
static_assert(offsetof(Parents, goal) == 40);
static_assert(Parents::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, Parents::NAME);
    hash = fnv1a(hash, "odometry");
    hash = fnv1a_number(hash, Schema<decltype(Parents::odometry)>::value);
    hash = fnv1a_number(hash, offsetof(Parents, odometry));
    hash = fnv1a(hash, "scan");
    hash = fnv1a_number(hash, Schema<decltype(Parents::scan)>::value);
    hash = fnv1a_number(hash, offsetof(Parents, scan));
    hash = fnv1a(hash, "map");
    hash = fnv1a_number(hash, Schema<decltype(Parents::map)>::value);
    hash = fnv1a_number(hash, offsetof(Parents, map));
    hash = fnv1a(hash, "path");
    hash = fnv1a_number(hash, Schema<decltype(Parents::path)>::value);
    hash = fnv1a_number(hash, offsetof(Parents, path));
    hash = fnv1a(hash, "request");
    hash = fnv1a_number(hash, Schema<decltype(Parents::request)>::value);
    hash = fnv1a_number(hash, offsetof(Parents, request));
    hash = fnv1a(hash, "goal");
    hash = fnv1a_number(hash, Schema<decltype(Parents::goal)>::value);
    hash = fnv1a_number(hash, offsetof(Parents, goal));
    return hash;
}());

/// The author's own clock readings, [ns] of `CLOCK_MONOTONIC`.
struct Stamps {
    static constexpr const char* NAME = "zeronav.Stamps.v1";
    static constexpr std::uint64_t SCHEMA = 0x0d8040dff7baaf0f;
    /// [ns] Return from the wait.
    std::uint64_t woken_ns{};
    /// [ns] All inputs taken in, work begins.
    std::uint64_t started_ns{};
    /// [ns] Just before the message was sent.
    std::uint64_t published_ns{};
};
static_assert(sizeof(Stamps) == 24);
static_assert(std::is_trivially_copyable_v<Stamps> && std::is_standard_layout_v<Stamps>);
static_assert(offsetof(Stamps, woken_ns) == 0);
static_assert(offsetof(Stamps, started_ns) == 8);
static_assert(offsetof(Stamps, published_ns) == 16);
static_assert(Stamps::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, Stamps::NAME);
    hash = fnv1a(hash, "woken_ns");
    hash = fnv1a_number(hash, Schema<decltype(Stamps::woken_ns)>::value);
    hash = fnv1a_number(hash, offsetof(Stamps, woken_ns));
    hash = fnv1a(hash, "started_ns");
    hash = fnv1a_number(hash, Schema<decltype(Stamps::started_ns)>::value);
    hash = fnv1a_number(hash, offsetof(Stamps, started_ns));
    hash = fnv1a(hash, "published_ns");
    hash = fnv1a_number(hash, Schema<decltype(Stamps::published_ns)>::value);
    hash = fnv1a_number(hash, offsetof(Stamps, published_ns));
    return hash;
}());

/// Fixed header of every message.
struct Header {
    static constexpr const char* NAME = "zeronav.Header.v2";
    static constexpr std::uint64_t SCHEMA = 0x127a2a8d11a040a2;
    /// Code of the author's `Role`.
    std::uint16_t role{};
    /// [number] Which robot; 0, because one domain is one robot.
    std::uint16_t robot{};
    /// [number] Low 32 bits of the topic's schema hash.
    std::uint32_t schema{};
    /// [number] Which clock the stamps belong to; 0 = the host of launch.
    std::uint32_t clock{};
    /// Written as 0, ignored by readers.
    std::uint32_t spare{};
    /// [id] Identity, see `Id`.
    std::uint64_t id{};
    /// [tick] Control tick that the message answers; 0 = an idle output before the first tick.
    /// That of a keyframe is the tick of its revision.
    std::uint64_t tick{};
    /// Run time of that tick, for a scan of its capture. [ns]
    std::uint64_t run_ns{};
    /// When the newest sensor data in it was captured, `CLOCK_MONOTONIC`; 0 = none. [ns]
    std::uint64_t capture_ns{};
    /// What it was made from.
    Parents parents{};
    /// When it was made.
    Stamps stamps{};
    /// [number] Checksum of everything else in the message, see `crate::checksum`.
    std::uint64_t checksum{};
};
static_assert(sizeof(Header) == 128);
static_assert(std::is_trivially_copyable_v<Header> && std::is_standard_layout_v<Header>);
static_assert(offsetof(Header, role) == 0);
static_assert(offsetof(Header, robot) == 2);
static_assert(offsetof(Header, schema) == 4);
static_assert(offsetof(Header, clock) == 8);
static_assert(offsetof(Header, spare) == 12);
static_assert(offsetof(Header, id) == 16);
static_assert(offsetof(Header, tick) == 24);
static_assert(offsetof(Header, run_ns) == 32);
static_assert(offsetof(Header, capture_ns) == 40);
static_assert(offsetof(Header, parents) == 48);
static_assert(offsetof(Header, stamps) == 96);
static_assert(offsetof(Header, checksum) == 120);
static_assert(Header::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, Header::NAME);
    hash = fnv1a(hash, "role");
    hash = fnv1a_number(hash, Schema<decltype(Header::role)>::value);
    hash = fnv1a_number(hash, offsetof(Header, role));
    hash = fnv1a(hash, "robot");
    hash = fnv1a_number(hash, Schema<decltype(Header::robot)>::value);
    hash = fnv1a_number(hash, offsetof(Header, robot));
    hash = fnv1a(hash, "schema");
    hash = fnv1a_number(hash, Schema<decltype(Header::schema)>::value);
    hash = fnv1a_number(hash, offsetof(Header, schema));
    hash = fnv1a(hash, "clock");
    hash = fnv1a_number(hash, Schema<decltype(Header::clock)>::value);
    hash = fnv1a_number(hash, offsetof(Header, clock));
    hash = fnv1a(hash, "spare");
    hash = fnv1a_number(hash, Schema<decltype(Header::spare)>::value);
    hash = fnv1a_number(hash, offsetof(Header, spare));
    hash = fnv1a(hash, "id");
    hash = fnv1a_number(hash, Schema<decltype(Header::id)>::value);
    hash = fnv1a_number(hash, offsetof(Header, id));
    hash = fnv1a(hash, "tick");
    hash = fnv1a_number(hash, Schema<decltype(Header::tick)>::value);
    hash = fnv1a_number(hash, offsetof(Header, tick));
    hash = fnv1a(hash, "run_ns");
    hash = fnv1a_number(hash, Schema<decltype(Header::run_ns)>::value);
    hash = fnv1a_number(hash, offsetof(Header, run_ns));
    hash = fnv1a(hash, "capture_ns");
    hash = fnv1a_number(hash, Schema<decltype(Header::capture_ns)>::value);
    hash = fnv1a_number(hash, offsetof(Header, capture_ns));
    hash = fnv1a(hash, "parents");
    hash = fnv1a_number(hash, Schema<decltype(Header::parents)>::value);
    hash = fnv1a_number(hash, offsetof(Header, parents));
    hash = fnv1a(hash, "stamps");
    hash = fnv1a_number(hash, Schema<decltype(Header::stamps)>::value);
    hash = fnv1a_number(hash, offsetof(Header, stamps));
    hash = fnv1a(hash, "checksum");
    hash = fnv1a_number(hash, Schema<decltype(Header::checksum)>::value);
    hash = fnv1a_number(hash, offsetof(Header, checksum));
    return hash;
}());

/// Position and yaw of one frame in another.
struct Pose {
    static constexpr const char* NAME = "zeronav.Pose.v1";
    static constexpr std::uint64_t SCHEMA = 0x026c68dfa3277c78;
    /// [m]
    double x_m{};
    /// [m]
    double y_m{};
    /// [rad] counter-clockwise from +x.
    double yaw_rad{};
};
static_assert(sizeof(Pose) == 24);
static_assert(std::is_trivially_copyable_v<Pose> && std::is_standard_layout_v<Pose>);
static_assert(offsetof(Pose, x_m) == 0);
static_assert(offsetof(Pose, y_m) == 8);
static_assert(offsetof(Pose, yaw_rad) == 16);
static_assert(Pose::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, Pose::NAME);
    hash = fnv1a(hash, "x_m");
    hash = fnv1a_number(hash, Schema<decltype(Pose::x_m)>::value);
    hash = fnv1a_number(hash, offsetof(Pose, x_m));
    hash = fnv1a(hash, "y_m");
    hash = fnv1a_number(hash, Schema<decltype(Pose::y_m)>::value);
    hash = fnv1a_number(hash, offsetof(Pose, y_m));
    hash = fnv1a(hash, "yaw_rad");
    hash = fnv1a_number(hash, Schema<decltype(Pose::yaw_rad)>::value);
    hash = fnv1a_number(hash, offsetof(Pose, yaw_rad));
    return hash;
}());

/// What the robot is. The slice holds the corners of a convex footprint, counter-clockwise in
/// `base`; an empty slice is a disc of `circumscribed_radius_m`.
struct Description {
    static constexpr const char* NAME = "zeronav.Description.v2";
    static constexpr std::uint64_t SCHEMA = 0x96a0516fd40ddf35;
    /// [m] largest disc around the origin of `base` inside the footprint, > 0.
    double inscribed_radius_m{};
    /// [m] smallest disc around the origin of `base` that holds the footprint.
    double circumscribed_radius_m{};
    /// [m/s] fastest forward speed, > 0.
    double v_mps_max{};
    /// [m/s] fastest backward speed as a number <= 0; 0 = never backwards.
    double v_mps_min{};
    /// [rad/s] fastest yaw rate either way, > 0.
    double w_radps_max{};
    /// [m/s^2] largest acceleration, > 0.
    double a_mps2_max{};
    /// [m/s^2] deceleration that braking can rely on, > 0.
    double brake_mps2{};
    /// [rad/s^2] largest yaw acceleration, > 0.
    double alpha_radps2_max{};
    /// `base_from_laser`.
    Pose base_from_laser{};
    /// [rad] direction of beam 0 in `laser`.
    double angle_min_rad{};
    /// [rad] step from beam to beam.
    double angle_increment_rad{};
    /// [m] closest valid range.
    double range_m_min{};
    /// [m] farthest valid range.
    double range_m_max{};
    /// [ns] from scan to scan.
    std::uint64_t scan_period_ns{};
    /// [ns] from a command's arrival to its taking effect; until then the commands before it are
    /// obeyed.
    std::uint64_t actuation_delay_ns{};
    /// [count] Beams of a scan.
    std::uint32_t n_beams{};
    /// [count] Corners in the slice, 0 = disc.
    std::uint32_t n_corners{};
};
static_assert(sizeof(Description) == 144);
static_assert(std::is_trivially_copyable_v<Description> && std::is_standard_layout_v<Description>);
static_assert(offsetof(Description, inscribed_radius_m) == 0);
static_assert(offsetof(Description, circumscribed_radius_m) == 8);
static_assert(offsetof(Description, v_mps_max) == 16);
static_assert(offsetof(Description, v_mps_min) == 24);
static_assert(offsetof(Description, w_radps_max) == 32);
static_assert(offsetof(Description, a_mps2_max) == 40);
static_assert(offsetof(Description, brake_mps2) == 48);
static_assert(offsetof(Description, alpha_radps2_max) == 56);
static_assert(offsetof(Description, base_from_laser) == 64);
static_assert(offsetof(Description, angle_min_rad) == 88);
static_assert(offsetof(Description, angle_increment_rad) == 96);
static_assert(offsetof(Description, range_m_min) == 104);
static_assert(offsetof(Description, range_m_max) == 112);
static_assert(offsetof(Description, scan_period_ns) == 120);
static_assert(offsetof(Description, actuation_delay_ns) == 128);
static_assert(offsetof(Description, n_beams) == 136);
static_assert(offsetof(Description, n_corners) == 140);
static_assert(Description::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, Description::NAME);
    hash = fnv1a(hash, "inscribed_radius_m");
    hash = fnv1a_number(hash, Schema<decltype(Description::inscribed_radius_m)>::value);
    hash = fnv1a_number(hash, offsetof(Description, inscribed_radius_m));
    hash = fnv1a(hash, "circumscribed_radius_m");
    hash = fnv1a_number(hash, Schema<decltype(Description::circumscribed_radius_m)>::value);
    hash = fnv1a_number(hash, offsetof(Description, circumscribed_radius_m));
    hash = fnv1a(hash, "v_mps_max");
    hash = fnv1a_number(hash, Schema<decltype(Description::v_mps_max)>::value);
    hash = fnv1a_number(hash, offsetof(Description, v_mps_max));
    hash = fnv1a(hash, "v_mps_min");
    hash = fnv1a_number(hash, Schema<decltype(Description::v_mps_min)>::value);
    hash = fnv1a_number(hash, offsetof(Description, v_mps_min));
    hash = fnv1a(hash, "w_radps_max");
    hash = fnv1a_number(hash, Schema<decltype(Description::w_radps_max)>::value);
    hash = fnv1a_number(hash, offsetof(Description, w_radps_max));
    hash = fnv1a(hash, "a_mps2_max");
    hash = fnv1a_number(hash, Schema<decltype(Description::a_mps2_max)>::value);
    hash = fnv1a_number(hash, offsetof(Description, a_mps2_max));
    hash = fnv1a(hash, "brake_mps2");
    hash = fnv1a_number(hash, Schema<decltype(Description::brake_mps2)>::value);
    hash = fnv1a_number(hash, offsetof(Description, brake_mps2));
    hash = fnv1a(hash, "alpha_radps2_max");
    hash = fnv1a_number(hash, Schema<decltype(Description::alpha_radps2_max)>::value);
    hash = fnv1a_number(hash, offsetof(Description, alpha_radps2_max));
    hash = fnv1a(hash, "base_from_laser");
    hash = fnv1a_number(hash, Schema<decltype(Description::base_from_laser)>::value);
    hash = fnv1a_number(hash, offsetof(Description, base_from_laser));
    hash = fnv1a(hash, "angle_min_rad");
    hash = fnv1a_number(hash, Schema<decltype(Description::angle_min_rad)>::value);
    hash = fnv1a_number(hash, offsetof(Description, angle_min_rad));
    hash = fnv1a(hash, "angle_increment_rad");
    hash = fnv1a_number(hash, Schema<decltype(Description::angle_increment_rad)>::value);
    hash = fnv1a_number(hash, offsetof(Description, angle_increment_rad));
    hash = fnv1a(hash, "range_m_min");
    hash = fnv1a_number(hash, Schema<decltype(Description::range_m_min)>::value);
    hash = fnv1a_number(hash, offsetof(Description, range_m_min));
    hash = fnv1a(hash, "range_m_max");
    hash = fnv1a_number(hash, Schema<decltype(Description::range_m_max)>::value);
    hash = fnv1a_number(hash, offsetof(Description, range_m_max));
    hash = fnv1a(hash, "scan_period_ns");
    hash = fnv1a_number(hash, Schema<decltype(Description::scan_period_ns)>::value);
    hash = fnv1a_number(hash, offsetof(Description, scan_period_ns));
    hash = fnv1a(hash, "actuation_delay_ns");
    hash = fnv1a_number(hash, Schema<decltype(Description::actuation_delay_ns)>::value);
    hash = fnv1a_number(hash, offsetof(Description, actuation_delay_ns));
    hash = fnv1a(hash, "n_beams");
    hash = fnv1a_number(hash, Schema<decltype(Description::n_beams)>::value);
    hash = fnv1a_number(hash, offsetof(Description, n_beams));
    hash = fnv1a(hash, "n_corners");
    hash = fnv1a_number(hash, Schema<decltype(Description::n_corners)>::value);
    hash = fnv1a_number(hash, offsetof(Description, n_corners));
    return hash;
}());

/// Header and fixed fields of the topic's messages.
struct RobotDescriptionEnvelope {
    static constexpr const char* NAME = "zeronav.robot.description.v1";
    static constexpr std::uint64_t SCHEMA = 0x6e64a288bef5faec;
    /// The header.
    Header header{};
    /// The fixed fields.
    Description meta{};
};
static_assert(sizeof(RobotDescriptionEnvelope) == 272);
static_assert(std::is_trivially_copyable_v<RobotDescriptionEnvelope> && std::is_standard_layout_v<RobotDescriptionEnvelope>);
static_assert(offsetof(RobotDescriptionEnvelope, header) == 0);
static_assert(offsetof(RobotDescriptionEnvelope, meta) == 128);
static_assert(RobotDescriptionEnvelope::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, RobotDescriptionEnvelope::NAME);
    hash = fnv1a(hash, "header");
    hash = fnv1a_number(hash, Schema<decltype(RobotDescriptionEnvelope::header)>::value);
    hash = fnv1a_number(hash, offsetof(RobotDescriptionEnvelope, header));
    hash = fnv1a(hash, "meta");
    hash = fnv1a_number(hash, Schema<decltype(RobotDescriptionEnvelope::meta)>::value);
    hash = fnv1a_number(hash, offsetof(RobotDescriptionEnvelope, meta));
    return hash;
}());

/// A corner of the footprint.
struct Corner {
    static constexpr const char* NAME = "zeronav.Corner.v1";
    static constexpr std::uint64_t SCHEMA = 0x6890156a2f0f11c1;
    /// [m] in `base`.
    double x_m{};
    /// [m] in `base`.
    double y_m{};
};
static_assert(sizeof(Corner) == 16);
static_assert(std::is_trivially_copyable_v<Corner> && std::is_standard_layout_v<Corner>);
static_assert(offsetof(Corner, x_m) == 0);
static_assert(offsetof(Corner, y_m) == 8);
static_assert(Corner::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, Corner::NAME);
    hash = fnv1a(hash, "x_m");
    hash = fnv1a_number(hash, Schema<decltype(Corner::x_m)>::value);
    hash = fnv1a_number(hash, offsetof(Corner, x_m));
    hash = fnv1a(hash, "y_m");
    hash = fnv1a_number(hash, Schema<decltype(Corner::y_m)>::value);
    hash = fnv1a_number(hash, offsetof(Corner, y_m));
    return hash;
}());

/// Fixed fields of a scan. The slice holds one range per beam: [m] in the `laser` frame, +inf = no
/// return within `range_max_m`, NaN = invalid. Beam `i` points to `angle_min_rad + i *
/// angle_increment_rad`. The header's capture is that of the last beam.
struct Scan {
    static constexpr const char* NAME = "zeronav.Scan.v1";
    static constexpr std::uint64_t SCHEMA = 0xcc817f81a2050ae0;
    /// [number] Which sensor, from 0.
    std::uint32_t sensor{};
    /// [count] Number of beams, equal to the length of the slice.
    std::uint32_t n_beams{};
    /// [rad] direction of beam 0.
    float angle_min_rad{};
    /// [rad] step from beam to beam, not 0, positive = counter-clockwise.
    float angle_increment_rad{};
    /// [s] time from beam to beam, 0 = all at once.
    float time_increment_s{};
    /// [m] closest valid range.
    float range_m_min{};
    /// [m] farthest valid range.
    float range_m_max{};
    /// Written as 0.
    std::uint32_t spare{};
};
static_assert(sizeof(Scan) == 32);
static_assert(std::is_trivially_copyable_v<Scan> && std::is_standard_layout_v<Scan>);
static_assert(offsetof(Scan, sensor) == 0);
static_assert(offsetof(Scan, n_beams) == 4);
static_assert(offsetof(Scan, angle_min_rad) == 8);
static_assert(offsetof(Scan, angle_increment_rad) == 12);
static_assert(offsetof(Scan, time_increment_s) == 16);
static_assert(offsetof(Scan, range_m_min) == 20);
static_assert(offsetof(Scan, range_m_max) == 24);
static_assert(offsetof(Scan, spare) == 28);
static_assert(Scan::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, Scan::NAME);
    hash = fnv1a(hash, "sensor");
    hash = fnv1a_number(hash, Schema<decltype(Scan::sensor)>::value);
    hash = fnv1a_number(hash, offsetof(Scan, sensor));
    hash = fnv1a(hash, "n_beams");
    hash = fnv1a_number(hash, Schema<decltype(Scan::n_beams)>::value);
    hash = fnv1a_number(hash, offsetof(Scan, n_beams));
    hash = fnv1a(hash, "angle_min_rad");
    hash = fnv1a_number(hash, Schema<decltype(Scan::angle_min_rad)>::value);
    hash = fnv1a_number(hash, offsetof(Scan, angle_min_rad));
    hash = fnv1a(hash, "angle_increment_rad");
    hash = fnv1a_number(hash, Schema<decltype(Scan::angle_increment_rad)>::value);
    hash = fnv1a_number(hash, offsetof(Scan, angle_increment_rad));
    hash = fnv1a(hash, "time_increment_s");
    hash = fnv1a_number(hash, Schema<decltype(Scan::time_increment_s)>::value);
    hash = fnv1a_number(hash, offsetof(Scan, time_increment_s));
    hash = fnv1a(hash, "range_m_min");
    hash = fnv1a_number(hash, Schema<decltype(Scan::range_m_min)>::value);
    hash = fnv1a_number(hash, offsetof(Scan, range_m_min));
    hash = fnv1a(hash, "range_m_max");
    hash = fnv1a_number(hash, Schema<decltype(Scan::range_m_max)>::value);
    hash = fnv1a_number(hash, offsetof(Scan, range_m_max));
    hash = fnv1a(hash, "spare");
    hash = fnv1a_number(hash, Schema<decltype(Scan::spare)>::value);
    hash = fnv1a_number(hash, offsetof(Scan, spare));
    return hash;
}());

/// Header and fixed fields of the topic's messages.
struct RobotScanEnvelope {
    static constexpr const char* NAME = "zeronav.robot.scan.v1";
    static constexpr std::uint64_t SCHEMA = 0xacf1bce78b014166;
    /// The header.
    Header header{};
    /// The fixed fields.
    Scan meta{};
};
static_assert(sizeof(RobotScanEnvelope) == 160);
static_assert(std::is_trivially_copyable_v<RobotScanEnvelope> && std::is_standard_layout_v<RobotScanEnvelope>);
static_assert(offsetof(RobotScanEnvelope, header) == 0);
static_assert(offsetof(RobotScanEnvelope, meta) == 128);
static_assert(RobotScanEnvelope::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, RobotScanEnvelope::NAME);
    hash = fnv1a(hash, "header");
    hash = fnv1a_number(hash, Schema<decltype(RobotScanEnvelope::header)>::value);
    hash = fnv1a_number(hash, offsetof(RobotScanEnvelope, header));
    hash = fnv1a(hash, "meta");
    hash = fnv1a_number(hash, Schema<decltype(RobotScanEnvelope::meta)>::value);
    hash = fnv1a_number(hash, offsetof(RobotScanEnvelope, meta));
    return hash;
}());

/// Pose and twist by odometry.
struct Odometry {
    static constexpr const char* NAME = "zeronav.Odometry.v1";
    static constexpr std::uint64_t SCHEMA = 0x964730218dedfa83;
    /// `odom_from_base`.
    Pose pose{};
    /// [m/s] forward speed in `base`.
    double v_mps{};
    /// [rad/s] yaw rate in `base`, counter-clockwise.
    double w_radps{};
    /// [m^2, m^2, rad^2] variances of x, y and yaw, >= 0.
    double variance[3]{};
    /// [flag] 1 when a scan belongs to this tick, 0 when not.
    std::uint32_t scan_due{};
    /// Written as 0.
    std::uint32_t spare{};
};
static_assert(sizeof(Odometry) == 72);
static_assert(std::is_trivially_copyable_v<Odometry> && std::is_standard_layout_v<Odometry>);
static_assert(offsetof(Odometry, pose) == 0);
static_assert(offsetof(Odometry, v_mps) == 24);
static_assert(offsetof(Odometry, w_radps) == 32);
static_assert(offsetof(Odometry, variance) == 40);
static_assert(offsetof(Odometry, scan_due) == 64);
static_assert(offsetof(Odometry, spare) == 68);
static_assert(Odometry::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, Odometry::NAME);
    hash = fnv1a(hash, "pose");
    hash = fnv1a_number(hash, Schema<decltype(Odometry::pose)>::value);
    hash = fnv1a_number(hash, offsetof(Odometry, pose));
    hash = fnv1a(hash, "v_mps");
    hash = fnv1a_number(hash, Schema<decltype(Odometry::v_mps)>::value);
    hash = fnv1a_number(hash, offsetof(Odometry, v_mps));
    hash = fnv1a(hash, "w_radps");
    hash = fnv1a_number(hash, Schema<decltype(Odometry::w_radps)>::value);
    hash = fnv1a_number(hash, offsetof(Odometry, w_radps));
    hash = fnv1a(hash, "variance");
    hash = fnv1a_number(hash, Schema<decltype(Odometry::variance)>::value);
    hash = fnv1a_number(hash, offsetof(Odometry, variance));
    hash = fnv1a(hash, "scan_due");
    hash = fnv1a_number(hash, Schema<decltype(Odometry::scan_due)>::value);
    hash = fnv1a_number(hash, offsetof(Odometry, scan_due));
    hash = fnv1a(hash, "spare");
    hash = fnv1a_number(hash, Schema<decltype(Odometry::spare)>::value);
    hash = fnv1a_number(hash, offsetof(Odometry, spare));
    return hash;
}());

/// Header and fixed fields of the topic's messages.
struct RobotOdometryEnvelope {
    static constexpr const char* NAME = "zeronav.robot.odometry.v1";
    static constexpr std::uint64_t SCHEMA = 0x898ef86160c7c41f;
    /// The header.
    Header header{};
    /// The fixed fields.
    Odometry meta{};
};
static_assert(sizeof(RobotOdometryEnvelope) == 200);
static_assert(std::is_trivially_copyable_v<RobotOdometryEnvelope> && std::is_standard_layout_v<RobotOdometryEnvelope>);
static_assert(offsetof(RobotOdometryEnvelope, header) == 0);
static_assert(offsetof(RobotOdometryEnvelope, meta) == 128);
static_assert(RobotOdometryEnvelope::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, RobotOdometryEnvelope::NAME);
    hash = fnv1a(hash, "header");
    hash = fnv1a_number(hash, Schema<decltype(RobotOdometryEnvelope::header)>::value);
    hash = fnv1a_number(hash, offsetof(RobotOdometryEnvelope, header));
    hash = fnv1a(hash, "meta");
    hash = fnv1a_number(hash, Schema<decltype(RobotOdometryEnvelope::meta)>::value);
    hash = fnv1a_number(hash, offsetof(RobotOdometryEnvelope, meta));
    return hash;
}());

/// Where a grid lies in the map frame. Row-major, `width x height`, half-open cells, origin at the
/// outer corner of cell (0, 0), columns along +x, rows along +y.
struct GridGeometry {
    static constexpr const char* NAME = "zeronav.GridGeometry.v1";
    static constexpr std::uint64_t SCHEMA = 0xbeb89aec645e2897;
    /// [m] map frame, outer corner of cell (0, 0).
    double origin_x_m{};
    /// [m] map frame, outer corner of cell (0, 0).
    double origin_y_m{};
    /// [m] side of a cell, > 0.
    double resolution_m{};
    /// [count] Columns, 1 to `SIDE_CELLS_MAX`.
    std::uint32_t width{};
    /// [count] Rows, 1 to `SIDE_CELLS_MAX`.
    std::uint32_t height{};
};
static_assert(sizeof(GridGeometry) == 32);
static_assert(std::is_trivially_copyable_v<GridGeometry> && std::is_standard_layout_v<GridGeometry>);
static_assert(offsetof(GridGeometry, origin_x_m) == 0);
static_assert(offsetof(GridGeometry, origin_y_m) == 8);
static_assert(offsetof(GridGeometry, resolution_m) == 16);
static_assert(offsetof(GridGeometry, width) == 24);
static_assert(offsetof(GridGeometry, height) == 28);
static_assert(GridGeometry::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, GridGeometry::NAME);
    hash = fnv1a(hash, "origin_x_m");
    hash = fnv1a_number(hash, Schema<decltype(GridGeometry::origin_x_m)>::value);
    hash = fnv1a_number(hash, offsetof(GridGeometry, origin_x_m));
    hash = fnv1a(hash, "origin_y_m");
    hash = fnv1a_number(hash, Schema<decltype(GridGeometry::origin_y_m)>::value);
    hash = fnv1a_number(hash, offsetof(GridGeometry, origin_y_m));
    hash = fnv1a(hash, "resolution_m");
    hash = fnv1a_number(hash, Schema<decltype(GridGeometry::resolution_m)>::value);
    hash = fnv1a_number(hash, offsetof(GridGeometry, resolution_m));
    hash = fnv1a(hash, "width");
    hash = fnv1a_number(hash, Schema<decltype(GridGeometry::width)>::value);
    hash = fnv1a_number(hash, offsetof(GridGeometry, width));
    hash = fnv1a(hash, "height");
    hash = fnv1a_number(hash, Schema<decltype(GridGeometry::height)>::value);
    hash = fnv1a_number(hash, offsetof(GridGeometry, height));
    return hash;
}());

/// How the cost of a known cell follows from its clearance, see `CostModel::cost`.
struct CostModel {
    static constexpr const char* NAME = "zeronav.CostModel.v1";
    static constexpr std::uint64_t SCHEMA = 0x01d4e2011a0c58ac;
    /// [m] of the robot's inscribed circle, >= 0.
    double inscribed_radius_m{};
    /// [m] added to the inscribed radius, >= 0.
    double padding_m{};
    /// [m] of clearance beyond which a cell is free, >= 0.
    double inflation_radius_m{};
    /// [1/m] by which the cost falls, >= 0.
    double scaling_per_m{};
};
static_assert(sizeof(CostModel) == 32);
static_assert(std::is_trivially_copyable_v<CostModel> && std::is_standard_layout_v<CostModel>);
static_assert(offsetof(CostModel, inscribed_radius_m) == 0);
static_assert(offsetof(CostModel, padding_m) == 8);
static_assert(offsetof(CostModel, inflation_radius_m) == 16);
static_assert(offsetof(CostModel, scaling_per_m) == 24);
static_assert(CostModel::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, CostModel::NAME);
    hash = fnv1a(hash, "inscribed_radius_m");
    hash = fnv1a_number(hash, Schema<decltype(CostModel::inscribed_radius_m)>::value);
    hash = fnv1a_number(hash, offsetof(CostModel, inscribed_radius_m));
    hash = fnv1a(hash, "padding_m");
    hash = fnv1a_number(hash, Schema<decltype(CostModel::padding_m)>::value);
    hash = fnv1a_number(hash, offsetof(CostModel, padding_m));
    hash = fnv1a(hash, "inflation_radius_m");
    hash = fnv1a_number(hash, Schema<decltype(CostModel::inflation_radius_m)>::value);
    hash = fnv1a_number(hash, offsetof(CostModel, inflation_radius_m));
    hash = fnv1a(hash, "scaling_per_m");
    hash = fnv1a_number(hash, Schema<decltype(CostModel::scaling_per_m)>::value);
    hash = fnv1a_number(hash, offsetof(CostModel, scaling_per_m));
    return hash;
}());

/// The straight way by which a robot that is in a keepout zone is let out.
struct WayOut {
    static constexpr const char* NAME = "zeronav.WayOut.v1";
    static constexpr std::uint64_t SCHEMA = 0x21ddf890191647f2;
    /// [m] map frame, where it begins.
    double from_m[2]{};
    /// [m] map frame, where it ends, outside of all keepout zones.
    double until_m[2]{};
    /// [m] to either side of the line between them; 0 = no way is open.
    double radius_m{};
};
static_assert(sizeof(WayOut) == 40);
static_assert(std::is_trivially_copyable_v<WayOut> && std::is_standard_layout_v<WayOut>);
static_assert(offsetof(WayOut, from_m) == 0);
static_assert(offsetof(WayOut, until_m) == 16);
static_assert(offsetof(WayOut, radius_m) == 32);
static_assert(WayOut::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, WayOut::NAME);
    hash = fnv1a(hash, "from_m");
    hash = fnv1a_number(hash, Schema<decltype(WayOut::from_m)>::value);
    hash = fnv1a_number(hash, offsetof(WayOut, from_m));
    hash = fnv1a(hash, "until_m");
    hash = fnv1a_number(hash, Schema<decltype(WayOut::until_m)>::value);
    hash = fnv1a_number(hash, offsetof(WayOut, until_m));
    hash = fnv1a(hash, "radius_m");
    hash = fnv1a_number(hash, Schema<decltype(WayOut::radius_m)>::value);
    hash = fnv1a_number(hash, offsetof(WayOut, radius_m));
    return hash;
}());

/// Fixed fields of map messages. The slice holds tiles.
struct MapInfo {
    static constexpr const char* NAME = "zeronav.MapInfo.v3";
    static constexpr std::uint64_t SCHEMA = 0x60e694f4ef19010a;
    /// Where the grid lies.
    GridGeometry geometry{};
    /// [id] Revision that the map has after this message: the id of the update's last part.
    std::uint64_t revision{};
    /// `map_from_odom`.
    Pose map_from_odom{};
    /// Covariance of the pose of `base` in the map, against where that began, upper triangle by
    /// rows. [m, m, rad] Its deviations also say how far the pose is known (`MapInfo::certainty`).
    double covariance[6]{};
    /// [number] Which part of the revision this is, from 0.
    std::uint16_t part{};
    /// [count] Parts of the revision, at least 1; 1 in a keyframe.
    std::uint16_t parts{};
    /// [count] Tiles in the slice.
    std::uint32_t n_tiles{};
    /// [mm] at which clearance is saturated.
    std::uint32_t clearance_limit_mm{};
    /// [flag] 1 when scans keep coming, 0 when the map is not current.
    std::uint32_t current{};
    /// How the cost of a cell follows from its clearance.
    CostModel cost_model{};
    /// The way out of a keepout zone, whose cells are open.
    WayOut way_out{};
};
static_assert(sizeof(MapInfo) == 200);
static_assert(std::is_trivially_copyable_v<MapInfo> && std::is_standard_layout_v<MapInfo>);
static_assert(offsetof(MapInfo, geometry) == 0);
static_assert(offsetof(MapInfo, revision) == 32);
static_assert(offsetof(MapInfo, map_from_odom) == 40);
static_assert(offsetof(MapInfo, covariance) == 64);
static_assert(offsetof(MapInfo, part) == 112);
static_assert(offsetof(MapInfo, parts) == 114);
static_assert(offsetof(MapInfo, n_tiles) == 116);
static_assert(offsetof(MapInfo, clearance_limit_mm) == 120);
static_assert(offsetof(MapInfo, current) == 124);
static_assert(offsetof(MapInfo, cost_model) == 128);
static_assert(offsetof(MapInfo, way_out) == 160);
static_assert(MapInfo::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, MapInfo::NAME);
    hash = fnv1a(hash, "geometry");
    hash = fnv1a_number(hash, Schema<decltype(MapInfo::geometry)>::value);
    hash = fnv1a_number(hash, offsetof(MapInfo, geometry));
    hash = fnv1a(hash, "revision");
    hash = fnv1a_number(hash, Schema<decltype(MapInfo::revision)>::value);
    hash = fnv1a_number(hash, offsetof(MapInfo, revision));
    hash = fnv1a(hash, "map_from_odom");
    hash = fnv1a_number(hash, Schema<decltype(MapInfo::map_from_odom)>::value);
    hash = fnv1a_number(hash, offsetof(MapInfo, map_from_odom));
    hash = fnv1a(hash, "covariance");
    hash = fnv1a_number(hash, Schema<decltype(MapInfo::covariance)>::value);
    hash = fnv1a_number(hash, offsetof(MapInfo, covariance));
    hash = fnv1a(hash, "part");
    hash = fnv1a_number(hash, Schema<decltype(MapInfo::part)>::value);
    hash = fnv1a_number(hash, offsetof(MapInfo, part));
    hash = fnv1a(hash, "parts");
    hash = fnv1a_number(hash, Schema<decltype(MapInfo::parts)>::value);
    hash = fnv1a_number(hash, offsetof(MapInfo, parts));
    hash = fnv1a(hash, "n_tiles");
    hash = fnv1a_number(hash, Schema<decltype(MapInfo::n_tiles)>::value);
    hash = fnv1a_number(hash, offsetof(MapInfo, n_tiles));
    hash = fnv1a(hash, "clearance_limit_mm");
    hash = fnv1a_number(hash, Schema<decltype(MapInfo::clearance_limit_mm)>::value);
    hash = fnv1a_number(hash, offsetof(MapInfo, clearance_limit_mm));
    hash = fnv1a(hash, "current");
    hash = fnv1a_number(hash, Schema<decltype(MapInfo::current)>::value);
    hash = fnv1a_number(hash, offsetof(MapInfo, current));
    hash = fnv1a(hash, "cost_model");
    hash = fnv1a_number(hash, Schema<decltype(MapInfo::cost_model)>::value);
    hash = fnv1a_number(hash, offsetof(MapInfo, cost_model));
    hash = fnv1a(hash, "way_out");
    hash = fnv1a_number(hash, Schema<decltype(MapInfo::way_out)>::value);
    hash = fnv1a_number(hash, offsetof(MapInfo, way_out));
    return hash;
}());

/// Header and fixed fields of the topic's messages.
struct MapUpdateEnvelope {
    static constexpr const char* NAME = "zeronav.map.update.v1";
    static constexpr std::uint64_t SCHEMA = 0x05b193d5f4cfde27;
    /// The header.
    Header header{};
    /// The fixed fields.
    MapInfo meta{};
};
static_assert(sizeof(MapUpdateEnvelope) == 328);
static_assert(std::is_trivially_copyable_v<MapUpdateEnvelope> && std::is_standard_layout_v<MapUpdateEnvelope>);
static_assert(offsetof(MapUpdateEnvelope, header) == 0);
static_assert(offsetof(MapUpdateEnvelope, meta) == 128);
static_assert(MapUpdateEnvelope::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, MapUpdateEnvelope::NAME);
    hash = fnv1a(hash, "header");
    hash = fnv1a_number(hash, Schema<decltype(MapUpdateEnvelope::header)>::value);
    hash = fnv1a_number(hash, offsetof(MapUpdateEnvelope, header));
    hash = fnv1a(hash, "meta");
    hash = fnv1a_number(hash, Schema<decltype(MapUpdateEnvelope::meta)>::value);
    hash = fnv1a_number(hash, offsetof(MapUpdateEnvelope, meta));
    return hash;
}());

/// One cell. `cost` and `clearance_mm` come from obstacles that are static, by the static map or
/// by what the lidar saw; those that move are on `map/obstacles` alone.
struct MapCell {
    static constexpr const char* NAME = "zeronav.MapCell.v2";
    static constexpr std::uint64_t SCHEMA = 0x4244a9fed47926c9;
    /// [number] As in Nav2: 0 free, 253 inscribed, 254 lethal, 255 unknown.
    std::uint8_t cost{};
    /// [bits] Sum of the `FLAG_` bits.
    std::uint8_t flags{};
    /// [mm] from the cell's centre to the nearest obstacle square, rounded down, saturated at the
    /// map's limit; 0 inside an obstacle.
    std::uint16_t clearance_mm{};
};
static_assert(sizeof(MapCell) == 4);
static_assert(std::is_trivially_copyable_v<MapCell> && std::is_standard_layout_v<MapCell>);
static_assert(offsetof(MapCell, cost) == 0);
static_assert(offsetof(MapCell, flags) == 1);
static_assert(offsetof(MapCell, clearance_mm) == 2);
static_assert(MapCell::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, MapCell::NAME);
    hash = fnv1a(hash, "cost");
    hash = fnv1a_number(hash, Schema<decltype(MapCell::cost)>::value);
    hash = fnv1a_number(hash, offsetof(MapCell, cost));
    hash = fnv1a(hash, "flags");
    hash = fnv1a_number(hash, Schema<decltype(MapCell::flags)>::value);
    hash = fnv1a_number(hash, offsetof(MapCell, flags));
    hash = fnv1a(hash, "clearance_mm");
    hash = fnv1a_number(hash, Schema<decltype(MapCell::clearance_mm)>::value);
    hash = fnv1a_number(hash, offsetof(MapCell, clearance_mm));
    return hash;
}());

/// 32 x 32 cells, row-major. Cells beyond the map's edge are unknown and ignored.
struct MapTile {
    static constexpr const char* NAME = "zeronav.MapTile.v2";
    static constexpr std::uint64_t SCHEMA = 0x551fd6366a7dfec1;
    /// [number] Column of tiles, from 0.
    std::uint32_t tile_x{};
    /// [number] Row of tiles, from 0.
    std::uint32_t tile_y{};
    /// The cells.
    MapCell cells[1024]{};
};
static_assert(sizeof(MapTile) == 4104);
static_assert(std::is_trivially_copyable_v<MapTile> && std::is_standard_layout_v<MapTile>);
static_assert(offsetof(MapTile, tile_x) == 0);
static_assert(offsetof(MapTile, tile_y) == 4);
static_assert(offsetof(MapTile, cells) == 8);
static_assert(MapTile::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, MapTile::NAME);
    hash = fnv1a(hash, "tile_x");
    hash = fnv1a_number(hash, Schema<decltype(MapTile::tile_x)>::value);
    hash = fnv1a_number(hash, offsetof(MapTile, tile_x));
    hash = fnv1a(hash, "tile_y");
    hash = fnv1a_number(hash, Schema<decltype(MapTile::tile_y)>::value);
    hash = fnv1a_number(hash, offsetof(MapTile, tile_y));
    hash = fnv1a(hash, "cells");
    hash = fnv1a_number(hash, Schema<decltype(MapTile::cells)>::value);
    hash = fnv1a_number(hash, offsetof(MapTile, cells));
    return hash;
}());

/// Header and fixed fields of the topic's messages.
struct MapKeyframeEnvelope {
    static constexpr const char* NAME = "zeronav.map.keyframe.v1";
    static constexpr std::uint64_t SCHEMA = 0x243114dd09615064;
    /// The header.
    Header header{};
    /// The fixed fields.
    MapInfo meta{};
};
static_assert(sizeof(MapKeyframeEnvelope) == 328);
static_assert(std::is_trivially_copyable_v<MapKeyframeEnvelope> && std::is_standard_layout_v<MapKeyframeEnvelope>);
static_assert(offsetof(MapKeyframeEnvelope, header) == 0);
static_assert(offsetof(MapKeyframeEnvelope, meta) == 128);
static_assert(MapKeyframeEnvelope::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, MapKeyframeEnvelope::NAME);
    hash = fnv1a(hash, "header");
    hash = fnv1a_number(hash, Schema<decltype(MapKeyframeEnvelope::header)>::value);
    hash = fnv1a_number(hash, offsetof(MapKeyframeEnvelope, header));
    hash = fnv1a(hash, "meta");
    hash = fnv1a_number(hash, Schema<decltype(MapKeyframeEnvelope::meta)>::value);
    hash = fnv1a_number(hash, offsetof(MapKeyframeEnvelope, meta));
    return hash;
}());

/// Fixed fields of the list of tracked obstacles.
struct Obstacles {
    static constexpr const char* NAME = "zeronav.Obstacles.v1";
    static constexpr std::uint64_t SCHEMA = 0x6e48a45e27e1d95f;
    /// [count] Number of obstacles, equal to the length of the slice.
    std::uint64_t n_obstacles{};
};
static_assert(sizeof(Obstacles) == 8);
static_assert(std::is_trivially_copyable_v<Obstacles> && std::is_standard_layout_v<Obstacles>);
static_assert(offsetof(Obstacles, n_obstacles) == 0);
static_assert(Obstacles::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, Obstacles::NAME);
    hash = fnv1a(hash, "n_obstacles");
    hash = fnv1a_number(hash, Schema<decltype(Obstacles::n_obstacles)>::value);
    hash = fnv1a_number(hash, offsetof(Obstacles, n_obstacles));
    return hash;
}());

/// Header and fixed fields of the topic's messages.
struct MapObstaclesEnvelope {
    static constexpr const char* NAME = "zeronav.map.obstacles.v1";
    static constexpr std::uint64_t SCHEMA = 0x9117b28eef3c2bdd;
    /// The header.
    Header header{};
    /// The fixed fields.
    Obstacles meta{};
};
static_assert(sizeof(MapObstaclesEnvelope) == 136);
static_assert(std::is_trivially_copyable_v<MapObstaclesEnvelope> && std::is_standard_layout_v<MapObstaclesEnvelope>);
static_assert(offsetof(MapObstaclesEnvelope, header) == 0);
static_assert(offsetof(MapObstaclesEnvelope, meta) == 128);
static_assert(MapObstaclesEnvelope::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, MapObstaclesEnvelope::NAME);
    hash = fnv1a(hash, "header");
    hash = fnv1a_number(hash, Schema<decltype(MapObstaclesEnvelope::header)>::value);
    hash = fnv1a_number(hash, offsetof(MapObstaclesEnvelope, header));
    hash = fnv1a(hash, "meta");
    hash = fnv1a_number(hash, Schema<decltype(MapObstaclesEnvelope::meta)>::value);
    hash = fnv1a_number(hash, offsetof(MapObstaclesEnvelope, meta));
    return hash;
}());

/// A tracked obstacle: a disc with constant velocity.
struct Obstacle {
    static constexpr const char* NAME = "zeronav.Obstacle.v2";
    static constexpr std::uint64_t SCHEMA = 0x8c5365a47ca1daff;
    /// [number] Stays with the track as long as it lives.
    std::uint64_t track{};
    /// [m] `map` frame.
    double x_m{};
    /// [m] `map` frame.
    double y_m{};
    /// [m/s] `map` frame.
    double vx_mps{};
    /// [m/s] `map` frame.
    double vy_mps{};
    /// [m] 0 to `OBSTACLE_RADIUS_M_MAX`.
    double radius_m{};
    /// [s] since the track began.
    double age_s{};
    /// [s] since the last scan that showed it: where it is now is predicted. 0 while it is seen.
    double unseen_s{};
    /// Covariance of (x, y, vx, vy), upper triangle by rows. [m^2, m^2/s, m^2/s^2]
    double covariance[10]{};
};
static_assert(sizeof(Obstacle) == 144);
static_assert(std::is_trivially_copyable_v<Obstacle> && std::is_standard_layout_v<Obstacle>);
static_assert(offsetof(Obstacle, track) == 0);
static_assert(offsetof(Obstacle, x_m) == 8);
static_assert(offsetof(Obstacle, y_m) == 16);
static_assert(offsetof(Obstacle, vx_mps) == 24);
static_assert(offsetof(Obstacle, vy_mps) == 32);
static_assert(offsetof(Obstacle, radius_m) == 40);
static_assert(offsetof(Obstacle, age_s) == 48);
static_assert(offsetof(Obstacle, unseen_s) == 56);
static_assert(offsetof(Obstacle, covariance) == 64);
static_assert(Obstacle::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, Obstacle::NAME);
    hash = fnv1a(hash, "track");
    hash = fnv1a_number(hash, Schema<decltype(Obstacle::track)>::value);
    hash = fnv1a_number(hash, offsetof(Obstacle, track));
    hash = fnv1a(hash, "x_m");
    hash = fnv1a_number(hash, Schema<decltype(Obstacle::x_m)>::value);
    hash = fnv1a_number(hash, offsetof(Obstacle, x_m));
    hash = fnv1a(hash, "y_m");
    hash = fnv1a_number(hash, Schema<decltype(Obstacle::y_m)>::value);
    hash = fnv1a_number(hash, offsetof(Obstacle, y_m));
    hash = fnv1a(hash, "vx_mps");
    hash = fnv1a_number(hash, Schema<decltype(Obstacle::vx_mps)>::value);
    hash = fnv1a_number(hash, offsetof(Obstacle, vx_mps));
    hash = fnv1a(hash, "vy_mps");
    hash = fnv1a_number(hash, Schema<decltype(Obstacle::vy_mps)>::value);
    hash = fnv1a_number(hash, offsetof(Obstacle, vy_mps));
    hash = fnv1a(hash, "radius_m");
    hash = fnv1a_number(hash, Schema<decltype(Obstacle::radius_m)>::value);
    hash = fnv1a_number(hash, offsetof(Obstacle, radius_m));
    hash = fnv1a(hash, "age_s");
    hash = fnv1a_number(hash, Schema<decltype(Obstacle::age_s)>::value);
    hash = fnv1a_number(hash, offsetof(Obstacle, age_s));
    hash = fnv1a(hash, "unseen_s");
    hash = fnv1a_number(hash, Schema<decltype(Obstacle::unseen_s)>::value);
    hash = fnv1a_number(hash, offsetof(Obstacle, unseen_s));
    hash = fnv1a(hash, "covariance");
    hash = fnv1a_number(hash, Schema<decltype(Obstacle::covariance)>::value);
    hash = fnv1a_number(hash, offsetof(Obstacle, covariance));
    return hash;
}());

/// Fixed fields of a path. Search statistics are counts, never times. A message with an unchanged
/// path repeats the waypoints and says by its parents how current it is.
struct Path {
    static constexpr const char* NAME = "zeronav.Path.v5";
    static constexpr std::uint64_t SCHEMA = 0xa7edfb8ed361ed11;
    /// [text] Key of the planner in lower case, padded with 0.
    std::uint8_t planner[24]{};
    /// Code of `PathStatus`.
    std::uint16_t status{};
    /// Code of `PathCause` of the geometry.
    std::uint16_t cause{};
    /// [count] Waypoints in the slice.
    std::uint32_t n_waypoints{};
    /// [id] Id of the message that brought this geometry or failure first; its own id when new.
    std::uint64_t geometry{};
    /// [id] Map revision that the search used; the header's parent is the one it was checked with.
    std::uint64_t searched_map{};
    /// [count] Nodes taken from the open list and closed.
    std::uint64_t expanded{};
    /// [count] Nodes put into the open list.
    std::uint64_t generated{};
    /// [count] Neighbours looked at, repeats counted.
    std::uint64_t evaluated{};
    /// [count] Longest open list.
    std::uint64_t peak_open{};
    /// [m] length, >= 0.
    double length_m{};
    /// [-] Cost in the planner's own measure, >= 0.
    double cost{};
    /// [-] No path costs less, in the same measure; 0 = not known. At most `cost`.
    double bound{};
    /// [number] Goal that it leads to, by `crate::task::Goal::id`.
    std::uint64_t goal{};
    /// [m] from the last waypoint to the goal, >= 0: above 0 when the goal's own place cannot be
    /// reached and the nearest one within its tolerance that can is taken.
    double beside_goal_m{};
    /// Code of `PathBlock`: which cell made this path another one, made it end beside the goal, or
    /// left no path. May be left 0.
    std::uint16_t block{};
    /// Code of `ObstacleSource` of the obstacle in that cell or nearest to it. May be left 0.
    std::uint16_t source{};
    /// Written as 0.
    std::uint16_t spare[2]{};
    /// [m] x and y of the centre of that cell, `map` frame.
    double block_m[2]{};
};
static_assert(sizeof(Path) == 144);
static_assert(std::is_trivially_copyable_v<Path> && std::is_standard_layout_v<Path>);
static_assert(offsetof(Path, planner) == 0);
static_assert(offsetof(Path, status) == 24);
static_assert(offsetof(Path, cause) == 26);
static_assert(offsetof(Path, n_waypoints) == 28);
static_assert(offsetof(Path, geometry) == 32);
static_assert(offsetof(Path, searched_map) == 40);
static_assert(offsetof(Path, expanded) == 48);
static_assert(offsetof(Path, generated) == 56);
static_assert(offsetof(Path, evaluated) == 64);
static_assert(offsetof(Path, peak_open) == 72);
static_assert(offsetof(Path, length_m) == 80);
static_assert(offsetof(Path, cost) == 88);
static_assert(offsetof(Path, bound) == 96);
static_assert(offsetof(Path, goal) == 104);
static_assert(offsetof(Path, beside_goal_m) == 112);
static_assert(offsetof(Path, block) == 120);
static_assert(offsetof(Path, source) == 122);
static_assert(offsetof(Path, spare) == 124);
static_assert(offsetof(Path, block_m) == 128);
static_assert(Path::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, Path::NAME);
    hash = fnv1a(hash, "planner");
    hash = fnv1a_number(hash, Schema<decltype(Path::planner)>::value);
    hash = fnv1a_number(hash, offsetof(Path, planner));
    hash = fnv1a(hash, "status");
    hash = fnv1a_number(hash, Schema<decltype(Path::status)>::value);
    hash = fnv1a_number(hash, offsetof(Path, status));
    hash = fnv1a(hash, "cause");
    hash = fnv1a_number(hash, Schema<decltype(Path::cause)>::value);
    hash = fnv1a_number(hash, offsetof(Path, cause));
    hash = fnv1a(hash, "n_waypoints");
    hash = fnv1a_number(hash, Schema<decltype(Path::n_waypoints)>::value);
    hash = fnv1a_number(hash, offsetof(Path, n_waypoints));
    hash = fnv1a(hash, "geometry");
    hash = fnv1a_number(hash, Schema<decltype(Path::geometry)>::value);
    hash = fnv1a_number(hash, offsetof(Path, geometry));
    hash = fnv1a(hash, "searched_map");
    hash = fnv1a_number(hash, Schema<decltype(Path::searched_map)>::value);
    hash = fnv1a_number(hash, offsetof(Path, searched_map));
    hash = fnv1a(hash, "expanded");
    hash = fnv1a_number(hash, Schema<decltype(Path::expanded)>::value);
    hash = fnv1a_number(hash, offsetof(Path, expanded));
    hash = fnv1a(hash, "generated");
    hash = fnv1a_number(hash, Schema<decltype(Path::generated)>::value);
    hash = fnv1a_number(hash, offsetof(Path, generated));
    hash = fnv1a(hash, "evaluated");
    hash = fnv1a_number(hash, Schema<decltype(Path::evaluated)>::value);
    hash = fnv1a_number(hash, offsetof(Path, evaluated));
    hash = fnv1a(hash, "peak_open");
    hash = fnv1a_number(hash, Schema<decltype(Path::peak_open)>::value);
    hash = fnv1a_number(hash, offsetof(Path, peak_open));
    hash = fnv1a(hash, "length_m");
    hash = fnv1a_number(hash, Schema<decltype(Path::length_m)>::value);
    hash = fnv1a_number(hash, offsetof(Path, length_m));
    hash = fnv1a(hash, "cost");
    hash = fnv1a_number(hash, Schema<decltype(Path::cost)>::value);
    hash = fnv1a_number(hash, offsetof(Path, cost));
    hash = fnv1a(hash, "bound");
    hash = fnv1a_number(hash, Schema<decltype(Path::bound)>::value);
    hash = fnv1a_number(hash, offsetof(Path, bound));
    hash = fnv1a(hash, "goal");
    hash = fnv1a_number(hash, Schema<decltype(Path::goal)>::value);
    hash = fnv1a_number(hash, offsetof(Path, goal));
    hash = fnv1a(hash, "beside_goal_m");
    hash = fnv1a_number(hash, Schema<decltype(Path::beside_goal_m)>::value);
    hash = fnv1a_number(hash, offsetof(Path, beside_goal_m));
    hash = fnv1a(hash, "block");
    hash = fnv1a_number(hash, Schema<decltype(Path::block)>::value);
    hash = fnv1a_number(hash, offsetof(Path, block));
    hash = fnv1a(hash, "source");
    hash = fnv1a_number(hash, Schema<decltype(Path::source)>::value);
    hash = fnv1a_number(hash, offsetof(Path, source));
    hash = fnv1a(hash, "spare");
    hash = fnv1a_number(hash, Schema<decltype(Path::spare)>::value);
    hash = fnv1a_number(hash, offsetof(Path, spare));
    hash = fnv1a(hash, "block_m");
    hash = fnv1a_number(hash, Schema<decltype(Path::block_m)>::value);
    hash = fnv1a_number(hash, offsetof(Path, block_m));
    return hash;
}());

/// Header and fixed fields of the topic's messages.
struct PlanPathEnvelope {
    static constexpr const char* NAME = "zeronav.plan.path.v1";
    static constexpr std::uint64_t SCHEMA = 0x14c041652310caa2;
    /// The header.
    Header header{};
    /// The fixed fields.
    Path meta{};
};
static_assert(sizeof(PlanPathEnvelope) == 272);
static_assert(std::is_trivially_copyable_v<PlanPathEnvelope> && std::is_standard_layout_v<PlanPathEnvelope>);
static_assert(offsetof(PlanPathEnvelope, header) == 0);
static_assert(offsetof(PlanPathEnvelope, meta) == 128);
static_assert(PlanPathEnvelope::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, PlanPathEnvelope::NAME);
    hash = fnv1a(hash, "header");
    hash = fnv1a_number(hash, Schema<decltype(PlanPathEnvelope::header)>::value);
    hash = fnv1a_number(hash, offsetof(PlanPathEnvelope, header));
    hash = fnv1a(hash, "meta");
    hash = fnv1a_number(hash, Schema<decltype(PlanPathEnvelope::meta)>::value);
    hash = fnv1a_number(hash, offsetof(PlanPathEnvelope, meta));
    return hash;
}());

/// A pose on the path.
struct Waypoint {
    static constexpr const char* NAME = "zeronav.Waypoint.v1";
    static constexpr std::uint64_t SCHEMA = 0xd99fefdb1fc0e96c;
    /// [m] `map` frame.
    double x_m{};
    /// [m] `map` frame.
    double y_m{};
    /// [rad] direction to the next waypoint; at the last one the goal's yaw.
    float yaw_rad{};
    /// [m] clearance when the path was made, saturated at the map's limit.
    float clearance_m{};
};
static_assert(sizeof(Waypoint) == 24);
static_assert(std::is_trivially_copyable_v<Waypoint> && std::is_standard_layout_v<Waypoint>);
static_assert(offsetof(Waypoint, x_m) == 0);
static_assert(offsetof(Waypoint, y_m) == 8);
static_assert(offsetof(Waypoint, yaw_rad) == 16);
static_assert(offsetof(Waypoint, clearance_m) == 20);
static_assert(Waypoint::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, Waypoint::NAME);
    hash = fnv1a(hash, "x_m");
    hash = fnv1a_number(hash, Schema<decltype(Waypoint::x_m)>::value);
    hash = fnv1a_number(hash, offsetof(Waypoint, x_m));
    hash = fnv1a(hash, "y_m");
    hash = fnv1a_number(hash, Schema<decltype(Waypoint::y_m)>::value);
    hash = fnv1a_number(hash, offsetof(Waypoint, y_m));
    hash = fnv1a(hash, "yaw_rad");
    hash = fnv1a_number(hash, Schema<decltype(Waypoint::yaw_rad)>::value);
    hash = fnv1a_number(hash, offsetof(Waypoint, yaw_rad));
    hash = fnv1a(hash, "clearance_m");
    hash = fnv1a_number(hash, Schema<decltype(Waypoint::clearance_m)>::value);
    hash = fnv1a_number(hash, offsetof(Waypoint, clearance_m));
    return hash;
}());

/// Fixed fields of a request; the slice is empty.
struct PlanRequest {
    static constexpr const char* NAME = "zeronav.PlanRequest.v1";
    static constexpr std::uint64_t SCHEMA = 0x9645c77274163223;
    /// Code of `RequestReason`.
    std::uint16_t reason{};
    /// Written as 0.
    std::uint16_t spare[3]{};
    /// [m] along the path from the robot to what blocks it, >= 0.
    double blocked_arc_m{};
};
static_assert(sizeof(PlanRequest) == 16);
static_assert(std::is_trivially_copyable_v<PlanRequest> && std::is_standard_layout_v<PlanRequest>);
static_assert(offsetof(PlanRequest, reason) == 0);
static_assert(offsetof(PlanRequest, spare) == 2);
static_assert(offsetof(PlanRequest, blocked_arc_m) == 8);
static_assert(PlanRequest::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, PlanRequest::NAME);
    hash = fnv1a(hash, "reason");
    hash = fnv1a_number(hash, Schema<decltype(PlanRequest::reason)>::value);
    hash = fnv1a_number(hash, offsetof(PlanRequest, reason));
    hash = fnv1a(hash, "spare");
    hash = fnv1a_number(hash, Schema<decltype(PlanRequest::spare)>::value);
    hash = fnv1a_number(hash, offsetof(PlanRequest, spare));
    hash = fnv1a(hash, "blocked_arc_m");
    hash = fnv1a_number(hash, Schema<decltype(PlanRequest::blocked_arc_m)>::value);
    hash = fnv1a_number(hash, offsetof(PlanRequest, blocked_arc_m));
    return hash;
}());

/// Header and fixed fields of the topic's messages.
struct PlanRequestEnvelope {
    static constexpr const char* NAME = "zeronav.plan.request.v1";
    static constexpr std::uint64_t SCHEMA = 0x9823a2af3f319c98;
    /// The header.
    Header header{};
    /// The fixed fields.
    PlanRequest meta{};
};
static_assert(sizeof(PlanRequestEnvelope) == 144);
static_assert(std::is_trivially_copyable_v<PlanRequestEnvelope> && std::is_standard_layout_v<PlanRequestEnvelope>);
static_assert(offsetof(PlanRequestEnvelope, header) == 0);
static_assert(offsetof(PlanRequestEnvelope, meta) == 128);
static_assert(PlanRequestEnvelope::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, PlanRequestEnvelope::NAME);
    hash = fnv1a(hash, "header");
    hash = fnv1a_number(hash, Schema<decltype(PlanRequestEnvelope::header)>::value);
    hash = fnv1a_number(hash, offsetof(PlanRequestEnvelope, header));
    hash = fnv1a(hash, "meta");
    hash = fnv1a_number(hash, Schema<decltype(PlanRequestEnvelope::meta)>::value);
    hash = fnv1a_number(hash, offsetof(PlanRequestEnvelope, meta));
    return hash;
}());

/// Fixed fields of a task. The slice holds the goals in order.
struct Task {
    static constexpr const char* NAME = "zeronav.Task.v1";
    static constexpr std::uint64_t SCHEMA = 0x522fec02901e38bd;
    /// Code of `TaskKind`.
    std::uint16_t kind{};
    /// Written as 0.
    std::uint16_t spare{};
    /// [count] Goals in the slice.
    std::uint32_t n_goals{};
    /// [tick] First tick at which it holds; 0 = at once.
    std::uint64_t from_tick{};
};
static_assert(sizeof(Task) == 16);
static_assert(std::is_trivially_copyable_v<Task> && std::is_standard_layout_v<Task>);
static_assert(offsetof(Task, kind) == 0);
static_assert(offsetof(Task, spare) == 2);
static_assert(offsetof(Task, n_goals) == 4);
static_assert(offsetof(Task, from_tick) == 8);
static_assert(Task::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, Task::NAME);
    hash = fnv1a(hash, "kind");
    hash = fnv1a_number(hash, Schema<decltype(Task::kind)>::value);
    hash = fnv1a_number(hash, offsetof(Task, kind));
    hash = fnv1a(hash, "spare");
    hash = fnv1a_number(hash, Schema<decltype(Task::spare)>::value);
    hash = fnv1a_number(hash, offsetof(Task, spare));
    hash = fnv1a(hash, "n_goals");
    hash = fnv1a_number(hash, Schema<decltype(Task::n_goals)>::value);
    hash = fnv1a_number(hash, offsetof(Task, n_goals));
    hash = fnv1a(hash, "from_tick");
    hash = fnv1a_number(hash, Schema<decltype(Task::from_tick)>::value);
    hash = fnv1a_number(hash, offsetof(Task, from_tick));
    return hash;
}());

/// Header and fixed fields of the topic's messages.
struct TaskGoalEnvelope {
    static constexpr const char* NAME = "zeronav.task.goal.v1";
    static constexpr std::uint64_t SCHEMA = 0x257e3065e7d763f5;
    /// The header.
    Header header{};
    /// The fixed fields.
    Task meta{};
};
static_assert(sizeof(TaskGoalEnvelope) == 144);
static_assert(std::is_trivially_copyable_v<TaskGoalEnvelope> && std::is_standard_layout_v<TaskGoalEnvelope>);
static_assert(offsetof(TaskGoalEnvelope, header) == 0);
static_assert(offsetof(TaskGoalEnvelope, meta) == 128);
static_assert(TaskGoalEnvelope::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, TaskGoalEnvelope::NAME);
    hash = fnv1a(hash, "header");
    hash = fnv1a_number(hash, Schema<decltype(TaskGoalEnvelope::header)>::value);
    hash = fnv1a_number(hash, offsetof(TaskGoalEnvelope, header));
    hash = fnv1a(hash, "meta");
    hash = fnv1a_number(hash, Schema<decltype(TaskGoalEnvelope::meta)>::value);
    hash = fnv1a_number(hash, offsetof(TaskGoalEnvelope, meta));
    return hash;
}());

/// A goal.
struct Goal {
    static constexpr const char* NAME = "zeronav.Goal.v1";
    static constexpr std::uint64_t SCHEMA = 0x30bd1a6fabf4d638;
    /// `map_from_base` to reach.
    Pose pose{};
    /// [m] how close counts, > 0.
    double tolerance_m{};
    /// [rad] how close the yaw must be; >= pi = any yaw.
    double yaw_tolerance_rad{};
    /// [number] The sender's own number for it, not 0.
    std::uint64_t id{};
};
static_assert(sizeof(Goal) == 48);
static_assert(std::is_trivially_copyable_v<Goal> && std::is_standard_layout_v<Goal>);
static_assert(offsetof(Goal, pose) == 0);
static_assert(offsetof(Goal, tolerance_m) == 24);
static_assert(offsetof(Goal, yaw_tolerance_rad) == 32);
static_assert(offsetof(Goal, id) == 40);
static_assert(Goal::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, Goal::NAME);
    hash = fnv1a(hash, "pose");
    hash = fnv1a_number(hash, Schema<decltype(Goal::pose)>::value);
    hash = fnv1a_number(hash, offsetof(Goal, pose));
    hash = fnv1a(hash, "tolerance_m");
    hash = fnv1a_number(hash, Schema<decltype(Goal::tolerance_m)>::value);
    hash = fnv1a_number(hash, offsetof(Goal, tolerance_m));
    hash = fnv1a(hash, "yaw_tolerance_rad");
    hash = fnv1a_number(hash, Schema<decltype(Goal::yaw_tolerance_rad)>::value);
    hash = fnv1a_number(hash, offsetof(Goal, yaw_tolerance_rad));
    hash = fnv1a(hash, "id");
    hash = fnv1a_number(hash, Schema<decltype(Goal::id)>::value);
    hash = fnv1a_number(hash, offsetof(Goal, id));
    return hash;
}());

/// Fixed fields of the status. The slice holds one entry per goal that has ended.
struct TaskStatus {
    static constexpr const char* NAME = "zeronav.TaskStatus.v3";
    static constexpr std::uint64_t SCHEMA = 0xe2d4217383846950;
    /// Code of `TaskState`.
    std::uint16_t state{};
    /// Code of `EndReason`; while it waits, that for which the goal will end.
    std::uint16_t reason{};
    /// [count] Goals that have ended.
    std::uint32_t n_ended{};
    /// [id] Id on `task/goal` of the task.
    std::uint64_t task{};
    /// [number] `Goal::id` of the current goal, 0 = none.
    std::uint64_t goal{};
    /// [m] along the path, or straight without one; >= 0.
    double remaining_m{};
    /// [count] Manoeuvres and waits of the recovery since the task began.
    std::uint32_t recoveries{};
    /// Code of `StuckCause`, with the reason `stuck`.
    std::uint16_t cause{};
    /// Code of `PathBlock`: the cell because of which the task failed, or waits. May be left 0.
    std::uint16_t block{};
    /// [m] x and y of the centre of that cell, `map` frame.
    double block_m[2]{};
    /// Code of `ObstacleSource` of the obstacle in that cell or nearest to it. May be left 0.
    std::uint16_t source{};
    /// [s] for which it waits at most for that obstacle to go, rounded up; 0 = it does not wait.
    std::uint16_t waits_s{};
    /// Written as 0.
    std::uint16_t spare[2]{};
};
static_assert(sizeof(TaskStatus) == 64);
static_assert(std::is_trivially_copyable_v<TaskStatus> && std::is_standard_layout_v<TaskStatus>);
static_assert(offsetof(TaskStatus, state) == 0);
static_assert(offsetof(TaskStatus, reason) == 2);
static_assert(offsetof(TaskStatus, n_ended) == 4);
static_assert(offsetof(TaskStatus, task) == 8);
static_assert(offsetof(TaskStatus, goal) == 16);
static_assert(offsetof(TaskStatus, remaining_m) == 24);
static_assert(offsetof(TaskStatus, recoveries) == 32);
static_assert(offsetof(TaskStatus, cause) == 36);
static_assert(offsetof(TaskStatus, block) == 38);
static_assert(offsetof(TaskStatus, block_m) == 40);
static_assert(offsetof(TaskStatus, source) == 56);
static_assert(offsetof(TaskStatus, waits_s) == 58);
static_assert(offsetof(TaskStatus, spare) == 60);
static_assert(TaskStatus::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, TaskStatus::NAME);
    hash = fnv1a(hash, "state");
    hash = fnv1a_number(hash, Schema<decltype(TaskStatus::state)>::value);
    hash = fnv1a_number(hash, offsetof(TaskStatus, state));
    hash = fnv1a(hash, "reason");
    hash = fnv1a_number(hash, Schema<decltype(TaskStatus::reason)>::value);
    hash = fnv1a_number(hash, offsetof(TaskStatus, reason));
    hash = fnv1a(hash, "n_ended");
    hash = fnv1a_number(hash, Schema<decltype(TaskStatus::n_ended)>::value);
    hash = fnv1a_number(hash, offsetof(TaskStatus, n_ended));
    hash = fnv1a(hash, "task");
    hash = fnv1a_number(hash, Schema<decltype(TaskStatus::task)>::value);
    hash = fnv1a_number(hash, offsetof(TaskStatus, task));
    hash = fnv1a(hash, "goal");
    hash = fnv1a_number(hash, Schema<decltype(TaskStatus::goal)>::value);
    hash = fnv1a_number(hash, offsetof(TaskStatus, goal));
    hash = fnv1a(hash, "remaining_m");
    hash = fnv1a_number(hash, Schema<decltype(TaskStatus::remaining_m)>::value);
    hash = fnv1a_number(hash, offsetof(TaskStatus, remaining_m));
    hash = fnv1a(hash, "recoveries");
    hash = fnv1a_number(hash, Schema<decltype(TaskStatus::recoveries)>::value);
    hash = fnv1a_number(hash, offsetof(TaskStatus, recoveries));
    hash = fnv1a(hash, "cause");
    hash = fnv1a_number(hash, Schema<decltype(TaskStatus::cause)>::value);
    hash = fnv1a_number(hash, offsetof(TaskStatus, cause));
    hash = fnv1a(hash, "block");
    hash = fnv1a_number(hash, Schema<decltype(TaskStatus::block)>::value);
    hash = fnv1a_number(hash, offsetof(TaskStatus, block));
    hash = fnv1a(hash, "block_m");
    hash = fnv1a_number(hash, Schema<decltype(TaskStatus::block_m)>::value);
    hash = fnv1a_number(hash, offsetof(TaskStatus, block_m));
    hash = fnv1a(hash, "source");
    hash = fnv1a_number(hash, Schema<decltype(TaskStatus::source)>::value);
    hash = fnv1a_number(hash, offsetof(TaskStatus, source));
    hash = fnv1a(hash, "waits_s");
    hash = fnv1a_number(hash, Schema<decltype(TaskStatus::waits_s)>::value);
    hash = fnv1a_number(hash, offsetof(TaskStatus, waits_s));
    hash = fnv1a(hash, "spare");
    hash = fnv1a_number(hash, Schema<decltype(TaskStatus::spare)>::value);
    hash = fnv1a_number(hash, offsetof(TaskStatus, spare));
    return hash;
}());

/// Header and fixed fields of the topic's messages.
struct TaskStatusEnvelope {
    static constexpr const char* NAME = "zeronav.task.status.v1";
    static constexpr std::uint64_t SCHEMA = 0xee37965966771ef6;
    /// The header.
    Header header{};
    /// The fixed fields.
    TaskStatus meta{};
};
static_assert(sizeof(TaskStatusEnvelope) == 192);
static_assert(std::is_trivially_copyable_v<TaskStatusEnvelope> && std::is_standard_layout_v<TaskStatusEnvelope>);
static_assert(offsetof(TaskStatusEnvelope, header) == 0);
static_assert(offsetof(TaskStatusEnvelope, meta) == 128);
static_assert(TaskStatusEnvelope::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, TaskStatusEnvelope::NAME);
    hash = fnv1a(hash, "header");
    hash = fnv1a_number(hash, Schema<decltype(TaskStatusEnvelope::header)>::value);
    hash = fnv1a_number(hash, offsetof(TaskStatusEnvelope, header));
    hash = fnv1a(hash, "meta");
    hash = fnv1a_number(hash, Schema<decltype(TaskStatusEnvelope::meta)>::value);
    hash = fnv1a_number(hash, offsetof(TaskStatusEnvelope, meta));
    return hash;
}());

/// End of a goal.
struct GoalEnd {
    static constexpr const char* NAME = "zeronav.GoalEnd.v1";
    static constexpr std::uint64_t SCHEMA = 0x51ab02aad6f25101;
    /// [number] `Goal::id`.
    std::uint64_t goal{};
    /// [tick] Tick at which it ended.
    std::uint64_t tick{};
    /// Code of `TaskState`.
    std::uint16_t state{};
    /// Code of `EndReason`.
    std::uint16_t reason{};
    /// Written as 0.
    std::uint32_t spare{};
};
static_assert(sizeof(GoalEnd) == 24);
static_assert(std::is_trivially_copyable_v<GoalEnd> && std::is_standard_layout_v<GoalEnd>);
static_assert(offsetof(GoalEnd, goal) == 0);
static_assert(offsetof(GoalEnd, tick) == 8);
static_assert(offsetof(GoalEnd, state) == 16);
static_assert(offsetof(GoalEnd, reason) == 18);
static_assert(offsetof(GoalEnd, spare) == 20);
static_assert(GoalEnd::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, GoalEnd::NAME);
    hash = fnv1a(hash, "goal");
    hash = fnv1a_number(hash, Schema<decltype(GoalEnd::goal)>::value);
    hash = fnv1a_number(hash, offsetof(GoalEnd, goal));
    hash = fnv1a(hash, "tick");
    hash = fnv1a_number(hash, Schema<decltype(GoalEnd::tick)>::value);
    hash = fnv1a_number(hash, offsetof(GoalEnd, tick));
    hash = fnv1a(hash, "state");
    hash = fnv1a_number(hash, Schema<decltype(GoalEnd::state)>::value);
    hash = fnv1a_number(hash, offsetof(GoalEnd, state));
    hash = fnv1a(hash, "reason");
    hash = fnv1a_number(hash, Schema<decltype(GoalEnd::reason)>::value);
    hash = fnv1a_number(hash, offsetof(GoalEnd, reason));
    hash = fnv1a(hash, "spare");
    hash = fnv1a_number(hash, Schema<decltype(GoalEnd::spare)>::value);
    hash = fnv1a_number(hash, offsetof(GoalEnd, spare));
    return hash;
}());

/// Where the robot is, as a person says, or as mapping knew before it ended: mapping puts it
/// there. Two poses of the same moment, so that it does not matter when the message is read.
struct PoseEstimate {
    static constexpr const char* NAME = "zeronav.PoseEstimate.v2";
    static constexpr std::uint64_t SCHEMA = 0x8f02f66fe57a1203;
    /// `map_from_base`.
    Pose map_from_base{};
    /// `odom_from_base` of the same moment.
    Pose odom_from_base{};
    /// [tick] First tick at which it holds.
    std::uint64_t from_tick{};
    /// Code of `PoseCertainty`: `unconfirmed` from a person; `unknown` = the robot is lost and
    /// stands.
    std::uint16_t certainty{};
    /// Written as 0.
    std::uint16_t spare[3]{};
};
static_assert(sizeof(PoseEstimate) == 64);
static_assert(std::is_trivially_copyable_v<PoseEstimate> && std::is_standard_layout_v<PoseEstimate>);
static_assert(offsetof(PoseEstimate, map_from_base) == 0);
static_assert(offsetof(PoseEstimate, odom_from_base) == 24);
static_assert(offsetof(PoseEstimate, from_tick) == 48);
static_assert(offsetof(PoseEstimate, certainty) == 56);
static_assert(offsetof(PoseEstimate, spare) == 58);
static_assert(PoseEstimate::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, PoseEstimate::NAME);
    hash = fnv1a(hash, "map_from_base");
    hash = fnv1a_number(hash, Schema<decltype(PoseEstimate::map_from_base)>::value);
    hash = fnv1a_number(hash, offsetof(PoseEstimate, map_from_base));
    hash = fnv1a(hash, "odom_from_base");
    hash = fnv1a_number(hash, Schema<decltype(PoseEstimate::odom_from_base)>::value);
    hash = fnv1a_number(hash, offsetof(PoseEstimate, odom_from_base));
    hash = fnv1a(hash, "from_tick");
    hash = fnv1a_number(hash, Schema<decltype(PoseEstimate::from_tick)>::value);
    hash = fnv1a_number(hash, offsetof(PoseEstimate, from_tick));
    hash = fnv1a(hash, "certainty");
    hash = fnv1a_number(hash, Schema<decltype(PoseEstimate::certainty)>::value);
    hash = fnv1a_number(hash, offsetof(PoseEstimate, certainty));
    hash = fnv1a(hash, "spare");
    hash = fnv1a_number(hash, Schema<decltype(PoseEstimate::spare)>::value);
    hash = fnv1a_number(hash, offsetof(PoseEstimate, spare));
    return hash;
}());

/// Header and fixed fields of the topic's messages.
struct TaskPoseEnvelope {
    static constexpr const char* NAME = "zeronav.task.pose.v1";
    static constexpr std::uint64_t SCHEMA = 0xd64ffcd8bac8f901;
    /// The header.
    Header header{};
    /// The fixed fields.
    PoseEstimate meta{};
};
static_assert(sizeof(TaskPoseEnvelope) == 192);
static_assert(std::is_trivially_copyable_v<TaskPoseEnvelope> && std::is_standard_layout_v<TaskPoseEnvelope>);
static_assert(offsetof(TaskPoseEnvelope, header) == 0);
static_assert(offsetof(TaskPoseEnvelope, meta) == 128);
static_assert(TaskPoseEnvelope::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, TaskPoseEnvelope::NAME);
    hash = fnv1a(hash, "header");
    hash = fnv1a_number(hash, Schema<decltype(TaskPoseEnvelope::header)>::value);
    hash = fnv1a_number(hash, offsetof(TaskPoseEnvelope, header));
    hash = fnv1a(hash, "meta");
    hash = fnv1a_number(hash, Schema<decltype(TaskPoseEnvelope::meta)>::value);
    hash = fnv1a_number(hash, offsetof(TaskPoseEnvelope, meta));
    return hash;
}());

/// Fixed fields of the zones. The slice holds their parts, those of a zone one after the other.
struct Zones {
    static constexpr const char* NAME = "zeronav.Zones.v1";
    static constexpr std::uint64_t SCHEMA = 0x70041535f3509961;
    /// [number] Grows with every change, from 1.
    std::uint64_t revision{};
    /// [tick] First tick at which they hold; 0 = at once.
    std::uint64_t from_tick{};
    /// [count] Parts in the slice.
    std::uint64_t n_parts{};
};
static_assert(sizeof(Zones) == 24);
static_assert(std::is_trivially_copyable_v<Zones> && std::is_standard_layout_v<Zones>);
static_assert(offsetof(Zones, revision) == 0);
static_assert(offsetof(Zones, from_tick) == 8);
static_assert(offsetof(Zones, n_parts) == 16);
static_assert(Zones::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, Zones::NAME);
    hash = fnv1a(hash, "revision");
    hash = fnv1a_number(hash, Schema<decltype(Zones::revision)>::value);
    hash = fnv1a_number(hash, offsetof(Zones, revision));
    hash = fnv1a(hash, "from_tick");
    hash = fnv1a_number(hash, Schema<decltype(Zones::from_tick)>::value);
    hash = fnv1a_number(hash, offsetof(Zones, from_tick));
    hash = fnv1a(hash, "n_parts");
    hash = fnv1a_number(hash, Schema<decltype(Zones::n_parts)>::value);
    hash = fnv1a_number(hash, offsetof(Zones, n_parts));
    return hash;
}());

/// Header and fixed fields of the topic's messages.
struct TaskZonesEnvelope {
    static constexpr const char* NAME = "zeronav.task.zones.v1";
    static constexpr std::uint64_t SCHEMA = 0x7726ed377bc84d3a;
    /// The header.
    Header header{};
    /// The fixed fields.
    Zones meta{};
};
static_assert(sizeof(TaskZonesEnvelope) == 152);
static_assert(std::is_trivially_copyable_v<TaskZonesEnvelope> && std::is_standard_layout_v<TaskZonesEnvelope>);
static_assert(offsetof(TaskZonesEnvelope, header) == 0);
static_assert(offsetof(TaskZonesEnvelope, meta) == 128);
static_assert(TaskZonesEnvelope::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, TaskZonesEnvelope::NAME);
    hash = fnv1a(hash, "header");
    hash = fnv1a_number(hash, Schema<decltype(TaskZonesEnvelope::header)>::value);
    hash = fnv1a_number(hash, offsetof(TaskZonesEnvelope, header));
    hash = fnv1a(hash, "meta");
    hash = fnv1a_number(hash, Schema<decltype(TaskZonesEnvelope::meta)>::value);
    hash = fnv1a_number(hash, offsetof(TaskZonesEnvelope, meta));
    return hash;
}());

/// A polygon of a zone. Its edges may not cross; inside is what an odd number of edges encloses.
struct ZonePart {
    static constexpr const char* NAME = "zeronav.ZonePart.v1";
    static constexpr std::uint64_t SCHEMA = 0x3e34c3fe1a2a1211;
    /// [text] Name of the zone, padded with 0.
    std::uint8_t name[32]{};
    /// [m] x and y of the corners, `map` frame; those beyond `n_corners` are 0.
    double corners_m[16][2]{};
    /// [m/s, -] by kind: a speed, percent, or a cost of 1 to 252; 0 for a keepout zone.
    double value{};
    /// Code of `ZoneKind`.
    std::uint16_t kind{};
    /// [count] Corners, at least 3.
    std::uint16_t n_corners{};
    /// Written as 0.
    std::uint32_t spare{};
};
static_assert(sizeof(ZonePart) == 304);
static_assert(std::is_trivially_copyable_v<ZonePart> && std::is_standard_layout_v<ZonePart>);
static_assert(offsetof(ZonePart, name) == 0);
static_assert(offsetof(ZonePart, corners_m) == 32);
static_assert(offsetof(ZonePart, value) == 288);
static_assert(offsetof(ZonePart, kind) == 296);
static_assert(offsetof(ZonePart, n_corners) == 298);
static_assert(offsetof(ZonePart, spare) == 300);
static_assert(ZonePart::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, ZonePart::NAME);
    hash = fnv1a(hash, "name");
    hash = fnv1a_number(hash, Schema<decltype(ZonePart::name)>::value);
    hash = fnv1a_number(hash, offsetof(ZonePart, name));
    hash = fnv1a(hash, "corners_m");
    hash = fnv1a_number(hash, Schema<decltype(ZonePart::corners_m)>::value);
    hash = fnv1a_number(hash, offsetof(ZonePart, corners_m));
    hash = fnv1a(hash, "value");
    hash = fnv1a_number(hash, Schema<decltype(ZonePart::value)>::value);
    hash = fnv1a_number(hash, offsetof(ZonePart, value));
    hash = fnv1a(hash, "kind");
    hash = fnv1a_number(hash, Schema<decltype(ZonePart::kind)>::value);
    hash = fnv1a_number(hash, offsetof(ZonePart, kind));
    hash = fnv1a(hash, "n_corners");
    hash = fnv1a_number(hash, Schema<decltype(ZonePart::n_corners)>::value);
    hash = fnv1a_number(hash, offsetof(ZonePart, n_corners));
    hash = fnv1a(hash, "spare");
    hash = fnv1a_number(hash, Schema<decltype(ZonePart::spare)>::value);
    hash = fnv1a_number(hash, offsetof(ZonePart, spare));
    return hash;
}());

/// Fixed fields of a velocity request; the slice is empty. What explains it may be left 0.
struct VelocityRequest {
    static constexpr const char* NAME = "zeronav.VelocityRequest.v2";
    static constexpr std::uint64_t SCHEMA = 0x52796979ebc296da;
    /// [m/s] forward speed in `base`.
    double v_mps{};
    /// [rad/s] yaw rate in `base`.
    double w_radps{};
    /// Code of `Validity`.
    std::uint16_t validity{};
    /// Code of `RequestCause`.
    std::uint16_t cause{};
    /// Code of `PlannerInput`: the one that is old, with the causes `ageing` and `stale`.
    std::uint16_t input{};
    /// Code of `RecoveryReason`, with the causes of the recovery.
    std::uint16_t recovery{};
    /// [m] length of the arc on which the author can still stop, >= 0.
    double braking_arc_m{};
    /// [ms, ms, ms, ms] ages of odometry, scan, map and path when it was made; 65535 = never
    /// received, or older. All 0 with the cause `none` = not told.
    std::uint16_t ages_ms[4]{};
    /// [m/s] fastest forward speed that the cause allows, >= 0; 0 = it sets none.
    double limit_mps{};
    /// [m] along the path to the first obstacle on it, >= 0; 0 = none in sight.
    double blocked_arc_m{};
    /// [number] Track of the nearest dynamic obstacle on `map/obstacles` within 2.5 m; 0 = none.
    std::uint64_t obstacle{};
};
static_assert(sizeof(VelocityRequest) == 64);
static_assert(std::is_trivially_copyable_v<VelocityRequest> && std::is_standard_layout_v<VelocityRequest>);
static_assert(offsetof(VelocityRequest, v_mps) == 0);
static_assert(offsetof(VelocityRequest, w_radps) == 8);
static_assert(offsetof(VelocityRequest, validity) == 16);
static_assert(offsetof(VelocityRequest, cause) == 18);
static_assert(offsetof(VelocityRequest, input) == 20);
static_assert(offsetof(VelocityRequest, recovery) == 22);
static_assert(offsetof(VelocityRequest, braking_arc_m) == 24);
static_assert(offsetof(VelocityRequest, ages_ms) == 32);
static_assert(offsetof(VelocityRequest, limit_mps) == 40);
static_assert(offsetof(VelocityRequest, blocked_arc_m) == 48);
static_assert(offsetof(VelocityRequest, obstacle) == 56);
static_assert(VelocityRequest::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, VelocityRequest::NAME);
    hash = fnv1a(hash, "v_mps");
    hash = fnv1a_number(hash, Schema<decltype(VelocityRequest::v_mps)>::value);
    hash = fnv1a_number(hash, offsetof(VelocityRequest, v_mps));
    hash = fnv1a(hash, "w_radps");
    hash = fnv1a_number(hash, Schema<decltype(VelocityRequest::w_radps)>::value);
    hash = fnv1a_number(hash, offsetof(VelocityRequest, w_radps));
    hash = fnv1a(hash, "validity");
    hash = fnv1a_number(hash, Schema<decltype(VelocityRequest::validity)>::value);
    hash = fnv1a_number(hash, offsetof(VelocityRequest, validity));
    hash = fnv1a(hash, "cause");
    hash = fnv1a_number(hash, Schema<decltype(VelocityRequest::cause)>::value);
    hash = fnv1a_number(hash, offsetof(VelocityRequest, cause));
    hash = fnv1a(hash, "input");
    hash = fnv1a_number(hash, Schema<decltype(VelocityRequest::input)>::value);
    hash = fnv1a_number(hash, offsetof(VelocityRequest, input));
    hash = fnv1a(hash, "recovery");
    hash = fnv1a_number(hash, Schema<decltype(VelocityRequest::recovery)>::value);
    hash = fnv1a_number(hash, offsetof(VelocityRequest, recovery));
    hash = fnv1a(hash, "braking_arc_m");
    hash = fnv1a_number(hash, Schema<decltype(VelocityRequest::braking_arc_m)>::value);
    hash = fnv1a_number(hash, offsetof(VelocityRequest, braking_arc_m));
    hash = fnv1a(hash, "ages_ms");
    hash = fnv1a_number(hash, Schema<decltype(VelocityRequest::ages_ms)>::value);
    hash = fnv1a_number(hash, offsetof(VelocityRequest, ages_ms));
    hash = fnv1a(hash, "limit_mps");
    hash = fnv1a_number(hash, Schema<decltype(VelocityRequest::limit_mps)>::value);
    hash = fnv1a_number(hash, offsetof(VelocityRequest, limit_mps));
    hash = fnv1a(hash, "blocked_arc_m");
    hash = fnv1a_number(hash, Schema<decltype(VelocityRequest::blocked_arc_m)>::value);
    hash = fnv1a_number(hash, offsetof(VelocityRequest, blocked_arc_m));
    hash = fnv1a(hash, "obstacle");
    hash = fnv1a_number(hash, Schema<decltype(VelocityRequest::obstacle)>::value);
    hash = fnv1a_number(hash, offsetof(VelocityRequest, obstacle));
    return hash;
}());

/// Header and fixed fields of the topic's messages.
struct ControlVelocityRequestEnvelope {
    static constexpr const char* NAME = "zeronav.control.velocity_request.v1";
    static constexpr std::uint64_t SCHEMA = 0x1e9b1577c6df1c6d;
    /// The header.
    Header header{};
    /// The fixed fields.
    VelocityRequest meta{};
};
static_assert(sizeof(ControlVelocityRequestEnvelope) == 192);
static_assert(std::is_trivially_copyable_v<ControlVelocityRequestEnvelope> && std::is_standard_layout_v<ControlVelocityRequestEnvelope>);
static_assert(offsetof(ControlVelocityRequestEnvelope, header) == 0);
static_assert(offsetof(ControlVelocityRequestEnvelope, meta) == 128);
static_assert(ControlVelocityRequestEnvelope::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, ControlVelocityRequestEnvelope::NAME);
    hash = fnv1a(hash, "header");
    hash = fnv1a_number(hash, Schema<decltype(ControlVelocityRequestEnvelope::header)>::value);
    hash = fnv1a_number(hash, offsetof(ControlVelocityRequestEnvelope, header));
    hash = fnv1a(hash, "meta");
    hash = fnv1a_number(hash, Schema<decltype(ControlVelocityRequestEnvelope::meta)>::value);
    hash = fnv1a_number(hash, offsetof(ControlVelocityRequestEnvelope, meta));
    return hash;
}());

/// Fixed fields of a velocity command; the slice is empty. What explains it may be left 0.
struct VelocityCommand {
    static constexpr const char* NAME = "zeronav.VelocityCommand.v2";
    static constexpr std::uint64_t SCHEMA = 0x20dd54cf4bae24fe;
    /// [m/s] forward speed in `base`.
    double v_mps{};
    /// [rad/s] yaw rate in `base`.
    double w_radps{};
    /// Code of `Validity`.
    std::uint16_t validity{};
    /// Code of `Intervention`.
    std::uint16_t intervention{};
    /// [number] Beam towards the point that decided, counted from 1, in a scan taken where the
    /// robot is now; 0 = no point decided.
    std::uint16_t beam{};
    /// Written as 0.
    std::uint16_t spare{};
    /// [m] x and y of the point of a scan that is nearest to the way that was asked for and not
    /// free, in `base` of now; with the interventions `slowed` and `stopped_short`.
    double point_m[2]{};
    /// [m] least distance between the outline and that point on that way, at most the margin and
    /// the slow zone of the guard; below 0 inside the outline.
    double point_clearance_m{};
};
static_assert(sizeof(VelocityCommand) == 48);
static_assert(std::is_trivially_copyable_v<VelocityCommand> && std::is_standard_layout_v<VelocityCommand>);
static_assert(offsetof(VelocityCommand, v_mps) == 0);
static_assert(offsetof(VelocityCommand, w_radps) == 8);
static_assert(offsetof(VelocityCommand, validity) == 16);
static_assert(offsetof(VelocityCommand, intervention) == 18);
static_assert(offsetof(VelocityCommand, beam) == 20);
static_assert(offsetof(VelocityCommand, spare) == 22);
static_assert(offsetof(VelocityCommand, point_m) == 24);
static_assert(offsetof(VelocityCommand, point_clearance_m) == 40);
static_assert(VelocityCommand::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, VelocityCommand::NAME);
    hash = fnv1a(hash, "v_mps");
    hash = fnv1a_number(hash, Schema<decltype(VelocityCommand::v_mps)>::value);
    hash = fnv1a_number(hash, offsetof(VelocityCommand, v_mps));
    hash = fnv1a(hash, "w_radps");
    hash = fnv1a_number(hash, Schema<decltype(VelocityCommand::w_radps)>::value);
    hash = fnv1a_number(hash, offsetof(VelocityCommand, w_radps));
    hash = fnv1a(hash, "validity");
    hash = fnv1a_number(hash, Schema<decltype(VelocityCommand::validity)>::value);
    hash = fnv1a_number(hash, offsetof(VelocityCommand, validity));
    hash = fnv1a(hash, "intervention");
    hash = fnv1a_number(hash, Schema<decltype(VelocityCommand::intervention)>::value);
    hash = fnv1a_number(hash, offsetof(VelocityCommand, intervention));
    hash = fnv1a(hash, "beam");
    hash = fnv1a_number(hash, Schema<decltype(VelocityCommand::beam)>::value);
    hash = fnv1a_number(hash, offsetof(VelocityCommand, beam));
    hash = fnv1a(hash, "spare");
    hash = fnv1a_number(hash, Schema<decltype(VelocityCommand::spare)>::value);
    hash = fnv1a_number(hash, offsetof(VelocityCommand, spare));
    hash = fnv1a(hash, "point_m");
    hash = fnv1a_number(hash, Schema<decltype(VelocityCommand::point_m)>::value);
    hash = fnv1a_number(hash, offsetof(VelocityCommand, point_m));
    hash = fnv1a(hash, "point_clearance_m");
    hash = fnv1a_number(hash, Schema<decltype(VelocityCommand::point_clearance_m)>::value);
    hash = fnv1a_number(hash, offsetof(VelocityCommand, point_clearance_m));
    return hash;
}());

/// Header and fixed fields of the topic's messages.
struct RobotVelocityCommandEnvelope {
    static constexpr const char* NAME = "zeronav.robot.velocity_command.v1";
    static constexpr std::uint64_t SCHEMA = 0x8e98cd5f4071e2f9;
    /// The header.
    Header header{};
    /// The fixed fields.
    VelocityCommand meta{};
};
static_assert(sizeof(RobotVelocityCommandEnvelope) == 176);
static_assert(std::is_trivially_copyable_v<RobotVelocityCommandEnvelope> && std::is_standard_layout_v<RobotVelocityCommandEnvelope>);
static_assert(offsetof(RobotVelocityCommandEnvelope, header) == 0);
static_assert(offsetof(RobotVelocityCommandEnvelope, meta) == 128);
static_assert(RobotVelocityCommandEnvelope::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, RobotVelocityCommandEnvelope::NAME);
    hash = fnv1a(hash, "header");
    hash = fnv1a_number(hash, Schema<decltype(RobotVelocityCommandEnvelope::header)>::value);
    hash = fnv1a_number(hash, offsetof(RobotVelocityCommandEnvelope, header));
    hash = fnv1a(hash, "meta");
    hash = fnv1a_number(hash, Schema<decltype(RobotVelocityCommandEnvelope::meta)>::value);
    hash = fnv1a_number(hash, offsetof(RobotVelocityCommandEnvelope, meta));
    return hash;
}());

/// Fixed fields of the clock; the slice is empty. Written once, before any child starts.
struct RunClock {
    static constexpr const char* NAME = "zeronav.RunClock.v3";
    static constexpr std::uint64_t SCHEMA = 0xd07a700a20640937;
    /// Code of `RunMode`.
    std::uint16_t mode{};
    /// [flag] 1 = services time the stages of their cycles and say it in their records; 0 = they
    /// read no clock for it. Always 0 in lockstep.
    std::uint16_t stages{};
    /// [bits] What services are told of what moves on `sim/foresight`: 1 = mapping what there is,
    /// 2 = the local planner what will be; 0 in earnest.
    std::uint16_t foresight{};
    /// Written as 0.
    std::uint16_t spare{};
    /// [number] Seed of everything random in the run.
    std::uint64_t seed{};
    /// [ns] `CLOCK_MONOTONIC` at run time 0.
    std::uint64_t zero_ns{};
    /// [ns] of run time from tick to tick.
    std::uint64_t tick_ns{};
};
static_assert(sizeof(RunClock) == 32);
static_assert(std::is_trivially_copyable_v<RunClock> && std::is_standard_layout_v<RunClock>);
static_assert(offsetof(RunClock, mode) == 0);
static_assert(offsetof(RunClock, stages) == 2);
static_assert(offsetof(RunClock, foresight) == 4);
static_assert(offsetof(RunClock, spare) == 6);
static_assert(offsetof(RunClock, seed) == 8);
static_assert(offsetof(RunClock, zero_ns) == 16);
static_assert(offsetof(RunClock, tick_ns) == 24);
static_assert(RunClock::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, RunClock::NAME);
    hash = fnv1a(hash, "mode");
    hash = fnv1a_number(hash, Schema<decltype(RunClock::mode)>::value);
    hash = fnv1a_number(hash, offsetof(RunClock, mode));
    hash = fnv1a(hash, "stages");
    hash = fnv1a_number(hash, Schema<decltype(RunClock::stages)>::value);
    hash = fnv1a_number(hash, offsetof(RunClock, stages));
    hash = fnv1a(hash, "foresight");
    hash = fnv1a_number(hash, Schema<decltype(RunClock::foresight)>::value);
    hash = fnv1a_number(hash, offsetof(RunClock, foresight));
    hash = fnv1a(hash, "spare");
    hash = fnv1a_number(hash, Schema<decltype(RunClock::spare)>::value);
    hash = fnv1a_number(hash, offsetof(RunClock, spare));
    hash = fnv1a(hash, "seed");
    hash = fnv1a_number(hash, Schema<decltype(RunClock::seed)>::value);
    hash = fnv1a_number(hash, offsetof(RunClock, seed));
    hash = fnv1a(hash, "zero_ns");
    hash = fnv1a_number(hash, Schema<decltype(RunClock::zero_ns)>::value);
    hash = fnv1a_number(hash, offsetof(RunClock, zero_ns));
    hash = fnv1a(hash, "tick_ns");
    hash = fnv1a_number(hash, Schema<decltype(RunClock::tick_ns)>::value);
    hash = fnv1a_number(hash, offsetof(RunClock, tick_ns));
    return hash;
}());

/// Header and fixed fields of the topic's messages.
struct RunClockEnvelope {
    static constexpr const char* NAME = "zeronav.run.clock.v1";
    static constexpr std::uint64_t SCHEMA = 0x9ed1e77c674af3f4;
    /// The header.
    Header header{};
    /// The fixed fields.
    RunClock meta{};
};
static_assert(sizeof(RunClockEnvelope) == 160);
static_assert(std::is_trivially_copyable_v<RunClockEnvelope> && std::is_standard_layout_v<RunClockEnvelope>);
static_assert(offsetof(RunClockEnvelope, header) == 0);
static_assert(offsetof(RunClockEnvelope, meta) == 128);
static_assert(RunClockEnvelope::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, RunClockEnvelope::NAME);
    hash = fnv1a(hash, "header");
    hash = fnv1a_number(hash, Schema<decltype(RunClockEnvelope::header)>::value);
    hash = fnv1a_number(hash, offsetof(RunClockEnvelope, header));
    hash = fnv1a(hash, "meta");
    hash = fnv1a_number(hash, Schema<decltype(RunClockEnvelope::meta)>::value);
    hash = fnv1a_number(hash, offsetof(RunClockEnvelope, meta));
    return hash;
}());

/// A topic whose messages are disturbed on purpose on their way to each service that reads it, in
/// real time only: lockstep waits for every message.
struct TopicFault {
    static constexpr const char* NAME = "zeronav.TopicFault.v1";
    static constexpr std::uint64_t SCHEMA = 0x5f8cd93dd9ae3a0d;
    /// [number] of the topic.
    std::uint16_t topic{};
    /// Code of `TopicFaultKind`.
    std::uint16_t kind{};
    /// [ppm] of the messages that are dropped or corrupted.
    std::uint32_t share{};
    /// [us] by which each message is late.
    std::uint32_t delay_us{};
    /// [number] Seed of which messages, and which bits.
    std::uint32_t seed{};
};
static_assert(sizeof(TopicFault) == 16);
static_assert(std::is_trivially_copyable_v<TopicFault> && std::is_standard_layout_v<TopicFault>);
static_assert(offsetof(TopicFault, topic) == 0);
static_assert(offsetof(TopicFault, kind) == 2);
static_assert(offsetof(TopicFault, share) == 4);
static_assert(offsetof(TopicFault, delay_us) == 8);
static_assert(offsetof(TopicFault, seed) == 12);
static_assert(TopicFault::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, TopicFault::NAME);
    hash = fnv1a(hash, "topic");
    hash = fnv1a_number(hash, Schema<decltype(TopicFault::topic)>::value);
    hash = fnv1a_number(hash, offsetof(TopicFault, topic));
    hash = fnv1a(hash, "kind");
    hash = fnv1a_number(hash, Schema<decltype(TopicFault::kind)>::value);
    hash = fnv1a_number(hash, offsetof(TopicFault, kind));
    hash = fnv1a(hash, "share");
    hash = fnv1a_number(hash, Schema<decltype(TopicFault::share)>::value);
    hash = fnv1a_number(hash, offsetof(TopicFault, share));
    hash = fnv1a(hash, "delay_us");
    hash = fnv1a_number(hash, Schema<decltype(TopicFault::delay_us)>::value);
    hash = fnv1a_number(hash, offsetof(TopicFault, delay_us));
    hash = fnv1a(hash, "seed");
    hash = fnv1a_number(hash, Schema<decltype(TopicFault::seed)>::value);
    hash = fnv1a_number(hash, offsetof(TopicFault, seed));
    return hash;
}());

/// Fixed fields of the control message. The slice holds the roster.
struct RunControl {
    static constexpr const char* NAME = "zeronav.RunControl.v3";
    static constexpr std::uint64_t SCHEMA = 0xfd6f5df11a6a068e;
    /// [tick] Highest tick that the robot may start, lockstep only.
    std::uint64_t lease{};
    /// [flag] 1 = the robot shall stand and run time stops.
    std::uint16_t paused{};
    /// [flag] 1 = the run is ending: stop the robot.
    std::uint16_t stopping{};
    /// [count] Seats in the slice.
    std::uint32_t n_seats{};
    /// [number] Revision of `task/zones` that holds; 0 = there were never any.
    std::uint64_t zones{};
    /// Topics that are disturbed on purpose; all zero in earnest.
    TopicFault topic_faults[4]{};
};
static_assert(sizeof(RunControl) == 88);
static_assert(std::is_trivially_copyable_v<RunControl> && std::is_standard_layout_v<RunControl>);
static_assert(offsetof(RunControl, lease) == 0);
static_assert(offsetof(RunControl, paused) == 8);
static_assert(offsetof(RunControl, stopping) == 10);
static_assert(offsetof(RunControl, n_seats) == 12);
static_assert(offsetof(RunControl, zones) == 16);
static_assert(offsetof(RunControl, topic_faults) == 24);
static_assert(RunControl::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, RunControl::NAME);
    hash = fnv1a(hash, "lease");
    hash = fnv1a_number(hash, Schema<decltype(RunControl::lease)>::value);
    hash = fnv1a_number(hash, offsetof(RunControl, lease));
    hash = fnv1a(hash, "paused");
    hash = fnv1a_number(hash, Schema<decltype(RunControl::paused)>::value);
    hash = fnv1a_number(hash, offsetof(RunControl, paused));
    hash = fnv1a(hash, "stopping");
    hash = fnv1a_number(hash, Schema<decltype(RunControl::stopping)>::value);
    hash = fnv1a_number(hash, offsetof(RunControl, stopping));
    hash = fnv1a(hash, "n_seats");
    hash = fnv1a_number(hash, Schema<decltype(RunControl::n_seats)>::value);
    hash = fnv1a_number(hash, offsetof(RunControl, n_seats));
    hash = fnv1a(hash, "zones");
    hash = fnv1a_number(hash, Schema<decltype(RunControl::zones)>::value);
    hash = fnv1a_number(hash, offsetof(RunControl, zones));
    hash = fnv1a(hash, "topic_faults");
    hash = fnv1a_number(hash, Schema<decltype(RunControl::topic_faults)>::value);
    hash = fnv1a_number(hash, offsetof(RunControl, topic_faults));
    return hash;
}());

/// Header and fixed fields of the topic's messages.
struct RunControlEnvelope {
    static constexpr const char* NAME = "zeronav.run.control.v1";
    static constexpr std::uint64_t SCHEMA = 0xc8de769278752ee7;
    /// The header.
    Header header{};
    /// The fixed fields.
    RunControl meta{};
};
static_assert(sizeof(RunControlEnvelope) == 216);
static_assert(std::is_trivially_copyable_v<RunControlEnvelope> && std::is_standard_layout_v<RunControlEnvelope>);
static_assert(offsetof(RunControlEnvelope, header) == 0);
static_assert(offsetof(RunControlEnvelope, meta) == 128);
static_assert(RunControlEnvelope::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, RunControlEnvelope::NAME);
    hash = fnv1a(hash, "header");
    hash = fnv1a_number(hash, Schema<decltype(RunControlEnvelope::header)>::value);
    hash = fnv1a_number(hash, offsetof(RunControlEnvelope, header));
    hash = fnv1a(hash, "meta");
    hash = fnv1a_number(hash, Schema<decltype(RunControlEnvelope::meta)>::value);
    hash = fnv1a_number(hash, offsetof(RunControlEnvelope, meta));
    return hash;
}());

/// One seat of the roster. Two processes can run in it: one is obeyed, the other is warm. At which
/// tick the one takes over from the other is said in advance, so that no message is heard twice
/// and none is missed.
struct Seat {
    static constexpr const char* NAME = "zeronav.Seat.v3";
    static constexpr std::uint64_t SCHEMA = 0x5c3114b8201013cc;
    /// Code of the `Role`.
    std::uint16_t role{};
    /// [10 us] by which the seat delays each of its answers; 0 in earnest. A delay put in on
    /// purpose must appear in this seat's hop and nowhere else.
    std::uint16_t delay{};
    /// [number] The epoch that is obeyed in this seat from `since_tick` on; 0 = none yet.
    std::uint32_t epoch{};
    /// [tick] First tick at which the seat is empty.
    std::uint64_t off_tick{};
    /// [tick] First tick at which it is taken again; `off_tick == on_tick` = never empty.
    std::uint64_t on_tick{};
    /// [tick] Messages of ticks below this one are not heard by `epoch`.
    std::uint64_t hear_tick{};
    /// [tick] First tick at which `epoch` is obeyed; before it, `other` is.
    std::uint64_t since_tick{};
    /// [tick] `other` answers from this tick on, and hears no message of an earlier one.
    std::uint64_t other_tick{};
    /// [number] Epoch of the second process in this seat: a newcomer that is not obeyed yet, or a
    /// predecessor that still runs; 0 = none.
    std::uint32_t other{};
    /// [ms] by which the clocks of its processes are put forward on purpose; 0 in earnest.
    std::int32_t clock_offset_ms{};
};
static_assert(sizeof(Seat) == 56);
static_assert(std::is_trivially_copyable_v<Seat> && std::is_standard_layout_v<Seat>);
static_assert(offsetof(Seat, role) == 0);
static_assert(offsetof(Seat, delay) == 2);
static_assert(offsetof(Seat, epoch) == 4);
static_assert(offsetof(Seat, off_tick) == 8);
static_assert(offsetof(Seat, on_tick) == 16);
static_assert(offsetof(Seat, hear_tick) == 24);
static_assert(offsetof(Seat, since_tick) == 32);
static_assert(offsetof(Seat, other_tick) == 40);
static_assert(offsetof(Seat, other) == 48);
static_assert(offsetof(Seat, clock_offset_ms) == 52);
static_assert(Seat::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, Seat::NAME);
    hash = fnv1a(hash, "role");
    hash = fnv1a_number(hash, Schema<decltype(Seat::role)>::value);
    hash = fnv1a_number(hash, offsetof(Seat, role));
    hash = fnv1a(hash, "delay");
    hash = fnv1a_number(hash, Schema<decltype(Seat::delay)>::value);
    hash = fnv1a_number(hash, offsetof(Seat, delay));
    hash = fnv1a(hash, "epoch");
    hash = fnv1a_number(hash, Schema<decltype(Seat::epoch)>::value);
    hash = fnv1a_number(hash, offsetof(Seat, epoch));
    hash = fnv1a(hash, "off_tick");
    hash = fnv1a_number(hash, Schema<decltype(Seat::off_tick)>::value);
    hash = fnv1a_number(hash, offsetof(Seat, off_tick));
    hash = fnv1a(hash, "on_tick");
    hash = fnv1a_number(hash, Schema<decltype(Seat::on_tick)>::value);
    hash = fnv1a_number(hash, offsetof(Seat, on_tick));
    hash = fnv1a(hash, "hear_tick");
    hash = fnv1a_number(hash, Schema<decltype(Seat::hear_tick)>::value);
    hash = fnv1a_number(hash, offsetof(Seat, hear_tick));
    hash = fnv1a(hash, "since_tick");
    hash = fnv1a_number(hash, Schema<decltype(Seat::since_tick)>::value);
    hash = fnv1a_number(hash, offsetof(Seat, since_tick));
    hash = fnv1a(hash, "other_tick");
    hash = fnv1a_number(hash, Schema<decltype(Seat::other_tick)>::value);
    hash = fnv1a_number(hash, offsetof(Seat, other_tick));
    hash = fnv1a(hash, "other");
    hash = fnv1a_number(hash, Schema<decltype(Seat::other)>::value);
    hash = fnv1a_number(hash, offsetof(Seat, other));
    hash = fnv1a(hash, "clock_offset_ms");
    hash = fnv1a_number(hash, Schema<decltype(Seat::clock_offset_ms)>::value);
    hash = fnv1a_number(hash, offsetof(Seat, clock_offset_ms));
    return hash;
}());

/// Fixed fields of the truth at one tick. The slice holds the scripted obstacles that exist.
struct Truth {
    static constexpr const char* NAME = "zeronav.Truth.v1";
    static constexpr std::uint64_t SCHEMA = 0xbf306f77685c2baa;
    /// True `map_from_base`.
    Pose pose{};
    /// [m/s] true forward speed.
    double v_mps{};
    /// [rad/s] true yaw rate.
    double w_radps{};
    /// [m] from the footprint to the nearest thing; 0 in contact; capped at 1000.
    double clearance_m{};
    /// [m] driven since the start.
    double driven_m{};
    /// [flag] 1 while the footprint touches something.
    std::uint32_t in_contact{};
    /// [count] Contacts that began while the robot moved faster than 0.05 m/s.
    std::uint32_t contacts_moving{};
    /// [count] Contacts that began while it stood.
    std::uint32_t contacts_standing{};
    /// [count] Obstacles in the slice.
    std::uint32_t n_obstacles{};
    /// [id] Id of the scan of this tick, 0 = none.
    std::uint64_t scan{};
    /// [ns] run time lost because the simulator was late.
    std::uint64_t slipped_ns{};
};
static_assert(sizeof(Truth) == 88);
static_assert(std::is_trivially_copyable_v<Truth> && std::is_standard_layout_v<Truth>);
static_assert(offsetof(Truth, pose) == 0);
static_assert(offsetof(Truth, v_mps) == 24);
static_assert(offsetof(Truth, w_radps) == 32);
static_assert(offsetof(Truth, clearance_m) == 40);
static_assert(offsetof(Truth, driven_m) == 48);
static_assert(offsetof(Truth, in_contact) == 56);
static_assert(offsetof(Truth, contacts_moving) == 60);
static_assert(offsetof(Truth, contacts_standing) == 64);
static_assert(offsetof(Truth, n_obstacles) == 68);
static_assert(offsetof(Truth, scan) == 72);
static_assert(offsetof(Truth, slipped_ns) == 80);
static_assert(Truth::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, Truth::NAME);
    hash = fnv1a(hash, "pose");
    hash = fnv1a_number(hash, Schema<decltype(Truth::pose)>::value);
    hash = fnv1a_number(hash, offsetof(Truth, pose));
    hash = fnv1a(hash, "v_mps");
    hash = fnv1a_number(hash, Schema<decltype(Truth::v_mps)>::value);
    hash = fnv1a_number(hash, offsetof(Truth, v_mps));
    hash = fnv1a(hash, "w_radps");
    hash = fnv1a_number(hash, Schema<decltype(Truth::w_radps)>::value);
    hash = fnv1a_number(hash, offsetof(Truth, w_radps));
    hash = fnv1a(hash, "clearance_m");
    hash = fnv1a_number(hash, Schema<decltype(Truth::clearance_m)>::value);
    hash = fnv1a_number(hash, offsetof(Truth, clearance_m));
    hash = fnv1a(hash, "driven_m");
    hash = fnv1a_number(hash, Schema<decltype(Truth::driven_m)>::value);
    hash = fnv1a_number(hash, offsetof(Truth, driven_m));
    hash = fnv1a(hash, "in_contact");
    hash = fnv1a_number(hash, Schema<decltype(Truth::in_contact)>::value);
    hash = fnv1a_number(hash, offsetof(Truth, in_contact));
    hash = fnv1a(hash, "contacts_moving");
    hash = fnv1a_number(hash, Schema<decltype(Truth::contacts_moving)>::value);
    hash = fnv1a_number(hash, offsetof(Truth, contacts_moving));
    hash = fnv1a(hash, "contacts_standing");
    hash = fnv1a_number(hash, Schema<decltype(Truth::contacts_standing)>::value);
    hash = fnv1a_number(hash, offsetof(Truth, contacts_standing));
    hash = fnv1a(hash, "n_obstacles");
    hash = fnv1a_number(hash, Schema<decltype(Truth::n_obstacles)>::value);
    hash = fnv1a_number(hash, offsetof(Truth, n_obstacles));
    hash = fnv1a(hash, "scan");
    hash = fnv1a_number(hash, Schema<decltype(Truth::scan)>::value);
    hash = fnv1a_number(hash, offsetof(Truth, scan));
    hash = fnv1a(hash, "slipped_ns");
    hash = fnv1a_number(hash, Schema<decltype(Truth::slipped_ns)>::value);
    hash = fnv1a_number(hash, offsetof(Truth, slipped_ns));
    return hash;
}());

/// Header and fixed fields of the topic's messages.
struct SimGroundTruthEnvelope {
    static constexpr const char* NAME = "zeronav.sim.ground_truth.v1";
    static constexpr std::uint64_t SCHEMA = 0xa5c52b7bd0a6d5b1;
    /// The header.
    Header header{};
    /// The fixed fields.
    Truth meta{};
};
static_assert(sizeof(SimGroundTruthEnvelope) == 216);
static_assert(std::is_trivially_copyable_v<SimGroundTruthEnvelope> && std::is_standard_layout_v<SimGroundTruthEnvelope>);
static_assert(offsetof(SimGroundTruthEnvelope, header) == 0);
static_assert(offsetof(SimGroundTruthEnvelope, meta) == 128);
static_assert(SimGroundTruthEnvelope::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, SimGroundTruthEnvelope::NAME);
    hash = fnv1a(hash, "header");
    hash = fnv1a_number(hash, Schema<decltype(SimGroundTruthEnvelope::header)>::value);
    hash = fnv1a_number(hash, offsetof(SimGroundTruthEnvelope, header));
    hash = fnv1a(hash, "meta");
    hash = fnv1a_number(hash, Schema<decltype(SimGroundTruthEnvelope::meta)>::value);
    hash = fnv1a_number(hash, offsetof(SimGroundTruthEnvelope, meta));
    return hash;
}());

/// Truth about one scripted obstacle.
struct TruthObstacle {
    static constexpr const char* NAME = "zeronav.TruthObstacle.v1";
    static constexpr std::uint64_t SCHEMA = 0xadb3b9b564924e97;
    /// [number] Place in the scenario's list, from 0.
    std::uint32_t index{};
    /// [count] Beams of this tick's scan that ended on it.
    std::uint32_t beams{};
    /// [ns] run time at which it was due to appear.
    std::uint64_t appeared_run_ns{};
    /// [ns] `CLOCK_MONOTONIC` of that moment.
    std::uint64_t appeared_ns{};
    /// Where it is, `map` frame.
    Pose pose{};
};
static_assert(sizeof(TruthObstacle) == 48);
static_assert(std::is_trivially_copyable_v<TruthObstacle> && std::is_standard_layout_v<TruthObstacle>);
static_assert(offsetof(TruthObstacle, index) == 0);
static_assert(offsetof(TruthObstacle, beams) == 4);
static_assert(offsetof(TruthObstacle, appeared_run_ns) == 8);
static_assert(offsetof(TruthObstacle, appeared_ns) == 16);
static_assert(offsetof(TruthObstacle, pose) == 24);
static_assert(TruthObstacle::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, TruthObstacle::NAME);
    hash = fnv1a(hash, "index");
    hash = fnv1a_number(hash, Schema<decltype(TruthObstacle::index)>::value);
    hash = fnv1a_number(hash, offsetof(TruthObstacle, index));
    hash = fnv1a(hash, "beams");
    hash = fnv1a_number(hash, Schema<decltype(TruthObstacle::beams)>::value);
    hash = fnv1a_number(hash, offsetof(TruthObstacle, beams));
    hash = fnv1a(hash, "appeared_run_ns");
    hash = fnv1a_number(hash, Schema<decltype(TruthObstacle::appeared_run_ns)>::value);
    hash = fnv1a_number(hash, offsetof(TruthObstacle, appeared_run_ns));
    hash = fnv1a(hash, "appeared_ns");
    hash = fnv1a_number(hash, Schema<decltype(TruthObstacle::appeared_ns)>::value);
    hash = fnv1a_number(hash, offsetof(TruthObstacle, appeared_ns));
    hash = fnv1a(hash, "pose");
    hash = fnv1a_number(hash, Schema<decltype(TruthObstacle::pose)>::value);
    hash = fnv1a_number(hash, offsetof(TruthObstacle, pose));
    return hash;
}());

/// Fixed fields of the foresight. The slice holds what moves.
struct Foresight {
    static constexpr const char* NAME = "zeronav.Foresight.v1";
    static constexpr std::uint64_t SCHEMA = 0x37ad2d72e7b328f8;
    /// True `map_from_base` at the capture of the scan.
    Pose pose{};
    /// [count] Obstacles in the slice.
    std::uint64_t n_obstacles{};
};
static_assert(sizeof(Foresight) == 32);
static_assert(std::is_trivially_copyable_v<Foresight> && std::is_standard_layout_v<Foresight>);
static_assert(offsetof(Foresight, pose) == 0);
static_assert(offsetof(Foresight, n_obstacles) == 24);
static_assert(Foresight::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, Foresight::NAME);
    hash = fnv1a(hash, "pose");
    hash = fnv1a_number(hash, Schema<decltype(Foresight::pose)>::value);
    hash = fnv1a_number(hash, offsetof(Foresight, pose));
    hash = fnv1a(hash, "n_obstacles");
    hash = fnv1a_number(hash, Schema<decltype(Foresight::n_obstacles)>::value);
    hash = fnv1a_number(hash, offsetof(Foresight, n_obstacles));
    return hash;
}());

/// Header and fixed fields of the topic's messages.
struct SimForesightEnvelope {
    static constexpr const char* NAME = "zeronav.sim.foresight.v1";
    static constexpr std::uint64_t SCHEMA = 0xfc490b748f05115a;
    /// The header.
    Header header{};
    /// The fixed fields.
    Foresight meta{};
};
static_assert(sizeof(SimForesightEnvelope) == 160);
static_assert(std::is_trivially_copyable_v<SimForesightEnvelope> && std::is_standard_layout_v<SimForesightEnvelope>);
static_assert(offsetof(SimForesightEnvelope, header) == 0);
static_assert(offsetof(SimForesightEnvelope, meta) == 128);
static_assert(SimForesightEnvelope::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, SimForesightEnvelope::NAME);
    hash = fnv1a(hash, "header");
    hash = fnv1a_number(hash, Schema<decltype(SimForesightEnvelope::header)>::value);
    hash = fnv1a_number(hash, offsetof(SimForesightEnvelope, header));
    hash = fnv1a(hash, "meta");
    hash = fnv1a_number(hash, Schema<decltype(SimForesightEnvelope::meta)>::value);
    hash = fnv1a_number(hash, offsetof(SimForesightEnvelope, meta));
    return hash;
}());

/// An obstacle that moves: where it is, and where it will be.
struct Foreseen {
    static constexpr const char* NAME = "zeronav.Foreseen.v1";
    static constexpr std::uint64_t SCHEMA = 0xc66ce90421372d9a;
    /// [number] Place in the scenario's list, from 0.
    std::uint64_t index{};
    /// [m/s] `map` frame.
    double vx_mps{};
    /// [m/s] `map` frame.
    double vy_mps{};
    /// [m] 0 to 10. For other shapes: radius of the enclosing disc.
    double radius_m{};
    /// [s] until it vanishes; 1e9 = it stays.
    double lasts_s{};
    /// [m] `map` frame, now and every 0.1 s from now on.
    double x_m[64]{};
    /// [m] `map` frame, at the same times.
    double y_m[64]{};
};
static_assert(sizeof(Foreseen) == 1064);
static_assert(std::is_trivially_copyable_v<Foreseen> && std::is_standard_layout_v<Foreseen>);
static_assert(offsetof(Foreseen, index) == 0);
static_assert(offsetof(Foreseen, vx_mps) == 8);
static_assert(offsetof(Foreseen, vy_mps) == 16);
static_assert(offsetof(Foreseen, radius_m) == 24);
static_assert(offsetof(Foreseen, lasts_s) == 32);
static_assert(offsetof(Foreseen, x_m) == 40);
static_assert(offsetof(Foreseen, y_m) == 552);
static_assert(Foreseen::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, Foreseen::NAME);
    hash = fnv1a(hash, "index");
    hash = fnv1a_number(hash, Schema<decltype(Foreseen::index)>::value);
    hash = fnv1a_number(hash, offsetof(Foreseen, index));
    hash = fnv1a(hash, "vx_mps");
    hash = fnv1a_number(hash, Schema<decltype(Foreseen::vx_mps)>::value);
    hash = fnv1a_number(hash, offsetof(Foreseen, vx_mps));
    hash = fnv1a(hash, "vy_mps");
    hash = fnv1a_number(hash, Schema<decltype(Foreseen::vy_mps)>::value);
    hash = fnv1a_number(hash, offsetof(Foreseen, vy_mps));
    hash = fnv1a(hash, "radius_m");
    hash = fnv1a_number(hash, Schema<decltype(Foreseen::radius_m)>::value);
    hash = fnv1a_number(hash, offsetof(Foreseen, radius_m));
    hash = fnv1a(hash, "lasts_s");
    hash = fnv1a_number(hash, Schema<decltype(Foreseen::lasts_s)>::value);
    hash = fnv1a_number(hash, offsetof(Foreseen, lasts_s));
    hash = fnv1a(hash, "x_m");
    hash = fnv1a_number(hash, Schema<decltype(Foreseen::x_m)>::value);
    hash = fnv1a_number(hash, offsetof(Foreseen, x_m));
    hash = fnv1a(hash, "y_m");
    hash = fnv1a_number(hash, Schema<decltype(Foreseen::y_m)>::value);
    hash = fnv1a_number(hash, offsetof(Foreseen, y_m));
    return hash;
}());

/// Fixed fields of the placements.
struct Placements {
    static constexpr const char* NAME = "zeronav.Placements.v1";
    static constexpr std::uint64_t SCHEMA = 0x2e0ab29d04752af7;
    /// [count] Placements in the slice.
    std::uint64_t n_placements{};
};
static_assert(sizeof(Placements) == 8);
static_assert(std::is_trivially_copyable_v<Placements> && std::is_standard_layout_v<Placements>);
static_assert(offsetof(Placements, n_placements) == 0);
static_assert(Placements::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, Placements::NAME);
    hash = fnv1a(hash, "n_placements");
    hash = fnv1a_number(hash, Schema<decltype(Placements::n_placements)>::value);
    hash = fnv1a_number(hash, offsetof(Placements, n_placements));
    return hash;
}());

/// Header and fixed fields of the topic's messages.
struct SimPlacementEnvelope {
    static constexpr const char* NAME = "zeronav.sim.placement.v1";
    static constexpr std::uint64_t SCHEMA = 0x5688a38a4f2c86ba;
    /// The header.
    Header header{};
    /// The fixed fields.
    Placements meta{};
};
static_assert(sizeof(SimPlacementEnvelope) == 136);
static_assert(std::is_trivially_copyable_v<SimPlacementEnvelope> && std::is_standard_layout_v<SimPlacementEnvelope>);
static_assert(offsetof(SimPlacementEnvelope, header) == 0);
static_assert(offsetof(SimPlacementEnvelope, meta) == 128);
static_assert(SimPlacementEnvelope::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, SimPlacementEnvelope::NAME);
    hash = fnv1a(hash, "header");
    hash = fnv1a_number(hash, Schema<decltype(SimPlacementEnvelope::header)>::value);
    hash = fnv1a_number(hash, offsetof(SimPlacementEnvelope, header));
    hash = fnv1a(hash, "meta");
    hash = fnv1a_number(hash, Schema<decltype(SimPlacementEnvelope::meta)>::value);
    hash = fnv1a_number(hash, offsetof(SimPlacementEnvelope, meta));
    return hash;
}());

/// Puts an obstacle somewhere for a time, whatever its script says. Until `from_run_ns` it does
/// what it did before. A later placement with the same `from_run_ns` and `pose` changes only how
/// long it stays.
struct Placement {
    static constexpr const char* NAME = "zeronav.Placement.v2";
    static constexpr std::uint64_t SCHEMA = 0x17e47a193d65891f;
    /// [number] Place in the scenario's list, from 0; one behind the last adds an obstacle.
    std::uint32_t index{};
    /// Written as 0.
    std::uint32_t spare{};
    /// [ns] run time from which it is there; in lockstep of a tick above the lease.
    std::uint64_t from_run_ns{};
    /// [ns] run time from which it is gone; 0 = it stays.
    std::uint64_t until_run_ns{};
    /// `map_from_shape` while it is there.
    Pose pose{};
    /// [m] of the rectangle that it becomes, along x, or diameter of a disc; 0 = the shape that it
    /// has.
    double size_x_m{};
    /// [m] along y; 0 = a disc.
    double size_y_m{};
};
static_assert(sizeof(Placement) == 64);
static_assert(std::is_trivially_copyable_v<Placement> && std::is_standard_layout_v<Placement>);
static_assert(offsetof(Placement, index) == 0);
static_assert(offsetof(Placement, spare) == 4);
static_assert(offsetof(Placement, from_run_ns) == 8);
static_assert(offsetof(Placement, until_run_ns) == 16);
static_assert(offsetof(Placement, pose) == 24);
static_assert(offsetof(Placement, size_x_m) == 48);
static_assert(offsetof(Placement, size_y_m) == 56);
static_assert(Placement::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, Placement::NAME);
    hash = fnv1a(hash, "index");
    hash = fnv1a_number(hash, Schema<decltype(Placement::index)>::value);
    hash = fnv1a_number(hash, offsetof(Placement, index));
    hash = fnv1a(hash, "spare");
    hash = fnv1a_number(hash, Schema<decltype(Placement::spare)>::value);
    hash = fnv1a_number(hash, offsetof(Placement, spare));
    hash = fnv1a(hash, "from_run_ns");
    hash = fnv1a_number(hash, Schema<decltype(Placement::from_run_ns)>::value);
    hash = fnv1a_number(hash, offsetof(Placement, from_run_ns));
    hash = fnv1a(hash, "until_run_ns");
    hash = fnv1a_number(hash, Schema<decltype(Placement::until_run_ns)>::value);
    hash = fnv1a_number(hash, offsetof(Placement, until_run_ns));
    hash = fnv1a(hash, "pose");
    hash = fnv1a_number(hash, Schema<decltype(Placement::pose)>::value);
    hash = fnv1a_number(hash, offsetof(Placement, pose));
    hash = fnv1a(hash, "size_x_m");
    hash = fnv1a_number(hash, Schema<decltype(Placement::size_x_m)>::value);
    hash = fnv1a_number(hash, offsetof(Placement, size_x_m));
    hash = fnv1a(hash, "size_y_m");
    hash = fnv1a_number(hash, Schema<decltype(Placement::size_y_m)>::value);
    hash = fnv1a_number(hash, offsetof(Placement, size_y_m));
    return hash;
}());

/// Fixed fields of the rollouts of a control period: a spread over all, with the chosen one and
/// the cheapest of every reason. A period that goes on with an older choice sends none.
struct Rollouts {
    static constexpr const char* NAME = "zeronav.Rollouts.v1";
    static constexpr std::uint64_t SCHEMA = 0xc99b51e227a7b107;
    /// [count] Number of rollouts, equal to the length of the slice.
    std::uint64_t n_rollouts{};
    /// [count] Motions that the local planner looked at, 0 = not told.
    std::uint64_t n_looked_at{};
    /// Where the rollouts begin: the robot in the map.
    Pose map_from_base{};
};
static_assert(sizeof(Rollouts) == 40);
static_assert(std::is_trivially_copyable_v<Rollouts> && std::is_standard_layout_v<Rollouts>);
static_assert(offsetof(Rollouts, n_rollouts) == 0);
static_assert(offsetof(Rollouts, n_looked_at) == 8);
static_assert(offsetof(Rollouts, map_from_base) == 16);
static_assert(Rollouts::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, Rollouts::NAME);
    hash = fnv1a(hash, "n_rollouts");
    hash = fnv1a_number(hash, Schema<decltype(Rollouts::n_rollouts)>::value);
    hash = fnv1a_number(hash, offsetof(Rollouts, n_rollouts));
    hash = fnv1a(hash, "n_looked_at");
    hash = fnv1a_number(hash, Schema<decltype(Rollouts::n_looked_at)>::value);
    hash = fnv1a_number(hash, offsetof(Rollouts, n_looked_at));
    hash = fnv1a(hash, "map_from_base");
    hash = fnv1a_number(hash, Schema<decltype(Rollouts::map_from_base)>::value);
    hash = fnv1a_number(hash, offsetof(Rollouts, map_from_base));
    return hash;
}());

/// Header and fixed fields of the topic's messages.
struct DebugRolloutsEnvelope {
    static constexpr const char* NAME = "zeronav.debug.rollouts.v1";
    static constexpr std::uint64_t SCHEMA = 0x8db4eb9a99d34beb;
    /// The header.
    Header header{};
    /// The fixed fields.
    Rollouts meta{};
};
static_assert(sizeof(DebugRolloutsEnvelope) == 168);
static_assert(std::is_trivially_copyable_v<DebugRolloutsEnvelope> && std::is_standard_layout_v<DebugRolloutsEnvelope>);
static_assert(offsetof(DebugRolloutsEnvelope, header) == 0);
static_assert(offsetof(DebugRolloutsEnvelope, meta) == 128);
static_assert(DebugRolloutsEnvelope::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, DebugRolloutsEnvelope::NAME);
    hash = fnv1a(hash, "header");
    hash = fnv1a_number(hash, Schema<decltype(DebugRolloutsEnvelope::header)>::value);
    hash = fnv1a_number(hash, offsetof(DebugRolloutsEnvelope, header));
    hash = fnv1a(hash, "meta");
    hash = fnv1a_number(hash, Schema<decltype(DebugRolloutsEnvelope::meta)>::value);
    hash = fnv1a_number(hash, offsetof(DebugRolloutsEnvelope, meta));
    return hash;
}());

/// A motion as far as it was looked at, at most as far as what it leads into.
struct Rollout {
    static constexpr const char* NAME = "zeronav.Rollout.v1";
    static constexpr std::uint64_t SCHEMA = 0xbff1df21de2f4ddf;
    /// [m/s] forward speed that it goes towards at first, in `base`.
    float v_mps{};
    /// [rad/s] yaw rate that it goes towards at first, in `base`.
    float w_radps{};
    /// [-] what it costs, in the controller's own unit; less is better. 0 = not rated.
    float cost{};
    /// Code of `RolloutOutcome`.
    std::uint16_t outcome{};
    /// [count] Number of points, at most `ROLLOUT_POINTS_MAX`; the others are 0.
    std::uint16_t n_points{};
    /// [m] x of its points in the `map` frame; the first one is where the robot is.
    float x_m[12]{};
    /// [m] y of its points in the `map` frame.
    float y_m[12]{};
};
static_assert(sizeof(Rollout) == 112);
static_assert(std::is_trivially_copyable_v<Rollout> && std::is_standard_layout_v<Rollout>);
static_assert(offsetof(Rollout, v_mps) == 0);
static_assert(offsetof(Rollout, w_radps) == 4);
static_assert(offsetof(Rollout, cost) == 8);
static_assert(offsetof(Rollout, outcome) == 12);
static_assert(offsetof(Rollout, n_points) == 14);
static_assert(offsetof(Rollout, x_m) == 16);
static_assert(offsetof(Rollout, y_m) == 64);
static_assert(Rollout::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, Rollout::NAME);
    hash = fnv1a(hash, "v_mps");
    hash = fnv1a_number(hash, Schema<decltype(Rollout::v_mps)>::value);
    hash = fnv1a_number(hash, offsetof(Rollout, v_mps));
    hash = fnv1a(hash, "w_radps");
    hash = fnv1a_number(hash, Schema<decltype(Rollout::w_radps)>::value);
    hash = fnv1a_number(hash, offsetof(Rollout, w_radps));
    hash = fnv1a(hash, "cost");
    hash = fnv1a_number(hash, Schema<decltype(Rollout::cost)>::value);
    hash = fnv1a_number(hash, offsetof(Rollout, cost));
    hash = fnv1a(hash, "outcome");
    hash = fnv1a_number(hash, Schema<decltype(Rollout::outcome)>::value);
    hash = fnv1a_number(hash, offsetof(Rollout, outcome));
    hash = fnv1a(hash, "n_points");
    hash = fnv1a_number(hash, Schema<decltype(Rollout::n_points)>::value);
    hash = fnv1a_number(hash, offsetof(Rollout, n_points));
    hash = fnv1a(hash, "x_m");
    hash = fnv1a_number(hash, Schema<decltype(Rollout::x_m)>::value);
    hash = fnv1a_number(hash, offsetof(Rollout, x_m));
    hash = fnv1a(hash, "y_m");
    hash = fnv1a_number(hash, Schema<decltype(Rollout::y_m)>::value);
    hash = fnv1a_number(hash, offsetof(Rollout, y_m));
    return hash;
}());

/// Fixed fields of the heartbeat; the slice is empty.
struct Health {
    static constexpr const char* NAME = "zeronav.Health.v1";
    static constexpr std::uint64_t SCHEMA = 0x044997d7e555e1f6;
    /// [count] Grows with every wake (at least every 50 ms, also when idle) and with long work.
    std::uint64_t progress{};
    /// Code of `HealthState`.
    std::uint16_t state{};
    /// Written as 0.
    std::uint16_t spare{};
    /// [bits] Sum of the reason bits.
    std::uint32_t reasons{};
    /// [number] Process id.
    std::uint32_t pid{};
    /// Written as 0.
    std::uint32_t spare2{};
    /// [count] Messages refused since the start.
    std::uint64_t refused{};
    /// [count] Inputs overtaken by newer ones since the start.
    std::uint64_t superseded{};
    /// Run time lost because the process was late, robot only. [ns]
    std::uint64_t slipped_ns{};
};
static_assert(sizeof(Health) == 48);
static_assert(std::is_trivially_copyable_v<Health> && std::is_standard_layout_v<Health>);
static_assert(offsetof(Health, progress) == 0);
static_assert(offsetof(Health, state) == 8);
static_assert(offsetof(Health, spare) == 10);
static_assert(offsetof(Health, reasons) == 12);
static_assert(offsetof(Health, pid) == 16);
static_assert(offsetof(Health, spare2) == 20);
static_assert(offsetof(Health, refused) == 24);
static_assert(offsetof(Health, superseded) == 32);
static_assert(offsetof(Health, slipped_ns) == 40);
static_assert(Health::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, Health::NAME);
    hash = fnv1a(hash, "progress");
    hash = fnv1a_number(hash, Schema<decltype(Health::progress)>::value);
    hash = fnv1a_number(hash, offsetof(Health, progress));
    hash = fnv1a(hash, "state");
    hash = fnv1a_number(hash, Schema<decltype(Health::state)>::value);
    hash = fnv1a_number(hash, offsetof(Health, state));
    hash = fnv1a(hash, "spare");
    hash = fnv1a_number(hash, Schema<decltype(Health::spare)>::value);
    hash = fnv1a_number(hash, offsetof(Health, spare));
    hash = fnv1a(hash, "reasons");
    hash = fnv1a_number(hash, Schema<decltype(Health::reasons)>::value);
    hash = fnv1a_number(hash, offsetof(Health, reasons));
    hash = fnv1a(hash, "pid");
    hash = fnv1a_number(hash, Schema<decltype(Health::pid)>::value);
    hash = fnv1a_number(hash, offsetof(Health, pid));
    hash = fnv1a(hash, "spare2");
    hash = fnv1a_number(hash, Schema<decltype(Health::spare2)>::value);
    hash = fnv1a_number(hash, offsetof(Health, spare2));
    hash = fnv1a(hash, "refused");
    hash = fnv1a_number(hash, Schema<decltype(Health::refused)>::value);
    hash = fnv1a_number(hash, offsetof(Health, refused));
    hash = fnv1a(hash, "superseded");
    hash = fnv1a_number(hash, Schema<decltype(Health::superseded)>::value);
    hash = fnv1a_number(hash, offsetof(Health, superseded));
    hash = fnv1a(hash, "slipped_ns");
    hash = fnv1a_number(hash, Schema<decltype(Health::slipped_ns)>::value);
    hash = fnv1a_number(hash, offsetof(Health, slipped_ns));
    return hash;
}());

/// Header and fixed fields of the topic's messages.
struct HealthEnvelope {
    static constexpr const char* NAME = "zeronav.health.v1";
    static constexpr std::uint64_t SCHEMA = 0x266f209a3c745475;
    /// The header.
    Header header{};
    /// The fixed fields.
    Health meta{};
};
static_assert(sizeof(HealthEnvelope) == 176);
static_assert(std::is_trivially_copyable_v<HealthEnvelope> && std::is_standard_layout_v<HealthEnvelope>);
static_assert(offsetof(HealthEnvelope, header) == 0);
static_assert(offsetof(HealthEnvelope, meta) == 128);
static_assert(HealthEnvelope::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, HealthEnvelope::NAME);
    hash = fnv1a(hash, "header");
    hash = fnv1a_number(hash, Schema<decltype(HealthEnvelope::header)>::value);
    hash = fnv1a_number(hash, offsetof(HealthEnvelope, header));
    hash = fnv1a(hash, "meta");
    hash = fnv1a_number(hash, Schema<decltype(HealthEnvelope::meta)>::value);
    hash = fnv1a_number(hash, offsetof(HealthEnvelope, meta));
    return hash;
}());

/// A self-contained record of one cycle. Sent without a header.
struct Span {
    static constexpr const char* NAME = "zeronav.Span.v3";
    static constexpr std::uint64_t SCHEMA = 0x9df02c0f69b58fcf;
    /// Code of the `Role`.
    std::uint16_t role{};
    /// Code of `SpanKind`.
    std::uint16_t kind{};
    /// [number] Epoch of the process.
    std::uint32_t epoch{};
    /// [tick] Tick that was answered.
    std::uint64_t tick{};
    /// [id] Inputs: id on `robot/odometry`, or the robot's own tick.
    std::uint64_t odometry{};
    /// [id] Inputs: id on `robot/scan`; from the robot: the scan it published.
    std::uint64_t scan{};
    /// [id] Inputs: revision of the map.
    std::uint64_t map{};
    /// [id] Inputs: id on `plan/path`.
    std::uint64_t path{};
    /// [id] Inputs: id of the request, or of the velocity command that the robot applied.
    std::uint64_t request{};
    /// [id] Inputs: id on `task/goal`.
    std::uint64_t goal{};
    /// [id] Id of the main message that was published; 0 = none.
    std::uint64_t output{};
    /// [ns] Moment of the data that came in: the scan's capture; for the robot its own.
    std::uint64_t capture_ns{};
    /// [ns] return from the wait.
    std::uint64_t woken_ns{};
    /// [ns] inputs taken in.
    std::uint64_t started_ns{};
    /// [ns] main message sent.
    std::uint64_t published_ns{};
    /// [count] Inputs that a newer one had overtaken, in this cycle.
    std::uint32_t superseded{};
    /// [count] Work done in units of the role: beams, expansions, rollouts.
    std::uint32_t work{};
    /// [number] FNV-1a of what the cycle published (headers without stamps, and payload); lockstep
    /// only.
    std::uint64_t hash{};
    /// [ns] between the wake and the end of the cycle in which the thread did not run: it was
    /// preempted, waited for a page, or slept for a delay put in on purpose.
    std::uint64_t off_processor_ns{};
    /// Robot only, real time: `CLOCK_MONOTONIC_RAW` at `capture_ns`, of a command that was applied
    /// at `started_ns`; 0 = none. [ns]
    std::uint64_t raw_ns{};
    /// [ns] Times of the stages of the role (`Stage::of`), one after the other from `started_ns`
    /// on and by the same clock; what is left until `published_ns` belongs to none. 0 = did not
    /// run, or was not timed (`stages` of `run/clock`).
    std::uint32_t stages_ns[4]{};
};
static_assert(sizeof(Span) == 152);
static_assert(std::is_trivially_copyable_v<Span> && std::is_standard_layout_v<Span>);
static_assert(offsetof(Span, role) == 0);
static_assert(offsetof(Span, kind) == 2);
static_assert(offsetof(Span, epoch) == 4);
static_assert(offsetof(Span, tick) == 8);
static_assert(offsetof(Span, odometry) == 16);
static_assert(offsetof(Span, scan) == 24);
static_assert(offsetof(Span, map) == 32);
static_assert(offsetof(Span, path) == 40);
static_assert(offsetof(Span, request) == 48);
static_assert(offsetof(Span, goal) == 56);
static_assert(offsetof(Span, output) == 64);
static_assert(offsetof(Span, capture_ns) == 72);
static_assert(offsetof(Span, woken_ns) == 80);
static_assert(offsetof(Span, started_ns) == 88);
static_assert(offsetof(Span, published_ns) == 96);
static_assert(offsetof(Span, superseded) == 104);
static_assert(offsetof(Span, work) == 108);
static_assert(offsetof(Span, hash) == 112);
static_assert(offsetof(Span, off_processor_ns) == 120);
static_assert(offsetof(Span, raw_ns) == 128);
static_assert(offsetof(Span, stages_ns) == 136);
static_assert(Span::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, Span::NAME);
    hash = fnv1a(hash, "role");
    hash = fnv1a_number(hash, Schema<decltype(Span::role)>::value);
    hash = fnv1a_number(hash, offsetof(Span, role));
    hash = fnv1a(hash, "kind");
    hash = fnv1a_number(hash, Schema<decltype(Span::kind)>::value);
    hash = fnv1a_number(hash, offsetof(Span, kind));
    hash = fnv1a(hash, "epoch");
    hash = fnv1a_number(hash, Schema<decltype(Span::epoch)>::value);
    hash = fnv1a_number(hash, offsetof(Span, epoch));
    hash = fnv1a(hash, "tick");
    hash = fnv1a_number(hash, Schema<decltype(Span::tick)>::value);
    hash = fnv1a_number(hash, offsetof(Span, tick));
    hash = fnv1a(hash, "odometry");
    hash = fnv1a_number(hash, Schema<decltype(Span::odometry)>::value);
    hash = fnv1a_number(hash, offsetof(Span, odometry));
    hash = fnv1a(hash, "scan");
    hash = fnv1a_number(hash, Schema<decltype(Span::scan)>::value);
    hash = fnv1a_number(hash, offsetof(Span, scan));
    hash = fnv1a(hash, "map");
    hash = fnv1a_number(hash, Schema<decltype(Span::map)>::value);
    hash = fnv1a_number(hash, offsetof(Span, map));
    hash = fnv1a(hash, "path");
    hash = fnv1a_number(hash, Schema<decltype(Span::path)>::value);
    hash = fnv1a_number(hash, offsetof(Span, path));
    hash = fnv1a(hash, "request");
    hash = fnv1a_number(hash, Schema<decltype(Span::request)>::value);
    hash = fnv1a_number(hash, offsetof(Span, request));
    hash = fnv1a(hash, "goal");
    hash = fnv1a_number(hash, Schema<decltype(Span::goal)>::value);
    hash = fnv1a_number(hash, offsetof(Span, goal));
    hash = fnv1a(hash, "output");
    hash = fnv1a_number(hash, Schema<decltype(Span::output)>::value);
    hash = fnv1a_number(hash, offsetof(Span, output));
    hash = fnv1a(hash, "capture_ns");
    hash = fnv1a_number(hash, Schema<decltype(Span::capture_ns)>::value);
    hash = fnv1a_number(hash, offsetof(Span, capture_ns));
    hash = fnv1a(hash, "woken_ns");
    hash = fnv1a_number(hash, Schema<decltype(Span::woken_ns)>::value);
    hash = fnv1a_number(hash, offsetof(Span, woken_ns));
    hash = fnv1a(hash, "started_ns");
    hash = fnv1a_number(hash, Schema<decltype(Span::started_ns)>::value);
    hash = fnv1a_number(hash, offsetof(Span, started_ns));
    hash = fnv1a(hash, "published_ns");
    hash = fnv1a_number(hash, Schema<decltype(Span::published_ns)>::value);
    hash = fnv1a_number(hash, offsetof(Span, published_ns));
    hash = fnv1a(hash, "superseded");
    hash = fnv1a_number(hash, Schema<decltype(Span::superseded)>::value);
    hash = fnv1a_number(hash, offsetof(Span, superseded));
    hash = fnv1a(hash, "work");
    hash = fnv1a_number(hash, Schema<decltype(Span::work)>::value);
    hash = fnv1a_number(hash, offsetof(Span, work));
    hash = fnv1a(hash, "hash");
    hash = fnv1a_number(hash, Schema<decltype(Span::hash)>::value);
    hash = fnv1a_number(hash, offsetof(Span, hash));
    hash = fnv1a(hash, "off_processor_ns");
    hash = fnv1a_number(hash, Schema<decltype(Span::off_processor_ns)>::value);
    hash = fnv1a_number(hash, offsetof(Span, off_processor_ns));
    hash = fnv1a(hash, "raw_ns");
    hash = fnv1a_number(hash, Schema<decltype(Span::raw_ns)>::value);
    hash = fnv1a_number(hash, offsetof(Span, raw_ns));
    hash = fnv1a(hash, "stages_ns");
    hash = fnv1a_number(hash, Schema<decltype(Span::stages_ns)>::value);
    hash = fnv1a_number(hash, offsetof(Span, stages_ns));
    return hash;
}());

/// Fixed fields of a message on a user's own topic; the slice holds its bytes.
struct UserMessage {
    static constexpr const char* NAME = "zeronav.UserMessage.v1";
    static constexpr std::uint64_t SCHEMA = 0x8b22ab13735b6140;
    /// [number] FNV-1a of the text of the form.
    std::uint64_t form{};
};
static_assert(sizeof(UserMessage) == 8);
static_assert(std::is_trivially_copyable_v<UserMessage> && std::is_standard_layout_v<UserMessage>);
static_assert(offsetof(UserMessage, form) == 0);
static_assert(UserMessage::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, UserMessage::NAME);
    hash = fnv1a(hash, "form");
    hash = fnv1a_number(hash, Schema<decltype(UserMessage::form)>::value);
    hash = fnv1a_number(hash, offsetof(UserMessage, form));
    return hash;
}());

/// Header and fixed fields of a message on a user's own topic.
struct UserEnvelope {
    static constexpr const char* NAME = "zeronav.user.v1";
    static constexpr std::uint64_t SCHEMA = 0x64a9cb430099747a;
    /// The header.
    Header header{};
    /// The fixed fields.
    UserMessage meta{};
};
static_assert(sizeof(UserEnvelope) == 136);
static_assert(std::is_trivially_copyable_v<UserEnvelope> && std::is_standard_layout_v<UserEnvelope>);
static_assert(offsetof(UserEnvelope, header) == 0);
static_assert(offsetof(UserEnvelope, meta) == 128);
static_assert(UserEnvelope::SCHEMA == [] {
    std::uint64_t hash = fnv1a(FNV_OFFSET, UserEnvelope::NAME);
    hash = fnv1a(hash, "header");
    hash = fnv1a_number(hash, Schema<decltype(UserEnvelope::header)>::value);
    hash = fnv1a_number(hash, offsetof(UserEnvelope, header));
    hash = fnv1a(hash, "meta");
    hash = fnv1a_number(hash, Schema<decltype(UserEnvelope::meta)>::value);
    hash = fnv1a_number(hash, offsetof(UserEnvelope, meta));
    return hash;
}());

/// Every topic: name, types, who writes it and whose doorbell a message rings.
namespace topics {

struct robot_description {
    using Envelope = RobotDescriptionEnvelope;
    using Item = Corner;
    static constexpr const char* NAME = "robot/description";
    static constexpr std::uint64_t SCHEMA = 0x4269f1a2e0ce4de2;
    static constexpr std::size_t NUMBER = 0;
    static constexpr std::size_t LEN_MAX = 32;
    static constexpr std::size_t BUFFER = 2;
    static constexpr std::size_t POOL = 59;
    static constexpr std::array<Role, 1> WRITERS{Role::robot};
    static constexpr std::array<Role, 4> RINGS{Role::mapping, Role::global_planner,
        Role::local_planner, Role::collision_guard};
    static constexpr std::array<Role, 0> RINGS_IN_LOCKSTEP{};
};

struct robot_scan {
    using Envelope = RobotScanEnvelope;
    using Item = float;
    static constexpr const char* NAME = "robot/scan";
    static constexpr std::uint64_t SCHEMA = 0x7caddf9ddb10ba5c;
    static constexpr std::size_t NUMBER = 1;
    static constexpr std::size_t LEN_MAX = 4096;
    static constexpr std::size_t BUFFER = 2;
    static constexpr std::size_t POOL = 58;
    static constexpr std::array<Role, 1> WRITERS{Role::robot};
    static constexpr std::array<Role, 2> RINGS{Role::mapping, Role::local_planner};
    static constexpr std::array<Role, 0> RINGS_IN_LOCKSTEP{};
};

struct robot_odometry {
    using Envelope = RobotOdometryEnvelope;
    using Item = std::uint8_t;
    static constexpr const char* NAME = "robot/odometry";
    static constexpr std::uint64_t SCHEMA = 0x539bfa04c81d517b;
    static constexpr std::size_t NUMBER = 2;
    static constexpr std::size_t LEN_MAX = 1;
    static constexpr std::size_t BUFFER = 32;
    static constexpr std::size_t POOL = 46;
    static constexpr std::array<Role, 1> WRITERS{Role::robot};
    static constexpr std::array<Role, 2> RINGS{Role::local_planner, Role::collision_guard};
    static constexpr std::array<Role, 2> RINGS_IN_LOCKSTEP{Role::mapping, Role::global_planner};
};

struct map_update {
    using Envelope = MapUpdateEnvelope;
    using Item = MapTile;
    static constexpr const char* NAME = "map/update";
    static constexpr std::uint64_t SCHEMA = 0xc6a1406d687e61c3;
    static constexpr std::size_t NUMBER = 3;
    static constexpr std::size_t LEN_MAX = 60;
    static constexpr std::size_t BUFFER = 32;
    static constexpr std::size_t POOL = 46;
    static constexpr std::array<Role, 1> WRITERS{Role::mapping};
    static constexpr std::array<Role, 2> RINGS{Role::global_planner, Role::local_planner};
    static constexpr std::array<Role, 0> RINGS_IN_LOCKSTEP{};
};

struct map_keyframe {
    using Envelope = MapKeyframeEnvelope;
    using Item = MapTile;
    static constexpr const char* NAME = "map/keyframe";
    static constexpr std::uint64_t SCHEMA = 0x1228f06e42e1b3f0;
    static constexpr std::size_t NUMBER = 4;
    static constexpr std::size_t LEN_MAX = 16384;
    static constexpr std::size_t BUFFER = 2;
    static constexpr std::size_t POOL = 4;
    static constexpr std::array<Role, 1> WRITERS{Role::mapping};
    static constexpr std::array<Role, 2> RINGS{Role::global_planner, Role::local_planner};
    static constexpr std::array<Role, 0> RINGS_IN_LOCKSTEP{};
};

struct map_obstacles {
    using Envelope = MapObstaclesEnvelope;
    using Item = Obstacle;
    static constexpr const char* NAME = "map/obstacles";
    static constexpr std::uint64_t SCHEMA = 0xea9d1f73e5827ded;
    static constexpr std::size_t NUMBER = 5;
    static constexpr std::size_t LEN_MAX = 128;
    static constexpr std::size_t BUFFER = 2;
    static constexpr std::size_t POOL = 58;
    static constexpr std::array<Role, 1> WRITERS{Role::mapping};
    static constexpr std::array<Role, 0> RINGS{};
    static constexpr std::array<Role, 0> RINGS_IN_LOCKSTEP{};
};

struct plan_path {
    using Envelope = PlanPathEnvelope;
    using Item = Waypoint;
    static constexpr const char* NAME = "plan/path";
    static constexpr std::uint64_t SCHEMA = 0x98746698aac9e113;
    static constexpr std::size_t NUMBER = 6;
    static constexpr std::size_t LEN_MAX = 2048;
    static constexpr std::size_t BUFFER = 2;
    static constexpr std::size_t POOL = 58;
    static constexpr std::array<Role, 1> WRITERS{Role::global_planner};
    static constexpr std::array<Role, 1> RINGS{Role::local_planner};
    static constexpr std::array<Role, 0> RINGS_IN_LOCKSTEP{};
};

struct plan_request {
    using Envelope = PlanRequestEnvelope;
    using Item = std::uint8_t;
    static constexpr const char* NAME = "plan/request";
    static constexpr std::uint64_t SCHEMA = 0x904f8c1a2cb8a816;
    static constexpr std::size_t NUMBER = 7;
    static constexpr std::size_t LEN_MAX = 1;
    static constexpr std::size_t BUFFER = 2;
    static constexpr std::size_t POOL = 58;
    static constexpr std::array<Role, 1> WRITERS{Role::local_planner};
    static constexpr std::array<Role, 1> RINGS{Role::global_planner};
    static constexpr std::array<Role, 0> RINGS_IN_LOCKSTEP{};
};

struct task_goal {
    using Envelope = TaskGoalEnvelope;
    using Item = Goal;
    static constexpr const char* NAME = "task/goal";
    static constexpr std::uint64_t SCHEMA = 0x91f13d6d71f9fd5b;
    static constexpr std::size_t NUMBER = 8;
    static constexpr std::size_t LEN_MAX = 64;
    static constexpr std::size_t BUFFER = 2;
    static constexpr std::size_t POOL = 59;
    static constexpr std::array<Role, 1> WRITERS{Role::launch};
    static constexpr std::array<Role, 2> RINGS{Role::global_planner, Role::local_planner};
    static constexpr std::array<Role, 0> RINGS_IN_LOCKSTEP{};
};

struct task_status {
    using Envelope = TaskStatusEnvelope;
    using Item = GoalEnd;
    static constexpr const char* NAME = "task/status";
    static constexpr std::uint64_t SCHEMA = 0x5c1beab4fcb50bb2;
    static constexpr std::size_t NUMBER = 9;
    static constexpr std::size_t LEN_MAX = 64;
    static constexpr std::size_t BUFFER = 2;
    static constexpr std::size_t POOL = 59;
    static constexpr std::array<Role, 1> WRITERS{Role::local_planner};
    static constexpr std::array<Role, 1> RINGS{Role::global_planner};
    static constexpr std::array<Role, 0> RINGS_IN_LOCKSTEP{};
};

struct task_pose {
    using Envelope = TaskPoseEnvelope;
    using Item = std::uint8_t;
    static constexpr const char* NAME = "task/pose";
    static constexpr std::uint64_t SCHEMA = 0xd5e6227b7f2b7155;
    static constexpr std::size_t NUMBER = 24;
    static constexpr std::size_t LEN_MAX = 1;
    static constexpr std::size_t BUFFER = 2;
    static constexpr std::size_t POOL = 59;
    static constexpr std::array<Role, 1> WRITERS{Role::launch};
    static constexpr std::array<Role, 1> RINGS{Role::mapping};
    static constexpr std::array<Role, 0> RINGS_IN_LOCKSTEP{};
};

struct task_zones {
    using Envelope = TaskZonesEnvelope;
    using Item = ZonePart;
    static constexpr const char* NAME = "task/zones";
    static constexpr std::uint64_t SCHEMA = 0x69d4f97669679555;
    static constexpr std::size_t NUMBER = 27;
    static constexpr std::size_t LEN_MAX = 512;
    static constexpr std::size_t BUFFER = 2;
    static constexpr std::size_t POOL = 59;
    static constexpr std::array<Role, 1> WRITERS{Role::launch};
    static constexpr std::array<Role, 3> RINGS{Role::mapping, Role::local_planner,
        Role::collision_guard};
    static constexpr std::array<Role, 0> RINGS_IN_LOCKSTEP{};
};

struct control_velocity_request {
    using Envelope = ControlVelocityRequestEnvelope;
    using Item = std::uint8_t;
    static constexpr const char* NAME = "control/velocity_request";
    static constexpr std::uint64_t SCHEMA = 0xbca40804cf7a583b;
    static constexpr std::size_t NUMBER = 10;
    static constexpr std::size_t LEN_MAX = 1;
    static constexpr std::size_t BUFFER = 2;
    static constexpr std::size_t POOL = 58;
    static constexpr std::array<Role, 1> WRITERS{Role::local_planner};
    static constexpr std::array<Role, 1> RINGS{Role::collision_guard};
    static constexpr std::array<Role, 0> RINGS_IN_LOCKSTEP{};
};

struct robot_velocity_command {
    using Envelope = RobotVelocityCommandEnvelope;
    using Item = std::uint8_t;
    static constexpr const char* NAME = "robot/velocity_command";
    static constexpr std::uint64_t SCHEMA = 0x00d63076348ff2bd;
    static constexpr std::size_t NUMBER = 11;
    static constexpr std::size_t LEN_MAX = 1;
    static constexpr std::size_t BUFFER = 2;
    static constexpr std::size_t POOL = 58;
    static constexpr std::array<Role, 1> WRITERS{Role::collision_guard};
    static constexpr std::array<Role, 1> RINGS{Role::robot};
    static constexpr std::array<Role, 0> RINGS_IN_LOCKSTEP{};
};

struct run_clock {
    using Envelope = RunClockEnvelope;
    using Item = std::uint8_t;
    static constexpr const char* NAME = "run/clock";
    static constexpr std::uint64_t SCHEMA = 0x2e21d988789afa53;
    static constexpr std::size_t NUMBER = 12;
    static constexpr std::size_t LEN_MAX = 1;
    static constexpr std::size_t BUFFER = 2;
    static constexpr std::size_t POOL = 59;
    static constexpr std::array<Role, 1> WRITERS{Role::launch};
    static constexpr std::array<Role, 5> RINGS{Role::robot, Role::mapping, Role::global_planner,
        Role::local_planner, Role::collision_guard};
    static constexpr std::array<Role, 0> RINGS_IN_LOCKSTEP{};
};

struct run_control {
    using Envelope = RunControlEnvelope;
    using Item = Seat;
    static constexpr const char* NAME = "run/control";
    static constexpr std::uint64_t SCHEMA = 0x0832878dcde34582;
    static constexpr std::size_t NUMBER = 13;
    static constexpr std::size_t LEN_MAX = 16;
    static constexpr std::size_t BUFFER = 2;
    static constexpr std::size_t POOL = 59;
    static constexpr std::array<Role, 1> WRITERS{Role::launch};
    static constexpr std::array<Role, 5> RINGS{Role::robot, Role::mapping, Role::global_planner,
        Role::local_planner, Role::collision_guard};
    static constexpr std::array<Role, 0> RINGS_IN_LOCKSTEP{};
};

struct sim_ground_truth {
    using Envelope = SimGroundTruthEnvelope;
    using Item = TruthObstacle;
    static constexpr const char* NAME = "sim/ground_truth";
    static constexpr std::uint64_t SCHEMA = 0x1e53b96e61365535;
    static constexpr std::size_t NUMBER = 14;
    static constexpr std::size_t LEN_MAX = 256;
    static constexpr std::size_t BUFFER = 2;
    static constexpr std::size_t POOL = 58;
    static constexpr std::array<Role, 1> WRITERS{Role::robot};
    static constexpr std::array<Role, 0> RINGS{};
    static constexpr std::array<Role, 0> RINGS_IN_LOCKSTEP{};
};

struct sim_foresight {
    using Envelope = SimForesightEnvelope;
    using Item = Foreseen;
    static constexpr const char* NAME = "sim/foresight";
    static constexpr std::uint64_t SCHEMA = 0x0c5d3692f4580ad9;
    static constexpr std::size_t NUMBER = 26;
    static constexpr std::size_t LEN_MAX = 128;
    static constexpr std::size_t BUFFER = 2;
    static constexpr std::size_t POOL = 58;
    static constexpr std::array<Role, 1> WRITERS{Role::robot};
    static constexpr std::array<Role, 0> RINGS{};
    static constexpr std::array<Role, 0> RINGS_IN_LOCKSTEP{};
};

struct sim_placement {
    using Envelope = SimPlacementEnvelope;
    using Item = Placement;
    static constexpr const char* NAME = "sim/placement";
    static constexpr std::uint64_t SCHEMA = 0x7b6be6082eb79558;
    static constexpr std::size_t NUMBER = 22;
    static constexpr std::size_t LEN_MAX = 256;
    static constexpr std::size_t BUFFER = 2;
    static constexpr std::size_t POOL = 58;
    static constexpr std::array<Role, 1> WRITERS{Role::launch};
    static constexpr std::array<Role, 1> RINGS{Role::robot};
    static constexpr std::array<Role, 0> RINGS_IN_LOCKSTEP{};
};

struct debug_rollouts {
    using Envelope = DebugRolloutsEnvelope;
    using Item = Rollout;
    static constexpr const char* NAME = "debug/rollouts";
    static constexpr std::uint64_t SCHEMA = 0x9c632191d0f72eac;
    static constexpr std::size_t NUMBER = 25;
    static constexpr std::size_t LEN_MAX = 64;
    static constexpr std::size_t BUFFER = 2;
    static constexpr std::size_t POOL = 58;
    static constexpr std::array<Role, 1> WRITERS{Role::local_planner};
    static constexpr std::array<Role, 0> RINGS{};
    static constexpr std::array<Role, 0> RINGS_IN_LOCKSTEP{};
};

struct health_robot {
    using Envelope = HealthEnvelope;
    using Item = std::uint8_t;
    static constexpr const char* NAME = "health/robot";
    static constexpr std::uint64_t SCHEMA = 0x3479845f530eb3c6;
    static constexpr std::size_t NUMBER = 16;
    static constexpr std::size_t LEN_MAX = 1;
    static constexpr std::size_t BUFFER = 2;
    static constexpr std::size_t POOL = 58;
    static constexpr std::array<Role, 1> WRITERS{Role::robot};
    static constexpr std::array<Role, 0> RINGS{};
    static constexpr std::array<Role, 0> RINGS_IN_LOCKSTEP{};
};

struct health_mapping {
    using Envelope = HealthEnvelope;
    using Item = std::uint8_t;
    static constexpr const char* NAME = "health/mapping";
    static constexpr std::uint64_t SCHEMA = 0x714d8d90f31678b8;
    static constexpr std::size_t NUMBER = 17;
    static constexpr std::size_t LEN_MAX = 1;
    static constexpr std::size_t BUFFER = 2;
    static constexpr std::size_t POOL = 58;
    static constexpr std::array<Role, 1> WRITERS{Role::mapping};
    static constexpr std::array<Role, 0> RINGS{};
    static constexpr std::array<Role, 0> RINGS_IN_LOCKSTEP{};
};

struct health_global_planner {
    using Envelope = HealthEnvelope;
    using Item = std::uint8_t;
    static constexpr const char* NAME = "health/global_planner";
    static constexpr std::uint64_t SCHEMA = 0x807e7f5586b4ce42;
    static constexpr std::size_t NUMBER = 18;
    static constexpr std::size_t LEN_MAX = 1;
    static constexpr std::size_t BUFFER = 2;
    static constexpr std::size_t POOL = 58;
    static constexpr std::array<Role, 1> WRITERS{Role::global_planner};
    static constexpr std::array<Role, 0> RINGS{};
    static constexpr std::array<Role, 0> RINGS_IN_LOCKSTEP{};
};

struct health_local_planner {
    using Envelope = HealthEnvelope;
    using Item = std::uint8_t;
    static constexpr const char* NAME = "health/local_planner";
    static constexpr std::uint64_t SCHEMA = 0x4f81d396ef28bf9e;
    static constexpr std::size_t NUMBER = 19;
    static constexpr std::size_t LEN_MAX = 1;
    static constexpr std::size_t BUFFER = 2;
    static constexpr std::size_t POOL = 58;
    static constexpr std::array<Role, 1> WRITERS{Role::local_planner};
    static constexpr std::array<Role, 0> RINGS{};
    static constexpr std::array<Role, 0> RINGS_IN_LOCKSTEP{};
};

struct health_collision_guard {
    using Envelope = HealthEnvelope;
    using Item = std::uint8_t;
    static constexpr const char* NAME = "health/collision_guard";
    static constexpr std::uint64_t SCHEMA = 0x708ae803c9a76d58;
    static constexpr std::size_t NUMBER = 20;
    static constexpr std::size_t LEN_MAX = 1;
    static constexpr std::size_t BUFFER = 2;
    static constexpr std::size_t POOL = 58;
    static constexpr std::array<Role, 1> WRITERS{Role::collision_guard};
    static constexpr std::array<Role, 0> RINGS{};
    static constexpr std::array<Role, 0> RINGS_IN_LOCKSTEP{};
};

struct run_spans {
    using Envelope = void;
    using Item = Span;
    static constexpr const char* NAME = "run/spans";
    static constexpr std::uint64_t SCHEMA = 0x9070cc0c5473c554;
    static constexpr std::size_t NUMBER = 21;
    static constexpr std::size_t LEN_MAX = 1;
    static constexpr std::size_t BUFFER = 1024;
    static constexpr std::size_t POOL = 1038;
    static constexpr std::array<Role, 5> WRITERS{Role::robot, Role::mapping, Role::global_planner,
        Role::local_planner, Role::collision_guard};
    static constexpr std::array<Role, 0> RINGS{};
    static constexpr std::array<Role, 1> RINGS_IN_LOCKSTEP{Role::robot};
};

/// All of them.
using All = std::tuple<robot_description, robot_scan, robot_odometry, map_update, map_keyframe,
    map_obstacles, plan_path, plan_request, task_goal, task_status, task_pose, task_zones,
    control_velocity_request, robot_velocity_command, run_clock, run_control, sim_ground_truth,
    sim_foresight, sim_placement, debug_rollouts, health_robot, health_mapping,
    health_global_planner, health_local_planner, health_collision_guard, run_spans>;

}  // namespace topics

}  // namespace zeronav
