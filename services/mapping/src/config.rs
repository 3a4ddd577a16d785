//! What a user may set.

use crate::clearance::CLEARANCE_CELLS_MAX;
use crate::error::MappingError;
use crate::localisation::LocalisationConfig;
use crate::localiser::CorrectionConfig;
use crate::log_odds::LogOdds;
use crate::regularise::RegularisationConfig;
use crate::tracker::TrackingConfig;
use crate::virtual_obstacles::VirtualConfig;
use crate::window::WindowConfig;
use std::path::PathBuf;
use zeronav_casts::Cast;
use zeronav_msgs::GridGeometry;
use zeronav_msgs::grid::RESOLUTION_M;
use zeronav_msgs::message::COORDINATE_M_MAX;
use zeronav_params::{ParameterError, parameters};

/// Largest clearance that a cell of the map can hold. [m]
const CLEARANCE_M_MAX: f64 = 65.535;

parameters! {
    /// Configuration of mapping.
    pub struct MappingConfig {
        /// ROS `map_server` YAML of the static map. It brings its own area and resolution.
        #[serde(skip_serializing_if = "Option::is_none")]
        static_map: Option<PathBuf> = None;
        /// Lower left corner `[x, y]` and upper right corner `[x, y]` of the map. Required without
        /// a static map, ignored with one.
        #[serde(skip_serializing_if = "Option::is_none")]
        area_m: Option<[[f64; 2]; 2]> = None, [-COORDINATE_M_MAX, COORDINATE_M_MAX] "m";
        /// Side of a cell of a map without a static one.
        resolution_m: f64 = 0.05, [RESOLUTION_M[0], RESOLUTION_M[1]] "m";
        /// Clearance beyond which distances are not distinguished; 1 to 90 cells.
        clearance_limit_m: f64 = 1.0, [f64::MIN_POSITIVE, CLEARANCE_M_MAX] "m";
        /// How much larger than the inscribed radius a cell's clearance must be for the planners to
        /// use it: what the local planner keeps around the outline. Without it paths lead into gaps
        /// that no controller enters.
        padding_m: f64 = 0.02, [0.0, 1.0] "m";
        /// Distance from an obstacle up to which cells have a cost.
        inflation_radius_m: f64 = 0.6, [0.0, CLEARANCE_M_MAX] "m";
        /// How fast cost falls beyond the inscribed radius: `252 exp(-factor (clearance -
        /// inscribed))`, as in Nav2.
        cost_scaling_factor: f64 = 4.0, [0.0, 1.0e3] "1/m";
        /// How scans change the belief in a cell.
        log_odds: LogOdds;
        /// Range up to which a scan marks obstacles.
        obstacle_range_m: f64 = 12.0, [f64::MIN_POSITIVE, 1.0e3] "m";
        /// Range up to which a scan clears; at least the obstacle range, so that everything that
        /// was marked can be cleared from where it was seen.
        raytrace_range_m: f64 = 12.5, [f64::MIN_POSITIVE, 1.0e3] "m";
        /// Whether the cells under the robot are free.
        footprint_clearing: bool = true;
        /// What is taken for a moving obstacle.
        tracking: TrackingConfig;
        /// How `map_from_odom` is corrected.
        pose_correction: CorrectionConfig;
        /// Where the robot begins, and when it counts as lost.
        localisation: LocalisationConfig;
        /// Obstacle groups on the way that become rectangles.
        regularisation: RegularisationConfig;
        /// Free cells that are not to be used.
        virtual_obstacles: VirtualConfig;
        /// What happens at the edge of the map.
        window: WindowConfig;
        /// Folder into which the map is written as `map.yaml` and `map.pgm` when the process ends;
        /// it must exist.
        #[serde(skip_serializing_if = "Option::is_none")]
        save_to: Option<PathBuf> = None;
    }
    relations |own| {
        inflation_radius_m: own.inflation_radius_m <= own.clearance_limit_m,
            "must be at most clearance_limit_m";
        raytrace_range_m: own.raytrace_range_m >= own.obstacle_range_m,
            "must be at least obstacle_range_m";
    }
}

impl MappingConfig {
    /// Accepts parameters that are within their ranges and fit cells of `resolution_m`.
    ///
    /// # Errors
    /// The first parameter that is wrong.
    pub fn check(&self, resolution_m: f64) -> Result<(), ParameterError> {
        zeronav_params::check(self)?;
        let range_m = resolution_m..=CLEARANCE_CELLS_MAX * resolution_m;
        if range_m.contains(&self.clearance_limit_m) {
            return Ok(());
        }
        Err(ParameterError {
            path: "clearance_limit_m".to_owned(),
            rule: format!("must be 1 to {CLEARANCE_CELLS_MAX} cells of {resolution_m} m"),
            value: format!("{:?}", self.clearance_limit_m),
        })
    }

    /// The grid of a map without a static one.
    ///
    /// # Errors
    /// [`MappingError::NoArea`], [`MappingError::Geometry`].
    pub fn geometry(&self) -> Result<GridGeometry, MappingError> {
        let [[x0, y0], [x1, y1]] = self.area_m.ok_or(MappingError::NoArea)?;
        // A sliver of a millionth of a cell makes no cell.
        let cells = |length_m: f64| (length_m / self.resolution_m - 1.0e-6).ceil().to_u32();
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

    /// Path of the parameter that is rejected after `change`, empty for none.
    fn check(change: impl FnOnce(&mut MappingConfig)) -> String {
        let mut config = MappingConfig::default();
        change(&mut config);
        config
            .check(0.05)
            .map_or_else(|error| error.path, |()| String::new())
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
