//! What a user may set.

use crate::clearance::CLEARANCE_CELLS_MAX;
use crate::error::{MappingError, ensure};
use crate::localiser::CorrectionConfig;
use crate::log_odds::LogOdds;
use crate::regularise::RegularisationConfig;
use crate::tracker::TrackingConfig;
use crate::virtual_obstacles::VirtualConfig;
use crate::window::WindowConfig;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use zeronav_msgs::GridGeometry;

/// Configuration of mapping.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MappingConfig {
    /// ROS `map_server` YAML of the static map. It brings its own area and resolution.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub static_map: Option<PathBuf>,
    /// Lower left corner `[x, y]` and upper right corner `[x, y]` of the map. [m] Required without
    /// a static map, ignored with one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub area_m: Option<[[f64; 2]; 2]>,
    /// [m] side of a cell of a map without a static one.
    pub resolution_m: f64,
    /// [m] beyond which clearance is not told apart; at most 90 cells, at least the inflation
    /// radius.
    pub clearance_limit_m: f64,
    /// [m] by which cells must be clearer than the inscribed radius to be of use: what the local
    /// planner keeps around the outline. Without it paths lead into gaps that no controller enters.
    pub padding_m: f64,
    /// [m] from an obstacle up to which cells have a cost.
    pub inflation_radius_m: f64,
    /// [1/m] how fast cost falls beyond the inscribed radius: `252 exp(-factor (clearance -
    /// inscribed))`, as in Nav2.
    pub cost_scaling_factor: f64,
    /// What scans do to the belief in a cell.
    pub log_odds: LogOdds,
    /// [m] up to which a scan marks obstacles.
    pub obstacle_range_m: f64,
    /// [m] up to which a scan clears; at least the obstacle range, so that whatever was marked
    /// can be cleared from where it was seen.
    pub raytrace_range_m: f64,
    /// Whether the cells under the robot are free.
    pub footprint_clearing: bool,
    /// [s] that a cell stays an obstacle after something that moves was last seen in it, unless a
    /// beam passes through it before.
    pub moving_age_s: f64,
    /// What is taken for a moving obstacle.
    pub tracking: TrackingConfig,
    /// How `map_from_odom` is kept right.
    pub pose_correction: CorrectionConfig,
    /// Obstacle groups on the way that become rectangles.
    pub regularisation: RegularisationConfig,
    /// Free cells that are not to be used.
    pub virtual_obstacles: VirtualConfig,
    /// What happens at the edge of the map.
    pub window: WindowConfig,
    /// Folder into which the map is written as `map.yaml` and `map.pgm` when the process ends; it
    /// must exist.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub save_to: Option<PathBuf>,
}

impl Default for MappingConfig {
    fn default() -> Self {
        Self {
            static_map: None,
            area_m: None,
            resolution_m: 0.05,
            clearance_limit_m: 1.0,
            padding_m: 0.02,
            inflation_radius_m: 0.6,
            cost_scaling_factor: 4.0,
            log_odds: LogOdds::default(),
            obstacle_range_m: 12.0,
            raytrace_range_m: 12.5,
            footprint_clearing: true,
            moving_age_s: 0.3,
            tracking: TrackingConfig::default(),
            pose_correction: CorrectionConfig::default(),
            regularisation: RegularisationConfig::default(),
            virtual_obstacles: VirtualConfig::default(),
            window: WindowConfig::default(),
            save_to: None,
        }
    }
}

