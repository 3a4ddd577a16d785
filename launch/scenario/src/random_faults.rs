//! Faults of the stack that are drawn from a seed.

use super::faults::{FAULTS_MAX, KINDS, mortals};
use super::limits::TIME_LIMIT_S_MAX;
use serde::{Deserialize, Serialize};
use zeronav_msgs::Role;
use zeronav_shell::nearest::unknown;
use zeronav_world::error::{SpecError, number};

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
    /// Kinds to choose from; without, all that the mode of the run allows and that touch this stack
    /// alone.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub kinds: Vec<String>,
    /// Seats to choose from, and their topics; without, all but the robot's.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub services: Vec<String>,
}

const fn one_s() -> f64 {
    1.0
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
        let kinds = KINDS.map(|kind| kind.name).to_vec();
        named("kinds", "kind of fault", &self.kinds, kinds)?;
        let seats = mortals().map(Role::label).collect();
        named("services", "service that may break", &self.services, seats)
    }
}
