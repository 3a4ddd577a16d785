//! A measure of two runs, and by how much it differs.

use super::html::{number, time};
use core::fmt::Write;

/// What a number means, and how it is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Unit {
    /// A count.
    Count,
    /// [s]
    Seconds,
    /// [m]
    Metres,
    /// [m/s^3]
    Jerk,
    /// [us], written in a unit that fits.
    Time,
    /// [bytes], written as MB.
    Bytes,
}

/// One measure of one run.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Measure {
    /// Its value; `None` when the run has none.
    pub value: Option<f64>,
    /// For an estimate from samples: its interval at 95 %, and how many there are.
    pub estimate: Option<(Option<[f64; 2]>, u64)>,
}

/// How two measures differ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Difference {
    /// One of them is missing.
    Unknown,
    /// Estimates without intervals cannot be told apart.
    TooFew,
    /// The same number, or intervals that overlap.
    None,
    /// The second less the first.
    By(f64),
}

impl Measure {
    /// A number that is what it is.
    pub(super) fn exact(value: impl Into<Option<f64>>) -> Self {
        Self {
            value: value.into().filter(|value| value.is_finite()),
            estimate: None,
        }
    }

    /// An estimate from `n` samples.
    pub(super) fn estimate(value: Option<f64>, interval: Option<[f64; 2]>, n: u64) -> Self {
        Self {
            value: value.filter(|value| value.is_finite()),
            estimate: Some((interval, n)),
        }
    }

    /// How `other` differs from this.
    pub(super) fn to(&self, other: &Self) -> Difference {
        let Some((first, second)) = self.value.zip(other.value) else {
            return Difference::Unknown;
        };
        if self.estimate.is_some() || other.estimate.is_some() {
            let intervals = [self.estimate, other.estimate].map(|of| of.and_then(|of| of.0));
            let [Some([a_low, a_high]), Some([b_low, b_high])] = intervals else {
                return Difference::TooFew;
            };
            if a_low <= b_high && b_low <= a_high {
                return Difference::None;
            }
        }
        let by = second - first;
        if by.abs() <= 1.0e-9 * first.abs() {
            Difference::None
        } else {
            Difference::By(by)
        }
    }

    /// The value in words.
    pub(super) fn text(&self, unit: Unit) -> String {
        let Some(value) = self.value else {
            return "–".to_owned();
        };
        let mut text = written(value, unit);
        if let Some((interval, n)) = self.estimate {
            if let Some([low, high]) = interval {
                let _ = write!(text, " [{}, {}]", written(low, unit), written(high, unit));
            }
            let _ = write!(text, ", n = {n}");
        }
        text
    }
}

impl Difference {
    /// In words, with its sign, relative to the value `first`.
    pub(super) fn text(self, unit: Unit, first: Option<f64>) -> String {
        match self {
            Self::Unknown => String::new(),
            Self::TooFew => "too few samples".to_owned(),
            Self::None => "no difference".to_owned(),
            // Less than what is written.
            Self::By(by) if written(by.abs(), unit) == written(0.0, unit) => {
                Self::None.text(unit, first)
            }
            Self::By(by) => {
                let sign = if by < 0.0 { "−" } else { "+" };
                let share = match first {
                    Some(first) if first.abs() > 0.0 && unit != Unit::Count => {
                        let percent = 100.0 * (by / first).abs();
                        format!(" ({sign}{} %)", number(percent, 1))
                    }
                    _ => String::new(),
                };
                format!("{sign}{}{share}", written(by.abs(), unit))
            }
        }
    }
}

fn written(value: f64, unit: Unit) -> String {
    match unit {
        Unit::Count => number(value, 0),
        Unit::Seconds => format!("{} s", number(value, 2)),
        Unit::Metres => format!("{} m", number(value, 2)),
        Unit::Jerk => format!("{} m/s³", number(value, 2)),
        Unit::Time => time(value),
        Unit::Bytes => format!("{} MB", number(value / 1.0e6, 1)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn estimate(value: f64, interval: [f64; 2]) -> Measure {
        Measure::estimate(Some(value), Some(interval), 200)
    }

    #[test]
    fn differences_have_a_sign_and_overlapping_intervals_none() {
        let first = estimate(430.0, [425.0, 436.0]);
        let slower = estimate(460.0, [450.0, 470.0]);
        let alike = estimate(440.0, [436.0, 444.0]);
        assert_eq!(first.to(&slower), Difference::By(30.0));
        assert_eq!(slower.to(&first), Difference::By(-30.0));
        assert_eq!(first.to(&alike), Difference::None);
        assert_eq!(first.to(&first), Difference::None);
        let text = first.to(&slower).text(Unit::Time, first.value);
        assert_eq!(text, "+30 µs (+7.0 %)");
        let text = slower.to(&first).text(Unit::Time, slower.value);
        assert_eq!(text, "−30 µs (−6.5 %)");
        assert_eq!(first.text(Unit::Time), "430 µs [425 µs, 436 µs], n = 200");
    }

    #[test]
    fn estimates_without_intervals_are_not_compared() {
        let few = Measure::estimate(Some(1629.0), None, 1);
        assert_eq!(few.to(&few), Difference::TooFew);
        assert_eq!(few.to(&estimate(1.0, [0.5, 1.5])), Difference::TooFew);
        assert_eq!(few.to(&Measure::default()), Difference::Unknown);
        assert_eq!(few.text(Unit::Time), "1.63 ms, n = 1");
    }

    #[test]
    fn exact_numbers_differ_by_what_they_differ() {
        let (one, three) = (Measure::exact(1.0), Measure::exact(3.0));
        assert_eq!(one.to(&three).text(Unit::Count, one.value), "+2");
        assert_eq!(
            three.to(&one).text(Unit::Metres, three.value),
            "−2.00 m (−66.7 %)"
        );
        assert_eq!(one.to(&one), Difference::None);
        assert_eq!(Measure::exact(f64::NAN).to(&one), Difference::Unknown);
        let hardly = Measure::exact(1.004);
        let text = one.to(&hardly).text(Unit::Metres, one.value);
        assert_eq!(text, "no difference", "to the centimetre");
        let zero = Measure::exact(0.0);
        assert_eq!(zero.to(&one).text(Unit::Seconds, zero.value), "+1.00 s");
        assert_eq!(zero.to(&zero), Difference::None);
    }
}
