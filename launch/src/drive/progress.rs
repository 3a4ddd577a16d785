//! How far a drive is, for the line that is shown while it goes on.

use super::session::Session;
use zeronav_casts::Cast;
use zeronav_console::progress::{Progress, Tally};
use zeronav_msgs::time::seconds;

impl Session<'_> {
    pub(super) fn progress(&self) -> Progress {
        let report = self.report();
        let trials = self.quota.zip(self.trial_runner.as_ref());
        Progress {
            trials: trials.map(|(quota, trial_runner)| Tally {
                done: quota.before + trial_runner.done(),
                total: quota.total,
                each_s: (trial_runner.done() > 0)
                    .then(|| self.begin.at.elapsed().as_secs_f64() / count(trial_runner.done())),
            }),
            time_s: seconds(self.collector.run_ns),
            state: report.map_or_else(|| "waiting".to_owned(), |report| report.state.to_string()),
            remaining_m: report.map(|report| report.remaining_m),
            last_replan: self
                .collector
                .records
                .paths
                .last()
                .map(|path| (seconds(path.run_ns), path.cause.to_string())),
        }
    }
}

fn count(n: usize) -> f64 {
    n.to_f64()
}
