//! Messages of the contract as messages of ROS 2. Frames as in REP-105, signs as in REP-103.

use super::messages as ros;
use super::topics::frame;
use zeronav_casts::Cast;
use zeronav_msgs::command::VelocityCommand;
use zeronav_msgs::description::Description;
use zeronav_msgs::grid::{CellRect, GridGeometry};
use zeronav_msgs::health::{Health, HealthState, reason_labels};
use zeronav_msgs::map::{
    COST_FREE, COST_INSCRIBED, COST_LETHAL, COST_UNKNOWN, FLAG_UNKNOWN, MapCell,
};
use zeronav_msgs::obstacles::Obstacle;
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::path::Waypoint;
use zeronav_msgs::pose::Pose;
use zeronav_msgs::role::Role;
use zeronav_msgs::rollouts::Rollout;
use zeronav_msgs::scan::Scan;
use zeronav_msgs::time::seconds;

/// An occupied cell of an occupancy grid.
pub const OCCUPIED: i8 = 100;
/// An unknown cell of an occupancy grid.
pub const UNKNOWN: i8 = -1;

/// Height of the cylinder that stands for a tracked obstacle. [m]
const OBSTACLE_HEIGHT_M: f64 = 1.0;

/// Number of a 32-bit float in `sensor_msgs/PointField`.
const FLOAT32: u8 = 7;

/// `ns` since 1970, or of run time.
#[must_use]
pub fn time(ns: u64) -> ros::Time {
    ros::Time {
        sec: i32::try_from(ns / 1_000_000_000).unwrap_or(i32::MAX),
        nanosec: u32::try_from(ns % 1_000_000_000).unwrap_or(0),
    }
}

/// A header of the moment `ns`.
#[must_use]
pub fn header(ns: u64, frame_id: &'static str) -> ros::Header {
    ros::Header {
        stamp: time(ns),
        frame_id: frame_id.into(),
    }
}

/// A yaw as a rotation.
#[must_use]
pub fn rotation(yaw_rad: f64) -> ros::Quaternion {
    let (sin, cos) = (yaw_rad / 2.0).sin_cos();
    ros::Quaternion {
        x: 0.0,
        y: 0.0,
        z: sin,
        w: cos,
    }
}

fn point(x: f64, y: f64) -> ros::Vector3 {
    ros::Vector3 { x, y, z: 0.0 }
}

/// A pose in the plane.
#[must_use]
pub fn pose(pose: &Pose) -> ros::Pose {
    ros::Pose {
        position: point(pose.x_m, pose.y_m),
        orientation: rotation(pose.yaw_rad),
    }
}

/// Where `child` is in `parent`, at the moment `ns`.
#[must_use]
pub fn transform(
    ns: u64,
    parent: &'static str,
    child: &'static str,
    parent_from_child: &Pose,
) -> ros::TfMessage {
    let it = pose(parent_from_child);
    ros::TfMessage {
        transforms: vec![ros::TransformStamped {
            header: header(ns, parent),
            child_frame_id: child.into(),
            translation: it.position,
            rotation: it.orientation,
        }],
    }
}

fn twist(v_mps: f64, w_radps: f64) -> ros::Twist {
    ros::Twist {
        linear: point(v_mps, 0.0),
        angular: ros::Vector3 {
            x: 0.0,
            y: 0.0,
            z: w_radps,
        },
    }
}

/// A scan whose last beam was captured at `ns`: the stamp is that of the first one.
#[must_use]
pub fn scan(
    ns: u64,
    scan: &Scan,
    ranges: &[f32],
    description: Option<&Description>,
) -> ros::LaserScan {
    let steps = ranges.len().saturating_sub(1).to_f32();
    let turn_ns = zeronav_msgs::time::nanoseconds(f64::from(scan.time_increment_s * steps));
    ros::LaserScan {
        header: header(ns.saturating_sub(turn_ns), frame::LASER),
        angle_min: scan.angle_min_rad,
        angle_max: scan.angle_min_rad + steps * scan.angle_increment_rad,
        angle_increment: scan.angle_increment_rad,
        time_increment: scan.time_increment_s,
        scan_time: description.map_or(0.0, |it| seconds(it.scan_period_ns).to_f32()),
        range_min: scan.range_m_min,
        range_max: scan.range_m_max,
        ranges: ranges.to_vec(),
        intensities: Vec::new(),
    }
}

