//! What the robot measures, on the topics of its seat.

use super::describe::{described, with_lidar};
use crate::config::SeatConfig;
use crate::inputs::Measured;
use crate::stamps::Moment;
use crate::timeline::{Tick, Timeline};
use zeronav_msgs::description::{Corner, Description, FOOTPRINT_CORNERS_MAX};
use zeronav_msgs::header::{Id, Parents};
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::pose::Pose;
use zeronav_msgs::scan::{BEAMS_MAX, Scan};
use zeronav_msgs::span::SpanKind;
use zeronav_msgs::topics::{RobotDescription, RobotOdometry, RobotScan};
use zeronav_shell::clock::both_ns;
use zeronav_shell::odometry::{REST_MESSAGES, is_stopped};
use zeronav_shell::{Due, Input, Peer, Sent, Shell, StartError, Writer};

/// A mount that moved by less than this is the same. [m], [rad]
const SAME_MOUNT: f64 = 1.0e-3;

/// What was counted of the messages of ROS.
pub(super) struct Counts {
    pub(super) rejected: u64,
    pub(super) dropped: u64,
}

impl Input for Counts {
    fn refused(&self) -> u64 {
        self.rejected
    }

    fn superseded(&self) -> u64 {
        self.dropped
    }
}

/// The writers of the seat.
pub(super) struct Sensors {
    description: Writer<RobotDescription>,
    scan: Writer<RobotScan>,
    odometry: Writer<RobotOdometry>,
    said: (Description, Vec<Corner>),
    is_begun: bool,
    /// When a scan and odometry were sent last. [ns]
    came_ns: [Option<u64>; 2],
    /// A scan that belongs to the odometry that comes next.
    waiting: Option<(Moment, Scan, Vec<f32>)>,
    /// Messages in a row with stopped wheels.
    stopped_messages: usize,
}

impl Sensors {
    pub(super) fn open(peer: &Peer, config: &SeatConfig) -> Result<Self, StartError> {
        Ok(Self {
            description: peer.writer(FOOTPRINT_CORNERS_MAX)?,
            scan: peer.writer(BEAMS_MAX)?,
            odometry: peer.writer(1)?,
            said: described(&config.robot)?,
            is_begun: false,
            came_ns: [None; 2],
            waiting: None,
            stopped_messages: 0,
        })
    }

    /// The idle output, and the description for readers that joined since.
    pub(super) fn begin(&mut self, shell: &mut Shell) {
        self.description.refresh();
        if self.is_begun {
            return;
        }
        self.is_begun = true;
        let draft = shell.begin(Due::IDLE, 0, 0, Parents::default());
        let (description, corners) = &self.said;
        shell.answer(&draft, &mut self.description, *description, corners);
    }

    /// When a scan and when odometry came last, monotonic. [ns]
    pub(super) fn came_ns(&self) -> [Option<u64>; 2] {
        self.came_ns
    }

    /// True when the wheels are stopped.
    pub(super) fn is_at_rest(&self) -> bool {
        self.stopped_messages >= REST_MESSAGES
    }

    /// Sends a measurement, at the run time of its moment.
    pub(super) fn send(&mut self, shell: &mut Shell, timeline: &mut Timeline, measured: Measured) {
        match measured {
            Measured::Scan {
                moment,
                scan,
                ranges,
                base_from_laser,
            } => {
                self.describe(shell, &scan, base_from_laser);
                self.waiting = Some((moment, scan, ranges));
                // Odometry around it was sent before.
                let run_ns = timeline.run_ns(moment.at_ns);
                if run_ns.is_some() && run_ns <= timeline.newest_run_ns() {
                    let newest = self.odometry.next_id().0.saturating_sub(1);
                    self.send_scan(shell, timeline, timeline.tick(), newest, true);
                }
            }
            Measured::Odometry { moment, odometry } => {
                let tick_ns = shell.roster().clock.tick_ns;
                if let Some(tick) = timeline.advance(moment.at_ns, tick_ns) {
                    let next = self.odometry.next_id().0;
                    let scan = self.send_scan(shell, timeline, tick.tick, next, false);
                    self.send_odometry(shell, (tick, moment), odometry, scan);
                }
            }
        }
    }

