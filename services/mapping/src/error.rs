//! Why a configuration or a static map makes no map.

use zeronav_msgs::message;

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
    /// A number outside its range.
    #[error("{field} = {value}: {rule}")]
    OutOfRange {
        /// Name of the field as in the configuration.
        field: &'static str,
        /// What it was.
        value: f64,
        /// What it must be.
        rule: &'static str,
    },
}

/// `Ok` when `ok`; otherwise names the field.
///
/// # Errors
/// [`MappingError::OutOfRange`].
pub(crate) fn ensure(
    ok: bool,
    field: &'static str,
    value: f64,
    rule: &'static str,
) -> Result<(), MappingError> {
    if ok {
        Ok(())
    } else {
        Err(MappingError::OutOfRange { field, value, rule })
    }
}
