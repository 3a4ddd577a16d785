//! What a recorded drive came to, in figures, to be put beside those of another one.

use crate::holders::Holders;
use crate::layout::Layout;
use crate::messages::{MessagesError, native_messages};
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::Read;
use zeronav_msgs::command::Intervention;
use zeronav_msgs::header::Id;
use zeronav_msgs::path::PathStatus;
use zeronav_msgs::pose::Pose;
use zeronav_msgs::role::Role;
use zeronav_msgs::time::seconds;
use zeronav_msgs::topics::{
    GroundTruth, MapUpdate, PlanPath, RobotCommand, RobotOdometry, RunControlTopic, SPANS, Topic,
};
use zeronav_observe::statistics::median;

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

/// Name of the figure of how far mapping had the robot from where it was, in the middle. [m]
pub const MEDIAN_ERROR: &str = "median error of the place";

/// Name of the figure of the median computing time of a seat. [ms]
#[must_use]
pub fn median_computing(role: Role) -> String {
    format!("median computing time, {role}")
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
    located: Located,
    /// Times of computing of each role. [ns]
    computing_ns: BTreeMap<u64, Vec<u64>>,
}

/// Most ticks of which not everything has come yet.
const TICKS_MAX: usize = 1024;

/// Where mapping has the robot, beside where it really is.
#[derive(Default)]
struct Located {
    /// Odometry, the map's place of its origin, and the truth, by tick.
    waiting: BTreeMap<u64, [Option<Pose>; 3]>,
    /// Distances between the two. [m]
    errors_m: Vec<f64>,
}

impl Located {
    /// Odometry (0), the place of its origin on the map (1), or the truth (2) of a tick.
    fn add(&mut self, tick: u64, which: usize, pose: Pose) {
        let it = self.waiting.entry(tick).or_default();
        it[which] = Some(pose);
        if let [Some(odometry), Some(map_from_odom), Some(truth)] = *it {
            let believed = map_from_odom.then(&odometry);
            self.errors_m.push(believed.distance_m(&truth));
            self.waiting.remove(&tick);
        }
        if self.waiting.len() > TICKS_MAX {
            self.waiting.pop_first();
        }
    }
}

/// The figures of a recording up to the tick with which its run ended, if that is known: of the process that was obeyed in
/// its seat at each tick. Shadows, and newcomers and predecessors of a swap, are left out.
///
/// # Errors
/// See [`MessagesError`].
pub fn figures(input: impl Read, end_tick: Option<u64>) -> Result<Vec<Figure>, MessagesError> {
    let topics = [
        RunControlTopic::ROW.name,
        RobotOdometry::ROW.name,
        MapUpdate::ROW.name,
        PlanPath::ROW.name,
        RobotCommand::ROW.name,
        GroundTruth::ROW.name,
        SPANS.name,
    ];
    let counts = |tick: Option<u64>| tick.is_none_or(|tick| end_tick.is_none_or(|end| tick < end));
    let mut sums = Sums::default();
    let mut holders = Holders::default();
    native_messages(
        input,
        |name| topics.contains(&name),
        |name, layout, [envelope, items]| {
            if name == RunControlTopic::ROW.name {
                holders.see(layout, items);
            } else if name == SPANS.name {
                for item in items.chunks_exact(layout.item_bytes.max(1)) {
                    let number = |path: &str| Layout::unsigned(&layout.item, item, path);
                    let author = [number("role"), number("epoch"), number("tick")];
                    if counts(number("tick")) && holders.obey(author) {
                        sums.add_span(layout, item);
                    }
                }
            } else {
                let number = |path: &str| layout.number(envelope, path);
                let epoch = number("header.id").map(|id| u64::from(Id(id).epoch()));
                let tick = number("header.tick");
                if counts(tick) && holders.obey([number("header.role"), epoch, tick]) {
                    sums.add(name, layout, envelope);
                }
            }
        },
    )?;
    Ok(sums.figures())
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
        } else if name == RobotOdometry::ROW.name {
            self.locate(layout, envelope, 0, "meta.pose");
        } else if name == MapUpdate::ROW.name {
            self.locate(layout, envelope, 1, "meta.map_from_odom");
        } else {
            self.locate(layout, envelope, 2, "meta.pose");
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

    fn locate(&mut self, layout: &Layout, envelope: &[u8], which: usize, path: &str) {
        let real = |name: &str| Layout::real(&layout.envelope, envelope, &format!("{path}.{name}"));
        let tick = layout.number(envelope, "header.tick");
        let pose = ["x_m", "y_m", "yaw_rad"].map(real);
        if let (Some(tick), [Some(x_m), Some(y_m), Some(yaw_rad)]) = (tick, pose) {
            self.located.add(tick, which, Pose::new(x_m, y_m, yaw_rad));
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
        let errors_m = &self.located.errors_m;
        let median_m = median(errors_m.iter().copied());
        figures.push(figure(MEDIAN_ERROR, "m", median_m));
        figures.push(figure(
            "largest error of the place",
            "m",
            errors_m.iter().copied().max_by(f64::total_cmp),
        ));
        for (role, times_ns) in self.computing_ns {
            let role = u16::try_from(role).ok().and_then(Role::from_code);
            let median_s = median(times_ns.into_iter().map(seconds));
            if let (Some(role), Some(median_s)) = (role, median_s) {
                let ms = Some(median_s * 1e3);
                figures.push(figure(&median_computing(role), "ms", ms));
            }
        }
        figures
    }
}

#[cfg(test)]
mod tests;
