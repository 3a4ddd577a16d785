//! Where scans have really ended on the surfaces of the map, finer than its cells.
//!
//! Cells that are obstacles lie behind what a noisy lidar sees: hits before a wall are cleared by the
//! beams that go on, those behind it stay. A scan laid on such cells is drawn towards every wall, the next
//! cells are marked from there, and an unknown map leads the robot away. The mean of all hits has no such
//! bias, and their scatter tells which way the surface runs and how well it is known (normal distributions
//! transform: Biber, Strasser, "The Normal Distributions Transform", 2003, around each point instead of on a
//! raster).

use nalgebra::{Matrix2, Point2, Vector2};
use zeronav_casts::Cast;
use zeronav_msgs::{Cell, GridGeometry};

/// Side of the blocks that are allocated. [cells]
const BLOCK: usize = 8;

/// Most hits that a cell remembers: the first ones, whose poses have drifted least.
const HITS_MAX: f32 = 40.0;

/// How far around a point its surface is looked for, and where that tells no direction: this far, and in cells
/// at most. [m]
const AROUND: [(f64, i32); 2] = [(0.15, 8), (0.3, 12)];

/// Largest standard error of a line's direction. [rad]
const TILT_RAD: f64 = 0.03;

/// Fewest hits that make a surface.
const HITS_MIN: f64 = 6.0;

/// How many times as far hits must scatter along a line as across it, squared.
const LINE_RATIO: f64 = 3.0;

/// Least standard deviation of hits along a line. Near the end of a wall the few hits around scatter farther across
/// it than along it; a line at right angles would come out. [m]
const ALONG_M: f64 = 0.07;

/// A point lies on a line up to this many standard deviations of its hits from their mean, along it.
const BESIDE: f64 = 2.0;

/// Standard deviation of a line where hits do not scatter. [m]
const SIGMA_M: f64 = 0.02;

/// Hits in a cell.
#[derive(Debug, Clone, Copy, Default)]
struct Hits {
    n: f32,
    /// Sums of their offsets from the cell's lower corner. [cells]
    x: f32,
    y: f32,
    /// Sum of the unit vectors to where they were seen from.
    eye: [f32; 2],
}

/// Where a beam ended [cells], and the unit vector to where it came from.
pub(crate) type BeamEnd = (Point2<f64>, Vector2<f64>);

/// What is known of a surface near a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Surface {
    /// Mean of the hits. [m]
    pub(crate) mean: Point2<f64>,
    /// Unit vector across it, and the variance of the hits that way. [m^2]
    pub(crate) across: (Vector2<f64>, f64),
    /// The same along it, of something small that stands alone.
    pub(crate) along: Option<(Vector2<f64>, f64)>,
}

impl Surface {
    /// The directions in which it tells a distance, with the variance.
    pub(crate) fn axes(&self) -> impl Iterator<Item = (Vector2<f64>, f64)> {
        core::iter::once(self.across).chain(self.along)
    }
}

/// What the hits around a point say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum HitsMean {
    /// Nothing: they are few.
    Nothing,
    /// They lie on no line.
    Unclear,
    /// The surface that they lie on.
    Surface(Surface),
}

/// Hits around a point.
#[derive(Debug, Default)]
struct Scatter {
    n: f64,
    /// Sums of places and their products, off the lower corner of the cell in the middle. [cells]
    sum: Vector2<f64>,
    squares: Matrix2<f64>,
    /// Sum of the unit vectors to where they were seen from.
    eye: Vector2<f64>,
    /// Some are in the outermost cells.
    on_edge: bool,
}

impl Scatter {
    fn add(&mut self, hits: &Hits, corner: Vector2<f64>, is_edge: bool) {
        let n = f64::from(hits.n);
        let at = corner + Vector2::new(f64::from(hits.x), f64::from(hits.y)) / n;
        self.n += n;
        self.sum += at * n;
        self.squares += at * at.transpose() * n;
        self.eye += Vector2::from(hits.eye.map(f64::from));
        self.on_edge |= is_edge;
    }
}

/// The hits of all scans. Memory follows the surfaces that were seen.
#[derive(Debug)]
pub(crate) struct HitMeans {
    geometry: GridGeometry,
    /// Blocks along a row.
    columns: usize,
    /// Number of every block, [`NO_BLOCK`] where nothing was seen.
    blocks: Vec<u32>,
    hits: Vec<[Hits; BLOCK * BLOCK]>,
    /// How far around a point its surface is looked for. [cells]
    around: [i32; 2],
}

