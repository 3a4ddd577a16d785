//! Random maps of a size and a share of obstacles, the same for the same seed.

use nalgebra::Point2;
use zeronav_casts::Cast;
use zeronav_msgs::map::COST_LETHAL;
use zeronav_msgs::{Cell, GridGeometry, MapCell, MapView, Pose};
use zeronav_world::World;
use zeronav_world::generate::{GenerateError, generate};
use zeronav_world::spec::{Family, GeneratedSpec, WorldSpec};
use zeronav_world::static_map::{Occupancy, StaticMap};

/// Which maps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapSpec {
    /// How blocked cells lie.
    pub family: MapFamily,
    /// Columns and rows.
    pub size: [u32; 2],
    /// Share of blocked cells.
    pub ratio: f64,
    /// Where from and where to.
    pub ends: Ends,
}

/// How blocked cells lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum MapFamily {
    /// Rectangles with sides of one to four cells: the main family, as the papers' figures show.
    Blocky,
    /// Single cells anywhere: the stress family.
    Iid,
    /// U, L and spiral traps.
    Concave,
}

impl MapFamily {
    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Blocky => "blocky",
            Self::Iid => "iid",
            Self::Concave => "concave",
        }
    }
}

/// Where from and where to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ends {
    /// Opposite corners.
    Corners,
    /// Two random cells at least so many cells apart.
    Random(u32),
    /// These two.
    Cells([u32; 2], [u32; 2]),
}

/// A map and what to do on it.
#[derive(Debug, Clone)]
pub struct Maze {
    cells: Vec<MapCell>,
    geometry: GridGeometry,
    /// Where from.
    pub start: Cell,
    /// Where to.
    pub goal: Cell,
    /// The same map for distances. A cell is a metre.
    pub world: World,
}

/// Maps of one kind.
#[derive(Debug, Clone)]
pub struct Mazes {
    /// The maps.
    pub mazes: Vec<Maze>,
    /// Share of the drawn maps that could be crossed under the strictest corner rule.
    pub acceptance: f64,
}

impl MapSpec {
    /// In words.
    #[must_use]
    pub fn name(&self) -> String {
        let ends = match self.ends {
            Ends::Corners => "corners".to_owned(),
            Ends::Random(apart) => format!("pairs {apart} cells apart"),
            Ends::Cells(start, goal) => format!("{start:?} to {goal:?}"),
        };
        let [columns, rows] = self.size;
        let percent = 100.0 * self.ratio;
        format!(
            "{} {columns}x{rows}, {percent:.1} %, {ends}",
            self.family.name()
        )
    }

    /// Draws maps, one for each of `seeds` seeds from `seed` on.
    ///
    /// # Errors
    /// When none of many maps can be crossed.
    pub fn draw(&self, seed: u64, seeds: u64) -> Result<Mazes, GenerateError> {
        let (mut mazes, mut tried) = (Vec::new(), 0_u64);
        for n in 0..seeds {
            let (maze, tries) = self.one(seed + n)?;
            tried += u64::from(tries);
            mazes.push(maze);
        }
        let acceptance = seeds.to_f64() / tried.max(1).to_f64();
        Ok(Mazes { mazes, acceptance })
    }

    fn one(&self, seed: u64) -> Result<(Maze, u32), GenerateError> {
        let [columns, rows] = self.size;
        let (start, goal) = match self.ends {
            Ends::Corners => ([0, 0], [columns - 1, rows - 1]),
            Ends::Cells(start, goal) => (start, goal),
            Ends::Random(apart) => random_pair(self.size, apart, seed),
        };
        let made = generate(&GeneratedSpec {
            family: match self.family {
                MapFamily::Blocky => Family::Blocky { side_cells_max: 4 },
                MapFamily::Iid => Family::Iid,
                MapFamily::Concave => Family::Concave { side_cells_max: 8 },
            },
            size_cells: self.size,
            ratio: self.ratio,
            start_cell: Some(start),
            goal_cell: Some(goal),
            seed,
            resolution_m: 1.0,
        })?;
        Ok((Maze::new(made.map, made.start, made.goal)?, made.tried))
    }
}

fn random_pair([columns, rows]: [u32; 2], apart: u32, seed: u64) -> ([u32; 2], [u32; 2]) {
    use rand::{RngExt as _, SeedableRng as _};
    let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(seed ^ 0x0005_eed5);
    let mut cell = || [rng.random_range(0..columns), rng.random_range(0..rows)];
    loop {
        let (one, other) = (cell(), cell());
        let (dx, dy) = (one[0].abs_diff(other[0]), one[1].abs_diff(other[1]));
        if dx * dx + dy * dy >= apart * apart {
            return (one, other);
        }
    }
}

