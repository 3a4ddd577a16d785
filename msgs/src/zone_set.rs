//! The zones as a reader keeps them, and what they ask of a place.

use crate::zone_shape::{Part, Segment, distance_m};
use crate::zones::{ZoneKind, ZonePart, Zones};
use nalgebra::Point2;

/// All zones of one revision; the default is none at all.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ZoneSet {
    revision: u64,
    parts: Vec<Part>,
    /// Edge of what all keepout zones cover together. [m]
    keepout_edge: Vec<Segment>,
}

/// A speed limit and the zone that asks for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedZone<'a> {
    /// Name of the zone.
    pub name: &'a str,
    /// [m/s] fastest speed.
    pub limit_mps: f64,
}

/// Some keepout zones.
#[derive(Debug, Clone, Default)]
pub struct Keepouts<'a> {
    parts: Vec<&'a Part>,
}

impl Keepouts<'_> {
    /// True when there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.parts.is_empty()
    }

    /// True when none comes nearer to a point than this. [m]
    #[must_use]
    pub fn are_far(&self, at: Point2<f64>, reach_m: f64) -> bool {
        !self.parts.iter().any(|part| part.is_within(at, reach_m))
    }

    /// True for a point in one.
    #[must_use]
    pub fn hold(&self, at: Point2<f64>) -> bool {
        self.parts.iter().any(|part| part.contains(at))
    }
}

impl ZoneSet {
    /// The zones of a message that [`Zones::check`] has accepted.
    #[must_use]
    pub fn of(zones: &Zones, parts: &[ZonePart]) -> Self {
        let mut set = Self {
            revision: zones.revision,
            parts: parts.iter().filter_map(Part::of).collect(),
            keepout_edge: Vec::new(),
        };
        let mut edge = Vec::new();
        let keepouts: Vec<&Part> = set.keepouts().collect();
        for part in &keepouts {
            part.open_edges(&keepouts, &mut edge);
        }
        set.keepout_edge = edge;
        set
    }

    /// Revision of the message; 0 = none has come.
    #[must_use]
    pub const fn revision(&self) -> u64 {
        self.revision
    }

