//! A global planner on a map: the way it finds, what that cost, and whether the way is legal.

use crate::maps::Maze;
use nalgebra::Point2;
use serde_json::Value;
use zeronav_global_planner::{
    CellPath, Control, CornerRule, Expansions, GlobalPlanner, PlanError, PlanQuery, PlanStats,
    PlannerOptions, Unknown, row_of,
};
use zeronav_msgs::Cell;

/// A planner with its options and corner rule.
#[derive(Debug, Clone)]
pub struct Method {
    /// Name in tables.
    pub name: &'static str,
    /// Key of the planner.
    pub key: &'static str,
    /// Options of the papers' planners that differ from the defaults, as in a configuration.
    pub papers: Value,
    /// Corner rule; planners whose rule is their own keep to that.
    pub rule: CornerRule,
}

/// A way over a map.
#[derive(Debug, Clone)]
pub struct Way {
    /// Cells, straight between the centres.
    pub cells: Vec<Cell>,
    /// The curve that the robot would follow, empty where it is the cells. [cells]
    pub curve: Vec<Point2<f64>>,
    /// Length between the centres, or of the curve of a planner that knows no cells. [cells]
    pub length: f64,
    /// Least distance from an obstacle's square. [cells]
    pub clearance: f64,
    /// Counters.
    pub stats: PlanStats,
}

/// Ways of one method on all maps of a kind, or how it failed.
pub type Ways = Vec<Result<Way, PlanError>>;

impl Way {
    /// Cells at which the way changes its direction.
    #[must_use]
    pub fn turns(&self) -> u64 {
        let is_turn = |cells: &&[Cell]| {
            let [one, here, other] = [cells[0], cells[1], cells[2]];
            let (before, after) = (
                (i64::from(here.x - one.x), i64::from(here.y - one.y)),
                (i64::from(other.x - here.x), i64::from(other.y - here.y)),
            );
            // Pieces may be any number of cells long.
            let is_bent = before.0 * after.1 != before.1 * after.0;
            is_bent || before.0 * after.0 + before.1 * after.1 < 0
        };
        self.cells.windows(3).filter(is_turn).count() as u64
    }

    /// Length of the curve that rounds the way; of the way without one. [cells]
    #[must_use]
    pub fn curve_length(&self) -> f64 {
        if self.curve.is_empty() {
            self.length
        } else {
            length(&self.curve)
        }
    }
}

/// Length of a polyline.
#[must_use]
pub fn length(points: &[Point2<f64>]) -> f64 {
    let pairs = points.windows(2);
    pairs.map(|pair| (pair[1] - pair[0]).norm()).sum()
}

/// A fault that ends the tool: a planner broke its own rules.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Fault {
    /// The options are not those of the planner.
    #[error("{method}: {problem}")]
    Options {
        /// Which.
        method: &'static str,
        /// Why.
        problem: String,
    },
    /// The way is not legal, or a theorem does not hold.
    #[error("{what} on map {map}: {problem}")]
    Broken {
        /// Method or theorem.
        what: String,
        /// Number of the map.
        map: usize,
        /// What is wrong.
        problem: String,
    },
}

impl Method {
    /// A planner with its defaults under the strictest rule.
    #[must_use]
    pub const fn new(name: &'static str, key: &'static str) -> Self {
        Self {
            name,
            key,
            papers: Value::Null,
            rule: CornerRule::ForbidAny,
        }
    }

    /// The same under another rule.
    #[must_use]
    pub fn under(self, rule: CornerRule) -> Self {
        Self { rule, ..self }
    }

    /// The same with these options.
    #[must_use]
    pub fn with(self, papers: Value) -> Self {
        Self { papers, ..self }
    }

