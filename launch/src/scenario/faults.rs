//! Faults of the stack that a scenario asks for: what breaks, when, and for how long.
//!
//! ```toml
//! [[faults]]
//! kind = "kill"
//! service = "local_planner"
//! begins = { at_s = 3.0 }          # or { robot_near = { point_m = [9.0, 6.4], distance_m = 1.2 } }
//!
//! [random_faults]                  # and so many more, drawn from the seed of the run
//! count = 40
//! until_s = 60.0
//! ```

use super::limits::{COORDINATE_M_MAX, TIME_LIMIT_S_MAX};
use serde::{Deserialize, Serialize};
use zeronav_msgs::Role;
use zeronav_msgs::run::{DELAY_STEP_NS, RunMode};
use zeronav_msgs::time::seconds;
use zeronav_shell::nearest::unknown;
use zeronav_world::error::{SpecError, number};
use zeronav_world::spec::{Near, Trigger};
use zeronav_world::world::NEAR_M;

/// Most faults of one scenario, random ones included.
pub const FAULTS_MAX: usize = 10_000;

/// Shortest time for which a fault lasts: less than most periods. [s]
const LASTS_S_MIN: f64 = 1.0e-3;

/// Names of the kinds.
pub(crate) const KINDS: [&str; 3] = ["kill", "stop", "slow"];

/// One fault.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum StackFault {
    /// A service is killed (SIGKILL), as if it had crashed.
    Kill {
        /// Its seat: `mapping`, `global_planner`, `local_planner` or `collision_guard`.
        service: String,
        /// When; without, at once. A scenario needs it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        begins: Option<Trigger>,
    },
    /// A service is stopped (SIGSTOP), so that it hangs until it is restarted.
    Stop {
        /// Its seat.
        service: String,
        /// When; without, at once. A scenario needs it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        begins: Option<Trigger>,
        /// It goes on after this time if nothing has restarted it by then; real time only. [s]
        #[serde(default, skip_serializing_if = "Option::is_none")]
        lasts_s: Option<f64>,
    },
    /// Each answer of a service is late. In lockstep, which waits for it, that changes nothing but
    /// the time that the run takes.
    Slow {
        /// Its seat.
        service: String,
        /// By how much. [ms]
        by_ms: f64,
        /// When it begins; without, at once. A scenario needs it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        begins: Option<Trigger>,
        /// For how long; without, to the end. [s]
        #[serde(default, skip_serializing_if = "Option::is_none")]
        lasts_s: Option<f64>,
    },
}

/// Faults that are drawn from a seed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RandomFaults {
    /// How many.
    pub count: usize,
    /// Run time of the first one at the earliest. [s]
    #[serde(default = "one_s")]
    pub from_s: f64,
    /// Run time of the last one at the latest. [s]
    pub until_s: f64,
    /// Seed; without, that of the run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// Kinds to choose from; without, all that the mode of the run allows.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub kinds: Vec<String>,
    /// Seats to choose from; without, all but the robot's.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub services: Vec<String>,
}

const fn one_s() -> f64 {
    1.0
}

/// The seats whose services may break: all but the robot's, which nothing restarts.
pub(crate) fn mortals() -> impl Iterator<Item = Role> + Clone {
    let services = Role::SERVICES.into_iter();
    services.filter(|role| *role != Role::Robot)
}

