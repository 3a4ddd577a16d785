//! [JU] tables I and II: the fusion of A* and potential field against A*, the field alone, and its
//! references 6 and 7, on 15 x 15 cells of a metre with fifty blocked ones.

use crate::figure::Drawing;
use crate::maps::{Ends, MapFamily, MapSpec, Maze};
use crate::rollout::{Rollout, bodies, goal_of, roll, walked, waypoints};
use crate::row::{Place, Row};
use crate::solve::{Method, Way, Ways};
use crate::stats;
use crate::table::{Context, Outcome, TableError, draw, excluded, figure};
use crate::verdict::{Printed, Standing};
use serde_json::json;
use std::hint::black_box;
use std::time::Instant;
use zeronav_global_planner::CornerRule;
use zeronav_local_planner::papers::Law;
use zeronav_local_planner::papers::ju_apf::JuApf;
use zeronav_local_planner::papers::ju_fusion::JuFusion;
use zeronav_local_planner::papers::ju_r6::JuR6;
use zeronav_local_planner::papers::ju_r7::JuR7;
use zeronav_local_planner::papers::options::{JuFusionConfig, JuR6Config, JuR7Config};
use zeronav_local_planner::papers::potential::Gains;
use zeronav_local_planner::papers::walk::{End, Walk};
use zeronav_observe::statistics::median;

/// Fifty cells.
const SPEC: MapSpec = MapSpec {
    family: MapFamily::Iid,
    size: [15, 15],
    ratio: 50.0 / 225.0,
    ends: Ends::Cells([1, 1], [11, 11]),
};

/// Roll-outs, with the printed change of the fusion's length and time against them.
const LAWS: [(&str, f64, f64); 3] = [
    ("APF", -0.0578, 3.4960),
    ("reference 6", -0.1004, 0.2450),
    ("reference 7", -0.1045, 0.3877),
];
const ASTAR_LENGTH: f64 = -0.0346;
const ASTAR_TIME: f64 = 0.5592;

/// Printed lengths of A* and of the field alone: A* is the shorter one.
const ASTAR_APF: f64 = 14.7279 / 15.0897 - 1.0;

/// Control period of the robot, within which a step of a method that is called real-time must be. [s]
const PERIOD_S: f64 = 0.02;

fn fusion(r1_m: f64) -> JuFusion {
    JuFusion::new(&JuFusionConfig {
        r1_m,
        ..JuFusionConfig::default()
    })
}

fn law(name: &str) -> Box<dyn Law> {
    match name {
        "APF" => Box::new(JuApf::new(Gains::JU)),
        "reference 6" => Box::new(JuR6::new(&JuR6Config::default())),
        "reference 7" => Box::new(JuR7::new(&JuR7Config::default())),
        _ => Box::new(fusion(1.5)),
    }
}

fn astar() -> Method {
    Method::new("A*", "ju_astar").under(CornerRule::Allow)
}

/// How obstacles are taken.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Mode {
    /// As points, which a path may cross: as printed.
    Point,
    /// As squares.
    Area,
}

impl Mode {
    const fn name(self) -> &'static str {
        match self {
            Self::Point => "point obstacles",
            Self::Area => "area obstacles",
        }
    }

    const fn walk(self, step: f64) -> Walk {
        Walk {
            literal: matches!(self, Self::Point),
            step,
            ..Walk::JU
        }
    }
}

struct Set {
    mazes: Vec<Maze>,
    ways: Vec<Way>,
    place: Place,
}

fn set(context: &Context, table: &'static str) -> Result<Set, TableError> {
    let (mazes, place) = draw(context, "JU", table, &SPEC)?;
    let ways = astar().ways(&mazes.mazes)?;
    // Every map can be crossed without cutting corners, so that A* finds a way on all of them.
    let ways: Vec<Way> = ways.into_iter().flatten().collect();
    Ok(Set {
        mazes: mazes.mazes,
        ways,
        place,
    })
}

