//! A scan as rays of one frame, each from where the laser was when it looked.
//!
//! A lidar that turns while the robot drives sees every beam from another pose. Between the first
//! and the last beam of a turn the laser's pose is taken as linear in time, which is right up to
//! the accelerations within one turn.

use nalgebra::{Point2, Vector2};
use zeronav_casts::Cast;
use zeronav_msgs::Pose;
use zeronav_msgs::pose::wrap_angle;
use zeronav_msgs::scan::{BeamDirections, Scan};

/// Where the laser was during a turn, in the frame that the beams shall be in.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sweep {
    /// `frame_from_laser` at beam 0.
    pub first: Pose,
    /// `frame_from_laser` at the last beam.
    pub last: Pose,
}

impl Sweep {
    /// All beams at once.
    #[must_use]
    pub const fn still(frame_from_laser: Pose) -> Self {
        Self {
            first: frame_from_laser,
            last: frame_from_laser,
        }
    }

    /// The same in the frame in which the other one lies at `other_from_frame`.
    #[must_use]
    pub(crate) fn seen_from(&self, other_from_frame: &Pose) -> Self {
        Self {
            first: other_from_frame.then(&self.first),
            last: other_from_frame.then(&self.last),
        }
    }

    /// `frame_from_laser` after a share, 0 to 1, of the turn.
    pub(crate) fn at(&self, share: f64) -> Pose {
        let shift = (self.last.point() - self.first.point()) * share;
        let turn_rad = wrap_angle(self.last.yaw_rad - self.first.yaw_rad) * share;
        Pose::new(
            self.first.x_m + shift.x,
            self.first.y_m + shift.y,
            self.first.yaw_rad + turn_rad,
        )
    }
}

/// How a beam ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum End {
    /// Returned from here. [m]
    Hit(f64),
    /// Nothing up to here, the sensor's range. [m]
    NoReturn(f64),
    /// Says nothing: NaN, or a number outside the sensor's range.
    Invalid,
}

/// One beam.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beam {
    /// Where the laser was. [m]
    pub origin: Point2<f64>,
    /// Where it looked, of length 1.
    pub direction: Vector2<f64>,
    /// How it ended.
    pub end: End,
}

impl Beam {
    /// Where it was returned from; `None` when it was not. [m]
    #[must_use]
    #[inline]
    pub fn point(&self) -> Option<Point2<f64>> {
        match self.end {
            End::Hit(range_m) => Some(self.origin + self.direction * range_m),
            End::NoReturn(_) | End::Invalid => None,
        }
    }
}

/// The beams of a scan, in its order. Memory is reused.
#[derive(Debug, Default)]
pub struct Beams {
    cast: Vec<Beam>,
    sweep: Sweep,
    directions: BeamDirections,
    increment_rad: f64,
    full_turn: bool,
}

impl Beams {
    /// Takes in a scan that was checked against [`Scan::check`].
    pub fn cast(&mut self, scan: &Scan, ranges: &[f32], sweep: &Sweep) {
        self.increment_rad = f64::from(scan.angle_increment_rad).abs();
        let fan_rad = self.increment_rad * (ranges.len().to_f64() + 0.5);
        self.full_turn = fan_rad >= core::f64::consts::TAU;
        self.cast.clear();
        self.sweep = *sweep;
        let directions = self.directions.of(scan).iter().zip(ranges);
        if sweep.first == sweep.last {
            let (sin, cos) = sweep.last.yaw_rad.sin_cos();
            let origin = sweep.last.point();
            self.cast
                .extend(directions.map(|(direction, range_m)| Beam {
                    origin,
                    direction: rotated(direction, sin, cos),
                    end: end_of(scan, *range_m),
                }));
            return;
        }
        let turn_rad = wrap_angle(sweep.last.yaw_rad - sweep.first.yaw_rad);
        let shift = sweep.last.point() - sweep.first.point();
        let steps = ranges.len().saturating_sub(1).max(1).to_f64();
        self.cast.extend(
            directions
                .zip(0_u32..)
                .map(|((direction, range_m), number)| {
                    let share = f64::from(number) / steps;
                    let (sin, cos) = (sweep.first.yaw_rad + share * turn_rad).sin_cos();
                    Beam {
                        origin: sweep.first.point() + shift * share,
                        direction: rotated(direction, sin, cos),
                        end: end_of(scan, *range_m),
                    }
                }),
        );
    }

    /// The beams, in the order of the scan.
    #[must_use]
    pub fn as_slice(&self) -> &[Beam] {
        &self.cast
    }

    /// Where the laser was while it took them, in their frame.
    #[must_use]
    pub(crate) fn sweep(&self) -> &Sweep {
        &self.sweep
    }