    /// A planner for this method.
    ///
    /// # Errors
    /// [`Fault::Options`].
    pub fn build(&self) -> Result<Box<dyn GlobalPlanner>, Fault> {
        let problem = |problem: String| Fault::Options {
            method: self.name,
            problem,
        };
        let mut options = serde_json::json!({ "cost_weight": 0.0 });
        if !self.papers.is_null() {
            options["papers"] = self.papers.clone();
        }
        let options: PlannerOptions =
            serde_json::from_value(options).map_err(|error| problem(error.to_string()))?;
        let row = row_of(self.key).map_err(|error| problem(error.to_string()))?;
        Ok((row.build)(&options))
    }

    /// The rule that its ways keep to.
    #[must_use]
    pub fn own_rule(&self) -> CornerRule {
        match self.key {
            "bao_taa" => CornerRule::Allow,
            "bao_aao" | "bao_iaa" | "bao_dij" | "bao_full" => CornerRule::ForbidAny,
            _ => self.rule,
        }
    }

    /// Plans on a map, with a planner of [`Self::build`].
    ///
    /// # Errors
    /// How the planner failed.
    pub fn solve(
        &self,
        planner: &mut dyn GlobalPlanner,
        maze: &Maze,
        path: &mut CellPath,
    ) -> Result<PlanStats, PlanError> {
        let query = PlanQuery {
            map: maze.view(),
            start: maze.pose(maze.start),
            goal: maze.pose(maze.goal),
            tolerance_m: 0.01,
            unknown: Unknown::Lethal,
            corner_rule: self.rule,
        };
        let mut go = |_: Expansions| Control::Go;
        planner.plan(&query, &mut go, path)
    }

    /// The ways of this method on all maps, with how it failed on the others.
    ///
    /// # Errors
    /// [`Fault`], also for a way that is not legal.
    pub fn ways(&self, mazes: &[Maze]) -> Result<Ways, Fault> {
        let halves = mazes.len().div_ceil(2).max(1);
        let parts: Vec<_> = std::thread::scope(|scope| {
            let handles: Vec<_> = mazes
                .chunks(halves)
                .enumerate()
                .map(|(n, part)| scope.spawn(move || self.part(part, n * halves)))
                .collect();
            handles
                .into_iter()
                .map(|handle| match handle.join() {
                    Ok(part) => part,
                    Err(panic) => std::panic::resume_unwind(panic),
                })
                .collect()
        });
        let mut ways = Vec::with_capacity(mazes.len());
        for part in parts {
            ways.extend(part?);
        }
        Ok(ways)
    }

    fn part(&self, mazes: &[Maze], first: usize) -> Result<Ways, Fault> {
        let mut planner = self.build()?;
        let mut path = CellPath::default();
        let mut ways = Vec::with_capacity(mazes.len());
        for (n, maze) in mazes.iter().enumerate() {
            let solved = self.solve(planner.as_mut(), maze, &mut path);
            ways.push(match solved {
                Ok(stats) => {
                    let way = way_of(maze, &path, stats, self.key == "lwx_rrt");
                    check(maze, &way, self.own_rule()).map_err(|problem| Fault::Broken {
                        what: self.name.to_owned(),
                        map: first + n,
                        problem,
                    })?;
                    Ok(way)
                }
                Err(error) => Err(error),
            });
        }
        Ok(ways)
    }
}

fn way_of(maze: &Maze, path: &CellPath, stats: PlanStats, is_curve: bool) -> Way {
    let centre = |cell: &Cell| {
        let pose = maze.pose(*cell);
        Point2::new(pose.x_m, pose.y_m)
    };
    let centres: Vec<Point2<f64>> = path.cells.iter().map(centre).collect();
    let line = if is_curve { &path.curve } else { &centres };
    Way {
        cells: path.cells.clone(),
        curve: path.curve.clone(),
        length: length(line),
        clearance: maze.world.polyline_clearance_m(line),
        stats,
    }
}

