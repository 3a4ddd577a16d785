//! What the local planner reads, and what it knows by it when an answer begins.

use zeronav_local_planner::remembered::Remembered;
use zeronav_local_planner::scan_points::ScanPoints;
use zeronav_local_planner::situation::Future;
use zeronav_local_planner::staleness::Ages;
use zeronav_local_planner::{Inputs, PathInput};
use zeronav_motion::{InFlight, Twist};
use zeronav_msgs::header::Parents;
use zeronav_msgs::pose::Pose;
use zeronav_msgs::role::Role;
use zeronav_msgs::task::{GoalEnd, TaskStatus};
use zeronav_msgs::time::seconds;
use zeronav_msgs::topics::{
    MapObstacles, PlanPath, RobotCommand, RobotDescription, RobotScan, SimForesight, TaskGoal,
    TaskState,
};
use zeronav_shell::{
    Draft, Due, Latest, MapInput, OdometryReader, Peer, Received, Roster, Shell, StartError,
    Stream, ZoneInput,
};

/// The readers of the seat.
pub(crate) struct Readings {
    pub(crate) odometry: OdometryReader,
    pub(crate) task: Latest<TaskGoal>,
    description: Latest<RobotDescription>,
    scan: Latest<RobotScan>,
    map: MapInput,
    obstacles: Latest<MapObstacles>,
    /// The same, and what a mapping before knew.
    remembered: Remembered,
    /// Where they will be, when that is told.
    foresight: Option<Latest<SimForesight>>,
    path: Latest<PlanPath>,
    zones: ZoneInput,
    /// What the wheels get.
    commands: Stream<RobotCommand>,
    in_flight: InFlight,
    /// What the local planner that is obeyed says of the task, as long as that is another one.
    incumbent: Stream<TaskState>,
    /// Its last two statuses, the newer one last.
    statuses: [Option<HeardStatus>; 2],
    /// Grows when cells of the map change.
    map_cells: u64,
    points: ScanPoints,
    /// `odom_from_base` at the capture of the scan whose points are held.
    scan_pose: Option<Pose>,
    /// The newest scan waits for the odometry of its capture.
    scan_fresh: bool,
}

/// A message of `task/status`.
#[derive(Debug)]
struct HeardStatus {
    tick: u64,
    status: TaskStatus,
    ends: Vec<GoalEnd>,
}

/// What came in with a wake.
#[derive(Debug, Clone, Copy)]
pub(crate) struct News {
    /// A task.
    pub(crate) task: bool,
    /// A scan or a path.
    pub(crate) planning: bool,
}

impl Readings {
    /// Opens the topics.
    pub(crate) fn open(peer: &Peer) -> Result<Self, StartError> {
        Ok(Self {
            odometry: OdometryReader::open(peer)?,
            task: peer.latest()?,
            description: peer.latest()?,
            scan: peer.latest()?,
            map: MapInput::open(peer)?,
            obstacles: peer.latest()?,
            remembered: Remembered::default(),
            foresight: None,
            path: peer.latest()?,
            zones: ZoneInput::open(peer)?,
            commands: peer.stream()?,
            in_flight: InFlight::default(),
            incumbent: peer.stream()?,
            statuses: [None, None],
            map_cells: 0,
            points: ScanPoints::default(),
            scan_pose: None,
            scan_fresh: false,
        })
    }

    /// From now on is told where obstacles will be.
    pub(crate) fn be_told(&mut self, peer: &Peer) -> Result<(), StartError> {
        if self.foresight.is_none() {
            self.foresight = Some(peer.latest()?);
        }
        Ok(())
    }

