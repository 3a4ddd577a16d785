//! What the track that was really driven says: points `[x, y]` every 5 cm [m], or rows in time.

/// Chords over which directions are compared: shorter ones would measure the spacing of the
/// points. [m]
const CHORD_M: f64 = 0.2;

/// Smallest distance of the track to a point, `None` without a track. [m]
#[must_use]
pub(super) fn closest_m(track: &[[f64; 2]], to: [f64; 2]) -> Option<f64> {
    let first = track.first()?;
    let start = (first[0] - to[0]).hypot(first[1] - to[1]);
    let on_segment = |ends: &[[f64; 2]]| {
        let (a, b) = (ends[0], ends[1]);
        let along = [b[0] - a[0], b[1] - a[1]];
        let length2 = along[0] * along[0] + along[1] * along[1];
        let share = if length2 > 0.0 {
            let dot = (to[0] - a[0]) * along[0] + (to[1] - a[1]) * along[1];
            (dot / length2).clamp(0.0, 1.0)
        } else {
            0.0
        };
        (a[0] + share * along[0] - to[0]).hypot(a[1] + share * along[1] - to[1])
    };
    Some(track.windows(2).map(on_segment).fold(start, f64::min))
}

/// The clock of BARN: it starts when the robot has really left its start and stops when its centre
/// really is at the goal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Clock {
    /// The goal. [m]
    pub(super) goal_m: [f64; 2],
    /// How near counts. [m]
    pub(super) tolerance_m: f64,
}

impl Clock {
    /// Way after which it starts. [m]
    const LEFT_M: f64 = 0.1;

    /// Time from start to stop of a motion in rows of time [s], x [m], y [m] and more; `None` when
    /// it did not start or did not stop. [s]
    #[must_use]
    pub(super) fn time_s(&self, motion: &[[f64; 6]]) -> Option<f64> {
        let [_, x0, y0, ..] = *motion.first()?;
        let far_m = |row: &[f64; 6], from: [f64; 2]| (row[1] - from[0]).hypot(row[2] - from[1]);
        let left = motion
            .iter()
            .find(|row| far_m(row, [x0, y0]) > Self::LEFT_M)?;
        let there = motion
            .iter()
            .find(|row| far_m(row, self.goal_m) <= self.tolerance_m)?;
        Some(there[0] - left[0])
    }
}

/// Sum of the changes of direction from chord to chord of [`CHORD_M`] or a little more, without
/// sign. Turns on the spot leave no track and are not in it. [rad]
#[must_use]
pub(super) fn turning_rad(track: &[[f64; 2]]) -> f64 {
    let Some(mut from) = track.first().copied() else {
        return 0.0;
    };
    let mut direction: Option<f64> = None;
    let mut turning_rad = 0.0;
    for point in track {
        let along = [point[0] - from[0], point[1] - from[1]];
        if along[0].hypot(along[1]) < CHORD_M {
            continue;
        }
        let new = along[1].atan2(along[0]);
        if let Some(old) = direction {
            turning_rad += zeronav_msgs::pose::wrap_angle(new - old).abs();
        }
        direction = Some(new);
        from = *point;
    }
    turning_rad
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::{FRAC_PI_2, TAU};

    #[test]
    fn the_closest_point_may_lie_between_two_points_of_the_track() {
        let track = [[0.0, 0.0], [4.0, 0.0]];
        assert!((closest_m(&track, [1.0, 0.5]).unwrap() - 0.5).abs() < 1e-12);
        assert!((closest_m(&track, [7.0, 4.0]).unwrap() - 5.0).abs() < 1e-12);
        assert!((closest_m(&track[..1], [3.0, 4.0]).unwrap() - 5.0).abs() < 1e-12);
        assert_eq!(closest_m(&[], [1.0, 0.5]), None);
    }

    #[test]
    fn the_clock_runs_from_the_first_decimetre_to_the_tolerance() {
        let row = |t: f64, x: f64| [t, x, 0.0, 0.0, 0.0, 0.0];
        let motion = [
            row(0.0, 0.0),
            row(0.5, 0.1),
            row(0.6, 0.2),
            row(3.0, 4.0),
            row(4.0, 4.5),
        ];
        let clock = |goal_x| Clock {
            goal_m: [goal_x, 0.0],
            tolerance_m: 1.0,
        };
        assert!((clock(5.0).time_s(&motion).unwrap() - 2.4).abs() < 1e-12);
        assert_eq!(clock(9.0).time_s(&motion), None);
        assert_eq!(clock(5.0).time_s(&motion[..2]), None);
        assert_eq!(clock(5.0).time_s(&[]), None);
    }

    #[test]
    fn a_circle_turns_once_around_and_a_straight_line_not_at_all() {
        let straight: Vec<[f64; 2]> = (0..100).map(|i| [0.05 * f64::from(i), 1.0]).collect();
        assert!(turning_rad(&straight).abs() < 1e-9);
        let circle: Vec<[f64; 2]> = (0..=628)
            .map(|i| 0.01 * f64::from(i))
            .map(|angle| [5.0 * angle.cos(), 5.0 * angle.sin()])
            .collect();
        let turned = turning_rad(&circle);
        // One chord of 0.2 m is 0.04 rad; the first has nothing before it.
        assert!((TAU - 0.1..TAU + 1e-9).contains(&turned), "{turned}");
        // Left and right both count.
        let steps = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [2.0, 1.0]];
        assert!((turning_rad(&steps) - 2.0 * FRAC_PI_2).abs() < 1e-12);
    }
}