/// Hits that an obstacle without any is taken for.
const OF_A_CELL: f32 = 3.0;

/// Blocks that memory is set aside for.
const BLOCKS_AT_FIRST: usize = 1024;

/// Nothing was seen.
const NO_BLOCK: u32 = u32::MAX;

impl HitMeans {
    /// Nothing has been seen of a map.
    pub(crate) fn new(geometry: &GridGeometry) -> Self {
        let columns = (geometry.width as usize).div_ceil(BLOCK);
        let rows = (geometry.height as usize).div_ceil(BLOCK);
        Self {
            geometry: *geometry,
            columns,
            blocks: vec![NO_BLOCK; columns * rows],
            hits: Vec::with_capacity((columns * rows).min(BLOCKS_AT_FIRST)),
            around: AROUND.map(|(around_m, cells_max)| {
                let cells = (around_m / geometry.resolution_m)
                    .round()
                    .min(99.0)
                    .to_i32();
                cells.clamp(2, cells_max)
            }),
        }
    }

    /// Takes in where a beam ended, in cells from the lower corner of the map.
    pub(crate) fn add(&mut self, (at, eye): &BeamEnd) {
        let (column, row) = (at.x.floor(), at.y.floor());
        let cell = Cell::new(column.to_i32(), row.to_i32());
        let Some(hits) = self.hits_mut(cell) else {
            return;
        };
        if hits.n < HITS_MAX {
            let [x, y, eye_x, eye_y] = [at.x - column, at.y - row, eye.x, eye.y].map(Cast::to_f32);
            hits.n += 1.0;
            hits.x += x;
            hits.y += y;
            hits.eye[0] += eye_x;
            hits.eye[1] += eye_y;
        }
    }

    /// Takes in that an obstacle is in a cell, of which nobody knows any more where scans ended: it counts as a few
    /// hits at its centre, besides those that come.
    pub(crate) fn add_cell(&mut self, cell: Cell) {
        if let Some(hits) = self.hits_mut(cell).filter(|hits| hits.n == 0.0) {
            hits.n = OF_A_CELL;
            hits.x = 0.5 * OF_A_CELL;
            hits.y = 0.5 * OF_A_CELL;
        }
    }

    /// Copies all hits to a map whose origin lies `shift` cells from this one's.
    pub(crate) fn copy_to(&self, other: &mut Self, shift: Cell) {
        let number = |n: usize| i32::try_from(n).unwrap_or(i32::MAX);
        for (block, first) in self.blocks.iter().enumerate() {
            let Some(hits) = self.hits.get(*first as usize) else {
                continue;
            };
            let corner = (block % self.columns * BLOCK, block / self.columns * BLOCK);
            for (place, hits) in hits.iter().enumerate().filter(|(_, hits)| hits.n > 0.0) {
                let (x, y) = (corner.0 + place % BLOCK, corner.1 + place / BLOCK);
                let cell = Cell::new(
                    number(x).saturating_sub(shift.x),
                    number(y).saturating_sub(shift.y),
                );
                if let Some(there) = other.hits_mut(cell) {
                    *there = *hits;
                }
            }
        }
    }

    /// Forgets all hits.
    pub(crate) fn clear(&mut self) {
        self.blocks.fill(NO_BLOCK);
        self.hits.clear();
    }

    /// Forgets the hits in a cell.
    pub(crate) fn forget(&mut self, cell: Cell) {
        if let Some((block, place)) = self.place_of(cell)
            && let Some(hits) = self.hits.get_mut(self.blocks[block] as usize)
        {
            hits[place] = Hits::default();
        }
    }

    /// The surface near a point of the map [m] that is seen from the direction `eye`: a wall has another
    /// one behind.
    pub(crate) fn near(&self, at: Point2<f64>, eye: Vector2<f64>) -> HitsMean {
        for around in self.around {
            let seen = self.within(around, at, eye);
            if seen != HitsMean::Unclear {
                return seen;
            }
        }
        HitsMean::Unclear
    }

