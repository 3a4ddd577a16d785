//! One run that a suite makes, and by what it is judged.

use super::noise;
use super::plan::Setup;
use super::track::Clock;
use super::turns::OutlineWay;
use std::path::PathBuf;
use std::time::Duration;
use toml::{Table, Value};
use zeronav_console::artifacts;
use zeronav_msgs::Pose;

/// One run.
#[derive(Debug, Clone)]
pub(super) struct Case {
    /// Name of the world.
    pub(super) world: String,
    /// What the worlds are sorted by: the difficulty, the scene.
    pub(super) class: Option<String>,
    /// Seed of everything random.
    pub(super) seed: u64,
    /// File of its scenario.
    pub(super) scenario: PathBuf,
    /// Run time that it has. [s]
    pub(super) time_limit_s: f64,
    /// By what it is judged.
    pub(super) rule: Rule,
    /// How it is driven.
    pub(super) manner: Manner,
}

/// How a run is driven.
#[derive(Debug, Clone, Default)]
pub(super) struct Manner {
    /// True in real time, false in lockstep.
    pub(super) real_time: bool,
    /// A folder of its own for temporary files, by which everything that it starts is known again;
    /// `None` = that of this process.
    pub(super) temp: Option<PathBuf>,
}

/// By what a run is judged.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Rule {
    /// What counts as a success.
    pub(super) success: Success,
    /// OT, the time of the benchmark's own path at 2 m/s; `None` where there is no score. [s]
    pub(super) optimal_time_s: Option<f64>,
    /// Length that the driven one is compared with. [m]
    pub(super) reference_m: Option<f64>,
    /// True when everything moves as it was recorded, whatever the robot does.
    pub(super) future_is_known: bool,
    /// The way of the outline among what stands.
    pub(super) way: OutlineWay,
}

/// What counts as a success.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Success {
    /// The centre of the robot really was within `tolerance_m` of the goal, the robot said that it
    /// had arrived, and touched nothing.
    Arrival {
        /// The goal. [m]
        goal_m: [f64; 2],
        /// How near counts. [m]
        tolerance_m: f64,
        /// True when a contact that began while the robot stood is a failure, too.
        standing_counts: bool,
    },
    /// The robot said that it had arrived, knew where it was then, and touched nothing.
    Found {
        /// False where it must never take itself to be lost.
        may_be_lost: bool,
        /// How far off its pose may be. [m]
        off_m: f64,
        /// The same of its yaw. [rad]
        off_rad: f64,
    },
    /// What the scenario itself expects.
    Expectations,
}

impl Case {
    /// Names the run: its scenario and its seed.
    pub(super) fn name(&self) -> String {
        let scenario = self.scenario.file_stem().unwrap_or_default();
        format!("{}-seed{}", scenario.to_string_lossy(), self.seed)
    }

    /// The benchmark's clock; `None` where the benchmark has no score by time.
    pub(super) fn clock(&self) -> Option<Clock> {
        let Success::Arrival {
            goal_m,
            tolerance_m,
            ..
        } = self.rule.success
        else {
            return None;
        };
        self.rule.optimal_time_s.map(|_| Clock {
            goal_m,
            tolerance_m,
        })
    }

    /// Wall time after which the run counts as hung: far more than it takes. In lockstep that is what is
    /// beyond any machine, as a busy one only makes the run longer; a service that hangs ends it before.
    pub(super) fn wall_limit(&self) -> Duration {
        /// Time to start and stop, and wall time per run time, in real time and in lockstep. [s], []
        const LIMITS: [[f64; 2]; 2] = [[60.0, 6.0], [600.0, 60.0]];
        /// A day. [s]
        const LONGEST_S: f64 = 86_400.0;
        let [around_s, slowest] = LIMITS[usize::from(!self.manner.real_time)];
        let limit_s = (around_s + slowest * self.time_limit_s).min(LONGEST_S);
        Duration::try_from_secs_f64(limit_s).unwrap_or(Duration::MAX)
    }

