//! `robot/description` of a robot whose lidar says itself what it is.

use zeronav_msgs::description::{Corner, Description};
use zeronav_msgs::pose::Pose;
use zeronav_msgs::scan::Scan;
use zeronav_msgs::time::nanoseconds;
use zeronav_robot_description::RobotSpec;
use zeronav_shell::StartError;

/// The outline as the contract has it: inscribed and circumscribed radius [m], and corners.
pub(super) fn footprint(robot: &RobotSpec) -> Result<([f64; 2], Vec<Corner>), StartError> {
    let failed = |it: &dyn core::fmt::Display| StartError::config("robot", it.to_string());
    let footprint = robot.footprint().map_err(|it| failed(&it))?;
    let corners = footprint.corners().iter();
    let corners = corners
        .map(|it| Corner {
            x_m: it.x,
            y_m: it.y,
        })
        .collect();
    let radii_m = [
        footprint.inscribed_radius_m(),
        footprint.circumscribed_radius_m(),
    ];
    Ok((radii_m, corners))
}

/// What the robot is, before its lidar has said anything: as the scenario describes it.
pub(super) fn described(robot: &RobotSpec) -> Result<(Description, Vec<Corner>), StartError> {
    let ([inscribed_radius_m, circumscribed_radius_m], corners) = footprint(robot)?;
    let lidar = &robot.lidar;
    let [x, y, yaw] = lidar.pose;
    let description = Description {
        inscribed_radius_m,
        circumscribed_radius_m,
        v_mps_max: robot.v_mps_max,
        v_mps_min: robot.v_mps_min,
        w_radps_max: robot.w_radps_max,
        a_mps2_max: robot.a_mps2_max,
        brake_mps2: robot.reliable_brake_mps2(),
        alpha_radps2_max: robot.alpha_radps2_max,
        base_from_laser: Pose::new(x, y, yaw),
        angle_min_rad: -0.5 * lidar.fov_rad,
        angle_increment_rad: lidar.fov_rad / f64::from(lidar.n_beams),
        range_m_min: lidar.range_m_min,
        range_m_max: lidar.range_m_max,
        scan_period_ns: nanoseconds(lidar.rate_hz.recip()),
        actuation_delay_ns: nanoseconds(robot.actuation_delay_s),
        n_beams: lidar.n_beams,
        n_corners: u32::try_from(corners.len()).unwrap_or(u32::MAX),
    };
    description
        .check(&corners)
        .map_err(|why| StartError::config("robot", why.to_string()))?;
    Ok((description, corners))
}

/// The same with what the lidar says of itself.
pub(super) fn with_lidar(before: Description, scan: &Scan, base_from_laser: Pose) -> Description {
    Description {
        base_from_laser,
        angle_min_rad: f64::from(scan.angle_min_rad),
        angle_increment_rad: f64::from(scan.angle_increment_rad),
        range_m_min: f64::from(scan.range_m_min),
        range_m_max: f64::from(scan.range_m_max),
        n_beams: scan.n_beams,
        ..before
    }
}
