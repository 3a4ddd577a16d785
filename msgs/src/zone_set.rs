//! The zones as a reader keeps them, and what they ask of a place.

use crate::zones::{ZoneKind, ZonePart, Zones};
use nalgebra::{Point2, Vector2};

/// Directions in which the way out of a zone is looked for.
const WAYS_OUT: u32 = 32;

/// Farthest way out that is told apart. [m]
const WAY_OUT_M_MAX: f64 = 1.0e4;

/// Gap between two parts on a way out that counts as none: neighbours of a mask share an edge. [m]
const SEAM_M: f64 = 1.0e-3;

/// All zones of one revision; the default is none at all.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ZoneSet {
    revision: u64,
    parts: Vec<Part>,
}

#[derive(Debug, Clone, PartialEq)]
struct Part {
    message: ZonePart,
    kind: ZoneKind,
    /// Smallest upright rectangle around it. [m]
    min: Point2<f64>,
    max: Point2<f64>,
}

/// A speed limit and the zone that asks for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedZone<'a> {
    /// Name of the zone.
    pub name: &'a str,
    /// [m/s] fastest speed.
    pub limit_mps: f64,
}

impl Part {
    fn of(message: &ZonePart) -> Option<Self> {
        let kind = message.kind()?;
        let mut min = Point2::new(f64::INFINITY, f64::INFINITY);
        let mut max = -min;
        for [x_m, y_m] in message.corners() {
            min = Point2::new(min.x.min(*x_m), min.y.min(*y_m));
            max = Point2::new(max.x.max(*x_m), max.y.max(*y_m));
        }
        Some(Self {
            message: *message,
            kind,
            min,
            max,
        })
    }

    /// No farther than this from the point lies the rectangle around it. [m]
    fn is_within(&self, at: Point2<f64>, reach_m: f64) -> bool {
        at.x >= self.min.x - reach_m
            && at.x <= self.max.x + reach_m
            && at.y >= self.min.y - reach_m
            && at.y <= self.max.y + reach_m
    }

    fn edges(&self) -> impl Iterator<Item = (Point2<f64>, Point2<f64>)> + '_ {
        let corners = self.message.corners();
        let next = corners.iter().cycle().skip(1);
        let pairs = corners.iter().zip(next);
        pairs.map(|(from, to)| (Point2::from(*from), Point2::from(*to)))
    }

    /// True for a point inside; crossing number, half-open in y.
    fn contains(&self, at: Point2<f64>) -> bool {
        self.is_within(at, 0.0)
            && self.edges().fold(false, |inside, (from, to)| {
                let crosses = (from.y > at.y) != (to.y > at.y)
                    && at.x < from.x + (at.y - from.y) / (to.y - from.y) * (to.x - from.x);
                inside ^ crosses
            })
    }

    /// From the point to the nearest edge. [m]
    fn edge_distance_m(&self, at: Point2<f64>) -> f64 {
        let distances = self.edges().map(|(from, to)| {
            let along = to - from;
            let length = along.norm_squared();
            let share = if length > 0.0 {
                ((at - from).dot(&along) / length).clamp(0.0, 1.0)
            } else {
                0.0
            };
            (from + along * share - at).norm()
        });
        distances.fold(f64::INFINITY, f64::min)
    }

    /// Where a ray is inside: adds pairs of distances from its origin. [m]
    fn spans(&self, origin: Point2<f64>, towards: Vector2<f64>, spans: &mut Vec<[f64; 2]>) {
        let mut crossings: Vec<f64> = Vec::new();
        for (from, to) in self.edges() {
            let (a, b) = (towards.perp(&(from - origin)), towards.perp(&(to - origin)));
            if (a > 0.0) != (b > 0.0) {
                let at = from + (to - from) * (a / (a - b));
                crossings.push((at - origin).dot(&towards));
            }
        }
        crossings.sort_by(f64::total_cmp);
        let pairs = crossings.chunks_exact(2).filter(|pair| pair[1] >= 0.0);
        spans.extend(pairs.map(|pair| [pair[0], pair[1]]));
    }

    /// True when the polygon and the upright square of that side around a point have a point in common.
    fn touches_square(&self, centre: Point2<f64>, half_m: f64) -> bool {
        if !self.is_within(centre, half_m) {
            return false;
        }
        let is_in = |at: Point2<f64>| (at - centre).amax() <= half_m;
        self.contains(centre)
            || self
                .edges()
                .any(|(from, to)| is_in(from) || clips(from - centre, to - centre, half_m))
    }
}

/// True when a segment crosses the upright square of that half side around the origin; Liang and
/// Barsky, "A new concept and method for line clipping" (1984).
fn clips(from: Vector2<f64>, to: Vector2<f64>, half_m: f64) -> bool {
    let along = to - from;
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    for (step, room) in [
        (-along.x, from.x + half_m),
        (along.x, half_m - from.x),
        (-along.y, from.y + half_m),
        (along.y, half_m - from.y),
    ] {
        if step == 0.0 {
            if room < 0.0 {
                return false;
            }
        } else if step < 0.0 {
            first = first.max(room / step);
        } else {
            last = last.min(room / step);
        }
    }
    first <= last
}