fn all(set: &Set, mut law: impl FnMut() -> Box<dyn Law>, how: &Walk) -> Vec<Rollout> {
    let maps = set.mazes.iter().zip(&set.ways);
    maps.map(|(maze, way)| {
        let route = waypoints(maze, way);
        roll(law().as_mut(), maze, &bodies(maze), &route, how)
    })
    .collect()
}

/// Changes of length from a base to the fusion where both arrive, and the share left out.
fn changes(set: &Set, fusion: &[Rollout], base: impl Fn(usize) -> Option<f64>) -> (Vec<f64>, f64) {
    let found: Vec<f64> = fusion
        .iter()
        .enumerate()
        .filter(|(_, rollout)| rollout.arrived())
        .filter_map(|(n, rollout)| Some(rollout.length(goal_of(&set.mazes[n])) / base(n)? - 1.0))
        .collect();
    let left = excluded(found.len(), fusion.len());
    (found, left)
}

/// Table I.
pub(super) fn lengths(context: &mut Context) -> Result<Outcome, TableError> {
    let set = set(context, "1")?;
    let mut outcome = Outcome::default();
    let optimum = Method::new("A*", "tn_a8").with(json!({ "heuristic": "octile" }));
    let pulled = Method::new("pulled A*", "c_los");
    let baselines = [optimum.ways(&set.mazes)?, pulled.ways(&set.mazes)?];
    for mode in [Mode::Point, Mode::Area] {
        let how = mode.walk(Walk::JU.step);
        let named = ["fusion", "APF", "reference 6", "reference 7"]
            .map(|name| (name, all(&set, || law(name), &how)));
        let rows = &mut outcome.rows;
        arrivals(&set, mode, &named, rows);
        against_laws(&set, mode, &named, rows);
        against_astar(&set, mode, &named[0].1, (&baselines, rows));
        field_against_astar(&set, mode, &named[1].1, rows);
        sweep(&set, mode, rows);
        if mode == Mode::Area {
            let named = named
                .each_ref()
                .map(|(name, rollouts)| (*name, &rollouts[..]));
            outcome.drawing = Drawing::of_rollouts(&set.mazes, &set.ways, &named);
        }
    }
    Ok(outcome)
}

/// Names with their roll-outs, the fusion first.
type Named<'a> = [(&'a str, Vec<Rollout>)];

/// How a figure of this mode stands: what holds for points alone holds because paths cross obstacles.
const fn standing(mode: Mode) -> Standing {
    match mode {
        Mode::Point => Standing::Artefact,
        Mode::Area => Standing::Fair,
    }
}

fn arrivals(set: &Set, mode: Mode, named: &Named<'_>, rows: &mut Vec<Row>) {
    for (name, rollouts) in named {
        let clean = rollouts.iter().filter(|rollout| rollout.is_clean()).count();
        let share = (stats::share(clean, rollouts.len()), 0.0);
        let metric = "arrives without a collision (share)";
        rows.push(
            set.place
                .row(figure("safety", metric, name, Printed::Nothing, share).noting(mode.name())),
        );
        let arrived = rollouts.iter().filter(|rollout| rollout.arrived()).count();
        let share = stats::share(arrived - clean, arrived);
        let share = (share, excluded(arrived, rollouts.len()));
        let algorithm = format!("{name}, where it arrives");
        rows.push(
            set.place.row(
                figure(
                    "safety",
                    "collides (share)",
                    &algorithm,
                    Printed::Nothing,
                    share,
                )
                .noting(mode.name()),
            ),
        );
    }
}

fn against_laws(set: &Set, mode: Mode, named: &Named<'_>, rows: &mut Vec<Row>) {
    for ((name, printed, _), (_, rollouts)) in LAWS.iter().zip(&named[1..]) {
        let base = |n: usize| {
            let rollout = &rollouts[n];
            rollout
                .arrived()
                .then(|| rollout.length(goal_of(&set.mazes[n])))
        };
        let (found, left) = changes(set, &named[0].1, base);
        let claim = if *name == "APF" { "C2" } else { "C3" };
        let algorithm = format!("fusion vs {name}");
        let ours = (stats::mean(&found), left);
        rows.push(
            set.place.row(
                figure(claim, "length", &algorithm, Printed::Change(*printed), ours)
                    .standing(standing(mode))
                    .noting(mode.name()),
            ),
        );
    }
}

