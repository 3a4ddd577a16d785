//! Why a configuration or a static map makes no map.

use zeronav_msgs::message;
use zeronav_params::ParameterError;

/// Why there can be no map.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MappingError {
    /// Neither a static map nor an area.
    #[error("area_m: required without static_map")]
    NoArea,
    /// Area and resolution make no grid.
    #[error("area_m and resolution_m make no map: {0}")]
    Geometry(message::Refusal),
    /// The static map has more or fewer cells than its geometry says.
    #[error("the static map has {n_cells} cells where its geometry has {expected}")]
    StaticMap {
        /// Cells that it has.
        n_cells: usize,
        /// Cells that it should have.
        expected: usize,
    },
    /// A parameter has a value that it must not have.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
}
