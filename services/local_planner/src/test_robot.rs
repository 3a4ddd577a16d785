//! The robot of the unit tests.

use zeronav_msgs::description::Description;

/// One that can drive backwards.
pub(crate) fn robot() -> Description {
    Description {
        v_mps_max: 1.0,
        v_mps_min: -0.3,
        w_radps_max: 2.0,
        a_mps2_max: 1.0,
        brake_mps2: 2.0,
        alpha_radps2_max: 4.0,
        ..Description::default()
    }
}