fn against_astar(
    set: &Set,
    mode: Mode,
    fusion: &[Rollout],
    ([best, pulled], rows): (&[Ways; 2], &mut Vec<Row>),
) {
    let length = |ways: &Ways, n: usize| ways[n].as_ref().ok().map(|way| way.length);
    let printed = Printed::Change(ASTAR_LENGTH);
    let as_paper = changes(set, fusion, |n| Some(set.ways[n].length));
    let matched = changes(set, fusion, |n| length(best, n));
    let taut = changes(set, fusion, |n| length(pulled, n));
    for (name, (found, left), printed) in [
        ("fusion vs A*", as_paper, printed),
        ("fusion vs A*, no corner cut", matched, printed),
        ("fusion vs pulled A*", taut, Printed::Nothing),
    ] {
        rows.push(
            set.place.row(
                figure("C1", "length", name, printed, (stats::mean(&found), left))
                    .standing(standing(mode))
                    .noting(mode.name()),
            ),
        );
    }
}

/// Table I without the fusion: A* against the field alone.
fn field_against_astar(set: &Set, mode: Mode, field: &[Rollout], rows: &mut Vec<Row>) {
    let arrived = |n: &usize| field[*n].arrived();
    let found: Vec<f64> = (0..field.len())
        .filter(arrived)
        .map(|n| set.ways[n].length / field[n].length(goal_of(&set.mazes[n])) - 1.0)
        .collect();
    let left = excluded(found.len(), field.len());
    let ours = (stats::mean(&found), left);
    let printed = Printed::Change(ASTAR_APF);
    rows.push(
        set.place.row(
            figure("C6", "length", "A* vs APF", printed, ours)
                .standing(standing(mode))
                .noting(mode.name()),
        ),
    );
}

/// The sizes that are not printed: circle and step.
fn sweep(set: &Set, mode: Mode, rows: &mut Vec<Row>) {
    for r1_m in [1.0, 1.5, 2.0, 3.0] {
        for step in [0.05, 0.2] {
            let rollouts = all(set, || Box::new(fusion(r1_m)), &mode.walk(step));
            let base = |n: usize| Some(set.ways[n].length);
            let (found, left) = changes(set, &rollouts, base);
            rows.push(
                set.place.row(
                    figure(
                        "C1",
                        "length",
                        "fusion vs A*, sweep",
                        Printed::Nothing,
                        (stats::mean(&found), left),
                    )
                    .noting(mode.name())
                    .with(json!({ "r1_m": r1_m, "step_m": step })),
                ),
            );
        }
    }
}

/// The share of the maps on which a step of the fusion takes less than a control period on average.
fn real_time(set: &Set, how: &Walk) -> Row {
    let maps = set.mazes.iter().zip(&set.ways);
    let in_time = maps.filter(|(maze, way)| {
        let (around, route) = (bodies(maze), waypoints(maze, way));
        let started = Instant::now();
        let trace = black_box(walked(law("fusion").as_mut(), maze, &around, &route, how));
        let steps = u32::try_from(trace.steps.max(1)).unwrap_or(u32::MAX);
        started.elapsed().as_secs_f64() / f64::from(steps) < PERIOD_S
    });
    let ours = (stats::share(in_time.count(), set.mazes.len()), 0.0);
    let metric = "a step within a control period of 20 ms (share)";
    let figure = figure("C7", metric, "fusion", Printed::Always, ours);
    set.place.row(figure.noting(Mode::Point.name()))
}

/// What is timed, the fusion last.
const TIMED: [&str; 5] = ["A*", "APF", "reference 6", "reference 7", "fusion"];

