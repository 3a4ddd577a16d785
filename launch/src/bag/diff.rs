//! `zeronav diff`: where two recordings begin to differ.

use super::input::{is_unit, open as open_file};
use crate::recorder::recording_in;
use clap::Args;
use core::fmt::Write;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use zeronav_console::exit::{EXIT_FAIL, EXIT_PASS};
use zeronav_console::terminal::{say, say_json, usage};
use zeronav_recorder::compare::{Comparison, Difference, Scope, compare};
use zeronav_recorder::figures::{Figure, figures};
use zeronav_recorder::file::START;
use zeronav_recorder::read::summary;
use zeronav_shell::printable::printable;

/// Two recordings beside each other.
#[derive(Debug)]
pub(crate) struct Beside {
    pub comparison: Comparison,
    pub figures: [Vec<Figure>; 2],
}

/// Compares what `scope` says of the recordings in two files.
///
/// # Errors
/// One line naming the file.
pub(crate) fn beside(scope: &Scope, a: &Path, b: &Path) -> Result<Beside, String> {
    let files = [a, b];
    let in_file = |file: &Path, why: &dyn core::fmt::Display| format!("{}: {why}", file.display());
    // Before anything is read of the first one.
    for file in files {
        open_file(file)?;
    }
    let open = |second: bool| {
        let file = files[usize::from(second)];
        open_file(file).map_err(|why| zeronav_recorder::read::ReadError { offset: 0, why })
    };
    let compared = compare(scope, |second| Ok(open(second)?));
    let comparison =
        compared.map_err(|(second, error)| in_file(files[usize::from(second)], &error))?;
    let end_ticks = comparison.end_ticks;
    let of = |second: bool| {
        // Of what is left out there are no figures, either.
        let after = scope.ticks[1].saturating_add(1);
        let end_tick = end_ticks[usize::from(second)].map_or(after, |tick| tick.min(after));
        let input = open(second).map_err(Into::into);
        let figures = input.and_then(|input| figures(input, Some(end_tick)));
        figures.map_err(|error| in_file(files[usize::from(second)], &error))
    };
    Ok(Beside {
        comparison,
        figures: [of(false)?, of(true)?],
    })
}

/// Arguments of `zeronav diff` and `zeronav bag diff`.
#[derive(Debug, Clone, Args)]
pub struct DiffArgs {
    /// The first recording: an MCAP file, or the folder of a run with --record.
    #[arg(value_name = "RUN")]
    pub a: PathBuf,
    /// The second one.
    #[arg(value_name = "RUN")]
    pub b: PathBuf,
    /// Compare from this run time on. [s]
    #[arg(long, value_name = "S", value_parser = run_time)]
    pub from: Option<f64>,
    /// Compare up to this run time. [s]
    #[arg(long, value_name = "S", value_parser = run_time)]
    pub to: Option<f64>,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// `zeronav diff` and `zeronav bag diff`.
#[must_use]
pub fn diff(arguments: &DiffArgs) -> ExitCode {
    let beside = match arguments.beside() {
        Ok(beside) => beside,
        Err(problem) => return usage(&printable(&problem)),
    };
    if arguments.json {
        say_json(&beside.to_json());
    } else {
        say(&beside.to_text());
    }
    ExitCode::from(if beside.is_equal() {
        EXIT_PASS
    } else {
        EXIT_FAIL
    })
}

impl DiffArgs {
    fn beside(&self) -> Result<Beside, String> {
        let [a, b] = [&self.a, &self.b].map(|run| recording_in(run));
        let (a, b) = (a?, b?);
        let ticks = ticks_of([self.from, self.to], || tick_ns(&a))?;
        let scope = Scope {
            ticks,
            ..Scope::default()
        };
        beside(&scope, &a, &b)
    }
}

/// How long a tick of a recorded run takes. [ns]
///
/// # Errors
/// One line when the file does not say so.
fn tick_ns(file: &Path) -> Result<u64, String> {
    let (found, _) = summary(open_file(file)?);
    let field = found.metadata.get(START).and_then(|it| it.get("tick_ns"));
    let tick_ns = field.and_then(|field| field.parse().ok());
    tick_ns.ok_or_else(|| {
        format!(
            "{}: it does not say how long a tick takes, so --from and --to mean nothing",
            file.display()
        )
    })
}

/// The first and the last tick of a part of a run, from one run time to another [s], whose ticks take as long as `tick_ns`
/// says.
///
/// # Errors
/// One line when nothing lies between them, or what `tick_ns` says.
pub(crate) fn ticks_of(
    [from_s, to_s]: [Option<f64>; 2],
    tick_ns: impl FnOnce() -> Result<u64, String>,
) -> Result<[u64; 2], String> {
    if let (Some(from_s), Some(to_s)) = (from_s, to_s)
        && from_s > to_s
    {
        return Err(format!(
            "--from {from_s} is behind --to {to_s}: nothing lies between them"
        ));
    }
    if from_s.or(to_s).is_none() {
        return Ok([0, u64::MAX]);
    }
    let tick_ns = tick_ns()?.max(1);
    let tick = |time_s: f64| zeronav_msgs::time::nanoseconds(time_s) / tick_ns;
    Ok([from_s.map_or(0, tick), to_s.map_or(u64::MAX, tick)])
}

/// A run time. [s]
///
/// # Errors
/// What is wrong with the text.
pub(crate) fn run_time(text: &str) -> Result<f64, String> {
    let number: Option<f64> = text.parse().ok();
    let time_s = number.filter(|it| it.is_finite() && *it >= 0.0);
    time_s.ok_or_else(|| format!("`{text}` is no time such as 12.5"))
}

impl Beside {
    /// True when something is compared, nothing of it differs, and both recordings are whole.
    pub(crate) fn is_equal(&self) -> bool {
        self.comparison.is_equal() && !self.has_none_of_a()
    }

