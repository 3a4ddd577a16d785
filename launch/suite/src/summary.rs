//! All runs of a suite, or of one class of its worlds, in a few numbers.

use super::row::Row;
use super::score::mean_of_worlds;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// The numbers. Rates and means are means over the worlds of the means over their runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// Worlds.
    pub worlds: usize,
    /// Runs.
    pub runs: usize,
    /// Share of successes.
    pub success: f64,
    /// Score by the rule of 2 OT, 0 to 0.5.
    pub score: Option<f64>,
    /// Score by the rule of 4 OT, 0 to 0.25.
    pub score_4ot: Option<f64>,
    /// Runs with a contact that began while the robot moved.
    pub contacts_moving: usize,
    /// Runs with a contact that began while it stood.
    pub contacts_standing: usize,
    /// Runs with a contact that began while the robot moved and that an oracle who knows every
    /// future could have avoided.
    pub contacts_own_fault: usize,
    /// Contacts that began while the robot moved and that the oracle could not avoid either; null
    /// where the future depends on the robot.
    pub unavoidable: Option<u32>,
    /// Share of the runs in which the robot came to its goal in time, whatever it touched.
    pub arrival: f64,
    /// The same where a way of the robot's outline was found among what stands; null where none was looked
    /// for.
    pub arrival_where_a_way_exists: Option<f64>,
    /// Runs in which the robot said that it had arrived and had not.
    pub wrong_arrivals: usize,
    /// Runs whose time was over.
    pub timeouts: usize,
    /// Runs that may go otherwise the next time.
    pub not_reproducible: usize,
    /// Time of the successes. [s]
    pub mean_time_s: Option<f64>,
    /// The same by the benchmark's clock, where it has one. [s]
    pub mean_clock_s: Option<f64>,
    /// Run time per time of the outline's way at top speeds, of the successes.
    pub mean_time_ratio: Option<f64>,
    /// Distance driven per length of reference, of the successes.
    pub mean_path_ratio: Option<f64>,
    /// Smallest clearance of all runs. [m]
    pub clearance_m_min: Option<f64>,
    /// Mean of the runs' smallest clearances. [m]
    pub mean_clearance_m_min: Option<f64>,
    /// Sum of the changes of direction of a track, of the successes. [rad]
    pub mean_turning_rad: Option<f64>,
    /// Mean absolute jerk of the true forward speed, of the successes. [m/s^3]
    pub mean_jerk_mps3: Option<f64>,
    /// Largest error of the robot's pose at the end of a success. [m]
    pub pose_error_m_max: Option<f64>,
    /// The same of its yaw. [rad]
    pub pose_error_rad_max: Option<f64>,
    /// Interventions of the collision guard in all runs.
    pub interventions: Option<u64>,
    /// Manoeuvres and waits of the recovery in all runs.
    pub recoveries: Option<u64>,
    /// Failures by cause.
    pub causes: BTreeMap<String, usize>,
}

impl Summary {
    /// The numbers of these rows.
    #[must_use]
    pub fn of(rows: &[&Row]) -> Self {
        let mean = |value: &dyn Fn(&Row) -> Option<f64>| {
            mean_of_worlds(
                rows.iter()
                    .filter_map(|row| Some((row.world.as_str(), value(row)?))),
            )
        };
        let of_success = |value: fn(&Row) -> Option<f64>| {
            mean(&move |row| row.success.then(|| value(row)).flatten())
        };
        let most = |value: fn(&Row) -> Option<f64>| {
            let successes = rows.iter().filter(|row| row.success);
            successes.filter_map(|row| value(row)).reduce(f64::max)
        };
        let count = |is: &dyn Fn(&Row) -> bool| rows.iter().filter(|row| is(row)).count();
        let total = |number: &dyn Fn(&Row) -> Option<u64>| {
            let numbers = rows.iter().filter_map(|row| number(row));
            numbers.reduce(u64::saturating_add)
        };
        let mut causes = BTreeMap::new();
        for cause in rows.iter().filter_map(|row| row.cause.clone()) {
            *causes.entry(cause).or_default() += 1;
        }
        let worlds: BTreeSet<&str> = rows.iter().map(|row| row.world.as_str()).collect();
        Self {
            worlds: worlds.len(),
            runs: rows.len(),
            success: mean(&|row| Some(f64::from(u8::from(row.success)))).unwrap_or(0.0),
            score: mean(&|row| row.score),
            score_4ot: mean(&|row| row.score_4ot),
            contacts_moving: count(&|row| row.contacts_moving > 0),
            contacts_standing: count(&|row| row.contacts_standing > 0),
            contacts_own_fault: count(&Row::is_at_fault),
            unavoidable: rows
                .iter()
                .filter_map(|row| row.unavoidable)
                .reduce(u32::saturating_add),
            arrival: mean(&|row| Some(f64::from(u8::from(row.arrived)))).unwrap_or(0.0),
            arrival_where_a_way_exists: mean(&|row| {
                (row.way_exists == Some(true)).then_some(f64::from(u8::from(row.arrived)))
            }),
            wrong_arrivals: count(&|row| row.wrong_arrival),
            timeouts: count(&Row::is_timeout),
            not_reproducible: count(&|row| row.not_reproducible.is_some()),
            mean_time_s: of_success(|row| row.time_s),
            mean_clock_s: of_success(|row| row.clock_s),
            mean_time_ratio: of_success(|row| row.time_ratio),
            mean_path_ratio: of_success(|row| row.path_ratio),
            clearance_m_min: rows
                .iter()
                .filter_map(|row| row.clearance_m_min)
                .reduce(f64::min),
            mean_clearance_m_min: mean(&|row| row.clearance_m_min),
            mean_turning_rad: of_success(|row| row.turning_rad),
            mean_jerk_mps3: of_success(|row| row.jerk_mps3),
            pose_error_m_max: most(|row| row.pose_error_m),
            pose_error_rad_max: most(|row| row.pose_error_rad),
            interventions: total(&|row| row.interventions),
            recoveries: total(&|row| row.recoveries),
            causes,
        }
    }
}