/// Points in the plane, z = 0.
#[must_use]
pub fn cloud(
    ns: u64,
    frame_id: &'static str,
    points_m: impl Iterator<Item = [f64; 2]>,
) -> ros::PointCloud2 {
    const STEP: u32 = 12;
    let mut data = Vec::new();
    for [x, y] in points_m {
        for along in [x.to_f32(), y.to_f32(), 0.0] {
            data.extend_from_slice(&along.to_le_bytes());
        }
    }
    let width = u32::try_from(data.len()).unwrap_or(0) / STEP;
    let fields = [("x", 0), ("y", 4), ("z", 8)];
    ros::PointCloud2 {
        header: header(ns, frame_id),
        height: 1,
        width,
        fields: fields
            .map(|(name, offset)| ros::PointField {
                name: name.into(),
                offset,
                datatype: FLOAT32,
                count: 1,
            })
            .into(),
        is_bigendian: false,
        point_step: STEP,
        row_step: width * STEP,
        data,
        is_dense: true,
    }
}

/// The hits of a scan in the lidar's frame.
#[must_use]
pub fn hits(ns: u64, scan: &Scan, ranges: &[f32]) -> ros::PointCloud2 {
    let hits = ranges.iter().enumerate();
    let hits = hits.filter(|(_, range)| scan.is_hit(**range));
    let points_m = hits.map(|(beam, range)| {
        let (sin, cos) = scan.angle_of(beam).sin_cos();
        [f64::from(*range) * cos, f64::from(*range) * sin]
    });
    cloud(ns, frame::LASER, points_m)
}

/// Odometry. What a robot in the plane does not have has the variance 0.
#[must_use]
pub fn odometry(ns: u64, odometry: &Odometry) -> ros::Odometry {
    let mut covariance = ros::Covariance::default();
    let [x, y, yaw] = odometry.variance;
    (covariance[0][0], covariance[1][1], covariance[5][5]) = (x, y, yaw);
    ros::Odometry {
        header: header(ns, frame::ODOM),
        child_frame_id: frame::BASE.into(),
        pose: ros::PoseWithCovariance {
            pose: pose(&odometry.pose),
            covariance,
        },
        twist: ros::TwistWithCovariance {
            twist: twist(odometry.v_mps, odometry.w_radps),
            covariance: ros::Covariance::default(),
        },
    }
}

/// What the wheels are told.
#[must_use]
pub fn command(ns: u64, command: &VelocityCommand) -> ros::TwistStamped {
    ros::TwistStamped {
        header: header(ns, frame::BASE),
        twist: twist(command.v_mps, command.w_radps),
    }
}

/// A pose in the map.
#[must_use]
pub fn pose_in_map(ns: u64, map_from_base: &Pose) -> ros::PoseStamped {
    ros::PoseStamped {
        header: header(ns, frame::MAP),
        pose: pose(map_from_base),
    }
}

/// A path, empty when there is none.
#[must_use]
pub fn path(ns: u64, poses: impl Iterator<Item = Pose>) -> ros::Path {
    ros::Path {
        header: header(ns, frame::MAP),
        poses: poses.map(|it| pose_in_map(ns, &it)).collect(),
    }
}

/// The waypoints of a path.
pub fn waypoints(waypoints: &[Waypoint]) -> impl Iterator<Item = Pose> + '_ {
    let poses = waypoints.iter();
    poses.map(|it| Pose::new(it.x_m, it.y_m, f64::from(it.yaw_rad)))
}

/// The points of a rollout, each with the direction to the next one.
pub fn rollout(rollout: &Rollout) -> impl Iterator<Item = Pose> + '_ {
    let mut points: Vec<[f64; 2]> = rollout.points_m().map(|it| it.map(f64::from)).collect();
    if let [.., before, last] = points[..] {
        // The last one goes on as it came.
        points.push([2.0 * last[0] - before[0], 2.0 * last[1] - before[1]]);
    }
    let n = usize::from(rollout.n_points);
    (0..n.min(points.len())).map(move |at| {
        let [x, y] = points[at];
        let next = points.get(at + 1).copied().unwrap_or([x, y]);
        Pose::new(x, y, (next[1] - y).atan2(next[0] - x))
    })
}

/// What a cell is in an occupancy grid, which knows no cost: occupied, unknown, or free.
#[must_use]
pub fn occupancy(cell: MapCell) -> i8 {
    if cell.cost == COST_LETHAL {
        OCCUPIED
    } else if cell.cost == COST_UNKNOWN || cell.flags & FLAG_UNKNOWN != 0 {
        UNKNOWN
    } else {
        0
    }
}

/// A cell as costmaps of Nav2 are published: 100 is an obstacle, 99 is so close to one that the robot's centre cannot
/// be there, -1 is unknown; what lies between falls with the distance from obstacles.
#[must_use]
pub fn cost(cell: MapCell) -> i8 {
    match (occupancy(cell), cell.cost) {
        (0, COST_INSCRIBED) => 99,
        (0, COST_FREE) => 0,
        (0, between) => i8::try_from(1 + 97 * (u32::from(between) - 1) / 251).unwrap_or(98),
        (other, _) => other,
    }
}

