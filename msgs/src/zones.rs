//! `task/zones`: where the robot may not go, where it is slow, and which ways it prefers.
//!
//! A message holds all zones, so that a lost one opens none: readers keep what they have. A zone is
//! one polygon, or several parts with its name, as a mask is made of rectangles. `run/control` names
//! the revision that holds, so that a reader knows when it lacks one.

use crate::message::{COORDINATE_M_MAX, Refusal, SPEED_MAX, ZeroCopySend, ensure, number};
use crate::{codes, message};

/// Most zones, by name.
pub const ZONES_MAX: usize = 128;

/// Most parts of all zones.
pub const ZONE_PARTS_MAX: usize = 512;

/// Most corners of a part.
pub const ZONE_CORNERS_MAX: usize = 16;

/// Longest name. [bytes]
pub const ZONE_NAME_BYTES: usize = 32;

/// Lowest speed limit: slower the robot would not leave its zone. [m/s]
pub const ZONE_SPEED_MPS_MIN: f64 = 0.01;

/// Lowest speed limit as a share of the robot's fastest speed. [%]
pub const ZONE_PERCENT_MIN: f64 = 1.0;

/// Highest cost of a cell that may be driven on.
pub const ZONE_COST_MAX: f64 = 252.0;

codes! {
    /// What a zone asks of the robot.
    pub enum ZoneKind: u16 {
        /// Nothing.
        None = 0 => "none",
        /// Stay outside.
        Keepout = 1 => "keepout",
        /// Drive no faster than so many m/s.
        SpeedLimit = 2 => "speed_limit",
        /// Drive no faster than so many percent of the robot's fastest speed.
        SpeedPercent = 3 => "speed_percent",
        /// Cells inside cost at least so much.
        Cost = 4 => "cost",
        /// A preferred lane: cells outside of all lanes cost at least so much.
        Lane = 5 => "lane",
    }
}

message! {
    /// Fixed fields of the zones. The slice holds their parts, those of a zone one after the other.
    pub struct Zones = "zeronav.Zones.v1" {
        /// [number] Grows with every change, from 1.
        pub revision: u64,
        /// [tick] First tick at which they hold; 0 = at once.
        pub from_tick: u64,
        /// [count] Parts in the slice.
        pub n_parts: u64,
    }
}

message! {
    /// A polygon of a zone. Its edges may not cross; inside is what an odd number of edges encloses.
    pub struct ZonePart = "zeronav.ZonePart.v1" {
        /// [text] Name of the zone, padded with 0.
        pub name: [u8; 32],
        /// [m] x and y of the corners, `map` frame; those beyond `n_corners` are 0.
        pub corners_m: [[f64; 2]; 16],
        /// [m/s, -] by kind: a speed, percent, or a cost of 1 to 252; 0 for a keepout zone.
        pub value: f64,
        /// Code of [`ZoneKind`].
        pub kind: u16,
        /// [count] Corners, at least 3.
        pub n_corners: u16,
        /// Written as 0.
        pub spare: u32,
    }
}

impl ZonePart {
    /// A part of the zone `name`; corners beyond the most are left out.
    #[must_use]
    pub fn new(name: &str, kind: ZoneKind, value: f64, corners: &[[f64; 2]]) -> Self {
        let mut part = Self {
            value,
            kind: kind.code(),
            n_corners: u16::try_from(corners.len().min(ZONE_CORNERS_MAX)).unwrap_or(0),
            ..Self::default()
        };
        for (to, from) in part.name.iter_mut().zip(name.bytes()) {
            *to = from;
        }
        for (to, from) in part.corners_m.iter_mut().zip(corners) {
            *to = *from;
        }
        part
    }

    /// What it asks of the robot.
    #[must_use]
    pub const fn kind(&self) -> Option<ZoneKind> {
        ZoneKind::from_code(self.kind)
    }

    /// Name of the zone; empty when it is no text.
    #[must_use]
    pub fn name(&self) -> &str {
        let n = (self.name.iter().position(|byte| *byte == 0)).unwrap_or(self.name.len());
        core::str::from_utf8(&self.name[..n]).unwrap_or("")
    }

    /// The corners in the map frame. [m]
    #[must_use]
    pub fn corners(&self) -> &[[f64; 2]] {
        &self.corners_m[..usize::from(self.n_corners).min(ZONE_CORNERS_MAX)]
    }

    fn check(&self) -> Result<(), Refusal> {
        let kind = self.kind().ok_or(Refusal::Code("zone.kind"))?;
        let name = self.name();
        let is_padded = self.name[name.len()..].iter().all(|byte| *byte == 0);
        let is_word = !name.is_empty() && name.chars().all(|one| !one.is_control());
        ensure(is_word && is_padded, Refusal::OutOfRange("zone.name"))?;
        let [least, most] = match kind {
            ZoneKind::None => return Err(Refusal::Code("zone.kind")),
            ZoneKind::Keepout => [0.0, 0.0],
            ZoneKind::SpeedLimit => [ZONE_SPEED_MPS_MIN, SPEED_MAX],
            ZoneKind::SpeedPercent => [ZONE_PERCENT_MIN, 100.0],
            ZoneKind::Cost | ZoneKind::Lane => [1.0, ZONE_COST_MAX],
        };
        number(self.value, least, most, "zone.value")?;
        let n = usize::from(self.n_corners);
        ensure(
            (3..=ZONE_CORNERS_MAX).contains(&n),
            Refusal::Length("zone.corners"),
        )?;
        for along in self.corners_m.iter().flatten() {
            number(
                *along,
                -COORDINATE_M_MAX,
                COORDINATE_M_MAX,
                "zone.corners_m",
            )?;
        }
        Ok(())
    }
}

impl Zones {
    /// Accepts zones whose parts are polygons with a name and a value of their kind.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self, parts: &[ZonePart]) -> Result<(), Refusal> {
        ensure(self.revision != 0, Refusal::Identity)?;
        ensure(
            parts.len() as u64 == self.n_parts && parts.len() <= ZONE_PARTS_MAX,
            Refusal::Length("parts"),
        )?;
        let mut n_zones = 0;
        for (index, part) in parts.iter().enumerate() {
            part.check()?;
            let before = index.checked_sub(1).and_then(|before| parts.get(before));
            n_zones += usize::from(before.is_none_or(|before| before.name != part.name));
        }
        ensure(n_zones <= ZONES_MAX, Refusal::Length("zones"))
    }
}
