//! Cost-to-go over the map around the robot, seeded from the path.
//!
//! Every cell of a window knows how far it is to the path's end by the shortest free way to the
//! path and along it (Dijkstra from all of the path's points in the window at once), so a motion
//! into a dead end is worth nothing however near it brings the robot to the path. Recomputed only
//! when the path changed, when cells of the window changed what they cost, or when the robot has
//! come near the window's edge.
//!
//! No step costs less than 1000, so cells within 1000 of each other cannot improve one another: the
//! queue is a ring of buckets that wide (Denardo and Fox 1979, "Shortest-Route Methods: 1"), each
//! emptied in any order, and the costs are those of a heap.

use crate::progress::{PathTracker, Place};
use nalgebra::Point2;
use zeronav_casts::Cast;
use zeronav_msgs::MapView;
use zeronav_msgs::path::Waypoint;

/// [m] smallest side of a cell; finer maps are taken in blocks.
const CELL_M: f64 = 0.1;

/// By how much the window reaches farther than what must be known.
const REACH_SHARE: f64 = 1.35;

/// Most cells on a side.
const SIDE_MAX: i32 = 160;

/// Steps to neighbours and their lengths in thousandths of a cell.
const STEPS: [(i32, i32, u32); 8] = [
    (1, 0, 1000),
    (0, 1, 1000),
    (-1, 0, 1000),
    (0, -1, 1000),
    (1, 1, 1414),
    (-1, 1, 1414),
    (-1, -1, 1414),
    (1, -1, 1414),
];

/// Cost of the cheapest step, and width of a bucket.
const BUCKET: u32 = 1000;

/// Buckets of the ring: more than the dearest step (1414 at three times the cost) spans.
const BUCKETS: usize = 8;

/// [m] between seeds along the path.
const SEED_M: f64 = 0.05;

/// Cost of a cell that leads nowhere.
const UNREACHED: u32 = u32::MAX;

/// What the window was made from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Key {
    geometry: u64,
    cells: u64,
    /// Rows and columns of cells around the robot.
    half: i32,
}

/// The window.
#[derive(Debug, Clone, Default)]
pub(crate) struct CostToGo {
    key: Option<Key>,
    cell_m: f64,
    /// Map frame, centre of cell (0, 0). [m]
    origin: Point2<f64>,
    side: i32,
    /// Where the robot was, in cells.
    made_at: (i32, i32),
    /// [m] to the path's end, infinite where no way leads there.
    to_go: Vec<f32>,
    costs: Vec<u32>,
    /// Cost factor in 256ths, 0 = not free.
    factors: Vec<u16>,
    /// The factors that the costs were made with.
    spread_factors: Vec<u16>,
    /// Costs and cells of the path's points, the dearest first.
    seeds: Vec<(u32, u32)>,
    /// Cells to be looked at, by their cost in buckets, modulo the ring.
    ring: [Vec<(u32, u32)>; BUCKETS],
}

/// What the window is made from.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CostToGoInputs<'a> {
    pub(crate) map: MapView<'a>,
    /// Grows when cells of the map change.
    pub(crate) map_cells: u64,
    pub(crate) path: &'a [Waypoint],
    pub(crate) geometry: u64,
    pub(crate) place: Place,
    pub(crate) position: Point2<f64>,
    /// [m] around the robot that must be known.
    pub(crate) reach_m: f64,
    /// [m] nearer than which obstacles block the robot's centre.
    pub(crate) inscribed_m: f64,
    /// [m] from obstacles below which a way costs more.
    pub(crate) soft_m: f64,
}

