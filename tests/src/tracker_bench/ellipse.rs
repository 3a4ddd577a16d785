//! Whether the truth lies where a track's covariance says.

use nalgebra::{Matrix2, Point2, Vector2};
use zeronav_msgs::obstacles::Obstacle;

/// Where a track will be when it goes on straight. [m]
pub(super) fn place(track: &Obstacle, ahead_s: f64) -> Point2<f64> {
    Point2::new(
        track.x_m + track.vx_mps * ahead_s,
        track.y_m + track.vy_mps * ahead_s,
    )
}

/// Covariance of [`place`], from the published one alone. [m^2]
pub(super) fn covariance(track: &Obstacle, ahead_s: f64) -> Matrix2<f64> {
    let [xx, xy, xvx, xvy, yy, yvx, yvy, vxvx, vxvy, vyvy] = track.covariance;
    let (h, h2) = (ahead_s, ahead_s * ahead_s);
    let mixed = xy + h * (xvy + yvx) + h2 * vxvy;
    Matrix2::new(
        xx + 2.0 * h * xvx + h2 * vxvx,
        mixed,
        mixed,
        yy + 2.0 * h * yvy + h2 * vyvy,
    )
}

/// Squared distance of the truth from a track, in standard deviations of the direction; infinite
/// without a covariance.
pub(super) fn distance2(track: &Obstacle, ahead_s: f64, truth: Point2<f64>) -> f64 {
    let off: Vector2<f64> = truth - place(track, ahead_s);
    let inverse = covariance(track, ahead_s).try_inverse();
    inverse.map_or(f64::INFINITY, |inverse| {
        (off.transpose() * inverse * off)[(0, 0)]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track() -> Obstacle {
        Obstacle {
            x_m: 1.0,
            y_m: 2.0,
            vx_mps: 0.5,
            vy_mps: -1.0,
            covariance: [0.04, 0.01, 0.02, -0.01, 0.09, 0.005, 0.03, 0.25, 0.02, 0.16],
            ..Obstacle::default()
        }
    }

    /// Against the product of the matrices, written out by hand for 2 s.
    #[test]
    fn the_covariance_is_carried_along_the_velocity() {
        let ahead = covariance(&track(), 2.0);
        let expected = Matrix2::new(
            0.04 + 4.0 * 0.02 + 4.0 * 0.25,
            0.01 + 2.0 * (-0.01 + 0.005) + 4.0 * 0.02,
            0.01 + 2.0 * (-0.01 + 0.005) + 4.0 * 0.02,
            0.09 + 4.0 * 0.03 + 4.0 * 0.16,
        );
        assert!((ahead - expected).norm() < 1e-12, "{ahead}");
        assert!((place(&track(), 2.0) - Point2::new(2.0, 0.0)).norm() < 1e-12);
    }

    #[test]
    fn one_standard_deviation_away_is_a_distance_of_one() {
        let mut round = track();
        round.covariance = [0.04, 0.0, 0.0, 0.0, 0.01, 0.0, 0.0, 0.0, 0.0, 0.0];
        let at = |x: f64, y: f64| distance2(&round, 0.0, Point2::new(x, y));
        assert!((at(1.2, 2.0) - 1.0).abs() < 1e-9 && (at(1.0, 1.8) - 4.0).abs() < 1e-9);
        round.covariance = [0.0; 10];
        assert!(distance2(&round, 0.0, Point2::new(1.0, 2.0)).is_infinite());
    }
}
