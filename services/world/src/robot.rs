//! A robot that can exist: what its numbers must be.

use crate::error::{SpecError, number};
use crate::faults::FAULTS_MAX;
use crate::footprint::Footprint;
use crate::robot_spec::{LidarSpec, OdometrySpec, RobotSpec, SlipSpec};
use core::f64::consts::{PI, TAU};
use zeronav_msgs::scan::BEAMS_MAX;

/// Largest speed, acceleration or rate that a robot may have, in its SI unit.
const RATE_MAX: f64 = 1.0e3;

/// Smallest positive one.
const RATE_MIN: f64 = 1.0e-3;

impl RobotSpec {
    /// Accepts robots that can exist.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self) -> Result<(), SpecError> {
        Footprint::new(self)?;
        number(self.v_mps_max, RATE_MIN, RATE_MAX, "v_mps_max")?;
        number(self.v_mps_min, -RATE_MAX, 0.0, "v_mps_min")?;
        number(self.w_radps_max, RATE_MIN, RATE_MAX, "w_radps_max")?;
        number(self.a_mps2_max, RATE_MIN, RATE_MAX, "a_mps2_max")?;
        number(self.reliable_brake_mps2(), RATE_MIN, RATE_MAX, "brake_mps2")?;
        number(
            self.alpha_radps2_max,
            RATE_MIN,
            RATE_MAX,
            "alpha_radps2_max",
        )?;
        number(self.command_timeout_s, 0.01, 10.0, "command_timeout_s")?;
        number(self.actuation_delay_s, 0.0, 1.0, "actuation_delay_s")?;
        if let Some(slip) = &self.slip {
            slip.check().map_err(|error| error.within("slip"))?;
        }
        if let Some(odometry) = &self.odometry {
            odometry.check().map_err(|error| error.within("odometry"))?;
        }
        self.lidar.check().map_err(|error| error.within("lidar"))?;
        if self.faults.len() > FAULTS_MAX {
            let why = format!("{} faults, at most {FAULTS_MAX}", self.faults.len());
            return Err(SpecError::new("faults", why));
        }
        for (index, fault) in self.faults.iter().enumerate() {
            fault
                .check()
                .map_err(|error| error.within(&format!("faults[{index}]")))?;
        }
        Ok(())
    }

    /// Braking that can be relied on: `brake_mps2`, or else `a_mps2_max`. [m/s^2]
    #[must_use]
    pub fn reliable_brake_mps2(&self) -> f64 {
        self.brake_mps2.unwrap_or(self.a_mps2_max)
    }
}

impl SlipSpec {
    /// Accepts slip that leaves some motion.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self) -> Result<(), SpecError> {
        number(self.forward_ratio, 0.0, 0.9, "forward_ratio")?;
        number(self.turn_ratio, 0.0, 0.9, "turn_ratio")?;
        number(self.sigma_ratio, 0.0, 0.9, "sigma_ratio")
    }
}

impl OdometrySpec {
    /// Accepts deviations.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self) -> Result<(), SpecError> {
        number(
            self.distance_per_distance,
            0.0,
            1.0,
            "distance_per_distance",
        )?;
        number(self.distance_per_turn, 0.0, 1.0, "distance_per_turn")?;
        number(self.turn_per_turn, 0.0, 1.0, "turn_per_turn")?;
        number(self.turn_per_distance, 0.0, 1.0, "turn_per_distance")
    }
}

impl LidarSpec {
    /// Direction of beam 0 and the step from beam to beam, counter-clockwise. [rad] `laser`
    /// frame. The field of view is centred on +x; all around, the last beam is one step before
    /// the first.
    #[must_use]
    pub fn directions_rad(&self) -> (f64, f64) {
        let n_beams = f64::from(self.n_beams);
        if self.fov_rad >= TAU - 1.0e-6 {
            (-PI, TAU / n_beams)
        } else {
            (-self.fov_rad / 2.0, self.fov_rad / (n_beams - 1.0).max(1.0))
        }
    }

