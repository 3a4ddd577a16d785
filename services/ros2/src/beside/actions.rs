//! An action of Nav2 on the side of the server: requests in, statuses, feedback and results out.

use super::config::Distro;
use super::layouts::{self, End, FeedbackMessage, GoalMessage, Kind, Progress, ResultMessage};
use ros2_client::action::{
    ActionServerQosPolicies, GetResultResponse, GoalId, GoalInfo, GoalStatusEnum, SendGoalResponse,
};
use ros2_client::action_msgs::{
    CancelGoalResponse, CancelGoalResponseEnum, GoalStatus, GoalStatusArray,
};
use ros2_client::builtin_interfaces::Time;
use ros2_client::dds::ActionServer;
use ros2_client::qos::{Durability, History, QosProfile};
use ros2_client::{ActionTypeName, Name, Node, RmwRequestId, ServiceMapping};
use serde::Deserialize;
use zeronav_ros_messages::messages::PoseStamped;

/// Goals that are remembered, with those that have ended.
const GOALS_MAX: usize = 32;

/// Requests that are taken in at a look.
const TURN: usize = 16;

/// Requests for results that wait.
const WAITING_MAX: usize = 64;

/// A goal that somebody asks for.
#[derive(Debug, Clone)]
pub(super) struct Asked {
    /// Its id.
    pub(super) id: GoalId,
    /// Where to.
    pub(super) poses: Vec<PoseStamped>,
    /// Why the message cannot be carried out.
    pub(super) problem: Option<&'static str>,
    request: RmwRequestId,
}

/// An action, whatever its messages are.
pub(super) trait Action {
    /// The next goal that somebody asks for.
    fn next_goal(&mut self) -> Option<Asked>;
    /// Says whether it is accepted.
    fn answer(&mut self, asked: &Asked, accepted: bool);
    /// Goals of `active` that somebody wants cancelled.
    fn next_cancelled(&mut self, active: Option<GoalId>) -> Option<GoalId>;
    /// Says how far the robot has come.
    fn feedback(&mut self, id: GoalId, poses: &[PoseStamped], progress: &Progress);
    /// A goal has ended.
    fn end(&mut self, id: GoalId, status: GoalStatusEnum, poses: &[PoseStamped], end: &End);
    /// Answers those who ask for results.
    fn serve(&mut self);
}

struct Held {
    info: GoalInfo,
    status: GoalStatusEnum,
    result: Option<ResultMessage>,
}

struct Offered<G: GoalMessage> {
    server: ActionServer<G, ResultMessage, FeedbackMessage>,
    distro: Distro,
    kind: Kind,
    held: Vec<Held>,
    waiting: Vec<(RmwRequestId, GoalId)>,
}

/// A request to cancel, which the library keeps to itself.
#[derive(Deserialize)]
struct Cancel {
    goal_info: CancelInfo,
}

#[derive(Deserialize)]
struct CancelInfo {
    goal_id: CancelId,
    stamp: CancelStamp,
}

#[derive(Deserialize)]
struct CancelId {
    uuid: [u8; 16],
}

#[derive(Deserialize)]
struct CancelStamp {
    sec: i32,
    nanosec: u32,
}

/// Opens an action.
///
/// # Errors
/// One line that names it.
pub(super) fn open(
    node: &mut Node,
    space: &str,
    distro: Distro,
    kind: Kind,
) -> Result<Box<dyn Action>, String> {
    use layouts::{GoalsGoal, LoopedWaypointsGoal, PosesGoal, ToPoseGoal, WaypointsGoal};
    Ok(match (kind, distro) {
        (Kind::ToPose, _) => server::<ToPoseGoal>(node, space, distro, kind)?,
        (Kind::ThroughPoses, Distro::Humble | Distro::Jazzy) => {
            server::<PosesGoal>(node, space, distro, kind)?
        }
        (Kind::ThroughPoses, _) => server::<GoalsGoal>(node, space, distro, kind)?,
        (Kind::Waypoints, Distro::Humble) => server::<WaypointsGoal>(node, space, distro, kind)?,
        (Kind::Waypoints, _) => server::<LoopedWaypointsGoal>(node, space, distro, kind)?,
    })
}

fn server<G: GoalMessage>(
    node: &mut Node,
    space: &str,
    distro: Distro,
    kind: Kind,
) -> Result<Box<dyn Action>, String> {
    let (name, kind_name) = match kind {
        Kind::ToPose => ("navigate_to_pose", "NavigateToPose"),
        Kind::ThroughPoses => ("navigate_through_poses", "NavigateThroughPoses"),
        Kind::Waypoints => ("follow_waypoints", "FollowWaypoints"),
    };
    let failed = |why: &dyn core::fmt::Debug| format!("offering the action {name}: {why:?}");
    let service = QosProfile::publisher_default().history(History::KeepLast { depth: 10 });
    let status = QosProfile::publisher_default()
        .durability(Durability::TransientLocal)
        .history(History::KeepLast { depth: 1 });
    let qos = ActionServerQosPolicies {
        goal_service: service.clone(),
        result_service: service.clone(),
        cancel_service: service.clone(),
        feedback_publisher: service,
        status_publisher: status,
    };
    let server = node.create_action_server(
        ServiceMapping::Enhanced,
        &Name::parse(&format!("{space}/{name}")).map_err(|why| failed(&why))?,
        &ActionTypeName::new("nav2_msgs", kind_name),
        qos,
    );
    Ok(Box::new(Offered::<G> {
        server: server.map_err(|why| failed(&why))?,
        distro,
        kind,
        held: Vec::new(),
        waiting: Vec::new(),
    }))
}

