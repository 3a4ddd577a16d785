//! Zones of a scenario or of a client: where the robot may not go, where it is slow, which ways it prefers.

use core::f64::consts::PI;
use nalgebra::{Point2, Vector2};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use std::path::PathBuf;
use zeronav_msgs::message::{COORDINATE_M_MAX, SPEED_MAX};
use zeronav_msgs::zones::{
    ZONE_CORNERS_MAX, ZONE_COST_MAX, ZONE_NAME_BYTES, ZONE_PARTS_MAX, ZONE_PERCENT_MIN,
    ZONE_SPEED_MPS_MIN, ZONES_MAX, ZoneKind, ZonePart, Zones,
};
use zeronav_msgs::{Pose, ZoneSet};
use zeronav_shell::printable::printable;
use zeronav_world::error::{SpecError, number};
use zeronav_world::{Footprint, World};
use zeronav_world_files::mask;

/// Cost beside a preferred lane, when the scenario says none.
const LANE_COST: f64 = 100.0;

/// Room around the robot at a pose that is offered in place of a goal. [m]
const OFFERED_M: f64 = 0.1;

/// What a zone asks for, in words.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ZoneWord {
    /// Stay outside.
    Keepout,
    /// Drive no faster inside than `limit_mps`, or than `percent` of the robot's fastest speed.
    SpeedLimit,
    /// Cells inside cost at least `cost`.
    Cost,
    /// A preferred lane: cells outside of all lanes cost at least `cost`.
    Lane,
}

/// A zone: a polygon with a kind, or a mask whose file says the kind.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ZoneSpec {
    /// What it is called.
    pub name: String,
    /// What it asks for; not with a mask.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kind: Option<ZoneWord>,
    /// Corners `[x, y]` in the map frame, in order. [m]
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub polygon: Vec<[f64; 2]>,
    /// YAML file of a mask, in place of a polygon.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mask: Option<PathBuf>,
    /// Fastest speed inside. [m/s]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit_mps: Option<f64>,
    /// The same as a share of the robot's fastest speed. [%]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub percent: Option<f64>,
    /// Cost of a cell, 1 to 252.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cost: Option<f64>,
}

impl ZoneSpec {
    /// The parts of the message, with the mask read.
    ///
    /// # Errors
    /// The field that cannot be.
    pub fn parts(&self) -> Result<Vec<ZonePart>, SpecError> {
        let is_named = !self.name.is_empty() && self.name.len() <= ZONE_NAME_BYTES;
        if !is_named || printable(&self.name) != self.name {
            let why = format!("must have 1 to {ZONE_NAME_BYTES} bytes and no control characters");
            return Err(SpecError::new("name", why));
        }
        let Some(file) = &self.mask else {
            return Ok(vec![self.polygon_part()?]);
        };
        let said = [
            ("kind", self.kind.is_some()),
            ("polygon", !self.polygon.is_empty()),
            ("limit_mps", self.limit_mps.is_some()),
            ("percent", self.percent.is_some()),
            ("cost", self.cost.is_some()),
        ];
        if let Some((field, _)) = said.into_iter().find(|(_, is_said)| *is_said) {
            let why = "is said by the file of the mask: leave it out";
            return Err(SpecError::new(field, why));
        }
        let read = mask::load(file).map_err(|error| SpecError::new("mask", error.to_string()))?;
        if read.is_empty() {
            let why = format!("{}: no pixel asks for anything", file.display());
            return Err(SpecError::new("mask", why));
        }
        let part = |part: &mask::MaskPart| {
            ZonePart::new(&self.name, part.kind, part.value, &part.corners_m)
        };
        Ok(read.iter().map(part).collect())
    }

