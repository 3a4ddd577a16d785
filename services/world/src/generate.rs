//! Random maps, the same for the same seed: single cells, blocks, concave traps, corridors.
//!
//! A map counts only when its goal can be reached from its start by steps to the four
//! neighbours, which is what no corner cutting at all leaves of eight; others are thrown away and
//! drawn again. How often that happens belongs to every result that is won on such maps, so it is
//! reported ([`Generated::tried`]): independent cells percolate only above 59.3 % free ones.

use crate::error::{SpecError, number};
use crate::spec::{Family, GeneratedSpec};
use crate::static_map::{Occupancy, StaticMap};
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;
use zeronav_casts::Cast;
use zeronav_msgs::grid::SIDE_CELLS_MAX;
use zeronav_msgs::{Cell, GridGeometry};

/// Most cells that are drawn in all tries of one map.
const CELLS_DRAWN_MAX: u64 = 200_000_000;

/// Most maps that are tried.
const TRIES_MAX: u64 = 100_000;

/// A random map that can be crossed.
#[derive(Debug, Clone, PartialEq)]
pub struct Generated {
    /// The map.
    pub map: StaticMap,
    /// A free cell.
    pub start: Cell,
    /// A free cell that can be reached from it without cutting corners.
    pub goal: Cell,
    /// Maps that were drawn until this one: acceptance rate = accepted / tried.
    pub tried: u32,
}

/// Why there is no such map.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GenerateError {
    /// A value cannot be.
    #[error(transparent)]
    Spec(#[from] SpecError),
    /// No map of many could be crossed.
    #[error("none of {tried} maps has a way from start to goal: lower the ratio")]
    NoWay {
        /// Maps that were drawn.
        tried: u32,
    },
}

/// Draws a map.
///
/// # Errors
/// See [`GenerateError`].
pub fn generate(spec: &GeneratedSpec) -> Result<Generated, GenerateError> {
    let recipe = Recipe::new(spec)?;
    let mut rng = Pcg64Mcg::seed_from_u64(spec.seed);
    let tries = (CELLS_DRAWN_MAX / recipe.len() as u64).clamp(16, TRIES_MAX);
    for tried in 1..=u32::try_from(tries).unwrap_or(u32::MAX) {
        let mut drawing = Drawing::new(&recipe);
        match spec.family {
            Family::Iid => drawing.iid(&mut rng),
            Family::Blocky { side_cells_max } => drawing.blocky(&mut rng, side_cells_max),
            Family::Concave { side_cells_max } => drawing.concave(&mut rng, side_cells_max),
            Family::Corridor { width_cells } => drawing.corridor(&mut rng, width_cells),
        }
        if recipe.is_crossed(&drawing.occupied) {
            return Ok(Generated {
                map: recipe.map(&drawing.occupied),
                start: recipe.start,
                goal: recipe.goal,
                tried,
            });
        }
    }
    let tried = u32::try_from(tries).unwrap_or(u32::MAX);
    Err(GenerateError::NoWay { tried })
}

/// A checked request.
struct Recipe {
    geometry: GridGeometry,
    /// Cells to occupy.
    n_occupied: usize,
    start: Cell,
    goal: Cell,
}

impl Recipe {
    fn new(spec: &GeneratedSpec) -> Result<Self, SpecError> {
        let [width, height] = spec.size_cells;
        for (axis, side) in [width, height].into_iter().enumerate() {
            let field = format!("size_cells[{axis}]");
            number(f64::from(side), 2.0, f64::from(SIDE_CELLS_MAX), &field)?;
        }
        number(spec.ratio, 0.0, 1.0, "ratio")?;
        number(spec.resolution_m, 1.0e-3, 10.0, "resolution_m")?;
        let (field, sides) = match spec.family {
            Family::Iid => ("family", 1),
            Family::Blocky { side_cells_max } | Family::Concave { side_cells_max } => {
                ("family.side_cells_max", side_cells_max)
            }
            Family::Corridor { width_cells } => ("family.width_cells", width_cells),
        };
        let sides_min = match spec.family {
            Family::Concave { .. } => 3.0,
            _ => 1.0,
        };
        number(
            f64::from(sides),
            sides_min,
            f64::from(width.min(height)),
            field,
        )?;
        let geometry = GridGeometry {
            origin_x_m: 0.0,
            origin_y_m: 0.0,
            resolution_m: spec.resolution_m,
            width,
            height,
        };
        let cell = |given: Option<[u32; 2]>, other: Cell, field: &str| {
            let cell = given.map_or(Some(other), |[x, y]| {
                Some(Cell::new(i32::try_from(x).ok()?, i32::try_from(y).ok()?))
            });
            cell.filter(|cell| geometry.contains(*cell))
                .ok_or_else(|| SpecError::new(field, "lies beside the map"))
        };
        let (columns, rows) = geometry.size();
        let start = cell(spec.start_cell, Cell::new(0, 0), "start_cell")?;
        let goal = cell(
            spec.goal_cell,
            Cell::new(columns - 1, rows - 1),
            "goal_cell",
        )?;
        let n_kept = if start == goal { 1 } else { 2 };
        let n_occupied = (spec.ratio * geometry.len().to_f64()).round().to_usize();
        if matches!(spec.family, Family::Corridor { .. }) && n_occupied > 0 {
            let why = "corridors follow from their width: remove it";
            return Err(SpecError::new("ratio", why));
        }
        if n_occupied + n_kept > geometry.len() {
            let why = "leaves no free cell for start and goal";
            return Err(SpecError::new("ratio", why));
        }
        Ok(Self {
            geometry,
            n_occupied,
            start,
            goal,
        })
    }

