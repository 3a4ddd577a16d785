//! What a successor of mapping is told of where the robot is: a new process takes odometry for the truth.

use super::session::Session;
use zeronav_msgs::Pose;
use zeronav_msgs::certainty::PoseCertainty;
use zeronav_msgs::role::Role;
use zeronav_msgs::task::PoseEstimate;
use zeronav_supervise::stack::Stack;

impl Session<'_> {
    /// When mapping has ended since there were `restarts_before`, tells its successor where odometry had drifted by then,
    /// and how far that was known.
    pub(super) fn hand_pose_on(&mut self, stack: &mut Stack, restarts_before: usize) {
        let restarts = self.restarter.records().iter().skip(restarts_before);
        let mut of_mapping = restarts.filter(|it| it.service == Role::Mapping.label());
        if of_mapping.next().is_none() {
            return;
        }
        let known = (self.collector.located)
            .map(|(tick, map_from_odom)| (tick, map_from_odom, self.collector.certainty));
        let Some(estimate) = handed_on(known, self.given_pose) else {
            return;
        };
        let estimate = PoseEstimate {
            from_tick: self.collector.robot_tick(),
            ..estimate
        };
        if !stack.estimate_pose(estimate) {
            tracing::warn!("no memory to tell mapping where the robot is");
        }
    }
}

/// What to tell of a robot that was `known` to be there by the newest map, of this tick; `None` where it is what a new process
/// takes for granted. A pose `given` by hand that no map rests on yet is newer than that.
fn handed_on(
    known: Option<(u64, Pose, PoseCertainty)>,
    given: Option<PoseEstimate>,
) -> Option<PoseEstimate> {
    let is_newer = |given: &PoseEstimate| known.is_none_or(|(tick, ..)| given.from_tick > tick);
    if let Some(given) = given.filter(is_newer) {
        return Some(given);
    }
    let (_, map_from_odom, certainty) = known?;
    let is_granted = certainty.is_confirmed() && map_from_odom == Pose::default();
    (!is_granted).then(|| PoseEstimate {
        map_from_base: map_from_odom,
        certainty: certainty.code(),
        ..PoseEstimate::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const DRIFTED: Pose = Pose::new(0.3, -0.2, 0.1);

    /// A successor of a robot that was lost does not take it to be somewhere, wherever that is.
    #[test]
    fn a_successor_knows_as_much_as_the_map_before_it() {
        for certainty in PoseCertainty::ALL {
            for map_from_odom in [DRIFTED, Pose::default()] {
                let told = handed_on(Some((7, map_from_odom, *certainty)), None);
                if certainty.is_confirmed() && map_from_odom == Pose::default() {
                    assert_eq!(told, None, "it takes odometry for the truth anyway");
                } else {
                    let told = told.expect("a pose");
                    assert_eq!(told.map_from_base, map_from_odom);
                    assert_eq!(told.certainty(), Some(*certainty));
                }
            }
        }
        assert_eq!(handed_on(None, None), None);
    }

    #[test]
    fn a_pose_that_no_map_rests_on_yet_is_told_again() {
        let given = PoseEstimate {
            map_from_base: Pose::new(4.0, 2.0, 1.0),
            from_tick: 8,
            certainty: PoseCertainty::Unconfirmed.code(),
            ..PoseEstimate::default()
        };
        let known = |tick| Some((tick, DRIFTED, PoseCertainty::Confirmed));
        assert_eq!(handed_on(None, Some(given)), Some(given));
        assert_eq!(handed_on(known(7), Some(given)), Some(given));
        let told = handed_on(known(8), Some(given)).expect("a pose");
        assert_eq!(told.map_from_base, DRIFTED);
        assert_eq!(told.certainty(), Some(PoseCertainty::Confirmed));
    }
}
