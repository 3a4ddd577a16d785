//! The zones that launch keeps for the run.

use std::time::Instant;
use zeronav_msgs::zones::{ZonePart, Zones};
use zeronav_scenario::zones::{ReadZone, ZoneSpec};

/// The zones that hold, as they are sent.
#[derive(Debug, Default)]
pub(crate) struct ZoneStore {
    pub(crate) zones: Vec<ReadZone>,
    pub(crate) message: Zones,
    pub(crate) parts: Vec<ZonePart>,
    /// When they were sent last.
    pub(crate) sent: Option<Instant>,
}

impl ZoneStore {
    /// As they were said.
    pub(crate) fn specs(&self) -> Vec<ZoneSpec> {
        self.zones.iter().map(|zone| zone.spec.clone()).collect()
    }
}
