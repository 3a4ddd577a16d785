//! Whether the robot comes closer to its goal.

use zeronav_msgs::time::seconds;

/// The progress checker of one goal.
///
/// Coming closer is measured along the path. Another geometry is measured from its beginning, but the time goes
/// on: a planner that changes its mind every second must not look like progress.
/// The time begins with the first step, so that a process that comes to a task later does not count what it did not
/// see.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Stall {
    since_ns: u64,
    geometry: u64,
    /// Smallest rest of the path when the time was reset last. [m]
    best_m: Option<f64>,
}

impl Stall {
    /// Takes in the rest of the path and says for how long the robot has not come closer by
    /// `progress_m`. [s]
    pub(crate) fn step(
        &mut self,
        run_ns: u64,
        geometry: u64,
        remaining_m: f64,
        progress_m: f64,
    ) -> f64 {
        match self.best_m {
            Some(best_m) if geometry == self.geometry => {
                if remaining_m <= best_m - progress_m {
                    self.best_m = Some(remaining_m);
                    self.since_ns = run_ns;
                }
            }
            before => {
                if before.is_none() {
                    self.since_ns = run_ns;
                }
                self.geometry = geometry;
                self.best_m = Some(remaining_m);
            }
        }
        seconds(run_ns.saturating_sub(self.since_ns))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: u64 = 1_000_000_000;

    #[test]
    fn coming_closer_resets_the_time_and_creeping_does_not() {
        let mut stall = Stall::default();
        assert!(stall.step(0, 1, 5.0, 0.1) < 1e-9);
        assert!((stall.step(3 * S, 1, 4.95, 0.1) - 3.0).abs() < 1e-9);
        assert!(stall.step(4 * S, 1, 4.89, 0.1) < 1e-9);
        assert!((stall.step(6 * S, 1, 4.85, 0.1) - 2.0).abs() < 1e-9);
    }

    #[test]
    fn a_new_path_is_measured_anew_while_the_time_goes_on() {
        let mut stall = Stall::default();
        for i in 0..20 {
            let longer = if i % 2 == 0 { 5.0 } else { 9.0 };
            let stalled_s = stall.step(i * S, i, longer, 0.1);
            assert!((stalled_s - f64::from(u32::try_from(i).unwrap_or(0))).abs() < 1e-9);
        }
        // A detour that is driven is progress.
        assert!(stall.step(30 * S, 99, 9.0, 0.1) > 29.0);
        assert!(stall.step(31 * S, 99, 8.8, 0.1) < 1e-9);
    }
}
