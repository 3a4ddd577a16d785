//! Where a run stands.

use core::str::FromStr;

/// A moment of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Moment {
    /// Before this tick; the first one is 1.
    Tick(u64),
    /// Before the first tick at or after this run time. [s]
    Time(f64),
}

impl FromStr for Moment {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || {
            format!("`{text}` is neither a tick from 1 on, such as 412, nor a time, such as 20.6s")
        };
        let moment = match text.strip_suffix('s') {
            Some(time) => time.parse().ok().map(Self::Time),
            None if text.contains('.') => text.parse().ok().map(Self::Time),
            None => text.parse().ok().map(Self::Tick),
        };
        let is_one = |moment: &Self| match moment {
            Self::Tick(tick) => *tick >= 1,
            Self::Time(time_s) => time_s.is_finite() && *time_s >= 0.0,
        };
        moment.filter(is_one).ok_or_else(wrong)
    }
}

impl Moment {
    /// The tick before which it is, with ticks of this length. [ns]
    pub(super) fn tick(self, tick_ns: u64) -> u64 {
        let tick = match self {
            Self::Tick(tick) => tick,
            Self::Time(time_s) => zeronav_msgs::time::nanoseconds(time_s).div_ceil(tick_ns.max(1)),
        };
        tick.max(1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_moment_is_a_tick_or_a_time() {
        let tick = |text: &str| text.parse::<Moment>().map(|moment| moment.tick(50_000_000));
        for (text, expected) in [
            ("1", 1),
            ("412", 412),
            ("20.6s", 412),
            ("20.61s", 413),
            ("3s", 60),
            ("0.02", 1),
            ("0s", 1),
        ] {
            assert_eq!(tick(text), Ok(expected), "{text}");
        }
        for wrong in [
            "",
            "0",
            "-1",
            "s",
            "1e400s",
            "nans",
            "-0.5s",
            "1x",
            "18446744073709551616",
        ] {
            let why = tick(wrong).expect_err(wrong);
            assert!(why.contains("412") && why.contains("20.6s"), "{why}");
        }
    }
}
