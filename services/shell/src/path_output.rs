//! What the global planner's seat says. A path is news once: until another takes its place its
//! message is repeated, with the map that it was checked with, under the id that brought it first.

use crate::error::StartError;
use crate::peer::Peer;
use crate::service::Shell;
use crate::turn::Turn;
use crate::writer::{Draft, Writer};
use zeronav_msgs::path::{Path, PathCause, PathStatus, Waypoint};
use zeronav_msgs::topics::PlanPath;

/// Writes `plan/path`.
#[derive(Debug)]
pub struct PathOutput {
    writer: Writer<PlanPath>,
    path: Path,
    waypoints: Vec<Waypoint>,
    /// What is held was not sent yet.
    fresh: bool,
}

impl PathOutput {
    /// Opens the topic for paths of up to `len` waypoints by the planner with this key. Until
    /// something else is said, there is no goal.
    ///
    /// # Errors
    /// As [`Peer::writer`].
    pub fn open(peer: &Peer, planner: &str, len: usize) -> Result<Self, StartError> {
        Ok(Self {
            writer: peer.writer(len)?,
            path: Path {
                planner: Path::planner_bytes(planner),
                ..Path::default()
            },
            waypoints: Vec::with_capacity(len),
            fresh: true,
        })
    }

    /// Goal that is led to, or failed at; 0 = none.
    #[must_use]
    pub fn goal(&self) -> u64 {
        self.path.goal
    }

    /// The waypoints; none without a path.
    #[must_use]
    pub fn waypoints(&self) -> &[Waypoint] {
        &self.waypoints
    }

    /// From the next answer on this is said: the outcome for `goal` on the map of that answer, for
    /// the goal's sake when it is another than before and otherwise because of an obstacle. A
    /// failure that goes on is no news. Costs are lengths.
    pub fn say(&mut self, status: PathStatus, goal: u64, waypoints: &[Waypoint]) {
        let same_goal = goal == self.path.goal;
        if same_goal && status.code() == self.path.status && status != PathStatus::Found {
            return;
        }
        let cause = match status {
            PathStatus::NoGoal => PathCause::None,
            _ if same_goal => PathCause::Obstacle,
            _ => PathCause::Goal,
        };
        self.waypoints.clear();
        self.waypoints.extend_from_slice(waypoints);
        let legs = waypoints.iter().zip(waypoints.iter().skip(1));
        let length_m = legs
            .map(|(from, to)| (to.x_m - from.x_m).hypot(to.y_m - from.y_m))
            .sum();
        self.path = Path {
            planner: self.path.planner,
            status: status.code(),
            cause: cause.code(),
            n_waypoints: u32::try_from(waypoints.len()).unwrap_or(u32::MAX),
            length_m,
            cost: length_m,
            goal,
            ..Path::default()
        };
        self.fresh = true;
    }

    /// Answers with what is said.
    pub fn answer(&mut self, shell: &mut Shell, turn: Turn, draft: &Draft) {
        if self.path.geometry == 0 {
            self.path.searched_map = draft.parents.map;
        }
        if self.fresh {
            self.path.geometry = self.writer.next_id().0;
        }
        let sent = shell.answer(
            turn.kind,
            draft,
            &mut self.writer,
            self.path,
            &self.waypoints,
        );
        // Without memory for it, the next message brings it.
        self.fresh &= sent.is_none();
    }
}
