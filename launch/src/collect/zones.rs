//! Which zone slows or stops the robot, by where it is and what the stages say.

use super::Collector;
use nalgebra::Point2;
use zeronav_measure::result::moment::Zone;
use zeronav_msgs::ZoneSet;
use zeronav_msgs::command::{Intervention, RequestCause, VelocityCommand};
use zeronav_msgs::map::ObstacleSource;
use zeronav_msgs::path::PathStatus;
use zeronav_msgs::zones::{ZonePart, Zones};

/// How far ahead of the robot a zone is looked for that it slows down for. [m]
const AHEAD_M: f64 = 4.0;

/// Between two places that are looked at. [m]
const STEP_M: f64 = 0.05;

impl Collector {
    /// Takes in the zones that hold from now on.
    pub(crate) fn take_zones(&mut self, zones: &Zones, parts: &[ZonePart]) {
        if zones.revision == self.zones.revision() {
            return;
        }
        self.zones = ZoneSet::of(zones, parts);
        self.film.zones(self.run_ns, parts);
    }

    /// The zone because of which the robot is slow, stands, or has no path; `None` when it is none, or
    /// nobody knows where the robot is.
    pub(super) fn zone(&self, command: &VelocityCommand) -> Option<Zone> {
        let keepout = |(name, _): (&str, f64)| Zone {
            name: name.to_owned(),
            limit_mps: None,
        };
        match command.intervention() {
            Some(Intervention::ZoneStopped) => {
                let robot = self.estimate()?.point();
                return self.zones.nearest_keepout(robot).map(keepout);
            }
            Some(Intervention::ZoneSlowed) => return self.speed_zone(),
            _ => {}
        }
        if self.asked == Some(RequestCause::SpeedZone) {
            return self.speed_zone();
        }
        let at_m = self.closed_m?;
        self.zones.nearest_keepout(Point2::from(at_m)).map(keepout)
    }

    /// The zone whose limit holds here, or ahead.
    fn speed_zone(&self) -> Option<Zone> {
        let robot = self.estimate()?;
        let steps = (0_u32..).map(|n| f64::from(n) * STEP_M);
        let ways = steps.take_while(|ahead_m| *ahead_m <= AHEAD_M);
        let mut found = ways.filter_map(|ahead_m| {
            let at = robot.transform(Point2::new(ahead_m, 0.0));
            self.zones.limit_at(at, self.v_mps_max)
        });
        let zone = found.next()?;
        Some(Zone {
            name: zone.name.to_owned(),
            limit_mps: Some(zone.limit_mps),
        })
    }

    /// Takes in which cell leaves no path, when a keepout zone closes it.
    pub(super) fn closed(&mut self, path: &zeronav_msgs::path::Path) {
        let is_zone = ObstacleSource::from_code(path.source) == Some(ObstacleSource::Keepout);
        let fails = !matches!(path.status(), Some(PathStatus::Found | PathStatus::NoGoal));
        self.closed_m = (is_zone && fails).then_some(path.block_m);
    }
}
