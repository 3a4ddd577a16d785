//! The controllers by key. A new one is a file plus a row here.

use crate::beam::beam;
use crate::config::LocalPlannerConfig;
use crate::dwa::dwa;
use crate::dwa_t::dwa_t;
use crate::mppi::mppi;
use crate::papers::Law;
use crate::papers::bao_window::bao_dwa;
use crate::papers::drive::along;
use crate::papers::ju_apf::JuApf;
use crate::papers::ju_fusion::JuFusion;
use crate::papers::ju_r6::JuR6;
use crate::papers::ju_r7::JuR7;
use crate::papers::lwx_fusion::LwxFusion;
use crate::papers::lwx_lsq::LwxLsq;
use crate::papers::lwx_oapf::LwxOapf;
use crate::papers::walk::Walk;
use crate::papers::zm_esc::ZmEsc;
use crate::papers::zm_full::ZmFull;
use crate::papers::zm_rep::ZmRep;
use crate::papers::zm_rv::ZmRv;
use crate::pilot::Pilot;
use zeronav_params::ParameterError;

/// A controller that can be chosen.
#[derive(Debug, Clone, Copy)]
pub struct ControllerRow {
    /// Name in configurations, lower case.
    pub key: &'static str,
    /// One line for users.
    pub title: &'static str,
    /// Where it comes from.
    pub source: &'static str,
    /// It is one of the papers', which is driven as they say.
    pub of_a_paper: bool,
    /// Makes one.
    pub build: fn(&LocalPlannerConfig) -> Pilot,
}

/// A potential-field law at the wheels.
fn law(law: impl Law + 'static, config: &LocalPlannerConfig) -> Pilot {
    along(Box::new(law), config.dwa, config.literal).shaped(config.shaping)
}

/// Every controller; the first one is the default.
pub const CONTROLLERS: &[ControllerRow] = &[
    ControllerRow {
        key: "beam",
        title: "Beam search in time among what moves, dwa_t where nothing does",
        source: "beam search over manoeuvres, with constant-velocity tracks",
        of_a_paper: false,
        build: |config| beam(config.dwa, config.dwa_t, config.beam).shaped(config.shaping),
    },
    ControllerRow {
        key: "dwa_t",
        title: "Time-indexed dynamic window: predicted obstacles, cost-to-go, speed by clearance",
        source: "dwa, with rollouts in time, a local navigation function and constant-velocity tracks",
        of_a_paper: false,
        build: |config| dwa_t(config.dwa, config.dwa_t).shaped(config.shaping),
    },
    ControllerRow {
        key: "dwa",
        title: "Dynamic window that follows the path, checked against map and scan",
        source: "Fox, Burgard, Thrun: The Dynamic Window Approach to Collision Avoidance, IEEE RAM 4(1), 1997",
        of_a_paper: false,
        build: |config| dwa(config.dwa).shaped(config.shaping),
    },
    ControllerRow {
        key: "mppi",
        title: "Model predictive path integral control around the choice of dwa_t",
        source: "Williams et al.: Information-Theoretic Model Predictive Control, IEEE T-RO 34(6), 2018",
        of_a_paper: false,
        build: |config| mppi(config.dwa, config.dwa_t, config.mppi).shaped(config.shaping),
    },
    ControllerRow {
        key: "ju_apf",
        title: "Artificial potential field towards the goal",
        source: "JU-APF",
        of_a_paper: true,
        build: |config| law(JuApf::new(config.papers.ju_apf.gains()), config),
    },
    ControllerRow {
        key: "ju_r6",
        title: "The path's inflection points as sub-goals of a potential field",
        source: "JU-R6",
        of_a_paper: true,
        build: |config| law(JuR6::new(&config.papers.ju_r6), config),
    },
    ControllerRow {
        key: "ju_r7",
        title: "Potential field towards a carrot on the path",
        source: "JU-R7",
        of_a_paper: true,
        build: |config| law(JuR7::new(&config.papers.ju_r7), config),
    },
    ControllerRow {
        key: "ju_fusion",
        title: "The path's points around the robot attract besides the goal",
        source: "JU-FUSION",
        of_a_paper: true,
        build: |config| law(JuFusion::new(&config.papers.ju_fusion), config),
    },
    ControllerRow {
        key: "zm_rep",
        title: "Repulsion that fades at the goal",
        source: "ZM-REP",
        of_a_paper: true,
        build: |config| law(ZmRep::new(&config.papers.zm_rep), config),
    },
    ControllerRow {
        key: "zm_esc",
        title: "Potential field that escapes from local minima",
        source: "ZM-ESC",
        of_a_paper: true,
        build: |config| law(ZmEsc::new(&config.papers.zm_esc), config),
    },
    ControllerRow {
        key: "zm_rv",
        title: "Sideways repulsion from what approaches",
        source: "ZM-RV",
        of_a_paper: true,
        build: |config| law(ZmRv::new(&config.papers.zm_rv), config),
    },
    ControllerRow {
        key: "zm_full",
        title: "Fading repulsion, escapes and sideways repulsion together",
        source: "ZM-REP, ZM-ESC, ZM-RV",
        of_a_paper: true,
        build: |config| law(ZmFull::new(&config.papers.zm_full), config),
    },
    ControllerRow {
        key: "lwx_apf",
        title: "Artificial potential field with a small reach",
        source: "LWX-APF",
        of_a_paper: true,
        build: |config| law(JuApf::new(config.papers.lwx_apf.gains()), config),
    },
    ControllerRow {
        key: "lwx_oapf",
        title: "The path's turning points as interim goals",
        source: "LWX-OAPF",
        of_a_paper: true,
        build: |config| {
            let own = &config.papers.lwx_oapf;
            law(LwxOapf::new(own.gains(), own.steps_per_m, false), config)
        },
    },
    ControllerRow {
        key: "lwx_iter",
        title: "The same with a strict budget of steps for every interim goal",
        source: "LWX-ITER",
        of_a_paper: true,
        build: |config| {
            let own = &config.papers.lwx_iter;
            law(LwxOapf::new(own.gains(), own.steps_per_m, true), config)
        },
    },
    ControllerRow {
        key: "lwx_lsq",
        title: "The path fitted by least squares, followed by a carrot",
        source: "LWX-LSQ",
        of_a_paper: true,
        build: |config| law(LwxLsq::new(&config.papers.lwx_lsq), config),
    },
    ControllerRow {
        key: "lwx_fusion",
        title: "Potential field over turning points, fitted by least squares",
        source: "LWX-FUSION",
        of_a_paper: true,
        build: |config| {
            law(
                LwxFusion::new(&config.papers.lwx_fusion, Walk::LWX_M),
                config,
            )
        },
    },
    ControllerRow {
        key: "bao_dwa",
        title: "Dynamic window with normalised heading, distance and speed",
        source: "BAO-DWA",
        of_a_paper: true,
        build: |config| bao_dwa(&config.papers.bao_dwa, config.dwa).shaped(config.shaping),
    },
];

/// Why there is no [`crate::LocalPlanner`] for a configuration.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BuildError {
    /// A number of the configuration is out of range.
    #[error(transparent)]
    Config(#[from] ParameterError),
    /// The configuration names a controller that there is not.
    #[error(transparent)]
    Controller(#[from] UnknownController),
}

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
