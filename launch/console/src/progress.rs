//! What is said while a run or a suite goes on: one line that changes on a terminal, elsewhere a
//! line every five seconds.

use super::terminal::{note, show_line};
use core::fmt;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::time::{Duration, Instant};
use zeronav_casts::Cast;

/// Between two lines where there is no terminal.
const PAUSE: Duration = Duration::from_secs(5);

/// How far the trials or the runs of a suite are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tally {
    /// What is over, of all rounds.
    pub done: usize,
    /// What is to be done in all.
    pub total: usize,
    /// Wall time that one takes; `None` before the first is over. [s]
    pub each_s: Option<f64>,
}

/// What the line says of a run.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Progress {
    /// Run time. [s]
    pub time_s: f64,
    /// State of the task.
    pub state: String,
    /// Way left. [m]
    pub remaining_m: Option<f64>,
    /// Last new path: run time and cause. [s]
    pub last_replan: Option<(f64, String)>,
    /// The trials, if that is what the run is for.
    pub trials: Option<Tally>,
}

/// The line. Silent when it is not wanted.
#[derive(Debug)]
pub struct ProgressLine {
    title: String,
    shown: Shown,
}

#[derive(Debug)]
enum Shown {
    Not,
    OnTerminal(ProgressBar),
    /// When the last line was written.
    AsLines(Instant),
}

impl ProgressLine {
    /// A line for what has this title.
    #[must_use]
    pub fn new(title: &str, wanted: bool) -> Self {
        let shown = if !wanted {
            Shown::Not
        } else if std::io::stderr().is_terminal() {
            Shown::OnTerminal(bar(title))
        } else {
            Shown::AsLines(Instant::now())
        };
        Self {
            title: title.to_owned(),
            shown,
        }
    }

    /// Shows the newest state.
    pub fn show<M: fmt::Display>(&mut self, message: impl FnOnce() -> M) {
        match &mut self.shown {
            Shown::Not => {}
            Shown::OnTerminal(bar) => {
                bar.set_message(message().to_string());
                bar.tick();
            }
            Shown::AsLines(last) => {
                if last.elapsed() >= PAUSE {
                    *last = Instant::now();
                    note(&format!("{}  {}", self.title, message()));
                }
            }
        }
    }

    /// Takes the line away.
    pub fn clear(&mut self) {
        if let Shown::OnTerminal(bar) = core::mem::replace(&mut self.shown, Shown::Not) {
            bar.finish_and_clear();
            show_line(None);
        }
    }
}

impl Drop for ProgressLine {
    fn drop(&mut self) {
        self.clear();
    }
}

/// It is drawn when there is something to show, by no thread of its own: there may be no room for one.
fn bar(title: &str) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(10));
    if let Ok(style) = ProgressStyle::with_template("{spinner} {prefix}  {msg}") {
        bar.set_style(style);
    }
    bar.set_prefix(title.to_owned());
    show_line(Some(bar.clone()));
    bar
}

impl fmt::Display for Progress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(trials) = self.trials {
            return write!(f, "{}", trials.in_words("trials"));
        }
        write!(f, "{:7.2} s  {}", self.time_s, self.state)?;
        if let Some(way_m) = self.remaining_m {
            write!(f, "  {way_m:.1} m to go")?;
        }
        if let Some((time_s, cause)) = &self.last_replan {
            write!(f, "  last path {time_s:.2} s ({cause})")?;
        }
        Ok(())
    }
}

impl Tally {
    /// "300 runs, 2 at a time: about 5.0 min", for what takes a minute and more; nothing before the time
    /// that one takes is known.
    #[must_use]
    pub fn estimate(&self, what: &str, at_a_time: usize) -> Option<String> {
        let whole_s = self.each_s? * self.total.to_f64();
        (whole_s >= 60.0).then(|| {
            let (total, minutes) = (self.total, whole_s / 60.0);
            format!("{total} {what}, {at_a_time} at a time: about {minutes:.1} min")
        })
    }

    /// "37 of 200 trials, about 4.2 min left"; nothing about the time before it can be known.
    #[must_use]
    pub fn in_words(&self, what: &str) -> String {
        let left = self.total.saturating_sub(self.done).to_f64();
        let time = self.each_s.map_or_else(String::new, |each_s| {
            format!(", about {:.1} min left", left * each_s / 60.0)
        });
        format!("{} of {} {what}{time}", self.done, self.total)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_left_is_said_once_it_can_be_known() {
        let mut tally = Tally {
            done: 0,
            total: 300,
            each_s: None,
        };
        assert_eq!(tally.in_words("runs"), "0 of 300 runs");
        (tally.done, tally.each_s) = (60, Some(2.0));
        assert_eq!(tally.in_words("runs"), "60 of 300 runs, about 8.0 min left");
    }

    #[test]
    fn what_takes_a_minute_says_so_once_that_is_known() {
        let estimate = |total, each_s| {
            let tally = Tally {
                done: 2,
                total,
                each_s,
            };
            tally.estimate("runs", 2)
        };
        assert_eq!(estimate(300, None), None);
        assert_eq!(estimate(60, Some(0.999)), None);
        let said = |text: &str| Some(text.to_owned());
        assert_eq!(
            estimate(60, Some(1.0)),
            said("60 runs, 2 at a time: about 1.0 min")
        );
        assert_eq!(
            estimate(900, Some(0.5)),
            said("900 runs, 2 at a time: about 7.5 min")
        );
    }

    #[test]
    fn a_run_says_where_it_is() {
        let progress = Progress {
            time_s: 6.3,
            state: "active".to_owned(),
            remaining_m: Some(30.94),
            last_replan: Some((6.3, "obstacle".to_owned())),
            trials: None,
        };
        assert_eq!(
            progress.to_string(),
            "   6.30 s  active  30.9 m to go  last path 6.30 s (obstacle)"
        );
    }
}