    /// Accepts lidars that fit a scan message.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self) -> Result<(), SpecError> {
        number(self.pose[0], -100.0, 100.0, "pose[0]")?;
        number(self.pose[1], -100.0, 100.0, "pose[1]")?;
        number(self.pose[2], -TAU, TAU, "pose[2]")?;
        if !(2..=BEAMS_MAX).contains(&(self.n_beams as usize)) {
            let why = format!("must be 2 to {BEAMS_MAX} beams, not {}", self.n_beams);
            return Err(SpecError::new("n_beams", why));
        }
        number(self.fov_rad, 1.0e-3, TAU + 1.0e-6, "fov_rad")?;
        let (_, step_rad) = self.directions_rad();
        if !(1.0e-5..=1.6).contains(&step_rad) {
            let why = format!("beams lie {step_rad:.6} rad apart, must be 0.00001 to 1.6 rad");
            return Err(SpecError::new("n_beams", why));
        }
        number(self.rate_hz, 0.1, RATE_MAX, "rate_hz")?;
        number(self.range_m_min, 0.0, RATE_MAX, "range_m_min")?;
        number(self.range_m_max, 0.01, RATE_MAX, "range_m_max")?;
        if self.range_m_min >= self.range_m_max {
            let why = format!("must be below range_m_max {}", self.range_m_max);
            return Err(SpecError::new("range_m_min", why));
        }
        number(self.sigma_m, 0.0, 10.0, "sigma_m")?;
        number(self.sigma_ratio, 0.0, 1.0, "sigma_ratio")?;
        number(self.quantum_m, 0.0, 1.0, "quantum_m")?;
        number(self.dropout_ratio, 0.0, 1.0, "dropout_ratio")?;
        number(self.short_ratio, 0.0, 1.0, "short_ratio")?;
        number(self.short_mean_m, 1.0e-3, RATE_MAX, "short_mean_m")?;
        number(self.edge_ratio, 0.0, 1.0, "edge_ratio")
    }

    /// Time from beam to beam, 0 when all are taken at once. [s] The mirror turns evenly, also
    /// where it sees nothing.
    #[must_use]
    pub fn beam_period_s(&self) -> f64 {
        if self.motion_distortion {
            self.directions_rad().1 / (TAU * self.rate_hz)
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::faults::{Begin, FaultSpec};

    fn robot() -> RobotSpec {
        RobotSpec::exact(0.25, 1.0, 2.0, LidarSpec::exact(360, 10.0, 0.1..12.0))
    }

    #[track_caller]
    fn refused(field: &str, change: impl FnOnce(&mut RobotSpec)) {
        let mut spec = robot();
        change(&mut spec);
        assert_eq!(spec.check().unwrap_err().field, field);
    }

    #[test]
    fn a_robot_that_can_exist_is_accepted() {
        assert_eq!(robot().check(), Ok(()));
        assert!((robot().reliable_brake_mps2() - 1.0).abs() < 1e-15);
    }

    #[test]
    fn every_number_is_looked_at() {
        refused("radius_m", |r| r.radius_m = None);
        refused("radius_m", |r| r.radius_m = Some(-1.0));
        refused("footprint_m", |r| r.footprint_m = Some(Vec::new()));
        refused("v_mps_max", |r| r.v_mps_max = 0.0);
        refused("v_mps_min", |r| r.v_mps_min = 0.5);
        refused("w_radps_max", |r| r.w_radps_max = f64::NAN);
        refused("a_mps2_max", |r| r.a_mps2_max = -1.0);
        refused("brake_mps2", |r| r.brake_mps2 = Some(0.0));
        refused("alpha_radps2_max", |r| r.alpha_radps2_max = f64::INFINITY);
        refused("command_timeout_s", |r| r.command_timeout_s = 0.0);
        refused("lidar.pose[1]", |r| r.lidar.pose[1] = f64::NAN);
        refused("lidar.n_beams", |r| r.lidar.n_beams = 4097);
        refused("lidar.n_beams", |r| r.lidar.n_beams = 2);
        refused("lidar.fov_rad", |r| r.lidar.fov_rad = 7.0);
        refused("lidar.rate_hz", |r| r.lidar.rate_hz = 0.0);
        refused("lidar.range_m_min", |r| r.lidar.range_m_min = 12.0);
        refused("lidar.range_m_max", |r| r.lidar.range_m_max = -1.0);
        refused("lidar.sigma_m", |r| r.lidar.sigma_m = -0.1);
        refused("lidar.sigma_ratio", |r| r.lidar.sigma_ratio = f64::NAN);
        refused("lidar.quantum_m", |r| r.lidar.quantum_m = -1.0);
        refused("lidar.dropout_ratio", |r| r.lidar.dropout_ratio = 1.1);
        refused("lidar.short_ratio", |r| r.lidar.short_ratio = -0.1);
        refused("lidar.short_mean_m", |r| r.lidar.short_mean_m = 0.0);
        refused("lidar.edge_ratio", |r| r.lidar.edge_ratio = 2.0);
        refused("actuation_delay_s", |r| r.actuation_delay_s = 1.5);
        refused("slip.turn_ratio", |r| {
            r.slip = Some(SlipSpec {
                turn_ratio: 0.95,
                ..SlipSpec::default()
            });
        });
        refused("faults[1].begins.at_s", |r| {
            let frozen = |at_s| FaultSpec::LidarFrozen {
                begins: Begin::at(at_s),
                lasts_s: None,
            };
            r.faults = vec![frozen(1.0), frozen(-1.0)];
        });
        refused("odometry.turn_per_turn", |r| {
            r.odometry = Some(OdometrySpec {
                turn_per_turn: f64::NAN,
                ..OdometrySpec::default()
            });
        });
    }

    #[test]
    fn a_mirror_takes_its_beams_one_after_the_other() {
        let mut lidar = robot().lidar;
        assert!(lidar.beam_period_s().abs() < 1e-15);
        lidar.motion_distortion = true;
        assert!((lidar.beam_period_s() * 360.0 - 0.1).abs() < 1e-12);
        // A quarter of the turn sees nothing.
        lidar.n_beams = 271;
        lidar.fov_rad = 1.5 * PI;
        assert!((lidar.beam_period_s() * 270.0 - 0.075).abs() < 1e-12);
    }

    #[test]
    fn beams_are_spread_over_the_field_of_view() {
        let mut lidar = robot().lidar;
        lidar.n_beams = 4;
        let (first, step) = lidar.directions_rad();
        assert!((first + PI).abs() < 1e-12 && (step - PI / 2.0).abs() < 1e-12);
        lidar.n_beams = 181;
        lidar.fov_rad = PI;
        let (first, step) = lidar.directions_rad();
        assert!((first + PI / 2.0).abs() < 1e-12 && (step - PI / 180.0).abs() < 1e-12);
    }
}
