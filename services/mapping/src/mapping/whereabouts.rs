//! Whether the robot is where it takes itself to be: what it was told, and what is asked after the answer.

use super::{Checked, Mapping, Observation, Unchecked};
use crate::relocaliser::{Relocaliser, Sight, Sought, Step};
use zeronav_msgs::Pose;
use zeronav_msgs::certainty::PoseCertainty;
use zeronav_msgs::map::{MapInfo, MapView};
use zeronav_msgs::pose::wrap_angle;

/// How far scans may move a configured pose: what fits only farther away may be one of several places that do. [m, rad]
const CONFIGURED_OFF: (f64, f64) = (0.3, 0.15);

impl Mapping {
    /// Goes on from where another mapping has come to: its map, and how it is fixed to odometry. False
    /// when its grid does not fit; then nothing changes.
    pub fn resume(&mut self, info: &MapInfo, map: &MapView<'_>) -> bool {
        let Some(mapper) = self.mapper.learnt(map, &self.config) else {
            return false;
        };
        self.mapper = mapper;
        (self.unchecked, self.checked, self.configured) = (None, None, None);
        let can_search = self.relocaliser.is_some();
        self.localiser
            .resume(info.map_from_odom, info.covariance, can_search);
        if let Some(relocaliser) = &mut self.relocaliser {
            match info.certainty() {
                PoseCertainty::Confirmed => relocaliser.confirm(),
                PoseCertainty::Unconfirmed | PoseCertainty::Unknown => relocaliser.tell(),
            }
        }
        self.see_whether_confirmed();
        true
    }

    /// The robot is where it was told to be: `map_from_odom` from the scan `next` on, by a person, or by what was known
    /// before a restart. That is doubted unless its `certainty` is `Confirmed`; a robot that was lost still is.
    ///
    /// What scans have added to a static map was seen from elsewhere and is forgotten. Without a
    /// static map there is nothing else to go by: the map stays, and the robot is put on it.
    pub fn relocate(
        &mut self,
        map_from_odom: Pose,
        certainty: PoseCertainty,
        next: &Observation<'_>,
    ) {
        // Its key scan counts, whether it was looked at by now or not.
        self.check();
        (self.checked, self.configured) = (None, None);
        self.localiser.relocate(map_from_odom, &next.odom_from_base);
        if let Some(relocaliser) = &mut self.relocaliser {
            match certainty {
                PoseCertainty::Unknown => {
                    relocaliser.tell();
                    self.localiser.lose();
                }
                PoseCertainty::Unconfirmed => relocaliser.tell(),
                PoseCertainty::Confirmed => relocaliser.confirm(),
            }
        } else if certainty == PoseCertainty::Unknown && self.has_static_map {
            self.localiser.doubt();
        }
        self.see_whether_confirmed();
        self.tracker.restart();
        if self.has_static_map {
            self.mapper.forget_sensed();
        }
    }

    /// Asks of the last scan what nobody waits for: whether the robot is lost, and where on the static map it is then.
    ///
    /// Nothing that is sent changes by it before the next scan: when it runs between two scans makes no difference, and
    /// [`Self::take_in`] does it at the latest.
    pub fn check(&mut self) {
        let Some(scan) = self.unchecked.take() else {
            return;
        };
        if scan.is_key {
            self.find_standing(&scan.map_from_base, scan.run_ns);
            self.localiser.next_key(&self.standing);
        }
        self.checked = self.relocalise(&scan);
    }

    /// Acts on what [`Self::check`] came to.
    pub(super) fn heed_check(&mut self) {
        let Some(checked) = self.checked.take() else {
            return;
        };
        self.see_whether_confirmed();
        match &checked.step {
            Step::Nothing => return,
            Step::Lost => self.localiser.lose(),
            Step::Found(found) => self.localiser.find(found, &checked.odom_from_base),
        }
        // What was seen meanwhile was seen from elsewhere.
        self.tracker.restart();
        self.mapper.forget_sensed();
    }

    /// A configured pose that scans would move far is wrong: the robot is looked for on the whole map.
    pub(super) fn hold_to_configuration(&mut self, odom_from_base: &Pose) {
        let left = self.configured.take();
        let Some((map_from_odom, scans)) = left.filter(|(_, scans)| *scans > 0) else {
            return;
        };
        let (told, now) = (
            map_from_odom.then(odom_from_base),
            self.localiser.map_from_base(odom_from_base),
        );
        let (most_m, most_rad) = CONFIGURED_OFF;
        let turned_rad = wrap_angle(told.yaw_rad - now.yaw_rad).abs();
        if told.distance_m(&now) > most_m || turned_rad > most_rad {
            self.localiser.lose();
        } else {
            self.configured = Some((map_from_odom, scans - 1));
        }
    }

    fn see_whether_confirmed(&mut self) {
        let relocaliser = self.relocaliser.as_ref();
        self.is_confirmed = relocaliser.is_none_or(Relocaliser::is_confirmed);
    }

    /// True when [`Self::check`] has something to do.
    #[must_use]
    pub const fn is_unchecked(&self) -> bool {
        self.unchecked.is_some()
    }

    /// Whether the robot is lost, and where on the static map it is then.
    fn relocalise(&mut self, scan: &Unchecked) -> Option<Checked> {
        let odom_from_base = &scan.odom_from_base;
        let (tracker, run_ns) = (&self.tracker, scan.run_ns);
        if self.localiser.is_uncertain() {
            self.mapper.make_surfaces();
        }
        let relocaliser = self.relocaliser.as_mut()?;
        let sight = Sight {
            beams: self.beams.as_slice(),
            mapper: &self.mapper,
            map_from_base: self.localiser.map_from_base(odom_from_base),
            run_ns,
            is_uncertain: self.localiser.is_uncertain(),
        };
        let step = relocaliser.follow(&sight, |point| !tracker.may_be_dynamic_at(point, run_ns));
        Some(Checked {
            step,
            odom_from_base: *odom_from_base,
        })
    }

    /// True while the robot does not know where it is.
    #[must_use]
    pub fn is_uncertain(&self) -> bool {
        self.localiser.is_uncertain()
    }

    /// How far a robot that does not know where it is has been looked for.
    #[must_use]
    pub fn sought(&self) -> Sought {
        self.relocaliser
            .as_ref()
            .map_or(Sought::Not, Relocaliser::sought)
    }

    /// `map_from_odom`, and the covariance of the robot's pose with it, at the last scan.
    #[must_use]
    pub fn map_from_odom(&self) -> (Pose, [f64; 6]) {
        let covariance = self.localiser.covariance(self.is_confirmed);
        (self.localiser.map_from_odom(), covariance)
    }
}