    /// The same by the hits that are so many cells around.
    fn within(&self, around: i32, at: Point2<f64>, eye: Vector2<f64>) -> HitsMean {
        let middle = self.geometry.unbounded_cell_at(at);
        let mut facing = Scatter::default();
        let mut all = Scatter::default();
        for dy in -around..=around {
            for dx in -around..=around {
                let cell = Cell::new(middle.x.saturating_add(dx), middle.y.saturating_add(dy));
                let Some(hits) = self.hits_in(cell) else {
                    continue;
                };
                let is_edge = dx.abs() == around || dy.abs() == around;
                let corner = Vector2::new(f64::from(dx), f64::from(dy));
                all.add(hits, corner, is_edge);
                let from = Vector2::from(hits.eye.map(f64::from));
                if from.dot(&eye) > 0.0 {
                    facing.add(hits, corner, is_edge);
                }
            }
        }
        let is_alone = !all.on_edge && around == self.around[0];
        // Along a wall one looks now from here, now from there.
        let scatter = if facing.n < HITS_MIN { all } else { facing };
        if scatter.n < HITS_MIN {
            return HitsMean::Nothing;
        }
        let cell_m = self.geometry.resolution_m;
        let mean = scatter.sum / scatter.n;
        let spread = scatter.squares / scatter.n - mean * mean.transpose();
        let mean = Point2::new(
            self.geometry.origin_x_m + (f64::from(middle.x) + mean.x) * cell_m,
            self.geometry.origin_y_m + (f64::from(middle.y) + mean.y) * cell_m,
        );
        let eigen = (spread * (cell_m * cell_m)).symmetric_eigen();
        let (across, along) = if eigen.eigenvalues[0] < eigen.eigenvalues[1] {
            (0, 1)
        } else {
            (1, 0)
        };
        let axis = |axis: usize| {
            let variance = eigen.eigenvalues[axis].max(0.0) + SIGMA_M * SIGMA_M;
            (eigen.eigenvectors.column(axis).into_owned(), variance)
        };
        let (across, along) = (axis(across), axis(along));
        let is_behind = across.0.dot(&scatter.eye) * across.0.dot(&eye) < 0.0;
        let tilt = (across.1 - SIGMA_M * SIGMA_M) / ((along.1 - across.1).max(1.0e-9) * scatter.n);
        let is_line = along.1 >= (LINE_RATIO * across.1).max(ALONG_M * ALONG_M)
            && tilt <= TILT_RAD.powi(2)
            && (at - mean).dot(&along.0).powi(2) <= BESIDE.powi(2) * along.1;
        if is_behind || !(is_alone || is_line) {
            return HitsMean::Unclear;
        }
        HitsMean::Surface(Surface {
            mean,
            across,
            along: is_alone.then_some(along),
        })
    }

    /// The hits in a cell, whose block is allocated; `None` beside the map.
    fn hits_mut(&mut self, cell: Cell) -> Option<&mut Hits> {
        let (block, place) = self.place_of(cell)?;
        if self.blocks[block] == NO_BLOCK {
            self.blocks[block] = u32::try_from(self.hits.len()).ok()?;
            self.hits.push([Hits::default(); BLOCK * BLOCK]);
        }
        Some(&mut self.hits[self.blocks[block] as usize][place])
    }

    fn hits_in(&self, cell: Cell) -> Option<&Hits> {
        let (block, place) = self.place_of(cell)?;
        let hits = &self.hits.get(self.blocks[block] as usize)?[place];
        (hits.n > 0.0).then_some(hits)
    }

