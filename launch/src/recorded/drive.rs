//! A recorded drive: what the messages of a recording come to, by the same folds as those of a running stack.

use super::notes::{Heard, Note, obeyed};
use super::{Recorded, end_tick};
use crate::collect::Collector;
use crate::record;
use crate::recorder::DrivenBy;
use crate::show::recording::Recording;
use crate::subject::Subject;
use core::fmt::Write;
use std::collections::BTreeMap;
use std::path::Path;
use zeronav_measure::RunHash;
use zeronav_msgs::Pose;
use zeronav_msgs::run::RunMode;
use zeronav_msgs::task::TaskKind;
use zeronav_msgs::topics::{
    ControlRequest, GroundTruth, MapKeyframe, MapObstacles, MapUpdate, PlanPath, RobotCommand,
    RobotDescription, RobotOdometry, RobotScan, RunControlTopic, SPANS, TaskGoal, TaskState,
    TaskZones, Topic,
};
use zeronav_recorder::file::DRIVEN_BY_SCENARIO;
use zeronav_recorder::native::PREFIX;
use zeronav_recorder::verdict::{OUTCOME, VERDICT};
use zeronav_scenario::Scenario;
use zeronav_world::{Convex, Footprint, World};

/// Messages that wait to be put into the order in which they were sent. [bytes]
const WAITING_BYTES_MAX: usize = 64 << 20;

/// Paths that are kept at most; of a recording with more the newest stay.
const PATHS_MAX: usize = 20_000;

/// Room around what was driven through, where nobody knows the world. [m]
const MARGIN_M: f64 = 3.0;

/// What is recorded of a drive.
#[derive(Debug)]
pub(crate) struct RecordedDrive {
    /// What the recording says of itself.
    pub recorded: Recorded,
    /// What was heard.
    collector: Collector,
    scenario: Scenario,
    world: World,
    footprint: Footprint,
    /// Why its world is not that of the scenario.
    pub no_world: Option<String>,
    goals_run_ns: u64,
    end_run_ns: u64,
}

/// What the scenario in a recording says.
type Staged = (Scenario, World, Footprint);

impl RecordedDrive {
    /// Reads the recording in `file`.
    ///
    /// # Errors
    /// One line naming the file, and the fix where there is one.
    pub(crate) fn read(file: &Path) -> Result<Self, String> {
        let wrong = |why: &dyn core::fmt::Display| format!("{}: {why}", file.display());
        let recorded = Recorded::read(file)?;
        let staged = recorded.staged();
        let mut reading = Reading::of(&recorded, staged.as_ref().ok().map(|staged| &staged.1));
        let wants = |name: &str| TOPICS.contains(&name) || name == SPANS.name;
        obeyed(file, (&recorded.found, &[]), wants, |heard| {
            reading.take(heard);
        })?;
        let (collector, goals_run_ns) = reading.end();
        if collector.film.poses().is_empty() {
            let why = format!(
                "no message on {} says where the robot was: nothing can be shown",
                RobotOdometry::ROW.name
            );
            return Err(wrong(&why));
        }
        let (staged, no_world) = match staged {
            Ok(staged) => (staged, None),
            Err(why) => (bare(&collector).map_err(|why| wrong(&why))?, Some(why)),
        };
        let (scenario, world, footprint) = staged;
        let end_run_ns =
            end_tick(&recorded.found).map(|end_tick| end_tick.saturating_mul(recorded.tick_ns));
        Ok(Self {
            // A run is not longer than what is known of it.
            end_run_ns: end_run_ns.unwrap_or(collector.run_ns),
            goals_run_ns,
            recorded,
            collector,
            scenario,
            world,
            footprint,
            no_world,
        })
    }