/// What is wrong with a way, judged by the map alone: its ends, single steps by the corner rule, longer
/// pieces and curves by their distance from every obstacle's square.
fn check(maze: &Maze, way: &Way, rule: CornerRule) -> Result<(), String> {
    if way.cells.first() != Some(&maze.start) || way.cells.last() != Some(&maze.goal) {
        return Err("does not lead from start to goal".to_owned());
    }
    for pair in way.cells.windows(2) {
        let (dx, dy) = (pair[1].x - pair[0].x, pair[1].y - pair[0].y);
        let blocked = |x: i32, y: i32| !maze.is_free(Cell::new(x, y));
        if blocked(pair[0].x, pair[0].y) || blocked(pair[1].x, pair[1].y) {
            return Err(format!("enters an obstacle at {pair:?}"));
        }
        if dx.abs().max(dy.abs()) > 1 {
            let ends = pair.iter().map(|cell| maze.pose(*cell));
            let line: Vec<_> = ends.map(|pose| Point2::new(pose.x_m, pose.y_m)).collect();
            if maze.world.polyline_clearance_m(&line) <= 0.0 {
                return Err(format!("touches an obstacle on {pair:?}"));
            }
        } else if dx != 0 && dy != 0 {
            let one = blocked(pair[1].x, pair[0].y);
            let other = blocked(pair[0].x, pair[1].y);
            let legal = match rule {
                CornerRule::Allow => true,
                CornerRule::ForbidAny => !one && !other,
                CornerRule::ForbidBoth => !(one && other),
            };
            if !legal {
                return Err(format!("cuts a corner on {pair:?}"));
            }
        }
    }
    let straight =
        f64::from(maze.goal.x - maze.start.x).hypot(f64::from(maze.goal.y - maze.start.y));
    if way.length < straight - 1.0e-9 {
        return Err(format!("{} cells long, {straight} apart", way.length));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::maps::{Ends, MapFamily, MapSpec};

    fn maze() -> Maze {
        let spec = MapSpec {
            family: MapFamily::Blocky,
            size: [12, 9],
            ratio: 0.2,
            ends: Ends::Corners,
        };
        spec.draw(3, 1).unwrap().mazes.remove(0)
    }

    #[test]
    fn legality_is_judged_by_the_map_alone() {
        let maze = maze();
        let method = Method::new("IAA", "bao_iaa");
        let way = method.ways(core::slice::from_ref(&maze)).unwrap().remove(0);
        let way = way.unwrap();
        assert_eq!(check(&maze, &way, CornerRule::ForbidAny), Ok(()));
        let mut short = way.clone();
        short.cells.pop();
        assert!(check(&maze, &short, CornerRule::ForbidAny).is_err());
        let mut through = way.clone();
        through.cells = vec![maze.start, maze.goal];
        assert!(check(&maze, &through, CornerRule::Allow).is_err());
        let mut nearer = way;
        nearer.length = 1.0;
        assert!(check(&maze, &nearer, CornerRule::ForbidAny).is_err());
    }

    #[test]
    fn turns_are_changes_of_direction_whatever_the_length_of_a_piece() {
        let way = maze();
        let mut way = Method::new("IAA", "bao_iaa").ways(&[way]).unwrap();
        let mut way = way.remove(0).unwrap();
        let mut of = |cells: &[(i32, i32)]| {
            way.cells = cells.iter().map(|&(x, y)| Cell::new(x, y)).collect();
            way.turns()
        };
        assert_eq!(of(&[(0, 0)]), 0);
        assert_eq!(of(&[(0, 0), (1, 1), (2, 2), (5, 5)]), 0);
        assert_eq!(of(&[(0, 0), (1, 1), (2, 1), (4, 1), (4, 3)]), 2);
        assert_eq!(of(&[(0, 0), (2, 0), (1, 0)]), 1, "back");
    }

    #[test]
    fn unknown_options_and_planners_are_named() {
        let wrong = Method::new("x", "bao_iaa").with(serde_json::json!({ "colour": 1 }));
        let Err(Fault::Options { problem, .. }) = wrong.build().map(|_| ()) else {
            panic!("it was built");
        };
        assert!(problem.contains("colour"), "{problem}");
        assert!(Method::new("x", "dstar").build().is_err());
    }
}