/// Times of each of [`TIMED`] on the first maps, medians of 31 interleaved repetitions; `None` where a walk
/// does not arrive: one that is caught ends after a few steps or after two thousand. [s]
fn timed(set: &Set, how: &Walk) -> Result<[Vec<Option<f64>>; TIMED.len()], TableError> {
    const REPETITIONS: usize = 31;
    const MAPS_MAX: usize = 40;
    let astar = astar();
    let mut planner = astar.build()?;
    let mut path = zeronav_global_planner::CellPath::default();
    let mut found = [const { Vec::new() }; TIMED.len()];
    for (maze, way) in set.mazes.iter().zip(&set.ways).take(MAPS_MAX) {
        let (around, route) = (bodies(maze), waypoints(maze, way));
        let mut times = [const { Vec::new() }; TIMED.len()];
        let mut arrives = [true; TIMED.len()];
        for _ in 0..REPETITIONS {
            for (n, name) in TIMED.iter().enumerate() {
                let started = Instant::now();
                // Every method but the field alone begins with A*.
                if *name != "APF" {
                    let solved = astar.solve(planner.as_mut(), maze, &mut path);
                    black_box(&solved).as_ref().ok();
                }
                if *name != "A*" {
                    let trace = walked(law(name).as_mut(), maze, &around, &route, how);
                    arrives[n] &= black_box(trace).end == End::Reached;
                }
                times[n].push(started.elapsed().as_secs_f64());
            }
        }
        for ((found, times), arrives) in found.iter_mut().zip(times).zip(arrives) {
            found.push(median(times).filter(|_| arrives));
        }
    }
    Ok(found)
}

/// Table II.
pub(super) fn times(context: &mut Context) -> Result<Outcome, TableError> {
    let set = set(context, "2")?;
    let how = Mode::Point.walk(Walk::JU.step);
    let [bases @ .., of_fusion] = timed(&set, &how)?;
    let mut outcome = Outcome::default();
    outcome.rows.push(real_time(&set, &how));
    let printed = core::iter::once(ASTAR_TIME).chain(LAWS.map(|(_, _, time)| time));
    for ((name, base), printed) in TIMED.iter().zip(&bases).zip(printed) {
        let both = of_fusion.iter().zip(base);
        let changes: Vec<f64> = both
            .filter_map(|(ours, base)| Some((*ours)? / (*base)? - 1.0))
            .collect();
        let left = excluded(changes.len(), base.len());
        let algorithm = format!("fusion vs {name}");
        let printed = Printed::Change(printed);
        let ours = (stats::mean(&changes), left);
        outcome.rows.push(
            set.place.row(
                figure("C4", "time", &algorithm, printed, ours)
                    .noting("ratio of medians of 31, interleaved, point obstacles"),
            ),
        );
    }
    Ok(outcome)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reference 6 is caught on some maps even where obstacles are points: its time there is none of a path.
    #[test]
    fn a_walk_that_does_not_arrive_has_no_time() {
        let mut context = Context {
            seeds: 40,
            drives: 0,
            seed: 1,
            families: Vec::new(),
            stack: None,
        };
        let set = set(&context, "2").unwrap();
        let how = Mode::Point.walk(Walk::JU.step);
        let caught = |name: &str| {
            let rollouts = all(&set, || law(name), &how);
            rollouts.iter().filter(|rollout| !rollout.arrived()).count()
        };
        let (fusion, r6) = (caught("fusion"), caught("reference 6"));
        assert_eq!(fusion, 0);
        assert!((1..30).contains(&r6), "{r6} of 40");
        let rows = times(&mut context).unwrap().rows;
        let of = |name: &str| rows.iter().find(|row| row.algorithm == name).unwrap();
        let row = of("fusion vs reference 6");
        assert_eq!(row.n, 40 - r6, "{row:?}");
        assert!(
            (row.excluded - excluded(row.n, 40)).abs() < 1.0e-12,
            "{row:?}"
        );
        assert_eq!(of("fusion vs A*").n, 40);
    }
}
