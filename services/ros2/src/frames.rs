//! Transforms, as far as a robot in the plane needs them.

use std::collections::BTreeMap;
use zeronav_msgs::pose::Pose;
use zeronav_ros_messages::messages::TfMessage;
use zeronav_ros_messages::received::{plain_frame, planar_pose};

/// Most frames that are held.
const FRAMES_MAX: usize = 1_000;

/// Most transforms between two frames.
const DEEPEST: usize = 16;

/// Names of the robot's own frame besides the one that is configured.
pub const BASES: [&str; 2] = ["base_link", "base_footprint"];

/// Each frame by its name without name space: its parent, and where it lies there.
#[derive(Debug, Clone, Default)]
pub struct Frames {
    parents: BTreeMap<String, (String, Pose)>,
    /// Transforms that were rejected: not finite, or too many.
    rejected: u64,
}

impl Frames {
    /// Takes in transforms.
    pub fn take(&mut self, message: &TfMessage) {
        for it in &message.transforms {
            let pose = planar_pose(&it.translation, &it.rotation);
            let (parent, child) = (
                plain_frame(&it.header.frame_id),
                plain_frame(&it.child_frame_id),
            );
            let is_room = self.parents.len() < FRAMES_MAX || self.parents.contains_key(child);
            match pose {
                Some(pose) if is_room && !child.is_empty() && child != parent => {
                    let parent = parent.to_owned();
                    self.parents.insert(child.to_owned(), (parent, pose));
                }
                _ => self.rejected += 1,
            }
        }
    }

    /// Transforms that were rejected.
    #[must_use]
    pub fn rejected(&self) -> u64 {
        self.rejected
    }

    /// Where `frame` lies in the robot's own frame; `None` when no transforms lead there. [m, m, rad]
    #[must_use]
    pub fn base_from(&self, base: &str, frame: &str) -> Option<Pose> {
        let base = plain_frame(base);
        let (mut at, mut pose) = (plain_frame(frame), Pose::default());
        for _ in 0..DEEPEST {
            if at == base || BASES.contains(&at) {
                return Some(pose);
            }
            let (parent, parent_from_at) = self.parents.get(at)?;
            pose = parent_from_at.then(&pose);
            at = parent;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_ros_messages::view;

    fn transform(parent: &'static str, child: &'static str, pose: Pose) -> TfMessage {
        view::transform(0, parent, child, &pose)
    }

    #[test]
    fn a_laser_on_a_mast_is_found_through_all_transforms() {
        let mut frames = Frames::default();
        let quarter = core::f64::consts::FRAC_PI_2;
        frames.take(&transform(
            "base_link",
            "mast",
            Pose::new(0.2, 0.0, quarter),
        ));
        assert_eq!(frames.base_from("base_link", "r1/laser"), None);
        frames.take(&transform("r1/mast", "r1/laser", Pose::new(0.1, 0.0, 0.0)));
        let pose = frames.base_from("base_link", "laser").expect("a way");
        assert!(pose.distance_m(&Pose::new(0.2, 0.1, 0.0)) < 1e-12);
        assert!((pose.yaw_rad - quarter).abs() < 1e-12);
        assert_eq!(
            frames.base_from("base_link", "base_link"),
            Some(Pose::default())
        );
    }

    #[test]
    fn circles_nan_and_floods_end() {
        let mut frames = Frames::default();
        frames.take(&transform("a", "b", Pose::default()));
        frames.take(&transform("b", "a", Pose::default()));
        frames.take(&transform("c", "c", Pose::default()));
        frames.take(&transform("base_link", "d", Pose::new(f64::NAN, 0.0, 0.0)));
        assert_eq!(frames.base_from("base_link", "a"), None);
        assert_eq!(frames.base_from("base_link", "d"), None);
        assert_eq!(frames.rejected(), 2);
        let mut message = transform("base_link", "e", Pose::default());
        for n in 0..2 * FRAMES_MAX {
            message.transforms[0].child_frame_id = format!("f{n}").into();
            frames.take(&message);
        }
        assert_eq!(frames.parents.len(), FRAMES_MAX);
    }
}
