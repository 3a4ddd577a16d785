//! Where beams ended that the lidar does not measure any more.
//!
//! A robot that does not see all around turns away from a wall, and then knows no more of it than the
//! cells of the map, which may be larger than what is in them by most of their side. The hits of the
//! last scan that measured a place tell where in its cells the surface is. They count as long as the map
//! says that something is there: what has left, or never stood, is cleared there.

use nalgebra::{Point2, Vector2};
use zeronav_casts::Cast;
use zeronav_msgs::map::FLAG_UNKNOWN;
use zeronav_msgs::time::seconds;
use zeronav_msgs::{MapView, Pose};

/// Side of a bin. [m]
const BIN_M: f64 = 0.05;

/// Bins along a side, 3.2 m. Places that are farther apart share a bin: the newer one has it.
const BINS: i32 = 64;

/// Distance along either axis within which hits are taken in and given back. [m]
const REACH_M: f64 = 1.5;

/// Most hits of a bin, and how far apart they are at least. [m]
const HITS_MAX: usize = 8;
const APART_M: f64 = 0.005;

/// How long a hit may count. [s] Poses drift against the map that they were taken in.
const KEPT_S: f64 = 30.0;

/// Distance along its beam within which a hit measures an obstacle cell. [m] A cell's side, and noise.
pub(crate) const ALONG_M: f64 = 0.05;

/// Where a beam ended. [m]
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Hit {
    /// The place.
    pub at: Point2<f64>,
    /// Unit vector along the beam.
    pub along: Vector2<f64>,
}

impl Hit {
    /// The hit of a beam from the lidar to a place.
    pub(crate) fn of(lidar: Point2<f64>, at: Point2<f64>) -> Self {
        let beam = at - lidar;
        let along = beam / beam.norm().max(1.0e-6);
        Self { at, along }
    }

    /// The same in the parent frame of a pose.
    #[must_use]
    pub fn in_parent(self, pose: &Pose) -> Self {
        let isometry = pose.isometry();
        Self {
            at: isometry * self.at,
            along: isometry * self.along,
        }
    }
}

/// A square of the map that holds hits of one scan.
#[derive(Debug, Clone, Copy, Default)]
struct Bin {
    /// Index of the square along x and y.
    square: (i32, i32),
    /// Run time of the period that took it in. [ns]
    run_ns: u64,
    n: usize,
}

/// See the module's description. Nothing is allocated after the first scan.
#[derive(Debug, Clone, Default)]
pub(crate) struct PastHits {
    bins: Vec<Bin>,
    /// Hits of each bin, map frame. Apart from the bins, all of which are looked at in every period.
    hits: Vec<[Hit; HITS_MAX]>,
    in_base: Vec<Hit>,
}

impl PastHits {
    /// Takes in the hits of a period, in `base`, at this run time [ns]; those of periods before it that the
    /// map still has as obstacles, in `base` and within [`REACH_M`].
    pub(crate) fn after(
        &mut self,
        map: MapView<'_>,
        (map_from_base, run_ns): (&Pose, u64),
        (points_in_base, lidar): (&[Point2<f64>], Point2<f64>),
    ) -> &[Hit] {
        let n_bins = (BINS * BINS) as usize;
        self.bins.resize(n_bins, Bin::default());
        self.hits.resize(n_bins, [Hit::default(); HITS_MAX]);
        for point in points_in_base {
            if is_remembered(point) {
                self.take(Hit::of(lidar, *point).in_parent(map_from_base), run_ns);
            }
        }
        let base_from_map = Pose::from(map_from_base.isometry().inverse());
        self.in_base.clear();
        for (bin, hits) in self.bins.iter_mut().zip(&self.hits) {
            if bin.n == 0 || bin.run_ns == run_ns {
                continue;
            }
            if seconds(run_ns.saturating_sub(bin.run_ns)) > KEPT_S {
                bin.n = 0;
            }
            for hit in &hits[..bin.n] {
                let in_base = hit.in_parent(&base_from_map);
                if is_remembered(&in_base.at) && is_obstacle(map, hit) {
                    self.in_base.push(in_base);
                }
            }
        }
        &self.in_base
    }

    /// Takes in a hit, map frame. A square has those of one period.
    fn take(&mut self, hit: Hit, run_ns: u64) {
        let index = |m: f64| (m / BIN_M).floor().to_i32();
        let square = (index(hit.at.x), index(hit.at.y));
        let (column, row) = (square.0.rem_euclid(BINS), square.1.rem_euclid(BINS));
        let slot = (row * BINS + column).to_usize();
        let (bin, hits) = (&mut self.bins[slot], &mut self.hits[slot]);
        if bin.square != square || bin.run_ns != run_ns {
            *bin = Bin {
                square,
                run_ns,
                n: 0,
            };
        }
        let is_new = |before: &Hit| (before.at - hit.at).norm() >= APART_M;
        if bin.n < HITS_MAX && hits[..bin.n].iter().all(is_new) {
            hits[bin.n] = hit;
            bin.n += 1;
        }
    }
}

