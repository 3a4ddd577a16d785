//! Static cylinders in a corridor by the published rules of BARN (Perille, Truong, Xiao, Stone,
//! "Benchmarking Metric Ground Navigation", SSRR 2020).
//!
//! A cellular automaton: each cell of a field of 30 x 30 is filled with a given probability; then,
//! a few times over, a cell with five or more filled neighbours of its eight is filled, one with
//! one or none is emptied, and the others stay. Cells beyond the field count as empty. A filled
//! cell is a cylinder that is as wide as the cell. The field lies at the end of a corridor with a
//! closed near side, and a world counts only when the robot can get from the start to the goal
//! behind the field.

use super::passage::{Robot, shortest_m};
use super::{NoPassage, first_passable, millimetres};
use crate::barn::{BarnWorld, GOAL, GOAL_TOLERANCE_M, START};
use rand::RngExt as _;
use rand_pcg::Pcg64Mcg;
use zeronav_casts::Cast;
use zeronav_world::{World, WorldSpec};

/// Cells along a side of the field.
const SIDE: usize = 30;

/// Side of a cell. [m]
const CELL_M: f64 = 0.15;

/// Radius of a cylinder. [m]
const RADIUS_M: f64 = 0.075;

/// Centre of the first column and the first row of the corridor. [m]
const FIRST_M: [f64; 2] = [-4.425, 0.075];

/// Rows of the corridor, and the first that is of the field.
const ROWS: [usize; 2] = [64, 34];

/// Worlds that are drawn until one can be passed.
const TRIES: u32 = 100;

/// How much is in the way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rule {
    /// Probability with which a cell is filled at first.
    pub fill_ratio: f64,
    /// Passes of the automaton: more make fewer, larger lumps.
    pub smoothings: u32,
}

/// A world that can be passed.
#[derive(Debug, Clone, PartialEq)]
pub struct Clutter {
    /// Its cylinders.
    pub world: BarnWorld,
    /// Length of the shortest drive in eight directions from [`START`] to [`GOAL`] of the disc
    /// around the robot. [m]
    pub path_length_m: f64,
}

/// Draws a world that `robot` can pass.
///
/// # Errors
/// [`NoPassage`] when none of many can be passed.
pub fn draw(rule: Rule, robot: Robot, seed: u64) -> Result<Clutter, NoPassage> {
    first_passable(seed, TRIES, |rng| {
        let world = corridor(&field(rule, rng));
        let spec: WorldSpec = world.spec();
        let asked = World::new(&spec, None).ok()?;
        let ends = [START.point(), GOAL.point()];
        let to_tolerance_m = shortest_m(&asked, robot, ends, GOAL_TOLERANCE_M)?;
        Some(Clutter {
            world,
            path_length_m: to_tolerance_m + GOAL_TOLERANCE_M,
        })
    })
}

/// The cells of a field, row by row.
fn field(rule: Rule, rng: &mut Pcg64Mcg) -> Vec<bool> {
    let mut filled: Vec<bool> = (0..SIDE * SIDE)
        .map(|_| rng.random_bool(rule.fill_ratio.clamp(0.0, 1.0)))
        .collect();
    for _ in 0..rule.smoothings {
        filled = smoothed(&filled);
    }
    filled
}

/// A field after a pass of the automaton.
fn smoothed(filled: &[bool]) -> Vec<bool> {
    (0..SIDE * SIDE)
        .map(|index| match neighbours(filled, index) {
            5.. => true,
            0..=1 => false,
            _ => filled[index],
        })
        .collect()
}

/// Filled ones of the eight neighbours of a cell.
fn neighbours(filled: &[bool], index: usize) -> usize {
    let (x, y) = (index % SIDE, index / SIDE);
    let around = |n: usize| n.saturating_sub(1)..(n + 2).min(SIDE);
    around(y)
        .flat_map(|row| around(x).map(move |column| row * SIDE + column))
        .filter(|other| *other != index && filled[*other])
        .count()
}

/// A field at the end of its corridor.
fn corridor(filled: &[bool]) -> BarnWorld {
    let mut cylinders = Vec::new();
    for row in 0..ROWS[0] {
        for column in 0..SIDE {
            let is_wall = row == 0 || column == 0 || column == SIDE - 1;
            let in_field = row.checked_sub(ROWS[1]).map(|row| row * SIDE + column);
            if is_wall || in_field.is_some_and(|index| filled[index]) {
                let along =
                    |n: usize, axis: usize| millimetres(FIRST_M[axis] + CELL_M * n.to_f64());
                cylinders.push([along(column, 0), along(row, 1), RADIUS_M]);
            }
        }
    }
    BarnWorld { cylinders }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROBOT: Robot = Robot { radius_m: 0.33 };

    #[test]
    fn the_automaton_fills_and_empties_by_its_neighbours() {
        // A block of 3 x 3 with a hole, and a cell by itself in the corner.
        let at = |x: usize, y: usize| y * SIDE + x;
        let mut filled = vec![false; SIDE * SIDE];
        for y in 10..13 {
            for x in 10..13 {
                filled[at(x, y)] = (x, y) != (11, 11);
            }
        }
        filled[0] = true;
        assert_eq!(neighbours(&filled, at(11, 11)), 8);
        assert_eq!(neighbours(&filled, at(1, 0)), 1);
        assert_eq!(neighbours(&filled, at(10, 10)), 2);
        assert_eq!(neighbours(&filled, at(9, 11)), 3);
        let after = smoothed(&filled);
        assert!(after[at(11, 11)], "eight neighbours fill");
        assert!(after[at(10, 10)], "two neighbours keep a filled cell");
        assert!(
            !after[at(9, 11)],
            "three neighbours do not fill an empty one"
        );
        assert!(!after[0], "a cell by itself goes");
    }

    #[test]
    fn a_world_is_a_corridor_with_a_field_that_can_be_passed() {
        let rule = Rule {
            fill_ratio: 0.2,
            smoothings: 2,
        };
        let clutter = draw(rule, ROBOT, 7).unwrap();
        assert_eq!(clutter, draw(rule, ROBOT, 7).unwrap());
        assert_ne!(clutter, draw(rule, ROBOT, 8).unwrap());
        let in_field = |[x, y, _]: &&[f64; 3]| *y > 5.0 && (-4.4..-0.1).contains(x);
        let n_field = clutter.world.cylinders.iter().filter(in_field).count();
        assert!(n_field > 20, "{n_field}");
        // Two side walls of 64 and the near one.
        assert!(clutter.world.cylinders.len() >= 2 * 64 + 28 + n_field);
        assert!(
            (10.0..15.0).contains(&clutter.path_length_m),
            "{}",
            clutter.path_length_m
        );
    }

    #[test]
    fn what_nothing_can_pass_is_an_error_and_no_endless_search() {
        let full = Rule {
            fill_ratio: 1.0,
            smoothings: 0,
        };
        let error = draw(full, ROBOT, 1).unwrap_err();
        assert_eq!(
            error,
            NoPassage {
                seed: 1,
                tried: TRIES
            }
        );
    }
}
