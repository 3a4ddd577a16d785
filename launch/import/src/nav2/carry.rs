//! The rows of the table, applied to a file.

use super::draft::Draft;
use super::outline::Mended;
use super::parameters::{Place, Sections};
use super::plugins::Plugins;
use super::reading::{self, Given};
use super::report::{Assumed, Carried, Report};
use super::table::{Choice, FIELDS, Field, ROWS, Row};
use std::collections::BTreeSet;

/// What a row found.
struct Candidate {
    row: &'static Row,
    /// Node and parameter.
    from: String,
    /// Line and value in the file; `None` = Nav2's default.
    written: Option<(u64, String)>,
    given: Given,
}

/// A parameter that cannot be: line, name and what is wrong.
pub(super) type Wrong = (u64, String, String);

/// Fills `draft` with what the rows find; the places that they have looked at.
///
/// # Errors
/// The first parameter that is wrong.
pub(super) fn carry(
    sections: &Sections,
    plugins: &Plugins<'_>,
    (draft, report): (&mut Draft, &mut Report),
) -> Result<BTreeSet<Place>, Wrong> {
    let mut seen = BTreeSet::new();
    let mut all = Vec::new();
    for row in ROWS {
        all.extend(find(row, sections, plugins, (&mut seen, report))?);
    }
    keep_one_outline(&mut all, report);
    for field in FIELDS {
        let (of_field, rest): (Vec<_>, Vec<_>) = all
            .into_iter()
            .partition(|it: &Candidate| it.row.to == field.path);
        all = rest;
        choose(field, of_field, (draft, report))?;
    }
    Ok(seen)
}

/// What a row finds in the file.
fn find(
    row: &'static Row,
    sections: &Sections,
    plugins: &Plugins<'_>,
    (seen, report): (&mut BTreeSet<Place>, &mut Report),
) -> Result<Option<Candidate>, Wrong> {
    if row.of.is_some_and(|it| it != plugins.kind) {
        return Ok(None);
    }
    let Some(parameter) = plugins.named(row.node, row.parameter) else {
        return Ok(None);
    };
    let item = row.item.map_or_else(String::new, |it| format!("[{it}]"));
    let from = format!("{}.{parameter}{item}", row.node);
    let places = sections.places(row.node, &parameter);
    seen.extend(places.iter().copied());
    let written = places.last().map(|it| sections.at(*it));
    let given = match written {
        Some(it) => match reading::read(row, &it.value, sections) {
            Ok(given) => given,
            Err(why) => return Err((it.line, from, why)),
        },
        None => match row.otherwise.filter(|_| sections.names(row.node)) {
            Some(usual) => Given::Is((usual.abs() * sign_of(row, usual)).into()),
            None => return Ok(None),
        },
    };
    match given {
        Given::Nothing => Ok(None),
        Given::Later => {
            let value = written.map_or_else(String::new, |it| format!(" = {}", it.value));
            let means = "a launch file fills it in, which is not read: the value below `assumed`, or that of another node, counts";
            report.leave(from + &value, means);
            Ok(None)
        }
        given => Ok(Some(Candidate {
            row,
            from,
            written: written.map(|it| (it.line, it.value.to_string())),
            given,
        })),
    }
}

/// The sign that a default has in the scenario: sizes have none.
fn sign_of(row: &Row, usual: f64) -> f64 {
    if usual < 0.0 && row.form != super::table::Form::Size {
        -1.0
    } else {
        1.0
    }
}

/// Of footprint and radius, of the local and of the global costmap, the first counts.
fn keep_one_outline(all: &mut Vec<Candidate>, report: &mut Report) {
    let is_outline = |it: &Candidate| matches!(it.row.to, "robot.footprint_m" | "robot.radius_m");
    let Some(first) = all.iter().position(is_outline) else {
        return;
    };
    let kept = (all[first].row.to, all[first].from.clone());
    let mut index = 0;
    all.retain(|it| {
        index += 1;
        let stays = !is_outline(it) || it.row.to == kept.0;
        if !stays {
            report.leave(
                it.from.clone(),
                format!("{} counts: a robot has one outline", kept.1),
            );
        }
        stays
    });
}

