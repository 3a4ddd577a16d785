//! Which obstacle it is that the robot does not get past. Nothing is decided by it.

use nalgebra::Point2;
use zeronav_casts::Cast;
use zeronav_msgs::map::{COST_LETHAL, ObstacleSource};
use zeronav_msgs::obstacles::Obstacle;
use zeronav_msgs::path::{Path, PathBlock, PathStatus};
use zeronav_msgs::task::TaskStatus;
use zeronav_msgs::{Cell, MapView, Pose};

/// [m] from a point of the scan within which an obstacle of the map or a track is what it shows.
const SAME_M: f64 = 0.12;

/// The cell because of which a task failed, as `task/status` tells it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Obstruction {
    /// What the cell is.
    pub(crate) block: PathBlock,
    /// Its place, `map` frame. [m]
    pub(crate) at_m: [f64; 2],
    /// Where its obstacle comes from.
    pub(crate) source: ObstacleSource,
}

impl Obstruction {
    /// None is known.
    pub(crate) const NONE: Self = Self {
        block: PathBlock::None,
        at_m: [0.0; 2],
        source: ObstacleSource::None,
    };

    /// What a status tells; [`Self::NONE`] for unknown codes.
    #[must_use]
    pub(crate) fn of(status: &TaskStatus) -> Self {
        let codes = status.block().zip(status.source());
        codes.map_or(Self::NONE, |(block, source)| Self {
            block,
            at_m: status.block_m,
            source,
        })
    }

    /// Why the global planner has no path, if it says so.
    pub(crate) fn told_by(path: &Path) -> Option<Self> {
        let is_failure = !matches!(path.status()?, PathStatus::NoGoal | PathStatus::Found);
        let (block, source) = path.block().zip(path.source())?;
        (is_failure && block != PathBlock::None).then_some(Self {
            block,
            at_m: path.block_m,
            source,
        })
    }
}

/// What is known of obstacles in one period.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Known<'a> {
    /// `map_from_base`.
    pub(crate) map_from_base: Pose,
    /// The map, which holds the static obstacles.
    pub(crate) map: Option<MapView<'a>>,
    /// Tracked obstacles, `map` frame.
    pub(crate) obstacles: &'a [Obstacle],
    /// Hits of the scan, in `base`. [m]
    pub(crate) scan_points_in_base: &'a [Point2<f64>],
}

impl Known<'_> {
    /// The obstacle that is nearest to a place of the map frame, at most `reach_m` away. A hit of the
    /// scan at a tracked obstacle or at one of the map is that obstacle.
    pub(crate) fn nearest(&self, place: Point2<f64>, reach_m: f64) -> Option<Obstruction> {
        let found = [
            self.tracked(place, reach_m),
            self.mapped(place, reach_m),
            self.hit(place, reach_m),
        ];
        // The first of those that are equally near: the one that is best known.
        let nearest = (found.into_iter().flatten()).min_by(|one, other| one.0.total_cmp(&other.0));
        nearest.map(|(_, at, source)| Obstruction {
            block: PathBlock::Obstacle,
            at_m: [at.x, at.y],
            source,
        })
    }

    fn tracked(
        &self,
        place: Point2<f64>,
        reach_m: f64,
    ) -> Option<(f64, Point2<f64>, ObstacleSource)> {
        let away = self.obstacles.iter().map(|obstacle| {
            let centre = Point2::new(obstacle.x_m, obstacle.y_m);
            ((centre - place).norm() - obstacle.radius_m, centre)
        });
        nearest_of(away, reach_m).map(|(away_m, at)| (away_m, at, ObstacleSource::Tracked))
    }

    fn mapped(
        &self,
        place: Point2<f64>,
        reach_m: f64,
    ) -> Option<(f64, Point2<f64>, ObstacleSource)> {
        let map = self.map?;
        let geometry = map.geometry;
        let half_m = geometry.resolution_m / 2.0;
        let (centre, reach) = (geometry.cell_at(place)?, cells(reach_m, half_m));
        let around = (-reach..=reach).flat_map(|y| (-reach..=reach).map(move |x| (x, y)));
        let lethal = around.filter_map(|(x, y)| {
            let cell = Cell::new(centre.x + x, centre.y + y);
            let known = map.get(cell).filter(|known| known.cost == COST_LETHAL)?;
            let at = geometry.centre_of(cell);
            Some(((at - place).norm() - half_m, at, known.source()))
        });
        let near = lethal.filter(|(away_m, ..)| *away_m <= reach_m);
        near.min_by(|one, other| one.0.total_cmp(&other.0))
    }

    fn hit(&self, place: Point2<f64>, reach_m: f64) -> Option<(f64, Point2<f64>, ObstacleSource)> {
        let map_from_base = self.map_from_base.isometry();
        let hits = self.scan_points_in_base.iter().map(|hit| {
            let at = map_from_base * hit;
            ((at - place).norm(), at)
        });
        let (away_m, at) = nearest_of(hits, reach_m)?;
        let known = self.tracked(at, SAME_M).or_else(|| self.mapped(at, SAME_M));
        Some(
            known.map_or((away_m, at, ObstacleSource::Lidar), |(_, known, source)| {
                (away_m, known, source)
            }),
        )
    }
}

