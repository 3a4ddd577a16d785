//! Zones as the renderer draws them.

use super::{Rounded, point};
use serde::Serialize;
use zeronav_msgs::zones::{ZoneKind, ZonePart};

/// A part of a zone: name, kind, value of the kind, corners in the map frame.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SceneZone(String, &'static str, Rounded, Vec<[Rounded; 2]>);

impl SceneZone {
    /// One of `task/zones`.
    #[must_use]
    pub fn of(part: &ZonePart) -> Self {
        let corners = part.corners().iter().map(|[x_m, y_m]| point(*x_m, *y_m));
        Self(
            part.name().to_owned(),
            part.kind().map_or("unknown", ZoneKind::label),
            Rounded::thousandths(part.value),
            corners.collect(),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_zone_has_its_name_its_kind_and_its_corners() {
        let corners = [[0.0, 0.0], [1.5, 0.0], [0.0, 2.0]];
        let part = ZonePart::new("ramp", ZoneKind::SpeedLimit, 0.3, &corners);
        let text = serde_json::to_string(&SceneZone::of(&part)).expect("JSON");
        assert_eq!(text, r#"["ramp","speed_limit",0.3,[[0,0],[1.5,0],[0,2]]]"#);
    }
}