    fn polygon_part(&self) -> Result<ZonePart, SpecError> {
        let Some(kind) = self.kind else {
            let why = "is missing: keepout, speed_limit, cost or lane, or a mask";
            return Err(SpecError::new("kind", why));
        };
        let limit = |field, value: Option<f64>, of: ZoneWord| match value {
            Some(_) if kind != of => Err(SpecError::new(
                field,
                "is of no use for a zone of that kind",
            )),
            value => Ok(value),
        };
        let limit_mps = limit("limit_mps", self.limit_mps, ZoneWord::SpeedLimit)?;
        let percent = limit("percent", self.percent, ZoneWord::SpeedLimit)?;
        let (wire, value, [least, most], field) = match kind {
            ZoneWord::Keepout => (ZoneKind::Keepout, 0.0, [0.0, 0.0], "kind"),
            ZoneWord::SpeedLimit => match (limit_mps, percent) {
                (Some(value), None) => {
                    let range = [ZONE_SPEED_MPS_MIN, SPEED_MAX];
                    (ZoneKind::SpeedLimit, value, range, "limit_mps")
                }
                (None, Some(value)) => {
                    let range = [ZONE_PERCENT_MIN, 100.0];
                    (ZoneKind::SpeedPercent, value, range, "percent")
                }
                _ => {
                    let why = "a speed limit needs limit_mps or percent, one of the two";
                    return Err(SpecError::new("kind", why));
                }
            },
            ZoneWord::Cost | ZoneWord::Lane => {
                let of = if kind == ZoneWord::Cost {
                    ZoneKind::Cost
                } else {
                    ZoneKind::Lane
                };
                let value = self.cost.unwrap_or(LANE_COST).round();
                (of, value, [1.0, ZONE_COST_MAX], "cost")
            }
        };
        if self.cost.is_some() && field != "cost" {
            return Err(SpecError::new(
                "cost",
                "is of no use for a zone of that kind",
            ));
        }
        number(value, least, most, field)?;
        check_polygon(&self.polygon)?;
        Ok(ZonePart::new(&self.name, wire, value, &self.polygon))
    }
}

/// Accepts corners of an area whose edges do not cross.
fn check_polygon(corners: &[[f64; 2]]) -> Result<(), SpecError> {
    let n = corners.len();
    if !(3..=ZONE_CORNERS_MAX).contains(&n) {
        let why = format!("needs 3 to {ZONE_CORNERS_MAX} corners, not {n}");
        return Err(SpecError::new("polygon", why));
    }
    for (index, along) in corners.iter().enumerate() {
        for value in along {
            let field = format!("polygon[{index}]");
            number(*value, -COORDINATE_M_MAX, COORDINATE_M_MAX, &field)?;
        }
    }
    let at = |index: usize| Point2::from(corners[index % n]);
    let side = |of: usize, point: Point2<f64>| {
        let along: Vector2<f64> = at(of + 1) - at(of);
        along.perp(&(point - at(of)))
    };
    for one in 0..n {
        for other in one + 2..n {
            if one == 0 && other == n - 1 {
                continue;
            }
            let is_cut = side(one, at(other)) * side(one, at(other + 1)) < 0.0
                && side(other, at(one)) * side(other, at(one + 1)) < 0.0;
            if is_cut {
                let why = format!("its edges from corner {one} and from corner {other} cross");
                return Err(SpecError::new("polygon", why));
            }
        }
    }
    let twice_area: f64 = (1..n - 1)
        .map(|index| (at(index) - at(0)).perp(&(at(index + 1) - at(0))))
        .sum();
    if twice_area.abs() < 1.0e-4 {
        return Err(SpecError::new("polygon", "its corners enclose no area"));
    }
    Ok(())
}

/// A zone and the parts that it is made of: its mask is read once.
#[derive(Debug, Clone)]
pub struct ReadZone {
    /// As it was said.
    pub spec: ZoneSpec,
    /// As it is sent.
    pub parts: Vec<ZonePart>,
}

impl ReadZone {
    /// Reads the mask of a zone.
    ///
    /// # Errors
    /// The field that cannot be.
    pub fn of(spec: ZoneSpec) -> Result<Self, SpecError> {
        let parts = spec.parts()?;
        Ok(Self { spec, parts })
    }

    /// Reads a list.
    ///
    /// # Errors
    /// The first field that cannot be, from its place in the list on.
    pub fn all(zones: &[ZoneSpec]) -> Result<Vec<Self>, SpecError> {
        let zones = zones.iter().enumerate().map(|(index, zone)| {
            Self::of(zone.clone()).map_err(|error| error.within(&format!("[{index}]")))
        });
        zones.collect()
    }
}

/// The zones of a list as one message.
///
/// # Errors
/// The first field that cannot be, from its place in the list on.
pub fn message(zones: &[ReadZone], revision: u64) -> Result<(Zones, Vec<ZonePart>), SpecError> {
    if zones.len() > ZONES_MAX {
        let why = format!("{} zones, at most {ZONES_MAX}", zones.len());
        return Err(SpecError::new("", why));
    }
    let mut parts = Vec::new();
    for (index, ReadZone { spec, parts: own }) in zones.iter().enumerate() {
        let at = |error: SpecError| error.within(&format!("[{index}]"));
        if zones[..index]
            .iter()
            .any(|other| other.spec.name == spec.name)
        {
            let why = format!("there are two zones `{}`", spec.name);
            return Err(at(SpecError::new("name", why)));
        }
        parts.extend_from_slice(own);
        if parts.len() > ZONE_PARTS_MAX {
            let why = format!(
                "with it all zones have {} parts, at most {ZONE_PARTS_MAX}: draw masks with fewer \
                 steps and shades",
                parts.len()
            );
            let field = spec.mask.as_ref().map_or("polygon", |_| "mask");
            return Err(at(SpecError::new(field, why)));
        }
    }
    let message = Zones {
        revision,
        from_tick: 0,
        n_parts: parts.len() as u64,
    };
    (message.check(&parts)).map_err(|refusal| SpecError::new("", refusal.to_string()))?;
    Ok((message, parts))
}

