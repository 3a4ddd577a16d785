//! What a return tells of a surface: single beams come back from dust, rain or from between two edges.
//!
//! A thing is as wide as the beams that it stops. What stops three beams beside each other is there; what
//! stops fewer has to be there in every scan of a fifth of a second: of a hundred drops of rain in a scan, some are
//! beside each other. Far away beams lie farther apart than the edges of a door tell from each other: a
//! beam beside an edge gives a range somewhere between what is before and behind it, which may lie as near to its
//! neighbour's as a surface seen at a slant does. There a return counts only when it lies on a line with two
//! neighbours on one side of it; a robot that comes nearer sees the rest.

use crate::beams::Beam;
use nalgebra::{Point2, Vector2};
use zeronav_casts::Cast;

/// How far apart the ends of neighbouring beams on one obstacle may lie, besides [`SAME_SPREADS`]. [m]
const SAME_M: f64 = 0.1;

/// The same in distances between the beams at that range, for surfaces seen at a slant.
const SAME_SPREADS: f64 = 3.0;

/// Largest angle between neighbouring beams; the last and the first beam are neighbours only when
/// the lidar sees all around. [rad]
const NEIGHBOURS_SPREAD_MAX: f64 = 0.3;

/// Distance between neighbouring beams beyond which they do not tell a surface from an edge. [m]
const RESOLVED_M: f64 = 0.06;

/// Beams beside each other that a thing must stop to be an obstacle at first sight.
const BEAMS_MIN: usize = 3;

/// How far a beam's end may lie from the line of two neighbours, and how much of its range besides: the
/// noise of three ranges. [m]
const ON_LINE_M: f64 = 0.05;
const ON_LINE_SHARE: f64 = 0.015;

/// Smallest angle between a beam and a line on which its end can be told to lie. [rad]
const GRAZING_RAD: f64 = 0.03;

/// [s] for which a free cell has to be hit by few beams, in every scan, to become an obstacle.
const ISOLATED_S: f64 = 0.2;

/// What a return tells of a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Evidence {
    /// Something is there: other beams ended on it, too.
    Surface,
    /// Something may be there: no other beam says so.
    Isolated,
    /// Nothing: beams lie too far apart there.
    None,
}

/// What the return of beam `n` tells; nothing when it was not returned.
pub(crate) fn evidence(beams: &[Beam], n: usize) -> Evidence {
    let Some((beam, point)) = beams.get(n).and_then(|beam| Some((beam, beam.point()?))) else {
        return Evidence::None;
    };
    let range_m = (point - beam.origin).norm();
    let spacing_m = [-1, 1]
        .into_iter()
        .filter_map(|side| neighbour(beams, n, side))
        .map(|other| (other.direction - beam.direction).norm() * range_m)
        .fold(f64::INFINITY, f64::min);
    let near = |other: &Beam, from: Point2<f64>| {
        let gap_m = SAME_M + SAME_SPREADS * spacing_m;
        other.point().filter(|end| (end - from).norm() <= gap_m)
    };
    if spacing_m.is_infinite() {
        // A single beam has nothing that could speak for it.
        return if beams.len() == 1 {
            Evidence::Surface
        } else {
            Evidence::Isolated
        };
    }
    if spacing_m > RESOLVED_M {
        let lies = |side| {
            on_line(beams, n, side)
                .is_some_and(|off_m| off_m <= ON_LINE_M + ON_LINE_SHARE * range_m)
        };
        return if lies(-1) || lies(1) {
            Evidence::Surface
        } else {
            Evidence::None
        };
    }
    let mut found = 1;
    for side in [-1, 1] {
        let mut from = point;
        let mut offset = 0;
        for _ in 1..BEAMS_MIN {
            offset += side;
            let Some(end) = neighbour(beams, n, offset).and_then(|other| near(other, from)) else {
                break;
            };
            from = end;
            found += 1;
        }
    }
    if found >= BEAMS_MIN {
        Evidence::Surface
    } else {
        Evidence::Isolated
    }
}

/// How far along beam `n` its end lies from the line through the ends of its two neighbours on a side;
/// `None` when there is none that it could be told of. [m]
fn on_line(beams: &[Beam], n: usize, side: isize) -> Option<f64> {
    let (beam, end) = (&beams[n], beams[n].point()?);
    let first = neighbour(beams, n, side)?.point()?;
    let second = neighbour(beams, n, 2 * side)?.point()?;
    let along = (second - first).try_normalize(1.0e-9)?;
    let across = Vector2::new(-along.y, along.x);
    let slope = beam.direction.dot(&across);
    (slope.abs() > GRAZING_RAD).then(|| ((first - end).dot(&across) / slope).abs())
}

