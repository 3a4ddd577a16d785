//! Where the trials of a run are made.

use crate::prepare::Prepared;
use crate::shuttle::{Course, Quota, Shuttle};
use zeronav_measure::DEADLINE_NS;

/// The trials of `prepared`'s scenario; `None` when it has none.
pub(super) fn shuttle(prepared: &Prepared, quota: Quota) -> Option<Shuttle<'_>> {
    let course = Course {
        spec: prepared.scenario.trials.as_ref()?,
        world: &prepared.world,
        radius_m: prepared.footprint.inscribed_radius_m(),
        scan_period_ns: prepared.scan_period_ns(),
        deadline_ns: DEADLINE_NS,
    };
    Shuttle::new(course, quota.n, quota.seed)
}
