//! A walled square of cells of one metre, some of them blocked: what all scenes stand in.

use zeronav_msgs::Cell;
use zeronav_world::generate::{GenerateError, generate};
use zeronav_world::spec::{Family, GeneratedSpec};
use zeronav_world::static_map::Occupancy;

/// Which map a scene stands in.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plan {
    /// How blocked cells lie.
    pub family: Family,
    /// Cells along each side; a cell is a metre.
    pub side: u32,
    /// Share of blocked cells.
    pub ratio: f64,
    /// Where the robot starts.
    pub start: [u32; 2],
    /// Where it is to go.
    pub goal: [u32; 2],
    /// Seed of the map.
    pub seed: u64,
    /// Run time that the robot has. [s]
    pub limit_s: f64,
}

/// Run time of the scenes. With 120 s the rate of arrival measured the clock: of 36 drives of [ZM] 29 had arrived
/// by then and 34 by this. [s]
pub const LIMIT_S: f64 = 300.0;

/// A map that can be crossed without cutting corners.
#[derive(Debug, Clone)]
pub(super) struct Blocks {
    plan: Plan,
    side: i32,
    occupied: Vec<bool>,
}

impl Blocks {
    /// Draws the map.
    ///
    /// # Errors
    /// When none of many maps can be crossed.
    pub(super) fn new(plan: Plan) -> Result<Self, GenerateError> {
        let map = generate(&GeneratedSpec {
            family: plan.family,
            size_cells: [plan.side; 2],
            ratio: plan.ratio,
            start_cell: Some(plan.start),
            goal_cell: Some(plan.goal),
            seed: plan.seed,
            resolution_m: 1.0,
        })?
        .map;
        let is_occupied = |cell: &Occupancy| *cell == Occupancy::Occupied;
        Ok(Self {
            plan,
            side: i32::try_from(plan.side).unwrap_or(i32::MAX),
            occupied: map.cells.iter().map(is_occupied).collect(),
        })
    }

    /// Every cell, row by row.
    pub(super) fn cells(&self) -> impl Iterator<Item = Cell> + use<> {
        let side = self.side;
        (0..side * side).map(move |index| Cell::new(index % side, index / side))
    }

    /// True for a cell of the map that is not blocked.
    pub(super) fn is_free(&self, cell: Cell) -> bool {
        let inside = (0..self.side).contains(&cell.x) && (0..self.side).contains(&cell.y);
        let index = usize::try_from(cell.y * self.side + cell.x).unwrap_or(usize::MAX);
        inside && !self.occupied[index]
    }

    /// Distance of a point [m] from the nearest blocked cell or wall. [m]
    pub(super) fn clearance_m(&self, [x, y]: [f64; 2]) -> f64 {
        let side_m = f64::from(self.side);
        let mut least_m = x.min(y).min(side_m - x).min(side_m - y);
        for cell in self.cells().filter(|cell| !self.is_free(*cell)) {
            let (left, low) = (f64::from(cell.x), f64::from(cell.y));
            let dx = (left - x).max(x - left - 1.0).max(0.0);
            let dy = (low - y).max(y - low - 1.0).max(0.0);
            least_m = least_m.min(dx.hypot(dy));
        }
        least_m
    }

    /// Centres of start and goal. [m]
    pub(super) fn ends_m(&self) -> [[f64; 2]; 2] {
        [self.plan.start, self.plan.goal].map(|cell| cell.map(|at| f64::from(at) + 0.5))
    }

    /// The scenario without its obstacles: a porter, whose map shows every block.
    pub(super) fn text(&self, title: &str, radius_m: f64, range_m: Option<f64>) -> String {
        let side_m = f64::from(self.side);
        let [[sx, sy], [gx, gy]] = self.ends_m();
        let yaw_rad = (gy - sy).atan2(gx - sx);
        let range = range_m.map_or_else(String::new, |range_m| {
            format!("lidar = {{ range_m_max = {range_m:?} }}\n")
        });
        let mut text = format!(
            "title = \"{title}\"\nbase = [\"porter\"]\nstart = [{sx}, {sy}, {yaw_rad:.4}]\n\
             [[goals]]\npose = [{gx}, {gy}, 0.0]\n\
             [run]\ntime_limit_s = {limit_s:?}\n[restart]\nhang_after_s = 10.0\n\
             [expect]\noutcome = \"reached\"\ncontacts_max = 0\n\
             [robot]\nradius_m = {radius_m:?}\n{range}\
             [world]\narea_m = [[-0.2, -0.2], [{end_m:?}, {end_m:?}]]\nresolution_m = 0.05\nshapes = [\n",
            end_m = side_m + 0.2,
            limit_s = self.plan.limit_s,
        );
        let mut put = |centre: [f64; 2], size: [f64; 2]| {
            let line = format!("{{ kind = \"box\", centre_m = {centre:?}, size_m = {size:?} }},");
            text.push_str(&line);
        };
        let (middle_m, wall_m) = (0.5 * side_m, 0.1);
        put([middle_m, -wall_m], [side_m + 0.4, 0.2]);
        put([middle_m, side_m + wall_m], [side_m + 0.4, 0.2]);
        put([-wall_m, middle_m], [0.2, side_m]);
        put([side_m + wall_m, middle_m], [0.2, side_m]);
        for cell in self.cells().filter(|cell| !self.is_free(*cell)) {
            put(middle(cell), [1.0, 1.0]);
        }
        text + "\n]\n"
    }
}

/// Centre of a cell. [m]
pub(super) fn middle(cell: Cell) -> [f64; 2] {
    [f64::from(cell.x) + 0.5, f64::from(cell.y) + 0.5]
}
