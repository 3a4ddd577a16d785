//! The drives of a soak: an endless list, in which each is drawn from its number alone.

use super::super::case::{Case, Manner, Rule, Success, goal, numbers, write};
use super::super::plan::Setup;
use super::super::turns::OutlineWay;
use super::super::{barn, generated};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::Serialize;
use std::path::{Path, PathBuf};
use toml::{Table, Value};
use zeronav_files::Folder;
use zeronav_msgs::Pose;
use zeronav_msgs::role::Role;
use zeronav_msgs::run::RunMode;
use zeronav_scenario::fault_plan::draw;
use zeronav_scenario::restart::RestartSpec;
use zeronav_scenario::{KEEP_S_MIN, KINDS, RandomFaults, StackFault, SwapSpec, mortals};
use zeronav_world_files::synthetic::course::Class;

/// One drive in so many is in real time, the others are in lockstep.
pub(super) const REAL_TIME_EVERY: u32 = 4;

/// In one drive in so many, services are swapped as well.
pub(super) const SWAPS_EVERY: u32 = 5;

/// When faults begin. [s]
const FAULTS_S: [f64; 2] = [2.0, 62.0];

/// Kills and hangs of a drive: each seat loses its process every few seconds.
const DEATHS: usize = 60;

/// Faults of other kinds of a drive.
const DISTURBANCES: usize = 20;

/// The kinds after which a seat has a successor.
const DEADLY: [&str; 2] = ["kill", "stop"];

/// Run time of a drive, several times what it takes without faults. [s]
const TIME_LIMIT_S: f64 = 300.0;

/// Swaps of a drive that has some begin within so long after these times: one is over before the next
/// begins. [s]
const SWAPS_S: [f64; 2] = [4.0, 18.0];
const SWAPS_WITHIN_S: f64 = 10.0;

/// How long a newcomer is compared. [s]
const SHADOW_S: f64 = 1.0;

/// Times through a generated world.
const CROSSINGS: usize = 6;

/// Restarts are what is wanted: no budget ends a drive.
const RESTARTS_MAX: i64 = 10_000;

/// Numbers of generated worlds start again after so many.
const NUMBERS: u32 = 1 << 28;

/// Through the south aisle of the warehouse and back through the north aisle. [m]
const AROUND_M: [[f64; 2]; 3] = [[25.4, 6.425], [25.4, 13.575], [4.5, 13.575]];

/// A load that fills the south aisle when the robot is three metres before it.
const LOAD: &str = r#"
[[obstacles]]
name = "load"
shape = { kind = "box", centre_m = [11.3, 6.425], size_m = [0.8, 1.85] }
appears = { robot_near = { point_m = [9.0, 6.425], distance_m = 1.2 } }
"#;

/// Where a drive goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
    /// To and fro through worlds of one class of those of `zeronav suite generated`, unknown to the
    /// robot.
    Generated {
        /// The class: its number below 9.
        class: u32,
    },
    /// Through both aisles of the warehouse, with wheels that slip.
    Warehouse,
    /// The same, and a load drops into the first aisle.
    BlockedAisle,
}

impl Place {
    /// Cylinders that go round slowly.
    const ORBITS: Self = Self::Generated { class: 1 };

    /// Static clutter of three levels, what goes round, the warehouse.
    const ALL: [Self; 6] = [
        Self::Generated { class: 0 },
        Self::Generated { class: 3 },
        Self::Generated { class: 6 },
        Self::ORBITS,
        Self::Warehouse,
        Self::BlockedAisle,
    ];
}

/// A drive before it has a scenario.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Drive {
    /// Its number.
    pub(super) number: u32,
    /// Where it goes.
    pub(super) place: Place,
    /// How it is driven.
    pub(super) mode: RunMode,
    /// What breaks.
    pub(super) faults: Vec<StackFault>,
    /// What is swapped.
    pub(super) swaps: Vec<SwapSpec>,
}

impl Drive {
    /// The drive of this number.
    pub(super) fn of(number: u32) -> Self {
        let mut dice = Pcg64Mcg::seed_from_u64(seed(number));
        let place = Place::ALL[dice.random_range(0..Place::ALL.len())];
        let mode = if number % REAL_TIME_EVERY == REAL_TIME_EVERY - 1 {
            RunMode::RealTime
        } else {
            RunMode::Lockstep
        };
        let names = |is_deadly: bool| {
            let of_sort = KINDS.into_iter().filter(move |kind| {
                let fits = kind.lockstep || mode == RunMode::RealTime;
                kind.is_drawn && fits && DEADLY.contains(&kind.name) == is_deadly
            });
            of_sort.map(|kind| kind.name.to_owned()).collect()
        };
        let mut faults = Vec::new();
        for (count, kinds) in [(DEATHS, names(true)), (DISTURBANCES, names(false))] {
            let spec = RandomFaults {
                count,
                from_s: FAULTS_S[0],
                until_s: FAULTS_S[1],
                seed: Some(dice.random()),
                kinds,
                services: Vec::new(),
            };
            let hang_after_s = RestartSpec::default().hang_after_s;
            faults.extend(draw(&spec, 0, mode, hang_after_s));
        }
        let has_swaps = number % SWAPS_EVERY == SWAPS_EVERY - 1;
        Self {
            number,
            place,
            mode,
            faults,
            swaps: if has_swaps {
                swaps(&mut dice)
            } else {
                Vec::new()
            },
        }
    }