/// True for a place in `base` that is remembered while the lidar measures nothing there.
pub(crate) fn is_remembered(in_base: &Point2<f64>) -> bool {
    in_base.x.abs() < REACH_M && in_base.y.abs() < REACH_M
}

/// True when a cell that the hit measures is an obstacle on the map. The hit is in the map frame.
fn is_obstacle(map: MapView<'_>, hit: &Hit) -> bool {
    [0.0, ALONG_M, -ALONG_M].iter().any(|along_m| {
        let at = hit.at + hit.along * *along_m;
        let cell = map.geometry.index_of(map.geometry.unbounded_cell_at(at));
        cell.is_some_and(|index| {
            let cell = map.cells[index];
            cell.clearance_mm == 0 && cell.flags & FLAG_UNKNOWN == 0
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::{GridGeometry, MapCell};

    const SIDE: u32 = 80;
    const LIDAR: Point2<f64> = Point2::new(0.1, 0.0);

    const GEOMETRY: GridGeometry = GridGeometry {
        origin_x_m: 0.0,
        origin_y_m: 0.0,
        resolution_m: 0.05,
        width: SIDE,
        height: SIDE,
    };

    /// Free but for the column of cells from x = 2.5 m to 2.55 m.
    fn cells(is_there: bool) -> Vec<MapCell> {
        let cell = |index: u32| MapCell {
            clearance_mm: if is_there && index % SIDE == 50 {
                0
            } else {
                500
            },
            ..MapCell::default()
        };
        (0..SIDE * SIDE).map(cell).collect()
    }

    fn map(cells: &[MapCell]) -> MapView<'_> {
        MapView {
            geometry: &GEOMETRY,
            cells,
        }
    }

    /// A wall at x = 2.54 m as a robot at (2, 2) sees it that faces it.
    fn wall() -> Vec<Point2<f64>> {
        (-20..20)
            .map(|n| Point2::new(0.54, 0.01 * f64::from(n)))
            .collect()
    }

    #[test]
    fn a_wall_that_the_robot_has_turned_away_from_stays_where_it_was_measured() {
        let (cells, mut past) = (cells(true), PastHits::default());
        let here = Pose::new(2.0, 2.0, 0.0);
        assert_eq!(
            past.after(map(&cells), (&here, 1), (&wall(), LIDAR)),
            [],
            "it is measured"
        );
        let away = Pose::new(2.0, 2.1, core::f64::consts::PI);
        let hits = past.after(map(&cells), (&away, 2), (&[], LIDAR));
        assert!((32..=40).contains(&hits.len()), "{}", hits.len());
        for hit in hits {
            assert!((hit.at.x + 0.54).abs() < 1e-9, "{hit:?}");
            assert!((hit.at.y - 0.1).abs() <= 0.2 + 1e-9, "{hit:?}");
            assert!(
                hit.along.x < -0.9 && (hit.along.norm() - 1.0).abs() < 1e-9,
                "{hit:?}"
            );
        }
        // Measured again it is not of the past.
        let turned: Vec<_> = wall()
            .iter()
            .map(|at| Point2::new(at.x - 0.01, at.y))
            .collect();
        assert_eq!(past.after(map(&cells), (&here, 3), (&turned, LIDAR)), []);
        let hits = past.after(map(&cells), (&here, 4), (&[], LIDAR));
        assert!(
            hits.iter().all(|hit| (hit.at.x - 0.53).abs() < 1e-9),
            "{hits:?}"
        );
    }

    #[test]
    fn what_the_map_has_cleared_or_was_seen_long_ago_or_is_far_does_not_count() {
        let (there, gone, mut past) = (cells(true), cells(false), PastHits::default());
        let here = Pose::new(2.0, 2.0, 0.0);
        past.after(map(&there), (&here, 1), (&wall(), LIDAR));
        assert_eq!(past.after(map(&gone), (&here, 2), (&[], LIDAR)), []);
        let far = Pose::new(0.9, 2.0, 0.0);
        assert_eq!(past.after(map(&there), (&far, 3), (&[], LIDAR)), []);
        let later_ns = 31_000_000_000;
        assert_eq!(past.after(map(&there), (&here, later_ns), (&[], LIDAR)), []);
        // Forgotten, not only too old.
        assert_eq!(past.after(map(&there), (&here, 4), (&[], LIDAR)), []);
    }
}