/// The nearest of places with their distances, at most `reach_m` away.
fn nearest_of(
    places: impl Iterator<Item = (f64, Point2<f64>)>,
    reach_m: f64,
) -> Option<(f64, Point2<f64>)> {
    let near = places.filter(|(away_m, _)| *away_m <= reach_m);
    near.min_by(|one, other| one.0.total_cmp(&other.0))
}

/// Cells in a distance, rounded up; bounded. [m]
fn cells(reach_m: f64, half_m: f64) -> i32 {
    ((reach_m + half_m) / (2.0 * half_m))
        .ceil()
        .clamp(0.0, 100.0)
        .to_i32()
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::map::{FLAG_SENSED, FLAG_STATIC};
    use zeronav_msgs::{GridGeometry, MapCell};

    #[test]
    fn the_nearest_obstacle_is_named_with_where_it_comes_from() {
        let geometry = GridGeometry {
            resolution_m: 0.1,
            width: 60,
            height: 20,
            ..GridGeometry::default()
        };
        let mut cells = vec![MapCell::unknown(1000); geometry.len()];
        let mut put = |x: i32, flags| {
            let index = geometry.index_of(Cell::new(x, 10)).expect("on the map");
            cells[index] = MapCell {
                cost: COST_LETHAL,
                flags,
                clearance_mm: 0,
            };
        };
        put(10, FLAG_STATIC);
        put(20, FLAG_SENSED);
        let map = MapView {
            geometry: &geometry,
            cells: &cells,
        };
        let tracked = [Obstacle {
            track: 3,
            x_m: 3.05,
            y_m: 1.05,
            radius_m: 0.2,
            ..Obstacle::default()
        }];
        // On the tracked obstacle, on the wall, and on something of its own.
        let hits = [[0.9, 0.0], [-0.95, 0.0], [2.0, 0.0]].map(|[x, y]| Point2::new(x, y));
        let known = Known {
            map_from_base: Pose::new(2.0, 1.05, 0.0),
            map: Some(map),
            obstacles: &tracked,
            scan_points_in_base: &hits,
        };
        let near = |x_m| {
            let found = known.nearest(Point2::new(x_m, 1.05), 0.6);
            found.map(|found| (found.source, (found.at_m[0] * 100.0).round() / 100.0))
        };
        assert_eq!(near(1.3), Some((ObstacleSource::StaticMap, 1.05)));
        assert_eq!(near(1.8), Some((ObstacleSource::Lidar, 2.05)));
        assert_eq!(near(2.6), Some((ObstacleSource::Tracked, 3.05)));
        assert_eq!(near(4.1), Some((ObstacleSource::Lidar, 4.0)));
        assert_eq!(near(5.5), None);
        assert_eq!(near(f64::NAN), None);
    }
}