/// A whole map.
#[must_use]
pub fn map(ns: u64, geometry: &GridGeometry, cells: &[i8]) -> ros::OccupancyGrid {
    ros::OccupancyGrid {
        header: header(ns, frame::MAP),
        info: ros::MapMetaData {
            map_load_time: time(ns),
            resolution: geometry.resolution_m.to_f32(),
            width: geometry.width,
            height: geometry.height,
            origin: pose(&Pose::new(geometry.origin_x_m, geometry.origin_y_m, 0.0)),
        },
        data: cells.to_vec(),
    }
}

/// The cells of `rect`, which lies on the map.
#[must_use]
pub fn map_update(
    ns: u64,
    geometry: &GridGeometry,
    cells: &[i8],
    rect: &CellRect,
) -> ros::OccupancyGridUpdate {
    let size = |from: i32, to: i32| u32::try_from(to - from).unwrap_or(0);
    let (width, height) = (size(rect.min.x, rect.max.x), size(rect.min.y, rect.max.y));
    let mut data = Vec::with_capacity(width as usize * height as usize);
    for y in rect.min.y..rect.max.y {
        let row = geometry.index_of(zeronav_msgs::Cell::new(rect.min.x, y));
        let row = row.and_then(|from| cells.get(from..from + width as usize));
        data.extend_from_slice(row.unwrap_or_default());
    }
    ros::OccupancyGridUpdate {
        header: header(ns, frame::MAP),
        x: rect.min.x,
        y: rect.min.y,
        width,
        height,
        data,
    }
}

fn marker(ns: u64, action: i32) -> ros::Marker {
    ros::Marker {
        header: header(ns, frame::MAP),
        ns: "tracks".into(),
        id: 0,
        kind: 3, // CYLINDER
        action,
        pose: pose(&Pose::default()),
        scale: ros::Vector3::default(),
        color: ros::ColorRgba::default(),
        lifetime: ros::Duration::default(),
        frame_locked: false,
        points: Vec::new(),
        colors: Vec::new(),
        texture_resource: "".into(),
        texture: ros::CompressedImage::default(),
        uv_coordinates: Vec::new(),
        text: String::new(),
        mesh_resource: "".into(),
        mesh_file: ros::MeshFile::default(),
        mesh_use_embedded_materials: false,
    }
}

/// Tracked obstacles: first all markers of the message before are deleted, then each obstacle is a
/// cylinder in the direction of its motion, orange while it is seen and grey while it is predicted.
#[must_use]
pub fn obstacles(ns: u64, obstacles: &[Obstacle]) -> ros::MarkerArray {
    const DELETE_ALL: i32 = 3;
    let cylinders = obstacles.iter().map(|obstacle| {
        let yaw_rad = obstacle.vy_mps.atan2(obstacle.vx_mps);
        let mut it = marker(ns, 0);
        // A marker's number has 32 bits.
        it.id = i32::try_from(obstacle.track & 0x7fff_ffff).unwrap_or(0);
        it.pose = pose(&Pose::new(obstacle.x_m, obstacle.y_m, yaw_rad));
        it.pose.position.z = OBSTACLE_HEIGHT_M / 2.0;
        it.scale = ros::Vector3 {
            x: 2.0 * obstacle.radius_m,
            y: 2.0 * obstacle.radius_m,
            z: OBSTACLE_HEIGHT_M,
        };
        let [r, g, b] = if obstacle.is_guess() {
            [0.5, 0.5, 0.5]
        } else {
            [1.0, 0.5, 0.0]
        };
        it.color = ros::ColorRgba { r, g, b, a: 0.7 };
        it.text = format!(
            "track {}: {:.2} m/s",
            obstacle.track,
            obstacle.vx_mps.hypot(obstacle.vy_mps)
        );
        it
    });
    ros::MarkerArray {
        markers: core::iter::once(marker(ns, DELETE_ALL))
            .chain(cylinders)
            .collect(),
    }
}

/// How a service is.
#[must_use]
pub fn diagnostic(role: Role, health: &Health) -> ros::DiagnosticStatus {
    let state = health.state();
    let reasons = reason_labels(health.reasons).join(", ");
    let word = state.map_or("unknown", HealthState::label);
    ros::DiagnosticStatus {
        // OK or WARN.
        level: u8::from(state != Some(HealthState::Ready)),
        name: format!("zeronav: {role}"),
        message: if reasons.is_empty() {
            word.to_owned()
        } else {
            format!("{word}: {reasons}")
        },
        hardware_id: "".into(),
        values: vec![
            ros::KeyValue {
                key: "pid".into(),
                value: health.pid.to_string(),
            },
            ros::KeyValue {
                key: "rejected".into(),
                value: health.refused.to_string(),
            },
            ros::KeyValue {
                key: "superseded".into(),
                value: health.superseded.to_string(),
            },
        ],
    }
}