impl ZoneSet {
    /// The zones of a message that [`Zones::check`] has accepted.
    #[must_use]
    pub fn of(zones: &Zones, parts: &[ZonePart]) -> Self {
        Self {
            revision: zones.revision,
            parts: parts.iter().filter_map(Part::of).collect(),
        }
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
        self.parts.iter().any(|part| part.kind == kind)
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

    fn keepouts(&self) -> impl Iterator<Item = &Part> {
        let parts = self.parts.iter();
        parts.filter(|part| part.kind == ZoneKind::Keepout)
    }

    /// True when no keepout zone comes nearer to a point than this. [m]
    #[must_use]
    pub fn is_far(&self, at: Point2<f64>, reach_m: f64) -> bool {
        !self.keepouts().any(|part| part.is_within(at, reach_m))
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

    /// How far a point is outside of all keepout zones; inside, below 0, how far it is to the way out
    /// that is the shortest of 32 directions, through all parts that lie on it. Infinite without one. [m]
    #[must_use]
    pub fn keepout_margin_m(&self, at: Point2<f64>) -> f64 {
        if self.keepout_at(at).is_none() {
            let edges = self.keepouts().map(|part| part.edge_distance_m(at));
            return edges.fold(f64::INFINITY, f64::min);
        }
        let mut spans = Vec::new();
        let ways = (0..WAYS_OUT).map(|n| {
            let (sin, cos) =
                (core::f64::consts::TAU * f64::from(n) / f64::from(WAYS_OUT)).sin_cos();
            spans.clear();
            for part in self.keepouts() {
                part.spans(at, Vector2::new(cos, sin), &mut spans);
            }
            spans.sort_by(|one, other| one[0].total_cmp(&other[0]));
            let ahead = spans.iter().fold(0.0_f64, |out_m, [from_m, until_m]| {
                if *from_m <= out_m + SEAM_M {
                    out_m.max(*until_m)
                } else {
                    out_m
                }
            });
            ahead.min(WAY_OUT_M_MAX)
        });
        -ways.fold(WAY_OUT_M_MAX, f64::min)
    }

    /// True when a keepout zone and the upright square of that half side around a point have a point
    /// in common. [m]
    #[must_use]
    pub fn keeps_out_of_square(&self, centre: Point2<f64>, half_m: f64) -> bool {
        let mut keepouts = self.keepouts();
        keepouts.any(|part| part.touches_square(centre, half_m))
    }

    /// Least cost of a cell around a point by the zones of cost and lanes; 0 = they ask for none.
    #[must_use]
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "1 to 252, as the check of the message has made sure"
    )]
    pub fn least_cost_at(&self, at: Point2<f64>) -> u8 {
        let (mut inside, mut beside, mut is_on_lane) = (0.0_f64, 0.0_f64, false);
        for part in &self.parts {
            match part.kind {
                ZoneKind::Cost if part.contains(at) => inside = inside.max(part.message.value),
                ZoneKind::Lane if part.contains(at) => is_on_lane = true,
                ZoneKind::Lane => beside = beside.max(part.message.value),
                _ => {}
            }
        }
        let cost = if is_on_lane {
            inside
        } else {
            inside.max(beside)
        };
        cost as u8
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(parts: &[ZonePart]) -> ZoneSet {
        let zones = Zones {
            revision: 1,
            n_parts: parts.len() as u64,
            ..Zones::default()
        };
        zones.check(parts).unwrap();
        ZoneSet::of(&zones, parts)
    }

    fn rect(name: &str, kind: ZoneKind, value: f64, [x0, y0, x1, y1]: [f64; 4]) -> ZonePart {
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
        assert!(
            (at(0.9, 2.0) + 1.06).abs() < 0.1,
            "across: {}",
            at(0.9, 2.0)
        );
        assert_eq!(zones.keepout_at(Point2::new(-0.5, 2.0)), Some("bar"));
        assert!(set(&[]).keepout_margin_m(Point2::origin()).is_infinite());
    }

    #[test]
    fn a_zone_without_right_angles_touches_the_cells_that_it_crosses() {
        let corners = [[0.0, 0.0], [4.0, 1.0], [3.0, 4.0], [1.9, 1.2]];
        let zones = set(&[ZonePart::new("wedge", ZoneKind::Keepout, 0.0, &corners)]);
        let touches = |x_m: f64, y_m: f64| zones.keeps_out_of_square(Point2::new(x_m, y_m), 0.05);
        assert!(touches(3.0, 2.0), "inside");
        assert!(touches(-0.04, -0.04), "a corner in it");
        assert!(touches(2.0, 0.46), "an edge through it");
        assert!(!touches(2.0, 0.3) && !touches(1.0, 2.0) && !touches(5.0, 5.0));
        // Every square with a point inside is touched.
        for n in 0..4000 {
            let at = Point2::new(
                f64::from(n % 80) * 0.06 - 0.3,
                f64::from(n / 80) * 0.09 - 0.2,
            );
            if zones.keepout_at(at).is_some() {
                let centre = Point2::new(
                    (at.x / 0.1).floor() * 0.1 + 0.05,
                    (at.y / 0.1).floor() * 0.1 + 0.05,
                );
                assert!(zones.keeps_out_of_square(centre, 0.05), "{at}");
            }
        }
    }

    #[test]
    fn lanes_raise_the_cost_beside_them_and_costs_that_inside() {
        let zones = set(&[
            rect("lane", ZoneKind::Lane, 80.0, [0.0, 0.0, 10.0, 1.0]),
            rect("wet", ZoneKind::Cost, 200.0, [4.0, 0.0, 5.0, 3.0]),
        ]);
        let at = |x_m: f64, y_m: f64| zones.least_cost_at(Point2::new(x_m, y_m));
        assert_eq!(
            [at(1.0, 0.5), at(1.0, 2.0), at(4.5, 0.5), at(4.5, 2.0)],
            [0, 80, 200, 200]
        );
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