/// The beam so many beside beam `n`, when it looks to its side: within a few steps of
/// [`NEIGHBOURS_SPREAD_MAX`].
fn neighbour(beams: &[Beam], n: usize, offset: isize) -> Option<&Beam> {
    let count = isize::try_from(beams.len()).ok()?;
    let at = (isize::try_from(n).ok()? + offset).rem_euclid(count);
    let at = usize::try_from(at).ok().filter(|at| *at != n)?;
    let other = beams.get(at)?;
    let spread_max = NEIGHBOURS_SPREAD_MAX * offset.unsigned_abs().to_f64();
    let spread = (other.direction - beams[n].direction).norm();
    (spread < spread_max).then_some(other)
}

/// By how much a hit of few beams, `since_s` after the scan before [s], leads from free to the threshold, which is
/// `whole` away: at most half of it.
pub(crate) fn isolated_hit(whole: i16, since_s: f64) -> i16 {
    let half = (whole / 2).max(1);
    if since_s <= 0.0 {
        return half;
    }
    (f64::from(whole) * since_s / ISOLATED_S)
        .ceil()
        .clamp(1.0, f64::from(half))
        .to_i16()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beams::{Beams, Sweep};
    use zeronav_msgs::Pose;
    use zeronav_msgs::scan::Scan;

    /// What the returns of a lidar with a beam per degree tell, by beam.
    fn told(range_m: impl Fn(usize) -> f64) -> Vec<Evidence> {
        let scan = Scan {
            n_beams: 360,
            angle_min_rad: 0.0,
            angle_increment_rad: core::f32::consts::TAU / 360.0,
            range_m_min: 0.1,
            range_m_max: 15.0,
            ..Scan::default()
        };
        let ranges: Vec<f32> = (0..360).map(|n| range_m(n).to_f32()).collect();
        let mut beams = Beams::default();
        beams.cast(&scan, &ranges, &Sweep::still(Pose::default()));
        (0..360).map(|n| evidence(beams.as_slice(), n)).collect()
    }

    fn wall_m(n: usize, ahead_m: f64) -> f64 {
        let angle = n.to_f64().to_radians();
        if angle.cos() > 0.1 {
            ahead_m / angle.cos()
        } else {
            f64::INFINITY
        }
    }

    #[test]
    fn a_wall_is_a_surface_near_and_far() {
        for ahead_m in [0.4, 2.0, 10.0] {
            let told = told(|n| wall_m(n, ahead_m));
            for n in (0..45).chain(316..360) {
                assert_eq!(told[n], Evidence::Surface, "{ahead_m} m, beam {n}");
            }
        }
    }

    /// The beam beside the edge of a far door, between the wall and what is behind it.
    #[test]
    fn a_mixed_return_at_a_far_edge_tells_nothing() {
        for mixed_m in [10.6, 11.5, 13.0] {
            let told = told(|n| match n {
                10 => mixed_m,
                11..14 => wall_m(n, 14.0),
                _ => wall_m(n, 10.0),
            });
            assert_eq!(told[9], Evidence::Surface);
            assert_eq!(told[10], Evidence::None, "{mixed_m} m");
            assert_eq!(told[14], Evidence::Surface);
        }
    }

    #[test]
    fn what_is_thinner_than_a_post_has_to_be_seen_again() {
        // A drop of rain at 0.4 m, two neighbours by chance at 0.3 m, a post of 5 cm at 1 m, of 3 cm at 0.4 m.
        let told = told(|n| match n {
            10 | 300..304 => 0.4,
            100 | 101 => 0.3,
            200..203 => 1.0,
            _ => 5.0,
        });
        for n in [10, 100, 101] {
            assert_eq!(told[n], Evidence::Isolated, "beam {n}");
        }
        for n in [200, 201, 202, 300, 301, 302, 303] {
            assert_eq!(told[n], Evidence::Surface, "beam {n}");
        }
    }

    #[test]
    fn few_beams_need_three_scans_and_as_many_as_there_are_in_a_fifth_of_a_second() {
        let whole = 40;
        for (since_s, scans) in [(0.0, 3), (0.2, 3), (0.1, 3), (0.05, 5), (0.025, 9)] {
            let hit = isolated_hit(whole, since_s);
            assert_eq!(1 + (whole + hit - 1) / hit, scans, "{since_s} s");
        }
    }
}
