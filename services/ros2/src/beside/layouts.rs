//! Nav2's actions as the distributions lay them out. Fields are in the order of their definitions.

use super::config::Distro;
use ros2_client::Message;
use serde::{Deserialize, Serialize};
use zeronav_casts::Cast;
use zeronav_msgs::time::{nanoseconds, seconds};
use zeronav_ros_messages::messages::{Header, PoseStamped, Time};
use zeronav_ros_messages::view::time;

/// Which action.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// `NavigateToPose`.
    ToPose,
    /// `NavigateThroughPoses`.
    ThroughPoses,
    /// `FollowWaypoints`.
    Waypoints,
}

/// A goal message.
pub(super) trait GoalMessage: Message + Clone + 'static {
    /// Where to, in order.
    fn poses(self) -> Vec<PoseStamped>;

    /// Why it cannot be carried out though its poses can.
    fn problem(&self) -> Option<&'static str> {
        None
    }
}

macro_rules! goals {
    ($($(#[$doc:meta])* $name:ident { $($field:ident : $type:ty),* } $poses:expr;)*) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone, Serialize, Deserialize)]
        #[allow(missing_docs, reason = "named by the definitions of Nav2")]
        pub(super) struct $name { $(pub(super) $field: $type),* }

        impl Message for $name {}

        impl GoalMessage for $name {
            fn poses(self) -> Vec<PoseStamped> {
                let poses: fn(Self) -> Vec<PoseStamped> = $poses;
                poses(self)
            }
        }
    )*};
}

goals! {
    /// Of `NavigateToPose`.
    ToPoseGoal { pose: PoseStamped, behavior_tree: String } |it| vec![it.pose];
    /// Of `NavigateThroughPoses` up to Jazzy.
    PosesGoal { poses: Vec<PoseStamped>, behavior_tree: String } |it| it.poses;
    /// Of `NavigateThroughPoses` from Kilted on: `nav_msgs/Goals`.
    GoalsGoal { header: Header, goals: Vec<PoseStamped>, behavior_tree: String } |it| it.goals;
    /// Of `FollowWaypoints` in Humble.
    WaypointsGoal { poses: Vec<PoseStamped> } |it| it.poses;
}

/// Of `FollowWaypoints` after Humble.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[allow(missing_docs, reason = "named by the definitions of Nav2")]
pub(super) struct LoopedWaypointsGoal {
    pub(super) number_of_loops: u32,
    pub(super) goal_index: u32,
    pub(super) poses: Vec<PoseStamped>,
}

impl Message for LoopedWaypointsGoal {}

impl GoalMessage for LoopedWaypointsGoal {
    fn poses(self) -> Vec<PoseStamped> {
        let first = usize::try_from(self.goal_index).unwrap_or(usize::MAX);
        self.poses.into_iter().skip(first).collect()
    }

    fn problem(&self) -> Option<&'static str> {
        (self.number_of_loops > 0).then_some("loops are not supported: number_of_loops must be 0")
    }
}

/// `nav2_msgs/WaypointStatus`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(
    missing_docs,
    clippy::struct_field_names,
    reason = "named by the definition of Nav2"
)]
pub(super) struct WaypointStatus {
    pub(super) waypoint_status: u8,
    pub(super) waypoint_index: u32,
    pub(super) waypoint_pose: PoseStamped,
    pub(super) error_code: u16,
    pub(super) error_msg: String,
}

/// A waypoint that was reached, and one that was not, in [`WaypointStatus`].
const COMPLETED: u8 = 1;
const PENDING: u8 = 0;
const FAILED: u8 = 3;