impl StackFault {
    /// What kind it is.
    #[must_use]
    pub const fn kind(&self) -> &'static str {
        match self {
            Self::Kill { .. } => "kill",
            Self::Stop { .. } => "stop",
            Self::Slow { .. } => "slow",
        }
    }

    /// What breaks.
    #[must_use]
    pub fn target(&self) -> &str {
        match self {
            Self::Kill { service, .. }
            | Self::Stop { service, .. }
            | Self::Slow { service, .. } => service,
        }
    }

    /// The seat whose service breaks; `None` when there is none of that name that may break.
    #[must_use]
    pub fn role(&self) -> Option<Role> {
        mortals().find(|role| role.label() == self.target())
    }

    /// When it begins; `None` = at once.
    #[must_use]
    pub const fn begins(&self) -> Option<&Trigger> {
        match self {
            Self::Kill { begins, .. } | Self::Stop { begins, .. } | Self::Slow { begins, .. } => {
                begins.as_ref()
            }
        }
    }

    /// For how long it lasts; `None` = to the end, or without an end. [s]
    #[must_use]
    pub const fn lasts_s(&self) -> Option<f64> {
        match self {
            Self::Kill { .. } => None,
            Self::Stop { lasts_s, .. } | Self::Slow { lasts_s, .. } => *lasts_s,
        }
    }

    /// Its figures, in words; empty when there are none.
    #[must_use]
    pub fn figures(&self) -> String {
        match self {
            Self::Kill { .. } | Self::Stop { .. } => String::new(),
            Self::Slow { by_ms, .. } => format!("{by_ms} ms"),
        }
    }

    /// Accepts known targets and usable numbers.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self) -> Result<(), SpecError> {
        if self.role().is_none() {
            let why = if self.target() == Role::Robot.label() {
                "the robot is not restarted; `zeronav down` ends the stack".to_owned()
            } else {
                unknown(
                    "service that may break",
                    self.target(),
                    mortals().map(Role::label),
                )
            };
            return Err(SpecError::new("service", why));
        }
        if let Some(lasts_s) = self.lasts_s() {
            number(lasts_s, LASTS_S_MIN, TIME_LIMIT_S_MAX, "lasts_s")?;
        }
        if let Self::Slow { by_ms, .. } = self {
            let step_ms = seconds(DELAY_STEP_NS) * 1.0e3;
            number(*by_ms, step_ms, step_ms * f64::from(u16::MAX), "by_ms")?;
        }
        match self.begins() {
            Some(begins) => check_trigger(begins).map_err(|error| error.within("begins")),
            None => Ok(()),
        }
    }

    /// The delay of each answer in steps of [`DELAY_STEP_NS`]; 0 for other faults.
    #[must_use]
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "its range was checked"
    )]
    pub fn delay_steps(&self) -> u16 {
        match self {
            Self::Slow { by_ms, .. } => (by_ms / (seconds(DELAY_STEP_NS) * 1.0e3)).round() as u16,
            _ => 0,
        }
    }

    /// Which field keeps a run in this mode from being the same every time, and why; `None` when
    /// none does.
    #[must_use]
    pub fn unfit(&self, mode: RunMode) -> Option<(&'static str, &'static str)> {
        match self {
            Self::Stop {
                lasts_s: Some(_), ..
            } if mode == RunMode::Lockstep => Some((
                "lasts_s",
                "lockstep waits for a service that hangs until it is restarted",
            )),
            _ => None,
        }
    }
}

impl RandomFaults {
    /// Accepts known names and usable numbers.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self) -> Result<(), SpecError> {
        if self.count > FAULTS_MAX {
            let why = format!("{}, at most {FAULTS_MAX}", self.count);
            return Err(SpecError::new("count", why));
        }
        number(self.from_s, 0.0, TIME_LIMIT_S_MAX, "from_s")?;
        number(self.until_s, self.from_s, TIME_LIMIT_S_MAX, "until_s")?;
        let named = |field: &str, what: &str, names: &[String], known: Vec<&'static str>| {
            for (index, name) in names.iter().enumerate() {
                if !known.contains(&name.as_str()) {
                    let field = format!("{field}[{index}]");
                    return Err(SpecError::new(field, unknown(what, name, known)));
                }
            }
            Ok(())
        };
        named("kinds", "kind of fault", &self.kinds, KINDS.to_vec())?;
        let seats = mortals().map(Role::label).collect();
        named("services", "service that may break", &self.services, seats)
    }
}

/// Accepts a run time or a place.
fn check_trigger(begins: &Trigger) -> Result<(), SpecError> {
    match (begins.at_s, &begins.robot_near) {
        (Some(at_s), None) => number(at_s, 0.0, TIME_LIMIT_S_MAX, "at_s"),
        (
            None,
            Some(Near {
                point_m,
                distance_m,
            }),
        ) => {
            for (axis, value) in point_m.iter().enumerate() {
                let most = COORDINATE_M_MAX;
                number(*value, -most, most, &format!("robot_near.point_m[{axis}]"))?;
            }
            number(*distance_m, NEAR_M[0], NEAR_M[1], "robot_near.distance_m")
        }
        _ => Err(SpecError::new(
            "",
            "give exactly one of at_s and robot_near",
        )),
    }
}
