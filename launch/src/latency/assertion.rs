//! What has to hold of the latencies: `replanning.p99 < 5ms, reaction.p50 < 1.1x`.
//!
//! ```text
//! expression = clause { "," clause }
//! clause     = row "." figure ( "<" | "<=" | ">" | ">=" ) number [ unit ]
//! figure     = "p50" | "p90" | "p99" | "max" | "n" | "censored"
//! unit       = "us" | "ms" | "s" | "x"
//! ```
//!
//! A row is a name of the report. Counts have no unit; `x` is the ratio to the baseline.

use core::fmt;
use zeronav_casts::Cast;
use zeronav_measure::result::latency::Figures;
use zeronav_shell::nearest::unknown;

/// A figure of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Figure {
    P50,
    P90,
    P99,
    Max,
    N,
    Censored,
}

const FIGURES: [(&str, Figure); 6] = [
    ("p50", Figure::P50),
    ("p90", Figure::P90),
    ("p99", Figure::P99),
    ("max", Figure::Max),
    ("n", Figure::N),
    ("censored", Figure::Censored),
];

impl Figure {
    pub(super) fn is_count(self) -> bool {
        matches!(self, Self::N | Self::Censored)
    }

    /// Fewest samples that it can be said of.
    pub(super) fn n_min(self) -> u64 {
        match self {
            Self::P50 => Figures::N_MIN[0],
            Self::P90 => Figures::N_MIN[1],
            Self::P99 => Figures::N_MIN[2],
            Self::Max => 1,
            Self::N | Self::Censored => 0,
        }
    }

    /// Its value: a time [us] or a count. `None` where so few samples do not tell it.
    pub(super) fn of(self, figures: &Figures) -> Option<f64> {
        let figures = figures.supported();
        match self {
            Self::P50 => figures.p50_us,
            Self::P90 => figures.p90_us,
            Self::P99 => figures.p99_us,
            Self::Max => figures.max_us,
            Self::N => Some(figures.n.to_f64()),
            Self::Censored => Some(figures.censored.to_f64()),
        }
    }

    fn label(self) -> &'static str {
        let named = FIGURES.iter().find(|(_, figure)| *figure == self);
        named.map_or("", |(name, _)| name)
    }
}

/// How a figure and its limit compare.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Comparison {
    Below,
    AtMost,
    Above,
    AtLeast,
}

const COMPARISONS: [(&str, Comparison); 4] = [
    ("<=", Comparison::AtMost),
    (">=", Comparison::AtLeast),
    ("<", Comparison::Below),
    (">", Comparison::Above),
];

/// What a limit is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Limit {
    /// A time. [us]
    Time(f64),
    /// A ratio to the baseline.
    Ratio(f64),
    /// A count.
    Count(f64),
}

/// One clause.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Clause {
    /// Name of the row.
    pub row: String,
    /// Which of its figures.
    pub figure: Figure,
    comparison: Comparison,
    /// To what it is compared.
    pub limit: Limit,
    /// The clause as it was written.
    text: String,
}

impl fmt::Display for Clause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// What is wrong with an expression, and where.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Wrong {
    /// The whole expression.
    text: String,
    /// First byte that is wrong.
    at: usize,
    why: String,
}

impl fmt::Display for Wrong {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { text, at, why } = self;
        // A line break would move the mark.
        let in_line = |text: &str| -> String {
            let plain = |letter: char| if letter.is_control() { ' ' } else { letter };
            text.chars().map(plain).collect()
        };
        let (line, why) = (in_line(text), in_line(why));
        let column = text.get(..*at).unwrap_or(text).chars().count();
        writeln!(f, "--assert: column {}: {why}", column + 1)?;
        writeln!(f, "  {line}")?;
        write!(f, "  {:column$}^", "")
    }
}

/// Most bytes of an expression.
const BYTES_MAX: usize = 10_000;

