//! The dynamic windows in closed loops: they arrive, in good time, and never touch anything.

#![allow(clippy::print_stdout, reason = "seeds and results of a failed run")]

mod dwa {
    use crate::support::{Block, Loop, Robot, block, disc, goal_at, jackal, path};
    use core::f64::consts::{FRAC_PI_2, PI};
    use zeronav_local_planner::dwa::options::DwaConfig;
    use zeronav_local_planner::{dwa, pilot::Pilot};
    use zeronav_msgs::Pose;
    use zeronav_msgs::command::Validity;
    use zeronav_msgs::pose::wrap_angle;

    /// Changes of direction allowed per metre at a corner.
    const WEAVING_PER_M_MAX: f64 = 0.15;
    /// The same on a path in steps.
    const STEPS_WEAVING_PER_M_MAX: f64 = 0.5;
    /// To get around a box on the way. [s]
    const ROUND_THE_BOX_S: f64 = 25.0;

    fn dwa() -> Pilot {
        dwa::dwa(DwaConfig::default())
    }

    include!("../support/manoeuvres.rs");
}

mod dwa_t {
    use crate::support::{Block, Loop, Robot, block, disc, goal_at, jackal, path};
    use core::f64::consts::{FRAC_PI_2, PI};
    use zeronav_local_planner::dwa::options::DwaConfig;
    use zeronav_local_planner::dwa_t::options::DwaTConfig;
    use zeronav_local_planner::{dwa_t, pilot::Pilot};
    use zeronav_msgs::Pose;
    use zeronav_msgs::command::Validity;
    use zeronav_msgs::pose::wrap_angle;

    /// Changes of direction allowed per metre at a corner.
    const WEAVING_PER_M_MAX: f64 = 0.25;
    /// The same on a path in steps.
    const STEPS_WEAVING_PER_M_MAX: f64 = 0.6;
    /// To get around a box on the way. [s]
    const ROUND_THE_BOX_S: f64 = 25.0;

    fn dwa() -> Pilot {
        dwa_t::dwa_t(DwaConfig::default(), DwaTConfig::default())
    }

    include!("../support/manoeuvres.rs");
}