impl<G: GoalMessage> Offered<G> {
    fn held(&mut self, id: GoalId) -> Option<&mut Held> {
        self.held.iter_mut().find(|held| held.info.goal_id == id)
    }

    fn set(&mut self, id: GoalId, status: GoalStatusEnum) {
        if let Some(held) = self.held(id) {
            held.status = status;
        }
        let status_list = self.held.iter().map(|held| GoalStatus {
            goal_info: held.info.clone(),
            status: held.status,
        });
        let statuses = GoalStatusArray {
            status_list: status_list.collect(),
        };
        let _ = self.server.send_goal_statuses(statuses);
    }
}

/// True of a goal that has not ended.
fn goes_on(status: GoalStatusEnum) -> bool {
    use GoalStatusEnum::{Accepted, Canceling, Executing};
    matches!(status, Accepted | Executing | Canceling)
}

impl<G: GoalMessage> Action for Offered<G> {
    fn next_goal(&mut self) -> Option<Asked> {
        for _ in 0..TURN {
            match self.server.receive_goal() {
                Ok(Some((request, message))) => {
                    return Some(Asked {
                        id: message.goal_id,
                        problem: message.goal.problem(),
                        poses: message.goal.poses(),
                        request,
                    });
                }
                Ok(None) => return None,
                Err(why) => tracing::warn!(?why, "rejected: a goal that cannot be read"),
            }
        }
        None
    }

    fn answer(&mut self, asked: &Asked, accepted: bool) {
        let stamp = Time::now();
        // A goal of this id is there: the client has sent it again.
        let accepted = accepted && self.held(asked.id).is_none();
        let response = SendGoalResponse { accepted, stamp };
        if let Err(why) = self.server.send_goal_response(asked.request, response) {
            tracing::warn!(?why, "a goal could not be answered");
        }
        if !accepted {
            return;
        }
        if self.held.len() == GOALS_MAX
            && let Some(ended) = self.held.iter().position(|held| !goes_on(held.status))
        {
            self.held.remove(ended);
        }
        let goal_id = asked.id;
        self.held.push(Held {
            info: GoalInfo { goal_id, stamp },
            status: GoalStatusEnum::Executing,
            result: None,
        });
        self.set(goal_id, GoalStatusEnum::Executing);
    }

    fn next_cancelled(&mut self, active: Option<GoalId>) -> Option<GoalId> {
        for _ in 0..TURN {
            let (request, message) = match self.server.receive_cancel_request() {
                Ok(Some(received)) => received,
                Ok(None) => return None,
                Err(_) => continue,
            };
            let cancel = serde_json::to_value(message).and_then(serde_json::from_value::<Cancel>);
            let Ok(Cancel { goal_info: wanted }) = cancel else {
                continue;
            };
            let of_all = wanted.goal_id.uuid == [0; 16];
            let before_ns =
                i64::from(wanted.stamp.sec) * 1_000_000_000 + i64::from(wanted.stamp.nanosec);
            let is_wanted = |held: &&Held| {
                let is_it = held.info.goal_id.uuid.as_bytes() == &wanted.goal_id.uuid;
                let is_before = before_ns > 0 && held.info.stamp.to_nanos() <= before_ns;
                is_it || (of_all && before_ns == 0) || is_before
            };
            let known = self.held.iter().find(is_wanted);
            let found = (self.held.iter())
                .filter(is_wanted)
                .find(|held| goes_on(held.status) && active == Some(held.info.goal_id));
            let response = CancelGoalResponse {
                return_code: match (found, known) {
                    (Some(_), _) => CancelGoalResponseEnum::None,
                    (None, Some(_)) => CancelGoalResponseEnum::GoalTerminated,
                    (None, None) => CancelGoalResponseEnum::UnknownGoal,
                },
                goals_canceling: found.map(|held| held.info.clone()).into_iter().collect(),
            };
            let found = found.map(|held| held.info.goal_id);
            let _ = self.server.send_cancel_response(request, response);
            if let Some(id) = found {
                self.set(id, GoalStatusEnum::Canceling);
                return Some(id);
            }
        }
        None
    }

    fn feedback(&mut self, id: GoalId, poses: &[PoseStamped], progress: &Progress) {
        let message = layouts::feedback(self.distro, self.kind, poses, progress);
        let _ = self.server.send_feedback(id, message);
    }

    fn end(&mut self, id: GoalId, status: GoalStatusEnum, poses: &[PoseStamped], end: &End) {
        let result = layouts::result(self.distro, self.kind, poses, end);
        if let Some(held) = self.held(id) {
            held.result = Some(result);
        }
        self.set(id, status);
        self.serve();
    }

    fn serve(&mut self) {
        for _ in 0..TURN {
            match self.server.receive_result_request() {
                Ok(Some((request, wanted))) => self.waiting.push((request, wanted.goal_id)),
                Ok(None) => break,
                Err(_) => {}
            }
        }
        let surplus = self.waiting.len().saturating_sub(WAITING_MAX);
        self.waiting.drain(..surplus);
        let waiting = core::mem::take(&mut self.waiting);
        for (request, id) in waiting {
            let held = self.held.iter().find(|held| held.info.goal_id == id);
            let known = held.map(|held| (held.status, held.result.clone()));
            let (status, result) = known.unwrap_or_else(|| {
                let empty = layouts::result(self.distro, self.kind, &[], &End::default());
                (GoalStatusEnum::Unknown, Some(empty))
            });
            let Some(result) = result else {
                self.waiting.push((request, id));
                continue;
            };
            let response = GetResultResponse { status, result };
            let _ = self.server.send_result(request, response);
        }
    }
}