impl CostToGo {
    /// Rebuilds the window when it has to be; true when it was.
    pub(crate) fn update(&mut self, tracker: &PathTracker, inputs: &CostToGoInputs<'_>) -> bool {
        let geometry = inputs.map.geometry;
        let stride = (CELL_M / geometry.resolution_m).ceil().max(1.0);
        let cell_m = stride * geometry.resolution_m;
        let half =
            ((REACH_SHARE * inputs.reach_m / cell_m).ceil().to_i32() + 2).min(SIDE_MAX / 2 - 1);
        let key = Key {
            geometry: inputs.geometry,
            cells: inputs.map_cells,
            half,
        };
        let at = inputs.position;
        let stride = stride.to_i32();
        let cell = geometry.unbounded_cell_at(at);
        let block = (cell.x.div_euclid(stride), cell.y.div_euclid(stride));
        let drifted = (block.0 - self.made_at.0)
            .abs()
            .max((block.1 - self.made_at.1).abs());
        let inner = (inputs.reach_m / cell_m).ceil().to_i32();
        let near = drifted <= (half - inner).max(2);
        if self.key == Some(key) && near {
            return false;
        }
        // Other cells, perhaps none that matter here: then the window stays where it is.
        let same_path = self.key.map(|key| (key.geometry, key.half)) == Some((key.geometry, half));
        let stays = same_path && near;
        self.key = Some(key);
        if !stays {
            self.made_at = block;
        }
        let first = (self.made_at.0 - half, self.made_at.1 - half);
        let origin = Point2::new(
            geometry.origin_x_m + (f64::from(first.0) + 0.5) * cell_m,
            geometry.origin_y_m + (f64::from(first.1) + 0.5) * cell_m,
        );
        let stays = stays && origin == self.origin;
        self.cell_m = cell_m;
        self.side = 2 * half + 1;
        self.origin = origin;
        self.weigh(inputs, first, stride);
        if stays && self.factors == self.spread_factors {
            return false;
        }
        self.spread_factors.clone_from(&self.factors);
        self.seed(tracker, inputs);
        self.spread();
        true
    }

    /// Cost factors of all cells: a block is as free as its freest cell.
    fn weigh(&mut self, inputs: &CostToGoInputs<'_>, first: (i32, i32), stride: i32) {
        let side = self.side.to_usize();
        let soft_m = inputs.inscribed_m + inputs.soft_m;
        let (width, height) = inputs.map.geometry.size();
        // Freest cell of every block, first; beside the map nothing is free.
        self.factors.clear();
        self.factors.resize(side * side, 0);
        let from_x = (first.0 * stride).max(0);
        let to_x = ((first.0 + self.side) * stride).min(width);
        for (row, freest) in self.factors.chunks_exact_mut(side).enumerate() {
            let top = (first.1 + row.to_i32()) * stride;
            for y in top.max(0)..(top + stride).min(height) {
                if from_x >= to_x {
                    break;
                }
                let start = y.to_usize() * width.to_usize();
                let cells = start + from_x.to_usize()..start + to_x.to_usize();
                let Some(cells) = inputs.map.cells.get(cells) else {
                    continue;
                };
                let mut block = (from_x - first.0 * stride) / stride;
                let mut left = stride - (from_x - first.0 * stride) % stride;
                for cell in cells {
                    let freest = &mut freest[block.to_usize()];
                    *freest = (*freest).max(cell.clearance_mm);
                    left -= 1;
                    if left == 0 {
                        (block, left) = (block + 1, stride);
                    }
                }
            }
        }
        for factor in &mut self.factors {
            let clearance_m = f64::from(*factor) * 1.0e-3;
            let near = ((soft_m - clearance_m) / inputs.soft_m).clamp(0.0, 1.0);
            *factor = if clearance_m < inputs.inscribed_m {
                0
            } else {
                256 + (512.0 * near * near).to_u16()
            };
        }
    }

    /// Index of the cell that holds a point of the map frame.
    fn index_of(&self, at: Point2<f64>) -> Option<usize> {
        let column = ((at.x - self.origin.x) / self.cell_m).round().to_i32();
        let row = ((at.y - self.origin.y) / self.cell_m).round().to_i32();
        let inside = column >= 0 && row >= 0 && column < self.side && row < self.side;
        inside.then(|| (row * self.side + column).to_usize())
    }

