//! The robots of the field: the presets, and outlines that public reports are about.

use rand::{Rng, RngExt};
use toml::{Table, Value};
use zeronav_robot_description::RobotPreset;

/// A robot and what its outline takes.
#[derive(Debug, Clone)]
pub(super) struct Body {
    /// For titles.
    pub(super) name: String,
    /// Its table `[robot]`.
    pub(super) robot: Table,
    /// How far its outline reaches ahead of, behind and beside `base`. [m]
    pub(super) front_m: f64,
    pub(super) rear_m: f64,
    pub(super) side_m: f64,
    /// Its top speed [m/s] and how it brakes. [m/s^2]
    pub(super) v_mps: f64,
    pub(super) brake_mps2: f64,
}

impl Body {
    /// A preset.
    pub(super) fn preset(preset: RobotPreset) -> Self {
        let spec = preset.robot();
        let word = Value::try_from(preset).expect("a choice is a word");
        let name = word.as_str().expect("a choice is a word").to_owned();
        let mut robot = Table::new();
        robot.insert("preset".into(), word);
        let corners = spec.footprint_m.clone().unwrap_or_default();
        let reach = |value: fn(&[f64; 2]) -> f64| {
            let farthest = corners.iter().map(value).fold(f64::NEG_INFINITY, f64::max);
            spec.radius_m.unwrap_or(farthest)
        };
        Self {
            name,
            robot,
            front_m: reach(|at| at[0]),
            rear_m: reach(|at| -at[0]),
            side_m: reach(|at| at[1].abs()),
            v_mps: spec.v_mps_max,
            brake_mps2: spec.brake_mps2.unwrap_or(spec.a_mps2_max),
        }
    }

    /// A rectangle that reaches so far ahead, behind and to either side, with a lidar of 360 beams that sees all
    /// around. [m]
    pub(super) fn rectangle([front_m, rear_m, side_m]: [f64; 3]) -> Self {
        let corners = [
            [-rear_m, -side_m],
            [front_m, -side_m],
            [front_m, side_m],
            [-rear_m, side_m],
        ];
        let corners: Vec<Value> = corners.iter().map(|at| at.to_vec().into()).collect();
        let mut robot = common();
        robot.insert("footprint_m".into(), corners.into());
        Self {
            name: format!("{:.2} m x {:.2} m", front_m + rear_m, 2.0 * side_m),
            robot,
            front_m,
            rear_m,
            side_m,
            v_mps: V_MPS,
            brake_mps2: A_MPS2,
        }
    }

    /// A disc. [m]
    pub(super) fn disc(radius_m: f64) -> Self {
        let mut robot = common();
        robot.insert("radius_m".into(), radius_m.into());
        Self {
            name: format!("a disc of {radius_m:.2} m"),
            robot,
            front_m: radius_m,
            rear_m: radius_m,
            side_m: radius_m,
            v_mps: V_MPS,
            brake_mps2: A_MPS2,
        }
    }

    /// Drives backwards, too.
    pub(super) fn with_reverse(mut self) -> Self {
        self.robot.insert("v_mps_min".into(), (-0.3).into());
        self
    }

    /// With another value of a field.
    pub(super) fn with(mut self, field: &str, value: impl Into<Value>) -> Self {
        self.robot.insert(field.into(), value.into());
        self
    }

    /// With another value of a field of its lidar.
    pub(super) fn with_lidar(mut self, field: &str, value: impl Into<Value>) -> Self {
        let lidar = self.robot.entry("lidar").or_insert(Table::new().into());
        if let Some(lidar) = lidar.as_table_mut() {
            lidar.insert(field.into(), value.into());
        }
        self
    }

    /// Length of the outline. [m]
    pub(super) fn length_m(&self) -> f64 {
        self.front_m + self.rear_m
    }
}

/// Top speed [m/s] and acceleration of the robots without a preset. [m/s^2]
const V_MPS: f64 = 0.9;
const A_MPS2: f64 = 1.2;

fn common() -> Table {
    let mut lidar = Table::new();
    lidar.insert("n_beams".into(), 360.into());
    lidar.insert("rate_hz".into(), 10.0.into());
    lidar.insert("range_m_min".into(), 0.1.into());
    lidar.insert("range_m_max".into(), 12.0.into());
    lidar.insert("sigma_m".into(), 0.008.into());
    let mut robot = Table::new();
    robot.insert("v_mps_max".into(), V_MPS.into());
    robot.insert("w_radps_max".into(), 1.9.into());
    robot.insert("a_mps2_max".into(), A_MPS2.into());
    robot.insert("alpha_radps2_max".into(), 4.0.into());
    robot.insert("lidar".into(), lidar.into());
    robot
}

/// Any of the robots.
pub(super) fn any(random: &mut impl Rng) -> Body {
    let presets = RobotPreset::ALL;
    match random.random_range(0..presets.len() + 2) {
        n if n < presets.len() => Body::preset(presets[n]),
        n if n == presets.len() => Body::rectangle([0.3, 0.3, 0.2]),
        _ => Body::disc(0.25),
    }
}

/// A robot with corners.
pub(super) fn with_corners(random: &mut impl Rng) -> Body {
    match random.random_range(0..5) {
        0 => Body::preset(RobotPreset::Jackal),
        1 | 2 => Body::rectangle([0.3, 0.3, 0.2]),
        3 => Body::rectangle([0.6, 0.6, 0.25]),
        _ => Body::rectangle([0.45, 0.25, 0.22]),
    }
}
