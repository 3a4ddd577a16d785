//! What a recorded drive came to, in figures, to be put beside those of another one.

use crate::layout::Layout;
use crate::messages::{MessagesError, native_messages};
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::Read;
use zeronav_msgs::command::Intervention;
use zeronav_msgs::header::{Id, SHADOW_EPOCH_MIN};
use zeronav_msgs::path::PathStatus;
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::{GroundTruth, PlanPath, RobotCommand, SPANS, Topic};

/// One figure.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figure {
    /// What it is.
    pub name: String,
    /// Its unit; empty for a count.
    pub unit: &'static str,
    /// Its value; none when nothing was recorded from which it follows.
    pub value: Option<f64>,
}

/// What is added up while a recording is read.
#[derive(Default)]
struct Sums {
    paths: u32,
    lengths_m: f64,
    costs: f64,
    commands: u32,
    speeds_mps: f64,
    interventions: u32,
    clearance_m: Option<f64>,
    driven_m: Option<f64>,
    contacts: Option<f64>,
    /// Times of computing of each role. [ns]
    computing_ns: BTreeMap<u64, Vec<u64>>,
}

/// The figures of a recording up to the tick with which its run ended, if that is known: of those processes that were
/// obeyed, shadows left out.
///
/// # Errors
/// See [`MessagesError`].
pub fn figures(input: impl Read, end_tick: Option<u64>) -> Result<Vec<Figure>, MessagesError> {
    let topics = [
        PlanPath::ROW.name,
        RobotCommand::ROW.name,
        GroundTruth::ROW.name,
        SPANS.name,
    ];
    let counts = |tick: Option<u64>| tick.is_none_or(|tick| end_tick.is_none_or(|end| tick < end));
    let mut sums = Sums::default();
    native_messages(
        input,
        |name| topics.contains(&name),
        |name, layout, [envelope, items]| {
            if name == SPANS.name {
                for item in items.chunks_exact(layout.item_bytes.max(1)) {
                    if counts(Layout::unsigned(&layout.item, item, "tick")) {
                        sums.add_span(layout, item);
                    }
                }
            } else if counts(layout.number(envelope, "header.tick"))
                && !is_shadow(layout.number(envelope, "header.id"))
            {
                sums.add(name, layout, envelope);
            }
        },
    )?;
    Ok(sums.figures())
}

fn is_shadow(id: Option<u64>) -> bool {
    id.is_some_and(|id| Id(id).epoch() >= SHADOW_EPOCH_MIN)
}

impl Sums {
    fn add(&mut self, name: &str, layout: &Layout, envelope: &[u8]) {
        let real = |path: &str| Layout::real(&layout.envelope, envelope, path);
        let word = |path: &str| layout.word(envelope, path).unwrap_or_default();
        if name == PlanPath::ROW.name {
            if word("meta.status") == PathStatus::Found.label() {
                self.paths += 1;
                self.lengths_m += real("meta.length_m").unwrap_or(0.0);
                self.costs += real("meta.cost").unwrap_or(0.0);
            }
        } else if name == RobotCommand::ROW.name {
            self.commands += 1;
            self.speeds_mps += real("meta.v_mps").unwrap_or(0.0).abs();
            let intervened = word("meta.intervention") != Intervention::None.label();
            self.interventions += u32::from(intervened);
        } else {
            let clearance_m = real("meta.clearance_m").filter(|it| it.is_finite());
            self.clearance_m = [self.clearance_m, clearance_m]
                .into_iter()
                .flatten()
                .reduce(f64::min);
            self.driven_m = real("meta.driven_m").or(self.driven_m);
            let contacts = ["meta.contacts_moving", "meta.contacts_standing"].map(real);
            let sum: Option<f64> = contacts.into_iter().sum();
            self.contacts = sum.or(self.contacts);
        }
    }

    fn add_span(&mut self, layout: &Layout, item: &[u8]) {
        let number = |path: &str| Layout::unsigned(&layout.item, item, path);
        // A thread that wakes another one up has no output.
        let times = number("published_ns").zip(number("started_ns"));
        let times = times.filter(|_| number("output").is_some_and(|id| id > 0));
        if let (Some(role), Some((end_ns, begin_ns))) = (number("role"), times)
            && let Some(ns) = end_ns.checked_sub(begin_ns)
        {
            self.computing_ns.entry(role).or_default().push(ns);
        }
    }

    fn figures(self) -> Vec<Figure> {
        let figure = |name: &str, unit, value| Figure {
            name: name.to_owned(),
            unit,
            value,
        };
        let mean = |sum: f64, n: u32| (n > 0).then(|| sum / f64::from(n));
        let count = |n: u32, of: u32| (of > 0).then(|| f64::from(n));
        let mut figures = vec![
            figure("driven", "m", self.driven_m),
            figure("least clearance", "m", self.clearance_m),
            figure("contacts", "", self.contacts),
            figure(
                "interventions of the guard",
                "",
                count(self.interventions, self.commands),
            ),
            figure("mean speed", "m/s", mean(self.speeds_mps, self.commands)),
            figure("paths found", "", count(self.paths, self.paths)),
            figure(
                "mean length of a path",
                "m",
                mean(self.lengths_m, self.paths),
            ),
            figure("mean cost of a path", "", mean(self.costs, self.paths)),
        ];
        for (role, mut times_ns) in self.computing_ns {
            times_ns.sort_unstable();
            let role = u16::try_from(role).ok().and_then(Role::from_code);
            let median_ns = times_ns.get(times_ns.len() / 2).copied();
            if let (Some(role), Some(ns)) = (role, median_ns) {
                let ms = zeronav_msgs::time::seconds(ns) * 1e3;
                figures.push(figure(
                    &format!("median computing time, {role}"),
                    "ms",
                    Some(ms),
                ));
            }
        }
        figures
    }
}
