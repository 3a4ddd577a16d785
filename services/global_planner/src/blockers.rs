//! What closes a cell to the robot's centre: the static map by itself, which stays as it is, or only
//! what the lidar saw or tracks besides it, which may go.

use crate::plan::Blocked;
use zeronav_casts::Cast;
use zeronav_msgs::map::{COST_INSCRIBED, COST_LETHAL, COST_UNKNOWN, ObstacleSource};
use zeronav_msgs::{Cell, MapView};

/// Farthest that obstacles are looked for. [cells]
const REACH_CELLS_MAX: i32 = 64;

/// The obstacles of one map.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Blockers<'a> {
    map: MapView<'a>,
    /// Largest clearance of a cell that is closed all the same. [mm]
    least_mm: u16,
    /// Cells from a closed one within which the obstacles are that may close it.
    reach: i32,
}

impl<'a> Blockers<'a> {
    /// Reads from the map how far its obstacles reach.
    pub(crate) fn of(map: MapView<'a>) -> Self {
        let closed = map.cells.iter().filter(|it| it.cost == COST_INSCRIBED);
        let least_mm = closed.map(|it| it.clearance_mm).max().unwrap_or(0);
        let reach = f64::from(least_mm) / 1000.0 / map.geometry.resolution_m + 1.0;
        Self {
            map,
            least_mm,
            reach: reach.min(f64::from(REACH_CELLS_MAX)).to_i32(),
        }
    }

    /// Where the obstacle comes from that closes `cell`: the static map when one of its obstacles does so
    /// whatever else is there, else the nearest of the others.
    pub(crate) fn source_at(&self, cell: Cell) -> ObstacleSource {
        let Some(own) = self.map.get(cell) else {
            return ObstacleSource::None;
        };
        if own.cost == COST_UNKNOWN {
            return own.source();
        }
        let mut nearest = (i32::MAX, own.source());
        for y in -self.reach..=self.reach {
            for x in -self.reach..=self.reach {
                let at = Cell::new(cell.x.saturating_add(x), cell.y.saturating_add(y));
                let Some(obstacle) = self.map.get(at).filter(|at| at.cost == COST_LETHAL) else {
                    continue;
                };
                if !self.closes(x, y) {
                    continue;
                }
                if obstacle.source() == ObstacleSource::StaticMap {
                    return ObstacleSource::StaticMap;
                }
                let away = x * x + y * y;
                if away < nearest.0 {
                    nearest = (away, obstacle.source());
                }
            }
        }
        nearest.1
    }

    /// True when an obstacle that is so many cells away closes a cell: clearance is to its edge.
    fn closes(&self, x: i32, y: i32) -> bool {
        let to_edge = |cells: i32| (f64::from(cells.abs()) - 0.5).max(0.0);
        let away_m = to_edge(x).hypot(to_edge(y)) * self.map.geometry.resolution_m;
        (1000.0 * away_m).floor() <= f64::from(self.least_mm)
    }

    /// A cell as a path names it.
    pub(crate) fn blocked(&self, cell: Cell) -> Blocked {
        let centre = self.map.geometry.centre_of(cell);
        Blocked {
            at_m: [centre.x, centre.y],
            source: self.source_at(cell),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::map::{FLAG_SENSED, FLAG_STATIC};
    use zeronav_msgs::{GridGeometry, MapCell};

    #[test]
    fn the_static_map_closes_what_it_would_close_alone_and_others_the_rest() {
        use ObstacleSource::{Lidar, None, StaticMap, Tracked};
        let geometry = GridGeometry {
            resolution_m: 0.05,
            width: 9,
            height: 1,
            ..GridGeometry::default()
        };
        let near = |clearance_mm, cost| MapCell {
            cost,
            flags: 0,
            clearance_mm,
        };
        let obstacle = |flags| MapCell {
            cost: COST_LETHAL,
            flags,
            clearance_mm: 0,
        };
        // Closed up to 75 mm: two cells beside an obstacle.
        let mut cells = [
            obstacle(FLAG_STATIC),
            near(25, COST_INSCRIBED),
            near(25, COST_INSCRIBED),
            obstacle(FLAG_SENSED),
            near(25, COST_INSCRIBED),
            near(75, COST_INSCRIBED),
            near(75, COST_INSCRIBED),
            near(25, COST_INSCRIBED),
            // Stamped on a reader's copy.
            obstacle(0),
        ];
        let sources = |cells: &[MapCell]| {
            let map = MapView {
                geometry: &geometry,
                cells,
            };
            let blockers = Blockers::of(map);
            [-1, 0, 1, 2, 3, 4, 5, 6, 7, 8].map(|x| blockers.source_at(Cell::new(x, 0)))
        };
        assert_eq!(
            sources(&cells),
            [
                None, StaticMap, StaticMap, StaticMap, Lidar, Lidar, Lidar, Tracked, Tracked,
                Tracked
            ]
        );
        // The next cell of a wall that was seen a cell beside it.
        cells[1] = obstacle(FLAG_SENSED);
        assert_eq!(sources(&cells)[2], StaticMap);
    }
}
