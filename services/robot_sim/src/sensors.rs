//! What the simulated robot publishes: its description, scans, odometry, and the ground truth.

use zeronav_msgs::description::FOOTPRINT_CORNERS_MAX;
use zeronav_msgs::foresight::{FORESEEN_MAX, Foreseen};
use zeronav_msgs::header::Parents;
use zeronav_msgs::stages::{Stage, StageTimer};
use zeronav_msgs::topics::{GroundTruth, RobotDescription, RobotOdometry, RobotScan, SimForesight};
use zeronav_msgs::truth::{TRUTH_OBSTACLES_MAX, TruthObstacle};
use zeronav_robot_sim::Simulator;
use zeronav_shell::clock::both_ns;
use zeronav_shell::odometry::{REST_MESSAGES, is_stopped};
use zeronav_shell::{Draft, Due, Peer, Shell, StartError, Writer};

/// The step that the sensors follow.
pub(crate) struct Moment {
    pub(crate) due: Due,
    /// Run time of its end. [ns]
    pub(crate) run_ns: u64,
    /// Run time that was lost so far. [ns]
    pub(crate) slipped_ns: u64,
    /// Monotonic time at which it began. [ns]
    pub(crate) started_ns: u64,
}

/// The writers of the seat.
pub(crate) struct Sensors {
    description: Writer<RobotDescription>,
    scan: Writer<RobotScan>,
    odometry: Writer<RobotOdometry>,
    truth: Writer<GroundTruth>,
    obstacles: Vec<TruthObstacle>,
    /// Only in a run that measures what perception and prediction cost.
    foresight: Option<(Writer<SimForesight>, Vec<Foreseen>)>,
    /// Newest tick with a scan.
    scan_tick: u64,
    /// Contacts that were logged.
    logged_contacts: u32,
    /// Messages in a row with stopped wheels.
    stopped_messages: usize,
}

impl Sensors {
    pub(crate) fn open(peer: &Peer, n_beams: usize) -> Result<Self, StartError> {
        Ok(Self {
            description: peer.writer(FOOTPRINT_CORNERS_MAX)?,
            scan: peer.writer(n_beams)?,
            odometry: peer.writer(1)?,
            truth: peer.writer(TRUTH_OBSTACLES_MAX)?,
            obstacles: Vec::with_capacity(TRUTH_OBSTACLES_MAX),
            foresight: None,
            scan_tick: 0,
            logged_contacts: 0,
            stopped_messages: 0,
        })
    }

    /// From now on tells what moves and where it will be.
    pub(crate) fn foresee(&mut self, peer: &Peer) -> Result<(), StartError> {
        let writer = peer.writer(FORESEEN_MAX)?;
        self.foresight = Some((writer, Vec::with_capacity(TRUTH_OBSTACLES_MAX)));
        Ok(())
    }

    /// Newest tick with a scan.
    pub(crate) fn scan_tick(&self) -> u64 {
        self.scan_tick
    }

    /// True when the wheels are stopped.
    pub(crate) fn is_at_rest(&self) -> bool {
        self.stopped_messages >= REST_MESSAGES
    }

    /// Brings the description to readers that joined since.
    pub(crate) fn refresh(&self) {
        self.description.refresh();
    }

    /// The idle output: what the robot is.
    pub(crate) fn send_description(&mut self, shell: &mut Shell, simulator: &Simulator) {
        let (description, corners) = simulator.description();
        let draft = shell.begin(Due::IDLE, 0, 0, Parents::default());
        shell.answer(&draft, &mut self.description, description, &corners);
    }

    /// Sends what the sensors measure after a step: the scan, if one is due, then odometry, and at
    /// the lidar's rate the ground truth.
    pub(crate) fn send(
        &mut self,
        shell: &mut Shell,
        simulator: &mut Simulator,
        moment: &Moment,
        mut timer: StageTimer,
    ) {
        let Moment { due, run_ns, .. } = *moment;
        // Nothing moves any more: this is the moment that the sensors measure.
        let (seen_ns, seen_raw_ns) = both_ns();
        let scan_due = simulator.scan_due();
        let mut parents = Parents {
            odometry: self.odometry.next_id().0,
            ..Parents::default()
        };
        let mut capture_ns = seen_ns;
        let n_beams = simulator.n_beams();
        if let Some(scan) = scan_due {
            self.scan_tick = due.tick;
            capture_ns = seen_ns - run_ns.saturating_sub(scan.capture_run_ns).min(seen_ns);
            let draft = shell.begin(due, scan.capture_run_ns, capture_ns, parents);
            // Before the scan: whoever has that has this, too.
            self.send_foresight(simulator, draft);
            let sent = shell.send_with(&draft, &mut self.scan, n_beams, |ranges| {
                let scan = simulator.scan(ranges).unwrap_or_default();
                timer.mark(Stage::Cast);
                scan
            });
            parents.scan = sent.map_or(0, |sent| sent.id.0);
        }
        let mut draft = shell.begin(due, run_ns, capture_ns, parents);
        draft.started_ns = moment.started_ns;
        draft.stages_ns = timer.stages_ns();
        if !shell.roster().lockstep() {
            draft.raw_ns = seen_raw_ns.saturating_sub(seen_ns - capture_ns);
        }
        let odometry = simulator.odometry();
        self.stopped_messages = if is_stopped(&odometry) {
            self.stopped_messages.saturating_add(1)
        } else {
            0
        };
        let sent = shell.send(&draft, &mut self.odometry, odometry, &[]);
        let work = scan_due.map_or(0, |_| n_beams as u64);
        shell.finish(&draft, sent, work);
        if simulator.truth_due() {
            self.send_truth(simulator, draft, seen_ns, moment.slipped_ns);
        }
    }

    fn send_foresight(&mut self, simulator: &Simulator, draft: Draft) {
        if let Some((writer, obstacles)) = &mut self.foresight {
            let foresight = simulator.foresee(obstacles);
            let draft = Draft {
                hashed: false,
                ..draft
            };
            writer.publish(&draft, foresight, obstacles);
        }
    }

    /// The ground truth is no part of the answer: it counts for no hash and rings no doorbell.
    fn send_truth(
        &mut self,
        simulator: &mut Simulator,
        draft: Draft,
        seen_ns: u64,
        slipped_ns: u64,
    ) {
        let mut truth = simulator.truth(&mut self.obstacles);
        let contacts = truth.contacts_moving + truth.contacts_standing;
        if contacts != self.logged_contacts {
            self.logged_contacts = contacts;
            let tick = draft.tick;
            let (x_m, y_m, v_mps) = (truth.pose.x_m, truth.pose.y_m, truth.v_mps);
            tracing::info!(tick, contacts, x_m, y_m, v_mps, "contact");
        }
        truth.scan = draft.parents.scan;
        truth.slipped_ns = slipped_ns;
        for obstacle in &mut self.obstacles {
            let ago_ns = draft.run_ns.saturating_sub(obstacle.appeared_run_ns);
            obstacle.appeared_ns = seen_ns.saturating_sub(ago_ns);
        }
        let draft = Draft {
            hashed: false,
            ..draft
        };
        self.truth.publish(&draft, truth, &self.obstacles);
    }
}
