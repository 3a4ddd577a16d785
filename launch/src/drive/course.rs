//! Where the trials of a run are made.

use crate::prepare::Prepared;
use crate::trial_runner::{Course, Quota, TrialRunner};
use zeronav_measure::DEADLINE_NS;

/// The trials of `prepared`'s scenario; `None` when it has none.
pub(super) fn trial_runner(prepared: &Prepared, quota: Quota) -> Option<TrialRunner<'_>> {
    let course = Course {
        spec: prepared.scenario.trials.as_ref()?,
        world: &prepared.world,
        radius_m: prepared.footprint.inscribed_radius_m(),
        scan_period_ns: prepared.scan_period_ns(),
        deadline_ns: DEADLINE_NS,
    };
    TrialRunner::new(course, quota.n, quota.seed)
}