    fn len(&self) -> usize {
        self.geometry.len()
    }

    fn map(&self, occupied: &[bool]) -> StaticMap {
        let mut map = StaticMap::free(self.geometry);
        for (cell, occupied) in map.cells.iter_mut().zip(occupied) {
            if *occupied {
                *cell = Occupancy::Occupied;
            }
        }
        map
    }

    /// True when steps to the four neighbours lead from start to goal.
    fn is_crossed(&self, occupied: &[bool]) -> bool {
        let mut seen = occupied.to_vec();
        let mut open = vec![self.start];
        while let Some(cell) = open.pop() {
            if cell == self.goal {
                return true;
            }
            for (dx, dy) in [(1, 0), (0, 1), (-1, 0), (0, -1)] {
                let next = Cell::new(cell.x + dx, cell.y + dy);
                if let Some(index) = self.geometry.index_of(next)
                    && !seen[index]
                {
                    seen[index] = true;
                    open.push(next);
                }
            }
        }
        false
    }
}

/// A map in the making.
struct Drawing<'a> {
    recipe: &'a Recipe,
    occupied: Vec<bool>,
    n_left: usize,
}

impl<'a> Drawing<'a> {
    fn new(recipe: &'a Recipe) -> Self {
        Self {
            occupied: vec![false; recipe.len()],
            n_left: recipe.n_occupied,
            recipe,
        }
    }

    /// Occupies `cell`, unless it lies beside the map, is kept free, or the count is reached.
    fn occupy(&mut self, cell: Cell) {
        let kept = cell == self.recipe.start || cell == self.recipe.goal;
        if let Some(index) = self.recipe.geometry.index_of(cell)
            && !kept
            && !self.occupied[index]
            && self.n_left > 0
        {
            self.occupied[index] = true;
            self.n_left -= 1;
        }
    }

    /// A partial shuffle (Fisher and Yates) of all cells that may be occupied.
    fn iid(&mut self, rng: &mut Pcg64Mcg) {
        let geometry = &self.recipe.geometry;
        let kept = [self.recipe.start, self.recipe.goal].map(|cell| geometry.index_of(cell));
        let n_cells = u32::try_from(self.recipe.len()).unwrap_or(u32::MAX);
        let mut cells: Vec<u32> = (0..n_cells)
            .filter(|index| !kept.contains(&Some(*index as usize)))
            .collect();
        let last = u32::try_from(cells.len()).unwrap_or(u32::MAX);
        for drawn in 0..self.n_left {
            let first = u32::try_from(drawn).unwrap_or(u32::MAX);
            let other = rng.random_range(first..last) as usize;
            cells.swap(drawn, other);
            self.occupied[cells[drawn] as usize] = true;
        }
        self.n_left = 0;
    }

    fn blocky(&mut self, rng: &mut Pcg64Mcg, side_cells_max: u32) {
        while self.n_left > 0 {
            let corner = self.anywhere(rng);
            let (width, height) = (side(rng, 1, side_cells_max), side(rng, 1, side_cells_max));
            for y in 0..height {
                for x in 0..width {
                    self.occupy(Cell::new(corner.x + x, corner.y + y));
                }
            }
        }
    }