    /// Takes in what has come.
    pub(crate) fn poll(&mut self, shell: &Shell) -> News {
        let roster = shell.roster();
        self.odometry.poll(roster);
        self.description.poll(roster);
        let task = self.task.poll(roster);
        let path = self.path.poll(roster);
        self.zones.poll(roster);
        let in_flight = &mut self.in_flight;
        self.commands.drain(roster, |view| {
            let command = Twist::new(view.meta.v_mps, view.meta.w_radps);
            in_flight.send(view.header.run_ns, command);
        });
        self.read_incumbent(shell);
        self.map.poll(shell);
        self.map_cells += u64::from(!self.map.changed().is_empty());
        if self.obstacles.poll(roster) {
            self.remember(roster);
        }
        if let Some(foresight) = &mut self.foresight {
            foresight.poll(roster);
        }
        let scan = self.scan.poll(roster);
        self.scan_fresh |= scan;
        self.take_points(shell.roster().clock.tick_ns);
        News {
            task,
            planning: scan || path,
        }
    }

    fn remember(&mut self, roster: &Roster) {
        // Whether a message that its author left before this process began came in depends on the speed
        // of the machine.
        if roster.lockstep() && roster.began_after(Role::Mapping, self.remembered.author()) {
            self.remembered.forget();
        }
        if let Some(view) = self.obstacles.get() {
            let author = view.header.id().epoch();
            (self.remembered).take(author, view.items, view.header.run_ns);
        }
    }

    fn read_incumbent(&mut self, shell: &Shell) {
        let (statuses, own) = (&mut self.statuses, shell.peer().epoch());
        self.incumbent.drain(shell.roster(), |view| {
            if view.header.id().epoch() != own {
                statuses.rotate_left(1);
                statuses[1] = Some(HeardStatus {
                    tick: view.header.tick,
                    status: *view.meta,
                    ends: view.items.to_vec(),
                });
            }
        });
    }

    /// How far the local planner that is obeyed has come with the task before `tick`, when that is
    /// another one and was not asked before.
    pub(crate) fn take_status_before(&mut self, tick: u64) -> Option<(TaskStatus, Vec<GoalEnd>)> {
        // In lockstep a status of the same tick may have come in or not.
        let is_before = |status: &Option<HeardStatus>| {
            (status.as_ref()).is_some_and(|status| status.tick < tick)
        };
        let at = self.statuses.iter().rposition(is_before)?;
        let newest = self.statuses[at].take()?;
        // An older one says nothing more.
        self.statuses[..at].fill_with(|| None);
        Some((newest.status, newest.ends))
    }

    /// Takes the points of a new scan, once odometry tells where it was captured. The first scan of a
    /// successor may be up to a tick older than its first odometry: in lockstep no other scan comes
    /// until it has answered that one.
    fn take_points(&mut self, tick_ns: u64) {
        if !self.scan_fresh {
            return;
        }
        let (Some(scan), Some(description)) = (self.scan.get(), self.description.get()) else {
            return;
        };
        let (history, run_ns) = (self.odometry.history(), scan.header.run_ns);
        let pose = history.pose_at(run_ns);
        let Some(pose) = pose.or_else(|| history.pose_before(run_ns, tick_ns)) else {
            return;
        };
        let twist = self.odometry.newest().map_or(Twist::REST, |newest| {
            Twist::new(newest.odometry.v_mps, newest.odometry.w_radps)
        });
        let base_from_laser = &description.meta.base_from_laser;
        self.points.take(
            scan.meta,
            scan.items,
            base_from_laser,
            (&pose, run_ns),
            twist,
        );
        self.scan_pose = Some(pose);
        self.scan_fresh = false;
    }

    /// Counts for the heartbeat.
    pub(crate) fn count(&self, shell: &mut Shell) {
        shell.count(&[
            &self.description,
            &self.odometry,
            &self.scan,
            &self.map,
            &self.obstacles,
            &self.path,
            &self.commands,
            &self.task,
            &self.zones,
            &self.foresight,
        ]);
        self.zones.report(shell);
    }

