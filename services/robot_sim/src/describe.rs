//! The robot's numbers as others shall know them, and as its motors obey them.

use crate::drive::DriveLimits;
use crate::lidar::Lidar;
use crate::scan_schedule::ScanSchedule;
use zeronav_msgs::description::Description;
use zeronav_msgs::time::nanoseconds;
use zeronav_robot_description::RobotSpec;
use zeronav_world::Footprint;

/// The message `robot/description` without its corners, of a robot that looks at its commands every
/// `tick_ns`.
#[must_use]
pub fn describe(
    robot: &RobotSpec,
    footprint: &Footprint,
    lidar: &Lidar,
    schedule: &ScanSchedule,
    tick_ns: u64,
) -> Description {
    let scan = lidar.header();
    // A command takes effect at the beginning of a tick.
    let delay_ticks = nanoseconds(robot.actuation_delay_s).div_ceil(tick_ns);
    Description {
        inscribed_radius_m: footprint.inscribed_radius_m(),
        circumscribed_radius_m: footprint.circumscribed_radius_m(),
        v_mps_max: robot.v_mps_max,
        v_mps_min: robot.v_mps_min,
        w_radps_max: robot.w_radps_max,
        a_mps2_max: robot.a_mps2_max,
        brake_mps2: robot.reliable_brake_mps2(),
        alpha_radps2_max: robot.alpha_radps2_max,
        base_from_laser: lidar.base_from_laser(),
        angle_min_rad: f64::from(scan.angle_min_rad),
        angle_increment_rad: f64::from(scan.angle_increment_rad),
        range_m_min: robot.lidar.range_m_min,
        range_m_max: robot.lidar.range_m_max,
        scan_period_ns: schedule.period_ns(),
        actuation_delay_ns: delay_ticks * tick_ns,
        n_beams: scan.n_beams,
        n_corners: u32::try_from(footprint.corners().len()).unwrap_or(u32::MAX),
    }
}

/// Limits under a command: slowing down is never worse than the braking that others rely on.
#[must_use]
pub fn limits_of(robot: &RobotSpec) -> DriveLimits {
    DriveLimits {
        v_mps_max: robot.v_mps_max,
        v_mps_min: robot.v_mps_min,
        w_radps_max: robot.w_radps_max,
        speed_up_mps2: robot.a_mps2_max,
        slow_down_mps2: robot.a_mps2_max.max(robot.reliable_brake_mps2()),
        alpha_radps2: robot.alpha_radps2_max,
    }
}
