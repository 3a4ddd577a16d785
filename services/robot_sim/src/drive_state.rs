//! State of the drive: pose and velocity.

use zeronav_motion::Twist;
use zeronav_msgs::Pose;

/// Pose and velocity of the robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveState {
    /// `map_from_base`.
    pub pose: Pose,
    /// Velocity in `base`.
    pub twist: Twist,
}
