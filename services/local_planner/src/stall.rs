//! Whether the robot comes closer to its goal.

use core::f64::consts::TAU;
use zeronav_msgs::pose::wrap_angle;
use zeronav_msgs::time::seconds;

/// Turn on the spot that counts as progress. [rad]
const PROGRESS_RAD: f64 = 0.1;

/// The progress checker of one goal.
///
/// Coming closer is measured along the path. Another geometry is measured from its beginning, but the time goes
/// on: a planner that changes its mind every second must not look like progress. Turning on the spot towards the
/// path or the goal's yaw is progress, too, for a full turn in sum: a robot that turns slowly needs its time, and
/// one that rocks to and fro uses it up.
/// The time begins with the first step, so that a process that comes to a task later does not count what it did not
/// see.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Stall {
    since_ns: u64,
    geometry: u64,
    /// Smallest rest of the path when the time was reset last. [m]
    best_m: Option<f64>,
    /// The last step.
    now_ns: u64,
    /// When the last turn counted.
    turned_ns: u64,
    /// Turned on the spot since it came closer. [rad]
    turned_rad: f64,
    /// Yaw from which the turn that goes on is measured. [rad]
    from_rad: Option<f64>,
}

/// How long there has been none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stalled {
    /// [s] without coming closer.
    pub(crate) far_s: f64,
    /// [s] without coming closer and without a turn that counts.
    pub(crate) idle_s: f64,
    /// It has come closer in this step.
    pub(crate) closer: bool,
}

impl Stall {
    /// Takes in the rest of the path, infinite while that is not known, and the yaw at which the robot turns on the spot, if
    /// it does, and says for how long it has not come closer by `progress_m`. To know the rest again is to come closer.
    pub(crate) fn step(
        &mut self,
        run_ns: u64,
        (geometry, remaining_m): (u64, f64),
        turning_rad: Option<f64>,
        progress_m: f64,
    ) -> Stalled {
        self.now_ns = run_ns;
        let mut closer = false;
        match self.best_m {
            Some(best_m)
                if remaining_m.is_finite()
                    && (geometry == self.geometry || best_m.is_infinite()) =>
            {
                closer = remaining_m <= best_m - progress_m;
                self.geometry = geometry;
                if closer {
                    self.best_m = Some(remaining_m);
                    self.since_ns = run_ns;
                    self.turned_rad = 0.0;
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
        self.turn(run_ns, turning_rad);
        let far_s = seconds(run_ns.saturating_sub(self.since_ns));
        let turned_s = seconds(run_ns.saturating_sub(self.turned_ns));
        Stalled {
            far_s,
            idle_s: far_s.min(turned_s),
            closer,
        }
    }

    fn turn(&mut self, run_ns: u64, turning_rad: Option<f64>) {
        let Some((yaw_rad, from_rad)) = turning_rad.zip(self.from_rad) else {
            self.from_rad = turning_rad;
            return;
        };
        let by_rad = wrap_angle(yaw_rad - from_rad).abs();
        if by_rad >= PROGRESS_RAD {
            self.from_rad = Some(yaw_rad);
            self.turned_rad += by_rad;
            if self.turned_rad <= TAU {
                self.turned_ns = run_ns;
            }
        }
    }

    /// The time from the last step until `run_ns` does not count: the robot waits.
    pub(crate) fn hold(&mut self, run_ns: u64) {
        let held_ns = run_ns.saturating_sub(self.now_ns);
        if self.best_m.is_some() {
            self.since_ns += held_ns;
        }
        self.turned_ns += held_ns;
        self.now_ns = run_ns;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: u64 = 1_000_000_000;

    #[test]
    fn coming_closer_resets_the_time_and_creeping_does_not() {
        let mut stall = Stall::default();
        let mut far_s = |run_ns, remaining_m| stall.step(run_ns, (1, remaining_m), None, 0.1).far_s;
        assert!(far_s(0, 5.0) < 1e-9);
        assert!((far_s(3 * S, 4.95) - 3.0).abs() < 1e-9);
        assert!(far_s(4 * S, 4.89) < 1e-9);
        assert!((far_s(6 * S, 4.85) - 2.0).abs() < 1e-9);
    }

    #[test]
    fn who_does_not_know_the_rest_comes_no_closer_before_it_does() {
        let mut stall = Stall::default();
        let mut step = |run_ns, on| stall.step(run_ns, on, None, 0.1);
        step(0, (1, 5.0));
        for s in 1..20_u32 {
            let unknown = step(u64::from(s) * S, (u64::from(s % 2), f64::INFINITY));
            assert!(!unknown.closer && (unknown.far_s - f64::from(s)).abs() < 1e-9);
        }
        let known = step(20 * S, (7, 9.0));
        assert!(known.closer && known.far_s < 1e-9, "{known:?}");
        assert!(!step(21 * S, (7, 8.95)).closer && step(22 * S, (7, 8.89)).closer);
    }

    #[test]
    fn a_new_path_is_measured_anew_while_the_time_goes_on() {
        let mut stall = Stall::default();
        for i in 0..20 {
            let longer = if i % 2 == 0 { 5.0 } else { 9.0 };
            let stalled_s = stall.step(i * S, (i, longer), None, 0.1).idle_s;
            assert!((stalled_s - f64::from(u32::try_from(i).unwrap_or(0))).abs() < 1e-9);
        }
        // A detour that is driven is progress.
        assert!(stall.step(30 * S, (99, 9.0), None, 0.1).far_s > 29.0);
        assert!(stall.step(31 * S, (99, 8.8), None, 0.1).far_s < 1e-9);
    }

    #[test]
    fn a_turn_on_the_spot_counts_once_around_and_no_more() {
        let mut stall = Stall::default();
        // 0.08 rad/s, with noise; the yaw wraps.
        let mut idle_s = |at_s: u64, turns: bool| {
            let seconds = f64::from(u32::try_from(at_s).unwrap_or(0));
            let yaw_rad = wrap_angle(0.08 * seconds + 0.01 * (3.0 * seconds).sin());
            let stalled = stall.step(at_s * S, (1, 5.0), turns.then_some(yaw_rad), 0.1);
            assert!((stalled.far_s - seconds).abs() < 1e-9, "it comes no closer");
            stalled.idle_s
        };
        assert!((0..=78).all(|at_s| idle_s(at_s, true) < 3.5));
        assert!(
            (79..=100)
                .map(|at_s| idle_s(at_s, true))
                .fold(0.0, f64::max)
                > 20.0
        );
        // Rocking uses it up as well, and a yaw that stays is no turn.
        let mut stall = Stall::default();
        let mut idle_s =
            |at_s: u64, yaw_rad: f64| (stall.step(at_s * S, (1, 5.0), Some(yaw_rad), 0.1)).idle_s;
        let rocks = (0..60).map(|at_s| idle_s(at_s, if at_s % 2 == 0 { 0.4 } else { 0.0 }));
        assert!((43.0..46.0).contains(&rocks.last().unwrap_or(0.0)));
    }

    #[test]
    fn what_is_held_does_not_count() {
        let mut stall = Stall::default();
        stall.step(0, (1, 5.0), None, 0.1);
        stall.step(2 * S, (1, 5.0), None, 0.1);
        for at_s in 3..=12 {
            stall.hold(at_s * S);
        }
        let stalled = stall.step(13 * S, (1, 5.0), None, 0.1);
        assert!((stalled.far_s - 3.0).abs() < 1e-9 && (stalled.idle_s - 3.0).abs() < 1e-9);
    }
}