/// A result, of whatever action and distribution.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub(super) enum ResultMessage {
    /// `std_msgs/Empty`, which has a byte.
    Empty(u8),
    /// `error_code` and `error_msg`.
    Coded(u16, String),
    /// The same, and what became of each pose.
    WithStatuses(u16, String, Vec<WaypointStatus>),
    /// `missed_waypoints` of Humble.
    Missed(Vec<i32>),
    /// `missed_waypoints` of Jazzy (index, goal, code), `error_code` and `error_msg`.
    MissedWaypoints(Vec<(u32, PoseStamped, u16)>, u16, String),
    /// `missed_waypoints` from Kilted on, `error_code` and `error_msg`.
    MissedStatuses(Vec<WaypointStatus>, u16, String),
}

impl Message for ResultMessage {}

/// Feedback of both `Navigate` actions up to where they differ.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "named by the definitions of Nav2")]
pub(super) struct Navigated {
    pub(super) current_pose: PoseStamped,
    pub(super) navigation_time: Time,
    pub(super) estimated_time_remaining: Time,
    pub(super) number_of_recoveries: i16,
    pub(super) distance_remaining: f32,
}

/// `position_tracking_error` and `heading_tracking_error`, which this stack does not tell.
type TrackingErrors = (f32, f32);

/// Feedback, of whatever action and distribution.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub(super) enum FeedbackMessage {
    /// `NavigateToPose` up to Kilted.
    ToPose(Navigated),
    /// The same from Lyrical on.
    ToPoseTracked(Navigated, TrackingErrors),
    /// `NavigateThroughPoses` up to Jazzy.
    Through(Navigated, i16),
    /// The same in Kilted.
    ThroughStatuses(Navigated, i16, Vec<WaypointStatus>),
    /// The same from Lyrical on.
    ThroughTracked(Navigated, TrackingErrors, i16, Vec<WaypointStatus>),
    /// `FollowWaypoints`.
    Waypoint(u32),
}

impl Message for FeedbackMessage {}

/// How far the robot has come.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Progress {
    /// Where it is.
    pub(super) pose: PoseStamped,
    /// Since the goal became active. [s]
    pub(super) elapsed_s: f64,
    /// Until it is there; `None` while that is not known. [s]
    pub(super) remaining_s: Option<f64>,
    /// Way left. [m]
    pub(super) remaining_m: f64,
    /// Manoeuvres and waits of the recovery.
    pub(super) recoveries: u32,
    /// Goals that are not reached yet.
    pub(super) goals_left: usize,
}

/// How a goal has ended: Nav2's error code, 0 = none, and why.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct End {
    /// Error code.
    pub(super) code: u16,
    /// In words.
    pub(super) why: String,
    /// Goals that were not reached.
    pub(super) goals_left: usize,
}

fn statuses(poses: &[PoseStamped], left: usize, is_over: bool, end: &End) -> Vec<WaypointStatus> {
    let reached = poses.len().saturating_sub(left);
    let all = (0_u32..).zip(poses).enumerate();
    all.map(|(at, (waypoint_index, pose))| {
        let is_reached = at < reached;
        WaypointStatus {
            waypoint_status: match (is_reached, is_over) {
                (true, _) => COMPLETED,
                (false, true) => FAILED,
                (false, false) => PENDING,
            },
            waypoint_index,
            waypoint_pose: pose.clone(),
            error_code: if is_reached { 0 } else { end.code },
            error_msg: if is_reached {
                String::new()
            } else {
                end.why.clone()
            },
        }
    })
    .collect()
}

/// The result of a goal to `poses`.
#[must_use]
pub(super) fn result(
    distro: Distro,
    kind: Kind,
    poses: &[PoseStamped],
    end: &End,
) -> ResultMessage {
    let (code, why) = (end.code, end.why.clone());
    let all = statuses(poses, end.goals_left, true, end);
    let missed = || all.iter().filter(|it| it.waypoint_status != COMPLETED);
    match (distro, kind) {
        (Distro::Humble, Kind::Waypoints) => {
            let at = |it: &WaypointStatus| i32::try_from(it.waypoint_index).unwrap_or(i32::MAX);
            ResultMessage::Missed(missed().map(at).collect())
        }
        (Distro::Humble, _) => ResultMessage::Empty(0),
        (Distro::Jazzy, Kind::Waypoints) => {
            let of =
                |it: &WaypointStatus| (it.waypoint_index, it.waypoint_pose.clone(), it.error_code);
            ResultMessage::MissedWaypoints(missed().map(of).collect(), code, why)
        }
        (_, Kind::Waypoints) => {
            ResultMessage::MissedStatuses(missed().cloned().collect(), code, why)
        }
        (Distro::Kilted | Distro::Lyrical, Kind::ThroughPoses) => {
            ResultMessage::WithStatuses(code, why, all)
        }
        _ => ResultMessage::Coded(code, why),
    }
}

