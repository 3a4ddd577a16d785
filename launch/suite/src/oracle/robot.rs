//! What the oracle knows of the robot.

use zeronav_robot_description::RobotSpec;
use zeronav_world::{Convex, Footprint};

/// What the robot can do, at best.
#[derive(Debug, Clone)]
pub(crate) struct Abilities {
    /// Its outline in `base`.
    pub(crate) outline: Convex,
    /// How far that reaches from its centre. [m]
    pub(crate) reach_m: f64,
    /// Radius of a disc that is within its outline everywhere. [m]
    pub(crate) radius_m: f64,
    /// Least and largest forward speed. [m/s]
    pub(crate) v_mps: [f64; 2],
    /// Largest yaw rate. [rad/s]
    pub(crate) w_radps_max: f64,
    /// Largest change of speed, faster or slower: that of braking. [m/s^2]
    pub(crate) a_mps2_max: f64,
    /// Largest change of speed away from zero. [m/s^2]
    pub(crate) speed_up_mps2: f64,
    /// Largest change of the yaw rate. [rad/s^2]
    pub(crate) alpha_radps2_max: f64,
}

impl Abilities {
    /// Those of a robot with this outline.
    pub(crate) fn new(robot: &RobotSpec, footprint: &Footprint) -> Self {
        Self {
            outline: footprint.form().clone(),
            reach_m: footprint.circumscribed_radius_m(),
            radius_m: footprint.inscribed_radius_m(),
            v_mps: [robot.v_mps_min.min(0.0), robot.v_mps_max],
            w_radps_max: robot.w_radps_max,
            a_mps2_max: robot.brake_mps2.unwrap_or(0.0).max(robot.a_mps2_max),
            speed_up_mps2: robot.a_mps2_max,
            alpha_radps2_max: robot.alpha_radps2_max,
        }
    }
}

/// The robot at a moment of the run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct State {
    /// Run time. [s]
    pub(crate) t_s: f64,
    /// Position of its centre. [m]
    pub(crate) at_m: [f64; 2],
    /// [rad]
    pub(crate) yaw_rad: f64,
    /// Forward speed. [m/s]
    pub(crate) v_mps: f64,
    /// Yaw rate. [rad/s]
    pub(crate) w_radps: f64,
}

/// A disc at a moment: centre and radius. [m]
pub(crate) type Disc = ([f64; 2], f64);