    /// Says what the robot is when its lidar says something new.
    fn describe(&mut self, shell: &Shell, scan: &Scan, base_from_laser: Pose) {
        let (before, corners) = &self.said;
        let next = with_lidar(*before, scan, base_from_laser);
        let moved = before.base_from_laser.distance_m(&base_from_laser) > SAME_MOUNT
            || (before.base_from_laser.yaw_rad - base_from_laser.yaw_rad).abs() > SAME_MOUNT;
        let is_other = before.n_beams != next.n_beams
            || before.angle_min_rad.to_bits() != next.angle_min_rad.to_bits()
            || before.angle_increment_rad.to_bits() != next.angle_increment_rad.to_bits()
            || before.range_m_max.to_bits() != next.range_m_max.to_bits();
        if !(moved || is_other) || next.check(corners).is_err() {
            return;
        }
        tracing::info!(
            n_beams = next.n_beams,
            x_m = base_from_laser.x_m,
            y_m = base_from_laser.y_m,
            yaw_rad = base_from_laser.yaw_rad,
            "the lidar"
        );
        let draft = shell.begin(Due::IDLE, 0, 0, Parents::default());
        shell.send_aside(&draft, &mut self.description, next, corners);
        self.said.0 = next;
    }

    /// Sends the scan that waits, with this odometry; its id, 0 without one. One `alone` has a record of its own, which
    /// is otherwise that of the odometry that follows.
    fn send_scan(
        &mut self,
        shell: &mut Shell,
        timeline: &Timeline,
        tick: u64,
        odometry: u64,
        alone: bool,
    ) -> u64 {
        let Some((moment, scan, ranges)) = self.waiting.take() else {
            return 0;
        };
        let Some(run_ns) = timeline.run_ns(moment.at_ns).filter(|_| tick > 0) else {
            return 0;
        };
        let kind = SpanKind::Extra;
        let parents = Parents {
            odometry,
            ..Parents::default()
        };
        let mut draft = shell.begin(Due { tick, kind }, run_ns, moment.capture_ns, parents);
        let sent = shell.send(&draft, &mut self.scan, scan, &ranges);
        self.came_ns[0] = Some(shell.woken_ns());
        let Some(sent) = sent else {
            return 0;
        };
        if alone {
            draft.parents.scan = sent.id.0;
            draft.raw_ns = raw_at(moment.capture_ns);
            // The ids of main messages are those of odometry.
            let id = Id::NONE;
            shell.finish(&draft, Some(Sent { id, ..sent }), 0);
        }
        sent.id.0
    }

    fn send_odometry(
        &mut self,
        shell: &mut Shell,
        (tick, moment): (Tick, Moment),
        odometry: Odometry,
        scan: u64,
    ) {
        let kind = if tick.is_new {
            SpanKind::Answer
        } else {
            SpanKind::Extra
        };
        let due = Due {
            tick: tick.tick,
            kind,
        };
        let parents = Parents {
            odometry: self.odometry.next_id().0,
            scan,
            ..Parents::default()
        };
        let mut draft = shell.begin(due, tick.run_ns, moment.capture_ns, parents);
        draft.raw_ns = raw_at(moment.capture_ns);
        self.stopped_messages = if is_stopped(&odometry) {
            self.stopped_messages.saturating_add(1)
        } else {
            0
        };
        let odometry = Odometry {
            scan_due: u32::from(scan != 0),
            ..odometry
        };
        let sent = shell.send(&draft, &mut self.odometry, odometry, &[]);
        self.came_ns[1] = Some(shell.woken_ns());
        shell.finish(&draft, sent, 0);
    }
}

/// The second clock at a moment of the first. [ns]
fn raw_at(capture_ns: u64) -> u64 {
    let (now, raw) = both_ns();
    raw.saturating_sub(now.saturating_sub(capture_ns))
}