    /// What a row says of a run that was ended because of [`Self::wall_limit`].
    pub(super) fn hung(&self) -> String {
        format!("hung: no end within {} s", self.wall_limit().as_secs())
    }
}

/// A world of a data set as a scenario.
#[derive(Debug, Clone)]
pub(super) struct Sheet {
    /// Name of the scenario's file.
    pub(super) name: String,
    /// One line.
    pub(super) title: String,
    /// Its table `[world]`.
    pub(super) world: Table,
    /// `map_from_base` at the start.
    pub(super) start: Pose,
    /// `map_from_base` at the end, any yaw.
    pub(super) goal: Pose,
    /// How near the robot shall think itself to be. [m]
    pub(super) goal_tolerance_m: f64,
    /// Run time. [s]
    pub(super) time_limit_s: f64,
}

/// Wall time without progress after which a service counts as hung. A busy machine shall not
/// decide how a lockstep run goes on. [s]
const HANG_AFTER_S: f64 = 5.0;

impl Sheet {
    /// Writes the scenario.
    ///
    /// # Errors
    /// One line naming the file.
    pub(super) fn write(self, setup: &Setup<'_>) -> Result<PathBuf, String> {
        let name = self.name.clone();
        write(setup, &name, self.table(setup)?)
    }

    /// The scenario: a Jackal that knows nothing of the world.
    ///
    /// # Errors
    /// One line about a value without a TOML form.
    pub(super) fn table(self, setup: &Setup<'_>) -> Result<Table, String> {
        let mut robot = noise::jackal(setup.plan.noise);
        robot.insert("preset".into(), "jackal".into());
        let mut run = Table::new();
        run.insert("time_limit_s".into(), self.time_limit_s.into());
        let mut restart = Table::new();
        restart.insert("hang_after_s".into(), HANG_AFTER_S.into());
        let goal = goal(self.goal, self.goal_tolerance_m);
        let mut sheet = Table::new();
        sheet.insert("title".into(), self.title.into());
        sheet.insert("start".into(), numbers(self.start));
        sheet.insert("static_map".into(), false.into());
        sheet.insert("run".into(), run.into());
        sheet.insert("restart".into(), restart.into());
        sheet.insert("world".into(), self.world.into());
        sheet.insert("robot".into(), robot.into());
        sheet.insert("goals".into(), vec![goal].into());
        let foresight = setup.plan.foresight;
        if !foresight.is_none() {
            let told = Table::try_from(foresight).map_err(|error| error.to_string())?;
            sheet.insert("foresight".into(), told.into());
        }
        Ok(sheet)
    }
}

/// A goal of a scenario.
pub(super) fn goal(pose: Pose, tolerance_m: f64) -> Table {
    let mut goal = Table::new();
    goal.insert("pose".into(), numbers(pose));
    goal.insert("tolerance_m".into(), tolerance_m.into());
    goal
}

/// Writes a scenario with the suite's controller and settings.
///
/// # Errors
/// One line naming the file.
pub(super) fn write(setup: &Setup<'_>, name: &str, mut sheet: Table) -> Result<PathBuf, String> {
    if let Some(controller) = setup.controller {
        let mut config = Table::new();
        config.insert("controller".into(), controller.into());
        let mut seat = Table::new();
        seat.insert("config".into(), config.into());
        let services = sheet.entry("services").or_insert(Table::new().into());
        if let Some(services) = services.as_table_mut() {
            services.insert("local_planner".into(), seat.into());
        }
    }
    setup.plan.settings.lay_over_sheet(&mut sheet);
    let name = format!("{name}.toml");
    artifacts::write_in(setup.scenarios, &name, &sheet.to_string())?;
    Ok(setup.scenarios.path().join(name))
}

pub(super) fn numbers(pose: Pose) -> Value {
    vec![pose.x_m, pose.y_m, pose.yaw_rad].into()
}
