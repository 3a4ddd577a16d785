//! What the global planner reads, and the situation that it makes.

use zeronav_global_planner::{Request, Situation, Target};
use zeronav_msgs::CellRect;
use zeronav_msgs::header::Parents;
use zeronav_msgs::health::REASON_MAP;
use zeronav_msgs::pose::Pose;
use zeronav_msgs::request::RequestReason;
use zeronav_msgs::topics::PlanRequests;
use zeronav_shell::{
    CurrentGoal, Latest, MapInput, OdometryReader, Peer, Shell, StartError, Trigger,
};

/// The readers of the seat.
pub(crate) struct Readings {
    odometry: OdometryReader,
    pub(crate) map: MapInput,
    request: Latest<PlanRequests>,
    pub(crate) goal: CurrentGoal,
    /// Rectangles written since the last situation.
    pub(crate) changed: Vec<CellRect>,
}

impl Readings {
    /// Opens the topics.
    ///
    /// # Errors
    /// As [`Peer::latest`].
    pub(crate) fn open(peer: &Peer, blocks_below_mps: f64) -> Result<Self, StartError> {
        Ok(Self {
            odometry: OdometryReader::open(peer)?,
            map: MapInput::with_obstacles(peer)?.slower_than(blocks_below_mps),
            request: peer.latest()?,
            goal: CurrentGoal::open(peer)?,
            changed: Vec::new(),
        })
    }

    /// Takes in what has come; true when it asks for another answer in real time.
    pub(crate) fn poll(&mut self, shell: &Shell) -> bool {
        self.odometry.poll(shell.roster());
        let mapped = self.map.poll(shell);
        self.changed.extend_from_slice(self.map.changed());
        let requested = self.request.poll(shell.roster());
        let other_goal = self.goal.poll(shell.roster());
        mapped || requested || other_goal
    }

    /// Where the robot is on the map; `None` before the first odometry.
    pub(crate) fn map_from_base(&self) -> Option<Pose> {
        let newest = self.odometry.newest()?;
        Some(self.map.map_from_base(&newest.odometry.pose))
    }

    fn target(&self) -> Option<Target> {
        let goal = self.goal.goal()?;
        Some(Target {
            task: self.goal.task().0,
            goal: goal.id,
            pose: goal.pose,
            tolerance_m: goal.tolerance_m,
        })
    }

    /// The newest request, and the path that it is about.
    fn request(&self, geometry: u64) -> Option<Request> {
        let request = self.request.get()?;
        let about_this = geometry != 0 && request.header.parents.path >= geometry;
        Some(Request {
            id: request.header.id,
            geometry: if about_this { geometry } else { 0 },
            reason: request.meta.reason().unwrap_or(RequestReason::None),
        })
    }

    /// What the replanner sees; `geometry` names the path that requests are about.
    pub(crate) fn situation(&self, robot: Pose, geometry: u64) -> Situation<'_> {
        Situation {
            robot,
            map: self.map.view(),
            revision: self.map.revision().0,
            changed: &self.changed,
            target: self.target(),
            request: self.request(geometry),
        }
    }

    /// The messages that an answer is made from.
    pub(crate) fn parents(&self) -> Parents {
        Parents {
            odometry: self.odometry.id().0,
            map: self.map.revision().0,
            request: self.request.id().0,
            goal: self.goal.task().0,
            ..Parents::default()
        }
    }

    /// Counts rejected messages and says whether the map is current, for the heartbeat; then the
    /// trigger of the answers. `news` is what [`Self::poll`] returned.
    pub(crate) fn trigger(&self, shell: &mut Shell, news: bool) -> Trigger {
        let Self {
            odometry,
            map,
            request,
            goal,
            ..
        } = self;
        shell.count(&[odometry, map, request, goal]);
        shell.reason(REASON_MAP, !map.is_current());
        map.trigger(shell.roster(), odometry, news)
    }
}