    /// Angle from beam to beam, >= 0. [rad]
    #[must_use]
    pub fn increment_rad(&self) -> f64 {
        self.increment_rad
    }

    /// True when the first beam is the last one's neighbour.
    #[must_use]
    pub fn full_turn(&self) -> bool {
        self.full_turn
    }
}

fn rotated(direction: &Vector2<f64>, sin: f64, cos: f64) -> Vector2<f64> {
    Vector2::new(
        cos * direction.x - sin * direction.y,
        sin * direction.x + cos * direction.y,
    )
}

fn end_of(scan: &Scan, range_m: f32) -> End {
    if range_m == f32::INFINITY {
        End::NoReturn(f64::from(scan.range_m_max))
    } else if scan.is_hit(range_m) {
        End::Hit(f64::from(range_m))
    } else {
        End::Invalid
    }
}

/// True for a beam that ended where beams count.
pub(crate) fn is_near(beam: &Beam, range_m_max: f64) -> bool {
    matches!(beam.end, End::Hit(range_m) if range_m <= range_m_max)
}

/// Every how many beams one is looked at, for about `n_max` of them.
pub(crate) fn every_nth(beams: &[Beam], n_max: usize) -> usize {
    beams.len().div_ceil(n_max).max(1)
}

/// Puts the ends that stand, of every n-th beam that ended no farther than `range_m_max`, in place of those in `at` [m],
/// and which share of the scan was still to come in place of those in `ago`. How many ended.
pub(crate) fn ends_of(
    beams: &[Beam],
    every: usize,
    range_m_max: f64,
    (at, ago): (&mut Vec<Point2<f64>>, &mut Vec<f64>),
    stands: impl Fn(&Point2<f64>) -> bool,
) -> usize {
    let steps = beams.len().saturating_sub(1).max(1).to_f64();
    at.clear();
    ago.clear();
    let mut n_ends = 0;
    for (n, beam) in beams.iter().enumerate().step_by(every) {
        // What lies beyond is on no map.
        let Some(end) = is_near(beam, range_m_max).then(|| beam.point()).flatten() else {
            continue;
        };
        n_ends += 1;
        if stands(&end) {
            at.push(end);
            ago.push(1.0 - n.to_f64() / steps);
        }
    }
    n_ends
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scan(n_beams: u32) -> Scan {
        Scan {
            n_beams,
            angle_min_rad: -1.0,
            angle_increment_rad: 0.01,
            range_m_min: 0.1,
            range_m_max: 10.0,
            ..Scan::default()
        }
    }

    #[test]
    fn ends_are_told_apart() {
        let mut beams = Beams::default();
        let ranges = [2.0, f32::INFINITY, f32::NAN, 0.05, 10.5];
        beams.cast(&scan(5), &ranges, &Sweep::still(Pose::new(1.0, 2.0, 1.0)));
        let ends: Vec<End> = beams.as_slice().iter().map(|beam| beam.end).collect();
        assert_eq!(
            ends,
            [
                End::Hit(2.0),
                End::NoReturn(10.0),
                End::Invalid,
                End::Invalid,
                End::Invalid
            ]
        );
        // Beam 0 looks along -1 rad in the laser, along 0 in the frame.
        let point = beams.as_slice()[0].point().expect("a hit");
        assert!((point - Point2::new(3.0, 2.0)).norm() < 1e-7, "{point}");
    }

    /// A laser that drives and turns during its turn sees a straight wall straight.
    #[test]
    fn a_wall_stays_straight_while_the_robot_drives_and_turns() {
        let n = 101;
        let at = |number: u32| {
            let share = f64::from(number) / f64::from(n - 1);
            Pose::new(0.7 * share, -0.2 * share, 0.5 * share)
        };
        let scan = scan(n);
        let mut ranges = Vec::new();
        for number in 0..n {
            let pose = at(number);
            let angle = pose.yaw_rad + scan.angle_of(number as usize);
            // The wall is x = 4.
            ranges.push(((4.0 - pose.x_m) / angle.cos()).to_f32());
        }
        let mut beams = Beams::default();
        let sweep = Sweep {
            first: at(0),
            last: at(n - 1),
        };
        beams.cast(&scan, &ranges, &sweep);
        for beam in beams.as_slice() {
            let point = beam.point().expect("a hit");
            assert!((point.x - 4.0).abs() < 1e-5, "{point}");
        }
        // Taken as if all beams were taken at once, the wall bends by decimetres.
        beams.cast(&scan, &ranges, &Sweep::still(at(n - 1)));
        let bent = beams
            .as_slice()
            .iter()
            .filter_map(Beam::point)
            .map(|point| (point.x - 4.0).abs())
            .fold(0.0, f64::max);
        assert!(bent > 0.3, "{bent}");
    }
}