    fn concave(&mut self, rng: &mut Pcg64Mcg, side_cells_max: u32) {
        while self.n_left > 0 {
            let corner = self.anywhere(rng);
            let size = (side(rng, 3, side_cells_max), side(rng, 3, side_cells_max));
            let cells = match rng.random_range(0..3_u32) {
                0 => u_trap(size),
                1 => l_trap(size),
                _ => spiral(size),
            };
            let quarters = rng.random_range(0..4_u32);
            for (x, y) in cells {
                let (x, y) = turned((x, y), size, quarters);
                self.occupy(Cell::new(corner.x + x, corner.y + y));
            }
        }
    }

    /// Walls across the map, one cell thick and `width` cells apart, with a gap of `width` cells
    /// at one end; the ends alternate, so the way goes to and fro.
    fn corridor(&mut self, rng: &mut Pcg64Mcg, width_cells: u32) {
        self.n_left = self.recipe.len();
        let (columns, rows) = self.recipe.geometry.size();
        let width = i32::try_from(width_cells).unwrap_or(i32::MAX);
        let mut open_right = rng.random::<bool>();
        let mut y = width;
        while y.saturating_add(width) < rows {
            for x in 0..columns {
                let from_open_end = if open_right { columns - 1 - x } else { x };
                if from_open_end >= width {
                    self.occupy(Cell::new(x, y));
                }
            }
            open_right = !open_right;
            y = y.saturating_add(width).saturating_add(1);
        }
    }

    fn anywhere(&self, rng: &mut Pcg64Mcg) -> Cell {
        let (columns, rows) = self.recipe.geometry.size();
        Cell::new(rng.random_range(0..columns), rng.random_range(0..rows))
    }
}

fn side(rng: &mut Pcg64Mcg, least: u32, most: u32) -> i32 {
    i32::try_from(rng.random_range(least..=most)).unwrap_or(i32::MAX)
}

/// Three sides of a rectangle, open at the top.
fn u_trap((width, height): (i32, i32)) -> Vec<(i32, i32)> {
    let sides = (1..height).flat_map(|y| [(0, y), (width - 1, y)]);
    (0..width).map(|x| (x, 0)).chain(sides).collect()
}

/// Two sides of a rectangle.
fn l_trap((width, height): (i32, i32)) -> Vec<(i32, i32)> {
    let upright = (1..height).map(|y| (0, y));
    (0..width).map(|x| (x, 0)).chain(upright).collect()
}

/// A wall that winds inwards, a free cell between its turns.
fn spiral((width, height): (i32, i32)) -> Vec<(i32, i32)> {
    const WAYS: [(i32, i32); 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];
    let mut cells = vec![(0, 0)];
    let (mut x, mut y, mut way) = (0, 0, 0_usize);
    let mut turns = 0;
    while turns < 2 {
        let (dx, dy) = WAYS[way % 4];
        let next = (x + dx, y + dy);
        let inside = (0..width).contains(&next.0) && (0..height).contains(&next.1);
        if inside && !cells.contains(&next) && !cells.contains(&(next.0 + dx, next.1 + dy)) {
            (x, y) = next;
            cells.push(next);
            turns = 0;
        } else {
            way += 1;
            turns += 1;
        }
    }
    cells
}

/// A cell of a box of `size` after the box was turned by quarters.
fn turned((x, y): (i32, i32), (width, height): (i32, i32), quarters: u32) -> (i32, i32) {
    match quarters % 4 {
        0 => (x, y),
        1 => (height - 1 - y, x),
        2 => (width - 1 - x, height - 1 - y),
        _ => (y, width - 1 - x),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn traps_have_the_form_of_their_name() {
        let drawn = |cells: &[(i32, i32)], width: i32, height: i32| -> Vec<String> {
            let row = |y: i32| {
                let mark = |x| if cells.contains(&(x, y)) { '#' } else { '.' };
                (0..width).map(mark).collect()
            };
            (0..height).rev().map(row).collect()
        };
        assert_eq!(drawn(&u_trap((3, 2)), 3, 2), ["#.#", "###"]);
        assert_eq!(drawn(&l_trap((3, 2)), 3, 2), ["#..", "###"]);
        let expected = [
            "#######", //
            "#.....#", //
            "#.###.#", //
            "#...#.#", //
            "#####.#", //
            "......#", //
            "#######",
        ];
        assert_eq!(drawn(&spiral((7, 7)), 7, 7), expected);
        let quarter: Vec<_> = l_trap((3, 2))
            .iter()
            .map(|at| turned(*at, (3, 2), 1))
            .collect();
        assert_eq!(drawn(&quarter, 2, 3), [".#", ".#", "##"]);
    }
}