impl Clause {
    /// Reads an expression. `rows` are the names that there are.
    ///
    /// # Errors
    /// The first thing that is wrong, and its place.
    pub(super) fn parse_all(text: &str, rows: &[String]) -> Result<Vec<Self>, Wrong> {
        if text.len() > BYTES_MAX {
            return Err(Wrong {
                text: text.chars().take(40).collect(),
                at: 0,
                why: format!("an expression has at most {BYTES_MAX} bytes"),
            });
        }
        let mut at = 0;
        let mut clauses = Vec::new();
        for part in text.split(',') {
            let parser = Parser { text, at, rows };
            clauses.push(parser.clause(part)?);
            at += part.len() + 1;
        }
        Ok(clauses)
    }

    /// True when `value`, a time [us], a ratio or a count as the limit is, meets the limit.
    pub(super) fn is_met_by(&self, value: f64) -> bool {
        let (Limit::Time(limit) | Limit::Ratio(limit) | Limit::Count(limit)) = self.limit;
        match self.comparison {
            Comparison::Below => value < limit,
            Comparison::AtMost => value <= limit,
            Comparison::Above => value > limit,
            Comparison::AtLeast => value >= limit,
        }
    }
}

/// Reads a clause that begins at byte `at` of `text`.
struct Parser<'a> {
    text: &'a str,
    at: usize,
    rows: &'a [String],
}

impl Parser<'_> {
    fn wrong(&self, part: &str, place: &str, why: String) -> Wrong {
        // `place` is a slice of `part`.
        let within = place.as_ptr() as usize - part.as_ptr() as usize;
        Wrong {
            text: self.text.to_owned(),
            at: self.at + within,
            why,
        }
    }

    fn clause(&self, part: &str) -> Result<Clause, Wrong> {
        let wrong = |place: &str, why: String| Err(self.wrong(part, place, why));
        let written = part.trim();
        if written.is_empty() {
            let place = &part[part.len()..];
            return wrong(
                place,
                "a clause is missing, such as replanning.p99 < 5ms".to_owned(),
            );
        }
        let place = written.find(['<', '>']).unwrap_or(written.len());
        let (left, right) = written.split_at(place);
        let compared = COMPARISONS
            .iter()
            .find_map(|(sign, comparison)| Some((right.strip_prefix(sign)?, *comparison)));
        let Some((right, comparison)) = compared else {
            return wrong(right, "<, <=, > or >= is missing".to_owned());
        };
        let left = left.trim_end();
        let Some((row, figure_name)) = left.rsplit_once('.') else {
            let end = &left[left.len()..];
            return wrong(end, format!("a figure is missing, such as `{left}.p50`"));
        };
        if !self.rows.iter().any(|name| name == row) {
            let names = self.rows.iter().map(String::as_str);
            return wrong(row, unknown("latency", row, names));
        }
        let named = FIGURES.iter().find(|(name, _)| *name == figure_name);
        let Some((_, figure)) = named else {
            let names = FIGURES.iter().map(|(name, _)| *name);
            return wrong(figure_name, unknown("figure", figure_name, names));
        };
        let limit = self.limit(part, right.trim_start(), *figure)?;
        Ok(Clause {
            row: row.to_owned(),
            figure: *figure,
            comparison,
            limit,
            text: written.to_owned(),
        })
    }

    fn limit(&self, part: &str, text: &str, figure: Figure) -> Result<Limit, Wrong> {
        let wrong = |place: &str, why: &str| Err(self.wrong(part, place, why.to_owned()));
        let is_of_number = |letter: char| letter.is_ascii_digit() || "+-.eE".contains(letter);
        let end = text.find(|letter| !is_of_number(letter));
        let (digits, unit) = text.split_at(end.unwrap_or(text.len()));
        let number = match digits.parse::<f64>() {
            Ok(number) if number.is_finite() && number >= 0.0 => number,
            Ok(_) => return wrong(text, "a limit is a finite number, not below 0"),
            Err(_) => return wrong(text, "a number is missing, such as 5ms or 1.1x"),
        };
        match (unit.trim(), figure.is_count()) {
            ("", true) => Ok(Limit::Count(number)),
            (_, true) => wrong(unit, "a count has no unit"),
            ("us", _) => Ok(Limit::Time(number)),
            ("ms", _) => Ok(Limit::Time(number * 1.0e3)),
            ("s", _) => Ok(Limit::Time(number * 1.0e6)),
            ("x", _) => Ok(Limit::Ratio(number)),
            ("", _) => wrong(unit, "the limit needs its unit: us, ms, s, or x"),
            _ => wrong(unit, "there is no such unit: us, ms, s, or x"),
        }
    }
}

