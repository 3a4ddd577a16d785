//! A flat world of square obstacles and a lidar in it, for tests and benches.

#![allow(dead_code, reason = "every test and bench uses its own part")]

use zeronav_casts::Cast;
use zeronav_mapping::{Mapping, MappingConfig, Observation};
use zeronav_msgs::description::Description;
use zeronav_msgs::scan::Scan;
use zeronav_msgs::{Cell, GridGeometry, Pose};
use zeronav_world::{Occupancy, StaticMap};

/// Obstacles as cells of a grid, so that what should be marked is known exactly.
#[derive(Debug, Clone)]
pub(crate) struct Room {
    pub(crate) geometry: GridGeometry,
    pub(crate) solid: Vec<bool>,
    pub(crate) n_beams: u32,
    pub(crate) range_m_max: f32,
}

impl Room {
    /// Nothing in it; 5 cm cells, origin off zero.
    pub(crate) fn empty(width: u32, height: u32) -> Self {
        let geometry = GridGeometry {
            origin_x_m: -3.0,
            origin_y_m: 1.25,
            resolution_m: 0.05,
            width,
            height,
        };
        Self {
            solid: vec![false; geometry.len()],
            geometry,
            n_beams: 720,
            range_m_max: 12.0,
        }
    }

    /// Walls of `thickness` cells along the edges.
    pub(crate) fn walled(width: u32, height: u32, thickness: i32) -> Self {
        let mut room = Self::empty(width, height);
        let (w, h) = room.geometry.size();
        room.fill(0, 0, w, thickness, true);
        room.fill(0, h - thickness, w, h, true);
        room.fill(0, 0, thickness, h, true);
        room.fill(w - thickness, 0, w, h, true);
        room
    }

    /// Fills the cells `x0 <= x < x1`, `y0 <= y < y1`.
    pub(crate) fn fill(&mut self, x0: i32, y0: i32, x1: i32, y1: i32, solid: bool) {
        for y in y0..y1 {
            for x in x0..x1 {
                if let Some(index) = self.geometry.index_of(Cell::new(x, y)) {
                    self.solid[index] = solid;
                }
            }
        }
    }

    /// The static map of the obstacles that are here now.
    pub(crate) fn as_static_map(&self) -> StaticMap {
        let occupancy = |solid: &bool| {
            if *solid {
                Occupancy::Occupied
            } else {
                Occupancy::Free
            }
        };
        StaticMap {
            geometry: self.geometry,
            cells: self.solid.iter().map(occupancy).collect(),
        }
    }

    /// Pose at a point given in cells; (0.5, 0.5) is the centre of the first.
    pub(crate) fn pose(&self, x_cells: f64, y_cells: f64, yaw_rad: f64) -> Pose {
        let g = &self.geometry;
        Pose::new(
            g.origin_x_m + x_cells * g.resolution_m,
            g.origin_y_m + y_cells * g.resolution_m,
            yaw_rad,
        )
    }

    /// A turn of the lidar.
    pub(crate) fn scan(&self, map_from_laser: &Pose) -> (Scan, Vec<f32>) {
        let scan = Scan {
            n_beams: self.n_beams,
            angle_min_rad: -std::f32::consts::PI,
            angle_increment_rad: std::f32::consts::TAU / self.n_beams.to_f32(),
            range_m_min: 0.1,
            range_m_max: self.range_m_max,
            ..Scan::default()
        };
        let ranges = (0..self.n_beams as usize)
            .map(|n| self.range_m(map_from_laser, map_from_laser.yaw_rad + scan.angle_of(n)))
            .collect();
        (scan, ranges)
    }

    /// Distance to the first solid cell, border by border.
    pub(crate) fn range_m(&self, from: &Pose, angle_rad: f64) -> f32 {
        let g = &self.geometry;
        let (dy, dx) = angle_rad.sin_cos();
        let at = |t: f64| {
            (
                (from.x_m - g.origin_x_m) / g.resolution_m + t * dx,
                (from.y_m - g.origin_y_m) / g.resolution_m + t * dy,
            )
        };
        let mut t = 0.0;
        while t * g.resolution_m <= f64::from(self.range_m_max) {
            let (x, y) = at(t + 1.0e-7);
            let cell = Cell::new(x.floor().to_i32(), y.floor().to_i32());
            if g.index_of(cell).is_some_and(|index| self.solid[index]) {
                return (t * g.resolution_m).to_f32();
            }
            let to_border = |at: f64, direction: f64| {
                if direction > 0.0 {
                    (at.floor() + 1.0 - at) / direction
                } else {
                    (at.floor() - at) / direction
                }
            };
            t += 1.0e-7 + to_border(x, dx).min(to_border(y, dy));
        }
        f32::INFINITY
    }
}

/// The `n`th scan of ten a second, all beams of which were taken at once where odometry says `odom_from_base`, of the
/// variances that it says.
pub(crate) fn observed<'a>(
    (scan, ranges): (&'a Scan, &'a [f32]),
    n: u64,
    odom_from_base: Pose,
    odometry_variance: [f64; 3],
) -> Observation<'a> {
    Observation {
        scan,
        ranges,
        run_ns: n * 100_000_000,
        odom_from_base_first: odom_from_base,
        odom_from_base,
        odometry_variance,
        goal: None,
        told: None,
    }
}

/// Takes in a scan and checks it, what it costs. [ms]
pub(crate) fn take_in_ms(mapping: &mut Mapping, seen: &Observation<'_>) -> f64 {
    let begun_ms = on_processor_ms();
    mapping.take_in(seen);
    mapping.check();
    on_processor_ms() - begun_ms
}

/// A robot of 0.2 m.
pub(crate) fn description() -> Description {
    Description {
        inscribed_radius_m: 0.2,
        circumscribed_radius_m: 0.2,
        ..Description::default()
    }
}

/// The defaults, for the area of `room`.
pub(crate) fn config(room: &Room) -> MappingConfig {
    let g = &room.geometry;
    let along = |origin_m: f64, cells: u32| origin_m + f64::from(cells) * g.resolution_m;
    MappingConfig {
        area_m: Some([
            [g.origin_x_m, g.origin_y_m],
            [along(g.origin_x_m, g.width), along(g.origin_y_m, g.height)],
        ]),
        resolution_m: g.resolution_m,
        ..MappingConfig::default()
    }
}

/// `SplitMix64`.
#[derive(Debug, Clone)]
pub(crate) struct Rng(pub(crate) u64);

impl Rng {
    pub(crate) fn draw(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// 0 to `n - 1`.
    pub(crate) fn below(&mut self, n: i32) -> i32 {
        i32::try_from(self.draw() % u64::from(n.max(1).unsigned_abs())).unwrap_or(0)
    }

    /// About normal, standard deviation 1: twelve uniform numbers less six.
    pub(crate) fn normal(&mut self) -> f64 {
        (0..12)
            .map(|_| f64::from(self.below(1_000_000)) / 1.0e6)
            .sum::<f64>()
            - 6.0
    }
}

/// Time that this thread has had a processor: others do not count. [ms]
pub(crate) fn on_processor_ms() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let ns = text
        .split_whitespace()
        .next()
        .and_then(|word| word.parse::<f64>().ok());
    1.0e-6 * ns.unwrap_or_default()
}
