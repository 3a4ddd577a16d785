//! Poses for parry.

use parry2d::math::Pose2;
use zeronav_msgs::Pose;

/// `pose` in the type of parry.
#[must_use]
pub fn parry_pose(pose: &Pose) -> Pose2 {
    pose.isometry().into()
}
