//! The score of BARN (Xu et al., `The BARN Challenge`): a success counts OT / T, where T is cut to
//! between 2 OT (4 OT until 2023) and 8 OT, so 0.5 (0.25) is the most.

/// Bounds of the two rules, in OT.
pub(super) const RULES: [f64; 2] = [2.0, 4.0];

/// Upper bound of the time, in OT.
const SLOWEST: f64 = 8.0;

/// Score of one run: `optimal_time_s` = OT, `fastest` = lower bound of the time in OT.
#[must_use]
pub(super) fn score(success: bool, optimal_time_s: f64, time_s: f64, fastest: f64) -> f64 {
    if !(success && optimal_time_s > 0.0 && time_s.is_finite()) {
        return 0.0;
    }
    optimal_time_s / time_s.clamp(fastest * optimal_time_s, SLOWEST * optimal_time_s)
}

/// Mean over the worlds of the mean over their runs, as the benchmark has it: `runs` are worlds
/// and values in any order. `None` without runs.
#[must_use]
pub(super) fn mean_of_worlds<'a>(runs: impl Iterator<Item = (&'a str, f64)>) -> Option<f64> {
    let mut worlds = std::collections::BTreeMap::<&str, (f64, u32)>::new();
    for (world, value) in runs {
        let (sum, n) = worlds.entry(world).or_default();
        *sum += value;
        *n += 1;
    }
    let n_worlds = u32::try_from(worlds.len()).unwrap_or(u32::MAX);
    let sum: f64 = worlds.values().map(|(sum, n)| sum / f64::from(*n)).sum();
    (n_worlds > 0).then(|| sum / f64::from(n_worlds))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn close(value: f64, golden: f64) {
        assert!((value - golden).abs() < 1e-9, "{value}, not {golden}");
    }

    /// By hand, with the OT of world 1, 6.2156 s: 2 OT = 12.4312, 4 OT = 24.8624, 8 OT = 49.7248.
    #[test]
    fn the_score_is_that_of_the_benchmark() {
        let ot_s = 6.2156;
        // Faster than 2 OT is no better than 2 OT.
        close(score(true, ot_s, 8.0, 2.0), 0.5);
        close(score(true, ot_s, 12.4312, 2.0), 0.5);
        close(score(true, ot_s, 8.0, 4.0), 0.25);
        // 6.2156 / 20 = 0.31078; below 4 OT the older rule still gives all.
        close(score(true, ot_s, 20.0, 2.0), 0.31078);
        close(score(true, ot_s, 20.0, 4.0), 0.25);
        // 6.2156 / 31.078 = 0.2 by both.
        close(score(true, ot_s, 31.078, 2.0), 0.2);
        close(score(true, ot_s, 31.078, 4.0), 0.2);
        // Slower than 8 OT is no worse than 8 OT.
        close(score(true, ot_s, 99.0, 2.0), 0.125);
        close(score(true, ot_s, 99.0, 4.0), 0.125);
        close(score(false, ot_s, 8.0, 2.0), 0.0);
    }

    #[test]
    fn worlds_count_alike_however_many_runs_they_have() {
        let runs = [("a", 0.5), ("a", 0.5), ("a", 0.2), ("b", 0.0)];
        // (1.2 / 3 + 0) / 2.
        close(mean_of_worlds(runs.into_iter()).unwrap(), 0.2);
        assert_eq!(mean_of_worlds(core::iter::empty()), None);
    }
}