    /// Gathers the path's points in the window.
    fn seed(&mut self, tracker: &PathTracker, inputs: &CostToGoInputs<'_>) {
        let n = self.factors.len();
        self.costs.clear();
        self.costs.resize(n, UNREACHED);
        self.seeds.clear();
        let length_m = tracker.length_m();
        let around_m = f64::from(self.side) * self.cell_m;
        let mut arc_m = (inputs.place.arc_m - 1.0).max(0.0);
        let until_m = (inputs.place.arc_m + 2.0 * around_m).min(length_m);
        loop {
            let at = tracker.point_at(inputs.path, arc_m);
            if let Some(index) = self.index_of(at)
                && self.factors[index] > 0
            {
                let cost = ((length_m - arc_m) / self.cell_m * 1000.0)
                    .min(4.0e9)
                    .to_u32();
                if cost < self.costs[index] {
                    self.costs[index] = cost;
                    self.seeds.push((cost, index.to_u32()));
                }
            }
            if arc_m >= until_m {
                break;
            }
            arc_m = (arc_m + SEED_M).min(until_m);
        }
    }

    /// Shortest ways from all seeds.
    fn spread(&mut self) {
        for bucket in &mut self.ring {
            bucket.reserve(self.factors.len());
        }
        let mut bucket = self.seeds.last().map_or(0, |(cost, _)| cost / BUCKET);
        let mut waiting = 0;
        loop {
            // Along the path costs only fall, so the cheapest seeds are the last ones.
            while let Some(&(cost, index)) = self.seeds.last()
                && cost / BUCKET <= bucket
            {
                self.seeds.pop();
                self.ring[cost as usize / BUCKET as usize % BUCKETS].push((cost, index));
                waiting += 1;
            }
            if waiting == 0 {
                match self.seeds.last() {
                    Some((cost, _)) => bucket = cost / BUCKET,
                    None => break,
                }
                continue;
            }
            while let Some((cost, index)) = self.ring[bucket as usize % BUCKETS].pop() {
                waiting -= 1;
                self.relax(&mut waiting, cost, index as usize);
            }
            bucket += 1;
        }
        self.to_go.clear();
        let thousandth_m = (self.cell_m * 1.0e-3).to_f32();
        self.to_go.extend(self.costs.iter().map(|cost| match *cost {
            UNREACHED => f32::INFINITY,
            cost => cost.to_f32() * thousandth_m,
        }));
    }

    /// Offers the neighbours of a cell the way through it.
    fn relax(&mut self, waiting: &mut usize, cost: u32, index: usize) {
        if cost > self.costs[index] {
            return;
        }
        let (column, row) = (index.to_i32() % self.side, index.to_i32() / self.side);
        for (dx, dy, length) in STEPS {
            let (x, y) = (column + dx, row + dy);
            if x < 0 || y < 0 || x >= self.side || y >= self.side {
                continue;
            }
            let next = (y * self.side + x).to_usize();
            let factor = u32::from(self.factors[next]);
            if factor == 0 {
                continue;
            }
            let through = cost.saturating_add(length * factor / 256);
            if through < self.costs[next] {
                self.costs[next] = through;
                self.ring[(through / BUCKET) as usize % BUCKETS].push((through, next.to_u32()));
                *waiting += 1;
            }
        }
    }

    /// The way to go from a point of the map frame, bilinear where all four neighbours know it;
    /// `None` where no free way is known. [m]
    pub(crate) fn at(&self, point: Point2<f64>) -> Option<f32> {
        let u = ((point.x - self.origin.x) / self.cell_m).to_f32();
        let v = ((point.y - self.origin.y) / self.cell_m).to_f32();
        let last = (self.side - 1).to_f32();
        if !(u >= 0.0 && v >= 0.0 && u < last && v < last) {
            return None;
        }
        let (column, row) = (u.to_usize(), v.to_usize());
        let (fu, fv) = (u - column.to_f32(), v - row.to_f32());
        let side = self.side.to_usize();
        let start = row * side + column;
        let quad = [start, start + 1, start + side, start + side + 1].map(|i| self.to_go[i]);
        let low = quad[0] + (quad[1] - quad[0]) * fu;
        let high = quad[2] + (quad[3] - quad[2]) * fu;
        let mean = low + (high - low) * fv;
        if mean.is_finite() {
            return Some(mean);
        }
        // Beside an obstacle: the nearest neighbour that knows a way.
        let least = quad.into_iter().fold(f32::INFINITY, f32::min);
        least.is_finite().then_some(least)
    }
}

#[cfg(test)]
mod tests;
