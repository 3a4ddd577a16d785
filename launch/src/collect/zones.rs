//! Which zone slows or stops the robot, by where it is and what the stages say.

use super::Collector;
use nalgebra::Point2;
use zeronav_measure::result::moment::Zone;
use zeronav_msgs::ZoneSet;
use zeronav_msgs::command::{Intervention, VelocityCommand};
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

    /// The zones that may make the robot slow, and stand or without a path: what the stages say decides.
    pub(super) fn zones_near(&self, command: &VelocityCommand) -> [Option<Zone>; 2] {
        let is_held = command.intervention() == Some(Intervention::ZoneStopped);
        let robot = self.estimate().map(|robot| robot.point());
        let closed = self.closed_m.filter(|_| !is_held).map(Point2::from);
        let nearest = closed
            .or(robot)
            .and_then(|at| self.zones.nearest_keepout(at));
        let keepout = nearest.map(|(name, _)| Zone {
            name: name.to_owned(),
            limit_mps: None,
        });
        [self.speed_zone(), keepout]
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

    /// Takes in which cell leaves no path, when a keepout zone closes it; of a goal that has ended it stays known.
    pub(super) fn closed(&mut self, path: &zeronav_msgs::path::Path) {
        if path.status() == Some(PathStatus::NoGoal) {
            return;
        }
        let is_zone = ObstacleSource::from_code(path.source) == Some(ObstacleSource::Keepout);
        let fails = path.status() != Some(PathStatus::Found);
        self.closed_m = (is_zone && fails).then_some(path.block_m);
    }
}