impl MappingConfig {
    /// Accepts numbers that make sense together with cells of `resolution_m`.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self, resolution_m: f64) -> Result<(), MappingError> {
        let limit_m = self.clearance_limit_m;
        // Comparisons are written so that NaN fails them.
        ensure(
            limit_m >= resolution_m
                && limit_m <= CLEARANCE_CELLS_MAX * resolution_m
                && limit_m <= f64::from(u16::MAX) / 1000.0,
            "clearance_limit_m",
            limit_m,
            "must be 1 to 90 cells and at most 65.535 m",
        )?;
        ensure(
            (0.0..=1.0).contains(&self.padding_m),
            "padding_m",
            self.padding_m,
            "must be 0 to 1 m",
        )?;
        ensure(
            self.inflation_radius_m >= 0.0 && self.inflation_radius_m <= limit_m,
            "inflation_radius_m",
            self.inflation_radius_m,
            "must be 0 to clearance_limit_m",
        )?;
        ensure(
            self.cost_scaling_factor >= 0.0 && self.cost_scaling_factor <= 1.0e3,
            "cost_scaling_factor",
            self.cost_scaling_factor,
            "must be 0 to 1000",
        )?;
        ensure(
            self.obstacle_range_m > 0.0 && self.obstacle_range_m <= 1.0e3,
            "obstacle_range_m",
            self.obstacle_range_m,
            "must be above 0 and at most 1000 m",
        )?;
        ensure(
            self.raytrace_range_m >= self.obstacle_range_m && self.raytrace_range_m <= 1.0e3,
            "raytrace_range_m",
            self.raytrace_range_m,
            "must be obstacle_range_m to 1000 m",
        )?;
        ensure(
            (0.0..=10.0).contains(&self.moving_age_s),
            "moving_age_s",
            self.moving_age_s,
            "must be 0 to 10 s",
        )?;
        self.tracking.check()?;
        self.pose_correction.check()?;
        self.regularisation.check()?;
        self.virtual_obstacles.check()?;
        self.window.check()?;
        self.log_odds.check()
    }

    /// The grid of a map without a static one.
    ///
    /// # Errors
    /// [`MappingError::NoArea`], [`MappingError::Geometry`].
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "float to int saturates, and the check refuses what is too large"
    )]
    pub fn geometry(&self) -> Result<GridGeometry, MappingError> {
        let [[x0, y0], [x1, y1]] = self.area_m.ok_or(MappingError::NoArea)?;
        // A sliver of a millionth of a cell makes no cell.
        let cells = |length_m: f64| (length_m / self.resolution_m - 1.0e-6).ceil() as u32;
        let geometry = GridGeometry {
            origin_x_m: x0,
            origin_y_m: y0,
            resolution_m: self.resolution_m,
            width: cells(x1 - x0),
            height: cells(y1 - y0),
        };
        geometry.check().map_err(MappingError::Geometry)?;
        Ok(geometry)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The field that is complained about, empty when all is well.
    fn check(change: impl FnOnce(&mut MappingConfig)) -> &'static str {
        let mut config = MappingConfig::default();
        change(&mut config);
        match config.check(0.05) {
            Ok(()) => "",
            Err(MappingError::OutOfRange { field, .. }) => field,
            Err(error) => panic!("{error}"),
        }
    }

    #[test]
    fn wrong_numbers_are_named() {
        assert_eq!(check(|_| ()), "");
        assert_eq!(check(|c| c.clearance_limit_m = 4.6), "clearance_limit_m");
        assert_eq!(
            check(|c| c.clearance_limit_m = f64::NAN),
            "clearance_limit_m"
        );
        assert_eq!(check(|c| c.inflation_radius_m = 1.1), "inflation_radius_m");
        assert_eq!(
            check(|c| c.cost_scaling_factor = -1.0),
            "cost_scaling_factor"
        );
        assert_eq!(check(|c| c.obstacle_range_m = 0.0), "obstacle_range_m");
        assert_eq!(check(|c| c.raytrace_range_m = 11.0), "raytrace_range_m");
        assert_eq!(check(|c| c.log_odds.hit = 0), "log_odds.hit");
        assert_eq!(check(|c| c.log_odds.miss = 0), "log_odds.miss");
        assert_eq!(check(|c| c.log_odds.min = -200), "log_odds.min");
        assert_eq!(check(|c| c.log_odds.max = 0), "log_odds.max");
    }

    #[test]
    fn an_area_makes_a_grid() {
        let mut config = MappingConfig {
            area_m: Some([[-1.0, 2.0], [0.5, 2.3]]),
            resolution_m: 0.1,
            ..MappingConfig::default()
        };
        let geometry = config.geometry().unwrap();
        assert_eq!((geometry.width, geometry.height), (15, 3));
        config.area_m = Some([[0.0, 0.0], [-1.0, 1.0]]);
        assert!(matches!(config.geometry(), Err(MappingError::Geometry(_))));
        config.area_m = Some([[0.0, 0.0], [f64::INFINITY, 1.0]]);
        assert!(matches!(config.geometry(), Err(MappingError::Geometry(_))));
        config.area_m = None;
        assert_eq!(config.geometry(), Err(MappingError::NoArea));
    }
}
