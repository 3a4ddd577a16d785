//! Zones as far as the robot's pose matters: one that is inside is let out.

use super::Mapping;
use zeronav_msgs::{Pose, ZoneSet};

/// Room beyond what the robot needs, so that cells along the middle of a way out are no border case.
/// [cells]
const SPARE_CELLS: f64 = 2.0;

impl Mapping {
    /// Takes in zones in place of those before.
    pub fn set_zones(&mut self, set: &ZoneSet) {
        self.mapper.set_zones(set);
    }

    /// Opens a way out for a robot in a keepout zone, and closes it behind it. One that does not know
    /// where it is changes nothing.
    pub fn let_out(&mut self, odom_from_base: &Pose) {
        if self.localiser.is_uncertain() {
            return;
        }
        let robot = self.localiser.map_from_base(odom_from_base).point();
        let costs = self.mapper.cost_model();
        let spare_m = costs.padding_m + SPARE_CELLS * self.mapper.geometry().resolution_m;
        let (inscribed_m, circumscribed_m) = (costs.inscribed_radius_m, self.outline.radius_m());
        let room = (inscribed_m + spare_m, circumscribed_m + spare_m);
        self.mapper.let_out(robot, room.0, room.1);
    }
}
