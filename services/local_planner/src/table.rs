//! The controllers by key. A new one is a file plus a row here.

use crate::config::LocalPlannerConfig;
use crate::controller::Controller;
use crate::dwa::Dwa;

/// A controller that can be chosen.
#[derive(Debug, Clone, Copy)]
pub struct ControllerRow {
    /// Name in configurations, lower case.
    pub key: &'static str,
    /// One line for users.
    pub title: &'static str,
    /// Where it comes from.
    pub source: &'static str,
    /// Makes one.
    pub build: fn(&LocalPlannerConfig) -> Box<dyn Controller>,
}

/// Every controller.
pub const CONTROLLERS: &[ControllerRow] = &[
    ControllerRow {
        key: "dwa_t",
        title: "Time-indexed dynamic window: predicted obstacles, cost-to-go, speed by clearance",
        source: "dwa, with rollouts in time, a local navigation function and constant-velocity tracks",
        build: |config| Box::new(Dwa::timed(config.dwa, config.dwa_t)),
    },
    ControllerRow {
    key: "dwa",
    title: "Dynamic window that follows the path, checked against map and scan",
    source: "Fox, Burgard, Thrun: The Dynamic Window Approach to Collision Avoidance, IEEE RAM 4(1), 1997",
    build: |config| Box::new(Dwa::new(config.dwa)),
    },
];

/// No controller has this key.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("no controller is called \"{key}\"; there are: {}", keys())]
pub struct UnknownController {
    /// The key asked for.
    pub key: String,
}

fn keys() -> String {
    let keys: Vec<&str> = CONTROLLERS.iter().map(|row| row.key).collect();
    keys.join(", ")
}

/// The row with `key`.
///
/// # Errors
/// [`UnknownController`], whose text lists the keys there are.
pub fn controller(key: &str) -> Result<&'static ControllerRow, UnknownController> {
    CONTROLLERS
        .iter()
        .find(|row| row.key == key)
        .ok_or_else(|| UnknownController {
            key: key.to_owned(),
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_is_found_once() {
        for row in CONTROLLERS {
            assert_eq!(controller(row.key).map(|found| found.title), Ok(row.title));
            assert_eq!(CONTROLLERS.iter().filter(|r| r.key == row.key).count(), 1);
        }
    }

    #[test]
    fn an_unknown_key_names_the_known_ones() {
        let text = match controller("teb") {
            Ok(row) => row.key.to_owned(),
            Err(error) => error.to_string(),
        };
        assert!(text.contains("\"teb\"") && text.contains("dwa"), "{text}");
    }
}