    /// What results and recordings are made of.
    pub(crate) fn subject(&self) -> Subject<'_> {
        Subject {
            scenario: &self.scenario,
            world: &self.world,
            footprint: &self.footprint,
            mode: self.recorded.mode(),
            seed: self.recorded.seed,
            collector: &self.collector,
            goals_run_ns: self.goals_run_ns,
            end_run_ns: self.end_run_ns,
        }
    }

    /// What a player shows of it.
    pub(crate) fn recording(&self) -> Recording {
        let (subject, outcome) = (self.subject(), self.outcome());
        let mut made = if self.recorded.driven_by() == Some(DrivenBy::Clients.label()) {
            record::of_film(&subject, outcome)
        } else {
            record::of_run(&subject, outcome, None)
        };
        if made.robot.is_empty() {
            // Nobody says where it really was.
            made = record::of_film(&subject, outcome);
            let steps = made.robot.windows(2);
            let steps = steps.map(|pair| (pair[1][1] - pair[0][1]).hypot(pair[1][2] - pair[0][2]));
            made.driven_m = steps.sum();
        }
        made
    }

    /// What became of it, as launch has said.
    fn outcome(&self) -> &str {
        let verdict = self.recorded.found.metadata.get(VERDICT);
        let outcome = verdict.and_then(|fields| fields.get(OUTCOME));
        outcome.map_or("recorded", String::as_str)
    }
}

impl Recorded {
    /// Real time or lockstep.
    fn mode(&self) -> RunMode {
        if self.is_lockstep() {
            RunMode::Lockstep
        } else {
            RunMode::RealTime
        }
    }

    /// The scenario with its world, as far as that can be made here.
    fn staged(&self) -> Result<Staged, String> {
        let (name, text) = self.scenario.as_ref().ok_or("it holds no scenario")?;
        staged(name, text)
    }

    /// True when there is something on a topic.
    fn has(&self, topic: &str) -> bool {
        let mut channels = self.found.channels.values();
        channels.any(|it| it.topic.strip_prefix(PREFIX) == Some(topic) && it.messages > 0)
    }
}

fn staged(name: &str, text: &str) -> Result<Staged, String> {
    let mut read = Scenario::of_text(name, text).map_err(|error| error.to_string())?;
    let checked = read.examine();
    if let Some(checked) = checked {
        return Ok((read.scenario, checked.world, checked.footprint));
    }
    let wrong = read.wrong.iter().map(ToString::to_string);
    Err(wrong.collect::<Vec<_>>().join("; "))
}

/// A world with nothing in it around what was driven through.
fn bare(collector: &Collector) -> Result<Staged, String> {
    let (mut low, mut high) = ([f64::MAX; 2], [f64::MIN; 2]);
    for (_, moving) in collector.film.poses() {
        for (axis, at_m) in [moving.pose.x_m, moving.pose.y_m].into_iter().enumerate() {
            low[axis] = low[axis].min((at_m - MARGIN_M).floor());
            high[axis] = high[axis].max((at_m + MARGIN_M).ceil());
        }
    }
    let [x_m, y_m] = [0, 1].map(|axis| 0.5 * (low[axis] + high[axis]));
    let mut text = String::new();
    let _ = write!(
        text,
        "start = [{x_m:?}, {y_m:?}, 0.0]\nstatic_map = false\n\n[world]\narea_m = [{low:?}, {high:?}]\n"
    );
    staged("recording", &text)
}

/// What is read besides the records of cycles.
const TOPICS: [&str; 14] = [
    RunControlTopic::ROW.name,
    RobotDescription::ROW.name,
    TaskGoal::ROW.name,
    GroundTruth::ROW.name,
    ControlRequest::ROW.name,
    RobotCommand::ROW.name,
    RobotOdometry::ROW.name,
    RobotScan::ROW.name,
    MapObstacles::ROW.name,
    MapKeyframe::ROW.name,
    MapUpdate::ROW.name,
    PlanPath::ROW.name,
    TaskState::ROW.name,
    TaskZones::ROW.name,
];