/// Feedback on the way to `poses`.
#[must_use]
pub(super) fn feedback(
    distro: Distro,
    kind: Kind,
    poses: &[PoseStamped],
    progress: &Progress,
) -> FeedbackMessage {
    let duration = |s: f64| time(nanoseconds(s.max(0.0)));
    let navigated = Navigated {
        current_pose: progress.pose.clone(),
        navigation_time: duration(progress.elapsed_s),
        estimated_time_remaining: duration(progress.remaining_s.unwrap_or(seconds(0))),
        number_of_recoveries: i16::try_from(progress.recoveries).unwrap_or(i16::MAX),
        distance_remaining: progress.remaining_m.to_f32(),
    };
    let left = i16::try_from(progress.goals_left).unwrap_or(i16::MAX);
    let all = || statuses(poses, progress.goals_left, false, &End::default());
    match (kind, distro) {
        (Kind::ToPose, Distro::Lyrical) => FeedbackMessage::ToPoseTracked(navigated, (0.0, 0.0)),
        (Kind::ToPose, _) => FeedbackMessage::ToPose(navigated),
        (Kind::ThroughPoses, Distro::Humble | Distro::Jazzy) => {
            FeedbackMessage::Through(navigated, left)
        }
        (Kind::ThroughPoses, Distro::Kilted) => {
            FeedbackMessage::ThroughStatuses(navigated, left, all())
        }
        (Kind::ThroughPoses, Distro::Lyrical) => {
            FeedbackMessage::ThroughTracked(navigated, (0.0, 0.0), left, all())
        }
        (Kind::Waypoints, _) => {
            let reached = poses.len().saturating_sub(progress.goals_left);
            FeedbackMessage::Waypoint(u32::try_from(reached).unwrap_or(u32::MAX))
        }
    }
}

#[cfg(test)]
mod tests {
    //! Golden bytes are those of rclpy with Fast DDS for the same messages, padding set to 0.

    use super::*;
    use zeronav_msgs::pose::Pose;
    use zeronav_ros_messages::{cdr, view};

    fn pose() -> PoseStamped {
        view::pose_in_map(7_500_000_000, &Pose::new(1.5, -2.0, 0.0))
    }

    fn progress() -> Progress {
        Progress {
            pose: pose(),
            elapsed_s: 3.25,
            remaining_s: Some(4.0),
            remaining_m: 5.5,
            recoveries: 2,
            goals_left: 1,
        }
    }

    fn end() -> End {
        End {
            code: 208,
            why: "no way".to_owned(),
            goals_left: 1,
        }
    }

    fn hex<T: Serialize>(message: &T) -> String {
        let bytes = cdr(message).expect("CDR");
        let bytes: Vec<String> = bytes[4..]
            .iter()
            .map(|byte| format!("{byte:02x}"))
            .collect();
        bytes.concat()
    }

