//! What the guard reads, and what it knows by it when an answer begins.

use zeronav_collision_guard::{GuardInputs, OdometryInput, ScanInput};
use zeronav_msgs::Pose;
use zeronav_msgs::header::Parents;
use zeronav_msgs::map::MapInfo;
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::{ControlRequest, MapUpdate, RobotDescription, RobotScan};
use zeronav_shell::{
    Draft, Due, Latest, OdometryReader, Peer, Received, Shell, StartError, Trigger, ZoneInput,
};

/// How long after odometry the guard waits for the request that belongs to it. [ns]
const PATIENCE_NS: u64 = 5_000_000;

/// The readers of the seat.
pub(crate) struct Readings {
    pub(crate) odometry: OdometryReader,
    pub(crate) description: Latest<RobotDescription>,
    scan: Latest<RobotScan>,
    request: Latest<ControlRequest>,
    /// The newest scan came after the answer before, and [`Self::ahead`] has not told it.
    is_scan_new: bool,
    pub(crate) zones: ZoneInput,
    /// For the pose among zones; opened with the first one.
    map: Option<Latest<MapUpdate>>,
    /// When the answer before began. [ns]
    answered_ns: u64,
    /// When this one began. [ns]
    began_ns: u64,
}

impl Readings {
    /// Opens the topics.
    pub(crate) fn open(peer: &Peer) -> Result<Self, StartError> {
        Ok(Self {
            odometry: OdometryReader::open(peer)?,
            description: peer.latest()?,
            scan: peer.latest()?,
            request: peer.latest()?,
            is_scan_new: false,
            zones: ZoneInput::open(peer)?,
            map: None,
            answered_ns: 0,
            began_ns: 0,
        })
    }

    /// Takes in what has come. An answer waits for the request: in lockstep for that of the tick,
    /// in real time for the next one, or [`PATIENCE_NS`].
    pub(crate) fn poll(&mut self, shell: &mut Shell) -> Trigger {
        let roster = shell.roster();
        self.odometry.poll(roster);
        self.description.poll(roster);
        let requested = self.request.poll(roster);
        self.is_scan_new |= self.scan.poll(roster);
        self.zones.poll(roster);
        let tick = self.odometry.tick();
        let trigger = Trigger {
            tick,
            complete: if roster.lockstep() {
                !roster.awaits(Role::LocalPlanner, tick, self.request.spoken_tick())
                    && !self.zones.is_missing(roster)
            } else {
                requested
            },
            deadline_ns: self.odometry.newest().map(|it| it.came_ns + PATIENCE_NS),
            news: requested,
        };
        shell.count(&[
            &self.odometry,
            &self.scan,
            &self.request,
            &self.zones,
            &self.map,
        ]);
        self.zones.report(shell);
        trigger
    }

    /// What the newest map says of itself, when that is news and there are zones.
    ///
    /// # Errors
    /// As [`Peer::latest`].
    pub(crate) fn located(&mut self, shell: &Shell) -> Result<Option<MapInfo>, StartError> {
        if self.map.is_none() {
            if self.zones.set().is_empty() {
                return Ok(None);
            }
            self.map = Some(shell.peer().latest()?);
        }
        let Some(map) = &mut self.map else {
            return Ok(None);
        };
        if !map.poll(shell.roster()) {
            return Ok(None);
        }
        // The idle output of a process that begins has seen nothing yet.
        let seen = map.get().filter(|view| view.header.parents.scan != 0);
        let located = seen.map(|view| *view.meta);
        // The tiles are large, and of no use here.
        map.release();
        Ok(located)
    }

    /// Begins an answer.
    pub(crate) fn begin(&mut self, shell: &Shell, due: Due) -> Draft {
        let parents = Parents {
            odometry: self.odometry.id().0,
            scan: self.scan.id().0,
            request: self.request.id().0,
            ..Parents::default()
        };
        let capture_ns = self.scan.received().map_or(0, |scan| scan.capture_ns);
        let draft = shell.begin(due, shell.run_ns(due.tick), capture_ns, parents);
        (self.answered_ns, self.began_ns) = (self.began_ns, draft.started_ns);
        self.is_scan_new = false;
        draft
    }

    /// Time since the answer before: from tick to tick. While odometry is late the ticks stand still, and
    /// the robot has to come to rest all the same: then by the own clock. [ns]
    fn period_ns(&self, shell: &Shell, draft: &Draft) -> u64 {
        let ticks = draft.tick.saturating_sub(shell.answered_tick());
        let tick_ns = shell.roster().clock.tick_ns;
        let late = |came_ns: u64| draft.started_ns.saturating_sub(came_ns) > tick_ns;
        let newest = self.odometry.newest();
        let is_late = ticks == 0 && newest.is_some_and(|newest| late(newest.came_ns));
        if is_late && !shell.roster().lockstep() {
            draft.started_ns.saturating_sub(self.answered_ns)
        } else {
            shell.run_ns(ticks)
        }
    }

    /// Where the robot was when a scan was captured. The first one of a successor may be up to a tick older
    /// than its first odometry.
    fn pose_at_capture(&self, shell: &Shell, run_ns: u64) -> Option<Pose> {
        let history = self.odometry.history();
        let tick_ns = shell.roster().clock.tick_ns;
        let pose = history.pose_at(run_ns);
        pose.or_else(|| history.pose_before(run_ns, tick_ns))
    }

    /// A scan that has just come, and what belongs to it, to be taken in before the request comes; once there is odometry of
    /// its capture. What counts at an answer alone, such as ages, is not in it.
    pub(crate) fn ahead(&mut self, shell: &Shell) -> Option<GuardInputs<'_>> {
        let (scan, odometry) = (self.scan.received()?, self.odometry.newest()?);
        if !self.is_scan_new || odometry.run_ns < scan.run_ns {
            return None;
        }
        self.is_scan_new = false;
        Some(self.inputs(shell, &Draft::default()))
    }

    /// What is known at the beginning of an answer. A scan is as old as its capture, the other
    /// messages are as old as their arrival.
    pub(crate) fn inputs(&self, shell: &Shell, draft: &Draft) -> GuardInputs<'_> {
        let age_ns = |message: Option<Received>| {
            message.map_or(u64::MAX, |message| shell.age_ns(draft, &message))
        };
        let arrival_age_ns = |message: Option<Received>| age_ns(message.map(Received::on_arrival));
        GuardInputs {
            robot: self.description.get().map(|view| (view.meta, view.items)),
            // The idle output commands rest, whatever has come before it.
            request: (draft.tick > 0)
                .then(|| self.request.get())
                .flatten()
                .map(|view| (*view.meta, arrival_age_ns(self.request.received()))),
            scan: self.scan.get().map(|view| ScanInput {
                scan: view.meta,
                ranges: view.items,
                id: view.header.id,
                run_ns: view.header.run_ns,
                age_ns: age_ns(self.scan.received()),
                odom_from_base: self.pose_at_capture(shell, view.header.run_ns),
            }),
            odometry: self.odometry.newest().map(|newest| OdometryInput {
                odometry: &newest.odometry,
                id: newest.id.0,
                run_ns: newest.run_ns,
                age_ns: arrival_age_ns(Some(newest.received())),
            }),
            period_ns: self.period_ns(shell, draft),
            stopping: shell.roster().control.stopping == 1,
        }
    }
}