impl Maze {
    fn new(map: StaticMap, start: Cell, goal: Cell) -> Result<Self, GenerateError> {
        let geometry = map.geometry;
        let blocked = MapCell {
            cost: COST_LETHAL,
            ..MapCell::default()
        };
        let cells = map
            .cells
            .iter()
            .map(|cell| match cell {
                Occupancy::Occupied => blocked,
                _ => MapCell::default(),
            })
            .collect();
        let world = World::new(&WorldSpec::of_map("drawn"), Some(map))?;
        Ok(Self {
            cells,
            geometry,
            start,
            goal,
            world,
        })
    }

    /// The map as planners take it.
    #[must_use]
    pub fn view(&self) -> MapView<'_> {
        MapView {
            geometry: &self.geometry,
            cells: &self.cells,
        }
    }

    /// Columns and rows.
    #[must_use]
    pub fn size(&self) -> (i32, i32) {
        self.geometry.size()
    }

    /// True for cells that are not blocked and on the map.
    #[must_use]
    pub fn is_free(&self, cell: Cell) -> bool {
        self.view()
            .get(cell)
            .is_some_and(|cell| !cell.blocks_centre())
    }

    /// True when the same cells are blocked.
    #[must_use]
    pub fn is_same_map(&self, other: &Self) -> bool {
        self.cells == other.cells
    }

    /// The cell at a point; `None` off the map. [cells]
    #[must_use]
    pub fn cell_at(&self, at: Point2<f64>) -> Option<Cell> {
        self.geometry.cell_at(at)
    }

    /// Centre of a cell as a pose.
    #[must_use]
    pub fn pose(&self, cell: Cell) -> Pose {
        let at = self.geometry.centre_of(cell);
        Pose::new(at.x, at.y, 0.0)
    }

    /// The same map with one more cell blocked, searched from another start.
    ///
    /// # Errors
    /// Never for a cell of the map.
    pub fn with_block(&self, block: Cell, start: Cell) -> Result<Self, GenerateError> {
        let mut map = StaticMap::free(self.geometry);
        for (cell, of) in map.cells.iter_mut().zip(&self.cells) {
            if of.blocks_centre() {
                *cell = Occupancy::Occupied;
            }
        }
        if let Some(index) = self.geometry.index_of(block) {
            map.cells[index] = Occupancy::Occupied;
        }
        Self::new(map, start, self.goal)
    }

    /// Index of a cell as [BAO] counts them (eq. 1): from 1, column by column, y downwards.
    #[must_use]
    pub fn bao_index(&self, cell: Cell) -> i32 {
        let (_, rows) = self.size();
        cell.x * rows + (rows - cell.y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPEC: MapSpec = MapSpec {
        family: MapFamily::Blocky,
        size: [30, 20],
        ratio: 0.158,
        ends: Ends::Corners,
    };

    #[test]
    fn c_gen_maps_have_their_share_and_are_the_same_for_the_same_seed() {
        let one = SPEC.draw(7, 5).unwrap();
        let other = SPEC.draw(7, 5).unwrap();
        assert!((0.3..=1.0).contains(&one.acceptance), "{}", one.acceptance);
        for (a, b) in one.mazes.iter().zip(&other.mazes) {
            assert_eq!(a.cells, b.cells);
            let blocked = a.cells.iter().filter(|cell| cell.blocks_centre()).count();
            assert_eq!(blocked, 95, "15.8 % of 600");
            assert!(a.is_free(a.start) && a.is_free(a.goal));
        }
        assert_ne!(one.mazes[0].cells, one.mazes[1].cells);
    }

    #[test]
    fn c_gen_pairs_are_as_far_apart_as_asked_for() {
        let spec = MapSpec {
            ends: Ends::Random(14),
            size: [20, 20],
            ..SPEC
        };
        for maze in spec.draw(1, 20).unwrap().mazes {
            let apart =
                f64::from(maze.start.x - maze.goal.x).hypot(f64::from(maze.start.y - maze.goal.y));
            assert!(apart >= 14.0, "{apart}");
        }
    }

    #[test]
    fn c_grid_bao_counts_cells_column_by_column_from_the_top() {
        for size in [[30, 20], [50, 40], [7, 4]] {
            let spec = MapSpec {
                size,
                ratio: 0.0,
                ..SPEC
            };
            let maze = spec.draw(1, 1).unwrap().mazes.remove(0);
            let (columns, rows) = maze.size();
            assert_eq!(maze.bao_index(Cell::new(0, rows - 1)), 1, "upper left");
            assert_eq!(maze.bao_index(Cell::new(columns - 1, 0)), columns * rows);
            assert_eq!(maze.bao_index(Cell::new(0, 0)), rows, "lower left");
            assert_eq!(maze.bao_index(Cell::new(1, rows - 1)), rows + 1);
            for x in 0..columns {
                for y in 0..rows {
                    let index = maze.bao_index(Cell::new(x, y));
                    // Eq. 1: x = ceil(i / n_y), y = (i - 1) mod n_y + 1.
                    assert_eq!((index - 1) / rows + 1, x + 1);
                    assert_eq!((index - 1) % rows + 1, rows - y);
                }
            }
        }
    }
}