impl Clause {
    /// The row and its figure, as it is written.
    pub(super) fn subject(&self) -> String {
        format!("{}.{}", self.row, self.figure.label())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows() -> Vec<String> {
        ["replanning", "reaction", "direct.mapping"]
            .map(str::to_owned)
            .to_vec()
    }

    fn parse(text: &str) -> Result<Vec<Clause>, Wrong> {
        Clause::parse_all(text, &rows())
    }

    #[test]
    fn every_unit_figure_and_comparison_is_read() {
        let text = "replanning.p99 < 5ms,reaction.p50<=1.1x , direct.mapping.max >2s, \
                    reaction.n>= 400, replanning.censored <1, reaction.p90 < 700us";
        let clauses = parse(text).expect("an expression");
        let limits: Vec<Limit> = clauses.iter().map(|clause| clause.limit).collect();
        let expected = [
            Limit::Time(5000.0),
            Limit::Ratio(1.1),
            Limit::Time(2.0e6),
            Limit::Count(400.0),
            Limit::Count(1.0),
            Limit::Time(700.0),
        ];
        assert_eq!(limits, expected);
        assert_eq!(clauses[2].row, "direct.mapping");
        assert_eq!(clauses[2].subject(), "direct.mapping.max");
        assert_eq!(clauses[1].to_string(), "reaction.p50<=1.1x");
        let met = |at: usize, value| clauses[at].is_met_by(value);
        assert!(met(0, 4999.0) && !met(0, 5000.0));
        assert!(met(1, 1.1) && !met(1, 1.11));
        assert!(met(2, 2.1e6) && !met(2, 2.0e6));
        assert!(met(3, 400.0) && !met(3, 399.0));
    }

    #[test]
    fn what_is_wrong_is_named_with_its_place() {
        let cases = [
            ("", 1, "a clause is missing"),
            ("reaction.p50 < 1ms,", 20, "a clause is missing"),
            ("reaction.p50 < 1ms, ,", 21, "a clause is missing"),
            ("reaction.p50", 13, "<, <=, > or >= is missing"),
            ("reaction.p50 = 1ms", 19, "<, <=, > or >= is missing"),
            ("reaction < 1ms", 9, "a figure is missing"),
            ("reacton.p50 < 1ms", 1, "reaction"),
            ("reaction.p50 < 1ms, replaning.p50 < 1ms", 21, "replanning"),
            ("reaction.p95 < 1ms", 10, "p90"),
            ("reaction.p50 < ms", 16, "a number is missing"),
            ("reaction.p50 <", 15, "a number is missing"),
            ("reaction.p50 < -1ms", 16, "not below 0"),
            ("reaction.p50 < 1e999ms", 16, "finite"),
            ("reaction.p50 < NaNms", 16, "a number is missing"),
            ("reaction.p50 < 1", 17, "needs its unit"),
            ("reaction.p50 < 1 min", 17, "no such unit"),
            ("reaction.n < 1ms", 15, "no unit"),
            ("reaction.p50 << 1ms", 15, "a number is missing"),
        ];
        for (text, column, why) in cases {
            let wrong = parse(text).expect_err(text);
            let said = wrong.to_string();
            assert!(said.contains(why), "{text}: {said}");
            assert!(
                said.contains(&format!("column {column}:")),
                "{text}: {said}"
            );
            let mark = said.lines().last().expect("a mark");
            assert_eq!(mark.len(), 2 + column, "{text}: {said}");
        }
    }

    #[test]
    fn hostile_expressions_are_answered_and_not_obeyed() {
        let long = "reaction.p50 < 1ms,".repeat(1000);
        let long = parse(&long).expect_err("too long").to_string();
        assert!(long.contains("at most"), "{long}");
        let said = parse("réaction\n.p50 < 1ms")
            .expect_err("no row")
            .to_string();
        assert_eq!(said.lines().count(), 3, "{said}");
        for text in ["ä<1ms", "reaction.p50 < 1ß", "日本", "reaction.p50 < ٣ms"] {
            assert!(parse(text).is_err(), "{text}");
        }
    }
}