    /// True when its clock is that on the wall.
    pub(super) fn is_real_time(&self) -> bool {
        self.mode == RunMode::RealTime
    }

    /// Its scenario and by what it is judged; temporary files go into a folder of its own in `temp`. When
    /// `calm`, nothing breaks and nothing is swapped.
    ///
    /// # Errors
    /// One line naming a world that cannot be drawn, or a file.
    pub(super) fn case(
        &self,
        setup: &Setup<'_>,
        temp: &Folder,
        calm: bool,
    ) -> Result<Case, String> {
        let world = format!("soak_{:04}", self.number);
        let name = if calm {
            format!("{world}_calm")
        } else {
            world.clone()
        };
        let Route {
            mut sheet,
            goals,
            tolerance_m,
        } = self.place.route(setup, &world, self.number)?;
        let asked_m = barn::TOLERANCE_SHARE * tolerance_m;
        let tables: Vec<Table> = goals.iter().map(|pose| goal(*pose, asked_m)).collect();
        sheet.insert("goals".into(), tables.into());
        let mut run = Table::new();
        run.insert("time_limit_s".into(), TIME_LIMIT_S.into());
        sheet.insert("run".into(), run.into());
        let mut restart = Table::new();
        for budget in ["per_service", "per_run"] {
            restart.insert(budget.into(), RESTARTS_MAX.into());
        }
        sheet.insert("restart".into(), restart.into());
        if !calm {
            sheet.insert("faults".into(), listed(&self.faults)?);
            if !self.swaps.is_empty() {
                sheet.insert("swaps".into(), listed(&self.swaps)?);
            }
        }
        let [x_m, y_m] = goals.last().map_or([0.0; 2], |last| [last.x_m, last.y_m]);
        Ok(Case {
            scenario: write(setup, &name, sheet)?,
            class: Some(self.mode.to_string()),
            seed: seed(self.number),
            time_limit_s: TIME_LIMIT_S,
            rule: Rule {
                success: Success::Arrival {
                    goal_m: [x_m, y_m],
                    tolerance_m,
                    standing_counts: false,
                },
                optimal_time_s: None,
                reference_m: None,
                future_is_known: self.place == Place::ORBITS,
                way: OutlineWay::NotSearched,
            },
            manner: Manner {
                real_time: self.is_real_time(),
                temp: Some(absolute(&temp.path().join(&name))),
            },
            world,
        })
    }
}

/// A scenario without what all drives have in common.
struct Route {
    sheet: Table,
    /// `map_from_base` of each goal; any yaw.
    goals: Vec<Pose>,
    /// How near the robot's centre must come to them. [m]
    tolerance_m: f64,
}

impl Place {
    fn route(self, setup: &Setup<'_>, world: &str, number: u32) -> Result<Route, String> {
        match self {
            Self::Generated { class } => {
                let number_of_world = (number % NUMBERS) * Class::COUNT + class;
                let (course, sheet) =
                    generated::sheet(String::new(), world, number_of_world, seed(number))?;
                let ends = [course.goal, course.start];
                Ok(Route {
                    sheet: sheet.table(setup)?,
                    goals: ends.into_iter().cycle().take(CROSSINGS).collect(),
                    tolerance_m: course.goal_tolerance_m,
                })
            }
            Self::Warehouse => Ok(warehouse(world)),
            Self::BlockedAisle => {
                let mut route = warehouse(world);
                let load: Table = LOAD.parse().map_err(|error| format!("{error}"))?;
                route.sheet.insert("world".into(), load.into());
                Ok(route)
            }
        }
    }
}

/// A porter with wheels that slip and odometry that drifts.
fn warehouse(world: &str) -> Route {
    let mut robot = Table::new();
    robot.insert("slip".into(), true.into());
    robot.insert("odometry".into(), true.into());
    let mut sheet = Table::new();
    sheet.insert("title".into(), format!("Warehouse, {world}").into());
    sheet.insert("base".into(), vec!["warehouse", "porter"].into());
    sheet.insert("start".into(), numbers(Pose::new(4.5, 6.425, 0.0)));
    sheet.insert("robot".into(), robot.into());
    let at = |[x_m, y_m]: &[f64; 2]| Pose::new(*x_m, *y_m, 0.0);
    Route {
        sheet,
        goals: AROUND_M.iter().map(at).collect(),
        tolerance_m: 1.0,
    }
}

/// Services, each exchanged for a new process of the same binary.
fn swaps(dice: &mut Pcg64Mcg) -> Vec<SwapSpec> {
    let seats: Vec<Role> = mortals().collect();
    let swap = |from_s| SwapSpec {
        service: seats[dice.random_range(0..seats.len())].to_string(),
        at_s: from_s + dice.random_range(0.0..SWAPS_WITHIN_S),
        binary: None,
        config: Table::new(),
        shadow_s: SHADOW_S,
        keep_s: KEEP_S_MIN,
        require: None,
    };
    SWAPS_S.into_iter().map(swap).collect()
}

fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}

/// Seed of everything in a drive.
fn seed(number: u32) -> u64 {
    u64::from(number) + 1
}

/// A list of a scenario.
fn listed(items: &[impl Serialize]) -> Result<Value, String> {
    let tables = items.iter().map(Value::try_from).collect();
    let tables: Result<Vec<Value>, _> = tables;
    tables.map(Value::from).map_err(|error| error.to_string())
}