/// A recording while it is read. A recorder writes what has come on one topic after the other, so messages wait until
/// they can be put into the order in which they were sent.
struct Reading<'a> {
    collector: Collector,
    world: Option<&'a World>,
    /// By the moment at which each was sent, and its number.
    waiting: BTreeMap<(u64, u64), Note>,
    waiting_bytes: usize,
    n: u64,
    /// Run time of the first goal of a run in real time that its scenario drove. [ns]
    goals_run_ns: Option<u64>,
}

impl<'a> Reading<'a> {
    fn of(recorded: &Recorded, world: Option<&'a World>) -> Self {
        let mut collector = Collector::default();
        collector.looks = !recorded.is_lockstep();
        if let Some(tick) = end_tick(&recorded.found) {
            collector.totals.end_at(tick);
            collector.reasons.end_at(tick);
        }
        if !recorded.has(MapUpdate::ROW.name) {
            // Without mapping the map begins where the odometry does.
            collector.film.placed(0, Pose::default());
        }
        let waits_for_goal =
            !recorded.is_lockstep() && recorded.driven_by() == Some(DRIVEN_BY_SCENARIO);
        Self {
            collector,
            world,
            waiting: BTreeMap::new(),
            waiting_bytes: 0,
            n: 0,
            goals_run_ns: (!waits_for_goal).then_some(0),
        }
    }

    fn take(&mut self, heard: Heard) {
        match heard {
            Heard::Spans(spans) => {
                for span in &spans {
                    self.collector.span(span, None);
                }
                self.collector.settle(None);
                // Nobody asks for the hash of a recording, which needs every answer.
                self.collector.hash = RunHash::default();
            }
            Heard::Note(note) => {
                self.n += 1;
                self.waiting_bytes += note.bytes.len();
                self.waiting.insert((note.sent_ns, self.n), note);
                while self.waiting_bytes > WAITING_BYTES_MAX {
                    self.next();
                }
            }
        }
    }

    /// Takes the oldest that waits; false when nothing does.
    fn next(&mut self) -> bool {
        let Some((_, note)) = self.waiting.pop_first() else {
            return false;
        };
        self.waiting_bytes -= note.bytes.len();
        let placed = |index: usize, pose: &Pose| -> Option<Convex> {
            let obstacle = self.world?.obstacles().get(index)?;
            Some(obstacle.shape.placed_at(pose))
        };
        let collector = &mut self.collector;
        note.show::<RobotDescription>(|view| collector.description(view));
        note.show::<TaskGoal>(|view| {
            if view.meta.kind == TaskKind::Go.code() {
                self.goals_run_ns.get_or_insert(collector.run_ns);
                collector.goals(view.items);
            }
        });
        note.show::<TaskZones>(|view| collector.take_zones(view.meta, view.items));
        note.show::<GroundTruth>(|view| collector.truth(view, &placed));
        note.show::<ControlRequest>(|view| collector.request(view));
        note.show::<RobotCommand>(|view| collector.command(view));
        note.show::<RobotOdometry>(|view| collector.odometry(view));
        note.show::<RobotScan>(|view| collector.scan(view));
        note.show::<MapObstacles>(|view| collector.moving(view));
        note.show::<MapKeyframe>(|view| {
            collector.keyframe(view);
            collector.look_at_map();
        });
        note.show::<MapUpdate>(|view| {
            collector.look_again(&placed);
            collector.update(view, &placed);
            collector.look_at_map();
        });
        note.show::<PlanPath>(|view| {
            collector.path(view);
            if collector.records.paths.len() > PATHS_MAX {
                collector.records.keep_newest();
            }
        });
        note.show::<TaskState>(|view| collector.status(view));
        true
    }

    /// Takes what still waits; what was heard, and the run time of the first goal. [ns]
    fn end(mut self) -> (Collector, u64) {
        while self.next() {}
        self.collector.film.end();
        // What is held back until an end is known counts.
        self.collector.totals.end();
        (self.collector, self.goals_run_ns.unwrap_or(0))
    }
}
