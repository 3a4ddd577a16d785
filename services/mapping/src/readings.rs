//! What mapping reads, and the observation that a scan makes with the odometry around it.

use zeronav_mapping::{Observation, TrueMotion};
use zeronav_msgs::header::Parents;
use zeronav_msgs::health::{REASON_ODOMETRY, REASON_SCAN};
use zeronav_msgs::pose::Pose;
use zeronav_msgs::task::PoseEstimate;
use zeronav_msgs::time::nanoseconds;
use zeronav_msgs::topics::{RobotDescription, RobotScan, SimForesight, TaskPose};
use zeronav_shell::{
    CurrentGoal, Draft, Due, Latest, OdometryReader, Peer, Shell, StartError, Trigger, ZoneInput,
};

/// Time without a scan after which the map is not current. [ns]
const STALE_NS: u64 = 500_000_000;

/// Time after a scan in which the odometry around it is looked for more often than the shell wakes. [ns]
const AWAIT_NS: u64 = 50_000_000;

/// The readers of the seat.
pub(crate) struct Readings {
    odometry: OdometryReader,
    pub(crate) description: Latest<RobotDescription>,
    pub(crate) scan: Latest<RobotScan>,
    /// Where a person says the robot is, or where the process before this one knew it to be.
    estimate: Latest<TaskPose>,
    /// Id of the estimate that was used last.
    used: u64,
    /// Where the robot may not go.
    pub(crate) zones: ZoneInput,
    /// For regularisation only.
    goal: Option<CurrentGoal>,
    /// What moves, when that is told instead of tracked.
    foresight: Option<Latest<SimForesight>>,
}

impl Readings {
    /// Opens the topics; that of the goal only when it is asked for.
    ///
    /// # Errors
    /// As [`Peer::latest`].
    pub(crate) fn open(peer: &Peer, reads_goal: bool) -> Result<Self, StartError> {
        Ok(Self {
            odometry: OdometryReader::open(peer)?,
            description: peer.latest()?,
            scan: peer.latest()?,
            estimate: peer.latest()?,
            used: 0,
            zones: ZoneInput::open(peer)?,
            goal: reads_goal.then(|| CurrentGoal::open(peer)).transpose()?,
            foresight: None,
        })
    }

    /// From now on is told what moves.
    ///
    /// # Errors
    /// As [`Peer::latest`].
    pub(crate) fn be_told(&mut self, peer: &Peer) -> Result<(), StartError> {
        if self.foresight.is_none() {
            self.foresight = Some(peer.latest()?);
        }
        Ok(())
    }

    /// Takes in what has come, and counts rejected messages for the heartbeat.
    pub(crate) fn poll(&mut self, shell: &mut Shell) {
        let roster = shell.roster();
        self.odometry.poll(roster);
        self.description.poll(roster);
        self.scan.poll(roster);
        self.estimate.poll(roster);
        self.zones.poll(roster);
        if let Some(goal) = &mut self.goal {
            goal.poll(roster);
        }
        // It was sent before the scan.
        if let Some(foresight) = &mut self.foresight {
            foresight.poll(roster);
        }
        shell.count(&[
            &self.odometry,
            &self.scan,
            &self.description,
            &self.estimate,
            &self.zones,
            &self.goal,
            &self.foresight,
        ]);
        self.zones.report(shell);
    }

    /// Which answers the newest scan asks for; `located` once its poses are known.
    pub(crate) fn trigger(&self, located: bool) -> Trigger {
        Trigger {
            tick: self.scan.tick(),
            complete: located,
            ..Trigger::default()
        }
    }

    /// True for a moment while the odometry around the newest scan is still to come, as over a link: it rings nobody here.
    pub(crate) fn awaits_odometry(&self, shell: &Shell) -> bool {
        let came_ns = self.scan.received().map_or(0, |scan| scan.came_ns);
        let is_young = shell.woken_ns().saturating_sub(came_ns) < AWAIT_NS;
        is_young && self.scan.tick() > shell.answered_tick()
    }

    /// Says in the heartbeat whether odometry or scans are missing; true when scans are.
    pub(crate) fn report(&self, shell: &mut Shell) -> bool {
        let newest = self.scan.received().unwrap_or_default();
        let silent = shell.woken_ns().saturating_sub(newest.came_ns) > STALE_NS
            && !shell.roster().lockstep();
        shell.reason(REASON_SCAN, silent);
        shell.reason(REASON_ODOMETRY, self.scan.tick() > shell.answered_tick());
        silent
    }

    /// A new estimate of where the robot is, once it holds at `tick`.
    pub(crate) fn take_estimate(&mut self, tick: u64) -> Option<PoseEstimate> {
        let estimate = self.estimate.get()?;
        if estimate.header.id == self.used || estimate.meta.from_tick > tick {
            return None;
        }
        self.used = estimate.header.id;
        Some(*estimate.meta)
    }

    /// Begins the answer to the newest scan, with the goal of its tick.
    pub(crate) fn begin(&mut self, shell: &Shell, due: Due) -> Draft {
        let scan = self.scan.received().unwrap_or_default();
        let draft = shell.begin(due, scan.run_ns, scan.capture_ns, self.parents());
        if let Some(goal) = &mut self.goal {
            goal.advance(shell.roster(), due.tick);
        }
        draft
    }

    /// `odom_from_base` at the capture of the newest scan's first and last beam; `None` until the
    /// odometry around the capture has been received. The first scan of a successor may have been
    /// captured up to a tick before the first odometry that it has: in lockstep no other scan comes
    /// until it has answered that one.
    pub(crate) fn poses_of_scan(&self, tick_ns: u64) -> Option<(Pose, Pose)> {
        let scan = self.scan.get()?;
        let history = self.odometry.history();
        let last_ns = scan.header.run_ns;
        let last = history.pose_at(last_ns);
        let last = last.or_else(|| history.pose_before(last_ns, tick_ns))?;
        let steps = f64::from(scan.meta.n_beams.saturating_sub(1));
        let turn_ns = nanoseconds(steps * f64::from(scan.meta.time_increment_s));
        if turn_ns == 0 {
            return Some((last, last));
        }
        // The first turn began before the first odometry.
        let first = history.pose_at(last_ns.saturating_sub(turn_ns));
        Some((first.unwrap_or(last), last))
    }

    /// The newest scan, with `odom_from_base` at its first and last beam.
    pub(crate) fn observation(&self, (first, last): (Pose, Pose)) -> Option<Observation<'_>> {
        let scan = self.scan.get()?;
        let newest = self.odometry.newest();
        let goal = self.goal.as_ref().and_then(CurrentGoal::goal);
        Some(Observation {
            scan: scan.meta,
            ranges: scan.items,
            run_ns: scan.header.run_ns,
            odom_from_base_first: first,
            odom_from_base: last,
            odometry_variance: newest.map_or([0.0; 3], |newest| newest.odometry.variance),
            goal: goal.map(|goal| goal.pose.point()),
            told: self
                .foresight
                .as_ref()
                .and_then(Latest::get)
                .map(|view| TrueMotion {
                    pose: view.meta.pose,
                    obstacles: view.items,
                }),
        })
    }

    /// The messages that an answer is made from.
    fn parents(&self) -> Parents {
        Parents {
            odometry: self.odometry.id().0,
            scan: self.scan.id().0,
            ..Parents::default()
        }
    }
}