    /// True when there is no zone.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.parts.is_empty()
    }

    /// The parts.
    pub fn parts(&self) -> impl Iterator<Item = &ZonePart> {
        self.parts.iter().map(|part| &part.message)
    }

    /// Corners of the smallest upright rectangle around each part, lower left and upper right, with its
    /// message. [m]
    pub fn bounds(&self) -> impl Iterator<Item = (&ZonePart, Point2<f64>, Point2<f64>)> {
        let parts = self.parts.iter();
        parts.map(|part| (&part.message, part.min, part.max))
    }

    /// True when there is a zone of that kind.
    #[must_use]
    pub fn has(&self, kind: ZoneKind) -> bool {
        self.of_kind(kind).next().is_some()
    }

    /// True when there is a speed limit.
    #[must_use]
    pub fn has_limit(&self) -> bool {
        self.has(ZoneKind::SpeedLimit) || self.has(ZoneKind::SpeedPercent)
    }

    /// The lowest speed limit that holds at a point for a robot with that fastest speed. [m/s]
    #[must_use]
    pub fn limit_at(&self, at: Point2<f64>, v_mps_max: f64) -> Option<SpeedZone<'_>> {
        self.lowest_limit(v_mps_max, |part| part.contains(at))
    }

    /// The lowest speed limit that holds anywhere. [m/s]
    #[must_use]
    pub fn limit_anywhere(&self, v_mps_max: f64) -> Option<SpeedZone<'_>> {
        self.lowest_limit(v_mps_max, |_| true)
    }

    fn lowest_limit(&self, v_mps_max: f64, of: impl Fn(&Part) -> bool) -> Option<SpeedZone<'_>> {
        let limits = self.parts.iter().filter_map(|part| {
            let limit_mps = match part.kind {
                ZoneKind::SpeedLimit => part.message.value,
                ZoneKind::SpeedPercent => v_mps_max * part.message.value / 100.0,
                _ => return None,
            };
            of(part).then(|| SpeedZone {
                name: part.message.name(),
                limit_mps,
            })
        });
        limits.reduce(|least, limit| {
            if limit.limit_mps < least.limit_mps {
                limit
            } else {
                least
            }
        })
    }

    pub(crate) fn of_kind(&self, kind: ZoneKind) -> impl Iterator<Item = &Part> {
        self.parts.iter().filter(move |part| part.kind == kind)
    }

    /// The largest value of the zones of a kind.
    pub(crate) fn largest(&self, kind: ZoneKind) -> Option<f64> {
        let values = self.of_kind(kind).map(|part| part.message.value);
        values.reduce(f64::max)
    }

    fn keepouts(&self) -> impl Iterator<Item = &Part> {
        self.of_kind(ZoneKind::Keepout)
    }

    /// The keepout zones that come nearer to a point than this, alone. [m]
    #[must_use]
    pub fn keepouts_near(&self, at: Point2<f64>, reach_m: f64) -> Keepouts<'_> {
        let parts = self.keepouts().filter(|part| part.is_within(at, reach_m));
        Keepouts {
            parts: parts.collect(),
        }
    }

    /// The keepout zone that holds a point.
    #[must_use]
    pub fn keepout_at(&self, at: Point2<f64>) -> Option<&str> {
        let mut holding = self.keepouts().filter(|part| part.contains(at));
        holding.next().map(|part| part.message.name())
    }

    /// The nearest keepout zone and its distance, 0 inside. [m]
    #[must_use]
    pub fn nearest_keepout(&self, at: Point2<f64>) -> Option<(&str, f64)> {
        let distance_m = |part: &Part| {
            if part.contains(at) {
                0.0
            } else {
                part.edge_distance_m(at)
            }
        };
        let all = self
            .keepouts()
            .map(|part| (part.message.name(), distance_m(part)));
        all.min_by(|one, other| one.1.total_cmp(&other.1))
    }

    /// How far a point is outside of all keepout zones; inside, below 0, how far it is to the nearest place outside of
    /// all of them. Infinite without one. [m]
    #[must_use]
    pub fn keepout_margin_m(&self, at: Point2<f64>) -> f64 {
        let distances = self.keepout_edge.iter().map(|edge| distance_m(edge, at));
        let least_m = distances.fold(f64::INFINITY, f64::min);
        if self.keepout_at(at).is_some() {
            -least_m
        } else {
            least_m
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::zone_shape::SEAM_M;
    use core::f64::consts::TAU;
    use nalgebra::Vector2;

    pub(crate) fn set(parts: &[ZonePart]) -> ZoneSet {
        let zones = Zones {
            revision: 1,
            n_parts: parts.len() as u64,
            ..Zones::default()
        };
        zones.check(parts).unwrap();
        ZoneSet::of(&zones, parts)
    }

    pub(crate) fn rect(
        name: &str,
        kind: ZoneKind,
        value: f64,
        [x0, y0, x1, y1]: [f64; 4],
    ) -> ZonePart {
        ZonePart::new(name, kind, value, &[[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
    }

    #[test]
    fn of_overlapping_limits_the_lowest_holds() {
        let zones = set(&[
            rect("hall", ZoneKind::SpeedPercent, 50.0, [0.0, 0.0, 10.0, 10.0]),
            rect("ramp", ZoneKind::SpeedLimit, 0.3, [4.0, 0.0, 6.0, 10.0]),
        ]);
        let at = |x_m: f64| zones.limit_at(Point2::new(x_m, 5.0), 1.0);
        let named = |zone: Option<SpeedZone<'_>>| zone.map(|zone| zone.name.to_owned());
        assert_eq!(named(at(5.0)).as_deref(), Some("ramp"));
        assert_eq!(named(at(1.0)).as_deref(), Some("hall"));
        assert_eq!(at(1.0).map(|zone| zone.limit_mps), Some(0.5));
        assert_eq!(at(11.0), None);
        assert_eq!(named(zones.limit_anywhere(1.0)).as_deref(), Some("ramp"));
        // Half of a slow robot's speed is less than the ramp allows.
        let slow = zones.limit_at(Point2::new(5.0, 5.0), 0.4);
        assert_eq!(named(slow).as_deref(), Some("hall"));
    }

    #[test]
    fn the_margin_grows_across_seams_and_overlaps() {
        // Two parts of a mask that share an edge, and a zone across both.
        let zones = set(&[
            rect("mask", ZoneKind::Keepout, 0.0, [0.0, 0.0, 1.0, 4.0]),
            rect("mask", ZoneKind::Keepout, 0.0, [1.0, 0.0, 2.0, 4.0]),
            rect("bar", ZoneKind::Keepout, 0.0, [-1.0, 1.5, 3.0, 2.5]),
        ]);
        let at = |x_m: f64, y_m: f64| zones.keepout_margin_m(Point2::new(x_m, y_m));
        assert!((at(-2.0, 2.0) - 1.0).abs() < 1e-9, "outside");
        assert!((at(0.25, 0.5) + 0.25).abs() < 1e-6, "{}", at(0.25, 0.5));
        assert!(
            (at(1.0, 1.0) + 1.0).abs() < 1e-6,
            "on the seam: {}",
            at(1.0, 1.0)
        );
        // To the corner where mask and bar meet.
        let across = at(0.9, 2.0);
        assert!((across + 0.9_f64.hypot(0.5)).abs() < 1e-6, "{across}");
        assert_eq!(zones.keepout_edge.len(), 14, "what they cover is a cross");
        assert_eq!(zones.keepout_at(Point2::new(-0.5, 2.0)), Some("bar"));
        assert!(set(&[]).keepout_margin_m(Point2::origin()).is_infinite());
    }

    /// Whatever zones overlap, the margin is that of the nearest place that is none's, and changes by no more than the
    /// way between two places.
    #[test]
    fn the_margin_of_any_zones_is_a_distance() {
        let wedge = [[0.0, 0.0], [4.0, 1.0], [3.0, 4.0], [1.9, 1.2]];
        let clockwise = [[-1.0, 0.5], [-1.0, 1.5], [2.5, 1.5], [2.5, 0.5]];
        let zones = set(&[
            ZonePart::new("wedge", ZoneKind::Keepout, 0.0, &wedge),
            ZonePart::new("bar", ZoneKind::Keepout, 0.0, &clockwise),
            rect("box", ZoneKind::Keepout, 0.0, [2.0, 0.0, 5.0, 2.0]),
            rect("limit", ZoneKind::SpeedLimit, 0.3, [-3.0, -3.0, 9.0, 9.0]),
        ]);
        let places: Vec<Point2<f64>> = (0..4900)
            .map(|n| {
                Point2::new(
                    f64::from(n % 70) * 0.11 - 1.5,
                    f64::from(n / 70) * 0.09 - 1.0,
                )
            })
            .collect();
        let outside = |at: &&Point2<f64>| zones.keepout_at(**at).is_none();
        let free: Vec<_> = places.iter().filter(outside).collect();
        for at in &places {
            let margin_m = zones.keepout_margin_m(*at);
            assert_eq!(margin_m < 0.0, zones.keepout_at(*at).is_some(), "{at}");
            if margin_m < 0.0 {
                let nearest_m = free.iter().map(|it| (*it - at).norm());
                let nearest_m = nearest_m.fold(f64::INFINITY, f64::min);
                assert!(-margin_m <= nearest_m + 1e-9, "{at} {margin_m} {nearest_m}");
                // As far away there is a place that is free.
                let around = (0..20_000).map(|n| {
                    let (sin, cos) = (f64::from(n) * TAU / 20_000.0).sin_cos();
                    at + Vector2::new(cos, sin) * (3.0 * SEAM_M - margin_m)
                });
                let mut free = around.filter(|it| zones.keepout_at(*it).is_none());
                assert!(free.next().is_some(), "{at} {margin_m}");
            }
            let beside = at + Vector2::new(0.006, -0.008);
            let change_m = (zones.keepout_margin_m(beside) - margin_m).abs();
            assert!(change_m <= 0.01 + 2.0 * SEAM_M, "{at} {change_m}");
        }
    }

    #[test]
    fn what_is_no_zone_is_rejected() {
        let good = rect("a", ZoneKind::SpeedLimit, 0.5, [0.0, 0.0, 1.0, 1.0]);
        let why = |change: fn(&mut ZonePart)| {
            let mut part = good;
            change(&mut part);
            let zones = Zones {
                revision: 1,
                n_parts: 1,
                ..Zones::default()
            };
            zones
                .check(&[part])
                .err()
                .map(|refusal| refusal.to_string())
        };
        assert_eq!(why(|_| ()), None);
        assert_eq!(
            why(|it| it.value = 0.0).as_deref(),
            Some("zone.value is out of range")
        );
        assert_eq!(
            why(|it| it.kind = 9).as_deref(),
            Some("unknown code in zone.kind")
        );
        assert_eq!(
            why(|it| it.kind = 0).as_deref(),
            Some("unknown code in zone.kind")
        );
        assert_eq!(
            why(|it| it.n_corners = 2).as_deref(),
            Some("wrong number of zone.corners")
        );
        assert_eq!(
            why(|it| it.name = [0; 32]).as_deref(),
            Some("zone.name is out of range")
        );
        assert_eq!(
            why(|it| it.name[5] = b'x').as_deref(),
            Some("zone.name is out of range")
        );
        let nan = why(|it| it.corners_m[1][0] = f64::NAN);
        assert_eq!(
            nan.as_deref(),
            Some("zone.corners_m is not a finite number")
        );
    }
}
