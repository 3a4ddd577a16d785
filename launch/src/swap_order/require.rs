//! What a newcomer has to reach: `p99<2ms, agree>0.95`.

use core::fmt;
use serde::{Deserialize, Serialize};
use zeronav_measure::result::swap::Comparison;

/// Fewest answers that a median is taken of, and a 99th percentile at the end of the comparison.
const ANSWERS_MIN: u64 = 20;

/// Fewest answers of which a 99th percentile takes the seat from a newcomer that has it: of fewer,
/// it is the slowest answer.
const P99_ANSWERS_MIN: u64 = 100;

/// A figure that can be required.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Figure {
    /// Median of the times from wake to answer.
    P50,
    /// 99th percentile of them.
    P99,
    /// Share of ticks on which both agree.
    Agree,
}

/// One requirement.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Clause {
    /// Of what.
    pub figure: Figure,
    /// Times stay below it [us], shares above it.
    pub limit: f64,
}

impl Clause {
    /// Reads `p50<TIME`, `p99<TIME` and `agree>SHARE`, separated by commas.
    ///
    /// # Errors
    /// What is wrong with the text.
    pub(crate) fn parse_all(text: &str) -> Result<Vec<Self>, String> {
        text.split(',')
            .map(|clause| Self::parse(clause.trim()))
            .collect()
    }

    fn parse(text: &str) -> Result<Self, String> {
        let wrong = || format!("`{text}` is none of p50<2ms, p99<2ms, agree>0.95");
        if let Some(share) = text.strip_prefix("agree>") {
            let limit: f64 = share.trim().parse().map_err(|_| wrong())?;
            if !(0.0..=1.0).contains(&limit) {
                return Err(format!("`{text}`: a share lies between 0 and 1"));
            }
            let figure = Figure::Agree;
            return Ok(Self { figure, limit });
        }
        let (figure, time) = text.split_once('<').ok_or_else(wrong)?;
        let figure = match figure.trim() {
            "p50" => Figure::P50,
            "p99" => Figure::P99,
            _ => return Err(wrong()),
        };
        let time = time.trim();
        let units = [("us", 1.0), ("ms", 1.0e3), ("s", 1.0e6)];
        let (number, unit_us) = units
            .iter()
            .find_map(|(unit, us)| Some((time.strip_suffix(unit)?, us)))
            .ok_or_else(|| format!("`{text}`: the time needs its unit, us, ms or s"))?;
        let limit = number.trim().parse::<f64>().map_err(|_| wrong())? * unit_us;
        if !(limit > 0.0 && limit.is_finite()) {
            return Err(format!("`{text}`: a time is above 0"));
        }
        Ok(Self { figure, limit })
    }

    /// True for times, which depend on the machine.
    pub(crate) fn is_timed(&self) -> bool {
        matches!(self.figure, Figure::P50 | Figure::P99)
    }

    /// Why `comparison` does not meet it. A figure that does not exist yet meets nothing when
    /// `is_final`, and everything before.
    pub(crate) fn missed(&self, comparison: &Comparison, is_final: bool) -> Option<String> {
        let times = &comparison.newcomer;
        let p99_min = if is_final {
            ANSWERS_MIN
        } else {
            P99_ANSWERS_MIN
        };
        let figure = match self.figure {
            Figure::P50 => times.p50_us.filter(|_| times.n >= ANSWERS_MIN),
            Figure::P99 => times.p99_us.filter(|_| times.n >= p99_min),
            Figure::Agree => comparison.agree,
        };
        let Some(figure) = figure else {
            return is_final.then(|| format!("{self} cannot be said after {} answers", times.n));
        };
        let (is_met, unit) = if self.is_timed() {
            (figure < self.limit, " us")
        } else {
            (figure > self.limit, "")
        };
        (!is_met).then(|| format!("{self} is not met: {figure:.3}{unit}"))
    }
}

impl fmt::Display for Clause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.figure {
            Figure::P50 => write!(f, "p50<{}us", self.limit),
            Figure::P99 => write!(f, "p99<{}us", self.limit),
            Figure::Agree => write!(f, "agree>{}", self.limit),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_measure::result::swap::AnswerTimes;

    #[test]
    fn requirements_are_read_with_their_units() {
        let clauses = Clause::parse_all("p99<2ms, agree>0.95,p50 < 300us").expect("requirements");
        let limits: Vec<f64> = clauses.iter().map(|clause| clause.limit).collect();
        assert_eq!(limits, [2000.0, 0.95, 300.0]);
        for wrong in [
            "",
            "p99",
            "p99<2",
            "p99>2ms",
            "agree>2",
            "p98<1ms",
            "p99<-1ms",
            "p99<NaNms",
        ] {
            assert!(Clause::parse_all(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_figure_is_met_or_not_and_a_missing_one_only_fails_at_the_end() {
        let clause = Clause::parse("p99<2ms").expect("a requirement");
        let of = |n, p99_us| Comparison {
            newcomer: AnswerTimes {
                n,
                p50_us: None,
                p99_us,
            },
            ..Comparison::default()
        };
        assert_eq!(clause.missed(&of(100, Some(1999.0)), true), None);
        assert!(clause.missed(&of(100, Some(2001.0)), false).is_some());
        assert_eq!(clause.missed(&of(99, Some(2001.0)), false), None);
        assert!(clause.missed(&of(20, Some(2001.0)), true).is_some());
        assert!(clause.missed(&of(3, Some(1.0)), true).is_some());
    }
}