    /// True when the newest tick can be answered: in lockstep its scan, if it has one, has been
    /// received with the odometry of its capture, and so have the map and the path made from it.
    pub(crate) fn are_complete(&self, roster: &Roster) -> bool {
        let tick = self.odometry.tick();
        if !roster.lockstep() {
            return true;
        }
        let map_tick = self.map.received().map_or(0, |map| map.tick);
        if self.zones.is_missing(roster) {
            return false;
        }
        let scan_complete = self.scan.tick() >= tick
            && !self.scan_fresh
            && !roster.awaits(Role::Mapping, tick, map_tick)
            && !roster.awaits(Role::GlobalPlanner, tick, self.path.spoken_tick());
        let scan_due = self
            .odometry
            .newest()
            .is_some_and(|newest| newest.odometry.scan_due());
        let map_lost = roster.answers(Role::Mapping, tick) && self.map.is_lost();
        (scan_complete || !scan_due) && !map_lost
    }

    /// Begins an answer.
    pub(crate) fn begin(&self, shell: &Shell, due: Due) -> Draft {
        // In real time a scan between two ticks brings odometry of its own moment.
        let newest = self.odometry.newest();
        let run_ns = newest
            .filter(|newest| newest.tick == due.tick)
            .map_or_else(|| shell.run_ns(due.tick), |newest| newest.run_ns);
        let capture_ns = self.scan.received().map_or(0, |scan| scan.capture_ns);
        let parents = Parents {
            odometry: self.odometry.id().0,
            // The scan whose points are used, not one that still waits for its odometry.
            scan: if self.scan_fresh { 0 } else { self.scan.id().0 },
            map: self.map.revision().0,
            // An idle output is no path, and the order of starts decides whether it was received.
            path: if self.path.tick() == 0 {
                0
            } else {
                self.path.id().0
            },
            goal: self.task.id().0,
            ..Parents::default()
        };
        shell.begin(due, run_ns, capture_ns, parents)
    }

    /// What is known at the beginning of an answer.
    pub(crate) fn inputs(&mut self, shell: &Shell, draft: &Draft, period_s: f64) -> Inputs<'_> {
        self.zones.advance(draft.tick);
        let age_ns = |message: Received| shell.age_ns(draft, &message);
        let newest = self.odometry.newest();
        let odometry = newest.map(|newest| &newest.odometry);
        // However old: what moves is somewhere near where it would be by now, and not where the scan met
        // it. When they are too old to say so, the robot stops.
        let tracked = self.obstacles.get().map(|view| {
            let age_ns = draft.run_ns.saturating_sub(view.header.run_ns);
            (self.remembered.obstacles(), seconds(age_ns))
        });
        let told = self.foresight.as_ref().and_then(Latest::get);
        Inputs {
            future: told.map_or_else(Future::default, |view| Future {
                obstacles: view.items,
                age_s: seconds(draft.run_ns.saturating_sub(view.header.run_ns)),
            }),
            tick: draft.tick,
            run_ns: draft.run_ns,
            period_s,
            robot: self.description.get().map(|view| (view.meta, view.items)),
            odometry,
            map: self
                .map
                .view()
                .map(|map| (self.map.info().map_from_odom, map)),
            certainty: self.map.info().certainty(),
            map_cells: self.map_cells,
            obstacles: tracked.unwrap_or((&[], 0.0)),
            path: self.path.get().map(|view| PathInput {
                path: view.meta,
                waypoints: view.items,
            }),
            in_flight: &self.in_flight,
            zones: Some(self.zones.set()).filter(|zones| zones.has_limit()),
            ages: Ages {
                scan_ns: self.scan.received().map(age_ns),
                odometry_ns: newest.map(|newest| age_ns(newest.received())),
                map_ns: self.map.received().map(age_ns),
                obstacles_ns: self.obstacles.received().map(age_ns),
                path_ns: self.path.received().map(age_ns),
            },
            stopping: shell.roster().control.stopping == 1,
            scan_points_in_base: match (self.scan_pose, odometry) {
                (Some(at_capture), Some(now)) => self.points.carry(&at_capture, &now.pose),
                _ => &[],
            },
        }
    }
}
