//! A point with constant velocity, filtered (Kalman, "A New Approach to Linear Filtering and
//! Prediction Problems", 1960).

use nalgebra::{Matrix2, Matrix2x4, Matrix4, Point2, Vector2, Vector4};

/// State (x, y, vx, vy) and its covariance. [m, m/s]
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ConstantVelocity {
    state: Vector4<f64>,
    covariance: Matrix4<f64>,
}

impl ConstantVelocity {
    /// At `position`, with covariance `measured`; the velocity is 0, known to `speed_sigma_mps`.
    #[must_use]
    pub(crate) fn new(
        position: Point2<f64>,
        measured: &Matrix2<f64>,
        speed_sigma_mps: f64,
    ) -> Self {
        let mut covariance = Matrix4::zeros();
        covariance.fixed_view_mut::<2, 2>(0, 0).copy_from(measured);
        let speed_variance = speed_sigma_mps * speed_sigma_mps;
        covariance
            .fixed_view_mut::<2, 2>(2, 2)
            .fill_diagonal(speed_variance);
        Self {
            state: Vector4::new(position.x, position.y, 0.0, 0.0),
            covariance,
        }
    }

    /// At `position` with `velocity`, both exact. [m, m/s]
    #[must_use]
    pub(crate) fn exact(position: Point2<f64>, velocity: Vector2<f64>) -> Self {
        Self {
            state: Vector4::new(position.x, position.y, velocity.x, velocity.y),
            covariance: Matrix4::zeros(),
        }
    }

    /// `dt_s` later. The acceleration of each axis is white noise whose integral over a second has
    /// the variance `acceleration_m2ps3`, in whatever steps that second passes.
    pub(crate) fn predict(&mut self, dt_s: f64, acceleration_m2ps3: f64) {
        let mut step = Matrix4::identity();
        step[(0, 2)] = dt_s;
        step[(1, 3)] = dt_s;
        let mut noise = Matrix4::zeros();
        for (at, speed) in [(0, 2), (1, 3)] {
            noise[(at, at)] = dt_s.powi(3) / 3.0 * acceleration_m2ps3;
            noise[(at, speed)] = dt_s * dt_s / 2.0 * acceleration_m2ps3;
            noise[(speed, at)] = noise[(at, speed)];
            noise[(speed, speed)] = dt_s * acceleration_m2ps3;
        }
        self.state = step * self.state;
        self.covariance = step * self.covariance * step.transpose() + noise;
    }

    /// Squared Mahalanobis distance of a measured position with covariance `measured`; chi-squared
    /// with two degrees of freedom when it belongs here. `None` when nothing can be said.
    #[must_use]
    pub(crate) fn distance(&self, position: Point2<f64>, measured: &Matrix2<f64>) -> Option<f64> {
        let innovation = position - self.position();
        let inverse = (self.position_covariance() + measured).try_inverse()?;
        Some((innovation.transpose() * inverse * innovation)[(0, 0)])
    }

    /// Takes in a measured position with covariance `measured`.
    pub(crate) fn update(&mut self, position: Point2<f64>, measured: &Matrix2<f64>) {
        let look = Matrix2x4::new(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0);
        let Some(inverse) = (self.position_covariance() + measured).try_inverse() else {
            return;
        };
        let gain = self.covariance * look.transpose() * inverse;
        self.state += gain * (position - self.position());
        let left = Matrix4::identity() - gain * look;
        // Joseph's form stays symmetric and positive.
        self.covariance =
            left * self.covariance * left.transpose() + gain * measured * gain.transpose();
    }

    /// Puts it elsewhere, as when what is taken for its centre changes; the velocity stays.
    pub(crate) fn place(&mut self, position: Point2<f64>) {
        self.state[0] = position.x;
        self.state[1] = position.y;
    }

    /// Where it is. [m]
    #[must_use]
    pub(crate) fn position(&self) -> Point2<f64> {
        Point2::new(self.state[0], self.state[1])
    }

    /// How it moves. [m/s]
    #[must_use]
    pub(crate) fn velocity(&self) -> Vector2<f64> {
        Vector2::new(self.state[2], self.state[3])
    }

    /// Standard deviation of the speed along the velocity. [m/s]
    #[must_use]
    pub(crate) fn speed_sigma_mps(&self) -> f64 {
        let velocity = self.velocity();
        let along = velocity.try_normalize(1.0e-9).unwrap_or(Vector2::x());
        let covariance = self.covariance.fixed_view::<2, 2>(2, 2).into_owned();
        (along.transpose() * covariance * along)[(0, 0)]
            .max(0.0)
            .sqrt()
    }

    fn position_covariance(&self) -> Matrix2<f64> {
        self.covariance.fixed_view::<2, 2>(0, 0).into_owned()
    }

    /// Covariance of (x, y, vx, vy), upper triangle by rows. [m^2, m^2/s, m^2/s^2]
    #[must_use]
    pub(crate) fn upper_triangle(&self) -> [f64; 10] {
        let c = &self.covariance;
        [
            c[(0, 0)],
            c[(0, 1)],
            c[(0, 2)],
            c[(0, 3)],
            c[(1, 1)],
            c[(1, 2)],
            c[(1, 3)],
            c[(2, 2)],
            c[(2, 3)],
            c[(3, 3)],
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_noiseless_walker_is_found_out() {
        let at = |t: f64| Point2::new(1.0 + 1.2 * t, 2.0 - 0.4 * t);
        let measured = Matrix2::from_diagonal_element(0.03 * 0.03);
        let mut filter = ConstantVelocity::new(at(0.0), &measured, 1.5);
        for n in 1..=8_u32 {
            filter.predict(0.1, 0.1);
            assert!(filter.distance(at(0.1 * f64::from(n)), &measured).unwrap() < 9.21);
            filter.update(at(0.1 * f64::from(n)), &measured);
        }
        assert!((filter.velocity() - Vector2::new(1.2, -0.4)).norm() < 0.05);
        assert!((filter.position() - at(0.8)).norm() < 0.01);
        assert!((0.05..0.25).contains(&filter.speed_sigma_mps()));
        // Half a metre beside is another obstacle.
        filter.predict(0.1, 0.1);
        let beside = at(0.9) + Vector2::new(0.0, 0.5);
        assert!(filter.distance(beside, &measured).unwrap() > 50.0);
    }

    /// Against the closed form of a scalar filter: with one axis measured once, the variances are
    /// those of a weighted mean.
    #[test]
    fn one_update_is_a_weighted_mean() {
        let begun = Matrix2::from_diagonal_element(0.2 * 0.2);
        let mut filter = ConstantVelocity::new(Point2::new(0.0, 0.0), &begun, 1.0);
        let measured = Matrix2::from_diagonal_element(0.1 * 0.1);
        filter.update(Point2::new(1.0, -1.0), &measured);
        let gain = 0.04 / (0.04 + 0.01);
        assert!((filter.position() - Point2::new(gain, -gain)).norm() < 1e-12);
        assert!((filter.upper_triangle()[0] - 0.04 * 0.01 / 0.05).abs() < 1e-12);
    }
}