    /// The block of a cell, and its place there.
    fn place_of(&self, cell: Cell) -> Option<(usize, usize)> {
        let (width, height) = self.geometry.size();
        if !(0..width).contains(&cell.x) || !(0..height).contains(&cell.y) {
            return None;
        }
        let (x, y) = (cell.x.to_usize(), cell.y.to_usize());
        let block = y / BLOCK * self.columns + x / BLOCK;
        Some((block, y % BLOCK * BLOCK + x % BLOCK))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn empty() -> HitMeans {
        with_cells(0.05)
    }

    /// 5 m x 4.5 m.
    fn with_cells(resolution_m: f64) -> HitMeans {
        let cells = |size_m: f64| (size_m / resolution_m).round().to_u32();
        HitMeans::new(&GridGeometry {
            origin_x_m: -1.0,
            origin_y_m: -2.0,
            resolution_m,
            width: cells(5.0),
            height: cells(4.5),
        })
    }

    /// Hits at places of the map [m], seen from `eye`.
    fn add(means: &mut HitMeans, places: impl Iterator<Item = (f64, f64)>, eye: Vector2<f64>) {
        for (x, y) in places {
            let cell_m = means.geometry.resolution_m;
            let at = Point2::new((x + 1.0) / cell_m, (y + 2.0) / cell_m);
            means.add(&(at, eye));
        }
    }

    /// Along y = 0.11 from x = 0 to 2, 3 cm before and behind it in turn.
    fn wall() -> impl Iterator<Item = (f64, f64)> {
        (0..400_u32).map(|n| {
            let off_m = if n.is_multiple_of(2) { 0.03 } else { -0.03 };
            (0.005 * f64::from(n), 0.11 + off_m)
        })
    }

    fn surface(seen: HitsMean) -> Surface {
        match seen {
            HitsMean::Surface(surface) => surface,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn the_middle_of_noisy_hits_is_where_the_wall_is() {
        for cell_m in [0.02, 0.03, 0.05] {
            finds_the_middle(with_cells(cell_m));
        }
    }

    fn finds_the_middle(mut means: HitMeans) {
        let front = Vector2::new(0.0, -1.0);
        add(&mut means, wall(), front);
        for y in [0.05, 0.11, 0.17] {
            let found = surface(means.near(Point2::new(1.0, y), front));
            assert!((found.mean.y - 0.11).abs() < 2.0e-3, "{found:?}");
            assert!(found.across.0.y.abs() > 0.999, "{found:?}");
            let sigma_m = found.across.1.sqrt();
            assert!((sigma_m - 0.036).abs() < 1.0e-3, "{found:?}");
            assert_eq!(found.along, None, "a wall tells nothing along itself");
        }
        // Looked along from both ends it is the same side.
        let along = Vector2::new(0.99, -0.14);
        assert!(matches!(
            means.near(Point2::new(1.0, 0.11), along),
            HitsMean::Surface(_)
        ));
    }

    #[test]
    fn from_behind_and_beyond_its_end_a_wall_tells_nothing() {
        let mut means = empty();
        let front = Vector2::new(0.0, -1.0);
        add(&mut means, wall(), front);
        assert_eq!(means.near(Point2::new(1.0, 0.2), -front), HitsMean::Unclear);
        let beyond = means.near(Point2::new(2.12, 0.11), front);
        assert!(!matches!(beyond, HitsMean::Surface(_)), "{beyond:?}");
        assert_eq!(means.near(Point2::new(3.0, 0.11), front), HitsMean::Nothing);
        let outside = means.near(Point2::new(-9.0, 1.0e9), front);
        assert_eq!(outside, HitsMean::Nothing);
    }

    #[test]
    fn a_post_that_stands_alone_tells_both_directions() {
        let mut means = empty();
        let front = Vector2::new(0.0, -1.0);
        let arc = (0..30_u32).map(|n| {
            let turn_rad = 0.1 * f64::from(n);
            (1.0 + 0.05 * turn_rad.cos(), 0.5 - 0.05 * turn_rad.sin())
        });
        add(&mut means, arc, front);
        let post = surface(means.near(Point2::new(1.02, 0.45), front));
        let (along, variance) = post.along.expect("both directions");
        assert!(along.x.abs() > 0.99 && variance.sqrt() < 0.05, "{post:?}");
    }

    #[test]
    fn obstacles_hold_the_place_until_scans_end_there_again() {
        let mut means = empty();
        let front = Vector2::new(0.0, -1.0);
        for x in 20..60 {
            means.add_cell(Cell::new(x, 42));
        }
        let held = surface(means.near(Point2::new(1.0, 0.15), front));
        assert!((held.mean.y - 0.125).abs() < 1.0e-6, "{held:?}");
        add(&mut means, wall(), front);
        let seen = surface(means.near(Point2::new(1.0, 0.15), front));
        assert!((seen.mean.y - 0.11).abs() < 5.0e-3, "{seen:?}");
    }

    #[test]
    fn what_is_forgotten_or_lies_beside_the_new_map_is_gone() {
        let mut means = empty();
        let front = Vector2::new(0.0, -1.0);
        add(&mut means, wall(), front);
        let mut moved = empty();
        // The new map begins 10 columns further on: the wall lies 0.5 m farther left on it.
        means.copy_to(&mut moved, Cell::new(10, 0));
        let there = surface(moved.near(Point2::new(0.5, 0.11), front));
        let here = surface(means.near(Point2::new(1.0, 0.11), front));
        assert!((there.mean.x + 0.5 - here.mean.x).abs() < 1.0e-6);
        assert_eq!(there.across, here.across);
        for x in 0..100 {
            for y in 0..90 {
                means.forget(Cell::new(x, y));
            }
        }
        assert_eq!(means.near(Point2::new(1.0, 0.11), front), HitsMean::Nothing);
        moved.clear();
        assert_eq!(moved.near(Point2::new(0.5, 0.11), front), HitsMean::Nothing);
    }
}
