//! `robot/scan`: one turn of the lidar.

use crate::message;
use crate::message::{Refusal, ZeroCopySend, ensure, number};
use nalgebra::Vector2;
use zeronav_casts::Cast;

/// Most beams of a scan.
pub const BEAMS_MAX: usize = 4096;

message! {
    /// Fixed fields of a scan. The slice holds one range per beam: [m] in the `laser` frame,
    /// +inf = no return within `range_max_m`, NaN = invalid. Beam `i` points to
    /// `angle_min_rad + i * angle_increment_rad`. The header's capture is that of the last beam.
    pub struct Scan = "zeronav.Scan.v1" {
        /// [number] Which sensor, from 0.
        pub sensor: u32,
        /// [count] Number of beams, equal to the length of the slice.
        pub n_beams: u32,
        /// [rad] direction of beam 0.
        pub angle_min_rad: f32,
        /// [rad] step from beam to beam, not 0, positive = counter-clockwise.
        pub angle_increment_rad: f32,
        /// [s] time from beam to beam, 0 = all at once.
        pub time_increment_s: f32,
        /// [m] closest valid range.
        pub range_m_min: f32,
        /// [m] farthest valid range.
        pub range_m_max: f32,
        /// Written as 0.
        pub spare: u32,
    }
}

impl Scan {
    /// Direction of beam `beam_index` in the `laser` frame. [rad]
    #[must_use]
    pub fn angle_of(&self, beam_index: usize) -> f64 {
        f64::from(self.angle_min_rad) + beam_index.to_f64() * f64::from(self.angle_increment_rad)
    }

    /// True when `range_m` is a hit: finite and between the sensor's limits.
    #[must_use]
    pub fn is_hit(&self, range_m: f32) -> bool {
        range_m >= self.range_m_min && range_m <= self.range_m_max
    }

    /// Accepts scans whose numbers describe `ranges`. Ranges may be anything but negative.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn check(&self, ranges: &[f32]) -> Result<(), Refusal> {
        ensure(
            ranges.len() == self.n_beams as usize && ranges.len() <= BEAMS_MAX,
            Refusal::Length("beams"),
        )?;
        number(f64::from(self.angle_min_rad), -12.6, 12.6, "angle_min_rad")?;
        number(
            f64::from(self.angle_increment_rad),
            -1.6,
            1.6,
            "angle_increment_rad",
        )?;
        ensure(
            self.angle_increment_rad.abs() > 1.0e-6,
            Refusal::OutOfRange("angle_increment_rad"),
        )?;
        number(
            f64::from(self.time_increment_s),
            0.0,
            1.0,
            "time_increment_s",
        )?;
        number(f64::from(self.range_m_min), 0.0, 1.0e3, "range_m_min")?;
        number(
            f64::from(self.range_m_max),
            f64::from(self.range_m_min),
            1.0e3,
            "range_m_max",
        )?;
        ensure(
            !ranges.iter().any(|range| *range < 0.0),
            Refusal::OutOfRange("ranges"),
        )
    }
}

/// Directions of a lidar's beams, which do not change from scan to scan: sines and cosines are the dearest part of a small
/// scan.
#[derive(Debug, Clone, Default)]
pub struct BeamDirections {
    /// Number of beams, first angle and increment.
    of: (u32, u32, u32),
    directions: Vec<Vector2<f64>>,
}

impl BeamDirections {
    /// Room for any scan, so that none needs memory.
    #[must_use]
    pub fn with_capacity() -> Self {
        Self {
            directions: Vec::with_capacity(BEAMS_MAX),
            ..Self::default()
        }
    }

    /// Of the beams of a scan, [`BEAMS_MAX`] at most: in the `laser` frame, of length 1.
    pub fn of(&mut self, scan: &Scan) -> &[Vector2<f64>] {
        let of = (
            scan.n_beams,
            scan.angle_min_rad.to_bits(),
            scan.angle_increment_rad.to_bits(),
        );
        if self.of != of {
            self.of = of;
            self.directions.clear();
            let n_beams = (scan.n_beams as usize).min(BEAMS_MAX);
            self.directions.extend((0..n_beams).map(|beam| {
                let (sin, cos) = scan.angle_of(beam).sin_cos();
                Vector2::new(cos, sin)
            }));
        }
        &self.directions
    }
}