    #[test]
    fn results_have_the_bytes_of_ros() {
        let two = [pose(), pose()];
        let of = |distro, kind| hex(&result(distro, kind, &two, &end()));
        let golden = [
            (
                Distro::Jazzy,
                Kind::ToPose,
                "d0000000070000006e6f2077617900",
            ),
            (
                Distro::Jazzy,
                Kind::ThroughPoses,
                "d0000000070000006e6f2077617900",
            ),
            (
                Distro::Jazzy,
                Kind::Waypoints,
                "0100000001000000070000000065cd1d040000006d617000000000000000f83f00000000000000c00000000000000000\
                 000000000000000000000000000000000000000000000000000000000000f03fd000d000070000006e6f2077617900",
            ),
            (
                Distro::Kilted,
                Kind::ToPose,
                "d0000000070000006e6f2077617900",
            ),
            (
                Distro::Kilted,
                Kind::ThroughPoses,
                "d0000000070000006e6f207761790000020000000100000000000000070000000065cd1d040000006d61700000000000\
                 000000000000f83f00000000000000c00000000000000000000000000000000000000000000000000000000000000000\
                 000000000000f03f00000000010000000003000001000000070000000065cd1d040000006d617000000000000000f83f\
                 00000000000000c00000000000000000000000000000000000000000000000000000000000000000000000000000f03f\
                 d0000000070000006e6f2077617900",
            ),
            (
                Distro::Kilted,
                Kind::Waypoints,
                "010000000300000001000000070000000065cd1d040000006d61700000000000000000000000f83f00000000000000c0\
                 0000000000000000000000000000000000000000000000000000000000000000000000000000f03fd000000007000000\
                 6e6f207761790000d0000000070000006e6f2077617900",
            ),
        ];
        for (distro, kind, expected) in golden {
            assert_eq!(of(distro, kind), expected, "{distro:?} {kind:?}");
        }
        // Humble: a byte where nothing is, and the numbers of the poses that were missed.
        assert_eq!(of(Distro::Humble, Kind::ToPose), "00");
        assert_eq!(of(Distro::Humble, Kind::Waypoints), "0100000001000000");
    }

    #[test]
    fn feedback_has_the_bytes_of_ros() {
        let two = [pose(), pose()];
        let of = |distro, kind| hex(&feedback(distro, kind, &two, &progress()));
        let golden = [
            (
                Distro::Jazzy,
                Kind::ToPose,
                "070000000065cd1d040000006d617000000000000000f83f00000000000000c000000000000000000000000000000000\
                 00000000000000000000000000000000000000000000f03f0300000080b2e60e0400000000000000020000000000b040",
            ),
            (
                Distro::Jazzy,
                Kind::ThroughPoses,
                "070000000065cd1d040000006d617000000000000000f83f00000000000000c000000000000000000000000000000000\
                 00000000000000000000000000000000000000000000f03f0300000080b2e60e0400000000000000020000000000b040\
                 0100",
            ),
            (
                Distro::Kilted,
                Kind::ToPose,
                "070000000065cd1d040000006d617000000000000000f83f00000000000000c000000000000000000000000000000000\
                 00000000000000000000000000000000000000000000f03f0300000080b2e60e0400000000000000020000000000b040",
            ),
            (
                Distro::Kilted,
                Kind::ThroughPoses,
                "070000000065cd1d040000006d617000000000000000f83f00000000000000c000000000000000000000000000000000\
                 00000000000000000000000000000000000000000000f03f0300000080b2e60e0400000000000000020000000000b040\
                 01000000020000000100000000000000070000000065cd1d040000006d617000000000000000f83f00000000000000c0\
                 0000000000000000000000000000000000000000000000000000000000000000000000000000f03f0000000001000000\
                 0000000001000000070000000065cd1d040000006d617000000000000000f83f00000000000000c00000000000000000\
                 000000000000000000000000000000000000000000000000000000000000f03f000000000100000000",
            ),
        ];
        for (distro, kind, expected) in golden {
            assert_eq!(of(distro, kind), expected, "{distro:?} {kind:?}");
        }
        // Lyrical: two more numbers behind the distance.
        let kilted = of(Distro::Kilted, Kind::ToPose);
        assert_eq!(
            of(Distro::Lyrical, Kind::ToPose),
            kilted + "0000000000000000"
        );
        assert_eq!(of(Distro::Jazzy, Kind::Waypoints), "01000000");
    }
}