/// Why a robot cannot be at a pose, or within `tolerance_m` of it: it would be in a keepout zone.
#[must_use]
pub fn keeps_out(
    zones: &ZoneSet,
    footprint: &Footprint,
    pose: &Pose,
    tolerance_m: f64,
) -> Option<String> {
    let (name, _) = zones.nearest_keepout(pose.point())?;
    let margin_m = zones.keepout_margin_m(pose.point());
    let needs_m = footprint.inscribed_radius_m() - tolerance_m.max(0.0);
    let at = format!("({}, {})", pose.x_m, pose.y_m);
    if margin_m < 0.0 {
        Some(format!("{at} lies in the keepout zone `{name}`"))
    } else if margin_m < needs_m {
        Some(format!(
            "at {at} the robot would reach into the keepout zone `{name}`"
        ))
    } else {
        None
    }
}

/// True for a place with room outside of all keepout zones.
#[must_use]
pub fn is_outside(zones: &ZoneSet, footprint: &Footprint, at: Point2<f64>) -> bool {
    zones.keepout_margin_m(at) > footprint.circumscribed_radius_m()
}

/// What is wrong with the zones of a scenario, and with goals inside of them, each a pose and its tolerance [m]; these are
/// looked at where there is a `place`.
pub(super) fn check<'a>(
    zones: &[ZoneSpec],
    goals: impl Iterator<Item = (&'a Pose, f64)>,
    place: Option<(&World, &Footprint)>,
) -> Vec<SpecError> {
    let read = ReadZone::all(zones).and_then(|zones| message(&zones, 1));
    let (message, parts) = match read {
        Ok(set) => set,
        Err(error) => return vec![error.within("zones")],
    };
    let Some(place) = place else {
        return Vec::new();
    };
    let set = ZoneSet::of(&message, &parts);
    let refused = goals
        .enumerate()
        .filter_map(|(index, (pose, tolerance_m))| {
            let why = refused_goal(&set, place, pose, tolerance_m)?;
            Some(SpecError::new(format!("goals[{index}].pose"), why))
        });
    refused.collect()
}

/// Why a goal of a scenario cannot be, with the nearest pose that can.
fn refused_goal(
    zones: &ZoneSet,
    (world, footprint): (&World, &Footprint),
    pose: &Pose,
    tolerance_m: f64,
) -> Option<String> {
    let why = keeps_out(zones, footprint, pose, tolerance_m)?;
    let accepts = |at| is_outside(zones, footprint, at);
    let nearest = world.nearest_free_pose(footprint, pose, PI, OFFERED_M, accepts);
    let nearest = nearest.map_or_else(
        || "no free pose outside is near".to_owned(),
        |Pose { x_m, y_m, yaw_rad }| {
            format!("the nearest free pose is [{x_m:.2}, {y_m:.2}, {yaw_rad:.2}]")
        },
    );
    Some(format!("{why}; {nearest}"))
}

/// The schema of the list.
pub(super) fn schema() -> Value {
    let number =
        |[least, most]: [f64; 2]| json!({ "type": "number", "minimum": least, "maximum": most });
    let coordinate = number([-COORDINATE_M_MAX, COORDINATE_M_MAX]);
    let point = json!({ "type": "array", "prefixItems": [coordinate, coordinate], "minItems": 2, "maxItems": 2 });
    let fields: Map<String, Value> = [
        (
            "name",
            json!({ "type": "string", "minLength": 1, "maxLength": ZONE_NAME_BYTES }),
        ),
        (
            "kind",
            json!({ "enum": ["keepout", "speed_limit", "cost", "lane"] }),
        ),
        (
            "polygon",
            json!({ "type": "array", "items": point, "minItems": 3, "maxItems": ZONE_CORNERS_MAX }),
        ),
        ("mask", json!({ "type": "string" })),
        ("limit_mps", number([ZONE_SPEED_MPS_MIN, SPEED_MAX])),
        ("percent", number([ZONE_PERCENT_MIN, 100.0])),
        ("cost", number([1.0, ZONE_COST_MAX])),
    ]
    .into_iter()
    .map(|(name, schema)| (name.to_owned(), schema))
    .collect();
    json!({
        "type": "array",
        "maxItems": ZONES_MAX,
        "items": {
            "type": "object", "properties": fields, "required": ["name"], "additionalProperties": false,
        },
    })
}