    /// True when the first recording has none of the messages that are compared and the second one has, as against the log
    /// of another robot: nothing can differ.
    pub(crate) fn cannot_differ(&self) -> bool {
        self.has_none_of_a() && self.n_of_b() > 0
    }

    /// True when the first recording has none of the messages that are compared.
    fn has_none_of_a(&self) -> bool {
        let mut topics = self.comparison.topics.iter();
        topics.all(|it| it.equal + it.different + it.only_a == 0)
    }

    /// How many messages the second recording has that the first one has not.
    fn n_of_b(&self) -> u64 {
        self.comparison.topics.iter().map(|it| it.only_b).sum()
    }

    pub(crate) fn to_json(&self) -> serde_json::Value {
        let [a, b] = &self.figures;
        json!({
            "equal": self.is_equal(),
            "compared": !self.has_none_of_a(),
            "incomplete": { "a": self.comparison.incomplete[0], "b": self.comparison.incomplete[1] },
            "first": self.comparison.first,
            "topics": self.comparison.topics,
            "figures": { "a": a, "b": b },
        })
    }

    /// What is missing, the first difference, the topics and the figures, a line each.
    pub(crate) fn to_text(&self) -> String {
        let topics = &self.comparison.topics;
        let equal: u64 = topics.iter().map(|topic| topic.equal).sum();
        let mut text = String::new();
        for (name, why) in ["a", "b"].iter().zip(&self.comparison.incomplete) {
            if let Some(why) = why.as_deref().map(printable) {
                let _ = writeln!(text, "{name}: NOT COMPLETE: {why}");
            }
        }
        let counted = format!("{equal} messages on {} topics", topics.len());
        let _ = match &self.comparison.first {
            _ if self.has_none_of_a() => {
                writeln!(
                    text,
                    "nothing to compare: a has none of these messages, b has {}",
                    self.n_of_b()
                )
            }
            Some(first) => writeln!(text, "first difference: {}", in_words(first)),
            None if self.is_equal() => writeln!(text, "equal: {counted}"),
            None => writeln!(text, "no difference in what is there of both: {counted}"),
        };
        if self.comparison.first.is_some() && !self.has_none_of_a() {
            text += &self.topics_in_words();
        }
        text + &self.figures_in_words()
    }

    fn topics_in_words(&self) -> String {
        let topics = &self.comparison.topics;
        let width = topics.iter().map(|topic| topic.topic.len()).max();
        let width = width.unwrap_or(0).max(5);
        let row = |topic: &str, counts: [&dyn core::fmt::Display; 4], first: &str| {
            let [equal, different, a, b] = counts;
            format!("{topic:width$}  {equal:>8}  {different:>9}  {a:>8}  {b:>8}  {first}\n")
        };
        let heads: [&dyn core::fmt::Display; 4] = [&"equal", &"different", &"only a", &"only b"];
        let head = row("topic", heads, "first difference");
        let rows = topics.iter().map(|topic| {
            let first = topic.first.as_ref().map_or_else(String::new, |first| {
                let field = first.field.as_deref().unwrap_or("one is missing");
                format!("tick {}: {}", first.tick, printable(field))
            });
            let counts: [&dyn core::fmt::Display; 4] =
                [&topic.equal, &topic.different, &topic.only_a, &topic.only_b];
            row(&printable(&topic.topic), counts, &first)
        });
        format!("\n{head}{}", rows.collect::<String>())
    }

    fn figures_in_words(&self) -> String {
        let [a, b] = &self.figures;
        let mut names: Vec<(&str, &str)> = Vec::new();
        for figure in a.iter().chain(b) {
            if !names.contains(&(&figure.name, figure.unit)) {
                names.push((&figure.name, figure.unit));
            }
        }
        let value = |figures: &[Figure], name: &str| {
            let figure = figures.iter().find(|figure| figure.name == name);
            let value = figure.and_then(|figure| figure.value);
            value.map_or_else(|| "-".to_owned(), |value| format!("{value:.3}"))
        };
        let width = names.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
        let mut text = format!("\n{:width$}  {:>10}  {:>10}\n", "", "a", "b");
        for (name, unit) in names {
            let (a, b) = (value(a, name), value(b, name));
            let line = format!("{name:width$}  {a:>10}  {b:>10}  {unit}");
            text += line.trim_end();
            text.push('\n');
        }
        text
    }
}

/// What differs first, in a line.
pub(crate) fn in_words(first: &Difference) -> String {
    let Difference {
        topic,
        author,
        tick,
        run_s,
        field,
        unit,
        a,
        b,
    } = first;
    let place = format!("tick {tick} ({run_s:.3} s), {author} on {topic}: ");
    let what = match (field, a, b) {
        (Some(field), Some(a), Some(b)) => {
            let unit = unit.as_deref().filter(|unit| is_unit(unit));
            let unit = unit.map_or_else(String::new, |unit| format!(" {unit}"));
            format!("{field} is {a}{unit} in a, {b}{unit} in b")
        }
        (_, Some(_), None) => "the message is in a only".to_owned(),
        (_, None, Some(_)) => "the message is in b only".to_owned(),
        _ => "the message differs".to_owned(),
    };
    // A recording of others may hold anything.
    printable(&(place + &what)).into_owned()
}
