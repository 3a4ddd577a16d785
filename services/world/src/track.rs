//! A path in time: where something is that passes given points at given moments.

use crate::error::{SpecError, number};
use crate::shape::point;
use nalgebra::Point2;

/// Longest time that a track may name. [s]
const TIME_S_MAX: f64 = 1.0e6;

/// Most rows of one track.
pub const ROWS_MAX: usize = 65_536;

/// A path in time, straight from row to row.
#[derive(Debug, Clone, PartialEq)]
pub struct Track {
    /// `[t, x, y]`, the times increase.
    rows: Vec<[f64; 3]>,
    repeat: bool,
    from_s: f64,
}

impl Track {
    /// A track of rows `[t, x, y]` that [`Self::check`] accepts. [s, m, m] Its time 0 is `from_s`
    /// of the rows; with `repeat` the last row is followed by the first, at once.
    #[must_use]
    pub fn new(rows: &[[f64; 3]], repeat: bool, from_s: f64) -> Self {
        Self {
            rows: rows.to_vec(),
            repeat,
            from_s,
        }
    }

    /// Accepts two rows and more, with finite numbers and increasing times.
    ///
    /// # Errors
    /// The first row that is wrong, as `[row]`.
    pub fn check(rows: &[[f64; 3]]) -> Result<(), SpecError> {
        if !(2..=ROWS_MAX).contains(&rows.len()) {
            let why = format!("needs 2 to {ROWS_MAX} rows, not {}", rows.len());
            return Err(SpecError::new("", why));
        }
        let mut last_s = f64::NEG_INFINITY;
        for (index, [t_s, x, y]) in rows.iter().enumerate() {
            let place = format!("[{index}]");
            number(*t_s, -TIME_S_MAX, TIME_S_MAX, &format!("{place}[0]"))?;
            point([*x, *y], &place)?;
            if *t_s <= last_s {
                let why = format!("{t_s} s is not after the row before, {last_s} s");
                return Err(SpecError::new(format!("{place}[0]"), why));
            }
            last_s = *t_s;
        }
        Ok(())
    }

    /// Where it is `t_s` after its time 0: before the first row there, after the last there.
    #[must_use]
    pub fn at(&self, t_s: f64) -> Point2<f64> {
        let t_s = self.wrapped(t_s + self.from_s);
        let next = self.rows.partition_point(|row| row[0] <= t_s);
        match (
            next.checked_sub(1).and_then(|i| self.rows.get(i)),
            self.rows.get(next),
        ) {
            (Some([t0, x0, y0]), Some([t1, x1, y1])) => {
                let along = (t_s - t0) / (t1 - t0);
                Point2::new(x0 + (x1 - x0) * along, y0 + (y1 - y0) * along)
            }
            (Some([_, x, y]), None) | (None, Some([_, x, y])) => Point2::new(*x, *y),
            (None, None) => Point2::origin(),
        }
    }

    /// Fastest stretch. [m/s] Jumps are none.
    #[must_use]
    pub fn speed_mps_max(&self) -> f64 {
        self.rows
            .windows(2)
            .map(|pair| {
                let ([t0, x0, y0], [t1, x1, y1]) = (pair[0], pair[1]);
                (x1 - x0).hypot(y1 - y0) / (t1 - t0)
            })
            .fold(0.0, f64::max)
    }

    /// The first moment after `t_s` at which it jumps from the last row to the first; `None` when
    /// it never does. [s]
    #[must_use]
    pub fn next_jump_s(&self, t_s: f64) -> Option<f64> {
        let (first, last) = (self.rows.first()?, self.rows.last()?);
        let jumps = self.repeat && (first[1] - last[1]).hypot(first[2] - last[2]) > 1.0e-9;
        jumps.then(|| {
            let period_s = last[0] - first[0];
            let into_s = (t_s + self.from_s - first[0]).rem_euclid(period_s);
            t_s + (period_s - into_s)
        })
    }

    fn wrapped(&self, t_s: f64) -> f64 {
        match (self.rows.first(), self.rows.last()) {
            (Some([first_s, ..]), Some([last_s, ..])) if self.repeat => {
                first_s + (t_s - first_s).rem_euclid(last_s - first_s)
            }
            _ => t_s,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROWS: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [3.0, 4.0, 0.0], [4.0, 4.0, 3.0]];

    #[track_caller]
    fn check(track: &Track, t_s: f64, x: f64, y: f64) {
        let at = track.at(t_s);
        assert!((at - Point2::new(x, y)).norm() < 1e-9, "{at} at {t_s} s");
    }

    #[test]
    fn rows_are_passed_at_their_times_and_the_ends_held() {
        let track = Track::new(&ROWS, false, 0.0);
        check(&track, -5.0, 0.0, 0.0);
        check(&track, 2.0, 2.0, 0.0);
        check(&track, 3.5, 4.0, 1.5);
        check(&track, 99.0, 4.0, 3.0);
        assert!((track.speed_mps_max() - 3.0).abs() < 1e-12);
        assert_eq!(track.next_jump_s(0.0), None);
    }

    #[test]
    fn a_round_jumps_back_to_its_first_row() {
        let track = Track::new(&ROWS, true, 2.0);
        check(&track, 0.0, 2.0, 0.0);
        check(&track, 1.5, 4.0, 1.5);
        let jump_s = track.next_jump_s(0.0).unwrap();
        assert!((jump_s - 2.0).abs() < 1e-12);
        check(&track, jump_s - 1e-10, 4.0, 3.0);
        check(&track, jump_s, 0.0, 0.0);
        assert!((track.next_jump_s(jump_s).unwrap() - 5.0).abs() < 1e-12);
        check(&track, 300.5, 3.0, 0.0);
    }

    #[test]
    fn rows_that_cannot_be_are_refused() {
        let refused = |rows: &[[f64; 3]]| Track::check(rows).unwrap_err().field;
        assert_eq!(Track::check(&ROWS), Ok(()));
        assert_eq!(refused(&ROWS[..1]), "");
        assert_eq!(refused(&[ROWS[1], ROWS[0]]), "[1][0]");
        assert_eq!(refused(&[ROWS[0], [2.0, f64::NAN, 0.0]]), "[1][0]");
        assert_eq!(refused(&[[f64::INFINITY, 0.0, 0.0], ROWS[0]]), "[0][0]");
    }
}