/// Fills a field from what was found for it.
fn choose(
    field: &'static Field,
    mut found: Vec<Candidate>,
    (draft, report): (&mut Draft, &mut Report),
) -> Result<(), Wrong> {
    // A default counts where its node says nothing of the field; of what is not strictest, where nobody does.
    let said: Vec<&str> = found
        .iter()
        .filter(|it| it.written.is_some())
        .map(|it| it.row.node)
        .collect();
    let is_asked = |it: &Candidate| match field.choice {
        Choice::First => said.is_empty(),
        Choice::Least | Choice::Most => !said.contains(&it.row.node),
    };
    let keeps: Vec<bool> = found
        .iter()
        .map(|it| it.written.is_some() || is_asked(it))
        .collect();
    let mut keeps = keeps.into_iter();
    found.retain(|_| keeps.next().unwrap_or(true));
    let forward_mps = draft.number("robot.v_mps_max").unwrap_or(0.0);
    for it in &mut found {
        if it.given == Given::Reverses {
            it.given = Given::Is((-forward_mps).into());
        }
        check_range(field, it)?;
    }
    found.retain(|it| !is_left(field, it, report));
    let better = |one: &Candidate, other: &Candidate| {
        let (Some(one), Some(other)) = (one.given.number(), other.given.number()) else {
            return false;
        };
        match field.choice {
            Choice::First => false,
            Choice::Least => one < other,
            Choice::Most => one > other,
        }
    };
    let mut best = None;
    for (index, it) in found.iter().enumerate() {
        if best.is_none_or(|best: usize| better(it, &found[best])) {
            best = Some(index);
        }
    }
    let Some(best) = best else { return Ok(()) };
    let chosen = found[best].from.clone();
    let value = value_of(&found[best].given);
    for (index, it) in found.into_iter().enumerate() {
        if index == best {
            take(field, it, (draft, report));
        } else if let Some((line, written)) = it.written {
            let same = value_of(&it.given) == value;
            if field.choice == Choice::First && !same {
                let means = format!("{chosen} = {value} counts");
                report.leave(format!("{} = {written}", it.from), means);
            } else {
                report.carried.push(Carried {
                    from: it.from,
                    line: Some(line),
                    value: written,
                    to: field.path,
                    ours: same.then(|| value.to_string()),
                });
            }
        }
    }
    Ok(())
}

/// The value of a scenario.
fn value_of(given: &Given) -> toml::Value {
    match given {
        Given::Is(value) => value.clone(),
        Given::Outline(corners, _) => {
            let corners = corners.iter().map(|it| it.to_vec());
            corners.collect::<Vec<_>>().into()
        }
        Given::Reverses | Given::Nothing | Given::Later => false.into(),
    }
}

fn check_range(field: &Field, it: &Candidate) -> Result<(), Wrong> {
    let (Some([least, most]), Some(number)) = (field.range, it.given.number()) else {
        return Ok(());
    };
    if field.may_be_left || (least..=most).contains(&number) {
        return Ok(());
    }
    let line = it.written.as_ref().map_or(0, |(line, _)| *line);
    let why = format!("must be {least} to {most} for {}, not {number}", field.path);
    Err((line, it.from.clone(), why))
}

/// Leaves out a number that our algorithm does not take.
fn is_left(field: &Field, it: &Candidate, report: &mut Report) -> bool {
    let (Some([least, most]), Some(number), true) =
        (field.range, it.given.number(), field.may_be_left)
    else {
        return false;
    };
    let is_out = !(least..=most).contains(&number);
    if is_out {
        let means = format!("{} takes {least} to {most}: its default stays", field.path);
        report.leave(format!("{} = {number}", it.from), means);
    }
    is_out
}

fn take(field: &Field, it: Candidate, (draft, report): (&mut Draft, &mut Report)) {
    let value = value_of(&it.given);
    let Some((line, written)) = it.written else {
        let why = format!("{} is not in the file: the default of Nav2", it.from);
        draft.set(field.path, value.clone(), why.clone());
        let to = field.path;
        let value = value.to_string();
        report.assumed.push(Assumed { to, value, why });
        return;
    };
    if let Given::Outline(_, mended @ (Mended::Reversed | Mended::Hull)) = it.given {
        let why = match mended {
            Mended::Reversed => "its corners were listed clockwise: reversed",
            _ => "it was not convex, or had corners on its sides: its convex hull is taken",
        };
        report.assumed.push(Assumed {
            to: field.path,
            value: value.to_string(),
            why: format!("{}: {why}", it.from),
        });
    }
    draft.set(field.path, value.clone(), it.from.clone());
    report.carried.push(Carried {
        from: it.from,
        line: Some(line),
        value: written,
        to: field.path,
        ours: Some(value.to_string()),
    });
}
